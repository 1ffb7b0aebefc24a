//! Whether two sets of independent pictures are draws of the same random picture: tests of
//! every pixel, of blocks and of the whole, and of the noise.
//!
//! One picture is the mean of some Owen samples; its variance is not that of independent samples, so it is estimated
//! from
//! [`REPEATS`] pictures with different seeds on each side (MODEL.md §10). All tests together refuse one right pair in
//! a thousand (Šidák).

use renderer_core::image::Picture;

use super::compare::REPEATS;

/// Chance that a right pair is refused by any of the tests.
const LEVEL: f64 = 1e-3;
/// Blocks along each side.
const BLOCKS: usize = 4;

/// What a comparison that found no difference could have found.
#[derive(Debug, Clone, Copy)]
pub struct Power {
    /// Relative bias of the whole picture that is found nineteen times in twenty.
    pub whole: f64,
    /// Relative bias of the median pixel that is not black, found as often.
    pub pixel: f64,
}

/// Compares; the power, or what differs.
pub fn same_distribution(a: &[Picture], b: &[Picture]) -> Result<Power, String> {
    assert_eq!((a.len(), b.len()), (REPEATS, REPEATS));
    let [width, height] = a[0].size.map(|side| side as usize);
    if b.iter().any(|picture| picture.size != a[0].size) {
        return Err("sizes differ".into());
    }
    let count = width * height;
    // Half of the level for the pixels, half for the blocks, the whole and the noise.
    let limit_of =
        |tests: usize| student_quantile(1.0 - (1.0 - 0.5 * LEVEL).powf(1.0 / tests as f64));
    let (limit, block_limit) = (limit_of(count), limit_of(BLOCKS * BLOCKS + 2));
    let (a, b) = (luminances(a), luminances(b));

    let mut variances = [0.0; 2];
    let mut detectable = Vec::new();
    for pixel in 0..count {
        let [a, b]: [Vec<f64>; 2] =
            [&a, &b].map(|side| side.iter().map(|picture| picture[pixel]).collect());
        let test = Welch::new(&a, &b);
        test.check(limit)
            .map_err(|error| format!("pixel {},{}: {error}", pixel % width, pixel / width))?;
        variances[0] += test.variances[0];
        variances[1] += test.variances[1];
        if test.means[0] > 1e-3 {
            detectable.push(test.detectable(limit));
        }
    }
    let mut whole = 0.0;
    for block in 0..=BLOCKS * BLOCKS {
        let all = block == BLOCKS * BLOCKS;
        let inside = |pixel: &usize| {
            let column = pixel % width * BLOCKS / width;
            all || block == pixel / width * BLOCKS / height * BLOCKS + column
        };
        let pixels: Vec<usize> = (0..count).filter(inside).collect();
        let sums = |side: &[Vec<f64>]| -> Vec<f64> {
            let sum = |picture: &Vec<f64>| pixels.iter().map(|&pixel| picture[pixel]).sum::<f64>();
            side.iter()
                .map(|picture| sum(picture) / pixels.len() as f64)
                .collect()
        };
        let test = Welch::new(&sums(&a), &sums(&b));
        let name = if all {
            "whole".into()
        } else {
            format!("block {block}")
        };
        test.check(block_limit)
            .map_err(|error| format!("{name}: {error}"))?;
        whole = test.detectable(block_limit);
    }
    // The noise: the ratio of the summed variances. Its own deviation comes from a jackknife over pixels' shares, which
    // are far from equal.
    let ratio = (variances[0] / variances[1]).ln();
    let shares = (0..count).map(|pixel| {
        let [a, b] = [&a, &b].map(|side| {
            moments(
                &side
                    .iter()
                    .map(|picture| picture[pixel])
                    .collect::<Vec<_>>(),
            )
            .1
        });
        (a / variances[0] - b / variances[1]).powi(2)
    });
    let spread = shares.sum::<f64>().sqrt();
    // Variances of a few pictures have heavy tails: half as much again as for Gaussian ones.
    let fits = ratio.abs() <= 1.5 * block_limit * spread;
    if !fits && variances != [0.0; 2] {
        return Err(format!(
            "noise: variances are as {:.3} to 1, spread {spread:.3}",
            ratio.exp()
        ));
    }
    detectable.sort_by(f64::total_cmp);
    Ok(Power {
        whole,
        pixel: detectable.get(detectable.len() / 2).copied().unwrap_or(0.0),
    })
}

/// Welch's test of two sets of numbers.
struct Welch {
    means: [f64; 2],
    variances: [f64; 2],
}

impl Welch {
    fn new(a: &[f64], b: &[f64]) -> Self {
        let (a, b) = (moments(a), moments(b));
        Self {
            means: [a.0, b.0],
            variances: [a.1, b.1],
        }
    }

    /// Deviation of the difference of means.
    fn spread(&self) -> f64 {
        ((self.variances[0] + self.variances[1]) / REPEATS as f64).sqrt()
    }

    fn check(&self, limit: f64) -> Result<(), String> {
        let [a, b] = self.means;
        let t = (a - b) / self.spread();
        // Without noise (the background, a black pixel) equal to rounding; NaN is not.
        let equal = (a - b).abs() <= 1e-5 * a.abs();
        if equal || t.abs() <= limit {
            Ok(())
        } else {
            Err(format!("means {a} and {b}, t = {t:.2}, allowed {limit:.2}"))
        }
    }

    /// The relative difference that exceeds the limit nineteen times in twenty.
    fn detectable(&self, limit: f64) -> f64 {
        (limit + 1.645) * self.spread() / self.means[0].abs().max(1e-12)
    }
}

/// The |t| with 30 degrees of freedom that is exceeded with this probability, by bisection on the distribution's closed
/// form for even degrees of freedom (Abramowitz and Stegun 26.7.4).
fn student_quantile(two_sided: f64) -> f64 {
    const FREEDOM: f64 = 30.0;
    let outside = |t: f64| {
        let angle = (t / FREEDOM.sqrt()).atan();
        let cos2 = angle.cos().powi(2);
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..15 {
            term *= cos2 * (2.0 * f64::from(k) - 1.0) / (2.0 * f64::from(k));
            sum += term;
        }
        1.0 - angle.sin() * sum
    };
    let (mut low, mut high) = (0.0, 60.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if outside(middle) > two_sided {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

fn luminances(pictures: &[Picture]) -> Vec<Vec<f64>> {
    let luminance = |pixel: &[f32; 4]| {
        let [r, g, b, _] = pixel.map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let of = |picture: &Picture| picture.pixels.iter().map(luminance).collect();
    pictures.iter().map(of).collect()
}

fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, squares / (count - 1.0))
}
