//! Oklab (Björn Ottosson, "A perceptual color space for image processing", 2020), in which distances are perceived
//! differences of colour. In f32 and with tables, since charts have millions of pixels, and in f64 for single colours.

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

/// What the three kinds of cones see of linear light.
const CONES: [[f64; 3]; 3] = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];

/// L, a and b of the cube roots of that.
const LAB: [[f64; 3]; 3] = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];

/// The numbers of a matrix in f32.
const fn rounded(m: [[f64; 3]; 3]) -> [[f32; 3]; 3] {
    const fn row([a, b, c]: [f64; 3]) -> [f32; 3] {
        [a as f32, b as f32, c as f32]
    }
    [row(m[0]), row(m[1]), row(m[2])]
}

/// Oklab of linear light.
#[inline]
pub fn oklab_from_linear([r, g, b]: [f32; 3]) -> [f32; 3] {
    const CONES_F32: [[f32; 3]; 3] = rounded(CONES);
    const LAB_F32: [[f32; 3]; 3] = rounded(LAB);
    let [l, m, s] = CONES_F32.map(|[x, y, z]| (x * r + y * g + z * b).cbrt());
    LAB_F32.map(|[x, y, z]| x * l + y * m + z * s)
}

/// Oklab of an sRGB colour, to the precision of f64.
pub fn precise_oklab(colour: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = colour.map(|value| srgb_to_linear(f64::from(value) / 255.0));
    let [l, m, s] = CONES.map(|[x, y, z]| (x * r + y * g + z * b).cbrt());
    LAB.map(|[x, y, z]| x * l + y * m + z * s)
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
