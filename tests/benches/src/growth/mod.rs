//! How time and memory grow: with loops, from a thousand to a million, and with pixels.
//!
//! The sheet grows and the camera moves away in proportion, so that the same share of the picture is cloth: each
//! pixel sees more loops. Samples of all sheets are drawn in turns.

mod report;

use std::sync::Arc;
use std::time::{Duration, Instant};

use renderer_core::design::Design;
use renderer_core::render::{Backend, Counters, MAX_SIDE, RenderRequest};
use renderer_core::scene::{self, Compiler, Scene};
use towel_designer::cli::scene_bytes;
use towel_designer::clock::{Spent, timed};

pub use report::{csv, plots, section};

use crate::conditions::Conditions;
use crate::drawing::{self, Drawn, LONG, count, draw, least, per_sample, samples_for};
use crate::parts::Turns;

/// Numbers of loops.
const LOOPS: [f64; 4] = [1e3, 1e4, 1e5, 1e6];
/// Sides of pictures, as shares of the bench's.
const SIDES: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
/// Share of the time for growth with loops.
const LOOPS_SHARE: f64 = 0.7;
/// What the next sheet is expected to take for each of its loops, beside what the last took: making it and handing it
/// over.
const LOOP_SECONDS: f64 = 3e-6;
/// Most samples of each.
const MOST_TURNS: u32 = 9;
/// Most scenes made of each sheet, for their time.
const MOST_COMPILES: u32 = 3;

/// What was found.
#[derive(Debug, Clone, Default)]
pub struct Growth {
    /// By rising number of loops.
    pub loops: Vec<Sheet>,
    /// By rising number of pixels.
    pub pixels: Vec<Picture>,
}

/// A sheet with many loops or few.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Warps and wefts.
    pub yarns: [u32; 2],
    /// Loops planted.
    pub loops: u64,
    /// From design to scene, nothing being there before: the least of a few.
    pub compile: Spent,
    /// Giving the scene to the backend, without pipelines: the least of all turns.
    pub upload: Duration,
    /// One sample: the least of all turns.
    pub sample: Spent,
    /// Work of one sample.
    pub counters: Counters,
    /// Bytes of the whole scene.
    pub scene_bytes: u64,
    /// Bytes of shapes, looks, lists and bounds for each loop.
    pub bytes_per_loop: f64,
    /// Bytes that the backend holds: of processors, beside the scene.
    pub backend_bytes: u64,
    /// How many samples were timed.
    pub turns: u32,
}

/// A picture with many pixels or few.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// One sample of every pixel: the least of all turns.
    pub sample: Spent,
    /// How many samples were timed.
    pub turns: u32,
}

/// A sheet as large as `times` this one along each side, seen from so many times as far.
pub fn grown(design: &Design, times: f64) -> Design {
    let mut design = design.clone();
    let yarns = |count: u32| ((f64::from(count) * times).round() as u32).max(1);
    design.sheet.warps = yarns(design.sheet.warps);
    design.sheet.wefts = yarns(design.sheet.wefts);
    for camera in &mut design.view.cameras {
        camera.target = camera.target.map(|place| place * times);
        camera.distance *= times;
        if let Some(height) = &mut camera.orthographic_height {
            *height *= times;
        }
    }
    design
}

