//! Shadows kept for the live view: how much of each light reaches the surroundings of a point, learned from the shadow
//! rays of a picture's first samples (not in the paper; a lazily filled relative of deep shadow maps).
//!
//! The cloth's box is a grid of texels, about [`TEXEL_PX`] pixels wide in the middle of the picture, and none across
//! the sheet's plane; there is room for those that are asked for, a page of [`PAGE_SIDE`]² of them and all layers at a
//! time. The first rays of paths ask them in the [`Settings::cached_shadows`](super::Settings::cached_shadows) first
//! samples: where a texel has seen enough rays towards a light, its mean replaces the ray; else the ray is traced, and
//! counts there. Rays count by the light that they would bring, so that means bring as much as rays do, whatever faces a
//! light or lies open to it. What has been learned is used from the next sample on, so that a picture does not depend on
//! the order in which its pixels are drawn. Points are moved by up to half a texel before they ask, which blurs the
//! texels' edges away in the mean of a few samples.
//!
//! Biased: shadows are blurred over a texel. The bias of a picture falls as later samples, whose rays are all traced,
//! outweigh the first. The cache outlives a picture as long as the cloth, its lights and, within a factor of two, the
//! scale of the view are the same: a moving camera finds what others have learned.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use bytemuck::Zeroable;
use glam::DVec3;
use rayon::prelude::*;

use super::RenderRequest;
use crate::design::Method;
use crate::optics::Visibility;
use crate::scene::Scene;

/// Texels times lights at most: 96 MB.
const MOST_ENTRIES: usize = 1 << 22;
/// Width and height of a page, texels.
pub const PAGE_SIDE: u32 = 16;
/// Pages of a sheet at most.
const MOST_PAGES: u32 = 1 << 20;
/// Layers at most on one side of the sheet.
const MOST_LAYERS: f64 = 16.0;
/// Layers at least on the side where most of the pile is: light falls off from its tips to its roots.
const FEWEST_LAYERS: f64 = 4.0;
/// Width of a texel at least, pixels.
pub const TEXEL_PX: f64 = 3.0;
/// Finest texels of a cell along each side.
const FINEST_PER_CELL: u32 = 8;
/// Rays that a texel has seen before its mean is used: their spread is at most ½, that of the mean ⅛, and a pixel asks
/// several texels.
pub const ENOUGH_RAYS: u32 = 16;
/// Until a texel has seen so many, a share of the rays is traced all the same and makes the mean better: else its error
/// would stay, and show as a stain.
pub const ALL_RAYS: u32 = 128;
/// That share.
pub const TRACED_SHARE: f32 = 0.25;
/// Entries that a thread goes through at a time.
const FINALISED_AT_A_TIME: usize = 1 << 16;
/// Steps of a sum per light, in the mean radiance that all lights bring unhindered; 65,000 rays fit a sum.
pub const SUM_STEPS: f64 = 1024.0;
/// Most light that a ray counts for, in the same unit.
pub const MOST_LIGHT: f64 = 64.0;
/// Steps of a mean from 0 to 1.
pub const MEAN_STEPS: f64 = 32767.0;
/// Marks a mean that is final.
pub const FINAL: u32 = 1 << 31;

/// The texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowGrid {
    /// Texels along x, y and z.
    pub texels: [u32; 3],
    /// A texel is 1 / `per_cell` cells wide where that is above 1, else 1 << `shift` cells.
    pub per_cell: u32,
    /// See `per_cell`.
    pub shift: u32,
    /// How many layers lie below the sheet's plane.
    pub layers_below: u32,
    /// Height of a layer, mm.
    pub layer_mm: f64,
    /// Lights: suns and area lights, then the environment; of a sky that is drawn, directions that follow the phase and
    /// those that follow its light see other shadows, and are two.
    pub lights: u32,
    /// Cells of the sheet, and their size, mm.
    cells: [u32; 2],
    pitch_mm: [f64; 2],
}

