//! One picture after another, and what each costs.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use renderer_core::design::Design;
use renderer_core::geometry::Camera;
use renderer_core::render::{Backend, Counters, RenderRequest, Settings};
use renderer_core::scene::Scene;
use renderer_core::scene::lod::LodView;

use towel_designer::clock::{Spent, timed};

/// How long a backend works between looks at the clock.
const SLICE: Duration = Duration::from_millis(100);

/// What a picture cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drawn {
    /// Giving the scene to the backend, pipelines included.
    pub upload: Spent,
    /// Making pipelines.
    pub pipelines: Duration,
    /// Adding samples.
    pub samples: Spent,
    /// relRMSE that the backend expects of its noise; `None` below sixteen samples.
    pub estimate: Option<f64>,
}

/// Draws until done; `None` if time was up before.
///
/// # Errors
/// When the backend fails.
pub fn draw(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    deadline: Option<Instant>,
) -> anyhow::Result<Option<Drawn>> {
    let [mut upload, mut pipelines, mut samples] = [Spent::zero(); 3];
    timed(&mut upload, || backend.begin_soon(request))?;
    // The same request again: only waits for what it needs.
    timed(&mut pipelines, || backend.begin(request))?;
    let never = AtomicBool::new(false);
    loop {
        let progress = timed(&mut samples, || backend.advance(SLICE, &never))?;
        if progress.done {
            return Ok(Some(Drawn {
                upload,
                pipelines: pipelines.wall,
                samples,
                estimate: progress.error_estimate,
            }));
        }
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Ok(None);
        }
    }
}

/// The work of drawing until done, counted, which takes longer than drawing.
///
/// # Errors
/// When the backend fails.
pub fn count(backend: &mut dyn Backend, request: &RenderRequest) -> anyhow::Result<Counters> {
    let mut request = request.clone();
    request.settings.counters = true;
    draw(backend, &request, None)?;
    Ok(backend.counters()?)
}

/// The whole picture of a design by its first camera, with so many samples and no error target.
///
/// # Errors
/// When the design has no camera.
pub fn request(
    design: &Design,
    scene: &Arc<Scene>,
    size: [u32; 2],
    samples: u32,
) -> anyhow::Result<RenderRequest> {
    let camera = design.view.cameras.first().map(Camera::from_design);
    Ok(RenderRequest {
        view: LodView::of(
            Arc::clone(scene),
            camera.ok_or_else(|| anyhow!("the preset has no camera"))?,
        ),
        size,
        crop: [0, 0, size[0], size[1]],
        settings: Settings {
            samples,
            error: 0.0,
            ..Settings::from(&design.quality)
        },
    })
}

/// The clocks tell work of this length; what is shorter is done several times.
pub const LONG: Duration = Duration::from_millis(120);

/// Most samples of what is repeated to be long enough.
const MOST_SAMPLES: u32 = 16;

/// How many samples make a picture of which one takes so long long enough.
pub fn samples_for(one: Duration) -> u32 {
    let samples = LONG.as_nanos() / one.as_nanos().max(1);
    (samples.min(MOST_SAMPLES.into()) as u32).max(1)
}

/// What each of so many samples cost.
pub fn per_sample(spent: Spent, samples: u32) -> Spent {
    Spent {
        wall: spent.wall / samples,
        processor: spent.processor.map(|time| time / samples),
    }
}

/// Patch tests for each ray of either kind.
pub fn patch_tests_per_ray(counters: &Counters) -> f64 {
    let rays = (counters.rays + counters.shadow_rays).max(1);
    counters.patch_tests as f64 / rays as f64
}

/// The middle one of some values; NaN of none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[count / 2],
        count => 0.5 * (values[count / 2 - 1] + values[count / 2]),
    }
}

/// The least that any turn took, by each clock, since what disturbs adds time; `None` of none.
pub fn least(all: impl IntoIterator<Item = Spent>) -> Option<Spent> {
    all.into_iter().reduce(|a, b| Spent {
        wall: a.wall.min(b.wall),
        processor: match (a.processor, b.processor) {
            (Some(a), Some(b)) => Some(a.min(b)),
            _ => None,
        },
    })
}
