//! A grid of small values to paint on: pencil, line, rectangle, fill, pick; by pointer and by keyboard. Row 0 is at the
//! bottom.
//!
//! Pointer: primary works with the tool, secondary or Alt picks the value under it, Shift makes lines straight and
//! rectangles square, Escape takes back what is under way. Keyboard, when focused: arrows move, with Shift they draw or
//! stretch a shape, space paints or begins and ends a shape, a digit paints that value, letters choose tools, + and −
//! zoom, and so does the wheel with Ctrl.

mod canvas;
mod keyboard;
mod paint;
mod pointer;

use egui::{Color32, CursorIcon, Response, Role, ScrollArea, Sense, Ui, Vec2, WidgetInfo, vec2};

use super::icon::Icon;
use super::shapes::{self, Cell, Run};
use canvas::Canvas;
use paint::Picture;

/// What the primary pointer button and the space bar do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GridTool {
    /// Sets the cells that the pointer passes.
    #[default]
    Pencil,
    /// Sets the cells on a straight line.
    Line,
    /// Sets the outermost cells of a rectangle.
    Rectangle,
    /// Sets all cells of a rectangle.
    FilledRectangle,
    /// Sets all connected cells of the same value.
    Fill,
    /// Takes a cell's value to paint with.
    Pick,
}

impl GridTool {
    /// All tools, in the order of their buttons.
    pub const ALL: [Self; 6] = [
        Self::Pencil,
        Self::Line,
        Self::Rectangle,
        Self::FilledRectangle,
        Self::Fill,
        Self::Pick,
    ];

    /// Its picture.
    pub fn icon(self) -> Icon {
        match self {
            Self::Pencil => Icon::Pencil,
            Self::Line => Icon::Line,
            Self::Rectangle => Icon::Rectangle,
            Self::FilledRectangle => Icon::FilledRectangle,
            Self::Fill => Icon::Fill,
            Self::Pick => Icon::Pick,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pencil => "Pencil",
            Self::Line => "Line",
            Self::Rectangle => "Rectangle",
            Self::FilledRectangle => "Filled rectangle",
            Self::Fill => "Fill",
            Self::Pick => "Pick",
        }
    }

    /// What it does, and its key.
    pub fn what(self) -> &'static str {
        match self {
            Self::Pencil => {
                "Pencil (P): paints the cells under the pointer. Right click or Alt picks a value."
            }
            Self::Line => {
                "Line (L): paints a straight line; Shift makes it level, upright or diagonal."
            }
            Self::Rectangle => "Rectangle (R): paints an outline; Shift makes it square.",
            Self::FilledRectangle => {
                "Filled rectangle (Shift+R): paints the whole rectangle; Shift makes it square."
            }
            Self::Fill => "Fill (F): paints all connected cells of the same value.",
            Self::Pick => "Pick (I): takes the value of a cell to paint with.",
        }
    }

    fn draws_shape(self) -> bool {
        matches!(self, Self::Line | Self::Rectangle | Self::FilledRectangle)
    }
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

/// How the grid is laid out.
#[derive(Debug, Clone, Copy)]
pub struct GridView {
    /// Room for the grid, points; a larger one is scrolled.
    pub room: Vec2,
    /// Whether the pattern is shown repeated on all sides, faded.
    pub repeats: bool,
}

/// State of an editor: tool, value to paint with, keyboard position, what is under way.
#[derive(Default)]
pub struct GridEditor {
    /// Current tool.
    pub tool: GridTool,
    /// Value that tools paint with.
    pub brush: u8,
    /// The cell that keys work on.
    cursor: Cell,
    /// The cell under the pointer.
    hovered: Option<Cell>,
    gesture: Gesture,
    /// Whether what is under way picks values with the secondary button.
    picks_by_secondary: bool,
    /// Side of a cell, points; `None` fits the grid into its room.
    zoom: Option<f32>,
    shown_side: f32,
    picture: Picture,
}

