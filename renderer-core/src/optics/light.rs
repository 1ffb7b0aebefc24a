//! Lights that have a place or a direction of their own: suns and area lights (MODEL.md §8; area lights are not in the
//! paper). What arrives at a point of the world from one direction, drawn by two random numbers; whether it arrives is
//! for shadow rays to find out. They need no end: the cloth lies before every area light.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use crate::sampling::{Set, directions};
use crate::scene::{AreaLight, Lights, SunLight};

/// A sun or an area light.
#[derive(Debug, Clone, Copy)]
pub enum Light<'a> {
    /// Parallel light but for the width of its disc.
    Sun(&'a SunLight),
    /// A rectangle that shines on one side, equally to all of it.
    Area(&'a AreaLight),
}

impl<'a> Light<'a> {
    /// Light `number` of all, suns first, and which numbers draw its light at scattering `bounce`.
    #[inline(always)]
    pub fn of(lights: &'a Lights, number: usize, bounce: u32) -> Option<(Self, Set)> {
        if let Some(light) = lights.suns.get(number) {
            let sun = number as u32;
            return Some((Self::Sun(light), Set::Sun { bounce, sun }));
        }
        let number = number - lights.suns.len();
        let light = lights.areas.get(number)?;
        let area = number as u32;
        Some((Self::Area(light), Set::Area { bounce, area }))
    }

    /// A unit direction from `point` (world, mm) to the light, and the irradiance that comes from there on a plane that
    /// faces it: over all numbers [0, 1)² its mean is that of the whole light.
    #[inline(always)]
    pub fn towards(self, point: DVec3, [u, v]: [f64; 2]) -> (DVec3, DVec3) {
        match self {
            Self::Sun(sun) => {
                let centre = DVec3::from_array(sun.direction);
                let direction = directions::cone(centre, sun.angular_radius, u, v);
                (direction, DVec3::from_array(sun.irradiance))
            }
            Self::Area(area) => {
                // Uniform over the area: a part of it brings its radiance times its solid angle, dA·cos/r².
                let [x, y] = area.half_sides.map(DVec3::from_array);
                let place =
                    DVec3::from_array(area.centre) + x * (2.0 * u - 1.0) + y * (2.0 * v - 1.0);
                let facing = DVec3::from_array(area.facing);
                let way = place - point;
                let squared = way.length_squared();
                let direction = way / squared.sqrt();
                let cosine = -facing.dot(direction);
                if cosine <= 0.0 {
                    // In its plane, or behind it.
                    return (-facing, DVec3::ZERO);
                }
                let share = cosine / squared;
                (direction, DVec3::from_array(area.intensity) * share)
            }
        }
    }
}

impl Lights {
    /// How many suns and area lights there are.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.suns.len() + self.areas.len()
    }

    /// Mean radiance over all directions, the brightest channel's, that all lights bring unhindered to the middle of the
    /// cloth.
    pub fn mean_radiance(&self) -> f64 {
        let suns = self.suns.iter().map(Light::Sun);
        let lights = suns.chain(self.areas.iter().map(Light::Area));
        let sum: DVec3 = lights
            .map(|light| light.towards(DVec3::ZERO, [0.5; 2]).1 * (0.25 * FRAC_1_PI))
            .sum();
        (sum + DVec3::from_array(self.environment)).max_element()
    }
}
