//! A button with a colour, which opens a picker: lightness, chroma and hue as strips and numbers, a* and b*, and the
//! colour as text. What is typed and is no colour stays, in red, until it is mended.

use egui::{
    Button, Color32, Id, Key, Mesh, Popup, PopupCloseBehavior, Rect, Response, RichText, Sense,
    Shape, Stroke, StrokeKind, TextEdit, Ui, WidgetInfo, pos2, vec2,
};

use super::NumberField;
use super::colour_space::{hex_of, lab_of, lab_of_lch, lch_of_lab, rgb_of_hex, rgb_of_lch};
use super::style;

/// Size of the strips, points.
const STRIP: egui::Vec2 = vec2(176.0, 16.0);
/// Largest chroma that a strip shows; sRGB has less.
const MOST_CHROMA: f64 = 134.0;
/// Colours that a strip is drawn with.
const STEPS: usize = 36;

/// A button with a colour, which opens a picker.
pub fn colour_well(ui: &mut Ui, rgb: &mut [u8; 3]) -> Response {
    let [r, g, b] = *rgb;
    let outline = Stroke::new(1.0, style::mark_outline(ui.visuals()));
    let size = ui.spacing().interact_size;
    let button = Button::new("")
        .fill(Color32::from_rgb(r, g, b))
        .stroke(outline);
    let mut response = ui.add(button.min_size(size));
    let popup = Popup::from_toggle_button_response(&response)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| picker(ui, rgb));
    if popup.is_some_and(|popup| popup.inner) {
        response.mark_changed();
    }
    response
}

/// The picker. Whether the colour is another now.
fn picker(ui: &mut Ui, rgb: &mut [u8; 3]) -> bool {
    let before = *rgb;
    let id = ui.scope_id().with("lch");
    // Grey has no hue, black no chroma: what was chosen last stays where it was.
    let kept: Option<([u8; 3], [f64; 3])> = ui.data(|data| data.get_temp(id));
    let mut lch = match kept {
        Some((of, lch)) if of == *rgb => lch,
        _ => lch_of_lab(lab_of(*rgb)),
    };
    let old = lch;
    ui.set_width(STRIP.x + 100.0);
    strips(ui, &mut lch);
    lab(ui, &mut lch);
    if lch != old {
        *rgb = rgb_of_lch(lch).0;
    }
    let is_all = rgb_of_lch(lch).1;
    ui.horizontal(|ui| {
        let label = ui.label("Hex");
        let before = *rgb;
        hex_field(ui, rgb).labelled_by(label.id);
        if *rgb != before {
            lch = lch_of_lab(lab_of(*rgb));
        }
    });
    let note = match is_all {
        true => "CIELAB of D65, 2°",
        false => "More chroma than a screen shows: the nearest is taken.",
    };
    ui.label(RichText::new(note).small().weak());
    ui.data_mut(|data| data.insert_temp(id, (*rgb, lch)));
    *rgb != before
}

/// Lightness, chroma and hue.
fn strips(ui: &mut Ui, lch: &mut [f64; 3]) {
    let rows = [
        ("L", "Lightness L*", 100.0),
        ("C", "Chroma C*", MOST_CHROMA),
        ("h", "Hue h", 360.0),
    ];
    for (k, (short, name, most)) in rows.into_iter().enumerate() {
        ui.horizontal(|ui| {
            ui.allocate_ui(vec2(12.0, STRIP.y), |ui| ui.label(short));
            strip(ui, lch, k, name, most);
            let unit = if k == 2 { "°" } else { "" };
            let field = NumberField::new(&mut lch[k], unit, 0.0..=most)
                .speed(0.2)
                .max_decimals(1);
            field.show(ui).accessible_name(name);
        });
    }
}

