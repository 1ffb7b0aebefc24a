//! Paths: from a camera ray to radiance (MODEL.md §8 and §9; the paper's §6, step 6).
//!
//! The method decides how the camera's ray and the shadow rays from its first point gather light; from there on paths
//! are tracked. Environment light comes by its own shadow ray at the first point of all methods but `tracked` and where
//! a path is cut off, everywhere else by the onward ray if that leaves the cloth: never by both. A sky whose light
//! tells where to look ([`Sky::importance_table`](crate::scene::Sky::importance_table)) is reached by a shadow ray
//! everywhere.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::medium::{Medium, PathInputs, Start};
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::limits::ROULETTE_FROM;
use crate::optics::{
    Exposure, Light, Vertex, Visibility, environment_radiance, multiple_scattering,
};
use crate::render::accumulation::{FirstHit, Sample};
use crate::sampling::{self, Pcg, Set};

/// One path in the making.
#[derive(Debug)]
pub struct PathTracer<'a, M: Medium> {
    medium: &'a M,
    inputs: PathInputs<'a>,
    scratch: &'a mut M::Scratch,
    seed: u32,
    number: u32,
    /// Numbers for free paths.
    pcg: Pcg,
}

/// Where on a path light is gathered.
#[derive(Debug, Clone, Copy)]
struct Gather {
    /// Which scattering, from 1.
    bounce: u32,
    /// Its shadow rays are composited, not tracked.
    composited: bool,
    /// The environment's light comes by a shadow ray.
    sees_sky: bool,
    /// How many orders of multiple scattering are estimated here.
    orders: u32,
}

/// Light from one direction, of which a shadow ray is to find out whether it arrives.
struct LightSample {
    /// To the light, in the sheet.
    direction: DVec3,
    /// ψ/albedo; 1 for the environment, whose directions are drawn by it.
    phase: f64,
    /// What is scattered towards the eye if all arrives, but for the albedo.
    scattered: DVec3,
    /// Mean over all directions of what arrives if nothing is in the way.
    unhindered: DVec3,
    /// Which of the lights it is in the shadow cache.
    cache_entry: usize,
}

impl<'a, M: Medium> PathTracer<'a, M> {
    /// The path of sample `number` of `pixel` of the whole picture.
    #[inline(always)]
    pub fn new(medium: &'a M, pixel: [u32; 2], number: u32, scratch: &'a mut M::Scratch) -> Self {
        let inputs = medium.inputs();
        let seed = sampling::pixel_seed(inputs.settings.seed, pixel);
        Self {
            medium,
            inputs,
            scratch,
            seed,
            number,
            pcg: Pcg::new(seed, number),
        }
    }

    #[inline(always)]
    fn random(&self, set: Set) -> [f64; 4] {
        let sampler = self.inputs.settings.sampler;
        sampling::sample(sampler, self.seed, self.number, set).map(f64::from)
    }

    /// The radiance along the camera's ray through `pixel`, and what it met first: the sum over all scatterings of a
    /// path.
    #[inline(always)]
    pub fn sample(mut self, pixel: [u32; 2]) -> Sample {
        let PathInputs {
            scene,
            optics,
            camera,
            size,
            settings,
            ..
        } = self.inputs;
        let medium = self.medium;
        let lights = &scene.lights;
        let path_cutoff = settings.path_cutoff();
        let has_environment = lights.environment != [0.0; 3];
        let is_sampled = lights.sky.importance_table().is_some();
        let [x, y, pick, choice] = self.random(Set::Film);
        let [column, row] = pixel.map(f64::from);
        let (origin, direction) = camera.ray(DVec2::new(column + x, row + y), size);
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
                medium.first_event(&ray, 1.0 - pick, choice, self.scratch)
            } else {
                medium.collision(&ray, start, &mut self.pcg, self.scratch)
            };
            let Some(vertex) = found else {
                radiance += throughput * beyond.unwrap_or_default();
                break;
            };
            if bounce == 1 {
                first = Some(FirstHit {
                    depth_mm: vertex.t * scene.sheet.cloth_scale(),
                    normal: vertex.world_from_sheet * vertex.normal,
                    albedo: vertex.albedo,
                });
            }
            if bounce > settings.bounces {
                // The last ray only looked for the environment.
                break;
            }
            let view = vertex.sheet_direction(-ray.direction);
            let is_cut_off = path_cutoff == Some(bounce);
            let gather = Gather {
                bounce,
                composited,
                sees_sky: has_environment && (composited || is_cut_off || is_sampled),
                orders: if is_cut_off {
                    settings.bounces - bounce
                } else {
                    0
                },
            };
            radiance += throughput * vertex.albedo * self.light(&vertex, view, gather);
            let follows_environment = has_environment && !composited && !is_sampled;
            if is_cut_off || bounce == settings.bounces && !follows_environment {
                break;
            }

