//! The truth that errors are measured against, and how far it is from the truth itself.
//!
//! It is rendered as two halves with different seeds. Their difference shows the noise of their mean, which every
//! measured error contains: error² = measured² − noise². Where that is less than noise², nothing but "below the truth's
//! noise" is known.

use renderer_core::image::Picture;
use renderer_core::image::metrics::{self, SizesDiffer};

use crate::flip::flip;

/// A converged picture.
#[derive(Debug, Clone)]
pub struct Truth {
    /// The best estimate.
    pub mean: Picture,
    /// Two independent halves of it.
    pub halves: [Picture; 2],
    /// Samples a pixel of each half.
    pub samples: [u32; 2],
    /// relRMSE that the mean is estimated to have itself.
    pub noise: f64,
    /// FLIP between the halves: what noise of twice the mean's variance, on both sides, looks like.
    pub flip_between_halves: f64,
}

/// What a measured error tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Known {
    /// The error, relRMSE, without the truth's noise.
    Error(f64),
    /// It is less than the truth's noise.
    BelowNoise,
}

impl Known {
    /// The error, or the bound that is known of it.
    pub fn bound(self, noise: f64) -> f64 {
        match self {
            Self::Error(error) => error,
            Self::BelowNoise => noise,
        }
    }
}

/// What is left of a measured relRMSE without the truth's noise.
pub fn known(measured: f64, noise: f64) -> Known {
    let square = measured * measured - noise * noise;
    // A NaN is an error, and must show.
    if square <= noise * noise {
        Known::BelowNoise
    } else {
        Known::Error(square.sqrt())
    }
}

impl Truth {
    /// The mean of two independent pictures of so many samples each, shown at `exposure`.
    ///
    /// # Errors
    /// When their sizes differ.
    pub fn new(
        halves: [Picture; 2],
        samples: [u32; 2],
        exposure: f64,
    ) -> Result<Self, SizesDiffer> {
        let [a, b] = samples.map(f64::from);
        let mut mean = halves[0].clone();
        for (mean, other) in mean.pixels.iter_mut().zip(&halves[1].pixels) {
            for (mean, other) in mean.iter_mut().zip(other) {
                let sum = a * f64::from(*mean) + b * f64::from(*other);
                *mean = (sum / (a + b)) as f32;
            }
        }
        // With a variance s² a sample, the halves differ by s²(1/a + 1/b) and their mean is s²/(a + b) off.
        let difference = metrics::rel_rmse(&halves[0], &halves[1])?;
        let scale = metrics::mean(&halves[1]) / metrics::mean(&mean);
        Ok(Self {
            noise: difference * scale * (a * b).sqrt() / (a + b),
            flip_between_halves: flip(&halves[0], &halves[1], exposure)?,
            mean,
            halves,
            samples,
        })
    }
}

/// Side of the blocks whose spread tells how well a bias is known, pixels: more than loops are wide at bench sizes.
const BLOCK: usize = 16;

/// The error that no number of samples removes, as its square: relRMSE².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bias {
    /// Its estimate, which may be negative by chance.
    pub square: f64,
    /// The estimate's standard deviation.
    pub deviation: f64,
}

impl Bias {
    /// From two independent pictures by one setting: the mean of (a − t)(b − u), in which all noise is independent and
    /// averages to nothing. Its deviation is that of the means of blocks.
    ///
    /// # Errors
    /// When sizes differ.
    pub fn new(pictures: [&Picture; 2], truth: &Truth) -> Result<Self, SizesDiffer> {
        let [a, b] = pictures;
        let [t, u] = &truth.halves;
        for picture in pictures {
            metrics::check_sizes(picture, t)?;
        }
        let [width, height] = t.size.map(|side| side as usize);
        let columns = width.div_ceil(BLOCK);
        let mut blocks = vec![(0.0, 0.0); columns * height.div_ceil(BLOCK)];
        for index in 0..width * height {
            let block = &mut blocks[index / width / BLOCK * columns + index % width / BLOCK];
            for c in 0..3 {
                let value = |picture: &Picture| f64::from(picture.pixels[index][c]);
                // Both ways to pair pictures and truths are as good.
                let one = (value(a) - value(t)) * (value(b) - value(u));
                let other = (value(a) - value(u)) * (value(b) - value(t));
                block.0 += 0.5 * (one + other);
                block.1 += 1.0;
            }
        }
        let scale = 1.0 / metrics::mean(&truth.mean).powi(2);
        let values: Vec<f64> = blocks
            .iter()
            .map(|(sum, count)| scale * sum / count)
            .collect();
        let count = values.len() as f64;
        let square = values.iter().sum::<f64>() / count;
        let spread: f64 = values.iter().map(|value| (value - square).powi(2)).sum();
        Ok(Self {
            square,
            deviation: (spread / (count * (count - 1.0).max(1.0))).sqrt(),
        })
    }
}

impl std::fmt::Display for Bias {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.square > 2.0 * self.deviation {
            let bias = self.square.sqrt();
            write!(f, "{bias:.3} ± {:.3}", 0.5 * self.deviation / bias)
        } else {
            let most = (self.square.max(0.0) + 2.0 * self.deviation).sqrt();
            write!(f, "below {most:.3}")
        }
    }
}
