//! The thread that owns a backend: takes the viewport's latest request, compiles its scene, renders it in short slices
//! and publishes pictures. The window never waits for it, and when a picture is done it sleeps.
//!
//! A new request is first drawn small: at a fraction of the size that takes a few hundredths of a second, then at
//! double that, and so on up to the full size. So every edit shows at once, however slow the machine, and nothing of
//! the full picture's samples depends on it. Pictures of few samples are shown softer, the sharper the more samples
//! they have.
//!
//! | module | what is in it |
//! | --- | --- |
//! | this | the request, the handle of the thread, and what they share |
//! | `view_state` | what the thread publishes: stage, picture, scene, device |
//! | `worker` | what the thread does with a request |
//! | `coarse_preview` | how coarse a picture may be, so that its scene is there soon |
//! | `render_job` | a picture in work, and the ladder of sizes it climbs |
//! | `stand_in`, `fallback` | the processor in place of a GPU that is not ready, or has failed |
//! | `renderer`, `display_table` | a backend, and how its pictures become frames of the window |
//! | `known` | what is known of a picture before it is drawn, and how both are joined |
//! | `denoising` | the thread that denoises pictures, and when |
//! | `draft_lighting` | what the viewport estimates instead of tracing it |
//! | `workers` | the threads that render, behind those of the window in priority |

mod coarse_preview;
mod denoising;
mod display_table;
pub mod draft_lighting;
mod fallback;
mod known;
mod render_job;
pub mod renderer;
mod stand_in;
mod view_state;
mod worker;
pub mod workers;

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use renderer_core::design::{CameraDesign, Design};
use renderer_core::image::Display;

pub use denoising::Denoising;
pub use view_state::{
    DenoisedPart, DeviceInUse, News, Priority, SceneSummary, Seen, Stage, ViewState,
};

use crate::backend::BackendChoice;
use crate::denoiser::MakeDenoiser;
use denoising::Outcome;
use draft_lighting::LiveLight;
use renderer::MakeRenderer;
use worker::Worker;

/// What the viewport wants to see.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewRequest {
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
    /// Whether pictures are denoised where that can be done.
    pub denoises: bool,
}

impl ViewRequest {
    /// Whether both have the same samples: they differ in nothing but how light becomes colour, whether noise is taken
    /// out of it, and in saved views. A light meter sets how bright the background is.
    pub fn has_samples_of(&self, other: &Self) -> bool {
        let same_design = || {
            let mut design = Design::clone(&other.design);
            let metering = design.view.metering;
            design.view = self.design.view.clone();
            design.view.metering = metering;
            design == *self.design
        };
        let seen_from =
            |request: &Self| (request.size, request.choice, request.attempt, request.light);
        self.camera == other.camera && seen_from(self) == seen_from(other) && same_design()
    }
}

/// What the thread finds when it looks for mail.
enum Mail {
    /// Something new to show.
    Request(Box<ViewRequest>),
    /// Something that the denoiser has to say.
    Denoiser(Outcome),
    /// Nothing: go on with what is in work.
    None,
    /// The window is gone.
    Stop,
}

#[derive(Default)]
struct Mailbox {
    request: Option<Box<ViewRequest>>,
    /// What the denoiser has to say, in order.
    denoised: VecDeque<Outcome>,
    stop: bool,
    /// Whether the thread sleeps and nothing was posted since.
    is_resting: bool,
}

/// What both sides see.
#[derive(Default)]
struct Shared {
    mailbox: Mutex<Mailbox>,
    mail: Condvar,
    /// Signalled when the thread goes to sleep.
    rest: Condvar,
    /// Whether what is in work is of no use any more: something else is requested.
    cancel: AtomicBool,
    state: Mutex<ViewState>,
}

