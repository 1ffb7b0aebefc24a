//! One picture by every backend that this machine has, in turns.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use renderer_core::cpu::{CpuBackend, Instructions};
use renderer_core::design::Design;
use renderer_core::render::{Backend, BackendKind, Counters, RenderRequest};
use renderer_core::scene;
use towel_designer::backend::{self, BackendChoice};
use towel_designer::cli::exit;
use towel_designer::clock::Spent;

use crate::conditions::Conditions;
use crate::csv::{OfPresets, number, optional, quoted, table};
use crate::drawing::{self, count, draw, patch_tests_per_ray};
use crate::parts::Turns;
use crate::plot::{Bar, Bars};
use crate::units::seconds;

/// How long the first sample may take even where there is no time.
const LONGEST_FIRST: Duration = Duration::from_secs(2);
/// Most samples of each.
const MOST_TURNS: u32 = 9;

/// A backend, and what became of measuring it.
#[derive(Debug, Clone)]
pub struct BackendRow {
    /// Which.
    pub name: &'static str,
    /// What was found, or why nothing was.
    pub found: Result<Found, String>,
}

/// What a backend needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Adapter or cores.
    pub device: String,
    /// The least that one sample of the picture took.
    pub sample: Spent,
    /// The first picture: giving it the scene, without pipelines.
    pub upload: Duration,
    /// Making pipelines.
    pub pipelines: Duration,
    /// Work of one sample.
    pub counters: Counters,
    /// Bytes held for scene and picture; for processors, beside the scene.
    pub bytes: u64,
    /// A sample if nothing were traced, on a GPU.
    pub bare: Option<Duration>,
    /// How many turns there were.
    pub turns: u32,
}

/// A way to draw that is measured.
#[derive(Clone, Copy)]
enum Way {
    Backend(BackendChoice),
    /// The processor without the wide instructions that it may have.
    Plain,
}

/// A backend at work.
struct Contender {
    backend: Box<dyn Backend>,
    found: Found,
}

