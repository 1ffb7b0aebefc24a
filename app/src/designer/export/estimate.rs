//! How long an export will take, before one starts: a small picture of the same view is rendered as the export would
//! be, on a thread of its own, and timed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use egui::Context;
use renderer_core::design::{CameraDesign, Design};
use renderer_core::geometry::Camera;
use renderer_core::render::{Backend, RenderRequest, Settings};
use renderer_core::scene::Cancel;
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodView};

use crate::backend::BackendChoice;
use crate::designer::render_thread::renderer::MakeBackend;
use crate::designer::tasks::Latest;

/// Longer side of the picture that is timed, pixels.
const SIDE: f64 = 96.0;
/// Its most samples,
const SAMPLES: u32 = 8;
/// and the time after which it needs no more of them.
const LONG_ENOUGH: Duration = Duration::from_millis(700);

/// Without a single sample after this, nothing is said.
const GIVEN_UP: Duration = Duration::from_secs(20);

/// What the time depends on beside size and samples.
#[derive(Clone, PartialEq)]
pub(super) struct Subject {
    pub design: Arc<Design>,
    pub camera: CameraDesign,
    pub choice: BackendChoice,
    /// Width over height.
    pub proportion: f64,
}

/// Times as measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    /// Making the scene and handing it over, seconds.
    pub start: f64,
    /// A sample of a pixel, seconds.
    pub sample: f64,
}

impl Cost {
    /// The time that so many samples of pixels take to render, at most the limit.
    pub fn rendering(&self, samples: f64, limit: Option<Duration>) -> Duration {
        let time = Duration::try_from_secs_f64(self.sample * samples).unwrap_or(Duration::MAX);
        limit.map_or(time, |limit| time.min(limit))
    }
}

/// The newest estimate.
#[derive(Default)]
pub(super) struct Estimate {
    latest: Latest<Subject, Option<Cost>>,
    /// Ends the measurement under way.
    cancel: Arc<AtomicBool>,
}

impl Drop for Estimate {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Estimate {
    /// What a picture of the subject costs; `None` while that is not known.
    pub fn cost(&mut self, ctx: &Context, subject: &Subject, make: &MakeBackend) -> Option<Cost> {
        let (make, cancel) = (Arc::clone(make), Arc::clone(&self.cancel));
        let work = move |subject: &Subject| measure(subject, &make, &cancel);
        let latest = self.latest.get(ctx, subject, work);
        let (of, cost) = latest?;
        cost.filter(|_| of == subject)
    }
}

/// Renders a small picture; `None` if that cannot be done, which the export will say better.
fn measure(subject: &Subject, make: &MakeBackend, cancel: &AtomicBool) -> Option<Cost> {
    let design = &*subject.design;
    if !design.faults().is_empty() {
        return None;
    }
    let begun = Instant::now();
    let [wide, high] = [
        subject.proportion.min(1.0),
        subject.proportion.max(1.0).recip(),
    ];
    let size = [wide, high].map(|share| ((SIDE * share).round() as u32).max(1));
    let camera = Camera::from_design(&subject.camera);
    let is_given_up = || cancel.load(Ordering::Relaxed);
    let view = LodView::new(
        &mut LodCompiler::default(),
        design,
        &camera,
        size,
        LodBudget::FINAL,
        &Cancel::when(&is_given_up),
    );
    let settings = Settings {
        samples: SAMPLES,
        error: 0.0,
        ..Settings::from(&design.quality)
    };
    let request = RenderRequest::new(view.ok()?, size, settings);
    let mut backend = make(subject.choice.for_method(design.quality.method)).ok()?;
    backend.begin(&request).ok()?;
    let start = begun.elapsed();
    let sample = time_samples(&mut *backend, cancel)?;
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    Some(Cost {
        start: start.as_secs_f64(),
        sample: sample / pixels,
    })
}

/// Seconds of a sample of the picture that a backend has begun. The first warms caches up, and does not count where
/// there is time for more.
fn time_samples(backend: &mut dyn Backend, cancel: &AtomicBool) -> Option<f64> {
    let begun = Instant::now();
    let mut first = None::<(u32, Duration)>;
    loop {
        let progress = backend.advance(Duration::from_millis(20), cancel).ok()?;
        let elapsed = begun.elapsed();
        let is_hopeless = progress.samples == 0 && elapsed > GIVEN_UP;
        if is_hopeless || cancel.load(Ordering::Relaxed) {
            return None;
        }
        if progress.samples > 0 && first.is_none() {
            first = Some((progress.samples, elapsed));
        }
        if progress.done || (progress.samples > 0 && elapsed > LONG_ENOUGH) {
            let (before, until) = first.unwrap_or_default();
            return Some(match progress.samples - before.min(progress.samples) {
                0 => elapsed.as_secs_f64() / f64::from(progress.samples.max(1)),
                more => (elapsed - until).as_secs_f64() / f64::from(more),
            });
        }
    }
}

/// About how long so many samples of pixels take, as one says it.
pub(super) fn text(
    cost: Option<Cost>,
    samples: f64,
    limit: Option<Duration>,
    may_end_sooner: bool,
) -> String {
    let Some(cost) = cost else {
        return "Estimating how long it takes…".into();
    };
    let mut seconds = cost.start + cost.sample * samples;
    let mut words = if may_end_sooner {
        "At most about"
    } else {
        "Takes about"
    };
    if let Some(limit) = limit.filter(|limit| limit.as_secs_f64() < seconds) {
        (seconds, words) = (limit.as_secs_f64(), "Ends after");
    }
    format!("{words} {}.", duration_text(seconds))
}

/// `8 s`, `3 min`, `1 h 20 min`, no finer than it can be known.
fn duration_text(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match seconds {
        ..1.5 => "a second".into(),
        ..90.0 => format!("{seconds:.0} s"),
        ..5400.0 => format!("{minutes} min"),
        _ => format!("{} h {:02} min", minutes / 60, minutes % 60),
    }
}
