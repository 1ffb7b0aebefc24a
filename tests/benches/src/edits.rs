//! `edits`: how long an edit takes until the picture is whole again, in a program that is already running
//! as the designer is: what the edit leaves alone is kept from the scene before it.
//!
//! Each edit is made and taken back in turns. Files are read before anything is measured.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use anyhow::anyhow;
use clap::Args;
use renderer_core::design::{Design, Method};
use renderer_core::geometry::Camera;
use renderer_core::render::{Backend, RenderRequest, Settings};
use renderer_core::scene::Compiler;
use renderer_core::scene::lod::LodView;
use serde::Serialize;

use towel_designer::backend::{self, BackendChoice};
use towel_designer::cli::arguments;
use towel_designer::clock::{Spent, timed};
use towel_designer::files::{self, UsedFile};

/// How long a backend may work before it is asked again: longer than any sample.
const SLICE: Duration = Duration::from_secs(600);

/// What to measure.
#[derive(Debug, Args)]
pub struct EditsArguments {
    /// Preset to edit.
    preset: PathBuf,
    /// An edit, as in length.value=2.5; several are measured one after the other.
    #[arg(long, required = true, value_name = "PATH=VALUE", value_parser = arguments::field_and_value)]
    edit: Vec<(String, String)>,
    /// How often each edit is made and taken back.
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = arguments::size)]
    size: [u32; 2],
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// How a ray gathers light; as the preset says where none is given.
    #[arg(long, value_parser = arguments::method)]
    method: Option<Method>,
    /// Change a field of the preset for good, as in quality.bounces=1.
    #[arg(long, value_name = "PATH=VALUE", value_parser = arguments::field_and_value)]
    set: Vec<(String, String)>,
    /// Write the times as JSON too.
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,
}

/// What one edit took, seconds.
#[derive(Debug, Serialize)]
struct Row {
    /// As given: PATH=VALUE.
    edit: String,
    /// False where it was taken back.
    made: bool,
    /// From design to scene.
    compile: Seconds,
    /// Giving the scene to the backend.
    upload: Seconds,
    /// One sample of every pixel, and the picture of it.
    sample: Seconds,
    /// All of these.
    total: Seconds,
}

#[derive(Debug, Serialize)]
struct Seconds {
    /// By the clock.
    wall: f64,
    /// On all cores together; null where the system does not measure it.
    processor: Option<f64>,
}

impl From<Spent> for Seconds {
    fn from(spent: Spent) -> Self {
        Self {
            wall: spent.wall.as_secs_f64(),
            processor: spent.processor.map(|time| time.as_secs_f64()),
        }
    }
}

/// What stays in memory from edit to edit.
struct Session {
    compiler: Compiler,
    backend: Box<dyn Backend>,
    size: [u32; 2],
}

impl Session {
    /// The times of compiling, uploading and drawing one sample of `design`.
    fn show(&mut self, design: &Design) -> anyhow::Result<[Spent; 3]> {
        let [mut compile, mut upload, mut sample] = [Spent::zero(); 3];
        let camera = design.view.cameras.first().map(Camera::from_design);
        let camera = camera.ok_or_else(|| anyhow!("the preset has no camera"))?;
        let scene = timed(&mut compile, || self.compiler.compile(design))?;
        let [width, height] = self.size;
        let request = RenderRequest {
            view: LodView::of(Arc::clone(&scene), camera),
            size: self.size,
            crop: [0, 0, width, height],
            settings: Settings {
                samples: 1,
                error: 0.0,
                ..Settings::from(&design.quality)
            },
        };
        timed(&mut upload, || self.backend.begin(&request))?;
        timed(&mut sample, || -> anyhow::Result<()> {
            let never = AtomicBool::new(false);
            while !self.backend.advance(SLICE, &never)?.done {}
            self.backend.picture()?;
            Ok(())
        })?;
        Ok([compile, upload, sample])
    }
}

/// Measures, prints a table, and writes.
///
/// # Errors
/// When the preset or an edit has faults, or the backend or the file refuses.
pub fn run(arguments: &EditsArguments) -> anyhow::Result<()> {
    let open = |edit: &[(String, String)]| -> anyhow::Result<Design> {
        let sets = [&arguments.set[..], edit].concat();
        let mut design = files::load_design_with(&arguments.preset, &sets)?;
        if let Some(method) = arguments.method {
            design.quality.method = method;
        }
        Ok(design)
    };
    let before = open(&[])?;
    let edited = arguments.edit.iter().map(|edit| {
        let name = format!("{}={}", edit.0, edit.1);
        Ok((name, open(std::slice::from_ref(edit))?))
    });
    let edited: Vec<(String, Design)> = edited.collect::<anyhow::Result<_>>()?;
    if let Some(output) = &arguments.output {
        let opened = files::open_design_with(&arguments.preset, &arguments.set)?;
        files::check_apart(
            &opened.read,
            &[UsedFile::new(output, "the file to write (-o)")],
        )?;
        files::check_writable(output)?;
    }
    let mut session = Session {
        compiler: Compiler::default(),
        backend: backend::make(arguments.backend.for_method(before.quality.method))?,
        size: arguments.size,
    };
    session.show(&before)?;

    let mut rows = Vec::new();
    let mut out = std::io::stdout().lock();
    writeln!(out, "ms by the clock   compile   upload   sample    total")?;
    for (name, after) in &edited {
        for _ in 0..arguments.repeats {
            for (design, made) in [(after, true), (&before, false)] {
                let [compile, upload, sample] = session.show(design)?;
                let mut total = compile;
                total += upload;
                total += sample;
                let ms = [compile, upload, sample, total].map(|s| 1e3 * s.wall.as_secs_f64());
                let [c, u, s, t] = ms;
                let step = if made { name } else { "  taken back" };
                writeln!(out, "{c:>25.1} {u:>8.1} {s:>8.1} {t:>8.1}   {step}")?;
                rows.push(Row {
                    edit: name.clone(),
                    made,
                    compile: compile.into(),
                    upload: upload.into(),
                    sample: sample.into(),
                    total: total.into(),
                });
            }
        }
    }
    if let Some(output) = &arguments.output {
        let json = serde_json::to_string_pretty(&rows)? + "\n";
        files::write_atomically(output, json.as_bytes())?;
    }
    Ok(())
}
