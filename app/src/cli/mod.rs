//! The command line: one file a subcommand; none opens the designer.
//!
//! Results go to files and to stdout, everything else to stderr. Exit codes: 0 done, 1 failed, 2 bad arguments or
//! preset.

mod arguments;
pub mod bench;
mod check;
mod edits;
mod export;
mod info;
mod pace;
mod render;
mod stats;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use renderer_core::render::RenderError;
use renderer_core::scene::CompileError;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

use crate::advice::{Place, with_advice, with_advice_on_cloth};
use crate::backend::BackendChoice;
use crate::files::FileError;

/// Design towels and carpets and see every yarn loop while you do. Without a command, the designer opens.
#[derive(Debug, Parser)]
#[command(
    name = "towel-designer",
    args_conflicts_with_subcommands = true,
    disable_version_flag = true
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// Preset to open in the designer.
    preset: Option<PathBuf>,
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Print version, adapters, limits and what would be used.
    #[arg(short = 'V', long)]
    version: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a preset to a PNG (as displayed) or EXR (linear) file.
    Render(Box<render::RenderArguments>),
    /// Measure what presets cost: run time against error, skips, backends, growth, first pictures; tables, plots and a
    /// summary.
    Bench(bench::BenchArguments),
    /// Measure how smoothly the window goes while it renders: the times between its frames.
    Pace(pace::PaceArguments),
    /// Measure how long an edit takes until the picture is whole again.
    Edits(edits::EditsArguments),
    /// Validate presets; print every fault with line and column.
    Check(check::CheckArguments),
    /// Write what a preset is made of: its loops, volumes or turbulence.
    #[command(subcommand)]
    Export(export::Export),
    /// Print version, adapters, limits and what would be used.
    Info,
}

/// An argument that cannot be used, found after parsing.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct BadArgument(String);

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    start_log();
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        // Who reads our output has seen enough, as in `towel-designer info | head -1`.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", message(&error));
            ExitCode::from(if is_bad_input(&error) { 2 } else { 1 })
        }
    }
}

/// Warnings, and what the variable RUST_LOG asks for, go to stderr.
fn start_log() {
    let filter = EnvFilter::builder()
        .with_default_directive(LevelFilter::WARN.into())
        .from_env_lossy();
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_env_filter(filter)
        .without_time()
        .init();
}

fn run() -> anyhow::Result<()> {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // clap takes a mistyped command for a preset and complains about what follows it.
            reject_unknown_word(std::env::args_os().nth(1))?;
            error.exit()
        }
    };
    match arguments.command {
        Some(Command::Render(arguments)) => render::run(&arguments),
        Some(Command::Bench(arguments)) => bench::run(&arguments),
        Some(Command::Pace(arguments)) => pace::run(&arguments),
        Some(Command::Edits(arguments)) => edits::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Export(export)) => export::run(&export),
        Some(Command::Info) => info::run(),
        None if arguments.version => info::run(),
        None => {
            let preset = arguments.preset;
            reject_unknown_word(preset.clone().map(PathBuf::into_os_string))?;
            crate::designer::run(preset, arguments.backend)
        }
    }
}

/// Refuses a first argument that is no option, command or file.
fn reject_unknown_word(word: Option<OsString>) -> Result<(), BadArgument> {
    let Some(word) = word else { return Ok(()) };
    let text = word.to_string_lossy();
    let program = Arguments::command();
    let commands: Vec<&str> = program
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    if text.starts_with('-') || commands.contains(&&*text) || Path::new(&word).is_file() {
        return Ok(());
    }
    Err(BadArgument(format!(
        "{text}: there is no such preset, nor such a command; commands are {}",
        commands.join(", ")
    )))
}

/// The error with what helps. Messages are whole sentences: they name their cause themselves.
fn message(error: &anyhow::Error) -> String {
    let render = error.chain().find_map(|cause| cause.downcast_ref());
    let cloth = error.chain().find_map(|cause| cause.downcast_ref());
    match (render, cloth) {
        (Some(error), _) => with_advice(error, Place::CommandLine),
        (None, Some(error)) => with_advice_on_cloth(error),
        (None, None) => error.to_string(),
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io: Option<&std::io::Error> = error.downcast_ref();
    io.is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Whether what the user gave is at fault, rather than the machine.
fn is_bad_input(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause.is::<BadArgument>()
            || cause.is::<CompileError>()
            || cause
                .downcast_ref::<FileError>()
                .is_some_and(FileError::is_bad_input)
            || matches!(
                cause.downcast_ref(),
                Some(RenderError::Size(_) | RenderError::BeyondAdapter { .. })
            )
    })
}
