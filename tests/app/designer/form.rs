//! The panel of the cloth's form, and its net over the picture.

use egui::accesskit::Role;
use egui::{Modifiers, Pos2, Vec2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use glam::DVec3;
use renderer_core::design::FormKind;
use renderer_core::geometry::Camera;
use renderer_core::scene::compile;
use towel_designer::designer::camera_moves;

use super::view::{camera, picture_rect};
use super::*;

/// Where a point of the world is in the window.
fn in_window(harness: &Harness<'_, App>, point: [f64; 3]) -> Pos2 {
    let (rect, size) = (picture_rect(harness), harness.state().viewport().size());
    let camera = Camera::from_design(&camera(harness));
    let pixel = camera.pixel_of(DVec3::from_array(point), size).unwrap();
    let share = vec2(
        pixel.x as f32 / size[0] as f32,
        pixel.y as f32 / size[1] as f32,
    );
    rect.min + share * rect.size()
}

/// Drags a point of the net, over which the pointer has been before.
fn drag_point(harness: &mut Harness<'_, App>, from: Pos2, by: Vec2) {
    harness.hover_at(from);
    harness.run_steps(1);
    drag(harness, from, from + by);
}

#[test]
fn forms_are_chosen_fitted_into_view_and_undone() {
    let mut harness = designer(None);
    open_panel(&mut harness, "Form");
    for (label, kind) in [
        ("waves", FormKind::Wave),
        ("rolled up", FormKind::Roll),
        ("over a rail", FormKind::Hanging),
        ("folded stack", FormKind::Stack),
    ] {
        choose(&mut harness, "Lies", label);
        harness.run_steps(3);
        assert_eq!(design(&harness).form.kind, kind);
        assert!(compile(design(&harness)).is_ok(), "{label}");
        let size = harness.state().viewport().size();
        assert!(
            camera_moves::shows_all(&camera(&harness), design(&harness), size),
            "{label}"
        );
    }
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(design(&harness).form.kind, FormKind::Hanging);
}

#[test]
fn points_of_the_net_are_dragged_and_the_camera_stays() {
    let mut harness = designer(None);
    open_panel(&mut harness, "Form");
    choose(&mut harness, "Lies", "net of points");
    harness.run_steps(4);
    let level = design(&harness).form.net.clone();
    assert_eq!((level.len(), level[0].len()), (5, 5));
    let (before, point) = (camera(&harness), level[2][3]);
    let at = in_window(&harness, point);
    drag_point(&mut harness, at, vec2(30.0, -24.0));
    let net = design(&harness).form.net.clone();
    assert_eq!(camera(&harness), before, "the camera stays");
    let there = in_window(&harness, net[2][3]);
    assert!(there.distance(at + vec2(30.0, -24.0)) < 1.0, "{there} {at}");
    let others = |net: &Vec<Vec<[f64; 3]>>| {
        let mut net = net.clone();
        net[2][3] = [0.0; 3];
        net
    };
    assert_eq!(others(&net), others(&level));

    // With Alt it goes up and nowhere else.
    harness.event(egui::Event::ModifiersChanged(Modifiers::ALT));
    drag_point(&mut harness, there, vec2(12.0, -20.0));
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    let up = design(&harness).form.net[2][3];
    assert_eq!(up[..2], net[2][3][..2]);
    assert!(up[2] > net[2][3][2] + 0.5, "{up:?}");

    // A drag is one step.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(design(&harness).form.net, net);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(design(&harness).form.net, level);

    // Beside the points the camera turns, as ever; and with the panel closed also at them.
    drag_point(&mut harness, at + vec2(0.0, 30.0), vec2(20.0, 0.0));
    let turned = camera(&harness);
    assert_ne!(turned, before);
    harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Form")
        .click();
    harness.run_steps(20);
    let at = in_window(&harness, level[2][3]);
    drag_point(&mut harness, at, vec2(20.0, 0.0));
    assert_ne!(camera(&harness), turned);
    assert_eq!(design(&harness).form.net, level);
}

#[test]
fn a_net_of_another_size_keeps_its_surface_and_can_be_laid_level() {
    let mut harness = designer(None);
    open_panel(&mut harness, "Form");
    choose(&mut harness, "Lies", "net of points");
    harness.run_steps(4);
    let level = design(&harness).form.net.clone();
    let at = in_window(&harness, level[2][2]);
    harness.event(egui::Event::ModifiersChanged(Modifiers::ALT));
    drag_point(&mut harness, at, vec2(0.0, -25.0));
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    let height = |harness: &Harness<'_, App>| {
        renderer_core::scene::Net::new(&design(harness).form.net)
            .at(0.5, 0.5)
            .z
    };
    let raised = height(&harness);
    assert!(raised > 0.5, "{raised}");
    harness.get_by_label("Lay level").click();
    harness.run_steps(3);
    assert_eq!(design(&harness).form.net, level);
    assert!(harness.get_by_label("Lay level").accesskit_node().role() == Role::Button);
}

#[test]
fn a_height_picture_is_opened_undone_and_refused_where_it_belongs() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("hill.png");
    let grey = |x: u32, y: u32| image::Luma([(x * (15 - x) + y * (11 - y)) as u8]);
    image::GrayImage::from_fn(16, 12, grey)
        .save(&file)
        .expect("written");
    let mut harness = designer_of_size(None, vec2(1280.0, 1600.0));
    open_panel(&mut harness, "Form");
    choose(&mut harness, "Lies", "height picture");
    let asked = "form.image is left out";
    assert!(harness.query_all_by_label_contains(asked).count() > 0);
    assert!(harness.query_by_label_contains("No picture yet").is_some());
    click(&mut harness, "Open height picture…");
    type_path(&mut harness, &file);
    click(&mut harness, "Open file");
    wait(&mut harness, "the picture", |h| {
        design(h).form.pixels.is_some()
    });
    harness.run_steps(3);
    let opened = design(&harness).form.clone();
    let document = harness.state().document();
    assert_eq!(document.undo_name(), Some("open height picture"));
    assert_eq!(harness.query_all_by_label_contains(asked).count(), 0);
    assert!(harness.query_by_label("hill.png, 16 × 12 px").is_some());
    assert!(harness.query_by_label("Height picture").is_some());
    assert!(compile(design(&harness)).is_ok_and(|scene| scene.form.is_some()));
    let size = harness.state().viewport().size();
    let shown = camera_moves::shows_all(&camera(&harness), design(&harness), size);
    assert!(shown);

    type_number(&mut harness, "Height", "7");
    type_number(&mut harness, "Smooth", "9");
    let form = &requested(&harness).form;
    assert_eq!((form.height, form.smooth), (7.0, 9.0));
    assert_eq!(form.pixels, opened.pixels);

    std::fs::write(&file, "no image").expect("written");
    click(&mut harness, "Open height picture…");
    type_path(&mut harness, &file);
    click(&mut harness, "Open file");
    wait(&mut harness, "the error", |h| {
        h.query_by_label("Height picture not opened").is_some()
    });
    let message = "is none of PNG, JPEG, WebP";
    assert!(harness.query_by_label_contains(message).is_some());
    assert_eq!(
        design(&harness).form.pixels,
        opened.pixels,
        "what was there stays"
    );
    for _ in 0..4 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
    }
    assert_eq!(*design(&harness), Design::default());
}
