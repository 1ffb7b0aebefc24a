//! How many loops of a cloth lie on each pixel of its chart.

use std::collections::HashMap;

/// How many loops lie on each pixel of a chart. The pattern repeats, so how many lie on the crossings of a warp and of
/// a weft follows from the weft's row of the repeat: columns count loops by that row, rows count wefts by it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LoopsPerPixel {
    /// All pixels count alike: loops take the mean of those around them.
    Alike,
    /// The sum over parts of the cloth.
    Counted(Vec<LoopsUnder>),
}

/// A part of the cloth on which the pixels' columns and rows lie straight: warps of all repeats that drop alike.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoopsUnder {
    /// Of each column of pixels: for each row of the pattern's repeat, the loops that a weft of that row has there.
    pub columns: Vec<Vec<u32>>,
    /// Of each row of pixels: the rows of the pattern's repeat that its wefts are, in order, each with the number of these.
    pub rows: Vec<Vec<(usize, u32)>>,
}

impl LoopsUnder {
    fn at(&self, x: usize, y: usize) -> u64 {
        let column = &self.columns[x];
        let of_row = |&(row, wefts): &(usize, u32)| u64::from(column[row]) * u64::from(wefts);
        self.rows[y].iter().map(of_row).sum()
    }
}

impl LoopsPerPixel {
    /// Loops on the pixel at column `x`, row `y` from the top.
    pub fn at(&self, x: usize, y: usize) -> u64 {
        match self {
            Self::Alike => 1,
            Self::Counted(parts) => parts.iter().map(|part| part.at(x, y)).sum(),
        }
    }

    /// The share of pixels on which no loop lies, 0 to 1.
    pub fn share_without(&self) -> f64 {
        let Self::Counted(parts) = self else {
            return 0.0;
        };
        let Some(first) = parts.first() else {
            return 1.0;
        };
        let (width, height) = (first.columns.len(), first.rows.len());
        // Few columns differ in where loops lie, and few rows: one of each kind stands for all.
        let columns = kinds(width, |x| {
            parts.iter().flat_map(move |part| {
                let loops = part.columns[x].iter().enumerate();
                loops
                    .filter(|(_, loops)| **loops > 0)
                    .map(|(row, _)| row)
                    .chain([END])
            })
        });
        let rows = kinds(height, |y| {
            let of_part = move |part: &LoopsUnder| {
                part.rows[y]
                    .iter()
                    .map(|(row, _)| *row)
                    .chain([END])
                    .collect::<Vec<_>>()
            };
            parts.iter().flat_map(of_part)
        });
        let pairs = columns
            .iter()
            .flat_map(|column| rows.iter().map(move |row| (column, row)));
        let without: u64 = pairs
            .filter(|((x, _), (y, _))| self.at(*x, *y) == 0)
            .map(|((_, columns), (_, rows))| columns * rows)
            .sum();
        without as f64 / (width * height) as f64
    }
}

/// Stands between what the parts say of a column or row.
const END: usize = usize::MAX;

/// One column or row of each kind, and how many are of it.
fn kinds<K: Iterator<Item = usize>>(side: usize, kind: impl Fn(usize) -> K) -> Vec<(usize, u64)> {
    let mut known = HashMap::<Vec<usize>, (usize, u64)>::new();
    for at in 0..side {
        known.entry(kind(at).collect()).or_insert((at, 0)).1 += 1;
    }
    known.into_values().collect()
}
