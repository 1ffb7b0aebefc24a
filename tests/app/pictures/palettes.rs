//! Charts with palettes, as weavers' programs write them: every entry that is used is a yarn.

use std::collections::HashSet;
use std::fs;

use image::{DynamicImage, ImageFormat, RgbImage};
use renderer_core::design::chart_edit::yarn_of;
use renderer_core::design::{ChartImage, ImageSlot};
use towel_designer::files;

use super::{PictureFolder, all};
use crate::support::picture_files::{Values, bmp, color_map, encoded, gif, packed_rows, tga, tiff};
use crate::support::png::indexed;

const RED: [u8; 3] = [198, 24, 33];
const NAVY: [u8; 3] = [16, 24, 99];
/// The first and the third are one colour, and so is the sixth, which no pixel has.
const PALETTE: [[u8; 3]; 6] = [RED, NAVY, RED, [255; 3], [0; 3], RED];
/// Four columns and three rows.
const NUMBERS: [u8; 12] = [0, 1, 2, 3, 2, 2, 0, 4, 1, 2, 3, 0];

fn pixels(colours: &[[u8; 3]; 6]) -> Vec<[u8; 4]> {
    let opaque = |number: &u8| {
        let [r, g, b] = colours[usize::from(*number)];
        [r, g, b, 255]
    };
    NUMBERS.iter().map(opaque).collect()
}

/// One picture with a palette in every format and width of numbers.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let map = |entries| color_map(&PALETTE, entries);
    let tags = |bits: u16| (258, bits, map(1 << bits));
    let tiff_of = |is_big, bits: u16| {
        let (tag, bits, map) = tags(bits);
        let pixels = packed_rows(&NUMBERS, 4, usize::from(bits), 1).concat();
        let tags = [
            (tag, Values::Shorts(&[bits])),
            (262, Values::Shorts(&[3])),
            (320, Values::Shorts(&map)),
        ];
        tiff(is_big, [4, 3], &tags, &pixels)
    };
    vec![
        ("png", indexed(4, &PALETTE, &[], &NUMBERS)),
        ("bmp of 8 bits", bmp(4, 8, &PALETTE, &NUMBERS)),
        ("bmp of 4 bits", bmp(4, 4, &PALETTE, &NUMBERS)),
        ("gif", gif(4, &PALETTE, None, false, &NUMBERS)),
        (
            "gif with a local palette",
            gif(4, &PALETTE, None, true, &NUMBERS),
        ),
        ("tiff of 8 bits", tiff_of(false, 8)),
        ("tiff of 8 bits, big end first", tiff_of(true, 8)),
        ("tiff of 4 bits", tiff_of(false, 4)),
        ("tiff of 4 bits, big end first", tiff_of(true, 4)),
        ("tga of 24 bits", tga(4, 24, 0, &PALETTE, &NUMBERS)),
        ("tga of 32 bits", tga(4, 32, 0, &PALETTE, &NUMBERS)),
    ]
}

#[test]
fn two_entries_of_one_colour_stay_two_yarns_in_every_format() {
    let folder = PictureFolder::new();
    let mut told_apart = PALETTE;
    // The nearest colour that no other entry has.
    told_apart[2][2] += 1;
    for (name, file) in files() {
        let chart = folder.chart(&file);
        assert_eq!((chart.width(), chart.height()), (4, 3), "{name}");
        assert_eq!(all(&chart), pixels(&told_apart), "{name}");
        let yarns: HashSet<[u8; 4]> = all(&chart).into_iter().map(yarn_of).collect();
        assert_eq!(yarns.len(), 5, "{name}");
        // Where numbers are data, they stay.
        let nap = folder.read(ImageSlot::Nap, &file).unwrap().pixels;
        assert_eq!(all(&super::colours(nap)), pixels(&PALETTE), "{name}");
    }
}

#[test]
fn a_crowded_palette_finds_a_free_colour_and_alpha_leaves_yarns_out() {
    let folder = PictureFolder::new();
    // Around the colour twice there, all that differ by one step in blue or red are taken, at the edge of the range.
    let palette = [
        [0, 9, 255],
        [0, 9, 255],
        [0, 9, 254],
        [1, 9, 255],
        [0, 8, 255],
    ];
    let file = indexed(5, &palette, &[], &[0, 1, 2, 3, 4]);
    let mut expected = palette;
    expected[1] = [0, 10, 255];
    let opaque = expected.map(|[r, g, b]| [r, g, b, 255]);
    assert_eq!(all(&folder.chart(&file)), opaque);

    // What plants nothing is no yarn, and takes no colour from one.
    let file = indexed(3, &[RED, RED, RED], &[0, 127, 255], &[0, 1, 2]);
    let [r, g, b] = RED;
    assert_eq!(
        all(&folder.chart(&file)),
        [[r, g, b, 0], [r, g, b, 127], [r, g, b, 255]]
    );
    let file = gif(3, &[RED, NAVY, RED], Some(1), false, &[0, 1, 2]);
    let chart = folder.chart(&file);
    assert_eq!(chart.pixel(1, 0)[3], 0);
    assert_eq!(
        [chart.pixel(0, 0), chart.pixel(2, 0)],
        [[r, g, b, 255], [r, g, b + 1, 255]]
    );
}

