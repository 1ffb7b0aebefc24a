//! The command line: one file a subcommand; none opens the designer.
//!
//! Results go to files and to stdout, everything else to stderr. Exit codes: 0 done, 1 failed, 2 bad arguments or
//! preset.

pub mod arguments;
mod check;
pub mod exit;
mod export;
mod info;
mod render;
mod stats;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use self::arguments::BadArgument;
use crate::backend::BackendChoice;
use crate::designer::Folders;
use crate::files::{self, FileError, KnownOutside, Opened, Outside, Reading};

pub use stats::scene_bytes;

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
    /// Validate presets; print every fault with line and column.
    Check(check::CheckArguments),
    /// Write what a preset is made of: its loops, volumes or turbulence.
    #[command(subcommand)]
    Export(export::Export),
    /// Print version, adapters, limits and what would be used.
    Info,
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    exit::code(run)
}

fn run() -> anyhow::Result<()> {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help that was asked for.
        Err(error) if !error.use_stderr() => error.exit(),
        Err(error) => {
            // clap takes a mistyped command for a preset and complains about what follows it.
            reject_unknown_word(std::env::args_os().nth(1))?;
            error.exit()
        }
    };
    match arguments.command {
        Some(Command::Render(arguments)) => render::run(&arguments),
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

/// Reads a design for a command: images outside the folder of its file only where the user has `allowed` them, or where
/// the file is known, because they have saved it or opened it in the window.
fn read_design(path: &Path, sets: &[(String, String)], allowed: bool) -> Result<Opened, FileError> {
    let folders = Folders::of_user();
    let known = folders.map(|folders| KnownOutside::load(&folders.config));
    let known = known.unwrap_or_default();
    let outside = match allowed {
        true => Outside::Open,
        false => Outside::Known(&known),
    };
    files::read_design(path, Reading { sets, outside })
}

/// Refuses a first argument that is no option, no command, and nothing that can be opened.
fn reject_unknown_word(word: Option<OsString>) -> Result<(), BadArgument> {
    let Some(word) = word else { return Ok(()) };
    let text = word.to_string_lossy();
    let mut program = Arguments::command();
    // With `help`, which clap adds.
    program.build();
    let commands: Vec<&str> = program
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    if text.starts_with('-') || commands.contains(&&*text) || Path::new(&word).exists() {
        return Ok(());
    }
    Err(BadArgument(format!(
        "{text}: there is no such preset, nor such a command; commands are {}",
        commands.join(", ")
    )))
}
