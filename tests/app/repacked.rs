//! Bundles that other programs packed again or renamed, and presets that other systems wrote: the paths in them lead to
//! the same images.

use std::fs;
use std::path::{Path, PathBuf};

use renderer_core::design::Design;
use towel_designer::designer::Document;
use towel_designer::files::{self, Origin};

use crate::bundles::archive;

/// Names and contents of the members of an archive.
type Members<'a> = &'a [(&'a str, &'a [u8])];

/// Composed, as most systems write it, and in letters and accents, as macOS does.
const COMPOSED: &str = "Blüten é.png";
const APART: &str = "Blu\u{308}ten e\u{301}.png";

fn chart() -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    let image =
        image::RgbImage::from_fn(3, 2, |x, y| image::Rgb([40 * x as u8, 90 * y as u8, 200]));
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

fn preset(image: &str) -> String {
    format!("format = 1\n[sheet]\nwarps = 12\nwefts = 10\n[chart]\nimage = '{image}'\n")
}

/// The design of an archive of these members, in a file of some name.
fn opened(folder: &Path, name: &str, members: &[(&str, &[u8])]) -> Result<Design, String> {
    let path = folder.join(name);
    fs::write(&path, archive(members)).unwrap();
    let opened = files::open_design(&path).map_err(|error| error.to_string())?;
    assert_eq!(opened.origin, Origin::Bundle);
    // Saved again it is whole.
    let again = folder.join("again.towel");
    files::save(&opened.design, &opened.carried, &again, Some(&path)).unwrap();
    let design = files::load_design(&again).unwrap();
    assert_eq!(design.chart.pixels, opened.design.chart.pixels);
    Ok(opened.design)
}

#[test]
fn bundles_packed_again_open() {
    let folder = tempfile::tempdir().unwrap();
    let (chart, junk) = (chart(), b"\0\x05\x16\x07".as_slice());
    let plain = preset("chart.png");
    let (plain, chart) = (plain.as_bytes(), chart.as_slice());
    let dotted = preset("./charts/chart.png");
    let backslashed = preset("charts\\chart.png");
    let (composed, apart) = (preset(COMPOSED), preset(APART));
    let cases: [(&str, Members<'_>); 11] = [
        (
            "as written",
            &[("preset.toml", plain), ("chart.png", chart)],
        ),
        (
            "a folder around",
            &[
                ("My towel/", b""),
                ("My towel/preset.toml", plain),
                ("My towel/chart.png", chart),
            ],
        ),
        (
            "of macOS",
            &[
                ("Set/preset.toml", plain),
                ("__MACOSX/Set/._preset.toml", junk),
                ("__MACOSX/._Set", junk),
                ("Set/.DS_Store", junk),
                ("Set/chart.png", chart),
                ("__MACOSX/Set/._chart.png", junk),
            ],
        ),
        (
            "with dots",
            &[("./preset.toml", plain), ("./chart.png", chart)],
        ),
        (
            "of Windows",
            &[("Set\\preset.toml", plain), ("Set\\chart.png", chart)],
        ),
        (
            "dots inside",
            &[
                ("preset.toml", dotted.as_bytes()),
                ("charts/chart.png", chart),
            ],
        ),
        (
            "a backslash inside",
            &[
                ("preset.toml", backslashed.as_bytes()),
                ("charts/chart.png", chart),
            ],
        ),
        (
            "accents apart in the archive",
            &[("preset.toml", composed.as_bytes()), (APART, chart)],
        ),
        (
            "accents apart in the preset",
            &[("preset.toml", apart.as_bytes()), (COMPOSED, chart)],
        ),
        (
            "another name of the preset",
            &[("x/stripes.toml", plain), ("x/chart.png", chart)],
        ),
        (
            "one within another",
            &[
                ("preset.toml", plain),
                ("chart.png", chart),
                ("old/preset.toml", b"format = 2"),
            ],
        ),
    ];
    for (what, members) in cases {
        let design = opened(folder.path(), "one.towel", members)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let pixels = design
            .chart
            .pixels
            .unwrap_or_else(|| panic!("{what}: no chart"));
        assert_eq!((pixels.width(), pixels.height()), (3, 2), "{what}");
    }
}

#[test]
fn archives_that_are_no_bundle_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let text = preset("chart.png");
    let text = text.as_bytes();
    let two: &[(&str, &[u8])] = &[("a/preset.toml", text), ("b/preset.toml", text)];
    let error = opened(folder.path(), "two.towel", two).unwrap_err();
    assert!(
        error.contains("several presets, a/preset.toml and b/preset.toml"),
        "{error}"
    );
    let error = opened(folder.path(), "none.towel", &[("chart.png", &chart())]).unwrap_err();
    assert!(
        error.contains("none.towel") && error.contains("no preset.toml"),
        "{error}"
    );
    // Names that lead out of the archive lead nowhere.
    let out = preset("../../chart.png");
    let error = opened(
        folder.path(),
        "out.towel",
        &[("a/b/preset.toml", out.as_bytes())],
    )
    .unwrap_err();
    assert!(error.contains("does not hold it"), "{error}");
}

