//! What gives the document up (a new one, another file, the end of the program), and the question whether to save it
//! first.

use egui::{Context, ViewportCommand};

use crate::designer::app::App;
use crate::designer::document::Document;
use crate::designer::shell::command::Command;
use crate::designer::shell::dialogs::Purpose;
use crate::designer::widgets::style;

impl App {
    /// Does what gives the document up, after asking whether to save it first.
    pub(in crate::designer::app) fn give_up_document(&mut self, ctx: &Context, command: Command) {
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
                self.set_document(Document::default(), None);
            }
            Command::Start(design) => {
                self.set_document(Document::new(*design, None), None);
            }
            Command::Open => {
                let folder = self.folder_for(Purpose::OpenPreset);
                self.shell
                    .dialogs
                    .ask(Purpose::OpenPreset, &folder, "", ctx);
            }
            Command::OpenPreset(path) => self.load_preset(ctx, &path),
            Command::OpenShipped(name) => self.load_shipped(ctx, name),
            Command::Quit => {
                self.window.is_quitting = true;
                if let Some(autosave) = &mut self.filing.autosave {
                    autosave.forget();
                }
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            other => self.perform(ctx, other),
        }
    }

    /// The question whether to save, while there is something to lose.
    pub(in crate::designer::app) fn ask_to_save(&mut self, ctx: &Context) {
        if self.filing.asked.is_none() {
            return;
        }
        let text = format!("{} has changes that are in no file.", self.document.name());
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("save changes"))
            .frame(style::dialog(ctx))
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

    pub(in crate::designer::app) fn close_requested(&mut self, ctx: &Context) {
        let requested = ctx.input(|i| i.viewport().close_requested());
        if requested && !self.window.is_quitting {
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
