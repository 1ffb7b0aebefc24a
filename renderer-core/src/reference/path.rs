//! Paths: from a camera ray to radiance (MODEL.md §8 and §9; the paper's §6, step 6).
//!
//! The method decides how the camera's ray and the shadow rays from its first point gather light; from there on, with
//! more than one bounce, paths are tracked. `tracked` is tracked from the camera on. Environment light comes by its own
//! shadow ray at the first point of all methods but `tracked`, and everywhere else by the onward ray if that
//! leaves the cloth: never by both. A sky whose light tells where to look ([`Sky::drawn`](crate::scene::Sky::drawn)) is
//! reached by a shadow ray everywhere.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::{Scratch, Tracer};
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::{FromSky, Light, Vertex, bounced, environment_radiance};
use crate::render::accumulation::{FirstHit, Sample};
use crate::sampling::{self, Pcg, Set};

/// The scattering from which on a path may end by Russian roulette: earlier ones carry most of the picture.
const ROULETTE_FROM: u32 = 3;

/// Distance from a surface at which rays leave it, mm: far above the precision of its hits (10⁻⁹ mm), far below any yarn.
const SURFACE_OFFSET_MM: f64 = 1e-6;

/// How a point gathers light.
#[derive(Clone, Copy)]
struct Gather {
    /// Which scattering, from 1.
    bounce: u32,
    /// Its shadow rays are composited, not tracked.
    composited: bool,
    /// How many orders of bounced light are estimated here.
    orders: u32,
}

impl Gather {
    /// Mean radiance by bounces of light from `direction`, per mean radiance that it would bring unhindered.
    fn by_bounces(self, vertex: &Vertex, direction: DVec3, visibility: f64) -> DVec3 {
        let up = (direction.z * vertex.position.z.signum()).max(0.0);
        bounced(visibility, up, vertex.albedo, self.orders)
    }
}

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

