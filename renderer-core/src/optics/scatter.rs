//! How a point scatters (MODEL.md §8): phase functions of the pile; `surface` has those of the skeleton.
//!
//! A value is ψ/albedo, in 1/sr, so normalised that its integral over all light directions is at most 1 for every
//! view direction (for surfaces the cosine is included). All directions point away from the point.
//!
//! With the light given instead, the sum over all views is 1 only for `isotropic`, since extinction does not depend on
//! direction: for `frame_lambert` and `gradient_lambert` it is 2|n·l|, for `kajiya_kay` up to 1.3. So a beam that meets
//! the frames of most loops face on is given back brighter than it came, once: measured up to 1.5 times for
//! `frame_lambert`, not at all for `gradient_lambert`, whose surfaces face all sides. Light from all around never is.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DMat3, DVec3};

use super::SurfaceOptics;
use crate::design::Phase;
use crate::geometry::Ray;
use crate::sampling::directions;
use crate::scene::{Material, PileOptics, Skeleton, Sky};

/// How one point scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lobe {
    /// Equally to all sides.
    Isotropic,
    /// As a small two-sided Lambertian surface.
    Frame {
        /// Its unit normal.
        normal: DVec3,
        /// Index of the loop's material.
        material: usize,
    },
    /// In this share as a small two-sided Lambertian surface, in the rest equally to all sides.
    Gradient {
        /// Unit vector down the slope of the density.
        normal: DVec3,
        /// How much of a surface it is.
        share: f64,
        /// Index of the loop's material.
        material: usize,
    },
    /// As a fibre.
    Fibre {
        /// Its unit tangent.
        tangent: DVec3,
        /// Index of the loop's material.
        material: usize,
    },
    /// As an opaque Lambertian surface with this unit normal.
    Surface(DVec3),
    /// As an opaque surface with this unit normal and a highlight.
    Phong(DVec3),
    /// As an opaque surface of parallel fibres.
    Fibres {
        /// Unit normal of the surface.
        normal: DVec3,
        /// Unit vector along the fibres, in the surface.
        along: DVec3,
    },
}

/// To which half of the sky a point of the cloth looks, and how often.
#[derive(Debug, Clone, Copy)]
pub struct Exposure {
    /// The side of the sheet that the point is on: 1 the front, −1 the back.
    pub up: f64,
    /// Share of the directions that go to the other side, for points that scatter equally to all: see
    /// [`Skeleton::worth_looking_down`].
    pub down: f64,
    /// How directions of the sheet are turned into the world's where the cloth is bent.
    pub world_from_sheet: Option<DMat3>,
}

impl Exposure {
    fn to_world(self, direction: DVec3) -> DVec3 {
        let rotation = self.world_from_sheet;
        rotation.map_or(direction, |rotation| rotation * direction)
    }

    fn to_sheet(self, direction: DVec3) -> DVec3 {
        let rotation = self.world_from_sheet;
        rotation.map_or(direction, |rotation| rotation.transpose() * direction)
    }

    /// Share of the directions in the world that go to the other half: points of bent cloth may see as much of it as of
    /// their own.
    fn down_in_world(self) -> f64 {
        if self.world_from_sheet.is_some() {
            0.5
        } else {
            self.down
        }
    }

    /// The share of the half that a direction is in, where the other half has the share `down`.
    fn half_share(self, direction: DVec3, down: f64) -> f64 {
        if direction.z * self.up < 0.0 {
            down
        } else {
            1.0 - down
        }
    }
}

impl Lobe {
    /// Of `gradient_lambert` where ρ changes by `gradient` per mm: the surface faces n = −∇ρ/|∇ρ|, and is one in the
    /// share x²/(1 + x²), where x = |∇ρ|·`thickness` is how much ρ changes over the loop's thickness. A yarn's skin,
    /// where ρ falls from 1 to 0 over an eighth of the thickness or less, is all surface; a density that takes the
    /// whole thickness for it is none. Where ∇ρ vanishes, and n with it, so does the share.
    pub fn gradient(gradient: DVec3, thickness: f64, material: usize) -> Self {
        let steepness = gradient.length();
        let x = steepness * thickness;
        Self::Gradient {
            normal: (-gradient).normalize_or(DVec3::Z),
            share: x * x / (1.0 + x * x),
            material,
        }
    }
}

