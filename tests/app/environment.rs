//! Pictures of the surroundings as files: formats, sizes, what is refused, and that the link to them survives saving.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::codecs::hdr::HdrEncoder;
use image::{ImageFormat, Rgb, Rgb32FImage};
use renderer_core::design::{EnvironmentImage, ImagePixels, ImageSlot, preset, srgb_to_linear};
use renderer_core::image::encode_exr_channels;
use towel_designer::files::{self, FileError};

/// 8 × 4 pixels: the left half red and brighter than white above, the right half dim blue.
fn colour_at(x: u32, y: u32) -> [f32; 3] {
    if x < 4 {
        [if y < 2 { 4.0 } else { 1.0 }, 0.25, 0.0]
    } else {
        [0.0, 0.125, 0.5]
    }
}

fn write_hdr(path: &Path, size: [u32; 2], colour: impl Fn(u32, u32) -> [f32; 3]) {
    let image = Rgb32FImage::from_fn(size[0], size[1], |x, y| Rgb(colour(x, y)));
    let mut file = Vec::new();
    let pixels: Vec<Rgb<f32>> = image.pixels().copied().collect();
    HdrEncoder::new(&mut file)
        .encode(&pixels, size[0] as usize, size[1] as usize)
        .unwrap();
    fs::write(path, file).unwrap();
}

fn write_exr(path: &Path, size: [u32; 2], colour: impl Fn(u32, u32) -> [f32; 3]) {
    let channel = |c: usize| -> Vec<f32> {
        (0..size[0] * size[1])
            .map(|k| colour(k % size[0], k / size[0])[c])
            .collect()
    };
    let channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    fs::write(path, encode_exr_channels(size, channels).unwrap()).unwrap();
}

/// A file with values of 8 bits.
fn write_encoded(path: &Path, format: ImageFormat, size: [u32; 2], value: impl Fn(u32) -> u8) {
    let image = image::RgbImage::from_fn(size[0], size[1], |x, _| Rgb([value(x); 3]));
    let mut file = Cursor::new(Vec::new());
    image.write_to(&mut file, format).unwrap();
    fs::write(path, file.into_inner()).unwrap();
}

fn load(path: &Path) -> Result<EnvironmentImage, FileError> {
    match files::load_image(ImageSlot::Environment, path)?.pixels {
        ImagePixels::Light(image) => Ok(image),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_format_is_read_the_same_way_round() {
    let folder = tempfile::TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_hdr(&at("a.hdr"), [8, 4], colour_at);
    write_exr(&at("a.exr"), [8, 4], colour_at);
    for name in ["a.hdr", "a.exr"] {
        let image = load(&at(name)).unwrap();
        assert_eq!((image.width(), image.height()), (8, 4), "{name}");
        assert_eq!(image.mended(), 0);
        for (k, pixel) in (0..).zip(image.pixels()) {
            let expected = colour_at(k % 8, k / 8);
            for c in 0..3 {
                // RGBE shares one exponent: 8 bits of the largest channel.
                let error = (pixel[c] - expected[c]).abs();
                let most = expected.iter().fold(0.0, |a: f32, &b| a.max(b));
                assert!(error <= most / 256.0, "{name} {k}: {pixel:?}");
            }
        }
    }
    let value = |x: u32| if x < 4 { 188 } else { 20 };
    write_encoded(&at("a.png"), ImageFormat::Png, [8, 4], value);
    write_encoded(&at("a.jpg"), ImageFormat::Jpeg, [8, 4], value);
    // The content decides, not the name.
    fs::copy(at("a.exr"), at("b.png")).unwrap();
    for (name, tolerance) in [("a.png", 1e-4), ("a.jpg", 0.02)] {
        let image = load(&at(name)).unwrap();
        for (x, value) in [(0, 188.0), (7, 20.0)] {
            let expected = srgb_to_linear(value / 255.0);
            let error = f64::from(image.pixel(x, 1)[1]) - expected;
            assert!(error.abs() < tolerance, "{name} {x}: off by {error}");
        }
    }
    let renamed = load(&at("b.png")).unwrap();
    assert_eq!(renamed, load(&at("a.exr")).unwrap());
}

#[test]
fn what_is_no_picture_of_the_surroundings_is_refused_with_what_is_allowed() {
    let folder = tempfile::TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("text.hdr"), "no image").unwrap();
    write_hdr(&at("square.hdr"), [4, 4], colour_at);
    write_exr(&at("wide.exr"), [12, 4], colour_at);
    write_exr(&at("large.exr"), [8194, 1], colour_at);
    write_encoded(&at("large.png"), ImageFormat::Png, [8194, 4097], |_| 1);
    write_exr(&at("nan.exr"), [8, 4], |x, y| {
        [0.0, if (x, y) == (5, 2) { f32::NAN } else { 1.0 }, 0.0]
    });
    for name in ["a.hdr", "a.exr"] {
        let whole = at(&format!("whole {name}"));
        if name == "a.hdr" {
            write_hdr(&whole, [64, 32], colour_at);
        } else {
            write_exr(&whole, [64, 32], |x, y| [x as f32, y as f32, 0.1]);
        }
        let bytes = fs::read(&whole).unwrap();
        fs::write(at(&format!("cut {name}")), &bytes[..bytes.len() / 2]).unwrap();
    }
    let cases = [
        ("gone.hdr", "cannot be read: "),
        ("text.hdr", "is none of .hdr, .exr, PNG, JPEG, WebP"),
        ("cut a.hdr", "is broken: "),
        ("cut a.exr", "is broken: "),
        (
            "square.hdr",
            "has 4 x 4 pixels; an equirectangular picture is twice as wide as high, as 8 x 4",
        ),
        ("wide.exr", "has 12 x 4 pixels; an equirectangular"),
        (
            "large.exr",
            "has 8194 x 1 pixels, allowed are at most 8192 x 4096",
        ),
        ("large.png", "has 8194 x 4097 pixels, allowed are at most"),
        (
            "nan.exr",
            "the pixel in column 5, row 2 is not a number (NaN)",
        ),
    ];
    for (name, says) in cases {
        let error = load(&at(name)).unwrap_err().to_string();
        let start = format!("{}: environment image: {says}", at(name).display());
        assert!(error.starts_with(&start), "{error}\ninstead of {start}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn a_design_saved_elsewhere_finds_its_surroundings() {
    let folder = tempfile::TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("a/skies")).unwrap();
    fs::create_dir_all(at("b/deep")).unwrap();
    write_hdr(&at("a/skies/s.hdr"), [8, 4], colour_at);
    fs::write(
        at("a/one.toml"),
        "format = 1\nlight.environment = { kind = 'image', image = 'skies/s.hdr' }",
    )
    .unwrap();
    let one = files::load_design(&at("a/one.toml")).unwrap();
    assert!(one.light.environment.pixels.is_some());
    for (place, expected) in [
        ("a/two.toml", "skies/s.hdr"),
        ("b/deep/two.toml", "../../a/skies/s.hdr"),
    ] {
        let saved = files::save_design(&one, &at(place), Some(&at("a/one.toml"))).unwrap();
        assert_eq!(saved.light.environment.image.as_deref(), Some(expected));
        assert_eq!(files::load_design(&at(place)).unwrap(), saved);
    }
    // Setting another field keeps the pixels, another path drops them.
    let kept = preset::set(&one, "light.environment.rotation", "20").unwrap();
    assert_eq!(kept.light.environment.pixels, one.light.environment.pixels);
    let other = preset::set(&one, "light.environment.image", "t.hdr").unwrap();
    assert_eq!(other.light.environment.pixels, None);
}
