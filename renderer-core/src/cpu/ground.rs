//! The ground weave (MODEL.md §7) in f32: where a ray meets a yarn, and whether it does.
//!
//! Space: relative to a cell's centre, mm. Yarns lie in a thin layer about the sheet, so a ray looks at the few cells that
//! it passes inside that layer, and at nothing where it stays above or below.
//!
//! - `winding`: the round tube x² + (z − H·s(y))² = R², x across and y along the yarn, met from outside by steps that the
//!   distance to the tube allows. Over its own cell a yarn stays on one side of the sheet: its heights there bound the ray first.
//! - `paper`: the thin height field z = A·s of equations 1 and 2, by fixed steps over the yarn's strip.

use std::f32::consts::PI;

use glam::{DVec3, Vec3A};

use super::patch::Span;
use super::walk::Grid;
use crate::design::SkeletonHeight;
use crate::geometry::Ray;
use crate::scene::{SheetGeometry, Skeleton};

/// Width to which a crossing is refined, mm: what f32 resolves within a cell.
const PRECISION_MM: f32 = 2e-7;
/// Steps over a strip of the paper's height field.
const PAPER_STEPS: u32 = 16;
/// Smallest step towards a tube, in its radii: a chord shorter than this may be missed.
const SMALLEST_STEP: f32 = 1.0 / 64.0;
/// Bounds of a tube are this much too wide: where they only just touch it, rounding would put their edge inside.
const ROOMY: f32 = 1.001;

/// Where a ray meets the ground weave.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroundHit {
    /// Distance along the ray, mm.
    pub t: f64,
    /// Unit normal, turned against the ray.
    pub normal: DVec3,
    /// Unit vector along the yarn on its surface; zero on a cut end.
    pub along: DVec3,
}

/// All yarns of the ground weave.
#[derive(Debug)]
pub(super) struct Ground {
    pitch: [f32; 2],
    /// Radius of the warps, then of the wefts, mm.
    radius: [f32; 2],
    /// H, mm.
    crimp: f32,
    form: SkeletonHeight,
    repeat: [i64; 2],
    warp_over: Vec<bool>,
    /// Warps and wefts of the sheet.
    cells: [i64; 2],
    /// How many places away a yarn can stand and still reach into a cell.
    reach: [i64; 2],
    /// Greatest height of any yarn above or below the sheet, mm.
    pub height: f64,
}

/// One yarn as seen from one cell, in its own axes: across it, along it, z.
#[derive(Debug, Clone, Copy)]
struct Yarn {
    /// Which coordinate runs across it: 0 for warps, 1 for wefts.
    across: usize,
    /// Its centre line's place across, relative to the cell's centre.
    centre: f32,
    radius: f32,
    crimp: f32,
    /// π over the distance between its crossings, 1/mm.
    wave_number: f32,
    /// s at the crossing before this cell's, at this cell's, and at the next.
    over: [f32; 3],
}

/// A crossing in a cell.
struct Local {
    t: f32,
    normal: Vec3A,
    along: Vec3A,
}

impl Ground {
    pub fn new(sheet: &SheetGeometry, skeleton: &Skeleton) -> Self {
        let pitch = [sheet.pitch_x_mm as f32, sheet.pitch_y_mm as f32];
        let radius = [skeleton.warp_radius_mm, skeleton.weft_radius_mm];
        let highest = radius[0].max(radius[1]);
        let height = match skeleton.height {
            SkeletonHeight::Winding => skeleton.crimp_mm + highest,
            SkeletonHeight::Paper => highest,
        };
        Self {
            pitch,
            radius,
            crimp: skeleton.crimp_mm,
            form: skeleton.height,
            repeat: skeleton.repeat.map(i64::from),
            warp_over: skeleton.warp_over.clone(),
            cells: [sheet.warps, sheet.wefts].map(i64::from),
            // Yarns k places away reach into the cell while k·pitch − radius < ½ pitch.
            reach: [0, 1].map(|set| (radius[set] / pitch[set] - 0.5).ceil().max(0.0) as i64),
            height: f64::from(height),
        }
    }

    /// The nearest meeting of a ray with a yarn in its part from `from` to `to`, mm along it.
    pub fn hit(&self, grid: &Grid, ray: &Ray, from: f64, to: f64) -> Option<GroundHit> {
        let height = self.height * f64::from(ROOMY);
        let part = grid.clip_heights(ray, from, to, [-height, height]);
        let direction = ray.direction.as_vec3a();
        grid.cells(ray, part)
            .filter(|span| (0..2).all(|axis| (0..self.cells[axis]).contains(&span.square[axis])))
            .find_map(|span| {
                let point = (ray.at(span.enter) - grid.cell_centre(span.square)).as_vec3a();
                let length = (span.leave - span.enter) as f32;
                let hit = self.nearest(span.square, point, direction, length)?;
                Some(GroundHit {
                    t: span.enter + f64::from(hit.t),
                    normal: hit.normal.as_dvec3(),
                    along: hit.along.as_dvec3(),
                })
            })
    }

