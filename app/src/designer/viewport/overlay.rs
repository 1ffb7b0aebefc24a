//! What is written and drawn over the picture: notes in its corners, the scale bar, the first hint.

use egui::{Align2, Color32, FontId, Label, Painter, Rect, Stroke, Ui, pos2, vec2};

/// Where a note stands in a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corner {
    /// In its lower left corner.
    LeftBottom,
    /// In its upper left corner.
    LeftTop,
    /// In its upper right corner.
    RightTop,
    /// About its middle.
    Middle,
}

/// Ground of notes: legible whatever the picture's colours.
const GROUND: Color32 = Color32::from_black_alpha(150);
const TEXT: Color32 = Color32::from_gray(0xf2);

/// A legible line.
pub fn note(painter: &Painter, rect: Rect, corner: Corner, text: &str) {
    if text.is_empty() {
        return;
    }
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(12.0), TEXT);
    let size = galley.size() + vec2(12.0, 6.0);
    let at = match corner {
        Corner::LeftBottom => Align2::LEFT_BOTTOM.anchor_size(rect.left_bottom(), size),
        Corner::LeftTop => Align2::LEFT_TOP.anchor_size(rect.left_top() + vec2(0.0, 10.0), size),
        Corner::RightTop => Align2::RIGHT_TOP.anchor_size(rect.right_top() + vec2(0.0, 10.0), size),
        Corner::Middle => Rect::from_center_size(rect.center(), size),
    };
    painter.rect_filled(at, 4.0, GROUND);
    painter.galley(at.min + vec2(6.0, 3.0), galley, TEXT);
}

/// Longest scale bar, points.
const LONGEST_BAR: f64 = 160.0;

/// The longest of 1, 2, 5, 10, 20 … mm that is at most [`LONGEST_BAR`] long at so many mm for a point.
pub fn bar_mm(mm_per_point: f64) -> f64 {
    let longest = LONGEST_BAR * mm_per_point;
    let decade = 10_f64.powf(longest.log10().floor());
    let factor = [5.0, 2.0].into_iter().find(|f| f * decade <= longest);
    factor.unwrap_or(1.0) * decade
}

/// A scale bar of so many mm, `length` points long, in the lower right corner of `rect`. `is_parallel`: the scale holds
/// for the whole picture, not only for what the camera looks at.
pub fn scale_bar(painter: &Painter, rect: Rect, mm: f64, length: f32, is_parallel: bool) {
    let place = if is_parallel { "" } else { " in the middle" };
    let text = format!("{mm} mm{place}");
    let galley = painter.layout_no_wrap(text, FontId::proportional(12.0), TEXT);
    let size = vec2(length.max(galley.size().x) + 16.0, galley.size().y + 16.0);
    let ground = Align2::RIGHT_BOTTOM.anchor_size(rect.right_bottom(), size);
    painter.rect_filled(ground, 4.0, GROUND);
    let middle = ground.center().x;
    let text_at = pos2(middle - galley.size().x / 2.0, ground.top() + 3.0);
    painter.galley(text_at, galley, TEXT);
    let y = ground.bottom() - 7.0;
    let (left, right) = (middle - length / 2.0, middle + length / 2.0);
    let stroke = Stroke::new(1.5, TEXT);
    painter.line_segment([pos2(left, y), pos2(right, y)], stroke);
    for x in [left, right] {
        painter.line_segment([pos2(x, y - 4.0), pos2(x, y + 4.0)], stroke);
    }
}

/// Tells how to move about, in the middle of the lower edge.
pub fn hint(ui: &mut Ui, rect: Rect) {
    let text = "Drag to turn the cloth · Shift and drag to move it · wheel or pinch to zoom · F fits it in";
    let margin = vec2(12.0, 8.0);
    let width = (rect.width() - 40.0).max(80.0) - 2.0 * margin.x;
    let galley = ui
        .painter()
        .layout(text.into(), FontId::proportional(13.0), TEXT, width);
    let size = galley.size() + 2.0 * margin;
    let place = Align2::CENTER_BOTTOM.anchor_size(rect.center_bottom() - vec2(0.0, 44.0), size);
    ui.painter().rect_filled(place, 6.0, GROUND);
    ui.place(place.shrink2(margin), Label::new(galley).selectable(false));
}
