//! The stitches: what each is, to paint with; and the pattern as it repeats over the cloth.

use egui::{Button, Color32, Mesh, Rect, RichText, Sense, Shape, Stroke, Ui, Vec2, Visuals, vec2};
use renderer_core::design::{Pattern, STITCHES};

use crate::designer::widgets::GridEditor;

/// What a stitch is, in a few words.
pub(super) fn stitch_name(value: u8) -> &'static str {
    match value {
        0 => "weft over warp",
        1 => "warp over weft",
        7 => "loop on the front",
        8 => "loop on the back",
        9 => "loops on both faces",
        _ => "not allowed",
    }
}

/// The five stitches side by side, and the name of the one that is painted with.
pub(super) fn brushes(ui: &mut Ui, editor: &mut GridEditor) {
    ui.horizontal(|ui| {
        for value in STITCHES {
            brush(ui, editor, value);
        }
        ui.label(RichText::new(stitch_name(editor.brush)).weak());
    });
}

/// The five stitches one below the other with their names.
pub(super) fn list(ui: &mut Ui, editor: &mut GridEditor) {
    for value in STITCHES {
        ui.horizontal(|ui| {
            brush(ui, editor, value);
            ui.label(stitch_name(value));
        });
    }
}

fn brush(ui: &mut Ui, editor: &mut GridEditor, value: u8) {
    let (ground, ink) = stitch_colours(value, ui.visuals());
    let mut button = Button::new(RichText::new(value.to_string()).color(ink).strong())
        .fill(ground)
        .min_size(vec2(26.0, 22.0));
    if editor.brush == value {
        button = button.stroke(Stroke::new(2.0, ui.visuals().strong_text_color()));
    }
    let name = format!("Paint {value}: {}", stitch_name(value));
    let tooltip = format!("{name}. Key {value} on the grid.");
    let button = ui.add(button).accessible_name(&name).on_hover_text(tooltip);
    if button.clicked() {
        editor.brush = value;
    }
}

/// Side of a cell of the preview, points.
const PREVIEW_CELL: f32 = 4.0;
/// Smallest preview, cells; narrower places have none.
const PREVIEW_CELLS: usize = 12;

/// The pattern as it repeats over the cloth, in the room beside the editor.
pub(super) fn repeat_preview(ui: &mut Ui, pattern: &Pattern) {
    ui.add_space(8.0);
    let cols = (ui.available_width() / PREVIEW_CELL) as usize;
    if cols < PREVIEW_CELLS {
        return;
    }
    let rows = (ui.available_height().clamp(52.0, 104.0) / PREVIEW_CELL) as usize;
    let size = vec2(cols as f32, rows as f32) * PREVIEW_CELL;
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    paint(ui, pattern, rect, PREVIEW_CELL);
    response.on_hover_text("The pattern as it repeats over the cloth.");
}

/// Fills a place with the pattern, from its lower left.
pub(super) fn paint(ui: &Ui, pattern: &Pattern, rect: Rect, side: f32) {
    let colours: [Color32; 10] =
        std::array::from_fn(|value| stitch_colours(value as u8, ui.visuals()).0);
    let [cols, rows] = [rect.width(), rect.height()].map(|length| (length / side).round() as i64);
    let mut mesh = Mesh::default();
    for row in 0..rows {
        for col in 0..cols {
            let corner = rect.left_bottom() + vec2(col as f32, -((row + 1) as f32)) * side;
            let colour = colours.get(usize::from(pattern.at(col, row)));
            let colour = colour.copied().unwrap_or(ui.visuals().error_fg_color);
            mesh.add_colored_rect(Rect::from_min_size(corner, Vec2::splat(side)), colour);
        }
    }
    ui.painter_at(rect).add(Shape::mesh(mesh));
}

/// Colour of a stitch in the pattern editor, and of its glyph.
pub(super) fn stitch_colours(value: u8, visuals: &Visuals) -> (Color32, Color32) {
    let dark = visuals.dark_mode;
    let ground = match (value, dark) {
        (0, true) => Color32::from_rgb(0x35, 0x37, 0x3a),
        (0, false) => Color32::from_rgb(0xf7, 0xf7, 0xf6),
        (1, true) => Color32::from_rgb(0x5c, 0x60, 0x65),
        (1, false) => Color32::from_rgb(0xc6, 0xca, 0xce),
        (7, true) => Color32::from_rgb(0x9a, 0x6a, 0x35),
        (7, false) => Color32::from_rgb(0xe8, 0xb9, 0x78),
        (8, true) => Color32::from_rgb(0x3d, 0x64, 0x86),
        (8, false) => Color32::from_rgb(0x9c, 0xc1, 0xde),
        (9, true) => Color32::from_rgb(0x57, 0x78, 0x49),
        (9, false) => Color32::from_rgb(0xae, 0xcf, 0x9d),
        (_, _) => visuals.error_fg_color,
    };
    let glyph = if dark {
        Color32::from_gray(0xec)
    } else {
        Color32::from_gray(0x24)
    };
    (ground, glyph)
}
