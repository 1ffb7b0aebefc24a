//! The programs and their pipelines, made when first needed and kept.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::render::RenderError;

use super::GpuContext;
use super::bindings::{self, other, storage, uniform};
use super::layout::Slice;
use super::pipeline_compiler::PipelineCompiler;
use super::program::Program;
use super::scene_bindings;
use super::shaders::{ERROR, FINALISE, RESOLVE, TRACE};

/// All pipelines of a device.
#[derive(Debug)]
pub struct Pipelines {
    /// Layout of group 0 of the tracing program.
    pub scene_layout: wgpu::BindGroupLayout,
    /// Makes the pipelines that add samples.
    pub trace: PipelineCompiler,
    display: Program,
    linear: Program,
    error: Program,
    finalise: Program,
    /// Keyed by AOV.
    displays: HashMap<bool, wgpu::ComputePipeline>,
    linears: HashMap<bool, wgpu::ComputePipeline>,
    errors: HashMap<bool, wgpu::ComputePipeline>,
    finaliser: Option<wgpu::ComputePipeline>,
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
        let program = |parts, scene, entries: &[_]| Program::new(context, parts, scene, entries);
        let trace = program(
            TRACE,
            Some(&scene_layout),
            &[
                storage(bindings::RAY_TILES, true),
                sums,
                slice,
                storage(bindings::TOTALS, false),
            ],
        )?;
        Ok(Self {
            trace: PipelineCompiler::new(context, trace)?,
            display: program(RESOLVE, None, &[sums, slice, ends, display])?,
            linear: program(
                RESOLVE,
                None,
                &[sums, slice, ends, storage(bindings::LINEAR, false)],
            )?,
            error: program(
                ERROR,
                None,
                &[sums, slice, ends, storage(bindings::TILE_ERRORS, false)],
            )?,
            finalise: program(FINALISE, None, &[storage(bindings::TOTALS, false)])?,
            scene_layout,
            displays: HashMap::new(),
            linears: HashMap::new(),
            errors: HashMap::new(),
            finaliser: None,
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
    pub fn finalise(&mut self, context: &GpuContext) -> Made<'_> {
        let pipeline = match self.finaliser.take() {
            Some(pipeline) => pipeline,
            None => self.finalise.pipeline(context, "finalise_main", &[])?,
        };
        Ok((self.finaliser.insert(pipeline), &self.finalise.group))
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
