//! Loops in the order of their blocks, and their shapes in whole units of length.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::super::bounds::box_of;
use super::super::frames::is_sound;
use super::super::skeleton::Face;
use super::super::{
    BlockEntry, BlockHeader, LoopCounts, LoopLook, LoopPatch, LoopShape, SheetGeometry,
};
use super::{BLOCK_SIZES, place_in_block};

/// Largest component of a shape, in units.
const UNITS: f64 = 32_767.0;
/// What shape, look, list and bounds may take for each loop. Finer blocks make for fewer loops that are tested in vain,
/// and for more entries.
const BYTES: f64 = 64.0;
/// Entries that a block should list: with fewer, rays spend more on steps from block to block than finer blocks save
/// them.
const ENTRIES: f64 = 6.0;
/// Slack around every bound, as a share of the farthest reach of any loop: some hundred f32 roundings.
const SLACK: f64 = 1e-5;

/// Loops before they are binned, ordered by cell, front before back.
pub(in super::super) struct Planted {
    pub(in super::super) patches: Vec<LoopPatch>,
    /// Warp of each loop.
    pub(in super::super) warps: Vec<u32>,
    /// Index of the first loop of each weft, and the number of loops.
    pub(in super::super) row_starts: Vec<usize>,
    pub(in super::super) base_width_mm: f32,
    pub(in super::super) thickness_mm: f32,
    pub(in super::super) counts: LoopCounts,
    /// What units and blocks are chosen for.
    pub(in super::super) whole: WholePile,
}

/// What units of length and sizes of blocks are chosen for: all loops that the design asks for. So a scene that has
/// only some of them has them to the bit as the whole scene does.
#[derive(Debug)]
pub(in super::super) struct WholePile {
    /// No component of any patch is larger, mm.
    pub(in super::super) largest_mm: f64,
    /// How many loops there are.
    pub(in super::super) loops: u64,
    /// Some of them, from all over the sheet, each with its warp and weft.
    pub(in super::super) samples: Vec<([u32; 2], LoopPatch)>,
}

/// First and last block that a span of mm about the middle of a cell touches, counted from the cell's own block.
fn blocks_from_own(span: [f64; 2], pitch: f64, cell: u32, block_cells: u32) -> [i64; 2] {
    span.map(|mm| {
        let cells = mm / pitch + 0.5 + f64::from(cell % block_cells);
        (cells / f64::from(block_cells)).floor() as i64
    })
}

/// Where a row's loops reach, in blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// First and last block along x.
    pub(super) columns: [i64; 2],
    /// First and last block along y.
    pub(super) rows: [i64; 2],
    /// Lowest and highest point, mm.
    pub(super) z: [f64; 2],
    /// How far a loop reaches to the other side of the sheet's plane, mm.
    pub(super) penetration_depth: f64,
    /// Blocks from a loop's own to the farthest that it reaches.
    pub(super) blocks: i64,
}

/// A row of the sheet's blocks.
pub(super) struct BlockRow {
    /// [`super::super::BlockHeader::planted`] of each block.
    pub(super) planted: Vec<u32>,
    /// In the order of blocks and bits.
    pub(super) shapes: Vec<LoopShape>,
    /// `None` where there are no loops.
    pub(super) reach: Option<Reach>,
    /// Loops that are degenerate in whole units.
    pub(super) dropped: u64,
}

/// What it takes to put loops into blocks.
pub(super) struct Planting<'a> {
    pub(super) sheet: &'a SheetGeometry,
    pub(super) planted: &'a Planted,
    pub(super) block_cells: u32,
    pub(super) length_unit_mm: f32,
    /// Slack around every bound, mm.
    pub(super) slack: f64,
}

impl<'a> Planting<'a> {
    pub(super) fn new(sheet: &'a SheetGeometry, planted: &'a Planted, block_cells: u32) -> Self {
        let largest = planted.whole.largest_mm;
        // Roots, axis and half top edge each add at most the largest component to where a corner is.
        let reach = (3.0 * largest).max(0.5 * f64::from(planted.base_width_mm))
            + 0.5 * f64::from(planted.thickness_mm);
        Self {
            sheet,
            planted,
            block_cells,
            length_unit_mm: length_unit(largest),
            slack: SLACK * reach.max(sheet.pitch_x_mm).max(sheet.pitch_y_mm),
        }
    }

    /// All rows of blocks.
    pub(super) fn rows(&self) -> Vec<BlockRow> {
        let count = self.sheet.wefts.div_ceil(self.block_cells);
        (0..count)
            .into_par_iter()
            .map(|row| self.row(row))
            .collect()
    }

    fn row(&self, row: u32) -> BlockRow {
        let b = self.block_cells;
        let mut planted = vec![0_u32; self.sheet.warps.div_ceil(b) as usize];
        let mut found = Vec::new();
        let mut reach = None;
        let mut dropped = 0;
        for j in row * b..((row + 1) * b).min(self.sheet.wefts) {
            for index in self.planted.row(j) {
                let (patch, i) = (&self.planted.patches[index], self.planted.warps[index]);
                let face = patch.face();
                let shape = LoopShape::new(patch, self.length_unit_mm);
                let stored = shape.patch(self.length_unit_mm);
                if !is_sound(&stored, self.planted.base_width_mm) {
                    dropped += 1;
                    continue;
                }
                let (block, place) = ((i / b) as usize, place_in_block(b, [i, j], face));
                planted[block] |= 1 << place;
                found.push((block, place, shape));
                let here = self.reach_of(&stored, [i, j]);
                reach = Some(reach.map_or(here, |reach: Reach| reach.join(here)));
            }
        }
        let mut first = 0;
        let firsts: Vec<u32> = planted
            .iter()
            .map(|bits| {
                first += bits.count_ones();
                first - bits.count_ones()
            })
            .collect();
        let mut shapes = vec![LoopShape::default(); found.len()];
        for (block, place, shape) in found {
            let before = planted[block] & ((1 << place) - 1);
            shapes[(firsts[block] + before.count_ones()) as usize] = shape;
        }
        BlockRow {
            planted,
            shapes,
            reach,
            dropped,
        }
    }

