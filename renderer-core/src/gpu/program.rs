//! A WGSL program as the device holds it, and pipelines of it.

use crate::render::RenderError;

use super::GpuContext;
use super::pipeline_cache::PipelineCache;
use super::shaders::{Composed, Part};

/// A program and the layouts of its bindings.
#[derive(Debug)]
pub struct Program {
    text: Composed,
    layout: wgpu::PipelineLayout,
    /// Layout of group 1.
    pub group: wgpu::BindGroupLayout,
}

impl Program {
    /// Composes `parts`, with the layout of the scene if they read one, and `entries` as group 1.
    ///
    /// # Errors
    /// When the device refuses the layouts.
    pub fn new(
        context: &GpuContext,
        parts: &[Part],
        scene: Option<&wgpu::BindGroupLayout>,
        entries: &[wgpu::BindGroupLayoutEntry],
    ) -> Result<Self, RenderError> {
        let device = &context.device;
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
                text: Composed::new(parts),
                layout,
                group,
            }
        })
    }

    /// A pipeline with these values of its `override` constants. Its text is compiled for them alone: that takes a
    /// small part of the time in which drivers would go through what it does not use.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn pipeline(
        &self,
        context: &GpuContext,
        entry_point: &str,
        constants: &[(&str, f64)],
    ) -> Result<wgpu::ComputePipeline, RenderError> {
        let module = self.text.specialised(constants).compile(&context.device)?;
        context.guarded(|| {
            context
                .device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(entry_point),
                    layout: Some(&self.layout),
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants,
                        ..Default::default()
                    },
                    cache: context.pipeline_cache.as_deref().map(PipelineCache::cache),
                })
        })
    }
}
