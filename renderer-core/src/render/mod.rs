//! What all backends share: the request, its camera, progress, counters, and the rule that chooses a backend.
//!
//! A backend is given a [`RenderRequest`], adds samples to an accumulation slice by slice, and shows their mean at any
//! time. If a request differs from the last, accumulation starts again. Display settings (exposure, tone map) are not
//! part of it.

pub mod accumulation;
mod background;
pub mod bounced_light;
mod coarse_preview;
pub mod convergence;
pub mod levels;
mod optimisations;
pub mod progressive;
mod ray_tile;
pub mod shadow_cache;

pub use background::{background_tiles, cloth_box};
pub use coarse_preview::CoarsePreview;
pub use optimisations::{Optimisation, Optimisations};
pub use ray_tile::RayTile;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::design::{Method, Quality};
use crate::geometry::Camera;
use crate::image::Picture;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::lod::LodView;

/// Largest side of a picture, pixels.
pub const MAX_SIDE: u32 = 16_384;

/// One picture to make.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderRequest {
    /// The cloth, its light and the camera, at one level of detail or at several.
    pub view: LodView,
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// The part to make: x, y, width, height, pixels from the top left; the picture returned has this size.
    pub crop: [u32; 4],
    /// How.
    pub settings: Settings,
}

impl RenderRequest {
    /// A whole picture of a view.
    pub fn new(view: LodView, size: [u32; 2], settings: Settings) -> Self {
        Self {
            view,
            size,
            crop: [0, 0, size[0], size[1]],
            settings,
        }
    }

    /// The scene of the nearest level.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.view.levels.nearest.scene
    }

    /// The camera in the space of the nearest level.
    pub fn camera(&self) -> &Camera {
        &self.view.levels.nearest.camera
    }
}

/// How a picture is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How the first segment of a path and its shadow rays gather light.
    pub method: Method,
    /// Most scatterings of a path, 1 to 64.
    pub bounces: u32,
    /// Scatterings after which the light of further ones is estimated, not traced; 0 traces all.
    pub traced_bounces: u32,
    /// Longest piece of a ray that is taken as uniform, mm; for the methods that march.
    pub step_mm: f64,
    /// Samples a pixel at which the picture is done.
    pub samples: u32,
    /// Estimated relative error at which the picture is done; 0 never stops early.
    pub error: f64,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// Rays towards lights are followed; else nothing is in their way.
    pub shadows: bool,
    /// Also accumulate depth, normal and albedo of the first scattering.
    pub aov: bool,
    /// Count rays, cells, patch tests and so on; costs time.
    pub counters: bool,
    /// Work that is left out where it cannot be seen.
    pub optimisations: Optimisations,
    /// First samples of each pixel whose shadows may come from [`shadow_cache`]; renderers that have none trace all.
    pub cached_shadows: u32,
    /// In those samples some paths go on where others are cut off, if that is at their first scattering, and teach
    /// [`bounced_light`] how good the estimate is.
    pub learns_bounces: bool,
}

/// Those of a final picture: every bounce and every shadow is traced.
impl From<&Quality> for Settings {
    fn from(quality: &Quality) -> Self {
        let Quality {
            method,
            bounces,
            step,
            samples,
            error,
            seed,
            sampler,
            shadows,
        } = *quality;
        Self {
            method,
            bounces,
            traced_bounces: 0,
            step_mm: step,
            samples,
            error,
            seed,
            sampler: sampler.into(),
            shadows,
            aov: false,
            counters: false,
            optimisations: Optimisations::ALL,
            cached_shadows: 0,
            learns_bounces: false,
        }
    }
}

impl Settings {
    /// Whether sample `number` of a pixel may take its shadows from a cache.
    pub fn caches_shadows(&self, number: u32) -> bool {
        self.shadows && number < self.cached_shadows
    }

    /// The scattering at which the light of all further ones is estimated, if not all are traced.
    pub fn path_cutoff(&self) -> Option<u32> {
        (1..self.bounces)
            .contains(&self.traced_bounces)
            .then_some(self.traced_bounces)
    }
}

/// Where a picture stands.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Whole samples so far of every pixel that is still drawn. Pixels of tiles that have converged have fewer, and
    /// those of tiles that show background alone need none; where a whole picture is background, this is the number
    /// asked for. While 0, [`Backend::picture`] may be coarse.
    pub samples: u32,
    /// Estimated relRMSE (MODEL.md §11) of the mean so far, all pixels included whatever their number of samples, from
    /// the spread of independent scrambles; `None` below [`convergence::FEWEST_FOR_ERROR`] samples.
    pub error_estimate: Option<f64>,
    /// True when nothing is left to do.
    pub done: bool,
}

