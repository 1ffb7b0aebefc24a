//! The table of loop lengths: a line for each colour of the chart, and what else its loops can have of their own.

use egui::{Button, ComboBox, Frame, Margin, Response, Ui};
use renderer_core::design::{Field, Length, LengthEntry, Phase, Pile, PileKind};

use crate::designer::panels::choice_row::{Choice, colour};
use crate::designer::panels::number_row::{number, number_value, optional_number};
use crate::designer::widgets::{colour_well, row};

/// Which row shows all it has.
#[derive(Default)]
pub struct State {
    open: Option<usize>,
}

/// Shows all rows.
pub fn show(ui: &mut Ui, state: &mut State, length: &mut Length, pile: &Pile) {
    let mut removed = None;
    for (index, entry) in length.table.iter_mut().enumerate() {
        ui.push_id(index, |ui| {
            if line(ui, state, index, entry) {
                removed = Some(index);
            }
            if state.open == Some(index) {
                Frame::new()
                    .inner_margin(Margin {
                        left: 8,
                        bottom: 6,
                        ..Margin::ZERO
                    })
                    .show(ui, |ui| more(ui, entry, pile));
            }
        });
    }
    if let Some(index) = removed {
        length.table.remove(index);
        state.open = None;
    }
}

/// Colour, length and kind; true when the row is to go.
fn line(ui: &mut Ui, state: &mut State, index: usize, entry: &mut LengthEntry) -> bool {
    let row = index + 1;
    ui.horizontal(|ui| {
        colour_well(ui, &mut entry.colour.0)
            .accessible_name(format!("Colour of row {row}"))
            .on_hover_text(
                "The chart's colour this row is for; other colours go to the nearest row.",
            );
        number_value(ui, &LengthEntry::FIELDS.length, &mut entry.length)
            .accessible_name(format!("Length of row {row}"));
        kind(ui, row, &mut entry.kind);
        let is_open = state.open == Some(index);
        let more = ui
            .add(Button::new("More").selected(is_open))
            .accessible_name(format!("More of row {row}"));
        if more
            .on_hover_text(
                "What else loops of this colour can have of their own: brightness, yarn, lean, width.",
            )
            .clicked()
        {
            state.open = (!is_open).then_some(index);
        }
        let remove = ui
            .add(Button::new("×").small())
            .accessible_name(format!("Remove row {row}"));
        remove
            .on_hover_text("Takes this row out of the table.")
            .clicked()
    })
    .inner
}

/// Kind of pile of a row, which may be that of the pile.
fn kind(ui: &mut Ui, row: usize, kind: &mut Option<PileKind>) {
    own_choice(ui, "kind", kind)
        .accessible_name(format!("Kind of row {row}"))
        .on_hover_text("Whether loops of this colour are cut or not.");
}

/// A menu of what a row has of its own, or as the pile.
pub(super) fn own_choice<C: Choice + 'static>(
    ui: &mut Ui,
    salt: &str,
    value: &mut Option<C>,
) -> Response {
    let as_pile = "as the pile";
    let combo = ComboBox::from_id_salt(salt)
        .selected_text(value.map_or(as_pile, Choice::label))
        .width(96.0)
        .truncate()
        .show_ui(ui, |ui| {
            ui.selectable_value(value, None, as_pile);
            for &choice in C::ALL {
                ui.selectable_value(value, Some(choice), Choice::label(choice))
                    .on_hover_text(Choice::what(choice));
            }
        });
    combo.response
}

/// What a row seldom has of its own.
fn more(ui: &mut Ui, entry: &mut LengthEntry, pile: &Pile) {
    colour(
        ui,
        "Colour",
        "The chart's colour this row is for; other colours go to the nearest row.",
        &mut entry.colour,
    );
    material(ui, entry, pile);
}

/// How the yarn of a row is and scatters light, where that is not as the pile's.
pub(super) fn material(ui: &mut Ui, entry: &mut LengthEntry, pile: &Pile) {
    let (fields, of_pile) = (LengthEntry::FIELDS, Pile::FIELDS);
    number(ui, &fields.albedo_scale, &mut entry.albedo_scale);
    let what = "How a point of the pile scatters light, for loops of this colour.";
    row(ui, "Own scattering", what, |ui, label| {
        own_choice(ui, "phase", &mut entry.phase)
            .labelled_by(label.id)
            .on_hover_text(what);
    });
    let mut own = |name, field: &Field, value: &mut Option<f64>, of_pile: f64| {
        let otherwise = format!("as the pile: {of_pile} {}", field.unit);
        optional_number(ui, name, field, value, of_pile, otherwise.trim());
    };
    own(
        "Own yarn",
        &of_pile.yarn_diameter,
        &mut entry.yarn_diameter,
        pile.yarn_diameter,
    );
    own(
        "Own density",
        &of_pile.density,
        &mut entry.density,
        pile.density,
    );
    own(
        "Own top width",
        &of_pile.top_width,
        &mut entry.top_width,
        pile.top_width,
    );
    own(
        "Own lean x",
        &of_pile.lean_x,
        &mut entry.lean_x,
        pile.lean_x,
    );
    own(
        "Own lean y",
        &of_pile.lean_y,
        &mut entry.lean_y,
        pile.lean_y,
    );
    own("Own tilt", &of_pile.tilt, &mut entry.tilt, pile.tilt);
    // Only the parameters that the row's way of scattering has; it keeps the others for when that changes.
    match entry.phase.unwrap_or(pile.phase) {
        Phase::Isotropic => {}
        Phase::FrameLambert | Phase::GradientLambert => own(
            "Own transmission",
            &of_pile.transmission,
            &mut entry.transmission,
            pile.transmission,
        ),
        Phase::KajiyaKay => {
            own(
                "Own specular",
                &of_pile.specular,
                &mut entry.specular,
                pile.specular,
            );
            own(
                "Own exponent",
                &of_pile.exponent,
                &mut entry.exponent,
                pile.exponent,
            );
        }
    }
}
