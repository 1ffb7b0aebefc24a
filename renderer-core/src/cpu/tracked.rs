//! `tracked`: delta tracking (Woodcock) through the summed densities of all loops, and ratio tracking for shadow rays.
//! Unbiased, without a step, overlaps exact (MODEL.md §9).
//!
//! Free paths in pile are far shorter than a block. So a ray goes on in stretches of a few mean free paths, and only the loops
//! that reach into a stretch are looked at. In a stretch σ is at most the densest material's, where loops may overlap 1.5 times
//! that; before the first loop and behind the last nothing is spent.

use std::ops::ControlFlow;

use super::block::{Block, BlockRay, Listed, LoopPart};
use super::frame::FrameRay;
use super::ground::GroundHit;
use super::patch::Span;
use super::{Scratch, Tracer};
use crate::geometry::Ray;
use crate::optics::Vertex;
use crate::sampling::Pcg;

/// How many times denser than one solid yarn overlapping yarns may be.
const MOST_OVERLAP: f32 = 1.5;
/// Length of a stretch, in mean free paths through solid yarn, and at least, mm.
const STRETCH: f32 = 3.0;
const SHORTEST_STRETCH_MM: f32 = 0.1;
/// Transmittance of a shadow ray below which every second one ends and the other counts twice.
const ROULETTE_BELOW: f32 = 1.0 / 16.0;

/// A loop that a stretch may pass.
#[derive(Debug)]
pub(super) struct Along {
    index: u32,
    frame: FrameRay,
    span: Span,
}

/// One loop at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    index: u32,
    place: [f32; 3],
    /// Extinction by this loop, 1/mm.
    sigma: f32,
}

/// A place where a ray may collide.
struct Tentative {
    /// Distance along the ray, mm.
    t: f64,
    /// Most that σ may be here, 1/mm.
    majorant: f32,
    /// σ there, 1/mm.
    sigma: f32,
}

impl Tracer {
    /// Where a ray collides; `None` if it leaves the cloth.
    #[inline(always)]
    pub fn collision(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Scratch) -> Option<Vertex> {
        scratch.counters.rays += 1;
        let part = self.part_in_cloth(ray);
        let mut vertex = None;
        let ground = self.track(ray, part, true, pcg, scratch, |tentative, pcg, scratch| {
            // One number decides both whether it collides and with which loop: with each in proportion to its part of σ.
            let mut rest = pcg.next_float() * tentative.majorant;
            if rest >= tentative.sigma {
                return ControlFlow::Continue(());
            }
            scratch.counters.contributing_hits += 1;
            let passed = |overlap: &&Overlap| {
                rest -= overlap.sigma;
                rest < 0.0
            };
            // Rounding may leave a rest behind the last.
            let overlaps = &scratch.overlaps;
            vertex = overlaps
                .iter()
                .find(passed)
                .or(overlaps.last())
                .map(|overlap| {
                    let shade = self.cloth.yarn(overlap.index).shade(overlap.place);
                    self.loop_vertex(ray, overlap.index, tentative.t, overlap.place, shade)
                });
            ControlFlow::Break(())
        });
        vertex.or_else(|| ground.map(|hit| self.ground_vertex(ray, &hit)))
    }

    /// Share of light that comes through along a shadow ray: random, with the right mean.
    #[inline(always)]
    pub fn tracked_visibility(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Scratch) -> f64 {
        scratch.counters.shadow_rays += 1;
        if self.is_blocked_by_ground(ray, scratch) {
            return 0.0;
        }
        let grid = &self.cloth.grid;
        let part = grid.clip_blocks(ray, grid.loop_heights);
        let mut transmittance = 1.0_f32;
        self.track(ray, part, false, pcg, scratch, |tentative, pcg, scratch| {
            scratch.counters.contributing_hits += 1;
            transmittance *= 1.0 - tentative.sigma / tentative.majorant;
            if transmittance < ROULETTE_BELOW && self.ends_opaque_rays {
                if pcg.next_float() < 0.5 {
                    scratch.counters.ended_rays += 1;
                    transmittance = 0.0;
                    return ControlFlow::Break(());
                }
                transmittance *= 2.0;
            }
            ControlFlow::Continue(())
        });
        f64::from(transmittance)
    }

