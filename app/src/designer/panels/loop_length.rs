//! Loop length: constant, from the chart's brightness through a curve, or from a table of its colours.

use egui::{Button, Ui};
use renderer_core::design::{
    ChartImage, Colour, Design, Length, LengthEntry, LengthMap, OPAQUE_FROM, Phase, Pile, PileKind,
};
use renderer_core::scene::{MonotoneCurve, luma};

use crate::designer::widgets::{
    Choice, CurveEditor, choice, colour, curve_editor, number, optional_number, row, subheading,
    subheading_with,
};

/// Editor of the curve, and the chart's histogram behind it.
#[derive(Default)]
pub struct State {
    curve: CurveEditor,
    histogram: Option<(ChartImage, Vec<f32>)>,
}

/// Bars of the histogram.
const BARS: usize = 48;
/// Rows that "From chart" makes at most.
const COMMONEST: usize = 8;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design) {
    let fields = Length::FIELDS;
    let length = &mut design.length;
    let map_before = length.map;
    choice(
        ui,
        "Map",
        "How a texel of the chart becomes a loop length.",
        &mut length.map,
    );
    if length.map == LengthMap::Lut && map_before != length.map && length.table.is_empty() {
        start_table(length, design.chart.pixels.as_ref());
    }
    match length.map {
        LengthMap::Constant => number(ui, &fields.value, &mut length.value),
        LengthMap::Gray => {
            number(ui, &fields.min, &mut length.min);
            number(ui, &fields.max, &mut length.max);
            curve(ui, state, length, design.chart.pixels.as_ref());
        }
        LengthMap::Lut => table(ui, length, &design.pile, design.chart.pixels.as_ref()),
    }
}

fn curve(ui: &mut Ui, state: &mut State, length: &mut Length, chart: Option<&ChartImage>) {
    subheading(ui, "Length over brightness");
    let histogram = match (chart, &state.histogram) {
        (None, _) => &[][..],
        (Some(chart), Some((of, bars))) if of == chart => bars,
        (Some(chart), _) => &state.histogram.insert((chart.clone(), histogram(chart))).1,
    };
    let joined = MonotoneCurve::new(&length.curve);
    curve_editor(
        ui,
        "Length curve",
        &mut state.curve,
        &mut length.curve,
        Length::MAX_POINTS,
        histogram,
        |x| joined.value(x),
    )
    .on_hover_text(
        "Left black, right white; bottom shortest, top longest. Drag points, press to add one, double click removes one.",
    );
    if let Some([x, y]) = length.curve.get(state.curve.selected).copied() {
        let longest = length.min + (length.max - length.min) * y;
        ui.weak(format!("Brightness {x:.2}: {longest:.2} mm"));
    }
    if ui
        .button("Reset curve")
        .on_hover_text("Makes length follow brightness evenly.")
        .clicked()
    {
        length.curve = Length::default().curve;
    }
}

/// Shares of brightness values, the commonest 1; heights by square root, so that small shares show.
fn histogram(chart: &ChartImage) -> Vec<f32> {
    let mut counts = [0.0_f32; BARS];
    for [r, g, b, _] in sampled(chart) {
        let bar = (luma([r, g, b]) * BARS as f64) as usize;
        counts[bar.min(BARS - 1)] += 1.0;
    }
    let most = counts.iter().fold(1.0_f32, |a, &b| a.max(b));
    counts.iter().map(|count| (count / most).sqrt()).collect()
}

/// Pixels of a chart, of a large one an even selection of some hundred thousand; transparent ones left out.
fn sampled(chart: &ChartImage) -> impl Iterator<Item = [u8; 4]> {
    let step = ((chart.width() * chart.height()) / 200_000).isqrt().max(1);
    (0..chart.height())
        .step_by(step)
        .flat_map(move |y| (0..chart.width()).step_by(step).map(move |x| (x, y)))
        .map(|(x, y)| chart.pixel(x, y))
        .filter(|pixel| pixel[3] >= OPAQUE_FROM)
}

