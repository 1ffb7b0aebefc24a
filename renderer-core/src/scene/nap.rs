//! Which way a nap map lays each loop (MODEL.md §13), radians along the weft and the warp.

use super::SheetGeometry;
use super::chart::ChartOnSheet;
use crate::design::{Chart, Colour, Fit, Nap, nap_edit};

/// The nap map of a design on its sheet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NapOnSheet {
    /// The map as a chart, which knows how images are laid over cells.
    map: Chart,
    /// Warps and wefts of the cloth it lies on.
    cells: [u32; 2],
    /// Lean where the map says all the way, radians.
    strength: f64,
}

impl NapOnSheet {
    /// `None` where there is no map or it does nothing.
    pub(super) fn new(nap: &Nap, sheet: &SheetGeometry) -> Option<Self> {
        let pixels = nap.pixels.clone().filter(|_| nap.strength > 0.0)?;
        let [r, g, b, _] = nap_edit::UPRIGHT;
        Some(Self {
            map: Chart {
                pixels: Some(pixels),
                fit: nap.fit,
                colour: Colour([r, g, b]),
                ..Chart::default()
            },
            cells: sheet.whole_cells(),
            strength: nap.strength.to_radians(),
        })
    }

    /// The farthest that it leans a loop along the weft or the warp, radians.
    pub(super) fn strength(&self) -> f64 {
        self.strength
    }

    /// How it leans the loops of cell (i, j) of that cloth. A map that covers the cloth is smooth between the middles
    /// of its pixels; in others one pixel is one crossing.
    pub(super) fn lean(&self, i: usize, j: usize) -> [f64; 2] {
        let Some(image) = &self.map.pixels else {
            return [0.0; 2];
        };
        let [warps, wefts] = self.cells;
        let direction = if self.map.fit == Fit::Stretch {
            let x = (i as f64 + 0.5) / f64::from(warps) * image.width() as f64 - 0.5;
            let y = (f64::from(wefts) - j as f64 - 0.5) / f64::from(wefts) * image.height() as f64
                - 0.5;
            let (x, y) = (x.max(0.0), y.max(0.0));
            let (left, top) = (x as usize, y as usize);
            let row = |y: usize| {
                let [a, b] = [left, left + 1].map(|x| nap_edit::direction(image.pixel(x, y)));
                nap_edit::mixed(a, b, x - left as f64)
            };
            nap_edit::mixed(row(top), row(top + 1), y - top as f64)
        } else {
            let there = ChartOnSheet::pixel_by_pixel(&self.map, [warps, wefts]).colour(i, j);
            there.map_or([0.0; 2], |[r, g, b]| nap_edit::direction([r, g, b, 255]))
        };
        direction.map(|part| part * self.strength)
    }
}
