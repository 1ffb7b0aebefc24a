//! The menu of ready patterns.

use egui::{Align2, Popup, Response, Role, Sense, StrokeKind, TextStyle, Ui, WidgetInfo, vec2};
use renderer_core::design::{LibraryWeave, WEAVE_LIBRARY, Weave};

use super::legend;

/// Size of an entry of the menu, points.
const ENTRY: egui::Vec2 = egui::Vec2 { x: 92.0, y: 78.0 };
/// Side of an entry's picture, points: whole repeats of 2, 3, 4 and 8 cells.
const PICTURE: f32 = 48.0;

/// A button that opens the menu.
pub(super) fn menu(ui: &mut Ui, weave: &mut Weave) {
    let button = ui.button("Ready patterns…").on_hover_text(
        "Replaces the pattern with a weave that every mill knows: plain, twill, satin, terry and more.",
    );
    Popup::menu(&button).show(|ui| {
        ui.set_width(4.0 * ENTRY.x + 3.0 * ui.spacing().item_spacing.x);
        for four in WEAVE_LIBRARY.chunks(4) {
            ui.horizontal(|ui| {
                for ready in four {
                    if entry(ui, ready, weave).clicked() {
                        ready.apply(weave);
                        ui.close();
                    }
                }
            });
        }
    });
}

fn entry(ui: &mut Ui, ready: &LibraryWeave, weave: &Weave) -> Response {
    let (rect, response) = ui.allocate_exact_size(ENTRY, Sense::click());
    let pattern = ready.pattern();
    let is_used = pattern == weave.pattern;
    response
        .widget_info(|| WidgetInfo::selected(Role::Button, ui.is_enabled(), is_used, ready.name));
    let look = ui.style().interact_selectable(&response, is_used);
    if is_used || response.hovered() || response.has_focus() {
        ui.painter().rect(
            rect,
            look.corner_radius,
            look.weak_bg_fill,
            look.bg_stroke,
            StrokeKind::Inside,
        );
    }
    let picture = egui::Rect::from_min_size(
        egui::pos2(rect.center().x - PICTURE / 2.0, rect.top() + 6.0),
        vec2(PICTURE, PICTURE),
    );
    legend::paint(ui, &pattern, picture, 4.0);
    let name_place = egui::pos2(rect.center().x, (picture.bottom() + rect.bottom()) / 2.0);
    ui.painter().text(
        name_place,
        Align2::CENTER_CENTER,
        ready.name,
        TextStyle::Body.resolve(ui.style()),
        look.text_color(),
    );
    response.on_hover_text(ready.what)
}
