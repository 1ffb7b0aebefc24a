//! A number that is dragged or typed. What is typed may have other units, a decimal comma, fractions; what is not
//! understood stays in the field, in red, with the reason below it, until it is mended or given up with Escape.

use std::cell::{Cell, RefCell};
use std::ops::RangeInclusive;

use egui::emath::{self, Numeric};
use egui::{Color32, DragValue, Id, Key, Response, RichText, Stroke, Tooltip, Ui, Vec2};
use renderer_core::design::read_number;

use super::units::UnitSystem;

/// A field for a number.
#[must_use = "a field shows once it is added"]
pub struct NumberField<'a, N> {
    value: &'a mut N,
    unit: &'a str,
    range: RangeInclusive<f64>,
    speed: f64,
    most_decimals: Option<usize>,
    format: Option<&'a dyn Fn(f64) -> String>,
    suffix: &'a str,
    has_unit: bool,
    size: Option<Vec2>,
}

/// What was typed and could not be taken as it is.
#[derive(Debug, Clone, PartialEq)]
struct Refusal {
    /// What was typed; `None` where something near to it was taken.
    text: Option<String>,
    /// Why, as a sentence.
    why: String,
    /// What the field held when it was typed: another value was set since then, or this one.
    value: f64,
    /// Whether the reason is shown without being asked for: until the next click or key.
    is_news: bool,
}

impl<'a, N: Numeric> NumberField<'a, N> {
    /// A field for a number in a unit; empty for plain numbers. Shown is the number alone, in inches where lengths are
    /// shown in them.
    pub fn new(value: &'a mut N, unit: &'a str, range: RangeInclusive<impl Numeric>) -> Self {
        Self {
            value,
            unit,
            range: range.start().to_f64()..=range.end().to_f64(),
            speed: 1.0,
            most_decimals: None,
            format: None,
            suffix: "",
            has_unit: false,
            size: None,
        }
    }

    /// How much a drag of a point changes it.
    pub fn speed(mut self, speed: f64) -> Self {
        self.speed = speed;
        self
    }

    /// How many decimals it shows at most; else as many as a drag can set.
    pub fn max_decimals(mut self, most: usize) -> Self {
        self.most_decimals = Some(most);
        self
    }

    /// Shows it as the function writes it.
    pub fn format(mut self, format: &'a dyn Fn(f64) -> String) -> Self {
        self.format = Some(format);
        self
    }

    /// What stands behind it in the field.
    pub fn suffix(mut self, suffix: &'a str) -> Self {
        self.suffix = suffix;
        self
    }

    /// Shows its unit behind it in the field.
    pub fn with_unit(mut self) -> Self {
        self.has_unit = true;
        self
    }

    /// How large the field is.
    pub fn size(mut self, size: Vec2) -> Self {
        self.size = Some(size);
        self
    }

