//! Monotone piecewise-cubic curve through given points, in any units: between two points it never leaves their range.
//!
//! Method: Fritsch and Carlson, "Monotone Piecewise Cubic Interpolation", SIAM J. Numer. Anal. 17 (1980).

/// A curve through points with rising x.
#[derive(Debug, Clone, PartialEq)]
pub struct MonotoneCurve {
    points: Vec<[f64; 2]>,
    slopes: Vec<f64>,
}

/// Points closer than this count as this far apart: a step stays finite.
const CLOSEST: f64 = 1e-9;

impl MonotoneCurve {
    /// The curve through `points`, whose x must rise. Without points it is zero everywhere.
    pub fn new(points: &[[f64; 2]]) -> Self {
        let secants: Vec<f64> = points
            .windows(2)
            .map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]).max(CLOSEST))
            .collect();
        let mut slopes: Vec<f64> = (0..points.len())
            .map(|k| {
                let before = k.checked_sub(1).and_then(|k| secants.get(k)).copied();
                let after = secants.get(k).copied();
                match (before, after) {
                    (Some(a), Some(b)) if a * b > 0.0 => 0.5 * (a + b),
                    (Some(_), Some(_)) => 0.0,
                    (Some(end), None) | (None, Some(end)) => end,
                    (None, None) => 0.0,
                }
            })
            .collect();
        for (k, &secant) in secants.iter().enumerate() {
            if secant == 0.0 {
                (slopes[k], slopes[k + 1]) = (0.0, 0.0);
                continue;
            }
            // Slopes inside the circle of radius three secants keep the cubic monotone.
            let radius = (slopes[k] / secant).hypot(slopes[k + 1] / secant);
            if radius > 3.0 {
                slopes[k] *= 3.0 / radius;
                slopes[k + 1] *= 3.0 / radius;
            }
        }
        Self {
            points: points.to_vec(),
            slopes,
        }
    }

    /// Value at `x`; beyond the ends the end points' values.
    pub fn value(&self, x: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return 0.0;
        };
        let after = self.points.partition_point(|point| point[0] <= x);
        if after == 0 {
            return first[1];
        }
        if after == self.points.len() {
            return last[1];
        }
        let ([x0, y0], [x1, y1]) = (self.points[after - 1], self.points[after]);
        let width = (x1 - x0).max(CLOSEST);
        let t = (x - x0) / width;
        let (m0, m1) = (self.slopes[after - 1] * width, self.slopes[after] * width);
        let t2 = t * t;
        let t3 = t2 * t;
        (2.0 * t3 - 3.0 * t2 + 1.0) * y0
            + (t3 - 2.0 * t2 + t) * m0
            + (3.0 * t2 - 2.0 * t3) * y1
            + (t3 - t2) * m1
    }
}
