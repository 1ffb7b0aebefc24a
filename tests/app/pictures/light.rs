//! Pictures of light: Radiance files with all that their headers may say, and OpenEXR files as programs write them.

use std::io::Cursor;

use exr::meta::attribute::Chromaticities;
use exr::prelude::*;

use super::PictureFolder;
use renderer_core::design::{EnvironmentImage, ImageSlot};

/// A pixel of 4 columns and 2 rows, with a shared exponent.
fn rgbe(x: usize, y: usize) -> [u8; 4] {
    [10 * (x as u8 + 1), 100 + 20 * y as u8, 200, 129]
}

fn value([r, g, b, exponent]: [u8; 4]) -> [f32; 3] {
    [r, g, b].map(|v| f32::from(v) * 2_f32.powi(i32::from(exponent) - 136))
}

/// A file of 4 columns and 2 rows, upright first and not coded.
fn hdr(header: &str, size: &str, pixels: impl IntoIterator<Item = [u8; 4]>) -> Vec<u8> {
    let mut file = format!("{header}\n{size}\n").into_bytes();
    file.extend(pixels.into_iter().flatten());
    file
}

fn upright() -> Vec<[u8; 4]> {
    (0..8).map(|k| rgbe(k % 4, k / 4)).collect()
}

const PLAIN: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n";

fn assert_is(sky: &EnvironmentImage, expected: impl Fn(usize, usize) -> [f32; 3], what: &str) {
    assert_eq!((sky.width(), sky.height()), (4, 2), "{what}");
    for (x, y) in (0..2).flat_map(|y| (0..4).map(move |x| (x, y))) {
        let (found, expected) = (sky.pixel(x, y), expected(x, y));
        for c in 0..3 {
            let near = (found[c] - expected[c]).abs() <= 1e-4 * expected[c].abs().max(1e-3);
            assert!(near, "{what}, {x} {y}: {found:?} instead of {expected:?}");
        }
    }
}

#[test]
fn every_order_of_axes_and_every_name_in_the_first_line_is_read() {
    let folder = PictureFolder::new();
    for first in ["#?RADIANCE", "#?RGBE", "#?made by hand"] {
        let header = format!("{first}\r\n# a note\r\nFORMAT=32-bit_rle_rgbe\r\n\r");
        let sky = folder.sky(&hdr(&header, "-Y 2 +X 4", upright())).unwrap();
        assert_is(&sky, |x, y| value(rgbe(x, y)), first);
    }
    for (size, by_columns, mirrored, upside_down) in [
        ("-Y 2 +X 4", false, false, false),
        ("-Y 2 -X 4", false, true, false),
        ("+Y 2 +X 4", false, false, true),
        ("+Y 2 -X 4", false, true, true),
        ("+X 4 -Y 2", true, false, false),
        ("-X 4 -Y 2", true, true, false),
        ("+X 4 +Y 2", true, false, true),
        ("-X 4 +Y 2", true, true, true),
    ] {
        let pixel = |x: usize, y: usize| {
            let x = if mirrored { 3 - x } else { x };
            rgbe(x, if upside_down { 1 - y } else { y })
        };
        let pixels = (0..8).map(|k| match by_columns {
            false => pixel(k % 4, k / 4),
            true => pixel(k / 2, k % 2),
        });
        let sky = folder.sky(&hdr(PLAIN, size, pixels)).unwrap();
        assert_is(&sky, |x, y| value(rgbe(x, y)), size);
    }
}

