//! The designer driven as a user drives it, through egui_kittest: edits reach the document and the renderer's request,
//! undo takes them back, files come out as they went in.
//!
//! Here: the window as a whole, its files, keys and devices. Its parts have modules of their own.

mod cell_sets;
mod chart;
mod chart_objects;
mod compare;
mod denoising;
mod driving;
mod export;
mod filing;
mod form;
mod handing_on;
mod kept_view;
mod legible;
mod light;
mod looks;
mod loops;
mod new_design;
mod panels;
mod ready_patterns;
mod rendering;
mod scripts;
mod states;
mod steady;
mod thumbnails;
mod typed;
mod view;
mod weave;
mod yarn_table;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use renderer_core::denoise::DenoiseError;
use renderer_core::design::{
    Design, EnvironmentKind, LengthEntry, LengthMap, Numbers, Pattern, Phase,
};
use renderer_core::gpu;
use renderer_core::image::Picture;
use renderer_core::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};
use towel_designer::backend::BackendChoice;
use towel_designer::designer::panels::Panels;
use towel_designer::designer::{App, DisplayFrame, LiveLight, Setup};
use towel_designer::files;

pub(crate) use driving::*;

#[test]
fn the_viewport_orbits_pans_zooms_and_keeps_the_document() {
    let mut harness = designer(None);
    let first = harness.state().viewport().camera.clone();
    let centre = harness.get_by_label("Viewport").rect().center();
    let drag = |harness: &mut Harness<'_, App>, by: Vec2| {
        harness.drag_at(centre);
        harness.run_steps(1);
        harness.hover_at(centre + by);
        harness.run_steps(1);
        harness.drop_at(centre + by);
        harness.run_steps(2);
    };
    drag(&mut harness, vec2(60.0, 20.0));
    let orbited = harness.state().viewport().camera.clone();
    assert!(orbited.azimuth < first.azimuth && orbited.elevation > first.elevation);
    assert_eq!(orbited.target, first.target);
    assert_eq!(
        harness
            .state()
            .viewport()
            .requested()
            .expect("a request")
            .camera,
        orbited
    );

    harness.hover_at(centre);
    harness.run_steps(1);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        source: egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(12);
    let zoomed = harness.state().viewport().camera.clone();
    assert!(
        zoomed.distance < 0.95 * orbited.distance,
        "{}",
        zoomed.distance
    );

    harness.get_by_label("Viewport").focus();
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.run_steps(2);
    let panned = harness.state().viewport().camera.clone();
    assert_ne!(panned.target, zoomed.target);
    assert_eq!(panned.azimuth, zoomed.azimuth);

    click(&mut harness, "Toolbar: Back");
    assert_eq!(harness.state().viewport().camera.elevation, -90.0);
    assert!(
        !harness.state().document().is_unsaved(),
        "looking is no change"
    );
}

#[test]
fn a_preset_is_opened_saved_as_and_reopened_equal() {
    let folder = tempfile::tempdir().expect("a folder");
    let preset = folder.path().join("first.toml");
    let chart = folder.path().join("stripes.png");
    write_chart(&chart);
    let mut original = Design::default();
    original.weave.pattern = Pattern::filled(3, 2, 7);
    original.chart.image = Some("stripes.png".into());
    files::save_design(&original, &preset, Some(&preset)).expect("saved");

    let home = tempfile::tempdir().expect("a folder");
    let start = |preset: PathBuf| {
        let setup = Setup {
            preset: Some(preset),
            folders: Some(folders_in(home.path())),
            ..setup(flat())
        };
        window(vec2(1280.0, 720.0), setup)
    };
    let mut harness = start(preset.clone());
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    assert_eq!(design(&harness).weave.pattern, original.weave.pattern);
    assert!(design(&harness).chart.pixels.is_some());
    type_number(&mut harness, "Wefts", "33");
    let edited = design(&harness).clone();

    // To another folder, so that the chart's path must change.
    let elsewhere = folder.path().join("elsewhere");
    std::fs::create_dir(&elsewhere).expect("a folder");
    let copy = elsewhere.join("second");
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    harness.run_steps(3);
    type_path(&mut harness, &copy);
    click(&mut harness, "Save file");
    let copy = copy.with_extension("toml");
    assert!(copy.is_file(), "the ending is added");
    assert_eq!(harness.state().document().path(), Some(copy.as_path()));
    assert!(!harness.state().document().is_unsaved());
    let text = std::fs::read_to_string(&copy).expect("text");
    assert!(text.contains("\"../stripes.png\""), "{text}");

    // Whoever saved it is not asked about its chart in another folder.
    drop(harness);
    let mut again = start(copy);
    wait(&mut again, "the copy", |h| {
        h.state().document().path().is_some()
    });
    let mut reopened = design(&again).clone();
    // The same file by another spelling.
    reopened.chart.image.clone_from(&edited.chart.image);
    assert_eq!(reopened, edited);
}

