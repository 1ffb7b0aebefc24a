//! The panel Light: suns and area lights dragged on a sphere, by pointer and keys, and light presets.

use renderer_core::design::{AreaLight, Sun};
use towel_designer::designer::panels::LightPreset;

use super::*;

fn lit() -> Harness<'static, App> {
    let mut harness = designer_of_size(None, vec2(1280.0, 2000.0));
    open_panel(&mut harness, "Light");
    harness
}

fn suns(harness: &Harness<'_, App>) -> Vec<Sun> {
    design(harness).light.sun.clone()
}

fn undo_name(harness: &Harness<'_, App>) -> String {
    let name = harness.state().document().undo_name();
    name.unwrap_or("nothing").to_owned()
}

/// Where a sun of that azimuth and elevation stands on the sphere, which is seen from straight above.
fn place(harness: &Harness<'_, App>, azimuth: f64, elevation: f64) -> Pos2 {
    let sphere = harness.get_by_label("Lights on a sphere").rect();
    let azimuth = azimuth.to_radians();
    let across = elevation.to_radians().cos();
    let offset = vec2(azimuth.cos() as f32, -azimuth.sin() as f32) * across as f32;
    // Twelve points around the sphere are left free.
    sphere.center() + offset * (sphere.width() / 2.0 - 12.0)
}

/// A point of the screen is a degree or two on the sphere, more towards its rim.
#[track_caller]
fn stands_at(sun: &Sun, azimuth: f64, elevation: f64) {
    let off = (sun.azimuth - azimuth)
        .abs()
        .max((sun.elevation - elevation).abs());
    assert!(
        off < 1.0,
        "at {}°, {}°, not {azimuth}°, {elevation}°",
        sun.azimuth,
        sun.elevation
    );
}

#[test]
fn a_sun_is_dragged_in_one_step_and_the_request_follows() {
    let mut harness = lit();
    let before = design(&harness).clone();
    let Sun {
        azimuth, elevation, ..
    } = before.light.sun[0];
    let (from, to) = (
        place(&harness, azimuth, elevation),
        place(&harness, -60.0, 25.0),
    );
    drag(&mut harness, from, to);
    stands_at(&suns(&harness)[0], -60.0, 25.0);
    assert_eq!(requested(&harness).light.sun, suns(&harness));
    assert_eq!(undo_name(&harness), "moved sun");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*design(&harness), before);
}

#[test]
fn taking_a_sun_does_not_move_it_and_beyond_the_rim_it_stays_on_the_horizon() {
    let mut harness = lit();
    let Sun {
        azimuth, elevation, ..
    } = suns(&harness)[0];
    let at = place(&harness, azimuth, elevation) + vec2(5.0, 3.0);
    drag(&mut harness, at, at);
    assert_eq!(undo_name(&harness), "nothing");
    let outside = place(&harness, 0.0, 0.0) + vec2(40.0, 0.0);
    drag(&mut harness, at, outside);
    let sun = &suns(&harness)[0];
    assert_eq!((sun.azimuth, sun.elevation), (0.0, 0.0));
}

#[test]
fn pressing_a_dot_selects_its_sun_and_keys_move_it() {
    let mut harness = lit();
    harness.state_mut().document_mut().design.light.sun = vec![Sun::default()];
    harness.run_steps(3);
    click(&mut harness, "Add sun");
    let usual = Sun::default();
    let from = place(&harness, usual.azimuth, usual.elevation);
    let to = place(&harness, -90.0, 40.0);
    drag(&mut harness, from, to);
    // Both stood at the same place; the first of them is taken.
    let moved = suns(&harness);
    stands_at(&moved[0], -90.0, 40.0);
    assert_eq!(moved[1], Sun::default());

    harness.key_press(Key::ArrowUp);
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(3);
    let by_keys = suns(&harness);
    assert!((by_keys[0].elevation - moved[0].elevation - 5.0).abs() < 1e-9);
    assert!((by_keys[0].azimuth - moved[0].azimuth + 5.0).abs() < 1e-9);
    harness.key_press(Key::PageDown);
    harness.run_steps(1);
    harness.key_press(Key::ArrowDown);
    harness.run_steps(3);
    assert_eq!(suns(&harness)[1].elevation, Sun::default().elevation - 5.0);
    assert!(harness.query_by_label("Remove sun 2").is_some());
    assert_eq!(undo_name(&harness), "moved sun");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(suns(&harness)[1], Sun::default());
}

#[test]
fn area_lights_are_added_dragged_duplicated_and_removed() {
    let mut harness = lit();
    let before = design(&harness).clone();
    click(&mut harness, "Add area light");
    assert_eq!(design(&harness).light.area, vec![AreaLight::default()]);
    assert_eq!(undo_name(&harness), "add area light");
    assert_eq!(requested(&harness).light, design(&harness).light);
    // Its numbers are shown, and typed.
    type_number(&mut harness, "Width", "250");
    assert_eq!(design(&harness).light.area[0].width, 250.0);
    assert_eq!(undo_name(&harness), "area light width");

    let usual = AreaLight::default();
    let sun = suns(&harness)[0].clone();
    // Away from the sun first, which by default stands at the same place.
    type_number(&mut harness, "Azimuth", "-30");
    let from = place(&harness, -30.0, usual.elevation);
    let to = place(&harness, -100.0, 20.0);
    drag(&mut harness, from, to);
    let moved = design(&harness).light.area[0].clone();
    let off = (moved.azimuth + 100.0)
        .abs()
        .max((moved.elevation - 20.0).abs());
    assert!(off < 1.0, "{moved:?}");
    assert_eq!(suns(&harness), vec![sun]);
    assert_eq!(undo_name(&harness), "moved area light");

    click(&mut harness, "Duplicate area light 1");
    assert_eq!(design(&harness).light.area, vec![moved.clone(), moved]);
    click(&mut harness, "Remove area light 2");
    click(&mut harness, "Remove area light 1");
    assert!(design(&harness).light.area.is_empty());
    assert_eq!(undo_name(&harness), "remove area light");
    while undo_name(&harness) != "nothing" {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
    }
    assert_eq!(*design(&harness), before);
    click(&mut harness, "Duplicate sun 1");
    assert_eq!(suns(&harness), vec![before.light.sun[0].clone(); 2]);
}

#[test]
fn an_area_light_stands_beyond_any_cloth_it_is_added_to() {
    let mut harness = lit();
    let mut large = design(&harness).clone();
    (large.sheet.warps, large.sheet.wefts) = (4000, 2000);
    for ready in LightPreset::ALL {
        large.light = ready.applied_to(&large);
        assert_eq!(large.faults(), []);
    }
    click(&mut harness, "Add area light");
    type_number(&mut harness, "Distance", "20");
    let message = "light.area[0].distance is 20, allowed is at least";
    assert!(
        harness
            .query_all_by_label_contains(message)
            .next()
            .is_some()
    );
}

#[test]
fn every_light_preset_is_sound_and_one_step() {
    let mut harness = lit();
    let before = design(&harness).clone();
    for ready in LightPreset::ALL {
        click(&mut harness, ready.name());
        let lit = design(&harness).clone();
        assert!(lit.faults().is_empty(), "{ready:?}: {:?}", lit.faults());
        assert_eq!(lit.light, ready.applied_to(&before));
        assert_ne!(lit.light, before.light);
        assert_eq!(lit.light.background, before.light.background);
        assert_eq!(requested(&harness).light, lit.light);
        let name = format!("light: {}", ready.name().to_lowercase());
        assert_eq!(undo_name(&harness), name);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
        assert_eq!(*design(&harness), before);
    }
}
