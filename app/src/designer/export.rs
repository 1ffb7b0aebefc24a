//! Export PNG: renders the design as it is now in a thread of its own, beside editing, and writes the file at the end:
//! it is whole or not there.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Align2, ComboBox, Context, DragValue, Grid, ProgressBar, Ui, Window};
use renderer_core::design::{CameraDesign, Design, Quality};
use renderer_core::image::{Depth, Display, encode_png};
use renderer_core::render::{Camera, MAX_SIDE, RenderRequest, Settings};
use renderer_core::scene;

use super::renderer::MakeBackend;
use super::tasks::{Poll, Task};
use super::viewport::seconds_text;
use crate::backend::BackendChoice;
use crate::files::{self, Carried};

/// The export window.
pub struct Export {
    /// Whether the window is open.
    pub is_open: bool,
    size: [u32; 2],
    samples: u32,
    choice: BackendChoice,
    job: Option<Job>,
}

/// An export at work.
struct Job {
    path: PathBuf,
    task: Task<Result<Outcome, String>>,
    progress: Arc<Mutex<Progress>>,
    cancel: Arc<AtomicBool>,
}

#[derive(Clone, Copy, Default)]
struct Progress {
    samples: u32,
    of: u32,
    seconds: f64,
}

enum Outcome {
    /// With what the picture does not take along.
    Written(Vec<String>),
    Cancelled,
}

/// What the window has to tell its owner.
#[derive(Debug)]
pub enum Event {
    /// The user wants to export: ask for the file.
    AskForFile,
    /// The file is written; sentences tell what it does not take along of the design.
    Written(PathBuf, Vec<String>),
    /// It is not, because.
    Failed(PathBuf, String),
}

/// How long the backend works before progress is shown and cancelling is looked for.
const SLICE: Duration = Duration::from_millis(200);

impl Export {
    /// A closed window.
    pub fn new(choice: BackendChoice) -> Self {
        Self {
            is_open: false,
            size: [1600, 1200],
            samples: Quality::default().samples,
            choice,
            job: None,
        }
    }

    /// Opens the window for a design, with the viewport's shape.
    pub fn open(&mut self, design: &Design, viewport: [u32; 2]) {
        if !self.is_open && self.job.is_none() {
            self.size = [2 * viewport[0], 2 * viewport[1]].map(|side| side.clamp(1, MAX_SIDE));
            self.samples = design.quality.samples;
        }
        self.is_open = true;
    }

    /// Starts to render `design` as `camera` sees it, and to write it to `path`.
    pub fn start(
        &mut self,
        path: PathBuf,
        design: Design,
        carried: Carried,
        camera: &CameraDesign,
        make: MakeBackend,
        ctx: &Context,
    ) {
        let progress = Arc::<Mutex<Progress>>::default();
        let cancel = Arc::<AtomicBool>::default();
        let order = Order {
            path: path.clone(),
            camera: Camera::from_design(camera),
            size: self.size,
            samples: self.samples,
            choice: self.choice,
            design,
            carried,
        };
        let (progress_there, cancel_there, repaint) =
            (Arc::clone(&progress), Arc::clone(&cancel), ctx.clone());
        let tell = move |now: Progress| {
            *progress_there
                .lock()
                .unwrap_or_else(PoisonError::into_inner) = now;
            repaint.request_repaint();
        };
        let task = Task::start(ctx, move || order.carry_out(&make, &cancel_there, tell));
        self.job = Some(Job {
            path,
            task,
            progress,
            cancel,
        });
    }

    /// Shows the window and looks after the job.
    pub fn show(&mut self, ctx: &Context) -> Option<Event> {
        let ended = self.job.as_ref().and_then(|job| match job.task.poll() {
            Poll::Pending => None,
            Poll::Ready(result) => Some(result),
            Poll::Lost => Some(Err("the renderer stopped unexpectedly".into())),
        });
        if let Some(result) = ended {
            let path = self.job.take()?.path.clone();
            return match result {
                Ok(Outcome::Written(warnings)) => {
                    self.is_open = false;
                    Some(Event::Written(path, warnings))
                }
                Ok(Outcome::Cancelled) => None,
                Err(error) => Some(Event::Failed(path, error)),
            };
        }
        let mut event = None;
        let mut is_open = self.is_open;
        Window::new("Export PNG")
            .open(&mut is_open)
            .collapsible(false)
            .resizable(false)
            .default_width(300.0)
            .pivot(Align2::CENTER_CENTER)
            .default_pos(ctx.content_rect().center())
            .show(ctx, |ui| match &self.job {
                None => event = self.settings(ui),
                Some(job) => job.show(ui),
            });
        self.is_open = is_open;
        event
    }

