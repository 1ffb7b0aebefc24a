//! Paths: from a camera ray to radiance (MODEL.md §8 and §9; the paper's §6, step 6).
//!
//! The method decides how the camera's ray and the shadow rays from its first point gather light; from there on paths
//! are tracked. Environment light comes by its own shadow ray at the first point of all methods but `tracked` and where
//! a path is cut off, everywhere else by the onward ray if that leaves the cloth: never by both. A sky whose light
//! tells where to look ([`Sky::importance_table`](crate::scene::Sky::importance_table)) is reached by a shadow ray
//! everywhere.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::medium::{Candidate, Medium, PathInputs, Start};
use super::resampling::{Resampling, openness, spread};
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::limits::{LATER_LIGHTS_SHARE, ROULETTE_FROM};
use crate::optics::{
    Exposure, Light, Vertex, Visibility, environment_radiance, multiple_scattering,
};
use crate::render::Optimisation;
use crate::render::accumulation::{FirstHit, Sample};
use crate::render::bounced_light::{self, BouncedLight};
use crate::render::shadow_cache::{ShadowCache, Unhindered};
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

/// The way that a path goes on.
struct Onward {
    /// From which of the points.
    point: usize,
    /// In the sheet.
    direction: DVec3,
    /// ψ/albedo over its density, times the point's share over the probability that it was chosen.
    weight: f64,
}

/// Weight of a candidate to which no light seems to come, relative to one that nothing hides: no candidate counts for
/// more than so many times the mean.
const UNLIKELY: f64 = 0.04;

/// The light of one light, from one of a ray's points.
#[derive(Debug, Clone, Copy)]
struct ChosenLight {
    /// Which.
    point: usize,
    sample: LightSample,
    /// The point's share over the probability that it was chosen.
    weight: f64,
    /// Its place in the shadow cache, which is to learn of it.
    entry: Option<usize>,
}

/// Light from one direction, of which a shadow ray is to find out whether it arrives.
#[derive(Debug, Clone, Copy)]
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

impl LightSample {
    /// How much light it brings to a point if all arrives.
    #[inline(always)]
    fn unhindered_at(&self, vertex: &Vertex) -> Unhindered {
        Unhindered {
            direct: self.scattered.max_element(),
            diffuse: self.unhindered.max_element() * self.up_from(vertex),
        }
    }

    /// Its cosine with the sheet's normal on a point's side, if above 0.
    #[inline(always)]
    fn up_from(&self, vertex: &Vertex) -> f64 {
        (self.direction.z * vertex.position.z.signum()).max(0.0)
    }
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
        let learns = self.learns_bounces(pixel);
        let mut learning: Option<Learning> = None;
        let mut throughput = DVec3::ONE;
        let mut radiance = DVec3::ZERO;
        let mut points = medium.room(self.scratch);
        // What arrives along the current ray if it meets no cloth.
        let mut beyond = Some(DVec3::from_array(lights.background));
        for bounce in 1..=settings.bounces + 1 {
            // Points found by compositing see their lights by compositing.
            let composited = bounce == 1 && settings.method != Method::Tracked;
            points.clear();
            let weighs = bounce == 1 && !learns && medium.weighs_candidates();
            let left = if weighs {
                medium.candidates(&ray, &mut self.pcg, &mut points, self.scratch)
            } else {
                let found = if composited {
                    medium.first_event(&ray, 1.0 - pick, choice, self.scratch)
                } else {
                    medium.collision(&ray, start, &mut self.pcg, self.scratch)
                };
                points.extend(found.map(|vertex| Candidate {
                    vertex,
                    share: 1.0,
                    place: None,
                }));
                if points.is_empty() { 1.0 } else { 0.0 }
            };
            if left > 0.0 {
                radiance += throughput * beyond.unwrap_or_default() * left;
            }
            if points.is_empty() {
                break;
            }
            if bounce == 1 {
                first = Some(first_hit(&points, left, scene.sheet.cloth_scale()));
            }
            if bounce > settings.bounces {
                // The last ray only looked for the environment.
                break;
            }
            let is_cut_off = path_cutoff == Some(bounce);
            // The last ray would only look for the environment.
            let looks_last = bounce == settings.bounces && medium.tracks_last_looks();
            let gather = Gather {
                bounce,
                composited,
                sees_sky: has_environment && (composited || is_cut_off || is_sampled || looks_last),
                orders: if is_cut_off {
                    settings.bounces - bounce
                } else {
                    0
                },
            };
            let lit = self.light(&points, -ray.direction, gather);
            radiance += throughput * (lit.light + lit.further);
            if is_cut_off {
                // Some paths go on nevertheless, to see how good the estimate is.
                learning = learns
                    .then(|| self.learning(&points, &lit, radiance))
                    .flatten();
                if learning.is_none() {
                    break;
                }
                radiance = DVec3::ZERO;
            }
            let follows_environment = has_environment && !gather.sees_sky;
            if bounce == settings.bounces && !follows_environment {
                break;
            }

            let [u, v, survival, choice] = self.random(Set::Onward { bounce });
            let Some(Onward {
                point,
                direction,
                weight,
            }) = self.onward(&points, -ray.direction, [u, v], choice)
            else {
                break;
            };
            let vertex = &points[point].vertex;
            throughput *= vertex.albedo * weight;
            let onward = medium.leave(vertex, direction);
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
        medium.keep_room(points, self.scratch);
        if let (Some(learning), Some(bounced)) = (learning, medium.bounced_light()) {
            bounced.add(learning.entry, radiance, learning.estimate);
            radiance = learning.seen;
        }
        Sample { radiance, first }
    }

