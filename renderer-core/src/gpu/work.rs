//! A picture in the making: what it is drawn from and how far it is.

use crate::render::convergence::{PixelErrors, is_decision, leads_on};
use crate::render::{Optimisation, Progress, RenderError, RenderRequest, Settings};

use super::GpuContext;
use super::accumulation::Accumulation;
use super::bindings::{self, entry, slice_buffer};
use super::pipeline_key::PipelineKey;
use super::pipelines::Pipelines;
use super::readback;
use super::schedule::{Dispatch, Drawn, Schedule};
use super::shadow_memory::ShadowMemory;
use super::upload::SceneBuffers;

/// A picture in the making.
#[derive(Debug)]
pub struct Work {
    /// What is asked for.
    pub request: RenderRequest,
    /// What it needs of the shaders.
    pub key: PipelineKey,
    /// The sums so far.
    pub accumulation: Accumulation,
    /// What is drawn next.
    pub schedule: Schedule,
    /// The last estimate of its error, if there is one.
    pub error_estimate: Option<f64>,
    /// What draws it, once that is made.
    pub pipeline: Option<wgpu::ComputePipeline>,
}

impl Work {
    /// True if `request` is the same picture, so that only targets differ, and would have been drawn the same so far.
    pub fn is_same_picture(&self, request: &RenderRequest) -> bool {
        let [old, new] = [self.request.settings.error, request.settings.error];
        if !leads_on(old, new, self.accumulation.has_converged_tiles()) {
            return false;
        }
        let mut same = request.clone();
        same.settings.samples = self.request.settings.samples;
        same.settings.error = self.request.settings.error;
        same == self.request && self.schedule.samples() <= request.settings.samples
    }

    /// Whether it has the samples, or the error, that are asked for.
    pub fn is_done(&self) -> bool {
        let settings = &self.request.settings;
        let samples = self.schedule.samples();
        if !self.schedule.is_between_passes() {
            return false;
        }
        let precise = self
            .error_estimate
            .is_some_and(|error| settings.error > 0.0 && error <= settings.error);
        samples >= settings.samples
            || (precise && is_decision(samples))
            || self.accumulation.drawn_count() == 0
    }

    /// Samples of the pixels that are drawn, or that would be if there were any.
    pub fn samples(&self) -> u32 {
        if self.accumulation.is_background() {
            return self.request.settings.samples;
        }
        self.schedule.samples()
    }

    /// Which samples the tiles of the picture have.
    pub fn drawn(&self) -> Drawn {
        let drawn = self.schedule.drawn();
        Drawn {
            split_tile: self.accumulation.tile_at(drawn.split_tile),
            ..drawn
        }
    }

    /// Estimates the error, and ends the tiles that need no more samples.
    pub fn estimate(
        &mut self,
        context: &GpuContext,
        pipelines: &Pipelines,
    ) -> Result<(), RenderError> {
        let samples = self.schedule.samples();
        let (accumulation, request) = (&mut self.accumulation, &self.request);
        let errors = readback::tile_errors(context, pipelines, accumulation, request, samples)?;
        let mut whole = PixelErrors::default();
        for tile in &errors {
            whole += *tile;
        }
        self.error_estimate = Some(whole.relative());
        let target = request.settings.error;
        let may_end = target > 0.0
            && request
                .settings
                .optimisations
                .has(Optimisation::ConvergedTiles);
        if may_end && is_decision(samples) {
            let is_done = |tile: &PixelErrors| tile.have_converged(&whole, target);
            if accumulation.end_tiles(context, request, samples, &errors, is_done)? {
                self.schedule.set_tiles(accumulation.drawn_count());
            }
        }
        Ok(())
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        Progress {
            samples: self.samples(),
            error_estimate: self.error_estimate,
            done: self.is_done(),
        }
    }

    /// Draws one slice, at each level of detail that it shows, and waits for it.
    pub fn draw(
        &mut self,
        context: &GpuContext,
        (pipeline, layout): (&wgpu::ComputePipeline, &wgpu::BindGroupLayout),
        scenes: &[SceneBuffers],
        dispatch: &Dispatch,
        shadows: &[Option<ShadowMemory>],
    ) -> Result<(), RenderError> {
        let (buffer, _) = self.accumulation.buffer_of(dispatch.tiles.start);
        let mut slice = self
            .accumulation
            .slice(&self.request, buffer, dispatch.tiles.clone());
        slice.first_sample = dispatch.samples.start;
        slice.end_sample = dispatch.samples.end;
        slice.stride = dispatch.stride;
        slice.pixels_per_tile = dispatch.pixels_per_tile();
        let rows_of_workgroups = rows_of_workgroups(context, &self.request.settings);
        slice.background[3] = rows_of_workgroups as f32;
        let rows = self.accumulation.rows_of(&dispatch.tiles);
        let [from, to] = rows.map(|row| slice.corner[1] + row);
        let levels = self
            .request
            .view
            .rows(self.request.size[1])
            .of_rows(from, to);
        let encoder = context.guarded(|| {
            let mut encoder = context.encoder();
            let buffers = &self.accumulation.levels;
            let all = scenes.iter().zip(buffers).enumerate();
            for (level, (scene, of_level)) in all.filter(|(level, _)| levels.contains(level)) {
                slice.level = level as u32;
                if let Some(Some(shadows)) = shadows.get(level) {
                    shadows.describe(&mut slice);
                }
                let slice = slice_buffer(context, &slice);
                let group = context
                    .device
                    .create_bind_group(&wgpu::BindGroupDescriptor {
                        label: Some("slice"),
                        layout,
                        entries: &[
                            entry(bindings::RAY_TILES, &of_level.rays),
                            entry(bindings::SUMS, &buffer.buffer),
                            entry(bindings::SLICE, &slice),
                            entry(bindings::TOTALS, &of_level.totals),
                        ],
                    });
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &scene.group, &[]);
                pass.set_bind_group(1, &group, &[]);
                pass.dispatch_workgroups(dispatch.workgroups(), rows_of_workgroups, 1);
            }
            encoder
        })?;
        context.submit_and_wait(encoder)?;
        self.schedule.finish(dispatch);
        Ok(())
    }
}

/// Most scatterings of paths whose loops software Vulkan never cuts short when it runs them in step.
const MOST_BOUNCES_IN_STEP: u32 = 5;
/// Whether paths of so many scatterings are too long for software Vulkan to run in step.
fn has_long_paths(context: &GpuContext, bounces: u32) -> bool {
    context.is_software() && bounces > MOST_BOUNCES_IN_STEP
}

/// Whether some paths may go on to their end where others are cut off: not where all would have to run alone for it.
pub fn may_learn_bounces(context: &GpuContext, settings: &Settings) -> bool {
    !has_long_paths(context, settings.bounces)
}

/// Threads that software Vulkan runs in step.
const THREADS_IN_STEP: u32 = 8;

/// How many rows of workgroups share out the threads of a dispatch, each thread working in one of them.
///
/// Mesa's software Vulkan ends all loops of the threads that it runs in step after 65,535 rounds, whatever the loops
/// are about, and reports nothing: paths then end inside the cloth as if they had left it. Where such threads part, the
/// rounds of all of them add up. Eight paths of 64 scatterings in crowded terry need 32,000 in the mean and up to
/// 100,000; one alone 6,000 and up to 50,000. So threads with long paths run alone.
fn rows_of_workgroups(context: &GpuContext, settings: &Settings) -> u32 {
    let bounces = settings.path_cutoff().unwrap_or(settings.bounces);
    if has_long_paths(context, bounces) {
        THREADS_IN_STEP
    } else {
        1
    }
}
