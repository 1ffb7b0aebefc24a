//! The export window: sizes, stops, kinds of files, progress, cancelling, and what it says when it cannot.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use egui::accesskit::Role;
use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use renderer_core::design::{Design, LengthMap, Method};
use renderer_core::image::Picture;
use renderer_core::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};
use towel_designer::backend::BackendChoice;
use towel_designer::designer::{App, MakeBackend, Setup};
use towel_designer::files;

use super::filing::User;
use super::{choose, click, design, designer, rest, setup, type_number, type_path, wait, window};

type Refusal = fn() -> RenderError;

/// Draws gray, and can be made never to end, never to begin or to refuse.
struct Gray {
    /// Samples that it draws at once; it is at work on the next for ever.
    most: u32,
    samples: u32,
    wanted: u32,
    size: [u32; 2],
    refuses: Option<Refusal>,
    /// Compiles what it draws with, for ever.
    compiles: bool,
    /// Who holds the other end sees when it is dropped.
    _alive: Arc<()>,
}

impl Backend for Gray {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        "gray".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if let Some(why) = self.refuses {
            return Err(why());
        }
        self.size = [request.crop[2], request.crop[3]];
        (self.samples, self.wanted) = (0, request.settings.samples);
        Ok(())
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        if self.samples == self.most {
            // Nobody wakes it: at work as long as it is allowed to be.
            std::thread::park_timeout(slice);
        } else if !cancel.load(Ordering::Relaxed) {
            self.samples += 1;
        }
        Ok(Progress {
            samples: self.samples,
            error_estimate: None,
            done: self.samples >= self.wanted,
        })
    }

    fn is_ready(&mut self) -> Result<bool, RenderError> {
        Ok(!self.compiles)
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        let [width, height] = self.size;
        Ok(Picture {
            size: self.size,
            pixels: vec![[0.5, 0.5, 0.5, 0.5]; (width * height) as usize],
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

/// What becomes of exports; the viewport is drawn at once. Every backend holds `alive`.
#[derive(Clone)]
struct Exports {
    /// Samples that any backend draws at once, to be at work on the next for ever.
    most: u32,
    /// Why the GPU refuses, if it does.
    refuses: Option<Refusal>,
    /// Whether the GPU never begins, because it compiles.
    compiles: bool,
    alive: Arc<()>,
}

impl Default for Exports {
    fn default() -> Self {
        Self {
            most: u32::MAX,
            refuses: None,
            compiles: false,
            alive: Arc::default(),
        }
    }
}

impl Exports {
    /// A designer whose exports are gray.
    fn window(&self, preset: Option<&Path>) -> Harness<'static, App> {
        let exports = self.clone();
        let make: MakeBackend = Arc::new(move |choice| {
            let is_gpu = choice == BackendChoice::Gpu;
            Ok(Box::new(Gray {
                most: exports.most,
                samples: 0,
                wanted: 0,
                size: [1, 1],
                refuses: exports.refuses.filter(|_| is_gpu),
                compiles: exports.compiles && is_gpu,
                _alive: Arc::clone(&exports.alive),
            }))
        });
        let setup = Setup {
            preset: preset.map(Path::to_path_buf),
            choice: BackendChoice::Cpu,
            ..setup(make)
        };
        window(vec2(1280.0, 900.0), setup)
    }
}

/// A designer whose exports are gray and end at once.
pub(super) fn with_gray(preset: Option<&Path>) -> Harness<'static, App> {
    Exports::default().window(preset)
}

pub(super) fn open(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::E);
    harness.run_steps(5);
}

fn number(harness: &Harness<'_, App>, label: &str) -> f64 {
    let field = harness.get_by_role_and_label(Role::SpinButton, label);
    field.value().unwrap_or_default().parse().expect("a number")
}

fn size(harness: &Harness<'_, App>) -> [f64; 2] {
    ["Export width", "Export height"].map(|label| number(harness, label))
}

pub(super) fn export_to(harness: &mut Harness<'_, App>, path: &Path) {
    click(harness, "Choose file and export…");
    type_path(harness, path);
    click(harness, "Save file");
}

