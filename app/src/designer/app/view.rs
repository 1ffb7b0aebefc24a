//! Carries out what is asked of the view.

use egui::{Context, Key, Modifiers, Popup, ViewportCommand};
use renderer_core::design::{CameraDesign, Design};

use crate::designer::app::App;
use crate::designer::panels::free_name;
use crate::designer::viewport::command::ViewCommand;

impl App {
    pub(super) fn perform_view(&mut self, ctx: &Context, command: ViewCommand) {
        match command {
            ViewCommand::Camera(index) => {
                let cameras = &self.document.design.view.cameras;
                if let Some(camera) = cameras.get(index) {
                    self.viewport.camera = camera.clone();
                } else {
                    let text = format!("The design has {} saved views.", cameras.len());
                    let title = format!("There is no view {}", index + 1);
                    self.shell.notices.news(title, text);
                }
            }
            ViewCommand::SaveCamera(name) => self.save_camera(&name),
            ViewCommand::Orthographic => self.viewport.toggle_orthographic(),
            ViewCommand::TrueScale => self.show_true_scale(ctx),
            ViewCommand::Calibrate => self.viewport.toggle_calibration(),
            ViewCommand::ScaleBar => self.viewport.toggle_scale_bar(),
            ViewCommand::Loupe => self.viewport.toggle_loupe(),
            ViewCommand::Denoise => self.viewport.toggle_denoising(),
            ViewCommand::Snapshot => {
                if !self.viewport.take_snapshot(ctx) {
                    let text = "There is no picture yet.";
                    self.shell.notices.news("No snapshot taken", text);
                }
            }
            ViewCommand::Compare => {
                if self.viewport.snapshot().is_some() {
                    self.viewport.toggle_compare();
                } else {
                    let text = "Take a snapshot first: S in the viewport, or View, Compare, Take snapshot.";
                    self.shell.notices.news("Nothing to compare with", text);
                }
            }
            ViewCommand::Restore => {
                if let Some((design, camera)) = self.viewport.snapshot() {
                    let (design, camera) = (Design::clone(design), camera.clone());
                    self.document.settle(false);
                    self.document.design = design;
                    self.document.name_step("restore snapshot".into());
                    self.viewport.look_anew(camera);
                }
            }
            ViewCommand::Alone => self.set_alone(ctx, !self.shell.is_alone),
        }
    }

    fn save_camera(&mut self, name: &str) {
        let cameras = &mut self.document.design.view.cameras;
        let name = free_name(cameras, name.trim());
        cameras.push(CameraDesign {
            name: name.clone(),
            ..self.viewport.camera.clone()
        });
        let text = format!("It is view {} of the design.", cameras.len());
        self.shell
            .notices
            .news(format!("View “{name}” saved"), text);
    }

    fn show_true_scale(&mut self, ctx: &Context) {
        self.viewport.show_true_scale(ctx);
        if !self.viewport.screen_is_measured() {
            let text = "That is as large as the system says its pixels are. To be sure, hold a ruler to the screen: \
                Display, Size of the screen.";
            self.shell.notices.news("The cloth at 1:1", text);
        }
    }

    /// Lets the cloth fill the screen, or shows the panels again.
    fn set_alone(&mut self, ctx: &Context, is_alone: bool) {
        self.shell.is_alone = is_alone;
        ctx.send_viewport_cmd(ViewportCommand::Fullscreen(is_alone));
    }

    /// Escape brings the panels back, unless something else wants it.
    pub(super) fn leave_alone(&mut self, ctx: &Context) {
        if self.shell.is_alone && ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape)) {
            self.set_alone(ctx, false);
        }
    }

    /// Escape closes the help, else the export window, unless something nearer takes it: a menu that is open, or what
    /// has the keyboard, which gives it up.
    pub(super) fn close_by_escape(&mut self, ctx: &Context) {
        let is_taken = self.shell.focus.had_focus() || Popup::is_any_open(ctx);
        let is_open = self.shell.help_is_open || self.export.is_open;
        if is_open && !is_taken && ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape)) {
            if self.shell.help_is_open {
                self.shell.help_is_open = false;
            } else {
                self.export.is_open = false;
            }
        }
    }

    /// Writes the view's settings when they have changed.
    pub(super) fn store_view_settings(&mut self) {
        if let Err(error) = self.viewport.store_settings() {
            self.shell.notices.error("Settings not kept", error);
        }
    }
}
