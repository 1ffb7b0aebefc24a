//! An export at work, on a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::Context;
use renderer_core::geometry::Camera;
use renderer_core::image::{Background, Display};
use renderer_core::render::Settings;
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodView};
use renderer_core::scene::{Cancel, CompileError};

use super::Subject;
use crate::advice::{Place, with_advice, with_advice_on_cloth, with_advice_on_denoiser};
use crate::backend::BackendChoice;
use crate::denoiser::MakeDenoiser;
use crate::designer::render_thread::renderer::MakeBackend;
use crate::designer::tasks::Task;
use crate::files;
use crate::picture_file::{self, BAND_BYTES, Failure, Format, Standing, TimeLeft};

/// The window shows how far an export is so often.
const SHOWN_EVERY: Duration = Duration::from_millis(250);

/// What to render and where to write it.
pub(super) struct ExportRequest {
    pub path: PathBuf,
    pub format: Format,
    pub subject: Subject,
    pub size: [u32; 2],
    pub samples: u32,
    pub error: f64,
    pub time: Option<Duration>,
    pub transparent: bool,
    /// What takes noise out of it, if anything is to.
    pub denoiser: Option<MakeDenoiser>,
    /// Whether a PNG takes its design along.
    pub takes_design: bool,
    pub dots_per_inch: f64,
    pub choice: BackendChoice,
    /// How long it is expected to take.
    pub expected: Option<Duration>,
}

/// How it ended, if it did not fail.
pub(super) enum Outcome {
    /// With what the picture does not take along.
    Written(Vec<String>),
    /// There is no file.
    Cancelled,
}

/// An export at work.
pub(super) struct ExportJob {
    pub path: PathBuf,
    pub task: Task<Result<Outcome, String>>,
    progress: Arc<Mutex<(Standing, TimeLeft)>>,
    samples: u32,
    cancel: Arc<AtomicBool>,
}

impl ExportJob {
    /// Starts.
    pub fn start(request: Arc<ExportRequest>, make: MakeBackend, ctx: &Context) -> Self {
        let left = request.expected.map(TimeLeft::expecting);
        let progress = Arc::new(Mutex::new((Standing::default(), left.unwrap_or_default())));
        let cancel = Arc::<AtomicBool>::default();
        let (path, samples) = (request.path.clone(), request.samples);
        let (there, cancel_there, repaint) =
            (Arc::clone(&progress), Arc::clone(&cancel), ctx.clone());
        let mut shown = None::<Instant>;
        // What comes before the first sample says nothing of how fast samples come.
        let mut begun = None::<Instant>;
        let report = move |standing: &Standing| {
            let mut now = there.lock().unwrap_or_else(PoisonError::into_inner);
            now.0 = *standing;
            if !standing.waits_for_device {
                let begun = begun.get_or_insert_with(Instant::now);
                now.1.note(begun.elapsed(), standing.share);
            }
            drop(now);
            // Where the processor draws the window, every frame of it is taken from the picture.
            if shown.is_none_or(|then| then.elapsed() >= SHOWN_EVERY) {
                shown = Some(Instant::now());
                repaint.request_repaint();
            }
        };
        let task = Task::start(ctx, move || request.carry_out(&make, &cancel_there, report));
        Self {
            path,
            task,
            progress,
            samples,
            cancel,
        }
    }

    /// Where it stands, how long it will still take, and how many samples are wanted. Before a large picture's first
    /// sample is whole its share is that of the time.
    pub fn progress(&self) -> (Standing, TimeLeft, u32) {
        let now = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut standing, left) = *now;
        if standing.samples == 0 && standing.share < 1.0 {
            standing.share = standing.share.max(left.share());
        }
        (standing, left, self.samples)
    }
}

impl Drop for ExportJob {
    fn drop(&mut self) {
        // Cancelled, or the window closes: nobody waits for the picture any more.
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl ExportRequest {
    fn carry_out(
        &self,
        make: &MakeBackend,
        cancel: &AtomicBool,
        report: impl FnMut(&Standing),
    ) -> Result<Outcome, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        // Now rather than after minutes of rendering.
        files::check_writable(&self.path).map_err(|error| text(&error))?;
        let denoiser = self.denoiser.as_ref().map(|make| make()).transpose();
        let denoiser = denoiser.map_err(|error| with_advice_on_denoiser(&error, Place::Export))?;
        let is_given_up = || cancel.load(Ordering::Relaxed);
        let made = LodView::new(
            &mut LodCompiler::default(),
            &self.subject.design,
            &Camera::from_design(&self.subject.camera),
            self.size,
            LodBudget::FINAL,
            &Cancel::when(&is_given_up),
        );
        let view = match made {
            Ok(view) => view,
            Err(CompileError::Cancelled) => return Ok(Outcome::Cancelled),
            Err(error) => return Err(with_advice_on_cloth(&error)),
        };
        if is_given_up() {
            return Ok(Outcome::Cancelled);
        }
        let (chunks, warnings) = match self.format {
            Format::Png(_) if self.takes_design => {
                // In a document paths of images are whole, or names of what it carries.
                let embedded =
                    files::embedded(&self.subject.design, &self.subject.carried, Path::new(""))?;
                (embedded.chunks, embedded.warnings)
            }
            Format::Png(_) | Format::Exr(_) => (Vec::new(), Vec::new()),
        };
        let background = Background(self.subject.design.background_radiance());
        let order = picture_file::PictureOrder {
            view,
            size: self.size,
            crop: [0, 0, self.size[0], self.size[1]],
            settings: Settings {
                samples: self.samples,
                error: self.error,
                ..Settings::from(&self.subject.design.quality)
            },
            time: self.time,
            format: self.format.clone(),
            display: Display::from(&self.subject.design),
            transparent: self.transparent.then_some(background),
            about: picture_file::about(&self.subject.name, Some(self.dots_per_inch)),
            chunks,
            band_bytes: BAND_BYTES,
        };
        let choice = self.choice.for_method(self.subject.design.quality.method);
        let mut backend = make(choice).map_err(|error| with_advice(&error, Place::Export))?;
        match picture_file::make(&order, &mut *backend, denoiser, &self.path, cancel, report) {
            Ok(_) => Ok(Outcome::Written(warnings)),
            Err(Failure::Cancelled) => Ok(Outcome::Cancelled),
            Err(Failure::Render(error)) => Err(with_advice(&error, Place::Export)),
            Err(error) => Err(text(&error)),
        }
    }
}
