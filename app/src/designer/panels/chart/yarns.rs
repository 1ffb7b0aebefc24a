//! The table of a chart's yarns: colour, name and share of each, how high its pile is, of which kind and material; and
//! making two of them one.

use egui::{Button, Color32, RichText, ScrollArea, Sense, TextEdit, Ui, vec2};
use renderer_core::design::chart_edit::{BARE, YarnCount, YarnCounts, replace_yarn};
use renderer_core::design::{Chart, Colour, Design, Length, LengthEntry, LengthMap};
use renderer_core::scene::{ChartYarns, LengthRule};

use crate::designer::chart_editor::work::put;
use crate::designer::chart_editor::yarn_name::yarn_name;
use crate::designer::panels::choice_row::colour_value;
use crate::designer::panels::length_table::{material, own_choice};
use crate::designer::panels::number_row::number_value;
use crate::designer::widgets::{row, subheading};

/// Height of the list before it scrolls, points.
const LIST_HEIGHT: f32 = 320.0;
/// Width of a yarn's name, points.
const NAME_WIDTH: f32 = 96.0;

/// What is remembered of the yarns.
#[derive(Default)]
pub struct State {
    /// The yarns of the chart, counted.
    pub counted: ChartYarns,
    /// A yarn whose colour is being changed.
    recolouring: Option<Recolouring>,
    /// The yarn that shows its material.
    open: Option<[u8; 4]>,
    /// Whether the table was shown.
    pub is_shown: bool,
}

/// Changing a colour goes on for many frames, through colours that other yarns may have: so it always starts from what
/// was there before.
struct Recolouring {
    before: Chart,
    rows: Vec<LengthEntry>,
    yarns: Vec<YarnCount>,
    /// Which of them.
    index: usize,
    to: [u8; 4],
}

/// Shows the list. Returns what the history is to call a change made here.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design) -> Option<String> {
    if design.chart.pixels.is_none() && design.chart.object.is_empty() {
        return None;
    }
    if !ui.input(|i| i.pointer.any_down()) {
        state.recolouring = None;
    }
    let yarns = match &state.recolouring {
        Some(recolouring) => {
            let mut yarns = recolouring.yarns.clone();
            yarns[recolouring.index].colour = recolouring.to;
            Some(yarns)
        }
        None => state.counted.of_design(design),
    };
    let Some(yarns) = yarns else {
        subheading(ui, "Yarns");
        ui.weak(format!(
            "More than {} colours. Reduce the chart to the yarns you weave with.",
            YarnCounts::MOST
        ));
        return None;
    };
    state.is_shown = true;
    let count = yarns.iter().filter(|yarn| yarn.colour != BARE).count();
    subheading(
        ui,
        &match count {
            1 => "1 yarn".into(),
            count => format!("{count} yarns"),
        },
    );
    let loops = yarns.iter().map(|yarn| yarn.loops).sum::<u64>().max(1) as f64;
    let mut name = None;
    ScrollArea::vertical()
        .id_salt("yarns")
        .max_height(LIST_HEIGHT)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            let mut number = 0;
            for (index, yarn) in yarns.iter().enumerate() {
                let label = if yarn.colour == BARE {
                    "Bare".into()
                } else {
                    number += 1;
                    format!("Yarn {number}")
                };
                let share = share_text(yarn.loops as f64 / loops);
                let named = ui.push_id(index, |ui| {
                    let place = Place {
                        index,
                        label: &label,
                        share: &share,
                    };
                    let name = yarn_row(ui, state, design, &yarns, &place);
                    if yarn.colour == BARE {
                        return name;
                    }
                    own_row(ui, state, design, &yarns, &place).or(name)
                });
                name = named.inner.or(name.take());
            }
        });
    name
}

/// Of the loops: `43 %`, `0.2 %`, `< 0.1 %`, `no loop`.
fn share_text(share: f64) -> String {
    match 100.0 * share {
        0.0 => "no loop".into(),
        percent if percent >= 10.0 => format!("{percent:.0} %"),
        percent if percent >= 0.1 => format!("{percent:.1} %"),
        _ => "< 0.1 %".into(),
    }
}

