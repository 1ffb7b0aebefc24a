//! A curve through points in the unit square, to drag: x rises from point to point, ends stay at the sides.

use egui::{
    Color32, Key, Pos2, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo,
    pos2, vec2,
};

use super::keys::arrow_keys;
use crate::designer::widgets::style;

/// State of an editor: the point that the keyboard moves.
#[derive(Debug, Clone, Default)]
pub struct CurveEditor {
    /// Index of the selected point.
    pub selected: usize,
    dragging: bool,
}

/// Least distance between neighbouring points along x.
const GAP: f64 = 0.01;
/// How near the pointer must be to a point to take it, points.
const REACH: f32 = 10.0;

/// Shows the points `curve` joined by `value` (the curve as it will be used), over a histogram with heights in 0 to 1.
///
/// Dragging a point moves it, pressing elsewhere adds one, a double click or Delete removes one; arrows move the
/// selected point when focused, Page up and Page down select.
pub fn curve_editor(
    ui: &mut Ui,
    name: &str,
    editor: &mut CurveEditor,
    curve: &mut Vec<[f64; 2]>,
    max_points: usize,
    histogram: &[f32],
    value: impl Fn(f64) -> f64,
) -> Response {
    let size = vec2(ui.available_width(), 120.0);
    let (outer, mut response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let rect = outer.shrink(6.0);
    let before = curve.clone();
    editor.selected = editor.selected.min(curve.len().saturating_sub(1));
    pointer(ui, editor, curve, max_points, &response, rect);
    keyboard(ui, editor, curve, &response);
    if *curve != before {
        response.mark_changed();
    }
    paint(
        ui,
        editor,
        curve,
        &response,
        [outer, rect],
        histogram,
        value,
    );
    let point = curve.get(editor.selected).copied().unwrap_or_default();
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(format!(
            "point {} of {}: brightness {:.2}, length {:.2}",
            editor.selected + 1,
            curve.len(),
            point[0],
            point[1]
        )),
        ..WidgetInfo::labeled(Role::Canvas, ui.is_enabled(), name)
    });
    response
}

fn to_screen(rect: Rect, [x, y]: [f64; 2]) -> Pos2 {
    pos2(
        rect.left() + rect.width() * x as f32,
        rect.bottom() - rect.height() * y as f32,
    )
}

fn from_screen(rect: Rect, at: Pos2) -> [f64; 2] {
    let x = (at.x - rect.left()) / rect.width();
    let y = (rect.bottom() - at.y) / rect.height();
    [x, y].map(|v| (f64::from(v).clamp(0.0, 1.0) * 1000.0).round() / 1000.0)
}

fn pointer(
    ui: &Ui,
    editor: &mut CurveEditor,
    curve: &mut Vec<[f64; 2]>,
    max_points: usize,
    response: &Response,
    rect: Rect,
) {
    let Some(at) = response.interact_pointer_pos() else {
        editor.dragging = false;
        return;
    };
    let distance = |point: &[f64; 2]| to_screen(rect, *point).distance(at);
    let nearest =
        (0..curve.len()).min_by(|&a, &b| distance(&curve[a]).total_cmp(&distance(&curve[b])));
    let near = nearest.filter(|&index| distance(&curve[index]) < REACH);
    if response.double_clicked() {
        if let Some(index) = near {
            editor.selected = index;
            remove(editor, curve);
        }
        return;
    }
    if !(response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down())) {
        editor.dragging = false;
        return;
    }
    response.request_focus();
    if !editor.dragging {
        editor.dragging = true;
        match near {
            Some(index) => editor.selected = index,
            None => add(editor, curve, max_points, from_screen(rect, at)),
        }
    } else if response.drag_delta() != egui::Vec2::ZERO {
        move_to(curve, editor.selected, from_screen(rect, at));
    }
}

