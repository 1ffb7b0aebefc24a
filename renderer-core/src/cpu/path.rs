//! Paths: from a camera ray to radiance (MODEL.md §8 and §9; the paper's §6, step 6).
//!
//! The method decides how the camera's ray and the shadow rays from its first point gather light; from there on paths are
//! tracked. Environment light comes by its own shadow ray at the first point of all methods but `tracked` and where a path is
//! closed, everywhere else by the onward ray if that leaves the cloth: never by both. A sky whose light tells where to look
//! ([`Sky::drawn`](crate::scene::Sky::drawn)) is reached by a shadow ray everywhere.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::form::Start;
use super::lanes::Lanes;
use super::{Scratch, Tracer};
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::{Light, Seen, Vertex, bounced, environment_radiance};
use crate::render::accumulation::{FirstHit, Sample};
use crate::sampling::{self, Pcg, Set};

/// The scattering from which on a path may end by Russian roulette: earlier ones carry most of the picture.
const ROULETTE_FROM: u32 = 3;

/// Distance from a surface at which rays leave it, mm: above the precision of its hits, far below any yarn.
const SURFACE_OFFSET_MM: f64 = 2e-6;

/// One path in the making.
pub(super) struct PathTracer<'a> {
    tracer: &'a Tracer,
    scratch: &'a mut Scratch,
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
    /// The environment's light comes by a shadow ray.
    sees_sky: bool,
    /// How many orders of bounced light are estimated here.
    orders: u32,
}

impl<'a> PathTracer<'a> {
    #[inline(always)]
    pub fn new(tracer: &'a Tracer, pixel: [u32; 2], number: u32, scratch: &'a mut Scratch) -> Self {
        let seed = sampling::pixel_seed(tracer.settings.seed, pixel);
        Self {
            tracer,
            scratch,
            seed,
            number,
            pcg: Pcg::new(seed, number),
        }
    }

    #[inline(always)]
    fn random(&self, set: Set) -> [f64; 4] {
        let sampler = self.tracer.settings.sampler;
        sampling::sample(sampler, self.seed, self.number, set).map(f64::from)
    }