#[test]
fn a_bundle_of_another_name_opens_by_its_content_and_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let (text, chart) = (preset("chart.png"), chart());
    let members: &[(&str, &[u8])] = &[("preset.toml", text.as_bytes()), ("chart.png", &chart)];
    for name in ["set.zip", "set.towel.zip", "set", "set.toml", "set.png"] {
        let design =
            opened(folder.path(), name, members).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(design.chart.pixels.is_some(), "{name}");
        let path = folder.path().join(name);
        let document = Document::opened(files::open_design(&path).unwrap(), path);
        // Saved there it would be a preset that calls itself something else.
        assert_eq!(document.path(), None, "{name}");
    }
    let path = folder.path().join("set.towel");
    fs::write(&path, archive(members)).unwrap();
    let document = Document::opened(files::open_design(&path).unwrap(), path.clone());
    assert_eq!(document.path(), Some(&*path));
}

/// A folder with a preset that names an image, and that image under another name.
fn folder_with(image: &str, file: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.toml");
    fs::write(&path, preset(image)).unwrap();
    let file = folder.path().join(file);
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(file, chart()).unwrap();
    (folder, path)
}

#[test]
fn presets_of_other_systems_find_their_images() {
    for (image, file) in [
        ("charts\\chart.png", "charts/chart.png"),
        (".\\chart.png", "chart.png"),
        ("charts\\..\\chart.png", "chart.png"),
        (COMPOSED, APART),
        (APART, COMPOSED),
        ("Muster a\u{308}\\x.png", "Muster ä/x.png"),
    ] {
        let (folder, path) = folder_with(image, file);
        fs::create_dir_all(folder.path().join("charts")).unwrap();
        let opened = files::open_design(&path).unwrap_or_else(|error| panic!("{image}: {error}"));
        assert!(opened.design.chart.pixels.is_some(), "{image}");
        // What is saved names the file as it is called here.
        files::save(&opened.design, &opened.carried, &path, Some(&path)).unwrap();
        let written = fs::read_to_string(&path).unwrap();
        let name = files::load_design(&path).unwrap().chart.image.unwrap();
        assert!(
            !written.contains('\\') && folder.path().join(name).is_file(),
            "{image}: {written}"
        );
    }
}

#[test]
#[cfg(unix)]
fn a_file_whose_name_has_a_backslash_is_that_file() {
    let (_folder, path) = folder_with("a\\b.png", "a\\b.png");
    assert!(files::load_design(&path).unwrap().chart.pixels.is_some());
}

#[test]
fn paths_that_lead_nowhere_speak_of_the_backslash() {
    let (folder, path) = folder_with("chart.png", "chart.png");
    for (line, says) in [
        (r#"image = "C:\Users\me\c.png""#, "backslash"),
        (r#"image = "C:\temp\new.png""#, "backslash"),
        (r#"image = 'C:\Users\me\c.png'"#, "path of Windows"),
        (r"image = '\\host\share\c.png'", "path of Windows"),
        (r"image = 'charts\c.png'", "backslash"),
    ] {
        fs::write(&path, format!("format = 1\n[chart]\n{line}\n")).unwrap();
        let error = files::load_design(&path).expect_err(line).to_string();
        assert!(
            error.contains("one.toml:3:") && error.contains(says),
            "{line}: {error}"
        );
    }
    // None where there is none.
    fs::write(&path, preset("gone.png")).unwrap();
    let error = files::load_design(&path).expect_err("gone").to_string();
    assert!(!error.contains("backslash"), "{error}");
    drop(folder);
}
