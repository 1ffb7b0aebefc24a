//! The file that `render --stats` writes: what was rendered, with what, how long each part took, and how good it is.

use std::time::Duration;

use renderer_core::render::{Backend, BackendKind, Counters};
use renderer_core::scene::lod::LodCloth;
use renderer_core::scene::{CompileReport, Scene, StageSeconds};
use serde::Serialize;

use crate::picture_file::{DenoisedPicture, Made, PictureOrder};

/// The whole file.
#[derive(Debug, Serialize)]
pub struct Stats {
    /// Version of the program.
    pub version: &'static str,
    /// Adapter or processor.
    pub adapter: String,
    /// `gpu`, `cpu` or `reference`.
    pub backend: &'static str,
    /// Name of the method.
    pub method: String,
    /// Width and height of the whole picture.
    pub size: [u32; 2],
    /// The part that was rendered: x, y, width, height.
    pub crop: [u32; 4],
    /// Samples a pixel; of a picture made in bands the fewest of any band.
    pub samples: u32,
    /// In how many bands it was made.
    pub bands: u32,
    /// Loops in the scene.
    pub loops: u64,
    /// Loops left out because they were degenerate.
    pub dropped_loops: u64,
    /// What compiling the scene took.
    pub compile: CompileJson,
    /// Wall-clock times.
    pub seconds: Seconds,
    /// Time on all cores together that adding samples took; null where the system does not tell.
    pub processor_seconds: Option<f64>,
    /// Work done, when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counters: Option<CountersJson>,
    /// Estimated relRMSE; null below sixteen samples.
    pub error_estimate: Option<f64>,
    /// What denoising has done; null where it was not asked for.
    pub denoised: Option<DenoisedJson>,
    /// Pixels with a value that is infinite or NaN; always 0, or something is wrong.
    pub nonfinite_pixels: u64,
    /// Sizes in memory.
    pub bytes: Bytes,
}

impl Stats {
    /// Of a picture that was made, and of what compiling its cloth took.
    pub fn new(
        order: &PictureOrder,
        cloth: &LodCloth,
        compile: CompileReport,
        backend: &dyn Backend,
        made: &Made,
        seconds: Seconds,
    ) -> Self {
        let kind = backend.kind();
        Self {
            version: env!("CARGO_PKG_VERSION"),
            adapter: backend.device_name(),
            backend: kind.name(),
            method: order.settings.method.name(),
            size: order.size,
            crop: order.crop,
            samples: made.samples,
            bands: made.bands,
            loops: cloth.counts().planted,
            dropped_loops: cloth.counts().dropped,
            compile: compile.into(),
            seconds,
            processor_seconds: made.render.processor.map(|time| time.as_secs_f64()),
            counters: order.settings.counters.then(|| made.counters.into()),
            error_estimate: made.error_estimate,
            denoised: made.denoised.as_ref().map(Into::into),
            nonfinite_pixels: made.nonfinite_pixels,
            bytes: Bytes {
                scene: cloth_bytes(cloth),
                per_loop: cloth.scenes.nearest.loops.bytes_per_loop(),
                gpu_total: match kind {
                    BackendKind::Gpu => made.device_bytes,
                    BackendKind::Cpu | BackendKind::Reference => 0,
                },
                band: made.band_bytes,
            },
        }
    }
}

impl Seconds {
    /// Adds those of a picture whose making began so long after the program's start.
    pub fn add(&mut self, before: Duration, made: &Made) {
        let first = before + made.upload + made.pipelines + made.first;
        self.pipelines += made.pipelines.as_secs_f64();
        self.upload = made.upload.as_secs_f64();
        self.render = made.render.wall.as_secs_f64();
        self.write = made.write.as_secs_f64();
        self.first_image = first.as_secs_f64();
    }
}

/// Wall-clock seconds of each part.
#[derive(Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading preset and chart.
    pub open: f64,
    /// From design to scene.
    pub compile: f64,
    /// Giving the scene to the backend.
    pub upload: f64,
    /// Making the backend ready: adapter, device, pipelines.
    pub pipelines: f64,
    /// From the program's start to the first whole sample of the picture.
    pub first_image: f64,
    /// Adding samples.
    pub render: f64,
    /// Encoding and writing the picture.
    pub write: f64,
    /// From the program's start to here.
    pub total: f64,
}

/// [`CompileReport`] as written.
#[derive(Debug, Serialize)]
pub struct CompileJson {
    sections_kept: u64,
    frames_made: u64,
    frames_left_out: u64,
    seconds: StageSeconds,
}

impl From<CompileReport> for CompileJson {
    fn from(report: CompileReport) -> Self {
        Self {
            sections_kept: report.sections_kept(),
            frames_made: report.frames_made,
            frames_left_out: report.frames_left_out,
            seconds: report.seconds,
        }
    }
}

/// [`DenoisedPicture`] as written.
#[derive(Debug, Serialize)]
pub struct DenoisedJson {
    by: String,
    share: f64,
    error_estimate: Option<f64>,
    distance: f64,
    seconds: f64,
}

impl From<&DenoisedPicture> for DenoisedJson {
    fn from(denoised: &DenoisedPicture) -> Self {
        Self {
            by: denoised.by.clone(),
            share: denoised.share,
            error_estimate: denoised.error,
            distance: denoised.distance,
            seconds: denoised.took.as_secs_f64(),
        }
    }
}

/// Sizes in memory, bytes.
#[derive(Debug, Serialize)]
pub struct Bytes {
    /// All records of the scene.
    pub scene: u64,
    /// Frames, lists and bounds for each loop, all together.
    pub per_loop: f64,
    /// On the GPU; 0 for other backends.
    pub gpu_total: u64,
    /// Most that the sums and the picture of a band took.
    pub band: u64,
}

/// [`Counters`] as written.
#[derive(Debug, Serialize)]
pub struct CountersJson {
    rays: u64,
    cells: u64,
    patch_tests: u64,
    volume_samples: u64,
    contributing_hits: u64,
    shadow_rays: u64,
    skipped_tiles: u64,
    converged_tiles: u64,
    skipped_cells: u64,
    repeated_tests: u64,
    ended_rays: u64,
    cached_rays: u64,
    hidden_rays: u64,
}

impl From<Counters> for CountersJson {
    fn from(counters: Counters) -> Self {
        let Counters {
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
        } = counters;
        Self {
            rays,
            cells,
            patch_tests,
            volume_samples,
            contributing_hits,
            shadow_rays,
            skipped_tiles,
            converged_tiles,
            skipped_cells,
            repeated_tests,
            ended_rays,
            cached_rays,
            hidden_rays,
        }
    }
}

/// Bytes of all records of a cloth's levels, which share their volumes.
pub fn cloth_bytes(cloth: &LodCloth) -> u64 {
    let farther = cloth.scenes.farther.iter();
    let farther = farther.map(|scene| scene.loops.bytes() + size_of_val(scene.looks.as_slice()));
    scene_bytes(&cloth.scenes.nearest) + farther.sum::<usize>() as u64
}

/// Bytes of all records of a scene.
pub fn scene_bytes(scene: &Scene) -> u64 {
    let (loops, volumes) = (&scene.loops, &scene.volumes);
    let bytes = loops.bytes()
        + size_of_val(scene.looks.as_slice())
        + size_of_val(&*volumes.voxels)
        + size_of_val(&*volumes.tangents);
    bytes as u64
}
