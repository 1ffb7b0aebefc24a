//! How a point scatters (MODEL.md §8): phase functions of the pile and the skeleton's Lambert surface.
//!
//! A value is ψ/albedo, in 1/sr, so normalised that its integral over all light directions is at most 1 for every
//! view direction (for the Lambert surface the cosine is included). All directions point away from the point.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use crate::design::Phase;
use crate::geometry::Ray;
use crate::sampling::directions;
use crate::scene::PileOptics;

/// Distance from a surface at which rays leave it, mm: far above the precision of its hits (10⁻⁹ mm), far below any yarn.
const SURFACE_OFFSET_MM: f64 = 1e-6;

/// How one point scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lobe {
    /// Equally to all sides.
    Isotropic,
    /// As a small two-sided Lambertian surface with this unit normal.
    Frame(DVec3),
    /// As a fibre with this unit tangent.
    Fibre(DVec3),
    /// As an opaque Lambertian surface with this unit normal.
    Surface(DVec3),
}

/// A point that scatters light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// World position, mm.
    pub position: DVec3,
    /// Distance along the ray that found it, mm.
    pub t: f64,
    /// Unit normal of loop or yarn, turned against that ray.
    pub normal: DVec3,
    /// Share of light that is scattered, of red, green and blue.
    pub albedo: DVec3,
    /// How it scatters.
    pub lobe: Lobe,
}

impl Vertex {
    /// The ray that leaves it towards `direction`.
    pub fn leave(&self, direction: DVec3) -> Ray {
        let origin = match self.lobe {
            Lobe::Surface(normal) => self.position + normal * SURFACE_OFFSET_MM,
            _ => self.position,
        };
        Ray { origin, direction }
    }
}

/// The parameters of the phase functions.
#[derive(Debug, Clone)]
pub struct Optics {
    phase: Phase,
    /// k of `frame_lambert`.
    transmission: f64,
    /// s and p of `kajiya_kay`.
    specular: f64,
    exponent: f64,
    /// N_p at equal steps of θ_v from 0 to π; empty for other phases.
    highlight_norm: Vec<f64>,
}

impl Optics {
    /// Prepares the phase function of `pile`.
    pub fn new(pile: &PileOptics) -> Self {
        let exponent = f64::from(pile.exponent);
        Self {
            phase: pile.phase,
            transmission: f64::from(pile.transmission),
            specular: f64::from(pile.specular),
            exponent,
            highlight_norm: match pile.phase {
                Phase::KajiyaKay => highlight_norms(exponent),
                Phase::Isotropic | Phase::FrameLambert => Vec::new(),
            },
        }
    }

    /// Which phase function it is.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// ψ/albedo for light from `light`, seen from `view`.
    pub fn value(&self, lobe: Lobe, view: DVec3, light: DVec3) -> f64 {
        match lobe {
            Lobe::Isotropic => 0.25 * FRAC_1_PI,
            Lobe::Frame(normal) => {
                let (to_light, to_view) = (normal.dot(light), normal.dot(view));
                let share = if to_light * to_view > 0.0 {
                    1.0 - self.transmission
                } else {
                    self.transmission
                };
                share * to_light.abs() * FRAC_1_PI
            }
            Lobe::Fibre(tangent) => {
                let (cos_light, cos_view) = (tangent.dot(light), tangent.dot(view));
                let sine = |cosine: f64| (1.0 - cosine * cosine).max(0.0).sqrt();
                let (sin_light, sin_view) = (sine(cos_light), sine(cos_view));
                // cos(θ_l + θ_v − π) = −cos(θ_l + θ_v)
                let highlight = (sin_light * sin_view - cos_light * cos_view).max(0.0);
                (1.0 - self.specular) * sin_light * FRAC_1_PI * FRAC_1_PI
                    + self.specular * highlight.powf(self.exponent) / self.highlight_norm(cos_view)
            }
            Lobe::Surface(normal) => normal.dot(light).max(0.0) * FRAC_1_PI,
        }
    }

    /// A direction of light for a path seen from `view`, from two numbers in [0, 1), and ψ/albedo over its density.
    pub fn sample(&self, lobe: Lobe, view: DVec3, [u, v]: [f64; 2]) -> (DVec3, f64) {
        match lobe {
            Lobe::Isotropic => (directions::sphere(u, v), 1.0),
            Lobe::Frame(normal) => {
                let near = if normal.dot(view) > 0.0 {
                    normal
                } else {
                    -normal
                };
                let reflected = 1.0 - self.transmission;
                let direction = if u < reflected {
                    directions::cosine_hemisphere(near, u / reflected, v)
                } else {
                    directions::cosine_hemisphere(-near, (u - reflected) / self.transmission, v)
                };
                (direction, 1.0)
            }
            Lobe::Fibre(_) => {
                let direction = directions::sphere(u, v);
                (direction, 4.0 * PI * self.value(lobe, view, direction))
            }
            Lobe::Surface(normal) => (directions::cosine_hemisphere(normal, u, v), 1.0),
        }
    }

    /// N_p(θ_v), interpolated.
    fn highlight_norm(&self, cos_view: f64) -> f64 {
        let last = self.highlight_norm.len() - 1;
        let x = cos_view.clamp(-1.0, 1.0).acos() / PI * last as f64;
        let near = (x as usize).min(last - 1);
        let share = x - near as f64;
        self.highlight_norm[near] * (1.0 - share) + self.highlight_norm[near + 1] * share
    }
}

/// N_p(θ_v) = 2π ∫₀^π max(0, cos(θ + θ_v − π))^p sin θ dθ at equal steps of θ_v from 0 to π.
fn highlight_norms(exponent: f64) -> Vec<f64> {
    // The narrowest highlight, p = 500, is 0.1 rad wide: 60 steps of its integral, 8 of the table.
    const STEPS: usize = 2048;
    const ENTRIES: usize = 257;
    (0..ENTRIES)
        .map(|entry| {
            let view = PI * entry as f64 / (ENTRIES - 1) as f64;
            let width = PI / STEPS as f64;
            let sum: f64 = (0..STEPS)
                .map(|step| {
                    let theta = (step as f64 + 0.5) * width;
                    (theta + view - PI).cos().max(0.0).powf(exponent) * theta.sin()
                })
                .sum();
            TAU * sum * width
        })
        .collect()
}
