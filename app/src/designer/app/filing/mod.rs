//! Everything between the document and the disk: opening, saving, recent files, settings, and what is kept in case the
//! program dies. Whatever goes wrong here is reported, and leaves the document as it is.

mod leaving;
mod opening;
mod saving;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::{Context, ThemePreference};
use renderer_core::design::CameraDesign;

use self::opening::Loaded;
use self::saving::Saving;
use crate::designer::Setup;
use crate::designer::app::App;
use crate::designer::app::layout::{PANELS_WIDTH, PRESETS_WIDTH};
use crate::designer::document::Document;
use crate::designer::document::autosave::Autosave;
use crate::designer::document::folders::Folders;
use crate::designer::document::settings::{Settings, ThemeChoice};
use crate::designer::shell::command::{Command, RecoveryChoice};
use crate::designer::shell::dialogs::Purpose;
use crate::designer::shell::questions::{Answer, Question};
use crate::designer::tasks::Task;
use crate::designer::widgets::UnitSystem;
use crate::files::{self, RecoveryFile};

/// The state of the designer's files.
pub struct Filing {
    /// What is remembered from one start to the next.
    pub settings: Settings,
    /// Settings as they were last written.
    written: Settings,
    pub(in crate::designer::app) folders: Option<Folders>,
    autosave: Option<Autosave>,
    recovery: Option<RecoveryFile>,
    loading: Option<Task<Loaded>>,
    /// The document's revision when a design was asked for that will replace it.
    replaces: Option<u64>,
    saving: Option<Saving>,
    /// What waits for an answer.
    pub question: Option<Question>,
    /// What waits for the answer to "save changes?".
    asked: Option<Command>,
    /// What to do once the design is saved.
    after_saving: Option<Command>,
}

impl Filing {
    /// Reads the settings; what went wrong is returned, to be reported.
    pub fn new(ctx: &Context, setup: &Setup) -> (Self, Option<String>) {
        let folders = setup.folders.clone();
        let (settings, failure) = match &folders {
            Some(folders) => Settings::load(&folders.config),
            None => (Settings::default(), None),
        };
        let state = folders.as_ref().map(|folders| &folders.state);
        let mut filing = Self {
            written: settings.clone(),
            settings,
            autosave: state.map(|state| Autosave::new(state.clone(), ctx)),
            recovery: state.and_then(|state| RecoveryFile::find(state)),
            folders,
            loading: None,
            replaces: None,
            saving: None,
            question: None,
            asked: None,
            after_saving: None,
        };
        filing.ask_about_recovery();
        filing.apply(ctx);
        (filing, failure)
    }

    fn apply(&self, ctx: &Context) {
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        ctx.set_zoom_factor(self.settings.scale as f32 / 100.0);
        ctx.set_theme(match self.settings.theme {
            ThemeChoice::System => ThemePreference::System,
            ThemeChoice::Dark => ThemePreference::Dark,
            ThemeChoice::Light => ThemePreference::Light,
        });
        self.settings.units.apply(ctx);
    }

    /// Whether a question stands before everything else.
    pub fn is_asking(&self) -> bool {
        self.asked.is_some() || self.question.is_some()
    }

    fn ask_about_recovery(&mut self) {
        let Some(recovery) = &self.recovery else {
            return;
        };
        let age = recovery.written().and_then(|then| then.elapsed().ok());
        let when = age.map_or_else(String::new, |age| format!(", kept {} ago", age_text(age)));
        let what = match recovery.read() {
            Ok(unsaved) => {
                let document = Document::recovered(unsaved);
                match document.path() {
                    Some(path) => format!("changes to {}", path.display()),
                    None => format!("the design “{}”", document.name()),
                }
            }
            Err(_) => "a design".into(),
        };
        let text = format!("Towel Designer ended without saving {what}{when}.");
        let answer = |choice| Command::Recovery(choice);
        let mut question = Question::new("Recover unsaved design?", text)
            .answer("Recover", answer(RecoveryChoice::Recover))
            .answer("Discard", answer(RecoveryChoice::Discard));
        question.otherwise = ("Later", Some(answer(RecoveryChoice::Later)));
        self.question = Some(question);
    }

    fn remember_folder(&mut self, purpose: &str, file: &Path) {
        if let Some(folder) = file.parent().filter(|folder| *folder != Path::new("")) {
            let folder = files::absolute(folder);
            self.settings.folders.insert(purpose.into(), folder);
        }
    }

    /// Notes how the panels are: how wide, and which are open. What is as at the first start is not noted, so that a
    /// later version may choose otherwise.
    pub fn remember_panels(&mut self, width: f32, open: &BTreeMap<String, bool>) {
        remember_width(&mut self.settings.panels_width, width, PANELS_WIDTH);
        if self.settings.open_panels != *open {
            self.settings.open_panels.clone_from(open);
        }
    }

    /// As [`Self::remember_panels`], of the width of the presets.
    pub fn remember_presets(&mut self, width: f32) {
        remember_width(&mut self.settings.presets_width, width, PRESETS_WIDTH);
    }

    /// Whether a file is being read.
    pub fn is_loading(&self) -> bool {
        self.loading.is_some()
    }

    /// The window takes the place of one that was lost, and has its unsaved document: what that kept is not offered.
    pub fn take_over(&mut self) {
        self.question = None;
        if let (Some(autosave), Some(recovery)) = (&mut self.autosave, self.recovery.take()) {
            autosave.replace(recovery);
        }
    }

    /// Writes settings that have changed.
    fn keep_settings(&mut self) {
        if self.settings == self.written {
            return;
        }
        self.written = self.settings.clone();
        if let (Some(autosave), Some(folders)) = (&mut self.autosave, &self.folders) {
            autosave.write(&folders.config.join(Settings::FILE), self.settings.text());
        }
    }
}

