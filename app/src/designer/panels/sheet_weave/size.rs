//! How many yarns the cloth has, how closely they stand, and how large that makes it.
//!
//! A size in cm stays when density changes: what was asked for is remembered, so that whole yarns do not round it away
//! step by step.

use egui::{RichText, Ui, vec2};
use renderer_core::design::{Field, Sheet};

use crate::designer::panels::number_row::number;
use crate::designer::widgets::style::{ROW_HEIGHT, VALUE_WIDTH};
use crate::designer::widgets::{NumberField, row, shown_unit};

/// The sides of the cloth that were asked for, width and length, cm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wanted([Option<f64>; 2]);

/// Shows numbers of yarns, densities and size.
pub fn show(ui: &mut Ui, wanted: &mut Wanted, sheet: &mut Sheet) {
    let fields = Sheet::FIELDS;
    number(ui, &fields.warps, &mut sheet.warps);
    number(ui, &fields.wefts, &mut sheet.wefts);
    let mut sides = sides(sheet);
    for (side, wanted) in sides.iter_mut().zip(&mut wanted.0) {
        // What was asked for counts as long as it is as many yarns as there are.
        let cm = wanted.filter(|cm| side.yarns_in(*cm) == *side.yarns);
        let cm = cm.unwrap_or(side.cm());
        number(ui, side.density, side.per_cm);
        if *side.yarns != side.yarns_in(cm) {
            *side.yarns = side.yarns_in(cm);
        }
        *wanted = Some(cm);
    }
    let what = "Width and length of the cloth: changes how many yarns there are, not how closely they stand. They stay \
        when the density changes.";
    row(ui, "Size", what, |ui, _| {
        for (index, (side, wanted)) in sides.iter_mut().zip(&mut wanted.0).enumerate() {
            if index > 0 {
                ui.label("×");
            }
            one(ui, side, wanted);
        }
        ui.weak(shown_unit(ui.ctx(), "cm"));
    });
    if let Some(text) = rounded_text(&sides, wanted) {
        ui.label(RichText::new(text).small().weak());
    }
}

/// A side of the cloth.
struct Side<'a> {
    name: &'static str,
    /// Number of its yarns.
    yarns: &'a mut u32,
    count: &'static Field,
    /// How many there are in a cm.
    per_cm: &'a mut f64,
    density: &'static Field,
}

fn sides(sheet: &mut Sheet) -> [Side<'_>; 2] {
    const FIELDS: &renderer_core::design::SheetFields = &Sheet::FIELDS;
    [
        Side {
            name: "Width of the cloth",
            yarns: &mut sheet.warps,
            count: &FIELDS.warps,
            per_cm: &mut sheet.warps_per_cm,
            density: &FIELDS.warps_per_cm,
        },
        Side {
            name: "Length of the cloth",
            yarns: &mut sheet.wefts,
            count: &FIELDS.wefts,
            per_cm: &mut sheet.wefts_per_cm,
            density: &FIELDS.wefts_per_cm,
        },
    ]
}

impl Side<'_> {
    fn cm(&self) -> f64 {
        f64::from(*self.yarns) / *self.per_cm
    }

    fn yarns_in(&self, cm: f64) -> u32 {
        let yarns = (cm * *self.per_cm).round();
        yarns.clamp(self.count.min, self.count.max) as u32
    }
}

fn one(ui: &mut Ui, side: &mut Side<'_>, wanted: &mut Option<f64>) {
    let before = wanted.unwrap_or(side.cm());
    let mut cm = before;
    let (name, per_cm) = (side.name, *side.per_cm);
    let range = side.count.min / per_cm..=side.count.max / per_cm;
    let response = NumberField::new(&mut cm, "cm", range)
        .speed(0.1)
        .max_decimals(1)
        .size(vec2(VALUE_WIDTH, ROW_HEIGHT))
        .show(ui)
        .accessible_name(name)
        .on_hover_text(format!(
            "{name}, in cm; the yarns stand as closely as before."
        ));
    if response.changed() && cm != before {
        *side.yarns = side.yarns_in(cm);
        *wanted = Some(cm);
    }
}

/// What the cloth measures in whole yarns, where that is not what was asked for.
fn rounded_text(sides: &[Side<'_>; 2], wanted: &Wanted) -> Option<String> {
    let is_off = |(side, wanted): (&Side<'_>, &Option<f64>)| {
        wanted.is_some_and(|cm| (cm - side.cm()).abs() >= 0.005)
    };
    let any = sides.iter().zip(&wanted.0).any(is_off);
    any.then(|| {
        let [width, length] = sides.each_ref().map(Side::cm);
        format!("In whole yarns {width:.2} × {length:.2} cm.")
    })
}