#[test]
fn exposure_colour_correction_and_primaries_are_undone() {
    let folder = PictureFolder::new();
    let lines =
        "EXPOSURE=50\nEXPOSURE= 2.0\nCOLORCORR=1 2 4\nCOLORCORR= 0.5 1 0.25\nEXPOSURE is a word\n";
    let file = hdr(&format!("{PLAIN}{lines}"), "-Y 2 +X 4", upright());
    let undone = |x, y| {
        let [r, g, b] = value(rgbe(x, y));
        [r / 50.0, g / 200.0, b / 100.0]
    };
    assert_is(&folder.sky(&file).unwrap(), undone, "both");

    // X, Y and Z of white are all 1, and so are red, green and blue.
    let header = "#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_xyze\n";
    let white = vec![[128, 128, 128, 129]; 8];
    let sky = folder.sky(&hdr(header, "-Y 2 +X 4", white)).unwrap();
    assert_is(&sky, |_, _| [0.5; 3], "white");
    // X, Y, Z of sRGB's red, scaled as cones see it (Bradford) from D65 to equal energy: what is left is red.
    let red = [112, 58, 3, 128];
    let sky = folder.sky(&hdr(header, "-Y 2 +X 4", vec![red; 8])).unwrap();
    let [r, g, b] = sky.pixel(0, 0);
    assert!(r > 0.4 && g.abs() < 0.01 && b.abs() < 0.01, "{r} {g} {b}");

    let p3 = "PRIMARIES=0.68 0.32 0.265 0.69 0.15 0.06 0.3127 0.3290\n";
    let file = hdr(
        &format!("{PLAIN}{p3}"),
        "-Y 2 +X 4",
        vec![[128, 64, 32, 129]; 8],
    );
    let of_p3 = |_, _| {
        [
            1.224_94 - 0.112_47,
            0.521_03 - 0.042_06,
            0.274_57 - 0.019_64 - 0.039_32,
        ]
    };
    assert_is(&folder.sky(&file).unwrap(), of_p3, "Display P3");
    let none = format!("{PLAIN}PRIMARIES=0 0 0 0 0 0 0 0\n");
    let loaded = folder
        .read(ImageSlot::Environment, &hdr(&none, "-Y 2 +X 4", upright()))
        .unwrap();
    assert!(
        loaded.warnings[0].contains("has PRIMARIES=0 0 0 0 0 0 0 0, which are"),
        "{:?}",
        loaded.warnings
    );
}

#[test]
fn runs_old_and_new_are_read_and_broken_ones_refused() {
    let folder = PictureFolder::new();
    // Old: the last pixel once more n times, and n times 256 where it follows at once.
    let old = [
        rgbe(0, 0),
        [1, 1, 1, 3],
        rgbe(3, 1),
        rgbe(2, 1),
        [1, 1, 1, 2],
    ];
    let sky = folder.sky(&hdr(PLAIN, "-Y 2 +X 4", old)).unwrap();
    assert_eq!(sky.pixel(3, 0), value(rgbe(0, 0)));
    assert_eq!(
        [0, 1, 3].map(|x| sky.pixel(x, 1)),
        [rgbe(3, 1), rgbe(2, 1), rgbe(2, 1)].map(value)
    );
    let long = |count: u8, shifted: u8| {
        let row = [rgbe(0, 0), [1, 1, 1, count], [1, 1, 1, shifted]];
        let rows = row.repeat(257);
        hdr(PLAIN, "-Y 257 +X 514", rows)
    };
    assert!(folder.sky(&long(1, 2)).is_ok());
    assert!(
        folder
            .sky(&long(2, 2))
            .unwrap_err()
            .contains("is longer than the picture is wide")
    );
    // New, a channel after the other: a run, and pixels as they are.
    let row = |tail: &[u8]| {
        let mut row = vec![2, 2, 0, 8, 128 + 8, 7, 3, 1, 2, 3];
        row.extend(tail);
        row.extend([128 + 8, 9, 128 + 8, 129]);
        row
    };
    let file = |row: Vec<u8>| {
        let mut file = format!("{PLAIN}\n-Y 4 +X 8\n").into_bytes();
        file.extend(row.repeat(4));
        file
    };
    let sky = folder.sky(&file(row(&[128 + 4, 4, 1, 5]))).unwrap();
    let expected = [1, 2, 3, 4, 4, 4, 4, 5].map(|green| value([7, green, 9, 129]));
    assert_eq!(
        (0..8).map(|x| sky.pixel(x, 3)).collect::<Vec<_>>(),
        expected
    );
    for (bytes, says) in [
        (
            file(row(&[128 + 6, 4])),
            "is broken: line 1 of its pixels is longer",
        ),
        (
            file(row(&[0])),
            "is broken: line 1 of its pixels has a run of no pixels",
        ),
        (
            file(vec![2, 2, 0, 9]),
            "is broken: line 1 of its pixels has another length",
        ),
        (
            hdr(PLAIN, "-Y 2 +X 4", upright()[..6].to_vec()),
            "is broken: line 2 of its pixels is cut off",
        ),
        (
            hdr(PLAIN, "-Y 2 +X 4", [[1; 4]; 8]),
            "is broken: line 1 of its pixels begins with a repetition",
        ),
        (
            hdr(PLAIN, "-Y 2 *X 4", upright()),
            "its size is given as \"-Y 2 *X 4\", allowed are such as",
        ),
        (
            hdr(PLAIN, "-Y 2 +Y 4", upright()),
            "its size is given as \"-Y 2 +Y 4\"",
        ),
        (
            hdr("#?RGBE\nFORMAT=16-bit\n", "-Y 2 +X 4", upright()),
            "has FORMAT=16-bit, allowed are 32-bit_rle_rgbe and",
        ),
        (
            hdr("#?RGBE\nEXPOSURE=0\n", "-Y 2 +X 4", upright()),
            "its header has EXPOSURE=0, allowed is a number above 0",
        ),
        (
            hdr("#?RGBE\nCOLORCORR=1 1\n", "-Y 2 +X 4", upright()),
            "its header has COLORCORR=1 1, allowed is 3 numbers above 0",
        ),
        (
            b"#?RGBE\nEXPOSURE=1\n".to_vec(),
            "is broken: it ends in its header",
        ),
    ] {
        let error = folder.sky(&bytes).unwrap_err();
        assert!(error.contains(says), "{error}\ninstead of {says}");
    }
}

