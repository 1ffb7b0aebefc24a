//! The chart by mouse and keys: painted, cut, turned, scaled, reduced to yarns, recoloured, placed, pasted, saved; each
//! gesture one step of the history with its name.
//!
//! Longer than most files because one canvas is worked: its gestures share their charts and helpers.

use std::path::Path;
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Color32, ColorImage, Event, Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use renderer_core::design::chart_edit::{BARE, crop, replace_yarn, rotate_right};
use renderer_core::design::chart_objects::ChartCanvas;
use renderer_core::design::{ChartImage, Design, Fit, LengthMap};
use towel_designer::designer::App;
use towel_designer::files;

use crate::support::picture_files::{bmp, jpeg_of_blocks};

use super::{
    Dropped, choose, click, design, designer, designer_of_size, first_button, in_frames,
    open_panel, requested, type_number, type_path, wait,
};

const RED: [u8; 4] = [200, 30, 30, 255];
const CREAM: [u8; 4] = [250, 250, 240, 255];
const NAVY: [u8; 4] = [20, 30, 90, 255];

/// An image of 8 × 4 pixels, its left half red.
fn two_yarns() -> ChartImage {
    ChartImage::from_fn(8, 4, |x, _| if x < 4 { RED } else { CREAM }).unwrap()
}

pub(super) fn write(image: &ChartImage, path: &Path) {
    let png = renderer_core::image::encode_chart_png(image, &[]).unwrap();
    std::fs::write(path, png).unwrap();
}

fn pixels(harness: &Harness<'_, App>) -> ChartImage {
    design(harness).chart.pixels.clone().expect("a chart")
}

pub(super) fn undo_name(harness: &Harness<'_, App>) -> String {
    let name = harness.state().document().undo_name();
    name.unwrap_or_default().to_owned()
}

pub(super) fn undo(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
}

/// A designer with an image dropped on it.
fn with_chart(image: &ChartImage, folder: &Path, size: Vec2) -> Harness<'static, App> {
    let path = folder.join("logo.png");
    write(image, &path);
    let mut harness = designer_of_size(None, size);
    drop_file(&mut harness, &path);
    wait(&mut harness, "the chart", |h| {
        design(h).chart.pixels.is_some()
    });
    harness.run_steps(3);
    harness
}

pub(super) fn drop_file(harness: &mut Harness<'_, App>, path: &Path) {
    let dropped = Arc::new(Dropped(path.to_owned()));
    harness.input_mut().dropped_files.push(dropped);
}

/// As [`with_chart`], with the chart editor open.
fn with_editor(image: &ChartImage, folder: &Path) -> Harness<'static, App> {
    let mut harness = with_chart(image, folder, vec2(1600.0, 1000.0));
    click(&mut harness, "Edit chart");
    harness.run_steps(3);
    harness
}

/// Place on the screen of the middle of a pixel, of a chart that is seen whole.
pub(super) fn on_canvas(harness: &Harness<'_, App>, x: f32, y: f32) -> Pos2 {
    let rect = harness
        .get_by_role_and_label(Role::Canvas, "Chart canvas")
        .rect();
    let Design { chart, sheet, .. } = design(harness);
    let canvas = ChartCanvas::of(chart, sheet);
    let size = canvas.size.map(|side| side as f32);
    let size = vec2(size[0], size[1]);
    // Pixels are as wide and high as on the cloth.
    let [width, height] = canvas.pixel_mm.map(|side| side as f32);
    let shape = vec2(width, height) / (width * height).sqrt();
    let scale = ((rect.size() - Vec2::splat(16.0)) / (size * shape))
        .min_elem()
        .clamp(0.02, 32.0);
    rect.center() + (vec2(x + 0.5, y + 0.5) - size / 2.0) * scale * shape
}

fn drag(harness: &mut Harness<'_, App>, from: [f32; 2], to: [f32; 2]) {
    let [from, to] = [from, to].map(|[x, y]| on_canvas(harness, x, y));
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(from + (to - from) * 0.5);
    harness.run_steps(1);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(3);
}

