//! Paths: from a camera ray to radiance (MODEL.md §8 and §9; the paper's §6, step 6).
//!
//! The method decides how the camera's ray and the shadow rays from its first point gather light; from there on paths are
//! tracked. Environment light comes by its own shadow ray at the first point of all methods but `tracked` and where a path is
//! closed, everywhere else by the onward ray if that leaves the cloth: never by both.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::{Scratch, Tracer};
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::{Vertex, bounced, environment_radiance};
use crate::render::accumulation::{FirstHit, Sample};
use crate::sampling::{self, Pcg, Set, directions};

/// The scattering from which on a path may end by Russian roulette: earlier ones carry most of the picture.
const ROULETTE_FROM: u32 = 3;

/// Distance from a surface at which rays leave it, mm: above the precision of its hits, far below any yarn.
const SURFACE_OFFSET_MM: f64 = 2e-5;

/// One path in the making.
pub(super) struct PathTracer<'a> {
    tracer: &'a Tracer,
    scratch: &'a mut Scratch,
    pixel: [u32; 2],
    seed: u32,
    number: u32,
    /// Numbers for free paths.
    pcg: Pcg,
}

/// Where on a path light is gathered.
#[derive(Clone, Copy)]
struct Gather {
    /// Which scattering, from 1.
    bounce: u32,
    /// Its shadow rays are composited, not tracked.
    composited: bool,
    /// How many orders of bounced light are estimated here.
    orders: u32,
}

impl<'a> PathTracer<'a> {
    pub fn new(
        tracer: &'a Tracer,
        pixel: [u32; 2],
        number: u32,
        scratch: &'a mut Scratch,
    ) -> Self {
        let seed = sampling::pixel_seed(tracer.settings.seed, pixel);
        Self {
            tracer,
            scratch,
            pixel,
            seed,
            number,
            pcg: Pcg::new(seed, number),
        }
    }

    fn random(&self, set: Set) -> [f64; 4] {
        let sampler = self.tracer.settings.sampler;
        sampling::sample(sampler, self.seed, self.number, set).map(f64::from)
    }

    /// The radiance along the camera's ray, and what it met first.
    pub fn sample(mut self) -> Sample {
        let tracer = self.tracer;
        let [x, y, pick, _] = self.random(Set::Film);
        let [column, row] = self.pixel.map(f64::from);
        let (origin, direction) =
            (tracer.camera).ray(DVec2::new(column + x, row + y), tracer.size);
        let ray = Ray { origin, direction };
        let first = match tracer.settings.method {
            Method::Tracked => tracer.collision(&ray, &mut self.pcg, self.scratch),
            _ => tracer.first_event(&ray, 1.0 - pick, self.scratch),
        };
        let Some(first) = first else {
            return Sample {
                radiance: DVec3::from_array(tracer.cloth.scene.lights.background),
                first: None,
            };
        };
        Sample {
            radiance: self.radiance_from(first, -ray.direction),
            first: Some(FirstHit {
                depth_mm: first.t,
                normal: first.normal,
                albedo: first.albedo,
            }),
        }
    }

