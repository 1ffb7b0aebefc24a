//! Light: suns, surroundings, background.

use egui::{Button, Color32, ColorImage, Ui, vec2};
use renderer_core::design::{Colour, Environment, EnvironmentImage, EnvironmentKind, Light, Sun};

use super::light_sphere::{self, LightSphere};
use super::{Surroundings, ready_lights};
use crate::designer::command::Command;
use crate::designer::widgets::{Thumbnail, choice, colour, number, show_thumbnail, subheading};

/// The suns' sphere and the picture of the surroundings.
#[derive(Default)]
pub struct State {
    sphere: LightSphere,
    thumbnail: Thumbnail<(EnvironmentImage, f64)>,
}

/// Columns of the picture of the surroundings, half of them, so that high resolutions have something to show.
const WIDTH: usize = 256;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, light: &mut Light, around: &mut Surroundings<'_>) {
    subheading(ui, "Ready lights");
    if let Some(ready) = ready_lights::show(ui, light) {
        state.sphere.selected = 0;
        *around.step_name = Some(format!("light: {}", ready.name().to_lowercase()));
    }
    subheading(ui, "Suns");
    ui.horizontal_top(|ui| {
        if light_sphere::show(ui, &mut state.sphere, light) {
            *around.step_name = Some("moved sun".into());
        }
        ui.vertical(|ui| list(ui, &mut state.sphere.selected, light));
    });
    if let Some(sun) = light.sun.get_mut(state.sphere.selected) {
        one_sun(ui, sun);
    }
    subheading(ui, "Surroundings");
    ui.push_id("environment", |ui| {
        surroundings(ui, state, &mut light.environment, around);
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

/// The suns by number, to choose one, and to have more or fewer.
fn list(ui: &mut Ui, selected: &mut usize, light: &mut Light) {
    ui.horizontal_wrapped(|ui| {
        for index in 0..light.sun.len() {
            let name = format!("Sun {}", index + 1);
            let button = ui.add(Button::new(name).selected(*selected == index));
            if button
                .on_hover_text("Shows this sun's numbers below.")
                .clicked()
            {
                *selected = index;
            }
        }
    });
    ui.add_space(4.0);
    let add = ui.add_enabled(light.sun.len() < Light::MAX_SUNS, Button::new("Add sun"));
    if add
        .on_hover_text(format!("At most {} suns.", Light::MAX_SUNS))
        .clicked()
    {
        light.sun.push(Sun::default());
        *selected = light.sun.len() - 1;
    }
    if *selected < light.sun.len() {
        let remove = ui.button(format!("Remove sun {}", *selected + 1));
        if remove.on_hover_text("Takes this sun away.").clicked() {
            light.sun.remove(*selected);
            *selected = selected.saturating_sub(1);
        }
    }
}

fn surroundings(
    ui: &mut Ui,
    state: &mut State,
    environment: &mut Environment,
    around: &mut Surroundings<'_>,
) {
    choice(
        ui,
        "Kind",
        "How light from all around varies with direction.",
        &mut environment.kind,
    );
    if environment.kind == EnvironmentKind::Image {
        picture(ui, state, environment, around);
    }
    number(ui, &Environment::FIELDS.radiance, &mut environment.radiance);
    match environment.kind {
        EnvironmentKind::Constant => colour(
            ui,
            "Colour",
            "Colour of the light from all around.",
            &mut environment.colour,
        ),
        EnvironmentKind::Gradient => {
            let mut part = |name, what, value| colour(ui, name, what, value);
            part(
                "Zenith",
                "Colour straight above the cloth.",
                &mut environment.zenith,
            );
            part(
                "Horizon",
                "Colour all around in the cloth's plane.",
                &mut environment.horizon,
            );
            part("Ground", "Colour below the cloth.", &mut environment.ground);
        }
        EnvironmentKind::Image => {}
    }
    ui.add_enabled_ui(environment.kind == EnvironmentKind::Image, |ui| {
        number(ui, &Environment::FIELDS.rotation, &mut environment.rotation);
    });
}

/// The image of the surroundings: opening it, and how it looks.
fn picture(
    ui: &mut Ui,
    state: &mut State,
    environment: &mut Environment,
    around: &mut Surroundings<'_>,
) {
    let open = ui.button("Open surroundings…");
    if open
        .on_hover_text(
            "Chooses an equirectangular image: .hdr or .exr with linear light, .png or .jpg. An .hdr or .exr can also be \
             dropped on the window.",
        )
        .clicked()
    {
        around.commands.push(Command::OpenEnvironment);
    }
    let Some(image) = &environment.pixels else {
        ui.weak("No image yet: the picture shows the last light.");
        return;
    };
    let key = (image.clone(), environment.radiance);
    let texture = state
        .thumbnail
        .texture(ui, "surroundings", key, |(image, radiance)| {
            as_seen(image, *radiance)
        });
    ui.add_space(2.0);
    let width = ui.available_width().min(2.0 * WIDTH as f32);
    let size = vec2(width, width / 2.0);
    show_thumbnail(ui, &texture, size, "Image of the surroundings").on_hover_text(
        "As bright as it is in the scene, without exposure. Up is above the cloth, the middle beyond its far edge unless it is turned.",
    );
    let path = environment.image.as_deref().unwrap_or("not yet saved");
    let name = std::path::Path::new(path)
        .file_name()
        .map_or_else(|| path.into(), |name| name.to_string_lossy());
    let [width, height] = image.file_size();
    ui.weak(format!("{name}, {width} × {height} px"))
        .on_hover_text(path);
}

/// The surroundings at twice the shown size at most, in displayed colours.
fn as_seen(image: &EnvironmentImage, radiance: f64) -> ColorImage {
    let step = image.width().div_ceil(2 * WIDTH);
    let size = [image.width().div_ceil(step), image.height().div_ceil(step)];
    let pixels = (0..size[0] * size[1])
        .map(|k| {
            let linear = image.pixel(k % size[0] * step, k / size[0] * step);
            let Colour([r, g, b]) = Colour::from_linear(linear.map(|c| f64::from(c) * radiance));
            Color32::from_rgb(r, g, b)
        })
        .collect();
    ColorImage::new(size, pixels)
}

fn one_sun(ui: &mut Ui, sun: &mut Sun) {
    let fields = Sun::FIELDS;
    number(ui, &fields.azimuth, &mut sun.azimuth);
    number(ui, &fields.elevation, &mut sun.elevation);
    number(ui, &fields.irradiance, &mut sun.irradiance);
    number(ui, &fields.angular_diameter, &mut sun.angular_diameter);
    colour(ui, "Colour", "Colour of the light.", &mut sun.colour);
}
