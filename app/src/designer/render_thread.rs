//! The thread that owns a backend: takes the latest wish of the viewport, compiles its scene, renders it in short
//! slices and publishes pictures. The window never waits for it, and when a picture is done it sleeps.
//!
//! A new wish is first drawn small: at a fraction of the size that takes a few hundredths of a second, then at double
//! that, and so on up to the full size. So every edit shows at once, however slow the machine, and nothing of the full
//! picture's samples depends on it. Pictures of very few samples are shown with neighbours averaged: less sharp, but
//! less noisy.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use renderer_core::design::{CameraDesign, Design};
use renderer_core::image::Display;
use renderer_core::render::{BackendKind, Camera, Progress, RenderRequest};
use renderer_core::scene::{self, Compiler, LoopCounts, Scene};

use super::live_light::LiveLight;
use super::renderer::{Developer, MakeRenderer, Renderer, Shot};
use crate::backend::BackendChoice;

/// How long a backend works before the thread looks for news.
const SLICE: Duration = Duration::from_millis(50);
/// The same on the window's own GPU, where frames must wait for what is under way.
const SHORT_SLICE: Duration = Duration::from_millis(12);
/// Pictures are published at most this often.
const PUBLISHING: Duration = Duration::from_millis(50);
/// A first picture that takes longer than this is drawn smaller.
const FIRST_PICTURE: f64 = 0.1;
/// Samples of a small picture.
const REDUCED_SAMPLES: u32 = 4;
/// Pictures of fewer samples are shown with 2 × 2 pixels averaged,
const SHARP_FROM: u32 = 4;
/// unless they are smaller than this: there is no sharpness to give away.
const SOFT_UP_TO: u32 = 2;
/// Smallest first picture: this fraction of the full width and height.
const MOST_REDUCED: u32 = 16;

/// What the viewport wants to see.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// A design without faults.
    pub design: Arc<Design>,
    /// From where.
    pub camera: CameraDesign,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// How light becomes colour.
    pub display: Display,
    /// Which backend.
    pub choice: BackendChoice,
    /// Which light.
    pub light: LiveLight,
}

/// What the thread is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Activity {
    /// Nothing.
    #[default]
    Idle,
    /// Making the scene.
    Compiling,
    /// Adding samples.
    Rendering,
}

/// What the thread has to show.
#[derive(Debug, Clone, Default)]
pub struct Shown {
    /// The newest picture.
    pub image: Option<Shot>,
    /// Counts pictures, so that the viewport notices a new one.
    pub version: u64,
    /// What the newest picture shows; its samples are those of a smaller picture while `is_reduced`.
    pub progress: Progress,
    /// Whether the newest picture is a small one, drawn for speed.
    pub is_reduced: bool,
    /// Whether no picture of full size shows what is wished yet.
    pub is_first: bool,
    /// What the thread is doing.
    pub activity: Activity,
    /// Time spent rendering since the last wish that changed the picture.
    pub seconds: f64,
    /// The backend at work and its adapter or processor.
    pub device: Option<(BackendKind, String)>,
    /// Bytes on the device.
    pub device_bytes: u64,
    /// Loops of the scene.
    pub counts: LoopCounts,
    /// Things about the design and its scene that are allowed but probably not meant.
    pub warnings: Vec<String>,
    /// What went wrong, until something goes right.
    pub error: Option<String>,
}

impl Shown {
    /// Whether the thread works towards the first picture of what is wished: somebody waits for it.
    pub fn is_busy(&self) -> bool {
        match self.activity {
            Activity::Idle => false,
            Activity::Compiling => true,
            Activity::Rendering => self.is_first,
        }
    }
}

#[derive(Default)]
struct Mailbox {
    wish: Option<Wish>,
    stop: bool,
}

#[derive(Default)]
struct Shared {
    mailbox: Mutex<Mailbox>,
    mail: Condvar,
    cancel: AtomicBool,
    shown: Mutex<Shown>,
}

/// Nobody panics while holding these locks; if somebody did, the data would still be whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Handle of the thread; dropping it stops and joins it.
pub struct RenderThread {
    shared: Arc<Shared>,
    make: MakeRenderer,
    repaint: egui::Context,
    thread: Option<JoinHandle<()>>,
}