/// A strip of colours, one of L*, C* and h from end to end.
fn strip(ui: &mut Ui, lch: &mut [f64; 3], k: usize, name: &str, most: f64) {
    let (rect, response) = ui.allocate_exact_size(STRIP, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::slider(ui.is_enabled(), lch[k], format!("{name} strip")));
    if let Some(at) = response.interact_pointer_pos() {
        let share = f64::from((at.x - rect.left()) / rect.width());
        lch[k] = share.clamp(0.0, 1.0) * most;
    }
    let mut mesh = Mesh::default();
    for step in 0..=STEPS {
        let share = step as f64 / STEPS as f64;
        let mut colour = *lch;
        colour[k] = share * most;
        if k == 2 {
            // Hues of a grey would all be grey.
            colour = [colour[0].clamp(40.0, 75.0), colour[1].max(40.0), colour[2]];
        }
        let [r, g, b] = rgb_of_lch(colour).0;
        let x = rect.left() + share as f32 * rect.width();
        let colour = Color32::from_rgb(r, g, b);
        mesh.colored_vertex(pos2(x, rect.top()), colour);
        mesh.colored_vertex(pos2(x, rect.bottom()), colour);
        if step > 0 {
            let last = 2 * step as u32;
            mesh.add_triangle(last - 2, last - 1, last);
            mesh.add_triangle(last - 1, last, last + 1);
        }
    }
    let painter = ui.painter();
    painter.add(Shape::mesh(mesh));
    let outline = Stroke::new(1.0, style::mark_outline(ui.visuals()));
    painter.rect_stroke(rect, 0.0, outline, StrokeKind::Outside);
    let x = rect.left() + (lch[k] / most).clamp(0.0, 1.0) as f32 * rect.width();
    let mark = Rect::from_center_size(pos2(x, rect.center().y), vec2(5.0, rect.height() + 4.0));
    painter.rect(
        mark,
        1.0,
        Color32::TRANSPARENT,
        Stroke::new(2.5, Color32::BLACK),
        StrokeKind::Outside,
    );
    painter.rect_stroke(
        mark,
        1.0,
        Stroke::new(1.0, Color32::WHITE),
        StrokeKind::Outside,
    );
}

/// The numbers a* and b*.
fn lab(ui: &mut Ui, lch: &mut [f64; 3]) {
    let mut lab = lab_of_lch(*lch);
    ui.horizontal(|ui| {
        for (k, short, name) in [(1, "a", "a*, green to red"), (2, "b", "b*, blue to yellow")] {
            ui.allocate_ui(vec2(12.0, STRIP.y), |ui| ui.label(short));
            let field = NumberField::new(&mut lab[k], "", -130.0..=130.0)
                .speed(0.2)
                .max_decimals(1);
            if field.show(ui).accessible_name(name).changed() {
                *lch = lch_of_lab(lab);
            }
        }
    });
}

/// A colour as text. What is no colour stays in the field, in red, until it is mended or given up with Escape.
pub fn hex_field(ui: &mut Ui, rgb: &mut [u8; 3]) -> Response {
    let id = ui.next_auto_id().with("text");
    // What is typed, and the colour that was there then: another that was set since ends it.
    let typed: Option<(String, [u8; 3])> = ui.data(|data| data.get_temp(id));
    let typed = typed.filter(|(_, of)| of == rgb).map(|(text, _)| text);
    let mut text = typed.unwrap_or_else(|| hex_of(*rgb));
    let is_refused = rgb_of_hex(&text).is_none();
    let edit = TextEdit::singleline(&mut text)
        .desired_width(68.0)
        .font(egui::TextStyle::Monospace);
    let edit = match is_refused {
        true => edit.text_color(ui.visuals().error_fg_color),
        false => edit,
    };
    let response = ui.add(edit.align(egui::Align2::LEFT_CENTER));
    let is_given_up = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Escape));
    if response.changed()
        && let Some(read) = rgb_of_hex(&text)
    {
        *rgb = read;
    }
    let keeps = !is_given_up && (response.has_focus() || rgb_of_hex(&text).is_none());
    remember(ui, id, keeps.then_some((text, *rgb)));
    if is_refused {
        return response.on_hover_text(
            "This is no colour, so the one before stays: write six digits, #1f3a6e.",
        );
    }
    response.on_hover_text("Colour as #rrggbb")
}

fn remember(ui: &Ui, id: Id, typed: Option<(String, [u8; 3])>) {
    ui.data_mut(|data| match typed {
        Some(typed) => {
            data.insert_temp(id, typed);
        }
        None => {
            data.remove::<(String, [u8; 3])>(id);
        }
    });
}
