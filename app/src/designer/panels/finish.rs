//! Finish: what happens to the loops after weaving, and which way they are brushed.

use egui::Ui;
use renderer_core::design::{Design, Finish, Sheared};

use super::nap;
use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::choice;
use crate::designer::panels::number_row::number;
use crate::designer::widgets::subheading;

/// Shows the panel.
pub fn show(
    ui: &mut Ui,
    state: &mut nap::State,
    design: &mut Design,
    around: &mut Surroundings<'_>,
) {
    let fields = Finish::FIELDS;
    let finish = &mut design.finish;
    choice(
        ui,
        "Shorn",
        "Which faces of the cloth are shorn: loops become the tufts of velour.",
        &mut finish.sheared,
    );
    ui.add_enabled_ui(finish.sheared != Sheared::None, |ui| {
        number(ui, &fields.shear_height, &mut finish.shear_height);
    });
    subheading(ui, "Wear");
    number(ui, &fields.pulled, &mut finish.pulled);
    ui.add_enabled_ui(finish.pulled > 0.0, |ui| {
        number(ui, &fields.pulled_length, &mut finish.pulled_length);
    });
    subheading(ui, "Water");
    number(ui, &fields.wetness, &mut finish.wetness);
    ui.add_enabled_ui(finish.wetness > 0.0, |ui| {
        number(ui, &fields.clump_size, &mut finish.clump_size);
    });
    nap::show(ui, state, design, around);
}
