//! The stitch pattern: which yarn is over at each crossing, and where loops stand (MODEL.md §2, the paper's §4.1).

use serde::{Deserialize, Serialize};

use super::Fault;

/// Values a pattern cell may have.
pub const STITCHES: [u8; 5] = [0, 1, 7, 8, 9];

/// [`STITCHES`] in words.
pub(super) const ALLOWED_STITCHES: &str = "0 (weft over), 1 (warp over), 7 (loop on the front), 8 (loop on the back) \
     or 9 (loops on both)";

/// What one value of the pattern means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stitch {
    /// The warp lies over the weft.
    pub warp_over: bool,
    /// A loop stands on the front.
    pub front: bool,
    /// A loop stands on the back (where the back follows the pattern).
    pub back: bool,
}

impl Stitch {
    /// Reads a pattern value; `None` for one that has no meaning.
    pub fn from_value(value: u8) -> Option<Self> {
        let (warp_over, front, back) = match value {
            0 => (false, false, false),
            1 => (true, false, false),
            7 => (true, true, false),
            8 => (false, false, true),
            9 => (true, true, true),
            _ => return None,
        };
        Some(Self {
            warp_over,
            front,
            back,
        })
    }
}

/// A 2D array of stitches, repeated over the sheet. Row 0 is the near edge (−y), column 0 the left one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Vec<u8>>", into = "Vec<Vec<u8>>")]
pub struct Pattern {
    cols: usize,
    values: Vec<u8>,
}

impl Pattern {
    /// Largest number of rows and of columns.
    pub const MAX_SIDE: usize = 512;

    /// A pattern of `cols` × `rows` cells that all have the value `value`.
    pub fn filled(cols: usize, rows: usize, value: u8) -> Self {
        let (cols, rows) = (cols.clamp(1, Self::MAX_SIDE), rows.clamp(1, Self::MAX_SIDE));
        Self {
            cols,
            values: vec![value; cols * rows],
        }
    }

    /// Number of columns: the repeat along the weft.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Number of rows: the repeat along the warp.
    pub fn rows(&self) -> usize {
        self.values.len() / self.cols
    }

    /// Value at a column and row, repeated to all sides.
    pub fn at(&self, col: i64, row: i64) -> u8 {
        let col = col.rem_euclid(self.cols as i64) as usize;
        let row = row.rem_euclid(self.rows() as i64) as usize;
        self.values[row * self.cols + col]
    }

    /// The stitch at a column and row, repeated to all sides. Values that validation rejects read as plain weft.
    pub fn stitch(&self, col: i64, row: i64) -> Stitch {
        Stitch::from_value(self.at(col, row)).unwrap_or(Stitch {
            warp_over: false,
            front: false,
            back: false,
        })
    }

    /// Sets the value at a column and row inside the pattern; positions outside are ignored.
    pub fn set(&mut self, col: usize, row: usize, value: u8) {
        if col < self.cols && row < self.rows() {
            self.values[row * self.cols + col] = value;
        }
    }

    /// All values, row by row from row 0.
    pub fn values(&self) -> &[u8] {
        &self.values
    }

    /// A pattern of `cols` × `rows` cells, each with the value that `value(column, row)` gives.
    pub fn from_fn(cols: usize, rows: usize, value: impl Fn(usize, usize) -> u8) -> Self {
        let mut new = Self::filled(cols, rows, 0);
        for (index, cell) in new.values.iter_mut().enumerate() {
            *cell = value(index % new.cols, index / new.cols);
        }
        new
    }

    /// The pattern with another size. Its content is kept at the side or corner that `anchor` names and is cut off at
    /// the others; new cells are what `new_cells` says.
    pub fn resized(&self, cols: usize, rows: usize, anchor: Anchor, new_cells: NewCells) -> Self {
        let shift = [
            anchor.x.offset(self.cols, cols),
            anchor.y.offset(self.rows(), rows),
        ];
        Self::from_fn(cols, rows, |col, row| {
            let [col, row] = [col as i64 - shift[0], row as i64 - shift[1]];
            let inside =
                (0..self.cols as i64).contains(&col) && (0..self.rows() as i64).contains(&row);
            match new_cells {
                NewCells::Weft if !inside => 0,
                NewCells::Weft | NewCells::Repeat => self.at(col, row),
            }
        })
    }