/// A direction to the environment, drawn at random.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentSample {
    /// Unit vector in sheet space.
    pub direction: DVec3,
    /// That direction as a unit vector in the world.
    pub in_world: DVec3,
    /// ψ/albedo over its density.
    pub weight: f64,
    /// Drawn by the environment's light, not by the phase.
    pub by_light: bool,
}

/// The largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A point that scatters light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position in the flat sheet, mm; for level cloth that in the world.
    pub position: DVec3,
    /// Distance along the ray that found it, mm.
    pub t: f64,
    /// Unit normal of loop or yarn, turned against that ray.
    pub normal: DVec3,
    /// Share of light that is scattered, of red, green and blue.
    pub albedo: DVec3,
    /// How it scatters.
    pub lobe: Lobe,
    /// Turns directions of the sheet, which `normal`, `lobe` and all directions of scattering are, to those of the
    /// world.
    pub world_from_sheet: DMat3,
}

impl Vertex {
    /// A direction of the world as one of the sheet.
    #[inline(always)]
    pub fn sheet_direction(&self, world: DVec3) -> DVec3 {
        self.world_from_sheet.transpose() * world
    }

    /// The ray that leaves it towards `direction`, a surface from `offset_mm` above it: that is to be above the
    /// precision of the renderer's hits and far below any yarn. It starts in the sheet, but its direction is the one
    /// that it has in the world.
    #[inline(always)]
    pub fn leave(&self, direction: DVec3, offset_mm: f64) -> Ray {
        let origin = match self.lobe {
            Lobe::Surface(normal) | Lobe::Phong(normal) | Lobe::Fibres { normal, .. } => {
                self.position + normal * offset_mm
            }
            _ => self.position,
        };
        Ray {
            origin,
            direction: self.world_from_sheet * direction,
        }
    }
}

/// The phase function of each material, and its parameters.
#[derive(Debug, Clone)]
pub struct Optics {
    surface: SurfaceOptics,
    materials: Vec<Parameters>,
    /// For each different p of `kajiya_kay`, N_p at equal steps of θ_v from 0 to π; empty where no material has that
    /// phase.
    highlight_norms: Vec<Vec<f64>>,
}

/// The parameters of one material.
#[derive(Debug, Clone, Copy)]
struct Parameters {
    phase: Phase,
    /// k of `frame_lambert` and `gradient_lambert`.
    transmission: f64,
    /// s and p of `kajiya_kay`.
    specular: f64,
    exponent: f64,
    /// Index into [`Optics::highlight_norms`].
    norm: usize,
}

impl Optics {
    /// Prepares the phase functions of `pile` and the surface of `skeleton`.
    pub fn new(pile: &PileOptics, skeleton: &Skeleton) -> Self {
        let mut exponents: Vec<f64> = Vec::new();
        let mut parameters = |material: &Material| {
            let exponent = f64::from(material.exponent);
            let known = exponents.iter().position(|&known| known == exponent);
            if known.is_none() {
                exponents.push(exponent);
            }
            Parameters {
                phase: material.phase,
                transmission: f64::from(material.transmission),
                specular: f64::from(material.specular),
                exponent,
                norm: known.unwrap_or(exponents.len() - 1),
            }
        };
        let materials = pile.materials.iter().map(&mut parameters).collect();
        Self {
            surface: SurfaceOptics::new(skeleton),
            materials,
            highlight_norms: if pile.has(Phase::KajiyaKay) {
                exponents.into_iter().map(highlight_norms).collect()
            } else {
                Vec::new()
            },
        }
    }

    /// Which phase function a material has.
    pub fn phase(&self, material: usize) -> Phase {
        self.materials[material].phase
    }

