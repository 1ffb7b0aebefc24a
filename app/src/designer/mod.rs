//! The designer: a window with the document's panels, the cloth rendered live, and the presets.
//!
//! ```text
//! panels ──edit──► Document ──Wish──► render thread ──pictures──► viewport
//!    └────────── Command ──► App: files, dialogs, camera, export
//! ```
//!
//! Panels edit the document and nothing else. What takes time happens on other threads: rendering
//! (`render_thread`), small pictures beside it (`small_pictures`), reading files (`tasks`), exporting (`export`), system
//! dialogs (`dialogs`). What commands do is in `work`.

mod bars;
pub mod camera_moves;
mod changes;
mod chart_editor;
mod command;
mod dialogs;
mod display_table;
mod document;
mod export;
mod filing;
pub mod first_picture;
mod folders;
mod help;
mod keeper;
mod keyboard_focus;
pub mod length_pictures;
mod live_light;
mod notices;
pub mod pace;
pub mod panels;
mod paste;
mod presets;
mod questions;
mod render_thread;
mod renderer;
mod reopen;
mod settings;
pub mod small_pictures;
mod status;
mod style;
mod tasks;
mod view_bar;
mod view_work;
mod viewport;
mod widgets;
mod work;
mod workers;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::anyhow;
use eframe::CreationContext;
use egui::{CentralPanel, Context, Frame, Margin, Panel, Ui, UiBuilder, ViewportCommand};
use renderer_core::gpu::{DeviceWatch, wanted_features};
use renderer_core::render::MAX_SIDE;

pub use command::Command;
pub use document::Document;
pub use folders::Folders;
pub use live_light::{CACHED_SHADOWS, LiveLight};
pub use render_thread::{Activity, Hurry, Shown, Wish};
pub use renderer::{MakeBackend, Shot, noise_left, softened};
pub use reopen::{Shelf, run};
pub use widgets::{Icon, label_of, shapes};

use crate::backend::BackendChoice;
use dialogs::Dialogs;
use export::Export;
use filing::Filing;
use keyboard_focus::KeyboardFocus;
use notices::Notices;
use panels::{Panels, Surroundings};
use presets::Presets;
use small_pictures::SmallPictures;
use viewport::Viewport;

/// Width beside the panels from which the presets stay while the chart editor is open, points.
const ROOM_FOR_PRESETS: f32 = 1100.0;
/// Width that is left to the cloth before the presets give way, points.
const ROOM_FOR_CLOTH: f32 = 280.0;
/// Width of the document's panels at the first start, points.
const PANELS_WIDTH: f32 = 356.0;
/// Width of the presets at the first start, points.
const PRESETS_WIDTH: f32 = 212.0;

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
    /// Where to keep what outlives the program; without, nothing is kept.
    pub folders: Option<Folders>,
}

/// The designer.
pub struct App {
    document: Document,
    viewport: Viewport,
    small_pictures: SmallPictures,
    panels: Panels,
    presets: Presets,
    filing: Filing,
    dialogs: Dialogs,
    export: Export,
    notices: Notices,
    make: MakeBackend,
    is_quitting: bool,
    /// Frames left to wait for what the clipboard was asked for.
    pasting: Option<u32>,
    help_is_open: bool,
    focus: KeyboardFocus,
    /// Whether the presets were shown in the last frame.
    has_presets: bool,
    /// Whether the cloth fills the window, without panels.
    is_alone: bool,
    title: String,
    commands: Vec<Command>,
    shelf: Shelf,
}

/// Opens a window of the designer's size with what `create` makes, and returns when it is closed.
///
/// # Errors
/// When no window can be opened, with what to install.
fn in_a_window(
    create: impl FnOnce(&CreationContext<'_>) -> Box<dyn eframe::App>,
) -> anyhow::Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("towel-designer")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([900.0, 560.0]),
        wgpu_options: wgpu_options(),
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(move |cc| Ok(create(cc)));
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
        required_features: wanted_features(adapter),
        required_limits: adapter.limits(),
        ..Default::default()
    });
    egui_wgpu::WgpuConfiguration {
        wgpu_setup: egui_wgpu::WgpuSetup::CreateNew(setup),
        ..Default::default()
    }
}

