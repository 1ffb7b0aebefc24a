//! The GPU as a [`Backend`]: requests in, samples, pictures and a display texture out.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::design::{Method, ToneMap};
use crate::image::{Display, Picture};
use crate::render::convergence::has_estimate;
use crate::render::progressive::check_size;
use crate::render::{
    Backend, BackendKind, Counters, MAX_SIDE, Progress, RenderError, RenderRequest,
};

use super::GpuContext;
use super::accumulation::Accumulation;
use super::bindings::{self, entry, record_dispatch, slice_buffer};
use super::constants::{TONE_FILMIC, TONE_NONE};
use super::pipeline_key::PipelineKey;
use super::pipelines::Pipelines;
use super::readback;
use super::schedule::{Dispatch, Pace, Schedule};
use super::shadow_memory::ShadowMemory;
use super::upload::SceneBuffers;
use super::work::{Work, may_learn_bounces};

/// Longest dispatch to aim for: what shares the device with us, a desktop perhaps, waits no longer.
const LONGEST_DISPATCH: Duration = Duration::from_millis(100);

/// Draws on a GPU.
#[derive(Debug)]
pub struct GpuBackend {
    context: GpuContext,
    pipelines: Arc<Pipelines>,
    /// The scene of each level of detail.
    scenes: Vec<SceneBuffers>,
    work: Option<Work>,
    pace: Pace,
    /// What is known of the shadows of the picture in work, and of pictures like it, at each level.
    shadows: Vec<Option<ShadowMemory>>,
    display: Option<wgpu::Texture>,
    filter_f32: bool,
    /// The pipeline that draws no more than rays and sums, and what it is for.
    baseline: Option<(PipelineKey, wgpu::ComputePipeline)>,
}

impl GpuBackend {
    /// Reads the shaders.
    ///
    /// # Errors
    /// When the device refuses them.
    pub fn new(context: GpuContext) -> Result<Self, RenderError> {
        let pipelines = Arc::new(Pipelines::new(&context)?);
        Ok(Self::with(context, pipelines))
    }

    /// Another backend on the same device, with its own pictures: what the two compile they share.
    pub fn beside(&self) -> Self {
        Self::with(self.context.clone(), Arc::clone(&self.pipelines))
    }

    fn with(context: GpuContext, pipelines: Arc<Pipelines>) -> Self {
        Self {
            context,
            pipelines,
            scenes: Vec::new(),
            work: None,
            pace: Pace::default(),
            shadows: Vec::new(),
            display: None,
            filter_f32: false,
            baseline: None,
        }
    }

    /// The device it draws on.
    pub fn context(&self) -> &GpuContext {
        &self.context
    }

    /// Filters voxels in full f32 precision by hand, several times slower than the device's sampler with its 8-bit
    /// weights: for comparing pictures to the last digits. Takes effect at the next new request.
    pub fn set_filter_f32(&mut self, on: bool) {
        self.filter_f32 = on;
        self.work = None;
    }

    /// Brings the scene of each of a request's levels to the device, with room for what is learned of its shadows.
    fn upload(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        let context = &self.context;
        let mut scenes: Vec<SceneBuffers> = Vec::new();
        let mut shadows = Vec::new();
        let mut old_shadows = std::mem::take(&mut self.shadows).into_iter();
        for level in 0..request.level_count() {
            let request = request.at_level(level);
            // What levels have in common, such as volumes, they share.
            let of_loops = |old: &&SceneBuffers| old.has_loops_of(request.scene());
            let old = self.scenes.iter().find(of_loops);
            let old = old.or(scenes.first()).or(self.scenes.first());
            scenes.push(SceneBuffers::new(
                context,
                &self.pipelines.scene_layout,
                request.scene(),
                old,
            )?);
            let old = old_shadows.next().flatten();
            shadows.push(ShadowMemory::new(context, &request, old)?);
        }
        if shadows.iter().any(Option::is_none) {
            shadows.fill_with(|| None);
        }
        (self.scenes, self.shadows) = (scenes, shadows);
        Ok(())
    }

    /// Draws nothing but rays and sums, of all tiles that are drawn.
    fn draw_baseline(&mut self, samples: u32) -> Result<(), RenderError> {
        let Some(work) = &mut self.work else {
            return Ok(());
        };
        let trace = &self.pipelines.trace;
        let pipeline = match &self.baseline {
            Some((key, pipeline)) if *key == work.key => pipeline,
            _ => {
                &self
                    .baseline
                    .insert((work.key, trace.baseline(work.key)?))
                    .1
            }
        };
        let mut place = 0;
        while place < work.accumulation.drawn_count() {
            let (_, end) = work.accumulation.buffer_of(place);
            let end = end.min(place + Dispatch::MOST_TILES);
            let dispatch = Dispatch {
                tiles: place..end,
                samples: 0..samples,
                stride: 0,
            };
            let (pipeline, scenes) = ((pipeline, trace.group()), &self.scenes);
            work.draw(&self.context, pipeline, scenes, &dispatch, &[])?;
            place = end;
        }
        Ok(())
    }