/// Waits until a change of the whole chart is worked out.
#[track_caller]
fn wait_for(harness: &mut Harness<'_, App>, expected: &ChartImage) {
    wait(harness, "the changed chart", |h| pixels(h) == *expected);
    harness.run_steps(3);
}

#[test]
fn painting_is_one_step_a_stroke_and_makes_the_chart_the_designs_own() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_editor(&two_yarns(), folder.path());
    let imported = design(&harness).chart.clone();
    assert!(imported.image.is_some());

    // What is there is picked with the other button.
    let at = on_canvas(&harness, 6.0, 1.0);
    harness.event(Event::PointerMoved(at));
    for pressed in [true, false] {
        harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Secondary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(2);
    }
    assert_eq!(design(&harness).chart, imported, "picking changes nothing");

    drag(&mut harness, [0.0, 1.0], [3.0, 1.0]);
    let mut expected = two_yarns();
    expected.fill_row(1, 0..4, CREAM);
    assert_eq!(pixels(&harness), expected);
    assert_eq!(requested(&harness).chart.pixels, Some(expected));
    assert_eq!(design(&harness).chart.image, None);
    assert_eq!(undo_name(&harness), "painted chart");
    undo(&mut harness);
    assert_eq!(design(&harness).chart, imported);

    // Painting with the colour that is there changes nothing, and the chart stays the imported one.
    drag(&mut harness, [5.0, 1.0], [6.0, 2.0]);
    assert_eq!(design(&harness).chart, imported);
    assert_eq!(undo_name(&harness), "open chart");
}

#[test]
fn a_stroke_within_few_frames_is_painted_where_the_pointer_went() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_editor(&two_yarns(), folder.path());
    let at = |x: f32, y: f32| on_canvas(&harness, x, y);
    // Down the left edge and along the lower one, with a corner that no frame ends at.
    let (start, corner, end) = (at(0.0, 0.0), at(0.0, 3.0), at(2.0, 3.0));
    let (pick, away) = (at(6.0, 1.0), at(7.0, 0.0));
    let alt = |pressed| Event::PointerButton {
        pos: pick,
        button: PointerButton::Secondary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    in_frames(
        &mut harness,
        vec![
            vec![Event::PointerMoved(pick), alt(true)],
            vec![alt(false)],
            vec![Event::PointerMoved(away), Event::PointerMoved(start)],
            vec![first_button(start, true), Event::PointerMoved(corner)],
            vec![
                Event::PointerMoved(end),
                first_button(end, false),
                Event::PointerMoved(away),
            ],
        ],
    );
    let mut expected = two_yarns();
    for row in 0..4 {
        expected.fill_row(row, 0..1, CREAM);
    }
    expected.fill_row(3, 0..3, CREAM);
    assert_eq!(pixels(&harness), expected);

    // A rectangle begins where the button went down, not where the frame ended.
    undo(&mut harness);
    click(&mut harness, "Chart filled rectangle");
    in_frames(
        &mut harness,
        vec![
            vec![Event::PointerMoved(start)],
            vec![
                first_button(start, true),
                Event::PointerMoved(corner),
                Event::PointerMoved(end),
            ],
            vec![first_button(end, false), Event::PointerMoved(away)],
        ],
    );
    let mut expected = two_yarns();
    expected.fill_rectangle(0..3, 0..4, CREAM);
    assert_eq!(pixels(&harness), expected);

    // All of it within one frame.
    undo(&mut harness);
    let all = [
        Event::PointerMoved(start),
        first_button(start, true),
        Event::PointerMoved(corner),
        Event::PointerMoved(end),
        first_button(end, false),
        Event::PointerMoved(away),
    ];
    in_frames(&mut harness, vec![all.to_vec()]);
    assert_eq!(pixels(&harness), expected);
    // Nor does a press beside the canvas paint.
    undo(&mut harness);
    let beside = harness.get_by_label("Viewport").rect().center();
    let press = vec![
        Event::PointerMoved(beside),
        first_button(beside, true),
        Event::PointerMoved(start),
    ];
    in_frames(&mut harness, vec![press, vec![first_button(start, false)]]);
    assert_eq!(pixels(&harness), two_yarns());
}

