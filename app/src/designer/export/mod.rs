//! The export window: what picture to make, how far the one in work is, and what came of it. Rendering and writing
//! (`job`) go on beside editing; the file is whole or not there.

mod estimate;
mod form;
mod job;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use egui::{Align2, Context, ProgressBar, ScrollArea, Ui, Window};
use renderer_core::design::{CameraDesign, Design};
use renderer_core::image::Depth;

use crate::backend::BackendChoice;
use crate::denoiser::MakeDenoiser;
use crate::designer::document::settings::ExportSettings;
use crate::designer::render_thread::renderer::MakeBackend;
use crate::designer::tasks::Poll;
use crate::files::Carried;
use crate::picture_file::Format;
use estimate::Estimate;
use form::{FileType, Form};
use job::{ExportJob, ExportRequest, Outcome};

/// What the window's title and frame take of the height, points.
const AROUND_FORM: f32 = 76.0;

/// The export window.
pub struct Export {
    /// Whether the window is open.
    pub is_open: bool,
    make: MakeBackend,
    denoiser: MakeDenoiser,
    form: Form,
    estimate: Estimate,
    /// What the last estimate was.
    expected: Option<Duration>,
    job: Option<ExportJob>,
}

/// How far an export is.
pub struct UnderWay {
    /// The file's name.
    pub name: String,
    /// Share of the whole work, 0 to 1.
    pub share: f64,
    /// How long it still takes, in words.
    pub left: String,
}

/// What a picture shows.
pub struct Subject {
    /// The design's name.
    pub name: String,
    /// The design.
    pub design: Design,
    /// Its images that lie in no folder.
    pub carried: Carried,
    /// From where it is seen.
    pub camera: CameraDesign,
}

/// What came of the window.
#[derive(Debug)]
pub enum Event {
    /// The user wants to export: ask for a file with this ending.
    AskForFile(&'static str),
    /// The file is written; sentences say what it does not take along of the design.
    Written(PathBuf, Vec<String>),
    /// It is not, because.
    Failed(PathBuf, String),
}

impl Export {
    /// A closed window, with `choice` at first; renders with what `make` makes.
    pub fn new(choice: BackendChoice, make: MakeBackend, denoiser: MakeDenoiser) -> Self {
        Self {
            is_open: false,
            make,
            denoiser,
            form: Form::new(choice),
            estimate: Estimate::default(),
            expected: None,
            job: None,
        }
    }

    /// Opens the window for a design, with size and quality of the last picture or else the viewport's shape.
    pub fn open(
        &mut self,
        design: &Design,
        camera: &CameraDesign,
        last: Option<ExportSettings>,
        viewport: [u32; 2],
    ) {
        if !self.is_open && self.job.is_none() {
            self.form.begin(design, camera, last, viewport);
        }
        self.is_open = true;
    }

    /// Size and quality as they were chosen last.
    pub fn settings(&self) -> ExportSettings {
        self.form.settings()
    }

    /// What is being exported, if anything is.
    pub fn under_way(&self) -> Option<UnderWay> {
        let job = self.job.as_ref()?;
        let (standing, left, _) = job.progress();
        let name = job.path.file_name().unwrap_or(job.path.as_os_str());
        Some(UnderWay {
            name: name.to_string_lossy().into_owned(),
            share: standing.share,
            left: left.text(),
        })
    }

    /// Starts to render what is to be seen, and to write it to `path`.
    pub fn start(&mut self, path: PathBuf, subject: Subject, ctx: &Context) {
        let request = ExportRequest {
            format: self.format_of(&path),
            path,
            subject,
            size: self.form.size,
            samples: self.form.samples,
            error: self.form.error_target(),
            time: self.form.time_limit(),
            transparent: self.form.transparent,
            denoiser: self.form.denoise.then(|| Arc::clone(&self.denoiser)),
            takes_design: self.form.takes_design,
            dots_per_inch: self.form.dots_per_inch,
            choice: self.form.choice,
            expected: self.expected.take(),
        };
        self.job = Some(ExportJob::start(
            Arc::new(request),
            Arc::clone(&self.make),
            ctx,
        ));
    }

    /// The format that the name of the file asks for, else that of the form.
    fn format_of(&self, path: &Path) -> Format {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match (ending.as_deref(), self.form.file_type) {
            (Some("exr"), _) => Format::Exr(self.form.layers()),
            (Some("png"), FileType::Png16) => Format::Png(Depth::Sixteen),
            (Some("png"), _) | (_, FileType::Png8) => Format::Png(Depth::Eight),
            (_, FileType::Png16) => Format::Png(Depth::Sixteen),
            (_, FileType::Exr) => Format::Exr(self.form.layers()),
        }
    }

