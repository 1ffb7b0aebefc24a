//! `bench`: what a preset costs, and what it is worth: tables, plots, and what follows from them.
//!
//! ```text
//! errors         methods × samplers × shadows against a converged truth, and one method without each optimisation and
//! up to
//!                error targets
//! optimisations  one piece of work with each optimisation and without it, in turns
//! backends       the same picture by each backend
//! growth         loops from a thousand to a million, and pixels
//! first-picture  from each kind of edit to the first picture in the window
//! lights         each kind of light on the same cloth: time and noise
//! piles          the same cloth with each kind of pile, and after each finish: time and noise
//! forms          the same cloth bent in each way: time and noise
//! distances      a large cloth from farther and farther: levels of detail beside the whole
//! costs          the stages between an edit and a whole picture: which is the largest
//! ```
//!
//! Each part has its share of a preset's budget. After each preset all files are written anew, each at once, so that
//! Ctrl-C leaves whole files.

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use renderer_core::design::Design;
use renderer_core::render::Backend;
use towel_designer::backend::{self, BackendChoice};
use towel_designer::cli::arguments::{self, BadArgument};
use towel_designer::files::{self, FileError, UsedFile};

use crate::conditions::Conditions;
use crate::measure::{Findings, Subject, measure, name_of};
use crate::measured::Measured;
use crate::parts::{Part, chosen, deadline_of_first};
use crate::{
    backends, costs, distances, first_picture, growth, optimisations, plan, summary, variants,
    written,
};

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArguments {
    /// Presets to measure.
    #[arg(required = true)]
    presets: Vec<PathBuf>,
    /// Folder to write to: summary.md, and a table as .csv and plots as .png and .svg for each part.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What to measure, separated by commas; everything where none is given.
    #[arg(long, value_name = "PARTS", value_enum, value_delimiter = ',')]
    what: Vec<Part>,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "192x192", value_parser = arguments::size)]
    size: [u32; 2],
    /// Size of the window's picture in pixels, for first-picture and costs.
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = arguments::size)]
    window: [u32; 2],
    /// Seconds to spend on each preset.
    #[arg(
        long,
        value_name = "S",
        default_value = "240",
        allow_negative_numbers = true,
        value_parser = arguments::seconds
    )]
    budget: f64,
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Print nothing but errors and the summary.
    #[arg(long)]
    quiet: bool,
}

/// Measures and writes.
///
/// # Errors
/// When a preset has faults, or a backend or a file refuses.
pub fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    let (presets, read) = load(&arguments.presets)?;
    let parts = chosen(&arguments.what);
    let folder = &arguments.output;
    fs::create_dir_all(folder).map_err(|source| FileError::Write {
        path: folder.clone(),
        source,
    })?;
    for name in written::names(&parts) {
        let file = folder.join(name);
        files::check_apart(&read, &[UsedFile::new(&file, "a file of results")])?;
        files::check_writable(&file)?;
    }
    let mut backend = backend::make(arguments.backend)?;
    let conditions = Conditions {
        size: arguments.size,
        window: arguments.window,
        backend: backend.kind(),
        device: backend.device_name(),
        budget: Duration::from_secs_f64(arguments.budget),
    };
    let mut all = Vec::new();
    for (name, design) in presets {
        let bench = Bench {
            name: &name,
            design: &design,
            conditions: &conditions,
            choice: arguments.backend,
            bar: bar(conditions.budget, arguments.quiet),
            start: Instant::now(),
        };
        all.push(bench.measure(&parts, &mut *backend)?);
        bench.bar.finish_and_clear();
        written::write(folder, &conditions, &parts, &all)?;
    }
    let summary = summary::write(&conditions, &all);
    std::io::stdout().lock().write_all(summary.as_bytes())?;
    Ok(())
}

/// A design by the name that its results go by.
type Named = (String, Design);

