//! A line in the coordinates of a loop's frame: the parts of a ray that are inside the loop, and where it crosses the
//! loop's surfaces of constant u, v or w (MODEL.md §4).
//!
//! Projected along n̂ onto the plane of b and c a point has coordinates p = u′(1 + αv′), q = v′(1 + βu′), u′ = u − ½,
//! v′ = v − ½; p, q and the height over that plane are linear along a ray. A surface of constant u or v is a plane,
//! since it holds n̂; one of constant w is the patch, moved along n̂.

use super::{BilinearPatch, Interval, LoopFrame, PatchLine, Ray, Roots};

/// How far beyond the patch's border roots are looked for, in u and v: where a ray runs within rounding along a side
/// face, its crossings with top and bottom must not get lost. What counts is the clip by the side faces.
const BORDER: f64 = 1e-9;

/// value + slope·t.
#[derive(Debug, Clone, Copy)]
struct Linear {
    value: f64,
    slope: f64,
}

impl Linear {
    fn at(self, t: f64) -> f64 {
        self.value + self.slope * t
    }

    fn scaled(self, by: f64) -> Self {
        Self {
            value: self.value * by,
            slope: self.slope * by,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: self.slope + other.slope,
        }
    }

    /// Where it is 0; infinite or NaN where it is constant.
    fn zero(self) -> f64 {
        -self.value / self.slope
    }

    /// The part of `span` in which it is not negative.
    fn clip_positive(self, span: Interval) -> Interval {
        span.clip_linear(self.value, self.slope, Interval::new(0.0, f64::INFINITY))
    }
}

/// The parts of a line inside a frame, in order; at most two, since the volume is convex but for the patch's saddle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsideParts {
    parts: [Interval; 2],
    count: usize,
}

impl InsideParts {
    /// The parts.
    pub fn as_slice(&self) -> &[Interval] {
        &self.parts[..self.count]
    }

    /// Adds what lies behind the last part, or makes that longer where it goes on without a gap.
    fn push(&mut self, part: Interval) {
        let is_full = self.count == self.parts.len();
        match self.parts[..self.count].last_mut() {
            Some(last) if is_full || last.high == part.low => last.high = part.high,
            _ => {
                self.parts[self.count] = part;
                self.count += 1;
            }
        }
    }
}

/// A line and a frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameLine<'a> {
    frame: &'a LoopFrame,
    patch_line: PatchLine<'a>,
    p: Linear,
    q: Linear,
    height: Linear,
}

impl<'a> FrameLine<'a> {
    /// The whole line of `ray`, seen from `frame`.
    pub fn new(frame: &'a LoopFrame, ray: &Ray) -> Self {
        let patch: &BilinearPatch = &frame.patch;
        let offset = ray.origin - patch.centre;
        let [b_dual, c_dual] = frame.duals();
        let along = |axis: glam::DVec3| Linear {
            value: offset.dot(axis),
            slope: ray.direction.dot(axis),
        };
        Self {
            frame,
            patch_line: PatchLine::new(patch, ray),
            p: along(b_dual),
            q: along(c_dual),
            height: along(frame.normal),
        }
    }

    /// (u, v, w) at `t`, which lies within the side faces (or next to them).
    pub fn at(&self, t: f64) -> [f64; 3] {
        self.frame
            .coordinates(self.p.at(t), self.q.at(t), self.height.at(t))
    }

    /// 0 where the line crosses the plane of constant u; positive on the side of larger u.
    fn over_u(&self, u: f64) -> Linear {
        let [alpha, beta] = self.frame.skew();
        let s = u - 0.5;
        // p(1 + βs) − s(1 + βs + αq), from p = s(1 + αv′) and q = v′(1 + βs).
        let stretch = 1.0 + beta * s;
        let mut over = self.p.scaled(stretch).plus(self.q.scaled(-alpha * s));
        over.value -= s * stretch;
        over
    }

    /// 0 where the line crosses the plane of constant v; positive on the side of larger v.
    fn over_v(&self, v: f64) -> Linear {
        let [alpha, beta] = self.frame.skew();
        let s = v - 0.5;
        let stretch = 1.0 + alpha * s;
        let mut over = self.q.scaled(stretch).plus(self.p.scaled(-beta * s));
        over.value -= s * stretch;
        over
    }

    /// Where it crosses the plane of constant `u`; not finite where it never does.
    pub fn crossing_u(&self, u: f64) -> f64 {
        self.over_u(u).zero()
    }

    /// Where it crosses the plane of constant `v`; not finite where it never does.
    pub fn crossing_v(&self, v: f64) -> f64 {
        self.over_v(v).zero()
    }

    /// Where it crosses the patch at `w`, with u and v in [0, 1] or a rounding error beyond.
    pub fn crossings_w(&self, w: f64) -> Roots {
        let offset = self.frame.normal * (w * self.frame.thickness);
        self.patch_line.roots_within(offset, 0.5 + BORDER)
    }

    /// The parts of `span` inside the frame: the clip by the four side faces is cut at the crossings with top and
    /// bottom, and those pieces are kept that are inside at their middle.
    pub fn inside(&self, span: Interval) -> InsideParts {
        let negative = |over: Linear| over.scaled(-1.0);
        let mut within = span;
        for side in [
            self.over_u(0.0),
            negative(self.over_u(1.0)),
            self.over_v(0.0),
            negative(self.over_v(1.0)),
        ] {
            within = side.clip_positive(within);
        }
        let mut inside = InsideParts {
            parts: [Interval::new(0.0, 0.0); 2],
            count: 0,
        };
        if within.is_empty() {
            return inside;
        }
        let (bottom, top) = (self.crossings_w(-0.5), self.crossings_w(0.5));
        let mut cuts = [within.high; 6];
        cuts[0] = within.low;
        let roots = bottom.as_slice().iter().chain(top.as_slice());
        for (cut, root) in cuts[1..5].iter_mut().zip(roots) {
            *cut = root.t.clamp(within.low, within.high);
        }
        cuts.sort_by(f64::total_cmp);
        for ends in cuts.windows(2) {
            let part = Interval::new(ends[0], ends[1]);
            if !part.is_empty() && self.at(part.middle())[2].abs() <= 0.5 {
                inside.push(part);
            }
        }
        inside
    }
}
