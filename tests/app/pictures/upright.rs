//! Photos lie as their cameras were held, in every format that says how.

use image::{DynamicImage, GrayImage, ImageFormat, Luma};
use renderer_core::design::{ImagePixels, ImageSlot, srgb_to_linear};

use super::{PictureFolder, colours, heights};
use crate::support::picture_files::{Values, encoded, exif, tiff, webp_with, with_segment};
use crate::support::png::{chunk, with_chunks};

/// Side of a patch of one grey, pixels: JPEG keeps blocks of 8.
const PATCH: u32 = 8;
/// Patches in a row of the upright picture, and rows.
const UPRIGHT: [u32; 2] = [4, 2];

/// The grey of a patch of the upright picture.
fn grey([x, y]: [u32; 2]) -> u8 {
    (20 + 30 * (x + UPRIGHT[0] * y)) as u8
}

/// Where a patch of a file of `[w, h]` patches is seen, as EXIF defines its orientations.
fn seen(orientation: u16, [w, h]: [u32; 2], [x, y]: [u32; 2]) -> [u32; 2] {
    let (right, bottom) = (w - 1 - x, h - 1 - y);
    match orientation {
        1 => [x, y],
        2 => [right, y],
        3 => [right, bottom],
        4 => [x, bottom],
        5 => [y, x],
        6 => [bottom, x],
        7 => [bottom, right],
        8 => [y, right],
        _ => unreachable!(),
    }
}

/// The picture as a camera held so stores it.
fn stored(orientation: u16) -> GrayImage {
    let [w, h] = match orientation {
        1..=4 => UPRIGHT,
        _ => [UPRIGHT[1], UPRIGHT[0]],
    };
    GrayImage::from_fn(w * PATCH, h * PATCH, |x, y| {
        Luma([grey(seen(orientation, [w, h], [x / PATCH, y / PATCH]))])
    })
}

/// One picture in every format that can say how it lies.
fn files(orientation: u16) -> Vec<(&'static str, Vec<u8>)> {
    let stored = stored(orientation);
    let size = [stored.width(), stored.height()];
    let image = DynamicImage::from(stored.clone());
    let exif = exif(orientation);
    let jpeg = encoded(&image, ImageFormat::Jpeg);
    let segment = [&b"Exif\0\0"[..], &exif].concat();
    let png = encoded(&image, ImageFormat::Png);
    let mut late = png.clone();
    late.splice(png.len() - 12..png.len() - 12, chunk(b"eXIf", &exif));
    let webp = encoded(&image.to_rgb8().into(), ImageFormat::WebP);
    let tags = |kind: u16| {
        [
            (258, Values::Shorts(&[8])),
            (262, Values::Shorts(if kind == 1 { &[1] } else { &[3] })),
            (274, Values::Long(0)),
        ]
    };
    let sides = size.map(|side| side as u16);
    let plain = |is_big| {
        let [bits, photometric, _] = tags(1);
        let lies = [orientation];
        let tags = [bits, photometric, (274, Values::Shorts(&lies))];
        tiff(is_big, sides, &tags, stored.as_raw())
    };
    let map: Vec<u16> = (0..768).map(|k| (k % 256) * 257).collect();
    let lies = [orientation];
    let [bits, photometric, _] = tags(3);
    let of_palette = [
        bits,
        photometric,
        (274, Values::Shorts(&lies)),
        (320, Values::Shorts(&map)),
    ];
    vec![
        ("jpeg", with_segment(jpeg, 0xe1, &segment)),
        ("png", with_chunks(png, &[chunk(b"eXIf", &exif)])),
        ("png, behind its pixels", late),
        ("webp", webp_with(&webp, size, 8, &[(b"EXIF", &exif)])),
        ("tiff", plain(false)),
        ("tiff, big end first", plain(true)),
        (
            "tiff of a palette",
            tiff(false, sides, &of_palette, stored.as_raw()),
        ),
    ]
}

/// The greys of patches as a design has them, from 0 to 255.
fn patches(pixels: &ImagePixels) -> ([usize; 2], Vec<f64>) {
    let middle = |k: u32| (k * PATCH + PATCH / 2) as usize;
    let places = (0..UPRIGHT[1]).flat_map(|y| (0..UPRIGHT[0]).map(move |x| [middle(x), middle(y)]));
    match pixels {
        ImagePixels::Colours(image) => {
            let greys = places.map(|[x, y]| f64::from(image.pixel(x, y)[1]));
            ([image.width(), image.height()], greys.collect())
        }
        ImagePixels::Heights(image) => {
            let greys = places.map(|[x, y]| f64::from(image.row(y)[x]) / 257.0);
            ([image.width(), image.height()], greys.collect())
        }
        ImagePixels::Light(image) => {
            let greys = places.map(|[x, y]| {
                let light = f64::from(image.pixel(x, y)[1]);
                let nearest = |a: &u8, b: &u8| {
                    let off = |v: u8| (srgb_to_linear(f64::from(v) / 255.0) - light).abs();
                    off(*a).total_cmp(&off(*b))
                };
                f64::from((0..=255).min_by(nearest).unwrap())
            });
            ([image.width(), image.height()], greys.collect())
        }
    }
}

#[test]
fn every_image_lies_as_its_camera_was_held() {
    let folder = PictureFolder::new();
    let expected: Vec<f64> = (0..UPRIGHT[0] * UPRIGHT[1])
        .map(|k| f64::from(grey([k % UPRIGHT[0], k / UPRIGHT[0]])))
        .collect();
    for orientation in 1..=8 {
        for (name, file) in files(orientation) {
            for slot in ImageSlot::ALL {
                let loaded = folder.read(slot, &file).unwrap();
                let (size, greys) = patches(&loaded.pixels);
                let place = format!("{name} {orientation} {slot:?}");
                assert_eq!(size, UPRIGHT.map(|side| (side * PATCH) as usize), "{place}");
                let tolerance = if name == "jpeg" { 3.0 } else { 0.5 };
                for (found, expected) in greys.iter().zip(&expected) {
                    assert!((found - expected).abs() <= tolerance, "{place}: {greys:?}");
                }
                assert_eq!(loaded.warnings, [""; 0], "{place}");
            }
        }
    }
}

#[test]
fn what_is_no_orientation_turns_nothing() {
    let folder = PictureFolder::new();
    let png = encoded(&stored(1).into(), ImageFormat::Png);
    let plain = folder.chart(&png);
    for data in [
        exif(0),
        exif(9),
        b"II*\0\xff\xff\xff\xff".to_vec(),
        Vec::new(),
    ] {
        let file = with_chunks(png.clone(), &[chunk(b"eXIf", &data)]);
        assert_eq!(folder.chart(&file), plain);
    }
    let deep = folder.read(ImageSlot::Height, &png).unwrap();
    assert_eq!(heights(deep.pixels).row(0)[0], 20 * 257);
    let nap = folder.read(ImageSlot::Nap, &png).unwrap();
    assert_eq!(colours(nap.pixels), plain);
}
