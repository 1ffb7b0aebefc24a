//! The grid that finds loops: for each cell of the weave, the loops whose volume reaches into it, each with the height
//! range of its part there (ARCHITECTURE.md, acceleration). mm, relative to cells; conservative to f32 rounding.
//!
//! Method: bands of cell rows in parallel. A band looks at all loops that can reach it, row after row, notes (cell, loop,
//! height range), and sorts the notes by cell by counting. No atomics and no locks, so the order is always the same.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::{PartOverCells, box_of, parts};
use super::skeleton::Face;
use super::{Cancel, CellEntry, CellHeader, LoopCounts, LoopShape, Loops, SheetGeometry};

/// Slack around every bound, as a share of the farthest reach of any loop: some hundred f32 roundings.
const SLACK: f64 = 1e-5;
/// Units of height up to the farthest point; below i16's limit so that rounding outwards fits.
const HEIGHT_UNITS: f64 = 32_000.0;
/// Cells that a band holds at most, to bound the memory for notes.
const BAND_CELLS: usize = 1 << 18;

/// Loops before they are binned, ordered by cell, front before back.
pub(super) struct Planted {
    pub(super) shapes: Vec<LoopShape>,
    /// Warp of each loop.
    pub(super) warps: Vec<u32>,
    /// Index of the first loop of each weft, and the number of loops.
    pub(super) row_starts: Vec<usize>,
    pub(super) base_width_mm: f32,
    pub(super) thickness_mm: f32,
    pub(super) counts: LoopCounts,
}

/// Most entries of all lists together: 2 GB, about the largest buffer that a device binds.
pub(super) const MAX_ENTRIES: u64 = 1 << 29;

/// Why there is no grid.
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
    /// Index in [`Self::headers`] of a cell; cells beyond the sheet are in the margin.
    pub fn header_index(&self, sheet: &SheetGeometry, i: i64, j: i64) -> Option<usize> {
        let [width, height] = self.grid_size(sheet).map(i64::from);
        let (i, j) = (i + i64::from(self.margin[0]), j + i64::from(self.margin[1]));
        ((0..width).contains(&i) && (0..height).contains(&j)).then_some((j * width + i) as usize)
    }

    /// Entries of a cell.
    pub fn entries_of(&self, header: &CellHeader) -> &[CellEntry] {
        let start = header.entries_start as usize;
        &self.entries[start..start + header.entries_count as usize]
    }

    /// The loops of weft `j`, in the order of their shapes.
    pub fn planted_in_row(
        &self,
        sheet: &SheetGeometry,
        j: u32,
    ) -> impl Iterator<Item = PlantedLoop> {
        let first = self.header_index(sheet, 0, i64::from(j)).unwrap_or(0);
        let headers = &self.headers[first..first + sheet.warps as usize];
        headers.iter().zip(0..).flat_map(move |(header, i)| {
            // A loop's root is in its own cell, so its own cell always lists it.
            let own = |entry: &&CellEntry| entry.cell_offset() == [0, 0];
            let entries = self.entries_of(header).iter().filter(own);
            entries.map(move |entry| {
                let index = header.first_loop + entry.slot();
                let face = self.shapes[index as usize].face();
                PlantedLoop {
                    index,
                    cell: [i, j],
                    face,
                }
            })
        })
    }
}

/// How far loops reach from their cells' centres, mm.
#[derive(Clone, Copy)]
struct Reach {
    low: DVec3,
    high: DVec3,
    /// Cells beyond the sheet's left or right border.
    beyond: i64,
}

impl Reach {
    const NONE: Self = Self {
        low: DVec3::ZERO,
        high: DVec3::ZERO,
        beyond: 0,
    };

    fn join(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            beyond: self.beyond.max(other.beyond),
        }
    }
}

/// Cells that a span of mm around a cell's centre touches, relative to that cell.
fn cells(low: f64, high: f64, pitch: f64) -> [i64; 2] {
    [low, high].map(|mm| (mm / pitch + 0.5).floor() as i64)
}