    /// Resolves the mean so far into a texture of the crop's size, sRGB-encoded values in rgba8unorm as egui wants
    /// them, and returns it. It is the same texture as before unless the size changed. `None` before any request.
    ///
    /// # Errors
    /// When the device fails, or the picture is larger than a texture can be.
    pub fn show(&mut self, display: Display) -> Result<Option<&wgpu::Texture>, RenderError> {
        let Some(work) = &self.work else {
            return Ok(None);
        };
        let [width, height] = work.accumulation.size;
        self.context.check(
            "the larger side of the picture shown",
            width.max(height).into(),
            self.context.limits.max_texture_dimension_2d.into(),
        )?;
        let fits = |texture: &wgpu::Texture| [texture.width(), texture.height()] == [width, height];
        let context = &self.context;
        let texture = match self.display.take().filter(fits) {
            Some(texture) => texture,
            None => context.guarded(|| {
                context.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("display"),
                    size: wgpu::Extent3d {
                        width,
                        height,
                        depth_or_array_layers: 1,
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::Rgba8Unorm,
                    usage: wgpu::TextureUsages::STORAGE_BINDING
                        | wgpu::TextureUsages::TEXTURE_BINDING
                        | wgpu::TextureUsages::COPY_SRC,
                    view_formats: &[],
                })
            })?,
        };
        let made = self
            .pipelines
            .display
            .get(context, work.request.settings.aov)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        for buffer in &work.accumulation.sums {
            // Pictures that fit a texture have few enough tiles for a dispatch, but for whole-device ones.
            let at_a_time = context.limits.max_compute_workgroups_per_dimension / 4;
            for first in buffer.tiles.clone().step_by(at_a_time.max(1) as usize) {
                let tiles = first..first.saturating_add(at_a_time).min(buffer.tiles.end);
                context.guarded(|| {
                    let workgroups = tiles.len() as u32 * 4;
                    let mut slice = work.accumulation.slice(&work.request, buffer, tiles);
                    readback::show(&mut slice, work.drawn());
                    slice.exposure_scale = display.exposure.exp2() as f32;
                    slice.tone_map = match display.tone_map {
                        ToneMap::None => TONE_NONE,
                        ToneMap::Filmic => TONE_FILMIC,
                    };
                    let slice = slice_buffer(context, &slice);
                    let mut encoder = context.encoder();
                    let entries = [
                        entry(bindings::SUMS, &buffer.buffer),
                        entry(bindings::SLICE, &slice),
                        entry(bindings::TILE_ENDS, &work.accumulation.tile_ends),
                        wgpu::BindGroupEntry {
                            binding: bindings::DISPLAY,
                            resource: wgpu::BindingResource::TextureView(&view),
                        },
                    ];
                    record_dispatch(context, &mut encoder, made, &entries, workgroups);
                    context.queue.submit([encoder.finish()]);
                })?;
            }
        }
        Ok(Some(self.display.insert(texture)))
    }
}

