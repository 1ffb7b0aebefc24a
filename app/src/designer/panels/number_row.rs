//! The row of a number of the design: slider, typed value and unit, from the field's own table; a double click resets
//! it.

use egui::emath::Numeric;
use egui::{PointerButton, Response, RichText, Sense, Slider, SliderClamping, Ui, vec2};
use renderer_core::design::Field;
use renderer_core::sampling::hash;

use crate::designer::document::labels::label_of;
use crate::designer::widgets::style::{ROW_HEIGHT, UNIT_WIDTH, VALUE_WIDTH};
use crate::designer::widgets::{
    Icon, IconButton, NumberField, check_box, fixed_text, row, shown_unit,
};

/// Row with label, slider, typed value and unit. Double clicks on the label or the slider set the default.
pub fn number<N: Numeric>(ui: &mut Ui, field: &Field, value: &mut N) {
    row(ui, &label_of(field.name), &tooltip(field), |ui, label| {
        number_with_slider(ui, field, value, label);
    });
}

/// Row with a check box that gives the value at all, for fields that a design may leave out; `otherwise` says what is
/// then.
pub fn optional_number(
    ui: &mut Ui,
    name: &str,
    field: &Field,
    value: &mut Option<f64>,
    start: f64,
    otherwise: &str,
) {
    row(ui, name, &tooltip(field), |ui, label| {
        let mut on = value.is_some();
        let check = check_box(ui, &mut on, "").labelled_by(label.id);
        if check.on_hover_text(field.what.trim()).changed() {
            *value = on.then_some(start);
        }
        if let Some(value) = value {
            number_value(ui, field, value).labelled_by(label.id);
        } else {
            ui.weak(otherwise);
        }
    });
}

/// The typed value and the unit of a number, without slider or label; the caller names it.
pub fn number_value<N: Numeric>(ui: &mut Ui, field: &Field, value: &mut N) -> Response {
    let response = drag_value(ui, field, value);
    if !field.unit.is_empty() {
        ui.label(RichText::new(shown_unit(ui.ctx(), field.unit)).weak());
    }
    response
}

/// Largest range that a slider makes sense for. Seeds are beyond it, and can be rolled.
const LARGEST_SLIDER: f64 = 1e8;
/// Rolled numbers stay short enough to remember.
const ROLL_BELOW: u32 = 100_000;

fn number_with_slider<N: Numeric>(ui: &mut Ui, field: &Field, value: &mut N, label: &Response) {
    let gaps = 2.0 * ui.spacing().item_spacing.x;
    let slider_width = (ui.available_width() - VALUE_WIDTH - UNIT_WIDTH - gaps).max(40.0);
    let mut reset = label.double_clicked();
    if field.max - field.min > LARGEST_SLIDER {
        let (rect, _) = ui.allocate_exact_size(vec2(slider_width, ROW_HEIGHT), Sense::hover());
        let name = format!("Roll {}", label_of(field.name).to_lowercase());
        let roll = IconButton::new(Icon::Dice, &name, "Rolls the dice: takes another number.");
        let roll = ui.place(rect.with_max_x(rect.left() + ROW_HEIGHT + 3.0), roll);
        if roll.clicked() {
            let another = hash(value.to_f64() as u32) % ROLL_BELOW;
            *value = N::from_f64(f64::from(another).clamp(field.min, field.max));
        }
    } else {
        ui.spacing_mut().slider_width = slider_width;
        let before = *value;
        let slider = Slider::new(
            value,
            N::from_f64(field.min)..=N::from_f64(slider_end(field)),
        )
        .show_value(false)
        // A typed value beyond the slider's end stays what it is.
        .clamping(SliderClamping::Edits)
        .logarithmic(is_logarithmic(field))
        .smallest_positive(smallest_positive(field));
        let slider = ui.add(slider).labelled_by(label.id);
        if slider.changed() {
            *value = N::from_f64(rounded(value.to_f64(), field));
        }
        // A slider itself only senses drags.
        reset |= slider.contains_pointer()
            && ui.input(|i| i.pointer.button_double_clicked(PointerButton::Primary));
        // Pressing a slider without moving it is no change of a value that its short form cannot show.
        if slider.drag_started() && text_of(before.to_f64()) == text_of(value.to_f64()) {
            *value = before;
        }
        slider.on_hover_text(tooltip(field));
    }
    drag_value(ui, field, value).labelled_by(label.id);
    let unit = shown_unit(ui.ctx(), field.unit);
    fixed_text(ui, UNIT_WIDTH, RichText::new(unit).weak());
    if reset {
        *value = N::from_f64(field.default);
    }
}

fn drag_value<N: Numeric>(ui: &mut Ui, field: &Field, value: &mut N) -> Response {
    let speed = if field.integer {
        1.0
    } else {
        let scale = value
            .to_f64()
            .abs()
            .max(field.default.abs())
            .max((field.max - field.min) * 1e-4);
        (scale * 0.01).min((field.max - field.min) * 0.01)
    };
    NumberField::new(value, field.unit, field.min..=field.max)
        .speed(speed)
        .format(&text_of)
        .size(vec2(VALUE_WIDTH, ROW_HEIGHT))
        .show(ui)
        .on_hover_text(tooltip(field))
}

fn tooltip(field: &Field) -> String {
    let space = if field.unit.is_empty() { "" } else { " " };
    format!(
        "{}\n{}, default {}{space}{}. Double click resets.",
        field.what.trim(),
        field.allowed(),
        text_of(field.default),
        field.unit
    )
}

/// Six significant digits at most, no trailing zeros.
fn text_of(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}").replace("-0", "0");
    }
    let digits_before_point = value.abs().log10().floor() as i32 + 1;
    let decimals = (6 - digits_before_point).clamp(0, 9) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

/// Sliders give three significant digits, and whole numbers where the field is whole.
fn rounded(value: f64, field: &Field) -> f64 {
    if field.integer {
        return value.round();
    }
    if value == 0.0 {
        return value;
    }
    let unit = 10_f64.powi(value.abs().log10().floor() as i32 - 2);
    ((value / unit).round() * unit).clamp(field.min, field.max)
}

/// Ranges that span decades above the usual value have logarithmic sliders.
fn is_logarithmic(field: &Field) -> bool {
    field.min >= 0.0 && field.default > 0.0 && field.max > 20.0 * field.default && field.max > 8.0
}

/// Where the slider ends: at values that are still a towel, so that one pull doesn't ask for a hundred million loops.
/// What lies beyond can be typed.
fn slider_end(field: &Field) -> f64 {
    if is_logarithmic(field) {
        field.max.min(20.0 * field.default)
    } else {
        field.max
    }
}

fn smallest_positive(field: &Field) -> f64 {
    if field.min > 0.0 {
        field.min
    } else {
        (field.default * 0.01).max(field.max * 1e-6)
    }
}