    /// Whether the path goes on where it is cut off, so that [`BouncedLight`] learns from it: that of some blocks of
    /// pixels, since pixels of a block take their time together on a GPU.
    ///
    /// [`BouncedLight`]: crate::render::bounced_light::BouncedLight
    #[inline(always)]
    fn learns_bounces(&self, pixel: [u32; 2]) -> bool {
        let settings = self.inputs.settings;
        self.medium.bounced_light().is_some()
            && settings.caches_shadows(self.number)
            && bounced_light::learns(settings.seed, pixel, self.number)
    }

    /// What the light that a path goes on to find is to be held against; `None` where enough is known.
    #[inline(always)]
    fn learning(&mut self, points: &[Candidate], lit: &Lit, seen: DVec3) -> Option<Learning> {
        let bounced = self.medium.bounced_light()?;
        let [only] = points else { return None };
        let random = [(); 3].map(|()| f64::from(self.pcg.next_float()));
        let entry = bounced.entry(only.vertex.position, random);
        bounced.is_learning(entry).then_some(Learning {
            entry,
            estimate: lit.estimate,
            seen,
        })
    }

    /// Where a path goes on: from one of its ray's points, by how much of what comes there goes towards `view` (world),
    /// in a direction that its phase draws with two numbers.
    #[inline(always)]
    fn onward(
        &self,
        points: &[Candidate],
        view: DVec3,
        numbers: [f64; 2],
        choice: f64,
    ) -> Option<Onward> {
        let (point, counts) = if points.len() == 1 {
            (0, 1.0)
        } else {
            let mut choice = Resampling::new(choice);
            for (index, Candidate { vertex, share, .. }) in points.iter().enumerate() {
                choice.add(index, share * vertex.albedo.element_sum());
            }
            choice.finish()?
        };
        let Candidate { vertex, share, .. } = &points[point];
        let view = vertex.sheet_direction(view);
        let (direction, weight) = self.inputs.optics.sample(vertex.lobe, view, numbers);
        Some(Onward {
            point,
            direction,
            weight: weight * counts * share,
        })
    }

