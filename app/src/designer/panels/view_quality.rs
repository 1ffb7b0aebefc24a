//! View & quality: display, saved cameras, and how a final picture is made.

use egui::Ui;
use renderer_core::design::{Design, Method, Quality, View};

use super::cameras;
use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::{check, choice};
use crate::designer::panels::number_row::number;
use crate::designer::widgets::{more, subheading};

/// Shows the panel.
pub fn show(ui: &mut Ui, design: &mut Design, around: &mut Surroundings<'_>) {
    let view = &mut design.view;
    choice(
        ui,
        "Exposure from",
        "What exposure counts from: white cloth under these lights, or the light as it is.",
        &mut view.metering,
    );
    number(ui, &View::FIELDS.exposure, &mut view.exposure);
    choice(
        ui,
        "Tone map",
        "How linear light becomes a displayed colour.",
        &mut view.tone_map,
    );
    cameras::show(ui, view, around);
    subheading(ui, "Quality of the final picture");
    let fields = Quality::FIELDS;
    let quality = &mut design.quality;
    choice(
        ui,
        "Method",
        "How a ray gathers light from the loops it crosses.",
        &mut quality.method,
    );
    number(ui, &fields.bounces, &mut quality.bounces);
    number(ui, &fields.samples, &mut quality.samples);
    number(ui, &fields.error, &mut quality.error);
    check(
        ui,
        "Shadows",
        "Pile and ground weave shade each other; without, light reaches every point they scatter it from.",
        &mut quality.shadows,
    );
    more(ui, "More about quality", |ui| {
        let marches = matches!(quality.method, Method::Exact | Method::SixFace);
        ui.add_enabled_ui(marches, |ui| number(ui, &fields.step, &mut quality.step));
        number(ui, &fields.seed, &mut quality.seed);
        choice(
            ui,
            "Sampler",
            "Where random numbers come from.",
            &mut quality.sampler,
        );
    });
}
