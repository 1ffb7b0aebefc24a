//! Editing a chart's pixels: shape, paint, yarns. Everything gives the same result on every machine.

mod loops_per_pixel;
mod mix;
mod oklab;
mod paint;
mod reduce;
mod reshape;
mod yarns;

pub use loops_per_pixel::{LoopsPerPixel, LoopsUnder};
pub(crate) use mix::mean_of;
pub use mix::mixed;
pub use oklab::{linear_from_oklab, nearest_srgb, oklab, oklab_from_linear, precise_oklab};
pub use paint::{LARGEST_BRUSH, draw_line, outline_rectangle};
pub use reduce::{Dither, MOST_YARNS, choose_yarns, reduce_to};
pub(crate) use reshape::{Covered, mean_colour};
pub use reshape::{Resampling, crop, flip_x, flip_y, resize, rotate_left, rotate_right};
pub use yarns::{BARE, YarnCount, YarnCounts, yarn_of};

use super::ChartImage;

/// The chart with one yarn instead of another.
pub fn replace_yarn(image: &ChartImage, from: [u8; 4], to: [u8; 4]) -> ChartImage {
    image.map_colours(|colour| if yarn_of(colour) == from { to } else { colour })
}
