//! Asking for files: with the system's dialog, off the window's thread; where none can open, with our own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use egui::Context;
use renderer_core::design::ImageSlot;

use crate::designer::widgets::{Browsed, FileBrowser, FileKind};
use crate::files::words;

/// What a file is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A preset to open.
    OpenPreset,
    /// A file to save the design to.
    SavePreset,
    /// A bundle to save the design as.
    SaveBundle,
    /// An image of the design.
    OpenImage(ImageSlot),
    /// A picture to write.
    ExportPng,
    /// A picture of linear light to write.
    ExportExr,
}

impl Purpose {
    /// Name under which the folder last used is remembered.
    pub fn key(self) -> &'static str {
        match self {
            Self::OpenPreset | Self::SavePreset | Self::SaveBundle => "designs",
            Self::OpenImage(slot) => words(slot).folder_key,
            Self::ExportPng | Self::ExportExr => "pictures",
        }
    }

    /// Whether such files lie in a folder of their own rather than beside the design.
    pub fn has_own_folder(self) -> bool {
        matches!(self, Self::OpenImage(_) | Self::ExportPng | Self::ExportExr)
    }

    fn kind(self) -> FileKind {
        let (title, name, endings, saving): (_, _, &[&str], _) = match self {
            Self::OpenPreset => (
                "Open design",
                "designs",
                &["toml", "towel", "png", "zip"],
                false,
            ),
            Self::SavePreset => ("Save design as", "designs", &["toml", "towel"], true),
            Self::SaveBundle => ("Save as bundle", "bundles", &["towel"], true),
            Self::OpenImage(slot) => {
                let words = words(slot);
                (words.dialog_title, "images", words.endings, false)
            }
            Self::ExportPng => ("Export picture as", "pictures", &["png", "exr"], true),
            Self::ExportExr => ("Export picture as", "pictures", &["exr", "png"], true),
        };
        FileKind {
            title,
            name,
            endings,
            saving,
        }
    }
}

/// A system dialog gone sooner than this has not been seen: there is none on this machine. (Without a desktop portal it
/// fails within 40 ms, on a busy machine later; who cancels a real one this fast can cancel ours too.)
const NEVER_OPENED: Duration = Duration::from_secs(1);

/// The dialog that is open, if any.
pub struct Dialogs {
    use_system: bool,
    system: Option<SystemDialog>,
    browser: Option<(Purpose, FileBrowser)>,
}

/// What was chosen in a system dialog, and for how long it was open.
type Answer = (Option<PathBuf>, Duration);

struct SystemDialog {
    purpose: Purpose,
    answer: Receiver<Answer>,
    folder: PathBuf,
    name: String,
}

impl Dialogs {
    /// Dialogs; with `use_system` those of the system where it has some.
    pub fn new(use_system: bool) -> Self {
        Self {
            use_system,
            system: None,
            browser: None,
        }
    }

    /// Whether a dialog of ours is open, which keeps the rest of the window from the keyboard.
    pub fn is_browsing(&self) -> bool {
        self.browser.is_some()
    }

    /// Asks for a file, starting in `folder` with the name `name`. One dialog at a time.
    pub fn ask(&mut self, purpose: Purpose, folder: &Path, name: &str, ctx: &Context) {
        if self.system.is_some() || self.browser.is_some() {
            return;
        }
        if self.use_system
            && let Some(answer) = open_system_dialog(purpose, folder, name, ctx)
        {
            self.system = Some(SystemDialog {
                purpose,
                answer,
                folder: folder.into(),
                name: name.into(),
            });
        } else {
            self.browse(purpose, folder, name);
        }
    }

    fn browse(&mut self, purpose: Purpose, folder: &Path, name: &str) {
        self.browser = Some((purpose, FileBrowser::new(purpose.kind(), folder, name)));
    }

    /// Shows our dialog and looks for the system's answer. `Some(file)` when chosen; `Some(None)` when cancelled.
    pub fn show(&mut self, ctx: &Context) -> Option<(Purpose, Option<PathBuf>)> {
        self.poll_system().or_else(|| self.show_browser(ctx))
    }

    fn poll_system(&mut self) -> Option<(Purpose, Option<PathBuf>)> {
        let dialog = self.system.as_ref()?;
        let (answer, open_for) = match dialog.answer.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(answer) => answer,
            Err(TryRecvError::Disconnected) => (None, Duration::ZERO),
        };
        let dialog = self.system.take()?;
        let purpose = dialog.purpose;
        let Some(path) = answer else {
            if open_for < NEVER_OPENED {
                self.browse(purpose, &dialog.folder, &dialog.name);
                return None;
            }
            return Some((purpose, None));
        };
        let kind = purpose.kind();
        let whole = match kind.saving {
            true => kind.complete(&path),
            false => path.clone(),
        };
        if whole != path && whole.exists() {
            // The system has asked about another name.
            let browser = FileBrowser::asking_to_replace(kind, whole);
            self.browser = Some((purpose, browser));
            return None;
        }
        Some((purpose, Some(whole)))
    }

    fn show_browser(&mut self, ctx: &Context) -> Option<(Purpose, Option<PathBuf>)> {
        let (purpose, browser) = self.browser.as_mut()?;
        let (purpose, browsed) = (*purpose, browser.show(ctx)?);
        self.browser = None;
        Some(match browsed {
            Browsed::Chosen(path) => (purpose, Some(path)),
            Browsed::Cancelled => (purpose, None),
        })
    }
}

/// The system's dialog, waited for on a thread of its own; `None` if there is no thread to be had.
fn open_system_dialog(
    purpose: Purpose,
    folder: &Path,
    name: &str,
    ctx: &Context,
) -> Option<Receiver<Answer>> {
    let kind = purpose.kind();
    // Made here, since macOS wants dialogs from the main thread; waited for elsewhere.
    let mut dialog = rfd::AsyncFileDialog::new()
        .set_title(kind.title)
        .add_filter(kind.name, kind.endings);
    if folder.is_dir() {
        dialog = dialog.set_directory(folder);
    }
    if !name.is_empty() {
        dialog = dialog.set_file_name(name);
    }
    let (sender, receiver) = channel();
    let ctx = ctx.clone();
    let opened = Instant::now();
    let wait = move |answer: Option<rfd::FileHandle>| {
        let path = answer.map(|file| file.path().to_path_buf());
        // Nobody listens any more when the window is closing.
        let _ = sender.send((path, opened.elapsed()));
        ctx.request_repaint();
    };
    let thread = std::thread::Builder::new().name("file dialog".into());
    let started = if kind.saving {
        let answer = dialog.save_file();
        thread.spawn(move || wait(pollster::block_on(answer)))
    } else {
        let answer = dialog.pick_file();
        thread.spawn(move || wait(pollster::block_on(answer)))
    };
    started.is_ok().then_some(receiver)
}
