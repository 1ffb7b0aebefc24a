//! Preset files on the disk: the shipped ones, links to images, and files that are whole or untouched.

use std::fs;

use renderer_core::design::{Design, preset};
use towel_designer::files;

use crate::support::scenes::{load_design, preset_paths};

#[test]
fn every_shipped_preset_is_sound_and_round_trips() {
    let paths = preset_paths();
    for path in &paths {
        let design = files::load_design(path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            design,
            load_design(path),
            "tests that know nothing of this program read the same"
        );
        assert_eq!(design.faults(), [], "{}", path.display());
        assert_eq!(
            design.chart.image.is_some(),
            design.chart.pixels.is_some(),
            "{}",
            path.display()
        );
        let mut without_pixels = design.clone();
        (without_pixels.chart.pixels, without_pixels.nap.pixels) = (None, None);
        without_pixels.form.pixels = None;
        without_pixels.light.environment.pixels = None;
        let text = preset::write(&without_pixels).unwrap();
        assert_eq!(preset::parse(&text), Ok(without_pixels), "{text}");
    }
    assert!(paths.len() >= 6, "only {} presets in presets/", paths.len());
}

#[test]
fn a_design_saved_elsewhere_finds_its_chart() {
    let folder = tempfile::TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("a/charts")).unwrap();
    fs::create_dir_all(at("b/deep")).unwrap();
    let chart = image::RgbaImage::from_pixel(3, 2, image::Rgba([9, 8, 7, 255]));
    chart.save(at("a/charts/c.png")).unwrap();
    fs::write(at("a/one.toml"), "format = 1\nchart.image = 'charts/c.png'").unwrap();

    let one = files::load_design(&at("a/one.toml")).unwrap();
    let pixels = one.chart.pixels.clone().unwrap();
    assert_eq!((pixels.width(), pixels.height()), (3, 2));
    assert_eq!(pixels.pixel(2, 1), [9, 8, 7, 255]);
    for (place, expected) in [
        ("a/two.toml", "charts/c.png"),
        ("b/deep/two.toml", "../../a/charts/c.png"),
        ("a/charts/two.toml", "c.png"),
    ] {
        let saved = files::save_design(&one, &at(place), Some(&at("a/one.toml"))).unwrap();
        assert_eq!(saved.chart.image.as_deref(), Some(expected));
        assert_eq!(files::load_design(&at(place)).unwrap(), saved);
    }
    // A chart just opened is named by its whole path until the design is saved.
    let mut new = Design::default();
    new.chart.image = Some(at("a/charts/c.png").to_str().unwrap().into());
    new.chart.pixels = Some(pixels);
    let saved = files::save_design(&new, &at("b/new.toml"), None).unwrap();
    assert_eq!(saved.chart.image.as_deref(), Some("../a/charts/c.png"));
    assert_eq!(files::load_design(&at("b/new.toml")).unwrap(), saved);
}

#[test]
fn saving_replaces_the_file_whole_or_not_at_all() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("a.toml");
    fs::write(&path, "old").unwrap();
    let names = || fs::read_dir(folder.path()).unwrap().count();
    let failing = files::write_atomically_with(&path, |file| {
        file.write_all(b"half of the new")?;
        Err(std::io::Error::other("the disk is full"))
    });
    let message = failing.unwrap_err().to_string();
    assert!(
        message.ends_with("a.toml: cannot be written: the disk is full"),
        "{message}"
    );
    assert_eq!(
        (fs::read(&path).unwrap().as_slice(), names()),
        (&b"old"[..], 1)
    );
    files::save_design(&Design::default(), &path, None).unwrap();
    assert_eq!(
        (files::load_design(&path).unwrap(), names()),
        (Design::default(), 1)
    );
}

#[cfg(unix)]
#[test]
fn saving_keeps_links_and_permissions() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("real.toml"), "old").unwrap();
    fs::set_permissions(at("real.toml"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.toml", at("link.toml")).unwrap();
    files::save_design(&Design::default(), &at("link.toml"), None).unwrap();
    assert!(fs::symlink_metadata(at("link.toml")).unwrap().is_symlink());
    assert!(
        fs::read(at("real.toml"))
            .unwrap()
            .starts_with(b"# Towel Designer")
    );
    let mode = fs::metadata(at("real.toml")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
}
