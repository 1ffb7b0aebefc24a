//! Files that end too soon, that are something else, or that never end: refused, or opened with a word.

use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use renderer_core::design::ImageSlot;

use super::PictureFolder;
use crate::support::picture_files::{bmp, encoded, gif, jpeg_of_blocks, tga, with_segment};
use crate::support::png::indexed;

/// A picture that no encoder can make small.
fn noise() -> DynamicImage {
    let value = |x: u32, y: u32, c: u32| ((x * 7919 + y * 104_729 + c * 31) % 251) as u8;
    RgbImage::from_fn(64, 32, |x, y| Rgb([0, 1, 2].map(|c| value(x, y, c)))).into()
}

#[test]
fn a_file_that_is_cut_off_is_never_opened_without_a_word() {
    let folder = PictureFolder::new();
    let numbers: Vec<u8> = (0..1024).map(|k| (k % 97) as u8).collect();
    let palette: Vec<[u8; 3]> = (0..97).map(|k| [k, 2 * k, 255 - k]).collect();
    let mut files = vec![
        ("png of a palette", indexed(32, &palette, &[], &numbers)),
        ("bmp of a palette", bmp(32, 8, &palette, &numbers)),
        ("gif", gif(32, &palette, None, false, &numbers)),
        ("tga of a palette", tga(32, 24, 0, &palette, &numbers)),
    ];
    for (name, format) in [
        ("png", ImageFormat::Png),
        ("jpeg", ImageFormat::Jpeg),
        ("webp", ImageFormat::WebP),
        ("bmp", ImageFormat::Bmp),
        ("tiff", ImageFormat::Tiff),
        ("tga", ImageFormat::Tga),
        ("ppm", ImageFormat::Pnm),
    ] {
        files.push((name, encoded(&noise(), format)));
    }
    let blocks: Vec<[u8; 4]> = (0..40).map(|k| [k, 200 - k, 3 * k, 99]).collect();
    let blocks: Vec<&[u8]> = blocks.iter().map(|block| &block[..]).collect();
    files.push(("jpeg of inks", jpeg_of_blocks(&blocks)));
    for (name, file) in files {
        let whole = folder.read(ImageSlot::Chart, &file).unwrap();
        let said = whole.warnings.len();
        for part in [40, 60, 90] {
            // Of a GIF all after the first picture may be missing.
            let end = if name == "gif" {
                800 + part * 5
            } else {
                file.len() * part / 100
            };
            match folder.read(ImageSlot::Chart, &file[..end]) {
                Err(error) => assert!(error.contains(" chart image: "), "{name}: {error}"),
                Ok(cut) => {
                    assert!(
                        cut.warnings.len() > said,
                        "{name}, {part} %: opened without a word"
                    );
                    let says = "picture: chart image: ends in the middle of its picture";
                    assert!(cut.warnings.iter().any(|warning| warning.contains(says)));
                }
            }
        }
    }
}

#[test]
fn a_jpeg_is_whole_where_its_picture_ends_and_not_where_a_thumbnail_does() {
    let folder = PictureFolder::new();
    let thumbnail = encoded(&noise(), ImageFormat::Jpeg);
    let jpeg = jpeg_of_blocks(&[&[9], &[200]]);
    let segment = [&b"Exif\0\0"[..], &thumbnail].concat();
    let file = with_segment(jpeg.clone(), 0xe1, &segment);
    let warnings = |file: &[u8]| folder.chart_and_warnings(file).1.len();
    assert_eq!(warnings(&file), 0);
    assert_eq!(warnings(&file[..file.len() - 2]), 1);
    // Filled up with zeros, as some programs do before they have all of a file.
    let mut filled = file[..file.len() - 2].to_vec();
    filled.resize(file.len() + 500, 0);
    assert_eq!(warnings(&filled), 1);
    assert_eq!(warnings(&[&file[..], b"trailing"].concat()), 0);
}

#[test]
fn what_is_no_picture_is_told_what_it_is_and_what_is_allowed() {
    let folder = PictureFolder::new();
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n01234567";
    for (bytes, says) in [
        (
            &b""[..],
            "is none of PNG, JPEG, WebP, GIF, BMP, TIFF, TGA and PPM",
        ),
        (
            b"\0\0\0\x18ftypheic\0\0\0\0",
            "is an HEIC picture, allowed are PNG, JPEG",
        ),
        (
            b"\0\0\0\x1cftypavif\0\0\0\0",
            "is an AVIF picture, allowed are PNG, JPEG",
        ),
        (b"8BPS\0\x01", "is a Photoshop file, allowed are PNG"),
        (hdr, "is a Radiance HDR picture, allowed are PNG"),
        (
            b"\x76\x2f\x31\x01\x02\0\0\0",
            "is an OpenEXR picture, allowed are PNG",
        ),
        (b"BM", "is broken: "),
    ] {
        for slot in [ImageSlot::Chart, ImageSlot::Nap, ImageSlot::Height] {
            let error = folder.read(slot, bytes).unwrap_err();
            assert!(
                error.contains(&format!(": {says}")),
                "{error}\ninstead of {says}"
            );
        }
    }
    let error = folder.read(ImageSlot::Environment, b"8BPS").unwrap_err();
    let says =
        "is a Photoshop file, allowed are .hdr, .exr, PNG, JPEG, WebP, GIF, BMP, TIFF, TGA and PPM";
    assert!(error.ends_with(says), "{error}");
}

#[test]
fn sizes_are_refused_before_pixels_are_made() {
    let folder = PictureFolder::new();
    // A header that promises 65535 columns and rows, in formats where that costs nothing to write.
    let mut gif = gif(4, &[[1; 3]; 2], None, false, &[0; 4]);
    gif[6..10].fill(0xff);
    let mut tga = tga(4, 24, 0, &[[1; 3]; 2], &[0; 4]);
    tga[12..16].fill(0xff);
    let mut bmp = bmp(4, 8, &[[1; 3]; 2], &[0; 4]);
    bmp[18..20].fill(0xff);
    bmp[22..24].fill(0xff);
    for file in [gif, tga, bmp, b"P6 65535 65535 255 ".to_vec()] {
        let error = folder.read(ImageSlot::Chart, &file).unwrap_err();
        assert!(
            error.contains("has 65535 x 65535 pixels, allowed are at most 8192 x 8192"),
            "{error}"
        );
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.png");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    for path in [&pipe, std::path::Path::new("/dev/zero"), folder.path()] {
        let error = towel_designer::files::load_image(ImageSlot::Chart, path);
        let error = error.unwrap_err().to_string();
        assert!(
            error.ends_with("cannot be read: it is no regular file"),
            "{error}"
        );
    }
}
