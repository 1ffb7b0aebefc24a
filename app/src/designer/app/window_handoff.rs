//! Opening the window again after it was lost, with its graphics device or in a panic: the document goes over to the
//! new one, with a message.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use egui::Context;
use renderer_core::design::CameraDesign;

use super::App;
use super::window::in_a_window;
use crate::backend::{self, BackendChoice};
use crate::denoiser;
use crate::designer::{Document, Folders, LiveLight, Setup};
use crate::files::{self, BUNDLE_ENDING, FileError};

/// Windows that last less than this,
const SHORT: Duration = Duration::from_secs(10);
/// so many times in a row, are not opened again.
const MOST: u32 = 3;

/// What a lost window leaves to the next.
struct Kept {
    document: Document,
    camera: CameraDesign,
    choice: BackendChoice,
    light: LiveLight,
    why: String,
}

/// Where a lost window leaves it.
#[derive(Clone, Default)]
pub struct WindowHandoff(Arc<Mutex<Option<Kept>>>);

impl WindowHandoff {
    fn lock(&self) -> MutexGuard<'_, Option<Kept>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a window has left something.
    pub fn is_filled(&self) -> bool {
        self.lock().is_some()
    }
}

/// Opens the designer's window, again when it is lost, and returns when it is closed.
///
/// # Errors
/// When no window can be opened, with what to install, or when windows are lost again and again, with where the design
/// is.
pub fn run(preset: Option<PathBuf>, choice: BackendChoice) -> anyhow::Result<()> {
    let handoff = WindowHandoff::default();
    // Wherever the program goes, it saves to the file that was named.
    let mut preset = preset.map(|preset| files::absolute(&preset));
    let mut short_lives = 0;
    loop {
        let opened = Instant::now();
        let result = open(preset.take(), choice, &handoff);
        if !handoff.is_filled() {
            return result.unwrap_or_else(|panic| resume_unwind(panic));
        }
        short_lives = if opened.elapsed() < SHORT {
            short_lives + 1
        } else {
            0
        };
        if short_lives == MOST {
            return Err(give_up(&handoff));
        }
    }
}

type Panic = Box<dyn Any + Send>;

fn open(
    preset: Option<PathBuf>,
    choice: BackendChoice,
    handoff: &WindowHandoff,
) -> Result<anyhow::Result<()>, Panic> {
    let handoff = handoff.clone();
    let window = AssertUnwindSafe(move || {
        in_a_window(move |cc| {
            let kept = handoff.lock().take();
            let setup = Setup {
                preset,
                choice: kept.as_ref().map_or(choice, |kept| kept.choice),
                make: Arc::new(backend::make),
                denoiser: Arc::new(denoiser::make),
                system_dialogs: true,
                folders: Folders::of_user(),
            };
            let mut app = App::new(cc, setup);
            if let Some(kept) = kept {
                app.go_on_from(kept);
            }
            app.window.handoff = handoff;
            Box::new(app)
        })
    });
    catch_unwind(window)
}

/// Saves the design where the user can find it, since no window lasts.
fn give_up(handoff: &WindowHandoff) -> anyhow::Error {
    let Some(kept) = handoff.lock().take() else {
        return anyhow!("the window was lost again and again");
    };
    let why = kept.why;
    if !kept.document.is_unsaved() {
        return anyhow!("the window was lost again and again: {why}");
    }
    match rescue(&kept.document) {
        Ok(path) => anyhow!(
            "the window was lost again and again: {why}; the design is in {}",
            path.display()
        ),
        Err(error) => anyhow!(
            "the window was lost again and again: {why}; the design could not be saved: {error}"
        ),
    }
}

/// Saves a document as a bundle in the folder for temporary files, under a name that no other file has.
fn rescue(document: &Document) -> Result<PathBuf, FileError> {
    let folder = std::env::temp_dir();
    let mut path = folder.join(format!("{}-rescued.{BUNDLE_ENDING}", document.name()));
    let mut number = 2;
    while path.exists() {
        let name = format!("{}-rescued-{number}.{BUNDLE_ENDING}", document.name());
        path = folder.join(name);
        number += 1;
    }
    files::save(&document.design, document.carried(), &path, document.path())?;
    Ok(path)
}

impl App {
    /// Where this window leaves its document when it is lost.
    pub fn handoff(&self) -> &WindowHandoff {
        &self.window.handoff
    }

    fn go_on_from(&mut self, kept: Kept) {
        if kept.document.is_unsaved() {
            self.filing.take_over();
        }
        self.document = kept.document;
        self.viewport.camera = kept.camera;
        self.viewport.light = kept.light;
        let text = format!(
            "{} The window was opened anew. The design, its history and its file are as they were.",
            kept.why
        );
        self.shell.notices.error("The window was lost", text);
    }

    /// Closes a window whose device is lost, after leaving the document to the next; true if so. Nothing must be drawn
    /// then: egui's renderer would panic for want of buffers.
    pub(super) fn is_lost(&mut self, ctx: &Context) -> bool {
        if !self.window.handoff.is_filled() {
            let lost = self.viewport.watch().and_then(|watch| watch.lost());
            let Some(lost) = lost else { return false };
            let why = format!("The graphics device that drew it stopped ({lost}).");
            self.leave(why);
        }
        self.quit(ctx);
        true
    }

    fn leave(&mut self, why: String) {
        let kept = Kept {
            document: std::mem::take(&mut self.document),
            camera: self.viewport.camera.clone(),
            choice: self.viewport.choice(),
            light: self.viewport.light,
            why,
        };
        *self.window.handoff.lock() = Some(kept);
    }
}

impl Drop for App {
    fn drop(&mut self) {
        if std::thread::panicking() && !self.window.handoff.is_filled() {
            self.leave("An error in the program ended it.".into());
        }
    }
}
