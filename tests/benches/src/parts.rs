//! What `bench` can measure, and how the time of a preset is shared among it.

use std::time::{Duration, Instant};

/// A part of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Run time against error of every method, and of one method without each optimisation.
    Errors,
    /// With and without each optimisation in turns: time, counters, pictures.
    #[value(alias = "skips")]
    Optimisations,
    /// One picture by every backend of this machine.
    Backends,
    /// Time and memory as loops and pixels grow.
    Growth,
    /// From an edit to the first coarse picture in the window, for each kind of edit.
    FirstPicture,
    /// Kinds of light on the same cloth: time and noise.
    Lights,
    /// One cloth with each kind of pile, and after each finish: time and noise.
    Piles,
    /// One cloth bent in each way: time and noise.
    Forms,
    /// A large cloth from farther and farther: regions of it beside the whole.
    Distances,
    /// Where the time from an edit to a whole picture goes.
    Costs,
}

impl Part {
    /// All of them, in the order in which they are measured.
    pub const ALL: [Self; 10] = [
        Self::Errors,
        Self::Optimisations,
        Self::Backends,
        Self::Growth,
        Self::FirstPicture,
        Self::Lights,
        Self::Piles,
        Self::Forms,
        Self::Distances,
        Self::Costs,
    ];

    /// Share of the time, in parts of the sum over what is measured.
    fn weight(self) -> f64 {
        match self {
            Self::Errors => 6.0,
            Self::Optimisations | Self::Growth | Self::FirstPicture => 4.0,
            Self::Backends
            | Self::Lights
            | Self::Piles
            | Self::Forms
            | Self::Distances
            | Self::Costs => 2.0,
        }
    }
}

/// The parts asked for, each once and in the order of [`Part::ALL`]; all where none is.
pub fn chosen(asked: &[Part]) -> Vec<Part> {
    let is_chosen = |part: &Part| asked.is_empty() || asked.contains(part);
    Part::ALL.into_iter().filter(is_chosen).collect()
}

/// Until when the first of `parts` may go on, if the others are to have their time before `deadline`. What a part
/// leaves over is shared by those to come.
pub fn deadline_of_first(parts: &[Part], deadline: Instant) -> Instant {
    let now = Instant::now();
    let left = deadline.saturating_duration_since(now);
    now + left.mul_f64(share_of_first(parts))
}

/// The share of the time left that the first of `parts` has.
pub fn share_of_first(parts: &[Part]) -> f64 {
    let weights: f64 = parts.iter().map(|part| part.weight()).sum();
    parts.first().map_or(0.0, |part| part.weight() / weights)
}

/// How a piece of work is repeated: at least once, and not again when time is up.
#[derive(Debug, Clone, Copy)]
pub struct Turns {
    /// Until when.
    pub deadline: Instant,
    /// At most so often.
    pub most: u32,
}

impl Turns {
    /// Whether there is time for turn number `turn`, from 0, which will take about so long.
    pub fn has_time_for(&self, turn: u32, long: Duration) -> bool {
        turn == 0 || (turn < self.most && Instant::now() + long < self.deadline)
    }
}
