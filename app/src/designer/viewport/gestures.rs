//! Drags, wheel, trackpad and keys, turned into camera moves.

use egui::{
    CursorIcon, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Response,
    Ui, Vec2,
};
use glam::DVec2;
use renderer_core::design::Design;

use super::camera_moves;
use super::command::KEYS;
use super::{Area, Viewport};
use crate::designer::shell::command::Command;
use crate::designer::widgets::arrow_keys;

/// Degrees of orbit for a point of drag.
const ORBIT_PER_POINT: f64 = 0.35;
/// Degrees of orbit for an arrow key.
const ORBIT_PER_KEY: f64 = 5.0;
/// Share of the picture's height that a key pans.
const PAN_PER_KEY: f64 = 0.05;
/// Zoom of a key.
const ZOOM_PER_KEY: f64 = 1.2;
/// Points of wheel for a zoom by e.
const WHEEL_PER_E: f64 = 300.0;

impl Viewport {
    /// Turns what happened to the picture since the last frame into camera moves and commands; drags only where they
    /// are not those of a net's point.
    pub(super) fn gestures(
        &mut self,
        ui: &Ui,
        response: &Response,
        picture: &Area,
        design: &Design,
        drags_net: bool,
        commands: &mut Vec<Command>,
    ) {
        let before = self.camera.clone();
        if !drags_net {
            self.drags(ui, response, picture);
        }
        self.scrolls(ui, response, picture);
        if self.camera != before {
            self.screen.knows_gestures();
        }
        self.keys(ui, response, picture, design, commands);
    }

    fn drags(&mut self, ui: &Ui, response: &Response, picture: &Area) {
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        let delta = response.drag_delta();
        let Some(at) = response.interact_pointer_pos() else {
            return;
        };
        if delta == Vec2::ZERO {
            return;
        }
        let shift = ui.input(|i| i.modifiers.shift);
        let pans = response.dragged_by(PointerButton::Middle)
            || response.dragged_by(PointerButton::Secondary)
            || shift;
        if pans {
            ui.set_cursor_icon(CursorIcon::Move);
            self.pan(picture, at - delta, delta);
        } else {
            ui.set_cursor_icon(CursorIcon::Grabbing);
            self.orbit(delta);
        }
    }

    fn pan(&mut self, picture: &Area, from: egui::Pos2, by: Vec2) {
        let (from, to) = (picture.pixel(from), picture.pixel(from + by));
        camera_moves::pan(&mut self.camera, from, to, picture.size);
    }

    fn orbit(&mut self, by: Vec2) {
        camera_moves::orbit(
            &mut self.camera,
            -f64::from(by.x) * ORBIT_PER_POINT,
            f64::from(by.y) * ORBIT_PER_POINT,
        );
    }

    /// The wheel and pinches zoom to the pointer; two fingers on a trackpad move the cloth, with Alt they turn it, and
    /// so does twisting them.
    fn scrolls(&mut self, ui: &Ui, response: &Response, picture: &Area) {
        let Some(at) = response.hover_pos() else {
            return;
        };
        let (wheel, pinch, twist, alt) = ui.input(|i| {
            (
                i.smooth_scroll_delta().y,
                i.zoom_delta(),
                i.rotation_delta(),
                i.modifiers.alt,
            )
        });
        let fingers = self.fingers(ui);
        let mut factor = f64::from(pinch);
        if !self.fingers_scroll {
            factor *= (f64::from(wheel) / WHEEL_PER_E).exp();
        } else if fingers != Vec2::ZERO && alt {
            self.orbit(fingers);
        } else if fingers != Vec2::ZERO {
            self.pan(picture, at, fingers);
        }
        if factor != 1.0 {
            camera_moves::zoom(&mut self.camera, factor, picture.pixel(at), picture.size);
        }
        if twist != 0.0 {
            camera_moves::orbit(&mut self.camera, f64::from(twist).to_degrees(), 0.0);
        }
    }

    /// How far fingers on a trackpad have moved. Not as egui sums it up: with Alt it makes one axis of two, and a
    /// wheel's smoothing only delays fingers. With Ctrl egui makes a zoom of it, as of the wheel.
    fn fingers(&mut self, ui: &Ui) -> Vec2 {
        ui.input(|i| {
            let mut sum = Vec2::ZERO;
            for event in &i.events {
                if let Event::MouseWheel {
                    unit,
                    source,
                    delta,
                    modifiers,
                    ..
                } = event
                {
                    self.fingers_scroll = is_trackpad(*unit, *source);
                    if self.fingers_scroll && !modifiers.command {
                        sum += *delta;
                    }
                }
            }
            sum
        })
    }

    fn keys(
        &mut self,
        ui: &Ui,
        response: &Response,
        picture: &Area,
        design: &Design,
        commands: &mut Vec<Command>,
    ) {
        let modifiers = ui.input(|i| i.modifiers);
        // With Ctrl, + and − are the size of the interface.
        if modifiers.command {
            return;
        }
        let Some(arrows) = arrow_keys(ui, response) else {
            return;
        };
        let [right, up] = arrows.map(f64::from);
        let presses = |key| ui.input(|i| i.num_presses(key) as f64);
        let nearer = presses(Key::Plus) + presses(Key::Equals) - presses(Key::Minus);
        let centre = DVec2::new(f64::from(picture.size[0]), f64::from(picture.size[1])) / 2.0;
        if nearer != 0.0 {
            let factor = ZOOM_PER_KEY.powf(nearer);
            camera_moves::zoom(&mut self.camera, factor, centre, picture.size);
        }
        if modifiers == Modifiers::SHIFT {
            let step = PAN_PER_KEY * f64::from(picture.size[1]) * DVec2::new(right, -up);
            if step != DVec2::ZERO {
                camera_moves::pan(&mut self.camera, centre + step, centre, picture.size);
            }
        } else if modifiers.is_none() && (right, up) != (0.0, 0.0) {
            camera_moves::orbit(&mut self.camera, right * ORBIT_PER_KEY, up * ORBIT_PER_KEY);
        }
        if !modifiers.is_none() {
            return;
        }
        if presses(Key::Home) + presses(Key::F) > 0.0 {
            self.fit(design);
        }
        let pressed = KEYS.iter().filter(|(_, key)| presses(*key) > 0.0);
        commands.extend(pressed.map(|(command, _)| Command::View(command.clone())));
    }
}

/// Whether a scroll comes from fingers on a trackpad, as far as the window system says: only trackpads scroll by
/// points. X11 makes lines of everything; there two fingers zoom as a wheel does.
fn is_trackpad(unit: MouseWheelUnit, source: MouseWheelSource) -> bool {
    match source {
        MouseWheelSource::Trackpad | MouseWheelSource::Momentum => true,
        MouseWheelSource::Wheel => false,
        MouseWheelSource::Unknown => unit == MouseWheelUnit::Point,
    }
}
