//! What the panel Loop length draws: how often each brightness is in the chart, and how long the loops of the sheet
//! are. Both look at all of a large chart or sheet, so they are made on another thread.

use std::collections::HashMap;

use egui::{Color32, ColorImage};
use renderer_core::design::{Chart, ChartImage, Length, OPAQUE_FROM, Sheet, Weave};
use renderer_core::scene::{ChartOnSheet, LengthRule, luma};

/// Bars of the histogram.
pub const BARS: usize = 64;

/// How many pixels of the chart have a brightness in each bar, from black to white, as the loop length takes it;
/// transparent ones, which plant nothing, are left out.
pub fn histogram(chart: &ChartImage) -> [u64; BARS] {
    let mut counts = [0; BARS];
    for y in 0..chart.height() {
        for x in 0..chart.width() {
            let [r, g, b, alpha] = chart.pixel(x, y);
            if alpha >= OPAQUE_FROM {
                let bar = (luma([r, g, b]) * BARS as f64) as usize;
                counts[bar.min(BARS - 1)] += 1;
            }
        }
    }
    counts
}

/// Everything that the lengths of a sheet's loops follow from, before turbulence.
#[derive(Debug, Clone, PartialEq)]
pub struct Lengths {
    /// The chart.
    pub chart: Chart,
    /// How its colours become lengths.
    pub length: Length,
    /// The sheet it lies on.
    pub sheet: Sheet,
    /// How that is woven.
    pub weave: Weave,
    /// No loop is longer, mm.
    pub max_length_mm: f64,
}

/// Most cells along a side of a height map that are drawn as a pixel each; of larger sheets a pixel is several cells.
const MOST_PIXELS: u32 = 192;
/// Most cells along x and along y that are looked at for a pixel.
const MOST_LOOKS: u32 = 4;

/// Lengths of loops as a gray picture.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    /// The picture, the sheet's far edge at the top.
    pub image: ColorImage,
    /// What black and white are, mm.
    pub scale_mm: [f64; 2],
}

impl Lengths {
    /// Length of the loop of a cell, mm; `None` where the chart leaves none.
    pub fn at(&self, warp: u32, weft: u32) -> Option<f64> {
        let colour = self.colour(warp, weft)?;
        let length = LengthRule::new(&self.length).length_mm(colour);
        Some(length.min(self.max_length_mm))
    }

    fn colour(&self, warp: u32, weft: u32) -> Option<[u8; 3]> {
        let chart = ChartOnSheet::new(
            &self.chart,
            &self.weave,
            [self.sheet.warps, self.sheet.wefts],
        );
        chart.colour(warp as usize, weft as usize)
    }

    /// The lengths of all cells as a picture. Cells without loop count as 0.
    pub fn height_map(&self) -> HeightMap {
        let rule = LengthRule::new(&self.length);
        // Charts have few colours, and the nearest row of a table takes a while to find.
        let mut known = HashMap::new();
        let mut length = |colour: [u8; 3]| {
            let mm = known.entry(colour);
            *mm.or_insert_with(|| rule.length_mm(colour).min(self.max_length_mm))
        };
        let cells = [self.sheet.warps, self.sheet.wefts];
        let [cols, rows] = cells.map(|side| side.clamp(1, MOST_PIXELS));
        let blocks = [blocks(cells[0], cols), blocks(cells[1], rows)];
        let mut values = Vec::with_capacity((cols * rows) as usize);
        // From the far edge to the near one.
        for looked_at in blocks[1].iter().rev() {
            for across in &blocks[0] {
                let places = looked_at
                    .iter()
                    .flat_map(|j| across.iter().map(move |i| (*i, *j)));
                let lengths = places.map(|(i, j)| self.colour(i, j).map_or(0.0, &mut length));
                let count = (looked_at.len() * across.len()) as f64;
                values.push(lengths.sum::<f64>() / count);
            }
        }
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        // All alike are shown white, over a scale from nothing.
        let low = if high - low < 1e-6 { 0.0 } else { low };
        let gray = |value: &f64| {
            let share = (value - low) / (high - low).max(1e-6);
            Color32::from_gray((255.0 * share).round() as u8)
        };
        let pixels = values.iter().map(gray).collect();
        HeightMap {
            image: ColorImage::new([cols as usize, rows as usize], pixels),
            scale_mm: [low, high],
        }
    }
}

/// For each pixel along a side of `pixels` the cells that it looks at, evenly spread over those it stands for.
fn blocks(cells: u32, pixels: u32) -> Vec<Vec<u32>> {
    let start = |pixel: u32| (u64::from(pixel) * u64::from(cells) / u64::from(pixels)) as u32;
    (0..pixels)
        .map(|pixel| {
            let (from, to) = (start(pixel), start(pixel + 1));
            let looks = (to - from).clamp(1, MOST_LOOKS);
            let look = |k| from + (2 * k + 1) * (to - from) / (2 * looks);
            (0..looks).map(look).collect()
        })
        .collect()
}
