//! The designer driven as a user drives it, through egui_kittest: edits reach the document and the renderer's wish,
//! undo takes them back, files come out as they went in.
//!
//! Longer than most files because one window is driven: its panels, gestures and dialogs share one set of helpers.

mod chart;
mod export;
mod filing;
mod legible;
mod light;
mod looks;
mod loops;
mod rendering;
mod small_pictures;
mod states;
mod view;
mod weave;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use renderer_core::design::{
    Design, EnvironmentKind, LengthEntry, LengthMap, Numbers, Pattern, Phase,
};
use renderer_core::gpu;
use renderer_core::image::Picture;
use renderer_core::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};
use towel_designer::backend::BackendChoice;
use towel_designer::designer::panels::Panels;
use towel_designer::designer::{App, LiveLight, Setup, Shot};
use towel_designer::files;

/// A backend that draws flat gray at once: these tests are about the window, not about the cloth.
struct FlatBackend {
    size: [u32; 2],
    samples: u32,
}

impl Backend for FlatBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Reference
    }

    fn device_name(&self) -> String {
        "flat".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.size = request.size;
        self.samples = request.settings.samples;
        Ok(())
    }

    fn advance(&mut self, _: Duration, _: &AtomicBool) -> Result<Progress, RenderError> {
        Ok(Progress {
            samples: self.samples,
            error_estimate: Some(0.0),
            done: true,
        })
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        let [width, height] = self.size;
        Ok(Picture {
            size: self.size,
            pixels: vec![[0.5, 0.5, 0.5, 1.0]; (width * height) as usize],
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

fn designer(preset: Option<PathBuf>) -> Harness<'static, App> {
    designer_of_size(preset, vec2(1280.0, 720.0))
}

/// A designer without system dialogs, its first frames shown.
pub(crate) fn designer_of_size(preset: Option<PathBuf>, size: Vec2) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_step_dt(1.0 / 60.0)
        .build_eframe(|cc| {
            let setup = Setup {
                preset,
                choice: BackendChoice::Auto,
                make: Arc::new(|_| {
                    Ok(Box::new(FlatBackend {
                        size: [1, 1],
                        samples: 0,
                    }))
                }),
                system_dialogs: false,
                folders: None,
            };
            App::new(cc, setup)
        });
    harness.run_steps(3);
    harness
}

/// Shows frames until `done`; what other threads do comes after a while.
#[track_caller]
pub(crate) fn wait(
    harness: &mut Harness<'_, App>,
    what: &str,
    done: impl Fn(&Harness<'_, App>) -> bool,
) {
    let start = Instant::now();
    while !done(harness) {
        assert!(
            start.elapsed() < Duration::from_secs(30),
            "{what} has not come"
        );
        std::thread::sleep(Duration::from_millis(5));
        harness.step();
    }
}

fn design<'h>(harness: &'h Harness<'_, App>) -> &'h Design {
    &harness.state().document().design
}

/// The design that the renderer was last asked to draw.
fn wished(harness: &Harness<'_, App>) -> Arc<Design> {
    Arc::clone(&harness.state().viewport().wish().expect("a wish").design)
}

#[track_caller]
fn click(harness: &mut Harness<'_, App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

/// Opens a panel that starts closed. Scrolled to first, since only what is seen can be clicked.
#[track_caller]
fn open_panel(harness: &mut Harness<'_, App>, title: &str) {
    harness
        .get_by_role_and_label(Role::DisclosureTriangle, title)
        .scroll_to_me();
    harness.run_steps(20);
    harness
        .get_by_role_and_label(Role::DisclosureTriangle, title)
        .click();
    harness.run_steps(20);
}

/// Opens what panels hide because it is seldom needed.
#[track_caller]
fn open_seldom_needed(harness: &mut Harness<'_, App>) {
    for heading in [
        "More about loops",
        "Light in the pile",
        "Fineness of the volume",
        "More about clumps",
        "More about ground yarns",
        "More about quality",
    ] {
        open_panel(harness, heading);
    }
}

/// Types a number into the field of that name.
#[track_caller]
fn type_number(harness: &mut Harness<'_, App>, label: &str, text: &str) {
    let field = harness.get_by_role_and_label(Role::SpinButton, label);
    field.scroll_to_me();
    harness.run_steps(4);
    harness
        .get_by_role_and_label(Role::SpinButton, label)
        .click();
    harness.run_steps(2);
    harness.event(egui::Event::Text(text.into()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}

/// Middle of a cell of the stitch pattern on the screen, row 0 at the bottom.
pub(crate) fn cell(harness: &Harness<'_, App>, col: usize, row: usize) -> Pos2 {
    let rect = harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .rect();
    let pattern = &design(harness).weave.pattern;
    let side = vec2(
        (rect.width() - 1.0) / pattern.cols() as f32,
        (rect.height() - 1.0) / pattern.rows() as f32,
    );
    let from_corner = vec2(col as f32 + 0.5, row as f32 + 0.5) * side;
    Pos2::new(
        rect.left() + from_corner.x,
        rect.bottom() - 1.0 - from_corner.y,
    )
}

#[track_caller]
fn paint_cell(harness: &mut Harness<'_, App>, col: usize, row: usize) {
    let at = cell(harness, col, row);
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(3);
}

#[test]
fn painting_a_cell_changes_the_picture_and_undo_takes_it_back() {
    let mut harness = designer(None);
    let before = design(&harness).clone();
    assert_eq!(
        before.weave.pattern.at(1, 0),
        0,
        "the default pattern has changed"
    );

    paint_cell(&mut harness, 1, 0);
    assert_eq!(design(&harness).weave.pattern.at(1, 0), 7);
    assert_eq!(wished(&harness).weave.pattern.at(1, 0), 7);
    let document = harness.state().document();
    assert_eq!(document.undo_name(), Some("painted stitches"));
    assert!(document.is_unsaved());

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*design(&harness), before);
    assert_eq!(*wished(&harness), before);
    assert!(!harness.state().document().is_unsaved());

    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(design(&harness).weave.pattern.at(1, 0), 7);
    assert_eq!(wished(&harness).weave.pattern.at(1, 0), 7);
}

#[test]
fn a_stroke_over_many_frames_is_one_step_without_gaps() {
    let mut harness = designer(None);
    type_number(&mut harness, "Pattern columns", "9");
    type_number(&mut harness, "Pattern rows", "4");
    assert_eq!(
        design(&harness).weave.pattern.at(0, 0),
        7,
        "resizing keeps content"
    );
    let before = design(&harness).clone();

    click(&mut harness, "Paint 8: loop on the back");
    harness.drag_at(cell(&harness, 0, 3));
    harness.run_steps(2);
    // Far apart, as a fast hand's events are.
    for col in [4, 8] {
        harness.hover_at(cell(&harness, col, 3));
        harness.run_steps(2);
    }
    harness.drop_at(cell(&harness, 8, 3));
    harness.run_steps(3);
    let pattern = &design(&harness).weave.pattern;
    assert!((0..9).all(|col| pattern.at(col, 3) == 8), "{pattern:?}");
    assert!((0..9).all(|col| pattern.at(col, 2) != 8), "{pattern:?}");

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*design(&harness), before);
}

#[test]
fn filling_stops_at_other_values() {
    let mut harness = designer(None);
    type_number(&mut harness, "Pattern columns", "5");
    type_number(&mut harness, "Pattern rows", "5");
    click(&mut harness, "Fill");
    click(&mut harness, "Paint 1: warp over weft");
    paint_cell(&mut harness, 4, 4);
    let pattern = &design(&harness).weave.pattern;
    assert_eq!(pattern.at(0, 0), 7, "filled over another value");
    assert_eq!(pattern.at(1, 1), 7);
    assert_eq!(pattern.at(2, 0), 1);
    // Cut off from the rest by the loops at (0, 0) and (1, 1) and the border, except through (0, 2).
    assert_eq!(pattern.at(0, 1), 1);
    assert_eq!(pattern.at(1, 0), 1);
}

#[test]
fn the_pattern_can_be_painted_by_keyboard() {
    let mut harness = designer(None);
    harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    harness.event(egui::Event::Text("9".into()));
    harness.run_steps(3);
    assert_eq!(design(&harness).weave.pattern.at(1, 0), 9);
    harness.key_press(Key::ArrowUp);
    harness.run_steps(1);
    harness.key_press(Key::Space);
    harness.run_steps(3);
    assert_eq!(design(&harness).weave.pattern.at(1, 1), 9);
}

#[test]
fn a_typed_number_is_one_step() {
    let mut harness = designer(None);
    let before = design(&harness).clone();
    type_number(&mut harness, "Warps", "77");
    assert_eq!(design(&harness).sheet.warps, 77);
    assert_eq!(wished(&harness).sheet.warps, 77);
    assert_eq!(harness.state().document().undo_name(), Some("sheet warps"));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*wished(&harness), before);
    assert_eq!(harness.state().document().undo_name(), None);
}

#[test]
fn a_dragged_slider_is_one_step_and_a_double_click_resets() {
    let mut harness = designer(None);
    let default = design(&harness).sheet.warps_per_cm;
    let rect = harness
        .get_by_role_and_label(Role::Slider, "Warps per cm")
        .rect();
    harness.drag_at(rect.center());
    harness.run_steps(2);
    for step in 1..=4 {
        harness.hover_at(rect.center() + vec2(4.0 * step as f32, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(rect.center() + vec2(16.0, 0.0));
    harness.run_steps(3);
    let dragged = design(&harness).sheet.warps_per_cm;
    assert!(dragged > default + 1.0, "{dragged} after {default}");
    assert_eq!(wished(&harness).sheet.warps_per_cm, dragged);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(
        design(&harness).sheet.warps_per_cm,
        default,
        "one drag is one step"
    );

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.run_steps(3);
    assert_eq!(design(&harness).sheet.warps_per_cm, dragged);
    let label = harness.get_by_role_and_label(Role::Label, "Warps per cm");
    label.click();
    label.click();
    harness.run_steps(3);
    assert_eq!(design(&harness).sheet.warps_per_cm, default);
}

#[test]
fn looking_at_a_number_does_not_round_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fine.toml");
    let mut fine = Design::default();
    fine.sheet.warps_per_cm = 12.345_678_912_345;
    files::save_design(&fine, &path, None).expect("saved");
    let mut harness = designer(Some(path));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    harness
        .get_by_role_and_label(Role::SpinButton, "Warps per cm")
        .click();
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(design(&harness).sheet.warps_per_cm, fine.sheet.warps_per_cm);
    assert!(!harness.state().document().is_unsaved());
}

#[test]
fn what_is_being_typed_is_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("typed.toml");
    files::save_design(&Design::default(), &path, None).expect("saved");
    let mut harness = designer(Some(path.clone()));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    harness
        .get_by_role_and_label(Role::SpinButton, "Warps")
        .click();
    harness.run_steps(2);
    harness.event(egui::Event::Text("91".into()));
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(4);
    assert_eq!(files::load_design(&path).expect("a preset").sheet.warps, 91);
    assert!(!harness.state().document().is_unsaved());
}

#[test]
fn every_number_of_every_section_has_a_control() {
    // Tall enough that all panels are seen at once; egui leaves out what a scroll area hides.
    let mut harness = designer_of_size(None, vec2(1280.0, 4200.0));
    for title in Panels::titles().skip(2) {
        open_panel(&mut harness, title);
    }
    open_seldom_needed(&mut harness);
    let design = design(&harness).clone();
    let mut sections: Vec<Box<dyn Numbers>> = vec![
        Box::new(design.sheet),
        Box::new(design.pile),
        Box::new(design.turbulence),
        Box::new(design.skeleton),
        Box::new(design.light.environment),
        Box::new(design.quality),
    ];
    sections.extend(
        design
            .light
            .sun
            .into_iter()
            .map(|s| Box::new(s) as Box<dyn Numbers>),
    );
    sections.extend(
        design
            .view
            .cameras
            .iter()
            .cloned()
            .map(|c| Box::new(c) as Box<dyn Numbers>),
    );
    sections.push(Box::new(design.view));
    for section in sections {
        for (field, value) in section.numbers() {
            let label = towel_designer::designer::label_of(field.name);
            let controls: Vec<_> = harness
                .get_all_by_role_and_label(Role::SpinButton, &label)
                .collect();
            let shows = |node: &egui_kittest::Node<'_>| {
                let shown = node.value().unwrap_or_default();
                shown
                    .parse::<f64>()
                    .is_ok_and(|shown| (shown - value).abs() <= 1e-5 * value.abs())
            };
            assert!(
                controls.iter().any(shows),
                "no control shows {} = {value}",
                field.name
            );
        }
    }
}

#[test]
fn each_length_map_has_its_controls() {
    let mut harness = designer_of_size(None, vec2(1280.0, 1600.0));
    open_panel(&mut harness, "Loop length");
    harness.get_by_role_and_label(Role::SpinButton, "Length");

    choose(&mut harness, "Lengths", LengthMap::Gray.label());
    assert_eq!(design(&harness).length.map, LengthMap::Gray);
    harness.get_by_role_and_label(Role::SpinButton, "Shortest");
    harness.get_by_role_and_label(Role::SpinButton, "Longest");
    let curve = harness.get_by_label("Length curve").rect();
    let at = curve.center() + vec2(0.0, -20.0);
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(3);
    let points = design(&harness).length.curve.clone();
    assert_eq!(points.len(), 3, "{points:?}");
    assert!(
        (points[1][0] - 0.5).abs() < 0.02 && points[1][1] > 0.6,
        "{points:?}"
    );

    choose(&mut harness, "Lengths", LengthMap::Lut.label());
    assert_eq!(design(&harness).length.table.len(), 1);
    assert_eq!(wished(&harness).length.map, LengthMap::Lut);
    click(&mut harness, "Add row");
    assert_eq!(design(&harness).length.table.len(), 2);
    click(&mut harness, "Remove row 1");
    assert_eq!(design(&harness).length.table.len(), 1);
}

#[test]
fn rows_of_lengths_have_the_parameters_of_the_piles_phase() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fibres.toml");
    let mut original = Design::default();
    original.pile.phase = Phase::KajiyaKay;
    original.pile.exponent = 44.0;
    original.length.map = LengthMap::Lut;
    original.length.table = vec![LengthEntry::default()];
    files::save_design(&original, &path, None).expect("saved");
    let mut harness = designer_of_size(Some(path), vec2(1280.0, 1600.0));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    open_panel(&mut harness, "Loop length");
    let own = |h: &mut Harness<'_, App>, label: &str| {
        h.get_by_role_and_label(Role::CheckBox, label).click();
        h.run_steps(3);
        design(h).length.table[0].clone()
    };
    click(&mut harness, "More of row 1");
    // A row of its own starts as the pile is.
    assert_eq!(own(&mut harness, "Own exponent").exponent, Some(44.0));
    assert_eq!(own(&mut harness, "Own specular").specular, Some(0.1));
    assert!(harness.query_by_label("Own transmission").is_none());
    type_number(&mut harness, "Own exponent", "9");
    assert_eq!(wished(&harness).length.table[0].exponent, Some(9.0));
    assert_eq!(own(&mut harness, "Own exponent").exponent, None);
}

