//! The sums of a picture on the device: several buffers where one would be larger than can be bound; and which of its
//! tiles are drawn.

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::render::convergence::PixelErrors;
use crate::render::{
    Counters, Optimisation, RenderError, RenderRequest, background_tiles, cloth_box,
};

use super::GpuContext;
use super::constants::{ALL_BACKGROUND, COUNTERS_IN_ALL, SUMS, SUMS_WITH_AOV, TILE, TILE_PIXELS};
use super::layout::{RayTile, Slice};
use super::shadow_memory::ShadowMemory;

/// Bytes of all counters.
pub const COUNTER_BYTES: u64 = COUNTERS_IN_ALL as u64 * 8;

/// Sums of consecutive tiles.
#[derive(Debug)]
pub struct SumBuffer {
    /// The buffer.
    pub buffer: wgpu::Buffer,
    /// The tiles whose sums it holds.
    pub tiles: Range<u32>,
}

/// Buffers of one level of detail.
#[derive(Debug)]
pub struct LevelBuffers {
    /// Ray bases of the tiles that are drawn, in their order.
    pub rays: wgpu::Buffer,
    /// Counters, and behind them shadows, if they are cached.
    pub totals: wgpu::Buffer,
}

/// The sums of one picture and the rays of its tiles.
#[derive(Debug)]
pub struct Accumulation {
    /// Width and height of the picture that is made (the crop), pixels.
    pub size: [u32; 2],
    /// Tiles along x and y.
    pub tiles: [u32; 2],
    /// Bytes of a tile's sums.
    tile_bytes: u64,
    /// Sums, in the order of tiles.
    pub sums: Vec<SumBuffer>,
    /// What differs from one level of detail to the next.
    pub levels: Vec<LevelBuffers>,
    /// Where each tile ended, as the shaders see it.
    pub tile_ends: wgpu::Buffer,
    /// For each tile 0 while it is drawn, then its samples; `ALL_BACKGROUND` if it never was.
    ends: Vec<u32>,
    /// The tiles that are drawn.
    drawn: Vec<u32>,
}

