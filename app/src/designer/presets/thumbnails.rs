//! Thumbnails, drawn in the background: presets, and a loop seen close.
//!
//! One thread draws them with a CPU backend on a few cores and takes turns between them in short slices. Pictures that
//! answer a gesture ("urgent" ones) come before others, the newest first, and are shown coarse at once; the others come
//! in the order they were asked for. A job replaces an unfinished one of the same key. While nothing of an edit can be
//! seen in the viewport, only coarse urgent pictures are drawn, and others than urgent ones wait until it shows in full
//! size: so edits show as fast as without.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use egui::{Color32, ColorImage};
use rayon::{ThreadPool, ThreadPoolBuilder};
use renderer_core::design::{CameraDesign, Design};
use renderer_core::geometry::Camera;
use renderer_core::image::{Display, Picture};
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodView};
use renderer_core::scene::{Cancel, CompileError};

use crate::backend::BackendChoice;
use crate::designer::render_thread::Priority;
use crate::designer::render_thread::draft_lighting::LiveLight;
use crate::designer::render_thread::renderer::MakeBackend;
use crate::designer::render_thread::workers;

/// How long one picture is worked on before the thread looks at the others.
const SLICE: Duration = Duration::from_millis(30);
/// Sides of a coarse picture are those of the picture divided by this.
const COARSE: u32 = 4;
/// Samples of a coarse picture.
const COARSE_SAMPLES: u32 = 4;
/// An urgent picture in work is shown again after this long.
const SHOWN_EVERY: Duration = Duration::from_millis(250);

/// What a picture shows; there is at most one picture of each.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum ThumbnailKey {
    /// One loop of the document's pile.
    Loop,
    /// A preset file.
    Preset(PathBuf),
}

/// A cloth and how it is seen.
#[derive(Debug, Clone)]
pub struct ThumbnailSubject {
    /// The cloth, its light and its display; of its quality all but samples and error count.
    pub design: Design,
    /// From where.
    pub camera: CameraDesign,
}

/// A picture to make.
pub struct ThumbnailJob {
    /// What it shows.
    pub key: ThumbnailKey,
    /// Finds out what to draw, on the thread: reads a file, say.
    pub subject: Box<dyn FnOnce() -> Result<ThumbnailSubject, String> + Send>,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// Whether it answers a gesture.
    pub is_urgent: bool,
}

/// What came of a job so far.
#[derive(Debug, Clone)]
pub struct DrawnThumbnail {
    /// The picture, or why there is none. Coarse ones are smaller than asked for.
    pub image: Result<ColorImage, String>,
    /// Whether this is the last news of the job.
    pub is_final: bool,
}

/// Something sent to the thread.
enum Mail {
    Draw(ThumbnailJob),
    Forget(ThumbnailKey),
}

impl Mail {
    fn key(&self) -> &ThumbnailKey {
        match self {
            Self::Draw(job) => &job.key,
            Self::Forget(key) => key,
        }
    }
}

#[derive(Default)]
struct Desk {
    mail: Vec<Mail>,
    drawn: HashMap<ThumbnailKey, DrawnThumbnail>,
    priority: Priority,
    stop: bool,
    /// Whether the thread sleeps and nothing was sent since.
    is_resting: bool,
}

#[derive(Default)]
struct Shared {
    desk: Mutex<Desk>,
    news: Condvar,
    /// Signalled when something is drawn, and when the thread goes to sleep.
    changed: Condvar,
    /// Ends the slice in work.
    interrupt: AtomicBool,
}

impl Shared {
    /// Nobody panics while holding the lock; if somebody did, the data would still be whole.
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a picture in work is of no use: the window is gone, or something else was sent about its key.
    fn is_unwanted(&self, key: &ThumbnailKey) -> bool {
        let desk = self.desk();
        desk.stop || desk.mail.iter().any(|mail| mail.key() == key)
    }

    fn change(&self, change: impl FnOnce(&mut Desk)) {
        let mut desk = self.desk();
        desk.is_resting = false;
        change(&mut desk);
        drop(desk);
        self.interrupt.store(true, Ordering::Relaxed);
        self.news.notify_one();
    }
}

/// Handle of the thread, which starts with the first job and ends when this is dropped.
pub struct ThumbnailRenderer {
    shared: Arc<Shared>,
    make: MakeBackend,
    repaint: egui::Context,
    is_running: bool,
}

impl ThumbnailRenderer {
    /// Pictures drawn with what `make` makes of the CPU; asks `repaint` for a frame whenever there is one to show.
    pub fn new(make: MakeBackend, repaint: egui::Context) -> Self {
        Self {
            shared: Arc::default(),
            make,
            repaint,
            is_running: false,
        }
    }

    /// Draws this instead of what was asked for under its key before.
    pub fn draw(&mut self, job: ThumbnailJob) {
        let key = job.key.clone();
        self.start();
        self.shared.change(|desk| {
            desk.drawn.remove(&key);
            if self.is_running {
                desk.mail.push(Mail::Draw(job));
            } else {
                let image = Err("there is no thread to draw it with".into());
                let is_final = true;
                desk.drawn.insert(key, DrawnThumbnail { image, is_final });
            }
        });
    }

