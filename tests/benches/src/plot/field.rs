//! The field that curves are drawn in: its titles, its grid and the numbers at its axes.

use plotters::prelude::{DrawingBackend, Text};
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::{Axis, label};
use super::canvas::{Canvas, Stroke, draw};
use super::{FINE_GRID, GREY, GRID, INK};

/// Left, top, right and lower border of the curves' field.
pub const FIELD: [f64; 4] = [84.0, 64.0, 690.0, 532.0];
/// Left border of the legend.
pub const LEGEND: f64 = 714.0;

/// Title and subtitle.
pub fn titles<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    title: &str,
    under: &str,
) -> anyhow::Result<()> {
    let left = FIELD[0];
    let above = (HPos::Left, VPos::Center);
    canvas.text(title, [left, 22.0], 19.0, above, INK)?;
    canvas.text(under, [left, 45.0], 14.0, above, GREY)
}

/// What the axes mean.
pub fn axis_titles<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    [x, y]: [&str; 2],
) -> anyhow::Result<()> {
    let [left, top, right, bottom] = FIELD;
    let middle = (HPos::Center, VPos::Center);
    canvas.text(x, [(left + right) / 2.0, bottom + 46.0], 16.0, middle, INK)?;
    let style = canvas
        .text_style(16.0, HPos::Center, VPos::Center, INK)
        .transform(FontTransform::Rotate270);
    let at = canvas.point([22.0, (top + bottom) / 2.0]);
    draw(canvas.area.draw(&Text::new(y, at, style)))
}

/// Lines at the ticks of both axes, and their numbers.
pub fn grid<B: DrawingBackend>(canvas: &Canvas<'_, B>, axes: &[Axis; 2]) -> anyhow::Result<()> {
    let [left, top, right, bottom] = FIELD;
    // Fine lines under coarse ones.
    for coarse in [false, true] {
        let stroke = Stroke {
            colour: if coarse { GRID } else { FINE_GRID },
            width: 1.0,
            dash: None,
        };
        for (value, labelled) in axes[0].ticks() {
            if labelled == coarse {
                let x = axes[0].place(value);
                canvas.line(&[[x, top], [x, bottom]], stroke)?;
            }
        }
        for (value, labelled) in axes[1].ticks() {
            if labelled == coarse {
                let y = axes[1].place(value);
                canvas.line(&[[left, y], [right, y]], stroke)?;
            }
        }
    }
    for (value, _) in axes[0].ticks().into_iter().filter(|tick| tick.1) {
        let at = [axes[0].place(value), bottom + 17.0];
        canvas.text(&label(value), at, 14.0, (HPos::Center, VPos::Center), INK)?;
    }
    for (value, _) in axes[1].ticks().into_iter().filter(|tick| tick.1) {
        let at = [left - 9.0, axes[1].place(value)];
        canvas.text(&label(value), at, 14.0, (HPos::Right, VPos::Center), INK)?;
    }
    let frame = [[left, top], [left, bottom], [right, bottom]];
    canvas.line(
        &frame,
        Stroke {
            colour: GREY,
            width: 1.2,
            dash: None,
        },
    )
}
