//! A grid of small values to paint on: pencil, fill, pick; by pointer and by keyboard. Row 0 is at the bottom.

use egui::{
    Align2, Color32, CursorIcon, EventFilter, FontId, Key, PointerButton, Pos2, Rect, Response,
    Role, ScrollArea, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, pos2, vec2,
};

use super::shapes::{self, Cell, Run};
use crate::designer::style;

/// What the primary pointer button and the space bar do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GridTool {
    /// Sets the cells that the pointer passes.
    #[default]
    Pencil,
    /// Sets all connected cells of the same value.
    Fill,
}

/// How a value is drawn and typed.
#[derive(Debug, Clone, Copy)]
pub struct GridCell {
    /// The value.
    pub value: u8,
    /// Colour of the cell.
    pub ground: Color32,
    /// Colour of its glyph.
    pub ink: Color32,
    /// What a screen reader says.
    pub name: &'static str,
}

/// State of an editor: tool, value to paint with, keyboard position.
#[derive(Debug, Clone, Default)]
pub struct GridEditor {
    /// Current tool.
    pub tool: GridTool,
    /// Value that tools paint with.
    pub brush: u8,
    cursor: [usize; 2],
    last: Option<[usize; 2]>,
}

impl GridEditor {
    /// A pencil that paints `brush`.
    pub fn new(brush: u8) -> Self {
        Self {
            brush,
            ..Self::default()
        }
    }
}

/// Largest and smallest side of a cell, points.
const CELL: std::ops::RangeInclusive<f32> = 9.0..=26.0;
/// Below this side a glyph would not be legible.
const GLYPH_CELL: f32 = 13.0;

/// Shows a grid of `cols` × `rows` values and paints on it through `get` and `set`.
///
/// Pointer: primary paints, secondary picks the value under it. Keyboard, when focused: arrows move, space paints, a
/// digit paints that value.
pub fn grid_editor(
    ui: &mut Ui,
    name: &str,
    editor: &mut GridEditor,
    [cols, rows]: [usize; 2],
    cells: &[GridCell],
    grid: &mut impl GridAccess,
) -> Response {
    editor.cursor = [
        editor.cursor[0].min(cols - 1),
        editor.cursor[1].min(rows - 1),
    ];
    let fitting = ui.available_width() / cols as f32;
    let side = fitting.floor().clamp(*CELL.start(), *CELL.end());
    let size = vec2(cols as f32, rows as f32) * side;
    ScrollArea::both()
        .id_salt(name)
        .max_height(234.0)
        .auto_shrink(true)
        .show(ui, |ui| {
            let (rect, mut response) =
                ui.allocate_exact_size(size + Vec2::splat(1.0), Sense::click_and_drag());
            let canvas = Canvas {
                rect: Rect::from_min_size(rect.min, size),
                side,
                rows,
                cols,
            };
            let changed = pointer(ui, editor, &canvas, &response, grid)
                | keyboard(ui, editor, &canvas, &response, cells, grid);
            if changed {
                response.mark_changed();
            }
            paint(ui, editor, &canvas, &response, cells, grid);
            let [col, row] = editor.cursor;
            let value = grid.get(col, row);
            let meaning = cells
                .iter()
                .find(|c| c.value == value)
                .map_or("", |c| c.name);
            response.widget_info(|| WidgetInfo {
                current_text_value: Some(format!("column {col}, row {row}: {value}, {meaning}")),
                ..WidgetInfo::labeled(Role::Grid, ui.is_enabled(), name)
            });
            response.on_hover_cursor(CursorIcon::Crosshair)
        })
        .inner
}

/// What a grid editor edits.
pub trait GridAccess {
    /// Value of a cell.
    fn get(&self, col: usize, row: usize) -> u8;
    /// Sets a cell.
    fn set(&mut self, col: usize, row: usize, value: u8);
}

struct Canvas {
    rect: Rect,
    side: f32,
    cols: usize,
    rows: usize,
}

impl Canvas {
    fn cell(&self, at: Pos2) -> Option<[usize; 2]> {
        let from_corner = at - self.rect.left_bottom();
        let (col, row) = (
            (from_corner.x / self.side).floor(),
            (-from_corner.y / self.side).floor(),
        );
        (col >= 0.0 && row >= 0.0 && col < self.cols as f32 && row < self.rows as f32)
            .then_some([col as usize, row as usize])
    }

    fn rect_of(&self, [col, row]: [usize; 2]) -> Rect {
        let corner = pos2(
            self.rect.left() + col as f32 * self.side,
            self.rect.bottom() - (row + 1) as f32 * self.side,
        );
        Rect::from_min_size(corner, Vec2::splat(self.side))
    }
}