    /// Gives up the picture of this key.
    pub fn forget(&self, key: &ThumbnailKey) {
        self.shared.change(|desk| {
            desk.drawn.remove(key);
            desk.mail.push(Mail::Forget(key.clone()));
        });
    }

    /// The news of a job, once.
    pub fn take(&self, key: &ThumbnailKey) -> Option<DrawnThumbnail> {
        self.shared.desk().drawn.remove(key)
    }

    /// As [`Self::take`], but waits for news, at most for so long.
    pub fn take_within(&self, key: &ThumbnailKey, patience: Duration) -> Option<DrawnThumbnail> {
        let is_missing = |desk: &mut Desk| !desk.drawn.contains_key(key);
        let desk = self.shared.desk();
        let waited = (self.shared.changed).wait_timeout_while(desk, patience, is_missing);
        let (mut desk, _) = waited.unwrap_or_else(PoisonError::into_inner);
        desk.drawn.remove(key)
    }

    /// How urgently the viewport needs the machine.
    pub fn give_way(&self, priority: Priority) {
        if self.shared.desk().priority != priority {
            self.shared.change(|desk| desk.priority = priority);
        }
    }

    /// Waits until nothing is drawn any more, or nothing may be; false if something still is after `patience`.
    pub fn wait_for_rest(&self, patience: Duration) -> bool {
        let is_at_work = |desk: &mut Desk| self.is_running && !desk.is_resting;
        let desk = self.shared.desk();
        let waited = (self.shared.changed).wait_timeout_while(desk, patience, is_at_work);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    fn start(&mut self) {
        if self.is_running {
            return;
        }
        let shared = Arc::clone(&self.shared);
        let (make, repaint) = (Arc::clone(&self.make), self.repaint.clone());
        let run = move || run(&shared, &make, &repaint);
        let thread = std::thread::Builder::new().name("thumbnails".into());
        self.is_running = thread.spawn(run).is_ok();
    }
}

impl Drop for ThumbnailRenderer {
    fn drop(&mut self) {
        self.shared.change(|desk| desk.stop = true);
    }
}

/// A job in work.
struct Work {
    key: ThumbnailKey,
    is_urgent: bool,
    size: [u32; 2],
    samples: u32,
    stage: WorkStage,
}

enum WorkStage {
    /// Nothing done yet.
    Asked(Box<dyn FnOnce() -> Result<ThumbnailSubject, String> + Send>),
    /// A picture is being drawn.
    Begun(Box<Begun>),
    /// Nothing left to do.
    Done,
}

struct Begun {
    backend: Box<dyn Backend>,
    /// The whole picture.
    request: RenderRequest,
    display: Display,
    is_coarse: bool,
    shown: Instant,
}

impl Work {
    /// Whether it may go on while the viewport needs the machine that much.
    fn may_go_on(&self, priority: Priority) -> bool {
        let is_quick = match &self.stage {
            WorkStage::Asked(_) => true,
            WorkStage::Begun(begun) => begun.is_coarse,
            WorkStage::Done => false,
        };
        match priority {
            Priority::Low => true,
            Priority::Medium => self.is_urgent,
            Priority::High => self.is_urgent && is_quick,
        }
    }
}

/// The thread: takes turns between jobs until the window is gone.
fn run(shared: &Shared, make: &MakeBackend, repaint: &egui::Context) {
    let pool = few_threads();
    let mut works: Vec<Work> = Vec::new();
    while let Some(index) = next(shared, &mut works) {
        let mut step = || works[index].step(make, shared);
        let drawn = catch_unwind(AssertUnwindSafe(|| match &pool {
            Some(pool) => pool.install(step),
            None => step(),
        }));
        let drawn = match drawn {
            Ok(Ok(drawn)) => drawn,
            Ok(Err(error)) => Some(failed(error)),
            Err(_) => Some(failed("the renderer stopped".into())),
        };
        let Some(drawn) = drawn else { continue };
        let key = works[index].key.clone();
        if drawn.is_final {
            works.remove(index);
        }
        let mut desk = shared.desk();
        // Who has asked for something else meanwhile does not want this any more.
        if desk.mail.iter().all(|mail| *mail.key() != key) {
            desk.drawn.insert(key, drawn);
            drop(desk);
            shared.changed.notify_all();
            repaint.request_repaint();
        }
    }
}

fn failed(error: String) -> DrawnThumbnail {
    DrawnThumbnail {
        image: Err(error),
        is_final: true,
    }
}

/// A quarter of the cores, so that the viewport and other programs hardly notice.
fn few_threads() -> Option<ThreadPool> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = ThreadPoolBuilder::new().num_threads((cores / 4).max(1));
    pool.thread_name(|_| "thumbnails".into())
        .start_handler(|_| workers::stand_back())
        .build()
        .ok()
}

