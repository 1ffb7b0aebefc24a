//! The files that `bench` writes: a table a part, the summary, and the plots of each preset.

use std::path::Path;

use super::parts::Part;
use super::plot::{Figure, Plot};
use super::{
    Conditions, Measured, backends, costs, csv, distances, first_picture, growth, skips, summary,
    variants,
};
use crate::files;

/// The table of a part.
fn table_name(part: Part) -> &'static str {
    match part {
        Part::Errors => "bench.csv",
        Part::Skips => "skips.csv",
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
        let text = match part {
            Part::Errors => csv::write(conditions, all),
            Part::Skips => skips::csv(all),
            Part::Backends => backends::csv(all, conditions),
            Part::Growth => growth::csv(all, conditions),
            Part::FirstPicture => first_picture::csv(all),
            Part::Lights => variants::csv("light", all, |measured| &measured.lights, conditions),
            Part::Piles => variants::csv("pile", all, |measured| &measured.piles, conditions),
            Part::Forms => variants::csv("form", all, |measured| &measured.forms, conditions),
            Part::Distances => distances::csv(all),
            Part::Costs => costs::csv(all),
        };
        files::write_atomically(&folder.join(table_name(*part)), text.as_bytes())?;
    }
    let text = summary::write(conditions, all);
    files::write_atomically(&folder.join("summary.md"), text.as_bytes())?;
    Ok(())
}

fn plots(folder: &Path, conditions: &Conditions, measured: &Measured) -> anyhow::Result<()> {
    let preset = &*measured.name;
    for findings in &measured.findings {
        let name = match findings.target.bounces {
            1 => preset.to_owned(),
            bounces => format!("{preset}-bounces-{bounces}"),
        };
        put(folder, &name, &Plot::new(preset, conditions, findings))?;
        if let Some(plot) = Plot::of_skips(preset, conditions, findings) {
            put(folder, &format!("{name}-without-skips"), &plot)?;
        }
    }
    let with = |end: &str| format!("{preset}-{end}");
    if !measured.skips.is_empty() {
        let bars = skips::bars(preset, conditions, &measured.skips);
        put(folder, &with("skips"), &bars)?;
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