impl<'a> PathTracer<'a> {
    pub(super) fn new(
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
    pub(super) fn sample(mut self) -> Sample {
        let tracer = self.tracer;
        let [x, y, pick, choice] = self.random(Set::Film);
        let [column, row] = self.pixel.map(f64::from);
        let ray = tracer.camera_ray(DVec2::new(column + x, row + y));
        let first = match tracer.settings.method {
            Method::Tracked => tracer.collision(&ray, &mut self.pcg, self.scratch),
            Method::Single | Method::Layered => tracer.first_event(&ray, 1.0 - pick, self.scratch),
            Method::Exact | Method::SixFace => {
                tracer.marched_event(&ray, 1.0 - pick, choice, self.scratch)
            }
        };
        let Some(first) = first else {
            return Sample {
                radiance: DVec3::from_array(tracer.scene.lights.background),
                first: None,
            };
        };
        Sample {
            radiance: self.radiance_from(first, first.sheet_direction(-ray.direction)),
            first: Some(FirstHit {
                depth_mm: first.t * self.tracer.scene.sheet.cloth_scale(),
                normal: first.world_from_sheet * first.normal,
                albedo: first.albedo,
            }),
        }
    }

    /// Radiance that leaves `vertex` towards `view`: the sum over all scatterings of a path from there (step 6).
    fn radiance_from(&mut self, mut vertex: Vertex, mut view: DVec3) -> DVec3 {
        let tracer = self.tracer;
        let bounces = tracer.settings.bounces;
        let lights = &tracer.scene.lights;
        let path_cutoff = tracer.settings.path_cutoff();
        let is_drawn = lights.sky.drawn().is_some();
        let mut throughput = DVec3::ONE;
        let mut radiance = DVec3::ZERO;
        for bounce in 1..=bounces {
            // Points found by compositing see their lights by compositing.
            let composited = bounce == 1 && tracer.settings.method != Method::Tracked;
            let closing = path_cutoff == Some(bounce);
            let gather = Gather {
                bounce,
                composited,
                orders: if closing { bounces - bounce } else { 0 },
            };
            let mut light = self.direct_light(&vertex, view, gather);
            if composited || closing || is_drawn {
                light += self.skylight(&vertex, view, gather);
            }
            radiance += throughput * vertex.albedo * light;
            if closing {
                break;
            }

            let gathers_environment = !composited && !is_drawn && lights.environment != [0.0; 3];
            // Without shadows the environment's light needs no ray to find out whether it arrives.
            let follows_environment = gathers_environment && tracer.settings.shadows;
            if bounce == bounces && !gathers_environment {
                break;
            }
            let [u, v, survival, _] = self.random(Set::Onward { bounce });
            let (direction, weight) = tracer.optics.sample(vertex.lobe, view, [u, v]);
            let onward = tracer.leave(&vertex, direction, SURFACE_OFFSET_MM);
            throughput *= vertex.albedo * weight;
            if gathers_environment && !follows_environment {
                radiance += throughput * environment_radiance(lights, onward.direction);
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
            match tracer.collision(&onward, &mut self.pcg, self.scratch) {
                Some(next) => {
                    (vertex, view) = (next, next.sheet_direction(-onward.direction));
                }
                None => {
                    if follows_environment {
                        radiance += throughput * environment_radiance(lights, onward.direction);
                    }
                    break;
                }
            }
        }
        radiance
    }

    /// Light of suns and area lights scattered towards `view`, but for the albedo.
    fn direct_light(&mut self, vertex: &Vertex, view: DVec3, gather: Gather) -> DVec3 {
        let tracer = self.tracer;
        let lights = &tracer.scene.lights;
        let mut light = DVec3::ZERO;
        let point = tracer.scene.lit_point(vertex.position);
        let sources = (0..).map_while(|number| Light::of(lights, number, gather.bounce));
        for (source, set) in sources {
            let [u, v, ..] = self.random(set);
            let (world, irradiance) = source.towards(point, [u, v]);
            let direction = vertex.sheet_direction(world);
            let value = tracer.optics.value(vertex.lobe, view, direction);
            if value > 0.0 || gather.orders > 0 {
                let visibility = self.visibility(
                    &tracer.leave(vertex, direction, SURFACE_OFFSET_MM),
                    gather.composited,
                );
                let by_bounces = gather.by_bounces(vertex, direction, visibility);
                light += irradiance * (by_bounces * (0.25 * FRAC_1_PI) + value * visibility);
            }
        }
        light
    }

    /// Light of the environment scattered towards `view`, but for the albedo, by one shadow ray.
    fn skylight(&mut self, vertex: &Vertex, view: DVec3, gather: Gather) -> DVec3 {
        let tracer = self.tracer;
        let lights = &tracer.scene.lights;
        if lights.environment == [0.0; 3] {
            return DVec3::ZERO;
        }
        let [u, v, side, _] = self.random(Set::Environment {
            bounce: gather.bounce,
        });
        let scene = &tracer.scene;
        let down = scene.skeleton.worth_looking_down(&scene.sheet);
        let sides = [1.0_f64.copysign(vertex.position.z), f64::from(down)];
        let turn = tracer.turn_of(vertex);
        let FromSky {
            direction, weight, ..
        } = (tracer.optics).sample_sky(&lights.sky, vertex.lobe, view, sides, [u, v, side], turn);
        let towards = tracer.leave(vertex, direction, SURFACE_OFFSET_MM);
        let visibility = self.visibility(&towards, gather.composited);
        let by_bounces = gather.by_bounces(vertex, direction, visibility);
        environment_radiance(lights, towards.direction) * (by_bounces + visibility) * weight
    }

    fn visibility(&mut self, ray: &Ray, composited: bool) -> f64 {
        let tracer = self.tracer;
        if !tracer.settings.shadows {
            return 1.0;
        }
        if !composited {
            return tracer.tracked_visibility(ray, &mut self.pcg, self.scratch);
        }
        match tracer.settings.method {
            Method::Exact | Method::SixFace => tracer.marched_visibility(ray, self.scratch),
            _ => tracer.composited_visibility(ray, self.scratch),
        }
    }
}
