//! `tracked`: delta tracking (Woodcock) through the summed densities of all loops, and ratio tracking for shadow rays.
//! Unbiased, without a step, overlaps exact (MODEL.md §9).
//!
//! In a block the loops that the ray may meet are looked up once, each with the part of the ray that may be in its
//! frame. Where no part is, nothing is spent: the ray goes on to the next. Long parts are cut into eighths, of which
//! those stay in which there is yarn: fur and grass are mostly air. In one frame σ is at most the densest material's,
//! where frames overlap 1.5 times that.

use std::ops::ControlFlow;

use super::batch::Batch;
use super::block::{Block, LoopPart};
use super::block_ray::BlockRay;
use super::event::Overlap;
use super::form::RaySegment;
use super::frames::Frames;
use super::ground::GroundHit;
use super::lanes::{LANES, Lanes};
use super::{Scratch, Tracer};
use crate::geometry::Ray;
use crate::optics::{Vertex, limits};
use crate::sampling::Pcg;
use crate::transport::Start;

const MOST_OVERLAP: f32 = limits::MOST_OVERLAP as f32;

/// Transmittance of a shadow ray below which every second one ends and the other counts twice.
const ROULETTE_BELOW: f32 = 1.0 / 16.0;

/// A place where a ray may collide.
pub(super) struct Tentative {
    /// Distance along the ray, mm.
    pub t: f64,
    /// Most that σ may be here, 1/mm.
    pub majorant: f32,
    /// σ there, 1/mm.
    pub sigma: f32,
}

impl Tracer {
    /// Where a ray collides; `None` if it leaves the cloth.
    #[inline(always)]
    pub(super) fn collision<L: Lanes>(
        &self,
        ray: &Ray,
        start: Start,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        scratch.counters.rays += 1;
        for segment in self.segments(ray, start) {
            let vertex = self.collision_in::<L>(&segment, pcg, scratch);
            if let Some(vertex) = vertex {
                return Some(segment.place(vertex));
            }
        }
        None
    }

