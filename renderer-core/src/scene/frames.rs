//! Yarn-loop frames: one bilinear patch a loop (MODEL.md §4; the paper's §4.2, figures 6 and 7). Computed in f64,
//! in mm relative to the loop's own cell, as f32 [`LoopPatch`], which the grid stores as [`super::LoopShape`].
//!
//! What the paper leaves open is bounded here: leans stop at 1.3 rad, top corners stay above the sheet, patches stay
//! convex seen along their normal, and degenerate ones are dropped. [`LoopCounts`] tells how often.

use glam::DVec3;

use super::finish::{Finishing, LoopFinish, wet_pile};
use super::skeleton::Face;
use super::{LoopCounts, LoopPatch};
use crate::design::{Design, LengthEntry, Pile};
use crate::sampling::{hash_with, unit_float};

/// Steepest lean, radians.
pub const MAX_LEAN: f64 = 1.3;
/// Largest twist to either side, radians.
pub const MAX_TWIST: f64 = 2.5;
/// Largest |α| + |β| of a patch; at 2 it stops being convex seen along its normal.
pub const MAX_SKEW: f64 = 1.8;
/// Largest |α| + |β| of a patch that was rounded to whole units of length: still short of 2.
const ROUNDED_SKEW: f64 = 1.9;
/// A patch is degenerate when |b × c| is below this share of w₀·L.
const DEGENERATE: f64 = 1e-3;
/// Loops shorter than this, mm, are no loops: the thinnest yarn has ten times this diameter.
const SHORTEST_MM: f64 = 1e-3;
/// Halvings in searches; 2⁻³⁰ of a radian or of a ratio is below f32 rounding of the shape.
const HALVINGS: u32 = 30;

/// What all loops have in common: lengths in mm, angles in radians.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameSettings {
    /// w₀: width of the patch at its root.
    pub base_width: f64,
    /// r: width at the top over width at the root.
    pub top_ratio: f64,
    /// h: thickness along the normal.
    pub thickness: f64,
    /// Longest loop.
    pub max_length: f64,
    /// Lean of all loops along X and Y.
    pub lean: [f64; 2],
    /// Lean at turbulence 1.
    pub tilt: f64,
    /// Twist at turbulence 1.
    pub twist: f64,
    /// Change of length at turbulence 1, a share.
    pub stretch: f64,
    /// Largest independent lean, twist and change of length.
    pub jitter: [f64; 3],
}

impl FrameSettings {
    /// The settings of a pile.
    pub fn new(pile: &Pile) -> Self {
        Self {
            base_width: pile.base_width,
            top_ratio: pile.top_width / pile.base_width,
            thickness: pile.thickness,
            max_length: pile.max_length,
            lean: [pile.lean_x.to_radians(), pile.lean_y.to_radians()],
            tilt: pile.tilt.to_radians(),
            twist: pile.twist.to_radians(),
            stretch: pile.stretch,
            jitter: [
                pile.jitter.to_radians(),
                pile.twist_jitter.to_radians(),
                pile.length_jitter,
            ],
        }
    }
}

impl FrameSettings {
    /// The longest that loops get whose lengths from the chart are at most `chart_mm`.
    fn longest_mm(&self, chart_mm: f64) -> f64 {
        let [.., length_jitter] = self.jitter;
        (chart_mm * (1.0 + self.stretch + length_jitter)).min(self.max_length)
    }

    /// The longest that half the top edge gets where the heights of roots differ by at most `step_mm`: ratios of the
    /// top's width to the root's are moved towards 1 where they are.
    pub(super) fn half_top_mm(&self, step_mm: f64) -> f64 {
        0.5 * self.top_ratio.max(1.0) * self.base_width.hypot(step_mm)
    }
}

/// The settings of a design's loops: of the pile, or of each row of the length table where rows have their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FrameRules(Vec<FrameSettings>);

