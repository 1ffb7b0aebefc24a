//! What gestures snap to: the chart's middle and edges, its guides, and crossings of the cloth.

use renderer_core::design::Chart;
use renderer_core::design::chart_objects::ChartCanvas;

/// Lines that a gesture has snapped to, mm from the chart's middle: upright and level ones.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Caught(pub [Option<f64>; 2]);

/// The lines that there are.
pub struct Snapper {
    lines: [Vec<f64>; 2],
    pixel_mm: [f64; 2],
    half: [f64; 2],
    /// How near something has to be, mm.
    reach: [f64; 2],
}

impl Snapper {
    /// Those of a chart; what is nearer than `reach` mm to a line snaps. Nothing does where `snaps` says so.
    pub fn new(chart: &Chart, canvas: &ChartCanvas, reach: f64, snaps: bool) -> Self {
        let half = canvas.size_mm().map(|side| 0.5 * side);
        let of = |k: usize, guides: &[f64]| {
            let mut lines = vec![0.0, -half[k], half[k]];
            lines.extend(guides);
            lines
        };
        Self {
            lines: [of(0, &chart.guides_x), of(1, &chart.guides_y)],
            pixel_mm: canvas.pixel_mm,
            half,
            reach: [if snaps { reach } else { -1.0 }; 2],
        }
    }

    /// These places to snap to, without guides.
    pub fn without_guides(mut self) -> Self {
        self.lines.iter_mut().for_each(|lines| lines.truncate(3));
        self
    }

    /// How far something has to move so that one of these places of it lies on a line, and which; else so that the
    /// first lies between two crossings.
    pub fn shift(&self, axis: usize, places: &[f64]) -> (f64, Option<f64>) {
        if self.reach[axis] < 0.0 {
            return (0.0, None);
        }
        let near = |place: &f64| {
            let lines = self.lines[axis].iter();
            let shifts = lines.map(|line| (line - place, *line));
            shifts.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        };
        let nearest = places.iter().filter_map(near);
        let nearest = nearest.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        match nearest {
            Some((shift, line)) if shift.abs() <= self.reach[axis] => (shift, Some(line)),
            _ => (
                places
                    .first()
                    .map_or(0.0, |first| self.crossing(axis, *first) - first),
                None,
            ),
        }
    }

    /// The place between two crossings that is nearest.
    fn crossing(&self, axis: usize, place: f64) -> f64 {
        let pixel = self.pixel_mm[axis];
        ((place + self.half[axis]) / pixel).round() * pixel - self.half[axis]
    }

    /// A place, snapped on both axes.
    pub fn place(&self, place: [f64; 2]) -> ([f64; 2], Caught) {
        let shifts = [0, 1].map(|k| self.shift(k, &[place[k]]));
        (
            [0, 1].map(|k| place[k] + shifts[k].0),
            Caught(shifts.map(|(_, line)| line)),
        )
    }
}