#[test]
fn sizes_are_chosen_typed_kept_in_proportion_and_measured_on_paper() {
    let mut harness = designer(None);
    open(&mut harness);
    let [width, height] = harness.state().viewport().size().map(f64::from);
    assert_eq!(size(&harness), [2.0 * width, 2.0 * height]);
    click(&mut harness, "Sizes…");
    click(&mut harness, "4K, 3840 × 2160");
    assert_eq!(size(&harness), [3840.0, 2160.0]);

    type_number(&mut harness, "Export width", "1000");
    assert_eq!(size(&harness), [1000.0, 2160.0], "sides are free at first");
    type_number(&mut harness, "Export height", "500");
    click(&mut harness, "keep the proportion");
    type_number(&mut harness, "Export height", "800");
    assert_eq!(size(&harness), [1600.0, 800.0]);

    // 254 mm are 10 inches.
    type_number(&mut harness, "Print width", "254");
    assert_eq!(size(&harness), [3000.0, 1500.0]);
    type_number(&mut harness, "Print resolution", "150");
    assert_eq!(size(&harness), [1500.0, 750.0]);
    assert_eq!(number(&harness, "Print width"), 254.0);

    type_number(&mut harness, "Export width", "99999");
    assert_eq!(size(&harness), [16384.0, 8192.0]);
    harness.get_by_label_contains("134.2 megapixels");
    harness.get_by_label_contains("bands");
}

#[test]
fn sizes_typed_digit_by_digit_are_what_was_typed() {
    let mut harness = designer(None);
    open(&mut harness);
    for (label, digits) in [("Export width", "96"), ("Export height", "64")] {
        let field = harness.get_by_role_and_label(Role::SpinButton, label);
        field.click();
        harness.run_steps(3);
        for digit in digits.chars() {
            // On the way a side is of few pixels, on paper less than a millimetre.
            harness.event(egui::Event::Text(digit.into()));
            harness.run_steps(5);
        }
        harness.key_press(Key::Enter);
        harness.run_steps(5);
    }
    assert_eq!(size(&harness), [96.0, 64.0]);
    type_number(&mut harness, "Export height", "3");
    assert_eq!(size(&harness), [96.0, 3.0]);
}

#[test]
fn every_kind_of_file_is_what_it_says() {
    let folder = tempfile::tempdir().expect("a folder");
    for (kind, name) in [
        (None, "eight.png"),
        (Some("PNG, 16 bit"), "sixteen.png"),
        (Some("EXR, linear light"), "light.exr"),
    ] {
        let mut harness = with_gray(None);
        open(&mut harness);
        if let Some(kind) = kind {
            choose(&mut harness, "File", kind);
        }
        type_number(&mut harness, "Export width", "30");
        type_number(&mut harness, "Export height", "20");
        type_number(&mut harness, "Export samples", "2");
        click(&mut harness, "transparent");
        let path = folder.path().join(name);
        export_to(&mut harness, &path);
        wait(&mut harness, name, |h| {
            h.query_by_label("Exported").is_some()
        });
        if name.ends_with("png") {
            let colour = image::open(&path).expect("a picture").color();
            let expected = if kind.is_some() {
                image::ColorType::Rgba16
            } else {
                image::ColorType::Rgba8
            };
            assert_eq!(colour, expected, "{name}");
            assert!(
                files::carries_design(&path),
                "{name} opens again as a design"
            );
        } else {
            let light = exr::prelude::read_first_rgba_layer_from_file(
                &path,
                |_, _| Vec::new(),
                |all: &mut Vec<[f32; 4]>, _, (r, g, b, a): (f32, f32, f32, f32)| {
                    all.push([r, g, b, a]);
                },
            );
            let light = light.expect("an EXR file").layer_data.channel_data.pixels;
            let background = Design::default().background_radiance();
            // Light of the cloth alone, premultiplied: half of the pixel is background.
            let expected = 0.5 - 0.5 * background[0] as f32;
            assert_eq!(light.len(), 600);
            assert!((light[0][0] - expected).abs() < 1e-6, "{:?}", light[0]);
            assert_eq!(light[0][3], 0.5);
        }
        harness.get_by_label("Show in folder");
        assert!(
            harness.query_by_label("Choose file and export…").is_none(),
            "the window has closed"
        );
    }
}

