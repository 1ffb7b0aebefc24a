//! What the thread does: takes a request, makes its scene and its picture, and answers failures.

mod denoised;
mod joined;
mod preview;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use renderer_core::design::Design;
use renderer_core::geometry::Camera;
use renderer_core::image::Display;
use renderer_core::render::{Progress, RenderError, RenderRequest};
use renderer_core::scene::lod::{LodBudget, LodCloth, LodCompiler, LodPlan};
use renderer_core::scene::{self, Cancel, ChartYarns, CompileError};

use self::joined::Knowledge;
use super::denoising::{DenoiseThread, Denoised};
use super::fallback::{Fallback, Remedy};
use super::render_job::RenderJob;
use super::renderer::{DisplayTransform, MakeRenderer, Renderer};
use super::stand_in::StandIn;
use super::{Mail, SceneSummary, Seen, Shared, Stage, ViewRequest, ViewState, lock, workers};
use crate::advice::{Place, with_advice, with_advice_on_cloth};
use crate::backend::BackendChoice;
use crate::denoiser::MakeDenoiser;

/// How long a backend works before the thread looks for news.
const SLICE: Duration = Duration::from_millis(50);
/// How long the window's own GPU works before the thread looks for news: frames must wait for what is under way there.
const SHORT_SLICE: Duration = Duration::from_millis(12);
/// A scene that is made within this time is not given up for a newer request: it still shows where a drag is going.
const FINISHED_ANYWAY: Duration = Duration::from_millis(400);
/// The first picture of an edit is drawn to its end for so long, in seconds, whatever else is requested meanwhile.
const OWED: f64 = 0.15;
/// Scenes are given up for so long; then one is made to its end, so that an endless drag shows something too.
const GIVING_UP: Duration = Duration::from_secs(2);

/// Why a request cannot be met.
enum Failure {
    Compile(CompileError),
    Render(RenderError),
}

impl From<CompileError> for Failure {
    fn from(error: CompileError) -> Self {
        Self::Compile(error)
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        Self::Render(error)
    }
}

/// The thread's state.
pub struct Worker<'a> {
    shared: &'a Shared,
    make: MakeRenderer,
    repaint: &'a egui::Context,
    renderer: Option<(BackendChoice, Renderer)>,
    stand_in: StandIn,
    fallback: Fallback,
    /// What is to be shown.
    view: Option<Box<ViewRequest>>,
    maker: LodCompiler,
    /// Makes cloth for coarse previews.
    preview_maker: LodCompiler,
    /// The last cloth and its design.
    made: Option<(Arc<Design>, Arc<LodCloth>)>,
    /// The yarns of the last chart, counted.
    yarns: ChartYarns,
    /// Since when scenes have been given up without one being finished.
    giving_up: Option<Instant>,
    /// How long the loops of the last scene took that was made with new ones.
    loops_took: Duration,
    job: Option<RenderJob>,
    transform: DisplayTransform,
    known: Knowledge,
    /// How the last picture was shown.
    display: Option<Display>,
    denoising: DenoiseThread,
    /// The last denoised picture of the job.
    denoised: Option<Denoised>,
    /// Whether that is what is shown.
    shows_denoised: bool,
    /// How far the job is.
    progress: Progress,
    /// Seconds for a sample of a pixel, as last measured.
    cost: Option<f64>,
}

impl<'a> Worker<'a> {
    /// Nothing requested, nothing made.
    pub fn new(
        shared: &'a Arc<Shared>,
        make: MakeRenderer,
        denoiser: MakeDenoiser,
        repaint: &'a egui::Context,
    ) -> Self {
        Self {
            shared,
            make,
            repaint,
            renderer: None,
            stand_in: StandIn::None,
            fallback: Fallback::default(),
            view: None,
            maker: LodCompiler::default(),
            preview_maker: LodCompiler::default(),
            made: None,
            yarns: ChartYarns::default(),
            giving_up: None,
            loops_took: Duration::ZERO,
            job: None,
            transform: DisplayTransform::default(),
            known: Knowledge::default(),
            display: None,
            denoising: DenoiseThread::start(denoiser, shared),
            denoised: None,
            shows_denoised: false,
            progress: Progress::default(),
            cost: None,
        }
    }

