//! Height pictures as files: they are kept with a design, and what is wrong with them is reported.

use std::fs;
use std::path::Path;

use renderer_core::design::HeightImage;
use towel_designer::files::{self, Carried, Origin};

/// A folder with a preset that names `heights.png`.
fn folder_with_preset() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let preset = folder.path().join("relief.toml");
    let text = "format = 1\n[form]\nkind = \"height\"\nimage = \"heights.png\"\nheight = 3.0\n";
    fs::write(&preset, text).unwrap();
    (folder, preset)
}

fn greys(preset: &Path) -> Vec<u16> {
    let design = files::load_design(preset).unwrap();
    design.form.pixels.unwrap().greys().to_vec()
}

#[test]
fn pictures_of_all_kinds_are_read_as_grey() {
    let (folder, preset) = folder_with_preset();
    let file = folder.path().join("heights.png");
    type Image<P> = image::ImageBuffer<P, Vec<<P as image::Pixel>::Subpixel>>;
    let deep: Image<image::Luma<u16>> = Image::from_vec(3, 1, vec![0, 257, 65535]).unwrap();
    deep.save(&file).unwrap();
    assert_eq!(greys(&preset), [0, 257, 65535], "16 bits are kept");
    image::GrayImage::from_vec(2, 1, vec![1, 255])
        .unwrap()
        .save(&file)
        .unwrap();
    assert_eq!(greys(&preset), [257, 65535]);
    let colours = vec![255, 255, 255, 128, 255, 255, 255, 0, 128, 128, 128, 255];
    image::RgbaImage::from_vec(3, 1, colours)
        .unwrap()
        .save(&file)
        .unwrap();
    assert_eq!(greys(&preset), [128 * 257, 0, 128 * 257], "over black");
    let jpeg = image::GrayImage::from_pixel(8, 8, image::Luma([200]));
    jpeg.save_with_format(&file, image::ImageFormat::Jpeg)
        .unwrap();
    assert!(
        greys(&preset)
            .iter()
            .all(|grey| grey.abs_diff(200 * 257) < 600)
    );
}

#[test]
fn a_picture_that_cannot_be_read_is_reported() {
    let (folder, preset) = folder_with_preset();
    let message = || files::load_design(&preset).unwrap_err().to_string();
    let missing = message();
    assert!(
        missing.contains("relief.toml:4:9: form.image: ")
            && missing.contains("heights.png: height picture: cannot be read"),
        "{missing}"
    );
    fs::write(folder.path().join("heights.png"), "no picture").unwrap();
    let wrong = message();
    assert!(
        wrong.contains("heights.png: height picture: is none of PNG, JPEG, WebP"),
        "{wrong}"
    );
    let wide = image::GrayImage::new(HeightImage::MAX_SIDE as u32 + 1, 1);
    wide.save(folder.path().join("heights.png")).unwrap();
    let large = message();
    assert!(large.contains("allowed are at most 8192 x 8192"), "{large}");
}

#[test]
fn presets_and_bundles_keep_the_picture() {
    let (folder, preset) = folder_with_preset();
    let file = folder.path().join("heights.png");
    let ramp: Vec<u16> = (0..12).map(|k| k * 5000).collect();
    image::ImageBuffer::<image::Luma<u16>, _>::from_vec(4, 3, ramp.clone())
        .unwrap()
        .save(&file)
        .unwrap();
    let design = files::load_design(&preset).unwrap();
    assert_eq!(design.form.height, 3.0);
    // As a bundle, which needs no other file; and from there beside a preset again.
    let bundle = folder.path().join("relief.towel");
    files::save(&design, &Carried::default(), &bundle, Some(&preset)).unwrap();
    let bytes = fs::read(&file).unwrap();
    fs::remove_file(&file).unwrap();
    let opened = files::open_design(&bundle).unwrap();
    assert_eq!(opened.origin, Origin::Bundle);
    assert_eq!(opened.design, design);
    assert_eq!(**opened.carried.get("heights.png").unwrap(), *bytes);
    let elsewhere = tempfile::tempdir().unwrap();
    let again = elsewhere.path().join("again.toml");
    files::save(&opened.design, &opened.carried, &again, Some(&bundle)).unwrap();
    assert_eq!(files::load_design(&again).unwrap(), design);
    assert_eq!(
        fs::read(elsewhere.path().join("heights.png")).unwrap(),
        bytes
    );
    // A picture that is in no file any more is written anew, with all of its bits.
    let lost = elsewhere.path().join("lost.toml");
    files::save(&design, &Carried::default(), &lost, None).unwrap();
    fs::remove_file(elsewhere.path().join("heights.png")).unwrap();
    files::save(&design, &Carried::default(), &lost, None).unwrap();
    assert_eq!(greys(&lost), ramp);
    // From a folder away the preset names the file where it is.
    fs::write(&file, &bytes).unwrap();
    let moved = files::save_design(&design, &elsewhere.path().join("m.toml"), Some(&preset));
    let path = moved.unwrap().form.image.unwrap();
    assert!(
        path.ends_with("/heights.png") && path != "heights.png",
        "{path}"
    );
}