    /// Light scattered towards `view` (world): of suns and area lights, and of the environment if it is to be seen. Of
    /// each by one of the points that a ray has, and by all at which a cache knows its shadow.
    #[inline(always)]
    fn light(&mut self, points: &[Candidate], view: DVec3, gather: Gather) -> Lit {
        let medium = self.medium;
        let mut lit = Lit::default();
        // Where later scatterings lie, less light comes than to what the camera sees beside them.
        let shadows = medium
            .shadow_cache(self.number)
            .filter(|_| gather.bounce == 1);
        let bounced = medium.bounced_light().filter(|_| gather.orders > 0);
        let known = (shadows.is_some() || bounced.is_some()).then(|| Known {
            shadows,
            bounced,
            random: [(); 3].map(|()| f64::from(self.pcg.next_float())),
        });
        // One place for all shadow rays, since on the processor everything they do is inlined.
        for number in 0..self.inputs.scene.lights.count() + usize::from(gather.sees_sky) {
            let Some(drawn) = self.draw_light(number, gather) else {
                continue;
            };
            let chosen = match &known {
                Some(known) if known.shadows.is_some() => {
                    self.add_known(points, view, gather.orders, &drawn, known, &mut lit)
                }
                _ => self.chosen_light(points, view, gather.orders, &drawn),
            };
            let Some(chosen) = chosen else {
                continue;
            };
            let (candidate, sample) = (&points[chosen.point], &chosen.sample);
            if self.is_dark(sample) && gather.orders == 0 {
                continue;
            }
            let ray = medium.leave(&candidate.vertex, sample.direction);
            let visibility = if !self.inputs.settings.shadows {
                1.0
            } else if gather.composited {
                medium.composited_visibility(&ray, self.scratch)
            } else {
                medium.tracked_visibility(&ray, &mut self.pcg, self.scratch)
            };
            let visibility = Visibility::by(visibility);
            if let (Some(entry), Some(shadows)) = (chosen.entry, shadows) {
                let light = sample.unhindered_at(&candidate.vertex);
                shadows.add(entry, light, visibility);
            }
            let arrives = Arrives {
                sample,
                visibility,
                weight: chosen.weight,
                orders: gather.orders,
            };
            lit.add(&candidate.vertex, &arrives, known.as_ref());
        }
        lit
    }

    /// Whether light is not followed, since it would not be scattered.
    #[inline(always)]
    fn is_dark(&self, sample: &LightSample) -> bool {
        if M::SKIPS_DARK_LIGHTS {
            sample.scattered == DVec3::ZERO
        } else {
            sample.phase <= 0.0
        }
    }