/// A window larger than its device's textures could not be drawn at all.
fn keep_to_textures(cc: &CreationContext<'_>) {
    let Some(state) = &cc.wgpu_render_state else {
        return;
    };
    let limit = state.device.limits().max_texture_dimension_2d;
    if limit < MAX_SIDE {
        let scale = cc.egui_ctx.native_pixels_per_point().unwrap_or(1.0);
        let most = egui::Vec2::splat(limit as f32 / scale);
        let command = ViewportCommand::MaxInnerSize(most);
        cc.egui_ctx.send_viewport_cmd(command);
    }
}

impl App {
    /// The designer in eframe's window (or a test's).
    pub fn new(cc: &CreationContext<'_>, setup: Setup) -> Self {
        let ctx = &cc.egui_ctx;
        style::apply(ctx);
        let (filing, failure) = Filing::new(ctx, &setup);
        let config = setup.folders.as_ref().map(|folders| &*folders.config);
        let mut app = Self {
            document: Document::default(),
            viewport: Viewport::new(Arc::clone(&setup.make), setup.choice, cc, config),
            small_pictures: SmallPictures::new(Arc::clone(&setup.make), ctx.clone()),
            panels: Panels::with_open(filing.settings.open_panels.clone()),
            presets: Presets::new(ctx, setup.folders.clone()),
            dialogs: Dialogs::new(setup.system_dialogs),
            export: Export::new(setup.choice),
            notices: Notices::default(),
            make: setup.make,
            filing,
            is_quitting: false,
            pasting: None,
            help_is_open: false,
            focus: KeyboardFocus::default(),
            has_presets: true,
            is_alone: false,
            title: String::new(),
            commands: Vec::new(),
            shelf: Shelf::default(),
        };
        if let Some(failure) = failure {
            app.notices.error("Settings not read", failure);
        }
        app.look_first();
        keep_to_textures(cc);
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
        if self.is_alone {
            CentralPanel::no_frame().show(ui, |ui| self.show_viewport(ui));
            return;
        }
        let mut commands = std::mem::take(&mut self.commands);
        Panel::top("menu").frame(bar).show(ui, |ui| {
            let settings = &self.filing.settings;
            let has_presets = self.has_presets;
            bars::menu(
                ui,
                &self.document,
                &self.viewport,
                settings,
                has_presets,
                &mut commands,
            );
        });
        Panel::top("toolbar")
            .frame(bar)
            .exact_size(32.0)
            .show(ui, |ui| {
                let has_presets = self.has_presets;
                bars::toolbar(
                    ui,
                    &self.document,
                    &self.viewport,
                    has_presets,
                    &mut commands,
                );
            });
        Panel::bottom("status").frame(bar).show(ui, |ui| {
            status::show(ui, &self.document.design, &self.viewport, &mut commands);
        });
        let faults = self.document.design.faults();
        let warnings = self.viewport.shown().warnings.clone();
        let mut step_name = None;
        let left = Panel::left("document")
            .frame(side)
            .resizable(true)
            .default_size(self.filing.settings.panels_width.unwrap_or(PANELS_WIDTH))
            .size_range(330.0..=520.0)
            .show(ui, |ui| {
                let mut around = Surroundings {
                    faults: &faults,
                    warnings: &warnings,
                    camera: &self.viewport.camera,
                    commands: &mut commands,
                    small_pictures: &mut self.small_pictures,
                    step_name: &mut step_name,
                    focus: &self.focus,
                };
                let design = &mut self.document.design;
                self.panels.show(ui, design, &mut around);
            });
        // In a small window the cloth, and the chart editor, need the room.
        let width = self.filing.settings.presets_width.unwrap_or(PRESETS_WIDTH);
        let has_room = if self.panels.chart_editor_is_open() {
            ui.available_width() > ROOM_FOR_PRESETS
        } else {
            ui.available_width() > width + ROOM_FOR_CLOTH
        };
        self.has_presets = self.filing.settings.shows_presets.unwrap_or(has_room);
        if self.has_presets {
            let right = Panel::right("presets")
                .frame(side)
                .resizable(true)
                .default_size(width)
                .size_range(150.0..=320.0)
                .show(ui, |ui| {
                    self.presets
                        .show(ui, self.document.path(), &self.focus, &mut commands);
                });
            self.filing.remember_presets(right.response.rect.width());
        }
        if self.panels.chart_editor_is_open() {
            let room = ui.available_width();
            Panel::left("chart editor")
                .frame(side.inner_margin(Margin::symmetric(8, 6)))
                .resizable(true)
                .default_size((room * 0.6).max((room - 80.0).min(320.0)).floor())
                .size_range(room.min(320.0) * 0.7..=(room - 80.0).max(241.0))
                .show(ui, |ui| {
                    let design = &mut self.document.design;
                    let named = self.panels.show_chart_editor(ui, design);
                    step_name = named.or(step_name.take());
                });
        }
        if let Some(name) = step_name {
            self.document.name_step(name);
        }
        let width = left.response.rect.width();
        self.filing.remember_panels(width, &self.panels.open);
        self.commands = commands;
        CentralPanel::no_frame().show(ui, |ui| self.show_viewport(ui));
    }