    /// The nearest meeting in a cell of a ray that is at `point` where it enters, and leaves after `length`.
    fn nearest(
        &self,
        cell: [i64; 2],
        point: Vec3A,
        direction: Vec3A,
        length: f32,
    ) -> Option<Local> {
        let mut nearest: Option<Local> = None;
        for set in 0..2 {
            for offset in -self.reach[set]..=self.reach[set] {
                if !(0..self.cells[set]).contains(&(cell[set] + offset)) {
                    continue;
                }
                let yarn = self.yarn(set, cell, offset);
                let part = Span {
                    low: 0.0,
                    high: nearest.as_ref().map_or(length, |hit| hit.t),
                };
                let part = yarn.clip(self.form, point, direction, part);
                if part.is_empty() {
                    continue;
                }
                let hit = match self.form {
                    SkeletonHeight::Winding => {
                        if yarn.distance(point + direction * part.low) <= 0.0 {
                            Some(self.cut_end(point + direction * part.low, part.low))
                        } else {
                            yarn.hit_tube(point, direction, part)
                        }
                    }
                    SkeletonHeight::Paper => yarn.hit_height_field(point, direction, part),
                };
                nearest = hit.or(nearest);
            }
        }
        nearest
    }

    /// A yarn met where it is cut, at the sheet's border: the only place where a ray can come to be inside one. (A ray that
    /// starts inside meets the yarn there, too, and goes nowhere.)
    fn cut_end(&self, point: Vec3A, t: f32) -> Local {
        let normal = if point.x.abs() * self.pitch[1] > point.y.abs() * self.pitch[0] {
            Vec3A::X * point.x.signum()
        } else {
            Vec3A::Y * point.y.signum()
        };
        Local {
            t,
            normal,
            along: Vec3A::ZERO,
        }
    }

    /// +1 where the warp lies over the weft at crossing (i, j), else −1; the pattern repeats beyond the sheet.
    fn over(&self, i: i64, j: i64) -> f32 {
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
            centre: offset as f32 * self.pitch[set],
            radius: self.radius[set],
            crimp: self.crimp,
            wave_number: PI / self.pitch[1 - set],
            over,
        }
    }
}

impl Yarn {
    /// The part of `span` in which the ray is over or under the yarn's strip and within its heights in this cell.
    fn clip(&self, form: SkeletonHeight, point: Vec3A, direction: Vec3A, span: Span) -> Span {
        let room = match form {
            SkeletonHeight::Winding => ROOMY,
            SkeletonHeight::Paper => 1.0,
        };
        let reach = self.radius * room;
        let rise = match form {
            SkeletonHeight::Winding => self.crimp * self.over[1],
            SkeletonHeight::Paper => 0.0,
        };
        let level = self.over == [self.over[1]; 3];
        let (low, high) = if level && form == SkeletonHeight::Winding {
            (rise, rise)
        } else {
            (rise.min(0.0), rise.max(0.0))
        };
        span.clip(
            point[self.across] - self.centre,
            direction[self.across],
            -reach,
            reach,
        )
        .clip(point.z, direction.z, low * room - reach, high * room + reach)
    }

    /// A point's place across from the centre line, along from the cell's centre, and its height.
    fn place(&self, point: Vec3A) -> (f32, f32, f32) {
        let (across, along) = self.axes(point);
        (across - self.centre, along, point.z)
    }

    /// A vector's components across the yarn and along it.
    fn axes(&self, v: Vec3A) -> (f32, f32) {
        match self.across {
            0 => (v.x, v.y),
            _ => (v.y, v.x),
        }
    }

    /// s at a place within half a pitch of the cell's crossing.
    fn wave(&self, along: f32) -> f32 {
        let [before, here, after] = self.over;
        let other = if along < 0.0 { before } else { after };
        if other == here {
            here
        } else {
            // s = ½(s_j + s_k) + ½(s_j − s_k)·cos(π·distance/pitch), whose first term is 0 for s_k = −s_j.
            here * cosine(self.wave_number * along)
        }
    }

    /// ds/d`along`.
    fn slope(&self, along: f32) -> f32 {
        let [before, here, after] = self.over;
        let other = if along < 0.0 { before } else { after };
        if other == here {
            0.0
        } else {
            -here * self.wave_number * (self.wave_number * along).sin()
        }
    }

