//! How much of a picture is denoised: as much as makes its error least, by what its own samples tell.
//!
//! Let P be the plain mean of N samples, p that of the first n of them, S that of the others, and d what denoising makes
//! of p. S knows nothing of p's noise, nor of d's, so that, with σ² the variance of a sample and e(d) the error of d,
//!
//! ```text
//! |p − S|² = σ²·(1/n + 1/(N − n))        |d − S|² = e(d)² + σ²/(N − n)
//! ```
//!
//! (means over pixels and channels). That gives e(P)² = σ²/N and e(d)², without any truth. The denoised picture D of all
//! samples is taken to be as far off as d, which is a little more than it is, and by another error than that of P: then
//! w·D + (1 − w)·P is best at w = e(P)²/(e(P)² + e(d)²). With few samples it is nearly D; as P converges it is P, so that
//! the bias of denoising goes as the noise does. The idea of measuring denoised pixels against independent ones follows
//! Firmino, Frisvad and Jensen, "Progressive Denoising of Monte Carlo Rendered Images", Eurographics 2022; here one
//! weight serves the whole picture, so that no seams can come of it.

use crate::image::Picture;
use crate::image::metrics::mean;

/// A picture of some samples a pixel, and what denoising makes of it.
#[derive(Debug, Clone)]
pub struct Step {
    /// Whole samples of every pixel.
    pub samples: u32,
    /// Their mean.
    pub plain: Picture,
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
    /// Mixes a step by what an earlier one of the same picture, with fewer samples, tells; without one all of it is
    /// denoised.
    pub fn new(earlier: Option<&Step>, now: &Step) -> Self {
        let earlier = earlier.filter(|earlier| {
            earlier.samples > 0
                && earlier.samples < now.samples
                && earlier.plain.size == now.plain.size
        });
        let Some([noise, bias]) = earlier.and_then(|earlier| squares(earlier, now)) else {
            return Self {
                picture: now.denoised.clone(),
                share: 1.0,
                error: None,
            };
        };
        let share = if noise > 0.0 {
            noise / (noise + bias)
        } else {
            0.0
        };
        let square = share * share * bias + (1.0 - share) * (1.0 - share) * noise;
        let mean = mean(&now.plain);
        Self {
            picture: now.mixed(share),
            share,
            error: (mean > 0.0).then(|| square.sqrt() / mean),
        }
    }
}

/// Mean squares of the errors of the plain picture and of a denoised one; `None` where nothing differs, as in a picture
/// of background.
fn squares(earlier: &Step, now: &Step) -> Option<[f64; 2]> {
    let (n, all) = (f64::from(earlier.samples), f64::from(now.samples));
    let [mut of_plain, mut of_denoised, mut count] = [0.0; 3];
    let pixels = earlier.plain.pixels.iter().zip(&now.plain.pixels);
    for ((before, after), denoised) in pixels.zip(&earlier.denoised.pixels) {
        // Pixels that had ended before have no other samples.
        if before == after {
            continue;
        }
        for c in 0..3 {
            let [p, mean, d] = [before[c], after[c], denoised[c]].map(f64::from);
            let others = (all * mean - n * p) / (all - n);
            of_plain += (p - others).powi(2);
            of_denoised += (d - others).powi(2);
            count += 1.0;
        }
    }
    let variance = of_plain / count / (1.0 / n + 1.0 / (all - n));
    let bias = of_denoised / count - variance / (all - n);
    let are_known = variance.is_finite() && bias.is_finite();
    are_known.then(|| [variance / all, bias.max(0.0)])
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
