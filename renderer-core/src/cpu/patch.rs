//! Ray against the bilinear patch of a loop, in f32; mm, relative to a point of the ray near by.
//!
//! With u′ = u − ½, v′ = v − ½ the patch is P = `middle` + u′b + v′c + u′v′A (MODEL.md §4). A ray meets a line of
//! constant u′ or v′ where a product of three vectors vanishes, a quadratic solved with the sign-safe root (Reshetov,
//! "Cool Patches", Ray Tracing Gems 2019, ch. 8; Wang's §5.2 solves the same system). Of the two families of lines the
//! one is taken that runs less along the ray: rounding would choose among lines that all run along it. The ray's point
//! nearest to the middle is the origin of the solve, since from far away the coefficients would be differences of large
//! numbers.

use glam::Vec3A;

use crate::geometry::tolerances::{FLATTEST, SHORT, SMALLEST_AREA};

/// A patch, `middle` seen from the ray's point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// P(½, ½), mm.
    pub middle: Vec3A,
    /// b: ∂P/∂u in the middle, mm.
    pub along_u: Vec3A,
    /// c: ∂P/∂v in the middle, mm.
    pub along_v: Vec3A,
    /// A, mm.
    pub twist: Vec3A,
}

/// A crossing of a ray with the patch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Root {
    /// Distance from the ray's point, mm; may be negative.
    pub t: f32,
    pub u: f32,
    pub v: f32,
}

/// At most two crossings, nearer first.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Roots {
    roots: [Root; 2],
    count: usize,
}

impl Roots {
    #[inline(always)]
    pub fn as_slice(&self) -> &[Root] {
        &self.roots[..self.count]
    }

    #[inline(always)]
    fn push(&mut self, root: Root) {
        self.roots[self.count] = root;
        self.count += 1;
        if self.count == 2 && self.roots[1].t < self.roots[0].t {
            self.roots.swap(0, 1);
        }
    }
}

/// How fast a ray moves through (u, v, w), per mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slopes {
    pub u: f32,
    pub v: f32,
    pub w: f32,
    /// (A·n̂)·u′·v′: what bends w along the ray, times the thickness, 1/mm.
    pub bend: f32,
}

/// The patch as seen along a ray: p and r in [−½, ½], r the one that is eliminated,
/// P = `middle` + p·`along_p` + r·`along_r` + p·r·`twist`, `middle` from the ray's point nearest to it.
struct Seen {
    middle: Vec3A,
    along_p: Vec3A,
    along_r: Vec3A,
    twist: Vec3A,
    direction: Vec3A,
}

impl Seen {
    /// (r, t) at a known p, with p made better where that is needed; `None` where r is outside [−½, ½].
    #[inline(always)]
    fn at(&self, p: f32) -> Option<[f32; 3]> {
        let ruling = self.along_r + self.twist * p;
        let start = self.middle + self.along_p * p;
        let ruling_d = ruling.cross(self.direction);
        let r_times = -start.cross(self.direction).dot(ruling_d);
        let squared = ruling_d.length_squared();
        let is_short = squared < SHORT * self.along_r.length_squared();
        // Before that step r may be a little off.
        let reach = if is_short { 0.6 } else { 0.5 };
        // False for NaN, too.
        let is_within = r_times.abs() <= reach * squared;
        if !is_within || squared <= 0.0 {
            return None;
        }
        let mut place = [p, r_times / squared];
        if is_short {
            place = self.refined(place);
            if place.iter().any(|x| x.abs() > 0.5) {
                return None;
            }
        }
        let [p, r] = place;
        let point = self.middle + self.along_p * p + (self.along_r + self.twist * p) * r;
        Some([p, r, point.dot(self.direction)])
    }

    /// One step of Newton's method on the place where patch and ray meet, if it is small.
    #[inline(always)]
    fn refined(&self, [p, r]: [f32; 2]) -> [f32; 2] {
        let tangent_p = self.along_p + self.twist * r;
        let tangent_r = self.along_r + self.twist * p;
        let point = self.middle + self.along_p * p + tangent_r * r;
        let area = tangent_p.cross(tangent_r).dot(self.direction);
        let p_area = tangent_r.cross(point).dot(self.direction);
        let r_area = point.cross(tangent_p).dot(self.direction);
        // A step leaves the product of its parts, times the twist. Where that is more than rounding two crossings are
        // about to become one, and the method fails.
        if (p_area * r_area).abs() > 1e-7 * area * area || area == 0.0 {
            return [p, r];
        }
        [p + p_area / area, r + r_area / area]
    }
}

