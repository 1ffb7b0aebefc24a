//! What was found of optimisations: as CSV, Markdown and bars.

use std::fmt::Write as _;

use renderer_core::render::{Counters, Optimisation};

use super::{Difference, Found, OptimisationRow, Side};
use crate::conditions::Conditions;
use crate::csv::{OfPresets, number, quoted, table};
use crate::plot::{Bar, Bars};
use crate::units::seconds;

const HEADER: &str = "preset,optimisation,measured,backend,work of a turn,cost with [s],cost without [s],clock time \
    with [s],\
    clock time without [s],without : with [median of pairs],pairs,counter,counted with,counted without,\
    patch tests with,patch tests without,volume samples with,volume samples without,cells with,cells without,\
    difference of pictures [relRMSE],largest difference [radiance],difference of two seeds [relRMSE]";

/// Rounding of f32 sums, relRMSE: below it pictures count as the same.
const ROUNDING: f64 = 1e-5;

/// Ratio at which bars are cut: what is kept from scene to scene saves more than any plot can hold.
const CUT: f64 = 3.0;

/// The counter that moves when this optimisation does, and its name.
pub fn counter_of(optimisation: Optimisation, side: &Side) -> Option<(&'static str, u64)> {
    let Counters {
        skipped_tiles,
        converged_tiles,
        skipped_cells,
        repeated_tests,
        ended_rays,
        hidden_rays,
        ..
    } = side.counters;
    match optimisation {
        Optimisation::EmptyCells => Some(("cells", skipped_cells)),
        Optimisation::RepeatedTests => Some(("patch tests", repeated_tests)),
        Optimisation::BackgroundTiles => Some(("samples of tiles", skipped_tiles)),
        Optimisation::ConvergedTiles => Some(("samples of tiles", converged_tiles)),
        Optimisation::OpaqueRays => Some(("shadow rays", ended_rays)),
        Optimisation::HiddenGround => Some(("rays", hidden_rays)),
        Optimisation::UnchangedSections => Some(("sections", side.sections_kept)),
        Optimisation::UnusedShading
        | Optimisation::WeighedEvents
        | Optimisation::LastLooks
        | Optimisation::LaterLights => None,
    }
}

/// The file.
pub fn csv(all: &OfPresets<'_, [OptimisationRow]>) -> String {
    let lines = all
        .iter()
        .flat_map(|(preset, lines)| lines.iter().map(move |line| (*preset, line)));
    table(HEADER, lines.map(|(preset, line)| csv_line(preset, line)))
}

fn csv_line(preset: &str, line: &OptimisationRow) -> String {
    let mut fields = vec![quoted(preset), line.optimisation.name().into()];
    match &line.found {
        Err(why) => {
            fields.push(quoted(&format!("no: {why}")));
            fields.resize(HEADER.split(',').count(), String::new());
        }
        Ok(found) => {
            let (with, without) = (&found.with, &found.without);
            fields.extend(["yes".into(), found.backend.name().into()]);
            fields.push(quoted(&found.work));
            fields.extend([with, without].map(|side| number(side.spent.cost(found.backend))));
            fields.extend([with, without].map(|side| number(side.spent.wall.as_secs_f64())));
            fields.extend([number(found.ratio), found.pairs.to_string()]);
            let counters = [with, without].map(|side| counter_of(line.optimisation, side));
            fields.push(counters[0].map_or("", |(name, _)| name).into());
            fields.extend(counters.map(|c| c.map_or_else(String::new, |(_, n)| n.to_string())));
            for count in [
                |c: &Counters| c.patch_tests,
                |c: &Counters| c.volume_samples,
                |c: &Counters| c.cells,
            ] {
                fields.extend([with, without].map(|side| count(&side.counters).to_string()));
            }
            let Difference {
                rel_rmse,
                largest,
                between_seeds,
            } = found.difference;
            fields.extend([rel_rmse, largest, between_seeds].map(number));
        }
    }
    fields.join(",")
}

/// What the difference of pictures says.
pub fn verdict(difference: &Difference) -> String {
    let Difference {
        rel_rmse,
        between_seeds,
        ..
    } = *difference;
    if rel_rmse == 0.0 {
        "none".into()
    } else if rel_rmse < ROUNDING {
        format!("rounding, {rel_rmse:.0e}")
    } else if rel_rmse < between_seeds {
        let share = 100.0 * rel_rmse / between_seeds;
        format!("{rel_rmse:.2e}, {share:.2} % of that of two seeds")
    } else {
        format!("{rel_rmse:.2e}, no less than that of two seeds")
    }
}

/// The section of the summary.
pub fn section(lines: &[OptimisationRow]) -> String {
    let mut text = String::from(
        "\n| optimisation | work | backend | with | without | without : with | patch tests | left out | difference of \
            pictures |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for line in lines {
        let rest = match &line.found {
            Ok(found) => measured(line.optimisation, found),
            Err(why) => format!("not measured: {why} | | | | | | | "),
        };
        let _ = writeln!(text, "| `{}` | {rest} |", line.optimisation);
    }
    text
}

fn measured(optimisation: Optimisation, found: &Found) -> String {
    let tests = [found.with, found.without].map(|side| side.counters.patch_tests);
    let tests = match tests {
        [0, 0] => "–".into(),
        [with, without] => format!(
            "{:.2} times as many without",
            without as f64 / with.max(1) as f64
        ),
    };
    let left_out = match counter_of(optimisation, &found.with) {
        Some((name, count)) => format!("{count} {name}"),
        None => "code".into(),
    };
    format!(
        "{} | {} | {} | {} | {:.2} ({} pairs) | {tests} | {left_out} | {}",
        found.work,
        found.backend.name(),
        seconds(found.with.spent.cost(found.backend)),
        seconds(found.without.spent.cost(found.backend)),
        found.ratio,
        found.pairs,
        verdict(&found.difference),
    )
}

/// Time without each optimisation, as bars.
pub fn bars(preset: &str, conditions: &Conditions, lines: &[OptimisationRow]) -> Bars {
    let bar = |line: &OptimisationRow| match &line.found {
        Ok(found) => Bar {
            name: line.optimisation.to_string(),
            value: Some(found.ratio),
            text: format!("{:.2} ({})", found.ratio, found.backend.name()),
        },
        Err(_) => Bar {
            name: line.optimisation.to_string(),
            value: None,
            text: "not measured".into(),
        },
    };
    Bars {
        title: format!("{preset}: time without each optimisation"),
        under: conditions.to_string(),
        axis: "time without the optimisation : time with it".into(),
        bars: lines.iter().map(bar).collect(),
        limit: Some((1.0, "no gain".into())),
        cut: Some(CUT),
    }
}
