//! The designer: a window with the document's panels, the cloth rendered live, and the presets.
//!
//! ```text
//! panels ──edit──► Document ──Wish──► render thread ──pictures──► viewport
//!    └────────── Command ──► App: files, dialogs, camera, export
//! ```
//!
//! Panels edit the document and nothing else. What takes time happens on other threads: rendering
//! ([`render_thread`]), reading files ([`tasks`]), exporting ([`export`]), system dialogs ([`dialogs`]).

mod bars;
pub mod camera_moves;
mod changes;
mod command;
mod dialogs;
mod display_table;
mod document;
mod export;
mod help;
mod notices;
pub mod panels;
mod preset_list;
mod render_thread;
mod renderer;
mod style;
mod tasks;
mod viewport;
mod widgets;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::anyhow;
use eframe::CreationContext;
use egui::{
    CentralPanel, Context, Frame, Id, Margin, Modal, Panel, Ui, UiBuilder, ViewportCommand,
};
use renderer_core::design::{ChartImage, Design};

pub use command::Command;
pub use document::Document;
pub use render_thread::{Shown, Wish};
pub use renderer::{MakeBackend, Shot};
pub use widgets::label_of;

use crate::backend::{self, BackendChoice};
use crate::files::{self, FileError};
use dialogs::{Dialogs, Purpose};
use export::{Event, Export};
use notices::Notices;
use panels::{Panels, Surroundings};
use preset_list::PresetList;
use tasks::{Poll, Task};
use viewport::Viewport;

/// What the designer starts with.
pub struct Setup {
    /// Preset to open.
    pub preset: Option<PathBuf>,
    /// Backend to render with.
    pub choice: BackendChoice,
    /// How backends are made.
    pub make: MakeBackend,
    /// Whether to try the system's file dialogs before our own.
    pub system_dialogs: bool,
}

/// The designer.
pub struct App {
    document: Document,
    viewport: Viewport,
    panels: Panels,
    presets: PresetList,
    dialogs: Dialogs,
    export: Export,
    notices: Notices,
    make: MakeBackend,
    loading: Option<Task<Loaded>>,
    /// What waits for the answer to "save changes?".
    asked: Option<Command>,
    /// What to do once the design is saved.
    after_saving: Option<Command>,
    is_quitting: bool,
    help_is_open: bool,
    title: String,
    commands: Vec<Command>,
}

/// A file that was read on another thread.
enum Loaded {
    Preset(PathBuf, Result<Box<Design>, FileError>),
    Chart(PathBuf, Result<ChartImage, FileError>),
}

/// Opens the designer's window and returns when it is closed.
///
/// # Errors
/// When no window can be opened, with what to install.
pub fn run(preset: Option<PathBuf>, choice: BackendChoice) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("towel-designer")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([900.0, 560.0]),
        wgpu_options: wgpu_options(),
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        let setup = Setup {
            preset,
            choice,
            make: Arc::new(backend::make),
            system_dialogs: true,
        };
        Ok(Box::new(App::new(cc, setup)))
    });
    eframe::run_native("Towel Designer", options, create).map_err(|error| {
        anyhow!(
            "the window cannot be opened: {error}; without a display use `towel-designer render`, and on Debian and \
             Ubuntu install mesa-vulkan-drivers, libxkbcommon-x11-0, libxcursor1 and libxi6"
        )
    })
}

/// eframe's device with the adapter's own limits: egui-wgpu would ask for 8192 pixels of texture whatever there is.
fn wgpu_options() -> egui_wgpu::WgpuConfiguration {
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("designer"),
        required_limits: adapter.limits(),
        ..Default::default()
    });
    egui_wgpu::WgpuConfiguration {
        wgpu_setup: egui_wgpu::WgpuSetup::CreateNew(setup),
        ..Default::default()
    }
}

impl App {
    /// The designer in eframe's window (or a test's).
    pub fn new(cc: &CreationContext<'_>, setup: Setup) -> Self {
        let ctx = &cc.egui_ctx;
        style::apply(ctx);
        let mut app = Self {
            document: Document::default(),
            viewport: Viewport::new(Arc::clone(&setup.make), setup.choice, cc),
            panels: Panels::default(),
            presets: PresetList::new(ctx),
            dialogs: Dialogs::new(setup.system_dialogs),
            export: Export::new(setup.choice),
            notices: Notices::default(),
            make: setup.make,
            loading: None,
            asked: None,
            after_saving: None,
            is_quitting: false,
            help_is_open: false,
            title: String::new(),
            commands: Vec::new(),
        };
        app.look_first();
        if let Some(preset) = setup.preset {
            app.load_preset(ctx, preset);
        }
        app
    }

    /// The document.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The viewport: camera, what was asked of the renderer, what it shows.
    pub fn viewport(&self) -> &Viewport {
        &self.viewport
    }

    /// Looks through the design's first camera, the one a file opens with.
    fn look_first(&mut self) {
        if let Some(camera) = self.document.design.view.cameras.first() {
            self.viewport.camera = camera.clone();
        }
    }

