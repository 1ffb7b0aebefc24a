//! Pictures of every format, changed at random, through every image of a design: whatever they say, they are opened or
//! refused.
//!
//! `FUZZ_INPUTS=100000` tries as many instead of a thousand, and tells how many were opened and which took longest.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use image::codecs::hdr::HdrEncoder;
use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage};
use moxcms::ColorProfile;
use renderer_core::design::ImageSlot;
use renderer_core::image::encode_exr_channels;

use super::PictureFolder;
use crate::support::mutate::Mutator;
use crate::support::picture_files::{
    Values, bmp, color_map, encoded, exif, gif, jpeg_of_blocks, packed_rows, profile_of_inks, tga,
    tiff, webp_with, with_segment,
};
use crate::support::png::{chunk, deflated, indexed, with_chunks, with_right_checksums};

/// Inputs that the suite tries.
const INPUTS: usize = 1000;

/// Small files of every format, twice as wide as high, so that each may be any image of a design.
fn seeds() -> Vec<Vec<u8>> {
    let rgb = RgbImage::from_fn(16, 8, |x, y| Rgb([x as u8 * 16, y as u8 * 30, 99]));
    let image = DynamicImage::from(rgb.clone());
    let grey: DynamicImage = GrayImage::from_fn(16, 8, |x, y| Luma([(x * y) as u8])).into();
    let profile = ColorProfile::new_display_p3().encode().unwrap();
    let numbers: Vec<u8> = (0..128).map(|k| (k / 3 % 6) as u8).collect();
    let palette = [
        [9, 8, 7],
        [99, 88, 77],
        [1; 3],
        [255; 3],
        [0; 3],
        [40, 200, 9],
    ];
    let formats = [
        ImageFormat::Png,
        ImageFormat::Jpeg,
        ImageFormat::WebP,
        ImageFormat::Bmp,
        ImageFormat::Tiff,
        ImageFormat::Tga,
        ImageFormat::Pnm,
    ];
    let mut seeds: Vec<Vec<u8>> = formats
        .iter()
        .map(|format| encoded(&image, *format))
        .collect();
    seeds.extend(formats.iter().map(|format| encoded(&grey, *format)));
    let png = encoded(&image.to_rgb16().into(), ImageFormat::Png);
    let iccp = chunk(b"iCCP", &[&b"p\0\0"[..], &deflated(&profile)].concat());
    seeds.push(with_chunks(png.clone(), &[iccp, chunk(b"eXIf", &exif(6))]));
    let big =
        |numbers: &[u32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_be_bytes()).collect() };
    let chromaticities = big(&[31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000]);
    seeds.push(with_chunks(
        png.clone(),
        &[
            chunk(b"gAMA", &big(&[55556])),
            chunk(b"cHRM", &chromaticities),
        ],
    ));
    seeds.push(with_chunks(png, &[chunk(b"cICP", &[12, 13, 0, 1])]));
    seeds.push(indexed(16, &palette, &[255, 9, 200], &numbers));
    seeds.push(bmp(16, 8, &palette, &numbers));
    seeds.push(bmp(16, 4, &palette, &numbers));
    seeds.push(gif(16, &palette, Some(2), false, &numbers));
    seeds.push(gif(16, &palette, None, true, &numbers));
    seeds.push(tga(16, 24, 0, &palette, &numbers));
    let map = color_map(&palette, 16);
    let tags = |photometric, map| {
        [
            (258, Values::Shorts(&[4])),
            (262, photometric),
            (274, Values::Shorts(&[6])),
            (320, Values::Shorts(map)),
        ]
    };
    let rows = packed_rows(&numbers, 16, 4, 1).concat();
    seeds.push(tiff(
        true,
        [16, 8],
        &tags(Values::Shorts(&[3]), &map),
        &rows,
    ));
    let inks = [
        (258, Values::Shorts(&[8; 4])),
        (262, Values::Shorts(&[5])),
        (277, Values::Shorts(&[4])),
    ];
    seeds.push(tiff(false, [16, 8], &inks, &numbers.repeat(4)));
    let print = profile_of_inks(|[c, m, y, k]| {
        [c, m, y].map(|ink| 200 - 60 * u8::from(ink) - 40 * u8::from(k))
    });
    let part = |profile: &[u8]| [&b"ICC_PROFILE\0\x01\x01"[..], profile].concat();
    let blocks = jpeg_of_blocks(&[&[1, 2, 3, 4], &[200, 100, 50, 25]]);
    let blocks = with_segment(blocks, 0xee, b"Adobe\0\x64\0\0\0\0\x02");
    seeds.push(with_segment(blocks, 0xe2, &part(&print)));
    let jpeg = encoded(&image, ImageFormat::Jpeg);
    let jpeg = with_segment(jpeg, 0xe1, &[&b"Exif\0\0"[..], &exif(8)].concat());
    seeds.push(with_segment(jpeg, 0xe2, &part(&profile)));
    let webp = encoded(&image, ImageFormat::WebP);
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"ICCP", &profile), (b"EXIF", &exif(3))];
    seeds.push(webp_with(&webp, [16, 8], 0x28, &chunks));
    seeds.push(b"P3 4 2 255 1 2 3 4 5 6 7 8 9 10 11 12 1 2 3 4 5 6 7 8 9 10 11 12".to_vec());
    seeds.push(b"P1 4 2 0 1 0 1 1 1 0 0".to_vec());
    let mut hdr = Cursor::new(Vec::new());
    let light: Vec<Rgb<f32>> = rgb.pixels().map(|p| Rgb(p.0.map(f32::from))).collect();
    HdrEncoder::new(&mut hdr).encode(&light, 16, 8).unwrap();
    seeds.push(hdr.into_inner());
    let lines = "#?RGBE\nEXPOSURE=2\nCOLORCORR=1 2 3\nPRIMARIES=.68 .32 .265 .69 .15 .06 .3127 .329\n\n+X 4 -Y 2\n";
    seeds.push([lines.as_bytes(), &[9; 32]].concat());
    let channel = |c: usize| rgb.pixels().map(|p| f32::from(p.0[c])).collect::<Vec<_>>();
    let channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    seeds.push(encode_exr_channels([16, 8], channels).unwrap());
    seeds.push(encode_exr_channels([16, 8], vec![("Y", channel(0))]).unwrap());
    seeds
}

