//! `pace`: how smoothly the window goes while it renders.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use towel_designer::backend::BackendChoice;
use towel_designer::cli::arguments;

use crate::window_pace::{Frames, Phase, measure};

/// What to measure.
#[derive(Debug, Args)]
pub struct PaceArguments {
    /// Preset to open.
    preset: PathBuf,
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Seconds to measure in each of four phases: idle, rendering, editing, painting.
    #[arg(long, default_value = "10", value_parser = arguments::seconds)]
    seconds: f64,
}

/// Opens the window, measures, and prints a table of the times between frames.
///
/// # Errors
/// When the window cannot be opened or the preset cannot be drawn.
#[expect(clippy::print_stdout, reason = "the table is the result")]
pub fn run(arguments: &PaceArguments) -> anyhow::Result<()> {
    let time = Duration::from_secs_f64(arguments.seconds);
    let pace = measure(arguments.preset.clone(), arguments.backend, time)?;
    let [width, height] = pace.size;
    println!("picture   {width} x {height} by {}", pace.device);
    println!("window    {}", pace.adapter);
    println!("\nms from frame to frame");
    println!("             frames   median   95 %  longest   samples   95 % against idle");
    let idle = pace
        .phases
        .iter()
        .find(|frames| frames.phase == Phase::Idle);
    let idle = idle.map_or(f64::NAN, |frames| frames.percentile(0.95));
    for frames in &pace.phases {
        println!("{}", line(frames, idle));
    }
    Ok(())
}

fn line(frames: &Frames, idle: f64) -> String {
    let name = match frames.phase {
        Phase::Opening => "opening",
        Phase::Idle => "idle",
        Phase::Rendering => "rendering",
        Phase::Editing => "editing",
        Phase::Painting => "painting",
    };
    let ms = |share: f64| 1000.0 * frames.percentile(share);
    format!(
        "{name:<12} {:>6} {:>8.1} {:>6.1} {:>8.1} {:>9} {:>19.2}",
        frames.seconds.len(),
        ms(0.5),
        ms(0.95),
        ms(1.0),
        frames.samples,
        frames.percentile(0.95) / idle
    )
}