#[test]
fn a_fault_is_shown_at_its_panel_and_neither_drawn_nor_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("good.toml");
    files::save_design(&Design::default(), &path, None).expect("saved");
    let mut harness = designer_of_size(Some(path.clone()), vec2(1280.0, 1600.0));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path().is_some()
    });
    open_panel(&mut harness, "Loop length");
    choose(&mut harness, "Lengths", LengthMap::Gray.label());
    type_number(&mut harness, "Shortest", "9");
    assert_eq!(design(&harness).length.min, 9.0);
    assert_eq!(wished(&harness).length.min, Design::default().length.min);
    // At the panel and over the picture.
    let told = harness.query_all_by_label_contains("length.min is 9, allowed is at most");
    assert_eq!(told.count(), 2);

    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(3);
    assert!(harness.query_by_label("Not saved").is_some());
    assert!(harness.state().document().is_unsaved());
    assert_eq!(
        files::load_design(&path).expect("the old file").length.min,
        1.5
    );

    type_number(&mut harness, "Longest", "9.5");
    assert_eq!(wished(&harness).length.min, 9.0, "mended, it is drawn");
}

/// Chooses from the menu of that name.
#[track_caller]
fn choose(harness: &mut Harness<'_, App>, name: &str, choice: &str) {
    harness.get_by_role_and_label(Role::ComboBox, name).click();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, choice).click();
    harness.run_steps(4);
}

