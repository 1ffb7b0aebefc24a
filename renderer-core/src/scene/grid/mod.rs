//! The grid that finds loops: for each block of cells of the weave, the loops whose volume reaches into it, each with
//! the height range of its part there (ARCHITECTURE.md, acceleration). mm, relative to cells; conservative to f32
//! rounding.
//!
//! `planting` puts loops in order and stores their shapes; `binning` finds which blocks each reaches. Both work on rows
//! of blocks in parallel, without atomics and locks, so the order is always the same.

mod binning;
mod planting;
mod wide;

use super::skeleton::Face;
use super::{BlockEntry, EntryLayout, LoopPatch, Loops, SheetGeometry};
use crate::design::Sheet;

pub(super) use binning::{MAX_ENTRIES, build};
pub(super) use planting::{Planted, WholePile};

/// Cells along each side of a block: what a grid may have.
const BLOCK_SIZES: &[u32] = &[1, 2, 4];
// Loops that reach farther are refused with the design; entries in a grid of the largest blocks can point as far as
// that.
const _: () = assert!(Sheet::MAX_REACH_CELLS <= (EntryLayout::FARTHEST * 4) as f64);

/// Why there is no grid.
#[derive(Debug)]
pub(super) enum NoGrid {
    /// The lists would be longer than [`MAX_ENTRIES`].
    TooManyEntries,
    /// It was given up.
    Cancelled,
}

/// A loop and where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlantedLoop {
    /// Index into [`Loops::shapes`].
    pub index: u32,
    /// Warp and weft of its cell.
    pub cell: [u32; 2],
    /// Side of the cloth.
    pub face: Face,
}

impl Loops {
    /// The block that holds a cell; cells beyond the sheet continue the grid.
    pub fn block_of(&self, cell: [i64; 2]) -> [i64; 2] {
        cell.map(|index| index.div_euclid(i64::from(self.block_cells)))
    }

    /// Index in [`Self::headers`] of a block, if it belongs to the grid.
    pub fn header_index(&self, block: [i64; 2]) -> Option<usize> {
        let [width, height] = self.blocks.map(i64::from);
        let x = block[0] + i64::from(self.margin[0]);
        let y = block[1] + i64::from(self.margin[1]);
        ((0..width).contains(&x) && (0..height).contains(&y)).then_some((y * width + x) as usize)
    }

    /// The grid's borders in world space, mm: least x and y, greatest x and y.
    pub fn borders_mm(&self, sheet: &SheetGeometry) -> [[f64; 2]; 2] {
        let cells = [sheet.warps, sheet.wefts].map(f64::from);
        let pitch = [sheet.pitch_x_mm, sheet.pitch_y_mm];
        let at = |blocks: [i64; 2]| {
            [0, 1].map(|axis| {
                let cell = blocks[axis] * i64::from(self.block_cells);
                (cell as f64 - 0.5 * cells[axis]) * pitch[axis]
            })
        };
        let margin = self.margin.map(i64::from);
        let blocks = self.blocks.map(i64::from);
        [
            at(margin.map(|blocks| -blocks)),
            at([blocks[0] - margin[0], blocks[1] - margin[1]]),
        ]
    }

    /// Entries of the block with this header.
    pub fn entries_of(&self, header: usize) -> &[BlockEntry] {
        let end = self.headers[header + 1].entries_start as usize;
        &self.entries[self.headers[header].entries_start as usize..end]
    }

    /// The cell of a block that the loop with bit `place` of the block's header is planted in.
    pub fn cell_in_block(&self, block: [i64; 2], place: u32) -> [i64; 2] {
        let b = self.block_cells;
        let [x, y] = [place / 2 % b, place / 2 / b];
        [
            block[0] * i64::from(b) + i64::from(x),
            block[1] * i64::from(b) + i64::from(y),
        ]
    }

    /// A loop's patch.
    pub fn patch(&self, index: usize) -> LoopPatch {
        self.shapes[index].patch(self.length_unit_mm)
    }

    /// Index in [`Self::shapes`] of the loop on one side of a cell.
    pub fn loop_at(&self, cell: [u32; 2], face: Face) -> Option<u32> {
        let header = &self.headers[self.header_index(self.block_of(cell.map(i64::from)))?];
        let place = place_in_block(self.block_cells, cell, face);
        (header.planted >> place & 1 == 1).then(|| header.loop_index(place))
    }

    /// The loops of weft `j` from left to right, front before back.
    pub fn planted_in_row(
        &self,
        sheet: &SheetGeometry,
        j: u32,
    ) -> impl Iterator<Item = PlantedLoop> {
        (0..sheet.warps).flat_map(move |i| {
            [Face::Front, Face::Back]
                .into_iter()
                .filter_map(move |face| {
                    let cell = [i, j];
                    let index = self.loop_at(cell, face)?;
                    Some(PlantedLoop { index, cell, face })
                })
        })
    }

    /// How many rows of blocks the sheet has, its last one perhaps in part.
    pub fn sheet_block_rows(&self, sheet: &SheetGeometry) -> u32 {
        sheet.wefts.div_ceil(self.block_cells)
    }

    /// The loops of a row of the sheet's blocks in the order of their shapes; rows follow each other without gaps.
    pub fn planted_in_block_row(
        &self,
        sheet: &SheetGeometry,
        row: u32,
    ) -> impl Iterator<Item = PlantedLoop> {
        (0..sheet.warps.div_ceil(self.block_cells)).flat_map(move |column| {
            let block = [i64::from(column), i64::from(row)];
            let header = self.header_index(block).map(|index| &self.headers[index]);
            header.into_iter().flat_map(move |header| {
                set_bits(header.planted).map(move |place| PlantedLoop {
                    index: header.loop_index(place),
                    // A planted cell is on the sheet.
                    cell: self.cell_in_block(block, place).map(|index| index as u32),
                    face: Face::of_place(place),
                })
            })
        })
    }
}

/// The bit of a loop in its block's header.
fn place_in_block(block_cells: u32, [i, j]: [u32; 2], face: Face) -> u32 {
    let (x, y) = (i % block_cells, j % block_cells);
    2 * (y * block_cells + x) + u32::from(face == Face::Back)
}

impl Face {
    /// The side of the loop with this bit in its block's header.
    pub fn of_place(place: u32) -> Self {
        if place & 1 == 0 {
            Self::Front
        } else {
            Self::Back
        }
    }
}

/// Numbers of the bits that are set, from the lowest.
fn set_bits(mut bits: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lowest = bits.trailing_zeros();
            bits &= bits - 1;
            lowest
        })
    })
}
