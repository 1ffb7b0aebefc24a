//! Which texel of the chart governs a cell (MODEL.md §6, "one texel governs one loop").
//!
//! Chart row 0 is the sheet's far edge (+y), while weft 0 is the near one.

use std::collections::BTreeMap;

use super::faces::{Faces, LoopSpacing};
use crate::design::chart_edit::{Covered, LoopsPerPixel, LoopsUnder, mean_colour};
use crate::design::{Chart, ChartImage, Fit, OPAQUE_FROM, Weave};

/// A chart laid over a sheet.
#[derive(Debug, Clone, Copy)]
pub struct ChartOnSheet<'a> {
    chart: &'a Chart,
    /// Warps and wefts of the cloth it lies on.
    cells: [usize; 2],
    /// Where a loop takes the mean of the pixels around it: how far apart loops stand along x and y.
    averaged: Option<[LoopSpacing; 2]>,
}

impl<'a> ChartOnSheet<'a> {
    /// Lays `chart` over a sheet of `warps` × `wefts` cells woven so.
    pub fn new(chart: &'a Chart, weave: &Weave, [warps, wefts]: [u32; 2]) -> Self {
        Self {
            averaged: Self::averaged_over(chart, weave),
            ..Self::pixel_by_pixel(chart, [warps, wefts])
        }
    }

    /// Lays `chart` over a sheet of `warps` × `wefts` cells of which each has one pixel.
    pub fn pixel_by_pixel(chart: &'a Chart, cells: [u32; 2]) -> Self {
        Self {
            chart,
            cells: cells.map(|count| count as usize),
            averaged: None,
        }
    }

    /// How far apart loops stand along x and y, where their colour is the mean over that.
    pub(super) fn averaged_over(chart: &Chart, weave: &Weave) -> Option<[LoopSpacing; 2]> {
        (chart.average && chart.fit == Fit::Stretch).then(|| Faces::new(weave).spacing())
    }

    /// sRGB colour of the loops of cell (i, j); `None` where the chart is transparent.
    pub fn colour(&self, i: usize, j: usize) -> Option<[u8; 3]> {
        let Some(image) = &self.chart.pixels else {
            return Some(self.chart.colour.0);
        };
        let around = || (self.chart.fit == Fit::Place).then_some(self.chart.colour.0);
        let pixel = match self.averaged {
            Some(spacing) => Some(self.mean_around(image, spacing, [i, j])),
            None => self.texel(image, i, j).map(|[x, y]| image.pixel(x, y)),
        };
        match pixel {
            Some([r, g, b, alpha]) if alpha >= OPAQUE_FROM => Some([r, g, b]),
            _ => around(),
        }
    }

    /// The mean light of the part of a stretched image that is nearer to the loop of cell (i, j) than to others: the
    /// rectangle around it as wide and as deep as loops stand apart.
    fn mean_around(
        &self,
        image: &ChartImage,
        spacing: [LoopSpacing; 2],
        [i, j]: [usize; 2],
    ) -> [u8; 4] {
        let from_far = self.cells[1] - 1 - j;
        let covered = |axis: usize, at: usize, side: usize| {
            let (
                cells,
                LoopSpacing {
                    cells: repeat,
                    loops,
                },
            ) = (self.cells[axis], spacing[axis]);
            // In 1/(2·cells·loops) of a pixel.
            let (middle, unit) = ((2 * at + 1) * loops, 2 * cells * loops);
            let (start, end) = (middle.saturating_sub(repeat), (middle + repeat).min(unit));
            Covered::between(start * side..end * side, unit)
        };
        let columns = covered(0, i, image.width());
        mean_colour(image, &columns, &covered(1, from_far, image.height()))
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
        let (x, is_dropped) = self.column(image, i)?;
        Some([x, self.row(image, j, is_dropped)?])
    }

    /// The column of texels of warp i, and whether repeats are dropped by half there.
    fn column(&self, image: &ChartImage, i: usize) -> Option<(usize, bool)> {
        let (warps, width) = (self.cells[0], image.width());
        match self.chart.fit {
            // The texel that holds (i+½)/warps, in whole numbers.
            Fit::Stretch => Some(((2 * i + 1) * width / (2 * warps), false)),
            Fit::Tile => {
                let (repeat, x) = (i / width, i % width);
                let is_dropped = self.chart.half_drop && repeat % 2 == 1;
                Some((mirrored(self.chart.mirror_x, repeat, x, width), is_dropped))
            }
            Fit::Place => {
                let [left, _] = placed_corner(self.chart, image, self.cells);
                let x = usize::try_from(i as i64 - left).ok()?;
                (x < width).then_some((x, false))
            }
        }
    }

    /// The row of texels (from the top) of weft j where repeats are dropped by half or not.
    fn row(&self, image: &ChartImage, j: usize, is_dropped: bool) -> Option<usize> {
        let (wefts, height) = (self.cells[1], image.height());
        match self.chart.fit {
            // The texel that holds 1 − (j+½)/wefts, in whole numbers.
            Fit::Stretch => Some((2 * (wefts - j) - 1) * height / (2 * wefts)),
            Fit::Tile => {
                let drop = if is_dropped { height / 2 } else { 0 };
                // Counted from the far edge; one more repeat of two keeps it positive when dropped.
                let row = (wefts - 1 - j) + 2 * height - drop;
                Some(mirrored(
                    self.chart.mirror_y,
                    row / height,
                    row % height,
                    height,
                ))
            }
            Fit::Place => {
                let [_, top] = placed_corner(self.chart, image, self.cells);
                let y = usize::try_from((wefts - 1 - j) as i64 - top).ok()?;
                (y < height).then_some(y)
            }
        }
    }

    /// How many loops of a cloth woven so lie on each pixel of an image that is laid like this chart's.
    pub fn loops_per_pixel(&self, weave: &Weave, image: &ChartImage) -> LoopsPerPixel {
        if self.averaged.is_some() {
            return LoopsPerPixel::Alike;
        }
        let part = |is_dropped| self.loops_under(&Faces::new(weave), image, is_dropped);
        let drops = self.chart.fit == Fit::Tile && self.chart.half_drop;
        let dropped: &[bool] = if drops { &[false, true] } else { &[false] };
        LoopsPerPixel::Counted(dropped.iter().map(|&is_dropped| part(is_dropped)).collect())
    }

    fn loops_under(&self, faces: &Faces, image: &ChartImage, is_dropped: bool) -> LoopsUnder {
        let ([warps, wefts], [_, repeat]) = (self.cells, faces.repeat());
        let mut columns = vec![vec![0; repeat]; image.width()];
        for i in 0..warps {
            if let Some((x, dropped)) = self.column(image, i)
                && dropped == is_dropped
            {
                for (row, loops) in columns[x].iter_mut().enumerate() {
                    *loops += faces.count_at(i, row);
                }
            }
        }
        let mut rows = vec![BTreeMap::new(); image.height()];
        for j in 0..wefts {
            if let Some(y) = self.row(image, j, is_dropped) {
                *rows[y].entry(j % repeat).or_insert(0) += 1;
            }
        }
        let rows = rows.into_iter().map(|row| row.into_iter().collect());
        LoopsUnder {
            columns,
            rows: rows.collect(),
        }
    }
}

/// Where a texel lies in a repeat if every second repeat is mirrored or not.
fn mirrored(every_second: bool, repeat: usize, at: usize, side: usize) -> usize {
    if every_second && repeat % 2 == 1 {
        side - 1 - at
    } else {
        at
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
