//! The bar of what lies on the chart: what there is, and all about the one that is chosen.

use egui::{Button, ComboBox, Panel, Response, ScrollArea, TextEdit, Ui};
use renderer_core::design::chart_objects::ChartCanvas;
use renderer_core::design::{Chart, ChartObject, Colour, Design, Field, ObjectKind, Sheet};

use super::ChartEditor;
use super::objects::{flatten, loops, new_object, pitch, rounded, set_text, use_as_chart};
use super::{Tool, chart_canvas};
use crate::designer::widgets::{Icon, IconButton, NumberField, check_box, colour_well};
use crate::lettering::font_names;

/// Height of the fields before they scroll, points.
const FIELDS_HEIGHT: f32 = 112.0;
/// Fonts of a menu before it scrolls take this height, points.
const FONTS_HEIGHT: f32 = 260.0;

/// Shows the bar below the canvas. Returns what the history is to call a change made here.
pub fn show(ui: &mut Ui, editor: &mut ChartEditor, design: &mut Design) -> Option<String> {
    let panel = Panel::bottom("chart objects")
        .frame(egui::Frame::new().inner_margin(egui::Margin::symmetric(0, 3)))
        .show(ui, |ui| {
            let name = ui.horizontal_wrapped(|ui| list(ui, editor, design)).inner;
            if !editor.tool.is_for_objects() {
                return name;
            }
            // As high whatever is chosen, or the canvas would move away under the pointer.
            let fields = ScrollArea::vertical()
                .id_salt("object fields")
                .max_height(FIELDS_HEIGHT)
                .min_scrolled_height(FIELDS_HEIGHT)
                .auto_shrink([false, false])
                .show(ui, |ui| match editor.objects.selected {
                    Some(index) if index < design.chart.object.len() => {
                        fields(ui, editor, design, index)
                    }
                    _ => {
                        ui.weak(
                            "Drag on the chart to lay something there, or choose what lies there.",
                        );
                        None
                    }
                });
            fields.inner.or(name)
        });
    panel.inner
}

/// `2: ellipse`, `3: “Spa”`.
fn label(index: usize, object: &ChartObject) -> String {
    let number = index + 1;
    match (object.kind, &object.text) {
        (ObjectKind::Text, Some(text)) => {
            let short: String = text.chars().take(14).collect();
            format!("{number}: “{short}”")
        }
        (kind, _) => format!("{number}: {}", kind.label()),
    }
}

/// The menu of objects, and what is done with the chosen one as a whole.
fn list(ui: &mut Ui, editor: &mut ChartEditor, design: &mut Design) -> Option<String> {
    let canvas = chart_canvas(design);
    let mut name = None;
    let room = design.chart.object.len() < ChartObject::MAX;
    ui.add_enabled_ui(room, |ui| {
        let menu = ui.menu_button("Add", |ui| {
            for &kind in ObjectKind::ALL {
                // Pictures are pasted or dropped.
                if kind != ObjectKind::Image && ui.button(kind.label()).on_hover_text(kind.what()).clicked() {
                    design.chart.object.push(new_object(kind, editor.colour, &canvas));
                    editor.choose_last(&design.chart);
                    ui.close();
                }
            }
        });
        menu.response
            .accessible_name("Add an object")
            .on_hover_text("Lays something into the middle of the chart. Pictures are pasted (Ctrl+V) or dropped.");
    });
    let objects = &mut design.chart.object;
    if objects.is_empty() {
        ui.weak("Nothing lies on the chart.");
        return None;
    }
    let shown = match editor.objects.selected {
        Some(index) => label(index, &objects[index]),
        None => format!("{} objects", objects.len()),
    };
    let combo = ComboBox::from_id_salt("object")
        .selected_text(shown)
        .width(118.0)
        .show_ui(ui, |ui| {
            for (index, object) in objects.iter().enumerate().rev() {
                let text = label(index, object);
                if ui
                    .selectable_value(&mut editor.objects.selected, Some(index), text)
                    .clicked()
                {
                    editor.tool = Tool::Select;
                }
            }
        });
    combo
        .response
        .accessible_name("Chosen object")
        .on_hover_text("What lies on the chart, the topmost first.");
    if let Some(index) = editor.objects.selected {
        name = change_order(ui, editor, objects, index);
    }
    let (flat, all) = (ui.button("Flatten all"), objects.len());
    if flat
        .on_hover_text("Makes everything that lies on the chart pixels of it: to be painted on, and not to be moved any more.")
        .clicked()
    {
        flatten(design, &mut editor.composer, all - 1);
        editor.objects.selected = None;
        name = Some("flatten all objects".into());
    }
    check_box(ui, &mut editor.objects.snaps, "Snap")
        .on_hover_text("What is dragged snaps to the chart's middle and edges, to guides and to crossings; Alt lets go.");
    name
}

