//! What the window looks like: bars around, the document's panels left, the presets right, between them the cloth and,
//! beside it, the chart editor.

use egui::{CentralPanel, Frame, Margin, Panel, Ui, UiBuilder, Visuals};
use renderer_core::scene::costs;

use super::App;
use crate::designer::panels::Surroundings;
use crate::designer::shell::{bars, notices, status};

/// Width beside the panels from which the presets stay while the chart editor is open, points.
const ROOM_FOR_PRESETS: f32 = 1100.0;
/// Width that is left to the cloth before the presets give way, points.
const ROOM_FOR_CLOTH: f32 = 280.0;
/// Width of the document's panels at the first start, points.
pub const PANELS_WIDTH: f32 = 356.0;
/// Width of the presets at the first start, points.
pub const PRESETS_WIDTH: f32 = 212.0;

impl App {
    /// Shows everything that lies in the window itself, and takes what the user does there.
    pub(super) fn lay_out(&mut self, ui: &mut Ui) {
        if !self.shell.is_alone {
            let (bar, side) = (bar_frame(ui.visuals()), side_frame(ui.visuals()));
            self.show_bars(ui, bar);
            self.show_panels(ui, side);
            self.show_presets(ui, side);
            self.show_chart_editor(ui, side);
        }
        CentralPanel::no_frame().show(ui, |ui| self.show_viewport(ui));
    }

    fn show_bars(&mut self, ui: &mut Ui, frame: Frame) {
        let (document, viewport, has_presets) =
            (&self.document, &self.viewport, self.shell.has_presets);
        let export = self.export.under_way();
        let (settings, commands) = (&self.filing.settings, &mut self.shell.commands);
        Panel::top("menu").frame(frame).show(ui, |ui| {
            bars::menu(ui, document, viewport, settings, has_presets, commands);
        });
        let toolbar = Panel::top("toolbar").frame(frame).exact_size(32.0);
        toolbar.show(ui, |ui| {
            bars::toolbar(ui, document, viewport, has_presets, commands);
        });
        Panel::bottom("status").frame(frame).show(ui, |ui| {
            status::show(ui, &document.design, viewport, export, commands);
        });
    }

    fn show_panels(&mut self, ui: &mut Ui, frame: Frame) {
        let faults = self.document.design.faults();
        // What a scene costs is known before it is made, which may take minutes.
        let mut warnings = costs(&self.document.design);
        for warning in &self.viewport.state().scene.warnings {
            if !warnings.iter().any(|known| known.path == warning.path) {
                warnings.push(warning.clone());
            }
        }
        let mut step_name = None;
        let woven = self.composer.chart(&self.document.design);
        let mut around = Surroundings {
            faults: &faults,
            warnings: &warnings,
            woven: &woven,
            camera: &self.viewport.camera,
            commands: &mut self.shell.commands,
            thumbnails: &mut self.thumbnails,
            step_name: &mut step_name,
            focus: &self.shell.focus,
        };
        let panel = Panel::left("document")
            .frame(frame)
            .resizable(true)
            .default_size(self.filing.settings.panels_width.unwrap_or(PANELS_WIDTH))
            .size_range(330.0..=520.0)
            .show(ui, |ui| {
                let design = &mut self.document.design;
                self.panels.show(ui, design, &mut around);
            });
        if let Some(name) = step_name {
            self.document.name_step(name);
        }
        let width = panel.response.rect.width();
        self.filing.remember_panels(width, &self.panels.open);
    }

    /// Shows the presets unless the user has hidden them, or the cloth, and the chart editor, need the room.
    fn show_presets(&mut self, ui: &mut Ui, frame: Frame) {
        let width = self.filing.settings.presets_width.unwrap_or(PRESETS_WIDTH);
        let needed = match self.panels.chart_editor_is_open() {
            true => ROOM_FOR_PRESETS,
            false => width + ROOM_FOR_CLOTH,
        };
        let has_room = ui.available_width() > needed;
        self.shell.has_presets = self.filing.settings.shows_presets.unwrap_or(has_room);
        if !self.shell.has_presets {
            return;
        }
        let panel = Panel::right("presets")
            .frame(frame)
            .resizable(true)
            .default_size(width)
            .size_range(150.0..=320.0)
            .show(ui, |ui| {
                let open = self.document.path();
                self.presets
                    .show(ui, open, &self.shell.focus, &mut self.shell.commands);
            });
        self.filing.remember_presets(panel.response.rect.width());
    }

    fn show_chart_editor(&mut self, ui: &mut Ui, frame: Frame) {
        if !self.panels.chart_editor_is_open() {
            return;
        }
        let room = ui.available_width();
        let editor = Panel::left("chart editor")
            .frame(frame.inner_margin(Margin::symmetric(8, 6)))
            .resizable(true)
            .default_size((room * 0.6).max((room - 80.0).min(320.0)).floor())
            .size_range(room.min(320.0) * 0.7..=(room - 80.0).max(241.0));
        let shown = editor.show(ui, |ui| {
            let design = &mut self.document.design;
            self.panels.show_chart_editor(ui, design)
        });
        if let Some(name) = shown.inner {
            self.document.name_step(name);
        }
    }

    /// Shows the cloth, and over it what is to be known about its picture.
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
            .show(ui, design, faults.is_empty(), &mut self.shell.commands);
        let messages = UiBuilder::new().max_rect(rect.shrink2(egui::vec2(12.0, 8.0)));
        ui.scope_builder(messages, |ui| {
            if let Some(fault) = faults.first() {
                let text = format!("{fault}. The picture shows the last state without faults.");
                notices::show_standing(ui, "The design has a fault", &text);
            }
            let state = self.viewport.state();
            if let Some(error) = &state.error {
                notices::show_standing(ui, "Not rendered", error);
            }
            if let Some(why) = &state.instead {
                notices::show_standing(ui, "Rendered by the processor", why);
            }
            self.shell.commands.extend(self.shell.notices.show(ui));
        });
    }
}

/// Around the menu, the toolbar and the status bar.
fn bar_frame(visuals: &Visuals) -> Frame {
    Frame::new()
        .fill(visuals.panel_fill)
        .inner_margin(Margin::symmetric(8, 3))
}

/// Around what stands left and right of the cloth.
fn side_frame(visuals: &Visuals) -> Frame {
    bar_frame(visuals).inner_margin(Margin {
        left: 10,
        right: 4,
        top: 6,
        bottom: 0,
    })
}
