//! Rows of what is no number in the design: one of several choices, yes or no, a colour.

use egui::{ComboBox, Response, Ui};
use renderer_core::design::{
    Back, BentAlong, Colour, EnvironmentKind, Filter, Fit, FormKind, Interpolation, LengthMap,
    Metering, Method, NoiseKind, Phase, PileKind, Sampler, Sheared, SkeletonHeight,
    SkeletonShading, ToneMap,
};

use crate::designer::widgets::{check_box, colour_well, hex_field, row};

/// One of a closed list of values.
pub trait Choice: Copy + PartialEq + 'static {
    /// All values, in menu order.
    const ALL: &'static [Self];
    /// What a menu calls it.
    fn label(self) -> &'static str;
    /// What it does.
    fn what(self) -> &'static str;
}

macro_rules! choices {
    ($($name:ident)+) => { $(
        impl Choice for $name {
            const ALL: &'static [Self] = $name::ALL;
            fn label(self) -> &'static str { $name::label(self) }
            fn what(self) -> &'static str { $name::what(self).trim() }
        }
    )+ };
}
choices!(
    Back BentAlong EnvironmentKind Filter Fit FormKind Interpolation LengthMap Metering Method NoiseKind Phase
    PileKind Sampler Sheared SkeletonHeight SkeletonShading ToneMap
);

/// Row with a menu of all values of an enumeration.
pub fn choice<C: Choice>(ui: &mut Ui, name: &str, what: &str, value: &mut C) {
    row(ui, name, what, |ui, label| {
        let combo = ComboBox::from_id_salt(name)
            .selected_text(value.label())
            .width(ui.available_width())
            .truncate()
            .show_ui(ui, |ui| {
                for &choice in C::ALL {
                    ui.selectable_value(value, choice, choice.label())
                        .on_hover_text(choice.what());
                }
            });
        let tooltip = format!("{what}\n{}: {}", value.label(), value.what());
        combo.response.labelled_by(label.id).on_hover_text(tooltip);
    });
}

/// Row with a check box.
pub fn check(ui: &mut Ui, name: &str, what: &str, value: &mut bool) {
    row(ui, name, what, |ui, label| {
        check_box(ui, value, "")
            .labelled_by(label.id)
            .on_hover_text(what);
    });
}

/// Row with a colour: a button that opens a picker, and the colour as text.
pub fn colour(ui: &mut Ui, name: &str, what: &str, value: &mut Colour) {
    row(ui, name, what, |ui, label| {
        colour_value(ui, what, value, label);
    });
}

/// The controls of a colour without their row, named by `label`.
pub fn colour_value(ui: &mut Ui, what: &str, value: &mut Colour, label: &Response) {
    colour_well(ui, &mut value.0)
        .labelled_by(label.id)
        .on_hover_text(what);
    hex_field(ui, &mut value.0).labelled_by(label.id);
}
