//! What lies on a chart, by mouse and keys: stripes, shapes, letters, pasted pictures; each gesture a step of the
//! history; kept in the file until it is flattened.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Color32, ColorImage, Event, Key, Modifiers, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use renderer_core::design::chart_objects::ChartCanvas;
use renderer_core::design::{ChartImage, ChartObject, Colour, ObjectKind};
use renderer_core::scene::ChartComposer;
use towel_designer::designer::App;
use towel_designer::files;

use super::chart::{drop_file, on_canvas, undo, undo_name, write};
use super::{click, design, designer_of_size, requested, type_number, type_path, wait};

fn objects<'h>(harness: &'h Harness<'_, App>) -> &'h [ChartObject] {
    &design(harness).chart.object
}

/// Place on the screen of a place on the chart, mm from its middle; the chart is seen whole.
fn at(harness: &Harness<'_, App>, place: [f64; 2]) -> Pos2 {
    let design = design(harness);
    let canvas = ChartCanvas::of(&design.chart, &design.sheet);
    let [x, y] = canvas.pixel_at(place);
    on_canvas(harness, x as f32 - 0.5, y as f32 - 0.5)
}

fn drag(harness: &mut Harness<'_, App>, from: [f64; 2], to: [f64; 2]) {
    let [from, to] = [from, to].map(|place| at(harness, place));
    drag_points(harness, from, to);
}

fn drag_points(harness: &mut Harness<'_, App>, from: Pos2, to: Pos2) {
    harness.hover_at(from);
    harness.run_steps(1);
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(from + (to - from) * 0.5);
    harness.run_steps(1);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(3);
}

/// A pasted picture of 40 × 20 pixels: a red field in a white one.
fn paste_logo(harness: &mut Harness<'_, App>) {
    let red = Color32::from_rgb(200, 30, 30);
    let inside = |k: usize| (8..32).contains(&(k % 40)) && (4..16).contains(&(k / 40));
    let pixels = (0..800).map(|k| if inside(k) { red } else { Color32::WHITE });
    let image = ColorImage::new([40, 20], pixels.collect());
    harness.event(Event::PasteImage(Arc::new(image)));
    harness.run_steps(4);
}

/// A designer with the chart editor open on a new chart, with a pixel for each of 120 × 140 crossings, cloth of
/// 90.2 × 94.6 mm.
fn with_new_chart() -> Harness<'static, App> {
    let mut harness = designer_of_size(None, vec2(1600.0, 1000.0));
    click(&mut harness, "Edit chart");
    harness.run_steps(2);
    click(&mut harness, "New chart of 120 × 140 px");
    harness.run_steps(2);
    harness
}

fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 1.5
}

