//! Final pictures in bands: the same bits as in one, memory that is bounded, files that are whole or not there.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use renderer_core::design::Design;
use renderer_core::geometry::Camera;
use renderer_core::image::{About, Depth, Display, ExrLayer, Picture};
use renderer_core::render::{
    Backend, BackendKind, Counters, Progress, RenderError, RenderRequest, Settings,
};
use renderer_core::scene;
use renderer_core::scene::lod::LodView;
use tempfile::TempDir;
use towel_designer::picture_file::{
    self, Bands, Failure, Format, PictureOrder, Standing, TimeLeft,
};

const SMALL: &str = "\
format = 1
[sheet]
warps = 24
wefts = 20
[pile]
variants = 2
layers = 3
resolution = 8
[view]
cameras = [{ name = 'above', distance = 40 }]
[quality]
method = 'single'
bounces = 2
samples = 4
";

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    folder
}

fn render(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_towel-designer"))
        .current_dir(folder)
        .args(["render", "small.toml"])
        .args(arguments)
        .output()
        .unwrap()
}

#[track_caller]
fn rendered(folder: &Path, arguments: &[&str]) {
    let output = render(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
}

fn stats(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(folder.join("stats.json")).unwrap()).unwrap()
}

/// Files in bands are the same files: samples depend on the place in the whole picture, rows are encoded alike.
fn same_in_bands(backend: &str, size: &str, more: &[&str], expected: [u32; 2]) {
    for name in ["picture.png", "picture.exr"] {
        let folder = folder();
        let arguments = [
            &[
                "-o",
                name,
                "--size",
                size,
                "--backend",
                backend,
                "--stats",
                "stats.json",
            ],
            more,
        ]
        .concat();
        let aov = ["--aov", "depth,normal,albedo,alpha"];
        let aov = if name.ends_with("exr") { &aov[..] } else { &[] };
        rendered(folder.path(), &[&arguments, aov].concat());
        let whole = fs::read(folder.path().join(name)).unwrap();
        assert_eq!(stats(folder.path())["bands"], 1);
        rendered(
            folder.path(),
            &[&arguments, aov, &["--memory", "1"]].concat(),
        );
        let in_bands = fs::read(folder.path().join(name)).unwrap();
        let stats = stats(folder.path());
        // 1 MB has 36 rows of 300 pixels of 96 bytes, or 16 with extra channels; bands are multiples of 16.
        let expected = expected[usize::from(!aov.is_empty())];
        assert_eq!(stats["bands"], expected, "{name}");
        assert!(
            stats["bytes"]["band"].as_u64().unwrap() <= 1 << 20,
            "{stats}"
        );
        assert!(
            whole == in_bands,
            "{name} on {backend}: another file in bands"
        );
    }
}

#[test]
fn bands_make_the_same_file_on_the_processor() {
    same_in_bands("cpu", "300x101", &[], [4, 7]);
    same_in_bands(
        "cpu",
        "300x101",
        &["--transparent", "--crop", "3,5,280,90"],
        [3, 6],
    );
}

#[test]
fn bands_make_the_same_file_on_the_gpu() {
    // Small: on a software adapter a sample takes its time.
    same_in_bands("gpu", "300x40", &["--samples", "1"], [2, 3]);
}

#[test]
fn stats_in_bands_are_those_of_the_whole() {
    let folder = folder();
    let arguments = [
        "-o",
        "picture.png",
        "--size",
        "300x100",
        "--backend",
        "cpu",
        "--samples",
        "16",
        "--counters",
        "--stats",
        "stats.json",
    ];
    rendered(folder.path(), &arguments);
    let whole = stats(folder.path());
    rendered(
        folder.path(),
        &[&arguments[..], &["--memory", "1"]].concat(),
    );
    let in_bands = stats(folder.path());
    assert_eq!(in_bands["counters"], whole["counters"]);
    assert_eq!(in_bands["samples"], whole["samples"]);
    let error = |stats: &serde_json::Value| stats["error_estimate"].as_f64().unwrap();
    // The mean of a band is taken of its f32 picture, that of the whole from f64 sums: 2⁻²⁴ a pixel.
    assert!(
        (error(&in_bands) / error(&whole) - 1.0).abs() < 1e-6,
        "{} {}",
        error(&in_bands),
        error(&whole)
    );
}

/// A backend that refuses bands of more than `most_rows`. A sample takes it no time, or all that it is given at once.
struct Slow {
    most_rows: u32,
    takes_time: bool,
    samples: u32,
    size: [u32; 2],
    wanted: u32,
    crops: Vec<[u32; 4]>,
}

