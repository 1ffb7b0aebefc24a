//! Colours of other colour spaces become sRGB, by numbers that are computed here from the spaces' definitions.

use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use moxcms::{ColorProfile, curve_from_gamma};
use renderer_core::design::{ImageSlot, srgb_to_linear};

use super::{PictureFolder, all, colours, heights};
use crate::support::picture_files::{
    Values, encoded, jpeg_of_blocks, profile_of_inks, tiff, webp_with, with_segment,
};
use crate::support::png::{chunk, deflated, indexed, with_chunks};

/// Colours within the gamuts of both spaces.
const COLOURS: [[u8; 3]; 6] = [
    [200, 100, 50],
    [90, 140, 110],
    [128, 128, 128],
    [60, 70, 160],
    [230, 220, 200],
    [20, 30, 24],
];

/// From linear Display P3 to linear sRGB: both have the white D65, so that it is inv(M of sRGB) × M of P3.
const SRGB_FROM_P3: [[f64; 3]; 3] = [
    [1.224_940_18, -0.224_940_18, 0.0],
    [-0.042_056_95, 1.042_056_95, 0.0],
    [-0.019_637_55, -0.078_636_05, 1.098_273_60],
];

fn encode(light: f64) -> f64 {
    let light = light.clamp(0.0, 1.0);
    255.0
        * if light <= 0.003_130_8 {
            12.92 * light
        } else {
            1.055 * light.powf(1.0 / 2.4) - 0.055
        }
}

fn converted(colour: [u8; 3], decode: impl Fn(f64) -> f64, matrix: [[f64; 3]; 3]) -> [f64; 3] {
    let light = colour.map(|value| decode(f64::from(value) / 255.0));
    matrix.map(|row| encode(row.iter().zip(light).map(|(m, l)| m * l).sum()))
}

const SAME: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn of_p3(colour: [u8; 3]) -> [f64; 3] {
    converted(colour, srgb_to_linear, SRGB_FROM_P3)
}

fn assert_near(found: [u8; 4], expected: [f64; 3], tolerance: f64, what: &str) {
    for c in 0..3 {
        let off = (f64::from(found[c]) - expected[c]).abs();
        assert!(
            off <= tolerance,
            "{what}: {found:?} instead of {expected:?}"
        );
    }
}

fn picture() -> DynamicImage {
    RgbImage::from_fn(6, 1, |x, _| Rgb(COLOURS[x as usize])).into()
}

/// A PNG's profile: a name, a method, and the data deflated.
fn iccp(profile: &[u8]) -> Vec<u8> {
    chunk(
        b"iCCP",
        &[&b"some name\0\0"[..], &deflated(profile)].concat(),
    )
}

fn big(numbers: &[u32]) -> Vec<u8> {
    numbers
        .iter()
        .flat_map(|number| number.to_be_bytes())
        .collect()
}

#[test]
fn a_profile_is_heeded_in_every_format_that_carries_one() {
    let folder = PictureFolder::new();
    let profile = ColorProfile::new_display_p3().encode().unwrap();
    let png = encoded(&picture(), ImageFormat::Png);
    let deep = encoded(&picture().to_rgb16().into(), ImageFormat::Png);
    let webp = encoded(&picture(), ImageFormat::WebP);
    let pixels = COLOURS.as_flattened();
    let tags = [
        (258, Values::Shorts(&[8, 8, 8])),
        (262, Values::Shorts(&[2])),
        (277, Values::Shorts(&[3])),
        (34675, Values::Bytes(&profile)),
    ];
    let numbers: Vec<u8> = (0..6).collect();
    let palette = indexed(6, &COLOURS, &[], &numbers);
    let files = [
        ("png", with_chunks(png.clone(), &[iccp(&profile)])),
        ("png of 16 bits", with_chunks(deep, &[iccp(&profile)])),
        ("png of a palette", with_chunks(palette, &[iccp(&profile)])),
        (
            "webp",
            webp_with(&webp, [6, 1], 0x20, &[(b"ICCP", &profile)]),
        ),
        ("tiff", tiff(false, [6, 1], &tags, pixels)),
        ("bmp", bmp_with_profile(&profile)),
    ];
    for (name, file) in files {
        for (pixel, colour) in all(&folder.chart(&file)).into_iter().zip(COLOURS) {
            assert_near(pixel, of_p3(colour), 0.75, name);
        }
        let red = folder.chart(&file).pixel(0, 0)[0];
        assert!(red > COLOURS[0][0] + 5, "{name}: converted, {red}");
        // What the numbers of a nap map and a height picture say is not colour.
        let nap = colours(folder.read(ImageSlot::Nap, &file).unwrap().pixels);
        let kept: Vec<[u8; 4]> = COLOURS.map(|[r, g, b]| [r, g, b, 255]).to_vec();
        assert_eq!(all(&nap), kept, "{name}");
        let height = heights(folder.read(ImageSlot::Height, &file).unwrap().pixels);
        assert_eq!(height.row(0)[2], 128 * 257, "{name}");
    }
    let grey = folder.chart(&encoded(&picture(), ImageFormat::Png));
    assert_eq!(
        grey.pixel(0, 0),
        [200, 100, 50, 255],
        "sRGB where nothing is said"
    );
}

