//! Several points of a camera ray at which it may scatter, with their shares (MODEL.md §9): every tentative collision
//! takes σ/majorant of what is left of the ray, so that from one walk come many. Neighbours are made one until they
//! have a notable share.

use std::ops::ControlFlow;

use glam::Vec3A;

use super::event::{Overlap, PileEvent};
use super::lanes::{LANES, Lanes};
use super::patch::Patch;
use super::{Scratch, Tracer};
use crate::design::Phase;
use crate::geometry::Ray;
use crate::optics::{Lobe, Vertex};
use crate::sampling::Pcg;
use crate::transport::{Candidate, LoopPlace, MOST_CANDIDATES, Start};

/// Share of a ray from which on neighbouring collisions are an event of their own.
const NOTABLE: f32 = 0.3;
/// Share of a ray below which every second one ends and the other counts twice.
const ROULETTE_BELOW: f32 = 0.1;
/// Free paths in solid yarn, beyond which it does not matter what is in the way.
const REACH: f32 = 12.0;

impl Tracer {
    /// See [`crate::transport::Medium::candidates`].
    #[inline(always)]
    pub(super) fn candidates<L: Lanes>(
        &self,
        ray: &Ray,
        pcg: &mut Pcg,
        points: &mut Vec<Candidate>,
        scratch: &mut Scratch,
    ) -> f64 {
        scratch.counters.rays += 1;
        let mut left = 1.0_f32;
        for segment in self.segments(ray, Start::Eye) {
            let ray = &segment.ray;
            let part = self.part_in_cloth(ray, segment.part);
            scratch.places.clear();
            let room = MOST_CANDIDATES.saturating_sub(points.len() + 2);
            let mut group = PileEvent::default();
            let ground =
                self.track::<L>(ray, part, true, pcg, scratch, |tentative, pcg, scratch| {
                    scratch.counters.contributing_hits += 1;
                    let share = left * (tentative.sigma / tentative.majorant).min(1.0);
                    left -= share;
                    let sum = group.share + share;
                    // Each of the group by its share, and the loop by its part of σ.
                    let number = pcg.next_float() * sum;
                    if number < share {
                        let mut rest = number / share * tentative.sigma;
                        let mut found = None;
                        for overlap in &scratch.overlaps {
                            found = Some(overlap);
                            rest -= overlap.sigma;
                            if rest < 0.0 {
                                break;
                            }
                        }
                        if let Some(&Overlap { index, place, .. }) = found {
                            let t = tentative.t;
                            group = PileEvent {
                                t,
                                index,
                                place,
                                share,
                            };
                        }
                    }
                    group.share = sum;
                    if sum >= NOTABLE && scratch.places.len() < room {
                        scratch.places.push(group);
                        group = PileEvent::default();
                    }
                    if left < ROULETTE_BELOW {
                        if pcg.next_float() < 0.5 {
                            left = 0.0;
                            return ControlFlow::Break(());
                        }
                        left *= 2.0;
                    }
                    ControlFlow::Continue(())
                });
            if group.share > 0.0 {
                scratch.places.push(group);
            }
            for event in &scratch.places {
                let (vertex, place) = self.pile_candidate::<L>(ray, event);
                points.push(Candidate {
                    vertex: segment.place(vertex),
                    share: f64::from(event.share),
                    place: Some(place),
                });
            }
            if let Some(hit) = ground {
                points.push(Candidate {
                    vertex: segment.place(self.ground_vertex(ray, &hit)),
                    share: f64::from(left),
                    place: None,
                });
                return 0.0;
            }
            if left <= 0.0 {
                return 0.0;
            }
        }
        f64::from(left)
    }

