//! View & quality: display, saved cameras, and how a final picture is made.

use egui::{Button, TextEdit, Ui};
use renderer_core::design::{CameraDesign, Design, Field, Method, Quality, View};

use super::Surroundings;
use crate::designer::command::Command;
use crate::designer::style::ROW_HEIGHT;
use crate::designer::widgets::{
    check, choice, number, number_value, optional_number, row, subheading,
};

/// Height of an orthographic picture; no part of the camera's own table because a camera need not have it.
const ORTHOGRAPHIC_HEIGHT: Field = Field {
    name: "orthographic_height",
    unit: "mm",
    default: 100.0,
    min: 0.001,
    max: 1_000_000.0,
    integer: false,
    what: "Height of the picture in mm of cloth; makes the view orthographic.",
};

/// One coordinate of the point that a camera looks at.
const TARGET: Field = Field {
    name: "target",
    unit: "",
    default: 0.0,
    min: -1_000_000.0,
    max: 1_000_000.0,
    integer: false,
    what: "Point looked at, mm from the middle of the cloth.",
};

/// Shows the panel.
pub fn show(ui: &mut Ui, design: &mut Design, around: &mut Surroundings<'_>) {
    let view = &mut design.view;
    number(ui, &View::FIELDS.exposure, &mut view.exposure);
    choice(
        ui,
        "Tone map",
        "How linear light becomes a displayed colour.",
        &mut view.tone_map,
    );
    cameras(ui, view, around);
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
    number(ui, &fields.traced_bounces, &mut quality.traced_bounces);
    number(ui, &fields.samples, &mut quality.samples);
    number(ui, &fields.error, &mut quality.error);
    let marches = matches!(quality.method, Method::Exact | Method::SixFace);
    ui.add_enabled_ui(marches, |ui| number(ui, &fields.step, &mut quality.step));
    number(ui, &fields.seed, &mut quality.seed);
    choice(
        ui,
        "Sampler",
        "Where random numbers come from.",
        &mut quality.sampler,
    );
    check(
        ui,
        "Shadows",
        "Pile and ground weave shade each other; without, light reaches every point they scatter it from.",
        &mut quality.shadows,
    );
}

fn cameras(ui: &mut Ui, view: &mut View, around: &mut Surroundings<'_>) {
    let mut removed = None;
    let count = view.cameras.len();
    for (index, camera) in view.cameras.iter_mut().enumerate() {
        ui.push_id(index, |ui| {
            subheading(ui, &format!("Camera {}", index + 1));
            let before = camera.clone();
            one_camera(ui, camera);
            if *camera != before {
                // Whoever turns a camera's numbers wants to see what they do.
                around.commands.push(Command::Look(camera.clone()));
            }
            ui.horizontal(|ui| {
                let number = index + 1;
                let look = ui
                    .small_button("Look")
                    .accessible_name(format!("Look through camera {number}"));
                if look
                    .on_hover_text("Shows the cloth as this camera sees it.")
                    .clicked()
                {
                    around.commands.push(Command::Look(camera.clone()));
                }
                let set = ui
                    .small_button("Set to view")
                    .accessible_name(format!("Set camera {number} to the view"));
                if set
                    .on_hover_text("Makes this camera see what the viewport shows.")
                    .clicked()
                {
                    *camera = CameraDesign {
                        name: camera.name.clone(),
                        ..around.camera.clone()
                    };
                }
                let remove = ui
                    .add_enabled(count > 1, Button::new("Remove").small())
                    .accessible_name(format!("Remove camera {number}"));
                if remove
                    .on_hover_text("A design has at least one camera.")
                    .clicked()
                {
                    removed = Some(index);
                }
            });
        });
    }
    if let Some(index) = removed {
        view.cameras.remove(index);
    }
    ui.add_space(2.0);
    let add = ui.button("Add camera from view");
    if add
        .on_hover_text("Saves what the viewport shows as a new camera.")
        .clicked()
    {
        view.cameras.push(CameraDesign {
            name: free_name(&view.cameras),
            ..around.camera.clone()
        });
    }
}

fn one_camera(ui: &mut Ui, camera: &mut CameraDesign) {
    let fields = CameraDesign::FIELDS;
    row(
        ui,
        "Name",
        "Name in menus and for --camera.",
        |ui, label| {
            let field = TextEdit::singleline(&mut camera.name)
                .char_limit(40)
                .align(egui::Align2::LEFT_CENTER);
            ui.add_sized([ui.available_width(), ROW_HEIGHT], field)
                .labelled_by(label.id);
        },
    );
    row(ui, "Target", TARGET.what, |ui, _| {
        for (axis, value) in ["x", "y", "z"].into_iter().zip(&mut camera.target) {
            number_value(ui, &TARGET, value).accessible_name(format!("Target {axis}"));
        }
    });
    number(ui, &fields.azimuth, &mut camera.azimuth);
    number(ui, &fields.elevation, &mut camera.elevation);
    number(ui, &fields.distance, &mut camera.distance);
    ui.add_enabled_ui(camera.orthographic_height.is_none(), |ui| {
        number(ui, &fields.fov, &mut camera.fov);
    });
    // What the perspective picture shows at the target, so that switching changes little.
    let same_height = 2.0 * camera.distance * (camera.fov.to_radians() / 2.0).tan();
    optional_number(
        ui,
        "Orthographic",
        &ORTHOGRAPHIC_HEIGHT,
        &mut camera.orthographic_height,
        same_height.clamp(ORTHOGRAPHIC_HEIGHT.min, ORTHOGRAPHIC_HEIGHT.max),
        "off",
    );
}

/// "view 2", or the first such name that no camera has.
fn free_name(cameras: &[CameraDesign]) -> String {
    let taken = |name: &String| cameras.iter().any(|camera| camera.name == *name);
    let mut names = (cameras.len() + 1..).map(|number| format!("view {number}"));
    names.find(|name| !taken(name)).unwrap_or_default()
}