#[test]
fn a_striped_towel_with_a_logo_is_put_together_by_mouse_and_keys() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_new_chart();
    // A stripe of 8 mm near the far edge, by the tool; then three of them, mirrored at the near edge.
    click(&mut harness, "Stripe across");
    drag(&mut harness, [0.0, 26.0], [10.0, 34.0]);
    assert_eq!(objects(&harness).len(), 1);
    assert_eq!(undo_name(&harness), "add stripe across");
    let stripe = &objects(&harness)[0];
    assert_eq!(stripe.kind, ObjectKind::StripeAcross);
    assert!(
        near(stripe.y, 30.0) && near(stripe.height, 8.0),
        "{stripe:?}"
    );
    type_number(&mut harness, "Object height", "3 mm");
    type_number(&mut harness, "Object from near edge", "8 cm");
    type_number(&mut harness, "Object repeats along", "3");
    type_number(&mut harness, "Object step along", "6");
    click(&mut harness, "mirrored near–far");
    let stripe = &objects(&harness)[0];
    assert_eq!(
        (stripe.height, stripe.repeat_y, stripe.step_y),
        (3.0, 3, 6.0)
    );
    assert!(near(stripe.y, 80.0 - 47.3) && stripe.reflect_y);

    // The logo is pasted: an object, not another chart; undistorted, a pixel a loop, in the middle and chosen.
    let before = design(&harness).chart.pixels.clone();
    paste_logo(&mut harness);
    assert_eq!(design(&harness).chart.pixels, before);
    assert_eq!(undo_name(&harness), "picture on the chart");
    let logo = objects(&harness)[1].clone();
    assert_eq!((logo.kind, logo.x, logo.y), (ObjectKind::Image, 0.0, 0.0));
    assert!((logo.width / logo.height - 2.0).abs() < 0.02, "{logo:?}");
    // Dragged a little off the middle it snaps back to it, one way.
    drag(&mut harness, [0.0, 0.0], [0.3, -15.0]);
    let moved = objects(&harness)[1].clone();
    assert_eq!(moved.x, 0.0, "snapped");
    assert!(near(moved.y, -15.0), "{moved:?}");
    assert_eq!(undo_name(&harness), "move image");
    // A corner scales it and keeps its proportion; its white ground is taken out.
    let corner = [0.5 * moved.width, moved.y + 0.5 * moved.height];
    drag(&mut harness, corner, [corner[0] + 6.0, corner[1] + 3.0]);
    let scaled = objects(&harness)[1].clone();
    assert!(scaled.width > moved.width + 3.0, "{scaled:?}");
    assert!(
        (scaled.width / scaled.height - 2.0).abs() < 0.05,
        "{scaled:?}"
    );
    click(&mut harness, "Transparent colour");
    assert_eq!(objects(&harness)[1].transparent, Some(Colour::WHITE));
    click(&mut harness, "Centre object across");

    // The cloth follows, all of it: three stripes twice, and the logo without its ground.
    harness.run_steps(3);
    let design_now = design(&harness).clone();
    assert_eq!(requested(&harness).chart, design_now.chart);
    let woven = ChartComposer::default().chart(&design_now).pixels.unwrap();
    let rows: Vec<usize> = (0..140)
        .filter(|row| woven.pixel(1, *row) != [255; 4])
        .collect();
    let runs = rows
        .iter()
        .filter(|row| !rows.contains(&(**row + 1)))
        .count();
    assert_eq!(runs, 6, "{rows:?}");
    let reds = (0..120 * 140).filter(|k| woven.pixel(k % 120, k / 120) == [200, 30, 30, 255]);
    assert!(reds.count() > 100);

    // Saved, it opens with everything still editable; the pasted picture lies beside it.
    let preset = folder.path().join("striped.toml");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(3);
    type_path(&mut harness, &preset);
    click(&mut harness, "Save file");
    wait(&mut harness, "the preset", |_| preset.exists());
    let opened = files::load_design(&preset).unwrap();
    assert_eq!(
        opened.chart.object[1].image.as_deref(),
        Some("striped-object-2.png")
    );
    assert_eq!(
        opened.chart.object[1].pixels,
        design_now.chart.object[1].pixels
    );
    assert_eq!(
        ChartComposer::default().chart(&opened).pixels,
        Some(woven.clone())
    );
    let mut again = designer_of_size(Some(preset.clone()), vec2(1280.0, 720.0));
    wait(&mut again, "the preset", |h| {
        h.state().document().path().is_some()
    });
    assert_eq!(
        objects(&again),
        objects(&harness),
        "the picture is the design's own again"
    );

    // Flattened, what was seen is painted; undone, it is not.
    click(&mut harness, "Flatten all");
    assert_eq!(objects(&harness), []);
    assert_eq!(design(&harness).chart.pixels, Some(woven));
    assert_eq!(undo_name(&harness), "flatten all objects");
    undo(&mut harness);
    assert_eq!(design(&harness).chart, design_now.chart);
    while !objects(&harness).is_empty() {
        undo(&mut harness);
    }
    assert_eq!(undo_name(&harness), "new chart");
}

#[test]
fn shapes_are_drawn_turned_nudged_and_removed() {
    let mut harness = with_new_chart();
    harness
        .get_by_role_and_label(Role::Canvas, "Chart canvas")
        .focus();
    harness.run_steps(1);
    harness.key_press(Key::E);
    harness.run_steps(2);
    // With Shift a circle on the cloth.
    let [from, to] = [[-20.0, 10.0], [0.0, 25.0]].map(|place| at(&harness, place));
    harness.event(Event::ModifiersChanged(Modifiers::SHIFT));
    drag_points(&mut harness, from, to);
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    let circle = objects(&harness)[0].clone();
    assert_eq!(circle.kind, ObjectKind::Ellipse);
    assert_eq!(circle.width, circle.height);
    assert!(near(circle.width, 20.0), "{circle:?}");
    let woven = ChartComposer::default()
        .chart(design(&harness))
        .pixels
        .unwrap();
    let paint = woven.pixel(60 - 13, 70 - 30);
    assert_ne!(paint, [255; 4]);
    // Arrows move it by a crossing, with Shift by ten.
    let pitch = design(&harness).sheet.pitch_x();
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    assert!((objects(&harness)[0].x - circle.x - pitch).abs() < 1e-9);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
    harness.run_steps(2);
    assert!((objects(&harness)[0].x - circle.x + 9.0 * pitch).abs() < 1e-9);
    type_number(&mut harness, "Object rotation", "45°");
    assert_eq!(objects(&harness)[0].rotation, 45.0);
    assert_eq!(undo_name(&harness), "turn ellipse");
    type_number(&mut harness, "Object width in ends", "40");
    assert!((objects(&harness)[0].width - 40.0 * pitch).abs() < 1e-9);
    // Another yarn for it.
    let red = Colour([200, 30, 30]);
    harness.state_mut().document_mut().design.chart.object[0].colour = red;
    harness.run_steps(3);

    harness
        .get_by_role_and_label(Role::Canvas, "Chart canvas")
        .focus();
    harness.run_steps(1);
    harness.key_press(Key::Delete);
    harness.run_steps(3);
    assert_eq!(objects(&harness), []);
    assert_eq!(undo_name(&harness), "remove ellipse");
    undo(&mut harness);
    assert_eq!(objects(&harness)[0].colour, red);
    // Escape gives a gesture up.
    let [from, to] = [[-20.0, 20.0], [20.0, -20.0]].map(|place| at(&harness, place));
    let before = objects(&harness).to_vec();
    click(&mut harness, "Rectangle object");
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    assert_eq!(objects(&harness).len(), 2);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(2);
    assert_eq!(objects(&harness), before);
}