fn change_order(
    ui: &mut Ui,
    editor: &mut ChartEditor,
    objects: &mut Vec<ChartObject>,
    index: usize,
) -> Option<String> {
    let chosen = &mut editor.objects.selected;
    let duplicate = IconButton::new(
        Icon::Duplicate,
        "Duplicate object",
        "Lays the same beside it.",
    );
    if ui
        .add_enabled(objects.len() < ChartObject::MAX, duplicate)
        .clicked()
    {
        let mut copy = objects[index].clone();
        copy.x += 5.0;
        copy.y -= 5.0;
        objects.insert(index + 1, copy);
        *chosen = Some(index + 1);
        return Some("duplicate object".into());
    }
    let raise = IconButton::new(
        Icon::ShiftUp,
        "Raise object",
        "Lays it over the next one above.",
    );
    if ui.add_enabled(index + 1 < objects.len(), raise).clicked() {
        objects.swap(index, index + 1);
        *chosen = Some(index + 1);
        return Some("order of objects".into());
    }
    let lower = IconButton::new(
        Icon::ShiftDown,
        "Lower object",
        "Lays it below the next one.",
    );
    if ui.add_enabled(index > 0, lower).clicked() {
        objects.swap(index, index - 1);
        *chosen = Some(index - 1);
        return Some("order of objects".into());
    }
    let remove = ui.button("Remove").accessible_name("Remove object");
    if remove
        .on_hover_text("Takes it off the chart (Delete).")
        .clicked()
    {
        objects.remove(index);
        *chosen = None;
    }
    None
}

/// Everything about an object.
fn fields(
    ui: &mut Ui,
    editor: &mut ChartEditor,
    design: &mut Design,
    index: usize,
) -> Option<String> {
    let canvas = chart_canvas(design);
    let Design { chart, sheet, .. } = design;
    let kind = chart.object[index].kind;
    let mut name = None;
    let object = &mut chart.object[index];
    ui.horizontal_wrapped(|ui| place(ui, object, &canvas));
    ui.horizontal_wrapped(|ui| size(ui, object, sheet));
    ui.horizontal_wrapped(|ui| look(ui, object));
    ui.horizontal_wrapped(|ui| repeats(ui, object));
    if kind == ObjectKind::Text {
        ui.horizontal_wrapped(|ui| text(ui, editor, object));
    }
    if kind == ObjectKind::Image {
        name = ui
            .horizontal_wrapped(|ui| picture(ui, editor, chart, index))
            .inner;
    }
    name
}

/// A labelled number in mm or degrees.
fn number(
    ui: &mut Ui,
    label: &str,
    name: &str,
    value: &mut f64,
    field: &Field,
    what: &str,
) -> Response {
    ui.label(label);
    let drag = NumberField::new(value, field.unit, field.min..=field.max).max_decimals(1);
    drag.with_unit()
        .show(ui)
        .accessible_name(name)
        .on_hover_text(what)
}

/// Where an object's middle is, from the chart's left and near edge.
fn place(ui: &mut Ui, object: &mut ChartObject, canvas: &ChartCanvas) {
    let fields = ChartObject::FIELDS;
    let half = canvas.size_mm().map(|side| 0.5 * side);
    let ways = [
        (
            "From left",
            "Object from left",
            "How far its middle is from the chart's left edge.",
        ),
        (
            "From near edge",
            "Object from near edge",
            "How far its middle is from the chart's near edge.",
        ),
    ];
    for axis in 0..2 {
        let through = [ObjectKind::StripeAcross, ObjectKind::StripeAlong][axis];
        if object.kind == through {
            continue;
        }
        let (label, name, what) = ways[axis];
        let value = if axis == 0 {
            &mut object.x
        } else {
            &mut object.y
        };
        let mut from_edge = *value + half[axis];
        let field = [&fields.x, &fields.y][axis];
        if number(ui, label, name, &mut from_edge, field, what).changed() {
            *value = from_edge - half[axis];
        }
        let centre = Button::new("Centre").small();
        let centre = ui.add_enabled(value.abs() > 1e-9, centre);
        let name = ["Centre object across", "Centre object along"][axis];
        if centre
            .accessible_name(name)
            .on_hover_text("Into the middle of the chart.")
            .clicked()
        {
            *value = 0.0;
        }
    }
    let turns = !matches!(
        object.kind,
        ObjectKind::StripeAcross | ObjectKind::StripeAlong
    );
    if turns {
        let what = "Turns it about its middle, anticlockwise.";
        number(
            ui,
            "Turned",
            "Object rotation",
            &mut object.rotation,
            &fields.rotation,
            what,
        );
        for (icon, name, value) in [
            (
                Icon::MirrorHorizontally,
                "Mirror object left to right",
                &mut object.mirror_x,
            ),
            (
                Icon::MirrorVertically,
                "Mirror object far to near",
                &mut object.mirror_y,
            ),
        ] {
            let button = IconButton::new(icon, name, "Mirrors it about its own middle.").on(*value);
            if ui.add(button).clicked() {
                *value = !*value;
            }
        }
    }
}