#[test]
fn escape_takes_back_a_stroke_for_as_long_as_the_button_is_down() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_editor(&two_yarns(), folder.path());
    click(&mut harness, "Paint bare ground");
    let [from, to] = [[0.0, 1.0], [3.0, 1.0]].map(|[x, y]| on_canvas(&harness, x, y));
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    assert_ne!(pixels(&harness), two_yarns());
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drop_at(from);
    harness.run_steps(2);
    assert_eq!(pixels(&harness), two_yarns());
}

#[test]
fn lines_rectangles_fills_and_bare_ground_are_painted() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_editor(&two_yarns(), folder.path());
    click(&mut harness, "Paint bare ground");
    for (tool, from, to, bare) in [
        (
            "Chart line",
            [1.0, 0.0],
            [4.0, 3.0],
            vec![(1, 0), (2, 1), (3, 2), (4, 3)],
        ),
        (
            "Chart rectangle",
            [5.0, 0.0],
            [7.0, 2.0],
            vec![
                (5, 0),
                (6, 0),
                (7, 0),
                (5, 1),
                (7, 1),
                (5, 2),
                (6, 2),
                (7, 2),
            ],
        ),
        (
            "Chart filled rectangle",
            [6.0, 3.0],
            [7.0, 2.0],
            vec![(6, 2), (7, 2), (6, 3), (7, 3)],
        ),
    ] {
        click(&mut harness, tool);
        drag(&mut harness, from, to);
        let now = pixels(&harness);
        let found: Vec<(usize, usize)> = (0..32)
            .map(|k| (k % 8, k / 8))
            .filter(|&(x, y)| now.pixel(x, y) == BARE)
            .collect();
        let mut expected = bare;
        expected.sort_by_key(|&(x, y)| (y, x));
        assert_eq!(found, expected, "{tool}");
        assert_eq!(undo_name(&harness), "painted chart");
        undo(&mut harness);
        assert_eq!(pixels(&harness), two_yarns());
    }
    click(&mut harness, "Chart fill");
    drag(&mut harness, [1.0, 1.0], [1.0, 1.0]);
    let now = pixels(&harness);
    assert_eq!(now, replace_yarn(&two_yarns(), RED, BARE));
    undo(&mut harness);
    assert_eq!(pixels(&harness), two_yarns());
}

#[test]
fn the_canvas_is_worked_by_keys_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_editor(&two_yarns(), folder.path());
    click(&mut harness, "Paint bare ground");
    harness
        .get_by_role_and_label(Role::Canvas, "Chart canvas")
        .focus();
    harness.run_steps(2);
    let press = |harness: &mut Harness<'_, App>, keys: &[Key]| {
        for &key in keys {
            harness.key_press(key);
            harness.run_steps(2);
        }
    };
    press(&mut harness, &[Key::ArrowRight, Key::ArrowDown, Key::Space]);
    let mut expected = two_yarns();
    expected.fill_row(1, 1..2, BARE);
    assert_eq!(pixels(&harness), expected);
    assert_eq!(undo_name(&harness), "painted chart");
    let canvas = harness.get_by_role_and_label(Role::Canvas, "Chart canvas");
    assert_eq!(canvas.value().as_deref(), Some("pixel 1, 1: bare"));

    // A line: one end, the way, the other end.
    press(
        &mut harness,
        &[
            Key::L,
            Key::Space,
            Key::ArrowRight,
            Key::ArrowRight,
            Key::Space,
        ],
    );
    expected.fill_row(1, 1..4, BARE);
    assert_eq!(pixels(&harness), expected);
    // One that is thought better of.
    press(&mut harness, &[Key::Space, Key::ArrowDown, Key::Escape]);
    assert_eq!(pixels(&harness), expected);

    press(
        &mut harness,
        &[
            Key::C,
            Key::Space,
            Key::ArrowRight,
            Key::ArrowDown,
            Key::Space,
        ],
    );
    press(&mut harness, &[Key::Enter]);
    let cropped = crop(&expected, 3..5, 2..4).unwrap();
    wait_for(&mut harness, &cropped);
    assert_eq!(undo_name(&harness), "crop chart");
}

