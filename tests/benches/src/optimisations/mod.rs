//! What each optimisation is worth: one piece of work with it and without it, in turns.
//!
//! With, without, with, without …: what disturbs the machine hits both sides, and the ratio reported is the median of
//! the pairs. Pictures of both sides have the same seed and the same number of samples, so that an optimisation that is
//! exact shows none but rounding; how far two seeds are apart tells what noise alone does.

mod compiling;
mod drawing;
mod report;
mod switch;

use std::sync::Arc;
use std::time::{Duration, Instant};

use renderer_core::design::Design;
use renderer_core::render::{Backend, BackendKind, Counters, Optimisation};
use renderer_core::scene;
use towel_designer::advice::{Place, with_advice};
use towel_designer::backend::{self, BackendChoice};
use towel_designer::clock::Spent;

pub use report::{bars, counter_of, csv, section, verdict};
pub use switch::{Switch, curve_optimisations, drawing_optimisations, switch_of};

use crate::conditions::Conditions;
use crate::parts::Turns;

/// Most pairs of an optimisation.
const MOST_PAIRS: u32 = 15;

/// An optimisation, and what became of measuring it.
#[derive(Debug, Clone)]
pub struct OptimisationRow {
    /// Which.
    pub optimisation: Optimisation,
    /// What was found, or why nothing was.
    pub found: Result<Found, String>,
}

/// What an optimisation is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Who has the switch; compiling is the processor's work whatever draws.
    pub backend: BackendKind,
    /// What was done in a turn, as in "4 samples".
    pub work: String,
    /// With the optimisation.
    pub with: Side,
    /// Without it.
    pub without: Side,
    /// Cost without over cost with it: the median of the pairs.
    pub ratio: f64,
    /// How many pairs there were.
    pub pairs: u32,
    /// How far the pictures are apart.
    pub difference: Difference,
}

/// One side of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Side {
    /// The least that a turn took.
    pub spent: Spent,
    /// Work of a turn.
    pub counters: Counters,
    /// Sections that the compiler kept.
    pub sections_kept: u64,
}

/// How far the pictures with an optimisation and without it are apart.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Difference {
    /// relRMSE between the two.
    pub rel_rmse: f64,
    /// The largest difference of any channel of any pixel, radiance.
    pub largest: f64,
    /// relRMSE between two pictures with the optimisation, of different seeds.
    pub between_seeds: f64,
}

/// An optimisation that can be turned off, ready to be measured.
trait Trial {
    /// One turn, with the optimisation or without; `None` if time was up before it ended.
    fn turn(
        &mut self,
        backend: &mut dyn Backend,
        with: bool,
        deadline: Instant,
    ) -> anyhow::Result<Option<Spent>>;
    /// What both sides do and show. Not timed.
    fn compare(&mut self, backend: &mut dyn Backend) -> anyhow::Result<([Side; 2], Difference)>;
    /// What is done in a turn.
    fn work(&self) -> String;
}

