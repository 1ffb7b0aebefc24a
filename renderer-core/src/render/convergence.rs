//! When work on tiles and pictures ends: one rule for all backends (MODEL.md §10).
//!
//! Decisions fall only when all pixels that are still drawn have 2^k samples. A picture ends when its estimated error
//! is at most the target. A tile ends before that, with [`Optimisation::ConvergedTiles`](super::Optimisation), when its
//! own part of the error is: when the variances of its pixels' means sum up to at most (target · mean of the whole
//! picture)² for each of its values. Were every tile like that, the picture would have the error asked for; the tiles
//! that are not go on until the picture as a whole has it, so that samples go where the error is.
//!
//! Bias: whether a tile ends depends on its samples. One that has been lucky, in which light that is rare and bright
//! has not shown itself, ends early and stays a little too dark, and its estimated error a little too small. From 16
//! samples on an estimate rests on two means or more of every pixel of a tile, some hundred numbers, which are hardly
//! ever all lucky; tests/core/tiles/converged.rs holds such tiles against other samples.

use crate::sampling::RUN;

/// Fewest samples at which errors are estimated and can end anything: of two scrambles' first runs.
pub const FEWEST_FOR_ERROR: u32 = 2 * RUN;

/// What is known of the error of some pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelErrors {
    /// Sum of the estimated variances of all channels' means.
    pub variance: f64,
    /// Sum of all channels' means.
    pub sum: f64,
    /// How many pixels these are.
    pub pixels: u64,
}

impl std::ops::AddAssign for PixelErrors {
    fn add_assign(&mut self, other: Self) {
        self.variance += other.variance;
        self.sum += other.sum;
        self.pixels += other.pixels;
    }
}

impl PixelErrors {
    /// How many values there are: three channels a pixel.
    fn values(&self) -> f64 {
        3.0 * self.pixels as f64
    }

    fn mean(&self) -> f64 {
        self.sum / self.values().max(1.0)
    }

    /// Estimated relRMSE (MODEL.md §11). A black picture has no relative error; its spread is 0 as well.
    pub fn relative(&self) -> f64 {
        if self.sum > 0.0 {
            (self.variance / self.values()).sqrt() / self.mean()
        } else {
            0.0
        }
    }

    /// Whether the error of these pixels, a part of the picture that `whole` is about, is at most what the picture's
    /// may be.
    pub fn have_converged(&self, whole: &Self, target: f64) -> bool {
        self.variance <= (target * whole.mean()).powi(2) * self.values()
    }
}

/// Whether what has been drawn towards an error of `old` is what would have been drawn towards `new` (0: no error ends
/// anything): nothing has ended by the old one, and nothing went on that the new one would have ended.
pub fn leads_on(old: f64, new: f64, has_ended_tiles: bool) -> bool {
    let never_ends = |error: f64| error <= 0.0;
    let is_stricter = never_ends(new) || !never_ends(old) && new <= old;
    old == new || is_stricter && !has_ended_tiles
}

/// Whether errors are estimated anew at so many samples: whenever a scramble has had its turn.
pub fn has_estimate(samples: u32) -> bool {
    samples >= FEWEST_FOR_ERROR && samples.is_multiple_of(RUN)
}

/// Whether an error target may end something at so many samples.
pub fn is_decision(samples: u32) -> bool {
    samples.is_power_of_two() && samples >= FEWEST_FOR_ERROR
}
