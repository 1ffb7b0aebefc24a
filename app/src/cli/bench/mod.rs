//! `bench`: run time against error of every way to render a preset: a table, plots, and what follows from them.
//!
//! For each preset a converged truth is made first, then methods × samplers × shadows are rendered at 1, 2, 4 … samples
//! for as long as the budget lasts. After each preset all files are written anew, each at once, so that Ctrl-C leaves
//! whole files.

pub mod csv;
pub mod measure;
pub mod pareto;
pub mod plan;
pub mod plot;
pub mod summary;
pub mod truth;

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use renderer_core::design::Design;
use renderer_core::render::{Backend, BackendKind};

use self::measure::{Findings, Subject, measure, name_of};
use super::{BadArgument, arguments};
use crate::backend::{self, BackendChoice};
use crate::files::{self, FileError};

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArguments {
    /// Presets to measure.
    #[arg(required = true)]
    presets: Vec<PathBuf>,
    /// Folder to write to: bench.csv, summary.md, and a plot a preset as PNG and SVG.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "192x192", value_parser = arguments::size)]
    size: [u32; 2],
    /// Seconds to spend on each preset.
    #[arg(long, value_name = "S", default_value = "120", allow_negative_numbers = true, value_parser = arguments::seconds)]
    budget: f64,
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Print nothing but errors and the summary.
    #[arg(long)]
    quiet: bool,
}

/// What is the same for all measurements of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// What renders.
    pub backend: BackendKind,
    /// Its adapter or cores.
    pub device: String,
    /// Time for each preset.
    pub budget: Duration,
}

/// A preset's results.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The preset's name.
    pub name: String,
    /// For each target.
    pub findings: Vec<Findings>,
}

/// Measures and writes.
pub fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    let presets = load(&arguments.presets)?;
    let folder = &arguments.output;
    fs::create_dir_all(folder).map_err(|source| FileError::Write {
        path: folder.clone(),
        source,
    })?;
    for name in ["bench.csv", "summary.md"] {
        files::check_writable(&folder.join(name))?;
    }
    let mut backend = backend::make(arguments.backend)?;
    let conditions = Conditions {
        size: arguments.size,
        backend: backend.kind(),
        device: backend.device_name(),
        budget: Duration::from_secs_f64(arguments.budget),
    };
    let mut all = Vec::new();
    for (name, design) in presets {
        let findings = one_preset(&name, design, &mut *backend, &conditions, arguments.quiet)?;
        all.push(Measured { name, findings });
        write(folder, &conditions, &all)?;
    }
    let summary = summary::write(&conditions, &all);
    std::io::stdout().lock().write_all(summary.as_bytes())?;
    Ok(())
}

/// Reads all presets before any is measured.
fn load(paths: &[PathBuf]) -> anyhow::Result<Vec<(String, Design)>> {
    let mut presets: Vec<(String, Design)> = Vec::new();
    for path in paths {
        let name = name_of(path);
        if presets.iter().any(|(other, _)| *other == name) {
            let path = path.display();
            return Err(BadArgument(format!(
                "{path}: another preset is called {name} too, and results go by that name"
            ))
            .into());
        }
        presets.push((name, files::load_design(path)?));
    }
    Ok(presets)
}

fn one_preset(
    name: &str,
    design: Design,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    quiet: bool,
) -> anyhow::Result<Vec<Findings>> {
    let bar = bar(conditions.budget, quiet);
    let start = Instant::now();
    // Every design has a camera: it has been validated.
    let mut subject = Subject::new(design, conditions.size)
        .ok_or_else(|| anyhow::anyhow!("{name}: the preset has no camera"))?;
    let mut findings = Vec::new();
    let mut share = 0.0;
    let methods = subject.methods_of(backend)?;
    for target in plan::targets(subject.quality(), &methods) {
        share += target.share;
        let deadline = start + conditions.budget.mul_f64(share);
        let title = target.name();
        let say = |what: &str| {
            bar.set_position(start.elapsed().as_millis() as u64);
            bar.set_message(format!("{name}, {title}: {what}"));
        };
        findings.push(measure(&mut subject, backend, target, deadline, say)?);
    }
    bar.finish_and_clear();
    Ok(findings)
}

/// A bar on stderr that fills with the budget.
fn bar(budget: Duration, quiet: bool) -> ProgressBar {
    let bar = if quiet {
        ProgressBar::hidden()
    } else {
        ProgressBar::new(budget.as_millis() as u64)
    };
    match ProgressStyle::with_template("{bar:30} {elapsed} · {msg}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Writes table, summary and the last preset's plots.
fn write(folder: &Path, conditions: &Conditions, all: &[Measured]) -> anyhow::Result<()> {
    let put = |name: &str, bytes: &[u8]| files::write_atomically(&folder.join(name), bytes);
    if let Some(measured) = all.last() {
        for findings in &measured.findings {
            let name = match findings.target.bounces {
                1 => measured.name.clone(),
                bounces => format!("{}-bounces-{bounces}", measured.name),
            };
            let plot = plot::Plot::new(&measured.name, conditions, findings);
            put(&format!("{name}.svg"), plot.svg()?.as_bytes())?;
            put(&format!("{name}.png"), &plot.png()?)?;
        }
    }
    put("bench.csv", csv::write(conditions, all).as_bytes())?;
    put("summary.md", summary::write(conditions, all).as_bytes())?;
    Ok(())
}
