//! Nap maps: which way the pile lies, as red and green of an image, as tangent-space normal maps write directions: 128
//! is none, 255 all the way to the right (red) and away from the near edge (green). Combing and smoothing them, and
//! ready ones.
//!
//! Directions here are right and up in the image, each from −1 to 1; pixels count from the upper left.

use super::{ChartImage, OPAQUE_FROM, Sheet};

/// The pixel of pile that lies no way.
pub const UPRIGHT: [u8; 4] = [128, 128, 255, 255];

/// Widest comb, pixels.
pub const LARGEST_COMB: f64 = 256.0;

/// Length and width of a footprint, mm; a stripe of a vacuum cleaner, mm.
const SOLE_MM: [f64; 2] = [285.0, 105.0];
const STRIPE_MM: f64 = 280.0;

/// The direction that a pixel tells; none where it is transparent.
pub fn direction([r, g, _, alpha]: [u8; 4]) -> [f64; 2] {
    if alpha < OPAQUE_FROM {
        return [0.0; 2];
    }
    [r, g].map(|value| ((f64::from(value) - 128.0) / 127.0).max(-1.0))
}

/// The pixel that tells a direction; one that is longer than 1 is shortened.
pub fn pixel(direction: [f64; 2]) -> [u8; 4] {
    let length = direction[0].hypot(direction[1]).max(1.0);
    let [r, g] = direction.map(|part| (128.0 + 127.0 * part / length).round() as u8);
    [r, g, 255, 255]
}

/// Between two directions.
pub(crate) fn mixed(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|k| a[k] + (b[k] - a[k]) * share)
}

/// 1 in the middle, 0 from `1` on, smooth.
fn falloff(distance: f64) -> f64 {
    let x = (1.0 - distance).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Draws a comb of this width, pixels, over the map: pile under it is laid the way the comb goes, by its edges less.
pub fn comb(map: &mut ChartImage, from: [f64; 2], to: [f64; 2], width: f64) {
    let radius = 0.5 * width.clamp(1.0, LARGEST_COMB);
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]);
    if length < 1e-6 {
        return;
    }
    let along = [way[0] / length, -way[1] / length];
    let span = |axis: usize, side: usize| {
        let low = (from[axis].min(to[axis]) - radius).floor().max(0.0) as usize;
        let high = (from[axis].max(to[axis]) + radius).ceil().max(0.0) as usize;
        low..(high + 1).min(side)
    };
    for y in span(1, map.height()) {
        for x in span(0, map.width()) {
            let place = [x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]];
            let share =
                ((place[0] * way[0] + place[1] * way[1]) / (length * length)).clamp(0.0, 1.0);
            let off = [0, 1].map(|k| place[k] - way[k] * share);
            let weight = falloff(off[0].hypot(off[1]) / radius);
            if weight > 0.0 {
                let now = mixed(direction(map.pixel(x, y)), along, weight);
                map.fill_row(y, x..x + 1, pixel(now));
            }
        }
    }
}

/// The map with each direction blended with those around it, up to two pixels away.
pub fn smoothed(map: &ChartImage) -> ChartImage {
    let blended = |x: usize, y: usize| {
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for (dx, dy) in (-2..=2_i64).flat_map(|dy| (-2..=2_i64).map(move |dx| (dx, dy))) {
            // Pixels beyond the edge are those of the edge.
            let at = |here: usize, by: i64| (here as i64 + by).max(0) as usize;
            let weight = [3.0, 2.0, 1.0][dx.unsigned_abs() as usize]
                * [3.0, 2.0, 1.0][dy.unsigned_abs() as usize];
            let there = direction(map.pixel(at(x, dx), at(y, dy)));
            sum = [0, 1].map(|k| sum[k] + weight * there[k]);
            weights += weight;
        }
        pixel(sum.map(|part| part / weights))
    };
    ChartImage::from_fn(map.width(), map.height(), blended).unwrap_or_else(|| map.clone())
}

/// A map of upright pile with a pixel for every crossing of a sheet, as far as an image can have them.
pub fn upright(sheet: &Sheet) -> Option<ChartImage> {
    let side = |cells: u32| (cells as usize).min(ChartImage::MAX_SIDE);
    ChartImage::filled(side(sheet.warps), side(sheet.wefts), UPRIGHT)
}

/// Size of a pixel of a map that covers the sheet, mm.
fn pixel_mm(map: &ChartImage, sheet: &Sheet) -> [f64; 2] {
    [
        f64::from(sheet.warps) * sheet.pitch_x() / map.width() as f64,
        f64::from(sheet.wefts) * sheet.pitch_y() / map.height() as f64,
    ]
}

/// How much smaller than in life marks are drawn on a sheet: one of a few footprints shows it is a small carpet, a part
/// of one shows nothing.
fn shrunk(sheet: &Sheet) -> f64 {
    let size = [
        f64::from(sheet.warps) * sheet.pitch_x(),
        f64::from(sheet.wefts) * sheet.pitch_y(),
    ];
    (size[0] / (4.0 * STRIPE_MM))
        .min(size[1] / (2.2 * SOLE_MM[0]))
        .min(1.0)
}