impl RenderThread {
    /// Starts the thread. It asks `repaint` for a frame whenever it has news.
    pub fn new(make: MakeRenderer, repaint: egui::Context) -> Self {
        let mut this = Self {
            shared: Arc::default(),
            make,
            repaint,
            thread: None,
        };
        this.start();
        this
    }

    fn start(&mut self) {
        let shared = Arc::clone(&self.shared);
        let (make, repaint) = (Arc::clone(&self.make), self.repaint.clone());
        let started = std::thread::Builder::new()
            .name("render".into())
            .spawn(move || {
                let worker = AssertUnwindSafe(|| Worker::new(&shared, make, &repaint).run());
                if let Err(panic) = catch_unwind(worker) {
                    let reason = panic
                        .downcast_ref::<String>()
                        .map(String::as_str)
                        .or_else(|| panic.downcast_ref::<&str>().copied())
                        .unwrap_or("unknown reason");
                    let mut shown = lock(&shared.shown);
                    shown.activity = Activity::Idle;
                    shown.error = Some(format!(
                        "The renderer stopped: {reason}. The design is unharmed; the next change starts it again."
                    ));
                    drop(shown);
                    repaint.request_repaint();
                }
            });
        match started {
            Ok(thread) => self.thread = Some(thread),
            Err(error) => {
                lock(&self.shared.shown).error =
                    Some(format!("No thread to render with: {error}."));
            }
        }
    }

    /// Renders this instead of what was wanted before. `same_picture` says that only its display differs.
    pub fn send(&mut self, wish: Wish, same_picture: bool) {
        if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
            self.start();
        }
        let mut mailbox = lock(&self.shared.mailbox);
        mailbox.wish = Some(wish);
        if !same_picture {
            self.shared.cancel.store(true, Ordering::Relaxed);
        }
        self.shared.mail.notify_one();
    }

    /// What there is to show now.
    pub fn shown(&self) -> Shown {
        lock(&self.shared.shown).clone()
    }
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        lock(&self.shared.mailbox).stop = true;
        self.shared.cancel.store(true, Ordering::Relaxed);
        self.shared.mail.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic was told in the window already.
            let _ = thread.join();
        }
    }
}

struct Worker<'a> {
    shared: &'a Shared,
    make: MakeRenderer,
    repaint: &'a egui::Context,
    renderer: Option<(BackendChoice, Renderer)>,
    wish: Option<Wish>,
    compiler: Compiler,
    scene: Option<Arc<Scene>>,
    job: Option<Job>,
    developer: Developer,
    /// Seconds for a sample of a pixel, as last measured.
    cost: Option<f64>,
}

/// A picture in work.
struct Job {
    request: RenderRequest,
    /// Width and height of the picture in work are those of the request divided by this.
    divisor: u32,
    is_done: bool,
    samples: u32,
    seconds: f64,
    /// Seconds on the picture of the present divisor.
    rung_seconds: f64,
    published: Instant,
    publishing_took: Duration,
}

impl<'a> Worker<'a> {
    fn new(shared: &'a Shared, make: MakeRenderer, repaint: &'a egui::Context) -> Self {
        Self {
            shared,
            make,
            repaint,
            renderer: None,
            wish: None,
            compiler: Compiler::default(),
            scene: None,
            job: None,
            developer: Developer::default(),
            cost: None,
        }
    }

    fn run(&mut self) {
        while let Some(mail) = self.next_mail() {
            let result = match mail {
                Some(wish) => self.take(wish),
                None => self.advance(),
            };
            if let Err(error) = result {
                // What remains of a failed device is of no use; the next wish makes a new one.
                self.renderer = None;
                self.job = None;
                self.publish(|shown| {
                    shown.activity = Activity::Idle;
                    shown.error = Some(error);
                });
            }
        }
    }