fn output_buffer(context: &GpuContext, label: &str, size: u64) -> wgpu::Buffer {
    context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

impl LevelBuffers {
    fn allocate(context: &GpuContext, tiles: u32) -> Self {
        let rays = u64::from(tiles) * size_of::<RayTile>() as u64;
        Self {
            rays: output_buffer(context, "ray tiles", rays),
            totals: output_buffer(context, "counters", COUNTER_BYTES),
        }
    }
}

impl Accumulation {
    /// Makes room for the picture of `request`, all zeros; in the buffers of `old` where they fit, so that a moving
    /// camera does not allocate. Counters of each level share the buffer of its `shadows`, if there are any.
    ///
    /// # Errors
    /// When there is no room.
    pub fn new(
        context: &GpuContext,
        request: &RenderRequest,
        old: Option<Self>,
        shadows: &[Option<ShadowMemory>],
    ) -> Result<Self, RenderError> {
        let [_, _, width, height] = request.crop;
        let tiles = [width.div_ceil(TILE), height.div_ceil(TILE)];
        context.check(
            "the bytes of the picture's ray bases",
            u64::from(tiles[0]) * u64::from(tiles[1]) * size_of::<RayTile>() as u64,
            context.largest_binding(),
        )?;
        let ends = if request
            .settings
            .optimisations
            .has(Optimisation::BackgroundTiles)
        {
            let is_background = background_tiles(request, TILE).into_iter();
            is_background
                .map(|is| if is { ALL_BACKGROUND } else { 0 })
                .collect()
        } else {
            vec![0; tiles[0] as usize * tiles[1] as usize]
        };
        let per_pixel = if request.settings.aov {
            SUMS_WITH_AOV
        } else {
            SUMS
        };
        let tile_bytes = u64::from(TILE_PIXELS * per_pixel) * 16;
        let mut made = match old.filter(|old| old.tiles == tiles && old.tile_bytes == tile_bytes) {
            Some(old) => Self {
                size: [width, height],
                ..old
            },
            None => context.guarded(|| Self::allocate(context, [width, height], tile_bytes))?,
        };
        context.guarded(|| {
            let mut encoder = context.encoder();
            for sums in &made.sums {
                encoder.clear_buffer(&sums.buffer, 0, None);
            }
            made.levels.truncate(shadows.len());
            while made.levels.len() < shadows.len() {
                let level = LevelBuffers::allocate(context, made.tile_count());
                made.levels.push(level);
            }
            for (level, shadows) in made.levels.iter_mut().zip(shadows) {
                if let Some(shadows) = shadows {
                    level.totals = shadows.buffer.clone();
                } else if level.totals.size() != COUNTER_BYTES {
                    level.totals = output_buffer(context, "counters", COUNTER_BYTES);
                }
                encoder.clear_buffer(&level.totals, 0, Some(COUNTER_BYTES));
            }
            made.ends = ends;
            made.draw_those_left(context, request);
            context.queue.submit([encoder.finish()]);
            made
        })
    }

    /// Tells the device which tiles have not ended.
    fn draw_those_left(&mut self, context: &GpuContext, request: &RenderRequest) {
        let tiles = (0_u32..).zip(&self.ends);
        self.drawn = tiles
            .filter(|(_, end)| **end == 0)
            .map(|(tile, _)| tile)
            .collect();
        let queue = &context.queue;
        for (index, level) in self.levels.iter().enumerate() {
            let rays = ray_tiles(&request.at_level(index), self.tiles[0], &self.drawn);
            queue.write_buffer(&level.rays, 0, bytemuck::cast_slice(&rays));
        }
        queue.write_buffer(&self.tile_ends, 0, bytemuck::cast_slice(&self.ends));
    }

    /// Ends every tile that has `samples` samples and `is_done(its error)`; true if there are any.
    ///
    /// # Errors
    /// When the device fails.
    pub fn end_tiles(
        &mut self,
        context: &GpuContext,
        request: &RenderRequest,
        samples: u32,
        errors: &[PixelErrors],
        is_done: impl Fn(&PixelErrors) -> bool,
    ) -> Result<bool, RenderError> {
        let before = self.drawn.len();
        self.drawn.retain(|tile| {
            let done = is_done(&errors[*tile as usize]);
            if done {
                self.ends[*tile as usize] = samples;
            }
            !done
        });
        let any = self.drawn.len() < before;
        if any {
            context.guarded(|| self.draw_those_left(context, request))?;
        }
        Ok(any)
    }

    /// Whether any tile has ended before the picture.
    pub fn has_converged_tiles(&self) -> bool {
        let mut ends = self.ends.iter();
        ends.any(|end| ![0, ALL_BACKGROUND].contains(end))
    }

    /// Whether there is nothing but background.
    pub fn is_background(&self) -> bool {
        self.ends.iter().all(|end| *end == ALL_BACKGROUND)
    }

    /// Samples of whole tiles that are left out of `samples` of each: of background, and of converged tiles.
    pub fn left_out(&self, samples: u32) -> Counters {
        let mut counters = Counters::default();
        for &end in &self.ends {
            match end {
                0 => {}
                ALL_BACKGROUND => counters.skipped_tiles += u64::from(samples),
                end => counters.converged_tiles += u64::from(samples.saturating_sub(end)),
            }
        }
        counters
    }

    fn allocate(context: &GpuContext, size: [u32; 2], tile_bytes: u64) -> Self {
        let tiles = size.map(|side| side.div_ceil(TILE));
        let count = tiles[0] * tiles[1];
        let tiles_in_buffer =
            (context.largest_binding() / tile_bytes).clamp(1, u64::from(count)) as u32;
        let buffer = |label, size| output_buffer(context, label, size);
        let sums = (0..count)
            .step_by(tiles_in_buffer as usize)
            .map(|first| {
                let tiles = first..(first + tiles_in_buffer).min(count);
                SumBuffer {
                    buffer: buffer("sums", tiles.len() as u64 * tile_bytes),
                    tiles,
                }
            })
            .collect();
        Self {
            size,
            tiles,
            tile_bytes,
            sums,
            levels: Vec::new(),
            tile_ends: buffer("tile ends", u64::from(count) * 4),
            ends: Vec::new(),
            drawn: Vec::new(),
        }
    }

    fn tile_count(&self) -> u32 {
        self.tiles[0] * self.tiles[1]
    }

    /// How many tiles are drawn.
    pub fn drawn_count(&self) -> u32 {
        self.drawn.len() as u32
    }

    /// Which tile has a place among those that are drawn; beyond all tiles for a place beyond the last.
    pub fn tile_at(&self, place: u32) -> u32 {
        let tile = self.drawn.get(place as usize).copied();
        tile.unwrap_or(self.tile_count())
    }

    /// The buffer that holds the sums of the drawn tile at a place, and the place of the first one beyond it.
    pub fn buffer_of(&self, place: u32) -> (&SumBuffer, u32) {
        let tile = self.tile_at(place);
        let index = self.sums.partition_point(|sums| sums.tiles.end <= tile);
        let buffer = &self.sums[index.min(self.sums.len() - 1)];
        let beyond = |tile: &u32| *tile < buffer.tiles.end;
        (buffer, self.drawn.partition_point(beyond) as u32)
    }

    /// Rows of the picture made, from the first to the last, that lie in the drawn tiles at some places.
    pub fn rows_of(&self, places: &Range<u32>) -> [u32; 2] {
        let row = |place: u32| self.tile_at(place) / self.tiles[0] * TILE;
        let last = row(places.end - 1) + TILE - 1;
        [row(places.start), last.min(self.size[1] - 1)]
    }

    /// Pixels of a tile.
    pub fn pixels_of(&self, tile: u32) -> u64 {
        let corner = [tile % self.tiles[0], tile / self.tiles[0]].map(|index| index * TILE);
        let side = |axis: usize| u64::from((self.size[axis] - corner[axis]).min(TILE));
        side(0) * side(1)
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let sums: u64 = self.sums.iter().map(|sums| sums.buffer.size()).sum();
        let levels = self.levels.iter();
        let levels: u64 = levels
            .map(|level| level.rays.size() + level.totals.size())
            .sum();
        sums + levels + self.tile_ends.size()
    }

    /// What is the same in every slice of this picture, for tiles of one buffer.
    pub fn slice(&self, request: &RenderRequest, buffer: &SumBuffer, tiles: Range<u32>) -> Slice {
        let [x, y, _, _] = request.crop;
        let [red, green, blue] = request.scene().lights.background.map(|c| c as f32);
        let levels = request.view.rows(request.size[1]);
        Slice {
            size: self.size,
            corner: [x, y],
            tiles_across: self.tiles[0],
            buffer_first_tile: buffer.tiles.start,
            first_tile: tiles.start,
            end_tile: tiles.end,
            first_sample: 0,
            end_sample: 0,
            stride: 0,
            pixels_per_tile: TILE_PIXELS,
            seed: request.settings.seed,
            bounces: request.settings.bounces,
            split_tile: 0,
            samples_before: 0,
            samples_after: 0,
            lattice_before: 0,
            lattice_after: 0,
            tone_map: 0,
            exposure_scale: 1.0,
            path_cutoff: request.settings.path_cutoff().unwrap_or(0),
            step: request.settings.step_mm as f32,
            cached_shadows: request.settings.cached_shadows,
            level: 0,
            last_level: levels.last,
            first_row_fineness: levels.at_first_row,
            fineness_per_row: levels.per_row,
            shadow_texels: [0; 4],
            shadow_per_cell: 0,
            shadow_shift: 0,
            shadow_layers_below: 0,
            shadow_layers_per_mm: 0.0,
            background: [red, green, blue, 0.0],
        }
    }
}

/// Ray bases of some tiles of a picture `across` tiles wide; a tile's reference point is its centre.
fn ray_tiles(request: &RenderRequest, across: u32, tiles: &[u32]) -> Vec<RayTile> {
    let scene = request.scene();
    let cloth = cloth_box(scene);
    let [x, y, _, _] = request.crop.map(f64::from);
    let side = f64::from(TILE);
    (tiles.iter())
        .map(|&tile| {
            let column = f64::from(tile % across) + 0.5;
            let row = f64::from(tile / across) + 0.5;
            let centre = DVec2::new(x + column * side, y + row * side);
            let rays = request
                .camera()
                .ray_tile(centre, request.size, &scene.sheet, cloth);
            let pitch = DVec2::new(scene.sheet.pitch_x_mm, scene.sheet.pitch_y_mm);
            let quantum = quantum(rays.origin_dx, rays.origin_dy, pitch);
            let [dx, dx_rest] = in_quanta(rays.origin_dx, quantum);
            let [dy, dy_rest] = in_quanta(rays.origin_dy, quantum);
            let [pitch, pitch_rest] = in_quanta(pitch.extend(0.0), quantum);
            let vector = |v: DVec3, w: f64| [v.x as f32, v.y as f32, v.z as f32, w as f32];
            RayTile {
                cell: [rays.cell[0], rays.cell[1], tile as i32, 0],
                origin: vector(rays.origin, rays.depth_offset),
                origin_dx: vector(dx, rays.shrink[0]),
                origin_dy: vector(dy, rays.shrink[1]),
                origin_dx_rest: vector(dx_rest, 0.0),
                origin_dy_rest: vector(dy_rest, 0.0),
                pitch: [pitch.x, pitch.y, pitch_rest.x, pitch_rest.y].map(|mm| mm as f32),
                direction: vector(rays.direction, 0.0),
                direction_dx: vector(rays.direction_dx, rays.depth_slope[0]),
                direction_dy: vector(rays.direction_dy, rays.depth_slope[1]),
            }
        })
        .collect()
}

/// A power of two, mm, of which f32 holds all whole multiples up to what a tile's pixels, and as many cells, lie apart:
/// sums of multiples are exact.
fn quantum(dx: DVec3, dy: DVec3, pitch: DVec2) -> f64 {
    let far = f64::from(TILE) * (dx.abs().max_element() + dy.abs().max_element());
    let far = far.max(2.0 * pitch.max_element());
    (far.log2().ceil() - f64::from(f32::MANTISSA_DIGITS) + 1.0).exp2()
}

/// The nearest whole multiple of `quantum`, and the rest.
fn in_quanta(vector: DVec3, quantum: f64) -> [DVec3; 2] {
    let whole = (vector / quantum).round() * quantum;
    [whole, vector - whole]
}