#[test]
fn suns_and_cameras_are_added_and_removed() {
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    open_panel(&mut harness, "Light");
    open_panel(&mut harness, "View & quality");
    click(&mut harness, "Add sun");
    assert_eq!(design(&harness).light.sun.len(), 2);
    assert_eq!(harness.state().document().undo_name(), Some("add sun"));
    click(&mut harness, "Remove sun 2");
    click(&mut harness, "Remove sun 1");
    assert!(design(&harness).light.sun.is_empty());

    click(&mut harness, "Save this view");
    let cameras = &design(&harness).view.cameras;
    assert_eq!(cameras.len(), 2);
    assert_ne!(cameras[0].name, cameras[1].name);
    assert!(design(&harness).faults().is_empty());
    click(&mut harness, "Remove view 2");
    assert_eq!(design(&harness).view.cameras.len(), 1);
}

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
        harness.state().viewport().wish().expect("a wish").camera,
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

    let mut harness = designer(Some(preset.clone()));
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

    let mut again = designer(Some(copy));
    wait(&mut again, "the copy", |h| {
        h.state().document().path().is_some()
    });
    let mut reopened = design(&again).clone();
    // The same file by another spelling.
    reopened.chart.image.clone_from(&edited.chart.image);
    assert_eq!(reopened, edited);
}