    /// Radiance that leaves `vertex` towards `view`: the sum over all scatterings of a path from there.
    fn radiance_from(&mut self, mut vertex: Vertex, mut view: DVec3) -> DVec3 {
        let tracer = self.tracer;
        let lights = &tracer.cloth.scene.lights;
        let bounces = tracer.settings.bounces;
        let closing_bounce = tracer.settings.closing_bounce();
        let has_environment = lights.environment != [0.0; 3];
        let mut throughput = DVec3::ONE;
        let mut radiance = DVec3::ZERO;
        for bounce in 1..=bounces {
            // Points found by compositing see their lights by compositing.
            let composited = bounce == 1 && tracer.settings.method != Method::Tracked;
            let closing = closing_bounce == Some(bounce);
            let gather = Gather {
                bounce,
                composited,
                orders: if closing { bounces - bounce } else { 0 },
            };
            let mut light = self.sunlight(&vertex, view, gather);
            if has_environment && (composited || closing) {
                light += self.skylight(&vertex, view, gather);
            }
            radiance += throughput * vertex.albedo * light;
            if closing {
                break;
            }

            let gathers_environment = !composited && has_environment;
            // Without shadows the environment's light needs no ray to find out whether it arrives.
            let follows_environment = gathers_environment && tracer.settings.shadows;
            if bounce == bounces && !gathers_environment {
                break;
            }
            let [u, v, survival, _] = self.random(Set::Onward { bounce });
            let (direction, weight) = tracer.cloth.optics.sample(vertex.lobe, view, [u, v]);
            throughput *= vertex.albedo * weight;
            if gathers_environment && !follows_environment {
                radiance += throughput * environment_radiance(lights, direction);
                if bounce == bounces {
                    break;
                }
            }
            if bounce >= ROULETTE_FROM {
                let chance = throughput.max_element().min(1.0);
                if survival >= chance {
                    break;
                }
                throughput /= chance;
            }
            let onward = vertex.leave(direction, SURFACE_OFFSET_MM);
            match tracer.collision(&onward, &mut self.pcg, self.scratch) {
                Some(next) => (vertex, view) = (next, -direction),
                None => {
                    if follows_environment {
                        radiance += throughput * environment_radiance(lights, direction);
                    }
                    break;
                }
            }
        }
        radiance
    }

    /// Light of the suns scattered towards `view`, but for the albedo.
    fn sunlight(&mut self, vertex: &Vertex, view: DVec3, gather: Gather) -> DVec3 {
        let tracer = self.tracer;
        let mut light = DVec3::ZERO;
        for (sun, number) in tracer.cloth.scene.lights.suns.iter().zip(0..) {
            let set = Set::Sun {
                bounce: gather.bounce,
                sun: number,
            };
            let [u, v, ..] = self.random(set);
            let centre = DVec3::from_array(sun.direction);
            let direction = directions::cone(centre, sun.angular_radius, u, v);
            let value = tracer.cloth.optics.value(vertex.lobe, view, direction);
            if value > 0.0 || gather.orders > 0 {
                let visibility = self.visibility(&vertex.leave(direction, SURFACE_OFFSET_MM), gather.composited);
                let by_bounces = by_bounces(vertex, direction, visibility, gather.orders);
                let light_of_sun = by_bounces * (0.25 * FRAC_1_PI) + value * visibility;
                light += DVec3::from_array(sun.irradiance) * light_of_sun;
            }
        }
        light
    }

    /// Light of the environment scattered towards `view`, but for the albedo, by one shadow ray.
    fn skylight(&mut self, vertex: &Vertex, view: DVec3, gather: Gather) -> DVec3 {
        let tracer = self.tracer;
        let [u, v, ..] = self.random(Set::Environment {
            bounce: gather.bounce,
        });
        let (direction, weight) = tracer.cloth.optics.sample(vertex.lobe, view, [u, v]);
        let visibility = self.visibility(&vertex.leave(direction, SURFACE_OFFSET_MM), gather.composited);
        let by_bounces = by_bounces(vertex, direction, visibility, gather.orders);
        environment_radiance(&tracer.cloth.scene.lights, direction)
            * (by_bounces + visibility)
            * weight
    }

    fn visibility(&mut self, ray: &Ray, composited: bool) -> f64 {
        let tracer = self.tracer;
        if !tracer.settings.shadows {
            return 1.0;
        }
        if composited {
            tracer.composited_visibility(ray, self.scratch)
        } else {
            tracer.tracked_visibility(ray, &mut self.pcg, self.scratch)
        }
    }
}

/// Mean radiance by `orders` further bounces of light from `direction`, per mean radiance that it would bring unhindered.
fn by_bounces(vertex: &Vertex, direction: DVec3, visibility: f64, orders: u32) -> DVec3 {
    if orders == 0 {
        return DVec3::ZERO;
    }
    let up = (direction.z * vertex.position.z.signum()).max(0.0);
    bounced(visibility, up, vertex.albedo, orders)
}
