//! which blocks each loop reaches, in which of their 2×2 quarters and between which heights.
//!
//! Method: bands of block rows in parallel. A band looks at all loops that can reach it, row after row, notes (block,
//! loop, occupancy masks, height range), and sorts the notes by block by counting. Heights are found for each quarter,
//! so that a part of a loop that is low in one and high in another stays out of the others.
//!
//! Longer than most files because parts of loops and whole footprints are noted by one walk over subcells.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::super::bounds::{Footprint, PartOverCells, Solid, larger, smaller};
use super::super::skeleton::Face;
use super::super::{
    BlockEntry, BlockHeader, Cancel, EntryLayout, EntryParts, LoopCounts, LoopPatch, Loops,
    SheetGeometry,
};
use super::planting::{BlockRow, Planted, Planting, Reach};
use super::{NoGrid, set_bits, wide};

/// Units of height up to the farthest point; below i16's limit so that rounding outwards fits.
const HEIGHT_UNITS: f64 = 32_000.0;
/// Blocks that a band holds at most, to bound the memory for notes.
const BAND_BLOCKS: usize = 1 << 17;
/// Most entries of all lists together: 2 GB, about the largest buffer that a device binds.
pub(in super::super) const MAX_ENTRIES: u64 = 1 << 29;

/// Bins all loops.
pub(in super::super) fn build(
    sheet: &SheetGeometry,
    planted: &Planted,
    cancel: &Cancel<'_>,
) -> Result<Loops, NoGrid> {
    let sizes = planted.block_sizes(sheet);
    let mut planting = Planting::new(sheet, planted, sizes[0]);
    let mut rows = planting.rows();
    let mut reach = reach_of(&rows);
    for &coarser in &sizes[1..] {
        if reach.blocks > EntryLayout::FARTHEST {
            planting.block_cells = coarser;
            rows = planting.rows();
            reach = reach_of(&rows);
        }
    }
    cancel.check().map_err(|_| NoGrid::Cancelled)?;

    let b = planting.block_cells;
    let sheet_blocks = [sheet.warps.div_ceil(b), sheet.wefts.div_ceil(b)].map(i64::from);
    // How far the grid goes beyond the sheet's blocks, before and behind.
    let beyond = |[first, last]: [i64; 2], count: i64| [(-first).max(0), (last + 1 - count).max(0)];
    let [left, right] = beyond(reach.columns, sheet_blocks[0]);
    let [near, far] = beyond(reach.rows, sheet_blocks[1]);
    let far_z = reach.z[1].max(-reach.z[0]);
    let height_unit_mm = if far_z > 0.0 {
        (far_z / HEIGHT_UNITS) as f32
    } else {
        1.0
    };

    let mut first_shape = 0;
    let homes: Vec<Homes<'_>> = rows
        .iter()
        .map(|row| {
            first_shape += row.shapes.len() as u32;
            Homes {
                row,
                first_shape: first_shape - row.shapes.len() as u32,
            }
        })
        .collect();
    let binning = Binning {
        planting: &planting,
        homes: &homes,
        layout: EntryLayout::new(b, reach.blocks),
        penetration_depth_mm: reach.penetration_depth as f32,
        left,
        width: (left + sheet_blocks[0] + right) as usize,
        height_unit_mm,
        whole: Subcells::new(&planting),
        cells_2x2: Subcells::new(&planting),
        cells_3x3: Subcells::new(&planting),
    };
    let bands = binning.bands(-near..sheet_blocks[1] + far, cancel)?;

    let dropped: u64 = rows.iter().map(|row| row.dropped).sum();
    let mut headers =
        Vec::with_capacity(bands.iter().map(|band| band.headers.len()).sum::<usize>() + 1);
    let mut entries = Vec::with_capacity(bands.iter().map(|band| band.entries.len()).sum());
    for mut band in bands {
        let base = entries.len() as u32;
        for header in &mut band.headers {
            header.entries_start += base;
        }
        headers.append(&mut band.headers);
        entries.append(&mut band.entries);
    }
    let z_range_mm = z_range_mm(&headers, height_unit_mm);
    let mut shapes = Vec::with_capacity(first_shape as usize);
    for row in &rows {
        shapes.extend_from_slice(&row.shapes);
    }
    headers.push(BlockHeader {
        entries_start: entries.len() as u32,
        first_loop: first_shape,
        ..EMPTY
    });
    Ok(Loops {
        z_range_mm,
        length_unit_mm: planting.length_unit_mm,
        headers,
        entries,
        entry_layout: binning.layout,
        block_cells: b,
        blocks: [binning.width as u32, (near + sheet_blocks[1] + far) as u32],
        margin: [left as u32, near as u32],
        base_width_mm: planted.base_width_mm,
        thickness_mm: planted.thickness_mm,
        height_unit_mm,
        penetration_depth_mm: binning.penetration_depth_mm,
        counts: LoopCounts {
            planted: planted.counts.planted - dropped,
            dropped: planted.counts.dropped + dropped,
            ..planted.counts
        },
        shapes,
    })
}