    /// Distance from the tube's axis, in the plane across the yarn, less its radius; negative inside.
    fn distance(&self, point: Vec3A) -> f32 {
        let (across, along, z) = self.place(point);
        let above = z - self.crimp * self.wave(along);
        (across * across + above * above).sqrt() - self.radius
    }

    fn hit_tube(&self, point: Vec3A, direction: Vec3A, part: Span) -> Option<Local> {
        let distance = |t: f32| self.distance(point + direction * t);
        let steepest = if self.over == [self.over[1]; 3] {
            0.0
        } else {
            self.crimp * self.wave_number
        };
        // The distance's gradient is (x, above − H·s′)/√(x² + above²): along the ray it grows at most this fast.
        let (across, along) = self.axes(direction);
        let up = direction.z.abs() + steepest * along.abs();
        let shrink = 1.0 / (across * across + up * up).sqrt();
        let smallest = SMALLEST_STEP * self.radius;
        let mut t = part.low;
        let mut gap = distance(t);
        while gap > 0.0 {
            let before = (t, gap);
            if t >= part.high {
                return None;
            }
            t = (t + (gap * shrink).max(smallest)).min(part.high);
            gap = distance(t);
            if gap <= 0.0 {
                t = crossing(before, (t, gap), distance);
                break;
            }
        }
        let (across, along, z) = self.place(point + direction * t);
        let slope = self.crimp * self.slope(along);
        let above = z - self.crimp * self.wave(along);
        Some(self.local(direction, t, [across, -slope * above, above], slope))
    }

    fn hit_height_field(&self, point: Vec3A, direction: Vec3A, part: Span) -> Option<Local> {
        // Height of the point over the paper's height field A·s.
        let above = |t: f32| {
            let (across, along, z) = self.place(point + direction * t);
            let half_height = (self.radius.powi(2) - across.powi(2)).max(0.0).sqrt();
            z - half_height * self.wave(along)
        };
        let step = part.length() / PAPER_STEPS as f32;
        let start = above(part.low);
        let side = if start > 0.0 { 1.0 } else { -1.0 };
        let at = |k: u32| part.low + k as f32 * step;
        let crossed = (1..=PAPER_STEPS).find(|&k| (above(at(k)) > 0.0) != (start > 0.0))?;
        let signed = |t: f32| side * above(t);
        let ends = [at(crossed - 1), at(crossed)].map(|t| (t, signed(t)));
        let t = crossing(ends[0], ends[1], signed);
        let (across, along, _) = self.place(point + direction * t);
        let squared = (self.radius.powi(2) - across.powi(2)).max(0.0);
        let slope = self.slope(along);
        // The gradient of z − A·s, times A to stay finite at the strip's edge.
        let normal = [across * self.wave(along), -squared * slope, squared.sqrt()];
        Some(self.local(direction, t, normal, squared.sqrt() * slope))
    }

    /// A hit with a normal given across the yarn, along it, and up, where the surface rises by `rise` along the yarn.
    fn local(&self, direction: Vec3A, t: f32, [across, along, up]: [f32; 3], rise: f32) -> Local {
        let turned = |across: f32, along: f32, up: f32| match self.across {
            0 => Vec3A::new(across, along, up),
            _ => Vec3A::new(along, across, up),
        };
        let normal = turned(across, along, up).normalize_or(-direction);
        Local {
            t,
            normal: if normal.dot(direction) > 0.0 {
                -normal
            } else {
                normal
            },
            along: turned(0.0, 1.0, rise).normalize_or_zero(),
        }
    }
}

/// cos x for |x| ≤ ½π or a little more, to 5·10⁻⁷: its series up to x¹⁰.
fn cosine(x: f32) -> f32 {
    let y = x * x;
    1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0 - y / 3_628_800.0))))
}

/// The place where `f` falls through zero between a place where it is positive and one where it is not, on the positive side.
///
/// False position in the Illinois variant: an end that stays twice counts half, so that both ends close in.
fn crossing(
    (mut low, mut at_low): (f32, f32),
    (mut high, mut at_high): (f32, f32),
    f: impl Fn(f32) -> f32,
) -> f32 {
    let mut last_moved_low = None;
    for _ in 0..40 {
        if high - low <= PRECISION_MM {
            break;
        }
        let guess = low + at_low / (at_low - at_high) * (high - low);
        // A guess on an end, where f is zero or nearly, would move nothing.
        let t = if low < guess && guess < high {
            guess
        } else {
            0.5 * (low + high)
        };
        if t <= low || t >= high {
            break;
        }
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