    fn perform(&mut self, ctx: &Context, command: Command) {
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
            Command::Look(camera) => self.viewport.camera = camera,
            Command::Standard(view) => {
                let design = &self.document.design;
                self.viewport.look_standard(view, design);
            }
            Command::Fit => self.viewport.fit(&self.document.design),
            Command::Backend(choice) => self.viewport.choice = choice,
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
        match files::save_design(design, &path, self.document.path()) {
            Ok(_) => {
                let saved = design.clone();
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

    fn load_preset(&mut self, ctx: &Context, path: PathBuf) {
        self.loading = Some(Task::start(ctx, move || {
            let design = files::load_design(&path).map(Box::new);
            Loaded::Preset(path, design)
        }));
    }

    fn load_chart(&mut self, ctx: &Context, path: PathBuf) {
        self.loading = Some(Task::start(ctx, move || {
            let path = std::path::absolute(&path).unwrap_or(path);
            let chart = files::load_chart(&path);
            Loaded::Chart(path, chart)
        }));
    }

    fn take_loaded(&mut self) {
        let Some(task) = &self.loading else { return };
        match task.poll() {
            Poll::Pending => return,
            Poll::Lost => self
                .notices
                .error("Not opened", "The file could not be read to its end."),
            Poll::Ready(Loaded::Preset(path, Ok(design))) => {
                self.document = Document::new(*design, Some(path));
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
        }
        self.loading = None;
    }

    fn take_dialog(&mut self, ctx: &Context) {
        let Some((purpose, path)) = self.dialogs.show(ctx) else {
            return;
        };
        match (purpose, path) {
            (Purpose::OpenPreset, Some(path)) => self.load_preset(ctx, path),
            (Purpose::OpenChart, Some(path)) => self.load_chart(ctx, path),
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

    fn take_export(&mut self, ctx: &Context) {
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

    fn take_dropped_files(&mut self, ctx: &Context) {
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
                _ => self.notices.error(
                    "Not opened",
                    format!(
                        "{}: drop a preset (.toml) or a chart image (.png, .jpg).",
                        path.display()
                    ),
                ),
            }
        }
    }

    /// The question whether to save, while there is something to lose.
    fn ask_to_save(&mut self, ctx: &Context) {
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
    fn is_typing_finished(&self, ctx: &Context) -> bool {
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

    fn close_requested(&mut self, ctx: &Context) {
        let requested = ctx.input(|i| i.viewport().close_requested());
        if requested && !self.is_quitting && self.document.is_unsaved() {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.asked = Some(Command::Quit);
        }
    }

    fn set_title(&mut self, ctx: &Context) {
        let mark = if self.document.is_unsaved() { "*" } else { "" };
        let title = format!("{}{mark} - Towel Designer", self.document.name());
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn lay_out(&mut self, ui: &mut Ui) {
        let bar = |visuals: &egui::Visuals| {
            Frame::new()
                .fill(visuals.panel_fill)
                .inner_margin(Margin::symmetric(8, 3))
        };
        let bar = bar(ui.visuals());
        let side = bar.inner_margin(Margin {
            left: 10,
            right: 4,
            top: 6,
            bottom: 0,
        });
        let mut commands = std::mem::take(&mut self.commands);
        Panel::top("menu").frame(bar).show(ui, |ui| {
            bars::menu(ui, &self.document, &self.viewport, &mut commands);
        });
        Panel::top("toolbar")
            .frame(bar)
            .exact_size(32.0)
            .show(ui, |ui| {
                bars::toolbar(ui, &self.document, &mut commands);
            });
        Panel::bottom("status").frame(bar).show(ui, |ui| {
            bars::status(ui, &self.viewport, &mut commands);
        });
        let faults = self.document.design.faults();
        let warnings = self.document.design.warnings();
        Panel::left("document")
            .frame(side)
            .resizable(true)
            .default_size(356.0)
            .size_range(330.0..=520.0)
            .show(ui, |ui| {
                let mut around = Surroundings {
                    faults: &faults,
                    warnings: &warnings,
                    camera: &self.viewport.camera,
                    commands: &mut commands,
                };
                let design = &mut self.document.design;
                self.panels.show(ui, design, &mut around);
            });
        Panel::right("presets")
            .frame(side)
            .resizable(true)
            .default_size(186.0)
            .size_range(140.0..=320.0)
            .show(ui, |ui| {
                self.presets.show(ui, self.document.path(), &mut commands);
            });
        CentralPanel::no_frame().show(ui, |ui| self.show_viewport(ui));
        self.commands = commands;
    }

    fn show_viewport(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        // The panels may just have changed the design.
        let faults = self.document.design.faults();
        let design = &self.document.design;
        self.viewport.show(ui, design, faults.is_empty());
        let messages = UiBuilder::new().max_rect(rect.shrink2(egui::vec2(12.0, 8.0)));
        ui.scope_builder(messages, |ui| {
            if let Some(fault) = faults.first() {
                let text = format!("{fault}. The picture shows the last state without faults.");
                notices::show_standing(ui, "The design has a fault", &text);
            }
            if let Some(error) = &self.viewport.shown().error {
                notices::show_standing(ui, "Not rendered", error);
            }
            self.notices.show(ui);
        });
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

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.close_requested(&ctx);
        self.viewport.take_news(&ctx);
        self.take_loaded();
        self.take_dropped_files(&ctx);
        let is_asking = self.dialogs.is_browsing() || self.asked.is_some();
        if !is_asking {
            command::take_shortcuts(&ctx, &mut self.commands);
        }
        self.lay_out(ui);
        self.take_export(&ctx);
        self.take_dialog(&ctx);
        self.ask_to_save(&ctx);
        help::show(&ctx, &mut self.help_is_open);
        if self.is_typing_finished(&ctx) {
            for command in std::mem::take(&mut self.commands) {
                self.perform(&ctx, command);
            }
        }
        let gesture_goes_on = ctx.text_edit_focused()
            || ctx.input(|i| i.pointer.any_down() || !i.keys_down.is_empty());
        self.document.settle(gesture_goes_on);
        self.set_title(&ctx);
    }
}
