//! Pile: the yarn loops, the volume inside them, their lie, and how they scatter light.

use egui::Ui;
use renderer_core::design::{Phase, Pile};

use crate::designer::widgets::{choice, number, subheading};

/// Shows the panel.
pub fn show(ui: &mut Ui, pile: &mut Pile) {
    let fields = Pile::FIELDS;
    choice(ui, "Kind", "What a loop is made of.", &mut pile.kind);
    subheading(ui, "Loop");
    number(ui, &fields.base_width, &mut pile.base_width);
    number(ui, &fields.top_width, &mut pile.top_width);
    number(ui, &fields.thickness, &mut pile.thickness);
    number(ui, &fields.max_length, &mut pile.max_length);
    number(ui, &fields.root_blend, &mut pile.root_blend);
    subheading(ui, "Yarn");
    number(ui, &fields.yarn_diameter, &mut pile.yarn_diameter);
    number(ui, &fields.plies, &mut pile.plies);
    number(ui, &fields.twist_per_cm, &mut pile.twist_per_cm);
    number(ui, &fields.fibres, &mut pile.fibres);
    number(ui, &fields.hairiness, &mut pile.hairiness);
    number(ui, &fields.density, &mut pile.density);
    subheading(ui, "Lie");
    number(ui, &fields.lean_x, &mut pile.lean_x);
    number(ui, &fields.lean_y, &mut pile.lean_y);
    number(ui, &fields.tilt, &mut pile.tilt);
    number(ui, &fields.twist, &mut pile.twist);
    number(ui, &fields.stretch, &mut pile.stretch);
    number(ui, &fields.jitter, &mut pile.jitter);
    number(ui, &fields.twist_jitter, &mut pile.twist_jitter);
    number(ui, &fields.length_jitter, &mut pile.length_jitter);
    subheading(ui, "Light in the pile");
    choice(
        ui,
        "Phase",
        "How a point of the pile scatters light.",
        &mut pile.phase,
    );
    number(ui, &fields.max_albedo, &mut pile.max_albedo);
    ui.add_enabled_ui(
        matches!(pile.phase, Phase::FrameLambert | Phase::GradientLambert),
        |ui| {
            number(ui, &fields.transmission, &mut pile.transmission);
        },
    );
    ui.add_enabled_ui(pile.phase == Phase::KajiyaKay, |ui| {
        number(ui, &fields.specular, &mut pile.specular);
        number(ui, &fields.exponent, &mut pile.exponent);
    });
    subheading(ui, "Volume");
    number(ui, &fields.variants, &mut pile.variants);
    number(ui, &fields.layers, &mut pile.layers);
    number(ui, &fields.resolution, &mut pile.resolution);
    choice(
        ui,
        "Interpolation",
        "How layers of the volume blend.",
        &mut pile.interpolation,
    );
}
