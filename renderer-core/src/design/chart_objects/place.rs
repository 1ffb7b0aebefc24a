//! Where an object and its repeats lie, and the outline that is filled there.

use super::glyph_path::GlyphPath;
use super::{ChartCanvas, ChartObject, ObjectKind};

/// Corners of the polygon that an ellipse is drawn as: of one a metre wide it leaves out less than a tenth of a mm.
const ELLIPSE_CORNERS: usize = 180;

/// Most repeats in a row or column: what presets allow.
const MOST_REPEATS: u32 = ChartObject::FIELDS.repeat_x.max as u32;

/// A closed line of places in the object's box, which reaches from −½ to ½ both ways.
pub(super) type Contour = Vec<[f64; 2]>;

/// One of an object's repeats on the chart: turned, mirrored, moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    middle: [f64; 2],
    /// Width and height, mm; negative where mirrored.
    size: [f64; 2],
    /// Sine and cosine of the rotation.
    turn: [f64; 2],
    /// Whether the turned box is mirrored.
    reflected: [bool; 2],
}

impl Placed {
    /// The object itself, without its repeats.
    pub fn first(object: &ChartObject, canvas: &ChartCanvas) -> Self {
        let (mut middle, mut size) = ([object.x, object.y], [object.width, object.height]);
        let mut rotation = object.rotation;
        // From edge to edge, whatever the cloth's size.
        let through = 2.0 * canvas.size_mm().iter().sum::<f64>();
        match object.kind {
            ObjectKind::StripeAcross => (middle[0], size[0], rotation) = (0.0, through, 0.0),
            ObjectKind::StripeAlong => (middle[1], size[1], rotation) = (0.0, through, 0.0),
            // Thinner, it would have gaps.
            ObjectKind::Line => {
                let thinnest = canvas.pixel_mm[0].max(canvas.pixel_mm[1]);
                size[1] = size[1].max(thinnest);
            }
            _ => {}
        }
        if object.mirror_x {
            size[0] = -size[0];
        }
        if object.mirror_y {
            size[1] = -size[1];
        }
        let (sine, cosine) = rotation.to_radians().sin_cos();
        Self {
            middle,
            size,
            turn: [sine, cosine],
            reflected: [false; 2],
        }
    }

    /// The object with its repeats and their reflections, as far as they lie on the canvas.
    pub fn all(object: &ChartObject, canvas: &ChartCanvas) -> Vec<Self> {
        let first = Self::first(object, canvas);
        let half = canvas.size_mm().map(|side| 0.5 * side);
        let mut all = Vec::new();
        let sides = |reflects: bool| {
            if reflects {
                &[false, true][..]
            } else {
                &[false]
            }
        };
        // Designs that are not checked yet may ask for anything.
        let [columns, rows] =
            [object.repeat_x, object.repeat_y].map(|times| times.min(MOST_REPEATS));
        for row in 0..rows {
            for column in 0..columns {
                let moved = first.moved([
                    f64::from(column) * object.step_x,
                    f64::from(row) * object.step_y,
                ]);
                for &x in sides(object.reflect_x) {
                    for &y in sides(object.reflect_y) {
                        let placed = moved.reflected([x, y]);
                        let [low, high] = placed.bounds();
                        if (0..2).all(|k| low[k] < half[k] && high[k] > -half[k]) {
                            all.push(placed);
                        }
                    }
                }
            }
        }
        all
    }

    fn moved(self, by: [f64; 2]) -> Self {
        Self {
            middle: [0, 1].map(|k| self.middle[k] + by[k]),
            ..self
        }
    }

    fn reflected(self, reflected: [bool; 2]) -> Self {
        let sign = |k: usize| if reflected[k] { -1.0 } else { 1.0 };
        Self {
            middle: [0, 1].map(|k| sign(k) * self.middle[k]),
            reflected,
            ..self
        }
    }