#[test]
fn crop_rotate_flip_and_resize_are_named_steps() {
    let folder = tempfile::tempdir().unwrap();
    let image = ChartImage::from_fn(9, 5, |x, y| [x as u8 * 20, y as u8 * 40, 7, 255]).unwrap();
    let mut harness = with_editor(&image, folder.path());
    let imported = design(&harness).chart.clone();

    click(&mut harness, "Chart crop");
    drag(&mut harness, [2.0, 1.0], [6.0, 3.0]);
    assert_eq!(design(&harness).chart, imported, "marking changes nothing");
    harness.get_by_label_contains("Crop to the marked").click();
    wait_for(&mut harness, &crop(&image, 2..7, 1..4).unwrap());
    assert_eq!(undo_name(&harness), "crop chart");
    undo(&mut harness);
    assert_eq!(design(&harness).chart, imported);

    click(&mut harness, "Rotate chart");
    wait_for(&mut harness, &rotate_right(&image));
    assert_eq!(undo_name(&harness), "rotate chart");
    undo(&mut harness);

    click(&mut harness, "Flip chart horizontally");
    wait(&mut harness, "the flipped chart", |h| {
        pixels(h).pixel(0, 0) == image.pixel(8, 0)
    });
    harness.run_steps(3);
    assert_eq!(undo_name(&harness), "flip chart");
    undo(&mut harness);

    click(&mut harness, "Size…");
    type_number(&mut harness, "Chart width", "18");
    click(&mut harness, "Resize chart");
    wait(&mut harness, "the larger chart", |h| {
        pixels(h).width() == 18
    });
    harness.run_steps(3);
    assert_eq!(pixels(&harness).height(), 10, "proportions are kept");
    assert_eq!(undo_name(&harness), "resize chart");
    undo(&mut harness);
    assert_eq!(design(&harness).chart, imported);
}

#[test]
fn an_empty_chart_has_the_sheets_size() {
    let mut harness = designer_of_size(None, vec2(1600.0, 1000.0));
    type_number(&mut harness, "Warps", "50");
    click(&mut harness, "Edit chart");
    click(&mut harness, "New chart of 50 × 140 px");
    assert_eq!(
        pixels(&harness),
        ChartImage::filled(50, 140, [255; 4]).unwrap()
    );
    assert_eq!(undo_name(&harness), "new chart");
    undo(&mut harness);
    assert_eq!(design(&harness).chart.pixels, None);
}

#[test]
fn a_photo_is_reduced_previewed_and_applied() {
    let folder = tempfile::tempdir().unwrap();
    let photo = ChartImage::from_fn(64, 48, |x, y| {
        [(x * 4) as u8, (y * 5) as u8, ((x * y) % 256) as u8, 255]
    })
    .unwrap();
    let mut harness = with_chart(&photo, folder.path(), vec2(1280.0, 1400.0));
    assert!(
        harness
            .query_by_label_contains("More than 64 colours")
            .is_some()
    );
    let imported = design(&harness).clone();

    click(&mut harness, "Reduce to yarns…");
    type_number(&mut harness, "Number of yarns", "5");
    choose(&mut harness, "Dithering", "regular pattern");
    // The cloth shows it before it is done; the design is what it was.
    let colours = |image: &ChartImage| {
        let all = (0..64 * 48).map(|k| image.pixel(k % 64, k / 64));
        all.collect::<std::collections::HashSet<_>>().len()
    };
    wait(&mut harness, "the preview", |h| {
        requested(h)
            .chart
            .pixels
            .as_ref()
            .is_some_and(|p| colours(p) == 5)
    });
    assert_eq!(*design(&harness), imported);
    assert_eq!(undo_name(&harness), "open chart");
    click(&mut harness, "Cancel the reduction");
    assert_eq!(*requested(&harness), imported);

    click(&mut harness, "Reduce to yarns…");
    wait(&mut harness, "the preview", |h| {
        requested(h)
            .chart
            .pixels
            .as_ref()
            .is_some_and(|p| colours(p) == 5)
    });
    harness.run_steps(2);
    click(&mut harness, "Apply the reduction");
    assert_eq!(colours(&pixels(&harness)), 5);
    assert_eq!(design(&harness).chart.image, None);
    assert_eq!(undo_name(&harness), "reduce to 5 yarns");
    assert!(harness.query_by_label("5 yarns").is_some());
    undo(&mut harness);
    assert_eq!(*design(&harness), imported);
}