#[test]
fn letters_are_written_in_any_font_and_kept_as_outlines() {
    let mut harness = with_new_chart();
    click(&mut harness, "Text object");
    drag(&mut harness, [-30.0, -10.0], [0.0, 10.0]);
    let text = objects(&harness)[0].clone();
    assert_eq!(
        (text.kind, text.text.as_deref()),
        (ObjectKind::Text, Some("Text"))
    );
    assert!(
        near(text.height, 20.0) && text.width > text.height,
        "{text:?}"
    );
    harness
        .get_by_role_and_label(Role::MultilineTextInput, "Text")
        .focus();
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text("Spa".into()));
    harness.run_steps(3);
    let written = objects(&harness)[0].clone();
    assert_eq!(written.text.as_deref(), Some("Spa"));
    assert!(written.width < text.width && written.height == text.height);
    assert_ne!(written.outline, text.outline);
    assert_eq!(
        written.font.as_deref(),
        Some(towel_designer::lettering::OWN_FONT)
    );
    // What cannot be drawn is told, and the letters that there were stay.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.key_press(Key::Backspace);
    harness.run_steps(3);
    assert_eq!(objects(&harness)[0].outline, written.outline);
    assert!(
        harness
            .query_by_label_contains("there is nothing to draw")
            .is_some()
    );
}

#[test]
fn guides_come_out_of_rulers_and_go_beside_the_chart() {
    let mut harness = with_new_chart();
    click(&mut harness, "Select objects");
    let ruler = harness.get_by_label("Upper ruler").rect().center();
    let to = at(&harness, [20.0, 12.0]);
    drag_points(&mut harness, ruler, to);
    let guides = design(&harness).chart.guides_y.clone();
    assert!(guides.len() == 1 && near(guides[0], 12.0), "{guides:?}");
    assert_eq!(undo_name(&harness), "guide");
    // A rectangle's edge snaps to it.
    click(&mut harness, "Rectangle object");
    drag(&mut harness, [-20.0, -10.0], [10.0, 11.5]);
    let rectangle = &objects(&harness)[0];
    assert!(
        (rectangle.y + 0.5 * rectangle.height - guides[0]).abs() < 0.06,
        "{rectangle:?}"
    );
    // Dragged off the canvas it is gone.
    let guide = at(&harness, [30.0, guides[0]]);
    drag_points(&mut harness, guide, ruler);
    assert_eq!(design(&harness).chart.guides_y, Vec::<f64>::new());
}

#[test]
fn a_dropped_picture_lies_on_the_chart_and_can_become_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_new_chart();
    let path = folder.path().join("logo.png");
    let logo =
        ChartImage::from_fn(6, 4, |x, _| if x < 3 { [9, 99, 9, 255] } else { [0; 4] }).unwrap();
    write(&logo, &path);
    drop_file(&mut harness, &path);
    wait(&mut harness, "the picture", |h| !objects(h).is_empty());
    harness.run_steps(3);
    let object = objects(&harness)[0].clone();
    assert_eq!(object.pixels, Some(logo.clone()));
    assert_eq!(object.image.as_deref(), Some(&*path.to_string_lossy()));
    click(&mut harness, "Duplicate object");
    assert_eq!(objects(&harness).len(), 2);
    click(&mut harness, "Use as chart");
    harness.run_steps(2);
    let chart = &design(&harness).chart;
    assert_eq!((chart.object.len(), &chart.pixels), (1, &Some(logo)));
    assert!(chart.image.is_some());
}
