//! The program's window: holds the document and everything that shows it, and runs a frame.
//!
//! Everything that changes more than one part of the window is here, one file each: what the window looks like
//! (`layout`), what commands do (`perform`, `view`, `preset_actions`, `paste`), files (`filing`), what becomes of the
//! document when the window is lost (`window_handoff`), and writing of all scripts (`system_fonts`, `character_map`).

mod character_map;
mod filing;
mod layout;
mod paste;
mod perform;
mod preset_actions;
mod system_fonts;
mod view;
mod window;
mod window_handoff;

use std::sync::Arc;
use std::time::Duration;

use eframe::CreationContext;
use egui::{Context, Ui, ViewportCommand};
use renderer_core::gpu::DeviceWatch;
use renderer_core::scene::ChartComposer;

pub use character_map::has_glyph;
pub use system_fonts::{use_fonts, use_system_fonts};
pub use window::{SMALLEST_WINDOW, in_a_window};
pub use window_handoff::{WindowHandoff, run};

use super::Setup;
use super::document::Document;
use super::export::Export;
use super::new_design::NewDesign;
use super::panels::Panels;
use super::presets::Presets;
use super::presets::thumbnails::ThumbnailRenderer;
use super::shell::Shell;
use super::shell::command::{self, Command};
use super::shell::dialogs::Dialogs;
use super::shell::help;
use super::viewport::Viewport;
use super::widgets::style;
use filing::Filing;

/// The designer.
pub struct App {
    document: Document,
    filing: Filing,
    viewport: Viewport,
    panels: Panels,
    presets: Presets,
    thumbnails: ThumbnailRenderer,
    composer: ChartComposer,
    export: Export,
    new_design: NewDesign,
    shell: Shell,
    window: WindowState,
}

/// The window itself, beside what it shows.
#[derive(Default)]
struct WindowState {
    /// The title that it was given last.
    title: String,
    /// Whether it is about to close.
    is_quitting: bool,
    /// Where it leaves its document if it is lost.
    handoff: WindowHandoff,
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
            viewport: Viewport::new(&setup, cc, config),
            panels: Panels::with_open(filing.settings.open_panels.clone()),
            presets: Presets::new(ctx, setup.folders.clone()),
            thumbnails: ThumbnailRenderer::new(Arc::clone(&setup.make), ctx.clone()),
            composer: ChartComposer::default(),
            new_design: NewDesign::default(),
            export: Export::new(setup.choice, setup.make, setup.denoiser),
            shell: Shell::new(Dialogs::new(setup.system_dialogs)),
            window: WindowState::default(),
            filing,
        };
        if let Some(failure) = failure {
            app.shell.notices.error("Settings not read", failure);
        }
        app.look_first();
        window::keep_to_textures(cc);
        window::note_drops(cc);
        if let Some(preset) = setup.preset {
            app.load_preset(ctx, &preset);
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

    /// The document, to be edited from outside.
    pub fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }

    /// Waits until neither the viewport's picture nor a thumbnail is drawn; false if one still is after `patience`.
    pub fn wait_for_rest(&self, patience: Duration) -> bool {
        self.viewport.wait_for_rest(patience) && self.thumbnails.wait_for_rest(patience)
    }

    /// Whether a file is being read.
    pub fn is_loading(&self) -> bool {
        self.filing.is_loading()
    }

    /// Whether the window is about to close.
    pub fn is_quitting(&self) -> bool {
        self.window.is_quitting
    }

    /// Closes the window, whatever is unsaved.
    pub fn quit(&mut self, ctx: &Context) {
        self.window.is_quitting = true;
        ctx.send_viewport_cmd(ViewportCommand::Close);
    }

    fn set_title(&mut self, ctx: &Context) {
        let mark = if self.document.is_unsaved() { "*" } else { "" };
        let title = format!("{}{mark} - Towel Designer", self.document.name());
        if title != self.window.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.window.title = title;
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
        self.shell.focus.follow(&ctx);
        self.close_requested(&ctx);
        self.take_results(&ctx);
        self.take_input(&ctx);
        self.lay_out(ui);
        self.show_windows(&ctx);
        self.carry_out_commands(&ctx);
        self.finish_frame(&ctx);
    }
}

/// The parts of a frame.
impl App {
    /// Takes what other threads have done.
    fn take_results(&mut self, ctx: &Context) {
        self.take_pictures(ctx);
        self.thumbnails.give_way(self.viewport.state().priority());
        self.take_loaded();
        self.take_saved(ctx, Duration::ZERO);
    }

    /// Takes what the render thread has to show and to report.
    fn take_pictures(&mut self, ctx: &Context) {
        if let Some(news) = self.viewport.take_news(ctx) {
            self.shell.notices.error(news.title, news.text);
        }
        let refused = self.viewport.watch().and_then(DeviceWatch::take_refused);
        if let Some(refused) = refused {
            let text =
                format!("{refused}\nWhat is seen may be incomplete; the design is unharmed.");
            self.shell
                .notices
                .error("The graphics device refused something", text);
        }
    }

    /// Takes what comes from outside the window's controls: files, the clipboard, keys that work everywhere.
    fn take_input(&mut self, ctx: &Context) {
        self.take_dropped_files(ctx);
        self.take_pasted(ctx);
        let is_asking = self.shell.dialogs.is_browsing() || self.filing.is_asking();
        if !is_asking {
            command::take_shortcuts(ctx, &mut self.shell.commands);
            self.leave_alone(ctx);
            self.close_by_escape(ctx);
        }
    }

    /// Shows what stands over the window: export, dialogs, questions, help.
    fn show_windows(&mut self, ctx: &Context) {
        self.take_export(ctx);
        if let Some(design) = self.new_design.show(ctx) {
            self.shell.commands.push(Command::Start(Box::new(design)));
        }
        self.take_dialog(ctx);
        self.ask_to_save(ctx);
        self.ask_question(ctx);
        help::show(ctx, &mut self.shell.help_is_open);
    }

    /// Does what was asked for in this frame, once nothing is being typed.
    fn carry_out_commands(&mut self, ctx: &Context) {
        if !self.shell.commands.is_empty() {
            // What they do shows in the next frame.
            ctx.request_repaint();
        }
        if self.is_typing_finished(ctx) {
            for command in std::mem::take(&mut self.shell.commands) {
                self.perform(ctx, command);
            }
        }
    }

    /// Notes in history, files and title what the frame has changed.
    fn finish_frame(&mut self, ctx: &Context) {
        self.store_view_settings();
        let gesture_goes_on = ctx.text_edit_focused()
            || ctx.input(|i| i.pointer.any_down() || !i.keys_down.is_empty());
        self.document.settle(gesture_goes_on);
        self.look_after_files(ctx, gesture_goes_on);
        self.set_title(ctx);
        self.shell.focus.ring(ctx);
    }
}