    /// Calls `collide` at the tentative collisions of a ray, in order, until it breaks or the ray meets the ground (if it is
    /// to be looked for) or leaves the cloth; the ground's hit if it got there.
    #[inline(always)]
    fn track(
        &self,
        ray: &Ray,
        part: [f64; 2],
        finds_ground: bool,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
        mut collide: impl FnMut(&Tentative, &mut Pcg, &mut Scratch) -> ControlFlow<()>,
    ) -> Option<GroundHit> {
        let cloth = &self.cloth;
        let mut depth_left = free_depth(pcg);
        let stretch = f64::from((STRETCH / cloth.densest.max(1e-6)).max(SHORTEST_STRETCH_MM));
        for mut span in cloth.grid.blocks(ray, part) {
            scratch.counters.cells += 1;
            let ground = if finds_ground {
                let layer = self.ground_layer(ray, [span.enter, span.leave]);
                self.ground_hit(ray, layer)
            } else {
                None
            };
            let end = ground.map_or(span.leave, |hit| hit.t);
            let block = cloth.block(span.square);
            let heights = if self.skips_empty {
                block.heights().map(f64::from)
            } else {
                cloth.grid.loop_heights
            };
            let [from, end] = cloth.grid.clip_heights(ray, span.enter, end, heights);
            if from >= end && self.skips_empty {
                scratch.counters.skipped_cells += 1;
            }
            span.enter = from;
            while span.enter < end {
                span.leave = end.min(span.enter + stretch);
                let piece = cloth.in_block(ray, &span);
                let mut along = std::mem::take(&mut scratch.along);
                self.loops_along(&piece, block, &mut along, scratch);
                let flow = self.fly(
                    &piece,
                    span.enter,
                    &along,
                    &mut depth_left,
                    pcg,
                    scratch,
                    &mut collide,
                );
                scratch.along = along;
                if flow.is_break() {
                    return None;
                }
                span.enter = span.leave;
            }
            if ground.is_some() {
                return ground;
            }
        }
        None
    }

    /// The loops that a ray may meet in a stretch, each with where.
    #[inline(always)]
    fn loops_along(
        &self,
        piece: &BlockRay,
        block: Block<'_>,
        along: &mut Vec<Along>,
        scratch: &mut Scratch,
    ) {
        along.clear();
        let whole = Span {
            low: 0.0,
            high: piece.length,
        };
        let cloth = &self.cloth;
        let mut look = |listed: Listed| {
            scratch.counters.patch_tests += 1;
            let patch = cloth.patch(listed.index, listed.cell, piece.point);
            let frame = FrameRay::new(&patch, cloth.thickness, piece.direction);
            let span = frame.clip(whole);
            if !span.is_empty() {
                along.push(Along {
                    index: listed.index,
                    frame,
                    span,
                });
            }
        };
        for listed in block.met_by(piece, LoopPart::Volume, false, self.skips_empty) {
            look(listed);
        }
    }

    /// Calls `collide` at the tentative collisions in a stretch that begins at distance `start`.
    #[expect(
        clippy::too_many_arguments,
        reason = "the state of a flight, taken apart for the borrow checker"
    )]
    fn fly(
        &self,
        piece: &BlockRay,
        start: f64,
        along: &[Along],
        depth_left: &mut f32,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
        collide: &mut impl FnMut(&Tentative, &mut Pcg, &mut Scratch) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let majorant = match along {
            [] => return ControlFlow::Continue(()),
            [_] => self.cloth.densest,
            _ => MOST_OVERLAP * self.cloth.densest,
        };
        // Nothing is met before the first loop, nor behind the last.
        let mut t = along
            .iter()
            .fold(piece.length, |t, along| t.min(along.span.low));
        let end = along
            .iter()
            .fold(0.0_f32, |t, along| t.max(along.span.high));
        loop {
            let collision = t + *depth_left / majorant;
            let is_before_end = collision < end;
            if !is_before_end {
                *depth_left -= (end - t).max(0.0) * majorant;
                *depth_left = depth_left.max(0.0);
                return ControlFlow::Continue(());
            }
            t = collision;
            let sigma = self.overlaps_at(t, along, scratch);
            if sigma > 0.0 {
                let tentative = Tentative {
                    t: start + f64::from(t),
                    majorant,
                    sigma,
                };
                collide(&tentative, pcg, scratch)?;
            }
            *depth_left = free_depth(pcg);
        }
    }

    /// σ at `t` of a stretch, and in `scratch` the loops that make it.
    #[inline(always)]
    fn overlaps_at(&self, t: f32, along: &[Along], scratch: &mut Scratch) -> f32 {
        let Scratch {
            counters, overlaps, ..
        } = scratch;
        overlaps.clear();
        let (mut sum_rho, mut sum_sigma) = (0.0, 0.0);
        for loop_along in along {
            if !(loop_along.span.low <= t && t <= loop_along.span.high) {
                continue;
            }
            counters.patch_tests += 1;
            let Some(place) = loop_along.frame.inside(t) else {
                continue;
            };
            counters.volume_samples += 1;
            let yarn = self.cloth.yarn(loop_along.index);
            let [u, v, w] = place;
            let rho = yarn.rho(u, v, w);
            if rho > 0.0 {
                let sigma = yarn.density * rho;
                (sum_rho, sum_sigma) = (sum_rho + rho, sum_sigma + sigma);
                overlaps.push(Overlap {
                    index: loop_along.index,
                    place,
                    sigma,
                });
            }
        }
        // Where yarns overlap too much they displace each other (MODEL.md §5).
        if sum_rho > MOST_OVERLAP {
            let crowding = MOST_OVERLAP / sum_rho;
            overlaps
                .iter_mut()
                .for_each(|overlap| overlap.sigma *= crowding);
            sum_sigma *= crowding;
        }
        sum_sigma
    }
}

/// A random optical depth with density e^−x.
#[inline(always)]
fn free_depth(pcg: &mut Pcg) -> f32 {
    -(-pcg.next_float()).ln_1p()
}
