//! What live views learn of light on the device (see [`crate::render::shadow_cache`] and
//! [`crate::render::bounced_light`]): one buffer with the counters, so that the tracing program needs no more bindings
//! than every device has.

use crate::render::bounced_light::BouncedKey;
use crate::render::shadow_cache::ShadowKey;
use crate::render::{RenderError, RenderRequest};

use super::GpuContext;
use super::bindings::{self, entry, record_dispatch};
use super::constants::{BOUNCED_SUMS, LEARNED_ROOMS, SHADOW_SUMS, SHADOWS_FROM, WORKGROUP};
use super::layout::Slice;
use super::pipelines::Pipelines;

/// Most workgroups in one dimension of a dispatch, in WebGPU.
const MAX_WORKGROUPS: u32 = 65_535;
/// Words of a texel of light that goes on: its ratios and its sums.
const BOUNCED_WORDS: u32 = 3 + BOUNCED_SUMS;
/// How many `LEARNED_*` words there are.
const LEARNED_WORDS: usize = (SHADOWS_FROM - LEARNED_ROOMS) as usize;

/// Where what lies in the buffer, in words.
#[derive(Debug, Clone, Copy)]
struct Layout {
    /// Entries of the shadow cache that there is room for.
    entries: u32,
    means: u32,
    sums: u32,
    ratios: u32,
    /// Texels of light that goes on.
    texels: u32,
}

impl Layout {
    fn new(key: &ShadowKey, bounced: Option<&BouncedKey>) -> Self {
        let grid = &key.grid;
        let pages: u32 = grid.pages().iter().product();
        let entries = (grid.most_pages() * grid.page_entries()) as u32;
        let means = SHADOWS_FROM + pages;
        let sums = means + entries;
        Self {
            entries,
            means,
            sums,
            ratios: sums + SHADOW_SUMS * entries,
            texels: bounced.map_or(0, |bounced| bounced.grid.texel_count() as u32),
        }
    }

    fn bytes(&self) -> u64 {
        4 * u64::from(self.ratios + BOUNCED_WORDS * self.texels)
    }

    /// The `LEARNED_*` words.
    fn words(&self, key: &ShadowKey, bounced: Option<&BouncedKey>) -> [u32; LEARNED_WORDS] {
        let bits = |steps: f64| (steps as f32).to_bits();
        let [across, along, _] = bounced.map_or([0; 3], |bounced| bounced.grid.texels);
        [
            0,
            key.grid.most_pages() as u32,
            key.grid.page_entries() as u32,
            self.means,
            self.sums,
            bits(key.steps_per_radiance()),
            self.ratios,
            self.texels,
            across,
            along,
            bounced.map_or(0, |bounced| bounced.grid.shift),
            bits(bounced.map_or(0.0, BouncedKey::steps_per_radiance)),
        ]
    }
}

/// What pictures of one cloth in one light have learned of its shadows and of its light that goes on.
#[derive(Debug)]
pub struct ShadowMemory {
    /// Counters, then means and sums of shadows, then ratios and sums of light that goes on.
    pub buffer: wgpu::Buffer,
    layout: Layout,
    key: ShadowKey,
    /// `None` where paths are not cut off.
    bounced: Option<BouncedKey>,
}

impl ShadowMemory {
    /// For `request`: `old` as far as it knows the same light; `None` if the request has no use for it or the device no
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
        let bounced = BouncedKey::new(request);
        let is_same =
            |old: &Self| old.key.is_same(&key) && old.bounced.is_some() == bounced.is_some();
        if let Some(old) = old.filter(is_same) {
            return old.with_bounced(context, bounced).map(Some);
        }
        let made = Layout::new(&key, bounced.as_ref());
        if made.bytes() > context.largest_binding() {
            return Ok(None);
        }
        // New buffers are zeros.
        let buffer = context.guarded(|| {
            let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("counters and learned light"),
                size: made.bytes(),
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            let words = made.words(&key, bounced.as_ref());
            let at = 4 * u64::from(LEARNED_ROOMS);
            (context.queue).write_buffer(&buffer, at, bytemuck::cast_slice(&words));
            buffer
        })?;
        Ok(Some(Self {
            buffer,
            layout: made,
            key,
            bounced,
        }))
    }

    /// Keeps its shadows, and its corrections of multiple scattering if those hold for `bounced`; else clears these.
    fn with_bounced(
        self,
        context: &GpuContext,
        bounced: Option<BouncedKey>,
    ) -> Result<Self, RenderError> {
        let is_same = match (&self.bounced, &bounced) {
            (Some(old), Some(new)) => old.is_same(new),
            _ => true,
        };
        if !is_same {
            context.guarded(|| {
                let mut encoder = context.encoder();
                let from = 4 * u64::from(self.layout.ratios);
                encoder.clear_buffer(&self.buffer, from, None);
                context.queue.submit([encoder.finish()]);
            })?;
        }
        Ok(Self { bounced, ..self })
    }

    /// Whether it learns of light that goes on.
    pub fn learns_bounces(&self) -> bool {
        self.bounced.is_some()
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
        let workgroups = self.layout.entries.div_ceil(WORKGROUP).min(MAX_WORKGROUPS);
        context.guarded(|| {
            let mut encoder = context.encoder();
            let entries = [entry(bindings::TOTALS, &self.buffer)];
            record_dispatch(context, &mut encoder, made, &entries, workgroups);
            context.queue.submit([encoder.finish()]);
        })
    }
}