    /// Works until the window is gone.
    pub fn run(&mut self) {
        loop {
            let is_working = self.job.as_ref().is_some_and(|job| !job.is_done);
            let mut result = match self.owes_picture() {
                true => self.advance(),
                false => match self.shared.next_mail(is_working, self.denoising.is_busy()) {
                    Mail::Stop => return,
                    Mail::Request(view) => {
                        self.view = Some(view);
                        self.take_request()
                    }
                    Mail::Denoiser(outcome) => self.take_denoised(outcome),
                    Mail::None => self.advance(),
                },
            };
            while let Err(failure) = result {
                result = self.answer(failure);
            }
        }
    }

    /// Whether the picture in work comes before whatever is requested now: that of an edit, which would else not be seen
    /// before a drag ends, for a moment.
    fn owes_picture(&self) -> bool {
        let job = self.job.as_ref();
        let is_young = |job: &RenderJob| !job.is_done && job.is_new() && job.seconds < OWED;
        job.is_some_and(is_young) && self.known.is_of_edit()
    }

    fn publish(&self, change: impl FnOnce(&mut ViewState)) {
        change(&mut lock(&self.shared.state));
        self.repaint.request_repaint();
    }

    /// Tries what helps after a failure, or publishes it.
    fn answer(&mut self, failure: Failure) -> Result<(), Failure> {
        let error = match failure {
            // What took its place waits in the mailbox.
            Failure::Compile(CompileError::Cancelled) => return Ok(()),
            Failure::Compile(error) => with_advice_on_cloth(&error),
            Failure::Render(error) => {
                // What remains of a failed device is of no use.
                let renderer = self.renderer.take();
                self.stand_in = StandIn::None;
                let kind = renderer.map(|(_, mut renderer)| renderer.backend().kind());
                let larger_side = self.job.take().map_or(0, |job| {
                    let [width, height] = job.request.size;
                    width.max(height)
                });
                match self.fallback.remedy(&error, kind, larger_side) {
                    Remedy::Again(news) => {
                        tracing::warn!("{error}");
                        if let Some(news) = news {
                            self.publish(|state| state.report("The GPU stopped", news));
                        }
                        return self.take_request();
                    }
                    Remedy::Report => with_advice(&error, Place::Viewport),
                }
            }
        };
        self.job = None;
        self.publish(|state| {
            state.stage = Stage::Idle;
            state.error = Some(error);
        });
        Ok(())
    }

    /// Starts what is requested, as far as it differs from what is in work.
    fn take_request(&mut self) -> Result<(), Failure> {
        let Some(view) = self.view.clone() else {
            return Ok(());
        };
        self.expect(&view)?;
        let has_preview = self.preview(&view)?;
        let cloth = self.cloth_of(&view, has_preview)?;
        if self.fallback.choose(view.choice, view.attempt) {
            self.renderer = None;
            self.stand_in = StandIn::None;
        }
        let choice = view.choice.for_method(view.design.quality.method);
        let largest_side = self.choose_backend(self.fallback.effective(choice))?;
        let size = self.fallback.fitted(view.size, largest_side);
        let camera = Camera::from_design(&view.camera);
        let seen = cloth.view(&view.design, &camera, view.size);
        let request = RenderRequest::new(seen, size, view.light.settings(&view.design));
        let standing = self.fallback.standing();
        self.publish(|state| {
            state.instead = standing;
            state.size = size;
        });
        match &mut self.job {
            Some(job) if job.request == request => {
                self.show_again(view.display)?;
                return self.denoise_if_due();
            }
            Some(job) if job.goes_on_as(&request) => job.go_on_as(request),
            _ => {
                self.job = Some(RenderJob::new(request, self.cost));
                self.known.start_size();
                self.forget_denoised();
            }
        }
        self.begin()
    }

    /// The parts of the cloth that a request's picture shows; those that are there as long as they hold it.
    fn plan(&self, view: &ViewRequest, camera: &Camera) -> LodPlan {
        let last = self.made.as_ref().map(|(_, cloth)| &cloth.plan);
        LodPlan::new(&view.design, camera, view.size, LodBudget::LIVE, last)
    }

    /// Whether the parts that a plan names of a request's design are there.
    fn has_parts(&self, view: &ViewRequest, plan: &LodPlan) -> bool {
        let made = self.made.as_ref();
        made.is_some_and(|(design, cloth)| {
            Arc::ptr_eq(design, &view.design) && cloth.plan.regions == plan.regions
        })
    }

