//! One cloth from farther and farther: what its levels of detail cost beside the whole, and how far their pictures
//! are from its.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

use renderer_core::design::{Design, Filter, Form};
use renderer_core::image::{Picture, metrics};
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodPlan};
use renderer_core::scene::{Cancel, Compiler, Scene};
use towel_designer::clock::{Spent, timed};

use crate::csv::{OfPresets, number, optional, quoted, table};
use crate::drawing::{count, draw, patch_tests_per_ray, per_sample, request};
use crate::units::seconds;

/// Pixels along each side of the pictures.
const SIDE: u32 = 48;
/// Warps and wefts of the cloth: just so many that it is made in parts.
const YARNS: u32 = 2048;
/// Cells along each side of a pixel.
const DISTANCES: [f64; 5] = [2.1, 4.2, 8.4, 16.8, 33.6];
/// Samples of the first pictures, which tell how many there is time for.
const TRIAL: u32 = 4;
/// Most samples of a picture.
const MOST_SAMPLES: u32 = 4096;

/// A distance, and what was found there.
#[derive(Debug, Clone, PartialEq)]
pub struct DistanceRow {
    /// Cells along each side of a pixel.
    pub cells: f64,
    /// What was found; `None` if time was up before.
    pub found: Option<Found>,
}

/// What the levels for a picture cost, and what they show.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// How often the cloth of the first level is halved.
    pub lod: u32,
    /// All levels.
    pub levels: Cost,
    /// The whole cloth's.
    pub whole: Cost,
    /// Making them.
    pub compile: Spent,
    /// Mean luminance of its picture over that of the whole cloth's.
    pub brightness: f64,
    /// relRMSE between the two without their noise: from two pairs of pictures with independent noise.
    pub error: f64,
}

/// What cloth costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Loops in it.
    pub loops: u64,
    /// Bytes of loops, lists, bounds and looks.
    pub bytes: u64,
    /// One sample.
    pub sample: Spent,
    /// Patch tests for each ray.
    pub patch_tests: f64,
}

