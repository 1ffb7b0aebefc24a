//! Levels of detail within one picture: the same cloth several times, each halved once more than the one before (see
//! [`Excerpt`](crate::scene::Excerpt)), for pixels that see it from farther and farther away.
//!
//! Each sample of a pixel is drawn in one level. Where a row of pixels needs the cloth finer than one level and less fine than
//! another, its samples are shared out between the two, so that neither a line in a picture nor a step in a zoom shows where
//! levels change. Rows are enough: cameras of level cloth do not roll, so all pixels of a row see the plane through its pile
//! equally far ahead.

use std::ops::RangeInclusive;
use std::sync::Arc;

use super::{Camera, RenderRequest};
use crate::design::Sampler;
use crate::sampling::{self, Set, pixel_seed};
use crate::scene::Scene;

/// One more level.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// The cloth.
    pub scene: Arc<Scene>,
    /// The camera in its space.
    pub camera: Camera,
}

/// The levels behind a request's own scene, and which rows show which.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Levels {
    /// Each halved once more than the one before, the first once more than the request's own scene.
    pub farther: Vec<Level>,
    /// How fine the rows need the cloth.
    pub fineness: Fineness,
}

/// How fine the rows of a picture need the cloth: 1 as fine as the first level, ½ as the second, ¼ as the third. Linear from
/// row to row, as the inverse of the distance to a plane is; 0 and less above its horizon.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fineness {
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

impl Levels {
    /// For a whole picture of so many rows.
    pub fn rows(&self, height: u32) -> LevelRows {
        let Fineness { at_top, down } = self.fineness;
        let per_row = down / f64::from(height.max(1));
        LevelRows {
            last: self.farther.len() as u32,
            at_first_row: (at_top + 0.5 * per_row) as f32,
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

/// Which level each sample of a picture shows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LevelChoice {
    rows: LevelRows,
    sampler: Sampler,
    seed: u32,
}

impl LevelChoice {
    fn new(request: &RenderRequest) -> Self {
        Self {
            rows: request.levels.rows(request.size[1]),
            sampler: request.settings.sampler,
            seed: request.settings.seed,
        }
    }

    /// The level of sample `number` of a pixel of the whole picture.
    #[inline(always)]
    fn of_sample(&self, pixel: [u32; 2], number: u32) -> usize {
        if self.rows.last == 0 {
            return 0;
        }
        let (level, share) = self.rows.of_row(pixel[1]);
        if share == 0.0 {
            return level;
        }
        let seed = pixel_seed(self.seed, pixel);
        let [u, ..] = sampling::sample(self.sampler, seed, number, Set::Level);
        level + usize::from(u < share)
    }
}

impl RenderRequest {
    /// How many levels there are, the first included.
    pub fn level_count(&self) -> usize {
        1 + self.levels.farther.len()
    }

    /// The same picture from one level alone; the first for any number beyond the last.
    pub fn at_level(&self, level: usize) -> Self {
        let mut request = Self {
            levels: Levels::default(),
            ..self.clone()
        };
        let farther = level.checked_sub(1);
        if let Some(level) = farther.and_then(|index| self.levels.farther.get(index)) {
            (request.scene, request.camera) = (Arc::clone(&level.scene), level.camera);
        }
        request
    }
}

/// What draws on the host, one for each level.
#[derive(Debug)]
pub struct Tracers<T> {
    choice: LevelChoice,
    tracers: Vec<T>,
}

impl<T> Tracers<T> {
    /// Made by `make(request of a level alone, what drew that level before)`.
    pub fn new(
        request: &RenderRequest,
        last: Option<&Self>,
        make: impl Fn(&RenderRequest, Option<&T>) -> T,
    ) -> Self {
        let last = |level: usize| last.and_then(|last| last.tracers.get(level));
        let levels = 0..request.level_count();
        Self {
            choice: LevelChoice::new(request),
            tracers: levels
                .map(|level| make(&request.at_level(level), last(level)))
                .collect(),
        }
    }

    /// The one that draws sample `number` of a pixel of the whole picture.
    #[inline(always)]
    pub fn of_sample(&self, pixel: [u32; 2], number: u32) -> &T {
        &self.tracers[self.choice.of_sample(pixel, number)]
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.tracers.iter()
    }
}
