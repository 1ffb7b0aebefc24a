//! Lights and background of a scene: directions in world space, linear light (MODEL.md §8).

use std::f64::consts::FRAC_PI_2;

use super::{Lights, Sky, SunLight};
use crate::design::{Environment, EnvironmentKind, Light, Sun};

impl Lights {
    /// The lights of a design.
    pub fn new(light: &Light) -> Self {
        let Environment {
            radiance, colour, ..
        } = light.environment;
        let tint = match light.environment.kind {
            EnvironmentKind::Constant => colour.linear(),
            EnvironmentKind::Gradient | EnvironmentKind::Image => [1.0; 3],
        };
        Self {
            suns: light.sun.iter().map(SunLight::new).collect(),
            environment: tint.map(|c| c * radiance),
            sky: Sky::new(&light.environment),
            background: light.background.linear(),
        }
    }
}

impl Sky {
    /// How an environment varies. One of kind `image` whose image was not read is uniform.
    fn new(environment: &Environment) -> Self {
        match (environment.kind, &environment.pixels) {
            (EnvironmentKind::Gradient, _) => Self::Gradient {
                zenith: environment.zenith.linear(),
                horizon: environment.horizon.linear(),
                ground: environment.ground.linear(),
            },
            (EnvironmentKind::Image, Some(image)) => Self::Image {
                image: image.clone(),
                middle: FRAC_PI_2 + environment.rotation.to_radians(),
            },
            (EnvironmentKind::Constant | EnvironmentKind::Image, _) => Self::Uniform,
        }
    }
}

impl SunLight {
    fn new(sun: &Sun) -> Self {
        let (sin_azimuth, cos_azimuth) = sun.azimuth.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = sun.elevation.to_radians().sin_cos();
        Self {
            direction: [
                cos_elevation * cos_azimuth,
                cos_elevation * sin_azimuth,
                sin_elevation,
            ],
            angular_radius: (0.5 * sun.angular_diameter).to_radians(),
            irradiance: sun.colour.linear().map(|c| c * sun.irradiance),
        }
    }
}
