//! The thread that owns a backend: takes the latest wish of the viewport, compiles its scene, renders it in short
//! slices and publishes pictures. The window never waits for it, and when a picture is done it sleeps.
//!
//! A new wish is first drawn small: at a fraction of the size that takes a few hundredths of a second, then at double
//! that, and so on up to the full size. So every edit shows at once, however slow the machine, and nothing of the full
//! picture's samples depends on it. Pictures of few samples are shown softer, the sharper the more
//! samples they have.

mod fallback;
mod first_look;
mod job;
mod stand_in;
mod worker;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use renderer_core::design::{CameraDesign, Design, Warning};
use renderer_core::image::Display;
use renderer_core::render::{BackendKind, Cloth, Progress};
use renderer_core::scene::LoopCounts;

use super::live_light::LiveLight;
use super::renderer::{MakeRenderer, Shot};
use super::workers;
use crate::backend::BackendChoice;
use worker::Worker;

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
    /// How often it was chosen: once more tries a backend again that had failed.
    pub attempt: u32,
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
    /// Whether no picture, however small, shows what is wished yet.
    pub is_unseen: bool,
    /// Whether no picture of full size shows what is wished yet.
    pub is_first: bool,
    /// What the thread is doing.
    pub activity: Activity,
    /// Time spent rendering since the last wish that changed the picture.
    pub seconds: f64,
    /// The backend whose picture is shown, and its adapter or processor.
    pub device: Option<(BackendKind, String)>,
    /// Whether that stands in for a GPU that was not ready for the picture.
    pub stands_in: bool,
    /// Bytes on the device.
    pub device_bytes: u64,
    /// Loops of the scene.
    pub counts: LoopCounts,
    /// Things about the design and its scene that are allowed but probably not meant.
    pub warnings: Vec<Warning>,
    /// What went wrong, until something goes right.
    pub error: Option<String>,
    /// Why something else renders than was chosen, as long as it does.
    pub instead: Option<String>,
    /// Something that happened, and how many such things did.
    pub news: (u64, String),
    /// Width and height of the picture in work at its full size, pixels; less than wished where the backend or its memory
    /// cannot do more.
    pub size: [u32; 2],
    /// What the picture shows.
    pub cloth: Option<Arc<Cloth>>,
}

impl Shown {
    fn tell(&mut self, news: String) {
        self.news = (self.news.0 + 1, news);
    }

    /// Whether the thread works towards the first picture of what is wished: somebody waits for it.
    pub fn is_busy(&self) -> bool {
        self.hurry() != Hurry::None
    }

    /// How much somebody waits for it.
    pub fn hurry(&self) -> Hurry {
        match self.activity {
            Activity::Idle => Hurry::None,
            Activity::Compiling => Hurry::Unseen,
            Activity::Rendering if self.is_unseen => Hurry::Unseen,
            Activity::Rendering if self.is_first => Hurry::Small,
            Activity::Rendering => Hurry::None,
        }
    }
}

/// How urgently the viewport needs the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hurry {
    /// What is wished can be seen in full size; it only gets clearer.
    #[default]
    None,
    /// What is wished can be seen, but smaller than it should be.
    Small,
    /// Nothing of what is wished can be seen.
    Unseen,
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

impl Shared {
    /// A wish, or `Some(None)` if there is none while something is in work; sleeps while there is nothing to do. `None` to
    /// stop.
    fn next_mail(&self, is_working: bool) -> Option<Option<Wish>> {
        let mut mailbox = lock(&self.mailbox);
        loop {
            if mailbox.stop {
                return None;
            }
            if let Some(wish) = mailbox.wish.take() {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(Some(wish));
            }
            if is_working {
                return Some(None);
            }
            mailbox = self
                .mail
                .wait(mailbox)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
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
                workers::stand_back();
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
