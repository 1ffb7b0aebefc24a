//! Oklab (Björn Ottosson, "A perceptual color space for image processing", 2020), in which distances are perceived
//! differences of colour. In f32 and with tables, since charts have millions of pixels; lengths of single colours use
//! f64 (`scene/length.rs`).

use std::sync::LazyLock;

use crate::design::srgb_to_linear;

/// Linear light of the 256 values of a channel.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|value| srgb_to_linear(value as f64 / 255.0) as f32));

/// Linear light half way between a value and the next.
static BETWEEN: LazyLock<[f32; 255]> =
    LazyLock::new(|| std::array::from_fn(|v| srgb_to_linear((v as f64 + 0.5) / 255.0) as f32));

/// Linear light of an sRGB colour.
#[inline]
pub(super) fn linear([r, g, b]: [u8; 3]) -> [f32; 3] {
    let table = &*LINEAR;
    [
        table[usize::from(r)],
        table[usize::from(g)],
        table[usize::from(b)],
    ]
}

/// The sRGB colour nearest to linear light; values outside [0, 1] are clipped.
pub fn nearest_srgb(linear: [f32; 3]) -> [u8; 3] {
    let between = &*BETWEEN;
    linear.map(|light| between.partition_point(|&limit| limit <= light) as u8)
}

/// Lightness L, and a (green to red) and b (blue to yellow), of an sRGB colour.
pub fn oklab(colour: [u8; 3]) -> [f32; 3] {
    oklab_from_linear(linear(colour))
}

/// Oklab of linear light.
#[inline]
pub fn oklab_from_linear([r, g, b]: [f32; 3]) -> [f32; 3] {
    let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
    let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
    let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// Linear light of an Oklab colour, which may lie outside [0, 1].
pub fn linear_from_oklab([l, a, b]: [f32; 3]) -> [f32; 3] {
    let cube = |x: f32| x * x * x;
    let long = cube(l + 0.396_337_78 * a + 0.215_803_76 * b);
    let middle = cube(l - 0.105_561_346 * a - 0.063_854_17 * b);
    let short = cube(l - 0.089_484_18 * a - 1.291_485_5 * b);
    [
        4.076_741_7 * long - 3.307_711_6 * middle + 0.230_969_94 * short,
        -1.268_438 * long + 2.609_757_4 * middle - 0.341_319_38 * short,
        -0.004_196_086_3 * long - 0.703_418_6 * middle + 1.707_614_7 * short,
    ]
}

/// Square of the distance of two Oklab colours.
#[inline]
pub(super) fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, m, n] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    l * l + m * m + n * n
}
