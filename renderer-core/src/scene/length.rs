//! From the colour of a texel to the length of its loop, mm, and to its row of the material table (MODEL.md §6).

use rayon::prelude::*;

use super::chart::ChartOnSheet;
use super::curve::MonotoneCurve;
use crate::design::chart_edit::precise_oklab;
use crate::design::{Length, LengthEntry, LengthMap};
use crate::scene::SheetGeometry;

/// How colours become lengths.
#[derive(Debug, Clone)]
pub struct LengthRule {
    map: LengthMap,
    value: f64,
    range: [f64; 2],
    curve: MonotoneCurve,
    table: ColourTable,
    lengths: Vec<f64>,
}

impl LengthRule {
    /// The rule that a design asks for.
    pub fn new(length: &Length) -> Self {
        Self {
            map: length.map,
            value: length.value,
            range: [length.min, length.max],
            curve: MonotoneCurve::new(&length.curve),
            table: ColourTable::new(&length.table),
            lengths: length.table.iter().map(|row| row.length).collect(),
        }
    }

    /// Length of a loop of this colour before turbulence, mm.
    pub fn length_mm(&self, colour: [u8; 3]) -> f64 {
        match self.map {
            LengthMap::Constant => self.value,
            LengthMap::Gray => {
                let [min, max] = self.range;
                min + (max - min) * self.curve.value(luma(colour)).clamp(0.0, 1.0)
            }
            LengthMap::Lut => self
                .table
                .nearest(colour)
                .map_or(self.value, |row| self.lengths[row]),
        }
    }

    /// Row of the table that a loop of this colour follows; `None` unless lengths come from the table.
    pub fn row(&self, colour: [u8; 3]) -> Option<usize> {
        match self.map {
            LengthMap::Lut => self.table.nearest(colour),
            LengthMap::Constant | LengthMap::Gray => None,
        }
    }
}

/// Rec. 709 luma in [0, 1]: the weights act on sRGB-encoded values, as the chart's author sees them.
pub fn luma([r, g, b]: [u8; 3]) -> f64 {
    (0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)) / 255.0
}

/// The colours of the table's rows in Oklab, where distance is perceived difference.
#[derive(Debug, Clone)]
struct ColourTable(Vec<[f64; 3]>);

impl ColourTable {
    fn new(rows: &[LengthEntry]) -> Self {
        Self(rows.iter().map(|row| precise_oklab(row.colour.0)).collect())
    }

    /// The row nearest to a colour, the first of equals; `None` in an empty table.
    fn nearest(&self, colour: [u8; 3]) -> Option<usize> {
        let [l, a, b] = precise_oklab(colour);
        let distance =
            |row: &[f64; 3]| (row[0] - l).powi(2) + (row[1] - a).powi(2) + (row[2] - b).powi(2);
        let by_distance = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        let rows = self.0.iter().map(distance).enumerate();
        rows.min_by(by_distance).map(|(row, _)| row)
    }
}

/// What the chart decides for the loops of every cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PerCell<T> {
    /// All cells alike.
    Uniform(T),
    /// Row by row.
    Each(Vec<T>),
}

impl<T: Copy + Default + PartialEq + Send + Sync> PerCell<T> {
    /// What `of` gives for the colour of each cell; the default where the chart is transparent.
    fn new(
        chart: &ChartOnSheet<'_>,
        sheet: &SheetGeometry,
        of: impl Fn([u8; 3]) -> T + Sync,
    ) -> Self {
        if chart.is_uniform() {
            return Self::Uniform(chart.colour(0, 0).map_or(T::default(), of));
        }
        let (warps, wefts) = (sheet.warps as usize, sheet.wefts as usize);
        let mut cells = vec![T::default(); warps * wefts];
        let rows = cells.par_chunks_mut(warps).enumerate();
        rows.for_each_init(
            || ColourCache::new(&of),
            |cache, (j, row)| {
                for (i, value) in row.iter_mut().enumerate() {
                    let [i, j] = sheet.original(i, j);
                    let colour = chart.colour(i, j);
                    *value = colour.map_or(T::default(), |colour| cache.get(colour));
                }
            },
        );
        // An image that says the same everywhere is no other input than no image.
        let first = cells[0];
        if cells.iter().all(|&value| value == first) {
            Self::Uniform(first)
        } else {
            Self::Each(cells)
        }
    }

    /// That of the cell with row-by-row index `cell`.
    pub(super) fn at(&self, cell: usize) -> T {
        match self {
            Self::Uniform(value) => *value,
            Self::Each(cells) => cells[cell],
        }
    }
}

/// What decides the frames of every cell's loops, besides turbulence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    /// Length before turbulence, mm; 0 plants nothing.
    lengths: PerCell<f32>,
    /// Row of the table, where rows have frames of their own: see [`super::frames::FrameRules`].
    rows: PerCell<u8>,
}

impl Cells {
    /// The cells of a sheet.
    pub(super) fn new(length: &Length, chart: &ChartOnSheet<'_>, sheet: &SheetGeometry) -> Self {
        let rule = LengthRule::new(length);
        let rows = if length.rows().iter().any(LengthEntry::has_own_frame) {
            PerCell::new(chart, sheet, |colour| rule.row(colour).unwrap_or(0) as u8)
        } else {
            PerCell::Uniform(0)
        };
        Self {
            lengths: PerCell::new(chart, sheet, |colour| rule.length_mm(colour) as f32),
            rows,
        }
    }

    /// The longest, mm.
    pub(super) fn longest_mm(&self) -> f64 {
        f64::from(match &self.lengths {
            PerCell::Uniform(length) => *length,
            PerCell::Each(lengths) => lengths.par_iter().copied().reduce(|| 0.0, f32::max),
        })
    }

    /// Length of the cell with row-by-row index `cell`, mm.
    pub(super) fn length_mm(&self, cell: usize) -> f64 {
        f64::from(self.lengths.at(cell))
    }

    /// Row of the table of that cell; 0 where no row has frames of its own.
    pub(super) fn row(&self, cell: usize) -> usize {
        usize::from(self.rows.at(cell))
    }
}

/// Remembers what a function gave for the colours seen last; charts have runs and few colours.
pub(super) struct ColourCache<T, F> {
    slots: Vec<Option<([u8; 3], T)>>,
    function: F,
}

impl<T: Copy, F: Fn([u8; 3]) -> T> ColourCache<T, F> {
    const SLOTS: usize = 1024;

    pub(super) fn new(function: F) -> Self {
        Self {
            slots: vec![None; Self::SLOTS],
            function,
        }
    }

    pub(super) fn get(&mut self, colour: [u8; 3]) -> T {
        let [r, g, b] = colour.map(usize::from);
        let slot = &mut self.slots[(r * 31 + g * 241 + b * 7) % Self::SLOTS];
        match slot {
            Some((key, value)) if *key == colour => *value,
            _ => {
                let value = (self.function)(colour);
                *slot = Some((colour, value));
                value
            }
        }
    }
}
