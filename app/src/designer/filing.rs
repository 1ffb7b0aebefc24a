//! Everything between the document and the disk: opening, saving, recent files, settings, and what is kept in case the
//! program dies. Whatever goes wrong here is told, and leaves the document as it is.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::{Context, ThemePreference, ViewportCommand};
use renderer_core::design::{ChartImage, Design, EnvironmentImage, EnvironmentKind};

use super::command::Command;
use super::dialogs::Purpose;
use super::document::Document;
use super::folders::Folders;
use super::keeper::Keeper;
use super::questions::Question;
use super::settings::{Settings, ThemeChoice};
use super::tasks::{Poll, Task};
use super::{App, PANELS_WIDTH, PRESETS_WIDTH, Setup};
use crate::files::{self, FileError, LeftBehind, Opened, OwnChart, Shipped, is_bundle};

/// How long saving may keep the window waiting, so that what is done at once is told at once. What takes longer (a bundle
/// with a large chart) goes on beside editing.
const AT_ONCE: Duration = Duration::from_millis(150);

/// A file that was read on another thread.
enum Loaded {
    Design(PathBuf, Result<Box<(Opened, Option<OwnChart>)>, FileError>),
    Chart(PathBuf, Result<ChartImage, FileError>),
    Environment(PathBuf, Result<EnvironmentImage, FileError>),
}

/// A file being written on another thread.
struct Saving {
    task: Task<Result<Option<OwnChart>, FileError>>,
    path: PathBuf,
    design: Design,
    /// Whether the document goes on belonging to its old file.
    is_copy: bool,
}

/// What to do with a design that was left behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftBehindChoice {
    /// Open it.
    Recover,
    /// Remove it.
    Discard,
    /// Leave it where it is; the next start asks again.
    Later,
}