#[test]
fn a_long_export_shows_its_progress_beside_editing_and_is_cancelled_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("long.png");
    let exports = Exports {
        most: 1000,
        ..Exports::default()
    };
    let mut harness = exports.window(None);
    rest(&mut harness);
    let before = Arc::strong_count(&exports.alive);
    open(&mut harness);
    type_number(&mut harness, "Export samples", "100000");
    export_to(&mut harness, &path);
    wait(&mut harness, "progress", |h| {
        h.query_by_label_contains(" of 100000 samples").is_some()
    });
    // More than a minute, as soon as a hundredth of the samples took a second.
    wait(&mut harness, "the time left", |h| {
        h.query_all_by_label_contains(" min left").count() > 0
    });
    harness.get_by_role(Role::ProgressIndicator);
    // Where the window is closed the status bar goes on telling, and opens it again.
    harness.get_by_label("Close window").click();
    harness.run_steps(5);
    assert!(harness.query_by_label("Cancel export").is_none());
    harness.get_by_label_contains("Exporting ").click();
    harness.run_steps(5);
    type_number(&mut harness, "Warps", "77");
    assert_eq!(design(&harness).sheet.warps, 77, "editing goes on");

    click(&mut harness, "Cancel export");
    harness.get_by_label("Choose file and export…");
    // The thread itself ends, not only what is seen of it.
    rest(&mut harness);
    wait(&mut harness, "the end of the export", |_| {
        Arc::strong_count(&exports.alive) == before
    });
    harness.run_steps(3);
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        0
    );
    assert!(harness.query_by_label("Not exported").is_none());
}

#[test]
fn an_export_is_cancelled_while_the_gpu_still_compiles() {
    let folder = tempfile::tempdir().expect("a folder");
    let exports = Exports {
        compiles: true,
        ..Exports::default()
    };
    let mut harness = exports.window(None);
    rest(&mut harness);
    let before = Arc::strong_count(&exports.alive);
    open(&mut harness);
    choose(&mut harness, "Backend", "gpu");
    export_to(&mut harness, &folder.path().join("never.png"));
    wait(&mut harness, "what it waits for", |h| {
        h.query_by_label_contains("Preparing the GPU").is_some()
    });
    assert_eq!(
        Arc::strong_count(&exports.alive),
        before + 1,
        "it is at work"
    );
    click(&mut harness, "Cancel export");
    harness.get_by_label("Choose file and export…");
    // The thread itself ends, not only what is seen of it.
    wait(&mut harness, "the end of the export", |_| {
        Arc::strong_count(&exports.alive) == before
    });
    let mut left = std::fs::read_dir(folder.path()).expect("a folder");
    assert!(left.next().is_none());
    assert!(harness.query_by_label("Not exported").is_none());
}

#[test]
fn a_time_limit_ends_the_export() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("timed.png");
    let exports = Exports {
        most: 1000,
        ..Exports::default()
    };
    let mut harness = exports.window(None);
    open(&mut harness);
    type_number(&mut harness, "Export samples", "100000");
    click(&mut harness, "time");
    type_number(&mut harness, "Export time", "0.05");
    export_to(&mut harness, &path);
    // Three seconds, the least there is; the samples would take for ever.
    wait(&mut harness, "the picture", |h| {
        h.query_by_label("Exported").is_some()
    });
    assert!(path.exists());
}

#[test]
fn a_fault_is_reported_before_anything_is_asked() {
    let mut harness = super::designer_of_size(None, vec2(1280.0, 1600.0));
    super::open_panel(&mut harness, "Loop length");
    choose(&mut harness, "Lengths", LengthMap::Gray.label());
    type_number(&mut harness, "Shortest", "9");
    assert!(
        !design(&harness).faults().is_empty(),
        "no fault to test with"
    );
    open(&mut harness);
    harness.get_by_label_contains("Mend it in its panel, then export.");
    let button = harness.get_by_label("Choose file and export…");
    assert!(button.accesskit_node().is_disabled());
}

