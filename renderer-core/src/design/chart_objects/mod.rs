//! Objects on a chart: stripes, shapes, letters and pictures, drawn into the chart's pixels.
//!
//! Objects are in mm of the cloth, x to the right and y away from the near edge, from the middle of the chart; pixels
//! are crossings of the cloth, or what a stretched image has. A pixel belongs to an object where its middle does.

mod fill;
mod glyph_path;
mod picture;
mod place;

use super::{Chart, ChartImage, ChartObject, Fit, ObjectKind, Sheet};

pub use glyph_path::{Bounds, GlyphPath};
pub use place::Placed;

/// What objects are drawn on: how many pixels it has and how large each is on the cloth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartCanvas {
    /// Columns and rows of pixels.
    pub size: [usize; 2],
    /// Width and height of a pixel, mm.
    pub pixel_mm: [f64; 2],
}

impl ChartCanvas {
    /// That of a chart as it is on a sheet: a pixel of one that is stretched is as large as that makes it, of others as
    /// large as a crossing. A chart without an image has a pixel for each crossing, as far as charts go.
    pub fn of(chart: &Chart, sheet: &Sheet) -> Self {
        match (&chart.pixels, chart.fit) {
            (None, _) => Self::of_sheet(sheet),
            (Some(image), Fit::Stretch) => Self::over(sheet, [image.width(), image.height()]),
            (Some(image), Fit::Tile | Fit::Place) => Self {
                size: [image.width(), image.height()],
                pixel_mm: [sheet.pitch_x(), sheet.pitch_y()],
            },
        }
    }

    /// A pixel for each crossing of a sheet, as far as charts go.
    pub fn of_sheet(sheet: &Sheet) -> Self {
        let side = |yarns: u32| (yarns as usize).min(ChartImage::MAX_SIDE);
        Self::over(sheet, [side(sheet.warps), side(sheet.wefts)])
    }

    fn over(sheet: &Sheet, size: [usize; 2]) -> Self {
        let sides = [
            f64::from(sheet.warps) * sheet.pitch_x(),
            f64::from(sheet.wefts) * sheet.pitch_y(),
        ];
        Self {
            size,
            pixel_mm: [0, 1].map(|k| sides[k] / size[k] as f64),
        }
    }

    /// Width and height, mm.
    pub fn size_mm(&self) -> [f64; 2] {
        [0, 1].map(|k| self.size[k] as f64 * self.pixel_mm[k])
    }

    /// Where a place on the cloth lies in pixels, from the upper left corner.
    pub fn pixel_at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            x / self.pixel_mm[0] + 0.5 * self.size[0] as f64,
            0.5 * self.size[1] as f64 - y / self.pixel_mm[1],
        ]
    }

    /// The place on the cloth, mm from the middle, of one in pixels from the upper left corner.
    pub fn place_of(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x - 0.5 * self.size[0] as f64) * self.pixel_mm[0],
            (0.5 * self.size[1] as f64 - y) * self.pixel_mm[1],
        ]
    }
}

/// Draws objects into an image that is such a canvas, the first lowest.
pub fn draw_objects(image: &mut ChartImage, objects: &[ChartObject], canvas: &ChartCanvas) {
    for object in objects.iter().take(ChartObject::MAX) {
        let outline = place::contours(object, canvas);
        for placed in Placed::all(object, canvas) {
            match (object.kind, &object.pixels) {
                (ObjectKind::Image, Some(pixels)) => {
                    picture::draw(image, object, pixels, &placed, canvas);
                }
                (ObjectKind::Image, None) => {}
                _ => fill::draw(image, object, &outline, &placed, canvas),
            }
        }
    }
}