impl FrameRules {
    pub(super) fn new(design: &Design) -> Self {
        let (pile, rows) = (&design.pile, design.length.rows());
        let settings = |pile: &Pile| FrameSettings::new(&wet_pile(pile, design.finish.wetness));
        if rows.iter().any(LengthEntry::has_own_frame) {
            let of_row = |row: &LengthEntry| settings(&row.of_pile(pile));
            Self(rows.iter().map(of_row).collect())
        } else {
            Self(vec![settings(pile)])
        }
    }

    /// Settings of a row, 0 where rows have none of their own.
    pub(super) fn of_row(&self, row: usize) -> &FrameSettings {
        &self.0[row]
    }

    /// Settings of all rows.
    pub(super) fn all(&self) -> &[FrameSettings] {
        &self.0
    }

    /// What is the same in all rows: width at the root, thickness, and all that turbulence and chance do but tilt.
    pub(super) fn common(&self) -> &FrameSettings {
        &self.0[0]
    }

    /// The longest that loops get whose lengths from the chart are at most `chart_mm`, mm.
    pub(super) fn longest_mm(&self, chart_mm: f64, finishing: &Finishing) -> f64 {
        let common = self.common();
        (common.longest_mm(chart_mm) + finishing.longer_mm()).min(common.max_length)
    }

    /// The longest that half the top edge of any loop gets: [`FrameSettings::half_top_mm`].
    pub(super) fn half_top_mm(&self, step_mm: f64) -> f64 {
        let rows = self.0.iter().map(|row| row.half_top_mm(step_mm));
        rows.fold(0.0, f64::max)
    }
}

/// What one loop has of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopInput {
    /// Which side it stands on.
    pub face: Face,
    /// Heights of P0 and P1 along the face's normal, mm.
    pub root_heights: [f64; 2],
    /// Length from the chart, mm.
    pub length: f64,
    /// The cell's turbulence: tilt x, tilt y, stretch, twist.
    pub turbulence: [f64; 4],
    /// Its independent random part.
    pub jitter: Jitter,
    /// What happens to it after weaving.
    pub finish: LoopFinish,
}

/// The independent random part of a loop, without strengths.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jitter {
    /// A point of the unit disc.
    pub lean: [f64; 2],
    /// In [−1, 1].
    pub twist: f64,
    /// In [−1, 1].
    pub length: f64,
}

impl Jitter {
    /// The jitter of a loop with this hash.
    pub fn new(loop_hash: u32) -> Self {
        let random = |k: u32| f64::from(unit_float(hash_with(loop_hash, k)));
        let (radius, angle) = (random(0).sqrt(), std::f64::consts::TAU * random(1));
        Self {
            lean: [radius * angle.cos(), radius * angle.sin()],
            twist: 2.0 * random(2) - 1.0,
            length: 2.0 * random(3) - 1.0,
        }
    }
}

/// The random number that belongs to the loop of a cell and face.
pub fn loop_hash(seed: u32, i: u32, j: u32, face: Face) -> u32 {
    let cell = hash_with(hash_with(seed, i), j);
    hash_with(cell, u32::from(face == Face::Back))
}

