//! Bars side by side from zero: what some things cost, each with its number.

use plotters::prelude::{DrawingBackend, WHITE};
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::label;
use super::canvas::{Canvas, Stroke, draw};
use super::{COLOURS, Figure, GREY, GRID, INK};

/// Left, top, right and lower border of the bars' field.
const FIELD: [f64; 4] = [206.0, 64.0, 780.0, 532.0];
/// Thickest bar, units.
const THICKEST: f64 = 26.0;

/// Width of a letter of the text at a bar's end, on average, units.
const LETTER: f64 = 6.8;

/// A bar.
#[derive(Debug, Clone)]
pub struct Bar {
    /// What it is of.
    pub name: String,
    /// How long it is, in the axis' unit; without, there is only the text.
    pub value: Option<f64>,
    /// What stands at its end: the number, and what it needs to be understood.
    pub text: String,
}

/// The plot.
#[derive(Debug, Clone)]
pub struct Bars {
    /// What it is of.
    pub title: String,
    /// Under which conditions.
    pub under: String,
    /// What the bars measure, with its unit.
    pub axis: String,
    /// From above.
    pub bars: Vec<Bar>,
    /// A value that the bars are held against, and its name.
    pub limit: Option<(f64, String)>,
    /// Longest bar that is drawn: those beyond it are cut, so that the others can be told apart.
    pub cut: Option<f64>,
}

/// Numbers for a linear axis from 0 that holds `most`: some five round ones.
fn ticks(most: f64) -> Vec<f64> {
    let raw = most / 5.0;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
    let step = step
        .into_iter()
        .find(|step| *step >= raw)
        .unwrap_or(10.0 * power);
    let count = (most / step).floor() as u32;
    // Rounded, because 3 · 0.1 has stray digits.
    (0..=count)
        .map(|k| (f64::from(k) * step * 1e9).round() / 1e9)
        .collect()
}

impl Bars {
    /// The longest value there is to show.
    fn most(&self) -> f64 {
        let values = self.bars.iter().filter_map(|bar| bar.value);
        let limit = self.limit.iter().map(|limit| limit.0);
        let most = values.chain(limit).filter(|value| value.is_finite());
        let most = most.fold(f64::MIN_POSITIVE, f64::max);
        self.cut.map_or(most, |cut| most.min(cut))
    }
}

impl Figure for Bars {
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        draw(canvas.area.fill(&WHITE))?;
        let [left, top, right, bottom] = FIELD;
        let most = self.most();
        let place = |value: f64| left + (right - left) * value / most;
        let above = (HPos::Left, VPos::Center);
        canvas.text(&self.title, [26.0, 22.0], 19.0, above, INK)?;
        canvas.text(&self.under, [26.0, 45.0], 14.0, above, GREY)?;
        let middle = (HPos::Center, VPos::Center);
        let grid = Stroke {
            colour: GRID,
            width: 1.0,
            dash: None,
        };
        for tick in ticks(most) {
            let x = place(tick);
            canvas.line(&[[x, top], [x, bottom]], grid)?;
            canvas.text(&label(tick), [x, bottom + 17.0], 14.0, middle, INK)?;
        }
        let under = [(left + right) / 2.0, bottom + 46.0];
        canvas.text(&self.axis, under, 16.0, middle, INK)?;

        // Under the bars and their numbers.
        if let Some((value, name)) = &self.limit {
            let x = place(*value);
            let stroke = Stroke {
                colour: COLOURS[1],
                width: 1.6,
                dash: Some([5.0, 4.0]),
            };
            canvas.line(&[[x, top], [x, bottom]], stroke)?;
            // On whichever side there is room.
            let (at, anchor) = if x < 0.5 * (left + right) {
                (x + 5.0, HPos::Left)
            } else {
                (x - 5.0, HPos::Right)
            };
            canvas.text(
                name,
                [at, top - 4.0],
                13.0,
                (anchor, VPos::Center),
                COLOURS[1],
            )?;
        }
        let pitch = (bottom - top) / self.bars.len().max(1) as f64;
        let thick = (0.7 * pitch).min(THICKEST);
        for (index, bar) in self.bars.iter().enumerate() {
            let y = top + pitch * (index as f64 + 0.5);
            let side = (HPos::Right, VPos::Center);
            canvas.text(&bar.name, [left - 10.0, y], 14.5, side, INK)?;
            let value = bar.value.filter(|value| value.is_finite()).unwrap_or(0.0);
            let end = place(value.min(most));
            if value > 0.0 {
                let (low, high) = (y - 0.5 * thick, y + 0.5 * thick);
                let corners = [[left, low], [end, low], [end, high], [left, high]];
                canvas.polygon(&corners, COLOURS[0])?;
                if value > most {
                    // It goes on beyond a gap.
                    let gap = [[-24.0, high], [-16.0, high], [-8.0, low], [-16.0, low]];
                    canvas.polygon(&gap.map(|[x, y]| [end + x, y]), WHITE)?;
                }
            }
            // On white, so that no line runs through it.
            let behind = [
                end + 5.0,
                end + 8.0 + LETTER * bar.text.chars().count() as f64,
            ];
            let (low, high) = (y - 9.0, y + 9.0);
            let [from, to] = behind;
            canvas.polygon(&[[from, low], [to, low], [to, high], [from, high]], WHITE)?;
            canvas.text(&bar.text, [end + 8.0, y], 13.5, above, INK)?;
        }
        let axis = Stroke {
            colour: GREY,
            width: 1.2,
            dash: None,
        };
        canvas.line(&[[left, top], [left, bottom]], axis)
    }
}