/// Work done since [`Backend::begin`], counted only when asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Camera and bounce rays.
    pub rays: u64,
    /// Rays towards lights.
    pub shadow_rays: u64,
    /// Cells walked through by rays of both kinds.
    pub cells: u64,
    /// Ray–loop solves and point inversions.
    pub patch_tests: u64,
    /// Densities read from loop volumes.
    pub volume_samples: u64,
    /// Loops or points that took light away.
    pub contributing_hits: u64,
    /// Samples of whole tiles not drawn because nothing can be seen in them.
    pub skipped_tiles: u64,
    /// Samples of whole tiles not drawn because their error was below the target.
    pub converged_tiles: u64,
    /// Cells in which a ray passed above or below all loops.
    pub skipped_cells: u64,
    /// Ray–loop solves not made again because an earlier cell had made them.
    pub repeated_tests: u64,
    /// Shadow rays ended because hardly any light came through.
    pub ended_rays: u64,
    /// Shadow rays not traced because their surroundings' shadows were known.
    pub cached_rays: u64,
    /// Rays that ended in pile before ground yarns were looked for, or at a ground weave without gaps before what lies
    /// behind it.
    pub hidden_rays: u64,
}

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        let Self {
            rays,
            shadow_rays,
            cells,
            patch_tests,
            volume_samples,
            contributing_hits,
            skipped_tiles,
            converged_tiles,
            skipped_cells,
            repeated_tests,
            ended_rays,
            cached_rays,
            hidden_rays,
        } = other;
        self.rays += rays;
        self.shadow_rays += shadow_rays;
        self.cells += cells;
        self.patch_tests += patch_tests;
        self.volume_samples += volume_samples;
        self.contributing_hits += contributing_hits;
        self.skipped_tiles += skipped_tiles;
        self.converged_tiles += converged_tiles;
        self.skipped_cells += skipped_cells;
        self.repeated_tests += repeated_tests;
        self.ended_rays += ended_rays;
        self.cached_rays += cached_rays;
        self.hidden_rays += hidden_rays;
    }
}

/// Why a backend cannot do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No adapter at all, or none that can compute.
    #[error("no GPU adapter: {0}")]
    NoAdapter(String),
    /// The request is beyond what the adapter can do.
    #[error("{what} is {value}, but {adapter} allows at most {limit}")]
    BeyondAdapter {
        /// What is too large.
        what: &'static str,
        /// How large it is.
        value: u64,
        /// How large it may be.
        limit: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// The size of the picture or of its crop is not allowed.
    #[error("{0}")]
    Size(String),
    /// The backend has no code for the method.
    #[error("the {} backend does not draw by method {}", backend.name(), method.name())]
    Method {
        /// Which backend.
        backend: BackendKind,
        /// What it was asked for.
        method: Method,
    },
    /// The device refused or failed to do something.
    #[error("the GPU stopped: {0}")]
    Device(String),
    /// The device has no memory left for scene or picture.
    #[error("the GPU is out of memory: {0}")]
    OutOfMemory(String),
    /// The device is gone: its driver was reset, or the card unplugged. Another one has to be made.
    #[error("the GPU was lost: {0}")]
    Lost(String),
}

/// A renderer: GPU, CPU or reference.
pub trait Backend: Send {
    /// Which one it is.
    fn kind(&self) -> BackendKind;

    /// Name of the adapter or processor, for the status bar and --stats.
    fn device_name(&self) -> String;

    /// Starts `request` from nothing unless it equals the one in work; then only targets may grow.
    ///
    /// # Errors
    /// When the request is beyond the device.
    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError>;

    /// Begins without waiting for what a device has to make first, such as compiled shaders: until [`Self::is_ready`]
    /// nothing is drawn, and [`Self::advance`] only waits.
    ///
    /// # Errors
    /// When the request is beyond the device.
    fn begin_soon(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.begin(request)
    }

    /// Whether the picture begun can be drawn.
    ///
    /// # Errors
    /// When what it needs could not be made.
    fn is_ready(&mut self) -> Result<bool, RenderError> {
        Ok(true)
    }

    /// Works for about `slice`, or until done or `cancel` is true.
    ///
    /// # Errors
    /// When the device fails.
    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError>;

    /// The mean of the samples so far, of the crop's size. Pixels that have no sample yet show the nearest that has.
    ///
    /// # Errors
    /// When the device fails.
    fn picture(&mut self) -> Result<Picture, RenderError>;

    /// Work done so far; zeros unless the request asked for counting.
    ///
    /// # Errors
    /// When the device fails.
    fn counters(&mut self) -> Result<Counters, RenderError>;

    /// Time of a sample of the picture begun if nothing is traced and only rays are made and sums written: what the
    /// rest is held against. `None` where that means nothing. The picture has to be begun again.
    ///
    /// # Errors
    /// When the device fails.
    fn baseline_sample(&mut self) -> Result<Option<Duration>, RenderError> {
        Ok(None)
    }

    /// Bytes held on the device for scene and accumulation; for processors, what they hold beside the scene.
    fn device_bytes(&self) -> u64;

    /// Largest side of a picture that a window can show, pixels.
    fn largest_side(&self) -> u32 {
        MAX_SIDE
    }
}

/// Which renderer to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BackendKind {
    /// wgpu compute.
    Gpu,
    /// All processor cores.
    Cpu,
    /// Plain scalar f64, one core.
    Reference,
}

impl BackendKind {
    /// Name on the command line and in the status bar.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
            Self::Reference => "reference",
        }
    }
}
