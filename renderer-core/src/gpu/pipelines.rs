//! The programs and their pipelines, made when first needed and kept.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::render::RenderError;

use super::GpuContext;
use super::builder::Builder;
use super::kept::KeptPipelines;
use super::layout::{SceneConstants, Slice};
use super::shaders::{Composed, ERROR, Part, RESOLVE, SETTLE, TRACE};

/// Bindings of group 1; group 0 is the scene's.
pub mod binding {
    /// Ray tiles.
    pub const RAY_TILES: u32 = 0;
    /// Accumulation.
    pub const SUMS: u32 = 1;
    /// The slice.
    pub const SLICE: u32 = 2;
    /// Counters.
    pub const TOTALS: u32 = 3;
    /// Display texture.
    pub const DISPLAY: u32 = 4;
    /// Linear pixels to read back.
    pub const LINEAR: u32 = 5;
    /// Errors of tiles to read back.
    pub const TILE_ERRORS: u32 = 6;
    /// Where tiles ended.
    pub const TILE_ENDS: u32 = 7;
}

/// A program and the layouts of its bindings.
#[derive(Debug)]
pub struct Program {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    /// Layout of group 1.
    pub group: wgpu::BindGroupLayout,
}

/// All pipelines of a device.
#[derive(Debug)]
pub struct Pipelines {
    /// Layout of group 0 of the tracing program.
    pub scene_layout: wgpu::BindGroupLayout,
    /// Makes the pipelines that add samples.
    pub trace: Builder,
    display: Program,
    linear: Program,
    error: Program,
    settle: Program,
    /// Keyed by AOV.
    displays: HashMap<bool, wgpu::ComputePipeline>,
    linears: HashMap<bool, wgpu::ComputePipeline>,
    errors: HashMap<bool, wgpu::ComputePipeline>,
    settled: Option<wgpu::ComputePipeline>,
}

fn storage(binding: u32, read_only: bool) -> wgpu::BindGroupLayoutEntry {
    buffer(binding, wgpu::BufferBindingType::Storage { read_only }, 0)
}

fn uniform(binding: u32, size: usize) -> wgpu::BindGroupLayoutEntry {
    buffer(binding, wgpu::BufferBindingType::Uniform, size)
}

fn buffer(binding: u32, ty: wgpu::BufferBindingType, size: usize) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: std::num::NonZeroU64::new(size as u64),
        },
        count: None,
    }
}

fn other(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

fn volume(binding: u32) -> wgpu::BindGroupLayoutEntry {
    other(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        },
    )
}

/// A texture read texel by texel.
fn table(binding: u32) -> wgpu::BindGroupLayoutEntry {
    other(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
    )
}

impl Program {
    fn new(
        context: &GpuContext,
        parts: &[Part],
        scene: Option<&wgpu::BindGroupLayout>,
        entries: &[wgpu::BindGroupLayoutEntry],
    ) -> Result<Self, RenderError> {
        let device = &context.device;
        let module = Composed::new(parts).compile(device)?;
        context.guarded(|| {
            let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries,
            });
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[scene, Some(&group)],
                immediate_size: 0,
            });
            Self {
                module,
                layout,
                group,
            }
        })
    }

    /// A pipeline with these values of its `override` constants.
    pub fn pipeline(
        &self,
        context: &GpuContext,
        entry_point: &str,
        constants: &[(&str, f64)],
    ) -> Result<wgpu::ComputePipeline, RenderError> {
        context.guarded(|| {
            context
                .device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(entry_point),
                    layout: Some(&self.layout),
                    module: &self.module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants,
                        ..Default::default()
                    },
                    cache: context.kept.as_deref().map(KeptPipelines::cache),
                })
        })
    }
}

impl Pipelines {
    /// Reads all programs; pipelines are made when first used.
    pub fn new(context: &GpuContext) -> Result<Self, RenderError> {
        let scene_layout = context.guarded(|| {
            let entries = [
                uniform(0, size_of::<SceneConstants>()),
                storage(1, true),
                storage(2, true),
                storage(3, true),
                storage(4, true),
                storage(5, true),
                table(6),
                volume(7),
                volume(8),
                volume(9),
                other(
                    10,
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                ),
                table(11),
                table(12),
            ];
            context
                .device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some("scene"),
                    entries: &entries,
                })
        })?;
        let sums = storage(binding::SUMS, false);
        let slice = uniform(binding::SLICE, size_of::<Slice>());
        let ends = storage(binding::TILE_ENDS, true);
        let display = other(
            binding::DISPLAY,
            wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: wgpu::TextureFormat::Rgba8Unorm,
                view_dimension: wgpu::TextureViewDimension::D2,
            },
        );
        let program = |parts, scene, entries: &[_]| Program::new(context, parts, scene, entries);
        let trace = program(
            TRACE,
            Some(&scene_layout),
            &[
                storage(binding::RAY_TILES, true),
                sums,
                slice,
                storage(binding::TOTALS, false),
            ],
        )?;
        Ok(Self {
            trace: Builder::new(context, trace)?,
            display: program(RESOLVE, None, &[sums, slice, ends, display])?,
            linear: program(
                RESOLVE,
                None,
                &[sums, slice, ends, storage(binding::LINEAR, false)],
            )?,
            error: program(
                ERROR,
                None,
                &[sums, slice, ends, storage(binding::TILE_ERRORS, false)],
            )?,
            settle: program(SETTLE, None, &[storage(binding::TOTALS, false)])?,
            scene_layout,
            displays: HashMap::new(),
            linears: HashMap::new(),
            errors: HashMap::new(),
            settled: None,
        })
    }

    /// The pipeline that fills the display texture.
    pub fn display(&mut self, context: &GpuContext, aov: bool) -> Made<'_> {
        made(
            &self.display,
            &mut self.displays,
            context,
            "resolve_display",
            aov,
        )
    }

    /// The pipeline that fills a buffer with linear pixels.
    pub fn linear(&mut self, context: &GpuContext, aov: bool) -> Made<'_> {
        made(
            &self.linear,
            &mut self.linears,
            context,
            "resolve_linear",
            aov,
        )
    }

    /// The pipeline that sums up errors.
    pub fn error(&mut self, context: &GpuContext, aov: bool) -> Made<'_> {
        made(&self.error, &mut self.errors, context, "error_main", aov)
    }

    /// The pipeline that makes learned shadows known.
    pub fn settle(&mut self, context: &GpuContext) -> Made<'_> {
        let pipeline = match self.settled.take() {
            Some(pipeline) => pipeline,
            None => self.settle.pipeline(context, "settle_main", &[])?,
        };
        Ok((self.settled.insert(pipeline), &self.settle.group))
    }
}

/// A pipeline and the layout of its group 1.
pub type Made<'a> = Result<(&'a wgpu::ComputePipeline, &'a wgpu::BindGroupLayout), RenderError>;

/// The pipeline for `aov` of a program that depends on nothing else.
fn made<'a>(
    program: &'a Program,
    made: &'a mut HashMap<bool, wgpu::ComputePipeline>,
    context: &GpuContext,
    entry_point: &str,
    aov: bool,
) -> Made<'a> {
    let pipeline = match made.entry(aov) {
        Entry::Occupied(made) => made.into_mut(),
        Entry::Vacant(place) => {
            let constants = [("AOV", f64::from(u8::from(aov)))];
            place.insert(program.pipeline(context, entry_point, &constants)?)
        }
    };
    Ok((pipeline, &program.group))
}
