//! How much of a picture is denoised: as much as makes its error least, by what its own samples tell.
//!
//! Let P be the plain mean of N samples and e(P) its error, which a backend estimates from sixteen samples on; p the mean
//! of the first n of them, S that of the other m = N − n, and d what denoising makes of p. With squares meant as means
//! over pixels and channels, and errors of means that fall as samples grow, n·e(p)² = m·e(S)²,
//!
//! ```text
//! e(S)² = (N·e(P)² + n·m·|p − S|²/N) / 2m        e(d)² = |d − S|² − e(S)²
//! ```
//!
//! The first holds however p and S depend on each other, as halves of one sequence do; the second since S knows nothing of
//! d's noise, of which little is left. The denoised picture D of all samples is taken to be as far off as d, which is a
//! little more than it is. How far it is from P tells what noise the two still share: with c the mean product of their
//! errors, |D − P|² = e(D)² + e(P)² − 2c, and the mixture w·D + (1 − w)·P is best at
//!
//! ```text
//! w = ½ + (e(P)² − e(D)²) / 2|D − P|²
//! ```
//!
//! (0 to 1). Without an earlier state c is taken to be 0. With few samples the mixture is nearly D; as P converges it is P,
//! so that the bias of denoising goes as the noise does. Below sixteen samples all of it is D.
//!
//! The idea to hold denoised pixels against others follows Firmino, Frisvad and Jensen, "Progressive Denoising of Monte
//! Carlo Rendered Images", Eurographics 2022; here one weight serves the whole picture, so that no seams can come of it.

use crate::image::Picture;
use crate::image::metrics::mean;

/// A picture of some samples a pixel, and what denoising makes of it.
#[derive(Debug, Clone)]
pub struct Step {
    /// Whole samples of every pixel.
    pub samples: u32,
    /// Their mean.
    pub plain: Picture,
    /// The relRMSE that the backend estimates of it, where it does.
    pub error: Option<f64>,
    /// Denoised, of the same size.
    pub denoised: Picture,
}

/// A picture that is denoised as much as does it good.
#[derive(Debug, Clone)]
pub struct Mix {
    /// The picture.
    pub picture: Picture,
    /// The share of the denoised one in it, 0 to 1.
    pub share: f64,
    /// Estimated relRMSE of it, bias included; `None` where a single step tells nothing.
    pub error: Option<f64>,
}

impl Mix {
    /// Mixes a step by what it tells, and an earlier one of the same picture with fewer samples; all of it is denoised where
    /// its noise is not known.
    pub fn new(earlier: Option<&Step>, now: &Step) -> Self {
        let earlier = earlier.filter(|earlier| {
            earlier.samples > 0
                && earlier.samples < now.samples
                && earlier.plain.size == now.plain.size
        });
        let mean = mean(&now.plain);
        let Some(noise) = now.error.map(|error| (error * mean).powi(2)) else {
            return Self {
                picture: now.denoised.clone(),
                share: 1.0,
                error: None,
            };
        };
        let apart = square(&now.denoised, &now.plain);
        let bias = match earlier {
            Some(earlier) => bias_of(earlier, now, noise),
            None => (apart - noise).max(0.0),
        };
        let share = match noise > 0.0 && apart > 0.0 && bias.is_finite() {
            true => (0.5 + (noise - bias) / (2.0 * apart)).clamp(0.0, 1.0),
            false => 0.0,
        };
        let rest = 1.0 - share;
        let shared = bias + noise - apart;
        let square = share * share * bias + rest * rest * noise + share * rest * shared;
        Self {
            picture: now.mixed(share),
            share,
            error: (mean > 0.0).then(|| square.max(0.0).sqrt() / mean),
        }
    }
}

/// The mean square of what two pictures differ by.
fn square(a: &Picture, b: &Picture) -> f64 {
    let pixels = a.pixels.iter().zip(&b.pixels);
    let sum: f64 = pixels.map(|(a, b)| squares(a, b)).sum();
    sum / (3 * a.pixels.len()).max(1) as f64
}

fn squares(a: &[f32; 4], b: &[f32; 4]) -> f64 {
    let channels = a.iter().zip(b).take(3);
    channels.map(|(a, b)| f64::from(a - b).powi(2)).sum()
}

/// The mean square of the error of the earlier step's denoised picture, where that of the plain one now is `noise`. Pixels
/// that had ended before tell nothing and are taken to have none.
fn bias_of(earlier: &Step, now: &Step, noise: f64) -> f64 {
    let (n, all) = (f64::from(earlier.samples), f64::from(now.samples));
    let m = all - n;
    let [mut halves, mut denoised] = [0.0; 2];
    let pixels = earlier.plain.pixels.iter().zip(&now.plain.pixels);
    for ((before, after), d) in pixels.zip(&earlier.denoised.pixels) {
        if before != after {
            let others: [f32; 4] = std::array::from_fn(|c| {
                ((all * f64::from(after[c]) - n * f64::from(before[c])) / m) as f32
            });
            halves += squares(before, &others);
            denoised += squares(d, &others);
        }
    }
    let count = (3 * now.plain.pixels.len()).max(1) as f64;
    let of_others = (all * noise + n * m * halves / count / all) / (2.0 * m);
    (denoised / count - of_others).max(0.0)
}

impl Step {
    /// A picture of which so much is denoised and the rest plain.
    pub fn mixed(&self, share: f64) -> Picture {
        let share = share as f32;
        let pixels = self.plain.pixels.iter().zip(&self.denoised.pixels);
        let pixel = |(plain, denoised): (&[f32; 4], &[f32; 4])| {
            std::array::from_fn(|c| plain[c] + share * (denoised[c] - plain[c]))
        };
        Picture {
            size: self.plain.size,
            pixels: pixels.map(pixel).collect(),
            aov: None,
        }
    }
}
