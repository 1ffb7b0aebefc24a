//! Where the time goes from an edit of all loops to the first whole picture of it in the window, stage by stage; and
//! so, which cost is the largest that remains.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use renderer_core::design::Design;
use renderer_core::render::{Backend, BackendKind};
use renderer_core::scene::Compiler;
use towel_designer::designer::LiveLight;

use crate::conditions::Conditions;
use crate::csv::{OfPresets, number, quoted, table};
use crate::drawing::{self, draw, median};
use crate::first_picture::{Edit, edit};
use crate::parts::Turns;
use crate::plot::{Bar, Bars};
use crate::units::seconds;

/// Most turns.
const MOST_TURNS: u32 = 5;

/// A stage of the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Cost {
    /// Which.
    pub stage: &'static str,
    /// Middle of all turns by the clock, s.
    pub seconds: f64,
    /// Its part of all, 0 to 1.
    pub share: f64,
}

/// Stages by name, and their seconds.
type Stages = Vec<(&'static str, f64)>;

/// Every stage; empty where there was no time for one turn.
///
/// # Errors
/// When there is no scene or the backend fails.
pub fn measure(
    design: &Design,
    backend: &mut dyn Backend,
    window: [u32; 2],
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Vec<Cost>> {
    let mut compiler = Compiler::default();
    compiler.compile(design)?;
    let turns = Turns {
        deadline,
        most: MOST_TURNS,
    };
    let mut all: Vec<Stages> = Vec::new();
    let mut long = Duration::ZERO;
    while turns.has_time_for(all.len() as u32, long) {
        say(&format!("costs, turn {}", all.len() + 1));
        let start = Instant::now();
        let mut edited = design.clone();
        edit(
            &mut edited,
            Edit::Length,
            design,
            all.len().is_multiple_of(2),
        );
        match turn(&edited, &mut compiler, backend, window, deadline)? {
            Some(turn) => all.push(turn),
            None => break,
        }
        long = start.elapsed();
    }
    let Some(first) = all.first() else {
        return Ok(Vec::new());
    };
    let middle = |stage: usize| median(all.iter().map(|turn| turn[stage].1));
    let middles: Vec<f64> = (0..first.len()).map(middle).collect();
    let sum: f64 = middles.iter().sum();
    let costs = first.iter().zip(middles);
    Ok(costs
        .map(|(&(stage, _), seconds)| Cost {
            stage,
            seconds,
            share: seconds / sum.max(1e-9),
        })
        .collect())
}

/// Seconds of each stage; `None` if time was up.
fn turn(
    design: &Design,
    compiler: &mut Compiler,
    backend: &mut dyn Backend,
    window: [u32; 2],
    deadline: Instant,
) -> anyhow::Result<Option<Stages>> {
    let scene = compiler.compile(design)?;
    let mut stages = compiler.last_report().seconds.by_name().to_vec();
    let mut request = drawing::request(design, &scene, window, 1)?;
    request.settings = LiveLight::default().settings(design);
    (request.settings.samples, request.settings.error) = (1, 0.0);
    let is_gpu = backend.kind() == BackendKind::Gpu;
    let mut upload = None;
    let mut seed = request.settings.seed;
    let mut sample = |shadows: bool, bounces: u32| -> anyhow::Result<Option<f64>> {
        let mut request = request.clone();
        request.settings.shadows &= shadows;
        request.settings.bounces = request.settings.bounces.min(bounces);
        // Never the picture that the backend has already: that would cost nothing.
        seed = seed.wrapping_add(1);
        request.settings.seed = seed;
        let Some(drawn) = draw(backend, &request, Some(deadline))? else {
            return Ok(None);
        };
        let begun = drawn.upload.wall.saturating_sub(drawn.pipelines);
        // The first begins with a new scene; the others keep what is made of it.
        upload.get_or_insert(begun.as_secs_f64());
        // What the clock tells differs from turn to turn by more than stages do; a processor's own time does not.
        let cores = match is_gpu {
            true => 1.0,
            false => std::thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64),
        };
        Ok(Some(drawn.samples.cost(backend.kind()) / cores))
    };
    let all = sample(true, u32::MAX)?;
    // Where there is nothing to leave out, two pictures would differ by chance alone.
    let direct = match request.settings.bounces {
        1 => all,
        _ => sample(true, 1)?,
    };
    let camera = match request.settings.shadows {
        false => direct,
        true => sample(false, 1)?,
    };
    let (Some(all), Some(direct), Some(camera)) = (all, direct, camera) else {
        return Ok(None);
    };
    stages.extend([
        ("upload", upload.unwrap_or_default()),
        ("camera rays", camera),
        ("shadow rays", (direct - camera).max(0.0)),
        ("further bounces", (all - direct).max(0.0)),
    ]);
    Ok(Some(stages))
}

/// The dearest stage.
pub fn largest(costs: &[Cost]) -> Option<&Cost> {
    costs.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds))
}

const HEADER: &str = "preset,stage,time [s],share";

/// The file.
pub fn csv(all: &OfPresets<'_, [Cost]>) -> String {
    let lines = all.iter().flat_map(|(preset, costs)| {
        let preset = quoted(preset);
        costs.iter().map(move |cost| {
            let [time, share] = [cost.seconds, cost.share].map(number);
            format!("{preset},{},{time},{share}", cost.stage)
        })
    });
    table(HEADER, lines)
}

/// The section of the summary.
pub fn section(costs: &[Cost]) -> String {
    let mut text = String::from(
        "\nStages of the compiler and the upload are by the clock, which other work disturbs; rays are processor time \
            over cores \
         where a processor draws.\n\n| stage | time | share |\n| --- | --- | --- |\n",
    );
    for cost in costs {
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} % |",
            cost.stage,
            seconds(cost.seconds),
            100.0 * cost.share
        );
    }
    text
}

/// Every stage, as bars.
pub fn bars(preset: &str, conditions: &Conditions, costs: &[Cost]) -> Bars {
    let bar = |cost: &Cost| Bar {
        name: cost.stage.into(),
        value: Some(1e3 * cost.seconds),
        text: format!("{} ({:.1} %)", seconds(cost.seconds), 100.0 * cost.share),
    };
    let [width, height] = conditions.window;
    Bars {
        title: format!("{preset}: from an edit of all loops to a whole picture"),
        under: format!(
            "{width} × {height} pixels, one sample, {} ({})",
            conditions.backend.name(),
            conditions.device
        ),
        axis: "time [ms]".into(),
        bars: costs.iter().map(bar).collect(),
        limit: None,
        cut: None,
    }
}
