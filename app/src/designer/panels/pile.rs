//! Pile: the yarn loops, one of them seen close, and how they scatter light. How they lie is the panel Turbulence's.

use egui::Ui;
use renderer_core::design::{Design, Phase, Pile, PileKind};

use super::loop_picture::{self, LoopPicture};
use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::choice;
use crate::designer::panels::number_row::number;
use crate::designer::widgets::{more, subheading};

/// The loop seen close.
#[derive(Default)]
pub struct State {
    picture: LoopPicture,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    let (woven, thumbnails) = (around.woven, &mut *around.thumbnails);
    loop_picture::show(ui, &mut state.picture, design, woven, thumbnails);
    // Of the pile and, where the table counts, of its rows.
    let rows = design.length.rows();
    let some_kind = |is_so: fn(PileKind) -> bool| {
        is_so(design.pile.kind) || rows.iter().filter_map(|row| row.kind).any(is_so)
    };
    let has_plies = some_kind(|kind| kind.plies_are().is_some());
    let is_plied = some_kind(PileKind::is_plied);
    let pile = &mut design.pile;
    let fields = Pile::FIELDS;
    choice(ui, "Kind", "What a loop is made of.", &mut pile.kind);
    subheading(ui, "Yarn");
    number(ui, &fields.yarn_diameter, &mut pile.yarn_diameter);
    ui.add_enabled_ui(has_plies, |ui| number(ui, &fields.plies, &mut pile.plies));
    // Cut tufts open up: their fibres are not twisted.
    ui.add_enabled_ui(is_plied, |ui| {
        number(ui, &fields.twist_per_cm, &mut pile.twist_per_cm);
    });
    number(ui, &fields.fibres, &mut pile.fibres);
    number(ui, &fields.hairiness, &mut pile.hairiness);
    number(ui, &fields.density, &mut pile.density);
    subheading(ui, "Shape of a loop");
    number(ui, &fields.base_width, &mut pile.base_width);
    number(ui, &fields.top_width, &mut pile.top_width);
    number(ui, &fields.thickness, &mut pile.thickness);
    subheading(ui, "Nap");
    number(ui, &fields.lean_x, &mut pile.lean_x);
    number(ui, &fields.lean_y, &mut pile.lean_y);
    more(ui, "More about loops", |ui| {
        number(ui, &fields.max_length, &mut pile.max_length);
        number(ui, &fields.root_blend, &mut pile.root_blend);
        number(ui, &fields.variants, &mut pile.variants);
    });
    more(ui, "Light in the pile", |ui| light(ui, pile));
    more(ui, "Fineness of the volume", |ui| {
        number(ui, &fields.layers, &mut pile.layers);
        number(ui, &fields.resolution, &mut pile.resolution);
        choice(
            ui,
            "Interpolation",
            "How layers of the volume blend.",
            &mut pile.interpolation,
        );
    });
}

fn light(ui: &mut Ui, pile: &mut Pile) {
    let fields = Pile::FIELDS;
    choice(
        ui,
        "Scattering",
        "How a point of the pile scatters light.",
        &mut pile.phase,
    );
    number(ui, &fields.max_albedo, &mut pile.max_albedo);
    let is_surface = matches!(pile.phase, Phase::FrameLambert | Phase::GradientLambert);
    ui.add_enabled_ui(is_surface, |ui| {
        number(ui, &fields.transmission, &mut pile.transmission);
    });
    ui.add_enabled_ui(pile.phase == Phase::KajiyaKay, |ui| {
        number(ui, &fields.specular, &mut pile.specular);
        number(ui, &fields.exponent, &mut pile.exponent);
    });
}
