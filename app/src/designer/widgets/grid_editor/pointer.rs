//! Painting by pointer.

use egui::{Key, Response, Ui};

use super::canvas::Canvas;
use super::{Gesture, GridAccess, GridEditor, GridTool, fill, get, put, put_all};
use crate::designer::widgets::PointerWay;
use crate::designer::widgets::shapes::{self, Cell};

/// Does what the pointer asks for. Whether a value changed.
pub(super) fn work(
    ui: &Ui,
    editor: &mut GridEditor,
    canvas: &Canvas,
    response: &Response,
    grid: &mut impl GridAccess,
) -> bool {
    zoom(ui, editor, response);
    let is_by_keys = matches!(editor.gesture, Gesture::Shape { by_keys: true, .. });
    let is_by_pointer = editor.gesture != Gesture::None && !is_by_keys;
    if is_by_pointer && ui.input(|i| i.key_pressed(Key::Escape)) {
        return cancel(editor, grid);
    }
    let holds_primary = is_by_pointer && !editor.picks_by_secondary;
    let way = PointerWay::new(ui, response, holds_primary);
    // A press and its release can come in the same frame.
    let picked = response.secondary_clicked()
        || (response.is_pointer_button_down_on() && ui.input(|i| i.pointer.secondary_down()));
    let places = if way.places.is_empty() {
        response.interact_pointer_pos().into_iter().collect()
    } else {
        way.places
    };
    let cells: Vec<Cell> = places.into_iter().map(|at| canvas.cell(at)).collect();
    let mut changed = false;
    if (way.begins || picked)
        && !is_by_pointer
        && let Some(&cell) = cells.first()
    {
        let alt = ui.input(|i| i.modifiers.alt);
        response.request_focus();
        editor.picks_by_secondary = !way.begins;
        changed = if picked || alt || editor.tool == GridTool::Pick {
            editor.gesture = Gesture::Picking;
            false
        } else {
            begin(editor, canvas, grid, cell)
        };
    }
    let constrained = ui.input(|i| i.modifiers.shift);
    for cell in cells {
        changed |= go_on(editor, canvas, grid, cell, constrained);
    }
    let ends = if editor.picks_by_secondary {
        !ui.input(|i| i.pointer.secondary_down())
    } else {
        way.ends
    };
    let is_by_keys = matches!(editor.gesture, Gesture::Shape { by_keys: true, .. });
    if ends && !is_by_keys && editor.gesture != Gesture::None {
        changed |= editor.finish_shape(grid);
        editor.gesture = Gesture::None;
    }
    changed
}

/// Ctrl and the wheel, or two fingers.
fn zoom(ui: &Ui, editor: &mut GridEditor, response: &Response) {
    let factor = ui.input(egui::InputState::zoom_delta);
    if response.contains_pointer() && factor != 1.0 {
        editor.zoom_by(factor.ln() / super::ZOOM_STEP.ln());
    }
}

/// A press of the primary button, on a tool that paints.
fn begin(editor: &mut GridEditor, canvas: &Canvas, grid: &mut impl GridAccess, cell: Cell) -> bool {
    editor.gesture = Gesture::Spent;
    if !canvas.has(cell) {
        return false;
    }
    editor.cursor = cell;
    match editor.tool {
        GridTool::Pencil => {
            editor.gesture = Gesture::Stroke {
                last: cell,
                before: grid.values().to_vec(),
            };
            put(grid, cell, editor.brush)
        }
        // One fill a press, or a drag across the border of the filled area would fill on.
        GridTool::Fill => fill(grid, cell, editor.brush),
        GridTool::Pick => false,
        GridTool::Line | GridTool::Rectangle | GridTool::FilledRectangle => {
            editor.gesture = Gesture::Shape {
                from: cell,
                to: cell,
                by_keys: false,
            };
            false
        }
    }
}

/// The pointer, with its button down, is over `cell`.
fn go_on(
    editor: &mut GridEditor,
    canvas: &Canvas,
    grid: &mut impl GridAccess,
    cell: Cell,
    constrained: bool,
) -> bool {
    match &mut editor.gesture {
        Gesture::Stroke { last, .. } => {
            // All cells on the way, so that a fast stroke has no gaps.
            let way = shapes::line(std::mem::replace(last, cell), cell);
            editor.cursor = canvas.nearest(cell);
            put_all(grid, way, editor.brush)
        }
        Gesture::Shape {
            from,
            by_keys: false,
            ..
        } => {
            let from = *from;
            let end = editor.shape_end(from, cell, constrained);
            editor.gesture = Gesture::Shape {
                from,
                to: end,
                by_keys: false,
            };
            editor.cursor = canvas.nearest(end);
            false
        }
        Gesture::Picking => {
            if let Some(value) = get(grid, cell) {
                editor.brush = value;
                editor.cursor = cell;
            }
            false
        }
        Gesture::None | Gesture::Spent | Gesture::Shape { .. } => false,
    }
}

/// Takes back what is under way.
fn cancel(editor: &mut GridEditor, grid: &mut impl GridAccess) -> bool {
    let gesture = std::mem::replace(&mut editor.gesture, Gesture::Spent);
    let Gesture::Stroke { before, .. } = gesture else {
        return false;
    };
    let cols = grid.size()[0];
    for (index, value) in before.into_iter().enumerate() {
        grid.set(index % cols, index / cols, value);
    }
    true
}