impl Slow {
    fn new(most_rows: u32, takes_time: bool) -> Self {
        Self {
            most_rows,
            takes_time,
            samples: 0,
            size: [0, 0],
            wanted: 0,
            crops: Vec::new(),
        }
    }
}

impl Backend for Slow {
    fn kind(&self) -> BackendKind {
        BackendKind::Reference
    }

    fn device_name(&self) -> String {
        "slow".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if request.crop[3] > self.most_rows {
            return Err(RenderError::OutOfMemory("too many rows".into()));
        }
        self.crops.push(request.crop);
        self.size = [request.crop[2], request.crop[3]];
        self.samples = 0;
        self.wanted = request.settings.samples;
        Ok(())
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        if !cancel.load(Ordering::Relaxed) {
            if self.takes_time {
                // Nobody wakes it.
                std::thread::park_timeout(slice);
            }
            self.samples += 1;
        }
        Ok(Progress {
            samples: self.samples,
            error_estimate: Some(0.1),
            done: self.samples >= self.wanted,
        })
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        let [width, height] = self.size;
        Ok(Picture {
            size: self.size,
            pixels: vec![[0.25, 0.5, 0.75, 1.0]; (width * height) as usize],
            aov: None,
        })
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        Ok(Counters::default())
    }

    fn device_bytes(&self) -> u64 {
        0
    }
}

fn order(size: [u32; 2], samples: u32, format: Format) -> PictureOrder {
    let design = Design::default();
    let mut small = design.clone();
    (small.sheet.warps, small.sheet.wefts) = (2, 2);
    PictureOrder {
        view: LodView::of(
            Arc::new(scene::compile(&small).unwrap()),
            Camera::from_design(&design.view.cameras[0]),
        ),
        size,
        crop: [0, 0, size[0], size[1]],
        settings: Settings {
            samples,
            error: 0.0,
            ..Settings::from(&design.quality)
        },
        time: None,
        format,
        display: Display::from(&design),
        transparent: None,
        about: About::default(),
        chunks: Vec::new(),
        band_bytes: 1 << 30,
    }
}

const PNG: Format = Format::Png(Depth::Eight);

#[test]
fn bands_get_lower_where_the_device_has_no_room() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("picture.png");
    let mut backend = Slow::new(40, false);
    let never = AtomicBool::new(false);
    let made = picture_file::make(
        &order([50, 200], 1, PNG),
        &mut backend,
        None,
        &path,
        &never,
        |_| {},
    )
    .unwrap();
    assert_eq!(image::image_dimensions(&path).unwrap(), (50, 200));
    let heights: Vec<u32> = backend.crops.iter().map(|crop| crop[3]).collect();
    assert_eq!(heights.iter().sum::<u32>(), 200);
    assert!(heights.iter().all(|height| *height <= 40), "{heights:?}");
    assert_eq!(made.bands as usize, heights.len());
    assert!(
        heights[..heights.len() - 1]
            .iter()
            .all(|height| height % 16 == 0),
        "{heights:?}"
    );

    // Where not even the lowest fits, it says so and leaves nothing.
    let path = folder.path().join("other.png");
    let mut backend = Slow::new(8, false);
    let failure = picture_file::make(
        &order([50, 200], 1, PNG),
        &mut backend,
        None,
        &path,
        &never,
        |_| {},
    );
    assert!(matches!(
        failure,
        Err(Failure::Render(RenderError::OutOfMemory(_)))
    ));
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "only the first picture"
    );
}

#[test]
fn time_is_shared_by_rows_and_no_band_goes_without_a_sample() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("picture.png");
    let mut order = order([100, 64], 1_000_000, PNG);
    // Four bands of 16 rows.
    order.band_bytes = 100 * 96 * 16;
    order.time = Some(Duration::from_millis(1200));
    let mut backend = Slow::new(99, true);
    let mut samples = [0; 5];
    let mut shares = vec![0.0];
    let never = AtomicBool::new(false);
    let begun = Instant::now();
    let tell = |standing: &Standing| {
        samples[standing.band[0] as usize] = standing.samples;
        assert_eq!(standing.band[1], 4);
        shares.push(standing.share);
    };
    let made = picture_file::make(&order, &mut backend, None, &path, &never, tell).unwrap();
    assert!(
        begun.elapsed() >= Duration::from_millis(1180),
        "stopped early"
    );
    assert!(
        shares.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9),
        "{shares:?}"
    );
    // 300 ms a band, in slices of 100 ms and a last one of what the machine left of them.
    assert!(
        samples[1..].iter().all(|samples| (2..=5).contains(samples)),
        "{samples:?}"
    );
    assert_eq!(made.samples, *samples[1..].iter().min().unwrap());

    order.time = Some(Duration::from_millis(1));
    let made = picture_file::make(&order, &mut backend, None, &path, &never, |_| {}).unwrap();
    assert_eq!(
        (made.samples, made.bands),
        (1, 4),
        "past its time each band has one sample"
    );
}