fn table(ui: &mut Ui, length: &mut Length, pile: &Pile, chart: Option<&ChartImage>) {
    let mut removed = None;
    for (index, entry) in length.table.iter_mut().enumerate() {
        ui.push_id(index, |ui| {
            subheading_with(ui, &format!("Row {}", index + 1), |ui| {
                let remove = ui
                    .small_button("Remove")
                    .accessible_name(format!("Remove row {}", index + 1));
                if remove.clicked() {
                    removed = Some(index);
                }
            });
            table_row(ui, entry, pile);
        });
    }
    if let Some(index) = removed {
        length.table.remove(index);
    }
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        let room = length.table.len() < Length::MAX_ROWS;
        let add = ui.add_enabled(room, Button::new("Add row"));
        if add.on_hover_text("Adds a colour to the table.").clicked() {
            length.table.push(LengthEntry::default());
        }
        let from_chart = ui.add_enabled(chart.is_some(), Button::new("From chart"));
        let from_chart = from_chart.on_hover_text(
            "Makes a row of each of the chart's commonest colours; lengths of colours already in the table are kept.",
        );
        if let (true, Some(chart)) = (from_chart.clicked(), chart) {
            take_colours(length, chart);
        }
    });
}

fn table_row(ui: &mut Ui, entry: &mut LengthEntry, pile: &Pile) {
    let fields = LengthEntry::FIELDS;
    colour(
        ui,
        "Colour",
        "The chart colour this row is for; texels use the nearest row.",
        &mut entry.colour,
    );
    number(ui, &fields.length, &mut entry.length);
    number(ui, &fields.albedo_scale, &mut entry.albedo_scale);
    let of_pile = Pile::FIELDS;
    let mut own = |label, field, value: &mut Option<f64>, pile_value| {
        optional_number(ui, label, field, value, pile_value);
    };
    own(
        "Own density",
        &of_pile.density,
        &mut entry.density,
        pile.density,
    );
    // Only the parameters that the pile's way of scattering has; a row keeps the others for when it changes.
    match pile.phase {
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
    own_kind(ui, &mut entry.kind);
}

/// Kind of pile of a row, which may be that of the pile.
fn own_kind(ui: &mut Ui, kind: &mut Option<PileKind>) {
    let what = "Kind of pile of loops of this colour.";
    row(ui, "Own kind", what, |ui, label| {
        let name = kind.map_or("as the pile", Choice::label);
        let combo = egui::ComboBox::from_id_salt("kind")
            .selected_text(name)
            .width(ui.available_width())
            .show_ui(ui, |ui| {
                ui.selectable_value(kind, None, "as the pile");
                for &choice in PileKind::ALL {
                    ui.selectable_value(kind, Some(choice), Choice::label(choice))
                        .on_hover_text(Choice::what(choice));
                }
            });
        combo.response.labelled_by(label.id).on_hover_text(what);
    });
}

/// Rows to begin with: a table without any is a fault.
fn start_table(length: &mut Length, chart: Option<&ChartImage>) {
    match chart {
        Some(chart) => take_colours(length, chart),
        None => length.table.push(LengthEntry {
            length: length.value,
            ..LengthEntry::default()
        }),
    }
}

/// Makes the table the chart's commonest colours, keeping rows it already has for them.
fn take_colours(length: &mut Length, chart: &ChartImage) {
    let mut counts = std::collections::HashMap::<[u8; 3], u32>::new();
    for [r, g, b, _] in sampled(chart) {
        *counts.entry([r, g, b]).or_default() += 1;
    }
    let mut commonest: Vec<_> = counts.into_iter().collect();
    // By colour where counts are equal, so that the order is always the same.
    commonest.sort_by_key(|&(colour, count)| (std::cmp::Reverse(count), colour));
    commonest.truncate(COMMONEST);
    let value = length.value;
    length.table = commonest
        .into_iter()
        .map(|(rgb, _)| {
            let known = length.table.iter().find(|row| row.colour == Colour(rgb));
            known.cloned().unwrap_or_else(|| LengthEntry {
                colour: Colour(rgb),
                length: value,
                ..LengthEntry::default()
            })
        })
        .collect();
}
