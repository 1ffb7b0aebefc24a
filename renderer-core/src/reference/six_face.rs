//! `six-face`: Kajiya's general form, as the paper's §5.2 describes what its own method avoids: the ray is intersected
//! with the six bounding surfaces of a loop's volume, each P = A·u·v + B·u + C·v + D, and marched from where it enters
//! to where it leaves, a voxel looked up at every step. It is the yardstick of the paper's "six times".
//!
//! Each surface counts as one patch test. Nothing is known of what lies between entry and exit: the march has no cuts
//! at voxels or layers, and looks a point up wherever it falls, also where the ray is outside for a while.

use super::march::{Inside, Met};
use super::tracer::Tracer;
use super::walk::LoopPlace;
use crate::geometry::{BilinearPatch, Interval, LoopFrame, Ray};
use crate::render::Counters;

/// The bounding surfaces of a frame: w, v and u each at its lowest and its highest.
fn faces(frame: &LoopFrame) -> [BilinearPatch; 6] {
    let corner = |u: u8, v: u8, w: u8| frame.at([f64::from(u), f64::from(v), f64::from(w) - 0.5]);
    let face = |at: &dyn Fn(u8, u8) -> glam::DVec3| {
        BilinearPatch::from_corners([at(0, 0), at(1, 0), at(1, 1), at(0, 1)])
    };
    [
        face(&|u, v| corner(u, v, 0)),
        face(&|u, v| corner(u, v, 1)),
        face(&|u, w| corner(u, 0, w)),
        face(&|u, w| corner(u, 1, w)),
        face(&|v, w| corner(0, v, w)),
        face(&|v, w| corner(1, v, w)),
    ]
}

impl Tracer {
    /// Adds the part of `span` of a ray between its first and its last crossing of a loop's surfaces; `ray` is relative
    /// to the loop's cell.
    pub(super) fn meet_faces(
        &self,
        ray: &Ray,
        span: Interval,
        place: LoopPlace,
        met: &mut Met,
        counters: &mut Counters,
    ) {
        let mut part = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        for face in faces(self.frame(place)) {
            counters.patch_tests += 1;
            for root in face.roots(ray).as_slice() {
                part = Interval::new(part.low.min(root.t), part.high.max(root.t));
            }
        }
        let part = part.intersect(span);
        if part.is_empty() {
            return;
        }
        met.inside.push(Inside { place, part });
        // One march from the first entry in the cell to the last exit.
        match met.cuts[..] {
            [low, high] => met.cuts = vec![low.min(part.low), high.max(part.high)],
            _ => met.cuts = vec![part.low, part.high],
        }
    }
}