/// Replaces the text of the file dialog's path field.
#[track_caller]
fn type_path(harness: &mut Harness<'_, App>, path: &Path) {
    let field = harness.get_by_role_and_label(Role::TextInput, "Path");
    field.focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(egui::Event::Text(path.to_string_lossy().into_owned()));
    harness.run_steps(3);
}

fn write_chart(path: &Path) {
    let mut chart = image::RgbImage::new(8, 4);
    for (x, _, pixel) in chart.enumerate_pixels_mut() {
        *pixel = image::Rgb(if x < 4 {
            [200, 30, 30]
        } else {
            [250, 250, 240]
        });
    }
    chart.save(path).expect("a chart");
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
    assert!(wished(&harness).chart.pixels.is_some());
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

/// A file as the window system hands it over when it is dropped.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
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
                // While the device compiles, the processor may draw.
                make: Arc::new(|choice| match choice {
                    BackendChoice::Cpu => towel_designer::backend::make(choice),
                    _ => panic!("a second device"),
                }),
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
    // The first small picture is enough: software Vulkan takes its time for large ones. What the processor has finished
    // before the device had compiled stays the processor's; then another picture is asked for.
    let is_drawn = |h: &Harness<'_, App>| {
        let shown = h.state().viewport().shown();
        assert_eq!(shown.error, None);
        matches!(shown.image, Some(Shot::Texture(_)))
    };
    let start = Instant::now();
    for warps in 13.. {
        wait(&mut harness, "a picture", |h| {
            is_drawn(h) || (h.state().viewport().shown().progress.done)
        });
        if is_drawn(&harness) {
            break;
        }
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "the device does not draw"
        );
        std::thread::sleep(Duration::from_secs(1));
        type_number(&mut harness, "Warps", &warps.to_string());
    }
    harness.run_steps(2);
    let viewport = harness.get_by_label("Viewport").rect();
    let picture = harness.render().expect("a picture of the window");
    let red = picture.enumerate_pixels().filter(|(x, y, p)| {
        viewport.contains(Pos2::new(*x as f32, *y as f32)) && p[0] > 60 && p[1] < p[0] / 2
    });
    assert!(red.count() > 2000, "no red cloth in the viewport");
}

#[test]
fn faults_of_a_preset_are_told_with_their_lines_and_nothing_is_lost() {
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
    let told = harness
        .get_by_label_contains("broken.toml")
        .accesskit_node()
        .label()
        .or_else(|| harness.get_by_label_contains("broken.toml").value())
        .unwrap_or_default();
    assert!(
        told.contains("broken.toml:5:") && told.contains("broken.toml:6:"),
        "{told}"
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
        h.state().viewport().shown().device.is_some()
    });
    harness.run_steps(2);
    click(&mut harness, "Backend");
    harness
        .get_by_role_and_label(Role::RadioButton, "cpu")
        .click();
    harness.run_steps(3);
    let wish = harness.state().viewport().wish().expect("a wish");
    assert_eq!(wish.choice, BackendChoice::Cpu);
    assert_eq!(wish.light, LiveLight::Fast);
    click(&mut harness, "Light in the viewport");
    click(&mut harness, "true light");
    let wish = harness.state().viewport().wish().unwrap();
    assert_eq!(wish.light, LiveLight::True);
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