    /// The radiance along the camera's ray through `pixel`, and what it met first: the sum over all scatterings of a path.
    #[inline(always)]
    pub fn sample<L: Lanes>(mut self, pixel: [u32; 2]) -> Sample {
        let tracer = self.tracer;
        let settings = &tracer.settings;
        let lights = &tracer.cloth.scene.lights;
        let path_cutoff = settings.path_cutoff();
        let has_environment = lights.environment != [0.0; 3];
        let is_drawn = lights.sky.drawn().is_some();
        let [x, y, pick, _] = self.random(Set::Film);
        let [column, row] = pixel.map(f64::from);
        let (origin, direction) = tracer
            .camera
            .ray(DVec2::new(column + x, row + y), tracer.size);
        let (mut ray, mut start) = (Ray { origin, direction }, Start::Eye);
        let mut first = None;
        let mut throughput = DVec3::ONE;
        let mut radiance = DVec3::ZERO;
        // What arrives along the current ray if it meets no cloth.
        let mut beyond = Some(DVec3::from_array(lights.background));
        for bounce in 1..=settings.bounces + 1 {
            // Points found by compositing see their lights by compositing.
            let composited = bounce == 1 && settings.method != Method::Tracked;
            let found = if composited {
                tracer.first_event::<L>(&ray, start, 1.0 - pick, self.scratch)
            } else {
                tracer.collision::<L>(&ray, start, &mut self.pcg, self.scratch)
            };
            let Some(vertex) = found else {
                radiance += throughput * beyond.unwrap_or_default();
                break;
            };
            if bounce == 1 {
                first = Some(FirstHit {
                    depth_mm: vertex.t * tracer.cloth.scene.sheet.cloth_scale(),
                    normal: vertex.world_from_sheet * vertex.normal,
                    albedo: vertex.albedo,
                });
            }
            if bounce > settings.bounces {
                // The last ray only looked for the environment.
                break;
            }
            let view = vertex.sheet_direction(-ray.direction);
            let closing = path_cutoff == Some(bounce);
            let gather = Gather {
                bounce,
                composited,
                sees_sky: has_environment && (composited || closing || is_drawn),
                orders: if closing {
                    settings.bounces - bounce
                } else {
                    0
                },
            };
            radiance += throughput * vertex.albedo * self.light::<L>(&vertex, view, gather);
            let follows_environment = has_environment && !composited && !is_drawn;
            if closing || bounce == settings.bounces && !follows_environment {
                break;
            }

            let [u, v, survival, _] = self.random(Set::Onward { bounce });
            let (direction, weight) = tracer.cloth.optics.sample(vertex.lobe, view, [u, v]);
            throughput *= vertex.albedo * weight;
            let onward = vertex.leave(direction, SURFACE_OFFSET_MM);
            beyond = follows_environment.then(|| environment_radiance(lights, onward.direction));
            if !settings.shadows {
                // Without shadows the environment's light needs no ray to find out whether it arrives.
                radiance += throughput * beyond.take().unwrap_or_default();
                if bounce == settings.bounces {
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
            (ray, start) = (onward, Start::Cloth);
        }
        Sample { radiance, first }
    }

    /// Light scattered towards `view`, but for the albedo: of lights, and of the environment if it is to be seen.
    #[inline(always)]
    fn light<L: Lanes>(&mut self, vertex: &Vertex, view: DVec3, gather: Gather) -> DVec3 {
        let tracer = self.tracer;
        let lights = &tracer.cloth.scene.lights;
        let Gather {
            bounce,
            composited,
            orders,
            ..
        } = gather;
        let sources = lights.count();
        let point = tracer.cloth.scene.lit_point(vertex.position);
        let mut sum = DVec3::ZERO;
        let cache = tracer.shadow_cache(self.number).map(|cache| {
            let random = [(); 3].map(|()| f64::from(self.pcg.next_float()));
            (cache, cache.key().grid.entry(vertex.position, random))
        });
        // One place for all shadow rays, since everything they do is inlined.
        for number in 0..sources + usize::from(gather.sees_sky) {
            let light = Light::of(lights, number, bounce);
            // The light's radiance times the phase over the direction's density, and its mean over all directions.
            let mut entry_of_light = number;
            let (direction, scattered, unhindered) = if let Some((light, set)) = light {
                let [u, v, ..] = self.random(set);
                let (world, irradiance) = light.towards(point, [u, v]);
                let direction = vertex.sheet_direction(world);
                let value = tracer.cloth.optics.value(vertex.lobe, view, direction);
                (
                    direction,
                    irradiance * value,
                    irradiance * (0.25 * FRAC_1_PI),
                )
            } else {
                let [u, v, side, _] = self.random(Set::Environment { bounce });
                let sides = [1.0_f64.copysign(vertex.position.z), tracer.cloth.looks_down];
                let drawn = (tracer.cloth.optics).sample_sky(
                    &lights.sky,
                    vertex.lobe,
                    view,
                    sides,
                    [u, v, side],
                    tracer.turn_of(vertex),
                );
                entry_of_light += usize::from(drawn.by_light);
                let light = environment_radiance(lights, drawn.in_world) * drawn.weight;
                (drawn.direction, light, light)
            };
            if scattered == DVec3::ZERO && orders == 0 {
                continue;
            }
            let up = (direction.z * vertex.position.z.signum()).max(0.0);
            let bounced = |visibility| unhindered * bounced(visibility, up, vertex.albedo, orders);
            if let Some((cache, entry)) = cache
                && let Some(seen) = cache.seen(entry + entry_of_light, || self.pcg.next_float())
            {
                self.scratch.counters.cached_rays += 1;
                sum += scattered * seen.direct;
                if orders > 0 {
                    sum += bounced(seen.for_bounces());
                }
                continue;
            }
            let ray = vertex.leave(direction, SURFACE_OFFSET_MM);
            let visibility = if !tracer.settings.shadows {
                1.0
            } else if composited {
                tracer.composited_visibility::<L>(&ray, Start::Cloth, self.scratch)
            } else {
                tracer.tracked_visibility::<L>(&ray, Start::Cloth, &mut self.pcg, self.scratch)
            };
            if let Some((cache, entry)) = cache {
                cache.add(entry + entry_of_light, Seen::by(visibility));
            }
            sum += scattered * visibility;
            if orders > 0 {
                sum += bounced(visibility);
            }
        }
        sum
    }
}
