//! Curves over an axis that grows: both axes logarithmic, so that a cost in proportion is a straight line.

use plotters::prelude::{DrawingBackend, WHITE};
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::{Canvas, Stroke, draw};
use super::field::{self, FIELD, LEGEND};
use super::{COLOURS, Figure, GREY, INK, MARKERS};

/// A curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// x and y, by rising x; what is not above 0 is not drawn.
    pub points: Vec<[f64; 2]>,
}

/// A value that curves are held against.
#[derive(Debug, Clone)]
pub struct Limit {
    /// Its name in the legend.
    pub name: String,
    /// In the units of the axis that it is on.
    pub value: f64,
}

/// The plot.
#[derive(Debug, Clone)]
pub struct Curves {
    /// What it is of.
    pub title: String,
    /// Under which conditions.
    pub under: String,
    /// What x and y are, with units.
    pub axes: [String; 2],
    /// The curves, at most as many as there are colours to tell them apart.
    pub curves: Vec<Curve>,
    /// Drawn across.
    pub limit: Option<Limit>,
    /// Lines of text under the legend.
    pub notes: Vec<String>,
}

impl Curves {
    fn axes(&self) -> [Axis; 2] {
        let [left, top, right, bottom] = FIELD;
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let limit = self.limit.iter().map(|limit| limit.value);
        [
            Axis::new(points().map(|point| point[0]), [left, right]),
            Axis::new(points().map(|point| point[1]).chain(limit), [bottom, top]),
        ]
    }
}

impl Figure for Curves {
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        draw(canvas.area.fill(&WHITE))?;
        let axes = self.axes();
        field::titles(canvas, &self.title, &self.under)?;
        field::axis_titles(canvas, [&self.axes[0], &self.axes[1]])?;
        field::grid(canvas, &axes)?;
        let mut y = FIELD[1] + 8.0;
        let name = (HPos::Left, VPos::Center);
        if let Some(limit) = &self.limit {
            let at = axes[1].place(limit.value);
            canvas.line(&[[FIELD[0], at], [FIELD[2], at]], LIMIT)?;
        }
        for (index, curve) in self.curves.iter().enumerate() {
            let stroke = Stroke {
                colour: COLOURS[index % COLOURS.len()],
                width: 1.8,
                dash: None,
            };
            let marker = MARKERS[index % MARKERS.len()];
            let is_drawn = |point: &&[f64; 2]| point.iter().all(|value| *value > 0.0);
            let points = curve.points.iter().filter(is_drawn);
            let line: Vec<_> = points
                .map(|point| [axes[0].place(point[0]), axes[1].place(point[1])])
                .collect();
            if line.len() > 1 {
                canvas.line(&line, stroke)?;
            }
            for &at in &line {
                canvas.marker(at, marker, stroke.colour, true)?;
            }
            canvas.line(&[[LEGEND, y], [LEGEND + 36.0, y]], stroke)?;
            canvas.marker([LEGEND + 18.0, y], marker, stroke.colour, true)?;
            canvas.text(&curve.name, [LEGEND + 46.0, y], 14.5, name, INK)?;
            y += 24.0;
        }
        if let Some(limit) = &self.limit {
            canvas.line(&[[LEGEND, y], [LEGEND + 36.0, y]], LIMIT)?;
            canvas.text(&limit.name, [LEGEND + 46.0, y], 14.5, name, INK)?;
            y += 24.0;
        }
        y += 14.0;
        for note in &self.notes {
            canvas.text(note, [LEGEND, y], 13.5, name, GREY)?;
            y += 19.0;
        }
        Ok(())
    }
}

const LIMIT: Stroke = Stroke {
    colour: GREY,
    width: 1.4,
    dash: Some([2.0, 4.0]),
};
