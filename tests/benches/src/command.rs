//! The command line: one file a subcommand.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use towel_designer::cli::exit;

use crate::{bench, edits, pace, quiet};

/// Measure what Towel Designer costs.
#[derive(Debug, Parser)]
#[command(name = "towel-bench")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure what presets cost: run time against error, optimisations, backends, growth, first pictures; tables,
    /// plots and a summary.
    Bench(bench::BenchArguments),
    /// Measure how smoothly the window goes while it renders: the times between its frames.
    Pace(pace::PaceArguments),
    /// Measure how long an edit takes until the picture is whole again.
    Edits(edits::EditsArguments),
    /// Measure how long after an edit the window's picture is quiet, with denoising and without, and what denoising is
    /// worth at each number of samples.
    Quiet(quiet::QuietArguments),
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    exit::code(|| match Arguments::parse().command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Pace(arguments) => pace::run(&arguments),
        Command::Edits(arguments) => edits::run(&arguments),
        Command::Quiet(arguments) => quiet::run(&arguments),
    })
}
