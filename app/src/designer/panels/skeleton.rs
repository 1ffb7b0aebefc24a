//! Skeleton: the ground weave's yarns.

use egui::Ui;
use renderer_core::design::{SkeletonDesign, SkeletonShading};

use crate::designer::panels::choice_row::{check, choice, colour};
use crate::designer::panels::number_row::number;
use crate::designer::widgets::more;

/// Shows the panel.
pub fn show(ui: &mut Ui, skeleton: &mut SkeletonDesign) {
    let fields = SkeletonDesign::FIELDS;
    check(
        ui,
        "Visible",
        "Whether the ground weave is drawn.",
        &mut skeleton.visible,
    );
    colour(
        ui,
        "Colour",
        "Colour of the ground yarns.",
        &mut skeleton.colour,
    );
    number(ui, &fields.warp_radius, &mut skeleton.warp_radius);
    number(ui, &fields.weft_radius, &mut skeleton.weft_radius);
    number(ui, &fields.crimp, &mut skeleton.crimp);
    more(ui, "More about ground yarns", |ui| {
        choice(
            ui,
            "Height",
            "How the height of a ground yarn follows over and under.",
            &mut skeleton.height,
        );
        choice(
            ui,
            "Shading",
            "How a ground yarn scatters light.",
            &mut skeleton.shading,
        );
        let shading = skeleton.shading;
        ui.add_enabled_ui(shading != SkeletonShading::Lambert, |ui| {
            number(ui, &fields.specular, &mut skeleton.specular);
            number(ui, &fields.exponent, &mut skeleton.exponent);
        });
        ui.add_enabled_ui(shading == SkeletonShading::PoulinFournier, |ui| {
            number(ui, &fields.fibre_spacing, &mut skeleton.fibre_spacing);
        });
    });
}