#[test]
fn a_yarn_takes_another_colour_and_two_become_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut image = two_yarns();
    image.fill_row(0, 7..8, NAVY);
    let mut harness = with_chart(&image, folder.path(), vec2(1280.0, 2400.0));
    // Sixteen of 32 pixels are red, one is navy.
    for label in ["Yarn 1  50 %", "Yarn 2  47 %", "Yarn 3  3.1 %"] {
        assert!(
            harness
                .query_by_role_and_label(Role::Label, label)
                .is_some(),
            "{label}"
        );
    }
    let field = harness.get_by_role_and_label(Role::TextInput, "Yarn 1  50 %");
    field.focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text("#141e5a".into()));
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(pixels(&harness), replace_yarn(&image, RED, NAVY));
    assert_eq!(undo_name(&harness), "yarn colour");
    assert_eq!(requested(&harness).chart.pixels, Some(pixels(&harness)));
    undo(&mut harness);
    assert_eq!(pixels(&harness), image);

    // A row of the table of lengths goes with its yarn, so that its loops keep their length.
    open_panel(&mut harness, "Loop length");
    choose(&mut harness, "Lengths", LengthMap::Lut.label());
    let rows = |h: &Harness<'_, App>| -> Vec<[u8; 3]> {
        let table = &design(h).length.table;
        table.iter().map(|row| row.colour.0).collect()
    };
    assert_eq!(rows(&harness)[0], RED[..3]);
    let field = harness
        .get_all_by_role_and_label(Role::TextInput, "Yarn 1  50 %")
        .next();
    field.expect("a field").focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text("#00aa44".into()));
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(rows(&harness)[0], [0, 0xaa, 0x44]);
    assert_eq!(undo_name(&harness), "yarn colour");
    undo(&mut harness);
    assert_eq!(rows(&harness)[0], RED[..3]);

    click(&mut harness, "Merge yarn 3");
    click(&mut harness, "into yarn 1, #c81e1e");
    assert_eq!(pixels(&harness), replace_yarn(&image, NAVY, RED));
    assert_eq!(undo_name(&harness), "merge yarns");
    undo(&mut harness);
    assert_eq!(pixels(&harness), image);
}

#[test]
fn a_chart_is_placed_once_and_moved() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_chart(&two_yarns(), folder.path(), vec2(1280.0, 1400.0));
    choose(&mut harness, "Fit", Fit::Place.label());
    assert_eq!(requested(&harness).chart.fit, Fit::Place);
    type_number(&mut harness, "Offset x", "-12");
    type_number(&mut harness, "Offset y", "7");
    assert_eq!(undo_name(&harness), "place of the chart");
    let chart = &requested(&harness).chart;
    assert_eq!((chart.offset_x, chart.offset_y), (-12, 7));
    click(&mut harness, "Centre chart");
    assert_eq!(
        (
            design(&harness).chart.offset_x,
            design(&harness).chart.offset_y
        ),
        (0, 0)
    );
    undo(&mut harness);
    assert_eq!(design(&harness).chart.offset_x, -12);
}

