//! The walk of a ray through the grid of blocks, front to back (Amanatides and Woo, Eurographics 1987), and through the
//! cells of a block.
//!
//! Space: sheet, mm. The grid is the sheet's blocks and its margin, [`crate::scene::Loops`]. A block's part of the ray
//! is half open, t in [enter, leave), and one block's `leave` is the next one's `enter` to the bit, so that a hit lies
//! in exactly one block. Crossings are computed from the block's number each time, not added up.

use glam::{DVec2, DVec3};

use crate::geometry::{BilinearPatch, Interval, Ray, clip_to_box};
use crate::scene::{BlockEntry, EntryParts, Face, LoopPatch, Loops, SheetGeometry};

/// The grid and its box.
#[derive(Debug, Clone)]
pub struct Grid {
    pitch: DVec2,
    /// Cells of the sheet.
    cells: [i64; 2],
    /// Cells along each side of a block.
    block_cells: i64,
    /// First block, and the one behind the last.
    first: [i64; 2],
    end: [i64; 2],
    low: DVec3,
    high: DVec3,
}

/// The part of a ray in one block or in one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// The block, or the cell (i, j); outside the sheet in the margin.
    pub index: [i64; 2],
    /// Where the ray enters it (or starts), mm along it.
    pub enter: f64,
    /// Where it leaves; not part of the span.
    pub leave: f64,
}

impl Span {
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
    /// The grid over a sheet, high enough for its loops and for yarns that reach `yarn_height` mm to both sides of it,
    /// if there are any.
    pub fn new(sheet: &SheetGeometry, loops: &Loops, yarn_height: Option<f64>) -> Self {
        let [mut z_low, mut z_high] = loops.z_range_mm.map(f64::from);
        if let Some(height) = yarn_height {
            z_low = z_low.min(-height);
            z_high = z_high.max(height);
        }
        let first = loops.margin.map(|blocks| -i64::from(blocks));
        let mut grid = Self {
            pitch: DVec2::new(sheet.pitch_x_mm, sheet.pitch_y_mm),
            cells: [i64::from(sheet.warps), i64::from(sheet.wefts)],
            block_cells: i64::from(loops.block_cells),
            first,
            end: [0, 1].map(|axis| first[axis] + i64::from(loops.blocks[axis])),
            low: DVec3::new(0.0, 0.0, z_low),
            high: DVec3::new(0.0, 0.0, z_high),
        };
        for axis in 0..2 {
            grid.low[axis] = grid.edge_mm(axis, grid.first[axis] * grid.block_cells);
            grid.high[axis] = grid.edge_mm(axis, grid.end[axis] * grid.block_cells);
        }
        grid
    }

    /// Corners of the box that holds the cloth.
    pub fn bounds(&self) -> [DVec3; 2] {
        [self.low, self.high]
    }

    /// Where cell `index` begins along an axis.
    fn edge_mm(&self, axis: usize, index: i64) -> f64 {
        (index as f64 - self.cells[axis] as f64 / 2.0) * self.pitch[axis]
    }

    /// The cell that holds the point (x, y).
    fn cell_at(&self, x: f64, y: f64) -> [i64; 2] {
        [0, 1].map(|axis| {
            let place = [x, y][axis] / self.pitch[axis] + self.cells[axis] as f64 / 2.0;
            place.floor() as i64
        })
    }

    /// The block that holds the point (x, y), or the nearest one.
    pub fn block_at(&self, x: f64, y: f64) -> [i64; 2] {
        let cell = self.cell_at(x, y);
        [0, 1].map(|axis| {
            let block = cell[axis].div_euclid(self.block_cells);
            block.clamp(self.first[axis], self.end[axis] - 1)
        })
    }

    /// The way of a ray through its part `span` of a block, by the subcells in which loops' `part` is noted.
    pub fn pieces(&self, ray: &Ray, span: Interval, block: [i64; 2], part: LoopPart) -> Pieces {
        let low = [0, 1].map(|axis| self.edge_mm(axis, block[axis] * self.block_cells));
        Pieces::new(ray, span, low, self.block_cells as f64 * self.pitch, part)
    }

    /// Whether a cell belongs to the sheet itself.
    pub fn is_in_sheet(&self, cell: [i64; 2]) -> bool {
        (0..2).all(|axis| (0..self.cells[axis]).contains(&cell[axis]))
    }