fn keyboard(ui: &Ui, editor: &mut CurveEditor, curve: &mut Vec<[f64; 2]>, response: &Response) {
    let Some(arrows) = arrow_keys(ui, response) else {
        return;
    };
    let presses = |key| ui.input(|i| i.num_presses(key));
    let last = curve.len().saturating_sub(1);
    editor.selected = (editor.selected + presses(Key::PageUp)).min(last);
    editor.selected = editor.selected.saturating_sub(presses(Key::PageDown));
    let [dx, dy] = arrows.map(|presses| 0.01 * f64::from(presses));
    if let (true, Some(&[x, y])) = (arrows != [0, 0], curve.get(editor.selected)) {
        move_to(curve, editor.selected, [x + dx, y + dy]);
    }
    if presses(Key::Delete) > 0 {
        remove(editor, curve);
    }
}

/// Puts a point between its neighbours; the ends of the curve keep their sides.
fn move_to(curve: &mut [[f64; 2]], index: usize, [x, y]: [f64; 2]) {
    let last = curve.len() - 1;
    let low = if index == 0 {
        0.0
    } else {
        curve[index - 1][0] + GAP
    };
    let high = if index == last {
        1.0
    } else {
        curve[index + 1][0] - GAP
    };
    let x = match index {
        0 => 0.0,
        _ if index == last => 1.0,
        _ => x.min(high).max(low),
    };
    curve[index] = [x, y.clamp(0.0, 1.0)];
}

fn add(editor: &mut CurveEditor, curve: &mut Vec<[f64; 2]>, max_points: usize, point: [f64; 2]) {
    let index = curve.partition_point(|p| p[0] < point[0]);
    let room = |a: usize| (curve[a][0] - point[0]).abs() >= GAP;
    let between = index > 0 && index < curve.len() && room(index - 1) && room(index);
    if between && curve.len() < max_points {
        curve.insert(index, point);
        editor.selected = index;
    }
}

fn remove(editor: &mut CurveEditor, curve: &mut Vec<[f64; 2]>) {
    let inner = 1..curve.len().saturating_sub(1);
    if inner.contains(&editor.selected) {
        curve.remove(editor.selected);
        editor.selected -= 1;
    }
}

fn paint(
    ui: &Ui,
    editor: &CurveEditor,
    curve: &[[f64; 2]],
    response: &Response,
    [outer, rect]: [Rect; 2],
    histogram: &[f32],
    value: impl Fn(f64) -> f64,
) {
    let visuals = ui.visuals();
    let painter = ui.painter_at(outer);
    let frame = if response.has_focus() {
        Stroke::new(1.0, style::accent(visuals))
    } else {
        visuals.widgets.noninteractive.bg_stroke
    };
    painter.rect(
        outer,
        3.0,
        visuals.extreme_bg_color,
        frame,
        StrokeKind::Inside,
    );
    let width = rect.width() / histogram.len().max(1) as f32;
    for (index, &height) in histogram.iter().enumerate() {
        let left = rect.left() + index as f32 * width;
        let bar = Rect::from_min_max(
            pos2(left, rect.bottom() - rect.height() * height.clamp(0.0, 1.0)),
            pos2(left + width, rect.bottom()),
        );
        painter.rect_filled(bar, 0.0, visuals.text_color().gamma_multiply(0.18));
    }
    let grid = Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color);
    for quarter in 1..4 {
        let share = f64::from(quarter) / 4.0;
        let ends = |a, b| [to_screen(rect, a), to_screen(rect, b)];
        painter.line_segment(ends([share, 0.0], [share, 1.0]), grid);
        painter.line_segment(ends([0.0, share], [1.0, share]), grid);
    }
    let line = (0..=96).map(|k| {
        let x = f64::from(k) / 96.0;
        to_screen(rect, [x, value(x).clamp(0.0, 1.0)])
    });
    let accent = style::accent(visuals);
    painter.add(Shape::line(line.collect(), Stroke::new(2.0, accent)));
    for (index, &point) in curve.iter().enumerate() {
        let fill = if index == editor.selected {
            accent
        } else {
            Color32::from_gray(if visuals.dark_mode { 0x30 } else { 0xff })
        };
        let outline = Stroke::new(1.5, visuals.strong_text_color());
        painter.circle(to_screen(rect, point), 4.0, fill, outline);
    }
}
