//! The ground weave (MODEL.md §7) in f32: where a ray meets a yarn, and whether it does.
//!
//! Space: relative to a cell's centre, mm. Yarns lie in a thin layer about the sheet, so a ray looks at the few cells
//! that it passes inside that layer, and at nothing where it stays above or below.
//!
//! - `winding`: the round tube x² + (z − H·s(y))² = R², x across and y along the yarn, met from outside by steps that
//!   cannot pass it. Over its own cell a yarn stays on one side of the sheet: its heights there bound the ray first.
//! - `paper`: the thin height field z = A·s of equations 1 and 2, by fixed steps over the yarn's strip.

use std::f32::consts::PI;

use glam::{DVec3, Vec3A};

use super::patch::Span;
use super::walk::Grid;
use crate::design::SkeletonHeight;
use crate::geometry::Ray;
use crate::geometry::tolerances::{self, PAPER_STEPS};
use crate::scene::{SheetGeometry, Skeleton};

const ROOMY: f32 = tolerances::ROOMY as f32;
/// Width to which a crossing is refined, mm: what f32 resolves within a cell.
const PRECISION_MM: f32 = 2e-7;
/// Steps towards a tube; five are common. A ray that needs more runs along it and has not come to it.
const MOST_STEPS: u32 = 64;

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
    /// π over the distance between crossings of a warp, then of a weft, 1/mm.
    wave_numbers: [f32; 2],
    repeat: [i32; 2],
    /// For each cell of the repeat, row by row, s of its warp and of its weft at the crossing before, here, and after.
    over: Vec<[[f32; 3]; 2]>,
    /// Warps and wefts of the sheet.
    cells: [i64; 2],
    /// How many places away a yarn can stand and still reach into a cell.
    reach: [i64; 2],
    /// Greatest height of any yarn above or below the sheet, and a little more, mm.
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
            wave_numbers: [PI / pitch[1], PI / pitch[0]],
            repeat: skeleton.repeat.map(|cells| cells as i32),
            over: over_and_under(skeleton),
            cells: [sheet.warps, sheet.wefts].map(i64::from),
            // Yarns k places away reach into the cell while k·pitch − radius < ½ pitch.
            reach: [0, 1].map(|set| (radius[set] / pitch[set] - 0.5).ceil().max(0.0) as i64),
            height: f64::from(height * ROOMY),
        }
    }

    /// The nearest meeting of a ray with a yarn in a part of it within [`Self::height`] of the sheet, mm along it.
    pub fn hit(&self, grid: &Grid, ray: &Ray, part: [f64; 2]) -> Option<GroundHit> {
        let direction = ray.direction.as_vec3a();
        for span in grid.cells(ray, part) {
            let point = (ray.at(span.enter) - grid.cell_centre(span.square)).as_vec3a();
            let length = (span.leave - span.enter) as f32;
            if let Some(hit) = self.nearest(span.square, point, direction, length) {
                return Some(GroundHit {
                    t: span.enter + f64::from(hit.t),
                    normal: hit.normal.as_dvec3(),
                    along: hit.along.as_dvec3(),
                });
            }
        }
        None
    }

    /// The nearest meeting in a cell of a ray that is at `point` where it enters, and leaves after `length`.
    #[inline(always)]
    fn nearest(
        &self,
        cell: [i64; 2],
        point: Vec3A,
        direction: Vec3A,
        length: f32,
    ) -> Option<Local> {
        let mut nearest: Option<Local> = None;
        let here = self.in_repeat(cell);
        for set in 0..2 {
            // Not an inclusive range: those cost a flag in each round.
            let mut offset = -self.reach[set] - 1;
            while offset < self.reach[set] {
                offset += 1;
                let place = cell[set] + offset;
                if offset != 0 && (place < 0 || place >= self.cells[set]) {
                    continue;
                }
                let index = if offset == 0 {
                    here
                } else {
                    let mut neighbour = cell;
                    neighbour[set] = place;
                    self.in_repeat(neighbour)
                };
                let yarn = self.yarn(set, index, offset);
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
                        let start = point + direction * part.low;
                        if yarn.is_inside(start) {
                            Some(self.cut_end(start, part.low))
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

    /// A yarn met where it is cut, at the sheet's border: the only place where a ray can come to be inside one. (A ray
    /// that starts inside meets the yarn there, too, and goes nowhere.)
    #[inline(always)]
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

    /// The yarn `offset` places beside the one through the centre of a cell; set 0 is the warps. `index` is the place
    /// of that yarn's cell in the repeat.
    #[inline(always)]
    fn yarn(&self, set: usize, index: usize, offset: i64) -> Yarn {
        Yarn {
            across: set,
            centre: offset as f32 * self.pitch[set],
            radius: self.radius[set],
            crimp: self.crimp,
            wave_number: self.wave_numbers[set],
            over: self.over[index][set],
        }
    }

    /// Place of a cell in the repeat. Cells are fewer than 2³¹, and dividing smaller numbers is quicker.
    #[inline(always)]
    fn in_repeat(&self, [i, j]: [i64; 2]) -> usize {
        let [columns, rows] = self.repeat;
        let (i, j) = ((i as i32).rem_euclid(columns), (j as i32).rem_euclid(rows));
        (j * columns + i) as usize
    }
}

/// For each cell of the repeat s of its warp and of its weft, +1 over and −1 under, at the crossing before, here, and
/// after.
fn over_and_under(skeleton: &Skeleton) -> Vec<[[f32; 3]; 2]> {
    let [columns, rows] = skeleton.repeat.map(|cells| cells as usize);
    let warp = |i: usize, j: usize| {
        if skeleton.warp_over[j % rows * columns + i % columns] {
            1.0
        } else {
            -1.0
        }
    };
    (0..columns * rows)
        .map(|index| {
            let (i, j) = (index % columns, index / columns);
            let steps = |count: usize| [count - 1, 0, 1];
            [
                steps(rows).map(|step| warp(i, j + step)),
                steps(columns).map(|step| -warp(i + step, j)),
            ]
        })
        .collect()
}

impl Yarn {
    /// The part of `span` in which the ray is over or under the yarn's strip and within its heights in this cell.
    #[inline(always)]
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
        // Outwards from both: of a yarn that stays above the sheet, both are above it.
        let slack = rise.abs() * (room - 1.0);
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
        .clip(
            point.z,
            direction.z,
            low - slack - reach,
            high + slack + reach,
        )
    }

    /// A point's place across from the centre line, along from the cell's centre, and its height.
    #[inline(always)]
    fn place(&self, point: Vec3A) -> (f32, f32, f32) {
        let (across, along) = self.axes(point);
        (across - self.centre, along, point.z)
    }

    /// A vector's components across the yarn and along it.
    #[inline(always)]
    fn axes(&self, v: Vec3A) -> (f32, f32) {
        match self.across {
            0 => (v.x, v.y),
            _ => (v.y, v.x),
        }
    }

    /// s at a place within half a pitch of the cell's crossing.
    #[inline(always)]
    fn wave(&self, along: f32) -> f32 {
        self.wave_and_slope(along).0
    }

    /// s and ds/d`along`.
    #[inline(always)]
    fn wave_and_slope(&self, along: f32) -> (f32, f32) {
        let [before, here, after] = self.over;
        let other = if along < 0.0 { before } else { after };
        if other == here {
            return (here, 0.0);
        }
        // s = ½(s_j + s_k) + ½(s_j − s_k)·cos(π·distance/pitch), whose first term is 0 for s_k = −s_j.
        let (sine, cosine) = sine_and_cosine(self.wave_number * along);
        (here * cosine, -here * self.wave_number * sine)
    }

    /// Whether a point is in the tube.
    #[inline(always)]
    fn is_inside(&self, point: Vec3A) -> bool {
        let (across, along, z) = self.place(point);
        let above = z - self.crimp * self.wave(along);
        across * across + above * above <= self.radius * self.radius
    }

    /// The first crossing with the tube of a ray that is outside it at the beginning of `part`.
    ///
    /// With a = z − H·s(y), the tube is where g(t) = x² + a² − R² vanishes. Since g″ = 2(x′² + a′² − a·H·s″·y′²) is
    /// nowhere below −M, M = 2(2H + R)·H·k²·y′², g stays above g + g′δ − ½Mδ² over a step δ: the step to where that
    /// vanishes never passes the first crossing, and where the tube bends little it is Newton's.
    #[inline(always)]
    fn hit_tube(&self, point: Vec3A, direction: Vec3A, part: Span) -> Option<Local> {
        let (x_slope, y_slope) = self.axes(direction);
        let (x_start, y_start) = self.axes(point);
        let crimp = self.crimp.abs();
        let bend =
            2.0 * (2.0 * crimp + self.radius) * crimp * (self.wave_number * y_slope).powi(2) + 1e-6;
        let mut t = part.low;
        for _ in 0..MOST_STEPS {
            let x = x_start - self.centre + x_slope * t;
            let (s, s_slope) = self.wave_and_slope(y_start + y_slope * t);
            let above = point.z + direction.z * t - self.crimp * s;
            let rise = self.crimp * s_slope;
            let gap = x * x + above * above - self.radius * self.radius;
            let gap_slope = 2.0 * (x * x_slope + above * (direction.z - rise * y_slope));
            let step = if gap > 0.0 {
                let root = (gap_slope * gap_slope + 2.0 * bend * gap).sqrt();
                // The same number, without cancellation.
                if gap_slope < 0.0 {
                    2.0 * gap / (root - gap_slope)
                } else {
                    (gap_slope + root) / bend
                }
            } else {
                0.0
            };
            if step < PRECISION_MM {
                return Some(self.local(direction, t, [x, -rise * above, above], rise));
            }
            t += step;
            if t > part.high {
                return None;
            }
        }
        None
    }

    #[inline(always)]
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
        let (s, slope) = self.wave_and_slope(along);
        // The gradient of z − A·s, times A to stay finite at the strip's edge.
        let normal = [across * s, -squared * slope, squared.sqrt()];
        Some(self.local(direction, t, normal, squared.sqrt() * slope))
    }

    /// A hit with a normal given across the yarn, along it, and up, where the surface rises by `rise` along the yarn.
    #[inline(always)]
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

/// sin x and cos x for |x| ≤ ½π or a little more, to 5·10⁻⁷: their series up to x¹¹ and x¹⁰.
#[inline(always)]
fn sine_and_cosine(x: f32) -> (f32, f32) {
    let y = x * x;
    let cosine = 1.0
        + y * (-0.5
            + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0 - y / 3_628_800.0))));
    let sine = x
        * (1.0
            + y * (-1.0 / 6.0
                + y * (1.0 / 120.0
                    + y * (-1.0 / 5_040.0 + y * (1.0 / 362_880.0 - y / 39_916_800.0)))));
    (sine, cosine)
}

/// The place where `f` falls through zero between a place where it is positive and one where it is not, on the positive
/// side.
///
/// False position in the Illinois variant: an end that stays twice counts half, so that both ends close in.
#[inline(always)]
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
