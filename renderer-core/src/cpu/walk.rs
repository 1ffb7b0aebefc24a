//! The walk of a ray over squares of cells, front to back (Amanatides and Woo, Eurographics 1987): over the blocks that
//! list loops, and over single cells for the ground weave.
//!
//! Distances are f64 and computed from a square's number each time, not added up. A square's part of the ray is half
//! open, and one square's `leave` is the next one's `enter` to the bit, so that a hit lies in exactly one.

use glam::{DVec2, DVec3};

use crate::geometry::Ray;
use crate::scene::{Loops, SheetGeometry};

/// The squares of a sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pitch: DVec2,
    /// Half the sheet, in cells.
    half: DVec2,
    /// Cells along each side of a block.
    pub block_cells: i64,
    /// First block, and the one behind the last.
    blocks: [[i64; 2]; 2],
    /// Lowest and highest point of any loop, mm.
    pub loop_heights: [f64; 2],
}

/// The part of a ray in one square.
#[derive(Debug, Clone, Copy)]
pub(super) struct SquareSpan {
    /// The square's number along x and y.
    pub square: [i64; 2],
    /// Where the ray enters it (or starts), mm along it.
    pub enter: f64,
    /// Where it leaves; not part of the span.
    pub leave: f64,
}

impl Grid {
    pub fn new(sheet: &SheetGeometry, loops: &Loops) -> Self {
        let margin = loops.margin.map(i64::from);
        let end = [0, 1].map(|axis| i64::from(loops.blocks[axis]) - margin[axis]);
        Self {
            pitch: DVec2::new(sheet.pitch_x_mm, sheet.pitch_y_mm),
            half: DVec2::new(f64::from(sheet.warps), f64::from(sheet.wefts)) / 2.0,
            block_cells: i64::from(loops.block_cells),
            blocks: [margin.map(|blocks| -blocks), end],
            loop_heights: loops.z_range_mm.map(f64::from),
        }
    }

    /// World position of a cell's centre.
    #[inline(always)]
    pub fn cell_centre(&self, [i, j]: [i64; 2]) -> DVec3 {
        let cell = DVec2::new(i as f64, j as f64);
        ((cell + 0.5 - self.half) * self.pitch).extend(0.0)
    }

    /// Index of a block's header; the block is one of the grid's.
    #[inline(always)]
    pub fn header(&self, [x, y]: [i64; 2]) -> usize {
        let [first, end] = self.blocks;
        ((y - first[1]) * (end[0] - first[0]) + x - first[0]) as usize
    }

    /// Size of a cell, mm.
    #[inline(always)]
    pub fn pitch(&self) -> DVec2 {
        self.pitch
    }

    /// The part of a ray from `from` to `to` between two heights.
    #[inline(always)]
    pub fn clip_heights(&self, ray: &Ray, from: f64, to: f64, [low, high]: [f64; 2]) -> [f64; 2] {
        clip(ray.origin.z, ray.direction.z, [low, high], [from, to])
    }

    /// Where in a part of it a ray is above blocks and between two heights.
    #[inline(always)]
    pub fn clip_blocks(&self, ray: &Ray, part: [f64; 2], heights: [f64; 2]) -> [f64; 2] {
        let mut part = self.clip_heights(ray, part[0], part[1], heights);
        for axis in 0..2 {
            let edges = self
                .blocks
                .map(|block| self.edge(axis, block[axis], self.block_cells));
            part = clip(ray.origin[axis], ray.direction[axis], edges, part);
        }
        part
    }

    /// The blocks along the part of a ray from `from` to `to`, which lies within them.
    #[inline(always)]
    pub fn blocks(&self, ray: &Ray, part: [f64; 2]) -> Walk<'_> {
        Walk::new(self, ray, part, self.block_cells, self.blocks)
    }

    /// The cells of the sheet along a part of a ray. Clipped to the sheet first: a level ray may go on for ever.
    #[inline(always)]
    pub fn cells(&self, ray: &Ray, mut part: [f64; 2]) -> Walk<'_> {
        let end = [0, 1].map(|axis| (2.0 * self.half[axis]) as i64);
        for (axis, &end) in end.iter().enumerate() {
            let edges = [self.edge(axis, 0, 1), self.edge(axis, end, 1)];
            part = clip(ray.origin[axis], ray.direction[axis], edges, part);
        }
        Walk::new(self, ray, part, 1, [[0; 2], end])
    }

    /// Place of the low edge of square `number`, `side` cells wide, mm.
    #[inline(always)]
    fn edge(&self, axis: usize, number: i64, side: i64) -> f64 {
        ((number * side) as f64 - self.half[axis]) * self.pitch[axis]
    }
}

