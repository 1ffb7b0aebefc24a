//! The table of yarns: names, pile heights, kinds and materials beside colours and shares; and the colour picker.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use renderer_core::design::{ChartImage, Colour, LengthMap, PileKind};
use towel_designer::designer::App;
use towel_designer::designer::colour_space::{
    hex_of, lab_of, lab_of_lch, lch_of_lab, rgb_of_hex, rgb_of_lch,
};

use super::chart::{drop_file, undo, undo_name, write};
use super::{choose, click, design, designer_of_size, type_number, wait};

const RED: [u8; 4] = [200, 30, 30, 255];
const CREAM: [u8; 4] = [250, 250, 240, 255];

/// A designer with a chart of 24 red pixels and 8 of cream.
fn with_yarns() -> (Harness<'static, App>, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.png");
    let image = ChartImage::from_fn(8, 4, |x, _| if x < 6 { RED } else { CREAM });
    write(&image.unwrap(), &path);
    let mut harness = designer_of_size(None, vec2(1280.0, 2400.0));
    drop_file(&mut harness, &path);
    wait(&mut harness, "the chart", |h| {
        design(h).chart.pixels.is_some()
    });
    harness.run_steps(3);
    (harness, folder)
}

fn type_text(harness: &mut Harness<'_, App>, label: &str, text: &str, key: Key) {
    harness
        .get_by_role_and_label(Role::TextInput, label)
        .focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text(text.into()));
    harness.run_steps(2);
    harness.key_press(key);
    harness.run_steps(3);
}

#[test]
fn each_yarn_has_a_name_a_height_a_kind_and_a_material_in_one_place() {
    let (mut harness, _folder) = with_yarns();
    let colours = [RED, CREAM].map(|[r, g, b, _]| Colour([r, g, b]));
    type_text(&mut harness, "Name of yarn 1", "Poppy 12", Key::Enter);
    assert_eq!(design(&harness).chart.name_of(colours[0]), Some("Poppy 12"));
    assert_eq!(undo_name(&harness), "yarn name");

    // One height for all becomes one for each.
    let common = design(&harness).length.value;
    type_number(&mut harness, "Pile height of yarn 2", "4.5");
    let length = design(&harness).length.clone();
    assert_eq!(length.map, LengthMap::Lut);
    let rows: Vec<_> = length
        .table
        .iter()
        .map(|row| (row.colour, row.length))
        .collect();
    assert_eq!(rows, [(colours[0], common), (colours[1], 4.5)]);
    assert_eq!(undo_name(&harness), "pile of a yarn");
    choose(&mut harness, "Kind of yarn 1", PileKind::Cut.label());
    assert_eq!(design(&harness).length.table[0].kind, Some(PileKind::Cut));
    click(&mut harness, "Material of yarn 1");
    type_number(&mut harness, "Brightness", "0.5");
    assert_eq!(design(&harness).length.table[0].albedo_scale, 0.5);

    // Name and row go with a yarn that takes another colour.
    type_text(&mut harness, "Yarn 1  75 %", "#00aa44", Key::Enter);
    let green = Colour([0, 0xaa, 0x44]);
    assert_eq!(design(&harness).chart.name_of(green), Some("Poppy 12"));
    assert_eq!(design(&harness).length.table[0].colour, green);
    for _ in 0..5 {
        undo(&mut harness);
    }
    assert_eq!(undo_name(&harness), "open chart");
    assert_eq!(
        (&*design(&harness).chart.yarn, design(&harness).length.map),
        (&[][..], LengthMap::Constant)
    );
}

#[test]
fn what_is_no_colour_stays_in_its_field_until_it_is_mended() {
    let (mut harness, _folder) = with_yarns();
    let before = design(&harness).clone();
    type_text(&mut harness, "Yarn 1  75 %", "#12345", Key::Enter);
    let shown = |h: &Harness<'_, App>| {
        let field = h.get_by_role_and_label(Role::TextInput, "Yarn 1  75 %");
        field.accesskit_node().value().unwrap_or_default()
    };
    assert_eq!(shown(&harness), "#12345");
    assert_eq!(*design(&harness), before);
    type_text(&mut harness, "Yarn 1  75 %", "1F3A6E", Key::Enter);
    assert_eq!(shown(&harness), "#1f3a6e");
    assert_ne!(*design(&harness), before);
    undo(&mut harness);
    type_text(&mut harness, "Yarn 1  75 %", "green", Key::Escape);
    assert_eq!(shown(&harness), "#c81e1e", "given up");
}

#[test]
fn the_picker_has_lightness_chroma_and_hue() {
    let (mut harness, _folder) = with_yarns();
    harness
        .get_by_role_and_label(Role::Button, "Yarn 1  75 %")
        .click();
    harness.run_steps(4);
    let [l, chroma, hue] = lch_of_lab(lab_of([200, 30, 30]));
    type_number(&mut harness, "Hue h", "150");
    let turned = design(&harness).chart.pixels.clone().unwrap().pixel(0, 0);
    let seen = lch_of_lab(lab_of([turned[0], turned[1], turned[2]]));
    assert!(
        (seen[0] - l).abs() < 1.0 && (seen[2] - 150.0).abs() < 3.0,
        "{seen:?}"
    );
    assert!(
        hue < 60.0 && seen[1] < chroma,
        "a screen shows less green than red"
    );
    assert_eq!(undo_name(&harness), "yarn colour");
}

#[test]
fn lab_is_that_of_the_white_of_srgb() {
    // Bruce Lindbloom's calculator: sRGB, D65, no adaptation.
    for (rgb, lab) in [
        ([255, 255, 255], [100.0, 0.0, 0.0]),
        ([0, 0, 0], [0.0, 0.0, 0.0]),
        ([255, 0, 0], [53.24, 80.09, 67.20]),
        ([0, 255, 0], [87.73, -86.18, 83.18]),
        ([0, 0, 255], [32.30, 79.19, -107.86]),
        ([119, 119, 119], [50.03, 0.0, 0.0]),
    ] {
        let found = lab_of(rgb);
        assert!(
            (0..3).all(|k| (found[k] - lab[k]).abs() < 0.02),
            "{rgb:?}: {found:?}"
        );
    }
    for k in 0..512_u32 {
        let rgb = [k % 8, k / 8 % 8, k / 64].map(|part| (part * 36) as u8);
        let lch = lch_of_lab(lab_of(rgb));
        assert_eq!(rgb_of_lch(lch), (rgb, true), "{rgb:?}");
        assert_eq!(rgb_of_hex(&hex_of(rgb)), Some(rgb));
    }
    let (clipped, is_all) = rgb_of_lch([60.0, 130.0, 150.0]);
    let seen = lch_of_lab(lab_of(clipped));
    assert!(
        !is_all && (seen[0] - 60.0).abs() < 1.0 && (seen[2] - 150.0).abs() < 2.0,
        "{seen:?}"
    );
    assert!((lab_of_lch([50.0, 10.0, 90.0])[2] - 10.0).abs() < 1e-9);
    for text in ["", "#12", "#12345", "#gggggg", "1234567", "ＦＦＦ"] {
        assert_eq!(rgb_of_hex(text), None, "{text}");
    }
    assert_eq!(rgb_of_hex(" #Fa0 "), Some([255, 170, 0]));
}
