//! `check`: validates presets, bundles and pictures that carry a design, with the images they name, and prints every
//! fault.

use std::io::Write;
use std::path::PathBuf;

use super::arguments::BadArgument;
use renderer_core::scene::ChartYarns;

use crate::files::open_design;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    /// Presets, bundles, or pictures that carry their design.
    #[arg(required = true)]
    files: Vec<PathBuf>,
}

/// Prints a line for each sound preset, and every fault of the others to stderr.
pub fn run(arguments: &CheckArguments) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    let mut faulty = 0;
    for file in &arguments.files {
        match open_design(file) {
            Ok(opened) => {
                for warning in &opened.warnings {
                    eprintln!("warning: {warning}");
                }
                let design = &opened.design;
                let of_chart = ChartYarns::default().warning(design);
                for warning in design.warnings().into_iter().chain(of_chart) {
                    eprintln!("{}: warning: {warning}", file.display());
                }
                writeln!(out, "{}: ok", file.display())?;
            }
            Err(error) => {
                eprintln!("{error}");
                faulty += 1;
            }
        }
    }
    match (faulty, arguments.files.len()) {
        (0, _) => Ok(()),
        (_, 1) => Err(BadArgument("the preset has faults".into()).into()),
        (faulty, all) => Err(BadArgument(format!("{faulty} of {all} presets have faults")).into()),
    }
}
