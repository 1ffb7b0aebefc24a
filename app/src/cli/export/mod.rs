//! `export`: what a preset is made of, for other programs.

mod glb;
mod loops;
mod surroundings;
mod turbulence;
mod volume;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use renderer_core::design::Design;
use renderer_core::scene::ChartComposer;

use super::arguments::{self, BadArgument};
use super::read_design;
use crate::files::{self, FileError, Opened, UsedFile};

/// What to export.
#[derive(Debug, Subcommand)]
pub enum Export {
    /// Every loop, as .json or .glb.
    ///
    /// JSON has every loop's cell, patch, normal, colour, albedo, length, kind of pile, volume, density (1/mm, of solid
    /// yarn) and phase function, one loop a line, and the ground, cameras and lights beside them. In glTF (.glb) there
    /// are patches and colours alone.
    Loops(ExportArguments),
    /// The volumes inside the loops, a PNG a layer, into a folder.
    ///
    /// Alpha is the density, A = 255·ρ, and gray the shade that multiplies the albedo, L = 255·shade. Row 0 is at v =
    /// 1, the loop's top, column 0 at u = 0, layer 0 at w = −½: pixel (x, y) of n × n in layer l of m is the voxel
    /// around u = (x + ½)/n, v = 1 − (y + ½)/n, w = (l + ½)/m − ½.
    Volume(ExportArguments),
    /// The four channels of the turbulence, one pixel a cell, as .exr.
    Turbulence(ExportArguments),
}

/// Arguments of every export.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Preset to read.
    preset: PathBuf,
    /// File or folder to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Change a field of the preset, as in turbulence.seed=3.
    #[arg(long, value_name = "PATH=VALUE", value_parser = arguments::field_and_value)]
    set: Vec<(String, String)>,
    /// Open images that the preset names outside its own folder.
    #[arg(long)]
    allow_outside_images: bool,
}

/// Reads, computes and writes.
pub fn run(export: &Export) -> anyhow::Result<()> {
    match export {
        Export::Loops(arguments) => {
            let format = extension(&arguments.output, &["json", "glb"])?;
            let design = open(arguments)?;
            match format {
                "glb" => glb::write(&design, &arguments.output),
                _ => loops::write(&design, &arguments.output),
            }
        }
        Export::Volume(arguments) => {
            let opened = load(arguments)?;
            volume::write(&opened.design, &opened.read, &arguments.output)
        }
        Export::Turbulence(arguments) => {
            extension(&arguments.output, &["exr"])?;
            turbulence::write(&open(arguments)?, &arguments.output)
        }
    }
}

fn load(arguments: &ExportArguments) -> Result<Opened, FileError> {
    let ExportArguments { preset, set, .. } = arguments;
    let opened = read_design(preset, set, arguments.allow_outside_images)?;
    for warning in &opened.warnings {
        eprintln!("warning: {warning}");
    }
    Ok(opened)
}

/// Reads the preset and makes sure that the output can be written, and is none of the files that were read.
fn open(arguments: &ExportArguments) -> anyhow::Result<Design> {
    let opened = load(arguments)?;
    let output = UsedFile::new(&arguments.output, "the file to write (-o)");
    files::check_apart(&opened.read, &[output])?;
    files::check_writable(&arguments.output)?;
    // Objects on the chart are drawn once.
    let design = ChartComposer::default().design(&opened.design).into_owned();
    Ok(design)
}

/// The output's extension, which must be one of `allowed`.
fn extension(output: &Path, allowed: &[&'static str]) -> Result<&'static str, BadArgument> {
    let found = output
        .extension()
        .and_then(OsStr::to_str)
        .unwrap_or_default();
    let known = allowed
        .iter()
        .find(|known| found.eq_ignore_ascii_case(known));
    known.copied().ok_or_else(|| {
        let names: Vec<String> = allowed.iter().map(|name| format!(".{name}")).collect();
        BadArgument(format!(
            "the output is {}, allowed are names that end in {}",
            output.display(),
            names.join(" or ")
        ))
    })
}
