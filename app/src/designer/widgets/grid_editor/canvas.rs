//! Where cells are on the screen.

use egui::{Pos2, Rect, Vec2, pos2, vec2};

use crate::designer::widgets::shapes::Cell;

/// A grid on the screen: the cells themselves, and the room for repeats around them.
pub(super) struct Canvas {
    /// The cells.
    pub rect: Rect,
    /// The cells and the repeats around them.
    pub outer: Rect,
    /// Side of a cell, points.
    pub side: f32,
    /// Columns and rows.
    pub size: [i32; 2],
}

impl Canvas {
    /// A grid with `margin` cells around it, from `corner` at its upper left.
    pub fn new(
        corner: Pos2,
        side: f32,
        size: [usize; 2],
        margin: [usize; 2],
        pixels_per_point: f32,
    ) -> Self {
        let corner = (corner * pixels_per_point).round() / pixels_per_point;
        let margin = vec2(margin[0] as f32, margin[1] as f32) * side;
        let inner = vec2(size[0] as f32, size[1] as f32) * side;
        Self {
            rect: Rect::from_min_size(corner + margin, inner),
            outer: Rect::from_min_size(corner, inner + 2.0 * margin),
            side,
            size: size.map(|side| side as i32),
        }
    }

    /// The cell at a place, which may be outside the grid.
    pub fn cell(&self, at: Pos2) -> Cell {
        let from_corner = at - self.rect.left_bottom();
        [
            (from_corner.x / self.side).floor() as i32,
            (-from_corner.y / self.side).floor() as i32,
        ]
    }

    /// Whether a cell is one of the grid.
    pub fn has(&self, cell: Cell) -> bool {
        (0..2).all(|axis| (0..self.size[axis]).contains(&cell[axis]))
    }

    /// The nearest cell of the grid.
    pub fn nearest(&self, cell: Cell) -> Cell {
        [0, 1].map(|axis| cell[axis].clamp(0, self.size[axis] - 1))
    }

    /// Place of a cell.
    pub fn rect_of(&self, [col, row]: Cell) -> Rect {
        let corner = pos2(
            self.rect.left() + col as f32 * self.side,
            self.rect.bottom() - (row + 1) as f32 * self.side,
        );
        Rect::from_min_size(corner, Vec2::splat(self.side))
    }

    /// Place of all cells between two.
    pub fn rect_between(&self, a: Cell, b: Cell) -> Rect {
        self.rect_of(a).union(self.rect_of(b))
    }

    /// The cells that `clip` shows: first and last column, first and last row.
    pub fn shown(&self, clip: Rect) -> Option<[Cell; 2]> {
        let shown = self.rect.intersect(clip);
        shown.is_positive().then(|| {
            [
                self.nearest(self.cell(shown.left_bottom())),
                self.nearest(self.cell(shown.right_top())),
            ]
        })
    }
}