#[test]
fn what_is_cancelled_leaves_the_old_file_alone() {
    for format in [PNG, Format::Exr(vec![ExrLayer::Alpha])] {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("picture");
        fs::write(&path, "old").unwrap();
        let cancel = AtomicBool::new(false);
        let mut backend = Slow::new(99, false);
        let failure = picture_file::make(
            &order([64, 64], 1_000, format),
            &mut backend,
            None,
            &path,
            &cancel,
            |standing| {
                if standing.samples == 5 {
                    cancel.store(true, Ordering::Relaxed);
                }
            },
        );
        assert!(matches!(failure, Err(Failure::Cancelled)), "{failure:?}");
        assert!(
            backend.samples < 10,
            "went on for {} samples",
            backend.samples
        );
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_and_nothing_is_left() {
    let folder = folder();
    for name in ["full.png", "full.exr"] {
        std::os::unix::fs::symlink("/dev/full", folder.path().join(name)).unwrap();
        let before = fs::read_dir(folder.path()).unwrap().count();
        let output = render(
            folder.path(),
            &["-o", name, "--size", "200x200", "--backend", "cpu"],
        );
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(
            errors.contains(name) && errors.contains("No space left"),
            "{errors}"
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), before);
    }
}

#[test]
fn the_largest_picture_is_made_in_bands_of_bounded_memory() {
    let side = renderer_core::render::MAX_SIDE;
    let mut bands = Bands::new([0, 0, side, side], true, picture_file::BAND_BYTES);
    let expected = bands.count();
    let (mut rows, mut count) = (0, 0);
    while rows < side {
        let band = bands.next();
        assert_eq!(band[1], rows);
        assert!(bands.bytes(band) <= picture_file::BAND_BYTES);
        let [before, after] = bands.shares(band);
        assert!(after > before && after <= 1.0);
        bands.finish(band);
        rows += band[3];
        count += 1;
    }
    assert_eq!((rows, count), (side, expected));
    // Even with no memory to speak of there is progress.
    assert_eq!(Bands::new([0, 0, side, 40], false, 1).next()[3], 16);
}

#[test]
fn the_time_left_counts_down_steadily_though_the_pace_changes() {
    // Work of 300 s whose pace swings by half every 20 s, reported ten times a second.
    let mut left = TimeLeft::default();
    let (mut share, mut before, mut largest_rise) = (0.0, None, 0.0_f64);
    for tick in 1..=3000 {
        let elapsed = f64::from(tick) / 10.0;
        let pace = 1.0 + 0.5 * (elapsed / 20.0 * std::f64::consts::TAU).sin();
        share += pace / 3000.0;
        left.note(Duration::from_secs_f64(elapsed), f64::min(share, 1.0));
        if let (Some(now), true) = (left.seconds(), elapsed > 30.0) {
            let truth = 300.0 - elapsed;
            assert!(
                (now - truth).abs() < 0.15 * truth + 15.0,
                "{now} s given with {truth} s left"
            );
            if let Some(before) = before {
                largest_rise = largest_rise.max(now - before);
            }
            before = Some(now);
        }
    }
    assert!(
        largest_rise < 0.5,
        "rose by {largest_rise} s in a tenth of a second"
    );
    // What is expected before counts down until a share of the work tells more, and never to nothing.
    let mut expected = TimeLeft::expecting(Duration::from_secs(100));
    assert_eq!((expected.seconds(), expected.share()), (Some(100.0), 0.0));
    expected.note(Duration::from_secs(40), 0.0);
    assert_eq!((expected.seconds(), expected.share()), (Some(60.0), 0.4));
    expected.note(Duration::from_secs(200), 0.0);
    assert_eq!(expected.seconds(), Some(1.0));
    // It was wrong: a quarter is done after 200 s.
    for second in 200..400 {
        expected.note(Duration::from_secs(second), second as f64 / 800.0);
    }
    assert!(
        (expected.seconds().unwrap_or_default() - 401.0).abs() < 40.0,
        "{expected:?}"
    );
    assert_eq!(TimeLeft::default().seconds(), None);
    assert!(TimeLeft::default().text().contains("estimating"));
}