/// The map with the stripes of a vacuum cleaner: pile pushed away and pulled back in turns, a little slanted.
pub fn stripes(map: &ChartImage, sheet: &Sheet) -> ChartImage {
    let mm = pixel_mm(map, sheet);
    let width = STRIPE_MM * shrunk(sheet);
    let middle = [map.width(), map.height()].map(|side| 0.5 * side as f64);
    let striped = |x: usize, y: usize| {
        // In lanes from the middle, where one is pushed away.
        let right = (x as f64 + 0.5 - middle[0]) * mm[0] / width;
        let down = (y as f64 + 0.5 - middle[1]) * mm[1] / width;
        // Nobody pushes quite straight.
        let across = right + 0.5 + 0.1 * down + 0.03 * (1.7 * down).sin();
        let lane = across.floor();
        let edge = (across - lane).min(1.0 - (across - lane));
        let up = if lane.rem_euclid(2.0) < 1.0 {
            1.0
        } else {
            -1.0
        };
        let fade = 1.0 - falloff(edge / 0.06);
        pixel([0.12 * up * fade, 0.95 * up * fade])
    };
    ChartImage::from_fn(map.width(), map.height(), striped).unwrap_or_else(|| map.clone())
}

/// The map with two steps of somebody who has walked over the pile, away from the near edge: within a sole the pile is
/// pushed back, against the step, and out at the edges.
pub fn footprints(map: &ChartImage, sheet: &Sheet) -> ChartImage {
    let mm = pixel_mm(map, sheet);
    let size = [map.width() as f64 * mm[0], map.height() as f64 * mm[1]];
    let scale = shrunk(sheet);
    let prints =
        [([-0.11, 0.19], 0.10), ([0.09, -0.24], -0.07)].map(|(place, turn): ([f64; 2], f64)| {
            // Places in lengths of a sole from the middle of the map, up and to the right; turns in radians to the
            // outside.
            let middle = [
                0.5 * size[0] + place[0] * 2.4 * SOLE_MM[0] * scale,
                0.5 * size[1] - place[1] * 2.4 * SOLE_MM[0] * scale,
            ];
            (middle, turn.sin_cos(), place[0].signum())
        });
    let trodden = |x: usize, y: usize| {
        let place = [(x as f64 + 0.5) * mm[0], (y as f64 + 0.5) * mm[1]];
        let mut now = direction(map.pixel(x, y));
        for (middle, (sin, cos), side) in prints {
            let off = [
                (place[0] - middle[0]) / scale,
                (middle[1] - place[1]) / scale,
            ];
            // Along the sole from heel to toe, and across to the outside of the foot.
            let along = cos * off[1] - sin * side * off[0];
            let across = cos * off[0] + sin * side * off[1];
            let (inside, out) = sole([across * side, along]);
            let to_the_outside = 0.55 * out * across.signum();
            let laid = [
                cos * to_the_outside + sin * side * 0.9,
                sin * side * to_the_outside - 0.9 * cos,
            ];
            now = mixed(now, laid, inside);
        }
        pixel(now)
    };
    ChartImage::from_fn(map.width(), map.height(), trodden).unwrap_or_else(|| map.clone())
}

/// How far within a sole a place is, mm across (to the outside of the foot) and along from its middle: 0 outside to 1,
/// and how near its edge, 0 to 1.
fn sole([across, along]: [f64; 2]) -> (f64, f64) {
    let t = along / SOLE_MM[0] + 0.5;
    if !(0.0..=1.0).contains(&t) {
        return (0.0, 0.0);
    }
    // Half widths from heel to toe in shares of the sole's, and how far its middle line bends outwards.
    let profile = [
        0.0, 0.30, 0.36, 0.34, 0.30, 0.36, 0.45, 0.50, 0.48, 0.36, 0.0,
    ];
    let at = t * (profile.len() - 1) as f64;
    let below = (at as usize).min(profile.len() - 2);
    let line = profile[below] + (profile[below + 1] - profile[below]) * (at - below as f64);
    // Heel and toe are round.
    let round = (1.0 - ((t - 0.5).abs() / 0.5).powi(8)).max(0.0).sqrt();
    let half = SOLE_MM[1] * line.max(0.28) * round;
    let off = (across - 0.08 * SOLE_MM[1] * (std::f64::consts::PI * t).sin()).abs();
    if half <= 0.0 || off >= half {
        return (0.0, 0.0);
    }
    // The instep hardly treads.
    let arch = 1.0 - 0.75 * falloff((t - 0.42).abs() / 0.13);
    let edge = off / half;
    (arch * (1.0 - falloff((half - off) / 7.0)), edge * edge)
}