fn reach_of(rows: &[BlockRow]) -> Reach {
    let reach = rows.iter().filter_map(|row| row.reach).reduce(Reach::join);
    reach.unwrap_or(Reach::NONE)
}

/// A block without loops.
const EMPTY: BlockHeader = BlockHeader {
    entries_start: 0,
    first_loop: 0,
    planted: 0,
    z_range: pack([i16::MAX, i16::MIN]),
};

const fn pack([low, high]: [i16; 2]) -> u32 {
    low as u16 as u32 | (high as u16 as u32) << 16
}

fn z_range_mm(headers: &[BlockHeader], unit_mm: f32) -> [f32; 2] {
    let ranges = headers.iter().map(BlockHeader::z_units);
    let range = ranges
        .filter(|[low, high]| low <= high)
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    range.unwrap_or([0, 0]).map(|z| f32::from(z) * unit_mm)
}

/// The loops of a row of blocks, and where their shapes begin among all.
struct Homes<'a> {
    row: &'a BlockRow,
    first_shape: u32,
}

/// A loop in a block of the band.
struct Note {
    /// Index of the block in the band.
    block: u32,
    /// The loop's own block minus this one, along x and y.
    offset: [i8; 2],
    place: u8,
    mask_2x2: u8,
    mask_3x3: u16,
    /// Lowest and highest point, mm, with slack.
    z: [f32; 2],
}

/// A loop, its block, and its bit in the block's header.
struct Home {
    patch: LoopPatch,
    home: [i64; 2],
    place: u32,
}

/// A loop's part in a block, before it is rounded.
#[derive(Clone, Copy)]
struct Reached {
    mask_2x2: u16,
    mask_3x3: u16,
    /// Lowest and highest point, mm; that f32 rounds them is a small part of the slack.
    z: [f32; 2],
}

impl Reached {
    const NOTHING: Self = Self {
        mask_2x2: 0,
        mask_3x3: 0,
        z: [f32::INFINITY, f32::NEG_INFINITY],
    };
}

/// Equal parts of blocks, `N` along each side.
struct Subcells<const N: i64> {
    /// Size along x and y, mm, and one over it.
    size: [f64; 2],
    inverse: [f64; 2],
    slack: f64,
}

/// What is done in subcells. Not a closure, since those are not sure to be compiled for their caller's instructions.
trait Visitor {
    /// In a subcell of the block of that number, row by row: its bit in the block, and where its middle is from that of
    /// the box, mm.
    fn visit(&mut self, block: usize, bit: u16, at: [f32; 2]);
}

/// Notes the quarters of blocks that a part of a loop reaches, and its heights there.
struct OfPart<'a> {
    /// Of the part's centre.
    height: f32,
    over: PartOverCells,
    reached: &'a mut [Reached],
}

impl Visitor for OfPart<'_> {
    #[inline(always)]
    fn visit(&mut self, block: usize, bit: u16, at: [f32; 2]) {
        if let Some([z0, z1]) = self.over.z_range(at) {
            let reached = &mut self.reached[block];
            reached.mask_2x2 |= bit;
            let [low, high] = reached.z;
            reached.z = [
                smaller(self.height + z0, low),
                larger(self.height + z1, high),
            ];
        }
    }
}

