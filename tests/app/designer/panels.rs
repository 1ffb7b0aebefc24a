//! The panels: painted patterns, typed and dragged numbers, menus, lists; each edit one step of the history, each
//! number of a design within reach, and faults reported where they belong.

use renderer_core::design::nap_edit;

use super::*;

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
    assert_eq!(requested(&harness).weave.pattern.at(1, 0), 7);
    let document = harness.state().document();
    assert_eq!(document.undo_name(), Some("painted stitches"));
    assert!(document.is_unsaved());

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*design(&harness), before);
    assert_eq!(*requested(&harness), before);
    assert!(!harness.state().document().is_unsaved());

    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(design(&harness).weave.pattern.at(1, 0), 7);
    assert_eq!(requested(&harness).weave.pattern.at(1, 0), 7);
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
    assert_eq!(requested(&harness).sheet.warps, 77);
    assert_eq!(harness.state().document().undo_name(), Some("sheet warps"));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*requested(&harness), before);
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
    assert_eq!(requested(&harness).sheet.warps_per_cm, dragged);
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
        Box::new(design.finish),
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
        assert_has_controls(&harness, &*section);
    }
    // The numbers of the light that is selected are shown.
    click(&mut harness, "Add area light");
    let area = super::design(&harness).light.area[0].clone();
    assert_has_controls(&harness, &area);
}

#[track_caller]
fn assert_has_controls(harness: &Harness<'_, App>, section: &dyn Numbers) {
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
    assert_eq!(requested(&harness).length.map, LengthMap::Lut);
    click(&mut harness, "Add row");
    assert_eq!(design(&harness).length.table.len(), 2);
    click(&mut harness, "Remove row 1");
    assert_eq!(design(&harness).length.table.len(), 1);
}

#[test]
fn the_nap_is_combed_on_its_picture() {
    let mut harness = designer_of_size(None, vec2(1280.0, 1600.0));
    open_panel(&mut harness, "Finish");
    let direction_at = |h: &Harness<'_, App>, x: usize, y: usize| {
        let map = design(h).nap.pixels.clone().expect("a map");
        nap_edit::direction(map.pixel(x, y))
    };
    click(&mut harness, "Brush all near");
    harness.run_steps(3);
    assert!(direction_at(&harness, 60, 70)[1] < -0.9);
    assert_eq!(harness.state().document().undo_name(), Some("brushed pile"));
    let canvas = harness.get_by_role_and_label(Role::Canvas, "Nap map canvas");
    let rect = canvas.rect();
    let (from, to) = (
        rect.center() - vec2(0.3 * rect.width(), 0.0),
        rect.center() + vec2(0.3 * rect.width(), 0.0),
    );
    drag(&mut harness, from, to);
    let [right, up] = direction_at(&harness, 60, 70);
    assert!(right > 0.9 && up.abs() < 0.2, "{right} {up}");
    assert!(
        direction_at(&harness, 60, 10)[1] < -0.9,
        "elsewhere as before"
    );
    assert_eq!(requested(&harness).nap, design(&harness).nap);
    assert_eq!(harness.state().document().undo_name(), Some("combed pile"));
    click(&mut harness, "Vacuum stripes");
    harness.run_steps(3);
    let ways: Vec<f64> = (0..120).map(|x| direction_at(&harness, x, 70)[1]).collect();
    assert!(ways.iter().any(|way| *way > 0.9) && ways.iter().any(|way| *way < -0.9));
    click(&mut harness, "Clear map");
    harness.run_steps(3);
    assert_eq!(design(&harness).nap, Design::default().nap);
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
    assert_eq!(requested(&harness).length.table[0].exponent, Some(9.0));
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
    assert_eq!(requested(&harness).length.min, Design::default().length.min);
    // At the panel and over the picture.
    let message = harness.query_all_by_label_contains("length.min is 9, allowed is at most");
    assert_eq!(message.count(), 2);

    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(3);
    assert!(harness.query_by_label("Not saved").is_some());
    assert!(harness.state().document().is_unsaved());
    assert_eq!(
        files::load_design(&path).expect("the old file").length.min,
        1.5
    );

    type_number(&mut harness, "Longest", "9.5");
    assert_eq!(requested(&harness).length.min, 9.0, "mended, it is drawn");
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
