//! N_p(θ_v), the normalisation of the highlight of `kajiya_kay` (MODEL.md §8), tabulated.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::layout::HIGHLIGHT_INTERVALS;

/// Steps of the integral over θ. The sharpest highlight (p = 500) is 0.1 rad wide, some 130 steps.
const STEPS: u32 = 4096;

/// N_p at equal steps of θ_v from 0 to π/2 (it is symmetric about π/2), padded to whole vec4s.
pub fn table(exponent: f32) -> Vec<f32> {
    let padded = (HIGHLIGHT_INTERVALS / 4 + 1) * 4;
    (0..padded)
        .map(|index| {
            let share = f64::from(index.min(HIGHLIGHT_INTERVALS)) / f64::from(HIGHLIGHT_INTERVALS);
            normalisation(f64::from(exponent), share * FRAC_PI_2) as f32
        })
        .collect()
}

/// N_p(θ_v) = 2π ∫₀^π max(0, cos(θ + θ_v − π))^p sin θ dθ by the midpoint rule.
fn normalisation(exponent: f64, angle: f64) -> f64 {
    let width = PI / f64::from(STEPS);
    let sum: f64 = (0..STEPS)
        .map(|step| {
            let theta = (f64::from(step) + 0.5) * width;
            (theta + angle - PI).cos().max(0.0).powf(exponent) * theta.sin()
        })
        .sum();
    TAU * sum * width
}
