//! `exact`: the parts of a ray inside a loop from four clips and two quadratics (MODEL.md §4), cut wherever the
//! volume's interpolation has a kink or a jump, so that within a piece σ of each loop is smooth. With `quality.step` →
//! 0 this is the truth that all other methods are measured against (MODEL.md §9).
//!
//! Cuts are: the ends of the parts; the planes of the texels' centres in u and v; and across the layers their
//! interfaces where layers are slabs, their centres where they blend.

use super::march::{Inside, Met};
use super::tracer::Tracer;
use super::walk::LoopPlace;
use crate::design::Interpolation;
use crate::geometry::{FrameLine, Interval, Ray};
use crate::render::Counters;

impl Tracer {
    /// Adds the parts of `span` of a ray inside a loop, and their cuts; `ray` is relative to the loop's cell.
    pub(super) fn meet_exactly(
        &self,
        ray: &Ray,
        span: Interval,
        place: LoopPlace,
        met: &mut Met,
        counters: &mut Counters,
    ) {
        counters.patch_tests += 1;
        let line = FrameLine::new(self.frame(place), ray);
        for &part in line.inside(span).as_slice() {
            met.inside.push(Inside { place, part });
            met.cuts.extend([part.low, part.high]);
            let inner = |&t: &f64| part.low < t && t < part.high;

            let texels = self.scene.volumes.resolution;
            let ([u0, v0, _], [u1, v1, _]) = (line.at(part.low), line.at(part.high));
            let across = centres_between(u0, u1, texels).map(|u| line.crossing_u(u));
            met.cuts.extend(across.filter(inner));
            let up = centres_between(v0, v1, texels).map(|v| line.crossing_v(v));
            met.cuts.extend(up.filter(inner));
            for w in self.layer_lines() {
                let crossings = line.crossings_w(w);
                let crossings = crossings.as_slice().iter().map(|root| root.t);
                met.cuts.extend(crossings.filter(inner));
            }
        }
    }

    /// The w at which the volumes' interpolation across layers has a jump or a kink.
    fn layer_lines(&self) -> impl Iterator<Item = f64> + use<> {
        let layers = self.scene.volumes.layers;
        let (first, shift) = match self.scene.volumes.interpolation {
            Interpolation::Nearest => (1, 0.0),
            Interpolation::Linear => (0, 0.5),
        };
        let count = f64::from(layers);
        (first..layers).map(move |layer| (f64::from(layer) + shift) / count - 0.5)
    }
}

/// The centres (k + ½)/`count` of those texels that lie between two places; u and v change one way along a ray.
fn centres_between(a: f64, b: f64, count: u32) -> impl Iterator<Item = f64> {
    let index = |place: f64| (place * f64::from(count) - 0.5).clamp(-0.5, f64::from(count));
    let (first, last) = (index(a.min(b)).ceil(), index(a.max(b)).floor());
    let last = last.min(f64::from(count) - 1.0);
    (first as i64..=last as i64).map(move |k| (k as f64 + 0.5) / f64::from(count))
}
