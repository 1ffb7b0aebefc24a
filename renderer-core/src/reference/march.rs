//! Marching along a ray through the summed densities, for `exact` and `six-face`: which piece of a camera ray scatters,
//! and what a shadow ray lets through (MODEL.md §8 and §9; the paper's figure 8, step by step).
//!
//! In each block the method says which parts of the ray are inside loops and where the ray must be cut; between two
//! cuts it is cut further into equal pieces of at most `quality.step`. A piece is uniform: all that it holds, σ, the
//! shares of the loops in it, shade and fibres, comes from its middle, and it lets exp(−σ·length) through.

use std::ops::ControlFlow;

use super::form::RaySegment;
use super::scratch::Scratch;
use super::skeleton::SkeletonHit;
use super::tracer::Tracer;
use super::tracked::{Overlap, chosen, crowded};
use super::walk::{LoopPart, LoopPlace, Span};
use crate::design::Method;
use crate::geometry::{Interval, Ray};
use crate::optics::Vertex;
use crate::optics::limits::DARK;

/// A part of a ray in a loop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inside {
    pub place: LoopPlace,
    pub part: Interval,
}

/// What a ray meets in a block.
#[derive(Debug, Default)]
pub(super) struct Met {
    /// Its parts in loops.
    pub inside: Vec<Inside>,
    /// Where it is cut, in no order; nothing is met before the first cut, nor behind the last.
    pub cuts: Vec<f64>,
}

/// A piece of a ray, with the loops that make its σ in [`Scratch`].
struct Piece {
    /// Where it begins, and its length, mm.
    start: f64,
    length: f64,
    /// Extinction, 1/mm.
    sigma: f64,
}

impl Tracer {
    /// The point at which the transmittance along a camera ray falls below `xi`; of the loops that overlap there,
    /// `choice` in [0, 1) picks one by its share of σ. The point counts with weight 1.
    pub fn marched_event(
        &self,
        ray: &Ray,
        xi: f64,
        choice: f64,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        scratch.counters.rays += 1;
        let mut transmittance = 1.0;
        let mut vertex = None;
        let skeleton = self.march(ray, scratch, |segment, piece, overlaps| {
            let left = transmittance * f64::exp(-piece.sigma * piece.length);
            if left >= xi {
                transmittance = left;
                return ControlFlow::Continue(());
            }
            let t = piece.start + f64::ln(transmittance / xi) / piece.sigma;
            vertex = chosen(overlaps, choice * piece.sigma).map(|overlap| {
                let ray = &segment.ray;
                segment.place(self.loop_vertex(
                    ray,
                    overlap.place,
                    t,
                    overlap.inside,
                    overlap.shade,
                ))
            });
            ControlFlow::Break(())
        });
        vertex.or_else(|| skeleton.map(|(segment, hit)| self.ground_vertex(&segment, hit)))
    }

    /// Share of light that comes through along a shadow ray.
    pub fn marched_visibility(&self, ray: &Ray, scratch: &mut Scratch) -> f64 {
        scratch.counters.shadow_rays += 1;
        let mut transmittance = 1.0;
        let skeleton = self.march(ray, scratch, |_, piece, _| {
            transmittance *= f64::exp(-piece.sigma * piece.length);
            if transmittance < DARK {
                transmittance = 0.0;
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        if skeleton.is_some() {
            0.0
        } else {
            transmittance
        }
    }

    /// Calls `visit` for the pieces of a ray that hold something, in order, until it breaks or the ray meets the
    /// skeleton or leaves the cloth; the skeleton's hit if it got there.
    fn march(
        &self,
        ray: &Ray,
        scratch: &mut Scratch,
        mut visit: impl FnMut(&RaySegment, &Piece, &[Overlap]) -> ControlFlow<()>,
    ) -> Option<(RaySegment, SkeletonHit)> {
        for (segment, mut span) in self.spans(ray) {
            let ray = &segment.ray;
            scratch.counters.cells += 1;
            let skeleton = self.skeleton_hit(ray, &span);
            if let Some(hit) = skeleton {
                span.leave = hit.t;
            }
            let mut met = std::mem::take(&mut scratch.met);
            self.meet(ray, &span, &mut met, scratch);
            let broke = self.march_block(ray, &met, scratch, |piece, overlaps| {
                visit(&segment, piece, overlaps)
            });
            scratch.met = met;
            if broke.is_break() {
                return None;
            }
            if let Some(hit) = skeleton {
                return Some((segment, hit));
            }
        }
        None
    }

    /// Finds what a ray meets in its part `span` of a block.
    fn meet(&self, ray: &Ray, span: &Span, met: &mut Met, scratch: &mut Scratch) {
        met.inside.clear();
        met.cuts.clear();
        let part = Interval::new(span.enter, span.leave);
        let pieces = self.grid.pieces(ray, part, span.index, LoopPart::Volume);
        for place in self.loops_in(span.index).along(pieces) {
            let ray = ray.relative_to(self.cell_origin(place.cell));
            if self.settings.method == Method::SixFace {
                self.meet_faces(&ray, part, place, met, &mut scratch.counters);
            } else {
                self.meet_exactly(&ray, part, place, met, &mut scratch.counters);
            }
        }
        met.cuts.sort_by(f64::total_cmp);
    }

    fn march_block(
        &self,
        ray: &Ray,
        met: &Met,
        scratch: &mut Scratch,
        mut visit: impl FnMut(&Piece, &[Overlap]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        for ends in met.cuts.windows(2) {
            let between = Interval::new(ends[0], ends[1]);
            let count = (between.length() / self.settings.step_mm).ceil();
            let length = between.length() / count;
            for k in 0..count as u64 {
                let start = between.low + k as f64 * length;
                let sigma = self.sigma_at(ray, start + 0.5 * length, &met.inside, scratch);
                if sigma > 0.0 {
                    scratch.counters.contributing_hits += 1;
                    let piece = Piece {
                        start,
                        length,
                        sigma,
                    };
                    visit(&piece, &scratch.overlaps)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// σ at `t` of a ray, and in `scratch` the loops that make it, of those that the ray is `inside`.
    fn sigma_at(&self, ray: &Ray, t: f64, inside: &[Inside], scratch: &mut Scratch) -> f64 {
        let Scratch {
            counters, overlaps, ..
        } = scratch;
        overlaps.clear();
        let mut sum_rho = 0.0;
        for &Inside { place, .. } in inside.iter().filter(|inside| inside.part.holds(t)) {
            let frame = self.frame(place);
            let point = ray.at(t) - self.cell_origin(place.cell);
            let found = if self.settings.method == Method::SixFace {
                // Between the first face and the last a ray may leave the loop and come back.
                frame.invert(point)
            } else {
                Some(frame.locate(point))
            };
            if let Some(overlap) = found.and_then(|at| self.overlap(place, at, counters)) {
                sum_rho += overlap.rho;
                overlaps.push(overlap);
            }
        }
        crowded(overlaps, sum_rho)
    }
}
