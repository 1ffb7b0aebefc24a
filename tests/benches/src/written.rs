//! The files that `bench` writes: a table a part, the summary, and the plots of each preset.

use std::path::Path;

use towel_designer::files;

use crate::conditions::Conditions;
use crate::measured::Measured;
use crate::parts::Part;
use crate::plot::{Figure, Plot};
use crate::{
    backends, costs, distances, error_table, first_picture, growth, optimisations, summary,
    variants,
};

/// The file of a part's table.
fn table_name(part: Part) -> &'static str {
    match part {
        Part::Errors => "bench.csv",
        Part::Optimisations => "optimisations.csv",
        Part::Backends => "backends.csv",
        Part::Growth => "growth.csv",
        Part::FirstPicture => "first-picture.csv",
        Part::Lights => "lights.csv",
        Part::Piles => "piles.csv",
        Part::Forms => "forms.csv",
        Part::Distances => "distances.csv",
        Part::Costs => "costs.csv",
    }
}

/// Names of the files that a run writes whatever the presets.
pub fn names(parts: &[Part]) -> Vec<&'static str> {
    let tables = parts.iter().map(|part| table_name(*part));
    tables.chain(["summary.md"]).collect()
}

/// Writes tables, summary and the last preset's plots.
pub fn write(
    folder: &Path,
    conditions: &Conditions,
    parts: &[Part],
    all: &[Measured],
) -> anyhow::Result<()> {
    if let Some(measured) = all.last() {
        plots(folder, conditions, measured)?;
    }
    for part in parts {
        let text = table(*part, conditions, all);
        files::write_atomically(&folder.join(table_name(*part)), text.as_bytes())?;
    }
    let text = summary::write(conditions, all);
    files::write_atomically(&folder.join("summary.md"), text.as_bytes())?;
    Ok(())
}

/// The table of a part.
fn table(part: Part, conditions: &Conditions, all: &[Measured]) -> String {
    match part {
        Part::Errors => error_table::csv(conditions, &of(all, |measured| &measured.findings[..])),
        Part::Optimisations => optimisations::csv(&of(all, |measured| &measured.optimisations[..])),
        Part::Backends => backends::csv(&of(all, |measured| &measured.backends[..]), conditions),
        Part::Growth => growth::csv(&of(all, |measured| &measured.growth), conditions),
        Part::FirstPicture => first_picture::csv(&of(all, |measured| &measured.first_pictures)),
        Part::Lights => {
            let lights = of(all, |measured| &measured.lights[..]);
            variants::csv("light", &lights, conditions)
        }
        Part::Piles => {
            let piles = of(all, |measured| &measured.piles[..]);
            variants::csv("pile", &piles, conditions)
        }
        Part::Forms => {
            let forms = of(all, |measured| &measured.forms[..]);
            variants::csv("form", &forms, conditions)
        }
        Part::Distances => distances::csv(&of(all, |measured| &measured.distances[..])),
        Part::Costs => costs::csv(&of(all, |measured| &measured.costs[..])),
    }
}

/// What was found of each preset by one part.
fn of<T: ?Sized>(all: &[Measured], found: fn(&Measured) -> &T) -> Vec<(&str, &T)> {
    all.iter()
        .map(|measured| (&*measured.name, found(measured)))
        .collect()
}

fn plots(folder: &Path, conditions: &Conditions, measured: &Measured) -> anyhow::Result<()> {
    let preset = &*measured.name;
    for findings in &measured.findings {
        let name = match findings.target.bounces {
            1 => preset.to_owned(),
            bounces => format!("{preset}-bounces-{bounces}"),
        };
        put(folder, &name, &Plot::new(preset, conditions, findings))?;
        if let Some(plot) = Plot::of_optimisations(preset, conditions, findings) {
            put(folder, &format!("{name}-without-optimisations"), &plot)?;
        }
    }
    let with = |end: &str| format!("{preset}-{end}");
    if !measured.optimisations.is_empty() {
        let bars = optimisations::bars(preset, conditions, &measured.optimisations);
        put(folder, &with("optimisations"), &bars)?;
    }
    if !measured.backends.is_empty() {
        let bars = backends::bars(preset, conditions, &measured.backends);
        put(folder, &with("backends"), &bars)?;
    }
    if let Some(growth) = &measured.growth {
        for (end, curves) in growth::plots(preset, conditions, growth) {
            put(folder, &with(end), &curves)?;
        }
    }
    let found = measured.first_pictures.as_ref();
    if let Some(bars) = found.and_then(|found| first_picture::bars(preset, conditions, found)) {
        put(folder, &with("first-picture"), &bars)?;
    }
    if !measured.costs.is_empty() {
        let bars = costs::bars(preset, conditions, &measured.costs);
        put(folder, &with("costs"), &bars)?;
    }
    Ok(())
}

/// Writes a plot as SVG and PNG.
fn put(folder: &Path, name: &str, figure: &impl Figure) -> anyhow::Result<()> {
    let path = |extension: &str| folder.join(format!("{name}.{extension}"));
    files::write_atomically(&path("svg"), figure.svg()?.as_bytes())?;
    files::write_atomically(&path("png"), &figure.png()?)?;
    Ok(())
}