/// Each backend with the preset's own method.
///
/// # Errors
/// When there is no scene.
pub fn measure(
    design: &Design,
    conditions: &Conditions,
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Vec<BackendRow>> {
    let scene = Arc::new(scene::compile(design)?);
    let request = drawing::request(design, &scene, conditions.size, 1)?;
    let mut lines = Vec::new();
    for (name, way) in [
        (BackendKind::Cpu.name(), Way::Backend(BackendChoice::Cpu)),
        ("cpu without wide instructions", Way::Plain),
        (
            BackendKind::Reference.name(),
            Way::Backend(BackendChoice::Reference),
        ),
        // The last: on a software adapter it may take all of the time.
        (BackendKind::Gpu.name(), Way::Backend(BackendChoice::Gpu)),
    ] {
        say(&format!("backend {name}"));
        let is_late = !lines.is_empty() && Instant::now() >= deadline;
        let found = if is_late {
            Err("time was up".into())
        } else {
            // A machine without a GPU, or a method that it does not draw, is a finding.
            first(way, &request, deadline).map_err(|error| exit::message(&error))
        };
        lines.push((name, found));
    }
    let turns = Turns {
        deadline,
        most: MOST_TURNS,
    };
    let mut long = Duration::ZERO;
    let mut turn = 1;
    while turns.has_time_for(turn, long) {
        let start = Instant::now();
        let mut request = request.clone();
        request.settings.seed = turn;
        for (_, contender) in &mut lines {
            let Ok(contender) = contender else { continue };
            if let Some(drawn) = draw(&mut *contender.backend, &request, None)? {
                let both = [contender.found.sample, drawn.samples];
                contender.found.sample = drawing::least(both).unwrap_or_default();
                contender.found.turns += 1;
            }
        }
        long = start.elapsed();
        turn += 1;
    }
    let line = |(name, contender): (_, Result<Contender, String>)| BackendRow {
        name,
        found: contender.map(|contender| contender.found),
    };
    Ok(lines.into_iter().map(line).collect())
}

/// Makes a backend and draws once with it, if that does not take until long after `deadline`.
fn first(way: Way, request: &RenderRequest, deadline: Instant) -> anyhow::Result<Contender> {
    let mut backend = match way {
        Way::Backend(choice) => backend::make(choice)?,
        Way::Plain => Box::new(CpuBackend::with_instructions(Instructions::Plain)),
    };
    let until = deadline.max(Instant::now() + LONGEST_FIRST);
    let drawn = draw(&mut *backend, request, Some(until))?;
    let drawn = drawn.ok_or_else(|| anyhow!("time was up"))?;
    let bytes = backend.device_bytes();
    let counters = count(&mut *backend, request)?;
    let mut plain = request.clone();
    plain.settings.seed = u32::MAX;
    backend.begin(&plain)?;
    Ok(Contender {
        found: Found {
            device: backend.device_name(),
            sample: drawn.samples,
            upload: drawn.upload.wall.saturating_sub(drawn.pipelines),
            pipelines: drawn.pipelines,
            counters,
            bytes,
            bare: backend.baseline_sample()?,
            turns: 1,
        },
        backend,
    })
}

const HEADER: &str = "preset,backend,measured,device,clock time of a sample [s],processor time of a sample [s],upload \
    [s],\
    pipelines [s],bare sample [s],patch tests [1/ray],rays [1/sample],bytes on the device or beside the scene,turns";

/// The file.
pub fn csv(all: &OfPresets<'_, [BackendRow]>, conditions: &Conditions) -> String {
    let [width, height] = conditions.size;
    let pixels = f64::from(width) * f64::from(height);
    let lines = all
        .iter()
        .flat_map(|(preset, lines)| lines.iter().map(move |line| (preset, line)));
    let line = |(preset, line): (&&str, &BackendRow)| {
        let mut fields = vec![quoted(preset), line.name.into()];
        match &line.found {
            Err(why) => {
                fields.push(quoted(&format!("no: {why}")));
                fields.resize(HEADER.split(',').count(), String::new());
            }
            Ok(found) => {
                let rays = found.counters.rays + found.counters.shadow_rays;
                let processor = found.sample.processor;
                fields.extend([
                    "yes".into(),
                    quoted(&found.device),
                    number(found.sample.wall.as_secs_f64()),
                    optional(processor.map(|time| time.as_secs_f64())),
                    number(found.upload.as_secs_f64()),
                    number(found.pipelines.as_secs_f64()),
                    optional(found.bare.map(|time| time.as_secs_f64())),
                    number(patch_tests_per_ray(&found.counters)),
                    number(rays as f64 / pixels),
                    found.bytes.to_string(),
                    found.turns.to_string(),
                ]);
            }
        }
        fields.join(",")
    };
    table(HEADER, lines.map(line))
}

/// The section of the summary.
pub fn section(lines: &[BackendRow]) -> String {
    let mut text = String::from(
        "\n| backend | device | a sample, by the clock | processor time | against a bare dispatch | upload | \
            pipelines | patch tests a ray | memory |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for line in lines {
        let rest = match &line.found {
            Err(why) => format!("not measured: {why} | | | | | | | "),
            Ok(found) => {
                let processor = found.sample.processor;
                let bare = found.bare.map_or_else(
                    || "–".into(),
                    |bare| {
                        let times = found.sample.wall.as_secs_f64() / bare.as_secs_f64().max(1e-9);
                        format!("{times:.0} times")
                    },
                );
                format!(
                    "{} | {} | {} | {bare} | {} | {} | {:.2} | {:.1} MB",
                    found.device,
                    seconds(found.sample.wall.as_secs_f64()),
                    processor.map_or_else(|| "–".into(), |time| seconds(time.as_secs_f64())),
                    seconds(found.upload.as_secs_f64()),
                    seconds(found.pipelines.as_secs_f64()),
                    patch_tests_per_ray(&found.counters),
                    found.bytes as f64 / 1e6,
                )
            }
        };
        let _ = writeln!(text, "| {} | {rest} |", line.name);
    }
    text
}

/// Time of a sample by each backend, as bars.
pub fn bars(preset: &str, conditions: &Conditions, lines: &[BackendRow]) -> Bars {
    let bar = |line: &BackendRow| {
        let (value, text) = match &line.found {
            Ok(found) => {
                let wall = found.sample.wall.as_secs_f64();
                (
                    Some(1e3 * wall),
                    format!("{} ({})", seconds(wall), found.device),
                )
            }
            Err(_) => (None, "not measured".into()),
        };
        Bar {
            name: line.name.into(),
            value,
            text,
        }
    };
    Bars {
        title: format!("{preset}: one sample by each backend"),
        under: format!("{} × {} pixels", conditions.size[0], conditions.size[1]),
        axis: "time by the clock [ms]".into(),
        bars: lines.iter().map(bar).collect(),
        limit: None,
        cut: None,
    }
}