    fn settings(&mut self, ui: &mut Ui) -> Option<Event> {
        Grid::new("export")
            .num_columns(2)
            .spacing([12.0, 6.0])
            .show(ui, |ui| {
                ui.label("Size");
                ui.horizontal(|ui| {
                    let [width, height] = &mut self.size;
                    let side = |value| DragValue::new(value).range(1..=MAX_SIDE).speed(4.0);
                    ui.add(side(width)).accessible_name("Export width");
                    ui.label("×");
                    ui.add(side(height)).accessible_name("Export height");
                    ui.weak("px");
                });
                ui.end_row();
                ui.label("Samples");
                let field = Quality::FIELDS.samples;
                let samples = DragValue::new(&mut self.samples)
                    .range(field.min..=field.max)
                    .speed(1.0);
                ui.add(samples)
                    .accessible_name("Export samples")
                    .on_hover_text(field.what.trim());
                ui.end_row();
                let label = ui.label("Backend");
                ComboBox::from_id_salt("export backend")
                    .selected_text(super::view_bar::backend_name(self.choice))
                    .show_ui(ui, |ui| {
                        for choice in super::view_bar::BACKENDS {
                            let name = super::view_bar::backend_name(choice);
                            ui.selectable_value(&mut self.choice, choice, name);
                        }
                    })
                    .response
                    .labelled_by(label.id);
                ui.end_row();
            });
        ui.add_space(4.0);
        ui.weak("The picture is made from the viewport's camera; editing can go on meanwhile.");
        ui.add_space(6.0);
        let export = ui.button("Choose file and export…");
        export.clicked().then_some(Event::AskForFile)
    }

    /// A name for the picture of a document.
    pub fn file_name(document: &str) -> String {
        format!("{document}.png")
    }
}

impl Job {
    fn show(&self, ui: &mut Ui) {
        let now = *self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        ui.set_width(280.0);
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        ui.label(format!("Rendering {}", name.to_string_lossy()));
        let share = f64::from(now.samples) / f64::from(now.of.max(1));
        ui.add(ProgressBar::new(share as f32).show_percentage());
        let left = if now.samples == 0 {
            "preparing…".into()
        } else {
            let rest = now.seconds * (1.0 / share - 1.0);
            format!(
                "{} of {} samples, {} left",
                now.samples,
                now.of,
                seconds_text(rest)
            )
        };
        ui.weak(left);
        ui.add_space(4.0);
        let stopping = self.cancel.load(Ordering::Relaxed);
        let cancel = ui.add_enabled(!stopping, egui::Button::new("Cancel export"));
        if cancel.clicked() {
            self.cancel.store(true, Ordering::Relaxed);
        }
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        // The window closes: nobody waits for the picture any more.
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// What to render and where to write it.
struct Order {
    path: PathBuf,
    design: Design,
    carried: Carried,
    camera: Camera,
    size: [u32; 2],
    samples: u32,
    choice: BackendChoice,
}

impl Order {
    fn carry_out(
        &self,
        make: &MakeBackend,
        cancel: &AtomicBool,
        tell: impl Fn(Progress),
    ) -> Result<Outcome, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        // Now rather than after minutes of rendering.
        files::check_writable(&self.path).map_err(|error| text(&error))?;
        let scene = Arc::new(scene::compile(&self.design).map_err(|error| text(&error))?);
        let choice = self.choice.for_method(self.design.quality.method);
        let mut backend = make(choice).map_err(|error| text(&error))?;
        let request = RenderRequest {
            scene,
            camera: self.camera,
            size: self.size,
            crop: [0, 0, self.size[0], self.size[1]],
            settings: Settings {
                samples: self.samples,
                ..Settings::from(&self.design.quality)
            },
        };
        backend.begin(&request).map_err(|error| text(&error))?;
        let start = Instant::now();
        loop {
            if cancel.load(Ordering::Relaxed) {
                return Ok(Outcome::Cancelled);
            }
            let progress = backend
                .advance(SLICE, cancel)
                .map_err(|error| text(&error))?;
            tell(Progress {
                samples: progress.samples,
                of: self.samples,
                seconds: start.elapsed().as_secs_f64(),
            });
            if progress.done {
                break;
            }
        }
        let picture = backend.picture().map_err(|error| text(&error))?;
        let display = Display::from(&self.design.view);
        let png =
            encode_png(&picture, display, Depth::Eight, None).map_err(|error| text(&error))?;
        // In a document paths of images are whole, or names of what it carries.
        let embedded = files::embedded(&self.design, &self.carried, Path::new(""))?;
        let png = files::insert_chunks(png, &embedded.chunks);
        if cancel.load(Ordering::Relaxed) {
            return Ok(Outcome::Cancelled);
        }
        write(&self.path, &png)?;
        Ok(Outcome::Written(embedded.warnings))
    }
}

fn write(path: &Path, png: &[u8]) -> Result<(), String> {
    files::write_atomically(path, png).map_err(|error| error.to_string())
}