#[test]
fn a_chart_is_opened_and_cleared() {
    let folder = tempfile::tempdir().expect("a folder");
    let chart = folder.path().join("chart.png");
    write_chart(&chart);
    let mut harness = designer(None);
    click(&mut harness, "Open chart…");
    type_path(&mut harness, &chart);
    click(&mut harness, "Open file");
    wait(&mut harness, "the chart", |h| {
        design(h).chart.pixels.is_some()
    });
    harness.run_steps(3);
    assert!(requested(&harness).chart.pixels.is_some());
    assert_eq!(harness.state().document().undo_name(), Some("open chart"));
    click(&mut harness, "Clear chart");
    assert_eq!(*design(&harness), Design::default());

    std::fs::write(&chart, "no image").expect("written");
    click(&mut harness, "Open chart…");
    type_path(&mut harness, &chart);
    click(&mut harness, "Open file");
    wait(&mut harness, "the error", |h| {
        h.query_by_label("Chart not opened").is_some()
    });
    assert!(harness.query_by_label_contains("chart.png").is_some());
}

#[test]
fn surroundings_are_opened_undone_and_refused_where_they_belong() {
    let folder = tempfile::tempdir().expect("a folder");
    let sky = folder.path().join("sky.hdr");
    let mut file = Vec::new();
    let encoder = image::codecs::hdr::HdrEncoder::new(&mut file);
    encoder
        .encode(&[image::Rgb([0.5, 1.0, 8.0]); 32], 8, 4)
        .expect("a picture");
    std::fs::write(&sky, file).expect("written");
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    open_panel(&mut harness, "Light");
    choose(&mut harness, "Kind", "image");
    let asked = "light.environment.image is left out";
    assert!(harness.query_all_by_label_contains(asked).count() > 0);
    click(&mut harness, "Open surroundings…");
    type_path(&mut harness, &sky);
    click(&mut harness, "Open file");
    let environment = |h: &Harness<'_, App>| design(h).light.environment.clone();
    wait(&mut harness, "the surroundings", |h| {
        environment(h).pixels.is_some()
    });
    harness.run_steps(3);
    assert_eq!(environment(&harness).kind, EnvironmentKind::Image);
    assert_eq!(
        harness.state().document().undo_name(),
        Some("open surroundings")
    );
    assert!(
        harness
            .query_by_label("Image of the surroundings")
            .is_some()
    );
    assert!(harness.query_by_label("sky.hdr, 8 × 4 px").is_some());
    assert_eq!(harness.query_all_by_label_contains(asked).count(), 0);
    let opened = environment(&harness);
    let mut twice = |key| {
        for _ in 0..2 {
            harness.key_press_modifiers(Modifiers::COMMAND, key);
            harness.run_steps(3);
        }
        design(&harness).clone()
    };
    assert_eq!(twice(Key::Z), Design::default());
    assert_eq!(twice(Key::Y).light.environment, opened);

    std::fs::write(&sky, "no image").expect("written");
    click(&mut harness, "Open surroundings…");
    type_path(&mut harness, &sky);
    click(&mut harness, "Open file");
    wait(&mut harness, "the error", |h| {
        h.query_by_label("Surroundings not opened").is_some()
    });
    assert!(
        harness
            .query_by_label_contains("is none of .hdr, .exr")
            .is_some()
    );
    assert_eq!(environment(&harness), opened, "what was there stays");
}

#[test]
fn a_dropped_image_becomes_the_chart() {
    let folder = tempfile::tempdir().expect("a folder");
    let chart = folder.path().join("chart.PNG");
    write_chart(&chart);
    let mut harness = designer(None);
    let dropped = Arc::new(Dropped(chart));
    harness.input_mut().dropped_files.push(dropped);
    wait(&mut harness, "the chart", |h| {
        design(h).chart.pixels.is_some()
    });
    let pixels = design(&harness).chart.pixels.clone().expect("pixels");
    assert_eq!((pixels.width(), pixels.height()), (8, 4));
}

/// Draws a first sample, over and over.
struct Endless(FlatBackend);

impl Backend for Endless {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        "endless".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.0.begin(request)
    }

    fn advance(&mut self, _: Duration, _: &AtomicBool) -> Result<Progress, RenderError> {
        std::thread::yield_now();
        Ok(Progress {
            samples: 1,
            ..Progress::default()
        })
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        self.0.picture()
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        self.0.counters()
    }

    fn device_bytes(&self) -> u64 {
        0
    }
}

