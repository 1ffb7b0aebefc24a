//! Differences of pictures, display and picture files, against closed forms; and that they notice what they must.

use renderer_core::design::{Colour, ToneMap, linear_to_srgb, srgb_to_linear};
use renderer_core::image::metrics::{
    max_abs_difference, mean_luminance, nonfinite_pixels, rel_rmse,
};
use renderer_core::image::{
    Aov, Background, Depth, Display, ExrLayer, Picture, encode_exr, encode_png,
    encode_png_gray_alpha,
};

use crate::support::pictures::{gradient, uniform};

const LINEAR: Display = Display {
    exposure: 0.0,
    tone_map: ToneMap::None,
};
const FILMIC: Display = Display {
    exposure: 0.0,
    tone_map: ToneMap::Filmic,
};

#[test]
fn differences_have_their_closed_forms() {
    let truth = uniform([4, 3], [2.0, 2.0, 2.0, 1.0]);
    let brighter = uniform([4, 3], [2.5, 2.5, 2.5, 1.0]);
    assert_eq!(rel_rmse(&brighter, &truth), Ok(0.25));
    assert_eq!(rel_rmse(&truth, &brighter), Ok(0.2));
    assert_eq!(max_abs_difference(&brighter, &truth), Ok(0.5));

    // One channel of one pixel of twelve is 6 off: sqrt(36/36)/2.
    let mut one = truth.clone();
    one.pixels[5][1] = 8.0;
    assert_eq!(rel_rmse(&one, &truth), Ok(0.5));
    assert_eq!(max_abs_difference(&one, &truth), Ok(6.0));
    // The sign of a difference does not matter, nor its cancelling another.
    let mut both = truth.clone();
    (both.pixels[0][0], both.pixels[1][0]) = (3.0, 1.0);
    let expected = (2.0_f64 / 36.0).sqrt() / 2.0;
    assert!((rel_rmse(&both, &truth).unwrap() - expected).abs() < 1e-15);

    let black = uniform([4, 3], [0.0; 4]);
    assert_eq!(rel_rmse(&black, &black), Ok(0.0));
    assert_eq!(rel_rmse(&truth, &black), Ok(f64::INFINITY));
}

#[test]
fn differences_notice_a_swap_a_shift_and_one_value() {
    let picture = gradient([8, 8]);
    assert_eq!(rel_rmse(&picture, &picture), Ok(0.0));
    assert_eq!(max_abs_difference(&picture, &picture), Ok(0.0));

    let mut flipped = picture.clone();
    flipped.pixels.reverse();
    let mut shifted = picture.clone();
    shifted.pixels.rotate_right(1);
    let mut channels = picture.clone();
    for pixel in &mut channels.pixels {
        pixel.swap(0, 2);
    }
    let mut one = picture.clone();
    one.pixels[63][2] += 1e-6;
    for other in [flipped, shifted, channels, one] {
        assert!(rel_rmse(&other, &picture).unwrap() > 1e-8);
        assert!(max_abs_difference(&other, &picture).unwrap() > 5e-7);
    }
}

#[test]
fn differences_of_other_sizes_are_errors_and_nan_stays_nan() {
    let picture = gradient([8, 8]);
    let other = gradient([4, 16]);
    assert!(rel_rmse(&picture, &other).is_err());
    let message = max_abs_difference(&picture, &other)
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "pictures of 8x8 and 4x16 pixels cannot be compared"
    );
    for place in [0, 10, 63] {
        let mut nan = picture.clone();
        nan.pixels[place][1] = f32::NAN;
        assert!(rel_rmse(&nan, &picture).unwrap().is_nan());
        assert!(max_abs_difference(&nan, &picture).unwrap().is_nan());
    }
}

#[test]
fn alpha_does_not_count_as_light() {
    let picture = uniform([2, 2], [0.5, 0.5, 0.5, 1.0]);
    let clear = uniform([2, 2], [0.5, 0.5, 0.5, 0.0]);
    assert_eq!(rel_rmse(&clear, &picture), Ok(0.0));
    assert_eq!(max_abs_difference(&clear, &picture), Ok(0.0));
}

#[test]
fn nonfinite_pixels_are_counted_once_whatever_the_channel() {
    let mut picture = gradient([4, 4]);
    assert_eq!(nonfinite_pixels(&picture), 0);
    picture.pixels[3] = [f32::NAN; 4];
    picture.pixels[7][0] = f32::INFINITY;
    picture.pixels[8][3] = f32::NEG_INFINITY;
    assert_eq!(nonfinite_pixels(&picture), 3);
}