/// What is under way.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
enum Gesture {
    /// Nothing.
    #[default]
    None,
    /// The pencil is on the grid; `before` holds all values for taking the stroke back.
    Stroke { last: Cell, before: Vec<u8> },
    /// A shape is drawn out, by pointer or by keys.
    Shape { from: Cell, to: Cell, by_keys: bool },
    /// Values are picked for as long as the button is down.
    Picking,
    /// The button is down, but there is nothing more to do.
    Spent,
}

/// What a grid editor edits.
pub trait GridAccess {
    /// Columns and rows.
    fn size(&self) -> [usize; 2];
    /// All values, row by row from row 0, each row from column 0.
    fn values(&self) -> &[u8];
    /// Sets a cell inside the grid.
    fn set(&mut self, col: usize, row: usize, value: u8);
}

/// Smallest and largest side of a cell, points.
const SIDES: std::ops::RangeInclusive<f32> = 2.0..=48.0;
/// Largest side of a cell that is chosen to fill the room, points.
const LARGEST_FITTING: f32 = 26.0;
/// Most cells of the repeats around the grid.
const MARGIN: usize = 4;
/// What one step of the zoom multiplies the side by.
const ZOOM_STEP: f32 = 1.25;

impl GridEditor {
    /// A pencil that paints `brush`.
    pub fn new(brush: u8) -> Self {
        Self {
            brush,
            ..Self::default()
        }
    }

    /// Makes cells larger (or smaller, for negative steps).
    pub fn zoom_by(&mut self, steps: f32) {
        let side = self.shown_side * ZOOM_STEP.powf(steps);
        self.zoom = Some(side.clamp(*SIDES.start(), *SIDES.end()));
    }

    /// Shows the whole grid.
    pub fn zoom_to_fit(&mut self) {
        self.zoom = None;
    }

    /// Where the pointer is, or else the cursor.
    pub fn place(&self) -> Cell {
        self.hovered.unwrap_or(self.cursor)
    }

    /// Columns and rows of the shape being drawn out.
    pub fn shape_size(&self) -> Option<[i32; 2]> {
        match self.gesture {
            Gesture::Shape { from, to, .. } => {
                Some([0, 1].map(|axis| (to[axis] - from[axis]).abs() + 1))
            }
            _ => None,
        }
    }

    /// The cells of the shape being drawn out.
    fn shape_cells(&self, from: Cell, to: Cell) -> Vec<Cell> {
        match self.tool {
            GridTool::Line => shapes::line(from, to).collect(),
            GridTool::Rectangle => shapes::rectangle(from, to).collect(),
            _ => shapes::filled_rectangle(from, to).collect(),
        }
    }

    /// The end of a shape, with Shift held down or not.
    fn shape_end(&self, from: Cell, to: Cell, constrained: bool) -> Cell {
        match (constrained, self.tool) {
            (false, _) => to,
            (true, GridTool::Line) => shapes::straightened(from, to),
            (true, _) => shapes::squared(from, to),
        }
    }

    /// Paints the shape that was drawn out. Whether anything changed.
    fn finish_shape(&mut self, grid: &mut impl GridAccess) -> bool {
        let Gesture::Shape { from, to, .. } = std::mem::take(&mut self.gesture) else {
            return false;
        };
        put_all(grid, self.shape_cells(from, to), self.brush)
    }
}

