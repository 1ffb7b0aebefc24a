//! What comes back from the device: pictures, the error estimate, counters.

use std::sync::mpsc;

use crate::image::{Aov, Picture};
use crate::render::convergence::PixelErrors;
use crate::render::{Counters, RenderError, RenderRequest};

use super::GpuContext;
use super::accumulation::{Accumulation, COUNTER_BYTES};
use super::bindings::{self, entry, record_dispatch, slice_buffer};
use super::constants::{self, COUNTERS_IN_ALL, TILE, TILE_PIXELS};
use super::layout::Slice;
use super::pipelines::Pipelines;
use super::schedule::Drawn;

/// Tiles that are read back at a time: 32 MiB of pixels, or 96 MiB with extra channels.
const TILES_AT_A_TIME: u32 = 8192;

/// Makes a buffer that shaders write and that can be copied from.
fn output_buffer(context: &GpuContext, size: u64) -> wgpu::Buffer {
    context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("output"),
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// Submits `encoder` with a copy of the first `size` bytes of `source` behind it, and returns the copy.
fn read(
    context: &GpuContext,
    mut encoder: wgpu::CommandEncoder,
    source: &wgpu::Buffer,
    size: u64,
) -> Result<Vec<u8>, RenderError> {
    let staging = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    encoder.copy_buffer_to_buffer(source, 0, &staging, 0, size);
    let failed = |error: &dyn std::fmt::Display| context.failed(error);
    let (sender, receiver) = mpsc::channel();
    context.queue.submit([encoder.finish()]);
    staging
        .slice(..)
        .map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if this function has already failed.
            let _ = sender.send(result);
        });
    context
        .device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|error| failed(&error))?;
    receiver
        .recv()
        .map_err(|error| failed(&error))?
        .map_err(|error| failed(&error))?;
    let bytes = staging
        .slice(..)
        .get_mapped_range()
        .map_err(|error| failed(&error))?
        .to_vec();
    Ok(bytes)
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytemuck::pod_collect_to_vec(bytes)
}

/// The mean so far.
pub fn picture(
    context: &GpuContext,
    pipelines: &Pipelines,
    accumulation: &Accumulation,
    request: &RenderRequest,
    drawn: Drawn,
) -> Result<Picture, RenderError> {
    let aov = request.settings.aov;
    let vectors = if aov { 3 } else { 1 };
    let [width, height] = accumulation.size;
    let count = width as usize * height as usize;
    let mut picture = Picture {
        size: accumulation.size,
        pixels: vec![[0.0; 4]; count],
        aov: aov.then(|| Aov {
            depth: vec![0.0; count],
            normal: vec![[0.0; 3]; count],
            albedo: vec![[0.0; 3]; count],
            noisy: Vec::new(),
        }),
    };
    let made = pipelines.linear.get(context, aov)?;
    for buffer in &accumulation.sums {
        for first in buffer.tiles.clone().step_by(TILES_AT_A_TIME as usize) {
            let tiles = first..(first + TILES_AT_A_TIME).min(buffer.tiles.end);
            let pixels = tiles.len() as u64 * u64::from(TILE_PIXELS);
            let bytes = context.guarded(|| {
                let mut slice = accumulation.slice(request, buffer, tiles.clone());
                show(&mut slice, drawn);
                let slice = slice_buffer(context, &slice);
                let output = output_buffer(context, pixels * vectors as u64 * 16);
                let mut encoder = context.encoder();
                let entries = [
                    entry(bindings::SUMS, &buffer.buffer),
                    entry(bindings::SLICE, &slice),
                    entry(bindings::TILE_ENDS, &accumulation.tile_ends),
                    entry(bindings::LINEAR, &output),
                ];
                let workgroups = pixels.div_ceil(constants::WORKGROUP.into()) as u32;
                record_dispatch(context, &mut encoder, made, &entries, workgroups);
                read(context, encoder, &output, output.size())
            })??;
            let values = floats(&bytes);
            for (index, pixel) in values.chunks_exact(4 * vectors).enumerate() {
                let tile = tiles.start + index as u32 / TILE_PIXELS;
                let within = index as u32 % TILE_PIXELS;
                let x = tile % accumulation.tiles[0] * TILE + within % TILE;
                let y = tile / accumulation.tiles[0] * TILE + within / TILE;
                if x >= width || y >= height {
                    continue;
                }
                let to = y as usize * width as usize + x as usize;
                picture.pixels[to].copy_from_slice(&pixel[..4]);
                if let Some(aov) = &mut picture.aov {
                    aov.normal[to].copy_from_slice(&pixel[4..7]);
                    aov.depth[to] = pixel[7];
                    aov.albedo[to].copy_from_slice(&pixel[8..11]);
                }
            }
        }
    }
    Ok(picture)
}

