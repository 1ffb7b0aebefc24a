//! Saving the design: on a thread, so that a bundle with a large chart does not hold the window up.

use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::Context;
use renderer_core::design::Design;

use crate::designer::app::App;
use crate::designer::shell::command::Command;
use crate::designer::shell::dialogs::Purpose;
use crate::designer::shell::questions::Question;
use crate::designer::tasks::{Poll, Task};
use crate::files::{self, FileError, KnownOutside, OwnImages, UsedFile, is_bundle};

/// How long saving may keep the window waiting, so that what is done at once is reported at once. What takes longer (a
/// bundle with a large chart) goes on beside editing.
const AT_ONCE: Duration = Duration::from_millis(150);

/// A file being written on another thread.
pub(super) struct Saving {
    task: Task<Result<OwnImages, FileError>>,
    path: PathBuf,
    design: Design,
    /// Whether the document goes on belonging to its old file.
    is_copy: bool,
}

impl App {
    pub(in crate::designer::app) fn ask_where_to_save(&mut self, ctx: &Context, purpose: Purpose) {
        let is_bundle =
            purpose == Purpose::SaveBundle || self.document.path().is_some_and(is_bundle);
        let ending = if is_bundle {
            files::BUNDLE_ENDING
        } else {
            "toml"
        };
        let name = format!("{}.{ending}", self.document.name());
        let folder = self.folder_for(purpose);
        self.shell.dialogs.ask(purpose, &folder, &name, ctx);
    }

    /// Saves to the document's own file; asks if another program has changed that.
    pub(in crate::designer::app) fn save_again(&mut self, ctx: &Context) {
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
    pub(super) fn save_chosen(&mut self, ctx: &Context, path: PathBuf) {
        self.filing
            .remember_folder(Purpose::SavePreset.key(), &path);
        if Some(path.as_path()) == self.document.path() && self.document.is_changed_outside() {
            self.save_again(ctx);
        } else {
            self.save(ctx, path);
        }
    }

    pub(in crate::designer::app) fn save(&mut self, ctx: &Context, path: PathBuf) {
        self.start_saving(ctx, path, false);
    }

    /// Writes the design to a file that does not become the document's.
    pub(in crate::designer::app) fn save_copy(&mut self, ctx: &Context, path: PathBuf) {
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
            self.shell
                .notices
                .error("Not saved", format!("{fault}. {why}"));
            return;
        }
        let path = files::absolute(&path);
        let output = UsedFile::new(&path, "the file to save to");
        if let Err(error) = files::check_apart(&self.document.image_files(), &[output]) {
            self.filing.after_saving = None;
            return self.shell.notices.error("Not saved", error.to_string());
        }
        let carried = self.document.carried().clone();
        let config = self.filing.folders.as_ref().map(|f| f.config.clone());
        let from = self.document.path().map(Path::to_path_buf);
        // What a copy's images are written to is no concern of the document's.
        let own_images = match is_copy {
            true => OwnImages::default(),
            false => self.document.own_images.clone(),
        };
        let (to, written) = (path.clone(), self.with_view(&design));
        let task = Task::start(ctx, move || {
            let from = from.as_deref();
            let saved = files::save_edited(&written, &carried, &to, from, &own_images);
            if let (Ok(_), Some(config)) = (&saved, config) {
                KnownOutside::note_saved(&config, &to);
            }
            saved
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
    pub(in crate::designer::app) fn take_saved(&mut self, ctx: &Context, patience: Duration) {
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
                self.shell
                    .notices
                    .news("Preset kept", path.display().to_string());
            }
            Ok(own_images) => {
                self.document.own_images = own_images;
                self.shell.notices.news("Saved", path.display().to_string());
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
                self.shell
                    .notices
                    .error("Not saved", format!("{error}\n{advice}"));
            }
        }
    }
}
