//! Cutting, turning and scaling charts.

use std::ops::Range;

use super::oklab::{linear, nearest_srgb};
use crate::design::ChartImage;

/// How a pixel of a scaled chart comes from those it covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Resampling {
    /// The pixel under its middle: no new colours.
    #[default]
    Nearest,
    /// The mean of their light, by the area covered.
    Average,
}

/// The part of a chart in columns `xs` and rows `ys`; `None` if no pixel of the chart lies in it.
pub fn crop(image: &ChartImage, xs: Range<usize>, ys: Range<usize>) -> Option<ChartImage> {
    let (right, bottom) = (xs.end.min(image.width()), ys.end.min(image.height()));
    ChartImage::from_fn(
        right.saturating_sub(xs.start),
        bottom.saturating_sub(ys.start),
        |x, y| image.pixel(xs.start + x, ys.start + y),
    )
}

/// The chart turned by a quarter, clockwise.
pub fn rotate_right(image: &ChartImage) -> ChartImage {
    let height = image.height();
    let turned = ChartImage::from_fn(height, image.width(), |x, y| image.pixel(y, height - 1 - x));
    turned.unwrap_or_else(|| image.clone())
}

/// The chart turned by a quarter, anticlockwise.
pub fn rotate_left(image: &ChartImage) -> ChartImage {
    let width = image.width();
    let turned = ChartImage::from_fn(image.height(), width, |x, y| image.pixel(width - 1 - y, x));
    turned.unwrap_or_else(|| image.clone())
}

/// The chart with left and right exchanged.
pub fn flip_x(image: &ChartImage) -> ChartImage {
    let (width, height) = (image.width(), image.height());
    let flipped = ChartImage::from_fn(width, height, |x, y| image.pixel(width - 1 - x, y));
    flipped.unwrap_or_else(|| image.clone())
}

/// The chart with top and bottom exchanged.
pub fn flip_y(image: &ChartImage) -> ChartImage {
    let (width, height) = (image.width(), image.height());
    let flipped = ChartImage::from_fn(width, height, |x, y| image.pixel(x, height - 1 - y));
    flipped.unwrap_or_else(|| image.clone())
}

/// The chart scaled to other sides; `None` unless they are 1 to [`ChartImage::MAX_SIDE`].
pub fn resize(
    image: &ChartImage,
    width: usize,
    height: usize,
    resampling: Resampling,
) -> Option<ChartImage> {
    match resampling {
        Resampling::Nearest => ChartImage::from_fn(width, height, |x, y| {
            image.pixel(
                (2 * x + 1) * image.width() / (2 * width),
                (2 * y + 1) * image.height() / (2 * height),
            )
        }),
        Resampling::Average => ChartImage::from_fn(width, height, |x, y| {
            let along = |at, from, to| Covered::between(at * from..(at + 1) * from, to);
            let xs = along(x, image.width(), width);
            mean_colour(image, &xs, &along(y, image.height(), height))
        }),
    }
}

/// The pixels of one axis that a span covers: all of them wholly but the first and the last.
pub(crate) struct Covered {
    first: usize,
    last: usize,
    share_of_first: f32,
    share_of_last: f32,
}

impl Covered {
    /// Those that a span covers whose ends are given in pixels / `unit`; it must not be empty.
    pub(crate) fn between(span: Range<usize>, unit: usize) -> Self {
        let Range { start, end } = span;
        let (first, last) = (start / unit, (end - 1) / unit);
        let share = |part: usize| part as f32 / unit as f32;
        Self {
            first,
            last,
            share_of_first: share(end.min((first + 1) * unit) - start),
            share_of_last: share(end - (last * unit).max(start)),
        }
    }

    fn shares(&self) -> impl Iterator<Item = (usize, f32)> {
        (self.first..=self.last).map(|k| {
            let share = match k {
                k if k == self.first => self.share_of_first,
                k if k == self.last => self.share_of_last,
                _ => 1.0,
            };
            (k, share)
        })
    }
}

/// Mean of the light of these columns and rows, by area and alpha; the alpha is the mean by area.
pub(crate) fn mean_colour(image: &ChartImage, xs: &Covered, ys: &Covered) -> [u8; 4] {
    let only = image.pixel(xs.first, ys.first);
    let (mut sum, mut alphas, mut area) = ([0.0; 3], 0.0, 0.0);
    let mut is_one_colour = true;
    for (y, share_y) in ys.shares() {
        for (x, share_x) in xs.shares() {
            let pixel = image.pixel(x, y);
            is_one_colour &= pixel == only;
            let [r, g, b, alpha] = pixel;
            let weight = share_x * share_y;
            let alpha = weight * f32::from(alpha);
            for (sum, light) in sum.iter_mut().zip(linear([r, g, b])) {
                *sum += alpha * light;
            }
            alphas += alpha;
            area += weight;
        }
    }
    if is_one_colour || alphas == 0.0 {
        return only;
    }
    let [r, g, b] = nearest_srgb(sum.map(|sum| sum / alphas));
    [r, g, b, (alphas / area).round() as u8]
}