#[test]
fn pictures_changed_at_random_are_opened_or_refused() {
    let inputs = std::env::var("FUZZ_INPUTS")
        .ok()
        .and_then(|count| count.parse().ok());
    let is_long = inputs.is_some();
    let seeds = seeds();
    let folder = PictureFolder::new();
    for (k, seed) in seeds.iter().enumerate() {
        let opened = ImageSlot::ALL.map(|slot| folder.read(slot, seed).is_ok());
        assert!(opened.contains(&true), "seed {k} is a picture");
    }
    let others: Vec<&[u8]> = seeds.iter().map(Vec::as_slice).collect();
    let mut mutator = Mutator::new(20_260_715);
    let (mut opened, mut warned, mut slowest) = (0, 0, (Duration::ZERO, 0));
    let mut panics = Vec::new();
    for input in 0..inputs.unwrap_or(INPUTS) {
        let seed = mutator.below(seeds.len());
        let mut file = mutator.mutated(&seeds[seed], &others);
        // Without checksums that are right, most changes of a PNG come no further.
        if file.starts_with(b"\x89PNG") && mutator.below(4) > 0 {
            file = with_right_checksums(file);
        }
        let start = Instant::now();
        for slot in ImageSlot::ALL {
            match catch_unwind(AssertUnwindSafe(|| folder.read(slot, &file))) {
                Ok(Ok(loaded)) => {
                    opened += 1;
                    warned += usize::from(!loaded.warnings.is_empty());
                }
                Ok(Err(message)) => assert!(message.contains("picture: "), "{message}"),
                Err(_) => panics.push((input, seed, slot)),
            }
        }
        slowest = slowest.max((start.elapsed(), input));
    }
    if is_long {
        eprintln!(
            "{opened} opened, {warned} with warnings, {} panics, slowest {slowest:?}",
            panics.len()
        );
    }
    assert!(panics.is_empty(), "input, seed, image: {panics:?}");
    // Neither all nor none come through, or nothing was tried.
    assert!(
        opened > INPUTS / 4 && opened < 4 * inputs.unwrap_or(INPUTS),
        "{opened}"
    );
}
