//! `tracked`: random free paths through the summed densities of all loops (Woodcock's delta tracking), and their
//! expected transmittance for shadow rays (ratio tracking). Unbiased, without a step, overlaps exact (MODEL.md §9).
//!
//! Where loops overlap, σ = Σ density_k·ρ_k · min(1, 1.5/Σρ_k) (MODEL.md §5). Where a ray may meet one loop in a block
//! σ is at most the densest material's, else 1.5 times that: the majorant. A free path is one optical depth −ln(1 − u)
//! spent block by block at the majorant's rate; where it is spent, the ray collides with probability σ/majorant,
//! otherwise it draws the next one. Before the first loop that a ray may meet in a block and behind the last nothing is
//! spent.

use std::ops::ControlFlow;

use glam::DVec3;

use super::form::RaySegment;
use super::scratch::Scratch;
use super::skeleton::SkeletonHit;
use super::tracer::Tracer;
use super::walk::{BlockLoops, LoopPart, LoopPlace};
use crate::geometry::{Interval, Ray};
use crate::optics::Vertex;
use crate::optics::limits::MOST_OVERLAP;
use crate::render::Counters;
use crate::sampling::Pcg;

/// Transmittance of a shadow ray below which every second one ends and the other counts twice.
const ROULETTE_BELOW: f64 = 1.0 / 16.0;

/// One loop at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    pub place: LoopPlace,
    /// u, v and w of the point.
    pub inside: [f64; 3],
    /// ρ, before crowding.
    pub rho: f64,
    /// Extinction by this loop, 1/mm.
    sigma: f64,
    /// Factor on the albedo.
    pub shade: f64,
}

/// Where yarns overlap too much they displace each other: holds the sum of their ρ to [`MOST_OVERLAP`]. The sum of σ.
pub(super) fn crowded(overlaps: &mut [Overlap], sum_rho: f64) -> f64 {
    let crowding = if sum_rho > MOST_OVERLAP {
        MOST_OVERLAP / sum_rho
    } else {
        1.0
    };
    let mut sigma = 0.0;
    for overlap in overlaps {
        overlap.sigma *= crowding;
        sigma += overlap.sigma;
    }
    sigma
}

/// The loop in which a number from 0 to the sum of σ falls.
pub(super) fn chosen(overlaps: &[Overlap], number: f64) -> Option<&Overlap> {
    let mut rest = number;
    let passed = |overlap: &&Overlap| {
        rest -= overlap.sigma;
        rest < 0.0
    };
    // Rounding may leave a rest behind the last.
    overlaps.iter().find(passed).or(overlaps.last())
}

/// A place where a ray may collide.
struct Tentative {
    t: f64,
    /// The block's majorant, 1/mm.
    majorant: f64,
    /// σ there, 1/mm.
    sigma: f64,
}

impl Tracer {
    /// σ at a point, and the loops that make it, each with its share of σ; `places` holds all loops that may be there.
    fn overlaps_at(
        &self,
        point: DVec3,
        places: impl Iterator<Item = LoopPlace>,
        scratch: &mut Scratch,
    ) -> f64 {
        let Scratch {
            counters, overlaps, ..
        } = scratch;
        overlaps.clear();
        let mut sum_rho = 0.0;
        for place in places {
            counters.patch_tests += 1;
            let frame = self.frame(place);
            let Some(inside) = frame.invert(point - self.cell_origin(place.cell)) else {
                continue;
            };
            if let Some(overlap) = self.overlap(place, inside, counters) {
                sum_rho += overlap.rho;
                overlaps.push(overlap);
            }
        }
        crowded(overlaps, sum_rho)
    }

    /// What a loop holds at (u, v, w), if it is not empty there.
    pub(super) fn overlap(
        &self,
        place: LoopPlace,
        inside: [f64; 3],
        counters: &mut Counters,
    ) -> Option<Overlap> {
        counters.volume_samples += 1;
        let volume = self.volume(place);
        let found = volume.at(inside);
        (found.rho > 0.0).then_some(Overlap {
            place,
            inside,
            rho: found.rho,
            sigma: volume.density_per_mm * found.rho,
            shade: found.shade,
        })
    }

    /// σ at a point of the world, 1/mm.
    pub fn extinction(&self, point: DVec3, scratch: &mut Scratch) -> f64 {
        let block = self.grid.block_at(point.x, point.y);
        // A ray that goes nowhere.
        let ray = Ray {
            origin: point,
            direction: DVec3::Z,
        };
        let here = Interval::new(0.0, 0.0);
        let pieces = self.grid.pieces(&ray, here, block, LoopPart::Volume);
        let places = self.loops_in(block).along(pieces);
        self.overlaps_at(point, places, scratch)
    }