#[test]
fn what_the_gpu_cannot_do_is_reported_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let preset = folder.path().join("six.toml");
    let mut six_face = Design::default();
    six_face.quality.method = Method::SixFace;
    files::save_design(&six_face, &preset, None).expect("saved");
    let mut harness = with_gray(Some(&preset));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    open(&mut harness);
    choose(&mut harness, "Backend", "gpu");
    harness.get_by_label_contains("choose the backend auto or cpu");

    let refusals: [(Refusal, &str); 3] = [
        (|| RenderError::NoAdapter("none".into()), "install a Vulkan"),
        (
            || RenderError::OutOfMemory("full".into()),
            "choose the backend cpu",
        ),
        (|| RenderError::Lost("unplugged".into()), "try again"),
    ];
    for (refusal, says) in refusals {
        let path = folder.path().join("refused.png");
        let exports = Exports {
            refuses: Some(refusal),
            ..Exports::default()
        };
        let mut harness = exports.window(None);
        open(&mut harness);
        choose(&mut harness, "Backend", "gpu");
        export_to(&mut harness, &path);
        wait(&mut harness, "the refusal", |h| {
            h.query_by_label("Not exported").is_some()
        });
        harness.get_by_label_contains(says);
        assert!(!path.exists());
        harness.get_by_label("Choose file and export…");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_and_the_design_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("full.png");
    std::os::unix::fs::symlink("/dev/full", &path).expect("a link");
    let mut harness = with_gray(None);
    open(&mut harness);
    type_number(&mut harness, "Export samples", "1");
    export_to(&mut harness, &path);
    if harness.query_by_label("Replace file").is_some() {
        click(&mut harness, "Replace file");
    }
    wait(&mut harness, "the failure", |h| {
        h.query_by_label("Not exported").is_some()
    });
    harness.get_by_label_contains("No space left");
    assert_eq!(*design(&harness), Design::default());
}

#[test]
fn quality_has_names_and_numbers_of_ones_own_have_none() {
    let mut harness = with_gray(None);
    open(&mut harness);
    choose(&mut harness, "Quality", "Draft, 16 samples");
    assert_eq!(number(&harness, "Export samples"), 16.0);
    choose(&mut harness, "Quality", "Best, 256 samples");
    assert_eq!(number(&harness, "Export samples"), 256.0);
    let shown = |harness: &Harness<'_, App>| {
        let quality = harness.get_by_role_and_label(Role::ComboBox, "Quality");
        quality.value().expect("a value")
    };
    assert_eq!(shown(&harness), "Best");
    type_number(&mut harness, "Export samples", "100");
    assert_eq!(shown(&harness), "Own");
    wait(&mut harness, "an estimate", |h| {
        h.query_by_label_contains("Takes about").is_some()
    });
}

#[test]
fn true_size_is_that_of_the_cloth() {
    let mut harness = with_gray(None);
    click(&mut harness, "Toolbar: Front");
    harness.get_by_label("Viewport").focus();
    harness.run_steps(2);
    harness.key_press(Key::O);
    harness.run_steps(3);
    let high = harness.state().viewport().camera.orthographic_height;
    let high = high.expect("a parallel projection");
    open(&mut harness);
    click(&mut harness, "True size");
    assert!(
        (number(&harness, "Print height") - high).abs() < 0.1,
        "{high} mm"
    );
    harness.get_by_label_contains("the cloth is printed at 100 %");
    type_number(&mut harness, "Print height", &format!("{}", high / 2.0));
    harness.get_by_label_contains("the cloth is printed at 50 %");
}

#[test]
fn size_and_quality_are_those_of_the_last_picture() {
    let user = User::new();
    let mut harness = user.start(None);
    open(&mut harness);
    type_number(&mut harness, "Export width", "64");
    type_number(&mut harness, "Export height", "48");
    type_number(&mut harness, "Export samples", "3");
    export_to(&mut harness, &user.at("small.png"));
    wait(&mut harness, "the file", |h| {
        h.query_by_label("Exported").is_some()
    });
    open(&mut harness);
    assert_eq!(size(&harness), [64.0, 48.0]);
    drop(harness);
    let mut harness = user.start(None);
    open(&mut harness);
    assert_eq!(size(&harness), [64.0, 48.0]);
    assert_eq!(number(&harness, "Export samples"), 3.0);
}