/// Width and height in mm and in loops.
fn size(ui: &mut Ui, object: &mut ChartObject, sheet: &Sheet) {
    let fields = ChartObject::FIELDS;
    let keeps = matches!(object.kind, ObjectKind::Image | ObjectKind::Text);
    let before = [object.width, object.height];
    let names = match object.kind {
        ObjectKind::Line => ["Length", "Thickness"],
        ObjectKind::StripeAcross | ObjectKind::StripeAlong => ["Breadth", "Breadth"],
        _ => ["Width", "Height"],
    };
    for axis in 0..2 {
        let through = [ObjectKind::StripeAcross, ObjectKind::StripeAlong][axis];
        if object.kind == through {
            continue;
        }
        let value = if axis == 0 {
            &mut object.width
        } else {
            &mut object.height
        };
        let field = [&fields.width, &fields.height][axis];
        let name = ["Object width", "Object height"][axis];
        number(
            ui,
            names[axis],
            name,
            value,
            field,
            "As millimetres, or any other unit behind the number.",
        );
        if object.kind == ObjectKind::Line {
            continue;
        }
        let pitch = pitch(sheet)[axis];
        let mut count = loops(*value, pitch);
        let yarns = ["ends", "picks"][axis];
        ui.label("=");
        let field = NumberField::new(&mut count, "", 0.1..=1e6)
            .max_decimals(1)
            .suffix(["  ends", "  picks"][axis]);
        let shown = field
            .show(ui)
            .accessible_name(["Object width in ends", "Object height in picks"][axis]);
        if shown
            .on_hover_text(format!("As {yarns}: a loop or a crossing each."))
            .changed()
        {
            *value = count * pitch;
        }
    }
    if keeps {
        let after = [object.width, object.height];
        // One side was typed: the other follows.
        if after[0] != before[0] {
            object.height = rounded(before[1] * after[0] / before[0]);
        } else if after[1] != before[1] {
            object.width = rounded(before[0] * after[1] / before[1]);
        }
    }
    if matches!(object.kind, ObjectKind::Rectangle | ObjectKind::Ellipse) {
        let what = "Draws its outline as wide as this; 0 fills it.";
        number(
            ui,
            "Outline",
            "Object outline",
            &mut object.border,
            &fields.border,
            what,
        );
    }
}

fn look(ui: &mut Ui, object: &mut ChartObject) {
    if object.kind != ObjectKind::Image {
        let label = ui.label("Colour");
        ui.add_enabled_ui(!object.bare, |ui| {
            let well = colour_well(ui, &mut object.colour.0).labelled_by(label.id);
            well.on_hover_text("The yarn it is woven with. The yarns of the chart are above.");
            ui.monospace(String::from(object.colour));
        });
        check_box(ui, &mut object.bare, "bare")
            .on_hover_text("Plants no loops there: the ground weave is seen.");
    }
    let mut percent = (object.opacity * 1000.0).round() / 10.0;
    ui.label("Opacity");
    let opacity = NumberField::new(&mut percent, "%", 0.0..=100.0)
        .max_decimals(1)
        .suffix(" %");
    let what = "Less than 100 % mixes its colour with what lies below: to new colours, which are no yarns.";
    if opacity
        .show(ui)
        .accessible_name("Object opacity")
        .on_hover_text(what)
        .changed()
    {
        object.opacity = percent / 100.0;
    }
}