    /// Where a place of its box, −½ to ½ both ways, lies on the chart, mm from the middle.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let ([sine, cosine], [u, v]) = (self.turn, [u * self.size[0], v * self.size[1]]);
        let turned = [u * cosine - v * sine, u * sine + v * cosine];
        let sign = |k: usize| if self.reflected[k] { -1.0 } else { 1.0 };
        [0, 1].map(|k| self.middle[k] + sign(k) * turned[k])
    }

    /// The place of its box that lies at a place on the chart.
    pub fn box_at(&self, place: [f64; 2]) -> [f64; 2] {
        let sign = |k: usize| if self.reflected[k] { -1.0 } else { 1.0 };
        let [x, y] = [0, 1].map(|k| sign(k) * (place[k] - self.middle[k]));
        let [sine, cosine] = self.turn;
        [
            (x * cosine + y * sine) / self.size[0],
            (y * cosine - x * sine) / self.size[1],
        ]
    }

    /// Its corners: lower left, lower right, upper right, upper left before it was turned.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|corner| self.at(corner))
    }

    /// The lowest and highest x and y of its corners, mm.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let corners = self.corners();
        let of = |f: fn(f64, f64) -> f64, start: f64| {
            [0, 1].map(|k| corners.iter().fold(start, |end, corner| f(end, corner[k])))
        };
        [of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY)]
    }

    /// Whether a place on the chart lies in its box, widened by `margin` mm.
    pub fn holds(&self, place: [f64; 2], margin: f64) -> bool {
        let at = self.box_at(place);
        (0..2).all(|k| at[k].abs() <= 0.5 + margin / self.size[k].abs())
    }
}

/// The outline of an object in its box, filled where it winds around.
pub(super) fn contours(object: &ChartObject, canvas: &ChartCanvas) -> Vec<Contour> {
    let whole: Contour = match object.kind {
        ObjectKind::Image => return Vec::new(),
        ObjectKind::Text => return letters(object),
        ObjectKind::Ellipse => ellipse([0.5; 2]),
        ObjectKind::Line | ObjectKind::StripeAcross | ObjectKind::StripeAlong => {
            rectangle([0.5; 2])
        }
        ObjectKind::Rectangle => rectangle([0.5; 2]),
    };
    let has_border = matches!(object.kind, ObjectKind::Rectangle | ObjectKind::Ellipse);
    if !has_border || object.border == 0.0 {
        return vec![whole];
    }
    // At least a crossing, or there would be gaps.
    let inner = [object.width, object.height].map(|side| side - 2.0 * object.border);
    let inner = [0, 1].map(|k| {
        let side = [object.width, object.height][k];
        0.5 * inner[k].min(side - 2.0 * canvas.pixel_mm[k]) / side
    });
    if inner.iter().any(|&half| half <= 0.0) {
        return vec![whole];
    }
    let mut hole = match object.kind {
        ObjectKind::Ellipse => ellipse(inner),
        _ => rectangle(inner),
    };
    hole.reverse();
    vec![whole, hole]
}

fn rectangle([x, y]: [f64; 2]) -> Contour {
    vec![[-x, -y], [x, -y], [x, y], [-x, y]]
}

fn ellipse([x, y]: [f64; 2]) -> Contour {
    let corner = |k: usize| {
        let (sine, cosine) = (k as f64 / ELLIPSE_CORNERS as f64 * std::f64::consts::TAU).sin_cos();
        [x * cosine, y * sine]
    };
    (0..ELLIPSE_CORNERS).map(corner).collect()
}

/// The outline of a text, its bounds stretched over the box.
fn letters(object: &ChartObject) -> Vec<Contour> {
    let path = object.outline.as_deref().map(GlyphPath::read);
    let Some(Ok(path)) = path else {
        return Vec::new();
    };
    let Some(bounds) = path.bounds() else {
        return Vec::new();
    };
    let [width, height] = bounds.size();
    let in_box = |[x, y]: [f64; 2]| {
        [
            (x - bounds.low[0]) / width.max(f64::MIN_POSITIVE) - 0.5,
            (y - bounds.low[1]) / height.max(f64::MIN_POSITIVE) - 0.5,
        ]
    };
    let contours = path.contours().into_iter();
    contours
        .map(|contour| contour.into_iter().map(in_box).collect())
        .collect()
}