    /// Where a ray collides in one of its segments. Free paths have no memory: each segment begins another.
    #[inline(always)]
    fn collision_in<L: Lanes>(
        &self,
        segment: &RaySegment,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        let ray = &segment.ray;
        let part = self.part_in_cloth(ray, segment.part);
        let mut vertex = None;
        let ground = self.track::<L>(ray, part, true, pcg, scratch, |tentative, pcg, scratch| {
            // One number decides both whether it collides and with which loop: with each in proportion to its part of
            // σ.
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
                    self.loop_vertex::<L>(ray, overlap.index, tentative.t, overlap.place, shade)
                });
            ControlFlow::Break(())
        });
        vertex.or_else(|| ground.map(|hit| self.ground_vertex(ray, &hit)))
    }

    /// Share of light that comes through along a shadow ray: random, with the right mean.
    #[inline(always)]
    pub(super) fn tracked_visibility<L: Lanes>(
        &self,
        ray: &Ray,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
    ) -> f64 {
        scratch.counters.shadow_rays += 1;
        let grid = &self.cloth.grid;
        let mut transmittance = 1.0_f32;
        for segment in self.segments(ray, Start::Cloth) {
            let ray = &segment.ray;
            if self.is_blocked_by_ground(ray, segment.part, scratch) {
                return 0.0;
            }
            let part = grid.clip_blocks(ray, segment.part, grid.loop_heights);
            self.track::<L>(ray, part, false, pcg, scratch, |tentative, pcg, scratch| {
                scratch.counters.contributing_hits += 1;
                // Rounding may lift σ a little above the majorant.
                transmittance *= (1.0 - tentative.sigma / tentative.majorant).max(0.0);
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
            if transmittance == 0.0 {
                return 0.0;
            }
        }
        f64::from(transmittance)
    }

    /// Calls `collide` at the tentative collisions of a ray, in order, until it breaks or the ray meets the ground (if
    /// it is to be looked for) or leaves the cloth; the ground's hit if it got there.
    #[inline(always)]
    pub(super) fn track<L: Lanes>(
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
            if from < end {
                (span.enter, span.leave) = (from, end);
                let piece = cloth.in_block(ray, &span);
                self.loops_along::<L>(&piece, block, scratch);
                let flow = self.fly::<L>(
                    piece.length,
                    from,
                    &mut depth_left,
                    pcg,
                    scratch,
                    &mut collide,
                );
                if flow.is_break() {
                    return None;
                }
            }
            if ground.is_some() {
                return ground;
            }
        }
        None
    }

    /// Looks up the loops that a ray may meet in its part in a block, each with where: into `scratch`.
    #[inline(always)]
    fn loops_along<L: Lanes>(&self, piece: &BlockRay, block: Block<'_>, scratch: &mut Scratch) {
        let cloth = &self.cloth;
        let along = &mut scratch.along;
        along.clear();
        // Lanes that are free in the last of them.
        let mut free = 0;
        let is_cut = self.skips_empty && cloth.is_sparse();
        let mut batch = Batch::new();
        let mut met = block.met_by(piece, LoopPart::Volume, false, self.skips_empty);
        loop {
            let is_more_left = met.fill::<L>(&mut batch, |_| true);
            if !batch.is_empty() {
                scratch.counters.patch_tests += batch.len() as u64;
                let (frames, kept) = Frames::new::<L>(&batch, cloth, piece);
                if is_cut {
                    free = self.put_full_parts::<L>(&frames, kept, along, free);
                } else if kept != 0 {
                    along.push(frames);
                }
                batch.clear();
            }
            if !is_more_left {
                break;
            }
        }
    }

    /// Adds those eighths of the ray's parts in the frames of some lanes in which there may be yarn, neighbours as one;
    /// `free` lanes are free in the last of `along`, as many as the answer will be.
    #[inline(always)]
    fn put_full_parts<L: Lanes>(
        &self,
        frames: &Frames,
        mut lanes: u32,
        along: &mut Vec<Frames>,
        mut free: usize,
    ) -> usize {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            // Bits of the eighths.
            let mut full = 0xff;
            if frames.length(lane) > self.cloth.worth_looking_mm {
                full = self.full_pieces::<L>(frames, lane);
            }
            while full != 0 {
                let first = full.trailing_zeros();
                let count = (full >> first).trailing_ones();
                full &= full.wrapping_add(1 << first);
                if free == 0 {
                    along.push(Frames::NONE);
                    free = LANES;
                }
                if let Some(last) = along.last_mut() {
                    last.put_part(LANES - free, frames, lane, first, count);
                }
                free -= 1;
            }
        }
        free
    }

    /// A bit for each eighth of the ray's part in the frame of `lane` in which there may be yarn.
    #[inline(always)]
    fn full_pieces<L: Lanes>(&self, frames: &Frames, lane: usize) -> u32 {
        let lane = lane & (LANES - 1);
        let yarn = self.cloth.yarn(frames.index[lane]);
        let pieces = frames.pieces::<L>(lane, self.cloth.thickness);
        let (mut inside, mut full) = (pieces.inside, 0);
        while inside != 0 {
            let piece = inside.trailing_zeros() as usize & (LANES - 1);
            inside &= inside - 1;
            let range = |ends: &[[f32; LANES]; 2]| [ends[0][piece], ends[1][piece]];
            let is_empty = yarn.is_empty(range(&pieces.u), range(&pieces.v), range(&pieces.w));
            full |= u32::from(!is_empty) << piece;
        }
        full
    }

    /// Calls `collide` at the tentative collisions in a part of a ray, `length` mm long, that begins at distance
    /// `start`.
    #[inline(always)]
    fn fly<L: Lanes>(
        &self,
        length: f32,
        start: f64,
        depth_left: &mut f32,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
        collide: &mut impl FnMut(&Tentative, &mut Pcg, &mut Scratch) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut t = 0.0_f32;
        // From one place where a loop begins or ends to the next.
        while t < length {
            let (mut around, mut end) = (0, length);
            for frames in &mut scratch.along {
                end = end.min(frames.hold::<L>(t));
                around += frames.holding.count_ones();
            }
            let majorant = match around {
                0 => {
                    t = end;
                    continue;
                }
                1 => self.cloth.densest,
                _ => MOST_OVERLAP * self.cloth.densest,
            };
            loop {
                let collision = t + *depth_left / majorant;
                let is_before_end = collision < end;
                if !is_before_end {
                    *depth_left = (*depth_left - (end - t) * majorant).max(0.0);
                    t = end;
                    break;
                }
                t = collision;
                let sigma = self.overlaps_at::<L>(t, scratch);
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
        ControlFlow::Continue(())
    }

    /// σ at `t` of a part of a ray, and in `scratch` the loops that make it.
    #[inline(always)]
    fn overlaps_at<L: Lanes>(&self, t: f32, scratch: &mut Scratch) -> f32 {
        let Scratch {
            counters,
            along,
            overlaps,
            ..
        } = scratch;
        overlaps.clear();
        let per_thickness = 1.0 / self.cloth.thickness;
        let (mut sum_rho, mut sum_sigma) = (0.0, 0.0);
        for frames in along {
            if frames.holding == 0 {
                continue;
            }
            counters.patch_tests += u64::from(frames.holding.count_ones());
            let places = frames.places::<L>(t, per_thickness);
            let mut inside = frames.holding & places.inside;
            while inside != 0 {
                let lane = inside.trailing_zeros() as usize & (LANES - 1);
                inside &= inside - 1;
                counters.volume_samples += 1;
                let index = frames.index[lane];
                let yarn = self.cloth.yarn(index);
                let place = [places.u[lane], places.v[lane], places.w[lane]];
                let rho = yarn.rho::<L>(place);
                if rho > 0.0 {
                    let sigma = yarn.density * rho;
                    (sum_rho, sum_sigma) = (sum_rho + rho, sum_sigma + sigma);
                    overlaps.push(Overlap {
                        index,
                        place,
                        sigma,
                    });
                }
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
    // Random numbers are multiples of 2⁻²⁴: the difference is exact.
    -(1.0 - pcg.next_float()).ln()
}
