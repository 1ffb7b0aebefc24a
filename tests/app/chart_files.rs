//! Charts that were painted here and their files beside presets: written first, found again, never somebody else's.

use std::fs;
use std::path::{Path, PathBuf};

use renderer_core::design::chart_edit::draw_line;
use renderer_core::design::{ChartImage, Design};
use towel_designer::files::{self, Carried, Outside, OwnImages};

use crate::support::folders::names_in;

const NAVY: [u8; 4] = [20, 30, 90, 255];

fn painted(colour: [u8; 4]) -> Design {
    let mut design = Design::default();
    let mut pixels = ChartImage::filled(40, 30, [255; 4]).unwrap();
    draw_line(&mut pixels, [3, 4], [30, 20], 2, colour);
    design.chart.pixels = Some(pixels);
    design
}

fn save(design: &Design, to: &Path, known: &OwnImages) -> OwnImages {
    files::save_edited(design, &Carried::default(), to, None, known).expect("saved")
}

/// What a preset shows when it is opened.
fn chart_of(preset: &Path) -> ChartImage {
    let design = files::load_design(preset).expect("a preset");
    design.chart.pixels.expect("a chart")
}

#[test]
fn a_painted_chart_is_written_beside_its_preset_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let preset = folder.path().join("Möwe.toml");
    let design = painted(NAVY);
    let own = save(&design, &preset, &OwnImages::default());
    assert_eq!(names_in(folder.path()), ["Möwe-chart.png", "Möwe.toml"]);
    assert_eq!(Some(chart_of(&preset)), design.chart.pixels);
    let text = fs::read_to_string(&preset).unwrap();
    assert!(text.contains("\"Möwe-chart.png\""), "{text}");

    // Opened to be edited it is the design's own again, so that no state of the history depends on the file.
    let (opened, again) = files::open_to_edit(&preset, Outside::Open).unwrap();
    assert_eq!(opened.design.chart.image, None);
    assert_eq!(opened.design, design);

    // Saved again without painting, the chart is not even written.
    let chart = folder.path().join("Möwe-chart.png");
    let before = fs::metadata(&chart).unwrap().modified().unwrap();
    for known in [own, again] {
        let mut other = design.clone();
        other.sheet.warps = 99;
        save(&other, &preset, &known);
        assert_eq!(fs::metadata(&chart).unwrap().modified().unwrap(), before);
    }
    let mut repainted = painted([200, 30, 30, 255]);
    repainted.chart.colour.0 = [1, 2, 3];
    let known = files::open_to_edit(&preset, Outside::Open).unwrap().1;
    save(&repainted, &preset, &known);
    assert_eq!(
        names_in(folder.path()).len(),
        2,
        "its own file is written again"
    );
    assert_eq!(Some(chart_of(&preset)), repainted.chart.pixels);
}

#[test]
fn no_file_of_others_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    // Somebody's image happens to have the name.
    fs::write(at("a-chart.png"), "mine").unwrap();
    save(&painted(NAVY), &at("a.toml"), &OwnImages::default());
    assert_eq!(fs::read_to_string(at("a-chart.png")).unwrap(), "mine");
    assert_eq!(Some(chart_of(&at("a.toml"))), painted(NAVY).chart.pixels);
    assert!(at("a-chart-2.png").exists());

    // Another preset's chart: saved under another name, a design gets a chart of its own.
    let (mut opened, known) = files::open_to_edit(&at("a.toml"), Outside::Open).unwrap();
    opened.design.chart.pixels = painted([9; 4]).chart.pixels;
    save(&opened.design, &at("b.toml"), &known);
    assert_eq!(Some(chart_of(&at("a.toml"))), painted(NAVY).chart.pixels);
    assert_eq!(Some(chart_of(&at("b.toml"))), opened.design.chart.pixels);

    // Somebody has drawn on our file meanwhile.
    let (mut opened, known) = files::open_to_edit(&at("b.toml"), Outside::Open).unwrap();
    let mut drawn = fs::read(at("b-chart.png")).unwrap();
    drawn.extend(b"more");
    fs::write(at("b-chart.png"), &drawn).unwrap();
    opened.design.chart.pixels = painted(NAVY).chart.pixels;
    save(&opened.design, &at("b.toml"), &known);
    assert_eq!(fs::read(at("b-chart.png")).unwrap(), drawn);
    assert_eq!(Some(chart_of(&at("b.toml"))), painted(NAVY).chart.pixels);

    // A copy of a preset made by a file manager shares the chart with it; what is saved from it does not.
    fs::copy(at("a.toml"), at("copy.toml")).unwrap();
    let (opened, _) = files::open_to_edit(&at("copy.toml"), Outside::Open).unwrap();
    assert!(opened.design.chart.image.is_some());
    let mut design = opened.design;
    (design.chart.image, design.chart.pixels) = (None, painted([7; 4]).chart.pixels);
    save(&design, &at("copy.toml"), &OwnImages::default());
    assert_eq!(Some(chart_of(&at("a.toml"))), painted(NAVY).chart.pixels);
    assert_eq!(Some(chart_of(&at("copy.toml"))), design.chart.pixels);
}

#[test]
fn a_preset_that_cannot_be_written_leaves_its_chart_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    // A folder has the preset's name: the chart could be written, the preset cannot.
    let preset = folder.path().join("x.toml");
    fs::create_dir_all(preset.join("full")).unwrap();
    let none = OwnImages::default();
    let failed = files::save_edited(&painted(NAVY), &Carried::default(), &preset, None, &none);
    let message = failed.expect_err("a folder").to_string();
    assert!(message.contains("x.toml"), "{message}");
    assert_eq!(names_in(folder.path()), ["x.toml"]);
}