    /// The point at which an event scatters, and its place in the loop.
    #[inline(always)]
    fn pile_candidate<L: Lanes>(&self, ray: &Ray, event: &PileEvent) -> (Vertex, LoopPlace) {
        let cloth = &self.cloth;
        let &PileEvent {
            t,
            index,
            place: inside,
            ..
        } = event;
        let patch = cloth.patch(index, [0.0; 2], Vec3A::ZERO);
        let normal = patch.normal();
        let gradients = gradients(&patch, normal, cloth.thickness, inside);
        let place = LoopPlace {
            index,
            inside,
            gradients,
        };
        let yarn = cloth.yarn(index);
        let shade = yarn.shade(inside);
        let look = cloth.scene.looks[index as usize];
        let material = usize::from(look.material);
        if cloth.optics.phase(material) == Phase::KajiyaKay {
            return (self.loop_vertex::<L>(ray, index, t, inside, shade), place);
        }
        let normal = normal.as_dvec3();
        let lobe = match cloth.optics.phase(material) {
            Phase::GradientLambert => {
                let slopes = yarn.slopes::<L>(inside);
                let [u, v, w] = gradients.map(Vec3A::as_dvec3);
                let gradient = u * slopes.x + v * slopes.y + w * slopes.z;
                Lobe::gradient(gradient, f64::from(cloth.thickness), material)
            }
            Phase::FrameLambert => Lobe::Frame { normal, material },
            _ => Lobe::Isotropic,
        };
        let vertex = self.pile_vertex(ray, index, t, normal, shade, lobe);
        (vertex, place)
    }

    /// See [`crate::transport::Medium::own_transmittance`]: eight looks along the straight line that the direction would
    /// be in a loop without twist, as far as it matters.
    #[inline(always)]
    pub(super) fn own_transmittance<L: Lanes>(&self, place: &LoopPlace, direction: Vec3A) -> f64 {
        // Pieces from k² to (k + 1)² of 64, and their middles.
        const MIDDLES: [f32; LANES] = middles();
        const WIDTHS: [f32; LANES] = widths();
        let [u, v, w] = place.inside;
        let [du, dv, dw] = [0, 1, 2].map(|axis: usize| place.gradients[axis].dot(direction));
        let exit = way_out(u, du, 0.0)
            .min(way_out(v, dv, 0.0))
            .min(way_out(w, dw, -0.5));
        let yarn = self.cloth.yarn(place.index);
        let length = exit.min(REACH / yarn.density);
        let along =
            |start: f32, slope: f32| L::splat(start) + L::splat(slope * length) * L::load(&MIDDLES);
        let rho = yarn.rhos([along(u, du), along(v, dv), along(w, dw)]);
        let mut parts = [0.0; LANES];
        (rho * L::load(&WIDTHS)).store(&mut parts);
        let depth = parts.iter().sum::<f32>() * length * yarn.density;
        f64::from((-depth).exp())
    }
}

const fn widths() -> [f32; LANES] {
    let mut widths = [0.0; LANES];
    let mut k = 0;
    while k < LANES {
        widths[k] = (2 * k + 1) as f32 / 64.0;
        k += 1;
    }
    widths
}

const fn middles() -> [f32; LANES] {
    let mut middles = [0.0; LANES];
    let mut k = 0;
    while k < LANES {
        middles[k] = (2 * k * k + 2 * k + 1) as f32 / 128.0;
        k += 1;
    }
    middles
}

/// How far it is from `at` to the end of a coordinate that begins at `low` and is 1 long, at `slope` of it a mm.
#[inline(always)]
fn way_out(at: f32, slope: f32, low: f32) -> f32 {
    let end = if slope > 0.0 { low + 1.0 } else { low };
    if slope.abs() < 1e-9 {
        return f32::INFINITY;
    }
    ((end - at) / slope).max(0.0)
}

/// How u, v and w change along x, y and z at a place in a loop.
#[inline(always)]
fn gradients(patch: &Patch, normal: Vec3A, thickness: f32, [u, v, _]: [f32; 3]) -> [Vec3A; 3] {
    let along_u = patch.along_u + patch.twist * (v - 0.5);
    let along_v = patch.along_v + patch.twist * (u - 0.5);
    let along_w = normal * thickness;
    let per_volume = 1.0 / along_u.cross(along_v).dot(along_w);
    [
        along_v.cross(along_w) * per_volume,
        along_w.cross(along_u) * per_volume,
        along_u.cross(along_v) * per_volume,
    ]
}
