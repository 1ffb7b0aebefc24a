//! Light: suns, area lights, surroundings, background.

use egui::{Button, Color32, ColorImage, Ui, vec2};
use renderer_core::design::{
    AreaLight, Colour, Design, Environment, EnvironmentImage, EnvironmentKind, ImageSlot, Light,
    Sun,
};

use super::light_presets;
use super::light_sphere::{self, LightSource, LightSphere};
use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::{choice, colour};
use crate::designer::panels::image_preview::file_label;
use crate::designer::panels::number_row::number;
use crate::designer::shell::command::Command;
use crate::designer::widgets::{Thumbnail, about_dropping, show_thumbnail, subheading};

/// The lights' sphere and the picture of the surroundings.
#[derive(Default)]
pub struct State {
    sphere: LightSphere,
    thumbnail: Thumbnail<(EnvironmentImage, f64)>,
}

/// Columns of the picture of the surroundings, half of them, so that high resolutions have something to show.
const WIDTH: usize = 256;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    subheading(ui, "Light presets");
    if let Some(ready) = light_presets::show(ui, design) {
        state.sphere.selected = 0;
        *around.step_name = Some(format!("light: {}", ready.name().to_lowercase()));
    }
    subheading(ui, "Suns and area lights");
    ui.horizontal_top(|ui| {
        if let Some(step) = light_sphere::show(ui, &mut state.sphere, &mut design.light) {
            *around.step_name = Some(step.into());
        }
        ui.vertical(|ui| list(ui, &mut state.sphere.selected, design));
    });
    let light = &mut design.light;
    match LightSource::of(light, state.sphere.selected) {
        Some(LightSource::Sun(index)) => one_sun(ui, &mut light.sun[index]),
        Some(LightSource::Area(index)) => one_area(ui, &mut light.area[index]),
        None => {}
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

/// The lights by number, to choose one, and to have more or fewer.
fn list(ui: &mut Ui, selected: &mut usize, design: &mut Design) {
    ui.horizontal_wrapped(|ui| {
        for (index, source) in LightSource::all(&design.light).enumerate() {
            let button = ui.add(Button::new(source.name()).selected(*selected == index));
            if button
                .on_hover_text("Shows this light's numbers below.")
                .clicked()
            {
                *selected = index;
            }
        }
    });
    ui.add_space(4.0);
    let has_room = |what: &str, most: usize| format!("{what} At most {most}.");
    let (suns, areas) = (design.light.sun.len(), design.light.area.len());
    ui.horizontal_wrapped(|ui| {
        let add = ui.add_enabled(suns < Light::MAX_SUNS, Button::new("Add sun"));
        let what = "Light from far away.";
        if add.on_hover_text(has_room(what, Light::MAX_SUNS)).clicked() {
            design.light.sun.push(Sun::default());
            *selected = suns;
        }
        let add = ui.add_enabled(areas < Light::MAX_AREAS, Button::new("Add area light"));
        let what = "A rectangle that shines on the cloth: a softbox or a window.";
        if add
            .on_hover_text(has_room(what, Light::MAX_AREAS))
            .clicked()
        {
            let mut area = AreaLight::default();
            let nearest = design.nearest_area_mm(area.azimuth, area.elevation);
            area.distance = area.distance.max(nearest);
            design.light.area.push(area);
            *selected = suns + areas;
        }
    });
    let Some(source) = LightSource::of(&design.light, *selected) else {
        return;
    };
    let light = &mut design.light;
    let name = source.name().to_lowercase();
    ui.horizontal_wrapped(|ui| {
        let is_full = match source {
            LightSource::Sun(_) => suns == Light::MAX_SUNS,
            LightSource::Area(_) => areas == Light::MAX_AREAS,
        };
        let duplicate = ui.add_enabled(!is_full, Button::new(format!("Duplicate {name}")));
        if duplicate
            .on_hover_text("Another one with the same numbers.")
            .clicked()
        {
            *selected = match source {
                LightSource::Sun(index) => {
                    light.sun.push(light.sun[index].clone());
                    suns
                }
                LightSource::Area(index) => {
                    light.area.push(light.area[index].clone());
                    suns + areas
                }
            };
        }
        let remove = ui.button(format!("Remove {name}"));
        if remove.on_hover_text("Takes this light away.").clicked() {
            match source {
                LightSource::Sun(index) => drop(light.sun.remove(index)),
                LightSource::Area(index) => drop(light.area.remove(index)),
            }
            *selected = selected.saturating_sub(1);
        }
    });
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
    let dropping = about_dropping(ui.ctx(), "An .hdr or .exr");
    let what = format!(
        "Chooses an equirectangular image: .hdr or .exr with linear light, or a picture as .png or .jpg. \
         {dropping}"
    );
    if ui
        .button("Open surroundings…")
        .on_hover_text(what)
        .clicked()
    {
        around
            .commands
            .push(Command::OpenImage(ImageSlot::Environment));
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
        "As bright as it is in the scene, without exposure. Up is above the cloth, the middle beyond its far edge \
        unless it is turned.",
    );
    let path = environment.image.as_deref();
    file_label(ui, path, "not yet saved", image.file_size());
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

fn one_area(ui: &mut Ui, area: &mut AreaLight) {
    let fields = AreaLight::FIELDS;
    number(ui, &fields.azimuth, &mut area.azimuth);
    number(ui, &fields.elevation, &mut area.elevation);
    number(ui, &fields.distance, &mut area.distance);
    number(ui, &fields.width, &mut area.width);
    number(ui, &fields.height, &mut area.height);
    number(ui, &fields.irradiance, &mut area.irradiance);
    colour(ui, "Colour", "Colour of the light.", &mut area.colour);
}