    /// The cloth that a request's picture shows; given up for a newer request sooner where there is a coarse preview
    /// already.
    fn cloth_of(
        &mut self,
        view: &ViewRequest,
        has_preview: bool,
    ) -> Result<Arc<LodCloth>, CompileError> {
        let design = &view.design;
        let camera = Camera::from_design(&view.camera);
        let plan = self.plan(view, &camera);
        if let Some((_, cloth)) = &self.made
            && self.has_parts(view, &plan)
            && cloth.plan == plan
        {
            return Ok(Arc::clone(cloth));
        }
        let mut before = Stage::Idle;
        self.publish(|state| {
            before = std::mem::replace(&mut state.stage, Stage::Compiling);
        });
        let (start, giving_up) = (Instant::now(), self.giving_up);
        let cancel = &self.shared.cancel;
        let is_given_up = || {
            let shows_nothing_else = !has_preview
                && (start.elapsed() <= FINISHED_ANYWAY
                    || giving_up.is_some_and(|since| since.elapsed() >= GIVING_UP));
            cancel.load(Ordering::Relaxed) && !shows_nothing_else
        };
        let maker = &mut self.maker;
        let made = workers::with_all(|| maker.make(design, plan, &Cancel::when(&is_given_up)));
        if made == Err(CompileError::Cancelled) && !has_preview {
            self.giving_up.get_or_insert(start);
        } else {
            self.giving_up = None;
        }
        let cloth = Arc::new(made?);
        if self.maker.last_report().frames_made > 0 {
            self.loops_took = start.elapsed();
        }
        let warnings = scene::warnings(design, &cloth.scenes.nearest, &mut self.yarns);
        let scene = SceneSummary {
            counts: cloth.counts(),
            warnings,
            cloth: Some(Arc::clone(&cloth)),
        };
        self.publish(|state| {
            // Where the picture stays the same, so does what is being done.
            state.stage = before;
            state.scene = scene;
        });
        self.made = Some((Arc::clone(design), Arc::clone(&cloth)));
        Ok(cloth)
    }

    /// Makes the backend unless it is there; the largest side of its pictures.
    fn choose_backend(&mut self, choice: BackendChoice) -> Result<u32, RenderError> {
        if let Some((made, renderer)) = &mut self.renderer
            && *made == choice
        {
            return Ok(renderer.backend().largest_side());
        }
        // The old one goes first: two of them may be more than the device's memory holds.
        self.renderer = None;
        self.stand_in = StandIn::None;
        self.job = None;
        self.cost = None;
        let mut renderer = (self.make)(choice)?;
        let largest_side = renderer.backend().largest_side();
        self.renderer = Some((choice, renderer));
        Ok(largest_side)
    }

    /// Hands the job's picture, at its present size, to the backend, and to the processor as well while that is not
    /// ready for it, or has begun the picture and may have it ended already.
    fn begin(&mut self) -> Result<(), Failure> {
        let (Some(job), Some((_, renderer))) = (&mut self.job, &mut self.renderer) else {
            return Ok(());
        };
        let (request, is_new) = (job.in_work(), job.is_new());
        let backend = renderer.backend();
        workers::with_all(|| backend.begin_soon(&request))?;
        let goes_on = !is_new && matches!(self.stand_in, StandIn::Draws(_));
        if goes_on || !backend.is_ready()? {
            let stand_in = match std::mem::take(&mut self.stand_in) {
                StandIn::Draws(stand_in) | StandIn::IsShown(stand_in) => stand_in,
                StandIn::None => (self.make)(BackendChoice::Cpu)?,
            };
            self.stand_in = StandIn::Draws(stand_in);
            let drawing = self.stand_in.drawing(renderer).backend();
            workers::with_all(|| drawing.begin(&request))?;
        } else if is_new {
            self.stand_in = StandIn::None;
        }
        let device = self.stand_in.device(renderer);
        self.publish(|state| {
            state.stage = Stage::Rendering(match state.stage {
                _ if is_new => Seen::Nothing,
                Stage::Rendering(seen) => seen,
                // Only pictures of full size go on after a rest.
                Stage::Idle | Stage::Compiling => Seen::Whole,
            });
            state.device = Some(device);
            state.error = None;
        });
        Ok(())
    }

