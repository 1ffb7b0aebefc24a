//! How a program on the command line ends: its log, its last message, its exit code.

use std::process::ExitCode;

use renderer_core::render::RenderError;
use renderer_core::scene::CompileError;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use super::arguments::BadArgument;
use crate::advice::{Place, with_advice, with_advice_on_cloth, with_advice_on_file};
use crate::files::FileError;

/// Runs a program; its error goes to stderr. Exit codes: 0 done, 1 failed, 2 bad arguments or preset.
pub fn code(program: impl FnOnce() -> anyhow::Result<()>) -> ExitCode {
    start_log();
    match program() {
        Ok(()) => ExitCode::SUCCESS,
        // Who reads our output has seen enough, as in `towel-designer info | head -1`.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", message(&error));
            ExitCode::from(if is_bad_input(&error) { 2 } else { 1 })
        }
    }
}

/// Warnings go to stderr, or what the variable RUST_LOG asks for, as in `debug` or `renderer_core=debug,warn`.
fn start_log() {
    let asked = std::env::var("RUST_LOG").unwrap_or_default();
    let filter = match asked.parse::<Targets>() {
        Ok(filter) if !asked.is_empty() => filter,
        _ => Targets::new().with_default(LevelFilter::WARN),
    };
    let lines = fmt::layer().with_writer(std::io::stderr).without_time();
    tracing_subscriber::registry()
        .with(lines)
        .with(filter)
        .init();
}

/// The error with what helps. Messages are whole sentences: they name their cause themselves.
pub fn message(error: &anyhow::Error) -> String {
    let render = error.chain().find_map(|cause| cause.downcast_ref());
    let cloth = error.chain().find_map(|cause| cause.downcast_ref());
    let file = error.chain().find_map(|cause| cause.downcast_ref());
    match (render, cloth, file) {
        (Some(error), ..) => with_advice(error, Place::CommandLine),
        (None, Some(error), _) => with_advice_on_cloth(error),
        (None, None, Some(error)) => with_advice_on_file(error),
        (None, None, None) => error.to_string(),
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
