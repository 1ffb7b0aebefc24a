//! Levels of detail within one picture: the cloth several times, each one LOD coarser than the one before (see
//! [`LodRegion`](super::LodRegion)), for pixels that see it from farther and farther away.
//!
//! Each sample of a pixel is drawn in one level. Where a row of pixels needs the cloth finer than one level and less
//! fine than another, its samples are shared out between the two, so that neither a line in a picture nor a step in a
//! zoom shows where levels change. Rows are enough: cameras of level cloth do not roll, so all pixels of a row see the
//! plane through its pile equally far ahead.

use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::geometry::Camera;
use crate::scene::Scene;

/// One of something for each level of detail, from near to far; there is always a nearest.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels<T> {
    /// The finest.
    pub nearest: T,
    /// Each one LOD coarser than the one before.
    pub farther: Vec<T>,
}

impl<T> Levels<T> {
    /// A single level.
    pub fn one(nearest: T) -> Self {
        Self {
            nearest,
            farther: Vec::new(),
        }
    }

    /// From the nearest to the farthest.
    pub fn iter(&self) -> impl Iterator<Item = &T> + Clone {
        std::iter::once(&self.nearest).chain(&self.farther)
    }

    /// How many there are, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        1 + self.farther.len()
    }

    /// The one of this number, from 0 for the nearest.
    pub fn get(&self, number: usize) -> Option<&T> {
        match number.checked_sub(1) {
            None => Some(&self.nearest),
            Some(index) => self.farther.get(index),
        }
    }

    /// What `f` makes of each.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Levels<U> {
        let mut f = f;
        Levels {
            nearest: f(&self.nearest),
            farther: self.farther.iter().map(f).collect(),
        }
    }
}

/// The cloth at one level of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// The cloth, or a region of it.
    pub scene: Arc<Scene>,
    /// The camera in its space.
    pub camera: Camera,
}

/// How fine the rows of a picture need the cloth: 1 as fine as the first level, ½ as the second, ¼ as the third. Linear
/// from row to row, as the inverse of the distance to a plane is; 0 and less above its horizon.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LodSelector {
    /// At the picture's top edge.
    pub at_top: f64,
    /// How much more it is at the bottom edge.
    pub down: f64,
}

/// Which levels the rows of a picture's pixels show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelRows {
    /// The last level; 0 if there is but one.
    pub last: u32,
    /// Fineness in the middle of the first row,
    pub at_first_row: f32,
    /// and how much more it is in the next.
    pub per_row: f32,
}

impl LodSelector {
    /// Which of `levels` levels each row of a whole picture of so many rows shows.
    pub fn rows(&self, levels: usize, height: u32) -> LevelRows {
        let per_row = self.down / f64::from(height.max(1));
        LevelRows {
            last: levels.saturating_sub(1) as u32,
            at_first_row: (self.at_top + 0.5 * per_row) as f32,
            per_row: per_row as f32,
        }
    }
}

impl LevelRows {
    /// The finer of a row's levels, and the share of its samples that the next one has.
    pub fn of_row(&self, row: u32) -> (usize, f32) {
        let fineness = self.at_first_row + row as f32 * self.per_row;
        let mut coarse = if fineness > 0.0 {
            1.0 / fineness
        } else {
            f32::INFINITY
        };
        let mut level = 0;
        while level < self.last && coarse >= 2.0 {
            coarse *= 0.5;
            level += 1;
        }
        let share = if level < self.last {
            (coarse - 1.0).max(0.0)
        } else {
            0.0
        };
        (level as usize, share)
    }

    /// The levels that rows from one to another may show.
    pub fn of_rows(&self, from: u32, to: u32) -> RangeInclusive<usize> {
        // Fineness goes one way.
        let [(a, a_share), (b, b_share)] = [self.of_row(from), self.of_row(to)];
        let coarsest = (a + usize::from(a_share > 0.0)).max(b + usize::from(b_share > 0.0));
        a.min(b)..=coarsest
    }
}
