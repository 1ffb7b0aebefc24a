//! The thread that denoises the viewport's pictures, and when it is given one.
//!
//! A picture of full size is denoised after its first whole sample, then each time its samples have doubled, and once
//! more when it is done: so all of it together takes no more than a few percent of the samples' own time, and the first
//! comes when it helps most. The thread that renders never waits for it: it hands over a picture and goes on, and takes
//! what has come of it between two slices of its own work. A picture that is requested no longer is given up half way.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use renderer_core::denoise::{Denoise, DenoiseError, DenoiseQuality, Mix, Step};
use renderer_core::image::Picture;
use renderer_core::render::Progress;

use super::{Shared, reason_of, workers};
use crate::advice::{Place, with_advice_on_denoiser};
use crate::denoiser::MakeDenoiser;

/// Pictures of fewer samples are denoised fast: what finer work would keep is noise there.
const FINE_FROM: u32 = 4;

/// Whether pictures can be denoised.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Denoising {
    /// It is being found out.
    #[default]
    Looking,
    /// By this, as in `Open Image Denoise 2.5.1 on CPU`.
    Ready(String),
    /// Not, because, and what helps.
    Missing(String),
}

/// A picture to denoise.
struct Job {
    picture_number: u64,
    samples: u32,
    picture: Picture,
    error: Option<f64>,
    scale: f32,
    cancel: Arc<AtomicBool>,
}

/// A picture that was denoised.
pub struct Denoised {
    /// Samples of a pixel.
    pub samples: u32,
    /// What to show.
    pub mix: Mix,
}

/// What the thread has to say.
pub enum Outcome {
    /// There is a denoiser, or none.
    Found(Denoising),
    /// What came of a job: the number of its picture, and what to show, if it was not given up.
    Done(u64, Option<Denoised>),
    /// The denoiser failed, and will not be used again.
    Failed(String),
}

/// The thread as the one that renders sees it.
pub struct DenoiseThread {
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
    /// Whether there is a denoiser.
    pub state: Denoising,
    /// Counts pictures, so that what comes too late is known.
    picture_number: u64,
    /// The job under way can be given up with this.
    under_way: Option<Arc<AtomicBool>>,
    schedule: Schedule,
}

impl DenoiseThread {
    /// Starts to look for a denoiser.
    pub fn start(make: MakeDenoiser, shared: &Arc<Shared>) -> Self {
        let (jobs, received) = channel();
        let shared = Arc::clone(shared);
        let thread = std::thread::Builder::new().name("denoise".into());
        let started = thread.spawn(move || run(&make, &received, &shared));
        let state = match &started {
            Ok(_) => Denoising::Looking,
            Err(error) => Denoising::Missing(format!("no thread to denoise with: {error}")),
        };
        Self {
            jobs: Some(jobs),
            thread: started.ok(),
            state,
            picture_number: 0,
            under_way: None,
            schedule: Schedule::default(),
        }
    }

    /// Whether it has something to say soon.
    pub fn is_busy(&self) -> bool {
        self.state == Denoising::Looking || self.under_way.is_some()
    }

