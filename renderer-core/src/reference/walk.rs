//! The walk of a ray through the grid of cells, front to back (Amanatides and Woo, Eurographics 1987).
//!
//! Space: world, mm. The grid is the sheet's cells and its margin, [`crate::scene::Loops`]. A cell's part of the ray is
//! half open, t in [enter, leave), and one cell's `leave` is the next one's `enter` to the bit, so that a hit lies in
//! exactly one cell. Crossings are computed from the cell's number each time, not added up.

use glam::{DVec2, DVec3};

use super::Yarns;
use crate::geometry::{BilinearPatch, Interval, Ray, clip_to_box};
use crate::scene::{CellEntry, CellHeader, LoopShape, Loops, SheetGeometry};

/// The grid and its box.
#[derive(Debug, Clone)]
pub struct Grid {
    pitch: DVec2,
    /// Cells of the sheet, and of the margin on each side.
    cells: [i64; 2],
    margin: [i64; 2],
    low: DVec3,
    high: DVec3,
}

/// The part of a ray in one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellSpan {
    /// The cell (i, j); outside the sheet in the margin.
    pub cell: [i64; 2],
    /// Where the ray enters the cell (or starts), mm along it.
    pub enter: f64,
    /// Where it leaves; not part of the span.
    pub leave: f64,
}

impl CellSpan {
    /// Whether the span holds `t`.
    pub fn holds(&self, t: f64) -> bool {
        self.enter <= t && t < self.leave
    }

    /// The heights that the ray passes in it.
    pub fn heights(&self, ray: &Ray) -> Interval {
        let (a, b) = (ray.at(self.enter).z, ray.at(self.leave).z);
        Interval::new(a.min(b), a.max(b))
    }
}

/// Which loop, and where it is planted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoopPlace {
    /// Index in [`Loops::shapes`].
    pub index: usize,
    /// Its own cell.
    pub cell: [i64; 2],
}

impl Grid {
    /// The grid over a sheet, high enough for its loops and yarns.
    pub fn new(sheet: &SheetGeometry, loops: &Loops, yarns: Option<&Yarns>) -> Self {
        let pitch = DVec2::new(sheet.pitch_x_mm, sheet.pitch_y_mm);
        let cells = [i64::from(sheet.warps), i64::from(sheet.wefts)];
        let margin = loops.margin.map(i64::from);
        let [mut z_low, mut z_high] = loops.z_range_mm.map(f64::from);
        if let Some(yarns) = yarns {
            z_low = z_low.min(-yarns.height());
            z_high = z_high.max(yarns.height());
        }
        let half = DVec2::new(
            cells[0] as f64 / 2.0 + margin[0] as f64,
            cells[1] as f64 / 2.0 + margin[1] as f64,
        ) * pitch;
        Self {
            pitch,
            cells,
            margin,
            low: (-half).extend(z_low),
            high: half.extend(z_high),
        }
    }

    /// Corners of the box that holds the cloth.
    pub fn bounds(&self) -> [DVec3; 2] {
        [self.low, self.high]
    }

    /// The cell that holds the point (x, y).
    pub fn cell_at(&self, x: f64, y: f64) -> [i64; 2] {
        [0, 1].map(|axis| {
            let place = [x, y][axis] / self.pitch[axis] + self.cells[axis] as f64 / 2.0;
            (place.floor() as i64)
                .clamp(-self.margin[axis], self.cells[axis] + self.margin[axis] - 1)
        })
    }

    /// Whether a cell belongs to the sheet itself.
    pub fn is_in_sheet(&self, cell: [i64; 2]) -> bool {
        (0..2).all(|axis| (0..self.cells[axis]).contains(&cell[axis]))
    }

    /// Whether a cell belongs to the grid, margin included.
    fn contains(&self, cell: [i64; 2]) -> bool {
        (0..2).all(|axis| {
            let margin = self.margin[axis];
            (-margin..self.cells[axis] + margin).contains(&cell[axis])
        })
    }

    /// The cells along a ray.
    pub fn walk(&self, ray: &Ray) -> Walk<'_> {
        let whole = clip_to_box(ray, Interval::new(0.0, f64::INFINITY), self.low, self.high);
        let start = ray.at(whole.low);
        let mut walk = Walk {
            grid: self,
            ray: *ray,
            cell: self.cell_at(start.x, start.y),
            next: [f64::INFINITY; 2],
            t: whole.low,
            end: whole.high,
        };
        for axis in 0..2 {
            walk.next[axis] = walk.crossing(axis);
        }
        walk
    }
}

