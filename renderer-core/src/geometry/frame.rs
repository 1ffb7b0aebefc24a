//! The frame of a yarn loop: a bilinear patch made thick along one constant normal (MODEL.md §4).
//!
//! X(u,v,w) = P(u,v) + w·h·n̂ with n̂ = (b × c)/|b × c| and w in [−½, ½]. Because n̂ is constant, a point is inverted
//! by projecting it along n̂ onto the plane of b and c, where A's part is αb + βc.

use glam::DVec3;

use super::{BilinearPatch, Interval, Ray};

/// A patch with its thickness: the space of one loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopFrame {
    /// The patch at w = 0.
    pub patch: BilinearPatch,
    /// n̂: direction of the thickness, unit vector.
    pub normal: DVec3,
    /// h: thickness along n̂, mm.
    pub thickness: f64,
    /// A·n̂: the patch's corners are a quarter of it out of the plane of b and c, mm.
    pub lift: f64,
    /// The dual vectors of b and c in their plane: the first has product 1 with b and 0 with c, the second the other
    /// way round.
    duals: [DVec3; 2],
    /// (α, β): the part of A in the plane of b and c is αb + βc.
    skew: [f64; 2],
}

/// How u, v and w change along a ray, per mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slopes {
    /// u′.
    pub u: f64,
    /// v′.
    pub v: f64,
    /// w′.
    pub w: f64,
}

impl LoopFrame {
    /// The frame about `patch`, whose b and c are not parallel, `thickness` mm thick.
    pub fn new(patch: BilinearPatch, thickness: f64) -> Self {
        let product = patch.along_u.cross(patch.along_v);
        let area = product.length();
        let normal = product / area;
        let unit = normal / area;
        let duals = [patch.along_v.cross(unit), unit.cross(patch.along_u)];
        Self {
            patch,
            normal,
            thickness,
            lift: patch.twist.dot(normal),
            duals,
            skew: duals.map(|dual| patch.twist.dot(dual)),
        }
    }

    /// The point X(u, v, w).
    pub fn at(&self, [u, v, w]: [f64; 3]) -> DVec3 {
        self.patch.at(u, v) + self.normal * (w * self.thickness)
    }

    /// ∂X/∂u, ∂X/∂v, ∂X/∂w at (u, v); they do not depend on w.
    pub fn jacobian(&self, u: f64, v: f64) -> [DVec3; 3] {
        let [along_u, along_v] = self.patch.tangents(u, v);
        [along_u, along_v, self.normal * self.thickness]
    }

    /// J⁻¹·`direction` at (u, v): how the coordinates change along a ray there.
    pub fn slopes(&self, u: f64, v: f64, direction: DVec3) -> Slopes {
        let [along_u, along_v] = self.patch.tangents(u, v);
        let v_cross = along_v.cross(self.normal);
        let inverse = 1.0 / along_u.dot(v_cross);
        Slopes {
            u: direction.dot(v_cross) * inverse,
            v: direction.dot(self.normal.cross(along_u)) * inverse,
            w: direction.dot(along_u.cross(along_v)) * inverse / self.thickness,
        }
    }

    /// J⁻ᵀ·`slopes` at (u, v): the gradient in space, per mm, of something with these derivatives by u, v and w.
    pub fn gradient(&self, u: f64, v: f64, slopes: DVec3) -> DVec3 {
        let [along_u, along_v, along_w] = self.jacobian(u, v);
        let volume = along_u.cross(along_v).dot(along_w);
        (along_v.cross(along_w) * slopes.x
            + along_w.cross(along_u) * slopes.y
            + along_u.cross(along_v) * slopes.z)
            / volume
    }

    /// (α, β): the part of A in the plane of b and c is αb + βc.
    pub fn skew(&self) -> [f64; 2] {
        self.skew
    }

    /// The dual vectors of b and c in their plane: products with a point's offset from the patch's middle are p and q.
    pub(super) fn duals(&self) -> [DVec3; 2] {
        self.duals
    }

    /// (u, v, w) of the point at (p, q) in the basis (b, c) and at `height` over their plane. Exact within convex
    /// frames, and next to them.
    ///
    /// From p = u′(1 + αv′), q = v′(1 + βu′): βu′² + (1 + αq − βp)u′ − p = 0, of which the root that vanishes with p.
    pub(super) fn coordinates(&self, p: f64, q: f64, height: f64) -> [f64; 3] {
        let [alpha, beta] = self.skew;
        let linear = 1.0 + alpha * q - beta * p;
        let discriminant = (linear * linear + 4.0 * beta * p).max(0.0);
        let u = 2.0 * p / (linear + discriminant.sqrt());
        let v = q / (1.0 + beta * u);
        let w = (height - u * v * self.lift) / self.thickness;
        [u + 0.5, v + 0.5, w]
    }

    /// Coordinates (u, v, w) of a point inside the frame or next to it.
    pub fn locate(&self, point: DVec3) -> [f64; 3] {
        let offset = point - self.patch.centre;
        let [p, q] = self.duals.map(|dual| offset.dot(dual));
        self.coordinates(p, q, offset.dot(self.normal))
    }

    /// The part of `span` along a ray outside of which the ray is certainly not in the frame: there |u′|, |v′| and |w|
    /// stay within ½, and with them p, q and the height over the middle plane, which are linear along the ray.
    pub fn clip(&self, ray: &Ray, span: Interval) -> Interval {
        let offset = ray.origin - self.patch.centre;
        let within = |span: Interval, axis: DVec3, bound: f64| {
            let range = Interval::new(-bound, bound);
            span.clip_linear(offset.dot(axis), ray.direction.dot(axis), range)
        };
        let [u_bound, v_bound] = self.skew.map(|skew| 0.5 + 0.25 * skew.abs());
        let height_bound = 0.5 * self.thickness + 0.25 * self.lift.abs();
        let span = within(span, self.normal, height_bound);
        let span = within(span, self.duals[0], u_bound);
        within(span, self.duals[1], v_bound)
    }

    /// Coordinates (u, v, w) of a point, if it is inside: u and v in [0, 1], w in [−½, ½]. Exact for convex frames.
    ///
    /// With p, q the coordinates of the projected point in the basis (b, c): p = u′(1 + αv′), q = v′(1 + βu′).
    pub fn invert(&self, point: DVec3) -> Option<[f64; 3]> {
        let offset = point - self.patch.centre;
        let height = offset.dot(self.normal);
        // Most points that are tried lie above or below the loop: the patch itself rises by a quarter of the lift.
        if height.abs() > 0.5 * self.thickness + 0.25 * self.lift.abs() {
            return None;
        }
        let [p, q] = self.duals.map(|dual| offset.dot(dual));
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