/// Takes the mail and chooses what to go on with; sleeps while there is nothing. `None` to stop.
fn next(shared: &Shared, works: &mut Vec<Work>) -> Option<usize> {
    let mut desk = shared.desk();
    loop {
        if desk.stop {
            return None;
        }
        shared.interrupt.store(false, Ordering::Relaxed);
        for mail in desk.mail.drain(..) {
            works.retain(|work| work.key != *mail.key());
            if let Mail::Draw(job) = mail {
                works.push(Work {
                    key: job.key,
                    is_urgent: job.is_urgent,
                    size: job.size,
                    samples: job.samples,
                    stage: WorkStage::Asked(job.subject),
                });
            }
        }
        let urgent = works.iter().rposition(|work| work.is_urgent);
        let chosen = urgent.or(if works.is_empty() { None } else { Some(0) });
        if let Some(index) = chosen.filter(|&index| works[index].may_go_on(desk.priority)) {
            return Some(index);
        }
        desk.is_resting = true;
        shared.changed.notify_all();
        let woken = shared.news.wait(desk);
        desk = woken.unwrap_or_else(PoisonError::into_inner);
    }
}

impl Work {
    /// A slice of work, and what there is to show after it.
    fn step(
        &mut self,
        make: &MakeBackend,
        shared: &Shared,
    ) -> Result<Option<DrawnThumbnail>, String> {
        match std::mem::replace(&mut self.stage, WorkStage::Done) {
            WorkStage::Asked(subject) => {
                if let Some(begun) = self.begin(&subject()?, make, shared)? {
                    self.stage = WorkStage::Begun(Box::new(begun));
                }
                Ok(None)
            }
            WorkStage::Begun(mut begun) => {
                let drawn = begun.advance(self.is_urgent, &shared.interrupt)?;
                self.stage = WorkStage::Begun(begun);
                Ok(drawn)
            }
            WorkStage::Done => Err("nothing was drawn".into()),
        }
    }

    /// Makes the scene and hands it to a backend; `None` if nobody wants the picture any more.
    fn begin(
        &self,
        subject: &ThumbnailSubject,
        make: &MakeBackend,
        shared: &Shared,
    ) -> Result<Option<Begun>, String> {
        let design = &subject.design;
        let key = &self.key;
        let is_unwanted = || shared.interrupt.load(Ordering::Relaxed) && shared.is_unwanted(key);
        let cancel = Cancel::when(&is_unwanted);
        let made = LodView::new(
            &mut LodCompiler::default(),
            design,
            &Camera::from_design(&subject.camera),
            self.size,
            LodBudget::LIVE,
            &cancel,
        );
        let view = match made {
            Ok(view) => view,
            Err(CompileError::Cancelled) => return Ok(None),
            Err(error) => return Err(error.to_string()),
        };
        let mut settings = LiveLight::Fast.settings(design);
        (settings.samples, settings.error) = (self.samples, 0.0);
        let request = RenderRequest::new(view, self.size, settings);
        let mut begun = Begun {
            backend: make(BackendChoice::Cpu).map_err(|error| error.to_string())?,
            request,
            display: Display::from(design),
            is_coarse: self.is_urgent,
            shown: Instant::now(),
        };
        begun.start()?;
        Ok(Some(begun))
    }
}

impl Begun {
    /// Hands the picture, coarse or whole, to the backend.
    fn start(&mut self) -> Result<(), String> {
        let mut request = self.request.clone();
        if self.is_coarse {
            request.size = request.size.map(|side| side.div_ceil(COARSE));
            request.crop = [0, 0, request.size[0], request.size[1]];
            request.settings.samples = COARSE_SAMPLES;
        }
        let begun = self.backend.begin(&request);
        begun.map_err(|error| error.to_string())
    }

    fn advance(
        &mut self,
        is_urgent: bool,
        interrupt: &AtomicBool,
    ) -> Result<Option<DrawnThumbnail>, String> {
        let progress = self.backend.advance(SLICE, interrupt);
        let progress = progress.map_err(|error| error.to_string())?;
        let is_final = progress.done && !self.is_coarse;
        let is_due = is_urgent
            && !self.is_coarse
            && progress.samples >= COARSE_SAMPLES
            && self.shown.elapsed() > SHOWN_EVERY;
        if !(progress.done || is_due) {
            return Ok(None);
        }
        let picture = self.backend.picture().map_err(|error| error.to_string())?;
        self.shown = Instant::now();
        if progress.done && self.is_coarse {
            self.is_coarse = false;
            self.start()?;
        }
        Ok(Some(DrawnThumbnail {
            image: Ok(encoded(&picture, self.display)),
            is_final,
        }))
    }
}

/// A picture as the window shows it.
fn encoded(picture: &Picture, display: Display) -> ColorImage {
    let colour = |&[r, g, b, _]: &[f32; 4]| {
        let [r, g, b] = display.encode([r, g, b]).map(|c| (c * 255.0).round() as u8);
        Color32::from_rgb(r, g, b)
    };
    let size = picture.size.map(|side| side as usize);
    ColorImage::new(size, picture.pixels.iter().map(colour).collect())
}