#[test]
fn the_gpu_draws_on_the_windows_own_device() {
    assert!(
        !gpu::adapters().is_empty(),
        "no GPU adapter; on Debian and Ubuntu install mesa-vulkan-drivers"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("red.toml");
    let text = "format = 1\n\n[sheet]\nwarps = 12\nwefts = 12\n\n[chart]\ncolour = \"#c04040\"\n\n\
                [quality]\nmethod = \"single\"\nbounces = 1\nsamples = 2\n";
    std::fs::write(&path, text).expect("written");
    let mut harness = Harness::builder()
        .with_size(vec2(1000.0, 560.0))
        .wgpu()
        .build_eframe(|cc| {
            let setup = Setup {
                preset: Some(path),
                choice: BackendChoice::Gpu,
                // While the device compiles, the processor may draw, but it comes to no end: what it has finished
                // before stays its own.
                make: Arc::new(|choice| match choice {
                    BackendChoice::Cpu => Ok(Box::new(Endless(FlatBackend {
                        size: [1, 1],
                        samples: 1,
                    }))),
                    _ => panic!("a second device"),
                }),
                denoiser: Arc::new(|| Err(DenoiseError::NotFound)),
                system_dialogs: false,
                folders: None,
            };
            App::new(cc, setup)
        });
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    harness.run_steps(2);
    click(&mut harness, "Toolbar: Fit");
    // The first picture of reduced size is enough: software Vulkan takes its time for large ones.
    let is_drawn = |h: &Harness<'_, App>| {
        let state = h.state().viewport().state();
        assert_eq!(state.error, None);
        matches!(state.picture.frame, Some(DisplayFrame::Texture(_)))
    };
    wait(&mut harness, "a picture", is_drawn);
    harness.run_steps(2);
    let viewport = harness.get_by_label("Viewport").rect();
    let picture = harness.render().expect("a picture of the window");
    let red = picture.enumerate_pixels().filter(|(x, y, p)| {
        viewport.contains(Pos2::new(*x as f32, *y as f32)) && p[0] > 60 && p[1] < p[0] / 2
    });
    assert!(red.count() > 2000, "no red cloth in the viewport");
}

#[test]
fn faults_of_a_preset_are_reported_with_their_lines_and_nothing_is_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("broken.toml");
    std::fs::write(
        &path,
        "format = 1\n\n[sheet]\nwarps = 5\nwefts = -3\nwarp = 7\n",
    )
    .expect("written");
    let mut harness = designer(Some(path));
    wait(&mut harness, "the error", |h| {
        h.query_by_label("Preset not opened").is_some()
    });
    let message = harness
        .get_by_label_contains("broken.toml")
        .accesskit_node()
        .label()
        .or_else(|| harness.get_by_label_contains("broken.toml").value())
        .unwrap_or_default();
    assert!(
        message.contains("broken.toml:5:") && message.contains("broken.toml:6:"),
        "{message}"
    );
    assert_eq!(*design(&harness), Design::default());
    click(&mut harness, "Dismiss: Preset not opened");
    assert!(harness.query_by_label("Preset not opened").is_none());
}

#[test]
fn unsaved_changes_are_asked_about() {
    let mut harness = designer(None);
    paint_cell(&mut harness, 1, 0);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::N);
    harness.run_steps(3);
    click(&mut harness, "Cancel");
    assert_eq!(
        design(&harness).weave.pattern.at(1, 0),
        7,
        "Cancel keeps the work"
    );

    harness.key_press_modifiers(Modifiers::COMMAND, Key::N);
    harness.run_steps(3);
    click(&mut harness, "Discard changes");
    assert_eq!(*design(&harness), Design::default());
    assert!(harness.query_by_label("Save changes?").is_none());
}

#[test]
fn shortcuts_open_help_export_and_dialogs() {
    let mut harness = designer(None);
    harness.key_press(Key::F1);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Every yarn loop").is_some());
    harness.key_press(Key::F1);
    harness.run_steps(6);
    assert!(harness.query_by_label_contains("Every yarn loop").is_none());

    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    harness.run_steps(3);
    assert!(harness.query_by_label("Open file").is_some());
    click(&mut harness, "Cancel");
    assert!(harness.query_by_label("Open file").is_none());

    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("picture.png");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::E);
    harness.run_steps(3);
    click(&mut harness, "Choose file and export…");
    type_path(&mut harness, &picture);
    click(&mut harness, "Save file");
    wait(&mut harness, "the picture", |_| picture.exists());
    let [width, height] = harness.state().viewport().size();
    let written = image::open(&picture).expect("a picture");
    assert_eq!((written.width(), written.height()), (2 * width, 2 * height));
}