    /// The loops that a ray may meet in its part `part` of a block, each with where.
    fn loops_along(
        &self,
        ray: &Ray,
        part: Interval,
        block: [i64; 2],
        loops: &BlockLoops<'_>,
        counters: &mut Counters,
        found: &mut Vec<(LoopPlace, Interval)>,
    ) {
        found.clear();
        let pieces = self.grid.pieces(ray, part, block, LoopPart::Volume);
        for place in loops.along(pieces) {
            counters.patch_tests += 1;
            let local = ray.relative_to(self.cell_origin(place.cell));
            let span = self.frame(place).clip(&local, part);
            if !span.is_empty() {
                found.push((place, span));
            }
        }
    }

    /// Calls `collide` at the tentative collisions of a ray, in order, until it breaks or the ray meets the skeleton or
    /// leaves the cloth; the skeleton's hit if it got there.
    fn track(
        &self,
        ray: &Ray,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
        mut collide: impl FnMut(&RaySegment, &Tentative, &mut Pcg, &mut Scratch) -> ControlFlow<()>,
    ) -> Option<(RaySegment, SkeletonHit)> {
        let mut depth_left = free_depth(pcg);
        for (segment, span) in self.spans(ray) {
            let ray = &segment.ray;
            scratch.counters.cells += 1;
            let skeleton = self.skeleton_hit(ray, &span);
            let end = skeleton.map_or(span.leave, |hit| hit.t);
            let loops = self.loops_in(span.index);
            let part = Interval::new(span.enter, end).clip_linear(
                ray.origin.z,
                ray.direction.z,
                loops.heights(),
            );
            let mut along = std::mem::take(&mut scratch.along);
            if part.is_empty() {
                along.clear();
            } else {
                self.loops_along(
                    ray,
                    part,
                    span.index,
                    &loops,
                    &mut scratch.counters,
                    &mut along,
                );
            }
            let majorant = match along.len() {
                0 => 0.0,
                1 => self.densest_per_mm,
                _ => MOST_OVERLAP * self.densest_per_mm,
            };
            // Nothing is met before the first loop, nor behind the last.
            let spans = || along.iter().map(|(_, span)| span);
            let mut t = spans().fold(f64::INFINITY, |t, span| t.min(span.low));
            let end = spans().fold(f64::NEG_INFINITY, |t, span| t.max(span.high));
            let mut broke = false;
            while t < end {
                let collision = t + depth_left / majorant;
                if collision >= end {
                    depth_left -= (end - t) * majorant;
                    break;
                }
                t = collision;
                let holding = along.iter().filter(|(_, span)| span.holds(t));
                let places = holding.map(|&(place, _)| place);
                let sigma = self.overlaps_at(ray.at(t), places, scratch);
                if sigma > 0.0 {
                    let tentative = Tentative { t, majorant, sigma };
                    broke = collide(&segment, &tentative, pcg, scratch).is_break();
                    if broke {
                        break;
                    }
                }
                depth_left = free_depth(pcg);
            }
            scratch.along = along;
            if broke {
                return None;
            }
            if let Some(hit) = skeleton {
                return Some((segment, hit));
            }
        }
        None
    }

    /// Where a ray collides, by delta tracking; `None` if it leaves the cloth.
    pub fn collision(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Scratch) -> Option<Vertex> {
        scratch.counters.rays += 1;
        let mut vertex = None;
        let skeleton = self.track(ray, pcg, scratch, |segment, tentative, pcg, scratch| {
            // One number decides both whether it collides and with which loop: with each in proportion to its part of
            // σ.
            let number = f64::from(pcg.next_float()) * tentative.majorant;
            if number >= tentative.sigma {
                return ControlFlow::Continue(());
            }
            scratch.counters.contributing_hits += 1;
            vertex = chosen(&scratch.overlaps, number).map(
                |&Overlap {
                     place,
                     inside,
                     shade,
                     ..
                 }| {
                    let vertex = self.loop_vertex(&segment.ray, place, tentative.t, inside, shade);
                    segment.place(vertex)
                },
            );
            ControlFlow::Break(())
        });
        vertex.or_else(|| skeleton.map(|(segment, hit)| self.ground_vertex(&segment, hit)))
    }

    /// Share of light that comes through along a shadow ray, by ratio tracking: random, with the right mean.
    pub fn tracked_visibility(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Scratch) -> f64 {
        scratch.counters.shadow_rays += 1;
        let mut transmittance = 1.0;
        let skeleton = self.track(ray, pcg, scratch, |_, tentative, pcg, scratch| {
            scratch.counters.contributing_hits += 1;
            // Rounding may lift σ a little above the majorant.
            transmittance *= (1.0 - tentative.sigma / tentative.majorant).max(0.0);
            if transmittance < ROULETTE_BELOW {
                if pcg.next_float() < 0.5 {
                    transmittance = 0.0;
                    return ControlFlow::Break(());
                }
                transmittance *= 2.0;
            }
            ControlFlow::Continue(())
        });
        if skeleton.is_some() {
            0.0
        } else {
            transmittance
        }
    }
}

/// A random optical depth with density e^−x.
fn free_depth(pcg: &mut Pcg) -> f64 {
    -(-f64::from(pcg.next_float())).ln_1p()
}
