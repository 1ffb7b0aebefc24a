//! Lights and background of a scene: directions in world space, linear light (MODEL.md §8).

use super::{Lights, SunLight};
use crate::design::{Environment, EnvironmentKind, Light, Sun};

impl Lights {
    /// The lights of a design.
    pub fn new(light: &Light) -> Self {
        let Environment {
            radiance,
            kind: EnvironmentKind::Constant,
            colour,
        } = &light.environment;
        Self {
            suns: light.sun.iter().map(SunLight::new).collect(),
            environment: colour.linear().map(|c| c * radiance),
            background: light.background.linear(),
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