    /// The pattern with left and right exchanged.
    pub fn mirrored_left_right(&self) -> Self {
        let (cols, rows) = (self.cols, self.rows());
        Self::from_fn(cols, rows, |col, row| {
            self.values[row * cols + cols - 1 - col]
        })
    }

    /// The pattern with near and far exchanged.
    pub fn mirrored_near_far(&self) -> Self {
        let (cols, rows) = (self.cols, self.rows());
        Self::from_fn(cols, rows, |col, row| {
            self.values[(rows - 1 - row) * cols + col]
        })
    }

    /// The pattern turned by a quarter, clockwise seen from the front.
    ///
    /// Values stay what they are: this moves the figure of loops and floats, it does not exchange warp and weft.
    pub fn turned(&self) -> Self {
        let (cols, rows) = (self.cols, self.rows());
        Self::from_fn(rows, cols, |col, row| {
            self.values[col * cols + cols - 1 - row]
        })
    }

    /// The pattern moved by whole cells; what leaves at one side comes in at the other.
    pub fn shifted(&self, cols: i64, rows: i64) -> Self {
        Self::from_fn(self.cols, self.rows(), |col, row| {
            self.at(col as i64 - cols, row as i64 - rows)
        })
    }

    pub(super) fn push_faults(&self, path: &str, faults: &mut Vec<Fault>) {
        for (index, &value) in self.values.iter().enumerate() {
            if Stitch::from_value(value).is_none() {
                faults.push(Fault {
                    path: format!("{path}[{}][{}]", index / self.cols, index % self.cols),
                    value: value.to_string(),
                    allowed: ALLOWED_STITCHES.into(),
                });
            }
        }
    }
}

/// Where along one axis content is kept when a pattern gets another size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Keep {
    /// At column or row 0: left, near.
    #[default]
    First,
    /// In the middle.
    Middle,
    /// At the last column or row: right, far.
    Last,
}

impl Keep {
    /// By how many cells old content moves.
    fn offset(self, old: usize, new: usize) -> i64 {
        let room = new as i64 - old as i64;
        match self {
            Self::First => 0,
            Self::Middle => room.div_euclid(2),
            Self::Last => room,
        }
    }
}

/// Where content is kept when a pattern gets another size; the near left corner unless given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Anchor {
    /// Along the weft.
    pub x: Keep,
    /// Along the warp.
    pub y: Keep,
}

/// What cells are that a larger pattern gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NewCells {
    /// Weft over warp.
    #[default]
    Weft,
    /// What the old pattern repeats there.
    Repeat,
}

impl TryFrom<Vec<Vec<u8>>> for Pattern {
    type Error = String;

    fn try_from(rows: Vec<Vec<u8>>) -> Result<Self, String> {
        let cols = rows.first().map_or(0, Vec::len);
        if cols == 0 || cols > Self::MAX_SIDE || rows.len() > Self::MAX_SIDE {
            return Err(format!(
                "the pattern has {} rows of {cols} cells, allowed are 1 to {} of each",
                rows.len(),
                Self::MAX_SIDE
            ));
        }
        if let Some((index, row)) = rows.iter().enumerate().find(|(_, row)| row.len() != cols) {
            return Err(format!(
                "row {index} of the pattern has {} cells, but row 0 has {cols}",
                row.len()
            ));
        }
        Ok(Self {
            cols,
            values: rows.concat(),
        })
    }
}

impl From<Pattern> for Vec<Vec<u8>> {
    fn from(pattern: Pattern) -> Self {
        pattern
            .values
            .chunks(pattern.cols)
            .map(<[u8]>::to_vec)
            .collect()
    }
}
