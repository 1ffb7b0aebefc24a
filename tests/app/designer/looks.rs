//! How the window looks: a picture of every panel and window, in both themes, held against the one that was looked at
//! and found good.
//!
//! `UPDATE_SNAPSHOTS=true` writes the pictures anew, beside this file; then look at them. Pictures that differ leave
//! `….new.png` and `….diff.png` there.

use egui::accesskit::Role;
use egui::{Rect, Theme, pos2, vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, SnapshotOptions, SnapshotResults, try_image_snapshot_options};
use image::RgbaImage;
use renderer_core::gpu;
use towel_designer::designer::App;
use towel_designer::designer::panels::Panels;

use super::rest;
use super::states::{self, Look};

/// How far a pixel may be off. The measure is dify's, (Δ luminance)² of about 0.5 for a step of 1/255 in gray, so this
/// is less than three such steps: two rasterisers may round a blended edge differently, by one step, and gamma makes
/// two of it in the dark. No pixel may be off more. Any change of a colour of the theme that an eye sees is more than
/// that.
fn options() -> SnapshotOptions {
    SnapshotOptions::new()
        .threshold(4.0)
        .max_failed_pixels(0)
        .output_path(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../tests/app/designer/looks"
        ))
}

/// Pictures can be drawn at all.
fn assert_adapter() {
    assert!(
        !gpu::adapters().is_empty(),
        "no GPU adapter; on Debian and Ubuntu install mesa-vulkan-drivers"
    );
}

/// The part of a picture of the window that a rectangle in points covers.
fn part(picture: &RgbaImage, rect: Rect, scale: f32) -> RgbaImage {
    let [left, top, right, bottom] = [rect.left(), rect.top(), rect.right(), rect.bottom()]
        .map(|at| (at * scale).round() as u32);
    let (right, bottom) = (right.min(picture.width()), bottom.min(picture.height()));
    image::imageops::crop_imm(picture, left, top, right - left, bottom - top).to_image()
}

/// Makes a part of a picture black.
fn blot_out(picture: &mut RgbaImage, rect: Rect, scale: f32) {
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        if rect.contains(pos2(x as f32 + 0.5, y as f32 + 0.5) / scale) {
            *pixel = image::Rgba([0, 0, 0, 255]);
        }
    }
}

/// Where the first panels are, each from its heading to the next one's.
fn places(harness: &Harness<'_, App>, count: usize) -> Vec<(&'static str, Rect)> {
    let heading = |title| {
        harness
            .get_by_role_and_label(Role::DisclosureTriangle, title)
            .rect()
    };
    let titles: Vec<&str> = Panels::titles().collect();
    let below = || harness.get_by_label("Sampler").rect().bottom() + 40.0;
    let right = harness.get_by_label("Viewport").rect().left();
    (0..count)
        .map(|index| {
            let top = heading(titles[index]).top() - 6.0;
            let bottom = titles
                .get(index + 1)
                .map_or_else(below, |next| heading(next).top() - 8.0);
            let rect = Rect::from_min_max(pos2(0.0, top), pos2(right, bottom));
            (titles[index], rect)
        })
        .collect()
}

fn file_name(theme: Theme, scale: f32, name: &str) -> String {
    let theme = if theme == Theme::Dark {
        "dark"
    } else {
        "light"
    };
    let name = name.to_lowercase().replace(" & ", " ").replace(' ', "-");
    format!("{name}-{theme}-{:.0}", 100.0 * scale)
}

#[test]
fn panels_look_as_they_were_found_good() {
    assert_adapter();
    let mut results = SnapshotResults::new();
    // At twice the size text and lines are other pixels, layout is not: one panel tells.
    for (theme, scale, titles) in [
        (Theme::Dark, 1.0, 8),
        (Theme::Light, 1.0, 8),
        (Theme::Light, 2.0, 1),
    ] {
        // Not more pixels than a texture has on any adapter.
        let size = vec2(900.0, states::TALL / scale);
        let (mut harness, _home) = states::start(Look { theme, scale, size });
        if titles > 1 {
            states::open_everything(&mut harness);
        }
        let mut picture = harness.render().expect("a picture of the window");
        // It comes when it is drawn, and is a picture of a loop, not of the panel.
        if let Some(drawn) = harness.query_by_label("One loop") {
            blot_out(&mut picture, drawn.rect(), scale);
        }
        for (title, place) in places(&harness, titles) {
            let seen = part(&picture, place, scale);
            let name = file_name(theme, scale, title);
            results.add(try_image_snapshot_options(&seen, name, &options()));
        }
    }
}

/// Of the window, what is the same at every start: without the status bar and the note above it, which tell how long
/// rendering took, and without the presets' pictures, which come when they are done.
const SAME: Rect = Rect {
    min: pos2(0.0, 0.0),
    max: pos2(1066.0, 650.0),
};

#[test]
fn windows_look_as_they_were_found_good() {
    assert_adapter();
    let mut results = SnapshotResults::new();
    let in_light = [
        "menu View",
        "menu Display",
        "message",
        "ready patterns",
        "question",
        "size of the screen",
        "chart objects",
        "new design",
    ];
    let in_dark = [
        "help",
        "export",
        "weave editor",
        "chart editor",
        "saved views",
    ];
    for (theme, names) in [(Theme::Light, &in_light[..]), (Theme::Dark, &in_dark)] {
        for name in names {
            let (scale, size) = (1.0, vec2(1280.0, 720.0));
            let (mut harness, _home) = states::start(Look { theme, scale, size });
            states::wait_for_picture(&mut harness);
            states::reach(&mut harness, name);
            states::wait_for_picture(&mut harness);
            harness.event(egui::Event::PointerGone);
            // What is seen on the way to a picture is another one; but how long an export takes is not always the same.
            match *name {
                "export" => harness.run_steps(20),
                _ => rest(&mut harness),
            }
            let picture = harness.render().expect("a picture of the window");
            let seen = part(&picture, SAME, scale);
            let name = file_name(theme, scale, name);
            results.add(try_image_snapshot_options(&seen, name, &options()));
        }
    }
}

#[test]
fn pictures_that_differ_are_told_apart() {
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let gray = |x: u32, y: u32| 100 + (x * y % 50) as u8;
    let draw = |by: u32, lighter: u8| {
        RgbaImage::from_fn(40, 30, |x, y| {
            let one = if (x, y) == (20, 10) { lighter } else { 0 };
            let level = gray(x + by, y) + one;
            image::Rgba([level, level, level, 255])
        })
    };
    draw(0, 0)
        .save(folder.path().join("drawn.png"))
        .expect("saved");
    let options = options().output_path(folder.path());
    let same = |picture: &RgbaImage| try_image_snapshot_options(picture, "drawn", &options).is_ok();
    assert!(same(&draw(0, 0)));
    assert!(same(&draw(0, 2)), "rounding of a rasteriser");
    assert!(!same(&draw(0, 4)), "one pixel, four steps lighter");
    assert!(!same(&draw(1, 0)), "a pixel to the side");
}
