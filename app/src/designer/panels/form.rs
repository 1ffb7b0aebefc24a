//! Form: how the cloth lies in space.

use std::ops::RangeInclusive;

use egui::{Color32, ColorImage, Response, Ui, vec2};
use renderer_core::design::{Design, Form, FormKind, HeightImage, ImageSlot};
use renderer_core::scene::{Net, net_through};

use crate::designer::panels::choice_row::{check, choice};
use crate::designer::panels::image_preview::file_label;
use crate::designer::panels::number_row::number;
use crate::designer::shell::command::Command;
use crate::designer::widgets::{NumberField, Thumbnail, row, show_thumbnail};

/// Rows and columns of a net that is new.
const NEW_NET: usize = 5;

/// Longest side of the height picture as it is shown, points.
const SIDE: f32 = 200.0;

/// What the panel remembers: the point of the net whose place it shows, and the height picture.
#[derive(Default)]
pub struct State {
    row: usize,
    column: usize,
    thumbnail: Thumbnail<HeightImage>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, commands: &mut Vec<Command>) {
    let fields = Form::FIELDS;
    let kind = design.form.kind;
    choice(ui, "Lies", "How the cloth lies.", &mut design.form.kind);
    if design.form.kind == FormKind::Net && design.form.net.is_empty() {
        design.form.net = level_net(design, [NEW_NET; 2]);
    }
    let form = &mut design.form;
    if matches!(
        form.kind,
        FormKind::Wave | FormKind::Roll | FormKind::Hanging | FormKind::Stack
    ) {
        choice(ui, "Bent", "Which way the cloth is bent.", &mut form.along);
    }
    match form.kind {
        FormKind::Flat => {}
        FormKind::Wave => {
            number(ui, &fields.wavelength, &mut form.wavelength);
            number(ui, &fields.steepness, &mut form.steepness);
        }
        FormKind::Roll => {
            number(ui, &fields.rolled, &mut form.rolled);
            number(ui, &fields.radius, &mut form.radius);
            number(ui, &fields.gap, &mut form.gap);
            check(
                ui,
                "Front inside",
                "Rolls have the front inside; else the back.",
                &mut form.front_inside,
            );
        }
        FormKind::Hanging => {
            number(ui, &fields.radius, &mut form.radius);
            number(ui, &fields.wavelength, &mut form.wavelength);
            number(ui, &fields.steepness, &mut form.steepness);
        }
        FormKind::Stack => {
            number(ui, &fields.layers, &mut form.layers);
            number(ui, &fields.gap, &mut form.gap);
        }
        FormKind::Net => net(ui, state, design),
        FormKind::Height => height(ui, state, form, commands),
    }
    if design.form.kind != kind {
        // Another form is seldom where the last one was.
        commands.push(Command::Fit);
    }
}

/// The height picture: opening it, and how it looks.
fn height(ui: &mut Ui, state: &mut State, form: &mut Form, commands: &mut Vec<Command>) {
    let open = ui.button("Open height picture…");
    let what = "Chooses a grey picture that covers the cloth: the brighter, the higher.";
    if open.on_hover_text(what).clicked() {
        commands.push(Command::OpenImage(ImageSlot::Height));
    }
    if let Some(picture) = &form.pixels {
        let texture = state
            .thumbnail
            .texture(ui, "heights", picture.clone(), as_shown);
        let size = vec2(picture.width() as f32, picture.height() as f32);
        let size = (size * (SIDE / size.max_elem())).max(vec2(4.0, 4.0));
        ui.add_space(2.0);
        show_thumbnail(ui, &texture, size, "Height picture");
        let size = [picture.width(), picture.height()];
        file_label(ui, form.image.as_deref(), "not yet saved", size);
    } else {
        ui.weak("No picture yet: the cloth is shown as it lay before.");
    }
    number(ui, &Form::FIELDS.height, &mut form.height);
    number(ui, &Form::FIELDS.smooth, &mut form.smooth);
}

/// The height picture at twice the shown size at most: of a large one every nth pixel.
fn as_shown(picture: &HeightImage) -> ColorImage {
    let step = picture
        .width()
        .max(picture.height())
        .div_ceil(2 * SIDE as usize);
    let size = [picture.width(), picture.height()].map(|side| side.div_ceil(step));
    let grey = |k: usize| picture.row(k / size[0] * step)[k % size[0] * step];
    let pixels = (0..size[0] * size[1]).map(|k| Color32::from_gray((grey(k) >> 8) as u8));
    ColorImage::new(size, pixels.collect())
}

/// A net that leaves the cloth level.
fn level_net(design: &Design, size: [usize; 2]) -> Vec<Vec<[f64; 3]>> {
    let sheet = &design.sheet;
    let width = f64::from(sheet.warps) * sheet.pitch_x();
    let length = f64::from(sheet.wefts) * sheet.pitch_y();
    net_through(size, |across, along| {
        [width * (across - 0.5), length * (along - 0.5), 0.0]
    })
}

/// A field for how many there are, or which of them.
fn count(ui: &mut Ui, value: &mut usize, range: RangeInclusive<usize>) -> Response {
    NumberField::new(value, "", range).speed(0.05).show(ui)
}

fn net(ui: &mut Ui, state: &mut State, design: &mut Design) {
    ui.weak("Drag the points in the picture; with Alt they go straight up and down.");
    let rows = design.form.net.len();
    let columns = design.form.net.first().map_or(0, Vec::len);
    let mut size = [columns, rows];
    row(
        ui,
        "Points",
        "How many points the net has along the weft and along the warp.",
        |ui, label| {
            count(ui, &mut size[0], Form::NET_SIZES).labelled_by(label.id);
            ui.label("×");
            count(ui, &mut size[1], Form::NET_SIZES).labelled_by(label.id);
            let level = ui.button("Lay level");
            if level
                .on_hover_text("Puts all points where they leave the cloth level.")
                .clicked()
            {
                design.form.net = level_net(design, size);
            }
        },
    );
    if size != [columns, rows] && rows >= 4 && columns >= 4 {
        // The same surface, as nearly as so many points can pull it.
        let surface = Net::new(&design.form.net);
        design.form.net = net_through(size, |across, along| surface.at(across, along).to_array());
    }
    let net = &mut design.form.net;
    let [last_row, last_column] = [
        net.len().saturating_sub(1),
        net.first().map_or(0, |row| row.len().saturating_sub(1)),
    ];
    (state.row, state.column) = (state.row.min(last_row), state.column.min(last_column));
    // From 1, as rows are counted everywhere in the window.
    let [mut row_number, mut column_number] = [state.row + 1, state.column + 1];
    row(
        ui,
        "Point",
        "Which point: its column from the left, and its row from the near edge.",
        |ui, label| {
            count(ui, &mut column_number, 1..=last_column + 1).labelled_by(label.id);
            count(ui, &mut row_number, 1..=last_row + 1).labelled_by(label.id);
        },
    );
    (state.row, state.column) = (row_number - 1, column_number - 1);
    let Some(point) = net
        .get_mut(state.row)
        .and_then(|row| row.get_mut(state.column))
    else {
        return;
    };
    row(
        ui,
        "Place",
        "Where the point is: along the weft, along the warp, and up.",
        |ui, label| {
            for value in point {
                let range = -Form::FARTHEST_MM..=Form::FARTHEST_MM;
                let place = NumberField::new(value, "mm", range).speed(0.5);
                place.max_decimals(1).show(ui).labelled_by(label.id);
            }
            ui.weak("mm");
        },
    );
}
