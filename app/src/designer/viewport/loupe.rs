//! The loupe: a circle under the pointer in which every pixel of the picture is a square, [`MAGNIFICATION`] times as
//! large.
//!
//! It shows the picture that is there, not a new one: nothing has to be rendered, the picture goes on getting clearer
//! under it, and what one sees is what an export of this size would hold.

use std::f32::consts::TAU;

use egui::epaint::{Mesh, Vertex};
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, TextureId, vec2};

use super::overlay::{Corner, note};

/// How many times as large the loupe shows the picture.
const MAGNIFICATION: f32 = 4.0;
/// Radius of the circle, points.
const RADIUS: f32 = 96.0;
/// Corners of the polygon that stands for the circle.
const CORNERS: u32 = 64;

/// Draws the loupe about `at`: what `texture` shows there if it fills `place`.
pub fn paint(painter: &Painter, at: Pos2, texture: TextureId, place: Rect) {
    let mut mesh = Mesh::with_texture(texture);
    let mut add = |offset: egui::Vec2| {
        let shows = at + offset / MAGNIFICATION;
        mesh.vertices.push(Vertex {
            pos: at + offset,
            uv: ((shows - place.min) / place.size()).to_pos2(),
            color: Color32::WHITE,
        });
    };
    add(egui::Vec2::ZERO);
    for corner in 0..CORNERS {
        let angle = TAU * corner as f32 / CORNERS as f32;
        add(RADIUS * vec2(angle.cos(), angle.sin()));
    }
    for corner in 0..CORNERS {
        mesh.add_triangle(0, 1 + corner, 1 + (corner + 1) % CORNERS);
    }
    painter.add(Shape::mesh(mesh));
    let dark = Stroke::new(3.0, Color32::from_black_alpha(130));
    painter.circle_stroke(at, RADIUS + 1.0, dark);
    painter.circle_stroke(at, RADIUS, Stroke::new(1.5, Color32::from_gray(0xf2)));
    let below = Rect::from_center_size(at + vec2(0.0, RADIUS - 4.0), vec2(0.0, 0.0));
    note(painter, below, Corner::Middle, "4×");
}