/// Bins all loops.
pub(super) fn build(
    sheet: &SheetGeometry,
    planted: Planted,
    cancel: &Cancel<'_>,
) -> Result<Loops, NoGrid> {
    let farthest = |index: usize| {
        let [low, high] = planted.box_of(index);
        (-low).max(high).max_element()
    };
    let far_mm = (0..planted.shapes.len())
        .into_par_iter()
        .map(farthest)
        .reduce(|| 0.0, f64::max);
    let slack = SLACK * far_mm.max(sheet.pitch_x_mm).max(sheet.pitch_y_mm);
    let row_reach: Vec<Reach> = (0..sheet.wefts as usize)
        .into_par_iter()
        .map(|j| planted.row_reach(sheet, j, slack))
        .collect();
    let reach = row_reach.iter().copied().fold(Reach::NONE, Reach::join);
    let margin_y = row_reach.iter().zip(0_i64..).fold(0, |margin, (row, j)| {
        let [low, high] = cells(row.low.y, row.high.y, sheet.pitch_y_mm);
        margin
            .max(-(j + low))
            .max(j + high + 1 - i64::from(sheet.wefts))
    });
    let margin = [reach.beyond, margin_y];
    let far_z = reach.high.z.max(-reach.low.z);
    let height_unit_mm = if far_z > 0.0 {
        (far_z / HEIGHT_UNITS) as f32
    } else {
        1.0
    };

    let binning = Binning {
        sheet,
        planted: &planted,
        row_reach: &row_reach,
        slack,
        margin_x: margin[0],
        width: sheet.warps as usize + 2 * margin[0] as usize,
        height_unit_mm: f64::from(height_unit_mm),
    };
    let rows = -margin[1]..i64::from(sheet.wefts) + margin[1];
    let bands = binning.bands(rows, cancel)?;

    let mut headers = Vec::with_capacity(bands.iter().map(|band| band.headers.len()).sum());
    let mut entries = Vec::with_capacity(bands.iter().map(|band| band.entries.len()).sum());
    for mut band in bands {
        let base = entries.len() as u32;
        for header in &mut band.headers {
            header.entries_start += base;
        }
        headers.append(&mut band.headers);
        entries.append(&mut band.entries);
    }
    Ok(Loops {
        z_range_mm: z_range_mm(&headers, height_unit_mm),
        shapes: planted.shapes,
        headers,
        entries,
        margin: margin.map(|cells| cells as u32),
        base_width_mm: planted.base_width_mm,
        thickness_mm: planted.thickness_mm,
        height_unit_mm,
        counts: planted.counts,
    })
}

fn z_range_mm(headers: &[CellHeader], unit_mm: f32) -> [f32; 2] {
    let filled = headers.iter().filter(|header| header.entries_count > 0);
    let range = filled
        .map(CellHeader::z_units)
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    range.unwrap_or([0, 0]).map(|z| f32::from(z) * unit_mm)
}

impl Planted {
    fn rows_loops(&self, j: usize) -> Range<usize> {
        self.row_starts[j]..self.row_starts[j + 1]
    }

    fn box_of(&self, index: usize) -> [DVec3; 2] {
        box_of(&self.shapes[index], self.base_width_mm, self.thickness_mm)
    }

    fn row_reach(&self, sheet: &SheetGeometry, j: usize, slack: f64) -> Reach {
        let mut reach = Reach::NONE;
        for index in self.rows_loops(j) {
            let i = i64::from(self.warps[index]);
            let [low, high] = self.box_of(index);
            let (low, high) = (low - slack, high + slack);
            let [first, last] = cells(low.x, high.x, sheet.pitch_x_mm);
            let beyond = (-(i + first)).max(i + last + 1 - i64::from(sheet.warps));
            reach = reach.join(Reach { low, high, beyond });
        }
        reach
    }
}

/// A loop in a cell of the band.
struct Note {
    /// Index of the cell in the band.
    cell: u32,
    /// The entry without its heights.
    entry: CellEntry,
    /// Lowest and highest point, mm, with slack.
    z: [f32; 2],
}

struct Band {
    headers: Vec<CellHeader>,
    entries: Vec<CellEntry>,
}

struct Binning<'a> {
    sheet: &'a SheetGeometry,
    planted: &'a Planted,
    row_reach: &'a [Reach],
    slack: f64,
    margin_x: i64,
    /// Cells in a row, margin included.
    width: usize,
    height_unit_mm: f64,
}

