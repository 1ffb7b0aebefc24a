//! Which level of detail each sample of a picture is drawn in, and what draws each level on the host.

use crate::sampling::{self, Sampler, Set, pixel_seed};
use crate::scene::lod::{LevelRows, LodView};

use super::RenderRequest;

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
            rows: request.view.rows(request.size[1]),
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
    /// How many levels there are, the nearest included.
    pub fn level_count(&self) -> usize {
        self.view.levels.len()
    }

    /// The picture as one level alone shows it; the nearest for any number beyond the last.
    pub fn at_level(&self, number: usize) -> Self {
        let level = self.view.levels.get(number);
        let level = level.unwrap_or(&self.view.levels.nearest);
        Self {
            view: LodView::of_level(level.clone()),
            ..self.clone()
        }
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
