//! Renders what the plan asks for and compares it with the truth.
//!
//! The settings take turns twice, with different seeds, so that a disturbance of the machine hits one row and not one
//! method, and so that two independent pictures of each show its bias. A turn renders one picture on and on and looks
//! at it at every power of two of samples; looking is not part of the time. A turn up to error targets renders one
//! picture after another instead, each from nothing, since tiles that have ended for one target are not drawn on for
//! the next.

use std::cmp::Ordering;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use renderer_core::design::{Design, Method, Quality, Sampler};
use renderer_core::geometry::Camera;
use renderer_core::image::Picture;
use renderer_core::image::metrics;
use renderer_core::render::{
    Backend, Counters, Optimisations, RenderError, RenderRequest, Settings, convergence,
};
use renderer_core::scene::lod::LodView;
use renderer_core::scene::{self, CompileError, Scene};
use towel_designer::clock::{Spent, timed};

use crate::conditions::Conditions;
use crate::drawing::{least, per_sample};
use crate::flip::flip;
use crate::pareto::Point;
use crate::plan::{Setting, TRUTH, Target, share};
use crate::truth::{Bias, Known, Truth, known};

/// How long a backend works between looks at the clock.
const SLICE: Duration = Duration::from_millis(100);
/// Share of a target's time that goes into its truth.
const TRUTH_SHARE: f64 = 0.45;
/// Share of what is left that goes into the first of the two rounds.
const FIRST_ROUND_SHARE: f64 = 0.4;
/// Fewest samples of each half of the truth.
const FEWEST_FOR_TRUTH: u32 = 2;
/// A setting that falls by less than this from one power of two to the next has met its bias (noise falls by 1/√2)…
const STALLED: f64 = 0.97;
/// … if it has at least so many samples.
const FEWEST_TO_STALL: u32 = 4;

/// The loosest error target, as a share of the error at the fewest samples that can end anything. The next is this by
/// √½, as much as noise falls where samples double, and so on.
const LOOSEST: f64 = 1.2;

/// A row of the table: a setting with a number of samples or an error target.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Index of the setting in its target.
    pub setting: usize,
    /// Samples a pixel; with an error target the most of any.
    pub samples: u32,
    /// The error target, relRMSE, where there is one.
    pub wanted: Option<f64>,
    /// The least that a round took, since what disturbs adds time.
    pub spent: Spent,
    /// relRMSE against the truth's mean, root mean square over the rounds; contains the truth's noise.
    pub measured: f64,
    /// What follows from that.
    pub error: Known,
    /// relRMSE that the backend itself expects of its noise; `None` below sixteen samples.
    pub estimate: Option<f64>,
    /// FLIP against the truth's mean, mean over the rounds.
    pub flip: f64,
    /// Rounds that got this far.
    pub rounds: u32,
}

/// What a setting costs and lacks, whatever its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Character {
    /// Work of one sample a pixel; `None` where there was no time.
    pub counters: Option<Counters>,
    /// Cost of a sample a pixel, at the most samples measured; `None` where none was.
    pub per_sample: Option<Spent>,
    /// What samples do not remove; `None` where there was no time for two pictures.
    pub bias: Option<Bias>,
}

/// All that was found for one target.
#[derive(Debug, Clone)]
pub struct Findings {
    /// What was planned.
    pub target: Target,
    /// The truth it is held to.
    pub truth: Truth,
    /// By setting, then samples.
    pub rows: Vec<Row>,
    /// For each setting.
    pub characters: Vec<Character>,
    /// Time of a sample if nothing were traced, on a GPU.
    pub bare: Option<Duration>,
}

/// A preset to measure.
#[derive(Debug)]
pub struct Subject {
    design: Design,
    camera: Camera,
    size: [u32; 2],
    /// Scenes by the bounces they are compiled for: colours depend on them.
    scenes: Vec<(u32, Arc<Scene>)>,
}

