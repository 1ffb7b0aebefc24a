//! The ground weave: two sets of yarns that wind over and under each other (MODEL.md §7, the paper's §4.1).
//!
//! Space: relative to a cell's centre, mm; z from the sheet. A warp over the cell has the centre line
//! (x_i, H·s(y)), s = ±1 at the crossings and a half cosine between; a weft along x has −s.
//!
//! - `winding`: the round tube (x − x_i)² + (z − H·s)² = R², whose upper half is the paper's displacement H·s + A with
//!   A = √(R² − (x − x_i)²), and whose lower half is what the back shows. It is met from outside by steps that the
//!   distance to the tube allows, divided by the fastest that distance can change along the ray.
//! - `paper`: the thin height field z = A·s of equations 1 and 2, by fixed steps over the yarn's strip.
//!
//! Either crossing is then refined between its two sides. Yarns end at the sheet's border and have no walls beside
//! their strip. Yarns wider than their pitch reach into their neighbours' cells; all that do are tested.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::walk::{Grid, Span};
use crate::design::SkeletonHeight;
use crate::geometry::tolerances::{PAPER_STEPS, ROOMY, SMALLEST_STEP};
use crate::geometry::{Interval, Ray};
use crate::scene::{SheetGeometry, Skeleton};

/// Width to which a crossing is refined, mm: far below a fibre, far above rounding.
const PRECISION_MM: f64 = 1e-9;

/// Where a ray meets the skeleton.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkeletonHit {
    /// Distance along the ray, mm.
    pub t: f64,
    /// Unit normal, turned against the ray.
    pub normal: DVec3,
    /// Unit vector along the yarn on its surface; zero on a cut end.
    pub along: DVec3,
}

/// All yarns of the ground weave.
#[derive(Debug, Clone)]
pub struct Yarns {
    pitch: DVec2,
    /// Radius of the warps, then of the wefts, mm.
    radius: [f64; 2],
    /// H, mm.
    crimp: f64,
    form: SkeletonHeight,
    repeat: [i64; 2],
    warp_over: Vec<bool>,
}

/// One yarn as seen from one cell, in its own axes: `across` it, `along` it, z.
#[derive(Debug, Clone, Copy)]
struct Yarn {
    /// Which coordinate runs across it: 0 for warps, 1 for wefts.
    across: usize,
    /// Its centre line's place across, relative to the cell's centre.
    centre: f64,
    radius: f64,
    crimp: f64,
    /// Distance between its crossings.
    pitch: f64,
    /// s at the crossing before this cell's, at this cell's, and at the next.
    over: [f64; 3],
}

impl Yarns {
    /// The yarns of a sheet.
    pub fn new(sheet: &SheetGeometry, skeleton: &Skeleton) -> Self {
        Self {
            pitch: DVec2::new(sheet.pitch_x_mm, sheet.pitch_y_mm),
            radius: [skeleton.warp_radius_mm, skeleton.weft_radius_mm].map(f64::from),
            crimp: f64::from(skeleton.crimp_mm),
            form: skeleton.height,
            repeat: skeleton.repeat.map(i64::from),
            warp_over: skeleton.warp_over.clone(),
        }
    }

    /// The greatest height of any yarn above or below the sheet, mm.
    pub fn height(&self) -> f64 {
        self.height_of(0).max(self.height_of(1))
    }

    fn height_of(&self, set: usize) -> f64 {
        match self.form {
            SkeletonHeight::Winding => self.crimp + self.radius[set],
            SkeletonHeight::Paper => self.radius[set],
        }
    }

    /// +1 where the warp lies over the weft at crossing (i, j), else −1; the pattern repeats beyond the sheet.
    fn over(&self, i: i64, j: i64) -> f64 {
        let [columns, rows] = self.repeat;
        let index = j.rem_euclid(rows) * columns + i.rem_euclid(columns);
        if self.warp_over[index as usize] {
            1.0
        } else {
            -1.0
        }
    }

    /// The yarn `offset` places beside the one through the centre of `cell`; set 0 is the warps.
    fn yarn(&self, set: usize, [i, j]: [i64; 2], offset: i64) -> Yarn {
        let over = [-1, 0, 1].map(|step| match set {
            0 => self.over(i + offset, j + step),
            _ => -self.over(i + step, j + offset),
        });
        Yarn {
            across: set,
            centre: offset as f64 * self.pitch[set],
            radius: self.radius[set],
            crimp: self.crimp,
            pitch: self.pitch[1 - set],
            over,
        }
    }