/// The part of `part` in which `value` + `slope`·t lies within `low` and `high`.
#[inline(always)]
fn clip(value: f64, slope: f64, [low, high]: [f64; 2], part: [f64; 2]) -> [f64; 2] {
    if slope == 0.0 {
        return if low <= value && value <= high {
            part
        } else {
            [1.0, 0.0]
        };
    }
    let inverse = 1.0 / slope;
    let (a, b) = ((low - value) * inverse, (high - value) * inverse);
    [part[0].max(a.min(b)), part[1].min(a.max(b))]
}

/// Iterator over the squares along a ray.
#[derive(Debug, Clone)]
pub(super) struct Walk<'a> {
    grid: &'a Grid,
    origin: DVec2,
    inverse: DVec2,
    /// Way to the next square, and to the edge that leads there, along each axis.
    step: [i64; 2],
    ahead: [i64; 2],
    side: i64,
    limits: [[i64; 2]; 2],
    square: [i64; 2],
    /// Where the ray leaves the current column and row.
    next: [f64; 2],
    t: f64,
    end: f64,
}

impl<'a> Walk<'a> {
    #[inline(always)]
    fn new(
        grid: &'a Grid,
        ray: &Ray,
        [t, end]: [f64; 2],
        side: i64,
        limits: [[i64; 2]; 2],
    ) -> Self {
        let origin = ray.origin.truncate();
        let direction = ray.direction.truncate();
        let start = (origin + direction * t) / grid.pitch + grid.half;
        // Not `map`, which is not inlined.
        let square_on = |axis: usize| {
            let square = (start[axis] / side as f64).floor() as i64;
            square.clamp(limits[0][axis], limits[1][axis] - 1)
        };
        let square = [square_on(0), square_on(1)];
        let forwards = [direction.x > 0.0, direction.y > 0.0];
        let mut walk = Self {
            grid,
            origin,
            inverse: 1.0 / direction,
            step: [
                2 * i64::from(forwards[0]) - 1,
                2 * i64::from(forwards[1]) - 1,
            ],
            ahead: [i64::from(forwards[0]), i64::from(forwards[1])],
            side,
            limits,
            square,
            next: [f64::INFINITY; 2],
            t,
            end,
        };
        for axis in 0..2 {
            walk.next[axis] = walk.crossing(axis);
        }
        walk
    }

    /// Where the ray leaves the current square along `axis`.
    #[inline(always)]
    fn crossing(&self, axis: usize) -> f64 {
        // A ray across the axis never does.
        if self.inverse[axis].is_infinite() {
            return f64::INFINITY;
        }
        let edge = self.square[axis] + self.ahead[axis];
        (self.grid.edge(axis, edge, self.side) - self.origin[axis]) * self.inverse[axis]
    }
}

impl Iterator for Walk<'_> {
    type Item = SquareSpan;

    #[inline(always)]
    fn next(&mut self) -> Option<SquareSpan> {
        while self.t < self.end {
            let axis = usize::from(self.next[1] < self.next[0]);
            let span = SquareSpan {
                square: self.square,
                enter: self.t,
                leave: self.next[axis].min(self.end),
            };
            // Rounding may put a crossing just before the start: then the square holds nothing.
            self.t = self.t.max(span.leave);
            if span.leave < self.end {
                self.square[axis] += self.step[axis];
                if self.square[axis] < self.limits[0][axis]
                    || self.square[axis] >= self.limits[1][axis]
                {
                    self.t = self.end;
                } else {
                    self.next[axis] = self.crossing(axis);
                }
            }
            if span.enter < span.leave {
                return Some(span);
            }
        }
        None
    }
}