impl ShadowGrid {
    /// The texels for a picture whose pixels are `pixel_mm` wide on the cloth.
    pub fn new(scene: &Scene, pixel_mm: f64) -> Self {
        let sheet = &scene.sheet;
        let pitch_mm = [sheet.pitch_x_mm, sheet.pitch_y_mm];
        let narrow = pitch_mm[0].min(pitch_mm[1]);
        let (mut per_cell, mut shift) = (FINEST_PER_CELL, 0);
        loop {
            let grid = Self::of_width(scene, per_cell, shift);
            let width_mm = narrow * f64::from(1_u32 << shift) / f64::from(per_cell);
            let [x, y] = grid.pages();
            let fits = x * y <= MOST_PAGES && grid.page_entries() <= MOST_ENTRIES;
            // So wide that one is the whole sheet.
            let widest = grid.texels[0] == 1 && grid.texels[1] == 1;
            if widest || fits && width_mm >= TEXEL_PX * pixel_mm {
                return grid;
            }
            if per_cell > 1 {
                per_cell /= 2;
            } else {
                shift += 1;
            }
        }
    }

    fn of_width(scene: &Scene, per_cell: u32, shift: u32) -> Self {
        let sheet = &scene.sheet;
        let cells = [sheet.warps, sheet.wefts];
        let pitch_mm = [sheet.pitch_x_mm, sheet.pitch_y_mm];
        let [low, high] = scene.heights_mm();
        let tallest = high.max(-low).max(1e-3);
        let width_mm =
            pitch_mm[0].min(pitch_mm[1]) * f64::from(1_u32 << shift) / f64::from(per_cell);
        // Cubes, if pile is neither very high nor very low.
        let layer_mm = width_mm.clamp(tallest / MOST_LAYERS, tallest / FEWEST_LAYERS);
        let below = (-low / layer_mm).ceil().max(0.0) as u32;
        let above = (high / layer_mm).ceil().max(0.0) as u32;
        let across = cells.map(|cells| (cells * per_cell).div_ceil(1 << shift));
        Self {
            texels: [across[0], across[1], (below + above).max(1)],
            per_cell,
            shift,
            layers_below: below,
            layer_mm,
            lights: scene.lights.count() as u32
                + 1
                + u32::from(scene.lights.sky.importance_table().is_some()),
            cells,
            pitch_mm,
        }
    }

    /// Pages along x and y that the whole sheet has.
    pub fn pages(&self) -> [u32; 2] {
        [0, 1].map(|axis| self.texels[axis].div_ceil(PAGE_SIDE))
    }

    /// Entries of a page: of its texels, at all layers, of all lights.
    pub fn page_entries(&self) -> usize {
        (PAGE_SIDE * PAGE_SIDE * self.texels[2] * self.lights) as usize
    }

    /// Pages that there is room for.
    pub fn most_pages(&self) -> usize {
        let all: u32 = self.pages().iter().product();
        (MOST_ENTRIES / self.page_entries()).min(all as usize)
    }

    /// The texel around a point of the world, mm, along x, y and z, moved by −½ to ½ texel along each axis for numbers of
    /// `random` from 0 to 1, but not through the sheet's plane nor out of the cloth's box.
    #[inline(always)]
    pub fn texel(&self, point: DVec3, random: [f64; 3]) -> [usize; 3] {
        let mut texel = [0_usize; 3];
        let texel_steps = f64::from(1_u32 << self.shift);
        for axis in 0..2 {
            let cells = point[axis] / self.pitch_mm[axis] + 0.5 * f64::from(self.cells[axis]);
            let place = cells * f64::from(self.per_cell) + (random[axis] - 0.5) * texel_steps;
            let whole = place.max(0.0) as usize >> self.shift;
            texel[axis] = whole.min(self.texels[axis] as usize - 1);
        }
        let below = self.layers_below as usize;
        let depth = ((point.z.abs() / self.layer_mm + random[2] - 0.5).max(0.0)) as usize;
        texel[2] = if point.z < 0.0 {
            below.saturating_sub(depth + 1)
        } else {
            (below + depth).min(self.texels[2] as usize - 1)
        };
        texel
    }

    /// The page of a texel, and the place of its first light's entry in that page.
    #[inline(always)]
    pub fn place(&self, [x, y, z]: [usize; 3]) -> (usize, usize) {
        let side = PAGE_SIDE as usize;
        let page = y / side * self.pages()[0] as usize + x / side;
        let in_page = (z * side + y % side) * side + x % side;
        (page, in_page * self.lights as usize)
    }

