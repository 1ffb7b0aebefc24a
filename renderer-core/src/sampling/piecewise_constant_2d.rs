//! Where the light of a picture of the surroundings comes from: how likely renderers look at each of its texels, so
//! that a small bright sun in a picture is found as often as it matters (Pharr, Jakob and Humphreys, "Physically Based
//! Rendering", §12.5; not in the paper).
//!
//! The upper and the lower half of all directions are drawn from apart, since hardly any light comes through the cloth
//! from its other side: each half has its rows from its pole to the horizon, a picture of an odd number of rows the
//! middle one in both. A row is drawn by its share of the half's light, a texel by its share of the row's, a direction
//! evenly within the part of the texel that lies in the half. All shares are sums in f32, so that every renderer finds
//! the same texel.
//!
//! The light of a texel is what bilinear filtering shows in it on average, a tent of [1, 6, 1]/8 over its neighbours
//! each way, and a little of the whole picture's mean, so that none is without. Red, green and blue count alike: errors
//! are those of all channels.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use glam::DVec3;

/// Share of the picture's mean light that every texel has at least.
const LEAST: f64 = 1.0 / 256.0;
/// The mean square of a half's light over its squared mean, above which directions are worth drawing by it: evenly
/// overcast skies are at 1.0 to 1.5, a hemisphere half of which is black at 2, skies with a sun beyond 100.
const UNEVEN: f64 = 2.5;
/// A half that has less of the light than this is not asked how even it is.
const NOTABLE: f64 = 0.02;

/// The shares.
#[derive(Debug, Clone)]
pub struct PiecewiseConstant2D {
    width: usize,
    height: usize,
    /// For each texel, row by row, the share of its row's light up to it and with it.
    in_row: Arc<[f32]>,
    /// For each half, upper first, and each of its rows from its pole on, the share of the half's light up to it and
    /// with it.
    of_rows: [Arc<[f32]>; 2],
    is_uneven: bool,
}

/// A texel, and within it the part in one half.
#[derive(Clone, Copy)]
struct Texel {
    half: usize,
    /// Row from the half's pole.
    ring: usize,
    column: usize,
}

impl PiecewiseConstant2D {
    /// Of a picture of `width` × `height` pixels.
    pub(crate) fn new(width: usize, height: usize, pixels: &[[f32; 3]]) -> Self {
        let rings = height.div_ceil(2);
        let raw: Vec<f64> = pixels
            .iter()
            .map(|pixel| pixel.iter().map(|&c| f64::from(c)).sum())
            .collect();
        let at = |x: usize, y: usize| raw[y * width + x];
        let across = |x: usize, y: usize| {
            (at((x + width - 1) % width, y) + 6.0 * at(x, y) + at((x + 1) % width, y)) / 8.0
        };
        let mut light = vec![0.0; raw.len()];
        for y in 0..height {
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            for x in 0..width {
                light[y * width + x] =
                    (across(x, above) + 6.0 * across(x, y) + across(x, below)) / 8.0;
            }
        }
        let row_of = |half: usize, ring: usize| match half {
            0 => ring,
            _ => height - 1 - ring,
        };
        // Sums over each half: light, its square, all as means over the half's directions.
        let moments = [0, 1].map(|half| {
            let mut sums = [0.0; 2];
            for ring in 0..rings {
                let row = row_of(half, ring) * width;
                let share = height_of_ring(ring, height) / width as f64;
                for value in &light[row..row + width] {
                    sums[0] += value * share;
                    sums[1] += value * value * share;
                }
            }
            sums
        });
        let mean = 0.5 * (moments[0][0] + moments[1][0]);
        let is_uneven = moments.iter().any(|&[first, second]| {
            first > 2.0 * NOTABLE * mean && second > UNEVEN * first * first
        });
        // A black picture is as likely looked at everywhere.
        let least = if mean > 0.0 { LEAST * mean } else { 1.0 };
        for value in &mut light {
            *value += least;
        }
        let rows: Vec<f64> = (0..height)
            .map(|y| light[y * width..(y + 1) * width].iter().sum())
            .collect();
        let mut in_row = Vec::with_capacity(light.len());
        for row in light.chunks_exact(width) {
            push_sums(row.iter().copied(), &mut in_row);
        }
        let of_rows = [0, 1].map(|half| {
            let mut sums = Vec::with_capacity(rings);
            let of_ring = |ring: usize| rows[row_of(half, ring)] * height_of_ring(ring, height);
            push_sums((0..rings).map(of_ring), &mut sums);
            sums.into()
        });
        Self {
            width,
            height,
            in_row: in_row.into(),
            of_rows,
            is_uneven,
        }
    }

