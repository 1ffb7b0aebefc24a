//! A surface whose heights a picture tells: a bicubic B-spline over the sheet.
//!
//! Space: the sheet's x and y, mm; heights in mm over the plane of level cloth. The picture covers the sheet, its first
//! row at the far edge. It is averaged over a grid of squares as wide as `form.smooth`, or of its own pixels where
//! these are larger, and the averages are the control points of the uniform spline (de Boor, "A Practical Guide to
//! Splines", 1978), which stays between them and has continuous slopes and bends. Square and spline together blend
//! heights like a bell of 0.65 squares' standard deviation (√(1/12 + 1/3)), so that steps of 8 bits do not show as
//! stairs. Beyond the sheet the outermost control points go on.

use glam::DVec2;

use crate::design::HeightImage;

/// Heights over the sheet.
#[derive(Debug, Clone)]
pub(super) struct HeightMap {
    /// Control points along x and y.
    counts: [usize; 2],
    /// Row by row from the far edge, mm.
    heights: Vec<f32>,
    /// Size of the sheet, mm.
    size: DVec2,
}

impl HeightMap {
    /// The heights of a picture over a sheet of a size, mm: white is `highest` mm over black, and details below
    /// `smooth` mm are blended.
    pub fn new(image: &HeightImage, highest: f64, smooth: f64, size: DVec2) -> Self {
        let pixels = [image.width(), image.height()];
        let count = |axis: usize| ((size[axis] / smooth).round() as usize).clamp(1, pixels[axis]);
        let counts = [count(0), count(1)];
        let mut heights = vec![0.0_f32; counts[0] * counts[1]];
        let mut averaged = vec![0.0_f64; counts[0]];
        let scale = highest / f64::from(u16::MAX);
        for y in 0..pixels[1] {
            averaged.fill(0.0);
            for (x, grey) in image.row(y).iter().enumerate() {
                for (column, share) in covered(x, pixels[0], counts[0]) {
                    averaged[column] += share * f64::from(*grey) * scale;
                }
            }
            for (row, share) in covered(y, pixels[1], counts[1]) {
                let sums = &mut heights[row * counts[0]..][..counts[0]];
                for (sum, value) in sums.iter_mut().zip(&averaged) {
                    *sum += (share * value) as f32;
                }
            }
        }
        Self {
            counts,
            heights,
            size,
        }
    }

    /// The height at a place, mm.
    pub fn height(&self, sheet: DVec2) -> f64 {
        let [x, y] = self.spans(sheet);
        self.sum(&x, &y, x.weights, y.weights)
    }

    /// How much the height grows along x and y at a place, mm a mm.
    pub fn slope(&self, sheet: DVec2) -> DVec2 {
        let [x, y] = self.spans(sheet);
        let along_x = self.sum(&x, &y, x.slopes, y.weights);
        let along_y = self.sum(&x, &y, x.weights, y.slopes);
        // Rows are counted from the far edge.
        DVec2::new(
            along_x * self.counts[0] as f64,
            -along_y * self.counts[1] as f64,
        ) / self.size
    }

    fn spans(&self, sheet: DVec2) -> [Span; 2] {
        let share = sheet / self.size;
        let span = |share: f64, count: usize| Span::new(share * count as f64 - 0.5, count);
        [
            span(0.5 + share.x, self.counts[0]),
            span(0.5 - share.y, self.counts[1]),
        ]
    }

    fn sum(&self, x: &Span, y: &Span, across: [f64; 4], down: [f64; 4]) -> f64 {
        let row = |row: usize| -> f64 {
            let heights = &self.heights[row * self.counts[0]..];
            let points = x.points.iter().zip(across);
            points
                .map(|(&x, weight)| f64::from(heights[x]) * weight)
                .sum()
        };
        let rows = y.points.iter().zip(down);
        rows.map(|(&y, weight)| row(y) * weight).sum()
    }
}

/// The control points that a place of one axis depends on.
struct Span {
    points: [usize; 4],
    /// What each counts for in the value,
    weights: [f64; 4],
    /// and in its slope for each step from point to point.
    slopes: [f64; 4],
}

impl Span {
    /// At a place counted in control points, of `count` of them.
    fn new(place: f64, count: usize) -> Self {
        let last = count as f64 - 1.0;
        let first = place.floor();
        let t = place - first;
        let s = 1.0 - t;
        let points = [-1.0, 0.0, 1.0, 2.0].map(|k| (first + k).clamp(0.0, last) as usize);
        Self {
            points,
            weights: [
                s * s * s / 6.0,
                (4.0 - 3.0 * t * t * (2.0 - t)) / 6.0,
                (4.0 - 3.0 * s * s * (2.0 - s)) / 6.0,
                t * t * t / 6.0,
            ],
            slopes: [
                -0.5 * s * s,
                0.5 * t * (3.0 * t - 4.0),
                0.5 * s * (4.0 - 3.0 * s),
                0.5 * t * t,
            ],
        }
    }
}

/// Which of `count` squares pixel `index` of `pixels` lies in, and which share of the square it is; one or two, since
/// there are no more squares than pixels.
fn covered(index: usize, pixels: usize, count: usize) -> impl Iterator<Item = (usize, f64)> {
    // In whole numbers: a pixel is `count` long, a square `pixels`.
    let (start, end) = (index * count, (index + 1) * count);
    let first = start / pixels;
    let border = ((first + 1) * pixels).min(end);
    let parts = [(first, border - start), (first + 1, end - border)];
    let parts = parts.into_iter().filter(|(_, length)| *length > 0);
    parts.map(move |(square, length)| (square, length as f64 / pixels as f64))
}
