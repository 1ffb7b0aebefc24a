//! Painting by keyboard.

use egui::{Event, EventFilter, Key, Modifiers, Response, Ui};

use super::canvas::Canvas;
use super::{Gesture, GridAccess, GridCell, GridEditor, GridTool, fill, get, put, put_all};
use crate::designer::widgets::shapes;

/// Does what the keys ask for, if the grid has the focus. Whether a value changed.
pub(super) fn work(
    ui: &Ui,
    editor: &mut GridEditor,
    canvas: &Canvas,
    response: &Response,
    cells: &[GridCell],
    grid: &mut impl GridAccess,
) -> bool {
    let is_by_keys = matches!(editor.gesture, Gesture::Shape { by_keys: true, .. });
    if !response.has_focus() {
        if is_by_keys {
            editor.gesture = Gesture::None;
        }
        return false;
    }
    let keep = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        // While a shape is drawn out, Escape takes it back and does not leave the grid.
        escape: editor.gesture != Gesture::None,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
    if is_by_keys && ui.input(|i| i.key_pressed(Key::Escape)) {
        editor.gesture = Gesture::None;
        return false;
    }
    if !(editor.gesture == Gesture::None || is_by_keys) {
        return false;
    }
    choose_tool(ui, editor);
    let mut changed = move_cursor(ui, editor, canvas, response, grid);
    let typed = ui.input(|i| {
        i.events.iter().find_map(|event| match event {
            Event::Text(text) => text.parse::<u8>().ok(),
            _ => None,
        })
    });
    if let Some(value) = typed.filter(|value| cells.iter().any(|cell| cell.value == *value)) {
        editor.brush = value;
        if editor.gesture == Gesture::None {
            changed |= put(grid, editor.cursor, value);
        }
    }
    let (space, enter) = ui.input(|i| (i.key_pressed(Key::Space), i.key_pressed(Key::Enter)));
    changed | ((space || enter) && press(editor, grid))
}

/// What the primary button would do at the cursor.
fn press(editor: &mut GridEditor, grid: &mut impl GridAccess) -> bool {
    if editor.gesture != Gesture::None {
        return editor.finish_shape(grid);
    }
    match editor.tool {
        GridTool::Pencil => put(grid, editor.cursor, editor.brush),
        GridTool::Fill => fill(grid, editor.cursor, editor.brush),
        GridTool::Pick => {
            editor.brush = get(grid, editor.cursor).unwrap_or(editor.brush);
            false
        }
        GridTool::Line | GridTool::Rectangle | GridTool::FilledRectangle => {
            editor.gesture = Gesture::Shape {
                from: editor.cursor,
                to: editor.cursor,
                by_keys: true,
            };
            false
        }
    }
}

fn choose_tool(ui: &Ui, editor: &mut GridEditor) {
    const PLAIN: Modifiers = Modifiers::NONE;
    let keys = [
        (PLAIN, Key::P, GridTool::Pencil),
        (PLAIN, Key::L, GridTool::Line),
        (PLAIN, Key::R, GridTool::Rectangle),
        (Modifiers::SHIFT, Key::R, GridTool::FilledRectangle),
        (PLAIN, Key::F, GridTool::Fill),
        (PLAIN, Key::I, GridTool::Pick),
    ];
    for (modifiers, key, tool) in keys {
        if ui.input(|i| i.modifiers == modifiers && i.key_pressed(key)) {
            editor.tool = tool;
            if !tool.draws_shape() {
                editor.gesture = Gesture::None;
            }
        }
    }
    let presses = |key| ui.input(|i| i.num_presses(key) as f32);
    if ui.input(|i| !i.modifiers.command) {
        let steps = presses(Key::Plus) + presses(Key::Equals) - presses(Key::Minus);
        if steps != 0.0 {
            editor.zoom_by(steps);
        }
    }
}

fn move_cursor(
    ui: &Ui,
    editor: &mut GridEditor,
    canvas: &Canvas,
    response: &Response,
    grid: &mut impl GridAccess,
) -> bool {
    let presses = |key| ui.input(|i| i.num_presses(key) as i32);
    let modifiers = ui.input(|i| i.modifiers);
    let right = presses(Key::ArrowRight) - presses(Key::ArrowLeft);
    let up = presses(Key::ArrowUp) - presses(Key::ArrowDown);
    if (right, up) == (0, 0) || modifiers.command || modifiers.alt {
        return false;
    }
    let before = editor.cursor;
    let [col, row] = before;
    editor.cursor = canvas.nearest([col + right, row + up]);
    ui.scroll_to_rect_animation(
        canvas.rect_of(editor.cursor),
        None,
        egui::style::ScrollAnimation::none(),
    );
    response.ctx.request_repaint();
    match (&mut editor.gesture, editor.tool) {
        (Gesture::Shape { to, .. }, _) => *to = editor.cursor,
        (_, GridTool::Pencil) if modifiers.shift => {
            return put_all(grid, shapes::line(before, editor.cursor), editor.brush);
        }
        (gesture, tool) if modifiers.shift && tool.draws_shape() => {
            *gesture = Gesture::Shape {
                from: before,
                to: editor.cursor,
                by_keys: true,
            };
        }
        _ => {}
    }
    false
}
