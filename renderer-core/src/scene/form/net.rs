//! A smooth surface that a net of points pulls: a bicubic B-spline that begins and ends in the outermost points.
//!
//! Source: de Boor, "A Practical Guide to Splines", 1978. Along each side of n points the knots are 0, 0, 0, 0, 1, …,
//! n − 3, n − 3, n − 3, n − 3.

use glam::DVec3;

/// The net.
#[derive(Debug, Clone)]
pub struct Net {
    rows: Vec<Vec<DVec3>>,
}

/// Knot `index` of a side of `count` points.
fn knot(index: usize, count: usize) -> f64 {
    (index as f64 - 3.0).clamp(0.0, (count - 3) as f64)
}

/// Where along a side, from 0 to 1, point `index` of `count` stands in a net that stretches nothing (Greville's
/// abscissa).
fn rest_place(index: usize, count: usize) -> f64 {
    let sum: f64 = (1..=3).map(|k| knot(index + k, count)).sum();
    sum / (3 * (count - 3)) as f64
}

/// Weights of the four points from the first returned on, at `share` of a side of `count` points; beyond the ends the
/// surface goes on straight.
fn weights(share: f64, count: usize) -> (usize, [f64; 4]) {
    let inside = share.clamp(0.0, 1.0);
    let x = inside * (count - 3) as f64;
    let first = (x as usize).min(count - 4);
    // The triangle of Cox and de Boor, up to degree `degree`.
    let basis = |degree: usize| {
        let mut values = [0.0; 4];
        values[0] = 1.0;
        for k in 1..=degree {
            let mut saved = 0.0;
            for (r, value) in values[..k].iter_mut().enumerate() {
                let right = knot(first + 4 + r, count) - x;
                let left = x - knot(first + 4 + r - k, count);
                let part = *value / (right + left);
                *value = saved + right * part;
                saved = left * part;
            }
            values[k] = saved;
        }
        values
    };
    let mut values = basis(3);
    let beyond = share - inside;
    if beyond != 0.0 {
        let slopes = basis(2);
        let scale = 3.0 * beyond * (count - 3) as f64;
        for (k, slope) in slopes[..3].iter().enumerate() {
            let span = knot(first + k + 4, count) - knot(first + k + 1, count);
            values[k + 1] += scale * slope / span;
            values[k] -= scale * slope / span;
        }
    }
    (first, values)
}

impl Net {
    /// A net of rows of as many points each, at least four of each.
    pub fn new(rows: &[Vec<[f64; 3]>]) -> Self {
        let row = |row: &Vec<[f64; 3]>| row.iter().copied().map(DVec3::from_array).collect();
        Self {
            rows: rows.iter().map(row).collect(),
        }
    }

    /// The point at shares of the width (from the left) and of the length (from the near edge).
    pub fn at(&self, across: f64, along: f64) -> DVec3 {
        let (first_row, row_weights) = weights(along, self.rows.len());
        let (first, point_weights) = weights(across, self.rows[0].len());
        let rows = &self.rows[first_row..];
        let sum = |row: &Vec<DVec3>| -> DVec3 {
            let points = row[first..].iter().zip(point_weights);
            points.map(|(point, weight)| *point * weight).sum()
        };
        rows.iter()
            .zip(row_weights)
            .map(|(row, weight)| sum(row) * weight)
            .sum()
    }
}

/// A net of `rows` rows of `columns` points that lies as `at` says at shares of the width and of the length; level
/// cloth in a level net is not stretched.
pub fn net_through(
    [columns, rows]: [usize; 2],
    at: impl Fn(f64, f64) -> [f64; 3],
) -> Vec<Vec<[f64; 3]>> {
    let row = |j| {
        let along = rest_place(j, rows);
        (0..columns)
            .map(|i| at(rest_place(i, columns), along))
            .collect()
    };
    (0..rows).map(row).collect()
}