fn repeats(ui: &mut Ui, object: &mut ChartObject) {
    let fields = ChartObject::FIELDS;
    let ways = [
        (
            "Side by side",
            "times",
            "Object repeats across",
            "every",
            "Object step across",
        ),
        (
            "One beyond the other",
            "times",
            "Object repeats along",
            "every",
            "Object step along",
        ),
    ];
    for axis in 0..2 {
        let through = [ObjectKind::StripeAcross, ObjectKind::StripeAlong][axis];
        if object.kind == through {
            continue;
        }
        let (label, unit, count_name, every, step_name) = ways[axis];
        let (count, step) = match axis {
            0 => (&mut object.repeat_x, &mut object.step_x),
            _ => (&mut object.repeat_y, &mut object.step_y),
        };
        let field = [&fields.repeat_x, &fields.repeat_y][axis];
        ui.label(label);
        let times = NumberField::new(count, unit, field.min..=field.max)
            .speed(0.1)
            .suffix(" ×");
        times
            .show(ui)
            .accessible_name(count_name)
            .on_hover_text(field.what);
        if *count > 1 {
            let field = [&fields.step_x, &fields.step_y][axis];
            number(ui, every, step_name, step, field, field.what);
        }
    }
    let mirrored = [
        (
            ObjectKind::StripeAcross,
            "mirrored left–right",
            &mut object.reflect_x,
            fields.x.what,
        ),
        (
            ObjectKind::StripeAlong,
            "mirrored near–far",
            &mut object.reflect_y,
            fields.y.what,
        ),
    ];
    for (through, text, value, _) in mirrored {
        if object.kind != through {
            check_box(ui, value, text)
                .on_hover_text("Stands once more, mirrored about the chart's middle.");
        }
    }
}

/// Words and font of a text.
fn text(ui: &mut Ui, editor: &mut ChartEditor, object: &mut ChartObject) {
    let label = ui.label("Text");
    let refused = &mut editor.objects.refused_text;
    let of_object = object.text.clone().unwrap_or_default();
    let mut typed = refused
        .as_ref()
        .map_or(of_object, |(typed, _)| typed.clone());
    let edit = TextEdit::multiline(&mut typed)
        .desired_rows(1)
        .desired_width(150.0);
    let edit = ui.add(edit).labelled_by(label.id);
    if edit.changed() {
        let font = object.font.clone();
        *refused = set_text(object, &typed, font.as_deref())
            .err()
            .map(|why| (typed, why));
    } else if !edit.has_focus() {
        *refused = None;
    }
    let shown = object.font.clone().unwrap_or_default();
    let combo = ComboBox::from_id_salt("font")
        .selected_text(&shown)
        .width(150.0)
        .height(FONTS_HEIGHT);
    let combo = combo.show_ui(ui, |ui| {
        for font in font_names() {
            if ui.selectable_label(shown == font, font).clicked() {
                let text = object.text.clone().unwrap_or_default();
                *refused = set_text(object, &text, Some(font))
                    .err()
                    .map(|why| (text, why));
            }
        }
    });
    combo.response.accessible_name("Font").on_hover_text("Fonts of this machine. The file keeps the letters' outlines: it looks the same where the font is missing.");
    if let Some((_, why)) = refused {
        ui.colored_label(ui.visuals().error_fg_color, why.as_str());
    }
}

/// What of a picture is transparent, and whether it is averaged.
fn picture(
    ui: &mut Ui,
    editor: &mut ChartEditor,
    chart: &mut Chart,
    index: usize,
) -> Option<String> {
    let object = &mut chart.object[index];
    let mut has_transparent = object.transparent.is_some();
    let corner = object.pixels.as_ref().map(|image| image.pixel(0, 0));
    let check = check_box(ui, &mut has_transparent, "Transparent colour");
    if check
        .on_hover_text("What of the picture has this colour is left out: the chart is seen there.")
        .changed()
    {
        // In most pictures the corner is ground.
        let [r, g, b, _] = corner.unwrap_or([255; 4]);
        object.transparent = has_transparent.then_some(Colour([r, g, b]));
    }
    if let Some(colour) = &mut object.transparent {
        colour_well(ui, &mut colour.0).accessible_name("Transparent colour of the picture");
        ui.label("±");
        let field = ChartObject::FIELDS.tolerance;
        let tolerance = NumberField::new(&mut object.tolerance, "", 0.0..=1.0)
            .speed(0.002)
            .max_decimals(3);
        tolerance
            .show(ui)
            .accessible_name("Tolerance")
            .on_hover_text(field.what);
    }
    check_box(ui, &mut object.average, "average")
        .on_hover_text("Each loop takes the mean colour of the pixels around it: for photographs.");
    let instead = ui.button("Use as chart");
    if instead
        .on_hover_text("Makes the picture the chart, instead of the one that is there.")
        .clicked()
    {
        use_as_chart(chart, index);
        editor.objects.selected = None;
        return Some("use picture as chart".into());
    }
    None
}