/// The optimisations that were asked for on the backend given, and on a GPU of its own where only that has the switch.
///
/// # Errors
/// When a scene cannot be made or a backend fails.
pub fn measure(
    design: &Design,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Vec<OptimisationRow>> {
    let method = design.quality.method;
    let scene = Arc::new(scene::compile(design)?);
    let mut lines = Vec::new();
    let mut gpu: Option<Result<Box<dyn Backend>, String>> = None;
    // Up to an error takes longest: it comes last, and has what the others leave over.
    let kind = backend.kind();
    let is_to_error =
        |optimisation: &Optimisation| switch_of(*optimisation, kind, method) == Switch::Target;
    let mut order = Optimisation::ALL.to_vec();
    order.sort_by_key(is_to_error);
    for (index, optimisation) in order.into_iter().enumerate() {
        say(&format!("optimisation {optimisation}"));
        let to_come = if is_to_error(&optimisation) {
            1
        } else {
            // As much for the last one as for three others.
            (Optimisation::ALL.len() - index + 2) as u32
        };
        let now = Instant::now();
        let left = deadline.saturating_duration_since(now);
        let turns = Turns {
            deadline: now + left / to_come,
            most: MOST_PAIRS,
        };
        let one = |backend: &mut dyn Backend, switch| -> anyhow::Result<OptimisationRow> {
            let size = conditions.size;
            let found = match switch {
                Switch::Compiling => {
                    let mut trial = compiling::Recompiling::new(design, size, optimisation)?;
                    pairs(&mut trial, backend, turns)?
                }
                Switch::Drawing | Switch::Target => {
                    let new = match switch {
                        Switch::Target => drawing::Sampling::to_error,
                        _ => drawing::Sampling::new,
                    };
                    match new(design, &scene, size, optimisation, backend, turns.deadline)? {
                        Some(mut trial) => pairs(&mut trial, backend, turns)?,
                        None => None,
                    }
                }
                Switch::None => {
                    return Ok(OptimisationRow::not_measured(
                        optimisation,
                        "it has no switch that shows",
                    ));
                }
            };
            Ok(OptimisationRow {
                optimisation,
                found: found.ok_or_else(|| "time was up".into()),
            })
        };
        let here = switch_of(optimisation, kind, method);
        let there = switch_of(optimisation, BackendKind::Gpu, method);
        let line = if here != Switch::None || there == Switch::None {
            one(backend, here)?
        } else if Instant::now() >= deadline {
            OptimisationRow::not_measured(optimisation, "time was up")
        } else {
            let gpu = gpu.get_or_insert_with(|| {
                backend::make(BackendChoice::Gpu)
                    .map_err(|error| with_advice(&error, Place::CommandLine))
            });
            match gpu {
                Ok(gpu) => one(&mut **gpu, there)?,
                Err(reason) => {
                    OptimisationRow::not_measured(optimisation, &format!("GPU alone; {reason}"))
                }
            }
        };
        lines.push(line);
    }
    let place = |line: &OptimisationRow| {
        Optimisation::ALL
            .iter()
            .position(|optimisation| *optimisation == line.optimisation)
    };
    lines.sort_by_key(place);
    Ok(lines)
}

impl OptimisationRow {
    fn not_measured(optimisation: Optimisation, why: &str) -> Self {
        Self {
            optimisation,
            found: Err(why.into()),
        }
    }
}

/// Turns in pairs; `None` if not even one was made.
fn pairs(
    trial: &mut dyn Trial,
    backend: &mut dyn Backend,
    turns: Turns,
) -> anyhow::Result<Option<Found>> {
    let kind = backend.kind();
    let mut spent: [Vec<Spent>; 2] = Default::default();
    let mut long = Duration::ZERO;
    let mut pair = 0;
    // Comparing takes as long as three turns more.
    while turns.has_time_for(pair, 3 * long) {
        let start = Instant::now();
        // A first pair is always made, unless it takes much longer than there was time for.
        let until = match pair {
            0 => start + 4 * turns.deadline.saturating_duration_since(start) + LONGEST_FIRST,
            _ => turns.deadline + long,
        };
        let mut both = [Spent::default(); 2];
        for (spent, with) in both.iter_mut().zip([true, false]) {
            match trial.turn(backend, with, until)? {
                Some(turn) => *spent = turn,
                None if pair == 0 => return Ok(None),
                None => break,
            }
        }
        if both[1] == Spent::default() {
            break;
        }
        spent[0].push(both[0]);
        spent[1].push(both[1]);
        long = start.elapsed();
        pair += 1;
    }
    let (mut sides, difference) = trial.compare(backend)?;
    for (side, spent) in sides.iter_mut().zip(&spent) {
        side.spent = crate::drawing::least(spent.iter().copied()).unwrap_or_default();
    }
    let costs = spent[0].iter().zip(&spent[1]);
    let ratios = costs.map(|(with, without)| without.cost(kind) / with.cost(kind).max(1e-9));
    let [with, without] = sides;
    Ok(Some(Found {
        backend: kind,
        work: trial.work(),
        with,
        without,
        ratio: crate::drawing::median(ratios),
        pairs: pair,
        difference,
    }))
}

/// How long the first pair may take even where there is no time.
const LONGEST_FIRST: Duration = Duration::from_secs(2);
