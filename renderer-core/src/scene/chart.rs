//! Which texel of the chart governs a cell (MODEL.md §6, "one texel governs one loop").
//!
//! Chart row 0 is the sheet's far edge (+y), while weft 0 is the near one.

use crate::design::{Chart, ChartImage, Fit, OPAQUE_FROM};

/// A chart laid over a sheet.
#[derive(Debug, Clone, Copy)]
pub struct ChartOnSheet<'a> {
    chart: &'a Chart,
    /// Warps and wefts of the cloth it lies on.
    cells: [usize; 2],
}

impl<'a> ChartOnSheet<'a> {
    /// Lays `chart` over a sheet of `warps` × `wefts` cells.
    pub fn new(chart: &'a Chart, warps: u32, wefts: u32) -> Self {
        Self {
            chart,
            cells: [warps as usize, wefts as usize],
        }
    }

    /// sRGB colour of the loops of cell (i, j); `None` where the chart is transparent.
    pub fn colour(&self, i: usize, j: usize) -> Option<[u8; 3]> {
        let Some(image) = &self.chart.pixels else {
            return Some(self.chart.colour.0);
        };
        let around = || (self.chart.fit == Fit::Place).then_some(self.chart.colour.0);
        let Some([x, y]) = self.texel(image, i, j) else {
            return around();
        };
        match image.pixel(x, y) {
            [r, g, b, alpha] if alpha >= OPAQUE_FROM => Some([r, g, b]),
            _ => around(),
        }
    }

    /// Whether all cells have the same colour, whatever the image.
    pub fn is_uniform(&self) -> bool {
        self.chart.pixels.is_none()
    }

    /// The cell under the middle of the texel at column `x`, row `y` of a chart that lies on the cloth once; `None`
    /// beside the cloth, and for charts that repeat.
    pub fn cell_under(&self, image: &ChartImage, [x, y]: [usize; 2]) -> Option<[usize; 2]> {
        let [warps, wefts] = self.cells;
        match self.chart.fit {
            Fit::Stretch => Some([
                (2 * x + 1) * warps / (2 * image.width()),
                wefts - 1 - (2 * y + 1) * wefts / (2 * image.height()),
            ]),
            Fit::Tile => None,
            Fit::Place => {
                let [left, top] = placed_corner(self.chart, image, self.cells);
                let i = usize::try_from(x as i64 + left).ok()?;
                let from_top = usize::try_from(y as i64 + top).ok()?;
                (i < warps && from_top < wefts).then(|| [i, wefts - 1 - from_top])
            }
        }
    }

    /// Column and row (from the top) of the texel of cell (i, j); `None` beside a chart that is placed.
    pub fn texel(&self, image: &ChartImage, i: usize, j: usize) -> Option<[usize; 2]> {
        let [warps, wefts] = self.cells;
        let (width, height) = (image.width(), image.height());
        match self.chart.fit {
            // The texel that holds ((i+½)/warps, 1 − (j+½)/wefts), in whole numbers.
            Fit::Stretch => Some([
                (2 * i + 1) * width / (2 * warps),
                (2 * (wefts - j) - 1) * height / (2 * wefts),
            ]),
            Fit::Tile => {
                let (column, x) = (i / width, i % width);
                let drop = if self.chart.half_drop && column % 2 == 1 {
                    height / 2
                } else {
                    0
                };
                // Counted from the far edge; one more repeat of two keeps it positive when dropped.
                let row = (wefts - 1 - j) + 2 * height - drop;
                let (repeat, y) = (row / height, row % height);
                let mirrored = |on: bool, repeat: usize, at: usize, size: usize| {
                    if on && repeat % 2 == 1 {
                        size - 1 - at
                    } else {
                        at
                    }
                };
                Some([
                    mirrored(self.chart.mirror_x, column, x, width),
                    mirrored(self.chart.mirror_y, repeat, y, height),
                ])
            }
            Fit::Place => {
                let [left, top] = placed_corner(self.chart, image, self.cells);
                let x = usize::try_from(i as i64 - left).ok()?;
                let y = usize::try_from((wefts - 1 - j) as i64 - top).ok()?;
                (x < width && y < height).then_some([x, y])
            }
        }
    }
}

/// Where the upper left texel of a chart that is placed lies: warps from the left, wefts from the far edge.
fn placed_corner(chart: &Chart, image: &ChartImage, cells: [usize; 2]) -> [i64; 2] {
    // Of sides that cannot be halved, the larger half lies left and near.
    let middle = |cells: usize, side: usize| (cells as i64 - side as i64).div_euclid(2);
    [
        middle(cells[0], image.width()) + i64::from(chart.offset_x),
        middle(cells[1], image.height()) - i64::from(chart.offset_y),
    ]
}