    /// ψ/albedo for light from `light`, seen from `view`.
    pub fn value(&self, lobe: Lobe, view: DVec3, light: DVec3) -> f64 {
        match lobe {
            Lobe::Isotropic => 0.25 * FRAC_1_PI,
            Lobe::Frame { normal, material } => {
                let transmission = self.materials[material].transmission;
                two_sided(normal, transmission, view, light)
            }
            Lobe::Gradient {
                normal,
                share,
                material,
            } => {
                let transmission = self.materials[material].transmission;
                let surface = two_sided(normal, transmission, view, light);
                share * surface + (1.0 - share) * 0.25 * FRAC_1_PI
            }
            Lobe::Fibre { tangent, material } => {
                let fibre = self.materials[material];
                let (cos_light, cos_view) = (tangent.dot(light), tangent.dot(view));
                let sine = |cosine: f64| (1.0 - cosine * cosine).max(0.0).sqrt();
                let (sin_light, sin_view) = (sine(cos_light), sine(cos_view));
                // cos(θ_l + θ_v − π) = −cos(θ_l + θ_v)
                let highlight = (sin_light * sin_view - cos_light * cos_view).max(0.0);
                (1.0 - fibre.specular) * sin_light * FRAC_1_PI * FRAC_1_PI
                    + fibre.specular * highlight.powf(fibre.exponent)
                        / self.highlight_norm(fibre.norm, cos_view)
            }
            Lobe::Surface(normal) => normal.dot(light).max(0.0) * FRAC_1_PI,
            Lobe::Phong(normal) => self.surface.phong(normal, view, light),
            Lobe::Fibres { normal, along } => self.surface.fibres(normal, along, view, light),
        }
    }

    /// A direction of light for a path seen from `view`, from two numbers in [0, 1), and ψ/albedo over its density.
    pub fn sample(&self, lobe: Lobe, view: DVec3, [u, v]: [f64; 2]) -> (DVec3, f64) {
        match lobe {
            Lobe::Isotropic => (directions::sphere(u, v), 1.0),
            Lobe::Frame { normal, material } => {
                let transmission = self.materials[material].transmission;
                let direction = two_sided_direction(normal, transmission, view, [u, v]);
                (direction, 1.0)
            }
            Lobe::Gradient {
                normal,
                share,
                material,
            } => {
                let transmission = self.materials[material].transmission;
                let direction = if u < share {
                    two_sided_direction(normal, transmission, view, [u / share, v])
                } else {
                    directions::sphere((u - share) / (1.0 - share), v)
                };
                (direction, 1.0)
            }
            Lobe::Fibre { .. } => {
                let direction = directions::sphere(u, v);
                (direction, 4.0 * PI * self.value(lobe, view, direction))
            }
            Lobe::Surface(normal) => (directions::cosine_hemisphere(normal, u, v), 1.0),
            Lobe::Phong(normal) => self.surface.sample_phong(normal, view, [u, v]),
            Lobe::Fibres { normal, along } => {
                self.surface.sample_fibres(normal, along, view, [u, v])
            }
        }
    }