/// Picture and price of a setting at some number of samples, in one round.
struct Look {
    samples: u32,
    wanted: Option<f64>,
    spent: Spent,
    measured: f64,
    flip: f64,
    estimate: Option<f64>,
}

/// What a row is of: minus the error target, so that stricter ones come later, or a number of samples.
#[derive(PartialEq, PartialOrd)]
enum Step {
    Target(f64),
    Samples(u32),
}

impl Look {
    fn step(&self) -> Step {
        match self.wanted {
            Some(wanted) => Step::Target(-wanted),
            None => Step::Samples(self.samples),
        }
    }
}

/// One turn of a setting.
#[derive(Default)]
struct Turn {
    looks: Vec<Look>,
    last: Option<Picture>,
}

impl Subject {
    /// A preset's design by its first camera.
    pub fn new(design: Design, size: [u32; 2]) -> Option<Self> {
        let camera = design.view.cameras.first().map(Camera::from_design)?;
        Some(Self {
            design,
            camera,
            size,
            scenes: Vec::new(),
        })
    }

    /// The quality that the preset asks for itself.
    pub fn quality(&self) -> &Quality {
        &self.design.quality
    }

    fn scene(&mut self, bounces: u32) -> Result<Arc<Scene>, CompileError> {
        if let Some((_, scene)) = self.scenes.iter().find(|(b, _)| *b == bounces) {
            return Ok(Arc::clone(scene));
        }
        let mut design = self.design.clone();
        design.quality.bounces = bounces;
        let scene = Arc::new(scene::compile(&design)?);
        self.scenes.push((bounces, Arc::clone(&scene)));
        Ok(scene)
    }

    fn request(&mut self, setting: &Setting, seed: u32) -> Result<RenderRequest, CompileError> {
        let [width, height] = self.size;
        Ok(RenderRequest {
            view: LodView::of(self.scene(setting.bounces)?, self.camera),
            size: self.size,
            crop: [0, 0, width, height],
            settings: Settings {
                method: setting.method,
                sampler: setting.sampler.into(),
                shadows: setting.shadows,
                bounces: setting.bounces,
                traced_bounces: setting.traced_bounces,
                cached_shadows: setting.cached_shadows,
                learns_bounces: setting.cached_shadows > 0,
                optimisations: match setting.without {
                    Some(optimisation) => Optimisations::ALL.without(optimisation),
                    None => Optimisations::ALL,
                },
                samples: 1,
                error: 0.0,
                seed,
                ..Settings::from(&self.design.quality)
            },
        })
    }

