//! Mixing colours by their light.

use super::oklab::{linear, nearest_srgb};
use super::{BARE, yarn_of};

/// A colour laid over another: the more of it, the more `opacity` (0 to 1) says. Yarn and bare ground do not mix: the
/// one with the larger share stays.
pub fn mixed(below: [u8; 4], above: [u8; 4], opacity: f64) -> [u8; 4] {
    let (below, above) = (yarn_of(below), yarn_of(above));
    if below == BARE || above == BARE {
        return if opacity >= 0.5 { above } else { below };
    }
    let share = opacity as f32;
    let light = |[r, g, b, _]: [u8; 4]| linear([r, g, b]);
    let (low, high) = (light(below), light(above));
    let [r, g, b] = nearest_srgb([0, 1, 2].map(|k| low[k] + share * (high[k] - low[k])));
    [r, g, b, 255]
}

/// The mean of colours by their light; there must be one.
pub(crate) fn mean_of(colours: &[[u8; 3]]) -> [u8; 3] {
    let count = colours.len().max(1) as f32;
    let lights = colours.iter().map(|colour| linear(*colour));
    let sum = lights.fold([0.0; 3], |sum: [f32; 3], light| {
        [0, 1, 2].map(|k| sum[k] + light[k])
    });
    nearest_srgb(sum.map(|sum| sum / count))
}
