//! Pictures on a chart: each pixel of the chart takes the picture's at its middle, or the mean of those around.

use super::fill::mix_row;
use super::place::Placed;
use super::{ChartCanvas, ChartObject};
use crate::design::chart_edit::{mean_of, oklab};
use crate::design::{ChartImage, OPAQUE_FROM};

/// Most samples along a side of a pixel of the chart that a mean is taken of.
const MOST_SAMPLES: usize = 16;

/// Draws a picture where it is placed.
pub(super) fn draw(
    image: &mut ChartImage,
    object: &ChartObject,
    picture: &ChartImage,
    placed: &Placed,
    canvas: &ChartCanvas,
) {
    let [low, high] = placed.bounds();
    let [left, bottom] = canvas.pixel_at(low);
    let [right, top] = canvas.pixel_at(high);
    let from = |at: f64, side: usize| (at - 0.5).ceil().clamp(0.0, side as f64) as usize;
    let columns = from(left, canvas.size[0])..from(right, canvas.size[0]);
    let sampler = Sampler::new(object, picture, placed, canvas);
    for row in from(top, canvas.size[1])..from(bottom, canvas.size[1]) {
        let colours: Vec<Option<[u8; 4]>> = columns
            .clone()
            .map(|column| sampler.at([column, row]))
            .collect();
        let mut start = 0;
        while start < colours.len() {
            let Some(first) = colours[start] else {
                start += 1;
                continue;
            };
            let run = colours[start..]
                .iter()
                .take_while(|colour| **colour == Some(first))
                .count();
            let part = columns.start + start..columns.start + start + run;
            if object.opacity >= 1.0 {
                image.fill_row(row, part, first);
            } else {
                mix_row(image, row, part, |_| first, object.opacity);
            }
            start += run;
        }
    }
}

/// What of a picture lies where.
struct Sampler<'a> {
    object: &'a ChartObject,
    picture: &'a ChartImage,
    placed: &'a Placed,
    canvas: &'a ChartCanvas,
    /// The transparent colour in Oklab.
    transparent: Option<[f32; 3]>,
    /// Samples along each side of a pixel of the chart.
    samples: usize,
}

impl<'a> Sampler<'a> {
    fn new(
        object: &'a ChartObject,
        picture: &'a ChartImage,
        placed: &'a Placed,
        canvas: &'a ChartCanvas,
    ) -> Self {
        let per_pixel = |k: usize| {
            let sides = [picture.width(), picture.height()];
            let size = [object.width, object.height];
            canvas.pixel_mm[k] * sides[k] as f64 / size[k]
        };
        let finest = per_pixel(0).max(per_pixel(1)).ceil().max(1.0);
        Self {
            object,
            picture,
            placed,
            canvas,
            transparent: object.transparent.map(|colour| oklab(colour.0)),
            samples: if object.average {
                // One more, so that none is left out where the picture is turned.
                (finest as usize + 1).min(MOST_SAMPLES)
            } else {
                1
            },
        }
    }

    /// What the pixel of the chart at a column and row gets; `None` where the picture is not or is transparent.
    fn at(&self, [column, row]: [usize; 2]) -> Option<[u8; 4]> {
        let n = self.samples;
        let mut seen = Vec::with_capacity(n * n);
        for k in 0..n * n {
            let part = |k: usize| (k as f64 + 0.5) / n as f64;
            let place = [column as f64 + part(k % n), row as f64 + part(k / n)];
            seen.push(self.pixel(self.canvas.place_of(place)));
        }
        let opaque: Vec<[u8; 3]> = seen.iter().flatten().copied().collect();
        if 2 * opaque.len() < seen.len() || opaque.is_empty() {
            return None;
        }
        let [r, g, b] = if opaque.iter().all(|colour| *colour == opaque[0]) {
            opaque[0]
        } else {
            mean_of(&opaque)
        };
        Some([r, g, b, 255])
    }

    /// The picture's colour at a place on the chart.
    fn pixel(&self, place: [f64; 2]) -> Option<[u8; 3]> {
        let [u, v] = self.placed.box_at(place);
        let (width, height) = (self.picture.width(), self.picture.height());
        let (x, y) = ((u + 0.5) * width as f64, (0.5 - v) * height as f64);
        if x < 0.0 || y < 0.0 || x >= width as f64 || y >= height as f64 {
            return None;
        }
        let [r, g, b, alpha] = self.picture.pixel(x as usize, y as usize);
        if alpha < OPAQUE_FROM {
            return None;
        }
        let is_transparent = self.transparent.is_some_and(|transparent| {
            let colour = oklab([r, g, b]);
            let square = |k: usize| f64::from(colour[k] - transparent[k]).powi(2);
            (0..3).map(square).sum::<f64>().sqrt() <= self.object.tolerance
        });
        (!is_transparent).then_some([r, g, b])
    }
}