#[test]
fn a_pasted_image_becomes_the_chart_and_an_empty_clipboard_says_so() {
    let mut harness = designer(None);
    let mut image = ColorImage::filled([5, 3], Color32::from_rgb(9, 8, 7));
    image[(4, 2)] = Color32::TRANSPARENT;
    harness.event(Event::PasteImage(Arc::new(image)));
    harness.run_steps(3);
    let pasted = pixels(&harness);
    assert_eq!((pasted.width(), pasted.height()), (5, 3));
    assert_eq!(
        (pasted.pixel(0, 0), pasted.pixel(4, 2)[3]),
        ([9, 8, 7, 255], 0)
    );
    assert_eq!(undo_name(&harness), "paste chart");

    // The test's clipboard never answers.
    click(&mut harness, "Paste chart");
    harness.run_steps(8);
    assert!(harness.query_by_label("Not pasted").is_some());
    assert!(harness.query_by_label_contains("holds no image").is_some());
    assert_eq!(pixels(&harness), pasted, "what was there stays");
    click(&mut harness, "Dismiss: Not pasted");

    harness.event(Event::Paste("some text".into()));
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("holds text").is_some());
    click(&mut harness, "Dismiss: Not pasted");

    let wide = ColorImage::filled([ChartImage::MAX_SIDE + 1, 1], Color32::RED);
    harness.event(Event::PasteImage(Arc::new(wide)));
    harness.run_steps(3);
    assert!(
        harness
            .query_by_label_contains("8193 × 1 pixels, allowed are")
            .is_some()
    );
    assert_eq!(pixels(&harness), pasted);
    undo(&mut harness);
    assert_eq!(design(&harness).chart.pixels, None);
}

#[test]
fn broken_and_too_large_images_are_refused_and_the_old_chart_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = with_chart(&two_yarns(), folder.path(), vec2(1280.0, 720.0));
    let before = design(&harness).clone();
    let good = std::fs::read(folder.path().join("logo.png")).unwrap();
    let large = image::RgbImage::new(8193, 2);
    large.save(folder.path().join("large.png")).unwrap();
    for (name, bytes, message) in [
        (
            "half.png",
            Some(&good[..good.len() / 2]),
            "half.png: picture on the chart: is broken",
        ),
        (
            "text.jpg",
            Some(&b"no image"[..]),
            "text.jpg: picture on the chart: is none of PNG, JPEG, WebP",
        ),
        (
            "empty.png",
            Some(&b""[..]),
            "empty.png: picture on the chart: is none of PNG",
        ),
        (
            "large.png",
            None,
            "8193 x 2 pixels, allowed are at most 8192 x 8192",
        ),
    ] {
        let path = folder.path().join(name);
        if let Some(bytes) = bytes {
            std::fs::write(&path, bytes).unwrap();
        }
        drop_file(&mut harness, &path);
        wait(&mut harness, name, |h| {
            h.query_by_label("Picture not opened").is_some()
        });
        assert!(harness.query_by_label_contains(message).is_some(), "{name}");
        assert_eq!(*design(&harness), before);
        click(&mut harness, "Dismiss: Picture not opened");
    }
}

#[test]
fn a_weavers_bmp_is_dropped_and_of_a_damaged_photo_a_warning_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = designer_of_size(None, vec2(1280.0, 720.0));
    // Two entries of one colour.
    let path = folder.path().join("dobby.BMP");
    let bmp = bmp(
        4,
        8,
        &[[200, 30, 30], [200, 30, 30], [20, 30, 90]],
        &[0, 1, 2, 2],
    );
    std::fs::write(&path, bmp).unwrap();
    drop_file(&mut harness, &path);
    wait(&mut harness, "the chart", |h| {
        design(h).chart.pixels.is_some()
    });
    let chart = pixels(&harness);
    let near_red = [200, 30, 31, 255];
    assert_eq!(
        [0, 1, 2, 3].map(|x| chart.pixel(x, 0)),
        [RED, near_red, NAVY, NAVY]
    );
    assert!(harness.query_by_label("Opened with a warning").is_none());

    let path = folder.path().join("photo.jpg");
    let jpeg = jpeg_of_blocks(&[&[90], &[200]]);
    std::fs::write(&path, &jpeg[..jpeg.len() - 2]).unwrap();
    drop_file(&mut harness, &path);
    wait(&mut harness, "the photo", |h| {
        !design(h).chart.object.is_empty()
    });
    harness.run_steps(20);
    let says = "photo.jpg: picture on the chart: ends in the middle of its picture";
    assert!(harness.query_by_label_contains(says).is_some());
    click(&mut harness, "Dismiss: Opened with a warning");
    assert!(harness.query_by_label_contains(says).is_none());
}