/// Both kinds of growth.
///
/// # Errors
/// When the preset has no scene or the backend fails.
pub fn measure(
    design: &Design,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Growth> {
    let left = deadline.saturating_duration_since(Instant::now());
    let until = Instant::now() + left.mul_f64(LOOPS_SHARE);
    let whole = scene::compile(design)?;
    let loops = with_loops(design, &whole, backend, conditions, until, &mut say)?;
    let pixels = with_pixels(design, whole, backend, conditions, deadline, &mut say)?;
    Ok(Growth { loops, pixels })
}

fn with_loops(
    design: &Design,
    whole: &Scene,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    deadline: Instant,
    say: &mut impl FnMut(&str),
) -> anyhow::Result<Vec<Sheet>> {
    let planted = whole.loops.counts.planted;
    if planted == 0 {
        return Ok(Vec::new());
    }
    let mut sheets: Vec<(Sheet, RenderRequest)> = Vec::new();
    let mut last = Duration::ZERO;
    for wanted in LOOPS {
        say(&format!("{wanted:e} loops"));
        let grown = grown(design, (wanted / planted as f64).sqrt());
        let expected = last + Duration::from_secs_f64(LOOP_SECONDS * wanted);
        if !sheets.is_empty() && Instant::now() + expected >= deadline {
            break;
        }
        let start = Instant::now();
        // Some presets cannot grow so far: validation says how many yarns there may be.
        if !grown.faults().is_empty() {
            break;
        }
        let sheet = sheet(&grown, backend, conditions, deadline)?;
        last = start.elapsed();
        sheets.push(sheet);
    }
    in_turns(&mut sheets, backend, deadline, |sheet, drawn, sample| {
        sheet.sample = least([sheet.sample, sample]).unwrap_or_default();
        let upload = drawn.upload.wall.saturating_sub(drawn.pipelines);
        sheet.upload = sheet.upload.min(upload);
        sheet.turns += 1;
    })?;
    Ok(sheets.into_iter().map(|(sheet, _)| sheet).collect())
}

/// Draws all of them in turns as long as there is time, with another seed each turn, and `note`s what came of it and
/// one sample's time.
fn in_turns<T>(
    all: &mut [(T, RenderRequest)],
    backend: &mut dyn Backend,
    deadline: Instant,
    mut note: impl FnMut(&mut T, &Drawn, Spent),
) -> anyhow::Result<()> {
    let turns = Turns {
        deadline,
        most: MOST_TURNS,
    };
    let (mut turn, mut long) = (1, Duration::ZERO);
    while turns.has_time_for(turn, long) {
        let start = Instant::now();
        for (of, request) in &mut *all {
            request.settings.seed = turn;
            if let Some(drawn) = draw(backend, request, None)? {
                let sample = per_sample(drawn.samples, request.settings.samples);
                note(of, &drawn, sample);
            }
        }
        long = start.elapsed();
        turn += 1;
    }
    Ok(())
}

/// Makes a sheet and draws it once.
fn sheet(
    design: &Design,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    deadline: Instant,
) -> anyhow::Result<(Sheet, RenderRequest)> {
    let turns = Turns {
        deadline,
        most: MOST_COMPILES,
    };
    let mut compiles = Vec::new();
    let mut made = None;
    while turns.has_time_for(compiles.len() as u32, compile_time(&compiles)) {
        let mut spent = Spent::zero();
        made = Some(timed(&mut spent, || Compiler::default().compile(design))?);
        compiles.push(spent);
    }
    let scene: Arc<Scene> = made.ok_or_else(|| anyhow::anyhow!("no scene was made"))?;
    let mut request = drawing::request(design, &scene, conditions.size, 1)?;
    let counters = count(backend, &request)?;
    request.settings.seed = u32::MAX;
    let drawn = draw_long(backend, &mut request)?;
    let sheet = Sheet {
        yarns: [design.sheet.warps, design.sheet.wefts],
        loops: scene.loops.counts.planted,
        compile: least(compiles).unwrap_or_default(),
        upload: drawn.upload.wall.saturating_sub(drawn.pipelines),
        sample: per_sample(drawn.samples, request.settings.samples),
        counters,
        scene_bytes: scene_bytes(&scene),
        bytes_per_loop: scene.loops.bytes_per_loop(),
        backend_bytes: backend.device_bytes(),
        turns: 1,
    };
    Ok((sheet, request))
}

/// Draws one sample to see how many are needed, and then these.
fn draw_long(backend: &mut dyn Backend, request: &mut RenderRequest) -> anyhow::Result<Drawn> {
    let one = draw(backend, request, None)?.unwrap_or_default();
    let samples = samples_for(one.samples.wall);
    if samples == 1 {
        return Ok(one);
    }
    request.settings.samples = samples;
    request.settings.seed = request.settings.seed.wrapping_add(1);
    Ok(draw(backend, request, None)?.unwrap_or(one))
}

fn compile_time(compiles: &[Spent]) -> Duration {
    compiles.last().map_or(Duration::ZERO, |spent| spent.wall)
}

fn with_pixels(
    design: &Design,
    scene: Scene,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    deadline: Instant,
    say: &mut impl FnMut(&str),
) -> anyhow::Result<Vec<Picture>> {
    let scene = Arc::new(scene);
    let mut pictures: Vec<(Picture, RenderRequest)> = Vec::new();
    for times in SIDES {
        let size = conditions.size.map(|side| {
            let side = (f64::from(side) * times).round() as u32;
            side.clamp(1, MAX_SIDE.min(backend.largest_side()))
        });
        say(&format!("{} x {} pixels", size[0], size[1]));
        let expected = pictures.last().map_or(Duration::ZERO, |(last, _)| {
            // Four times the pixels, and as long again for a second turn.
            8 * last.sample.wall.max(LONG)
        });
        if !pictures.is_empty() && Instant::now() + expected >= deadline {
            break;
        }
        let mut request = drawing::request(design, &scene, size, 1)?;
        let drawn = draw_long(backend, &mut request)?;
        let picture = Picture {
            size,
            sample: per_sample(drawn.samples, request.settings.samples),
            turns: 1,
        };
        pictures.push((picture, request));
    }
    in_turns(&mut pictures, backend, deadline, |picture, _, sample| {
        picture.sample = least([picture.sample, sample]).unwrap_or_default();
        picture.turns += 1;
    })?;
    Ok(pictures.into_iter().map(|(picture, _)| picture).collect())
}