    /// A direction of light from `sky`, from numbers in [0, 1): two for the direction, and one for the half of the sky.
    /// It follows the phase, and that of an importance-sampled environment mostly the light of its picture (one-sample
    /// balance heuristic: Veach 1997, §9.2.4).
    #[inline(always)]
    pub fn sample_sky(
        &self,
        sky: &Sky,
        lobe: Lobe,
        view: DVec3,
        exposure: Exposure,
        [u, v]: [f64; 2],
        half: f64,
    ) -> EnvironmentSample {
        let Some((light, middle)) = sky.importance_table() else {
            let (direction, weight) = self.sample_by_phase(lobe, view, exposure, [u, v], half);
            return EnvironmentSample {
                direction,
                in_world: exposure.to_world(direction),
                weight,
                by_light: false,
            };
        };
        // One number chooses between the two and goes on in its part, so that each of them is spread evenly. In f32,
        // since the texel that it finds must be the same on all devices.
        let (phase_share, light_share) = (Sky::PHASE_SHARE, 1.0 - Sky::PHASE_SHARE);
        let by_light = u as f32 >= phase_share;
        let (direction, in_world) = if by_light {
            let is_below = (half < exposure.down_in_world()) != (exposure.up < 0.0);
            let u = (u as f32 - phase_share) * (1.0 / light_share);
            let in_world = light.direction(is_below, [u.min(BELOW_ONE), v as f32], middle);
            (exposure.to_sheet(in_world), in_world)
        } else {
            let u = u / f64::from(phase_share);
            let direction = match lobe {
                // What draws fibres cannot tell its density.
                Lobe::Fibres { normal, .. } => directions::cosine_hemisphere(normal, u, v),
                _ => self.sample_by_phase(lobe, view, exposure, [u, v], half).0,
            };
            (direction, exposure.to_world(direction))
        };
        let by_phase = match lobe {
            Lobe::Isotropic => exposure.half_share(direction, exposure.down) * 0.5 * FRAC_1_PI,
            _ => self.density(lobe, view, direction),
        };
        let of_light = exposure.half_share(in_world, exposure.down_in_world())
            * light.density(in_world, middle);
        let density = f64::from(phase_share) * by_phase + f64::from(light_share) * of_light;
        EnvironmentSample {
            direction,
            in_world,
            weight: self.value(lobe, view, direction) / density.max(1e-20),
            by_light,
        }
    }

    /// The density of [`Self::sample`], per sr; of fibres that of a Lambertian surface.
    fn density(&self, lobe: Lobe, view: DVec3, direction: DVec3) -> f64 {
        match lobe {
            Lobe::Isotropic | Lobe::Fibre { .. } => 0.25 * FRAC_1_PI,
            Lobe::Frame { .. } | Lobe::Gradient { .. } | Lobe::Surface(_) => {
                self.value(lobe, view, direction)
            }
            Lobe::Phong(normal) => self.surface.phong_density(normal, view, direction),
            Lobe::Fibres { normal, .. } => normal.dot(direction).max(0.0) * FRAC_1_PI,
        }
    }

    /// A direction to the environment that follows the phase alone, and ψ/albedo over its density.
    fn sample_by_phase(
        &self,
        lobe: Lobe,
        view: DVec3,
        exposure: Exposure,
        [u, v]: [f64; 2],
        half: f64,
    ) -> (DVec3, f64) {
        if lobe != Lobe::Isotropic {
            return self.sample(lobe, view, [u, v]);
        }
        let Exposure { up, down, .. } = exposure;
        let DVec3 { x, y, z } = directions::sphere(0.5 * u, v);
        if half < down {
            (DVec3::new(x, y, -up * z), 0.5 / down)
        } else {
            (DVec3::new(x, y, up * z), 0.5 / (1.0 - down))
        }
    }

    /// N_p(θ_v) of one of the exponents, interpolated.
    fn highlight_norm(&self, exponent: usize, cos_view: f64) -> f64 {
        let norms = &self.highlight_norms[exponent];
        let last = norms.len() - 1;
        let x = cos_view.clamp(-1.0, 1.0).acos() / PI * last as f64;
        let near = (x as usize).min(last - 1);
        let share = x - near as f64;
        norms[near] * (1.0 - share) + norms[near + 1] * share
    }
}

/// A small Lambertian surface that lets the share `transmission` of the light through.
fn two_sided(normal: DVec3, transmission: f64, view: DVec3, light: DVec3) -> f64 {
    let (to_light, to_view) = (normal.dot(light), normal.dot(view));
    let share = if to_light * to_view > 0.0 {
        1.0 - transmission
    } else {
        transmission
    };
    share * to_light.abs() * FRAC_1_PI
}

/// A direction with the density of [`two_sided`].
fn two_sided_direction(normal: DVec3, transmission: f64, view: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    let near = if normal.dot(view) > 0.0 {
        normal
    } else {
        -normal
    };
    let reflected = 1.0 - transmission;
    if u < reflected {
        directions::cosine_hemisphere(near, u / reflected, v)
    } else {
        directions::cosine_hemisphere(-near, (u - reflected) / transmission, v)
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