    /// The nearest meeting of a ray with a yarn in one cell of the sheet; `cell_centre` is the cell's, in the ray's
    /// space.
    pub fn hit(
        &self,
        grid: &Grid,
        ray: &Ray,
        span: &Span,
        cell_centre: DVec3,
    ) -> Option<SkeletonHit> {
        let height = self.height();
        let sheet_layer = Interval::new(-height, height);
        if !grid.is_in_sheet(span.index) || !span.heights(ray).overlaps(sheet_layer) {
            return None;
        }
        let ray = ray.relative_to(cell_centre);
        let mut nearest: Option<SkeletonHit> = None;
        for set in 0..2 {
            // Yarns k places away reach into the cell while k·pitch − radius < ½ pitch.
            let reach = (self.radius[set] / self.pitch[set] - 0.5).ceil().max(0.0) as i64;
            for offset in -reach..=reach {
                let mut neighbour = span.index;
                neighbour[set] += offset;
                if !grid.is_in_sheet(neighbour) {
                    continue;
                }
                let yarn = self.yarn(set, span.index, offset);
                let end = nearest.map_or(span.leave, |hit| hit.t);
                let room = match self.form {
                    SkeletonHeight::Winding => ROOMY,
                    SkeletonHeight::Paper => 1.0,
                };
                let part = Interval::new(span.enter, end);
                let part = yarn.clip(&ray, part, self.height_of(set), room);
                if part.is_empty() {
                    continue;
                }
                let hit = match self.form {
                    SkeletonHeight::Winding if yarn.distance(ray.at(part.low)) <= 0.0 => {
                        Some(self.cut_end(&ray, part.low))
                    }
                    SkeletonHeight::Winding => yarn.hit_tube(&ray, part),
                    SkeletonHeight::Paper => yarn.hit_height_field(&ray, part),
                };
                nearest = hit.or(nearest);
            }
        }
        nearest
    }

    /// A yarn met where it is cut: at the sheet's border, the only place where a ray can come to be inside one. (A ray
    /// that starts inside meets the yarn there, too, and goes nowhere.) `ray` is relative to the cell.
    fn cut_end(&self, ray: &Ray, t: f64) -> SkeletonHit {
        let point = ray.at(t);
        let normal = if point.x.abs() * self.pitch.y > point.y.abs() * self.pitch.x {
            DVec3::X * point.x.signum()
        } else {
            DVec3::Y * point.y.signum()
        };
        SkeletonHit {
            t,
            normal,
            along: DVec3::ZERO,
        }
    }
}

impl Yarn {
    /// The part of `interval` in which the ray is over or under the yarn's strip, within `height` of the sheet, both
    /// taken `room` times as wide.
    fn clip(&self, ray: &Ray, interval: Interval, height: f64, room: f64) -> Interval {
        let (radius, height) = (self.radius * room, height * room);
        let strip = Interval::new(self.centre - radius, self.centre + radius);
        interval
            .clip_linear(ray.origin[self.across], ray.direction[self.across], strip)
            .clip_linear(
                ray.origin.z,
                ray.direction.z,
                Interval::new(-height, height),
            )
    }

    /// A point's place across from the centre line, along from the cell's centre, and its height.
    fn place(&self, point: DVec3) -> (f64, f64, f64) {
        let (across, along, z) = self.axes(point);
        (across - self.centre, along, z)
    }

    /// A vector's components across the yarn, along it, and up.
    fn axes(&self, v: DVec3) -> (f64, f64, f64) {
        match self.across {
            0 => (v.x, v.y, v.z),
            _ => (v.y, v.x, v.z),
        }
    }

    /// s and ds/d`along`.
    fn wave(&self, along: f64) -> (f64, f64) {
        let [before, here, after] = self.over;
        let (other, sign) = if along < 0.0 {
            (before, -1.0)
        } else {
            (after, 1.0)
        };
        if other == here {
            return (here, 0.0);
        }
        // s = ½(s_j + s_k) + ½(s_j − s_k)·cos(π·distance/pitch), whose first term is 0 for s_k = −s_j.
        let (sine, cosine) = (PI * along.abs() / self.pitch).sin_cos();
        (here * cosine, -sign * here * sine * PI / self.pitch)
    }

    /// Signed distance from the tube measured in the plane across the yarn; negative inside.
    fn distance(&self, point: DVec3) -> f64 {
        let (across, along, z) = self.place(point);
        let above = z - self.crimp * self.wave(along).0;
        (across * across + above * above).sqrt() - self.radius
    }

