//! On which faces of which crossings the pattern plants loops, and how far apart they stand (MODEL.md §2).

use crate::design::{Back, Weave};

/// Whether a loop stands on the front and on the back of each cell of the pattern's repeat.
pub(super) struct Faces {
    repeat: [usize; 2],
    faces: Vec<[bool; 2]>,
}

/// Cells from loop to loop along an axis, as `cells / loops`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LoopSpacing {
    /// Cells of the repeat.
    pub(super) cells: usize,
    /// Loops among them; at least 1.
    pub(super) loops: usize,
}

impl Faces {
    pub(super) fn new(weave: &Weave) -> Self {
        let repeat = [weave.pattern.cols(), weave.pattern.rows()];
        let faces = |cell: usize| {
            let (i, j) = (cell % repeat[0], cell / repeat[0]);
            let stitch = weave.pattern.stitch(i as i64, j as i64);
            let back = match weave.back {
                Back::Mirror => stitch.front,
                Back::Pattern => stitch.back,
                Back::None => false,
            };
            [stitch.front, back]
        };
        Self {
            repeat,
            faces: (0..repeat[0] * repeat[1]).map(faces).collect(),
        }
    }

    /// Columns and rows of the repeat.
    pub(super) fn repeat(&self) -> [usize; 2] {
        self.repeat
    }

    /// Whether cell (i, j) has a loop on the front and on the back.
    pub(super) fn at(&self, i: usize, j: usize) -> [bool; 2] {
        self.faces[j % self.repeat[1] * self.repeat[0] + i % self.repeat[0]]
    }

    /// How many loops cell (i, j) has.
    pub(super) fn count_at(&self, i: usize, j: usize) -> u32 {
        let [front, back] = self.at(i, j);
        u32::from(front) + u32::from(back)
    }

    /// How far apart loops stand along x, in the wefts that have most, and along y, counted in wefts that have any.
    pub(super) fn spacing(&self) -> [LoopSpacing; 2] {
        let [cols, rows] = self.repeat;
        let in_weft = |j: usize| (0..cols).filter(|&i| self.at(i, j) != [false; 2]).count();
        let most = (0..rows).map(in_weft).max().unwrap_or(0);
        let wefts = (0..rows).filter(|&j| in_weft(j) > 0).count();
        let spacing = |cells, loops: usize| LoopSpacing {
            cells,
            loops: loops.max(1),
        };
        [spacing(cols, most), spacing(rows, wefts)]
    }
}