    /// Where the light of light `number` comes from; `None` if it is not looked for.
    #[inline(always)]
    fn draw_light(&self, number: usize, gather: Gather) -> Option<DrawnLight<'a>> {
        let PathInputs {
            scene, settings, ..
        } = self.inputs;
        let bounce = gather.bounce;
        let light = Light::of(&scene.lights, number, bounce);
        let set = light.map_or(Set::Environment { bounce }, |(_, set)| set);
        let [u, v, side, choice] = self.random(set);
        // Only a path's first scattering chooses among points.
        let is_later = bounce > 1
            && gather.orders == 0
            && settings.optimisations.has(Optimisation::LaterLights);
        if is_later && choice >= LATER_LIGHTS_SHARE {
            return None;
        }
        let source = match light {
            // A sun is where it is for all points.
            Some((sun @ Light::Sun(_), _)) => Source::Far(sun.towards(DVec3::ZERO, [u, v])),
            Some((area, _)) => Source::Near(area, [u, v]),
            None => Source::Sky([u, v], side),
        };
        Some(DrawnLight {
            number,
            source,
            choice,
            counts: if is_later {
                1.0 / LATER_LIGHTS_SHARE
            } else {
                1.0
            },
        })
    }

    /// Adds the light of one light from all points at which its shadow is known. Of the others one is to find it out,
    /// chosen by its share alone: a cache that learned from points that light had chosen would take them for bright.
    #[inline(always)]
    fn add_known(
        &mut self,
        points: &[Candidate],
        view: DVec3,
        orders: u32,
        drawn: &DrawnLight<'_>,
        known: &Known<'_>,
        lit: &mut Lit,
    ) -> Option<ChosenLight> {
        let shadows = known.shadows?;
        let mut unknown = Resampling::new(drawn.choice);
        for (point, Candidate { vertex, share, .. }) in points.iter().enumerate() {
            let source = drawn.source.for_candidate(point);
            let sample = self.light_sample(vertex, view, source, drawn.number);
            if orders == 0 && self.is_dark(&sample) {
                continue;
            }
            let texel = shadows.entry(vertex.position, known.random);
            let entry = texel.map(|texel| texel + sample.cache_entry);
            let weight = share * drawn.counts;
            let visibility =
                entry.and_then(|entry| shadows.visibility(entry, || self.pcg.next_float()));
            let Some(visibility) = visibility else {
                let chosen = ChosenLight {
                    point,
                    sample,
                    weight,
                    entry,
                };
                unknown.add(chosen, *share);
                continue;
            };
            self.scratch.as_mut().cached_rays += 1;
            let arrives = Arrives {
                sample: &sample,
                visibility,
                weight,
                orders,
            };
            lit.add(vertex, &arrives, Some(known));
        }
        unknown.finish().map(|(chosen, counts)| ChosenLight {
            weight: chosen.weight * counts,
            ..chosen
        })
    }

    /// Light of one light from one of a ray's points, by how much of it is likely to come there and go towards `view`
    /// (world).
    #[inline(always)]
    fn chosen_light(
        &self,
        points: &[Candidate],
        view: DVec3,
        orders: u32,
        drawn: &DrawnLight<'_>,
    ) -> Option<ChosenLight> {
        if let [only] = points {
            return Some(ChosenLight {
                point: 0,
                sample: self.light_sample(&only.vertex, view, drawn.source, drawn.number),
                weight: only.share * drawn.counts,
                entry: None,
            });
        }
        let mut choice = Resampling::new(drawn.choice);
        for (point, candidate) in points.iter().enumerate() {
            let source = drawn.source.for_candidate(point);
            let sample = self.light_sample(&candidate.vertex, view, source, drawn.number);
            let likely = self.likely_light(candidate, &sample, &source, orders);
            let chosen = ChosenLight {
                point,
                sample,
                weight: candidate.share,
                entry: None,
            };
            choice.add(chosen, candidate.share * likely);
        }
        let (chosen, counts) = choice.finish()?;
        Some(ChosenLight {
            weight: chosen.weight * counts,
            ..chosen
        })
    }

    /// About how much light a candidate scatters, but for what other loops are in its way.
    #[inline(always)]
    fn likely_light(
        &self,
        candidate: &Candidate,
        sample: &LightSample,
        source: &Source<'_>,
        orders: u32,
    ) -> f64 {
        let vertex = &candidate.vertex;
        let mut light = sample.scattered;
        if orders > 0 {
            light += sample.unhindered;
        }
        let light = (light * vertex.albedo).element_sum();
        if light <= 0.0 {
            return 0.0;
        }
        let mut arrives = self.medium.own_transmittance(candidate, sample.direction);
        if let Source::Sky(..) = source {
            arrives *= openness(sample.direction.z * vertex.position.z.signum());
        }
        light * (arrives + UNLIKELY)
    }

    /// Light from a random direction to a light, number `number` of all, that is scattered towards `view` (world).
    // Inlined at each of its calls, it would be most of the time that this file takes to compile.
    #[inline(never)]
    fn light_sample(
        &self,
        vertex: &Vertex,
        view: DVec3,
        source: Source<'_>,
        number: usize,
    ) -> LightSample {
        let PathInputs {
            scene,
            optics,
            looks_down,
            ..
        } = self.inputs;
        let lights = &scene.lights;
        let view = vertex.sheet_direction(view);
        let (found, [u, v], side) = match source {
            Source::Far(found) => (Some(found), [0.0; 2], 0.0),
            Source::Near(light, numbers) => {
                let point = scene.lit_point(vertex.position);
                (Some(light.towards(point, numbers)), numbers, 0.0)
            }
            Source::Sky(numbers, side) => (None, numbers, side),
        };
        if let Some((world, irradiance)) = found {
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

/// Light from one light, as it is drawn.
#[derive(Debug, Clone, Copy)]
struct DrawnLight<'a> {
    /// Which of the lights.
    number: usize,
    source: Source<'a>,
    /// A number in [0, 1) that chooses one of a ray's points.
    choice: f64,
    /// One over the probability that it is looked for.
    counts: f64,
}

/// What earlier samples have learned of the surroundings of a ray's points.
#[derive(Debug, Clone, Copy)]
struct Known<'a> {
    shadows: Option<&'a ShadowCache>,
    bounced: Option<&'a BouncedLight>,
    /// Numbers in [0, 1) that move the points by up to half a texel.
    random: [f64; 3],
}

