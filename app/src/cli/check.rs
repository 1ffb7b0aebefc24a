//! `check`: validates presets and the images they name, and prints every fault.

use std::io::Write;
use std::path::PathBuf;

use super::BadArgument;
use crate::files::load_design;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    /// Presets to check.
    #[arg(required = true)]
    files: Vec<PathBuf>,
}

/// Prints a line for each sound preset, and every fault of the others to stderr.
pub fn run(arguments: &CheckArguments) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    let mut faulty = 0;
    for file in &arguments.files {
        match load_design(file) {
            Ok(design) => {
                for warning in design.warnings() {
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
