//! Exposure by an incident light meter that lies level in the cloth's middle (MODEL.md §11).
//!
//! What the meter reads depends on the lights alone, and what white is on how many bounces of them are shown: neither
//! cloth nor camera changes it, so that nothing gets brighter or darker while one looks or edits yarns.

use std::f64::consts::PI;

use super::{Design, Environment, EnvironmentKind, Light, Metering, View};

/// What white terry reflects in pictures of 1, 2, 4 … 64 bounces: what leaves it after so many scatterings.
const WHITE_CLOTH: [f64; 7] = [0.11, 0.18, 0.27, 0.37, 0.48, 0.55, 0.60];
/// Displayed value of a level sheet that reflects that much evenly, linear: sRGB 221 of 255, so that loops that face the
/// light come to 235 to 245.
const SHOWN: f64 = 0.72;
/// Weights of linear red, green and blue in luminance (Rec. 709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Most stops that the meter asks for, brighter or darker: a scene without light stays dark.
const MOST_STOPS: f64 = 8.0;

impl Light {
    /// Irradiance of a level plane in the cloth's middle, from above, with nothing in the way; linear RGB, where π
    /// lights white paper to radiance 1. Suns and area lights that are partly below the horizon count as a whole, by
    /// their middle.
    pub fn level_irradiance(&self) -> [f64; 3] {
        let mut sum = self.environment.level_irradiance();
        let mut add = |colour: [f64; 3], facing: f64, elevation: f64| {
            let level = facing * elevation.to_radians().sin().max(0.0);
            for (sum, tint) in sum.iter_mut().zip(colour) {
                *sum += tint * level;
            }
        };
        for sun in &self.sun {
            // What a plane that faces it receives of a disc with the radius r: (1 + cos r)/2 of that of a point.
            let spread = 0.5 + 0.5 * (0.5 * sun.angular_diameter).to_radians().cos();
            add(sun.colour.linear(), sun.irradiance * spread, sun.elevation);
        }
        for area in &self.area {
            add(area.colour.linear(), area.irradiance, area.elevation);
        }
        sum
    }
}

impl Environment {
    fn level_irradiance(&self) -> [f64; 3] {
        let scale = PI * self.radiance;
        let tint = match (self.kind, &self.pixels) {
            (EnvironmentKind::Gradient, _) => {
                // ∫ 2z·smoothstep(z) dz over 0 to 1.
                const OF_ZENITH: f64 = 0.7;
                let (zenith, horizon) = (self.zenith.linear(), self.horizon.linear());
                std::array::from_fn(|c| horizon[c] + (zenith[c] - horizon[c]) * OF_ZENITH)
            }
            (EnvironmentKind::Image, Some(image)) => image.level_radiance(),
            (EnvironmentKind::Image, None) => [1.0; 3],
            (EnvironmentKind::Constant, _) => self.colour.linear(),
        };
        tint.map(|c| c * scale)
    }
}

impl Design {
    /// Stops by which the picture is shown brighter than its light is: what the meter says, if there is one, and
    /// `view.exposure`.
    pub fn exposure(&self) -> f64 {
        self.metered_stops() + self.view.exposure
    }

    /// What the meter says, stops: 0 without one.
    pub fn metered_stops(&self) -> f64 {
        let View { metering, .. } = self.view;
        if metering == Metering::None {
            return 0.0;
        }
        let irradiance = self.light.level_irradiance();
        let luminance: f64 = irradiance.iter().zip(LUMINANCE).map(|(e, w)| e * w).sum();
        if luminance <= 0.0 || !luminance.is_finite() {
            return 0.0;
        }
        let white = white_cloth(self.quality.bounces) * luminance / PI;
        (SHOWN / white).log2().clamp(-MOST_STOPS, MOST_STOPS)
    }

    /// Radiance of the background, linear RGB: such that it shows in its colour as the meter has it.
    pub fn background_radiance(&self) -> [f64; 3] {
        let scale = (-self.metered_stops()).exp2();
        self.light.background.linear().map(|c| c * scale)
    }
}

/// What white terry reflects in a picture of so many bounces.
fn white_cloth(bounces: u32) -> f64 {
    let doublings = f64::from(bounces.max(1)).log2();
    let below = (doublings as usize).min(WHITE_CLOTH.len() - 2);
    let share = (doublings - below as f64).min(1.0);
    WHITE_CLOTH[below] + (WHITE_CLOTH[below + 1] - WHITE_CLOTH[below]) * share
}