#[test]
fn luminance_is_the_rec_709_mean() {
    let of = |pixel| mean_luminance(&uniform([3, 5], pixel));
    // The weights are decimals, sums of f64 round in the last places.
    for (pixel, expected) in [
        ([1.0, 1.0, 1.0, 0.0], 1.0),
        ([1.0, 0.0, 0.0, 1.0], 0.2126),
        ([0.0, 1.0, 0.0, 1.0], 0.7152),
        ([0.0, 0.0, 1.0, 1.0], 0.0722),
        ([2.0, 0.5, 0.25, 1.0], 0.4252 + 0.3576 + 0.018_05),
    ] {
        assert!((of(pixel) - expected).abs() < 1e-12, "{pixel:?}");
    }
    assert_eq!(mean_luminance(&Picture::default()), 0.0);
}

#[test]
fn srgb_is_iec_61966_2_1() {
    // 188 and 118 are what any colour calculator gives for half and for middle grey's 18 %.
    let byte = |linear: f64| (linear_to_srgb(linear) * 255.0).round();
    assert_eq!(
        [byte(0.0), byte(0.5), byte(0.18), byte(1.0)],
        [0.0, 188.0, 118.0, 255.0]
    );
    // The standard's toe: slope 12.92.
    assert!((linear_to_srgb(0.001) - 0.012_92).abs() < 1e-15);
    // The two pieces meet; the standard's rounded constants leave a step of 1e-7 or so.
    assert!((linear_to_srgb(0.003_130_8 + 1e-12) - linear_to_srgb(0.003_130_8)).abs() < 1e-6);
    for value in 0..=255_u8 {
        let linear = srgb_to_linear(f64::from(value) / 255.0);
        assert!((linear_to_srgb(linear) * 255.0 - f64::from(value)).abs() < 1e-4);
        assert_eq!(
            Colour::from_linear(Colour([value; 3]).linear()),
            Colour([value; 3])
        );
    }
}

#[test]
fn display_exposes_clips_and_keeps_nan_out() {
    let shown = |display: Display, linear: f32| display.encode([linear; 3])[0];
    let exposed = |exposure| Display { exposure, ..LINEAR };
    assert_eq!(shown(exposed(1.0), 0.25), linear_to_srgb(0.5));
    assert_eq!(shown(exposed(-2.0), 1.0), linear_to_srgb(0.25));
    assert_eq!(shown(LINEAR, 0.5), linear_to_srgb(0.5));
    for display in [LINEAR, FILMIC] {
        assert_eq!(shown(display, -1.0), 0.0);
        assert_eq!(shown(display, f32::NAN), 0.0);
        let brightest = shown(display, f32::INFINITY);
        assert!((brightest - 1.0).abs() < 1e-12);
    }
    // The encoding of 1 rounds to 1 − 2⁻⁵³.
    assert!((shown(LINEAR, 7.0) - 1.0).abs() < 1e-15);
    // Each channel by itself.
    let [r, g, b] = LINEAR.encode([0.1, 0.2, 0.3]);
    let expected = [0.1_f32, 0.2, 0.3].map(|c| linear_to_srgb(f64::from(c)));
    assert_eq!([r, g, b], expected);
}

#[test]
fn filmic_is_the_identity_with_a_smooth_shoulder() {
    let light = |linear: f64| srgb_to_linear(FILMIC.encode([linear as f32; 3])[0]);
    // f32 input: seven digits.
    for linear in [0.01, 0.18, 0.5, 0.6] {
        assert!((light(linear) - linear).abs() < 1e-6, "{linear}");
    }
    // 1 − 0.4²/(x − 0.2), MODEL.md leaves the curve to us.
    for (linear, expected) in [(1.0, 0.8), (1.8, 0.9), (16.2, 0.99)] {
        assert!((light(linear) - expected).abs() < 1e-6, "{linear}");
    }
    // No kink where the shoulder begins: slopes on both sides differ by the curvature alone, 5 · step.
    let step = 1e-3;
    let slope = |from: f64| (light(from + step) - light(from)) / step;
    assert!((slope(0.6) - slope(0.6 - step)).abs() < 6.0 * step);
    // Brighter light is never shown darker, and never clipped in this range.
    let values: Vec<f64> = (0..1000).map(|k| light(f64::from(k) * 0.01)).collect();
    assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(values.iter().all(|value| *value < 1.0));
}

fn decode(file: &[u8]) -> image::DynamicImage {
    image::load_from_memory(file).unwrap()
}