impl Shared {
    /// The mail there is; without any sleeps until some comes, unless something `is_working`. While the denoiser
    /// `is_busy` that is no rest.
    fn next_mail(&self, is_working: bool, denoiser_is_busy: bool) -> Mail {
        let mut mailbox = lock(&self.mailbox);
        loop {
            if mailbox.stop {
                return Mail::Stop;
            }
            if let Some(request) = mailbox.request.take() {
                self.cancel.store(false, Ordering::Relaxed);
                return Mail::Request(request);
            }
            if let Some(outcome) = mailbox.denoised.pop_front() {
                return Mail::Denoiser(outcome);
            }
            if is_working {
                return Mail::None;
            }
            mailbox.is_resting = !denoiser_is_busy;
            self.rest.notify_all();
            let woken = self.mail.wait(mailbox);
            mailbox = woken.unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Changes what is in the mailbox and wakes the thread; it leaves what it does if that `is_outdated`.
    fn post(&self, is_outdated: bool, change: impl FnOnce(&mut Mailbox)) {
        let mut mailbox = lock(&self.mailbox);
        mailbox.is_resting = false;
        change(&mut mailbox);
        drop(mailbox);
        if is_outdated {
            self.cancel.store(true, Ordering::Relaxed);
        }
        self.mail.notify_one();
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
    denoiser: MakeDenoiser,
    repaint: egui::Context,
    thread: Option<JoinHandle<()>>,
}

impl RenderThread {
    /// Starts the thread. It asks `repaint` for a frame whenever it has news.
    pub fn new(make: MakeRenderer, denoiser: MakeDenoiser, repaint: egui::Context) -> Self {
        let mut this = Self {
            shared: Arc::default(),
            make,
            denoiser,
            repaint,
            thread: None,
        };
        this.start();
        this
    }

    fn start(&mut self) {
        let shared = Arc::clone(&self.shared);
        let (make, denoiser) = (Arc::clone(&self.make), Arc::clone(&self.denoiser));
        let repaint = self.repaint.clone();
        let thread = std::thread::Builder::new().name("render".into());
        let started = thread.spawn(move || run(&shared, make, denoiser, &repaint));
        match started {
            Ok(thread) => self.thread = Some(thread),
            Err(error) => {
                let error = format!("No thread to render with: {error}.");
                lock(&self.shared.state).error = Some(error);
            }
        }
    }

    /// Renders this instead of what was requested before. Starts the thread again if it has died.
    pub fn send(&mut self, request: ViewRequest, same_samples: bool) {
        if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
            self.start();
        }
        let request = Box::new(request);
        self.shared
            .post(!same_samples, |mailbox| mailbox.request = Some(request));
    }

    /// Waits until the thread has nothing left to do; false if it still has after `patience`.
    pub fn wait_for_rest(&self, patience: Duration) -> bool {
        let mailbox = lock(&self.shared.mailbox);
        let is_at_work = |mailbox: &mut Mailbox| !mailbox.is_resting;
        let waited = (self.shared.rest).wait_timeout_while(mailbox, patience, is_at_work);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// What there is to show now.
    pub fn state(&self) -> ViewState {
        lock(&self.shared.state).clone()
    }
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        self.shared.post(true, |mailbox| mailbox.stop = true);
        if let Some(thread) = self.thread.take() {
            // The window has reported a panic already.
            let _ = thread.join();
        }
    }
}

/// The thread, from its start to the end of the window. A panic ends it, and is published as an error.
fn run(shared: &Arc<Shared>, make: MakeRenderer, denoiser: MakeDenoiser, repaint: &egui::Context) {
    workers::stand_back();
    // What an earlier thread was still to be told is not for this one.
    lock(&shared.mailbox).denoised.clear();
    let work = AssertUnwindSafe(|| Worker::new(shared, make, denoiser, repaint).run());
    if let Err(panic) = catch_unwind(work) {
        let reason = reason_of(&*panic);
        let mut state = lock(&shared.state);
        state.stage = Stage::Idle;
        state.error = Some(format!(
            "The renderer stopped: {reason}. The design is unharmed; the next change starts it again."
        ));
        drop(state);
        repaint.request_repaint();
    }
}

/// The message of a panic.
fn reason_of(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("unknown reason")
}
