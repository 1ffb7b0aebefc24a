//! The view belongs to the design: files and recovery bring back what one saw, and the view follows a change of size.

use std::fs;

use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use renderer_core::design::CameraDesign;
use towel_designer::designer::{App, camera_moves};
use towel_designer::files;

use super::export::{export_to, open as open_export};
use super::filing::{User, key, wait_for_document, wait_for_kept};
use super::view::{camera, focus_viewport};
use super::{click, design, designer_of_size, requested, type_number, type_path, wait};

/// Turns the camera to where no file has it, and nearer.
fn look_around(harness: &mut Harness<'_, App>) -> CameraDesign {
    let before = camera(harness);
    focus_viewport(harness);
    for press in [
        Key::ArrowRight,
        Key::ArrowUp,
        Key::Plus,
        Key::Plus,
        Key::Plus,
    ] {
        harness.key_press(press);
        harness.run_steps(2);
    }
    let after = camera(harness);
    assert_ne!(after, before);
    after
}

#[test]
fn files_open_with_the_view_they_were_saved_in() {
    let user = User::new();
    for name in ["looked.toml", "looked.towel", "looked.png"] {
        let mut harness = user.start(Some(user.preset("one.toml")));
        wait_for_document(&mut harness, "one");
        let seen = look_around(&mut harness);
        assert!(
            !harness.state().document().is_unsaved(),
            "looking around is no change of the design"
        );
        let path = user.at(name);
        if name.ends_with("png") {
            open_export(&mut harness);
            type_number(&mut harness, "Export width", "30");
            type_number(&mut harness, "Export samples", "2");
            export_to(&mut harness, &path);
            wait(&mut harness, name, |h| {
                h.query_by_label("Exported").is_some()
            });
        } else {
            key(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
            type_path(&mut harness, &path);
            click(&mut harness, "Save file");
            wait_for_document(&mut harness, "looked");
        }
        drop(harness);
        let saved = files::load_design(&path).expect("a design");
        assert_eq!(saved.view.opening(), Some(&seen), "{name}");
        assert_eq!(saved.view.cameras.len(), 1, "saved views are as they were");
        let mut again = user.start(Some(path));
        wait_for_document(&mut again, "looked");
        assert_eq!(camera(&again), seen, "{name}");
        assert!(!again.state().document().is_unsaved());
    }
}

#[test]
fn a_recovered_design_is_seen_as_it_was() {
    let user = User::new();
    let mut harness = user.start(None);
    type_number(&mut harness, "Wefts", "44");
    wait_for_kept(&user, &mut harness);
    let first = fs::read(user.kept_file()).expect("what was kept");
    // Nothing but the view changes from here on.
    let seen = look_around(&mut harness);
    wait(&mut harness, "the view to be kept", |_| {
        fs::read(user.kept_file()).is_ok_and(|now| now != first)
    });
    drop(harness);
    let mut harness = user.start(None);
    click(&mut harness, "Recover");
    assert_eq!(design(&harness).sheet.wefts, 44);
    assert_eq!(camera(&harness), seen);
}

#[test]
fn cloth_of_another_size_is_fitted_unless_one_looks_at_a_detail() {
    let mut harness = designer_of_size(None, vec2(1280.0, 900.0));
    click(&mut harness, "Toolbar: Angle");
    let shows_all = |harness: &Harness<'_, App>| {
        let viewport = harness.state().viewport();
        camera_moves::shows_all(&viewport.camera, design(harness), viewport.size())
    };
    let distance = camera(&harness).distance;
    type_number(&mut harness, "Length of the cloth", "60");
    assert!(
        camera(&harness).distance > 3.0 * distance,
        "{:?}",
        camera(&harness)
    );
    assert!(shows_all(&harness));
    // Smaller cloth is not left as a speck.
    type_number(&mut harness, "Length of the cloth", "10");
    assert!(camera(&harness).distance < 1.3 * distance);
    click(&mut harness, "Toolbar: Macro");
    let near = camera(&harness);
    type_number(&mut harness, "Length of the cloth", "60");
    assert_eq!(camera(&harness), near, "one looks at a detail");
    assert_eq!(
        requested(&harness).sheet.wefts,
        design(&harness).sheet.wefts
    );
}

#[test]
fn density_keeps_the_size_and_says_what_it_rounds_to() {
    let mut harness = designer_of_size(None, vec2(1280.0, 900.0));
    let length = |h: &Harness<'_, App>| {
        let sheet = &design(h).sheet;
        f64::from(sheet.wefts) * sheet.pitch_y() / 10.0
    };
    type_number(&mut harness, "Length of the cloth", "140");
    assert_eq!(design(&harness).sheet.wefts, 2072, "14.8 in a cm");
    for (density, wefts) in [("15.2", 2128), ("0.7", 98), ("0.73", 102), ("14.8", 2072)] {
        type_number(&mut harness, "Wefts per cm", density);
        assert_eq!(design(&harness).sheet.wefts, wefts, "{density} in a cm");
        let off = (length(&harness) - 140.0).abs();
        let is_said = harness.query_by_label_contains("In whole yarns").is_some();
        assert_eq!(is_said, off >= 0.005, "{density} in a cm: {off} cm off");
    }
    // Whoever counts yarns means yarns.
    type_number(&mut harness, "Wefts", "2000");
    type_number(&mut harness, "Wefts per cm", "16");
    assert_eq!(design(&harness).sheet.wefts, 2162, "of 135.135 cm");
    assert_eq!(design(&harness).sheet.warps, 120);
}