#[test]
fn other_depths_and_palettes_that_begin_later_are_read() {
    let folder = PictureFolder::new();
    let bits: Vec<u8> = NUMBERS.iter().map(|number| number & 1).collect();
    let two = [NAVY, RED];
    let of_two = |numbers: &[u8]| -> Vec<[u8; 4]> {
        let colour = |number: &u8| two[usize::from(*number)];
        numbers
            .iter()
            .map(colour)
            .map(|[r, g, b]| [r, g, b, 255])
            .collect()
    };
    let map = color_map(&two, 2);
    let packed = packed_rows(&bits, 4, 1, 1).concat();
    let tags = [(262, Values::Shorts(&[3])), (320, Values::Shorts(&map))];
    for (name, file) in [
        ("bmp of 1 bit", bmp(4, 1, &two, &bits)),
        ("tiff of 1 bit", tiff(false, [4, 3], &tags, &packed)),
        (
            "tga from entry 7 on",
            tga(
                4,
                24,
                7,
                &two,
                &bits.iter().map(|b| b + 7).collect::<Vec<_>>(),
            ),
        ),
    ] {
        assert_eq!(all(&folder.chart(&file)), of_two(&bits), "{name}");
    }
    // Five bits a channel, and greys of four bits, one way and the other.
    let tga = folder.chart(&tga(4, 16, 0, &[[255, 0, 128], [8, 255, 0]], &bits));
    assert_eq!(
        [tga.pixel(0, 0), tga.pixel(1, 0)],
        [[255, 0, 132, 255], [8, 255, 0, 255]]
    );
    let packed = packed_rows(&NUMBERS, 4, 4, 1).concat();
    for (photometric, grey) in [(1, 4 * 17), (0, 255 - 4 * 17)] {
        let tags = [
            (258, Values::Shorts(&[4])),
            (262, Values::Shorts(&[photometric])),
        ];
        let chart = folder.chart(&tiff(true, [4, 3], &tags, &packed));
        assert_eq!(chart.pixel(3, 1), [grey, grey, grey, 255]);
    }
}

#[test]
fn every_format_opens_as_a_chart_from_a_preset_and_a_bundle() {
    let folder = PictureFolder::new();
    let rgb = RgbImage::from_raw(4, 3, NUMBERS.map(|k| PALETTE[usize::from(k)]).concat()).unwrap();
    let image = DynamicImage::from(rgb);
    let expected = ChartImage::new(4, 3, &pixels(&PALETTE)).unwrap();
    for (format, name) in [
        (ImageFormat::Png, "c.png"),
        (ImageFormat::WebP, "c.webp"),
        (ImageFormat::Bmp, "c.bmp"),
        (ImageFormat::Tiff, "c.tif"),
        (ImageFormat::Tga, "c.tga"),
        (ImageFormat::Pnm, "c.ppm"),
    ] {
        folder.put(name, &encoded(&image, format));
        let preset = folder.put(
            "p.toml",
            format!("format = 1\nchart.image = '{name}'").as_bytes(),
        );
        let opened = files::open_design(&preset).unwrap();
        assert_eq!(
            opened.design.chart.pixels.as_ref(),
            Some(&expected),
            "{name}"
        );
        assert_eq!(opened.warnings, [""; 0], "{name}");
        let bundle = preset.with_file_name("b.towel");
        files::save(&opened.design, &opened.carried, &bundle, Some(&preset)).unwrap();
        let again = files::open_design(&bundle).unwrap();
        assert_eq!(again.design.chart.pixels, Some(expected.clone()), "{name}");
        let kept = again.carried.get(name).expect("as the file it was");
        assert_eq!(
            **kept,
            *fs::read(preset.with_file_name(name)).unwrap(),
            "{name}"
        );
    }
    for name in [
        "c.webp", "c.bmp", "c.tif", "c.tiff", "c.tga", "c.ppm", "c.gif", "c.jpg",
    ] {
        let ending = name.split('.').next_back().unwrap();
        assert_eq!(files::dropped(ending), Some(ImageSlot::Chart), "{name}");
        for slot in ImageSlot::ALL {
            assert!(files::words(slot).endings.contains(&ending), "{name}");
        }
    }
}