/// Fills in what has been drawn.
pub fn show(slice: &mut Slice, drawn: Drawn) {
    slice.split_tile = drawn.split_tile;
    (slice.samples_before, slice.lattice_before) = drawn.before;
    (slice.samples_after, slice.lattice_after) = drawn.after;
}

/// The error of each tile, of which those that are drawn have `samples` samples.
pub fn tile_errors(
    context: &GpuContext,
    pipelines: &Pipelines,
    accumulation: &Accumulation,
    request: &RenderRequest,
    samples: u32,
) -> Result<Vec<PixelErrors>, RenderError> {
    let made = pipelines.error.get(context, request.settings.aov)?;
    // One workgroup a tile, so no more tiles in a dispatch than it may have workgroups.
    let tiles_at_a_time = context.limits.max_compute_workgroups_per_dimension;
    let mut errors = Vec::new();
    for buffer in &accumulation.sums {
        for first in buffer.tiles.clone().step_by(tiles_at_a_time as usize) {
            let tiles = first..first.saturating_add(tiles_at_a_time).min(buffer.tiles.end);
            let bytes = context.guarded(|| {
                let mut slice = accumulation.slice(request, buffer, tiles.clone());
                slice.samples_before = samples;
                let slice = slice_buffer(context, &slice);
                let output = output_buffer(context, tiles.len() as u64 * 8);
                let mut encoder = context.encoder();
                let entries = [
                    entry(bindings::SUMS, &buffer.buffer),
                    entry(bindings::SLICE, &slice),
                    entry(bindings::TILE_ENDS, &accumulation.tile_ends),
                    entry(bindings::TILE_ERRORS, &output),
                ];
                record_dispatch(context, &mut encoder, made, &entries, tiles.len() as u32);
                read(context, encoder, &output, output.size())
            })??;
            let found = floats(&bytes);
            errors.extend(
                (tiles.zip(found.chunks_exact(2))).map(|(tile, error)| PixelErrors {
                    variance: f64::from(error[0]),
                    sum: f64::from(error[1]),
                    pixels: accumulation.pixels_of(tile),
                }),
            );
        }
    }
    Ok(errors)
}

/// Work done since the accumulation was made.
pub fn counters(
    context: &GpuContext,
    accumulation: &Accumulation,
) -> Result<Counters, RenderError> {
    let mut sum = Counters::default();
    for level in &accumulation.levels {
        sum += counters_in(context, &level.totals)?;
    }
    Ok(sum)
}

fn counters_in(context: &GpuContext, totals: &wgpu::Buffer) -> Result<Counters, RenderError> {
    let bytes = context.guarded(|| read(context, context.encoder(), totals, COUNTER_BYTES))??;
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    let total = |which: u32| {
        debug_assert!(which < COUNTERS_IN_ALL);
        let at = 2 * which as usize;
        u64::from(words[at]) | u64::from(words[at + 1]) << 32
    };
    Ok(Counters {
        rays: total(constants::COUNT_RAYS),
        shadow_rays: total(constants::COUNT_SHADOW_RAYS),
        cells: total(constants::COUNT_CELLS),
        patch_tests: total(constants::COUNT_PATCH_TESTS),
        volume_samples: total(constants::COUNT_VOLUME_SAMPLES),
        contributing_hits: total(constants::COUNT_CONTRIBUTING_HITS),
        ended_rays: total(constants::COUNT_ENDED_RAYS),
        cached_rays: total(constants::COUNT_CACHED_RAYS),
        hidden_rays: total(constants::COUNT_HIDDEN_RAYS),
        ..Counters::default()
    })
}
