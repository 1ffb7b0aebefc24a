//! Compositing along a ray for `single` and `layered` (MODEL.md §9; the paper's §6, steps 3 to 5): which event a camera
//! ray shows, and what a shadow ray lets through.
//!
//! A loop is solved once a ray, in the first block that lists it. What that finds is a camera ray's business in the
//! block that holds it, and until then waits in [`Scratch::pending`]; a shadow ray takes it at once, since the order of
//! what takes light away does not matter to what is left.

use glam::Vec3A;

use super::batch::Batch;
use super::block::LoopPart;
use super::block_ray::{BlockRay, Listed};
use super::crossing::Crossing;
use super::event::Event;
use super::form::RaySegment;
use super::lanes::Lanes;
use super::walk::SquareSpan;
use super::{Scratch, Tracer};
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::Vertex;
use crate::render::Counters;
use crate::transport::Start;

/// Optical depth of a shadow ray from which on it counts as dark: −ln of [`DARK`](crate::optics::limits::DARK).
const DARK_DEPTH: f32 = 9.210_34;

impl Tracer {
    /// The first event at which the transmittance along a camera ray falls below `xi`, as the point that scatters; each
    /// event is chosen with its share T·opacity of the light, so that the point counts with weight 1.
    #[inline(always)]
    pub(super) fn first_event<L: Lanes>(
        &self,
        ray: &Ray,
        xi: f64,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        scratch.counters.rays += 1;
        let limit = -(xi.ln() as f32);
        let mut depth = 0.0;
        for segment in self.segments(ray, Start::Eye) {
            let vertex = self.first_event_of::<L>(&segment, limit, &mut depth, scratch);
            if let Some(vertex) = vertex {
                return Some(segment.place(vertex));
            }
        }
        None
    }

    /// The first event in one segment of a camera ray at which `depth`, which grows, exceeds a limit.
    #[inline(always)]
    fn first_event_of<L: Lanes>(
        &self,
        segment: &RaySegment,
        limit: f32,
        depth: &mut f32,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        let cloth = &self.cloth;
        let ray = &segment.ray;
        let part = self.part_in_cloth(ray, segment.part);
        scratch.pending.clear();
        scratch.mailbox.clear();
        let ground_layer = self.ground_layer(ray, part);
        let (mut ground, mut ground_is_known) = (None, false);
        for span in cloth.grid.blocks(ray, part) {
            scratch.counters.cells += 1;
            // Step 5: the ground is opaque. Loops of the far side are met in blocks behind its gaps.
            if !ground_is_known && span.leave > ground_layer[0] {
                ground = self.ground_hit(ray, ground_layer);
                ground_is_known = true;
            }
            let from = (span.enter - part[0]) as f32;
            let to = ground.map_or(span.leave, |hit| hit.t.min(span.leave)) - part[0];
            // Step 3: all loops crossed in this block.
            self.solve_block::<L>(
                ray,
                &span,
                from,
                part[0] as f32,
                scratch,
                |event, pending| {
                    // Of equals, all those that the ray's origin lies in, the first found is the nearest.
                    let behind = pending.iter().rposition(|other| other.t > event.t);
                    pending.insert(behind.map_or(0, |at| at + 1), event);
                },
            );
            // Step 4: what each lets through. The nearest is last.
            let mut chosen = None;
            while let Some(event) = scratch.pending.pop_if(|event| event.t < to as f32) {
                *depth += event.depth;
                if *depth > limit {
                    chosen = Some(event);
                    break;
                }
            }
            if let Some(event) = chosen {
                return Some(self.event_vertex::<L>(ray, &event, part[0]));
            }
            if ground.is_some_and(|hit| hit.t <= span.leave) {
                break;
            }
        }
        ground.map(|hit| self.ground_vertex(ray, &hit))
    }

    /// Share of light that comes through along a shadow ray.
    #[inline(always)]
    pub(super) fn composited_visibility<L: Lanes>(&self, ray: &Ray, scratch: &mut Scratch) -> f64 {
        scratch.counters.shadow_rays += 1;
        let cloth = &self.cloth;
        let mut depth = 0.0;
        for segment in self.segments(ray, Start::Cloth) {
            let ray = &segment.ray;
            if self.is_blocked_by_ground(ray, segment.part, scratch) {
                return 0.0;
            }
            let part = (cloth.grid).clip_blocks(ray, segment.part, cloth.grid.loop_heights);
            // Of a loop that is solved here, another segment may hold the crossing.
            let end = (segment.part[1] - part[0]) as f32;
            scratch.mailbox.clear();
            for span in cloth.grid.blocks(ray, part) {
                scratch.counters.cells += 1;
                let from = (span.enter - part[0]) as f32;
                self.solve_block::<L>(ray, &span, from, part[0] as f32, scratch, |event, _| {
                    if event.t < end {
                        depth += event.depth;
                    }
                });
                if depth > DARK_DEPTH && self.ends_opaque_rays {
                    scratch.counters.ended_rays += 1;
                    return 0.0;
                }
            }
        }
        f64::from(-depth).exp()
    }

