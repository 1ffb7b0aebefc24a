//! Carries out commands. What concerns files is in `filing`, presets in `preset_actions`, the view in
//! `view`.

use std::path::PathBuf;
use std::sync::Arc;

use egui::Context;
use renderer_core::design::Design;

use crate::designer::app::App;
use crate::designer::export::{Event, Subject};
use crate::designer::shell::command::Command;
use crate::designer::shell::dialogs::Purpose;
use crate::files::{self, UsedFile};

impl App {
    /// Looks through the design's first camera.
    pub(super) fn look_first(&mut self) {
        if let Some(camera) = self.document.design.view.cameras.first() {
            self.viewport.look_anew(camera.clone());
        }
    }

    /// A design as files are to hold it: with the view that one sees.
    pub(super) fn with_view(&self, design: &Design) -> Design {
        let mut design = design.clone();
        design.view.current = Some(self.viewport.camera.clone());
        design
    }

    pub(super) fn perform(&mut self, ctx: &Context, command: Command) {
        match command {
            Command::New
            | Command::Start(_)
            | Command::Open
            | Command::OpenPreset(_)
            | Command::OpenShipped(_)
            | Command::Quit => self.give_up_document(ctx, command),
            // Whether to save what it replaces was asked before.
            Command::OpenPresetWith(path, choice) => self.load_preset_with(ctx, &path, choice),
            Command::Save => self.save_again(ctx),
            Command::SaveAs => self.ask_where_to_save(ctx, Purpose::SavePreset),
            Command::SaveAsBundle => self.ask_where_to_save(ctx, Purpose::SaveBundle),
            Command::SaveTo(path) => self.save(ctx, path),
            Command::Recovery(choice) => self.take_recovery(choice),
            Command::Presets(command) => self.perform_preset(ctx, command),
            Command::Scale(percent) => self.set_scale(ctx, percent),
            Command::ScaleStep(step) => {
                let percent = self.filing.settings.next_scale(step);
                self.set_scale(ctx, percent);
            }
            Command::Theme(theme) => self.set_theme(ctx, theme),
            Command::Units(units) => self.set_units(ctx, units),
            Command::ShowPresets(shows) => self.filing.settings.shows_presets = Some(shows),
            Command::ClearRecent => self.filing.settings.recent.clear(),
            Command::Export => {
                let (design, viewport) = (&self.document.design, &self.viewport);
                let last = self.filing.settings.export;
                self.export
                    .open(design, &viewport.camera, last, viewport.size());
            }
            Command::AskForNew => self.new_design.is_open = true,
            Command::Undo => self.document.undo(),
            Command::Redo => self.document.redo(),
            Command::OpenImage(slot) => {
                let purpose = Purpose::OpenImage(slot);
                let folder = self.folder_for(purpose);
                self.shell.dialogs.ask(purpose, &folder, "", ctx);
            }
            Command::UseImage(slot, path) => self.load_image(ctx, slot, path),
            Command::AddPicture(path) => self.load_picture(ctx, path),
            Command::PasteChart => self.ask_to_paste(ctx),
            Command::EditChart => self.panels.toggle_chart_editor(),
            Command::MoveNetPoint { row, column, to } => {
                let net = &mut self.document.design.form.net;
                if let Some(point) = net.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *point = to;
                }
            }
            Command::Look(camera) => self.viewport.camera = camera,
            Command::Standard(view) => {
                let design = &self.document.design;
                self.viewport.look_standard(view, design);
            }
            Command::Fit => self.viewport.fit(&self.document.design),
            Command::Backend(choice) => self.viewport.choose(choice),
            Command::LiveLight(light) => self.viewport.light = light,
            Command::View(command) => self.perform_view(ctx, command),
            Command::Help => self.shell.help_is_open = !self.shell.help_is_open,
        }
    }

    pub(super) fn take_dialog(&mut self, ctx: &Context) {
        let Some((purpose, path)) = self.shell.dialogs.show(ctx) else {
            return;
        };
        match path {
            Some(path) => self.take_file(ctx, purpose, path),
            None => self.take_no_file(),
        }
    }

    pub(super) fn start_export(&mut self, ctx: &Context, path: PathBuf) {
        let document = &self.document;
        let output = UsedFile::new(&path, "the picture");
        if let Err(error) = files::check_apart(&document.files(), &[output]) {
            let text = error.to_string();
            return self.shell.notices.error("Not exported", text);
        }
        let camera = &self.viewport.camera;
        let carried = document.carried().clone();
        let subject = Subject {
            name: document.name(),
            design: self.with_view(&document.design),
            carried,
            camera: camera.clone(),
        };
        self.filing.settings.export = Some(self.export.settings());
        self.export.start(path, subject, ctx);
    }

    /// The document's design as the viewport shares it.
    fn shown_design(&self) -> Arc<Design> {
        let requested = self.viewport.requested().map(|requested| &requested.design);
        let shared = requested.filter(|design| ***design == self.document.design);
        shared.map_or_else(|| Arc::new(self.document.design.clone()), Arc::clone)
    }

    pub(super) fn take_export(&mut self, ctx: &Context) {
        let design = self.shown_design();
        match self.export.show(ctx, &design, &self.viewport.camera) {
            Some(Event::AskForFile(ending)) => {
                let purpose = match ending {
                    "exr" => Purpose::ExportExr,
                    _ => Purpose::ExportPng,
                };
                let folder = self.folder_for(purpose);
                let document = &self.document;
                let used = document.files();
                let name = files::picture_name(&document.name(), ending, &folder, &used);
                self.shell.dialogs.ask(purpose, &folder, &name, ctx);
            }
            Some(Event::Written(path, warnings)) => {
                let text = path.display().to_string();
                self.shell.notices.news_of_file("Exported", text, path);
                if !warnings.is_empty() {
                    let text = warnings.join("\n");
                    self.shell
                        .notices
                        .error("Exported without a part of the design", text);
                }
            }
            Some(Event::Failed(path, error)) => {
                let file = path.display().to_string();
                // Errors of files name them already.
                let text = match error.contains(&file) {
                    true => error,
                    false => format!("{file}: {error}"),
                };
                self.shell.notices.error("Not exported", text);
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
            self.take_dropped(path);
        }
    }

    /// Whether commands can be carried out. What is being typed counts as soon as its field is left, so that "save"
    /// saves it: a field that is typed in is left first, and commands wait for the next frame.
    pub(super) fn is_typing_finished(&self, ctx: &Context) -> bool {
        let is_typing = !self.shell.commands.is_empty() && ctx.text_edit_focused();
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
}
