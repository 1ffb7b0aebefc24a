//! The design's saved views: shown, named, set anew, put in order, removed.

use egui::{CollapsingHeader, RichText, Sides, TextEdit, Ui};
use renderer_core::design::{CameraDesign, Field, View};

use super::surroundings::Surroundings;
use crate::designer::panels::number_row::{number, number_value, optional_number};
use crate::designer::shell::command::Command;
use crate::designer::viewport::command::ViewCommand;
use crate::designer::widgets::style::ROW_HEIGHT;
use crate::designer::widgets::{Icon, IconButton, row, subheading};

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

/// What is asked of one of the views.
#[derive(Clone, Copy)]
enum Action {
    Look,
    Set,
    Up,
    Down,
    Remove,
}

/// Shows all saved views.
pub fn show(ui: &mut Ui, view: &mut View, around: &mut Surroundings<'_>) {
    subheading(ui, "Saved views");
    let count = view.cameras.len();
    let mut asked = None;
    for (index, camera) in view.cameras.iter_mut().enumerate() {
        ui.push_id(index, |ui| {
            let title = format!("View {}", index + 1);
            ui.add_space(5.0);
            Sides::new().show(
                ui,
                |ui| ui.label(RichText::new(title).small()),
                |ui| {
                    if let Some(action) = actions(ui, index, count) {
                        asked = Some((index, action));
                    }
                },
            );
            let before = camera.clone();
            one_camera(ui, camera, count == 1);
            let is_moved = CameraDesign {
                name: before.name.clone(),
                ..camera.clone()
            } != before;
            if is_moved {
                // Whoever turns a camera's numbers wants to see what they do.
                around.commands.push(Command::Look(camera.clone()));
            }
        });
    }
    if let Some((index, action)) = asked {
        carry_out(view, index, action, around);
    }
    ui.add_space(2.0);
    let add = ui.button("Save this view");
    let add = add.on_hover_text("Saves the view you see now in the design.");
    if add.clicked() {
        view.cameras.push(CameraDesign {
            name: free_name(&view.cameras, ""),
            ..around.camera.clone()
        });
    }
}

/// Buttons of one view, from the right.
fn actions(ui: &mut Ui, index: usize, count: usize) -> Option<Action> {
    let number = index + 1;
    let buttons = [
        (
            Action::Remove,
            Icon::Minus,
            count > 1,
            format!("Remove view {number}"),
            "Removes this view from the design, which has at least one.",
        ),
        (
            Action::Down,
            Icon::ShiftDown,
            number < count,
            format!("Move view {number} down"),
            "Later in the list of saved views and their keys Alt+1 to Alt+9.",
        ),
        (
            Action::Up,
            Icon::ShiftUp,
            index > 0,
            format!("Move view {number} up"),
            "Earlier in the list of saved views and their keys Alt+1 to Alt+9.",
        ),
        (
            Action::Set,
            Icon::Pencil,
            true,
            format!("Set view {number} to what is seen"),
            "Makes this view what the viewport shows now.",
        ),
        (
            Action::Look,
            Icon::Eye,
            true,
            format!("Show view {number}"),
            "Shows the cloth as this view sees it.",
        ),
    ];
    let mut asked = None;
    for (action, icon, enabled, name, what) in buttons {
        let button = ui.add_enabled(enabled, IconButton::new(icon, &name, what));
        if button.clicked() {
            asked = Some(action);
        }
    }
    asked
}

fn carry_out(view: &mut View, index: usize, action: Action, around: &mut Surroundings<'_>) {
    match action {
        Action::Look => around
            .commands
            .push(Command::View(ViewCommand::Camera(index))),
        Action::Set => {
            let camera = &mut view.cameras[index];
            *camera = CameraDesign {
                name: camera.name.clone(),
                ..around.camera.clone()
            };
        }
        Action::Up => view.cameras.swap(index - 1, index),
        Action::Down => view.cameras.swap(index, index + 1),
        Action::Remove => {
            view.cameras.remove(index);
        }
    }
}

fn one_camera(ui: &mut Ui, camera: &mut CameraDesign, is_only: bool) {
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
    // One view is looked at in numbers; a list of many is read by names.
    CollapsingHeader::new("Place and direction")
        .default_open(is_only)
        .show_unindented(ui, |ui| numbers(ui, camera));
}

fn numbers(ui: &mut Ui, camera: &mut CameraDesign) {
    let fields = CameraDesign::FIELDS;
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

/// This name, or where it is empty or taken the first "view 2", "name 2" … that no camera has.
pub fn free_name(cameras: &[CameraDesign], wanted: &str) -> String {
    let is_free = |name: &String| cameras.iter().all(|camera| camera.name != *name);
    let (stem, from) = match wanted {
        "" => ("view", cameras.len() + 1),
        wanted => (wanted, 2),
    };
    let first = (!wanted.is_empty()).then(|| wanted.to_owned());
    let numbered = (from..).map(|number| format!("{stem} {number}"));
    first
        .into_iter()
        .chain(numbered)
        .find(is_free)
        .unwrap_or_default()
}
