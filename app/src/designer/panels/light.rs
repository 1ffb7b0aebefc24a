//! Light: suns, surroundings, background.

use egui::Ui;
use renderer_core::design::{Environment, Light, Sun};

use crate::designer::widgets::{choice, colour, number, subheading, subheading_with};

/// Shows the panel.
pub fn show(ui: &mut Ui, light: &mut Light) {
    let mut removed = None;
    let count = light.sun.len();
    for (index, sun) in light.sun.iter_mut().enumerate() {
        ui.push_id(index, |ui| {
            subheading_with(ui, &format!("Sun {}", index + 1), |ui| {
                let remove = ui
                    .small_button("Remove")
                    .accessible_name(format!("Remove sun {}", index + 1));
                if remove.on_hover_text("Takes this sun away.").clicked() {
                    removed = Some(index);
                }
            });
            one_sun(ui, sun);
        });
    }
    if let Some(index) = removed {
        light.sun.remove(index);
    }
    ui.add_space(2.0);
    let add = ui.add_enabled(count < Light::MAX_SUNS, egui::Button::new("Add sun"));
    if add
        .on_hover_text(format!("At most {} suns.", Light::MAX_SUNS))
        .clicked()
    {
        light.sun.push(Sun::default());
    }
    subheading(ui, "Surroundings");
    let environment = &mut light.environment;
    choice(
        ui,
        "Kind",
        "How light from all around varies with direction.",
        &mut environment.kind,
    );
    number(ui, &Environment::FIELDS.radiance, &mut environment.radiance);
    ui.push_id("environment", |ui| {
        colour(
            ui,
            "Colour",
            "Colour of the light from all around.",
            &mut environment.colour,
        );
    });
    subheading(ui, "Background");
    ui.push_id("background", |ui| {
        colour(
            ui,
            "Colour",
            "Colour seen where there is no cloth; it gives no light.",
            &mut light.background,
        );
    });
}

fn one_sun(ui: &mut Ui, sun: &mut Sun) {
    let fields = Sun::FIELDS;
    number(ui, &fields.azimuth, &mut sun.azimuth);
    number(ui, &fields.elevation, &mut sun.elevation);
    number(ui, &fields.irradiance, &mut sun.irradiance);
    number(ui, &fields.angular_diameter, &mut sun.angular_diameter);
    colour(ui, "Colour", "Colour of the light.", &mut sun.colour);
}