/// A layer of a file: its name, where its data window lies and how large it is, and its channels, each of one value
/// more a pixel.
struct Part {
    name: &'static str,
    position: [i32; 2],
    size: [usize; 2],
    channels: Vec<(&'static str, f32)>,
}

fn part(channels: &[(&'static str, f32)]) -> Part {
    Part {
        name: "",
        position: [0, 0],
        size: [4, 2],
        channels: channels.to_vec(),
    }
}

fn exr(
    display: ([i32; 2], [usize; 2]),
    parts: Vec<Part>,
    primaries: Option<Chromaticities>,
) -> Vec<u8> {
    let ([x, y], [width, height]) = display;
    let bounds = IntegerBounds::new(Vec2(x, y), Vec2(width, height));
    let mut attributes = ImageAttributes::new(bounds);
    attributes.chromaticities = primaries;
    let layers: SmallVec<[_; 2]> = parts
        .into_iter()
        .map(|part| {
            let count = part.size[0] * part.size[1];
            let channels = part.channels.iter().map(|(name, first)| {
                let samples = (0..count).map(|k| first + k as f32).collect();
                AnyChannel::new(*name, FlatSamples::F32(samples))
            });
            let mut about = LayerAttributes::named(part.name);
            about.layer_position = Vec2(part.position[0], part.position[1]);
            Layer::new(
                Vec2(part.size[0], part.size[1]),
                about,
                Encoding::FAST_LOSSLESS,
                AnyChannels::sort(channels.collect()),
            )
        })
        .collect();
    let image = Image::empty(attributes);
    let image = Image {
        layer_data: layers,
        attributes: image.attributes,
    };
    let mut file = Cursor::new(Vec::new());
    image.write().to_buffered(&mut file).unwrap();
    file.into_inner()
}

const WHOLE: ([i32; 2], [usize; 2]) = ([0, 0], [4, 2]);
const RGB: [(&str, f32); 3] = [("R", 0.0), ("G", 100.0), ("B", 200.0)];

#[test]
fn a_data_window_is_placed_in_the_display_window() {
    let folder = PictureFolder::new();
    let place = |position, size, display| {
        let part = Part {
            position,
            size,
            ..part(&RGB)
        };
        folder.sky(&exr(display, vec![part], None)).unwrap()
    };
    // Smaller: the rest is black.
    let sky = place([1, 1], [2, 1], WHOLE);
    let small = |x, y| match (x, y) {
        (1, 1) => [0.0, 100.0, 200.0],
        (2, 1) => [1.0, 101.0, 201.0],
        _ => [0.0; 3],
    };
    assert_is(&sky, small, "smaller");
    // Larger: what lies beside is left out. Windows may begin anywhere.
    let sky = place([-12, 5], [8, 5], ([-10, 7], [4, 2]));
    let cropped = |x: usize, y: usize| {
        let k = (x + 2 + 8 * (y + 2)) as f32;
        [k, 100.0 + k, 200.0 + k]
    };
    assert_is(&sky, cropped, "larger");
    let file = exr(
        WHOLE,
        vec![Part {
            size: [16385, 1],
            ..part(&RGB)
        }],
        None,
    );
    let error = folder.sky(&file).unwrap_err();
    assert!(
        error.contains("has a data window of 16385 x 1 pixels, allowed are at most 16384 x 8192"),
        "{error}"
    );
}

#[test]
fn layers_of_blender_and_krita_and_greys_are_found() {
    let folder = PictureFolder::new();
    let passes = [
        ("ViewLayer.AO.R", 7.0),
        ("ViewLayer.AO.G", 7.0),
        ("ViewLayer.AO.B", 7.0),
        ("ViewLayer.Combined.R", 0.0),
        ("ViewLayer.Combined.G", 100.0),
        ("ViewLayer.Combined.B", 200.0),
        ("ViewLayer.Combined.A", 1.0),
        ("ViewLayer.Depth.Z", 9.0),
    ];
    let of_krita = [
        ("sky.R", 0.0),
        ("sky.G", 100.0),
        ("sky.B", 200.0),
        ("trees.R", 5.0),
        ("trees.G", 5.0),
        ("trees.B", 5.0),
    ];
    let named = |name, channels: &[(&'static str, f32)]| Part {
        name,
        ..part(channels)
    };
    let colours = |x, y| {
        let k = (x + 4 * y) as f32;
        [k, 100.0 + k, 200.0 + k]
    };
    for (name, parts) in [
        ("Blender's passes", vec![part(&passes)]),
        ("Krita's layers", vec![part(&of_krita)]),
        (
            "parts",
            vec![
                named("depth", &[("Z", 3.0)]),
                named("sky", &RGB),
                named("later", &[("R", 9.0), ("G", 9.0), ("B", 9.0)]),
            ],
        ),
        (
            "beside others",
            vec![part(&[
                ("R", 0.0),
                ("G", 100.0),
                ("B", 200.0),
                ("a.R", 9.0),
                ("a.G", 9.0),
                ("a.B", 9.0),
                ("Y", 1.0),
            ])],
        ),
    ] {
        assert_is(
            &folder.sky(&exr(WHOLE, parts, None)).unwrap(),
            colours,
            name,
        );
    }
    let grey = |x: usize, y: usize| [(x + 4 * y) as f32 + 2.0; 3];
    for channels in [[("Y", 2.0), ("A", 1.0)], [("sky.Y", 2.0), ("sky.A", 1.0)]] {
        assert_is(
            &folder
                .sky(&exr(WHOLE, vec![part(&channels)], None))
                .unwrap(),
            grey,
            "grey",
        );
    }
    let error = folder.sky(&exr(
        WHOLE,
        vec![part(&[
            ("Z", 1.0),
            ("left.R", 1.0),
            ("left.G", 1.0),
            ("right.B", 1.0),
        ])],
        None,
    ));
    let says =
        "has no channels R, G and B of one layer, nor a Y; it has Z, left.G, left.R, right.B";
    assert!(
        error.as_ref().is_err_and(|error| error.ends_with(says)),
        "{error:?}"
    );
}

#[test]
fn coarser_chroma_is_told_and_primaries_are_heeded() {
    let folder = PictureFolder::new();
    let mut file = exr(
        WHOLE,
        vec![part(&[("BY", 0.0), ("RY", 0.0), ("Y", 1.0)])],
        None,
    );
    for name in [b"BY\0", b"RY\0"] {
        let at = file.windows(3).position(|window| window == name).unwrap();
        // Behind the name: its type and four bytes, then steps across and down.
        file[at + 11] = 2;
        file[at + 15] = 2;
    }
    let error = folder.sky(&file).unwrap_err();
    let says =
        "has channels that are coarser than the picture (luminance and chroma: Y, RY, BY), allowed";
    assert!(error.contains(says), "{error}");

    let p3 = Chromaticities {
        red: Vec2(0.68, 0.32),
        green: Vec2(0.265, 0.69),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    };
    let channels = [("R", 100.0), ("G", 50.0), ("B", 25.0)];
    let sky = folder
        .sky(&exr(WHOLE, vec![part(&channels)], Some(p3)))
        .unwrap();
    let of_p3 = |x: usize, y: usize| {
        let k = (x + 4 * y) as f32;
        let [r, g, b] = [100.0 + k, 50.0 + k, 25.0 + k];
        [
            1.224_94 * r - 0.224_94 * g,
            1.042_057 * g - 0.042_057 * r,
            1.098_274 * b - 0.019_638 * r - 0.078_636 * g,
        ]
    };
    assert_is(&sky, of_p3, "Display P3");
}