    fn reach_of(&self, patch: &LoopPatch, cell: [u32; 2]) -> Reach {
        let [low, high] = self.box_of(patch);
        let pitch = [self.sheet.pitch_x_mm, self.sheet.pitch_y_mm];
        let b = self.block_cells;
        let own = cell.map(|index| i64::from(index / b));
        // Blocks from the loop's own.
        let [columns, rows] =
            [0, 1].map(|axis| blocks_from_own([low[axis], high[axis]], pitch[axis], cell[axis], b));
        let penetration_depth = match patch.face() {
            Face::Front => -low.z,
            Face::Back => high.z,
        };
        Reach {
            columns: columns.map(|block| own[0] + block),
            rows: rows.map(|block| own[1] + block),
            z: [low.z, high.z],
            penetration_depth: penetration_depth.max(0.0),
            blocks: (-columns[0]).max(columns[1]).max(-rows[0]).max(rows[1]),
        }
    }

    /// Smallest box that holds a loop's volume, relative to its cell, with slack.
    pub(super) fn box_of(&self, patch: &LoopPatch) -> [DVec3; 2] {
        let planted = self.planted;
        let [low, high] = box_of(patch, planted.base_width_mm, planted.thickness_mm);
        [low - self.slack, high + self.slack]
    }
}

impl Planted {
    /// Cells along each side of a block, from the finest to the coarsest that may do: the finest of which loops'
    /// records are expected to stay within [`BYTES`] and whose blocks list [`ENTRIES`], and those that are coarser.
    pub(super) fn block_sizes(&self, sheet: &SheetGeometry) -> &'static [u32] {
        let WholePile { loops, samples, .. } = &self.whole;
        // Blocks that the boxes of all sampled loops touch.
        let mut touched = [0.0; BLOCK_SIZES.len()];
        for (cell, patch) in samples {
            let [low, high] = box_of(patch, self.base_width_mm, self.thickness_mm);
            let pitch = [sheet.pitch_x_mm, sheet.pitch_y_mm];
            for (touched, &b) in touched.iter_mut().zip(BLOCK_SIZES) {
                let blocks = |axis: usize| {
                    let [first, last] =
                        blocks_from_own([low[axis], high[axis]], pitch[axis], cell[axis], b);
                    (last - first + 1) as f64
                };
                *touched += blocks(0) * blocks(1);
            }
        }
        let cells = f64::from(sheet.warps) * f64::from(sheet.wefts);
        let fits = |(&touched, &b): (&f64, &u32)| {
            let entries = touched / samples.len().max(1) as f64;
            let blocks = cells / f64::from(b * b) / (*loops).max(1) as f64;
            let bytes = size_of::<LoopShape>() + size_of::<LoopLook>();
            let bytes = bytes as f64
                + entries * size_of::<BlockEntry>() as f64
                + blocks * size_of::<BlockHeader>() as f64;
            bytes <= BYTES && entries >= ENTRIES * blocks
        };
        let finest = touched.iter().zip(BLOCK_SIZES).position(fits);
        &BLOCK_SIZES[finest.unwrap_or(BLOCK_SIZES.len() - 1)..]
    }

    fn row(&self, j: u32) -> Range<usize> {
        self.row_starts[j as usize]..self.row_starts[j as usize + 1]
    }
}

impl Reach {
    /// Where there are no loops.
    pub(super) const NONE: Self = Self {
        columns: [0, 0],
        rows: [0, 0],
        z: [0.0, 0.0],
        penetration_depth: 0.0,
        blocks: 0,
    };

    pub(super) fn join(self, other: Self) -> Self {
        Self {
            columns: hull(self.columns, other.columns, Ord::min, Ord::max),
            rows: hull(self.rows, other.rows, Ord::min, Ord::max),
            z: hull(self.z, other.z, f64::min, f64::max),
            penetration_depth: self.penetration_depth.max(other.penetration_depth),
            blocks: self.blocks.max(other.blocks),
        }
    }
}

fn hull<T: Copy>(a: [T; 2], b: [T; 2], min: fn(T, T) -> T, max: fn(T, T) -> T) -> [T; 2] {
    [min(a[0], b[0]), max(a[1], b[1])]
}

/// The smallest unit with nine significant bits of which no more than [`UNITS`] are `largest`.
fn length_unit(largest: f64) -> f32 {
    if largest <= 0.0 {
        return 1.0;
    }
    let smallest = largest / UNITS;
    let last_bit = f64::exp2(smallest.log2().floor() - 8.0);
    ((smallest / last_bit).ceil() * last_bit) as f32
}

impl LoopShape {
    /// The shape nearest to a patch.
    fn new(patch: &LoopPatch, length_unit_mm: f32) -> Self {
        let units = |mm: f32| (mm / length_unit_mm).round() as i16;
        Self {
            axis: patch.axis.map(units),
            root_z0: units(patch.root_z0),
            half_top: patch.half_top.map(units),
            root_z1: units(patch.root_z1),
        }
    }
}
