//! The shadow cache on the device (see [`crate::render::shadow_cache`]): one buffer with the counters, so that the
//! tracing program needs no more bindings than every device has.

use crate::render::shadow_cache::ShadowKey;
use crate::render::{RenderError, RenderRequest};

use super::GpuContext;
use super::bindings::{self, entry, record_dispatch};
use super::constants::{SHADOWS_FROM, WORKGROUP};
use super::layout::Slice;
use super::pipelines::Pipelines;

/// Most workgroups in one dimension of a dispatch, in WebGPU.
const MAX_WORKGROUPS: u32 = 65_535;

/// What pictures of one cloth in one light have learned of its shadows.
#[derive(Debug)]
pub struct ShadowMemory {
    /// Counters, then means, then sums.
    pub buffer: wgpu::Buffer,
    entries: u32,
    key: ShadowKey,
}

impl ShadowMemory {
    /// For `request`: `old` if it knows the same shadows; `None` if the request has no use for it or the device no
    /// room.
    ///
    /// # Errors
    /// When the device fails.
    pub fn new(
        context: &GpuContext,
        request: &RenderRequest,
        old: Option<Self>,
    ) -> Result<Option<Self>, RenderError> {
        let Some(key) = ShadowKey::new(request) else {
            return Ok(None);
        };
        if let Some(old) = old.filter(|old| old.key.is_same(&key)) {
            return Ok(Some(old));
        }
        let entries = key.grid.entries() as u32;
        let size = 4 * (u64::from(SHADOWS_FROM) + 4 * u64::from(entries));
        if size > context.largest_binding() {
            return Ok(None);
        }
        // New buffers are zeros.
        let buffer = context.guarded(|| {
            context.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("counters and shadows"),
                size,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        })?;
        Ok(Some(Self {
            buffer,
            entries,
            key,
        }))
    }

    /// Tells the shaders of its texels.
    pub fn describe(&self, slice: &mut Slice) {
        let grid = &self.key.grid;
        let [x, y, z] = grid.texels;
        slice.shadow_texels = [x, y, z, grid.lights];
        slice.shadow_per_cell = grid.per_cell as i32;
        slice.shadow_shift = grid.shift;
        slice.shadow_layers_below = grid.layers_below as i32;
        slice.shadow_layers_per_mm = (1.0 / grid.layer_mm) as f32;
    }

    /// Makes what has been learned known: between two samples.
    ///
    /// # Errors
    /// When the device fails.
    pub fn finalise(&self, context: &GpuContext, pipelines: &Pipelines) -> Result<(), RenderError> {
        let made = pipelines.finalise.get(context, false)?;
        let workgroups = self.entries.div_ceil(WORKGROUP).min(MAX_WORKGROUPS);
        context.guarded(|| {
            let mut encoder = context.encoder();
            let entries = [entry(bindings::TOTALS, &self.buffer)];
            record_dispatch(context, &mut encoder, made, &entries, workgroups);
            context.queue.submit([encoder.finish()]);
        })
    }
}