    /// Shows the window for the design as it is now and looks after the job.
    pub fn show(
        &mut self,
        ctx: &Context,
        design: &Arc<Design>,
        camera: &CameraDesign,
    ) -> Option<Event> {
        let mut event = self.take_outcome();
        if event.is_some() {
            return event;
        }
        if !self.is_open || self.job.is_some() {
            self.estimate = Estimate::default();
        }
        if !self.is_open {
            return None;
        }
        let estimate = self.estimate_text(ctx, design, camera);
        let mut is_open = self.is_open;
        let mut is_cancelled = false;
        let room = ctx.content_rect();
        Window::new("Export picture")
            .open(&mut is_open)
            .collapsible(false)
            .resizable(false)
            .default_width(380.0)
            .pivot(Align2::CENTER_CENTER)
            .default_pos(room.center())
            .default_height(room.height() - AROUND_FORM)
            .show(ctx, |ui| match &self.job {
                None => {
                    // In a small window the form is higher than that.
                    let form = ScrollArea::vertical().max_height(room.height() - AROUND_FORM);
                    if form
                        .show(ui, |ui| self.form.show(ui, design, camera, &estimate))
                        .inner
                    {
                        event = Some(Event::AskForFile(self.form.file_type.ending()));
                    }
                }
                Some(job) => is_cancelled = show_job(ui, job),
            });
        if is_cancelled {
            // The thread sees it at its next row; nobody waits for that.
            self.job = None;
        }
        self.is_open = is_open;
        event
    }

    /// How long the picture takes that the form describes.
    fn estimate_text(
        &mut self,
        ctx: &Context,
        design: &Arc<Design>,
        camera: &CameraDesign,
    ) -> String {
        if self.job.is_some() {
            return String::new();
        }
        let [width, height] = self.form.size.map(f64::from);
        let subject = estimate::Subject {
            design: Arc::clone(design),
            camera: camera.clone(),
            choice: self.form.choice,
            proportion: width / height,
        };
        let cost = self.estimate.cost(ctx, &subject, &self.make);
        let (samples, limit) = (self.form.most_samples(), self.form.time_limit());
        self.expected = cost.map(|cost| cost.rendering(samples, limit));
        estimate::text(cost, samples, limit, self.form.may_end_sooner())
    }

    /// What came of the job, once it has ended; nothing of one that was cancelled.
    fn take_outcome(&mut self) -> Option<Event> {
        let result = match self.job.as_ref()?.task.poll() {
            Poll::Pending => return None,
            Poll::Ready(result) => result,
            Poll::Lost => {
                Err("the renderer stopped unexpectedly; try again, or with another backend".into())
            }
        };
        let path = self.job.take()?.path.clone();
        match result {
            Ok(Outcome::Written(warnings)) => {
                self.is_open = false;
                Some(Event::Written(path, warnings))
            }
            Ok(Outcome::Cancelled) => None,
            Err(error) => {
                self.is_open = true;
                Some(Event::Failed(path, error))
            }
        }
    }
}

/// How far a job is. Whether it is to be cancelled.
fn show_job(ui: &mut Ui, job: &ExportJob) -> bool {
    let (standing, left, of) = job.progress();
    ui.set_width(360.0);
    let name = job.path.file_name().unwrap_or(job.path.as_os_str());
    ui.label(format!("Rendering {}", name.to_string_lossy()));
    ui.add(ProgressBar::new(standing.share as f32).show_percentage());
    let [band, bands] = standing.band;
    let mut parts = Vec::new();
    if band == 0 {
        parts.push("Planting loops…".to_owned());
    } else if standing.waits_for_device {
        parts.push("Preparing the GPU…".to_owned());
    } else {
        if bands > 1 {
            parts.push(format!("band {band} of {bands}"));
        }
        parts.push(format!("{} of {of} samples", standing.samples));
        if let Some(error) = standing.error {
            parts.push(format!("error {:.2} %", 100.0 * error));
        }
        parts.push(left.text());
    }
    ui.weak(parts.join(" · "));
    ui.weak("Editing can go on meanwhile: the picture shows the design as it was.");
    ui.add_space(4.0);
    ui.button("Cancel export")
        .on_hover_text("Stops at once and writes no file.")
        .clicked()
}
