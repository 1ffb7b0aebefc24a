//! Rulers at the canvas: from the chart's left and near edge, in centimetres or inches. Guides are dragged out of them.

use egui::{
    Align2, CursorIcon, FontId, Painter, Pos2, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2,
};
use renderer_core::design::Design;

use super::ChartEditor;
use super::object_gestures::{View, begin_guide, drag_guide};
use crate::designer::widgets::{UnitSystem, style};

/// Breadth of a ruler, points.
pub const BREADTH: f32 = 18.0;
/// Labels are at least this far apart, points.
const LABELS_FROM: f32 = 42.0;
/// Marks are at least this far apart, points.
const MARKS_FROM: f32 = 5.0;

/// Shows a ruler above the canvas (0) or left of it (1), and takes guides that are dragged out of it.
pub fn show(
    ui: &mut Ui,
    editor: &mut ChartEditor,
    design: &mut Design,
    view: &View,
    rect: Rect,
    canvas: Rect,
    axis: usize,
) {
    let name = ["Upper ruler", "Left ruler"][axis];
    let response = ui.interact(rect, ui.scope_id().with(name), Sense::drag());
    let what = "In cm from the chart's left and near edge. Drag a guide out of it; drag it off the chart to remove it.";
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, ui.is_enabled(), name));
    let painter = ui.painter_at(rect);
    marks(ui, &painter, view, rect, axis);
    if let Some(at) = response.interact_pointer_pos() {
        // Out of the upper ruler come level guides.
        let guides = 1 - axis;
        if response.drag_started() {
            begin_guide(editor, &mut design.chart, view, guides, at);
        }
        let ends = response.drag_stopped();
        drag_guide(editor, &mut design.chart, view, at, canvas, ends);
    }
    let cursor = [CursorIcon::ResizeVertical, CursorIcon::ResizeHorizontal][axis];
    response.on_hover_cursor(cursor).on_hover_text(what);
}

fn marks(ui: &Ui, painter: &Painter, view: &View, rect: Rect, axis: usize) {
    let visuals = ui.visuals();
    painter.rect_filled(rect, 0.0, visuals.extreme_bg_color);
    let (unit, mm) = UnitSystem::of(ui.ctx()).of_rulers();
    let half = view.canvas.size_mm().map(|side| 0.5 * side);
    let points_per_unit = (mm / view.mm_per_point()) as f32;
    if !(points_per_unit.is_finite() && points_per_unit > 0.0) {
        return;
    }
    let steps = [
        0.1, 0.5, 1.0, 5.0, 10.0, 50.0, 100.0, 500.0, 1000.0, 5000.0, 10_000.0,
    ];
    let step_for = |from: f32| {
        steps
            .into_iter()
            .find(|step| step * points_per_unit >= from)
    };
    let (Some(labelled), Some(marked)) = (step_for(LABELS_FROM), step_for(MARKS_FROM)) else {
        return;
    };
    let per_label = (labelled / marked).round().max(1.0) as i64;
    let at = |units: f32| {
        let mut place = [0.0; 2];
        place[axis] = f64::from(units) * mm - half[axis];
        view.point(place)[axis]
    };
    let ends = [at(0.0), at((2.0 * half[axis] / mm) as f32)];
    let (low, high) = (rect.min[axis], rect.max[axis]);
    let seen = [
        ends[0].min(ends[1]).max(low),
        ends[0].max(ends[1]).min(high),
    ];
    let units_at =
        |point: f32| (point - ends[0]) / (ends[1] - ends[0]) * (2.0 * half[axis] / mm) as f32;
    let span = [units_at(seen[0]), units_at(seen[1])];
    let first = (span[0].min(span[1]) / marked).floor().max(0.0) as i64;
    let last = (span[0].max(span[1]) / marked).ceil().max(0.0) as i64;
    let stroke = Stroke::new(1.0, visuals.weak_text_color());
    for k in first..=last.min(first + 4000) {
        let point = at(k as f32 * marked);
        if point < seen[0] - 0.5 || point > seen[1] + 0.5 {
            continue;
        }
        let is_labelled = k % per_label == 0;
        let length = if is_labelled {
            BREADTH * 0.5
        } else {
            BREADTH * 0.25
        };
        let line = |a: f32, b: f32| -> [Pos2; 2] {
            match axis {
                0 => [pos2(point, a), pos2(point, b)],
                _ => [pos2(a, point), pos2(b, point)],
            }
        };
        let far = rect.max[1 - axis];
        painter.line_segment(line(far - length, far), stroke);
        if is_labelled {
            let text = format!("{}", (k as f32 * marked * 10.0).round() / 10.0);
            let font = FontId::proportional(9.5);
            let place = match axis {
                0 => (pos2(point + 2.0, rect.top()), Align2::LEFT_TOP),
                _ => (pos2(rect.left() + 1.0, point - 1.0), Align2::LEFT_BOTTOM),
            };
            painter.text(place.0, place.1, text, font, visuals.text_color());
        }
    }
    if axis == 0 {
        let end = rect.right_top();
        let font = FontId::proportional(9.5);
        painter.text(end, Align2::RIGHT_TOP, unit, font, style::accent(visuals));
    }
}
