//! The programs of a device and their pipelines, made when first needed and kept, for all backends that share them.

use std::sync::OnceLock;

use crate::render::RenderError;

use super::GpuContext;
use super::bindings::{self, other, storage, uniform};
use super::layout::Slice;
use super::pipeline_compiler::PipelineCompiler;
use super::program::Program;
use super::scene_bindings;
use super::shaders::{ERROR, FINALISE, Part, RESOLVE, TRACE};

/// All pipelines of a device.
#[derive(Debug)]
pub struct Pipelines {
    /// Layout of group 0 of the tracing program.
    pub scene_layout: wgpu::BindGroupLayout,
    /// Makes the pipelines that add samples.
    pub trace: PipelineCompiler,
    /// Fills the display texture.
    pub display: ByAov,
    /// Fills a buffer with linear pixels.
    pub linear: ByAov,
    /// Sums up errors.
    pub error: ByAov,
    /// Makes learned shadows known; the same for both.
    pub finalise: ByAov,
}

impl Pipelines {
    /// Reads all programs; pipelines are made when first used.
    pub fn new(context: &GpuContext) -> Result<Self, RenderError> {
        let scene_layout = scene_bindings::layout(context)?;
        let sums = storage(bindings::SUMS, false);
        let slice = uniform(bindings::SLICE, size_of::<Slice>());
        let ends = storage(bindings::TILE_ENDS, true);
        let display = other(
            bindings::DISPLAY,
            wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: wgpu::TextureFormat::Rgba8Unorm,
                view_dimension: wgpu::TextureViewDimension::D2,
            },
        );
        let totals = storage(bindings::TOTALS, false);
        let rays = storage(bindings::RAY_TILES, true);
        let trace = &[rays, sums, slice, totals];
        let trace = Program::new(context, TRACE, Some(&scene_layout), trace)?;
        let linear = storage(bindings::LINEAR, false);
        let errors = storage(bindings::TILE_ERRORS, false);
        let by_aov = |parts, entry, bound: &[_]| ByAov::new(context, parts, entry, bound);
        Ok(Self {
            trace: PipelineCompiler::new(context, trace)?,
            display: by_aov(RESOLVE, "resolve_display", &[sums, slice, ends, display])?,
            linear: by_aov(RESOLVE, "resolve_linear", &[sums, slice, ends, linear])?,
            error: by_aov(ERROR, "error_main", &[sums, slice, ends, errors])?,
            finalise: by_aov(FINALISE, "finalise_main", &[totals])?,
            scene_layout,
        })
    }
}

/// A pipeline and the layout of its group 1.
pub type Made<'a> = Result<(&'a wgpu::ComputePipeline, &'a wgpu::BindGroupLayout), RenderError>;

/// A program of which there are two pipelines: for sums with and without AOVs.
#[derive(Debug)]
pub struct ByAov {
    program: Program,
    entry_point: &'static str,
    made: [OnceLock<wgpu::ComputePipeline>; 2],
}

impl ByAov {
    fn new(
        context: &GpuContext,
        parts: &[Part],
        entry_point: &'static str,
        bound: &[wgpu::BindGroupLayoutEntry],
    ) -> Result<Self, RenderError> {
        Ok(Self {
            program: Program::new(context, parts, None, bound)?,
            entry_point,
            made: Default::default(),
        })
    }

    /// The pipeline, made now if it is not yet. Where two threads make it at once, both use the first that is there.
    pub fn get(&self, context: &GpuContext, aov: bool) -> Made<'_> {
        let place = &self.made[usize::from(aov)];
        let pipeline = match place.get() {
            Some(pipeline) => pipeline,
            None => {
                let constants = [("AOV", f64::from(u8::from(aov)))];
                let made = self
                    .program
                    .pipeline(context, self.entry_point, &constants)?;
                place.get_or_init(|| made)
            }
        };
        Ok((pipeline, &self.program.group))
    }
}