    fn show_viewport(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        // The panels may just have changed the design.
        let faults = self.document.design.faults();
        let design = &self.document.design;
        let tried_out = self.panels.chart_preview(&design.chart).map(|pixels| {
            let mut design = design.clone();
            design.chart.pixels = Some(pixels.clone());
            design
        });
        let design = tried_out.as_ref().unwrap_or(design);
        self.viewport.shows_net = self.panels.form_is_open();
        self.viewport
            .show(ui, design, faults.is_empty(), &mut self.commands);
        let messages = UiBuilder::new().max_rect(rect.shrink2(egui::vec2(12.0, 8.0)));
        ui.scope_builder(messages, |ui| {
            if let Some(fault) = faults.first() {
                let text = format!("{fault}. The picture shows the last state without faults.");
                notices::show_standing(ui, "The design has a fault", &text);
            }
            let shown = self.viewport.shown();
            if let Some(error) = &shown.error {
                notices::show_standing(ui, "Not rendered", error);
            }
            if let Some(why) = &shown.instead {
                notices::show_standing(ui, "Rendered by the processor", why);
            }
            self.commands.extend(self.notices.show(ui));
        });
    }
}

impl App {
    /// Takes what the render thread has to show and to tell.
    fn take_pictures(&mut self, ctx: &Context) {
        if let Some(news) = self.viewport.take_news(ctx) {
            self.notices.error("The GPU stopped", news);
        }
        let refused = self.viewport.watch().and_then(DeviceWatch::take_refused);
        if let Some(refused) = refused {
            let text =
                format!("{refused}\nWhat is seen may be incomplete; the design is unharmed.");
            self.notices
                .error("The graphics device refused something", text);
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        tracing::trace!("frame");
        if self.is_lost(&ctx) {
            return;
        }
        self.focus.follow(&ctx);
        self.close_requested(&ctx);
        self.take_pictures(&ctx);
        self.small_pictures.give_way(self.viewport.shown().hurry());
        self.take_loaded();
        self.take_saved(&ctx, std::time::Duration::ZERO);
        self.take_dropped_files(&ctx);
        self.take_pasted(&ctx);
        let is_asking = self.dialogs.is_browsing() || self.filing.is_asking();
        if !is_asking {
            command::take_shortcuts(&ctx, &mut self.commands);
            self.leave_alone(&ctx);
            self.close_by_escape(&ctx);
        }
        self.lay_out(ui);
        self.take_export(&ctx);
        self.take_dialog(&ctx);
        self.ask_to_save(&ctx);
        self.ask_question(&ctx);
        help::show(&ctx, &mut self.help_is_open);
        self.store_view_settings();
        if !self.commands.is_empty() {
            // What they do shows in the next frame.
            ctx.request_repaint();
        }
        if self.is_typing_finished(&ctx) {
            for command in std::mem::take(&mut self.commands) {
                self.perform(&ctx, command);
            }
        }
        let gesture_goes_on = ctx.text_edit_focused()
            || ctx.input(|i| i.pointer.any_down() || !i.keys_down.is_empty());
        self.document.settle(gesture_goes_on);
        self.look_after_files(&ctx, gesture_goes_on);
        self.set_title(&ctx);
        self.focus.ring(&ctx);
    }
}