    /// Calls `found` for all events, here or further on, of the loops that a ray may meet in a block and that it has
    /// not solved before. The block begins `from` mm from where the ray came to the cloth, and that is `start` mm from
    /// its origin.
    #[inline(always)]
    fn solve_block<L: Lanes>(
        &self,
        ray: &Ray,
        span: &SquareSpan,
        from: f32,
        start: f32,
        scratch: &mut Scratch,
        mut found: impl FnMut(Event, &mut Vec<Event>),
    ) {
        let block = self.cloth.block(span.square);
        let part = self.cloth.in_block(ray, span);
        let leave = part.point.z + part.direction.z * part.length;
        let heights = [part.point.z.min(leave), part.point.z.max(leave)];
        let Scratch {
            counters,
            mailbox,
            pending,
            ..
        } = scratch;
        if self.skips_empty && block.is_missed(heights) {
            counters.skipped_cells += 1;
            return;
        }
        let mut batch = Batch::new();
        let looked_for = match self.settings.method {
            Method::Layered => LoopPart::Volume,
            _ => LoopPart::Patch,
        };
        let starts = span.enter <= 0.0;
        let mut met = block.met_by(&part, looked_for, starts, self.skips_empty);
        loop {
            let is_more_left = met.fill::<L>(&mut batch, |index| {
                let is_known = self.remembers_tests && mailbox.has(index);
                counters.repeated_tests += u64::from(is_known);
                !is_known
            });
            self.solve_batch::<L>(&mut batch, &part, [from, start], counters, &mut |event| {
                found(event, pending);
            });
            if !is_more_left {
                return;
            }
        }
    }

    /// The events of the loops of a batch, which is emptied.
    #[inline(always)]
    fn solve_batch<L: Lanes>(
        &self,
        batch: &mut Batch,
        part: &BlockRay,
        [from, start]: [f32; 2],
        counters: &mut Counters,
        found: &mut impl FnMut(Event),
    ) {
        if batch.is_empty() {
            return;
        }
        let mut crossed = if self.settings.method == Method::Layered {
            // Layers lie beside the middle patch.
            counters.patch_tests += (batch.len() * self.cloth.layers()) as u64;
            batch.all()
        } else {
            counters.patch_tests += batch.len() as u64;
            batch.crossed::<L>(&self.cloth, part)
        };
        while crossed != 0 {
            let listed = batch.loop_of(crossed.trailing_zeros() as usize);
            crossed &= crossed - 1;
            self.solve::<L>(part, listed, from, from + start, counters, found);
        }
        batch.clear();
    }

    /// The events of one loop. `from` and `travelled` are the distances of the part's beginning from where the ray came
    /// to the cloth, and from its origin.
    #[inline(always)]
    fn solve<L: Lanes>(
        &self,
        part: &BlockRay,
        listed: Listed,
        from: f32,
        travelled: f32,
        counters: &mut Counters,
        found: &mut impl FnMut(Event),
    ) {
        let cloth = &self.cloth;
        let patch = cloth.patch(listed.index, listed.cell, part.point);
        if self.settings.method == Method::Layered {
            let normal = patch.normal();
            let layers = cloth.layers() as f32;
            for layer in 0..cloth.layers() {
                let w = (layer as f32 + 0.5) / layers - 0.5;
                let offset = normal * (w * cloth.thickness);
                let roots = patch.roots(part.direction, offset);
                for &root in roots.as_slice() {
                    let crossing = Crossing::of_layer(
                        &patch,
                        normal,
                        cloth.thickness,
                        part.direction,
                        travelled,
                        root,
                        [w, layers],
                    );
                    if let Some(crossing) = crossing {
                        self.event::<L>(part, listed, crossing, from, travelled, counters, found);
                    }
                }
            }
            return;
        }
        let roots = patch.roots(part.direction, Vec3A::ZERO);
        let count = roots.as_slice().len();
        if count == 0 {
            return;
        }
        let normal = patch.normal();
        for which in 0..count {
            let crossing = Crossing::of_middle(
                &patch,
                normal,
                cloth.thickness,
                part.direction,
                travelled,
                &roots,
                which,
            );
            if let Some(crossing) = crossing {
                self.event::<L>(part, listed, crossing, from, travelled, counters, found);
            }
        }
    }

    /// The event of a crossing, if it is one and this block's to tell.
    #[expect(
        clippy::too_many_arguments,
        reason = "all of it is inlined into the one loop that has them"
    )]
    #[inline(always)]
    fn event<L: Lanes>(
        &self,
        part: &BlockRay,
        listed: Listed,
        crossing: Crossing,
        from: f32,
        travelled: f32,
        counters: &mut Counters,
        found: &mut impl FnMut(Event),
    ) {
        let t = crossing.t();
        // Crossings before this block were found in an earlier one, but for those behind a ray that begins here. Where
        // loops are solved in every block that lists them, each block takes its own crossings only.
        if t < 0.0 && travelled > 0.0 || !self.remembers_tests && t >= part.length {
            return;
        }
        let cloth = &self.cloth;
        let yarn = cloth.yarn(listed.index);
        let depth = crossing.optical_depth::<L>(&yarn, cloth.layers(), counters);
        if depth > 0.0 {
            counters.contributing_hits += 1;
            found(Event {
                t: from + t.max(0.0),
                depth,
                index: listed.index,
                crossing,
                found_from: from,
            });
        }
    }
}
