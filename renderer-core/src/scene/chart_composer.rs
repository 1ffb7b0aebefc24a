//! Charts with what lies on them: objects are drawn once, and what follows sees pixels alone.

use std::borrow::Cow;

use super::chart::ChartOnSheet;
use super::faces::LoopSpacing;
use crate::design::chart_edit::BARE;
use crate::design::chart_objects::{ChartCanvas, draw_objects};
use crate::design::{Chart, ChartImage, Design, Fit};

/// Draws the objects of one chart after another, and keeps what it drew until chart or cloth are others.
#[derive(Debug, Default)]
pub struct ChartComposer {
    /// The last chart without its objects, as pixels that objects can be drawn on.
    base: Option<(Laid, ChartImage)>,
    /// The last chart, and as it is with its objects.
    last: Option<(Laid, Chart)>,
}

/// A chart and what it lies on.
#[derive(Debug, Clone, PartialEq)]
struct Laid {
    chart: Chart,
    cells: [u32; 2],
    pitch_mm: [f64; 2],
    averaged: Option<[LoopSpacing; 2]>,
}

impl Laid {
    fn new(chart: Chart, design: &Design) -> Self {
        let sheet = &design.sheet;
        Self {
            averaged: ChartOnSheet::averaged_over(&chart, &design.weave),
            chart,
            cells: [sheet.warps, sheet.wefts],
            pitch_mm: [sheet.pitch_x(), sheet.pitch_y()],
        }
    }
}

impl ChartComposer {
    /// The design with a chart that looks the same and has no objects.
    pub fn design<'d>(&mut self, design: &'d Design) -> Cow<'d, Design> {
        let chart = &design.chart;
        let is_plain =
            chart.guides_x.is_empty() && chart.guides_y.is_empty() && chart.yarn.is_empty();
        if chart.object.is_empty() && is_plain {
            return Cow::Borrowed(design);
        }
        let chart = self.chart(design);
        Cow::Owned(Design {
            chart,
            ..design.clone()
        })
    }

    /// A chart that looks as the design's with its objects, and has none.
    pub fn chart(&mut self, design: &Design) -> Chart {
        let bare = Chart {
            object: Vec::new(),
            yarn: Vec::new(),
            guides_x: Vec::new(),
            guides_y: Vec::new(),
            ..design.chart.clone()
        };
        if design.chart.object.is_empty() {
            return bare;
        }
        let laid = Laid::new(
            Chart {
                object: design.chart.object.clone(),
                ..bare.clone()
            },
            design,
        );
        if let Some((of, chart)) = &self.last
            && *of == laid
        {
            return chart.clone();
        }
        let Some(mut pixels) = self.base(bare.clone(), design) else {
            // A cloth without crossings, which is a fault of its own.
            return bare;
        };
        let canvas = canvas(&design.chart, design);
        draw_objects(&mut pixels, &design.chart.object, &canvas);
        if let Some((_, last)) = &self.last
            && let Some(last) = &last.pixels
        {
            pixels.share_with(last);
        }
        let chart = Chart {
            pixels: Some(pixels),
            image: None,
            // Without an image objects lie on the whole cloth.
            fit: match bare.pixels {
                None => Fit::Stretch,
                Some(_) => bare.fit,
            },
            // Of a stretched chart each pixel is a crossing by now, averaged where that was asked for.
            average: false,
            ..bare
        };
        self.last = Some((laid, chart.clone()));
        chart
    }

    /// The pixels below the objects.
    fn base(&mut self, chart: Chart, design: &Design) -> Option<ChartImage> {
        let laid = Laid::new(chart, design);
        if let Some((of, image)) = &self.base
            && *of == laid
        {
            return Some(image.clone());
        }
        let image = below(&laid, design)?;
        self.base = Some((laid, image.clone()));
        Some(image)
    }
}

/// What objects of a chart are drawn on: for a stretched one the crossings of the cloth.
fn canvas(chart: &Chart, design: &Design) -> ChartCanvas {
    match chart.fit {
        Fit::Stretch => ChartCanvas::of_sheet(&design.sheet),
        Fit::Tile | Fit::Place => ChartCanvas::of(chart, &design.sheet),
    }
}

fn below(laid: &Laid, design: &Design) -> Option<ChartImage> {
    let chart = &laid.chart;
    let [width, height] = canvas(chart, design).size;
    let [r, g, b] = chart.colour.0;
    match (&chart.pixels, chart.fit) {
        (None, _) => ChartImage::filled(width, height, [r, g, b, 255]),
        (Some(image), Fit::Tile | Fit::Place) => Some(image.clone()),
        (Some(image), Fit::Stretch) => {
            let is_crossings =
                laid.averaged.is_none() && (image.width(), image.height()) == (width, height);
            if is_crossings {
                Some(image.clone())
            } else {
                stretched(laid, design, [width, height])
            }
        }
    }
}

/// A stretched chart with a pixel for each crossing, or for the crossing in the middle of several of a cloth that is
/// larger than charts.
fn stretched(laid: &Laid, design: &Design, [width, height]: [usize; 2]) -> Option<ChartImage> {
    let on_sheet = ChartOnSheet::new(&laid.chart, &design.weave, laid.cells);
    let cells = laid.cells.map(|count| count as usize);
    ChartImage::from_fn(width, height, |x, y| {
        let i = (2 * x + 1) * cells[0] / (2 * width);
        let j = cells[1] - 1 - (2 * y + 1) * cells[1] / (2 * height);
        match on_sheet.colour(i, j) {
            Some([r, g, b]) => [r, g, b, 255],
            None => BARE,
        }
    })
}
