//! What is drawn over the chart: guides, what gestures snap to, the outline and handles of the chosen object, and its
//! size while it changes.

use egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, Vec2, vec2,
};
use renderer_core::design::chart_objects::Placed;
use renderer_core::design::{Chart, ChartObject, ObjectKind, Sheet};

use super::ChartEditor;
use super::object_gestures::{View, handle_point, handles, turn_point, under_way};
use super::objects::{loops, pitch};
use crate::designer::widgets::style;

/// Side of a handle, points.
const HANDLE: f32 = 8.0;
/// Repeats beyond these are not outlined.
const MOST_OUTLINED: usize = 60;

/// Draws all of it.
pub fn paint(
    ui: &Ui,
    painter: &Painter,
    editor: &ChartEditor,
    chart: &Chart,
    sheet: &Sheet,
    view: &View,
) {
    let accent = style::accent(ui.visuals());
    guides(painter, chart, view);
    let caught = Stroke::new(1.5, accent);
    let clip = painter.clip_rect();
    for (axis, line) in editor.objects.caught.0.into_iter().enumerate() {
        let Some(line) = line else { continue };
        let mut place = [0.0; 2];
        place[axis] = line;
        let at = view.point(place);
        if axis == 0 {
            painter.vline(at.x, clip.y_range(), caught);
        } else {
            painter.hline(clip.x_range(), at.y, caught);
        }
    }
    let selected = editor
        .objects
        .selected
        .and_then(|index| chart.object.get(index));
    if let Some(object) = selected
        && editor.tool.is_for_objects()
    {
        chosen(painter, object, view, accent);
    }
    if let Some(object) = under_way(editor, chart) {
        size(ui, painter, object, sheet, view);
    }
}

fn guides(painter: &Painter, chart: &Chart, view: &View) {
    let clip = painter.clip_rect();
    let stroke = Stroke::new(1.0, Color32::from_rgb(0x18, 0xb4, 0xc8));
    for &guide in &chart.guides_x {
        painter.vline(view.point([guide, 0.0]).x, clip.y_range(), stroke);
    }
    for &guide in &chart.guides_y {
        painter.hline(clip.x_range(), view.point([0.0, guide]).y, stroke);
    }
}

/// Outline, repeats and handles of an object.
fn chosen(painter: &Painter, object: &ChartObject, view: &View, accent: Color32) {
    let corners = |placed: &Placed| -> Vec<Pos2> {
        // Stripes reach far beyond the chart.
        let clip = painter.clip_rect().expand(50.0);
        let inside = |place| view.point(place).clamp(clip.min, clip.max);
        placed.corners().map(inside).to_vec()
    };
    let closed = |points: Vec<Pos2>, stroke: Stroke| {
        painter.add(Shape::closed_line(points, stroke));
    };
    for placed in Placed::all(object, &view.canvas).iter().take(MOST_OUTLINED) {
        closed(
            corners(placed),
            Stroke::new(1.0, accent.gamma_multiply(0.6)),
        );
    }
    let first = Placed::first(object, &view.canvas);
    closed(corners(&first), Stroke::new(2.5, Color32::WHITE));
    closed(corners(&first), Stroke::new(1.0, Color32::BLACK));
    for handle in handles(object.kind) {
        let at = handle_point(view, object, *handle);
        let rect = Rect::from_center_size(at, Vec2::splat(HANDLE));
        painter.rect(
            rect,
            1.0,
            Color32::WHITE,
            Stroke::new(1.0, Color32::BLACK),
            StrokeKind::Inside,
        );
    }
    if let Some(at) = turn_point(view, object) {
        painter.circle(
            at,
            0.5 * HANDLE,
            Color32::WHITE,
            Stroke::new(1.0, Color32::BLACK),
        );
    }
}

/// `12.4 × 8 cm · 165 × 118 loops` beside an object.
fn size(ui: &Ui, painter: &Painter, object: &ChartObject, sheet: &Sheet, view: &View) {
    let text = size_text(object, sheet);
    let [low, high] = Placed::first(object, &view.canvas).bounds();
    let below = view.point([0.5 * (low[0] + high[0]), low[1]]) + vec2(0.0, 10.0);
    let font = FontId::proportional(12.0);
    let galley = painter.layout_no_wrap(text, font, Color32::WHITE);
    let room = painter
        .clip_rect()
        .shrink2(galley.size() * 0.5 + vec2(8.0, 8.0));
    let middle = (below + vec2(0.0, 0.5 * galley.size().y)).clamp(room.min, room.max.max(room.min));
    let rect = Align2::CENTER_CENTER.anchor_size(middle, galley.size());
    painter.rect_filled(
        rect.expand2(vec2(5.0, 2.0)),
        3.0,
        Color32::from_black_alpha(200),
    );
    painter.galley(rect.min, galley, ui.visuals().text_color());
}

/// How large an object is, in cm and in loops.
pub fn size_text(object: &ChartObject, sheet: &Sheet) -> String {
    let cm = |mm: f64| (mm * 10.0).round() / 100.0;
    let [across, down] = pitch(sheet);
    let wide = loops(object.width, across).round();
    let high = loops(object.height, down).round();
    match object.kind {
        ObjectKind::StripeAcross => format!("{} cm · {high} picks", cm(object.height)),
        ObjectKind::StripeAlong => format!("{} cm · {wide} ends", cm(object.width)),
        ObjectKind::Line => format!("{} cm long, {:.1}°", cm(object.width), object.rotation),
        _ => format!(
            "{} × {} cm · {wide} × {high} loops",
            cm(object.width),
            cm(object.height)
        ),
    }
}
