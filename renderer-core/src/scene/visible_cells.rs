//! Scenes for a coarse preview: which cells some rays pass, and how far loops can reach into them. mm, and cells of the
//! sheet.

use std::ops::RangeInclusive;

use glam::DVec3;

use super::finish::Finishing;
use super::frames::{FrameRules, MAX_LEAN};
use super::skeleton::RootHeights;
use super::{CellSet, SheetGeometry, Skeleton};
use crate::design::Design;

/// Slack around every bound, as a share of the farthest reach: twice what the grid allows for f32 rounding.
const SLACK: f64 = 2e-5;

/// How far from the centre of its own cell any loop of a design can be, whatever its turbulence, and how high and how
/// deep loops and ground yarns lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PileReach {
    /// The sheet.
    pub sheet: SheetGeometry,
    /// Lowest x, y and z, mm.
    pub low_mm: [f64; 3],
    /// Highest x, y and z, mm.
    pub high_mm: [f64; 3],
}

impl PileReach {
    /// The reach of a design's loops.
    pub fn of(design: &Design) -> Self {
        let sheet = SheetGeometry::new(design);
        let skeleton = Skeleton::new(&design.weave, &design.skeleton);
        let frames = FrameRules::new(design);
        let roots = RootHeights::new(&skeleton, &sheet, design.pile.base_width);
        let finishing = Finishing::new(design, &sheet);
        let longest = frames.longest_mm(design.length.longest(), &finishing);
        let mut reach = Self::of_frames(&sheet, &frames, &roots, longest, finishing.more_lean());
        let radius = skeleton.warp_radius_mm.max(skeleton.weft_radius_mm);
        let yarns = f64::from(radius + skeleton.crimp_mm);
        reach.low_mm[2] = reach.low_mm[2].min(-yarns);
        reach.high_mm[2] = reach.high_mm[2].max(yarns);
        reach
    }

    /// The reach of loops of these frames that are at most so long and lean so much more than their frames say,
    /// radians.
    fn of_frames(
        sheet: &SheetGeometry,
        frames: &FrameRules,
        roots: &RootHeights,
        length: f64,
        more_lean: f64,
    ) -> Self {
        let common = frames.common();
        let [lean_jitter, ..] = common.jitter;
        // No part of the axis across the sheet is longer than the lean along it, nor than all of the steepest lean.
        let steepest = MAX_LEAN.sin();
        let (mut low_lean, mut high_lean) = ([0.0_f64; 2], [0.0_f64; 2]);
        for row in frames.all() {
            let spread = row.tilt + lean_jitter + more_lean;
            for (axis, lean) in row.lean.into_iter().enumerate() {
                low_lean[axis] = low_lean[axis].min((lean - spread).max(-steepest));
                high_lean[axis] = high_lean[axis].max((lean + spread).min(steepest));
            }
        }

        let ([low_root, high_root], step) = roots.range();
        let half_top = frames.half_top_mm(step);
        let half_thickness = 0.5 * common.thickness;

        let root = DVec3::new(0.0, 0.5 * common.base_width, 0.0);
        let low = DVec3::new(length * low_lean[0], length * low_lean[1], 0.0) - half_top;
        let high = DVec3::new(length * high_lean[0], length * high_lean[1], 0.0) + half_top;
        let (low, high) = (
            low.min(-root) - half_thickness,
            high.max(root) + half_thickness,
        );
        // Loops of the back hang as far down as those of the front stand up. Upright ones may be lower than their
        // roots.
        let up = high_root + length + half_top + half_thickness;
        let down = half_top + half_thickness - low_root;
        let far_z = up.max(down);
        let (low, high) = (low.with_z(-far_z), high.with_z(far_z));
        let reach = Self {
            sheet: *sheet,
            low_mm: low.to_array(),
            high_mm: high.to_array(),
        };
        let slack = reach.slack_mm();
        Self {
            low_mm: (low - slack).to_array(),
            high_mm: (high + slack).to_array(),
            ..reach
        }
    }

    /// Allowance for rounding, mm.
    fn slack_mm(&self) -> f64 {
        let ends = self.low_mm.into_iter().chain(self.high_mm).map(f64::abs);
        let cell = self.sheet.pitch_x_mm.max(self.sheet.pitch_y_mm);
        SLACK * ends.fold(cell, f64::max)
    }

    /// Cells from a loop's own to the first and to the last that it can reach, along x or y.
    fn cells(&self, axis: usize) -> [i64; 2] {
        let pitch = [self.sheet.pitch_x_mm, self.sheet.pitch_y_mm][axis];
        [self.low_mm[axis], self.high_mm[axis]].map(|mm| (mm / pitch + 0.5).floor() as i64)
    }

    /// Cells beyond the sheet that loops can reach, along x and y.
    pub fn margin(&self) -> [i64; 2] {
        [0, 1].map(|axis| {
            let [first, last] = self.cells(axis);
            (-first).max(last)
        })
    }
}

/// Cells, on the sheet and beside it, in which the cloth must be as in its whole scene.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleCells {
    reach: PileReach,
    margin: [i64; 2],
    cells: CellSet,
}

