//! Drawing a grid. Cells are the pixels of one small texture and glyphs share one layout a value, so that a large grid
//! costs no more than a few shapes and what its glyphs need.

use std::sync::Arc;

use egui::{
    Color32, ColorImage, FontId, Galley, Mesh, Painter, Rect, Response, Shape, Stroke, StrokeKind,
    TextureHandle, TextureOptions, Ui, pos2,
};

use super::canvas::Canvas;
use super::{Gesture, GridAccess, GridCell, GridEditor, GridTool};
use crate::designer::widgets::shapes::Cell;
use crate::designer::widgets::style;

/// The grid's colours as a texture, a pixel a cell, and what it was made from.
#[derive(Default)]
pub(super) struct Picture {
    made_of: Option<(Vec<u8>, usize, bool)>,
    texture: Option<TextureHandle>,
}

/// Below this side of a cell a glyph would not be legible, points.
const GLYPH_CELL: f32 = 13.0;
/// Below this side lines between cells would hide them, points.
const LINE_CELL: f32 = 5.0;
/// How much of the repeats around the grid is seen.
const FADED: u8 = 90;

/// Draws the grid and what is under way.
pub(super) fn show(
    ui: &Ui,
    editor: &mut GridEditor,
    canvas: &Canvas,
    response: &Response,
    cells: &[GridCell],
    grid: &impl GridAccess,
) {
    let painter = ui.painter_at(canvas.outer.expand(1.0).intersect(ui.clip_rect()));
    let texture = editor.picture.texture(ui, cells, grid);
    repeats(&painter, canvas, &texture);
    painter.image(texture.id(), canvas.rect, WHOLE, Color32::WHITE);
    if let Some(shown) = canvas.shown(ui.clip_rect()) {
        lines(ui, &painter, canvas, shown);
        if canvas.side >= GLYPH_CELL {
            glyphs(&painter, canvas, shown, cells, grid);
        }
    }
    if let Gesture::Shape { from, to, .. } = editor.gesture {
        preview(ui, &painter, editor, canvas, cells, [from, to]);
    }
    if response.has_focus() {
        let rect = canvas.rect_of(editor.cursor);
        let stroke = Stroke::new(2.0, style::accent(ui.visuals()));
        painter.rect_stroke(rect, 1.0, stroke, StrokeKind::Outside);
    }
    if let Some(cell) = editor.hovered {
        let stroke = Stroke::new(1.0, ui.visuals().strong_text_color());
        painter.rect_stroke(canvas.rect_of(cell), 0.0, stroke, StrokeKind::Inside);
    }
}

const WHOLE: Rect = Rect {
    min: pos2(0.0, 0.0),
    max: pos2(1.0, 1.0),
};

impl Picture {
    fn texture(&mut self, ui: &Ui, cells: &[GridCell], grid: &impl GridAccess) -> TextureHandle {
        let [cols, rows] = grid.size();
        let (values, dark) = (grid.values(), ui.visuals().dark_mode);
        let is_same = self
            .made_of
            .as_ref()
            .is_some_and(|made| (made.0.as_slice(), made.1, made.2) == (values, cols, dark));
        if let (true, Some(texture)) = (is_same, &self.texture) {
            return texture.clone();
        }
        let mut colours = [ui.visuals().error_fg_color; 256];
        for cell in cells {
            colours[usize::from(cell.value)] = cell.ground;
        }
        // Pictures have row 0 at the top.
        let from_the_top = values.chunks(cols).rev().flatten();
        let pixels = from_the_top.map(|value| colours[usize::from(*value)]);
        let image = ColorImage::new([cols, rows], pixels.collect());
        let options = TextureOptions::NEAREST_REPEAT;
        self.made_of = Some((values.to_vec(), cols, dark));
        match &mut self.texture {
            Some(texture) => {
                texture.set(image, options);
                texture.clone()
            }
            None => {
                let texture = ui.ctx().load_texture("grid", image, options);
                self.texture.insert(texture).clone()
            }
        }
    }
}