/// The patch of one loop; `None` where nothing is planted. Adds what it had to do to `counts`.
pub fn loop_shape(
    settings: &FrameSettings,
    input: &LoopInput,
    counts: &mut LoopCounts,
) -> Option<LoopPatch> {
    let [tilt_x, tilt_y, stretch, twist] = input.turbulence;
    let [lean_jitter, twist_jitter, length_jitter] = settings.jitter;
    let mut wanted_length =
        input.length * (1.0 + settings.stretch * stretch + length_jitter * input.jitter.length);
    let length = wanted_length.min(settings.max_length);
    if length < SHORTEST_MM {
        return None;
    }

    let drawn = lean_to(input.finish.drawn_mm, length);
    let lean: [f64; 2] = std::array::from_fn(|axis| {
        settings.lean[axis]
            + settings.tilt * [tilt_x, tilt_y][axis]
            + lean_jitter * input.jitter.lean[axis]
            + input.finish.lean[axis]
            + drawn[axis]
    });
    let twist =
        (settings.twist * twist + twist_jitter * input.jitter.twist).clamp(-MAX_TWIST, MAX_TWIST);

    let standing = |lean, length| {
        let (towards, angle) = direction_of(lean);
        let stance = Stance::new(settings.base_width, input, length, towards, twist);
        let (frame, lean_kept, ratio) = stance.stand(angle, settings.top_ratio);
        (stance, (frame, angle, lean_kept, ratio))
    };
    let (stance, mut stood) = standing(lean, length);
    let mut is_cut = false;
    match input
        .finish
        .shear_mm
        .map(|shear_mm| stance.shorn(&stood.0, shear_mm))
    {
        Some(Shorn::Away) => return None,
        Some(Shorn::At(cut)) => (stood.0, is_cut) = (cut, true),
        Some(Shorn::Not) | None if input.finish.pulled_mm > 0.0 => {
            wanted_length += input.finish.pulled_mm;
            let longer = wanted_length.min(settings.max_length);
            // As long a loop as lies on the pile with all its slack leans that far, and each some share of it its own
            // way.
            let limp = (length / longer).acos();
            let lean = [0, 1].map(|axis| lean[axis] + limp * input.jitter.lean[axis]);
            stood = standing(lean, longer).1;
        }
        _ => {}
    }
    let (frame, angle, lean_kept, ratio) = stood;
    let [b, c] = frame.edges();
    if (is_cut && frame.skew() > MAX_SKEW)
        || b.cross(c).length() < DEGENERATE * settings.base_width * c.length()
    {
        counts.dropped += 1;
        return None;
    }
    counts.planted += 1;
    counts.capped += u64::from(wanted_length > settings.max_length);
    counts.raised += u64::from(lean_kept < angle);
    counts.repaired += u64::from(ratio != settings.top_ratio);
    let sign = input.face.sign();
    let shape = LoopPatch {
        axis: frame.axis.as_vec3().into(),
        root_z0: (sign * input.root_heights[0]) as f32,
        half_top: frame.half_top.as_vec3().into(),
        root_z1: (sign * input.root_heights[1]) as f32,
    };
    debug_assert!(
        shape
            .axis
            .iter()
            .chain(&shape.half_top)
            .all(|x| x.is_finite()),
        "{input:?} gives {shape:?}"
    );
    Some(shape)
}

/// Direction in the sheet's plane and angle of a lean, which stops at [`MAX_LEAN`].
fn direction_of(lean: [f64; 2]) -> ([f64; 2], f64) {
    let amount = lean[0].hypot(lean[1]);
    if amount < 1e-6 {
        // The direction of so small a lean is rounding noise.
        ([0.0; 2], 0.0)
    } else {
        ([lean[0] / amount, lean[1] / amount], amount.min(MAX_LEAN))
    }
}

/// The lean that brings the tip of an upright loop as far as this, mm, or as far as it gets.
fn lean_to(way_mm: [f64; 2], length_mm: f64) -> [f64; 2] {
    let distance = way_mm[0].hypot(way_mm[1]);
    if distance == 0.0 {
        return [0.0; 2];
    }
    let angle = (distance / length_mm).min(1.0).asin();
    way_mm.map(|mm| mm / distance * angle)
}

/// What shears make of a loop.
enum Shorn {
    /// It does not reach them.
    Not,
    /// A tuft whose top is level, as far as it reached them.
    At(Frame),
    /// It is cut below its roots.
    Away,
}

/// A loop that stands on its roots; its lean and top ratio are still open.
struct Stance {
    normal: DVec3,
    /// P1 − P0.
    base_edge: DVec3,
    /// Height of the middle of the roots along the normal.
    root_height: f64,
    length: f64,
    /// Unit vector in the sheet's plane towards which the loop leans, or zero.
    towards: DVec3,
    /// Sine and cosine of the twist.
    twist: (f64, f64),
}

