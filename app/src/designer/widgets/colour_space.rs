//! CIE L*a*b* and its cylinder L*C*h of sRGB colours, for the white of sRGB (D65, 2° observer), as colour atlases of
//! yarns and measuring devices give them.

/// XYZ of linear sRGB (IEC 61966-2-1).
const XYZ: [[f64; 3]; 3] = [
    [0.412_390_8, 0.357_584_3, 0.180_480_8],
    [0.212_639_0, 0.715_168_7, 0.072_192_3],
    [0.019_330_8, 0.119_194_8, 0.950_532_2],
];
/// Linear sRGB of XYZ.
const LINEAR: [[f64; 3]; 3] = [
    [3.240_969_9, -1.537_383_2, -0.498_610_8],
    [-0.969_243_6, 1.875_967_5, 0.041_555_1],
    [0.055_630_1, -0.203_977_0, 1.056_971_5],
];
/// White of sRGB: the sums of the rows of [`XYZ`].
const WHITE: [f64; 3] = [0.950_455_9, 1.0, 1.089_057_8];
/// Where the cube root becomes a line: (6/29)³.
const KNEE: f64 = 216.0 / 24_389.0;

fn times(matrix: [[f64; 3]; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c]| a * x + b * y + c * z)
}

fn decoded(value: f64) -> f64 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn encoded(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

/// L* (0 to 100), a* and b* of a colour.
pub fn lab_of(rgb: [u8; 3]) -> [f64; 3] {
    let xyz = times(XYZ, rgb.map(|value| decoded(f64::from(value) / 255.0)));
    let root = |k: usize| {
        let share = xyz[k] / WHITE[k];
        if share > KNEE {
            share.cbrt()
        } else {
            (24_389.0 / 27.0 * share + 16.0) / 116.0
        }
    };
    let [x, y, z] = [root(0), root(1), root(2)];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// L*, chroma C* and hue h (degrees, 0 to 360) of L*, a* and b*.
pub fn lch_of_lab([l, a, b]: [f64; 3]) -> [f64; 3] {
    [l, a.hypot(b), b.atan2(a).to_degrees().rem_euclid(360.0)]
}

/// L*, a* and b* of L*, C* and h.
pub fn lab_of_lch([l, chroma, hue]: [f64; 3]) -> [f64; 3] {
    let (sine, cosine) = hue.to_radians().sin_cos();
    [l, chroma * cosine, chroma * sine]
}

/// Encoded sRGB, 0 to 1 where a screen shows it.
fn srgb_of([l, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (l + 16.0) / 116.0;
    let roots = [y + a / 500.0, y, y - b / 200.0];
    let part = |k: usize| {
        let cube = roots[k].powi(3);
        let share = if cube > KNEE {
            cube
        } else {
            (116.0 * roots[k] - 16.0) * 27.0 / 24_389.0
        };
        share * WHITE[k]
    };
    times(LINEAR, [part(0), part(1), part(2)]).map(encoded)
}

fn is_shown(srgb: [f64; 3]) -> bool {
    // Half a step of 8 bits beyond the ends rounds to them.
    srgb.iter().all(|value| (-0.002..=1.002).contains(value))
}

/// The colour of L*, C* and h: with the largest chroma up to that which a screen shows. Whether that is all of it.
pub fn rgb_of_lch(lch: [f64; 3]) -> ([u8; 3], bool) {
    let at = |chroma: f64| srgb_of(lab_of_lch([lch[0].clamp(0.0, 100.0), chroma, lch[2]]));
    let bytes = |srgb: [f64; 3]| srgb.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
    if is_shown(at(lch[1])) {
        return (bytes(at(lch[1])), true);
    }
    let (mut shown, mut beyond) = (0.0, lch[1]);
    for _ in 0..24 {
        let middle = 0.5 * (shown + beyond);
        if is_shown(at(middle)) {
            shown = middle;
        } else {
            beyond = middle;
        }
    }
    (bytes(at(shown)), false)
}

/// A colour as people type it: `#1f3a6e`, `1f3a6e`, `#fff`, in capitals too.
pub fn rgb_of_hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.trim().trim_start_matches('#');
    if !digits.is_ascii() || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let number = u32::from_str_radix(digits, 16).ok()?;
    match digits.len() {
        6 => Some([16, 8, 0].map(|by| (number >> by) as u8)),
        3 => Some([8, 4, 0].map(|by| (number >> by & 15) as u8 * 17)),
        _ => None,
    }
}

/// `#1f3a6e`.
pub fn hex_of([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
