//! A button with an icon: does something, or is one of several that can be on.

use egui::{Response, Role, Sense, Ui, Vec2, Widget, WidgetInfo, vec2};

use super::icon::Icon;
use crate::designer::widgets::style::ROW_HEIGHT;

/// Side of the icon on a button, points.
const ICON: f32 = 16.0;

/// A button with an icon. It has no text, so its name is what a screen reader says and the tooltip says what it does.
#[must_use = "add it to a Ui"]
pub struct IconButton<'a> {
    icon: Icon,
    name: &'a str,
    tooltip: &'a str,
    on: Option<bool>,
    size: Vec2,
}

impl<'a> IconButton<'a> {
    /// A button that does something when clicked.
    pub fn new(icon: Icon, name: &'a str, tooltip: &'a str) -> Self {
        Self {
            icon,
            name,
            tooltip,
            on: None,
            size: vec2(ROW_HEIGHT + 3.0, ROW_HEIGHT),
        }
    }

    /// Makes it one that is on or off.
    pub fn on(mut self, on: bool) -> Self {
        self.on = Some(on);
        self
    }
}

impl Widget for IconButton<'_> {
    fn ui(self, ui: &mut Ui) -> Response {
        let (rect, response) = ui.allocate_exact_size(self.size, Sense::click());
        let enabled = ui.is_enabled();
        response.widget_info(|| match self.on {
            Some(on) => WidgetInfo::selected(Role::Button, enabled, on, self.name),
            None => WidgetInfo::labeled(Role::Button, enabled, self.name),
        });
        if ui.is_rect_visible(rect) {
            let look = ui
                .style()
                .interact_selectable(&response, self.on == Some(true));
            // At rest only what is on has a ground: a row of tools is no row of boxes.
            if self.on == Some(true) || response.hovered() || response.has_focus() {
                ui.painter().rect(
                    rect,
                    look.corner_radius,
                    look.weak_bg_fill,
                    look.bg_stroke,
                    egui::StrokeKind::Inside,
                );
            }
            let place = egui::Rect::from_center_size(rect.center(), Vec2::splat(ICON));
            self.icon.paint(ui.painter(), place, look.text_color());
        }
        let tooltip = if self.tooltip.is_empty() {
            self.name
        } else {
            self.tooltip
        };
        response
            .on_hover_text(tooltip)
            .on_disabled_hover_text(tooltip)
    }
}