/// Axis and half top edge: what the roots do not fix.
#[derive(Clone, Copy)]
struct Frame {
    base_edge: DVec3,
    axis: DVec3,
    half_top: DVec3,
}

impl Stance {
    fn new(base_width: f64, input: &LoopInput, length: f64, [x, y]: [f64; 2], twist: f64) -> Self {
        let normal = DVec3::new(0.0, 0.0, input.face.sign());
        let [h0, h1] = input.root_heights;
        Self {
            normal,
            base_edge: DVec3::new(0.0, base_width, 0.0) + (h1 - h0) * normal,
            root_height: 0.5 * (h0 + h1),
            length,
            towards: DVec3::new(x, y, 0.0),
            twist: twist.sin_cos(),
        }
    }

    fn frame(&self, lean: f64, ratio: f64) -> Frame {
        let direction = self.normal * lean.cos() + self.towards * lean.sin();
        // Rodrigues' rotation of the whole base edge about the loop's own axis, right-handed.
        let (sin, cos) = self.twist;
        let edge = self.base_edge;
        let turned = edge * cos
            + direction.cross(edge) * sin
            + direction * (direction.dot(edge) * (1.0 - cos));
        Frame {
            base_edge: edge,
            axis: direction * self.length,
            half_top: turned * (0.5 * ratio),
        }
    }

    /// Height of the lower top corner above the sheet's plane, along the normal.
    fn clearance(&self, frame: &Frame) -> f64 {
        self.root_height + self.normal.dot(frame.axis) - self.normal.dot(frame.half_top).abs()
    }

    /// The frame with the greatest lean up to `lean` and the top ratio nearest to `ratio` whose corners are above the
    /// sheet and whose patch is convex; also the lean and the ratio. Upright loops stay whatever their corners do.
    fn stand(&self, lean: f64, ratio: f64) -> (Frame, f64, f64) {
        let frame = self.frame(lean, ratio);
        if self.clearance(&frame) > 0.0 && frame.skew() <= MAX_SKEW {
            return (frame, lean, ratio);
        }
        let (mut lean, mut ratio) = (lean, ratio);
        // A smaller lean changes the skew, and another ratio moves the corners; ratio 1 is convex at every lean.
        for attempt in 0..4 {
            lean = self.raised(lean, ratio);
            let repaired = self.repaired(lean, ratio);
            if repaired == ratio {
                return (self.frame(lean, ratio), lean, ratio);
            }
            ratio = if attempt < 3 { repaired } else { 1.0 };
        }
        lean = self.raised(lean, ratio);
        (self.frame(lean, ratio), lean, ratio)
    }

    /// What shears leave that cut at this height over the sheet's plane. The highest corner of what they reach is
    /// there.
    fn shorn(&self, frame: &Frame, height: f64) -> Shorn {
        let rise = self.normal.dot(frame.axis);
        let (top, over) = (self.root_height + rise, self.normal.dot(frame.half_top));
        if top + over.abs() <= height {
            return Shorn::Not;
        }
        let middle = top.min(height);
        if middle - self.root_height < SHORTEST_MM {
            return Shorn::Away;
        }
        let left = over.abs().min(height - middle).copysign(over);
        let mut cut = Frame {
            axis: frame.axis * ((middle - self.root_height) / rise),
            half_top: frame.half_top + (left - over) * self.normal,
            ..*frame
        };
        // A top that was turned steeply upwards lies askew when it is level: it is turned back as far as it must be.
        let level = 0.5 * (self.base_edge - self.normal.dot(self.base_edge) * self.normal)
            + left * self.normal;
        let turned = |share: f64| Frame {
            half_top: level + share * (cut.half_top - level),
            ..cut
        };
        if cut.skew() > MAX_SKEW {
            cut = turned(last_good(0.0, 1.0, |share| {
                turned(share).skew() <= MAX_SKEW
            }));
        }
        Shorn::At(cut)
    }

