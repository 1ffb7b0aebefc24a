//! Compositing along a ray for `single` and `layered`: which event a camera ray shows, and what a shadow ray lets
//! through (MODEL.md §9; the paper's §6, steps 3 to 5).

use super::layered::LayerCrossing;
use super::scratch::Scratch;
use super::single::Crossing;
use super::skeleton::SkeletonHit;
use super::tracer::Tracer;
use super::walk::{LoopPart, LoopPlace, Span};
use crate::design::Method;
use crate::geometry::{Interval, Ray};
use crate::optics::Vertex;
use crate::optics::limits::DARK;
use crate::render::Counters;

/// Something that takes light from a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Event {
    /// Place in the order of events, mm along the ray.
    t: f64,
    /// Share of light that goes no further.
    opacity: f64,
    what: EventKind,
}

#[derive(Debug, Clone, Copy)]
enum EventKind {
    /// `single`: a loop crossed.
    Loop(LoopPlace, Crossing),
    /// `layered`: one layer of a loop crossed.
    Layer(LoopPlace, LayerCrossing),
    Skeleton(SkeletonHit),
}

impl Tracer {
    /// The first event at which the transmittance along a camera ray falls below `xi`, as the point that scatters; each
    /// event is chosen with its share T·opacity of the light, so that the point counts with weight 1.
    pub fn first_event(&self, ray: &Ray, xi: f64, scratch: &mut Scratch) -> Option<Vertex> {
        scratch.counters.rays += 1;
        let mut transmittance = 1.0;
        for (segment, span) in self.spans(ray) {
            let ray = &segment.ray;
            scratch.counters.cells += 1;
            scratch.events.clear();
            // Step 5: the skeleton is opaque. Loops of the far side are met in blocks behind its gaps.
            if let Some(hit) = self.skeleton_hit(ray, &span) {
                scratch.events.push(Event {
                    t: hit.t,
                    opacity: 1.0,
                    what: EventKind::Skeleton(hit),
                });
            }
            let Scratch {
                events, counters, ..
            } = scratch;
            // Step 3: all loops crossed in this block.
            self.for_each_event(ray, &span, counters, |event| events.push(event));
            events.sort_by(|a, b| a.t.total_cmp(&b.t));
            for event in events.iter() {
                // Step 4: what each lets through.
                transmittance *= 1.0 - event.opacity;
                if transmittance < xi {
                    return Some(segment.place(self.vertex_of(ray, event)));
                }
            }
        }
        None
    }

    /// Share of light that comes through along a shadow ray.
    pub fn composited_visibility(&self, ray: &Ray, scratch: &mut Scratch) -> f64 {
        scratch.counters.shadow_rays += 1;
        let mut transmittance = 1.0;
        for (segment, span) in self.spans(ray) {
            let ray = &segment.ray;
            scratch.counters.cells += 1;
            if self.skeleton_hit(ray, &span).is_some() {
                return 0.0;
            }
            self.for_each_event(ray, &span, &mut scratch.counters, |event| {
                transmittance *= 1.0 - event.opacity;
            });
            if transmittance < DARK {
                return 0.0;
            }
        }
        transmittance
    }

    /// The events of loops whose place on the ray lies in `span`.
    fn for_each_event(
        &self,
        ray: &Ray,
        span: &Span,
        counters: &mut Counters,
        mut found: impl FnMut(Event),
    ) {
        let layers = self.scene.volumes.layers;
        let part = match self.settings.method {
            Method::Single => LoopPart::Patch,
            _ => LoopPart::Volume,
        };
        let within = Interval::new(span.enter, span.leave);
        let pieces = self.grid.pieces(ray, within, span.index, part);
        for place in self.loops_in(span.index).along(pieces) {
            let ray = ray.relative_to(self.cell_origin(place.cell));
            let mut event = |t: f64, depth: f64, what: EventKind, counters: &mut Counters| {
                if depth > 0.0 {
                    counters.contributing_hits += 1;
                    found(Event {
                        t,
                        opacity: -(-depth).exp_m1(),
                        what,
                    });
                }
            };
            if self.settings.method == Method::Layered {
                self.for_each_layer(&ray, place, counters, |crossing, counters| {
                    if span.holds(crossing.t()) {
                        let depth = crossing.optical_depth(&self.volume(place), counters);
                        let what = EventKind::Layer(place, crossing);
                        event(crossing.t(), depth, what, counters);
                    }
                });
            } else {
                self.for_each_crossing(&ray, place, counters, |crossing, counters| {
                    if span.holds(crossing.t()) {
                        let depth = crossing.optical_depth(&self.volume(place), layers, counters);
                        let what = EventKind::Loop(place, crossing);
                        event(crossing.t(), depth, what, counters);
                    }
                });
            }
        }
    }

    /// The point at which an event scatters.
    fn vertex_of(&self, ray: &Ray, event: &Event) -> Vertex {
        match event.what {
            EventKind::Loop(place, crossing) => {
                let mean = crossing.mean_point(&self.volume(place), self.scene.volumes.layers);
                self.loop_vertex(ray, place, mean.t, mean.place, mean.shade)
            }
            EventKind::Layer(place, crossing) => {
                let shade = self.volume(place).at(crossing.place()).shade;
                self.loop_vertex(ray, place, crossing.t_middle(), crossing.place(), shade)
            }
            EventKind::Skeleton(hit) => self.skeleton_vertex(ray, hit),
        }
    }
}
