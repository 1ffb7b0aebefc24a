//! What was found of skips: as CSV, Markdown and bars.

use std::fmt::Write as _;

use renderer_core::render::{Counters, Optimisation};

use super::super::csv::{number, quoted, table};
use super::super::plot::{Bar, Bars};
use super::super::summary::seconds;
use super::super::{Conditions, Measured};
use super::{Difference, Found, Line, Side};

const HEADER: &str = "preset,skip,measured,backend,work of a turn,cost with [s],cost without [s],clock time with [s],\
    clock time without [s],without : with [median of pairs],pairs,counter,counted with,counted without,\
    patch tests with,patch tests without,volume samples with,volume samples without,cells with,cells without,\
    difference of pictures [relRMSE],largest difference [radiance],difference of two seeds [relRMSE]";

/// Rounding of f32 sums, relRMSE: below it pictures count as the same.
const ROUNDING: f64 = 1e-5;

/// Ratio at which bars are cut: what is kept from scene to scene saves more than any plot can hold.
const CUT: f64 = 3.0;

/// The counter that moves when this skip does, and its name.
pub fn counter_of(skip: Optimisation, side: &Side) -> Option<(&'static str, u64)> {
    let Counters {
        skipped_tiles,
        converged_tiles,
        skipped_cells,
        repeated_tests,
        ended_rays,
        hidden_rays,
        ..
    } = side.counters;
    let [kept, left_out] = side.left_out;
    match skip {
        Optimisation::EmptyCells => Some(("cells", skipped_cells)),
        Optimisation::RepeatedTests => Some(("patch tests", repeated_tests)),
        Optimisation::BackgroundTiles => Some(("samples of tiles", skipped_tiles)),
        Optimisation::ConvergedTiles => Some(("samples of tiles", converged_tiles)),
        Optimisation::OpaqueRays => Some(("shadow rays", ended_rays)),
        Optimisation::HiddenGround => Some(("rays", hidden_rays)),
        Optimisation::UnchangedSections => Some(("sections", kept)),
        Optimisation::UnplantedLoops => Some(("frames", left_out)),
        Optimisation::UnusedShading | Optimisation::Idle => None,
    }
}

/// The file.
pub fn csv(all: &[Measured]) -> String {
    let lines = all
        .iter()
        .flat_map(|measured| measured.skips.iter().map(|line| (&*measured.name, line)));
    table(HEADER, lines.map(|(preset, line)| csv_line(preset, line)))
}

fn csv_line(preset: &str, line: &Line) -> String {
    let mut fields = vec![quoted(preset), line.skip.name().into()];
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
            let counters = [with, without].map(|side| counter_of(line.skip, side));
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
pub fn section(lines: &[Line]) -> String {
    let mut text = String::from(
        "\n| skip | work | backend | with | without | without : with | patch tests | left out | difference of pictures |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for line in lines {
        let rest = match &line.found {
            Ok(found) => measured(line.skip, found),
            Err(why) => format!("not measured: {why} | | | | | | | "),
        };
        let _ = writeln!(text, "| `{}` | {rest} |", line.skip);
    }
    text
}

fn measured(skip: Optimisation, found: &Found) -> String {
    let tests = [found.with, found.without].map(|side| side.counters.patch_tests);
    let tests = match tests {
        [0, 0] => "–".into(),
        [with, without] => format!(
            "{:.2} times as many without",
            without as f64 / with.max(1) as f64
        ),
    };
    let left_out = match counter_of(skip, &found.with) {
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

/// Time without each skip, as bars.
pub fn bars(preset: &str, conditions: &Conditions, lines: &[Line]) -> Bars {
    let bar = |line: &Line| match &line.found {
        Ok(found) => Bar {
            name: line.skip.to_string(),
            value: Some(found.ratio),
            text: format!("{:.2} ({})", found.ratio, found.backend.name()),
        },
        Err(_) => Bar {
            name: line.skip.to_string(),
            value: None,
            text: "not measured".into(),
        },
    };
    Bars {
        title: format!("{preset}: time without each skip"),
        under: conditions.to_string(),
        axis: "time without the skip : time with it".into(),
        bars: lines.iter().map(bar).collect(),
        limit: Some((1.0, "no gain".into())),
        cut: Some(CUT),
    }
}