    /// Texels with this grid's layers, of whole cells of the sheet of `scene`, so wide that there are at most `most`.
    pub fn of_cells(&self, scene: &Scene, most: usize) -> Self {
        let mut shift = if self.per_cell > 1 { 0 } else { self.shift };
        loop {
            let grid = Self {
                layers_below: self.layers_below,
                layer_mm: self.layer_mm,
                ..Self::of_width(scene, 1, shift)
            };
            let texels = [grid.texels[0], grid.texels[1], self.texels[2]];
            let grid = Self { texels, ..grid };
            if grid.texel_count() <= most || grid.texels[0] == 1 && grid.texels[1] == 1 {
                return grid;
            }
            shift += 1;
        }
    }

    /// Texels of the whole sheet.
    pub fn texel_count(&self) -> usize {
        self.texels.iter().map(|&n| n as usize).product()
    }

    /// Number of a texel among them.
    #[inline(always)]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        let [across, along, _] = self.texels.map(|n| n as usize);
        (z * along + y) * across + x
    }
}

/// What of a request a cache depends on: the cloth, its lights, how rays see, and the seed, since pictures of several
/// seeds are to be independent.
#[derive(Debug, Clone)]
pub struct ShadowKey {
    pub(super) scene: Arc<Scene>,
    method: Method,
    seed: u32,
    /// The texels.
    pub grid: ShadowGrid,
    /// Mean radiance, the brightest channel's, that the lights bring unhindered to the middle of the cloth: above 0.
    pub unit: f64,
}

impl ShadowKey {
    /// For `request`; `None` if it takes no shadows from a cache.
    pub fn new(request: &RenderRequest) -> Option<Self> {
        let pixel_mm = request.camera().pixel_mm(request.size[1]);
        let unit = request.scene().lights.mean_radiance();
        (request.settings.caches_shadows(0) && unit > 0.0).then(|| Self {
            unit,
            scene: Arc::clone(request.scene()),
            method: request.settings.method,
            seed: request.settings.seed,
            grid: ShadowGrid::new(request.scene(), pixel_mm),
        })
    }

    /// Steps of a sum in a radiance of 1.
    pub fn steps_per_radiance(&self) -> f64 {
        SUM_STEPS / self.unit
    }

    /// Whether what has been learned for one holds for the other.
    pub fn is_same(&self, other: &Self) -> bool {
        self.method == other.method
            && self.seed == other.seed
            && self.grid == other.grid
            && self.scene.has_same_shadows(&other.scene)
    }
}

/// How much light a ray would bring if nothing were in its way: what its shadow counts.
#[derive(Debug, Clone, Copy)]
pub struct Unhindered {
    /// By this scattering.
    pub direct: f64,
    /// By further ones.
    pub diffuse: f64,
}

/// What rays towards one light have seen from one texel.
#[derive(Debug, Zeroable)]
#[repr(C)]
struct Sums {
    rays: AtomicU32,
    /// What they would have brought, directly and by multiple scattering.
    unhindered: [AtomicU32; 2],
    /// What they have brought.
    arrived: [AtomicU32; 2],
}

/// The cache of a renderer on the host. Threads of a sample read the means of earlier ones and add to the sums.
#[derive(Debug)]
pub struct ShadowCache {
    key: ShadowKey,
    /// For each page of the sheet the number of its room, from 1; 0 while it has none.
    rooms: Vec<AtomicU32>,
    /// Rooms given away, or asked for in vain.
    taken: AtomicU32,
    /// Mean of [`Visibility::direct`] in the 15 lowest bits, of [`Visibility::diffuse`] in the next 15, [`FINAL`]; 0:
    /// not yet known.
    means: Vec<AtomicU32>,
    sums: Vec<Sums>,
}

impl ShadowCache {
    /// Knows nothing yet.
    pub fn new(key: ShadowKey) -> Self {
        let grid = &key.grid;
        let entries = grid.most_pages() * grid.page_entries();
        let pages: u32 = grid.pages().iter().product();
        // Zeros from the system cost nothing before they are touched: every edit of the cloth begins with a new cache.
        Self {
            rooms: bytemuck::zeroed_vec(pages as usize),
            taken: AtomicU32::new(0),
            means: bytemuck::zeroed_vec(entries),
            sums: bytemuck::zeroed_vec(entries),
            key,
        }
    }

    /// What it was made for.
    pub fn key(&self) -> &ShadowKey {
        &self.key
    }