/// Notes the ninths of blocks, 3×3, that a loop's patch may reach.
struct OfFootprint<'a> {
    footprint: Footprint,
    reached: &'a mut [Reached],
}

impl Visitor for OfFootprint<'_> {
    #[inline(always)]
    fn visit(&mut self, block: usize, bit: u16, at: [f32; 2]) {
        if self.footprint.reaches(at) {
            self.reached[block].mask_3x3 |= bit;
        }
    }
}

/// Subcells counted from the first of a loop's own block, and mm from the middle of the loop's own cell.
struct SubcellsFromLoop<'a, const N: i64> {
    subcells: &'a Subcells<N>,
    /// Where the middle of the loop's cell is, in subcells.
    own: [f64; 2],
}

/// The whole number below; without the call that `f64::floor` is where the processor may be an old one.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(x < towards_zero as f64)
}

impl<const N: i64> Subcells<N> {
    fn new(planting: &Planting<'_>) -> Self {
        let cells = f64::from(planting.block_cells) / N as f64;
        let sheet = planting.sheet;
        let size = [sheet.pitch_x_mm, sheet.pitch_y_mm].map(|mm| cells * mm);
        Self {
            size,
            inverse: size.map(|mm| 1.0 / mm),
            slack: planting.slack,
        }
    }

    /// Half the size, with slack.
    fn half_size(&self) -> [f64; 2] {
        self.size.map(|mm| 0.5 * mm + self.slack)
    }

    /// As seen from the loop with bit `place` in its block's header.
    #[inline(always)]
    fn seen_from(&self, place: u32, block_cells: u32) -> SubcellsFromLoop<'_, N> {
        let own = [place / 2 % block_cells, place / 2 / block_cells].map(f64::from);
        let in_subcells = N as f64 / f64::from(block_cells);
        SubcellsFromLoop {
            subcells: self,
            own: own.map(|cell| (cell + 0.5) * in_subcells),
        }
    }
}

impl<const N: i64> SubcellsFromLoop<'_, N> {
    /// First and last that a span touches.
    #[inline(always)]
    fn span(&self, axis: usize, low: f64, high: f64) -> [i64; 2] {
        [low, high].map(|mm| floor(mm * self.subcells.inverse[axis] + self.own[axis]))
    }

    /// Shows `visitor` the subcells of some `blocks` that a box touches.
    #[inline(always)]
    fn visit(&self, centre: DVec3, half: DVec3, blocks: [[i64; 2]; 2], visitor: &mut impl Visitor) {
        let half = half + self.subcells.slack;
        let touched = |axis: usize| {
            let (middle, half) = (centre[axis], half[axis]);
            let [first, last] = self.span(axis, middle - half, middle + half);
            let [first_block, last_block] = blocks[axis];
            [first.max(first_block * N), last.min(last_block * N + N - 1)]
        };
        let middle = |axis: usize, index: i64| {
            let from_own = (index as f64 + 0.5 - self.own[axis]) * self.subcells.size[axis];
            (from_own - centre[axis]) as f32
        };
        let [[left, right], [near, _]] = blocks;
        let ([x0, x1], [y0, y1]) = (touched(0), touched(1));
        let (column, first_x) = (x0.div_euclid(N) - left, x0.rem_euclid(N));
        let (middle_x0, step_x) = (middle(0, x0), self.subcells.size[0] as f32);
        for y in y0..=y1 {
            let bits = 1 << (N * y.rem_euclid(N));
            let middle_y = middle(1, y);
            let mut block = ((y.div_euclid(N) - near) * (right - left + 1) + column) as usize;
            let (mut x, mut steps) = (first_x, 0.0);
            for _ in x0..=x1 {
                visitor.visit(block, bits << x, [middle_x0 + steps * step_x, middle_y]);
                steps += 1.0;
                x += 1;
                if x == N {
                    (x, block) = (0, block + 1);
                }
            }
        }
    }
}