    /// The methods that `backend` has.
    ///
    /// # Errors
    /// When the scene cannot be made or the backend fails.
    pub fn methods_of(&mut self, backend: &mut dyn Backend) -> anyhow::Result<Vec<Method>> {
        let mut methods = Vec::new();
        for &method in Method::ALL {
            let setting = Setting {
                method,
                sampler: Sampler::Owen,
                shadows: true,
                bounces: 1,
                traced_bounces: 0,
                cached_shadows: 0,
                without: None,
                to_error: false,
            };
            match backend.begin(&self.request(&setting, 0)?) {
                Ok(()) => methods.push(method),
                Err(RenderError::Method { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(methods)
    }

    fn exposure(&self) -> f64 {
        self.design.exposure()
    }
}

/// Measures one target until `deadline`; `say` is given what is being done.
///
/// # Errors
/// When the scene cannot be made or the backend fails.
pub fn measure(
    subject: &mut Subject,
    backend: &mut dyn Backend,
    target: Target,
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Findings> {
    let left = deadline.saturating_duration_since(Instant::now());
    let truth_deadline = Instant::now() + left.mul_f64(TRUTH_SHARE);
    say("truth");
    let truth = truth(subject, backend, &target, truth_deadline, &mut say)?;

    let left = deadline.saturating_duration_since(Instant::now());
    let first_deadline = Instant::now() + left.mul_f64(FIRST_ROUND_SHARE);
    let mut turns: Vec<[Option<Turn>; 2]> = target.settings.iter().map(|_| [None, None]).collect();
    let mut counted: Vec<(Setting, Counters)> = Vec::new();
    let mut loosest = None;
    for (round, round_deadline) in [first_deadline, deadline].into_iter().enumerate() {
        let mut order: Vec<usize> = (0..target.settings.len()).collect();
        if round == 1 {
            // First what there was no time for. Then the most important last: what the others leave over is theirs.
            order.sort_by_key(|&index| match turns[index][0] {
                None => (0, index),
                Some(_) => (1, target.settings.len() - index),
            });
        }
        for (turn, &index) in order.iter().enumerate() {
            let now = Instant::now();
            // One step of the first setting is always made.
            if now >= round_deadline && (round, turn) != (0, 0) {
                break;
            }
            let setting = &target.settings[index];
            let to_come: Vec<Setting> = order[turn..].iter().map(|&i| target.settings[i]).collect();
            say(&format!("{}, round {}", setting.name(&target), round + 1));
            let left = round_deadline.saturating_duration_since(now).as_secs_f64();
            let share = Duration::from_secs_f64(share(&to_come, left));
            let request = subject.request(setting, 1 + round as u32)?;
            if !counted.iter().any(|(other, _)| works_like(other, setting)) {
                counted.push((*setting, count(backend, request.clone())?));
            }
            let held_to = (&truth, subject.exposure());
            let turn = if setting.to_error {
                if loosest.is_none() {
                    let first = subject.request(setting, 0)?;
                    loosest = loosest_target(backend, first, now + share)?;
                }
                take_turn_to_errors(backend, request, held_to, loosest, now + share)?
            } else {
                take_turn(backend, request, held_to, now + share)?
            };
            turns[index][round] = turn;
        }
    }
    let mut characters = Vec::new();
    for (setting, turns) in target.settings.iter().zip(&turns) {
        let mut counted = counted.iter();
        let counters = counted.find(|(other, _)| works_like(other, setting));
        let counters = counters.map(|(_, counters)| *counters);
        characters.push(character(setting, counters, turns, &truth)?);
    }
    backend.begin(&subject.request(&target.settings[0], 0)?)?;
    let bare = backend.baseline_sample()?;
    let turns = turns.iter().enumerate();
    let rows = turns.flat_map(|(index, turns)| rows(index, turns, truth.noise));
    Ok(Findings {
        rows: rows.collect(),
        target,
        truth,
        characters,
        bare,
    })
}

/// Adds samples up to what `request` asks for.
fn render(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    spent: &mut Spent,
    mut go_on: impl FnMut() -> bool,
) -> anyhow::Result<Option<(u32, Option<f64>)>> {
    backend.begin(request)?;
    let never = AtomicBool::new(false);
    loop {
        let progress = timed(spent, || backend.advance(SLICE, &never))?;
        if progress.done {
            return Ok(Some((progress.samples, progress.error_estimate)));
        }
        if !go_on() {
            return Ok(None);
        }
    }
}

/// Renders the truth: two halves with half of the time each.
fn truth(
    subject: &mut Subject,
    backend: &mut dyn Backend,
    target: &Target,
    deadline: Instant,
    say: &mut impl FnMut(&str),
) -> anyhow::Result<Truth> {
    let setting = Setting {
        method: TRUTH,
        bounces: target.bounces,
        traced_bounces: 0,
        ..target.settings[0]
    };
    let mut halves = Vec::new();
    let mut samples = [0; 2];
    for (half, samples) in samples.iter_mut().enumerate() {
        let left = deadline.saturating_duration_since(Instant::now());
        let half_deadline = Instant::now() + left / (2 - half as u32);
        // Seeds of their own, far from those of the settings.
        let mut request = subject.request(&setting, 1_000_000 + half as u32)?;
        loop {
            // A sample after the other, so that every pixel has equally many when time is up.
            request.settings.samples = *samples + 1;
            if let Some((reached, _)) = render(backend, &request, &mut Spent::default(), || true)? {
                *samples = reached;
            }
            say(&format!("truth, half {}, {samples} samples", half + 1));
            let most = Quality::FIELDS.samples.max as u32;
            if (Instant::now() >= half_deadline && *samples >= FEWEST_FOR_TRUTH) || *samples >= most
            {
                break;
            }
        }
        halves.push(backend.picture()?);
    }
    let halves: [Picture; 2] = halves
        .try_into()
        .map_err(|_| anyhow::anyhow!("the truth has no two halves"))?;
    Ok(Truth::new(halves, samples, subject.exposure())?)
}

/// Renders on until `deadline`, as far as powers of two of samples can be reached, or until more samples do not help.
fn take_turn(
    backend: &mut dyn Backend,
    mut request: RenderRequest,
    held_to: (&Truth, f64),
    deadline: Instant,
) -> anyhow::Result<Option<Turn>> {
    let mut turn = Turn::default();
    let mut spent = Spent::zero();
    let most = Quality::FIELDS.samples.max as u32;
    while request.settings.samples <= most {
        let begun = spent.wall;
        let in_time = || request.settings.samples == 1 || Instant::now() < deadline;
        let Some((samples, estimate)) = render(backend, &request, &mut spent, in_time)? else {
            break;
        };
        let stalled = turn.look(backend.picture()?, held_to, |measured, flip| Look {
            samples,
            wanted: None,
            spent,
            measured,
            flip,
            estimate,
        })?;
        // As many samples again will take about as long as all so far.
        let next = if samples == 1 {
            spent.wall - begun
        } else {
            spent.wall
        };
        if stalled || Instant::now() + next > deadline {
            break;
        }
        request.settings.samples = 2 * samples;
    }
    Ok(Some(turn))
}

/// The loosest error target; `None` where time is up before it is known, or where there is nothing but background.
fn loosest_target(
    backend: &mut dyn Backend,
    mut request: RenderRequest,
    deadline: Instant,
) -> anyhow::Result<Option<f64>> {
    request.settings.samples = convergence::FEWEST_FOR_ERROR;
    let in_time = || Instant::now() < deadline;
    let drawn = render(backend, &request, &mut Spent::default(), in_time)?;
    let estimate = drawn.and_then(|(_, estimate)| estimate);
    let known = estimate.filter(|estimate| *estimate > 0.0);
    Ok(known.map(|estimate| LOOSEST * estimate))
}

/// Draws one picture after another, each from nothing up to an error target that is stricter than the last, until
/// `deadline` or until that does not help. `None` where not one was done in time.
fn take_turn_to_errors(
    backend: &mut dyn Backend,
    mut request: RenderRequest,
    held_to: (&Truth, f64),
    loosest: Option<f64>,
    deadline: Instant,
) -> anyhow::Result<Option<Turn>> {
    let mut turn = Turn::default();
    let Some(mut wanted) = loosest else {
        return Ok(None);
    };
    request.settings.samples = Quality::FIELDS.samples.max as u32;
    loop {
        let mut other = request.clone();
        other.settings.seed = !request.settings.seed;
        backend.begin(&other)?;
        request.settings.error = wanted;
        let mut spent = Spent::zero();
        let in_time = || Instant::now() < deadline;
        let Some((samples, estimate)) = render(backend, &request, &mut spent, in_time)? else {
            break;
        };
        let stalled = turn.look(backend.picture()?, held_to, |measured, flip| Look {
            samples,
            wanted: Some(wanted),
            spent,
            measured,
            flip,
            estimate,
        })?;
        if stalled || Instant::now() + spent.wall > deadline {
            break;
        }
        wanted *= std::f64::consts::FRAC_1_SQRT_2;
    }
    Ok((!turn.looks.is_empty()).then_some(turn))
}

impl Turn {
    /// Compares a picture with the truth and notes what `look` makes of relRMSE and FLIP. Whether more samples did not
    /// help.
    fn look(
        &mut self,
        picture: Picture,
        (truth, exposure): (&Truth, f64),
        look: impl FnOnce(f64, f64) -> Look,
    ) -> anyhow::Result<bool> {
        let look = look(
            metrics::rel_rmse(&picture, &truth.mean)?,
            flip(&picture, &truth.mean, exposure)?,
        );
        let has_stalled =
            |last: &Look| look.samples > last.samples && look.measured > STALLED * last.measured;
        let stalled = look.samples >= FEWEST_TO_STALL && self.looks.last().is_some_and(has_stalled);
        self.looks.push(look);
        self.last = Some(picture);
        Ok(stalled)
    }
}

/// Whether two settings do the same work for a sample, but for chance.
fn works_like(a: &Setting, b: &Setting) -> bool {
    let kind = |s: &Setting| Setting {
        sampler: a.sampler,
        to_error: a.to_error,
        ..*s
    };
    kind(a) == kind(b)
}

/// Work of one sample a pixel.
fn count(backend: &mut dyn Backend, mut request: RenderRequest) -> anyhow::Result<Counters> {
    request.settings.counters = true;
    render(backend, &request, &mut Spent::default(), || true)?;
    Ok(backend.counters()?)
}

/// What both turns of a setting show of it.
fn character(
    setting: &Setting,
    counters: Option<Counters>,
    turns: &[Option<Turn>; 2],
    truth: &Truth,
) -> anyhow::Result<Character> {
    let last = |turn: &Option<Turn>| turn.as_ref().and_then(|turn| turn.last.clone());
    let bias = match (last(&turns[0]), last(&turns[1])) {
        (Some(a), Some(b)) => Some(Bias::new([&a, &b], truth)?),
        _ => None,
    };
    // Up to an error some pixels have more samples than others.
    let looks = turns.iter().filter(|_| !setting.to_error).flatten();
    let looks = looks.filter_map(|turn| turn.looks.last());
    let per_sample = looks.map(|look| per_sample(look.spent, look.samples));
    Ok(Character {
        counters,
        per_sample: least(per_sample),
        bias,
    })
}

/// The rows of a setting: its rounds put together.
fn rows(setting: usize, turns: &[Option<Turn>; 2], noise: f64) -> Vec<Row> {
    let all: Vec<&Look> = turns
        .iter()
        .flatten()
        .flat_map(|turn| &turn.looks)
        .collect();
    let mut steps: Vec<Step> = all.iter().map(|look| look.step()).collect();
    steps.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    steps.dedup();
    let row = |step: Step| {
        let looks: Vec<&Look> = all
            .iter()
            .copied()
            .filter(|look| look.step() == step)
            .collect();
        let count = looks.len() as f64;
        let mean =
            |value: &dyn Fn(&Look) -> f64| looks.iter().map(|l| value(l)).sum::<f64>() / count;
        let estimates: Option<Vec<f64>> = looks.iter().map(|look| look.estimate).collect();
        let measured = mean(&|look| look.measured.powi(2)).sqrt();
        Row {
            setting,
            samples: looks.iter().map(|look| look.samples).max().unwrap_or(0),
            wanted: looks.first().and_then(|look| look.wanted),
            spent: least(looks.iter().map(|look| look.spent)).unwrap_or_default(),
            measured,
            error: known(measured, noise),
            estimate: estimates.map(|all| (all.iter().map(|e| e * e).sum::<f64>() / count).sqrt()),
            flip: mean(&|look| look.flip),
            rounds: looks.len() as u32,
        }
    };
    steps.into_iter().map(row).collect()
}

/// The name that a preset's results go by: its file's without the extension.
pub fn name_of(preset: &Path) -> String {
    preset
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Cost and error of rows, held to a truth of this noise.
pub fn points(conditions: &Conditions, rows: &[&Row], noise: f64) -> Vec<Point> {
    let point = |row: &&Row| Point {
        cost: row.spent.cost(conditions.backend),
        error: row.error.bound(noise),
    };
    rows.iter().map(point).collect()
}
