//! Radiance of the environment in a direction (MODEL.md §8): constant, a gradient, or a picture.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::design::EnvironmentImage;
use crate::sampling::PiecewiseConstant2D;
use crate::scene::{Lights, Sky};

/// Radiance that arrives from the unit vector `direction`, world space.
pub fn environment_radiance(lights: &Lights, direction: DVec3) -> DVec3 {
    DVec3::from_array(lights.environment) * factor(&lights.sky, direction)
}

fn factor(sky: &Sky, direction: DVec3) -> DVec3 {
    match sky {
        Sky::Uniform => DVec3::ONE,
        Sky::Gradient {
            zenith,
            horizon,
            ground,
        } => {
            let horizon = DVec3::from_array(*horizon);
            if direction.z >= 0.0 {
                horizon.lerp(DVec3::from_array(*zenith), smoothstep(direction.z))
            } else {
                let share = smoothstep(-direction.z / Sky::HAZE);
                horizon.lerp(DVec3::from_array(*ground), share)
            }
        }
        Sky::Image { image, middle } => {
            let across = direction.x.hypot(direction.y);
            let azimuth = direction.y.atan2(direction.x);
            // Columns go against azimuths; the middle one is half a turn from both borders.
            let column = (0.5 - (azimuth - middle) / TAU).rem_euclid(1.0);
            let row = across.atan2(direction.z) / PI;
            bilinear(image, column, row)
        }
    }
}

fn smoothstep(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// The picture at `column` and `row`, both in [0, 1] from its left and upper border.
fn bilinear(image: &EnvironmentImage, column: f64, row: f64) -> DVec3 {
    let (width, height) = (image.width() as f64, image.height() as f64);
    // Texel k is centred at (k + ½)/width.
    let x = column * width - 0.5;
    let y = (row * height - 0.5).clamp(0.0, height - 1.0);
    let (left, upper) = (x.floor(), y.floor());
    let texel = |x: f64, y: f64| {
        let x = x.rem_euclid(width) as usize;
        let [r, g, b] = image.pixel(x, y.min(height - 1.0) as usize);
        DVec3::new(r.into(), g.into(), b.into())
    };
    let line = |y: f64| texel(left, y).lerp(texel(left + 1.0, y), x - left);
    line(upper).lerp(line(upper + 1.0), y - upper)
}

impl Sky {
    /// Share of the directions to an importance-sampled environment that follow the phase all the same: what a
    /// picture's light does not tell is which part of it is shaded.
    pub const PHASE_SHARE: f32 = 0.25;

    /// The light of a picture that directions are drawn by, and the azimuth of its middle, radians; `None` if they
    /// follow the phase alone. Light of such a sky comes by shadow rays only, at every scattering, never by paths that
    /// leave the cloth.
    #[inline(always)]
    pub fn importance_table(&self) -> Option<(&PiecewiseConstant2D, f64)> {
        match self {
            Self::Image { image, middle } if image.light().is_uneven() => {
                Some((image.light(), *middle))
            }
            _ => None,
        }
    }
}
