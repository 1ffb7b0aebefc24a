//! Comparing the picture with an earlier one: a snapshot keeps a picture with its design and camera; a divider that can
//! be dragged shows the snapshot left of it and the present picture right of it.

use std::sync::Arc;

use egui::{
    Color32, CursorIcon, EventFilter, Id, Key, Painter, Pos2, Rect, Sense, Stroke, Ui, WidgetInfo,
    pos2, vec2,
};
use renderer_core::design::{CameraDesign, Design};

use super::overlay::{Corner, note};
use super::picture::Texture;

/// How far a key moves the divider, as a share of the width.
const KEY_STEP: f32 = 0.02;

/// An earlier picture.
pub struct Snapshot {
    /// What it shows.
    pub design: Arc<Design>,
    /// From where.
    pub camera: CameraDesign,
    /// The picture.
    pub texture: Texture,
    /// Width and height of the area it was shown in, pixels.
    pub size: [u32; 2],
}

/// The snapshot, if there is one, and whether and where it is shown.
pub struct Compare {
    /// The snapshot.
    pub snapshot: Option<Snapshot>,
    /// Whether it is shown.
    pub is_on: bool,
    /// The divider's place as a share of the width.
    divider: f32,
}

impl Default for Compare {
    fn default() -> Self {
        Self {
            snapshot: None,
            is_on: false,
            divider: 0.5,
        }
    }
}

impl Compare {
    /// The snapshot while it is shown.
    pub fn shown(&self) -> Option<&Snapshot> {
        self.snapshot.as_ref().filter(|_| self.is_on)
    }

    /// Place of the divider in `rect`.
    pub fn divider_x(&self, rect: Rect) -> f32 {
        rect.left() + self.divider * rect.width()
    }

    /// Takes drags and keys of the divider.
    pub fn interact(&mut self, ui: &Ui, rect: Rect) {
        if self.shown().is_none() {
            return;
        }
        let x = self.divider_x(rect);
        let grip = Rect::from_x_y_ranges(x - 6.0..=x + 6.0, rect.y_range());
        let id = divider_id();
        let grip = ui.interact(grip, id, Sense::click_and_drag());
        let share = 100.0 * f64::from(self.divider);
        grip.widget_info(|| {
            WidgetInfo::slider(true, share, "Divider between snapshot and picture")
        });
        if grip.clicked() || grip.drag_started() {
            grip.request_focus();
        }
        let mut moved = grip.drag_delta().x / rect.width();
        if grip.has_focus() {
            let keep = EventFilter {
                horizontal_arrows: true,
                ..EventFilter::default()
            };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(id, keep));
            let presses = |key| ui.input(|i| i.num_presses(key) as f32);
            moved += KEY_STEP * (presses(Key::ArrowRight) - presses(Key::ArrowLeft));
        }
        self.divider = (self.divider + moved).clamp(0.0, 1.0);
        let is_strong = grip.hovered() || grip.has_focus() || grip.dragged();
        ui.data_mut(|data| data.insert_temp(id, is_strong));
        grip.on_hover_cursor(CursorIcon::ResizeHorizontal)
            .on_hover_text("Left: the snapshot. Right: the cloth as it is now. Drag, or move with the arrow keys.");
    }

    /// Paints the snapshot over the left part of the picture in `rect`.
    pub fn paint(&self, ui: &Ui, painter: &Painter, rect: Rect) {
        let Some(snapshot) = self.shown() else {
            return;
        };
        let x = self.divider_x(rect);
        let left = painter.with_clip_rect(rect.with_max_x(x).intersect(painter.clip_rect()));
        left.image(
            snapshot.texture.id(),
            snapshot.place_in(rect),
            Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)),
            Color32::WHITE,
        );
        let is_strong = ui.data(|data| data.get_temp(divider_id()) == Some(true));
        let width = if is_strong { 3.0 } else { 1.5 };
        let line = [pos2(x, rect.top()), pos2(x, rect.bottom())];
        painter.line_segment(
            line,
            Stroke::new(width + 2.0, Color32::from_black_alpha(110)),
        );
        painter.line_segment(line, Stroke::new(width, Color32::from_gray(0xf2)));
        let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(8.0, 34.0));
        painter.rect(
            grip,
            4.0,
            Color32::from_gray(0xf2),
            Stroke::new(1.0, Color32::from_black_alpha(150)),
            egui::StrokeKind::Outside,
        );
        let (before, now) = (rect.with_max_x(x), rect.with_min_x(x));
        note(
            &left,
            before.shrink2(vec2(10.0, 0.0)),
            Corner::RightTop,
            "Snapshot",
        );
        let right = painter.with_clip_rect(now.intersect(painter.clip_rect()));
        note(&right, now.shrink2(vec2(10.0, 0.0)), Corner::LeftTop, "Now");
    }
}

/// There is one divider.
fn divider_id() -> Id {
    Id::unique("divider between snapshot and picture")
}

impl Snapshot {
    /// Where the snapshot lies in `rect`: as high as this and in the middle. That is how a camera sees more or less to
    /// the sides when the window's shape changes.
    fn place_in(&self, rect: Rect) -> Rect {
        let [width, height] = self.size.map(|side| side as f32);
        let size = vec2(rect.height() * width / height, rect.height());
        Rect::from_center_size(rect.center(), size)
    }
}