    /// Whether some of the light comes from a small part of all directions: then it is worth drawing directions by it.
    pub fn is_uneven(&self) -> bool {
        self.is_uneven
    }

    /// This table, which says of itself that the light is even.
    pub(crate) fn taken_as_even(&self) -> Self {
        Self {
            is_uneven: false,
            ..self.clone()
        }
    }

    /// For each texel, row by row from the zenith, the share of its row's light up to it and with it.
    pub fn in_row(&self) -> &[f32] {
        &self.in_row
    }

    /// For the upper (0) or the lower half (1) and each of its rows, from its pole to the horizon, the share of the
    /// half's light up to it and with it.
    pub fn of_rows(&self, half: usize) -> &[f32] {
        &self.of_rows[half]
    }

    /// A unit direction of the upper half or, for `below`, of the lower one, for numbers in [0, 1) that choose column
    /// and row; the picture's middle is at azimuth `middle`, radians.
    pub fn direction(&self, below: bool, [u, v]: [f32; 2], middle: f64) -> DVec3 {
        let half = usize::from(below);
        let (ring, down) = find(&self.of_rows[half], v);
        let row = self.row(half, ring);
        let (column, right) = find(&self.in_row[row * self.width..][..self.width], u);
        let [high, low] = falls(ring, self.height);
        let fall = high + (low - high) * down;
        let across = (fall * (2.0 - fall)).max(0.0).sqrt();
        let turn = 0.5 - (column as f64 + right) / self.width as f64;
        let (sine, cosine) = (middle + TAU * turn).sin_cos();
        let up = if below { fall - 1.0 } else { 1.0 - fall };
        DVec3::new(across * cosine, across * sine, up)
    }

    /// The density, per sr, with which [`Self::direction`] draws a unit direction of its half.
    pub fn density(&self, direction: DVec3, middle: f64) -> f64 {
        let Texel { half, ring, column } = self.texel(direction, middle);
        let row = &self.in_row[self.row(half, ring) * self.width..][..self.width];
        let share = |sums: &[f32], k: usize| {
            let before = if k > 0 { sums[k - 1] } else { 0.0 };
            f64::from(sums[k] - before)
        };
        let solid_angle = TAU / self.width as f64 * height_of_ring(ring, self.height);
        share(&self.of_rows[half], ring) * share(row, column) / solid_angle
    }

    fn texel(&self, direction: DVec3, middle: f64) -> Texel {
        let angle = direction.x.hypot(direction.y).atan2(direction.z.abs());
        let ring = (angle / PI * self.height as f64) as usize;
        let azimuth = direction.y.atan2(direction.x);
        let turn = (0.5 - (azimuth - middle) / TAU).rem_euclid(1.0);
        Texel {
            half: usize::from(direction.z < 0.0),
            ring: ring.min(self.height.div_ceil(2) - 1),
            column: ((turn * self.width as f64) as usize).min(self.width - 1),
        }
    }

    fn row(&self, half: usize, ring: usize) -> usize {
        if half == 0 {
            ring
        } else {
            self.height - 1 - ring
        }
    }
}

/// 1 − cos of the angles from a half's pole at which one of its rows begins and ends; none is beyond the horizon.
fn falls(ring: usize, height: usize) -> [f64; 2] {
    [ring, ring + 1].map(|edge| {
        let angle = (PI * edge as f64 / height as f64).min(FRAC_PI_2);
        2.0 * (0.5 * angle).sin().powi(2)
    })
}

/// The height of a row's part in a half: its solid angle over 2π.
fn height_of_ring(ring: usize, height: usize) -> f64 {
    let [high, low] = falls(ring, height);
    low - high
}

/// Appends the sums of `values` up to each of them, over their total; the last is 1.
fn push_sums(values: impl Iterator<Item = f64> + Clone, sums: &mut Vec<f32>) {
    let total: f64 = values.clone().sum();
    let mut sum = 0.0;
    for value in values {
        sum += value;
        sums.push((sum / total) as f32);
    }
    if let Some(last) = sums.last_mut() {
        *last = 1.0;
    }
}

/// The first of rising `sums` above `at`, and how far `at` is from the one before to it.
fn find(sums: &[f32], at: f32) -> (usize, f64) {
    let place = sums.partition_point(|&sum| sum <= at).min(sums.len() - 1);
    let before = if place > 0 { sums[place - 1] } else { 0.0 };
    let share = f64::from(at - before) / f64::from(sums[place] - before).max(1e-30);
    (place, share.clamp(0.0, 1.0))
}