/// Shows a grid of values and works on it with the editor's tool.
pub fn grid_editor(
    ui: &mut Ui,
    name: &str,
    editor: &mut GridEditor,
    cells: &[GridCell],
    grid: &mut impl GridAccess,
    view: GridView,
) -> Response {
    let size = grid.size();
    editor.cursor = [0, 1].map(|axis| editor.cursor[axis].min(size[axis] as i32 - 1));
    let margin = if view.repeats {
        // Small patterns are shown nine times, of large ones enough to see how they meet.
        size.map(|side| side.min(MARGIN))
    } else {
        [0, 0]
    };
    let fitting = [0, 1].map(|axis| view.room[axis] / (size[axis] + 2 * margin[axis]) as f32);
    let fitting = fitting[0].min(fitting[1]).floor();
    let fitting = fitting.clamp(*SIDES.start(), LARGEST_FITTING);
    let pixel = ui.pixels_per_point();
    // Whole pixels, so that all cells are equally large.
    let side = (editor.zoom.unwrap_or(fitting) * pixel).round().max(1.0) / pixel;
    editor.shown_side = side;
    let shown = vec2(
        (size[0] + 2 * margin[0]) as f32,
        (size[1] + 2 * margin[1]) as f32,
    ) * side;
    ScrollArea::both()
        .id_salt(name)
        .max_width(view.room.x + 1.0)
        .max_height(view.room.y + 1.0)
        .auto_shrink(true)
        .show(ui, |ui| {
            let (rect, mut response) =
                ui.allocate_exact_size(shown + Vec2::splat(1.0), Sense::click_and_drag());
            let canvas = Canvas::new(rect.min, side, size, margin, pixel);
            let changed = pointer::work(ui, editor, &canvas, &response, grid)
                | keyboard::work(ui, editor, &canvas, &response, cells, grid);
            if changed {
                response.mark_changed();
            }
            editor.hovered = response
                .hover_pos()
                .map(|at| canvas.cell(at))
                .filter(|cell| canvas.has(*cell));
            paint::show(ui, editor, &canvas, &response, cells, grid);
            describe(ui, &response, name, editor, cells, grid);
            response.on_hover_cursor(CursorIcon::Crosshair)
        })
        .inner
}

/// Gives a screen reader the cell that keys work on.
fn describe(
    ui: &Ui,
    response: &Response,
    name: &str,
    editor: &GridEditor,
    cells: &[GridCell],
    grid: &impl GridAccess,
) {
    let [col, row] = editor.cursor;
    let [cols, rows] = grid.size();
    let value = get(grid, editor.cursor);
    let meaning = cells.iter().find(|c| Some(c.value) == value);
    let meaning = meaning.map_or("", |cell| cell.name);
    let value = value.unwrap_or_default();
    let shape = match editor.shape_size() {
        Some([cols, rows]) => format!("; drawing {cols} by {rows}"),
        None => String::new(),
    };
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(format!(
            "column {} of {cols}, row {} of {rows}: {value}, {meaning}{shape}",
            col + 1,
            row + 1
        )),
        ..WidgetInfo::labeled(Role::Grid, ui.is_enabled(), name)
    });
}

/// The value of a cell; `None` outside.
fn get(grid: &impl GridAccess, [col, row]: Cell) -> Option<u8> {
    let [cols, rows] = grid.size();
    let (col, row) = (usize::try_from(col).ok()?, usize::try_from(row).ok()?);
    (col < cols && row < rows).then(|| grid.values()[row * cols + col])
}

/// Sets a cell, if it is inside. Whether anything changed.
fn put(grid: &mut impl GridAccess, cell: Cell, value: u8) -> bool {
    let differs = get(grid, cell).is_some_and(|old| old != value);
    if differs {
        grid.set(cell[0] as usize, cell[1] as usize, value);
    }
    differs
}

fn put_all(grid: &mut impl GridAccess, cells: impl IntoIterator<Item = Cell>, value: u8) -> bool {
    let mut changed = false;
    for cell in cells {
        changed |= put(grid, cell, value);
    }
    changed
}

/// Sets all connected cells. Whether anything changed.
fn fill(grid: &mut impl GridAccess, start: Cell, value: u8) -> bool {
    let size = grid.size();
    let values = grid.values();
    let at = |[col, row]: Cell| values[row as usize * size[0] + col as usize];
    let runs = shapes::connected(size.map(|side| side as i32), start, at);
    put_all(grid, runs.iter().flat_map(Run::cells), value)
}