    fn raised(&self, lean: f64, ratio: f64) -> f64 {
        let clears = |lean: f64| self.clearance(&self.frame(lean, ratio)) > 0.0;
        if clears(lean) {
            lean
        } else {
            last_good(0.0, lean, clears)
        }
    }

    fn repaired(&self, lean: f64, ratio: f64) -> f64 {
        let convex = |ratio: f64| self.frame(lean, ratio).skew() <= MAX_SKEW;
        if convex(ratio) {
            ratio
        } else {
            last_good(1.0, ratio, convex)
        }
    }
}

impl Frame {
    /// b = ∂P/∂u and c = ∂P/∂v in the middle of the patch.
    fn edges(&self) -> [DVec3; 2] {
        [0.5 * self.base_edge + self.half_top, self.axis]
    }

    fn skew(&self) -> f64 {
        let [b, c] = self.edges();
        skew(b, c, 2.0 * self.half_top - self.base_edge)
    }
}

/// |α| + |β|, where A is αb + βc in the plane of b and c; infinite where b and c are parallel.
fn skew(b: DVec3, c: DVec3, a: DVec3) -> f64 {
    let area = b.cross(c);
    let (alpha, beta) = (a.cross(c).dot(area), b.cross(a).dot(area));
    let skew = (alpha.abs() + beta.abs()) / area.length_squared();
    if skew.is_nan() { f64::INFINITY } else { skew }
}

/// Whether a patch is still convex and not degenerate after its numbers were rounded: very short loops beside very long
/// ones have few digits.
pub(super) fn is_sound(patch: &LoopPatch, base_width_mm: f32) -> bool {
    let [b, c, a] = patch.coefficients(base_width_mm);
    let smallest = DEGENERATE * f64::from(base_width_mm) * c.length();
    let area = b.cross(c).length();
    area > 0.0 && area >= 0.5 * smallest && skew(b, c, a) < ROUNDED_SKEW
}

/// The value nearest to `bad` that is still good, by halving the way from `good`.
fn last_good(mut good: f64, mut bad: f64, is_good: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if is_good(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

impl LoopPatch {
    /// The corners P0, P1, P2, P3 relative to the cell's centre, mm.
    pub fn corners(&self, base_width_mm: f32) -> [DVec3; 4] {
        let half = 0.5 * f64::from(base_width_mm);
        let p0 = DVec3::new(0.0, -half, f64::from(self.root_z0));
        let p1 = DVec3::new(0.0, half, f64::from(self.root_z1));
        let half_top = DVec3::from_array(self.half_top.map(f64::from));
        let top = 0.5 * (p0 + p1) + DVec3::from_array(self.axis.map(f64::from));
        [p0, p1, top + half_top, top - half_top]
    }

    /// b = ∂P/∂u and c = ∂P/∂v in the middle of the patch, and A, the coefficient of uv, mm.
    pub fn coefficients(&self, base_width_mm: f32) -> [DVec3; 3] {
        let [p0, p1, ..] = self.corners(base_width_mm);
        let half_top = DVec3::from_array(self.half_top.map(f64::from));
        let axis = DVec3::from_array(self.axis.map(f64::from));
        let base = p1 - p0;
        [0.5 * base + half_top, axis, 2.0 * half_top - base]
    }

    /// n̂, the direction of the thickness.
    pub fn normal(&self, base_width_mm: f32) -> DVec3 {
        let [b, c, _] = self.coefficients(base_width_mm);
        b.cross(c).normalize_or(DVec3::X)
    }

    /// The side of the cloth the loop stands on.
    pub fn face(&self) -> Face {
        if self.axis[2] >= 0.0 {
            Face::Front
        } else {
            Face::Back
        }
    }
}