            let [u, v, survival, _] = self.random(Set::Onward { bounce });
            let (direction, weight) = optics.sample(vertex.lobe, view, [u, v]);
            throughput *= vertex.albedo * weight;
            let onward = medium.leave(&vertex, direction);
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

    /// Light scattered towards `view`, but for the albedo: of suns and area lights, and of the environment if it is to
    /// be seen.
    #[inline(always)]
    fn light(&mut self, vertex: &Vertex, view: DVec3, gather: Gather) -> DVec3 {
        let medium = self.medium;
        let orders = gather.orders;
        let point = self.inputs.scene.lit_point(vertex.position);
        let mut sum = DVec3::ZERO;
        let cache = medium.shadow_cache(self.number).map(|cache| {
            let random = [(); 3].map(|()| f64::from(self.pcg.next_float()));
            (cache, cache.key().grid.entry(vertex.position, random))
        });
        // One place for all shadow rays, since on the processor everything they do is inlined.
        for number in 0..self.inputs.scene.lights.count() + usize::from(gather.sees_sky) {
            let sample = self.light_sample(vertex, view, point, gather.bounce, number);
            let is_dark = if M::SKIPS_DARK_LIGHTS {
                sample.scattered == DVec3::ZERO
            } else {
                sample.phase <= 0.0
            };
            if is_dark && orders == 0 {
                continue;
            }
            let up = (sample.direction.z * vertex.position.z.signum()).max(0.0);
            let by_scatterings = |visibility| {
                sample.unhindered * multiple_scattering(visibility, up, vertex.albedo, orders)
            };
            let cached = cache.map(|(cache, entry)| (cache, entry + sample.cache_entry));
            if let Some((cache, entry)) = cached
                && let Some(known) = cache.visibility(entry, || self.pcg.next_float())
            {
                self.scratch.as_mut().cached_rays += 1;
                sum += sample.scattered * known.direct;
                if orders > 0 {
                    sum += by_scatterings(known.for_multiple_scattering());
                }
                continue;
            }
            let ray = medium.leave(vertex, sample.direction);
            let visibility = if !self.inputs.settings.shadows {
                1.0
            } else if gather.composited {
                medium.composited_visibility(&ray, self.scratch)
            } else {
                medium.tracked_visibility(&ray, &mut self.pcg, self.scratch)
            };
            if let Some((cache, entry)) = cached {
                cache.add(entry, Visibility::by(visibility));
            }
            sum += sample.scattered * visibility;
            if orders > 0 {
                sum += by_scatterings(visibility);
            }
        }
        sum
    }

    /// Light from a random direction to light `number`: suns and area lights first, then the environment. `point` is
    /// where the vertex lies in the world.
    #[inline(always)]
    fn light_sample(
        &self,
        vertex: &Vertex,
        view: DVec3,
        point: DVec3,
        bounce: u32,
        number: usize,
    ) -> LightSample {
        let PathInputs {
            scene,
            optics,
            looks_down,
            ..
        } = self.inputs;
        let lights = &scene.lights;
        if let Some((light, set)) = Light::of(lights, number, bounce) {
            let [u, v, ..] = self.random(set);
            let (world, irradiance) = light.towards(point, [u, v]);
            let direction = vertex.sheet_direction(world);
            let phase = optics.value(vertex.lobe, view, direction);
            return LightSample {
                direction,
                phase,
                scattered: irradiance * phase,
                unhindered: irradiance * (0.25 * FRAC_1_PI),
                cache_entry: number,
            };
        }
        let [u, v, side, _] = self.random(Set::Environment { bounce });
        let exposure = Exposure {
            up: 1.0_f64.copysign(vertex.position.z),
            down: looks_down,
            world_from_sheet: scene.form.is_some().then_some(vertex.world_from_sheet),
        };
        let drawn = optics.sample_sky(&lights.sky, vertex.lobe, view, exposure, [u, v], side);
        let light = environment_radiance(lights, drawn.in_world) * drawn.weight;
        LightSample {
            direction: drawn.direction,
            phase: 1.0,
            scattered: light,
            unhindered: light,
            cache_entry: number + usize::from(drawn.by_light),
        }
    }
}