/// Iterator over the cells along a ray.
#[derive(Debug, Clone)]
pub struct Walk<'a> {
    grid: &'a Grid,
    ray: Ray,
    cell: [i64; 2],
    /// Where the ray leaves the current column and row.
    next: [f64; 2],
    t: f64,
    end: f64,
}

impl Walk<'_> {
    /// Where the ray leaves the current cell along `axis`.
    fn crossing(&self, axis: usize) -> f64 {
        let slope = self.ray.direction[axis];
        if slope == 0.0 {
            return f64::INFINITY;
        }
        let edge = self.cell[axis] + i64::from(slope > 0.0);
        let edge_mm = (edge as f64 - self.grid.cells[axis] as f64 / 2.0) * self.grid.pitch[axis];
        (edge_mm - self.ray.origin[axis]) / slope
    }
}

impl Iterator for Walk<'_> {
    type Item = CellSpan;

    fn next(&mut self) -> Option<CellSpan> {
        while self.t < self.end {
            let axis = usize::from(self.next[1] < self.next[0]);
            let span = CellSpan {
                cell: self.cell,
                enter: self.t,
                leave: self.next[axis].min(self.end),
            };
            // Rounding may put a crossing just before the start: then the cell holds nothing.
            self.t = self.next[axis].max(self.t);
            self.cell[axis] += if self.ray.direction[axis] > 0.0 {
                1
            } else {
                -1
            };
            self.next[axis] = self.crossing(axis);
            if !self.grid.contains(self.cell) {
                self.end = f64::NEG_INFINITY;
            }
            if span.enter < span.leave {
                return Some(span);
            }
        }
        None
    }
}

impl CellHeader {
    /// Lowest and highest point of any loop in the cell, mm; empty if there is none.
    fn heights(&self, loops: &Loops) -> Interval {
        let unit = f64::from(loops.height_unit_mm);
        let [low, high] = self.z_units().map(|z| f64::from(z) * unit);
        Interval::new(low, high)
    }
}

/// The loops of one cell.
#[derive(Debug, Clone, Copy)]
pub struct CellLoops<'a> {
    sheet: &'a SheetGeometry,
    loops: &'a Loops,
    cell: [i64; 2],
    entries: &'a [CellEntry],
    /// Lowest and highest point of any loop in the cell, mm.
    pub heights: Interval,
}

impl<'a> CellLoops<'a> {
    /// The loops listed in `cell`; none outside the grid.
    pub fn new(sheet: &'a SheetGeometry, loops: &'a Loops, cell: [i64; 2]) -> Self {
        let index = loops.header_index(sheet, cell[0], cell[1]);
        let header = index.map(|index| &loops.headers[index]);
        Self {
            sheet,
            loops,
            cell,
            entries: header.map_or(&[], |header| loops.entries_of(header)),
            heights: header.map_or(Interval::new(1.0, 0.0), |header| header.heights(loops)),
        }
    }

    /// The loops whose part in this cell is somewhere within `heights`.
    pub fn within(&self, heights: Interval) -> impl Iterator<Item = LoopPlace> + use<'a> {
        let Self {
            sheet,
            loops,
            cell,
            entries,
            heights: own,
        } = *self;
        let step = (own.high - own.low) / 255.0;
        let met = if own.overlaps(heights) { entries } else { &[] };
        met.iter().filter_map(move |entry| {
            let [low, high] = entry.z_steps().map(|z| own.low + f64::from(z) * step);
            if !Interval::new(low, high).overlaps(heights) {
                return None;
            }
            let [di, dj] = entry.cell_offset();
            let home = [cell[0] + i64::from(di), cell[1] + i64::from(dj)];
            let header = &loops.headers[loops.header_index(sheet, home[0], home[1])?];
            Some(LoopPlace {
                index: (header.first_loop + entry.slot()) as usize,
                cell: home,
            })
        })
    }
}

/// The patch of a loop, relative to its own cell (see [`LoopShape`]).
pub fn patch_of(shape: &LoopShape, base_width_mm: f32) -> BilinearPatch {
    let axis = DVec3::from_array(shape.axis.map(f64::from));
    let half_top = DVec3::from_array(shape.half_top.map(f64::from));
    let (z0, z1) = (f64::from(shape.root_z0), f64::from(shape.root_z1));
    let base = DVec3::new(0.0, f64::from(base_width_mm), z1 - z0);
    let root = DVec3::new(0.0, 0.0, 0.5 * (z0 + z1));
    BilinearPatch {
        centre: root + axis * 0.5,
        along_u: base * 0.5 + half_top,
        along_v: axis,
        twist: half_top * 2.0 - base,
    }
}
