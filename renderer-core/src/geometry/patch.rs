//! Ray against bilinear patch: all crossings of a ray with P(u,v), in f64.
//!
//! The patch is written about its middle: with u′ = u − ½, v′ = v − ½,
//! P = `centre` + u′·b + v′·c + u′v′·A, which is MODEL.md §4's P0 + u·B + v·C + uv·A with b = B + ½A, c = C + ½A.
//!
//! Method: a ray meets the ruling line of constant u where (`centre` + u′b − o)·((c + u′A) × direction) = 0, a
//! quadratic in u′, solved with the sign-safe formula; v′ and t follow from that line (Reshetov, "Cool Patches", Ray
//! Tracing Gems 2019, ch. 8). The paper's §5.2 solves the same system. A vanishing leading coefficient falls through to
//! the linear root, not to a division.

use glam::DVec3;

use super::Ray;

/// A bilinear patch: `centre` + (u−½)·`along_u` + (v−½)·`along_v` + (u−½)(v−½)·`twist`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BilinearPatch {
    /// P(½, ½).
    pub centre: DVec3,
    /// b: ∂P/∂u in the middle.
    pub along_u: DVec3,
    /// c: ∂P/∂v in the middle.
    pub along_v: DVec3,
    /// A: the mixed derivative.
    pub twist: DVec3,
}

/// A crossing of a ray with a patch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Root {
    /// Distance along the ray; may be negative.
    pub t: f64,
    /// Place on the patch along its base.
    pub u: f64,
    /// Place on the patch upwards.
    pub v: f64,
}

/// At most two crossings, in order of t.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Roots {
    roots: [Root; 2],
    count: usize,
}

impl Roots {
    fn push(&mut self, root: Root) {
        self.roots[self.count] = root;
        self.count += 1;
        if self.count == 2 && self.roots[1].t < self.roots[0].t {
            self.roots.swap(0, 1);
        }
    }

    /// The crossings.
    pub fn as_slice(&self) -> &[Root] {
        &self.roots[..self.count]
    }
}

/// The real roots of a·x² + b·x + c, each computed without cancellation; a double root comes twice; infinite where
/// there is only one (a = 0); `None` where there is none, or where all coefficients vanish.
pub fn quadratic_roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    if q != 0.0 {
        Some([q / a, c / q])
    } else if a != 0.0 {
        // b = 0 and a·c = 0, so c = 0.
        Some([0.0; 2])
    } else {
        None
    }
}

impl BilinearPatch {
    /// The patch with P(0,0), P(1,0), P(1,1), P(0,1) at these points.
    pub fn from_corners([p0, p1, p2, p3]: [DVec3; 4]) -> Self {
        Self {
            centre: (p0 + p1 + p2 + p3) * 0.25,
            along_u: (p1 - p0 + p2 - p3) * 0.5,
            along_v: (p3 - p0 + p2 - p1) * 0.5,
            twist: p0 - p1 + p2 - p3,
        }
    }

    /// The point P(u, v).
    pub fn at(&self, u: f64, v: f64) -> DVec3 {
        let (u, v) = (u - 0.5, v - 0.5);
        self.centre + self.along_u * u + self.along_v * v + self.twist * (u * v)
    }

    /// ∂P/∂u and ∂P/∂v at (u, v).
    pub fn tangents(&self, u: f64, v: f64) -> [DVec3; 2] {
        [
            self.along_u + self.twist * (v - 0.5),
            self.along_v + self.twist * (u - 0.5),
        ]
    }

    /// Crossings of the whole line with the part of the patch with u and v in [0, 1], in order of t.
    pub fn roots(&self, ray: &Ray) -> Roots {
        PatchLine::new(self, ray).roots(DVec3::ZERO)
    }
}

/// A line and a patch that may be moved: what all crossings of one line with parallel patches share.
#[derive(Debug, Clone, Copy)]
pub struct PatchLine<'a> {
    patch: &'a BilinearPatch,
    direction: DVec3,
    /// Where the line is nearest to the patch's middle, and the way from there to the middle: in f32 (the twin in
    /// shaders/), products with the distance to a far origin would cost all digits.
    t_near: f64,
    to_centre: DVec3,
    /// c × direction and A × direction.
    c_cross: DVec3,
    a_cross: DVec3,
    /// b·(A × direction) and b·(c × direction).
    quadratic: f64,
    linear: f64,
}

impl<'a> PatchLine<'a> {
    /// The whole line of `ray`, and `patch`.
    pub fn new(patch: &'a BilinearPatch, ray: &Ray) -> Self {
        let direction = ray.direction;
        let t_near = (patch.centre - ray.origin).dot(direction);
        let c_cross = patch.along_v.cross(direction);
        let a_cross = patch.twist.cross(direction);
        Self {
            patch,
            direction,
            t_near,
            to_centre: patch.centre - ray.at(t_near),
            c_cross,
            a_cross,
            quadratic: patch.along_u.dot(a_cross),
            linear: patch.along_u.dot(c_cross),
        }
    }

    /// Crossings with the part with u and v in [0, 1] of the patch moved by `offset`, in order of t.
    pub fn roots(&self, offset: DVec3) -> Roots {
        self.roots_within(offset, 0.5)
    }

    /// Crossings with the part with u and v at most `reach` from ½ of the patch moved by `offset`, in order of t.
    pub(super) fn roots_within(&self, offset: DVec3, reach: f64) -> Roots {
        let within = -reach..=reach;
        let to_centre = self.to_centre + offset;
        let candidates = quadratic_roots(
            self.quadratic,
            to_centre.dot(self.a_cross) + self.linear,
            to_centre.dot(self.c_cross),
        );
        let mut roots = Roots::default();
        for u in candidates.into_iter().flatten() {
            if !within.contains(&u) {
                continue;
            }
            // start + t·direction = base + v·ruling, the ruling line of this u.
            let base = to_centre + self.patch.along_u * u;
            let ruling = self.patch.along_v + self.patch.twist * u;
            let ruling_cross = self.c_cross + self.a_cross * u;
            let v = -base.cross(self.direction).dot(ruling_cross) / ruling_cross.length_squared();
            // Also false for NaN, of a ray along the ruling line.
            if within.contains(&v) {
                roots.push(Root {
                    t: self.t_near + (base + ruling * v).dot(self.direction),
                    u: u + 0.5,
                    v: v + 0.5,
                });
            }
        }
        roots
    }
}
