//! The loops that a block lists, and which of them a ray may meet there.

use glam::Vec3A;

use super::cloth::Cloth;
use super::walk::SquareSpan;
use crate::geometry::Ray;
use crate::scene::BlockEntry;

/// The part of a ray in a block, relative to the centre of the block's first cell (x, y) and to the sheet (z), mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockRay {
    /// Where it enters.
    pub point: Vec3A,
    /// Unit vector.
    pub direction: Vec3A,
    /// Length of the part.
    pub length: f32,
}

/// A loop that a block lists.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listed {
    /// Index in [`crate::scene::Loops::shapes`].
    pub index: u32,
    /// Centre of its own cell, relative to that of the block's first.
    pub cell: Vec3A,
}

/// A block's list, and what of it can be met.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    cloth: &'a Cloth,
    square: [i64; 2],
    entries: &'a [BlockEntry],
    /// Lowest and highest point of any loop in the block, mm.
    pub heights: [f32; 2],
}

/// Which entries are looked at: those that reach one of these quadrants and these heights, in steps of the block's range.
#[derive(Debug, Clone, Copy)]
struct Window {
    quadrants: u32,
    lowest_below: u32,
    highest_from: u32,
}

impl Window {
    const ALL: Self = Self {
        quadrants: 15,
        lowest_below: u32::MAX,
        highest_from: 0,
    };

    #[inline]
    fn shows(self, entry: BlockEntry) -> bool {
        let [low, high] = entry.z_steps();
        entry.quadrants() & self.quadrants != 0
            && low < self.lowest_below
            && high >= self.highest_from
    }
}

impl Cloth {
    /// The block of a span.
    #[inline]
    pub fn block(&self, square: [i64; 2]) -> Block<'_> {
        let loops = &self.scene.loops;
        let header = loops.header_index(square);
        let [first, next] = [&loops.headers[header], &loops.headers[header + 1]];
        let unit = loops.height_unit_mm;
        Block {
            cloth: self,
            square,
            entries: &loops.entries[first.entries_start as usize..next.entries_start as usize],
            heights: first.z_units().map(|z| f32::from(z) * unit),
        }
    }

    /// A ray in a block.
    #[inline]
    pub fn in_block(&self, ray: &Ray, span: &SquareSpan) -> BlockRay {
        let first_cell = span.square.map(|number| number * self.grid.block_cells);
        BlockRay {
            point: (ray.at(span.enter) - self.grid.cell_centre(first_cell)).as_vec3a(),
            direction: ray.direction.as_vec3a(),
            length: (span.leave - span.enter) as f32,
        }
    }

    /// The quadrants of a block that a ray passes, as in [`BlockEntry::quadrants`].
    #[inline]
    fn quadrants(&self, part: &BlockRay) -> u32 {
        if self.grid.block_cells == 1 {
            return 15;
        }
        let enter = part.point.truncate() - self.block_middle;
        let way = part.direction.truncate() * part.length;
        let leave = enter + way;
        let bit = |x: f32, y: f32| 1 << (u32::from(x >= 0.0) + 2 * u32::from(y >= 0.0));
        let ends = bit(enter.x, enter.y) | bit(leave.x, leave.y);
        if (enter.x >= 0.0) == (leave.x >= 0.0) || (enter.y >= 0.0) == (leave.y >= 0.0) {
            return ends;
        }
        // From one quadrant to the opposite one, through that whose side it comes to first: −enter.x/way.x < −enter.y/way.y.
        let x_first = (enter.x * way.y).abs() < (enter.y * way.x).abs();
        ends | if x_first {
            bit(leave.x, enter.y)
        } else {
            bit(enter.x, leave.y)
        }
    }
}

impl<'a> Block<'a> {
    /// Whether a ray passes above or below all loops of the block.
    #[inline]
    pub fn is_missed(&self, [low, high]: [f32; 2]) -> bool {
        !(low <= self.heights[1] && high >= self.heights[0])
    }

    /// The loops that a ray may meet, by their heights and quadrants.
    #[inline]
    pub fn met_by(&self, part: &BlockRay) -> impl Iterator<Item = Listed> + use<'a> {
        let z = part.point.z;
        let leave = z + part.direction.z * part.length;
        let mut window = self.window([z.min(leave), z.max(leave)]);
        window.quadrants = self.cloth.quadrants(part);
        self.shown(window)
    }

    /// The loops that may be at a height.
    #[inline]
    pub fn at_height(&self, z: f32) -> impl Iterator<Item = Listed> + use<'a> {
        self.shown(self.window([z, z]))
    }

    /// All loops.
    pub fn all(&self) -> impl Iterator<Item = Listed> + use<'a> {
        self.shown(Window::ALL)
    }

    fn window(&self, heights: [f32; 2]) -> Window {
        let [low, high] = self.heights;
        let range = high - low;
        if range <= 0.0 {
            return Window::ALL;
        }
        let steps = BlockEntry::HIGH_STEPS as f32 / range;
        // Entries hold their bounds rounded outwards; a float below 0 becomes 0.
        let lowest = (heights[1] - low) * (BlockEntry::LOW_STEPS as f32 / range);
        Window {
            quadrants: 15,
            lowest_below: lowest as u32 + 1,
            highest_from: ((heights[0] - low) * steps).ceil() as u32,
        }
    }

    #[inline]
    fn shown(&self, window: Window) -> impl Iterator<Item = Listed> + use<'a> {
        let Self {
            cloth,
            square,
            entries,
            ..
        } = *self;
        let loops = &cloth.scene.loops;
        entries
            .iter()
            .filter(move |entry| window.shows(**entry))
            .map(move |entry| {
                let side = loops.block_cells;
                let offset = entry.block_offset();
                let home = [0, 1].map(|axis| square[axis] + i64::from(offset[axis]));
                let cell = entry.place() >> 1;
                let [x, y] = [cell % side, cell / side].map(|place| place as i32);
                let side = side as i32;
                let cell = Vec3A::new(
                    (offset[0] * side + x) as f32 * cloth.pitch.x,
                    (offset[1] * side + y) as f32 * cloth.pitch.y,
                    0.0,
                );
                Listed {
                    index: loops.headers[loops.header_index(home)].loop_index(entry.place()),
                    cell,
                }
            })
    }
}
