//! From an edit to the first coarse picture of it in the window, for each kind of edit, against one sample of the whole
//! window.

mod edits;
mod report;

use std::sync::Arc;
use std::time::Instant;

use renderer_core::design::Design;
use towel_designer::backend::{self, BackendChoice};
use towel_designer::clock::Spent;

pub use edits::{Edit, camera, edit};
pub use report::{bars, csv, section};

use crate::coarse_preview::{FirstPicture, LatencyProbe};
use crate::drawing::median;

/// Most rounds; every second one takes back the edits of the one before.
const MOST_ROUNDS: u32 = 6;

/// What was found.
#[derive(Debug, Clone, Default)]
pub struct FirstPictures {
    /// Width and height of the window's picture, pixels.
    pub window: [u32; 2],
    /// Each edit with its first pictures, in the order of rounds.
    pub edits: Vec<(Edit, Vec<FirstPicture>)>,
    /// Whole samples.
    pub whole: Vec<Spent>,
    /// Whether time was up before every edit had a picture.
    pub is_partial: bool,
}

/// Which clock.
type Clock = fn(&Spent) -> Option<f64>;

/// By the clock on the wall, s.
const WALL: Clock = |spent| Some(spent.wall.as_secs_f64());
/// On all cores together, s.
const PROCESSOR: Clock = |spent| spent.processor.map(|time| time.as_secs_f64());

impl FirstPictures {
    /// Middle time of a whole sample, s.
    fn whole_sample(&self, clock: Clock) -> Option<f64> {
        middle(self.whole.iter(), clock)
    }

    /// Time of the first pictures as a share of that of a whole sample.
    fn share(&self, pictures: &[FirstPicture], clock: Clock) -> Option<f64> {
        let first = middle(pictures.iter().map(|picture| &picture.spent), clock)?;
        Some(first / self.whole_sample(clock)?)
    }
}

fn middle<'a>(all: impl Iterator<Item = &'a Spent>, clock: Clock) -> Option<f64> {
    let times: Option<Vec<f64>> = all.map(clock).collect();
    times.filter(|times| !times.is_empty()).map(median)
}

/// Makes every kind of edit and takes it back, in turns with whole samples.
///
/// # Errors
/// When the render thread or the backend fails.
pub fn measure(
    design: &Design,
    choice: BackendChoice,
    window: [u32; 2],
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<FirstPictures> {
    say("first picture: opening");
    let mut found = FirstPictures {
        window,
        edits: Edit::ALL.map(|edit| (edit, Vec::new())).to_vec(),
        whole: Vec::new(),
        is_partial: true,
    };
    let mut watch = LatencyProbe::new(Arc::new(backend::make), choice, design, window)?;
    if !watch.rest(deadline)? {
        return Ok(found);
    }
    let original = watch.design().clone();
    let choice = choice.for_method(original.quality.method);
    let mut whole = backend::make(choice)?;
    let mut seed = original.quality.seed;
    let mut one_whole = |watch: &LatencyProbe| {
        seed = seed.wrapping_add(1);
        watch.whole_sample(&mut *whole, seed, deadline)
    };
    for round in 0..MOST_ROUNDS {
        let forth = round % 2 == 0;
        for (kind, pictures) in &mut found.edits {
            say(&format!(
                "first picture: {}, round {}",
                kind.name(),
                round + 1
            ));
            let first = match kind {
                Edit::Camera | Edit::Pan => watch.look(deadline, |seen| {
                    if let Some(first) = original.view.cameras.first() {
                        *seen = camera(first, *kind, forth);
                    }
                })?,
                _ => watch.edit(deadline, |design| edit(design, *kind, &original, forth))?,
            };
            let Some(first) = first else {
                return Ok(found);
            };
            pictures.push(first);
            if !watch.rest(deadline)? {
                return Ok(FirstPictures {
                    is_partial: round == 0 && *kind != Edit::Chart,
                    ..found
                });
            }
        }
        found.is_partial = false;
        // One after the first round, and one after the last: they take longer than all the rest.
        if round == 0 || round + 1 == MOST_ROUNDS {
            found.whole.extend(one_whole(&watch)?);
        }
    }
    Ok(found)
}
