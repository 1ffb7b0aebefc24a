//! Light that goes on where a live view cuts its paths off, held to traced paths (not in the paper).
//!
//! The estimate of [`multiple_scattering`](crate::optics::multiple_scattering) knows how open a point lies, not the cloth
//! around it: its pile, its colours, what its lights come through. Some paths of the
//! [`Settings::cached_shadows`](super::Settings::cached_shadows) first samples therefore go on to their end. For each
//! cell of the cloth, or some if they are many, and each layer of the [shadow cache](super::shadow_cache) what they find
//! is added up, and so is what was estimated for them; the ratio of both corrects estimates there, of later samples too, a colour channel at a time. So
//! what is near by comes from the estimate, sharp and quiet, how bright it is from the paths.
//!
//! With few paths the ratio is drawn towards 1, as if [`PRIOR_PATHS`] more had found what was estimated. The cache
//! outlives a picture as long as nothing changes but where it is seen from.

use std::sync::atomic::{AtomicU32, Ordering};

use bytemuck::Zeroable;
use glam::DVec3;
use rayon::prelude::*;

use super::RenderRequest;
use super::shadow_cache::{ShadowGrid, ShadowKey};
use crate::sampling;

/// Texels at most: 40 MB.
const MOST_TEXELS: usize = 1 << 20;
/// One in so many blocks of pixels follows its paths to their end in a sample.
pub const LEARNING_BLOCKS: u32 = 16;
/// Blocks learn whose hash is below this.
pub const CHANCE: u32 = u32::MAX / LEARNING_BLOCKS;
/// Width and height of those blocks are 2 to this, pixels.
pub const BLOCK_SHIFT: u32 = 3;
/// Paths that a texel's ratio begins with, each as estimated.
pub const PRIOR_PATHS: f32 = 8.0;
/// Paths after which a texel learns no more.
pub const ALL_PATHS: u32 = 256;
/// Steps of a sum, per mean radiance that the lights bring unhindered.
pub const STEPS: f64 = 1024.0;
/// Most that a path counts, in the same unit.
pub const MOST: f64 = 64.0;
/// Bounds of a ratio: beyond them it is chance.
pub const BOUNDS: [f32; 2] = [0.2, 5.0];

/// What of a request it depends on.
#[derive(Debug, Clone)]
pub struct BouncedKey {
    shadows: ShadowKey,
    bounces: u32,
    /// The texels; all of one light.
    pub grid: ShadowGrid,
}

impl BouncedKey {
    /// For `request`; `None` if its paths are not cut off at their first scattering, or nothing is to be learned.
    pub fn new(request: &RenderRequest) -> Option<Self> {
        let shadows = ShadowKey::new(request)?;
        let settings = &request.settings;
        let grid = shadows.grid.of_cells(request.scene(), MOST_TEXELS);
        (settings.learns_bounces && settings.path_cutoff() == Some(1)).then_some(Self {
            shadows,
            bounces: settings.bounces,
            grid,
        })
    }

    /// Steps of a sum in a radiance of 1.
    pub fn steps_per_radiance(&self) -> f64 {
        STEPS / self.shadows.unit
    }

    /// Whether what has been learned for one holds for the other.
    pub fn is_same(&self, other: &Self) -> bool {
        self.bounces == other.bounces
            && self.shadows.is_same(&other.shadows)
            && self.shadows.scene.looks == other.shadows.scene.looks
    }
}

/// Whether sample `number` of a pixel of the whole picture follows its path to its end.
#[inline(always)]
pub fn learns(seed: u32, pixel: [u32; 2], number: u32) -> bool {
    let block = sampling::pixel_seed(seed, pixel.map(|at| at >> BLOCK_SHIFT));
    sampling::hash_with(block, number) < CHANCE
}

/// What paths have found of one texel, and what was estimated for them.
#[derive(Debug, Zeroable)]
#[repr(C)]
struct Sums {
    paths: AtomicU32,
    found: [AtomicU32; 3],
    estimated: [AtomicU32; 3],
}

/// The texels of a renderer on the host.
#[derive(Debug)]
pub struct BouncedLight {
    key: BouncedKey,
    /// Ratios of red, green and blue, less 1, as bits of a number.
    ratios: Vec<[AtomicU32; 3]>,
    sums: Vec<Sums>,
}

impl BouncedLight {
    /// Knows nothing yet.
    pub fn new(key: BouncedKey) -> Self {
        let entries = key.grid.texel_count();
        // Zeros from the system cost nothing before they are touched.
        Self {
            key,
            ratios: bytemuck::zeroed_vec(entries),
            sums: bytemuck::zeroed_vec(entries),
        }
    }

    /// What it was made for.
    pub fn key(&self) -> &BouncedKey {
        &self.key
    }

    /// The entry of a point of the world, mm, moved as by [`ShadowGrid::texel`].
    #[inline(always)]
    pub fn entry(&self, point: DVec3, random: [f64; 3]) -> usize {
        let grid = &self.key.grid;
        grid.index(grid.texel(point, random))
    }

    /// What an estimate at an entry is to be multiplied with.
    #[inline(always)]
    pub fn correction(&self, entry: usize) -> DVec3 {
        let ratio =
            |bits: &AtomicU32| 1.0 + f64::from(f32::from_bits(bits.load(Ordering::Relaxed)));
        DVec3::from_array(self.ratios[entry].each_ref().map(ratio))
    }

    /// Whether an entry has not seen all that it is to learn from.
    #[inline(always)]
    pub fn is_learning(&self, entry: usize) -> bool {
        self.sums[entry].paths.load(Ordering::Relaxed) < ALL_PATHS
    }

    /// Adds the radiance that one path has found, and what had been estimated in its place.
    #[inline(always)]
    pub fn add(&self, entry: usize, found: DVec3, estimated: DVec3) {
        let sums = &self.sums[entry];
        let scale = self.key.steps_per_radiance();
        sums.paths.fetch_add(1, Ordering::Relaxed);
        for channel in 0..3 {
            let steps =
                |radiance: DVec3| ((radiance[channel] * scale).min(MOST * STEPS) + 0.5) as u32;
            sums.found[channel].fetch_add(steps(found), Ordering::Relaxed);
            sums.estimated[channel].fetch_add(steps(estimated), Ordering::Relaxed);
        }
    }

    /// Makes what has been learned known: between two samples of a picture.
    pub fn finalise(&self) {
        let entries = self.ratios.par_iter().zip(&self.sums);
        entries.with_min_len(1 << 14).for_each(|(ratios, sums)| {
            let paths = sums.paths.load(Ordering::Relaxed);
            if paths == 0 {
                return;
            }
            let known = 1.0 + PRIOR_PATHS / paths as f32;
            let sums = sums.found.iter().zip(&sums.estimated);
            for (ratio, (found, estimated)) in ratios.iter().zip(sums) {
                let sum = |sum: &AtomicU32| sum.load(Ordering::Relaxed) as f32;
                let estimated = sum(estimated);
                let excess = (sum(found) - estimated) / (estimated * known).max(1.0);
                let excess = excess.clamp(BOUNDS[0] - 1.0, BOUNDS[1] - 1.0);
                ratio.store(excess.to_bits(), Ordering::Relaxed);
            }
        });
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.ratios) + size_of_val(&*self.sums)) as u64
    }
}