#[test]
fn png_holds_the_displayed_picture() {
    let picture = gradient([5, 3]);
    let display = Display {
        exposure: -0.5,
        tone_map: ToneMap::Filmic,
    };
    let eight = decode(&encode_png(&picture, display, Depth::Eight, None).unwrap());
    let sixteen = decode(&encode_png(&picture, display, Depth::Sixteen, None).unwrap());
    assert_eq!(
        [eight.color(), sixteen.color()],
        [image::ColorType::Rgb8, image::ColorType::Rgb16]
    );
    let (eight, sixteen) = (eight.into_rgb8(), sixteen.into_rgb16());
    assert_eq!(eight.dimensions(), (5, 3));
    let positions = (0..3).flat_map(|y| (0..5).map(move |x| (x, y)));
    for ((x, y), &[r, g, b, _]) in positions.zip(&picture.pixels) {
        let shown = display.encode([r, g, b]);
        let expected = shown.map(|c| (c * 255.0).round() as u8);
        assert_eq!(eight.get_pixel(x, y).0, expected);
        let expected = shown.map(|c| (c * 65535.0).round() as u16);
        assert_eq!(sixteen.get_pixel(x, y).0, expected);
    }
}

#[test]
fn transparent_png_has_the_cloths_own_colour() {
    let background = Background([0.5, 0.25, 1.0]);
    // Cloth of the colour (0.2, 0.4, 0.6) that covers all, half and nothing of a pixel.
    let cloth = [0.2_f32, 0.4, 0.6];
    let over = |alpha: f32| {
        let channel = |c: usize| alpha * cloth[c] + (1.0 - alpha) * background.0[c] as f32;
        [channel(0), channel(1), channel(2), alpha]
    };
    let picture = Picture {
        size: [3, 1],
        pixels: [1.0, 0.5, 0.0].map(over).to_vec(),
        aov: None,
    };
    let file = encode_png(&picture, LINEAR, Depth::Sixteen, Some(background)).unwrap();
    let shown = decode(&file).into_rgba16();
    let expected = LINEAR.encode(cloth).map(|c| (c * 65535.0).round() as i32);
    for (x, alpha) in [(0, 65535), (1, 32768)] {
        let [r, g, b, a] = shown.get_pixel(x, 0).0.map(i32::from);
        assert_eq!(a, alpha);
        for (found, expected) in [r, g, b].into_iter().zip(expected) {
            // One f32 rounding of a colour near a half is a thousandth of a 16-bit step; sRGB's slope adds some.
            assert!((found - expected).abs() <= 1, "{found} {expected}");
        }
    }
    assert_eq!(shown.get_pixel(2, 0).0, [0; 4]);
}

#[test]
fn gray_png_keeps_its_bytes() {
    let pixels: Vec<[u8; 2]> = (0..6).map(|k| [40 * k, 255 - k]).collect();
    let image = decode(&encode_png_gray_alpha([3, 2], &pixels).unwrap()).into_luma_alpha8();
    assert_eq!(image.dimensions(), (3, 2));
    assert_eq!(image.into_raw(), pixels.as_flattened());
}

#[test]
fn exr_keeps_every_float() {
    use exr::prelude::{ReadChannels, ReadLayers};
    let mut picture = gradient([3, 2]);
    picture.pixels[0] = [1e30, 1e-40, -0.5, 0.25];
    picture.pixels[5] = [65504.0, 65536.5, 1.0 + f32::EPSILON, 1.0];
    picture.aov = Some(Aov {
        depth: (0..6).map(|k| 100.0 + k as f32 / 3.0).collect(),
        normal: (0..6).map(|k| [k as f32, -1.0, 0.5]).collect(),
        albedo: (0..6).map(|k| [0.9, 0.8, k as f32 / 7.0]).collect(),
        ..Aov::default()
    });
    let layers = [
        ExrLayer::Depth,
        ExrLayer::Normal,
        ExrLayer::Albedo,
        ExrLayer::Alpha,
    ];
    let file = encode_exr(&picture, &layers, None).unwrap();
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(file))
        .unwrap();
    let channel = |name: &str| -> Vec<f32> {
        let mut list = image.layer_data.channel_data.list.iter();
        let found = list.find(|channel| channel.name.to_string() == name);
        found.unwrap().sample_data.values_as_f32().collect()
    };
    let aov = picture.aov.as_ref().unwrap();
    let pixel = |c: usize| -> Vec<f32> { picture.pixels.iter().map(|p| p[c]).collect() };
    let part = |list: &[[f32; 3]], c: usize| -> Vec<f32> { list.iter().map(|v| v[c]).collect() };
    for (name, expected) in [
        ("R", pixel(0)),
        ("G", pixel(1)),
        ("B", pixel(2)),
        ("alpha.A", pixel(3)),
        ("depth.Z", aov.depth.clone()),
        ("normal.X", part(&aov.normal, 0)),
        ("normal.Y", part(&aov.normal, 1)),
        ("normal.Z", part(&aov.normal, 2)),
        ("albedo.R", part(&aov.albedo, 0)),
        ("albedo.G", part(&aov.albedo, 1)),
        ("albedo.B", part(&aov.albedo, 2)),
    ] {
        assert_eq!(channel(name), expected, "{name}");
    }
    assert_eq!(image.layer_data.channel_data.list.len(), 11);
}