    fn hit_tube(&self, ray: &Ray, part: Interval) -> Option<SkeletonHit> {
        let distance = |t: f64| self.distance(ray.at(t));
        let steepest = if self.over == [self.over[0]; 3] {
            0.0
        } else {
            self.crimp * PI / self.pitch
        };
        // The distance's gradient is (x, above − H·s′)/√(x² + above²): along the ray it grows at most this fast.
        let (across, along, up) = self.axes(ray.direction);
        let fastest = across.hypot(up.abs() + steepest * along.abs());
        let shrink = 1.0 / fastest;
        let smallest = SMALLEST_STEP * self.radius;
        let mut t = part.low;
        let mut gap = distance(t);
        while gap > 0.0 {
            let before = t;
            if before >= part.high {
                return None;
            }
            t = (t + (gap * shrink).max(smallest)).min(part.high);
            gap = distance(t);
            if gap <= 0.0 {
                t = crossing(before, t, distance);
                break;
            }
        }
        let (across, along, z) = self.place(ray.at(t));
        let (s, slope) = self.wave(along);
        let above = z - self.crimp * s;
        let normal = [across, -self.crimp * slope * above, above];
        Some(self.hit_at(ray, t, normal, self.crimp * slope))
    }

    /// Height of the point over the paper's height field A·s.
    fn over_height_field(&self, point: DVec3) -> f64 {
        let (across, along, z) = self.place(point);
        z - (self.radius.powi(2) - across.powi(2)).max(0.0).sqrt() * self.wave(along).0
    }

    fn hit_height_field(&self, ray: &Ray, part: Interval) -> Option<SkeletonHit> {
        let above = |t: f64| self.over_height_field(ray.at(t));
        let step = part.length() / f64::from(PAPER_STEPS);
        let starts_above = above(part.low) > 0.0;
        let crossed = (1..=PAPER_STEPS)
            .map(|k| part.low + f64::from(k) * step)
            .find(|&t| (above(t) > 0.0) != starts_above)?;
        let side = if starts_above { 1.0 } else { -1.0 };
        let t = crossing(crossed - step, crossed, |t| side * above(t));
        let (across, along, _) = self.place(ray.at(t));
        let (s, slope) = self.wave(along);
        let squared = (self.radius.powi(2) - across.powi(2)).max(0.0);
        // The gradient of z − A·s, times A to stay finite at the strip's edge.
        let normal = [across * s, -squared * slope, squared.sqrt()];
        Some(self.hit_at(ray, t, normal, squared.sqrt() * slope))
    }

    /// A hit at `t` with a normal given across the yarn, along it, and up, where the surface rises by `rise` along the
    /// yarn.
    fn hit_at(&self, ray: &Ray, t: f64, [across, along, up]: [f64; 3], rise: f64) -> SkeletonHit {
        let mut normal = DVec3::new(0.0, 0.0, up);
        normal[self.across] = across;
        normal[1 - self.across] = along;
        let mut thread = DVec3::new(0.0, 0.0, rise);
        thread[1 - self.across] = 1.0;
        let normal = normal.normalize_or(-ray.direction);
        SkeletonHit {
            t,
            normal: if normal.dot(ray.direction) > 0.0 {
                -normal
            } else {
                normal
            },
            along: thread.normalize_or(DVec3::Z),
        }
    }
}

/// The place between `low` and `high` where `f` falls through zero, on the side where it is positive.
///
/// False position in the Illinois variant: an end that stays twice counts half, so that both ends close in. Smooth
/// crossings take five evaluations; what has not closed after fifty is halved to the end.
fn crossing(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut at_low, mut at_high) = (f(low), f(high));
    let mut last_moved_low = None;
    for round in 0..100 {
        if high - low <= PRECISION_MM {
            break;
        }
        let guess = low + at_low / (at_low - at_high) * (high - low);
        // A guess on an end, where f is zero or nearly, would move nothing.
        let t = if round < 50 && low < guess && guess < high {
            guess
        } else {
            0.5 * (low + high)
        };
        let value = f(t);
        if value > 0.0 {
            if value < PRECISION_MM {
                return t;
            }
            if last_moved_low == Some(true) {
                at_high *= 0.5;
            }
            (low, at_low, last_moved_low) = (t, value, Some(true));
        } else {
            if last_moved_low == Some(false) {
                at_low *= 0.5;
            }
            (high, at_high, last_moved_low) = (t, value, Some(false));
        }
    }
    low
}
