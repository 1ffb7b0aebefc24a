//! A ray in the coordinates of a loop's frame, in f32: MODEL.md §4's inversion along a line.
//!
//! Projected along n̂ onto the plane of b and c a point has coordinates p = u′(1 + αv′), q = v′(1 + βu′), u′ = u − ½,
//! v′ = v − ½, with αb + βc the part of A in that plane. p, q and the height over the plane are linear along a ray: six
//! products are made once for a loop, and a point costs a square root.

use glam::Vec3A;

use super::patch::{Patch, Span};

/// A ray seen from a loop's frame: start and slope of p, q and height; t in mm from the ray's point.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameRay {
    p: [f32; 2],
    q: [f32; 2],
    height: [f32; 2],
    /// α and β.
    skew: [f32; 2],
    /// A·n̂, mm.
    lift: f32,
    thickness: f32,
}

impl FrameRay {
    #[inline(always)]
    pub fn new(patch: &Patch, thickness: f32, direction: Vec3A) -> Self {
        let product = patch.along_u.cross(patch.along_v);
        let per_area = 1.0 / product.length_squared().max(1e-30);
        let normal = product * per_area.sqrt();
        let unit = product * per_area;
        let duals = [patch.along_v.cross(unit), unit.cross(patch.along_u)];
        let along = |axis: Vec3A| [-patch.middle.dot(axis), direction.dot(axis)];
        Self {
            p: along(duals[0]),
            q: along(duals[1]),
            height: along(normal),
            skew: duals.map(|dual| patch.twist.dot(dual)),
            lift: patch.twist.dot(normal),
            thickness,
        }
    }

    /// The part of `span` outside of which the ray is certainly not in the frame: there |u′|, |v′| and |w| stay within ½,
    /// and with them p, q and the height.
    #[inline(always)]
    pub fn clip(&self, span: Span) -> Span {
        let [u_bound, v_bound] = self.skew.map(|skew| 0.5 + 0.25 * skew.abs());
        let height_bound = 0.5 * self.thickness + 0.25 * self.lift.abs();
        span.clip(self.height[0], self.height[1], -height_bound, height_bound)
            .clip(self.p[0], self.p[1], -u_bound, u_bound)
            .clip(self.q[0], self.q[1], -v_bound, v_bound)
    }

    /// (u, v, w) at `t`, if that is in the frame: u and v in [0, 1], w in [−½, ½]. Exact for convex frames.
    ///
    /// From p and q: βu′² + (1 + αq − βp)u′ − p = 0, of which the root that vanishes with p.
    #[inline(always)]
    pub fn inside(&self, t: f32) -> Option<[f32; 3]> {
        let at = |[start, slope]: [f32; 2]| start + slope * t;
        let (p, q, height) = (at(self.p), at(self.q), at(self.height));
        let [alpha, beta] = self.skew;
        let linear = 1.0 + alpha * q - beta * p;
        let discriminant = linear * linear + 4.0 * beta * p;
        if discriminant < 0.0 {
            return None;
        }
        let u = 2.0 * p / (linear + discriminant.sqrt());
        let v = q / (1.0 + beta * u);
        let w = (height - u * v * self.lift) / self.thickness;
        let half = -0.5..=0.5;
        (half.contains(&u) && half.contains(&v) && half.contains(&w)).then_some([
            u + 0.5,
            v + 0.5,
            w,
        ])
    }
}