    /// Another picture is begun: what is under way of the last one is of no use.
    pub fn restart(&mut self) {
        self.picture_number += 1;
        self.schedule = Schedule::default();
        if let Some(cancel) = &self.under_way {
            cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Whether a picture of so many samples should be given to it now.
    pub fn wants(&self, samples: u32, is_done: bool) -> bool {
        let is_free = matches!(self.state, Denoising::Ready(_)) && self.under_way.is_none();
        is_free && self.schedule.is_due(samples, is_done)
    }

    /// Gives it a picture that is so far; white is 1 in its values times `scale`.
    pub fn denoise(&mut self, progress: Progress, picture: Picture, scale: f32) {
        let samples = progress.samples;
        self.schedule.note(samples);
        let cancel = Arc::<AtomicBool>::default();
        let job = Job {
            picture_number: self.picture_number,
            samples,
            picture,
            error: progress.error_estimate,
            scale,
            cancel: Arc::clone(&cancel),
        };
        let sent = self
            .jobs
            .as_ref()
            .is_some_and(|jobs| jobs.send(job).is_ok());
        self.under_way = sent.then_some(cancel);
    }

    /// Takes note of an outcome; what there is to show of the present picture, and what to report.
    pub fn take(&mut self, outcome: Outcome) -> (Option<Denoised>, Option<String>) {
        match outcome {
            Outcome::Found(state) => self.state = state,
            Outcome::Done(number, denoised) => {
                self.under_way = None;
                return (denoised.filter(|_| number == self.picture_number), None);
            }
            Outcome::Failed(error) => {
                self.under_way = None;
                self.state = Denoising::Missing(error.clone());
                return (None, Some(error));
            }
        }
        (None, None)
    }
}

impl Drop for DenoiseThread {
    fn drop(&mut self) {
        if let Some(cancel) = &self.under_way {
            cancel.store(true, Ordering::Relaxed);
        }
        // Without jobs to come it ends. The program must not end before: it would take the library away under the thread.
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // It catches its panics.
            let _ = thread.join();
        }
    }
}

/// Which samples are denoised: 1, 2, 4, 8 …, and the last.
#[derive(Debug, Clone, Copy, Default)]
struct Schedule {
    /// Samples of the last picture given.
    last: u32,
}

impl Schedule {
    fn is_due(self, samples: u32, is_done: bool) -> bool {
        // From 5 samples on it is the doubling to 8 that counts, not to 10.
        let next = match self.last {
            0 => 1,
            last => (last + 1).next_power_of_two(),
        };
        samples >= next || (is_done && samples > self.last)
    }

    fn note(&mut self, samples: u32) {
        self.last = samples;
    }
}

/// The thread, until there are no more jobs.
fn run(make: &MakeDenoiser, jobs: &Receiver<Job>, shared: &Shared) {
    workers::stand_back();
    let say = |outcome| shared.post(false, |mailbox| mailbox.denoised.push_back(outcome));
    let work = AssertUnwindSafe(|| {
        let mut denoiser = match make() {
            Ok(denoiser) => denoiser,
            Err(error) => {
                let why = with_advice_on_denoiser(&error, Place::Viewport);
                return say(Outcome::Found(Denoising::Missing(why)));
            }
        };
        say(Outcome::Found(Denoising::Ready(denoiser.name())));
        let mut last = None;
        while let Ok(job) = jobs.recv() {
            let number = job.picture_number;
            match carry_out(&mut *denoiser, job, &mut last) {
                Ok(denoised) => say(Outcome::Done(number, Some(denoised))),
                Err(DenoiseError::Cancelled) => say(Outcome::Done(number, None)),
                Err(error) => {
                    return say(Outcome::Failed(with_advice_on_denoiser(
                        &error,
                        Place::Viewport,
                    )));
                }
            }
        }
    });
    if let Err(panic) = catch_unwind(work) {
        say(Outcome::Failed(format!(
            "the denoiser stopped: {}",
            reason_of(&*panic)
        )));
    }
}

/// Denoises a picture and mixes it by what the last of the same picture tells.
fn carry_out(
    denoiser: &mut dyn Denoise,
    job: Job,
    last: &mut Option<(u64, Step)>,
) -> Result<Denoised, DenoiseError> {
    let quality = match job.samples {
        ..FINE_FROM => DenoiseQuality::Fast,
        _ => DenoiseQuality::High,
    };
    let denoised = denoiser.denoise(&job.picture, quality, job.scale, &job.cancel)?;
    let step = Step {
        samples: job.samples,
        plain: job.picture,
        error: job.error,
        denoised,
    };
    let earlier = last
        .take()
        .filter(|(number, _)| *number == job.picture_number);
    let mix = Mix::new(earlier.as_ref().map(|(_, step)| step), &step);
    *last = Some((job.picture_number, step));
    Ok(Denoised {
        samples: job.samples,
        mix,
    })
}
