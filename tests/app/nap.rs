//! Nap maps as files: they are kept as a chart is, and what is wrong with them is reported.

use std::fs;

use renderer_core::design::nap_edit::{UPRIGHT, comb};
use renderer_core::design::{ChartImage, Design};
use towel_designer::files::{self, Carried, Outside, OwnImages};

#[test]
fn a_combed_map_is_written_beside_its_preset_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let preset = folder.path().join("rug.toml");
    let mut design = Design::default();
    let mut map = ChartImage::filled(20, 10, UPRIGHT).unwrap();
    comb(&mut map, [2.0, 5.0], [18.0, 5.0], 6.0);
    design.nap.pixels = Some(map);
    design.chart.pixels = ChartImage::filled(3, 3, [9, 99, 199, 255]);
    let save = |design: &Design, known: &OwnImages| {
        files::save_edited(design, &Carried::default(), &preset, None, known).unwrap()
    };
    let known = save(&design, &OwnImages::default());
    let names = || {
        let entries = fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(names(), ["rug-chart.png", "rug-nap.png", "rug.toml"]);
    let (opened, again) = files::open_to_edit(&preset, Outside::Open).unwrap();
    assert_eq!(opened.design, design);
    // Neither image is written again while it stays the same.
    let written = |name: &str| {
        fs::metadata(folder.path().join(name))
            .unwrap()
            .modified()
            .unwrap()
    };
    let before = [written("rug-chart.png"), written("rug-nap.png")];
    design.sheet.warps = 77;
    for known in [known, again] {
        save(&design, &known);
        assert_eq!([written("rug-chart.png"), written("rug-nap.png")], before);
    }
    // As a bundle, and moved to another folder.
    let bundle = folder.path().join("rug.towel");
    files::save(&design, &Carried::default(), &bundle, None).unwrap();
    let mut opened = files::open_design(&bundle).unwrap().design;
    assert_eq!(opened.nap.image.as_deref(), Some("nap.png"));
    (opened.nap.image, opened.chart.image) = (None, None);
    assert_eq!(opened, design);
}

#[test]
fn a_map_that_cannot_be_read_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let preset = folder.path().join("rug.toml");
    fs::write(&preset, "format = 1\n[nap]\nimage = \"gone.png\"\n").unwrap();
    let message = files::load_design(&preset).unwrap_err().to_string();
    assert!(
        message.contains("rug.toml:3:9: nap.image: ")
            && message.contains("gone.png: nap map: cannot be read"),
        "{message}"
    );
    fs::write(folder.path().join("gone.png"), "no picture").unwrap();
    let message = files::load_design(&preset).unwrap_err().to_string();
    assert!(
        message.contains("gone.png: nap map: is none of PNG, JPEG, WebP"),
        "{message}"
    );
}