/// A BMP of the fifth version, one row of 24 bits a pixel.
fn bmp_with_profile(profile: &[u8]) -> Vec<u8> {
    let row: Vec<u8> = COLOURS.iter().flat_map(|&[r, g, b]| [b, g, r]).collect();
    let row = [&row[..], &[0; 2]].concat();
    let mut header = vec![0; 124];
    for (at, value) in [
        (0, 124_u32),
        (4, 6),
        (8, 1),
        (12, 1 | 24 << 16),
        (112, 124 + row.len() as u32),
        (116, profile.len() as u32),
    ] {
        header[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    header[56..60].copy_from_slice(b"DEBM");
    let mut file = b"BM".to_vec();
    file.extend([0; 8]);
    file.extend((14 + 124_u32).to_le_bytes());
    [file, header, row, profile.to_vec()].concat()
}

#[test]
fn jpegs_with_profiles_of_colours_and_of_greys_are_converted() {
    let folder = PictureFolder::new();
    let profile = ColorProfile::new_display_p3().encode().unwrap();
    let tile = RgbImage::from_pixel(16, 16, Rgb([200, 100, 50]));
    let jpeg = encoded(&tile.into(), ImageFormat::Jpeg);
    let plain = folder.chart(&jpeg).pixel(8, 8);
    // In two parts, as large ones are.
    let (first, second) = profile.split_at(profile.len() / 2);
    let part = |k: u8, data: &[u8]| [&b"ICC_PROFILE\0"[..], &[k, 2], data].concat();
    let file = with_segment(jpeg.clone(), 0xe2, &part(2, second));
    let file = with_segment(file, 0xe2, &part(1, first));
    let found = folder.chart(&file).pixel(8, 8);
    assert_near(found, of_p3([plain[0], plain[1], plain[2]]), 1.0, "jpeg");

    let grey = jpeg_of_blocks(&[&[100], &[30]]);
    let gamma = ColorProfile::new_gray_with_gamma(1.0).encode().unwrap();
    let whole = [&b"ICC_PROFILE\0\x01\x01"[..], &gamma].concat();
    let file = with_segment(grey.clone(), 0xe2, &whole);
    assert_eq!(folder.chart(&grey).pixel(0, 0), [100, 100, 100, 255]);
    let expected = [encode(100.0 / 255.0); 3];
    assert_near(
        folder.chart(&file).pixel(0, 0),
        expected,
        1.0,
        "linear grey",
    );

    // Surroundings become light by their profile.
    let sky = RgbImage::from_pixel(16, 8, Rgb([200, 100, 50]));
    let sky = encoded(&sky.into(), ImageFormat::Png);
    let sky = folder.sky(&with_chunks(sky, &[iccp(&profile)])).unwrap();
    let light = sky.pixel(3, 3);
    for (c, expected) in of_p3([200, 100, 50]).into_iter().enumerate() {
        let expected = srgb_to_linear(expected / 255.0);
        assert!((f64::from(light[c]) - expected).abs() < 2e-4, "{light:?}");
    }
}

#[test]
fn profiles_of_srgb_change_nothing_and_broken_ones_are_told() {
    let folder = PictureFolder::new();
    let png = encoded(&picture(), ImageFormat::Png);
    let plain = folder.chart(&png);
    let mut srgb = ColorProfile::new_srgb();
    srgb.cicp = None;
    let file = with_chunks(png.clone(), &[iccp(&srgb.encode().unwrap())]);
    assert_eq!(folder.chart(&file), plain);
    // Not quite its curve, and beyond a step of it.
    let mut other = srgb.clone();
    let curve = Some(curve_from_gamma(2.2));
    (other.red_trc, other.green_trc, other.blue_trc) = (curve.clone(), curve.clone(), curve);
    let file = with_chunks(png.clone(), &[iccp(&other.encode().unwrap())]);
    assert_ne!(folder.chart(&file), plain);

    let broken = with_chunks(png.clone(), &[iccp(b"no profile")]);
    let torn = with_chunks(png.clone(), &[chunk(b"iCCP", b"name\0\0not deflated")]);
    let profile = ColorProfile::new_gray_with_gamma(2.2).encode().unwrap();
    let of_greys = with_chunks(png.clone(), &[iccp(&profile)]);
    let mut jpeg = jpeg_of_blocks(&[&[100]]);
    jpeg = with_segment(jpeg, 0xe2, b"ICC_PROFILE\0\x01\x02half");
    for (file, says) in [
        (
            broken,
            "chart image: has a colour profile that cannot be read (",
        ),
        (
            torn,
            "chart image: has a colour profile that cannot be read (it is broken)",
        ),
        (
            of_greys,
            "chart image: has a colour profile for Gray, but its pixels are red, green and blue",
        ),
        (
            jpeg,
            "chart image: has a colour profile that cannot be read (it is broken)",
        ),
    ] {
        let (_, warnings) = folder.chart_and_warnings(&file);
        let [warning] = warnings.as_slice() else {
            panic!("{says}: {warnings:?}");
        };
        assert!(warning.contains(says), "{warning}\ninstead of {says}");
        assert!(
            warning.ends_with("): its colours are taken as sRGB")
                || warning.ends_with("blue: its colours are taken as sRGB"),
            "{warning}"
        );
        // Numbers that are no colours have no use for it.
        let nap = folder.read(ImageSlot::Nap, &file).unwrap();
        assert_eq!(nap.warnings, [""; 0]);
    }
}

#[test]
fn what_a_png_says_of_its_colours_without_a_profile_is_heeded() {
    let folder = PictureFolder::new();
    let png = encoded(&picture(), ImageFormat::Png);
    let plain = folder.chart(&png);
    let gamma = |exponent: u32| chunk(b"gAMA", &big(&[exponent]));
    let p3 = big(&[31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000]);
    let srgb = big(&[31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000]);
    let with = |chunks: &[Vec<u8>]| with_chunks(png.clone(), chunks);
    for (name, file) in [
        (
            "as programs write sRGB",
            with(&[gamma(45455), chunk(b"cHRM", &srgb)]),
        ),
        (
            "sRGB is weightier",
            with(&[chunk(b"sRGB", &[0]), gamma(100_000)]),
        ),
        (
            "code points of sRGB",
            with(&[chunk(b"cICP", &[1, 13, 0, 1]), gamma(100_000)]),
        ),
    ] {
        assert_eq!(folder.chart(&file), plain, "{name}");
    }
    let cube = |value: f64| value.powf(1.8);
    for (name, file, expected) in [
        (
            "linear",
            with(&[gamma(100_000)]),
            [
                encode(200.0 / 255.0),
                encode(100.0 / 255.0),
                encode(50.0 / 255.0),
            ],
        ),
        (
            "1/1.8",
            with(&[gamma(55556)]),
            converted(COLOURS[0], cube, SAME),
        ),
        ("primaries", with(&[chunk(b"cHRM", &p3)]), of_p3(COLOURS[0])),
        (
            "code points",
            with(&[chunk(b"cICP", &[12, 13, 0, 1])]),
            of_p3(COLOURS[0]),
        ),
        (
            "both",
            with(&[gamma(55556), chunk(b"cHRM", &p3)]),
            converted(COLOURS[0], cube, SRGB_FROM_P3),
        ),
    ] {
        assert_near(folder.chart(&file).pixel(0, 0), expected, 0.75, name);
    }
    let line = big(&[31270, 32900, 10000, 10000, 20000, 20000, 30000, 30000]);
    for (file, says) in [
        (
            with(&[chunk(b"cHRM", &line)]),
            "chromaticities are those of no colours",
        ),
        (with(&[gamma(0)]), "its gamma is 0"),
        (
            with(&[chunk(b"cICP", &[99, 13, 0, 1])]),
            "its code points are 99, 13, 0, 1",
        ),
        (
            with(&[chunk(b"cICP", &[1, 13, 0, 0])]),
            "its code points are 1, 13, 0, 0",
        ),
    ] {
        let (chart, warnings) = folder.chart_and_warnings(&file);
        assert!(warnings[0].contains(says), "{warnings:?}");
        assert_eq!(chart, plain);
    }
}

/// Colour of a Lab value of 8 bits under D50, by the definitions of CIE, Bradford and sRGB.
fn of_lab([l, a, b]: [u8; 3]) -> [f64; 3] {
    let l = (f64::from(l) * 100.0 / 255.0 + 16.0) / 116.0;
    let (a, b) = (
        (f64::from(a) - 128.0) / 500.0,
        (f64::from(b) - 128.0) / 200.0,
    );
    let f = |t: f64| {
        if t > 6.0 / 29.0 {
            t.powi(3)
        } else {
            (t - 4.0 / 29.0) * 108.0 / 841.0
        }
    };
    let xyz = [0.9642 * f(l + a), f(l), 0.8249 * f(l - b)];
    // From X, Y, Z under D50 to linear sRGB, Bradford's adaptation within.
    [
        [3.133_856_1, -1.616_866_7, -0.490_614_6],
        [-0.978_768_4, 1.916_141_5, 0.033_454_0],
        [0.071_945_3, -0.228_991_4, 1.405_242_7],
    ]
    .map(|row| encode(row.iter().zip(xyz).map(|(m, v)| m * v).sum()))
}

#[test]
fn inks_are_converted_by_their_profile_and_else_estimated() {
    let folder = PictureFolder::new();
    let lab = |inks: [bool; 4]| match inks {
        [_, _, _, true] => [40, 128, 128],
        [true, false, false, false] => [150, 100, 96],
        [false, true, false, false] => [130, 190, 120],
        [false, false, false, false] => [250, 128, 130],
        _ => [90, 130, 140],
    };
    let profile = profile_of_inks(lab);
    let part = [&b"ICC_PROFILE\0\x01\x01"[..], &profile].concat();
    let adobe = |transform: u8| [&b"Adobe\0\x64\0\0\0\0"[..], &[transform]].concat();
    let whole = [
        ([255, 0, 0, 0], of_lab(lab([true, false, false, false]))),
        ([0, 255, 0, 0], of_lab(lab([false, true, false, false]))),
        ([0, 0, 0, 0], of_lab(lab([false; 4]))),
        ([0, 0, 0, 255], of_lab(lab([false, false, false, true]))),
    ];
    let estimate = [
        [0.0, 255.0, 255.0],
        [255.0, 0.0, 255.0],
        [255.0; 3],
        [0.0; 3],
    ];
    let inverted = whole.map(|(inks, _)| inks.map(|ink: u8| 255 - ink));
    // Y, Cb and Cr of what Adobe's programs store of the first three: not what is left of the inks, but the inks.
    let ycck = whole.map(|([c, m, y, k], _)| {
        let [r, g, b] = [c, m, y].map(f64::from);
        let luma = 0.299 * r + 0.587 * g + 0.114 * b;
        let coded = [luma, 128.0 + (b - luma) / 1.772, 128.0 + (r - luma) / 1.402];
        let [y, cb, cr] = coded.map(|value| value.round().clamp(0.0, 255.0) as u8);
        [y, cb, cr, 255 - k]
    });
    let slices =
        |blocks: &[[u8; 4]]| jpeg_of_blocks(&blocks.iter().map(|b| &b[..]).collect::<Vec<_>>());
    let plain: Vec<[u8; 4]> = whole.iter().map(|(inks, _)| *inks).collect();
    let tags = |icc: bool| {
        let mut tags = vec![
            (258, Values::Shorts(&[8, 8, 8, 8])),
            (262, Values::Shorts(&[5])),
            (277, Values::Shorts(&[4])),
        ];
        if icc {
            tags.push((34675, Values::Bytes(&profile)));
        }
        tags
    };
    let in_eights: Vec<u8> = plain.iter().flat_map(|p| p.repeat(8)).collect();
    let print = |icc: bool| tiff(false, [32, 1], &tags(icc), &in_eights);
    // The library's own table between the corners of the profile's has 8 bits: off by 2 or 3 steps, where an estimate
    // is off by a hundred.
    for (name, bare, tolerance) in [
        (
            "as Adobe writes inks",
            with_segment(slices(&inverted), 0xee, &adobe(0)),
            3.0,
        ),
        (
            "as Adobe writes YCCK",
            with_segment(slices(&ycck), 0xee, &adobe(2)),
            4.0,
        ),
        ("without Adobe's segment", slices(&plain), 3.0),
        ("tiff", print(false), 3.0),
    ] {
        let file = match name {
            "tiff" => print(true),
            _ => with_segment(bare.clone(), 0xe2, &part),
        };
        let chart = folder.chart(&file);
        let (guessed, warnings) = folder.chart_and_warnings(&bare);
        for k in 0..4 {
            let place = format!("{name} {k}");
            assert_near(chart.pixel(8 * k + 4, 0), whole[k].1, tolerance, &place);
            assert_near(guessed.pixel(8 * k + 4, 0), estimate[k], 3.0, &place);
        }
        let says = "has inks (CMYK) and no colour profile: its colours are an estimate";
        assert!(warnings[0].ends_with(says), "{warnings:?}");
    }
}