#[test]
fn a_painted_chart_is_saved_undone_saved_again_and_reopened() {
    let folder = tempfile::tempdir().unwrap();
    let preset = folder.path().join("towel.toml");
    let mut harness = with_editor(&two_yarns(), folder.path());
    let logo = folder.path().join("logo.png");
    let imported = std::fs::read(&logo).unwrap();
    let chart_of = |preset: &Path| files::load_design(preset).unwrap().chart;

    click(&mut harness, "Paint bare ground");
    drag(&mut harness, [0.0, 0.0], [2.0, 0.0]);
    let painted = pixels(&harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(3);
    type_path(&mut harness, &preset);
    click(&mut harness, "Save file");
    wait(&mut harness, "the preset", |_| preset.exists());
    harness.run_steps(3);
    assert!(!harness.state().document().is_unsaved());
    assert_eq!(chart_of(&preset).pixels, Some(painted.clone()));
    assert_eq!(chart_of(&preset).image.as_deref(), Some("towel-chart.png"));

    // Undone, the preset names the imported image again, which nobody has written.
    undo(&mut harness);
    assert!(harness.state().document().is_unsaved());
    let save = |harness: &mut Harness<'_, App>| {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        harness.run_steps(3);
        wait(harness, "saving", |h| !h.state().document().is_unsaved());
    };
    save(&mut harness);
    assert_eq!(chart_of(&preset).image.as_deref(), Some("logo.png"));
    assert_eq!(chart_of(&preset).pixels, Some(two_yarns()));
    assert_eq!(std::fs::read(&logo).unwrap(), imported);

    // Redone, painted further, saved; then undone to what was saved first: each time the file has what is seen.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.run_steps(3);
    drag(&mut harness, [0.0, 3.0], [5.0, 3.0]);
    let further = pixels(&harness);
    save(&mut harness);
    assert_eq!(chart_of(&preset).pixels, Some(further));
    undo(&mut harness);
    assert!(harness.state().document().is_unsaved());
    save(&mut harness);
    assert_eq!(chart_of(&preset).pixels, Some(painted.clone()));
    let files: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(files.len(), 3, "logo, preset and its one chart: {files:?}");

    let mut again = designer(Some(preset));
    wait(&mut again, "the preset", |h| {
        h.state().document().path().is_some()
    });
    assert_eq!(pixels(&again), painted);
    assert!(!again.state().document().is_unsaved());
}

#[test]
fn large_charts_are_painted_without_copying_them() {
    let folder = tempfile::tempdir().unwrap();
    let image = ChartImage::filled(4096, 4096, CREAM).unwrap();
    let mut harness = with_editor(&image, folder.path());
    drag(&mut harness, [1000.0, 1000.0], [1200.0, 1100.0]);
    let painted = pixels(&harness);
    assert_ne!(painted, image);
    // A stroke of 200 × 100 pixels reaches six tiles; one of few colours has 16 kB.
    let requested = requested(&harness).chart.pixels.clone().unwrap();
    assert!(
        requested.is(&painted),
        "the renderer has the document's own tiles"
    );
    undo(&mut harness);
    assert!(painted.bytes_beside(Some(&pixels(&harness))) < 6 * 17_000);
    assert_eq!(pixels(&harness), image);
}
