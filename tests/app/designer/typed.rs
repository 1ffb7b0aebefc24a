//! Numbers typed into the window: other units, decimal commas, fractions; and what is not understood, which stays in its
//! field with the reason.

use egui::Event;

use super::*;

/// What a number field shows.
fn shown(harness: &Harness<'_, App>, label: &str) -> String {
    let field = harness.get_by_role_and_label(Role::SpinButton, label);
    field.accesskit_node().value().unwrap_or_default()
}

fn is_told(harness: &Harness<'_, App>, part: &str) -> bool {
    harness.query_by_label_contains(part).is_some()
}

#[test]
fn units_commas_and_fractions_are_understood() {
    let mut harness = designer(None);
    type_number(&mut harness, "Width of the cloth", "700 mm");
    let per_cm = design(&harness).sheet.warps_per_cm;
    assert_eq!(
        f64::from(design(&harness).sheet.warps),
        (70.0 * per_cm).round()
    );
    type_number(&mut harness, "Warps per cm", "25.4 /in");
    assert_eq!(design(&harness).sheet.warps_per_cm, 10.0);
    type_number(&mut harness, "Warps", "1,024");
    assert_eq!(design(&harness).sheet.warps, 1024);
    open_panel(&mut harness, "Loop length");
    for (text, mm) in [("2,5", 2.5), ("1/8\"", 3.175), ("0,4 cm", 4.0)] {
        type_number(&mut harness, "Length", text);
        assert_eq!(design(&harness).length.value, mm, "{text}");
        assert_eq!(shown(&harness, "Length"), mm.to_string(), "{text}");
    }
}

#[test]
fn what_is_not_understood_stays_with_the_reason() {
    let mut harness = designer(None);
    let before = design(&harness).clone();
    type_number(&mut harness, "Warps", "many");
    assert_eq!(*design(&harness), before);
    assert_eq!(shown(&harness, "Warps"), "many");
    assert!(is_told(&harness, "“many” is no number"));
    // It goes on being there, and the reason until something else is done.
    harness.run_steps(10);
    assert!(is_told(&harness, "“many” is no number"));
    harness.key_press(Key::Tab);
    harness.run_steps(4);
    assert!(!is_told(&harness, "“many” is no number"));
    assert_eq!(shown(&harness, "Warps"), "many");
    // Mended, it is a number again.
    type_number(&mut harness, "Warps", "77");
    assert_eq!(design(&harness).sheet.warps, 77);
    assert_eq!(shown(&harness, "Warps"), "77");

    // Given up by Escape, and by an undo.
    type_number(&mut harness, "Warps", "8 kg");
    assert!(is_told(&harness, "has the unit kg; here it is yarns"));
    harness
        .get_by_role_and_label(Role::SpinButton, "Warps")
        .click();
    harness.run_steps(2);
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert_eq!(shown(&harness, "Warps"), "77");
    type_number(&mut harness, "Warps", "x");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(4);
    assert_eq!(shown(&harness, "Warps"), before.sheet.warps.to_string());
}

#[test]
fn what_is_beyond_the_range_is_taken_as_far_as_allowed_with_a_word() {
    let mut harness = designer(None);
    open_panel(&mut harness, "Loop length");
    type_number(&mut harness, "Length", "70 cm");
    assert_eq!(design(&harness).length.value, 100.0);
    assert!(is_told(
        &harness,
        "“70 cm” is beyond what is allowed: 0 to 100 mm"
    ));
    harness.key_press(Key::Tab);
    harness.run_steps(4);
    assert!(!is_told(&harness, "beyond what is allowed"));
}

#[test]
fn escape_takes_back_what_is_being_typed() {
    let mut harness = designer(None);
    let before = design(&harness).clone();
    harness
        .get_by_role_and_label(Role::SpinButton, "Warps")
        .click();
    harness.run_steps(2);
    harness.event(Event::Text("99".into()));
    harness.run_steps(2);
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert_eq!(*design(&harness), before);
}

#[test]
fn looking_at_a_number_changes_nothing() {
    let mut harness = designer(None);
    let before = design(&harness).clone();
    harness
        .get_by_role_and_label(Role::SpinButton, "Width of the cloth")
        .click();
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(
        *design(&harness),
        before,
        "shown are fewer digits than there are"
    );
    assert!(!is_told(&harness, "beyond"));
}