    /// Shows the field. It has changed where another value was taken; a value that it shows rounded stays what it is.
    pub fn show(self, ui: &mut Ui) -> Response {
        // Fields are in the same order from frame to frame, as widgets are.
        let id = ui.next_auto_id().with("refused");
        let before = self.value.to_f64();
        let refusal: Option<Refusal> = ui.data(|data| data.get_temp(id));
        // egui takes what was typed in the frame after the one with Escape.
        let escaped = id.with("escaped");
        let was_escaped = ui
            .data_mut(|data| data.remove_temp::<()>(escaped))
            .is_some();
        let refusal = refusal.filter(|refusal| refusal.value == before);
        let kept = refusal.as_ref().and_then(|refusal| refusal.text.clone());
        let (unit, factor) = UnitSystem::of(ui.ctx()).shown(self.unit);
        let shown = RefCell::new(String::new());
        let news = RefCell::new(None);
        let is_read = Cell::new(false);
        let format = |value: f64, decimals: RangeInclusive<usize>| {
            let written = match self.format {
                Some(format) => format(value / factor),
                None => emath::format_with_decimals_in_range(value / factor, decimals),
            };
            let text = kept.clone().filter(|_| value == before).unwrap_or(written);
            shown.borrow_mut().clone_from(&text);
            text
        };
        let range = self.range.clone();
        let parse = |text: &str| {
            if was_escaped || kept.is_none() && text == *shown.borrow() {
                return None;
            }
            let refused = |text: Option<&str>, why: String, value: f64| Refusal {
                text: text.map(str::to_owned),
                why,
                value,
                is_news: true,
            };
            match read_number(text, unit, N::INTEGRAL) {
                Ok(number) => {
                    is_read.set(true);
                    let number = number * factor;
                    let taken = number.clamp(*range.start(), *range.end());
                    *news.borrow_mut() = (taken != number).then(|| {
                        let why = format!(
                            "“{}” is beyond what is allowed: {}.",
                            text.trim(),
                            allowed(&range, unit, factor)
                        );
                        refused(None, why, N::from_f64(taken).to_f64())
                    });
                    Some(number)
                }
                Err(why) => {
                    *news.borrow_mut() = Some(refused(Some(text.trim()), why, before));
                    None
                }
            }
        };
        let suffix = match self.has_unit {
            true => format!(" {unit}"),
            false => self.suffix.to_owned(),
        };
        let field = DragValue::new(self.value)
            .range(range.clone())
            .clamp_existing_to_range(false)
            .update_while_editing(false)
            .clip_text(true)
            .speed(self.speed)
            .suffix(suffix)
            .custom_formatter(format)
            .custom_parser(parse);
        let field = match self.most_decimals {
            // An inch is worth two decimals more.
            Some(most) => field.max_decimals(most + if factor == 1.0 { 0 } else { 2 }),
            None => field,
        };
        let red = kept.is_some().then(|| ui.visuals().error_fg_color);
        let response = in_colour(ui, red, |ui| match self.size {
            Some(size) => ui.add_sized(size, field.min_size(size)),
            None => ui.add(field),
        });
        let is_given_up = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Escape));
        if is_given_up {
            ui.data_mut(|data| data.insert_temp(escaped, ()));
        }
        let refusal = match news.into_inner() {
            Some(news) => Some(news),
            None if is_read.get() || is_given_up => None,
            None => refusal,
        };
        remember(ui, id, refusal, &response)
    }
}

/// The range of a field, as a sentence's end, in a unit of which each is `factor` of the range's.
fn allowed(range: &RangeInclusive<f64>, unit: &str, factor: f64) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    let end = |value: f64| match factor {
        1.0 => value,
        factor => (value / factor * 1000.0).round() / 1000.0,
    };
    let (least, most) = (end(*range.start()), end(*range.end()));
    format!("{least} to {most}{space}{unit}")
}

/// Adds what `add` does with its text in a colour and a border of it, where one is given.
fn in_colour(
    ui: &mut Ui,
    colour: Option<Color32>,
    add: impl FnOnce(&mut Ui) -> Response,
) -> Response {
    let Some(colour) = colour else {
        return add(ui);
    };
    let before = ui.style().clone();
    ui.visuals_mut().override_text_color = Some(colour);
    let response = add(ui);
    ui.set_style(before);
    let stroke = Stroke::new(1.0, colour);
    let corners = ui.visuals().widgets.inactive.corner_radius;
    ui.painter()
        .rect_stroke(response.rect, corners, stroke, egui::StrokeKind::Inside);
    response
}

/// Keeps what was refused until the next frame, and says why: at once until something else is done, then where the
/// pointer rests on the field.
fn remember(ui: &Ui, id: Id, refusal: Option<Refusal>, response: &Response) -> Response {
    let Some(mut refusal) = refusal else {
        ui.data_mut(|data| data.remove::<Refusal>(id));
        return response.clone();
    };
    let is_answered = ui.input(|i| {
        i.pointer.any_pressed()
            || i.events
                .iter()
                .any(|event| matches!(event, egui::Event::Key { pressed: true, .. }))
    });
    let is_new = ui.data(|data| data.get_temp::<Refusal>(id)).as_ref() != Some(&refusal);
    if is_answered && !is_new {
        refusal.is_news = false;
    }
    let why = RichText::new(&refusal.why);
    let response = if refusal.is_news {
        Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), id, response)
            .gap(2.0)
            .show(|ui| ui.label(why.color(ui.visuals().error_fg_color)));
        response.clone()
    } else if refusal.text.is_some() {
        response.clone().on_hover_text(why)
    } else {
        response.clone()
    };
    ui.data_mut(|data| data.insert_temp(id, refusal));
    response
}