fn pointer(
    ui: &Ui,
    editor: &mut GridEditor,
    canvas: &Canvas,
    response: &Response,
    grid: &mut impl GridAccess,
) -> bool {
    let primary = response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down());
    let released = response.clicked_by(PointerButton::Primary);
    let cell = response
        .interact_pointer_pos()
        .and_then(|at| canvas.cell(at));
    if let (true, Some([col, row])) = (response.secondary_clicked(), cell) {
        editor.brush = grid.get(col, row);
    }
    if !(primary || released) {
        editor.last = None;
        return false;
    }
    let Some(cell) = cell else { return false };
    response.request_focus();
    editor.cursor = cell;
    let changed = match editor.tool {
        // All cells on the way, so that a fast stroke has no gaps.
        GridTool::Pencil => shapes::line(signed(editor.last.unwrap_or(cell)), signed(cell))
            .map(|[col, row]| put(grid, col as usize, row as usize, editor.brush))
            .fold(false, |any, one| any | one),
        // One fill a press, or a drag across the border of the filled area would fill on.
        GridTool::Fill if editor.last.is_none() => fill(grid, canvas, cell, editor.brush),
        GridTool::Fill => false,
    };
    editor.last = primary.then_some(cell);
    changed
}

fn keyboard(
    ui: &Ui,
    editor: &mut GridEditor,
    canvas: &Canvas,
    response: &Response,
    cells: &[GridCell],
    grid: &mut impl GridAccess,
) -> bool {
    if !response.has_focus() {
        return false;
    }
    let keep = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
    let presses = |key| ui.input(|i| i.num_presses(key));
    let [col, row] = &mut editor.cursor;
    *col = (*col + presses(Key::ArrowRight)).min(canvas.cols - 1);
    *col = col.saturating_sub(presses(Key::ArrowLeft));
    *row = (*row + presses(Key::ArrowUp)).min(canvas.rows - 1);
    *row = row.saturating_sub(presses(Key::ArrowDown));
    let [col, row] = editor.cursor;
    let typed = ui.input(|i| {
        i.events.iter().find_map(|event| match event {
            egui::Event::Text(text) => text.parse::<u8>().ok(),
            _ => None,
        })
    });
    if let Some(value) = typed.filter(|value| cells.iter().any(|cell| cell.value == *value)) {
        editor.brush = value;
        return put(grid, col, row, value);
    }
    presses(Key::Space) > 0
        && match editor.tool {
            GridTool::Pencil => put(grid, col, row, editor.brush),
            GridTool::Fill => fill(grid, canvas, [col, row], editor.brush),
        }
}

fn put(grid: &mut impl GridAccess, col: usize, row: usize, value: u8) -> bool {
    let differs = grid.get(col, row) != value;
    if differs {
        grid.set(col, row, value);
    }
    differs
}

fn fill(grid: &mut impl GridAccess, canvas: &Canvas, start: [usize; 2], value: u8) -> bool {
    if grid.get(start[0], start[1]) == value {
        return false;
    }
    let size = [canvas.cols as i32, canvas.rows as i32];
    let at = |[col, row]: Cell| grid.get(col as usize, row as usize);
    for [col, row] in shapes::connected(size, signed(start), at)
        .iter()
        .flat_map(Run::cells)
    {
        grid.set(col as usize, row as usize, value);
    }
    true
}

fn signed(cell: [usize; 2]) -> Cell {
    cell.map(|side| side as i32)
}

fn paint(
    ui: &Ui,
    editor: &GridEditor,
    canvas: &Canvas,
    response: &Response,
    cells: &[GridCell],
    grid: &impl GridAccess,
) {
    let painter = ui.painter_at(canvas.rect.expand(1.0));
    let line = Stroke::new(1.0, ui.visuals().extreme_bg_color);
    let font = FontId::proportional((canvas.side * 0.62).min(13.0));
    // Only what the scroll area shows.
    let shown = canvas.rect.intersect(ui.clip_rect());
    let first_col = ((shown.left() - canvas.rect.left()) / canvas.side).max(0.0) as usize;
    let first_row = ((canvas.rect.bottom() - shown.bottom()) / canvas.side).max(0.0) as usize;
    let shown_cols = (shown.width() / canvas.side).ceil() as usize + 1;
    let shown_rows = (shown.height() / canvas.side).ceil() as usize + 1;
    for row in first_row..(first_row + shown_rows).min(canvas.rows) {
        for col in first_col..(first_col + shown_cols).min(canvas.cols) {
            let rect = canvas.rect_of([col, row]);
            let value = grid.get(col, row);
            let look = cells.iter().find(|cell| cell.value == value);
            let (ground, ink) = look.map_or((ui.visuals().error_fg_color, Color32::BLACK), |c| {
                (c.ground, c.ink)
            });
            painter.rect(rect, 0.0, ground, line, StrokeKind::Middle);
            if canvas.side >= GLYPH_CELL {
                painter.text(
                    rect.center(),
                    Align2::CENTER_CENTER,
                    value,
                    font.clone(),
                    ink,
                );
            }
        }
    }
    if response.has_focus() {
        let rect = canvas.rect_of(editor.cursor).shrink(1.0);
        let stroke = Stroke::new(2.0, style::accent(ui.visuals()));
        painter.rect_stroke(rect, 1.0, stroke, StrokeKind::Inside);
    } else if let Some(cell) = response.hover_pos().and_then(|at| canvas.cell(at)) {
        let stroke = Stroke::new(1.0, ui.visuals().strong_text_color());
        painter.rect_stroke(canvas.rect_of(cell), 0.0, stroke, StrokeKind::Inside);
    }
}