pub(super) struct Band {
    headers: Vec<BlockHeader>,
    entries: Vec<BlockEntry>,
}

/// What it takes to bin loops.
pub(super) struct Binning<'a> {
    planting: &'a Planting<'a>,
    homes: &'a [Homes<'a>],
    layout: EntryLayout,
    /// How far loops of one face reach to the other's side, mm.
    penetration_depth_mm: f32,
    /// Blocks of the grid before the sheet's first, along x.
    left: i64,
    /// Blocks in a row of the grid.
    width: usize,
    height_unit_mm: f32,
    whole: Subcells<1>,
    cells_2x2: Subcells<2>,
    cells_3x3: Subcells<3>,
}

impl Binning<'_> {
    fn bands(&self, rows: Range<i64>, cancel: &Cancel<'_>) -> Result<Vec<Band>, NoGrid> {
        let count = (rows.end - rows.start) as usize;
        // Several bands a thread, so that uneven ones do not leave threads idle.
        let even = count.div_ceil(4 * rayon::current_num_threads());
        let height = even.clamp(1, 64).min((BAND_BLOCKS / self.width).max(1));
        let total = AtomicU64::new(0);
        let starts: Vec<i64> = rows.clone().step_by(height).collect();
        let band = |&start: &i64| {
            cancel.check().map_err(|_| NoGrid::Cancelled)?;
            let band = wide::band(self, start..(start + height as i64).min(rows.end));
            let entries = band.entries.len() as u64;
            let sum = total.fetch_add(entries, Ordering::Relaxed) + entries;
            (sum <= MAX_ENTRIES)
                .then_some(band)
                .ok_or(NoGrid::TooManyEntries)
        };
        starts.par_iter().map(band).collect()
    }

    /// The lists of some rows of blocks. Inlined whole, so that it is compiled for the instructions of its caller.
    #[inline(always)]
    pub(super) fn band(&self, rows: Range<i64>) -> Band {
        let mut headers = vec![EMPTY; (rows.end - rows.start) as usize * self.width];
        let mut notes = Vec::new();
        let mut reached = Vec::new();
        for (y, homes) in (0_i64..).zip(self.homes) {
            let reaches = |reach: Reach| reach.rows[1] >= rows.start && reach.rows[0] < rows.end;
            if !homes.row.reach.is_some_and(reaches) {
                continue;
            }
            let mut shapes = homes.row.shapes.iter();
            let mut first_loop = homes.first_shape;
            for (x, &planted) in (0_i64..).zip(&homes.row.planted) {
                if rows.contains(&y) {
                    let header = &mut headers[self.block_in_band(&rows, [x, y])];
                    (header.first_loop, header.planted) = (first_loop, planted);
                }
                first_loop += planted.count_ones();
                for (place, shape) in set_bits(planted).zip(shapes.by_ref()) {
                    let patch = shape.patch(self.planting.length_unit_mm);
                    let home = [x, y];
                    self.note_loop(
                        &rows,
                        &Home { patch, home, place },
                        &mut reached,
                        &mut notes,
                    );
                }
            }
        }
        let entries = self.sort(&notes, &mut headers);
        Band { headers, entries }
    }

    fn block_in_band(&self, rows: &Range<i64>, [x, y]: [i64; 2]) -> usize {
        (y - rows.start) as usize * self.width + (x + self.left) as usize
    }

    /// Adds a note for each block of the band that a loop reaches. `reached` is scratch space.
    #[inline(always)]
    fn note_loop(
        &self,
        rows: &Range<i64>,
        own: &Home,
        reached: &mut Vec<Reached>,
        notes: &mut Vec<Note>,
    ) {
        let planting = self.planting;
        let Planted {
            base_width_mm,
            thickness_mm,
            ..
        } = *planting.planted;
        let solid = Solid::new(&own.patch, base_width_mm, thickness_mm);
        let [low, high] = solid.bounds();
        let (low, high) = (low - planting.slack, high + planting.slack);
        let (place, b) = (own.place, planting.block_cells);
        let blocks = self.whole.seen_from(place, b);
        let [x0, x1] = blocks.span(0, low.x, high.x);
        let [y0, y1] = blocks.span(1, low.y, high.y);
        let (y0, y1) = (
            y0.max(rows.start - own.home[1]),
            y1.min(rows.end - 1 - own.home[1]),
        );
        if y0 > y1 {
            return;
        }
        let width = (x1 - x0 + 1) as usize;
        reached.clear();
        reached.resize(width * (y1 - y0 + 1) as usize, Reached::NOTHING);
        let blocks = [[x0, x1], [y0, y1]];
        let cells_2x2 = self.cells_2x2.seen_from(place, b);
        for part in solid.parts() {
            let over = PartOverCells::new(&part, self.cells_2x2.half_size());
            let mut visitor = OfPart {
                height: part.centre.z as f32,
                over,
                reached,
            };
            cells_2x2.visit(part.centre, part.half_size(), blocks, &mut visitor);
        }
        let footprint = solid.footprint(self.cells_3x3.half_size());
        let (centre, half) = (footprint.centre, footprint.half_size);
        let cells_3x3 = self.cells_3x3.seen_from(place, b);
        let mut visitor = OfFootprint { footprint, reached };
        cells_3x3.visit(centre, half, blocks, &mut visitor);
        for (index, reached) in reached.iter().enumerate() {
            let [z0, z1] = reached.z.map(f64::from);
            let z = [
                low.z.max(z0 - planting.slack),
                high.z.min(z1 + planting.slack),
            ];
            if z[0] <= z[1] {
                let (x, y) = (x0 + (index % width) as i64, y0 + (index / width) as i64);
                notes.push(Note {
                    block: self.block_in_band(rows, [own.home[0] + x, own.home[1] + y]) as u32,
                    offset: [-x as i8, -y as i8],
                    place: own.place as u8,
                    mask_2x2: reached.mask_2x2 as u8,
                    mask_3x3: reached.mask_3x3,
                    z: z.map(|z| z as f32),
                });
            }
        }
    }

    /// Sorts notes by block, keeping their order within one; fills the headers' lists and height ranges.
    #[inline(always)]
    fn sort(&self, notes: &[Note], headers: &mut [BlockHeader]) -> Vec<BlockEntry> {
        let unit = f64::from(self.height_unit_mm);
        let units_in_mm = 1.0 / unit;
        let mut counts = vec![0_u32; headers.len()];
        let mut ranges = vec![[i16::MAX, i16::MIN]; headers.len()];
        for note in notes {
            let block = note.block as usize;
            counts[block] += 1;
            let [low, high] = note.z.map(|z| f64::from(z) * units_in_mm);
            let range = &mut ranges[block];
            *range = [
                range[0].min(floor(low) as i16),
                range[1].max(-floor(-high) as i16),
            ];
        }
        let mut start = 0;
        for ((header, count), &range) in headers.iter_mut().zip(&mut counts).zip(&ranges) {
            header.entries_start = start;
            header.z_range = pack(range);
            start += *count;
            // From here on, where the block's next entry goes.
            *count = header.entries_start;
        }
        let mut entries = vec![BlockEntry(0); notes.len()];
        for note in notes {
            let block = note.block as usize;
            let face = Face::of_place(note.place.into());
            let [low, high] =
                headers[block].heights_of(self.height_unit_mm, self.penetration_depth_mm, face);
            let steps = self.layout.height_steps();
            let steps_in_mm = f64::from(steps) / (high - low).max(unit);
            let [z0, z1] = note.z.map(|z| (f64::from(z) - low) * steps_in_mm);
            let last = i64::from(steps) - 1;
            let next = &mut counts[block];
            entries[*next as usize] = self.layout.pack(EntryParts {
                offset: note.offset.map(i32::from),
                place: note.place.into(),
                mask_2x2: note.mask_2x2.into(),
                mask_3x3: note.mask_3x3.into(),
                heights: [floor(z0), -floor(-z1) - 1].map(|z| z.clamp(0, last) as u32),
            });
            *next += 1;
        }
        entries
    }
}