/// The grid again on all sides, faded.
fn repeats(painter: &Painter, canvas: &Canvas, texture: &TextureHandle) {
    if canvas.outer == canvas.rect {
        return;
    }
    let of_grid = |at: egui::Pos2| {
        let from_corner = (at - canvas.rect.min) / canvas.rect.size();
        pos2(from_corner.x, from_corner.y)
    };
    let uv = Rect::from_min_max(of_grid(canvas.outer.min), of_grid(canvas.outer.max));
    painter.image(
        texture.id(),
        canvas.outer,
        uv,
        Color32::from_white_alpha(FADED),
    );
}

/// Lines between cells, all in one mesh.
fn lines(ui: &Ui, painter: &Painter, canvas: &Canvas, [first, last]: [Cell; 2]) {
    let visuals = ui.visuals();
    let colour = if visuals.dark_mode {
        visuals.extreme_bg_color
    } else {
        visuals.widgets.noninteractive.bg_stroke.color
    };
    let pixel = 1.0 / ui.pixels_per_point();
    let thickness = (1.0 / pixel).round() * pixel;
    let rect = canvas.rect;
    let mut mesh = Mesh::default();
    let every = |axis: usize| {
        let side = canvas.size[axis];
        let all = canvas.side >= LINE_CELL;
        (first[axis]..=last[axis] + 1).filter(move |at| all || *at == 0 || *at == side)
    };
    for col in every(0) {
        let x = rect.left() + col as f32 * canvas.side;
        let line = Rect::from_min_max(pos2(x, rect.top()), pos2(x + thickness, rect.bottom()));
        mesh.add_colored_rect(line, colour);
    }
    for row in every(1) {
        let y = rect.bottom() - row as f32 * canvas.side;
        let line = Rect::from_min_max(pos2(rect.left(), y), pos2(rect.right(), y + thickness));
        mesh.add_colored_rect(line, colour);
    }
    painter.add(Shape::mesh(mesh));
}

fn glyphs(
    painter: &Painter,
    canvas: &Canvas,
    [first, last]: [Cell; 2],
    cells: &[GridCell],
    grid: &impl GridAccess,
) {
    let font = FontId::proportional((canvas.side * 0.62).min(14.0));
    let laid_out: Vec<(u8, Color32, Arc<Galley>)> = cells
        .iter()
        .map(|cell| {
            let text = cell.value.to_string();
            let galley = painter.layout_no_wrap(text, font.clone(), cell.ink);
            (cell.value, cell.ink, galley)
        })
        .collect();
    let cols = grid.size()[0];
    let mut shapes = Vec::new();
    for row in first[1]..=last[1] {
        for col in first[0]..=last[0] {
            let value = grid.values()[row as usize * cols + col as usize];
            if let Some((_, ink, galley)) = laid_out.iter().find(|(v, ..)| *v == value) {
                let corner = canvas.rect_of([col, row]).center() - galley.size() / 2.0;
                shapes.push(Shape::galley(corner, Arc::clone(galley), *ink));
            }
        }
    }
    painter.extend(shapes);
}

/// What the shape that is drawn out would paint.
fn preview(
    ui: &Ui,
    painter: &Painter,
    editor: &GridEditor,
    canvas: &Canvas,
    cells: &[GridCell],
    [from, to]: [Cell; 2],
) {
    let look = cells.iter().find(|cell| cell.value == editor.brush);
    let ground = look.map_or(ui.visuals().error_fg_color, |look| look.ground);
    let painter = painter.with_clip_rect(painter.clip_rect().intersect(canvas.rect));
    let mut mesh = Mesh::default();
    if editor.tool == GridTool::FilledRectangle {
        mesh.add_colored_rect(canvas.rect_between(from, to), ground);
    } else {
        for cell in editor.shape_cells(from, to) {
            if canvas.has(cell) {
                mesh.add_colored_rect(canvas.rect_of(cell).shrink(0.5), ground);
            }
        }
    }
    painter.add(Shape::mesh(mesh));
    let stroke = Stroke::new(1.5, style::accent(ui.visuals()));
    if editor.tool == GridTool::Line {
        let ends = [canvas.rect_of(from).center(), canvas.rect_of(to).center()];
        painter.line_segment(ends, stroke);
    } else {
        let rect = canvas.rect_between(from, to);
        painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Inside);
    }
}