#[test]
fn backend_and_light_are_switched_in_the_status_bar() {
    let mut harness = designer(None);
    wait(&mut harness, "a device", |h| {
        h.state().viewport().state().device.is_some()
    });
    harness.run_steps(2);
    click(&mut harness, "Backend");
    harness
        .get_by_role_and_label(Role::RadioButton, "cpu")
        .click();
    harness.run_steps(3);
    let requested = harness.state().viewport().requested().expect("a request");
    assert_eq!(requested.choice, BackendChoice::Cpu);
    assert_eq!(requested.light, LiveLight::Fast);
    click(&mut harness, "Light in the viewport");
    click(&mut harness, "true light");
    let requested = harness.state().viewport().requested().unwrap();
    assert_eq!(requested.light, LiveLight::True);
}

#[test]
fn names_are_given_to_all_widgets() {
    let mut harness = designer_of_size(None, vec2(1280.0, 4200.0));
    for title in Panels::titles().skip(2) {
        open_panel(&mut harness, title);
    }
    open_seldom_needed(&mut harness);
    harness.check_accessibility();
}

#[test]
fn the_cloths_size_is_typed_in_centimetres() {
    let mut harness = designer(None);
    let before = design(&harness).sheet.clone();
    type_number(&mut harness, "Width of the cloth", "70");
    type_number(&mut harness, "Length of the cloth", "140");
    let sheet = &design(&harness).sheet;
    let expected = [70.0 * before.warps_per_cm, 140.0 * before.wefts_per_cm];
    assert_eq!(
        [sheet.warps, sheet.wefts].map(f64::from),
        expected.map(f64::round)
    );
    assert_eq!(
        sheet.warps_per_cm, before.warps_per_cm,
        "as close as before"
    );
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
    }
    assert_eq!(design(&harness).sheet, before);
}

#[test]
fn escape_closes_what_is_nearest() {
    let mut harness = designer(None);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::E);
    harness.run_steps(6);
    harness.key_press(Key::F1);
    harness.run_steps(6);
    let is_open = |harness: &Harness<'_, App>, part: &str| {
        harness.query_all_by_label_contains(part).next().is_some()
    };
    let escape = |harness: &mut Harness<'_, App>| {
        harness.key_press(Key::Escape);
        harness.run_steps(20);
        [
            is_open(harness, "Every yarn loop"),
            is_open(harness, "Choose file and export…"),
        ]
    };
    assert!(is_open(&harness, "Every yarn loop"));
    assert_eq!(escape(&mut harness), [false, true], "the help");
    // What is typed in gives up the keyboard first.
    let field = harness.get_by_role_and_label(Role::SpinButton, "Export width");
    field.click();
    harness.run_steps(3);
    assert_eq!(escape(&mut harness), [false, true], "a field");
    assert_eq!(escape(&mut harness), [false, false], "the window");
}

#[test]
fn a_panel_scrolls_to_what_tab_comes_to() {
    let mut harness = designer_of_size(None, vec2(1280.0, 560.0));
    // From the last control that is seen in the panel at the start, on to what is below.
    harness.get_by_label("Ready patterns…").focus();
    harness.run_steps(2);
    for _ in 0..40 {
        harness.key_press(Key::Tab);
        harness.run_steps(2);
        harness.run_steps(20);
        let focused = harness.root().children_recursive();
        let focused = focused.filter(|node| node.accesskit_node().is_focused());
        let Some(place) = focused.map(|node| node.rect()).next() else {
            continue;
        };
        let panel = egui::Rect::from_min_max(Pos2::new(0.0, 50.0), Pos2::new(360.0, 545.0));
        // The bars above and below scroll nowhere.
        let is_left = place.right() < 356.0 && place.top() > 58.0 && place.top() < 535.0;
        assert!(
            !is_left || panel.contains_rect(place),
            "{place:?} is not seen"
        );
    }
    let last = harness.get_by_role_and_label(Role::DisclosureTriangle, "View & quality");
    assert!(
        last.rect().bottom() < 560.0,
        "the panel was never scrolled: {:?}",
        last.rect()
    );
}

#[test]
fn presets_give_way_to_the_cloth_and_come_back() {
    let has_presets =
        |harness: &Harness<'_, App>| harness.query_by_label("Search presets").is_some();
    let mut harness = designer_of_size(None, vec2(800.0, 720.0));
    let cloth = harness.get_by_label("Viewport").rect().width();
    assert!(
        cloth >= 250.0 && !has_presets(&harness),
        "{cloth} points of cloth"
    );
    click(&mut harness, "Toolbar: Presets");
    assert!(has_presets(&harness));
    states::show_presets(&mut harness);
    assert!(!has_presets(&harness));

    let mut harness = designer(None);
    assert!(has_presets(&harness));
    assert!(harness.query_by_label("Toolbar: Presets").is_none());
    states::show_presets(&mut harness);
    assert!(!has_presets(&harness), "hidden though there is room");
}