fn remember_width(kept: &mut Option<f32>, width: f32, first: f32) {
    // Half a point: layout rounds to pixels.
    if (width - kept.unwrap_or(first)).abs() > 0.5 {
        *kept = Some(width);
    }
}

/// As precise as it matters.
fn age_text(age: Duration) -> String {
    let (number, unit) = match age.as_secs() {
        0..120 => return "a moment".into(),
        seconds @ 120..7200 => (seconds / 60, "minutes"),
        seconds @ 7200..172_800 => (seconds / 3600, "hours"),
        seconds => (seconds / 86_400, "days"),
    };
    format!("{number} {unit}")
}

impl App {
    /// Shows a document, in the view that its file was saved in if there is one.
    fn set_document(&mut self, document: Document, view: Option<CameraDesign>) {
        if let Some(autosave) = &mut self.filing.autosave {
            autosave.forget();
        }
        self.document = document;
        match view {
            Some(view) => self.viewport.look_anew(view),
            None => self.look_first(),
        }
    }

    /// Where a dialog starts: the document's folder, else the one last used, else the user's.
    pub(in crate::designer::app) fn folder_for(&self, purpose: Purpose) -> PathBuf {
        let own = self.document.path().and_then(Path::parent);
        let last = self.filing.settings.folders.get(purpose.key());
        let last = last.map(PathBuf::as_path).filter(|last| last.is_dir());
        let folder = if purpose.has_own_folder() {
            last.or(own)
        } else {
            own.or(last)
        };
        let user = directories::UserDirs::new();
        let user = user.as_ref();
        let user = user.and_then(|user| user.document_dir().or(Some(user.home_dir())));
        match folder.filter(|folder| *folder != Path::new("")) {
            Some(folder) => folder.into(),
            // Who keeps nothing works where the program was started.
            None if self.filing.folders.is_none() => Path::new(".").into(),
            None => user.unwrap_or(Path::new(".")).into(),
        }
    }

    /// A file was chosen in a dialog.
    pub(in crate::designer::app) fn take_file(
        &mut self,
        ctx: &Context,
        purpose: Purpose,
        path: PathBuf,
    ) {
        match purpose {
            Purpose::OpenPreset => self.load_preset(ctx, &path),
            Purpose::OpenImage(slot) => self.load_image(ctx, slot, path),
            Purpose::SavePreset | Purpose::SaveBundle => self.save_chosen(ctx, path),
            Purpose::ExportPng | Purpose::ExportExr => {
                self.filing.remember_folder(purpose.key(), &path);
                self.start_export(ctx, path);
            }
        }
    }

    /// No file was chosen in a dialog.
    pub(in crate::designer::app) fn take_no_file(&mut self) {
        self.filing.after_saving = None;
    }

    pub(in crate::designer::app) fn set_scale(&mut self, ctx: &Context, percent: u32) {
        self.filing.settings.scale = percent;
        self.filing.apply(ctx);
    }

    pub(in crate::designer::app) fn set_theme(&mut self, ctx: &Context, theme: ThemeChoice) {
        self.filing.settings.theme = theme;
        self.filing.apply(ctx);
    }

    pub(in crate::designer::app) fn set_units(&mut self, ctx: &Context, units: UnitSystem) {
        self.filing.settings.units = units;
        self.filing.apply(ctx);
    }

    pub(in crate::designer::app) fn take_recovery(&mut self, choice: RecoveryChoice) {
        let Some(recovery) = self.filing.recovery.take() else {
            return;
        };
        match choice {
            RecoveryChoice::Later => {}
            RecoveryChoice::Discard => {
                recovery.discard();
                let folders = self.filing.folders.as_ref();
                self.filing.recovery = folders.and_then(|f| RecoveryFile::find(&f.state));
                self.filing.ask_about_recovery();
            }
            RecoveryChoice::Recover => match recovery.read() {
                Ok(mut unsaved) => {
                    let view = unsaved.design.view.current.take();
                    self.set_document(Document::recovered(unsaved), view);
                    if let Some(autosave) = &mut self.filing.autosave {
                        autosave.replace(recovery);
                    }
                }
                Err(error) => {
                    let place = match recovery.set_aside() {
                        Ok(place) => format!("It was kept as {}.", place.display()),
                        Err(error) => error.to_string(),
                    };
                    self.shell
                        .notices
                        .error("Not recovered", format!("{error}\n{place}"));
                }
            },
        }
    }

    /// Shows the question that is open, if any.
    pub(in crate::designer::app) fn ask_question(&mut self, ctx: &Context) {
        if let Some(question) = &mut self.filing.question
            && let Some(answer) = question.show(ctx)
        {
            self.filing.question = None;
            match answer {
                Answer::Do(command) => self.shell.commands.push(command),
                Answer::Leave => self.filing.after_saving = None,
            }
        }
    }

    /// Looks after everything that goes on by itself; to be called at the end of every frame.
    pub(in crate::designer::app) fn look_after_files(
        &mut self,
        ctx: &Context,
        gesture_goes_on: bool,
    ) {
        if let Some((path, error)) = self.presets.take_news(ctx, &mut self.thumbnails) {
            let folder = path.parent().unwrap_or(Path::new("")).display();
            let text = format!("{error}\nThe file is in {folder}.");
            self.shell.notices.error("The folder cannot be shown", text);
        }
        if let Some(autosave) = &mut self.filing.autosave {
            autosave.look(&self.document, &self.viewport.camera, gesture_goes_on);
            if let Some(failure) = autosave.take_failure() {
                self.shell.notices.error("Not kept", failure);
            }
        }
        if !gesture_goes_on {
            self.filing.keep_settings();
        }
    }
}