    /// Whether most of its room is taken, so that another view had better begin anew.
    pub fn is_crowded(&self) -> bool {
        let grid = &self.key.grid;
        let all: u32 = grid.pages().iter().product();
        let most = grid.most_pages();
        most < all as usize && self.rooms_taken() > most / 2
    }

    fn rooms_taken(&self) -> usize {
        (self.taken.load(Ordering::Relaxed) as usize).min(self.key.grid.most_pages())
    }

    /// The entry of the first light at a point, moved as by [`ShadowGrid::texel`]; `None` where there is no room.
    #[inline(always)]
    pub fn entry(&self, point: DVec3, random: [f64; 3]) -> Option<usize> {
        let grid = &self.key.grid;
        let (page, place) = grid.place(grid.texel(point, random));
        let room = match self.rooms[page].load(Ordering::Relaxed) {
            0 => self.take_room(page)?,
            room => room,
        };
        Some((room as usize - 1) * grid.page_entries() + place)
    }

    #[cold]
    fn take_room(&self, page: usize) -> Option<u32> {
        if self.rooms_taken() >= self.key.grid.most_pages() {
            return None;
        }
        let room = self.taken.fetch_add(1, Ordering::Relaxed) + 1;
        if room as usize > self.key.grid.most_pages() {
            return None;
        }
        // Where another thread was faster, this room stays empty.
        let relaxed = Ordering::Relaxed;
        match self.rooms[page].compare_exchange(0, room, relaxed, relaxed) {
            Ok(_) => Some(room),
            Err(other) => Some(other),
        }
    }

    /// The mean of an entry, once it is known; not if the ray is to make it better, which `random` decides.
    #[inline(always)]
    pub fn visibility(&self, entry: usize, random: impl FnOnce() -> f32) -> Option<Visibility> {
        let mean = self.means[entry].load(Ordering::Relaxed);
        if mean == 0 || mean & FINAL == 0 && random() < TRACED_SHARE {
            return None;
        }
        Some(Visibility {
            direct: f64::from(mean & 0x7fff) / MEAN_STEPS,
            diffuse: f64::from(mean >> 15 & 0x7fff) / MEAN_STEPS,
        })
    }

    /// Adds what one ray saw.
    #[inline(always)]
    pub fn add(&self, entry: usize, light: Unhindered, found: Visibility) {
        let sums = &self.sums[entry];
        let scale = self.key.steps_per_radiance();
        sums.rays.fetch_add(1, Ordering::Relaxed);
        let both = [(light.direct, found.direct), (light.diffuse, found.diffuse)];
        for (k, (light, share)) in both.into_iter().enumerate() {
            let steps = (light * scale).min(MOST_LIGHT * SUM_STEPS);
            sums.unhindered[k].fetch_add((steps + 0.5) as u32, Ordering::Relaxed);
            sums.arrived[k].fetch_add((steps * share + 0.5) as u32, Ordering::Relaxed);
        }
    }

    /// Makes what has been learned known: between two samples of a picture.
    pub fn finalise(&self) {
        let used = self.rooms_taken() * self.key.grid.page_entries();
        let entries = self.means[..used].par_iter().zip(&self.sums[..used]);
        entries
            .with_min_len(FINALISED_AT_A_TIME)
            .for_each(|(mean, sums)| {
                let rays = sums.rays.load(Ordering::Relaxed);
                if rays >= ENOUGH_RAYS && mean.load(Ordering::Relaxed) & FINAL == 0 {
                    let of = |k: usize| {
                        let all = sums.unhindered[k].load(Ordering::Relaxed).max(1);
                        let share =
                            f64::from(sums.arrived[k].load(Ordering::Relaxed)) / f64::from(all);
                        (share.min(1.0) * MEAN_STEPS + 0.5) as u32
                    };
                    // What comes by bounces is never nothing, so that known means are not 0.
                    let both = of(0) | of(1).max(1) << 15;
                    let mark = if rays >= ALL_RAYS { FINAL } else { 0 };
                    mean.store(both | mark, Ordering::Relaxed);
                }
            });
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let used = self.rooms_taken() * self.key.grid.page_entries();
        (size_of_val(&*self.rooms)
            + size_of_val(&self.means[..used])
            + size_of_val(&self.sums[..used])) as u64
    }
}