impl Patch {
    /// All crossings with u and v in [0, 1] of the patch moved by `offset`.
    #[inline(always)]
    pub fn roots(&self, direction: Vec3A, offset: Vec3A) -> Roots {
        let mut roots = Roots::default();
        let to_middle = self.middle + offset;
        let t_near = to_middle.dot(direction);
        let middle = to_middle - direction * t_near;
        let u_cross = self.along_u.cross(direction);
        let v_cross = self.along_v.cross(direction);
        let solve_u = u_cross.length_squared() * self.along_v.length_squared()
            < v_cross.length_squared() * self.along_u.length_squared();
        let (along_p, along_r, r_cross) = if solve_u {
            (self.along_u, self.along_v, v_cross)
        } else {
            (self.along_v, self.along_u, u_cross)
        };
        let twist_cross = self.twist.cross(direction);
        // (middle + p·along_p)·((along_r + p·twist) × direction) = c0 + c1·p + c2·p² = 0.
        let c0 = middle.dot(r_cross);
        let c1 = middle.dot(twist_cross) + along_p.dot(r_cross);
        let c2 = along_p.dot(twist_cross);
        // No p in [−½, ½] makes c1·p + c2·p² as large as c0.
        if c0.abs() > 0.5 * c1.abs() + 0.25 * c2.abs() {
            return roots;
        }
        let discriminant = c1 * c1 - 4.0 * c0 * c2;
        if discriminant < 0.0 {
            return roots;
        }
        let root = discriminant.sqrt();
        let q = -0.5 * (c1 + root.copysign(c1));
        let seen = Seen {
            middle,
            along_p,
            along_r,
            twist: self.twist,
            direction,
        };
        // p = c0/q and p = q/c2; each division is made only where its result lies in [−½, ½], so a vanishing leading
        // coefficient leaves the linear root and no division by zero.
        let first = q != 0.0 && c0.abs() <= 0.5 * q.abs();
        let second = c2 != 0.0 && root > 0.0 && q.abs() <= 0.5 * c2.abs();
        for which in 0..2 {
            let p = match which {
                0 if first => c0 / q,
                1 if second => q / c2,
                _ => continue,
            };
            if let Some([p, r, t]) = seen.at(p) {
                let (u, v) = if solve_u { (p, r) } else { (r, p) };
                roots.push(Root {
                    t: t_near + t,
                    u: u + 0.5,
                    v: v + 0.5,
                });
            }
        }
        roots
    }

    /// n̂: unit normal. Compile drops loops for which it (nearly) vanishes.
    #[inline(always)]
    pub fn normal(&self) -> Vec3A {
        let normal = self.along_u.cross(self.along_v);
        normal / normal.length_squared().max(1e-30).sqrt()
    }

    /// (u′, v′, w′) = J⁻¹·direction at (u, v), J = [∂P/∂u, ∂P/∂v, `thickness`·n̂]. |w′| is at least [`FLATTEST`].
    #[inline(always)]
    pub fn slopes(&self, normal: Vec3A, thickness: f32, direction: Vec3A, root: &Root) -> Slopes {
        let along_u = self.along_u + self.twist * (root.v - 0.5);
        let along_v = self.along_v + self.twist * (root.u - 0.5);
        let area = along_u.cross(along_v);
        let inverse = 1.0 / area.dot(normal).max(SMALLEST_AREA);
        let u = direction.dot(along_v.cross(normal)) * inverse;
        let v = direction.dot(normal.cross(along_u)) * inverse;
        let w = direction.dot(area) * inverse / thickness;
        Slopes {
            u,
            v,
            w: w.abs().max(FLATTEST as f32).copysign(w),
            bend: self.twist.dot(normal) * u * v,
        }
    }
}

/// An interval of distances, mm; empty unless `low` < `high`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub low: f32,
    pub high: f32,
}

impl Span {
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        // NaN counts as empty.
        let holds_some = self.low < self.high;
        !holds_some
    }

    #[inline(always)]
    pub fn middle(self) -> f32 {
        0.5 * (self.low + self.high)
    }

    #[inline(always)]
    pub fn length(self) -> f32 {
        self.high - self.low
    }

    /// The part in which `value` + `slope`·t lies within `low` and `high`. A slope below 10⁻⁹ moves less than f32
    /// resolves over any interval inside a loop.
    #[inline(always)]
    pub fn clip(self, value: f32, slope: f32, low: f32, high: f32) -> Self {
        let slope = if slope.abs() < 1e-9 { 1e-9 } else { slope };
        let inverse = 1.0 / slope;
        let (a, b) = ((low - value) * inverse, (high - value) * inverse);
        Self {
            low: self.low.max(a.min(b)),
            high: self.high.min(a.max(b)),
        }
    }
}