/// Measures from near to far until a time.
///
/// # Errors
/// When the preset has no scene or the backend fails.
pub fn measure(
    design: &Design,
    backend: &mut dyn Backend,
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Vec<DistanceRow>> {
    let mut design = design.clone();
    (design.sheet.warps, design.sheet.wefts) = (YARNS, YARNS);
    design.form = Form::default();
    design.turbulence.filter = Filter::None;
    say("the whole cloth");
    let whole = Compiler::default().compile(&design)?;
    let mut lines = Vec::new();
    for (index, cells) in DISTANCES.into_iter().enumerate() {
        say(&format!("{cells} cells a pixel"));
        let left = deadline.saturating_duration_since(Instant::now());
        let until = Instant::now() + left / (DISTANCES.len() - index) as u32;
        let found = at_distance(&mut design, &whole, backend, cells, until)?;
        lines.push(DistanceRow { cells, found });
    }
    Ok(lines)
}

fn at_distance(
    design: &mut Design,
    whole: &Arc<Scene>,
    backend: &mut dyn Backend,
    cells: f64,
    until: Instant,
) -> anyhow::Result<Option<Found>> {
    let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
    if let Some(camera) = design.view.cameras.first_mut() {
        camera.target = [0.0; 3];
        camera.orthographic_height = Some(cells * pitch * f64::from(SIDE));
    }
    let of_whole = request(design, whole, [SIDE; 2], TRIAL)?;
    let camera = *of_whole.camera();
    let plan = LodPlan::new(design, &camera, [SIDE; 2], LodBudget::FINAL, None);
    let mut compile = Spent::zero();
    let cloth = timed(&mut compile, || {
        LodCompiler::default().make(design, plan, &Cancel::never())
    })?;
    let view = cloth.view(design, &camera, [SIDE; 2]);
    let of_levels = RenderRequest::new(view, [SIDE; 2], of_whole.settings);
    let both = [&of_whole, &of_levels];
    let mut costs = Vec::new();
    for request in both {
        let Some(cost) = cost(backend, request, until)? else {
            return Ok(None);
        };
        costs.push(cost);
    }
    let one = costs[0].sample.wall + costs[1].sample.wall;
    let left = until.saturating_duration_since(Instant::now());
    let samples = left.as_secs_f64() / (2.0 * one.as_secs_f64()).max(1e-9);
    let samples = (samples as u32).clamp(TRIAL, MOST_SAMPLES);
    let mut pictures = Vec::new();
    for seed in [1, 2] {
        for request in both {
            let mut request = request.clone();
            (request.settings.samples, request.settings.seed) = (samples, seed);
            draw(backend, &request, None)?;
            pictures.push(backend.picture()?);
        }
    }
    let [whole, levels] = [0, 1].map(|first| {
        let seeds = [&pictures[first], &pictures[first + 2]];
        seeds.map(metrics::mean_luminance).iter().sum::<f64>()
    });
    Ok(Some(Found {
        lod: cloth.scenes.nearest.sheet.region.map_or(0, |e| e.lod),
        levels: costs[1],
        whole: costs[0],
        compile,
        brightness: levels / whole,
        error: error_without_noise(&pictures),
    }))
}

fn cost(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    until: Instant,
) -> anyhow::Result<Option<Cost>> {
    let Some(drawn) = draw(backend, request, Some(until))? else {
        return Ok(None);
    };
    let counters = count(backend, request)?;
    let levels = 0..request.level_count();
    let scenes: Vec<_> = levels
        .map(|level| Arc::clone(request.at_level(level).scene()))
        .collect();
    let bytes = |scene: &Arc<Scene>| scene.loops.bytes_per_loop() * scene.looks.len() as f64;
    Ok(Some(Cost {
        loops: scenes.iter().map(|scene| scene.loops.counts.planted).sum(),
        bytes: scenes.iter().map(bytes).sum::<f64>() as u64,
        sample: per_sample(drawn.samples, request.settings.samples),
        patch_tests: patch_tests_per_ray(&counters),
    }))
}

/// relRMSE between two pictures of two seeds each, in turns: noise of one seed has nothing to do with that of the
/// other, so that in the product of both differences it averages out.
fn error_without_noise(pictures: &[Picture]) -> f64 {
    let (mut sum, mut mean, mut count) = (0.0, 0.0, 0.0);
    let [a0, b0, a1, b1] = [0, 1, 2, 3].map(|index| pictures[index].pixels.iter());
    for (((a0, b0), a1), b1) in a0.zip(b0).zip(a1).zip(b1) {
        for channel in 0..3 {
            let [a0, b0, a1, b1] = [a0, b0, a1, b1].map(|pixel| f64::from(pixel[channel]));
            sum += (a0 - b0) * (a1 - b1);
            mean += 0.5 * (a0 + a1);
            count += 1.0;
        }
    }
    (sum / count).max(0.0).sqrt() / (mean / count)
}

const HEADER: &str = "preset,cells a pixel,measured,lod,loops,bytes,compile clock time [s],sample clock time [s],\
    sample processor time [s],patch tests [1/ray],whole cloth: loops,bytes of the whole cloth,sample of the whole \
    cloth: clock time [s],\
    patch tests in the whole cloth [1/ray],brightness over the whole cloth's,error [relRMSE]";

/// The file.
pub fn csv(all: &OfPresets<'_, [DistanceRow]>) -> String {
    let lines = all
        .iter()
        .flat_map(|(preset, lines)| lines.iter().map(move |line| (preset, line)));
    let line = |(preset, line): (&&str, &DistanceRow)| {
        let mut fields = vec![quoted(preset), number(line.cells)];
        match &line.found {
            None => {
                fields.push(quoted("no: time was up"));
                fields.resize(HEADER.split(',').count(), String::new());
            }
            Some(found) => {
                let (levels, whole) = (&found.levels, &found.whole);
                fields.extend([
                    "yes".into(),
                    found.lod.to_string(),
                    levels.loops.to_string(),
                    levels.bytes.to_string(),
                    number(found.compile.wall.as_secs_f64()),
                    number(levels.sample.wall.as_secs_f64()),
                    optional(levels.sample.processor.map(|time| time.as_secs_f64())),
                    number(levels.patch_tests),
                    whole.loops.to_string(),
                    whole.bytes.to_string(),
                    number(whole.sample.wall.as_secs_f64()),
                    number(whole.patch_tests),
                    number(found.brightness),
                    number(found.error),
                ]);
            }
        }
        fields.join(",")
    };
    table(HEADER, lines.map(line))
}

/// The section of the summary.
pub fn section(lines: &[DistanceRow]) -> String {
    let mut text = format!(
        "\nA cloth of {YARNS} × {YARNS} cells, pictures of {SIDE} × {SIDE} pixels.\n\n\
         | cells a pixel | halved | loops | MB | compile | a sample | patch tests a ray | … of the whole cloth: MB, a \
         sample, patch tests | brightness | error |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
    );
    for line in lines {
        let Some(found) = &line.found else {
            let _ = writeln!(text, "| {} | not measured: time was up |", line.cells);
            continue;
        };
        let megabytes = |cost: &Cost| cost.bytes as f64 / 1e6;
        let one = |cost: &Cost| seconds(cost.sample.wall.as_secs_f64());
        let (levels, whole) = (&found.levels, &found.whole);
        let _ = writeln!(
            text,
            "| {} | {} times | {} | {:.1} | {} | {} | {:.2} | {:.1}, {}, {:.2} | {:.3} | {:.3} |",
            line.cells,
            found.lod,
            levels.loops,
            megabytes(levels),
            seconds(found.compile.wall.as_secs_f64()),
            one(levels),
            levels.patch_tests,
            megabytes(whole),
            one(whole),
            whole.patch_tests,
            found.brightness,
            found.error,
        );
    }
    text
}
