//! Lights and background of a scene: directions in world space, linear light (MODEL.md §8).

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::lod::LodRegion;
use super::{AreaLight, Lights, Sky, SunLight};
use crate::design::{self, Design, Environment, EnvironmentKind, Light, Sun};

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
            areas: light.area.iter().map(AreaLight::new).collect(),
            environment: tint.map(|c| c * radiance),
            sky: Sky::new(&light.environment),
            background: light.background.linear(),
        }
    }
}

impl Lights {
    /// These lights in the world of a region of a design: area lights come nearer and shrink with it.
    pub(super) fn in_region(mut self, region: &LodRegion, design: &Design) -> Self {
        let scale = region.scale();
        for area in &mut self.areas {
            let centre = DVec3::from_array(area.centre);
            area.centre = region.region_from_world(design, centre, 0.0).to_array();
            area.half_sides = area.half_sides.map(|side| side.map(|mm| mm * scale));
            area.intensity = area.intensity.map(|mm2| mm2 * scale * scale);
        }
        self
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
        Self {
            direction: direction(sun.azimuth, sun.elevation).to_array(),
            angular_radius: (0.5 * sun.angular_diameter).to_radians(),
            irradiance: sun.colour.linear().map(|c| c * sun.irradiance),
        }
    }
}

impl AreaLight {
    fn new(area: &design::AreaLight) -> Self {
        let away = direction(area.azimuth, area.elevation);
        // One side is level; straight above the cloth it keeps its azimuth.
        let (sine, cosine) = area.azimuth.to_radians().sin_cos();
        let level = DVec3::new(-sine, cosine, 0.0);
        let half_sides = [0.5 * area.width, 0.5 * area.height];
        let radiance = area.irradiance / seen_share(half_sides, area.distance);
        let intensity = radiance * area.width * area.height;
        Self {
            centre: (away * area.distance).to_array(),
            half_sides: [
                (level * half_sides[0]).to_array(),
                (away.cross(level) * half_sides[1]).to_array(),
            ],
            facing: (-away).to_array(),
            intensity: area.colour.linear().map(|c| c * intensity),
        }
    }
}

/// Irradiance per radiance of a rectangle of these half sides, on a plane parallel to it at `distance` from its middle:
/// four times the known form of one corner (Howell's catalogue of configuration factors, B-3), times π.
fn seen_share([a, b]: [f64; 2], distance: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let slant = a.hypot(distance);
        a / slant * (b / slant).atan()
    };
    2.0 * (part(a, b) + part(b, a))
}

/// Unit vector to azimuth and elevation in degrees.
fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth.to_radians().sin_cos();
    let (sin_elevation, cos_elevation) = elevation.to_radians().sin_cos();
    DVec3::new(
        cos_elevation * cos_azimuth,
        cos_elevation * sin_azimuth,
        sin_elevation,
    )
}
