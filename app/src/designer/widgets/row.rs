//! A row of a panel: a label in a column of fixed width, then a control; and the headings between rows.

use egui::{
    Align, CollapsingHeader, Label, Layout, Response, RichText, Sense, Ui, UiBuilder, vec2,
};

use crate::designer::widgets::style::{LABEL_WIDTH, ROW_HEIGHT};

/// A label and what `controls` adds behind it. `controls` is given the label's response, to name its widgets by.
pub fn row<R>(
    ui: &mut Ui,
    label: &str,
    what: &str,
    controls: impl FnOnce(&mut Ui, &Response) -> R,
) -> R {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(LABEL_WIDTH, ROW_HEIGHT), Sense::hover());
        let place = UiBuilder::new()
            .max_rect(rect)
            .layout(Layout::left_to_right(Align::Center));
        // CLICK alone: a label reacts to a double click, but is no stop of the Tab key.
        let text = Label::new(label).truncate().sense(Sense::CLICK);
        let label = ui.new_child(place).add(text).on_hover_text(what);
        controls(ui, &label)
    })
    .inner
}

/// A quiet heading inside a panel.
pub fn subheading(ui: &mut Ui, text: &str) {
    ui.add_space(5.0);
    ui.label(RichText::new(text).small().strong());
}

/// Rows that are seldom needed, hidden until their heading is clicked.
pub fn more(ui: &mut Ui, heading: &str, rows: impl FnOnce(&mut Ui)) {
    ui.add_space(3.0);
    CollapsingHeader::new(RichText::new(heading).small().strong())
        .id_salt(heading)
        .show_unindented(ui, rows);
}

/// Text in a column of fixed width; a column that grew with its text would widen the whole panel.
pub fn fixed_text(ui: &mut Ui, width: f32, text: RichText) {
    let (rect, _) = ui.allocate_exact_size(vec2(width, ROW_HEIGHT), Sense::hover());
    let place = UiBuilder::new()
        .max_rect(rect)
        .layout(Layout::left_to_right(Align::Center));
    ui.new_child(place).add(Label::new(text).truncate());
}