    /// The blocks along a ray.
    pub fn walk(&self, ray: &Ray) -> Walk<'_> {
        self.walk_part(ray, Interval::new(0.0, f64::INFINITY))
    }

    /// The blocks along a part of a ray.
    pub fn walk_part(&self, ray: &Ray, part: Interval) -> Walk<'_> {
        let whole = clip_to_box(ray, part, self.low, self.high);
        let start = ray.at(whole.low);
        Walk {
            grid: self,
            ray: *ray,
            stride: self.block_cells,
            first: self.first,
            end: self.end,
            index: self.block_at(start.x, start.y),
            t: whole.low,
            t_end: whole.high,
        }
    }

    /// The cells along a ray's part in a block.
    pub fn walk_cells(&self, ray: &Ray, block: &Span) -> Walk<'_> {
        let start = ray.at(block.enter);
        let first = block.index.map(|index| index * self.block_cells);
        let end = first.map(|index| index + self.block_cells);
        let cell = self.cell_at(start.x, start.y);
        Walk {
            grid: self,
            ray: *ray,
            stride: 1,
            first,
            end,
            // Rounding may put the start just beside the block.
            index: [0, 1].map(|axis| cell[axis].clamp(first[axis], end[axis] - 1)),
            t: block.enter,
            t_end: block.leave,
        }
    }
}

/// Iterator over the blocks or the cells along a ray.
#[derive(Debug, Clone)]
pub struct Walk<'a> {
    grid: &'a Grid,
    ray: Ray,
    /// Cells along each side of what it steps over.
    stride: i64,
    /// First index, and the one behind the last.
    first: [i64; 2],
    end: [i64; 2],
    index: [i64; 2],
    t: f64,
    t_end: f64,
}

impl Walk<'_> {
    /// Where the ray leaves the current column or row.
    fn crossing(&self, axis: usize) -> f64 {
        let slope = self.ray.direction[axis];
        if slope == 0.0 {
            return f64::INFINITY;
        }
        let edge = (self.index[axis] + i64::from(slope > 0.0)) * self.stride;
        (self.grid.edge_mm(axis, edge) - self.ray.origin[axis]) / slope
    }
}

impl Iterator for Walk<'_> {
    type Item = Span;

    fn next(&mut self) -> Option<Span> {
        while self.t < self.t_end {
            let next = [self.crossing(0), self.crossing(1)];
            let axis = usize::from(next[1] < next[0]);
            let span = Span {
                index: self.index,
                enter: self.t,
                leave: next[axis].min(self.t_end),
            };
            // Rounding may put a crossing just before the start: then nothing is held.
            self.t = next[axis].max(self.t);
            self.index[axis] += if self.ray.direction[axis] > 0.0 {
                1
            } else {
                -1
            };
            if !(self.first[axis]..self.end[axis]).contains(&self.index[axis]) {
                self.t_end = f64::NEG_INFINITY;
            }
            if span.enter < span.leave {
                return Some(span);
            }
        }
        None
    }
}

/// What of a loop a ray may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoopPart {
    /// Its patch, w = 0: all that `single` asks for.
    Patch,
    /// Its volume.
    Volume,
}

impl LoopPart {
    /// Subcells along each side of a block in which it is noted.
    fn subcells(self) -> usize {
        match self {
            Self::Patch => 3,
            Self::Volume => 2,
        }
    }
}

/// A ray's part in a block, cut where it goes from one of the block's subcells to the next.
#[derive(Debug, Clone, Copy)]
pub struct Pieces {
    part: LoopPart,
    /// The bit of each subcell passed, and the heights that the ray passes in it.
    list: [(u32, Interval); 5],
    count: usize,
    /// The quadrant and the height at which the ray starts: of a loop that holds the start, a part lies ahead even
    /// where its patch lies behind.
    start: Option<(u32, f64)>,
}