    /// A wish, or `Some(None)` if there is none and work goes on; sleeps while there is nothing to do. `None` to stop.
    fn next_mail(&self) -> Option<Option<Wish>> {
        let mut mailbox = lock(&self.shared.mailbox);
        loop {
            if mailbox.stop {
                return None;
            }
            if let Some(wish) = mailbox.wish.take() {
                self.shared.cancel.store(false, Ordering::Relaxed);
                return Some(Some(wish));
            }
            if self.job.as_ref().is_some_and(|job| !job.is_done) {
                return Some(None);
            }
            mailbox = self
                .shared
                .mail
                .wait(mailbox)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn publish(&self, change: impl FnOnce(&mut Shown)) {
        change(&mut lock(&self.shared.shown));
        self.repaint.request_repaint();
    }

    /// Starts what is wished, as far as it differs from what is in work.
    fn take(&mut self, wish: Wish) -> Result<(), String> {
        let scene = self.scene_of(&wish.design)?;
        self.choose_backend(wish.choice.for_method(wish.design.quality.method))?;
        let request = RenderRequest {
            scene,
            camera: Camera::from_design(&wish.camera),
            size: wish.size,
            crop: [0, 0, wish.size[0], wish.size[1]],
            settings: wish.light.settings(&wish.design),
        };
        let same_request = self.job.as_ref().is_some_and(|job| job.request == request);
        let last_display = self.wish.as_ref().map(|wish| wish.display);
        let display = wish.display;
        self.wish = Some(wish);
        if same_request {
            if last_display != Some(display) {
                self.show_again(display)?;
            }
            return Ok(());
        }
        let only_targets_differ = self.job.as_ref().is_some_and(|job| {
            let mut same = request.clone();
            (same.settings.samples, same.settings.error) =
                (job.request.settings.samples, job.request.settings.error);
            job.divisor == 1 && same == job.request
        });
        let now = Instant::now();
        let divisor = if only_targets_differ {
            1
        } else {
            self.first_divisor(request.size)
        };
        self.job = Some(Job {
            request,
            divisor,
            is_done: false,
            samples: 0,
            seconds: 0.0,
            rung_seconds: 0.0,
            published: now,
            publishing_took: Duration::ZERO,
        });
        self.begin()
    }

    fn scene_of(&mut self, design: &Arc<Design>) -> Result<Arc<Scene>, String> {
        let same = self
            .wish
            .as_ref()
            .is_some_and(|wish| Arc::ptr_eq(&wish.design, design));
        if let (true, Some(scene)) = (same, &self.scene) {
            return Ok(Arc::clone(scene));
        }
        let mut before = Activity::Idle;
        self.publish(|shown| {
            before = std::mem::replace(&mut shown.activity, Activity::Compiling);
        });
        let scene = self
            .compiler
            .compile(design)
            .map_err(|error| error.to_string())?;
        let (counts, warnings) = (scene.loops.counts, scene::warnings(design, &scene));
        self.publish(|shown| {
            // Where the picture stays the same, so does what is being done.
            shown.activity = before;
            shown.counts = counts;
            shown.warnings = warnings;
        });
        self.scene = Some(Arc::clone(&scene));
        Ok(scene)
    }

    fn choose_backend(&mut self, choice: BackendChoice) -> Result<(), String> {
        if matches!(&self.renderer, Some((made, _)) if *made == choice) {
            return Ok(());
        }
        // The old one goes first: two of them may be more than the device's memory holds.
        self.renderer = None;
        self.job = None;
        self.cost = None;
        let mut renderer = (self.make)(choice).map_err(|error| error.to_string())?;
        let backend = renderer.backend();
        let device = Some((backend.kind(), backend.device_name()));
        self.renderer = Some((choice, renderer));
        self.publish(|shown| shown.device = device);
        Ok(())
    }

    /// The divisor at which one sample takes less than [`FIRST_PICTURE`].
    fn first_divisor(&self, size: [u32; 2]) -> u32 {
        let Some(cost) = self.cost else {
            return MOST_REDUCED;
        };
        let whole = cost * f64::from(size[0]) * f64::from(size[1]);
        let mut divisor = 1;
        while divisor < MOST_REDUCED && whole / f64::from(divisor * divisor) > FIRST_PICTURE {
            divisor *= 2;
        }
        divisor
    }

    /// Hands the job's picture, at its present divisor, to the backend.
    fn begin(&mut self) -> Result<(), String> {
        let (Some(job), Some((_, renderer))) = (&mut self.job, &mut self.renderer) else {
            return Ok(());
        };
        let backend = renderer.backend();
        job.samples = 0;
        job.rung_seconds = 0.0;
        let begun = backend.begin(&reduced(&job.request, job.divisor));
        begun.map_err(|error| error.to_string())?;
        let bytes = backend.device_bytes();
        self.publish(|shown| {
            shown.activity = Activity::Rendering;
            shown.is_first = true;
            shown.device_bytes = bytes;
            shown.error = None;
        });
        Ok(())
    }

    /// One slice of work on the job.
    fn advance(&mut self) -> Result<(), String> {
        let (Some(job), Some((_, renderer))) = (&mut self.job, &mut self.renderer) else {
            return Ok(());
        };
        let slice = match renderer {
            Renderer::Within(backend) if !backend.context().is_software() => SHORT_SLICE,
            Renderer::Apart(_) | Renderer::Within(_) => SLICE,
        };
        let start = Instant::now();
        let progress = renderer
            .backend()
            .advance(slice, &self.shared.cancel)
            .map_err(|error| error.to_string())?;
        let spent = start.elapsed().as_secs_f64();
        job.seconds += spent;
        job.rung_seconds += spent;
        if progress.samples > job.samples || progress.done {
            let is_first = job.samples == 0;
            job.samples = progress.samples;
            let [width, height] = reduced(&job.request, job.divisor).size;
            let samples = f64::from(progress.samples.max(1));
            self.cost = Some(job.rung_seconds / (f64::from(width) * f64::from(height) * samples));
            let is_due = job.published.elapsed() > (4 * job.publishing_took).max(PUBLISHING);
            if progress.done || is_first || is_due {
                self.show(progress)?;
            }
        }
        if progress.done {
            return self.next_rung();
        }
        Ok(())
    }

    /// Goes on with a picture twice as large, or rests.
    fn next_rung(&mut self) -> Result<(), String> {
        let Some(job) = &mut self.job else {
            return Ok(());
        };
        if job.divisor > 1 {
            job.divisor /= 2;
            return self.begin();
        }
        job.is_done = true;
        self.publish(|shown| shown.activity = Activity::Idle);
        Ok(())
    }

    /// Publishes the picture so far.
    fn show(&mut self, progress: Progress) -> Result<(), String> {
        let (Some(job), Some((_, renderer)), Some(wish)) =
            (&mut self.job, &mut self.renderer, &self.wish)
        else {
            return Ok(());
        };
        let start = Instant::now();
        let soft = progress.samples < SHARP_FROM && job.divisor <= SOFT_UP_TO;
        let shot = self.developer.shoot(renderer, wish.display, soft);
        let image = shot.map_err(|error| error.to_string())?;
        let bytes = renderer.backend().device_bytes();
        (job.published, job.publishing_took) = (Instant::now(), start.elapsed());
        let (seconds, is_reduced) = (job.seconds, job.divisor > 1);
        self.publish(|shown| {
            shown.image = image;
            shown.version += 1;
            shown.progress = progress;
            shown.is_reduced = is_reduced;
            shown.is_first = is_reduced;
            shown.seconds = seconds;
            shown.device_bytes = bytes;
        });
        Ok(())
    }

    /// Publishes the last picture with another display.
    fn show_again(&mut self, display: Display) -> Result<(), String> {
        let Some((_, renderer)) = &mut self.renderer else {
            return Ok(());
        };
        let shot = self.developer.again(renderer, display);
        let image = shot.map_err(|error| error.to_string())?;
        self.publish(|shown| {
            shown.image = image;
            shown.version += 1;
        });
        Ok(())
    }
}

/// The whole picture at a fraction of its size, few samples; at divisor 1 the request itself.
fn reduced(request: &RenderRequest, divisor: u32) -> RenderRequest {
    let mut reduced = request.clone();
    if divisor > 1 {
        reduced.size = request.size.map(|side| side.div_ceil(divisor));
        reduced.crop = [0, 0, reduced.size[0], reduced.size[1]];
        reduced.settings.samples = REDUCED_SAMPLES;
        reduced.settings.error = 0.0;
    }
    reduced
}