struct Place<'a> {
    index: usize,
    label: &'a str,
    share: &'a str,
}

fn yarn_row(
    ui: &mut Ui,
    state: &mut State,
    design: &mut Design,
    yarns: &[YarnCount],
    place: &Place<'_>,
) -> Option<String> {
    let yarn = yarns[place.index];
    let what = "Colour of this yarn; all its loops change with it. The share is of the loops.";
    row(
        ui,
        &format!("{}  {}", place.label, place.share),
        what,
        |ui, label| {
            let mut name = None;
            if yarn.colour == BARE {
                ui.label(RichText::new("no loops stand here").weak());
            } else {
                let [r, g, b, _] = yarn.colour;
                let mut colour = Colour([r, g, b]);
                colour_value(ui, what, &mut colour, label);
                let Colour([r, g, b]) = colour;
                let to = [r, g, b, 255];
                if to != yarn.colour {
                    recolour(state, design, yarns, place.index, to);
                    name = Some("yarn colour".into());
                }
            }
            if yarns.len() > 1 {
                let merge = ui.menu_button("Merge", |ui| {
                    let mut merged = None;
                    for (index, other) in yarns.iter().enumerate() {
                        if index == place.index || other.colour == BARE {
                            continue;
                        }
                        let before = yarns[..index].iter().filter(|yarn| yarn.colour != BARE);
                        let text = format!("into {}", yarn_name(before.count(), other.colour));
                        let [r, g, b, _] = other.colour;
                        ui.horizontal(|ui| {
                            let side = vec2(14.0, 14.0);
                            let (rect, _) = ui.allocate_exact_size(side, Sense::hover());
                            let colour = Color32::from_rgb(r, g, b);
                            ui.painter().rect_filled(rect, 2.0, colour);
                            if ui.button(text).clicked() {
                                merged = Some(other.colour);
                                ui.close();
                            }
                        });
                    }
                    merged
                });
                merge
                    .response
                    .accessible_name(format!("Merge {}", place.label.to_lowercase()))
                    .on_hover_text("Makes it the same yarn as another.");
                if let Some(Some(into)) = merge.inner {
                    exchange(&mut design.chart, yarn.colour, into);
                    name = Some("merge yarns".into());
                }
            }
            name
        },
    )
}

/// Name, pile height and kind of a yarn, and below them its material.
fn own_row(
    ui: &mut Ui,
    state: &mut State,
    design: &mut Design,
    yarns: &[YarnCount],
    place: &Place<'_>,
) -> Option<String> {
    let yarn = yarns[place.index].colour;
    let colour = Colour([yarn[0], yarn[1], yarn[2]]);
    let of = place.label.to_lowercase();
    let before = row_of(&design.length, colour);
    let mut entry = before.clone();
    ui.horizontal(|ui| {
        let mut name = design.chart.name_of(colour).unwrap_or_default().to_owned();
        let edit = TextEdit::singleline(&mut name).hint_text("name").desired_width(NAME_WIDTH);
        let edit = ui.add(edit).accessible_name(format!("Name of {of}"));
        if edit.on_hover_text("What you call this yarn: of a shade card, say.").changed() {
            design.chart.set_name(colour, &name);
        }
        if design.length.map == LengthMap::Gray {
            let what = "Lengths follow the chart's brightness: see the panel Loop length.";
            ui.weak(format!("{:.1} mm", entry.length)).on_hover_text(what);
        } else {
            number_value(ui, &LengthEntry::FIELDS.length, &mut entry.length)
                .accessible_name(format!("Pile height of {of}"))
                .on_hover_text("How high its loops stand. Another height for one yarn gives each a height of its own.");
            own_choice(ui, "kind", &mut entry.kind)
                .accessible_name(format!("Kind of {of}"))
                .on_hover_text("Loops, cut tufts or other pile.");
            let is_open = state.open == Some(yarn);
            let more = ui.add(Button::new("…").selected(is_open)).accessible_name(format!("Material of {of}"));
            if more.on_hover_text("Its material: brightness, yarn, lean, how it scatters light.").clicked() {
                state.open = (!is_open).then_some(yarn);
            }
        }
    });
    if state.open == Some(yarn) && design.length.map != LengthMap::Gray {
        let pile = design.pile.clone();
        ui.indent("material", |ui| material(ui, &mut entry, &pile));
    }
    if entry == before {
        return None;
    }
    give_row(&mut design.length, yarns, entry);
    Some("pile of a yarn".into())
}