impl VisibleCells {
    /// None, among those that loops can reach.
    pub fn none(reach: &PileReach) -> Self {
        let margin = reach.margin();
        let [warps, wefts] = [reach.sheet.warps, reach.sheet.wefts].map(i64::from);
        Self {
            reach: *reach,
            margin,
            cells: CellSet::none(
                (warps + 2 * margin[0]) as usize,
                (wefts + 2 * margin[1]) as usize,
            ),
        }
    }

    /// Adds the cells of weft `j` from one warp to another, as far as loops can reach them.
    pub fn insert(&mut self, j: i64, warps: RangeInclusive<i64>) {
        let row = j + self.margin[1];
        if (0..self.cells.wefts() as i64).contains(&row) {
            let [first, last] = [warps.start(), warps.end()].map(|i| i + self.margin[0]);
            self.cells.insert(row as usize, first..=last);
        }
    }

    /// Adds the cells around these, up to so many away along x and y.
    pub fn grow(&mut self, [x, y]: [i64; 2]) {
        self.cells = self.cells.spread([-x, x], [-y, y]);
    }

    /// These and those of `other`, made for the same reach.
    #[must_use]
    pub fn or(self, other: &Self) -> Self {
        Self {
            cells: self.cells.or(&other.cells),
            ..self
        }
    }

    /// Corners of the box that holds all cells which loops can reach, as high as these, mm.
    pub fn bounds_mm(&self) -> [[f64; 3]; 2] {
        let reach = &self.reach;
        let half = |axis: usize| 0.5 * self.size_mm(axis);
        let (x, y) = (half(0), half(1));
        [[-x, -y, reach.low_mm[2]], [x, y, reach.high_mm[2]]]
    }

    /// Size of the grid, margin included, along x or y, mm.
    fn size_mm(&self, axis: usize) -> f64 {
        let SheetGeometry {
            warps,
            wefts,
            pitch_x_mm,
            pitch_y_mm,
            ..
        } = self.reach.sheet;
        let cells = f64::from([warps, wefts][axis]) + 2.0 * self.margin[axis] as f64;
        cells * [pitch_x_mm, pitch_y_mm][axis]
    }

    /// The wefts that lie between two y, mm, as far as loops can reach them.
    pub fn wefts_between(&self, low_mm: f64, high_mm: f64) -> RangeInclusive<i64> {
        let wefts = i64::from(self.reach.sheet.wefts);
        let [first, last] = [low_mm, high_mm].map(|y| self.cell_at(1, y));
        first.max(-self.margin[1])..=last.min(wefts + self.margin[1] - 1)
    }

    /// The warps that lie between two x, mm; they may be beyond what loops can reach.
    pub fn warps_between(&self, low_mm: f64, high_mm: f64) -> RangeInclusive<i64> {
        self.cell_at(0, low_mm)..=self.cell_at(0, high_mm)
    }

    /// Lowest and highest y of weft `j`, mm.
    pub fn weft_mm(&self, j: i64) -> [f64; 2] {
        let sheet = &self.reach.sheet;
        [0.0, 1.0].map(|edge| (j as f64 + edge - 0.5 * f64::from(sheet.wefts)) * sheet.pitch_y_mm)
    }

    /// Number of the warp or weft at x or y.
    fn cell_at(&self, axis: usize, mm: f64) -> i64 {
        let sheet = &self.reach.sheet;
        let (cells, pitch) = [
            (sheet.warps, sheet.pitch_x_mm),
            (sheet.wefts, sheet.pitch_y_mm),
        ][axis];
        (mm / pitch + 0.5 * f64::from(cells)).floor() as i64
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Whether a loop of cell (i, j) whose volume lies in a box, mm from the cell's centre, may reach one of them.
    pub(super) fn meets_loop(&self, [i, j]: [i64; 2], [low, high]: [DVec3; 2]) -> bool {
        let SheetGeometry {
            pitch_x_mm,
            pitch_y_mm,
            ..
        } = self.reach.sheet;
        let slack = self.reach.slack_mm();
        let cells = |low: f64, high: f64, pitch: f64| {
            [low - slack, high + slack].map(|mm| (mm / pitch + 0.5).floor() as i64)
        };
        let [x, y] = self.margin;
        let [first, last] = cells(low.x, high.x, pitch_x_mm).map(|di| i + di + x);
        let [near, far] = cells(low.y, high.y, pitch_y_mm).map(|dj| j + dj + y);
        let mut rows = near.max(0)..=far.min(self.cells.wefts() as i64 - 1);
        rows.any(|row| self.cells.meets(row as usize, first..=last))
    }

    /// The cells of the sheet whose loops may reach one of these.
    pub fn planted_in(&self) -> CellSet {
        let [x, y] = [0, 1].map(|axis| self.reach.cells(axis).map(|cells| -cells));
        let within = self.cells.spread([x[1], x[0]], [y[1], y[0]]);
        let SheetGeometry { warps, wefts, .. } = self.reach.sheet;
        let [left, near] = self.margin.map(|cells| cells as usize);
        CellSet::from_fn(warps as usize, wefts as usize, |i, j| {
            within.contains(i + left, j + near)
        })
    }
}