/// Reads all presets before any is measured; also the files that they were read from.
fn load(paths: &[PathBuf]) -> anyhow::Result<(Vec<Named>, Vec<UsedFile>)> {
    let mut presets: Vec<Named> = Vec::new();
    let mut read = Vec::new();
    for path in paths {
        let name = name_of(path);
        if presets.iter().any(|(other, _)| *other == name) {
            let path = path.display();
            return Err(BadArgument(format!(
                "{path}: another preset is called {name} too, and results go by that name"
            ))
            .into());
        }
        let opened = files::open_design(path)?;
        read.extend(opened.read);
        presets.push((name, opened.design));
    }
    Ok((presets, read))
}

/// One preset on the bench.
struct Bench<'a> {
    name: &'a str,
    design: &'a Design,
    conditions: &'a Conditions,
    choice: BackendChoice,
    bar: ProgressBar,
    start: Instant,
}

impl Bench<'_> {
    fn say(&self, what: &str) {
        self.bar
            .set_position(self.start.elapsed().as_millis() as u64);
        self.bar.set_message(format!("{}, {what}", self.name));
    }

    fn measure(&self, parts: &[Part], backend: &mut dyn Backend) -> anyhow::Result<Measured> {
        let mut measured = Measured {
            name: self.name.into(),
            ..Measured::default()
        };
        let end = self.start + self.conditions.budget;
        let (design, conditions) = (self.design, self.conditions);
        for (index, part) in parts.iter().enumerate() {
            let until = deadline_of_first(&parts[index..], end);
            let say = |what: &str| self.say(what);
            match part {
                Part::Errors => measured.findings = self.errors(backend, until)?,
                Part::Optimisations => {
                    measured.optimisations =
                        optimisations::measure(design, backend, conditions, until, say)?;
                }
                Part::Backends => {
                    measured.backends = backends::measure(design, conditions, until, say)?;
                }
                Part::Growth => {
                    let growth = growth::measure(design, backend, conditions, until, say)?;
                    measured.growth = Some(growth);
                }
                Part::FirstPicture => {
                    let window = conditions.window;
                    let found = first_picture::measure(design, self.choice, window, until, say)?;
                    measured.first_pictures = Some(found);
                }
                Part::Lights => {
                    let lights = variants::lights(design);
                    measured.lights = variants::measure(lights, backend, conditions, until, say)?;
                }
                Part::Piles => {
                    let piles = variants::piles(design);
                    measured.piles = variants::measure(piles, backend, conditions, until, say)?;
                }
                Part::Forms => {
                    let forms = variants::forms(design);
                    measured.forms = variants::measure(forms, backend, conditions, until, say)?;
                }
                Part::Distances => {
                    measured.distances = distances::measure(design, backend, until, say)?;
                }
                Part::Costs => {
                    let window = conditions.window;
                    measured.costs = costs::measure(design, backend, window, until, say)?;
                }
            }
        }
        Ok(measured)
    }

    /// Run time against error until a time.
    fn errors(&self, backend: &mut dyn Backend, until: Instant) -> anyhow::Result<Vec<Findings>> {
        let begin = Instant::now();
        let time = until.saturating_duration_since(begin);
        // Every design has a camera: it has been validated.
        let mut subject = Subject::new(self.design.clone(), self.conditions.size)
            .ok_or_else(|| anyhow::anyhow!("{}: the preset has no camera", self.name))?;
        let mut findings = Vec::new();
        let mut share = 0.0;
        let methods = subject.methods_of(backend)?;
        let optimisations =
            optimisations::curve_optimisations(backend.kind(), subject.quality().method);
        for target in plan::targets(subject.quality(), &methods, &optimisations) {
            share += target.share;
            let title = target.name();
            let say = |what: &str| self.say(&format!("{title}: {what}"));
            let deadline = begin + time.mul_f64(share);
            findings.push(measure(&mut subject, backend, target, deadline, say)?);
        }
        Ok(findings)
    }
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