    /// One slice of work on the job.
    fn advance(&mut self) -> Result<(), Failure> {
        let is_owed = self.owes_picture();
        let (Some(job), Some((_, renderer))) = (&mut self.job, &mut self.renderer) else {
            return Ok(());
        };
        if matches!(self.stand_in, StandIn::Draws(_))
            && !job.has_met_target()
            && renderer.backend().is_ready()?
        {
            job.start_again(renderer.softens());
            self.stand_in.step_back(job.is_new());
        }
        let start = Instant::now();
        let drawing = self.stand_in.drawing(renderer);
        let never = AtomicBool::new(false);
        let cancel = if is_owed { &never } else { &self.shared.cancel };
        let progress = advance(drawing, cancel)?;
        self.progress = progress;
        let (cost, is_due) = job.note(progress, start.elapsed().as_secs_f64());
        if !matches!(self.stand_in, StandIn::Draws(_)) {
            self.cost = cost.or(self.cost);
        }
        let stays = progress.done && job.is_behind();
        if is_due {
            self.stand_in.give_way();
            self.show(progress)?;
        } else if stays {
            self.publish(|state| state.picture.progress.done = true);
        }
        self.denoise_if_due()?;
        if progress.done {
            return self.climb();
        }
        Ok(())
    }

    /// Goes on with a picture twice as large, or rests.
    fn climb(&mut self) -> Result<(), Failure> {
        if self.job.as_mut().is_some_and(RenderJob::climb) {
            self.expect_what_is_shown();
            self.progress = Progress::default();
            return self.begin();
        }
        self.publish(|state| state.stage = Stage::Idle);
        Ok(())
    }

    /// Publishes the picture so far.
    fn show(&mut self, progress: Progress) -> Result<(), Failure> {
        let (Some(job), Some(view)) = (&self.job, &self.view) else {
            return Ok(());
        };
        let start = Instant::now();
        let (display, softness) = (view.display, job.softness(progress.samples));
        // A denoised picture stays until the next one: plain ones in between would flicker.
        let stays = self.denoised.is_some() && view.denoises;
        let is_whole = !job.is_reduced();
        let joined = match stays {
            true => None,
            false => self.joined(is_whole, progress.samples, progress.done)?,
        };
        let (Some(job), Some((_, renderer))) = (&mut self.job, &mut self.renderer) else {
            return Ok(());
        };
        let transform = &mut self.transform;
        let drawing = self.stand_in.shown(renderer);
        let frame = match (stays, joined) {
            (true, _) => None,
            (false, Some(joined)) => Some(workers::with_all(|| {
                transform.frame_of(Arc::new(joined), display)
            })),
            (false, None) => Some(workers::with_all(|| {
                transform.frame(drawing, display, softness)
            })?),
        };
        let device = self.stand_in.device(renderer);
        job.published(start.elapsed());
        let (seconds, is_reduced) = (job.seconds, job.is_reduced());
        if !stays {
            self.display = Some(display);
            self.shows_denoised = false;
            self.note_shown();
        }
        self.publish(|state| {
            if let Some(frame) = frame {
                state.show(frame);
                state.picture.denoised = None;
            }
            state.picture.progress = progress;
            state.picture.is_reduced = is_reduced;
            state.picture.seconds = seconds;
            state.stage = Stage::Rendering(match is_reduced {
                true => Seen::Reduced,
                false => Seen::Whole,
            });
            state.device = Some(device);
        });
        Ok(())
    }

    /// Publishes the last picture as another display shows it, or denoised, or no longer.
    fn show_again(&mut self, display: Display) -> Result<(), Failure> {
        let denoises = self.view.as_ref().is_some_and(|view| view.denoises);
        let shows_denoised = denoises && self.denoised.is_some();
        if shows_denoised {
            self.show_denoised(display);
            return Ok(());
        }
        if self.shows_denoised {
            return self.show(self.progress);
        }
        if self.display == Some(display) {
            return Ok(());
        }
        let Some((_, renderer)) = &mut self.renderer else {
            return Ok(());
        };
        let shown = self.stand_in.shown(renderer);
        let frame = self.transform.last_frame(shown, display)?;
        self.display = Some(display);
        self.publish(|state| state.show(frame));
        Ok(())
    }
}

fn advance(renderer: &mut Renderer, cancel: &AtomicBool) -> Result<Progress, RenderError> {
    match renderer {
        Renderer::Within(backend) => {
            let is_software = backend.context().is_software();
            let slice = if is_software { SLICE } else { SHORT_SLICE };
            renderer.backend().advance(slice, cancel)
        }
        Renderer::Apart(backend) => workers::with_all(|| backend.advance(SLICE, cancel)),
    }
}
