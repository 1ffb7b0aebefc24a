//! Loop length: constant, from the chart's brightness through a curve, or from a table of its colours; and how long the
//! loops come out over the sheet.

use egui::{Button, Ui};
use renderer_core::design::{
    Chart, ChartImage, Colour, Design, Fit, Length, LengthEntry, LengthMap, OPAQUE_FROM,
};
use renderer_core::scene::MonotoneCurve;

use super::height_map::{self, HeightMaps};
use super::length_pictures::{BARS, histogram};
use super::length_table;
use super::surroundings::Surroundings;
use crate::designer::panels::choice_row::choice;
use crate::designer::panels::number_row::number;
use crate::designer::tasks::Latest;
use crate::designer::widgets::{CurveEditor, curve_editor, more, subheading};

/// Editor of the curve, the chart's histogram behind it, the open rows of the table, and the height map.
#[derive(Default)]
pub struct State {
    curve: CurveEditor,
    histogram: Latest<ChartImage, [u64; BARS]>,
    table: length_table::State,
    heights: HeightMaps,
}

/// Rows that "From chart" makes at most.
const COMMONEST: usize = 16;

/// Shows the panel; `has_yarn_table` tells whether the table of yarns is seen, which then has the lengths.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    design: &mut Design,
    has_yarn_table: bool,
    around: &mut Surroundings<'_>,
) {
    let fields = Length::FIELDS;
    let length = &mut design.length;
    let map_before = length.map;
    choice(
        ui,
        "Lengths",
        "What decides how long each loop is.",
        &mut length.map,
    );
    if length.map == LengthMap::Lut && map_before != length.map && length.table.is_empty() {
        start_table(length, around.woven);
    }
    match length.map {
        LengthMap::Constant => number(ui, &fields.value, &mut length.value),
        LengthMap::Gray => {
            number(ui, &fields.min, &mut length.min);
            number(ui, &fields.max, &mut length.max);
            curve(ui, state, length, around.woven.pixels.as_ref());
        }
        LengthMap::Lut if has_yarn_table => {
            ui.weak("Each yarn has its own, in the table of yarns in the panel Chart.");
            // For colours that the chart has not, or not yet.
            more(ui, "Rows by colour", |ui| table(ui, state, design, around));
        }
        LengthMap::Lut => table(ui, state, design, around),
    }
    height_map::show(ui, &mut state.heights, design, around.woven);
}

/// The table from colours to lengths, and what adds rows.
fn table(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    let length = &mut design.length;
    length_table::show(ui, &mut state.table, length, &design.pile);
    if table_buttons(ui, length, around.woven) {
        *around.step_name = Some("lengths by the chart's colours".into());
    }
}

fn curve(ui: &mut Ui, state: &mut State, length: &mut Length, chart: Option<&ChartImage>) {
    subheading(ui, "Length over brightness");
    let counts = chart.and_then(|chart| {
        let made = state.histogram.get(ui.ctx(), chart, histogram);
        made.filter(|(of, _)| of == chart)
    });
    let bars = counts.map_or(Vec::new(), |(_, counts)| heights(counts));
    let joined = MonotoneCurve::new(&length.curve);
    curve_editor(
        ui,
        "Length curve",
        &mut state.curve,
        &mut length.curve,
        Length::MAX_POINTS,
        &bars,
        |x| joined.value(x),
    )
    .on_hover_text(
        "How brightness of the chart becomes length: left black, right white; bottom shortest, top longest. Behind \
         it: how much of the chart has each brightness. Drag points, press to add one, double click removes one.",
    );
    ui.horizontal(|ui| {
        if let Some([x, y]) = length.curve.get(state.curve.selected).copied() {
            let longest = length.min + (length.max - length.min) * y;
            ui.weak(format!("Brightness {:.0} %: {longest:.2} mm", 100.0 * x));
        }
        let right = egui::Layout::right_to_left(egui::Align::Center);
        ui.with_layout(right, |ui| {
            let reset = ui.button("Reset curve");
            if reset
                .on_hover_text("Makes length follow brightness evenly.")
                .clicked()
            {
                length.curve = Length::default().curve;
            }
        });
    });
    if chart.is_none() {
        ui.weak("Without a chart all loops have the brightness of the cloth's colour.");
    }
}

/// Heights of the bars, the commonest 1; by square root, so that small shares show.
fn heights(counts: &[u64; BARS]) -> Vec<f32> {
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    counts
        .iter()
        .map(|&count| (count as f32 / most).sqrt())
        .collect()
}

/// Buttons that add rows; true when the chart's colours were taken.
fn table_buttons(ui: &mut Ui, length: &mut Length, chart: &Chart) -> bool {
    let mut are_taken = false;
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        let room = length.table.len() < Length::MAX_ROWS;
        let add = ui.add_enabled(room, Button::new("Add row"));
        if add.on_hover_text("Adds a colour to the table.").clicked() {
            length.table.push(LengthEntry::default());
        }
        let from_chart = ui.add_enabled(chart.pixels.is_some(), Button::new("Colours from chart"));
        let what = format!(
            "Makes a row of each of the chart's commonest colours, at most {COMMONEST}; rows of colours already in \
             the table are kept."
        );
        let without = "There is no chart: open one in the panel Chart.";
        let from_chart = from_chart.on_hover_text(what).on_disabled_hover_text(without);
        if let (true, Some(image)) = (from_chart.clicked(), &chart.pixels) {
            take_colours(length, chart, image);
            are_taken = true;
        }
    });
    are_taken
}

/// Rows to begin with: a table without any is a fault.
fn start_table(length: &mut Length, chart: &Chart) {
    match &chart.pixels {
        Some(image) => take_colours(length, chart, image),
        None => length.table.push(LengthEntry {
            length: length.value,
            ..LengthEntry::default()
        }),
    }
}

/// Makes the table the chart's commonest colours, keeping rows it already has for them.
fn take_colours(length: &mut Length, chart: &Chart, image: &ChartImage) {
    let mut counts = std::collections::HashMap::<[u8; 3], u32>::new();
    if chart.fit == Fit::Place {
        // The cloth around it has a row, whatever its share.
        counts.insert(chart.colour.0, u32::MAX / 2);
    }
    for [r, g, b, _] in sampled(image) {
        *counts.entry([r, g, b]).or_default() += 1;
    }
    let mut commonest: Vec<_> = counts.into_iter().collect();
    // By colour where counts are equal, so that the order is always the same.
    commonest.sort_by_key(|&(colour, count)| (std::cmp::Reverse(count), colour));
    commonest.truncate(COMMONEST);
    if commonest.is_empty() {
        // A chart that is transparent all over has no colours to take.
        return;
    }
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

/// Pixels of a chart, of a large one an even selection of some hundred thousand; transparent ones left out.
fn sampled(chart: &ChartImage) -> impl Iterator<Item = [u8; 4]> {
    let step = ((chart.width() * chart.height()) / 200_000).isqrt().max(1);
    (0..chart.height())
        .step_by(step)
        .flat_map(move |y| (0..chart.width()).step_by(step).map(move |x| (x, y)))
        .map(|(x, y)| chart.pixel(x, y))
        .filter(|pixel| pixel[3] >= OPAQUE_FROM)
}