/// The state of the designer's files.
pub struct Filing {
    /// What is remembered from one start to the next.
    pub settings: Settings,
    /// Settings as they were last written.
    written: Settings,
    pub(super) folders: Option<Folders>,
    keeper: Option<Keeper>,
    left_behind: Option<LeftBehind>,
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
    /// Reads the settings; what went wrong is returned to be told.
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
            keeper: state.map(|state| Keeper::new(state.clone(), ctx)),
            left_behind: state.and_then(|state| LeftBehind::find(state)),
            folders,
            loading: None,
            replaces: None,
            saving: None,
            question: None,
            asked: None,
            after_saving: None,
        };
        filing.ask_about_left_behind();
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
    }

    /// Whether a question stands before everything else.
    pub fn is_asking(&self) -> bool {
        self.asked.is_some() || self.question.is_some()
    }

    fn ask_about_left_behind(&mut self) {
        let Some(left_behind) = &self.left_behind else {
            return;
        };
        let age = left_behind.written().and_then(|then| then.elapsed().ok());
        let when = age.map_or_else(String::new, |age| format!(", kept {} ago", age_text(age)));
        let what = match left_behind.read() {
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
        let answer = |choice| Command::LeftBehind(choice);
        let mut question = Question::new("Recover unsaved design?", text)
            .answer("Recover", answer(LeftBehindChoice::Recover))
            .answer("Discard", answer(LeftBehindChoice::Discard));
        question.otherwise = ("Later", Some(answer(LeftBehindChoice::Later)));
        self.question = Some(question);
    }

    fn remember_folder(&mut self, purpose: &str, file: &Path) {
        if let Some(folder) = file.parent().filter(|folder| *folder != Path::new("")) {
            let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
            self.settings.folders.insert(purpose.into(), folder);
        }
    }

    /// Notes how the panels are: how wide, and which are open. What is as at the first start is not noted, so that a later
    /// version may choose otherwise.
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
        if let (Some(keeper), Some(left_behind)) = (&mut self.keeper, self.left_behind.take()) {
            keeper.replace(left_behind);
        }
    }

    /// Writes settings that have changed.
    fn keep_settings(&mut self) {
        if self.settings == self.written {
            return;
        }
        self.written = self.settings.clone();
        if let (Some(keeper), Some(folders)) = (&mut self.keeper, &self.folders) {
            keeper.write(&folders.config.join(Settings::FILE), self.settings.text());
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
    /// Does what gives the document up, after asking whether to save it first.
    pub(super) fn give_up_document(&mut self, ctx: &Context, command: Command) {
        if self.filing.saving.is_some() {
            self.filing.after_saving = Some(command);
        } else if self.document.is_unsaved() {
            self.filing.asked = Some(command);
        } else {
            self.replace_document(ctx, command);
        }
    }

    /// Does what gives the document up, without asking.
    fn replace_document(&mut self, ctx: &Context, command: Command) {
        match command {
            Command::New => {
                self.set_document(Document::default());
            }
            Command::Open => {
                let folder = self.folder_for(Purpose::OpenPreset);
                self.dialogs.ask(Purpose::OpenPreset, &folder, "", ctx);
            }
            Command::OpenPreset(path) => self.load_preset(ctx, path),
            Command::OpenShipped(name) => self.load_shipped(ctx, name),
            Command::Quit => {
                self.is_quitting = true;
                if let Some(keeper) = &mut self.filing.keeper {
                    keeper.forget();
                }
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            other => self.perform(ctx, other),
        }
    }

    fn set_document(&mut self, document: Document) {
        if let Some(keeper) = &mut self.filing.keeper {
            keeper.forget();
        }
        self.document = document;
        self.look_first();
    }

    /// Where a dialog starts: the document's folder, else the one last used, else the user's.
    pub(super) fn folder_for(&self, purpose: Purpose) -> PathBuf {
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

    pub(super) fn ask_where_to_save(&mut self, ctx: &Context, purpose: Purpose) {
        let is_bundle =
            purpose == Purpose::SaveBundle || self.document.path().is_some_and(is_bundle);
        let ending = if is_bundle {
            files::BUNDLE_ENDING
        } else {
            "toml"
        };
        let name = format!("{}.{ending}", self.document.name());
        let folder = self.folder_for(purpose);
        self.dialogs.ask(purpose, &folder, &name, ctx);
    }

    /// Saves to the document's own file; asks if another program has changed that.
    pub(super) fn save_again(&mut self, ctx: &Context) {
        let Some(path) = self.document.path().map(Path::to_path_buf) else {
            return self.ask_where_to_save(ctx, Purpose::SavePreset);
        };
        if !self.document.is_changed_outside() {
            return self.save(ctx, path);
        }
        let text = format!(
            "{} was changed by another program since it was opened here. Saving would undo those changes.",
            path.display()
        );
        let question = Question::new("Replace the changed file?", text)
            .answer("Replace", Command::SaveTo(path))
            .answer("Save as…", Command::SaveAs);
        self.filing.question = Some(question);
    }

    /// Saves to a file that was asked for.
    fn save_chosen(&mut self, ctx: &Context, path: PathBuf) {
        self.filing
            .remember_folder(Purpose::SavePreset.key(), &path);
        if Some(path.as_path()) == self.document.path() && self.document.is_changed_outside() {
            self.save_again(ctx);
        } else {
            self.save(ctx, path);
        }
    }

    pub(super) fn save(&mut self, ctx: &Context, path: PathBuf) {
        self.start_saving(ctx, path, false);
    }

    /// Writes the design to a file that does not become the document's.
    pub(super) fn save_copy(&mut self, ctx: &Context, path: PathBuf) {
        self.start_saving(ctx, path, true);
    }

    fn start_saving(&mut self, ctx: &Context, path: PathBuf, is_copy: bool) {
        self.document.settle(false);
        if self.filing.saving.is_some() {
            // Once more, when the disk is free.
            self.filing
                .after_saving
                .get_or_insert(Command::SaveTo(path));
            return;
        }
        let design = self.document.design.clone();
        if let Some(fault) = design.faults().first() {
            self.filing.after_saving = None;
            let why = "A file with a fault could not be opened again; mend it first.";
            self.notices.error("Not saved", format!("{fault}. {why}"));
            return;
        }
        let carried = self.document.carried().clone();
        let from = self.document.path().map(Path::to_path_buf);
        // What a copy's chart is written to is no concern of the document's.
        let own_chart = self.document.own_chart.clone().filter(|_| !is_copy);
        let (to, written) = (path.clone(), design.clone());
        let task = Task::start(ctx, move || {
            let from = from.as_deref();
            files::save_edited(&written, &carried, &to, from, own_chart.as_ref())
        });
        self.filing.saving = Some(Saving {
            task,
            path,
            design,
            is_copy,
        });
        self.take_saved(ctx, AT_ONCE);
    }

    /// Looks whether a file is written.
    pub(super) fn take_saved(&mut self, ctx: &Context, patience: Duration) {
        let Some(saving) = &self.filing.saving else {
            return;
        };
        let result = match saving.task.poll_for(patience) {
            Poll::Pending => return,
            Poll::Ready(result) => result.map_err(|error| error.to_string()),
            Poll::Lost => Err(format!(
                "{}: writing stopped unexpectedly.",
                saving.path.display()
            )),
        };
        let Some(saving) = self.filing.saving.take() else {
            return;
        };
        let Saving { path, design, .. } = saving;
        match result {
            Ok(_) if saving.is_copy => {
                self.presets.look_again();
                self.notices.news("Preset kept", path.display().to_string());
            }
            Ok(own_chart) => {
                self.document.own_chart = own_chart;
                self.notices.news("Saved", path.display().to_string());
                self.filing.settings.add_recent(&path);
                self.presets.look_again();
                self.document.mark_saved(path, design);
                if let Some(command) = self.filing.after_saving.take() {
                    self.perform(ctx, command);
                }
            }
            Err(error) => {
                self.filing.after_saving = None;
                let advice =
                    "The design is kept in the window. Save it to another place (File, Save as).";
                self.notices
                    .error("Not saved", format!("{error}\n{advice}"));
            }
        }
    }

    pub(super) fn load_preset(&mut self, ctx: &Context, path: PathBuf) {
        self.filing.replaces = Some(self.document.revision());
        self.filing.loading = Some(Task::start(ctx, move || {
            let opened = files::open_to_edit(&path).map(Box::new);
            Loaded::Design(path, opened)
        }));
    }

    fn load_shipped(&mut self, ctx: &Context, name: String) {
        let Some(shipped) = Shipped::named(&name) else {
            return;
        };
        self.filing.replaces = Some(self.document.revision());
        self.filing.loading = Some(Task::start(ctx, move || {
            let opened = shipped.open().map(|opened| Box::new((opened, None)));
            Loaded::Design(name.into(), opened)
        }));
    }

    pub(super) fn load_chart(&mut self, ctx: &Context, path: PathBuf) {
        self.filing.remember_folder(Purpose::OpenChart.key(), &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let chart = files::load_chart(&path);
            Loaded::Chart(path, chart)
        }));
    }

    pub(super) fn load_environment(&mut self, ctx: &Context, path: PathBuf) {
        let purpose = Purpose::OpenEnvironment.key();
        self.filing.remember_folder(purpose, &path);
        self.filing.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let image = files::load_environment(&path);
            Loaded::Environment(path, image)
        }));
    }

    pub(super) fn take_loaded(&mut self) {
        let Some(task) = &self.filing.loading else {
            return;
        };
        let loaded = match task.poll() {
            Poll::Pending => return,
            Poll::Lost => None,
            Poll::Ready(loaded) => Some(loaded),
        };
        self.filing.loading = None;
        match loaded {
            None => self
                .notices
                .error("Not opened", "The file could not be read to its end."),
            Some(Loaded::Design(path, Ok(opened))) => {
                let (opened, own_chart) = *opened;
                self.take_opened(path, opened, own_chart);
            }
            Some(Loaded::Design(path, Err(error))) => self.tell_not_opened(&path, &error),
            Some(Loaded::Chart(path, Ok(image))) => {
                let chart = &mut self.document.design.chart;
                chart.image = Some(path.to_string_lossy().into_owned());
                chart.pixels = Some(image);
            }
            Some(Loaded::Chart(_, Err(error))) => {
                self.notices.error("Chart not opened", error.to_string());
            }
            Some(Loaded::Environment(path, Ok(image))) => {
                let environment = &mut self.document.design.light.environment;
                environment.kind = EnvironmentKind::Image;
                environment.image = Some(path.to_string_lossy().into_owned());
                environment.pixels = Some(image);
            }
            Some(Loaded::Environment(_, Err(error))) => {
                self.notices
                    .error("Surroundings not opened", error.to_string());
            }
        }
    }

    fn take_opened(&mut self, path: PathBuf, opened: Opened, own_chart: Option<OwnChart>) {
        self.document.settle(false);
        if self.document.is_unsaved() && self.filing.replaces != Some(self.document.revision()) {
            // Edited while the file was read.
            self.filing.asked = Some(match opened.origin {
                files::Origin::Program => Command::OpenShipped(path.to_string_lossy().into_owned()),
                _ => Command::OpenPreset(path),
            });
            return;
        }
        if !opened.warnings.is_empty() {
            self.notices
                .error("Not everything was opened", opened.warnings.join("\n"));
        }
        if opened.origin != files::Origin::Program {
            self.filing.settings.add_recent(&path);
            self.filing
                .remember_folder(Purpose::OpenPreset.key(), &path);
        }
        self.set_document(Document::opened(opened, path));
        self.document.own_chart = own_chart;
    }

    fn tell_not_opened(&mut self, path: &Path, error: &FileError) {
        let recent = &mut self.filing.settings;
        let is_gone = matches!(error, FileError::Read { .. }) && !path.exists();
        if is_gone && recent.recent.iter().any(|recent| recent == path) {
            recent.remove_recent(path);
            let text = format!("{error}\nIt was taken off the list of recent files.");
            self.notices.error("Not opened", text);
        } else {
            self.notices.error("Preset not opened", error.to_string());
        }
    }

    /// A file was chosen in a dialog.
    pub(super) fn take_file(&mut self, ctx: &Context, purpose: Purpose, path: PathBuf) {
        match purpose {
            Purpose::OpenPreset => self.load_preset(ctx, path),
            Purpose::OpenChart => self.load_chart(ctx, path),
            Purpose::OpenEnvironment => self.load_environment(ctx, path),
            Purpose::SavePreset | Purpose::SaveBundle => self.save_chosen(ctx, path),
            Purpose::ExportPng | Purpose::ExportExr => {
                self.filing.remember_folder(purpose.key(), &path);
                self.start_export(ctx, path);
            }
        }
    }

    /// No file was chosen in a dialog.
    pub(super) fn take_no_file(&mut self) {
        self.filing.after_saving = None;
    }

    /// A file was dropped on the window.
    pub(super) fn take_dropped(&mut self, path: PathBuf) {
        if self.filing.is_asking() {
            let text = "Answer the question first, then drop the file again.";
            return self.notices.error("Not opened", text);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("toml" | files::BUNDLE_ENDING) => self.commands.push(Command::OpenPreset(path)),
            Some("png") if files::carries_design(&path) => {
                let name = path.file_name().unwrap_or(path.as_os_str());
                let text = format!(
                    "{} is a picture of a design, and carries that design.",
                    name.to_string_lossy()
                );
                self.filing.question = Some(
                    Question::new("Open its design?", text)
                        .answer("Open its design", Command::OpenPreset(path.clone()))
                        .answer("Use as chart", Command::UseChart(path)),
                );
            }
            Some("png" | "jpg" | "jpeg") => self.commands.push(Command::UseChart(path)),
            Some("hdr" | "exr") => self.commands.push(Command::UseEnvironment(path)),
            _ => self.notices.error(
                "Not opened",
                format!(
                    "{}: drop a design (.toml, .towel, or a .png exported here), a chart image (.png, .jpg) or an image of the surroundings (.hdr, .exr).",
                    path.display()
                ),
            ),
        }
    }

    pub(super) fn set_scale(&mut self, ctx: &Context, percent: u32) {
        self.filing.settings.scale = percent;
        self.filing.apply(ctx);
    }

    pub(super) fn set_theme(&mut self, ctx: &Context, theme: ThemeChoice) {
        self.filing.settings.theme = theme;
        self.filing.apply(ctx);
    }

    pub(super) fn take_left_behind(&mut self, choice: LeftBehindChoice) {
        let Some(left_behind) = self.filing.left_behind.take() else {
            return;
        };
        match choice {
            LeftBehindChoice::Later => {}
            LeftBehindChoice::Discard => {
                left_behind.discard();
                let folders = self.filing.folders.as_ref();
                self.filing.left_behind = folders.and_then(|f| LeftBehind::find(&f.state));
                self.filing.ask_about_left_behind();
            }
            LeftBehindChoice::Recover => match left_behind.read() {
                Ok(unsaved) => {
                    self.set_document(Document::recovered(unsaved));
                    if let Some(keeper) = &mut self.filing.keeper {
                        keeper.replace(left_behind);
                    }
                }
                Err(error) => {
                    let place = match left_behind.set_aside() {
                        Ok(place) => format!("It was kept as {}.", place.display()),
                        Err(error) => error.to_string(),
                    };
                    self.notices
                        .error("Not recovered", format!("{error}\n{place}"));
                }
            },
        }
    }

    /// Shows the question that is open, if any.
    pub(super) fn ask_question(&mut self, ctx: &Context) {
        if let Some(question) = &mut self.filing.question
            && let Some(answer) = question.show(ctx)
        {
            self.filing.question = None;
            match answer {
                Some(command) => self.commands.push(command),
                None => self.filing.after_saving = None,
            }
        }
    }

    /// Looks after everything that goes on by itself; to be called at the end of every frame.
    pub(super) fn look_after_files(&mut self, ctx: &Context, gesture_goes_on: bool) {
        if let Some((path, error)) = self.presets.take_news(ctx, &mut self.small_pictures) {
            let folder = path.parent().unwrap_or(Path::new("")).display();
            let text = format!("{error}\nThe file is in {folder}.");
            self.notices.error("The folder cannot be shown", text);
        }
        if let Some(keeper) = &mut self.filing.keeper {
            keeper.look(&self.document);
            if let Some(failure) = keeper.take_failure() {
                self.notices.error("Not kept", failure);
            }
        }
        if !gesture_goes_on {
            self.filing.keep_settings();
        }
    }

    /// The question whether to save, while there is something to lose.
    pub(super) fn ask_to_save(&mut self, ctx: &Context) {
        if self.filing.asked.is_none() {
            return;
        }
        let text = format!("{} has changes that are in no file.", self.document.name());
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("save changes"))
            .frame(super::style::dialog(ctx))
            .show(ctx, |ui| {
                ui.set_width(340.0);
                ui.heading("Save changes?");
                ui.add_space(4.0);
                ui.label(text);
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    for choice in [Answer::Save, Answer::Discard, Answer::Cancel] {
                        if ui.button(choice.name()).clicked() {
                            answer = Some(choice);
                        }
                    }
                });
            });
        if modal.should_close() && answer.is_none() {
            answer = Some(Answer::Cancel);
        }
        let Some(answer) = answer else { return };
        let Some(command) = self.filing.asked.take() else {
            return;
        };
        match answer {
            Answer::Save => {
                self.filing.after_saving = Some(command);
                self.perform(ctx, Command::Save);
            }
            Answer::Discard => self.replace_document(ctx, command),
            Answer::Cancel => {}
        }
    }

    pub(super) fn close_requested(&mut self, ctx: &Context) {
        let requested = ctx.input(|i| i.viewport().close_requested());
        if requested && !self.is_quitting {
            let is_busy = self.filing.saving.is_some();
            if is_busy || self.document.is_unsaved() {
                ctx.send_viewport_cmd(ViewportCommand::CancelClose);
                self.give_up_document(ctx, Command::Quit);
            }
        }
    }
}

/// Answers to "save changes?".
#[derive(Clone, Copy)]
enum Answer {
    Save,
    Discard,
    Cancel,
}

impl Answer {
    fn name(self) -> &'static str {
        match self {
            Self::Save => "Save changes",
            Self::Discard => "Discard changes",
            Self::Cancel => "Cancel",
        }
    }
}