/// What loops of a colour are: the table's row for it, or what they have in common.
fn row_of(length: &Length, colour: Colour) -> LengthEntry {
    let rule = LengthRule::new(length);
    let nearest = rule.row(colour.0).and_then(|row| length.rows().get(row));
    LengthEntry {
        colour,
        length: rule.length_mm(colour.0),
        ..nearest.cloned().unwrap_or_default()
    }
}

/// Gives a yarn a row of its own in the table of lengths, and every other that has none the one it had in common.
fn give_row(length: &mut Length, yarns: &[YarnCount], entry: LengthEntry) {
    let colours = yarns.iter().filter(|yarn| yarn.colour != BARE);
    let colours = colours.map(|yarn| Colour([yarn.colour[0], yarn.colour[1], yarn.colour[2]]));
    let own: Vec<LengthEntry> = colours.map(|colour| row_of(length, colour)).collect();
    if length.map != LengthMap::Lut {
        length.map = LengthMap::Lut;
        length.table.clear();
    }
    for row in own {
        if length.table.iter().all(|known| known.colour != row.colour) {
            length.table.push(row);
        }
    }
    if let Some(row) = length
        .table
        .iter_mut()
        .find(|row| row.colour == entry.colour)
    {
        *row = entry;
    }
}

/// Gives a yarn another colour. Its row in the table of lengths goes with it: the loops stay as long as they are.
fn recolour(
    state: &mut State,
    design: &mut Design,
    yarns: &[YarnCount],
    index: usize,
    to: [u8; 4],
) {
    let recolouring = state.recolouring.get_or_insert_with(|| Recolouring {
        before: design.chart.clone(),
        rows: design.length.table.clone(),
        yarns: yarns.to_vec(),
        index,
        to,
    });
    if recolouring.index != index {
        return;
    }
    recolouring.to = to;
    let from = recolouring.yarns[index].colour;
    design.chart = recolouring.before.clone();
    exchange(&mut design.chart, from, to);
    let pairs = design.length.table.iter_mut().zip(&recolouring.rows);
    for (row, before) in pairs {
        if before.colour.0 == from[..3] {
            row.colour = Colour([to[0], to[1], to[2]]);
        }
    }
}

/// Gives everything of a chart that is one yarn another: pixels, and what lies on it.
fn exchange(chart: &mut Chart, from: [u8; 4], to: [u8; 4]) {
    let [before, after] = [from, to].map(|[r, g, b, _]| Colour([r, g, b]));
    // A name goes with its yarn, unless that becomes one that has another.
    if let Some(name) = chart.name_of(before).map(str::to_owned) {
        chart.set_name(before, "");
        if to != BARE && chart.name_of(after).is_none() {
            chart.set_name(after, &name);
        }
    }
    match &chart.pixels {
        Some(image) => {
            let replaced = replace_yarn(image, from, to);
            if replaced != *image {
                put(chart, replaced);
            }
        }
        // Objects alone lie on cloth of one colour.
        None if chart.colour.0 == from[..3] && to != BARE => {
            chart.colour = Colour([to[0], to[1], to[2]]);
        }
        None => {}
    }
    for object in &mut chart.object {
        if !object.bare && object.colour.0 == from[..3] {
            object.bare = to == BARE;
            if !object.bare {
                object.colour = Colour([to[0], to[1], to[2]]);
            }
        }
        if let Some(image) = &object.pixels {
            let replaced = replace_yarn(image, from, to);
            if replaced != *image {
                (object.image, object.pixels) = (None, Some(replaced));
            }
        }
    }
}
