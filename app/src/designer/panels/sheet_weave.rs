//! Sheet & weave: size of the ground weave, and the stitch pattern on a grid.

use egui::{Button, DragValue, RichText, Ui};
use renderer_core::design::{Back, Design, Pattern, STITCHES, Sheet};

use crate::designer::style;
use crate::designer::widgets::{
    GridAccess, GridCell, GridEditor, GridTool, Icon, IconButton, choice, grid_editor, number, row,
    subheading,
};

/// Editor of the stitch pattern.
pub struct State {
    editor: GridEditor,
}

impl Default for State {
    fn default() -> Self {
        Self {
            editor: GridEditor::new(7),
        }
    }
}

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design) {
    let fields = Sheet::FIELDS;
    let sheet = &mut design.sheet;
    number(ui, &fields.warps, &mut sheet.warps);
    number(ui, &fields.wefts, &mut sheet.wefts);
    number(ui, &fields.warps_per_cm, &mut sheet.warps_per_cm);
    number(ui, &fields.wefts_per_cm, &mut sheet.wefts_per_cm);
    row(ui, "Size", "Width and length of the cloth.", |ui, _| {
        let width = f64::from(sheet.warps) * sheet.pitch_x() / 10.0;
        let length = f64::from(sheet.wefts) * sheet.pitch_y() / 10.0;
        ui.weak(format!("{width:.1} × {length:.1} cm"));
    });
    let weave = &mut design.weave;
    choice(
        ui,
        "Back",
        "What stands on the back of the cloth.",
        &mut weave.back,
    );
    subheading(ui, "Stitch pattern");
    brushes(ui, &mut state.editor);
    tools(ui, &mut state.editor, &mut weave.pattern);
    let cells = STITCHES.map(|value| {
        let (ground, ink) = style::stitch_colours(value, ui.visuals());
        GridCell {
            value,
            ground,
            ink,
            name: stitch_name(value),
        }
    });
    let size = [weave.pattern.cols(), weave.pattern.rows()];
    ui.horizontal_top(|ui| {
        grid_editor(
            ui,
            "Stitch pattern",
            &mut state.editor,
            size,
            &cells,
            &mut weave.pattern,
        );
        repeat_preview(ui, &weave.pattern);
    });
    let follows = match weave.back {
        Back::Pattern => "",
        Back::Mirror | Back::None => {
            " Loops of 8 and 9 on the back stand only where the back follows the pattern."
        }
    };
    let uses_back = (0..size[1])
        .any(|row| (0..size[0]).any(|col| matches!(weave.pattern.get(col, row), 8 | 9)));
    if uses_back && !follows.is_empty() {
        ui.label(RichText::new(follows.trim()).small().weak());
    }
}

/// Side of a cell of the preview, points.
const PREVIEW_CELL: f32 = 4.0;
/// Smallest preview, cells; narrower places have none.
const PREVIEW_CELLS: usize = 12;

/// The pattern as it repeats over the cloth, in the room beside the editor.
fn repeat_preview(ui: &mut Ui, pattern: &Pattern) {
    ui.add_space(8.0);
    let cols = (ui.available_width() / PREVIEW_CELL) as usize;
    if cols < PREVIEW_CELLS {
        return;
    }
    let rows = (ui.available_height().clamp(52.0, 104.0) / PREVIEW_CELL) as usize;
    let size = egui::vec2(cols as f32, rows as f32) * PREVIEW_CELL;
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    let colours = STITCHES.map(|value| (value, style::stitch_colours(value, ui.visuals()).0));
    let painter = ui.painter_at(rect);
    for row in 0..rows {
        for col in 0..cols {
            let corner =
                rect.left_bottom() + egui::vec2(col as f32, -((row + 1) as f32)) * PREVIEW_CELL;
            let cell = egui::Rect::from_min_size(corner, egui::Vec2::splat(PREVIEW_CELL));
            let value = pattern.at(col as i64, row as i64);
            let colour = colours.iter().find(|(other, _)| *other == value);
            let colour = colour.map_or(ui.visuals().error_fg_color, |(_, colour)| *colour);
            painter.rect_filled(cell, 0.0, colour);
        }
    }
    response.on_hover_text("The pattern as it repeats over the cloth.");
}

fn stitch_name(value: u8) -> &'static str {
    match value {
        0 => "weft over warp",
        1 => "warp over weft",
        7 => "loop on the front",
        8 => "loop on the back",
        9 => "loops on both faces",
        _ => "not allowed",
    }
}

/// The five stitches to paint with.
fn brushes(ui: &mut Ui, editor: &mut GridEditor) {
    ui.horizontal(|ui| {
        for value in STITCHES {
            let (ground, ink) = style::stitch_colours(value, ui.visuals());
            let chosen = editor.brush == value;
            let mut button = Button::new(RichText::new(value.to_string()).color(ink).strong())
                .fill(ground)
                .min_size(egui::vec2(26.0, 22.0));
            if chosen {
                let outline = egui::Stroke::new(2.0, ui.visuals().strong_text_color());
                button = button.stroke(outline);
            }
            let name = format!("Paint {value}: {}", stitch_name(value));
            let button = ui.add(button).accessible_name(&name).on_hover_text(&name);
            if button.clicked() {
                editor.brush = value;
            }
        }
        ui.label(RichText::new(stitch_name(editor.brush)).weak());
    });
}

fn tools(ui: &mut Ui, editor: &mut GridEditor, pattern: &mut Pattern) {
    ui.horizontal(|ui| {
        for (tool, icon, name, what) in [
            (
                GridTool::Pencil,
                Icon::Pencil,
                "Pencil",
                "Pencil: paints the cells under the pointer. Right click picks a value; arrows, space and digits paint by keyboard.",
            ),
            (
                GridTool::Fill,
                Icon::Fill,
                "Fill",
                "Fill: paints all connected cells of the same value.",
            ),
        ] {
            let button = IconButton::new(icon, name, what).on(editor.tool == tool);
            if ui.add(button).clicked() {
                editor.tool = tool;
            }
        }
        ui.separator();
        let (mut cols, mut rows) = (pattern.cols(), pattern.rows());
        let side = |value| DragValue::new(value).range(1..=Pattern::MAX_SIDE).speed(0.1);
        ui.add(side(&mut cols))
            .accessible_name("Pattern columns")
            .on_hover_text("Columns of the pattern: its repeat along the weft. What is painted is kept.");
        ui.label("×");
        ui.add(side(&mut rows))
            .accessible_name("Pattern rows")
            .on_hover_text("Rows of the pattern: its repeat along the warp. What is painted is kept.");
        if (cols, rows) != (pattern.cols(), pattern.rows()) {
            *pattern = pattern.resized(cols, rows);
        }
    });
}

impl GridAccess for Pattern {
    fn get(&self, col: usize, row: usize) -> u8 {
        self.at(col as i64, row as i64)
    }

    fn set(&mut self, col: usize, row: usize, value: u8) {
        Pattern::set(self, col, row, value);
    }
}
