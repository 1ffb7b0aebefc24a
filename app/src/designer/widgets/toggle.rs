//! Check boxes and radio buttons, outlined: what is inside may be as light or dark as what is around, and
//! then the outline is all that shows there is something to press.

use egui::{Response, Stroke, Ui};

use crate::designer::widgets::style;

/// A check box. Without a text it is named by its label.
pub fn check_box(ui: &mut Ui, value: &mut bool, text: impl Into<String>) -> Response {
    outlined(ui, |ui| ui.checkbox(value, text.into()))
}

/// A radio button.
pub fn radio_button(ui: &mut Ui, is_on: bool, text: impl Into<String>) -> Response {
    outlined(ui, |ui| ui.radio(is_on, text.into()))
}

fn outlined(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    let outline = Stroke::new(1.0, style::mark_outline(ui.visuals()));
    ui.scope(|ui| {
        let ground = ui.visuals().extreme_bg_color;
        let widgets = &mut ui.visuals_mut().widgets;
        for look in [&mut widgets.inactive, &mut widgets.hovered] {
            (look.bg_fill, look.bg_stroke) = (ground, outline);
        }
        add(ui)
    })
    .inner
}