impl Pieces {
    fn new(ray: &Ray, span: Interval, low: [f64; 2], size: DVec2, part: LoopPart) -> Self {
        let starts_here = part == LoopPart::Patch && span.low <= 0.0;
        let start = starts_here.then(|| {
            let (quadrant, _) = Self::new(ray, span, low, size, LoopPart::Volume).list[0];
            (quadrant, ray.at(span.low).z)
        });
        let n = part.subcells();
        let mut cuts = [span.high; 6];
        cuts[0] = span.low;
        let mut count = 1;
        for axis in 0..2 {
            for k in 1..n {
                let line = low[axis] + size[axis] * k as f64 / n as f64;
                let t = (line - ray.origin[axis]) / ray.direction[axis];
                if span.low < t && t < span.high {
                    cuts[count] = t;
                    count += 1;
                }
            }
        }
        let cuts = &mut cuts[..=count];
        cuts.sort_by(f64::total_cmp);
        let mut pieces = Self {
            part,
            list: [(0, Interval::new(0.0, 0.0)); 5],
            count,
            start,
        };
        for (piece, ends) in pieces.list.iter_mut().zip(cuts.windows(2)) {
            let middle = ray.at(0.5 * (ends[0] + ends[1]));
            let [x, y] = [0, 1].map(|axis| {
                let place = (middle[axis] - low[axis]) / size[axis] * n as f64;
                (place.floor().max(0.0) as usize).min(n - 1)
            });
            let (a, b) = (ray.at(ends[0]).z, ray.at(ends[1]).z);
            *piece = (1 << (x + n * y), Interval::new(a.min(b), a.max(b)));
        }
        pieces
    }

    /// Whether a loop may be met whose entry tells this and whose part in the block is between two heights.
    fn meet(&self, entry: &EntryParts, heights: Interval) -> bool {
        let subcells = match self.part {
            LoopPart::Patch => entry.mask_3x3,
            LoopPart::Volume => entry.mask_2x2,
        };
        let mut pieces = self.list[..self.count].iter();
        let meets =
            |&(subcell, own): &(u32, Interval)| subcells & subcell != 0 && own.overlaps(heights);
        let holds = |(quadrant, z): (u32, f64)| entry.mask_2x2 & quadrant != 0 && heights.holds(z);
        pieces.any(meets) || self.start.is_some_and(holds)
    }
}

/// The loops of one block.
#[derive(Debug, Clone, Copy)]
pub struct BlockLoops<'a> {
    loops: &'a Loops,
    block: [i64; 2],
    entries: &'a [BlockEntry],
    /// The heights in which entries tell where loops of the front and of the back are, mm.
    of_face: [Interval; 2],
}

impl<'a> BlockLoops<'a> {
    /// The loops listed in `block`; none outside the grid.
    pub fn new(loops: &'a Loops, block: [i64; 2]) -> Self {
        let index = loops.header_index(block);
        let of_face = [Face::Front, Face::Back].map(|face| {
            let heights = index.map(|index| loops.headers[index].heights_mm(loops, face));
            let [low, high] = heights.unwrap_or([1.0, 0.0]);
            Interval::new(low, high)
        });
        Self {
            loops,
            block,
            entries: index.map_or(&[], |index| loops.entries_of(index)),
            of_face,
        }
    }

    /// Lowest and highest point of any loop in the block, mm; empty if there is none.
    pub fn heights(&self) -> Interval {
        let [front, back] = self.of_face;
        Interval::new(front.low.min(back.low), front.high.max(back.high))
    }

    /// The loops that may be met on a way through the block.
    pub fn along(&self, pieces: Pieces) -> impl Iterator<Item = LoopPlace> + use<'a> {
        let Self {
            loops,
            block,
            entries,
            of_face,
        } = *self;
        let layout = loops.entry_layout;
        entries.iter().filter_map(move |&entry| {
            let entry = layout.unpack(entry);
            let own = of_face[usize::from(Face::of_place(entry.place) == Face::Back)];
            let step = (own.high - own.low) / f64::from(layout.height_steps());
            let [low, high] = [entry.heights[0], entry.heights[1] + 1]
                .map(|steps| own.low + f64::from(steps) * step);
            if !pieces.meet(&entry, Interval::new(low, high)) {
                return None;
            }
            let [x, y] = entry.offset.map(i64::from);
            let home = [block[0] + x, block[1] + y];
            let header = &loops.headers[loops.header_index(home)?];
            Some(LoopPlace {
                index: header.loop_index(entry.place) as usize,
                cell: loops.cell_in_block(home, entry.place),
            })
        })
    }
}

/// The patch of a loop, relative to its own cell.
pub fn patch_of(shape: &LoopPatch, base_width_mm: f32) -> BilinearPatch {
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
