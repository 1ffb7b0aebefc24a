//! The cells of lines, rectangles and connected areas on a grid, for painting on patterns and on pictures.
//!
//! Cells are `[column, row]`. Shapes may reach outside the grid, as a drag does that leaves it; who paints leaves out
//! what is outside.

use std::ops::Range;

/// A cell of a grid: column and row.
pub type Cell = [i32; 2];

/// The cells on the way from one to another, both included, without gaps; a cell a step along the longer side.
pub fn line(from: Cell, to: Cell) -> impl Iterator<Item = Cell> {
    let delta = [0, 1].map(|axis| i64::from(to[axis]) - i64::from(from[axis]));
    let steps = delta[0].abs().max(delta[1].abs()).max(1);
    (0..=steps).map(move |step| {
        [0, 1].map(|axis| {
            let rounded = (2 * delta[axis] * step + steps).div_euclid(2 * steps);
            (i64::from(from[axis]) + rounded) as i32
        })
    })
}

/// The cells of a rectangle between two opposite corners, row by row.
pub fn filled_rectangle(from: Cell, to: Cell) -> impl Iterator<Item = Cell> {
    let [cols, rows] = sides(from, to);
    rows.flat_map(move |row| cols.clone().map(move |col| [col, row]))
}

/// The outermost cells of a rectangle between two opposite corners, each once.
pub fn rectangle(from: Cell, to: Cell) -> impl Iterator<Item = Cell> {
    let [cols, rows] = sides(from, to);
    let (first, last) = (rows.start, rows.end - 1);
    rows.flat_map(move |row| {
        let is_edge = row == first || row == last;
        let step = if is_edge { 1 } else { (cols.len() - 1).max(1) };
        cols.clone().step_by(step).map(move |col| [col, row])
    })
}

fn sides(from: Cell, to: Cell) -> [Range<i32>; 2] {
    [0, 1].map(|axis| from[axis].min(to[axis])..from[axis].max(to[axis]) + 1)
}

/// The end of a line from `from` near `to` that is level, upright or diagonal.
pub fn straightened(from: Cell, to: Cell) -> Cell {
    let [x, y] = [0, 1].map(|axis| to[axis] - from[axis]);
    let (flat, steep) = (2 * y.abs() < x.abs(), 2 * x.abs() < y.abs());
    match (flat, steep) {
        (true, _) => [to[0], from[1]],
        (_, true) => [from[0], to[1]],
        _ => squared(from, to),
    }
}

/// The corner opposite `from`, near `to`, of a square.
pub fn squared(from: Cell, to: Cell) -> Cell {
    let delta = [0, 1].map(|axis| to[axis] - from[axis]);
    let side = delta[0].abs().max(delta[1].abs());
    [0, 1].map(|axis| from[axis] + if delta[axis] < 0 { -side } else { side })
}

/// Neighbouring cells of one row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// The row.
    pub row: i32,
    /// Its columns.
    pub cols: Range<i32>,
}

impl Run {
    /// The cells.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let row = self.row;
        self.cols.clone().map(move |col| [col, row])
    }
}

/// All cells that are connected with `start` through cells of the same value, side to side, on a grid of `size` cells;
/// none if `start` is outside.
///
/// Runs of whole rows are found one after the other from a list of places to look at, with a bit a cell for what has
/// been found: every cell is looked at a few times at most, and 4096 × 4096 of them take 2 MB beside the runs.
pub fn connected<T: PartialEq>(size: Cell, start: Cell, value: impl Fn(Cell) -> T) -> Vec<Run> {
    let inside = |axis: usize| (0..size[axis]).contains(&start[axis]);
    if !(inside(0) && inside(1)) {
        return Vec::new();
    }
    let wanted = value(start);
    let mut found = Found::new(size);
    let mut runs = Vec::new();
    let mut open = vec![start];
    while let Some([col, row]) = open.pop() {
        let is_new = |found: &Found, col| !found.has([col, row]) && value([col, row]) == wanted;
        if !is_new(&found, col) {
            continue;
        }
        let (mut first, mut end) = (col, col + 1);
        while first > 0 && is_new(&found, first - 1) {
            first -= 1;
        }
        while end < size[0] && is_new(&found, end) {
            end += 1;
        }
        for col in first..end {
            found.add([col, row]);
        }
        for beside in [row - 1, row + 1] {
            if (0..size[1]).contains(&beside) {
                // One place to look at for each stretch of cells that are to be filled.
                let mut before = false;
                for col in first..end {
                    let here = !found.has([col, beside]) && value([col, beside]) == wanted;
                    if here && !before {
                        open.push([col, beside]);
                    }
                    before = here;
                }
            }
        }
        runs.push(Run {
            row,
            cols: first..end,
        });
    }
    runs
}

/// A bit for every cell of a grid.
struct Found {
    cols: usize,
    bits: Vec<u64>,
}

impl Found {
    fn new([cols, rows]: Cell) -> Self {
        let (cols, rows) = (cols as usize, rows as usize);
        Self {
            cols,
            bits: vec![0; (cols * rows).div_ceil(64)],
        }
    }

    fn place(&self, [col, row]: Cell) -> (usize, u64) {
        let index = row as usize * self.cols + col as usize;
        (index / 64, 1 << (index % 64))
    }

    fn has(&self, cell: Cell) -> bool {
        let (word, bit) = self.place(cell);
        self.bits[word] & bit != 0
    }

    fn add(&mut self, cell: Cell) {
        let (word, bit) = self.place(cell);
        self.bits[word] |= bit;
    }
}
