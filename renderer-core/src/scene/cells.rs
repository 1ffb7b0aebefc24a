//! Sets of cells of a sheet: a bit a cell, every weft on words of its own, so that wefts can be worked on in parallel.

use std::ops::RangeInclusive;

use rayon::prelude::*;

/// A set of cells of one sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellSet {
    warps: usize,
    words_in_row: usize,
    words: Vec<u64>,
}

/// Cells in a word.
const BITS: usize = u64::BITS as usize;

impl CellSet {
    /// No cell of a sheet of `warps` × `wefts`.
    pub fn none(warps: usize, wefts: usize) -> Self {
        let words_in_row = warps.div_ceil(BITS);
        Self {
            warps,
            words_in_row,
            words: vec![0; words_in_row * wefts],
        }
    }

    /// Every cell.
    pub fn all(warps: usize, wefts: usize) -> Self {
        let mut all = Self::none(warps, wefts);
        for j in 0..wefts {
            all.insert(j, 0..=warps as i64 - 1);
        }
        all
    }

    /// The cells (i, j) for which `is_in(i, j)`.
    pub fn from_fn(
        warps: usize,
        wefts: usize,
        is_in: impl Fn(usize, usize) -> bool + Sync,
    ) -> Self {
        let mut set = Self::none(warps, wefts);
        let rows = set.words.par_chunks_mut(set.words_in_row.max(1));
        rows.enumerate().for_each(|(j, row)| {
            for (word, bits) in row.iter_mut().enumerate() {
                let first = word * BITS;
                for i in first..(first + BITS).min(warps) {
                    *bits |= u64::from(is_in(i, j)) << (i - first);
                }
            }
        });
        set
    }

    /// Number of wefts.
    pub fn wefts(&self) -> usize {
        self.words.len() / self.words_in_row.max(1)
    }

    /// Whether the cell at warp `i` and weft `j` is in the set.
    pub fn contains(&self, i: usize, j: usize) -> bool {
        self.words[j * self.words_in_row + i / BITS] >> (i % BITS) & 1 == 1
    }

    /// Adds the cells of weft `j` from one warp to another, as far as they are on the sheet.
    pub fn insert(&mut self, j: usize, warps: RangeInclusive<i64>) {
        for (word, mask) in self.masks(warps) {
            self.words[j * self.words_in_row + word] |= mask;
        }
    }

    /// The words of a weft that hold cells from one warp to another, each with the bits of these.
    fn masks(&self, warps: RangeInclusive<i64>) -> impl Iterator<Item = (usize, u64)> + use<> {
        let first = (*warps.start()).max(0) as usize;
        let end = (*warps.end() + 1).clamp(0, self.warps as i64) as usize;
        let words = if first < end {
            first / BITS..end.div_ceil(BITS)
        } else {
            0..0
        };
        words.map(move |word| {
            let from = first.saturating_sub(word * BITS);
            let to = (end - word * BITS).min(BITS);
            (word, (u64::MAX << from) & (u64::MAX >> (BITS - to)))
        })
    }

    /// The warps of weft `j` whose cells are in the set, from left to right.
    pub fn row(&self, j: usize) -> impl Iterator<Item = usize> {
        let words = self.words_of(j).iter().enumerate();
        words.flat_map(|(word, &bits)| {
            let rest =
                |bits: &u64| (*bits & (*bits).wrapping_sub(1) != 0).then(|| bits & (bits - 1));
            let all = std::iter::successors((bits != 0).then_some(bits), rest);
            all.map(move |bits| word * BITS + bits.trailing_zeros() as usize)
        })
    }

    /// Whether the set has a cell of weft `j` from one warp to another.
    pub fn meets(&self, j: usize, warps: RangeInclusive<i64>) -> bool {
        let bits = |word: usize, mask: u64| self.words[j * self.words_in_row + word] & mask != 0;
        self.masks(warps).any(|(word, mask)| bits(word, mask))
    }

    /// The cells within reach of the set's: from `x[0]` to `x[1]` warps and from `y[0]` to `y[1]` wefts beside one of
    /// them.
    #[must_use]
    pub fn spread(&self, x: [i64; 2], y: [i64; 2]) -> Self {
        let wefts = self.wefts();
        let mut across = Self::none(self.warps, wefts);
        for j in 0..wefts {
            let mut warps = self.row(j).map(|i| i as i64).peekable();
            while let Some(first) = warps.next() {
                let mut last = first;
                while let Some(next) = warps.next_if(|&next| next + x[0] <= last + x[1] + 1) {
                    last = next;
                }
                across.insert(j, first + x[0]..=last + x[1]);
            }
        }
        let mut spread = Self::none(self.warps, wefts);
        for j in 0..wefts as i64 {
            let from = (j - y[1]).max(0)..(j - y[0] + 1).min(wefts as i64);
            for source in from {
                let to = spread.words_of_mut(j as usize).iter_mut();
                to.zip(across.words_of(source as usize))
                    .for_each(|(to, from)| *to |= from);
            }
        }
        spread
    }

    /// Number of cells in weft `j`.
    pub fn row_len(&self, j: usize) -> usize {
        let words = self.words_of(j).iter();
        words.map(|word| word.count_ones() as usize).sum()
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        let ones = |word: &u64| word.count_ones() as usize;
        self.words.iter().map(ones).sum()
    }

    /// Every `step`th of the cells, counted row by row.
    #[must_use]
    pub fn every(&self, step: usize) -> Self {
        let mut some = Self::none(self.warps, self.wefts());
        let mut next = 0;
        for j in 0..self.wefts() {
            let count = self.row_len(j);
            if next < count {
                for i in self.row(j).skip(next).step_by(step) {
                    some.insert(j, i as i64..=i as i64);
                }
                next += (count - next).div_ceil(step) * step;
            }
            next -= count;
        }
        some
    }

    /// Whether it holds no cell.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Whether every cell of `other`, a set of the same sheet, is in this one.
    pub fn holds(&self, other: &Self) -> bool {
        self.words
            .iter()
            .zip(&other.words)
            .all(|(a, b)| b & !a == 0)
    }

    /// The cells that are in this set and in `other`, a set of the same sheet.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a &= b;
        }
        self
    }

    /// The cells that are in this set or in `other`, a set of the same sheet.
    #[must_use]
    pub fn or(mut self, other: &Self) -> Self {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a |= b;
        }
        self
    }

    fn words_of(&self, j: usize) -> &[u64] {
        &self.words[j * self.words_in_row..(j + 1) * self.words_in_row]
    }

    fn words_of_mut(&mut self, j: usize) -> &mut [u64] {
        &mut self.words[j * self.words_in_row..(j + 1) * self.words_in_row]
    }
}
