//! The net that pulls the cloth, over the picture: its points can be dragged.

use egui::{Color32, CursorIcon, Painter, PointerButton, Pos2, Response, Stroke, Ui};
use glam::{DVec2, DVec3};
use renderer_core::design::{Design, Form, FormKind};
use renderer_core::geometry::Camera;

use super::{Area, Viewport};
use crate::designer::shell::command::Command;
use crate::designer::widgets::style;

/// How near to a point the pointer has it, points of the screen.
const REACH: f32 = 11.0;
/// Radius of a point.
const RADIUS: f32 = 4.5;

/// A point of a net: its row, and its place in that.
pub type NetPoint = [usize; 2];

impl Viewport {
    /// Drags points of the net. Whether the pointer is at it, so that the camera stays.
    pub(super) fn drag_net(
        &mut self,
        ui: &Ui,
        response: &Response,
        area: &Area,
        design: &Design,
        commands: &mut Vec<Command>,
    ) -> bool {
        if !self.shows_net || design.form.kind != FormKind::Net {
            self.net_point = None;
            return false;
        }
        let camera = Camera::from_design(&self.camera);
        let net = &design.form.net;
        let is_dragged = response.dragged_by(PointerButton::Primary);
        if !is_dragged {
            let pointer = response.hover_pos();
            self.net_point = pointer.and_then(|at| nearest(net, &camera, area, at));
        }
        let Some([row, column]) = self.net_point else {
            return false;
        };
        ui.set_cursor_icon(if is_dragged {
            CursorIcon::Grabbing
        } else {
            CursorIcon::PointingHand
        });
        let delta = response.drag_delta();
        if is_dragged && delta != egui::Vec2::ZERO {
            let Some(point) = net.get(row).and_then(|row| row.get(column)) else {
                return true;
            };
            let point = DVec3::from_array(*point);
            let mm = camera.pixel_mm_at(point, area.size[1]) * f64::from(area.size[1])
                / f64::from(area.rect.height());
            let moved = if ui.input(|i| i.modifiers.alt) {
                // As far up as the pointer went, however the view foreshortens it.
                DVec3::Z * (-f64::from(delta.y) * mm / camera.up.z.abs().max(0.2))
            } else {
                (camera.right * f64::from(delta.x) - camera.up * f64::from(delta.y)) * mm
            };
            let most = DVec3::splat(Form::FARTHEST_MM);
            commands.push(Command::MoveNetPoint {
                row,
                column,
                to: (point + moved).clamp(-most, most).to_array(),
            });
        }
        true
    }

    /// Draws the net over the picture.
    pub(super) fn paint_net(&self, ui: &Ui, painter: &Painter, area: &Area, design: &Design) {
        if !self.shows_net || design.form.kind != FormKind::Net {
            return;
        }
        let camera = Camera::from_design(&self.camera);
        let accent = style::accent(ui.visuals());
        let line = Stroke::new(1.0, accent.gamma_multiply(0.7));
        let place = |point: &[f64; 3]| on_screen(&camera, area, *point);
        let net = &design.form.net;
        let segment = |a: &[f64; 3], b: &[f64; 3]| {
            if let (Some(a), Some(b)) = (place(a), place(b)) {
                painter.line_segment([a, b], line);
            }
        };
        for (index, row) in net.iter().enumerate() {
            row.windows(2).for_each(|ends| segment(&ends[0], &ends[1]));
            if let Some(next) = net.get(index + 1) {
                row.iter().zip(next).for_each(|(a, b)| segment(a, b));
            }
        }
        for (row, points) in net.iter().enumerate() {
            for (column, point) in points.iter().enumerate() {
                if let Some(at) = place(point) {
                    let is_held = self.net_point == Some([row, column]);
                    let fill = if is_held { accent } else { Color32::WHITE };
                    painter.circle(at, RADIUS, fill, Stroke::new(1.5, accent));
                }
            }
        }
    }
}

/// The point that the pointer has.
fn nearest(net: &[Vec<[f64; 3]>], camera: &Camera, area: &Area, at: Pos2) -> Option<NetPoint> {
    let rows = net.iter().enumerate();
    let points = rows.flat_map(|(row, points)| {
        let points = points.iter().enumerate();
        points.map(move |(column, point)| ([row, column], *point))
    });
    let near = points.filter_map(|(index, point)| {
        let distance = on_screen(camera, area, point)?.distance(at);
        (distance < REACH).then_some((index, distance))
    });
    near.min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// Where a point of the world is on the screen, if it is ahead of the camera.
fn on_screen(camera: &Camera, area: &Area, point: [f64; 3]) -> Option<Pos2> {
    let pixel = camera.pixel_of(DVec3::from_array(point), area.size)?;
    let size = DVec2::new(f64::from(area.size[0]), f64::from(area.size[1]));
    let share = (pixel / size).as_vec2();
    Some(area.rect.min + area.rect.size() * egui::vec2(share.x, share.y))
}
