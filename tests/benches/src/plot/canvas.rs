//! Drawing in units, on SVG and pixels alike: lines, dashes, markers, text.

use plotters::coord::Shift;
use plotters::prelude::{
    Circle, DrawingArea, DrawingBackend, PathElement, Polygon, RGBColor, Text, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, ShapeStyle, TextStyle, register_font};

/// The shape of a curve's points.
#[derive(Debug, Clone, Copy)]
pub enum Marker {
    /// A disc.
    Circle,
    /// Sides upright.
    Square,
    /// A square on its corner.
    Diamond,
    /// A triangle that points up.
    Up,
    /// A triangle that points down.
    Down,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    /// Its colour.
    pub colour: RGBColor,
    /// Units.
    pub width: f64,
    /// Lengths of dashes and gaps; none for a whole line.
    pub dash: Option<[f64; 2]>,
}

/// A surface to draw on in units.
pub struct Canvas<'a, B: DrawingBackend> {
    /// What is drawn on.
    pub area: &'a DrawingArea<B, Shift>,
    /// Pixels a unit.
    pub scale: f64,
    /// How far text stands too high, as a share of its size; depends on who sets it.
    pub text_rise: f64,
}

impl<B: DrawingBackend> Canvas<'_, B> {
    /// The pixel at a place.
    pub fn point(&self, [x, y]: [f64; 2]) -> (i32, i32) {
        (
            (x * self.scale).round() as i32,
            (y * self.scale).round() as i32,
        )
    }

    fn style(&self, colour: RGBColor, width: f64) -> ShapeStyle {
        colour.stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    /// A line through points.
    pub fn line(&self, points: &[[f64; 2]], stroke: Stroke) -> anyhow::Result<()> {
        let style = self.style(stroke.colour, stroke.width);
        for piece in pieces(points, stroke.dash) {
            let path: Vec<_> = piece.iter().map(|&point| self.point(point)).collect();
            draw(self.area.draw(&PathElement::new(path, style)))?;
        }
        Ok(())
    }

    /// A filled polygon.
    pub fn polygon(&self, points: &[[f64; 2]], colour: RGBColor) -> anyhow::Result<()> {
        let corners: Vec<_> = points.iter().map(|&point| self.point(point)).collect();
        draw(self.area.draw(&Polygon::new(corners, colour.filled())))
    }

    /// A filled circle.
    pub fn disc(&self, at: [f64; 2], radius: f64, colour: RGBColor) -> anyhow::Result<()> {
        let radius = (radius * self.scale).round() as i32;
        draw(
            self.area
                .draw(&Circle::new(self.point(at), radius, colour.filled())),
        )
    }

    /// A marker, filled or hollow.
    pub fn marker(
        &self,
        at: [f64; 2],
        marker: Marker,
        colour: RGBColor,
        filled: bool,
    ) -> anyhow::Result<()> {
        self.shape(at, marker, 5.0, colour)?;
        if filled {
            return Ok(());
        }
        self.shape(at, marker, 2.9, WHITE)
    }

    fn shape(
        &self,
        [x, y]: [f64; 2],
        marker: Marker,
        radius: f64,
        colour: RGBColor,
    ) -> anyhow::Result<()> {
        // Corners about the centre of gravity; areas are about that of the circle of radius 1.
        let corners: &[[f64; 2]] = match marker {
            Marker::Circle => return self.disc([x, y], radius, colour),
            Marker::Square => &[[-0.88, -0.88], [0.88, -0.88], [0.88, 0.88], [-0.88, 0.88]],
            Marker::Diamond => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
            Marker::Up => &[[0.0, -1.45], [1.26, 0.73], [-1.26, 0.73]],
            Marker::Down => &[[0.0, 1.45], [1.26, -0.73], [-1.26, -0.73]],
        };
        let around = corners
            .iter()
            .map(|[dx, dy]| [x + radius * dx, y + radius * dy]);
        self.polygon(&around.collect::<Vec<_>>(), colour)
    }

    /// A line of text, anchored at its side and middle as given.
    pub fn text(
        &self,
        text: &str,
        at: [f64; 2],
        size: f64,
        (h, v): (HPos, VPos),
        colour: RGBColor,
    ) -> anyhow::Result<()> {
        let style = self.text_style(size, h, v, colour);
        let at = self.point([at[0], at[1] + self.text_rise * size]);
        draw(self.area.draw(&Text::new(text, at, style)))
    }

    /// The style of [`Self::text`].
    pub fn text_style(&self, size: f64, h: HPos, v: VPos, colour: RGBColor) -> TextStyle<'static> {
        let mut style = TextStyle::from(("sans-serif", size * self.scale));
        style.color = colour.to_backend_color();
        style.pos = Pos::new(h, v);
        style
    }
}

/// The visible pieces of a dashed line.
fn pieces(points: &[[f64; 2]], dash: Option<[f64; 2]>) -> Vec<Vec<[f64; 2]>> {
    let Some([on, off]) = dash else {
        return vec![points.to_vec()];
    };
    let mut pieces = Vec::new();
    let mut walked = 0.0;
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let at = |distance: f64| {
            let share = (distance / length.max(1e-9)).clamp(0.0, 1.0);
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        };
        // Dashes go on around corners.
        let mut start = -(walked % (on + off));
        while start < length {
            if start + on > 0.0 {
                pieces.push(vec![at(start.max(0.0)), at((start + on).min(length))]);
            }
            start += on + off;
        }
        walked += length;
    }
    pieces
}

/// The drawing library's errors depend on what is drawn on.
pub fn draw<T, E: std::error::Error + Send + Sync>(
    result: Result<T, plotters::drawing::DrawingAreaErrorKind<E>>,
) -> anyhow::Result<T> {
    result.map_err(|error| anyhow::anyhow!("the plot cannot be drawn: {error}"))
}

/// Gives the drawing library a font: that of the designer.
pub fn register() -> anyhow::Result<()> {
    register_font(
        "sans-serif",
        FontStyle::Normal,
        epaint_default_fonts::UBUNTU_LIGHT,
    )
    .map_err(|_| anyhow::anyhow!("the plot's font cannot be read"))
}