/// Light that comes to a point.
#[derive(Debug, Clone, Copy)]
struct Arrives<'a> {
    sample: &'a LightSample,
    /// How much of it gets there.
    visibility: Visibility,
    /// What the point's light counts.
    weight: f64,
    /// How many orders of multiple scattering are estimated from it.
    orders: u32,
}

/// Light that a ray's points scatter towards the eye.
#[derive(Debug, Clone, Copy, Default)]
struct Lit {
    /// After this scattering.
    light: DVec3,
    /// After further ones: their estimate, as corrected by what is known.
    further: DVec3,
    /// After further scatterings, as estimated before any correction.
    estimate: DVec3,
}

impl Lit {
    #[inline(always)]
    fn add(&mut self, vertex: &Vertex, arrives: &Arrives<'_>, known: Option<&Known<'_>>) {
        let Arrives {
            sample,
            visibility,
            weight,
            orders,
        } = *arrives;
        let albedo = vertex.albedo * weight;
        self.light += albedo * sample.scattered * visibility.direct;
        if orders == 0 {
            return;
        }
        let up = sample.up_from(vertex);
        let reach = visibility.for_multiple_scattering();
        let estimate =
            albedo * sample.unhindered * multiple_scattering(reach, up, vertex.albedo, orders);
        self.estimate += estimate;
        self.further += match known.and_then(|known| known.bounced.zip(Some(known.random))) {
            Some((bounced, random)) => {
                estimate * bounced.correction(bounced.entry(vertex.position, random))
            }
            None => estimate,
        };
    }
}

/// A path that goes on where it is cut off.
#[derive(Debug, Clone, Copy)]
struct Learning {
    /// Of the point at which it is cut off.
    entry: usize,
    /// What is estimated there.
    estimate: DVec3,
    /// The sample's radiance.
    seen: DVec3,
}

/// Where the light of one light comes from, for the points of one ray.
#[derive(Debug, Clone, Copy)]
enum Source<'a> {
    /// From the same direction (world) for all, with the same irradiance.
    Far((DVec3, DVec3)),
    /// From a place on it that two numbers draw.
    Near(Light<'a>, [f64; 2]),
    /// From the environment, in a direction that three numbers draw.
    Sky([f64; 2], f64),
}

impl Source<'_> {
    /// The source for candidate `index`: each looks into another part of the sky.
    #[inline(always)]
    fn for_candidate(self, index: usize) -> Self {
        match self {
            Self::Sky(numbers, side) if index > 0 => Self::Sky(spread(numbers, index), side),
            _ => self,
        }
    }
}

/// What a camera ray met first: the mean over its points. The share `left` of it met nothing.
fn first_hit(points: &[Candidate], left: f64, cloth_scale: f64) -> FirstHit {
    let mut first = FirstHit {
        share: 1.0 - left,
        depth_mm: 0.0,
        normal: DVec3::ZERO,
        albedo: DVec3::ZERO,
    };
    let shares: f64 = points.iter().map(|point| point.share).sum();
    for Candidate { vertex, share, .. } in points {
        let weight = share / shares;
        first.depth_mm += weight * vertex.t * cloth_scale;
        first.normal += weight * (vertex.world_from_sheet * vertex.normal);
        first.albedo += weight * vertex.albedo;
    }
    first
}
