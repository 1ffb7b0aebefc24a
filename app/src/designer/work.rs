//! Carries out commands: files and their dialogs, the question about unsaved changes, leaving.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Context, Id, Modal, ViewportCommand};
use renderer_core::design::EnvironmentKind;

use super::command::Command;
use super::dialogs::Purpose;
use super::document::Document;
use super::export::{Event, Export};
use super::tasks::{Poll, Task};
use super::{App, Loaded, style};
use crate::files::{self, Carried};

impl App {
    /// Looks through the design's first camera, the one a file opens with.
    pub(super) fn look_first(&mut self) {
        if let Some(camera) = self.document.design.view.cameras.first() {
            self.viewport.camera = camera.clone();
        }
    }

    pub(super) fn perform(&mut self, ctx: &Context, command: Command) {
        match command {
            Command::New | Command::Open | Command::OpenPreset(_) | Command::Quit
                if self.document.is_unsaved() =>
            {
                self.asked = Some(command);
            }
            Command::New | Command::Open | Command::OpenPreset(_) | Command::Quit => {
                self.replace_document(ctx, command);
            }
            Command::Save => match self.document.path() {
                Some(path) => self.save(ctx, path.to_path_buf()),
                None => self.ask_where_to_save(ctx),
            },
            Command::SaveAs => self.ask_where_to_save(ctx),
            Command::Export => {
                let design = &self.document.design;
                self.export.open(design, self.viewport.size());
            }
            Command::Undo => self.document.undo(),
            Command::Redo => self.document.redo(),
            Command::OpenChart => {
                let folder = self.folder();
                self.dialogs.ask(Purpose::OpenChart, &folder, "", ctx);
            }
            Command::UseChart(path) => self.load_chart(ctx, path),
            Command::PasteChart => self.ask_to_paste(ctx),
            Command::EditChart => self.panels.toggle_chart_editor(),
            Command::OpenEnvironment => {
                let folder = self.folder();
                self.dialogs.ask(Purpose::OpenEnvironment, &folder, "", ctx);
            }
            Command::UseEnvironment(path) => self.load_environment(ctx, path),
            Command::Look(camera) => self.viewport.camera = camera,
            Command::Standard(view) => {
                let design = &self.document.design;
                self.viewport.look_standard(view, design);
            }
            Command::Fit => self.viewport.fit(&self.document.design),
            Command::Backend(choice) => self.viewport.choose(choice),
            Command::LiveLight(light) => self.viewport.light = light,
            Command::View(command) => self.perform_view(ctx, command),
            Command::Help => self.help_is_open = !self.help_is_open,
        }
    }