impl Backend for GpuBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Gpu
    }

    fn device_name(&self) -> String {
        self.context.info.name.clone()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.begin_soon(request)?;
        let (Some(work), Some(scene)) = (&mut self.work, self.scenes.first()) else {
            return Ok(());
        };
        if work.pipeline.is_none() {
            let never = AtomicBool::new(false);
            let trace = &self.pipelines.trace;
            work.pipeline = trace.wait(work.key, &scene.group, None, &never)?;
        }
        Ok(())
    }

    fn begin_soon(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if let Some(work) = &mut self.work
            && work.is_same_picture(request)
        {
            work.request.settings = request.settings;
            return Ok(());
        }
        check_size(request.size, request.crop)?;
        if request.settings.method == Method::SixFace {
            return Err(RenderError::Method {
                backend: BackendKind::Gpu,
                method: Method::SixFace,
            });
        }
        let before = self.work.take().map(|work| work.accumulation);
        self.upload(request)?;
        let Some(scene) = self.scenes.first() else {
            return Ok(());
        };
        let accumulation = Accumulation::new(&self.context, request, before, &self.shadows)?;
        let known = PipelineKey::new(request.scene(), &request.settings, self.filter_f32);
        let learns_bounces = may_learn_bounces(&self.context, &request.settings)
            && (self.shadows.iter().flatten()).all(ShadowMemory::learns_bounces)
            && !self.shadows.is_empty();
        let cached_shadows = self.shadows.iter().all(Option::is_some);
        let bounced_light = cached_shadows && learns_bounces;
        let key = PipelineKey {
            cached_shadows,
            bounced_light,
            long_paths: known.long_paths || bounced_light,
            levels: request.level_count() > 1,
            ..known
        };
        let pipeline = self.pipelines.trace.get(key, &scene.group)?;
        self.work = Some(Work {
            request: request.clone(),
            key,
            schedule: Schedule::new(accumulation.drawn_count()),
            error_estimate: accumulation.is_background().then_some(0.0),
            accumulation,
            pipeline,
        });
        Ok(())
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        let (Some(work), Some(scene)) = (&mut self.work, self.scenes.first()) else {
            return Ok(Progress {
                done: true,
                ..Progress::default()
            });
        };
        let start = Instant::now();
        if work.pipeline.is_none() {
            let deadline = start.checked_add(slice);
            let trace = &self.pipelines.trace;
            work.pipeline = trace.wait(work.key, &scene.group, deadline, cancel)?;
        }
        let Some(pipeline) = work.pipeline.clone() else {
            return Ok(work.progress());
        };
        while !work.is_done() && !cancel.load(Ordering::Relaxed) {
            let left = slice.saturating_sub(start.elapsed());
            let paths = self.pace.paths_in(left.min(LONGEST_DISPATCH));
            let accumulation = &work.accumulation;
            let buffer_end = |place| accumulation.buffer_of(place).1;
            let settings = &work.request.settings;
            let samples = work.schedule.samples();
            // Samples that learn shadows from each other come one by one. On software Vulkan all do: see
            // `rows_of_workgroups` in work.rs.
            let caches = work.key.cached_shadows;
            let learns = caches && settings.caches_shadows(samples);
            let most = if learns || self.context.is_software() {
                samples + 1
            } else {
                settings.samples
            };
            let dispatch = work.schedule.next(paths, most, buffer_end);
            let begun = Instant::now();
            let pipeline = (&pipeline, self.pipelines.trace.group());
            work.draw(
                &self.context,
                pipeline,
                &self.scenes,
                &dispatch,
                &self.shadows,
            )?;
            self.pace.learn(dispatch.paths(), begun.elapsed());
            let before = samples;
            let samples = work.schedule.samples();
            if caches && samples > before && work.request.settings.caches_shadows(before) {
                for shadows in self.shadows.iter().flatten() {
                    shadows.finalise(&self.context, &self.pipelines)?;
                }
            }
            if work.schedule.is_between_passes() && has_estimate(samples) {
                work.estimate(&self.context, &self.pipelines)?;
            }
            if start.elapsed() >= slice {
                break;
            }
        }
        Ok(work.progress())
    }

    fn is_ready(&mut self) -> Result<bool, RenderError> {
        let (Some(work), Some(scene)) = (&mut self.work, self.scenes.first()) else {
            return Ok(true);
        };
        if work.pipeline.is_none() {
            work.pipeline = self.pipelines.trace.get(work.key, &scene.group)?;
        }
        Ok(work.pipeline.is_some())
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        match &self.work {
            None => Ok(Picture::default()),
            Some(work) => readback::picture(
                &self.context,
                &self.pipelines,
                &work.accumulation,
                &work.request,
                work.drawn(),
            ),
        }
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        match &self.work {
            Some(work) if work.request.settings.counters => {
                let mut counters = readback::counters(&self.context, &work.accumulation)?;
                counters += work.accumulation.left_out(work.samples());
                Ok(counters)
            }
            _ => Ok(Counters::default()),
        }
    }

    fn baseline_sample(&mut self) -> Result<Option<Duration>, RenderError> {
        // So many that the time between dispatches counts for nothing; the first pays for the driver's compiler.
        const SAMPLES: u32 = 16;
        const ROUNDS: u32 = 5;
        self.draw_baseline(1)?;
        let mut least = Duration::MAX;
        for _ in 0..ROUNDS {
            let start = Instant::now();
            self.draw_baseline(SAMPLES)?;
            least = least.min(start.elapsed() / SAMPLES);
        }
        // Its sums are worth nothing now.
        self.work = None;
        Ok(Some(least))
    }

    fn largest_side(&self) -> u32 {
        self.context.limits.max_texture_dimension_2d.min(MAX_SIDE)
    }

    fn device_bytes(&self) -> u64 {
        let scenes = SceneBuffers::bytes(&self.scenes);
        let work = self
            .work
            .as_ref()
            .map_or(0, |work| work.accumulation.bytes());
        let display = self.display.as_ref().map_or(0, |texture| {
            u64::from(texture.width()) * u64::from(texture.height()) * 4
        });
        scenes + work + display
    }
}
