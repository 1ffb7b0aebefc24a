//! N_p(θ_v), the normalisation of the highlight of `kajiya_kay` (MODEL.md §8), tabulated.
//!
//! With φ = θ + θ_v − π the integral 2π ∫₀^π max(0, cos(θ + θ_v − π))^p sin θ dθ has, for θ_v ≤ π/2 (it is symmetric
//! about π/2), the closed form 2π·(sin θ_v · ∫_{−π/2}^{θ_v} cos^{p+1} φ dφ + cos^{p+2} θ_v / (p+1)). What is left of
//! an integral grows with θ_v, so that a whole table takes one pass.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::constants::HIGHLIGHT_INTERVALS;

/// Steps of the integral from one entry to the next; Simpson's rule with it errs by less than 10⁻⁹ of the sharpest
/// highlight's (p = 500, 0.1 rad wide: 130 steps).
const STEPS: u32 = 8;

/// N_p at `HIGHLIGHT_INTERVALS` + 1 equal steps of θ_v from 0 to π/2.
pub fn table(exponent: f32) -> Vec<f32> {
    let exponent = f64::from(exponent);
    let power = |angle: f64| angle.cos().max(0.0).powf(exponent + 1.0);
    let interval = FRAC_PI_2 / f64::from(HIGHLIGHT_INTERVALS);
    let over = |interval_index: u32| simpson(f64::from(interval_index) * interval, interval, power);
    // From −π/2 to 0, which mirrors 0 to π/2.
    let mut below: f64 = (0..HIGHLIGHT_INTERVALS).map(over).sum();
    (0..=HIGHLIGHT_INTERVALS)
        .map(|index| {
            let (sine, cosine) = (f64::from(index) * interval).sin_cos();
            let edge = cosine.max(0.0).powf(exponent + 2.0) / (exponent + 1.0);
            let norm = TAU * (sine * below + edge);
            below += over(index);
            norm as f32
        })
        .collect()
}

/// ∫ f from `start` to `start + width`.
fn simpson(start: f64, width: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = width / f64::from(STEPS);
    (0..STEPS)
        .map(|k| {
            let low = start + f64::from(k) * step;
            (f(low) + 4.0 * f(low + 0.5 * step) + f(low + step)) * step / 6.0
        })
        .sum()
}