impl Binning<'_> {
    fn bands(&self, rows: Range<i64>, cancel: &Cancel<'_>) -> Result<Vec<Band>, NoGrid> {
        let count = (rows.end - rows.start) as usize;
        // Several bands a thread, so that uneven ones do not leave threads idle.
        let even = count.div_ceil(4 * rayon::current_num_threads());
        let height = even.clamp(1, 64).min((BAND_CELLS / self.width).max(1));
        let total = AtomicU64::new(0);
        let starts: Vec<i64> = rows.clone().step_by(height).collect();
        let band = |&start: &i64| {
            cancel.check().map_err(|_| NoGrid::Cancelled)?;
            let band = self.band(start..(start + height as i64).min(rows.end));
            let entries = band.entries.len() as u64;
            let sum = total.fetch_add(entries, Ordering::Relaxed) + entries;
            (sum <= MAX_ENTRIES)
                .then_some(band)
                .ok_or(NoGrid::TooManyEntries)
        };
        starts.par_iter().map(band).collect()
    }

    fn band(&self, rows: Range<i64>) -> Band {
        let cell_count = (rows.end - rows.start) as usize * self.width;
        let mut headers = vec![
            CellHeader {
                entries_start: 0,
                entries_count: 0,
                first_loop: 0,
                z_range: 0,
            };
            cell_count
        ];
        let mut notes = Vec::new();
        let mut patch = Vec::new();
        for (j, reach) in (0_i64..).zip(self.row_reach) {
            let [low, high] = cells(reach.low.y, reach.high.y, self.sheet.pitch_y_mm);
            if j + high < rows.start || j + low >= rows.end {
                continue;
            }
            let mut last_warp = None;
            for index in self.planted.rows_loops(j as usize) {
                let warp = self.planted.warps[index];
                let second = last_warp == Some(warp);
                last_warp = Some(warp);
                if rows.contains(&j) && !second {
                    let cell = self.cell_in_band(&rows, [i64::from(warp), j]);
                    headers[cell].first_loop = index as u32;
                }
                self.note_loop(
                    &rows,
                    index,
                    [i64::from(warp), j],
                    second,
                    &mut patch,
                    &mut notes,
                );
            }
        }
        let entries = self.sort(&notes, &mut headers);
        Band { headers, entries }
    }

    fn cell_in_band(&self, rows: &Range<i64>, [i, j]: [i64; 2]) -> usize {
        (j - rows.start) as usize * self.width + (i + self.margin_x) as usize
    }

    /// Adds a note for each cell of the band that the loop reaches. `ranges` is scratch space.
    fn note_loop(
        &self,
        rows: &Range<i64>,
        index: usize,
        own: [i64; 2],
        second: bool,
        ranges: &mut Vec<[f64; 2]>,
        notes: &mut Vec<Note>,
    ) {
        let pitch = [self.sheet.pitch_x_mm, self.sheet.pitch_y_mm];
        let planted = self.planted;
        let shape = &planted.shapes[index];
        let [low, high] = planted.box_of(index);
        let [i0, i1] = cells(low.x - self.slack, high.x + self.slack, pitch[0]);
        let [j0, j1] = cells(low.y - self.slack, high.y + self.slack, pitch[1]);
        let (j0, j1) = (j0.max(rows.start - own[1]), j1.min(rows.end - 1 - own[1]));
        if j0 > j1 {
            return;
        }
        let width = (i1 - i0 + 1) as usize;
        const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        ranges.clear();
        ranges.resize(width * (j1 - j0 + 1) as usize, NOWHERE);
        let half_cell = pitch.map(|pitch| 0.5 * pitch + self.slack);
        for part in parts(shape, planted.base_width_mm, planted.thickness_mm) {
            let (centre, half) = (part.centre, part.half_size() + self.slack);
            let span = |axis: usize, first: i64, last: i64| {
                let low_high = [centre[axis] - half[axis], centre[axis] + half[axis]];
                let [low, high] = cells(low_high[0], low_high[1], pitch[axis]);
                low.max(first)..=high.min(last)
            };
            let part_over_cells = PartOverCells::new(&part, half_cell);
            for dj in span(1, j0, j1) {
                for di in span(0, i0, i1) {
                    let cell = [di as f64 * pitch[0], dj as f64 * pitch[1]];
                    if let Some([z0, z1]) = part_over_cells.z_range(cell) {
                        let range = &mut ranges[(dj - j0) as usize * width + (di - i0) as usize];
                        *range = [range[0].min(z0), range[1].max(z1)];
                    }
                }
            }
        }
        for (k, range) in ranges.iter().enumerate() {
            let z0 = range[0].max(low.z) - self.slack;
            let z1 = range[1].min(high.z) + self.slack;
            if z0 <= z1 {
                let (di, dj) = (i0 + (k % width) as i64, j0 + (k / width) as i64);
                notes.push(Note {
                    cell: self.cell_in_band(rows, [own[0] + di, own[1] + dj]) as u32,
                    entry: CellEntry::new(-di as i32, -dj as i32, second, 0, 0),
                    z: [z0 as f32, z1 as f32],
                });
            }
        }
    }

    /// Sorts notes by cell, keeping their order within one; fills the headers' lists and height ranges.
    fn sort(&self, notes: &[Note], headers: &mut [CellHeader]) -> Vec<CellEntry> {
        const NOWHERE: [i16; 2] = [i16::MAX, i16::MIN];
        let mut ranges = vec![NOWHERE; headers.len()];
        for note in notes {
            let cell = note.cell as usize;
            headers[cell].entries_count += 1;
            let [low, high] = note.z.map(|z| f64::from(z) / self.height_unit_mm);
            let range = &mut ranges[cell];
            *range = [
                range[0].min(low.floor() as i16),
                range[1].max(high.ceil() as i16),
            ];
        }
        let mut start = 0;
        for (header, range) in headers.iter_mut().zip(&ranges) {
            header.entries_start = start;
            start += header.entries_count;
            header.z_range = u32::from(range[0] as u16) | u32::from(range[1] as u16) << 16;
        }
        let mut next: Vec<u32> = headers.iter().map(|header| header.entries_start).collect();
        let mut entries = vec![CellEntry(0); notes.len()];
        for note in notes {
            let cell = note.cell as usize;
            let [low, high] = ranges[cell].map(|z| f64::from(z) * self.height_unit_mm);
            let steps = note
                .z
                .map(|z| (f64::from(z) - low) / (high - low).max(self.height_unit_mm) * 255.0);
            let z0 = steps[0].floor().clamp(0.0, 255.0) as u32;
            let z1 = steps[1].ceil().clamp(0.0, 255.0) as u32;
            entries[next[cell] as usize] = CellEntry(note.entry.0 | z0 << 16 | z1 << 24);
            next[cell] += 1;
        }
        entries
    }
}