    /// Does what gives the document up, without asking.
    fn replace_document(&mut self, ctx: &Context, command: Command) {
        match command {
            Command::New => {
                self.document = Document::default();
                self.look_first();
            }
            Command::Open => {
                let folder = self.folder();
                self.dialogs.ask(Purpose::OpenPreset, &folder, "", ctx);
            }
            Command::OpenPreset(path) => self.load_preset(ctx, path),
            Command::Quit => {
                self.is_quitting = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            _ => {}
        }
    }

    /// Where dialogs start: the document's folder, else that of the presets.
    fn folder(&self) -> PathBuf {
        let own = self.document.path().and_then(Path::parent);
        own.or(self.presets.folder())
            .unwrap_or(Path::new("."))
            .into()
    }

    fn ask_where_to_save(&mut self, ctx: &Context) {
        let name = format!("{}.toml", self.document.name());
        // A design without a file starts where the user is, not among the presets.
        let folder = self.document.path().and_then(Path::parent);
        let folder = folder.unwrap_or(Path::new(".")).to_path_buf();
        self.dialogs.ask(Purpose::SavePreset, &folder, &name, ctx);
    }

    fn save(&mut self, ctx: &Context, path: PathBuf) {
        self.document.settle(false);
        let design = &self.document.design;
        if let Some(fault) = design.faults().first() {
            self.after_saving = None;
            let why = "A file with a fault could not be opened again; mend it first.";
            self.notices.error("Not saved", format!("{fault}. {why}"));
            return;
        }
        let own_chart = self.document.own_chart.as_ref();
        let carried = Carried::default();
        match files::save_edited(design, &carried, &path, self.document.path(), own_chart) {
            Ok(own_chart) => {
                let saved = design.clone();
                self.document.own_chart = own_chart;
                self.notices.news("Saved", path.display().to_string());
                self.document.mark_saved(path, saved);
                if let Some(command) = self.after_saving.take() {
                    self.replace_document(ctx, command);
                }
            }
            Err(error) => {
                self.after_saving = None;
                self.notices
                    .error("Not saved", format!("{error}\nSave to another place."));
            }
        }
    }

    pub(super) fn load_preset(&mut self, ctx: &Context, path: PathBuf) {
        self.loading = Some(Task::start(ctx, move || {
            let opened = files::open_to_edit(&path).map(Box::new);
            Loaded::Preset(path, opened)
        }));
    }

    fn load_chart(&mut self, ctx: &Context, path: PathBuf) {
        self.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let chart = files::load_chart(&path);
            Loaded::Chart(path, chart)
        }));
    }

    fn load_environment(&mut self, ctx: &Context, path: PathBuf) {
        self.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let image = files::load_environment(&path);
            Loaded::Environment(path, image)
        }));
    }

    pub(super) fn take_loaded(&mut self) {
        let Some(task) = &self.loading else { return };
        match task.poll() {
            Poll::Pending => return,
            Poll::Lost => self
                .notices
                .error("Not opened", "The file could not be read to its end."),
            Poll::Ready(Loaded::Preset(path, Ok(opened))) => {
                let (opened, own_chart) = *opened;
                self.document = Document::new(opened.design, Some(path));
                self.document.own_chart = own_chart;
                self.look_first();
            }
            Poll::Ready(Loaded::Preset(_, Err(error))) => {
                self.notices.error("Preset not opened", error.to_string());
            }
            Poll::Ready(Loaded::Chart(path, Ok(image))) => {
                let chart = &mut self.document.design.chart;
                chart.image = Some(path.to_string_lossy().into_owned());
                chart.pixels = Some(image);
            }
            Poll::Ready(Loaded::Chart(_, Err(error))) => {
                self.notices.error("Chart not opened", error.to_string());
            }
            Poll::Ready(Loaded::Environment(path, Ok(image))) => {
                let environment = &mut self.document.design.light.environment;
                environment.kind = EnvironmentKind::Image;
                environment.image = Some(path.to_string_lossy().into_owned());
                environment.pixels = Some(image);
            }
            Poll::Ready(Loaded::Environment(_, Err(error))) => {
                self.notices
                    .error("Surroundings not opened", error.to_string());
            }
        }
        self.loading = None;
    }

    pub(super) fn take_dialog(&mut self, ctx: &Context) {
        let Some((purpose, path)) = self.dialogs.show(ctx) else {
            return;
        };
        match (purpose, path) {
            (Purpose::OpenPreset, Some(path)) => self.load_preset(ctx, path),
            (Purpose::OpenChart, Some(path)) => self.load_chart(ctx, path),
            (Purpose::OpenEnvironment, Some(path)) => self.load_environment(ctx, path),
            (Purpose::SavePreset, Some(path)) => self.save(ctx, path),
            (Purpose::ExportPng, Some(path)) => {
                let design = self.document.design.clone();
                let make = Arc::clone(&self.make);
                self.export
                    .start(path, design, &self.viewport.camera, make, ctx);
            }
            (Purpose::SavePreset, None) => self.after_saving = None,
            (_, None) => {}
        }
    }

    pub(super) fn take_export(&mut self, ctx: &Context) {
        match self.export.show(ctx) {
            Some(Event::AskForFile) => {
                let name = Export::file_name(&self.document.name());
                let folder = self.document.path().and_then(Path::parent);
                let folder = folder.unwrap_or(Path::new(".")).to_path_buf();
                self.dialogs.ask(Purpose::ExportPng, &folder, &name, ctx);
            }
            Some(Event::Written(path)) => {
                self.notices.news("Exported", path.display().to_string());
            }
            Some(Event::Failed(path, error)) => {
                let text = format!("{}: {error}", path.display());
                self.notices.error("Not exported", text);
            }
            None => {}
        }
    }

    pub(super) fn take_dropped_files(&mut self, ctx: &Context) {
        let dropped = ctx.input(|i| {
            let files = i.raw.dropped_files.iter();
            files
                .map(|file| file.path().to_path_buf())
                .collect::<Vec<_>>()
        });
        for path in dropped {
            let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
            match ending.as_deref() {
                Some("toml") => self.commands.push(Command::OpenPreset(path)),
                Some("png" | "jpg" | "jpeg") => self.commands.push(Command::UseChart(path)),
                Some("hdr" | "exr") => self.commands.push(Command::UseEnvironment(path)),
                _ => self.notices.error(
                    "Not opened",
                    format!(
                        "{}: drop a preset (.toml), a chart image (.png, .jpg) or an image of the surroundings (.hdr, .exr).",
                        path.display()
                    ),
                ),
            }
        }
    }

    /// The question whether to save, while there is something to lose.
    pub(super) fn ask_to_save(&mut self, ctx: &Context) {
        if self.asked.is_none() {
            return;
        }
        let mut answer = None;
        let modal = Modal::new(Id::unique("save changes"))
            .frame(style::dialog(ctx))
            .show(ctx, |ui| {
                ui.set_width(340.0);
                ui.heading("Save changes?");
                ui.add_space(4.0);
                ui.label(format!(
                    "{} has changes that are in no file.",
                    self.document.name()
                ));
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
        let Some(command) = self.asked.take() else {
            return;
        };
        match answer {
            Answer::Save => {
                self.after_saving = Some(command);
                self.perform(ctx, Command::Save);
            }
            Answer::Discard => self.replace_document(ctx, command),
            Answer::Cancel => {}
        }
    }

    /// Whether commands can be carried out. What is being typed counts as soon as its field is left, so that "save"
    /// saves it: a field that is typed in is left first, and commands wait for the next frame.
    pub(super) fn is_typing_finished(&self, ctx: &Context) -> bool {
        let is_typing = !self.commands.is_empty() && ctx.text_edit_focused();
        if is_typing {
            ctx.memory_mut(|memory| {
                if let Some(field) = memory.focused() {
                    memory.surrender_focus(field);
                }
            });
            ctx.request_repaint();
        }
        !is_typing
    }

    pub(super) fn close_requested(&mut self, ctx: &Context) {
        let requested = ctx.input(|i| i.viewport().close_requested());
        if requested && !self.is_quitting && self.document.is_unsaved() {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.asked = Some(Command::Quit);
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
