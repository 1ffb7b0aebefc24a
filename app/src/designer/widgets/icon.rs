//! Pictures on buttons, drawn with lines and areas in one colour, so that they are crisp at every scale and take
//! the colour of the text in both themes.
//!
//! Each is made of marks on a field of 16 × 16 units, y down, with half a unit of air at the sides.

use std::f32::consts::{PI, TAU};

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke};

/// What a button does, as a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say what the pictures show")]
pub enum Icon {
    Pencil,
    Line,
    Rectangle,
    FilledRectangle,
    Fill,
    Pick,
    MirrorHorizontally,
    MirrorVertically,
    Rotate,
    ShiftLeft,
    ShiftRight,
    ShiftUp,
    ShiftDown,
    Crop,
    ZoomIn,
    ZoomOut,
    Undo,
    Redo,
    Dice,
    Enlarge,
    Plus,
    Minus,
    Duplicate,
    Search,
    Eye,
    Arrow,
    StripeAcross,
    StripeAlong,
    Ellipse,
    Letters,
}

impl Icon {
    /// All icons.
    pub const ALL: [Self; 30] = [
        Self::Pencil,
        Self::Line,
        Self::Rectangle,
        Self::FilledRectangle,
        Self::Fill,
        Self::Pick,
        Self::MirrorHorizontally,
        Self::MirrorVertically,
        Self::Rotate,
        Self::ShiftLeft,
        Self::ShiftRight,
        Self::ShiftUp,
        Self::ShiftDown,
        Self::Crop,
        Self::ZoomIn,
        Self::ZoomOut,
        Self::Undo,
        Self::Redo,
        Self::Dice,
        Self::Enlarge,
        Self::Plus,
        Self::Minus,
        Self::Duplicate,
        Self::Search,
        Self::Eye,
        Self::Arrow,
        Self::StripeAcross,
        Self::StripeAlong,
        Self::Ellipse,
        Self::Letters,
    ];

    /// Draws the icon as large as fits into the middle of `rect`.
    pub fn paint(self, painter: &Painter, rect: Rect, colour: Color32) {
        let side = rect.width().min(rect.height());
        // A whole number of pixels from the corner, or straight lines would be blurred over two of them.
        let pixel = painter.pixels_per_point();
        let corner = rect.center() - egui::Vec2::splat(side / 2.0);
        let corner = (corner * pixel).round() / pixel;
        let pen = Pen {
            corner,
            unit: side / UNITS,
            pixel,
            colour,
        };
        painter.extend(self.marks().into_iter().map(|mark| pen.shape(&mark)));
    }

    fn marks(self) -> Vec<Mark> {
        use Mark::{Area, Dot, Line, Ring};
        match self {
            Self::Pencil => vec![
                Line(vec![
                    (3.0, 13.0),
                    (3.8, 9.6),
                    (11.0, 2.4),
                    (13.6, 5.0),
                    (6.4, 12.2),
                    (3.0, 13.0),
                ]),
                Line(vec![(9.2, 4.2), (11.8, 6.8)]),
                Area(vec![(2.4, 13.6), (3.2, 10.8), (5.2, 12.8)]),
            ],
            Self::Line => vec![
                Line(vec![(3.5, 12.5), (12.5, 3.5)]),
                Dot((3.5, 12.5), 1.8),
                Dot((12.5, 3.5), 1.8),
            ],
            Self::Rectangle => vec![frame((2.5, 4.5), (13.5, 12.5))],
            Self::FilledRectangle => vec![
                Area(corners((2.5, 4.5), (13.5, 12.5))),
                frame((2.5, 4.5), (13.5, 12.5)),
            ],
            Self::Fill => vec![
                Line(vec![
                    (2.0, 8.0),
                    (7.0, 3.0),
                    (12.0, 8.0),
                    (7.0, 13.0),
                    (2.0, 8.0),
                ]),
                Area(vec![(2.6, 8.4), (11.4, 8.4), (7.0, 12.8)]),
                Line(vec![(7.0, 6.5), (7.0, 1.5)]),
                Area(vec![(13.6, 8.6), (14.9, 11.4), (12.3, 11.4)]),
                Dot((13.6, 12.0), 1.5),
            ],
            Self::Pick => vec![
                Line(vec![
                    (8.2, 5.6),
                    (3.4, 10.4),
                    (2.6, 13.4),
                    (5.6, 12.6),
                    (10.4, 7.8),
                ]),
                Line(vec![(7.0, 4.4), (11.6, 9.0)]),
                Area(vec![(8.6, 5.4), (10.8, 3.0), (13.0, 5.2), (10.6, 7.4)]),
                Dot((12.1, 3.9), 1.9),
            ],
            Self::MirrorHorizontally => mirror(|point| point),
            Self::MirrorVertically => mirror(|(x, y)| (y, x)),
            Self::Rotate => {
                let mut marks = vec![arc((8.0, 8.5), 5.0, -0.35 * PI, 1.2 * PI)];
                marks.push(Area(vec![(7.6, 0.6), (12.2, 3.6), (7.6, 6.4)]));
                marks
            }
            Self::ShiftLeft => arrow(|point| point),
            Self::ShiftRight => arrow(|(x, y)| (UNITS - x, y)),
            Self::ShiftUp => arrow(|(x, y)| (y, x)),
            Self::ShiftDown => arrow(|(x, y)| (y, UNITS - x)),
            Self::Crop => vec![
                Line(vec![(4.5, 1.5), (4.5, 11.5), (14.5, 11.5)]),
                Line(vec![(1.5, 4.5), (11.5, 4.5), (11.5, 14.5)]),
            ],
            Self::ZoomIn => {
                let mut marks = lens();
                marks.push(Line(vec![(4.5, 6.5), (8.5, 6.5)]));
                marks.push(Line(vec![(6.5, 4.5), (6.5, 8.5)]));
                marks
            }
            Self::ZoomOut => {
                let mut marks = lens();
                marks.push(Line(vec![(4.5, 6.5), (8.5, 6.5)]));
                marks
            }
            Self::Search => lens(),
            Self::Arrow => vec![
                Area(vec![(4.0, 1.5), (12.2, 9.6), (7.8, 9.4), (4.0, 13.0)]),
                Line(vec![(7.4, 9.0), (10.0, 14.4)]),
            ],
            Self::StripeAcross => stripes(|point| point),
            Self::StripeAlong => stripes(|(x, y)| (y, x)),
            Self::Ellipse => vec![Line(
                (0..=32)
                    .map(|step| {
                        let angle = step as f32 / 32.0 * TAU;
                        (8.0 + 6.0 * angle.cos(), 8.0 + 4.4 * angle.sin())
                    })
                    .collect(),
            )],
            Self::Letters => vec![
                Line(vec![(2.5, 4.0), (2.5, 2.5), (13.5, 2.5), (13.5, 4.0)]),
                Line(vec![(8.0, 2.5), (8.0, 13.5)]),
                Line(vec![(6.0, 13.5), (10.0, 13.5)]),
            ],
            Self::Undo => turn(|point| point),
            Self::Redo => turn(|(x, y)| (UNITS - x, y)),
            Self::Dice => vec![
                frame((2.5, 2.5), (13.5, 13.5)),
                Dot((5.4, 5.4), 1.25),
                Dot((10.6, 5.4), 1.25),
                Dot((8.0, 8.0), 1.25),
                Dot((5.4, 10.6), 1.25),
                Dot((10.6, 10.6), 1.25),
            ],
            Self::Enlarge => vec![
                Line(vec![(9.2, 6.8), (13.0, 3.0)]),
                Line(vec![(9.0, 2.5), (13.5, 2.5), (13.5, 7.0)]),
                Line(vec![(6.8, 9.2), (3.0, 13.0)]),
                Line(vec![(7.0, 13.5), (2.5, 13.5), (2.5, 9.0)]),
            ],
            Self::Plus => vec![
                Line(vec![(2.5, 8.5), (14.5, 8.5)]),
                Line(vec![(8.5, 2.5), (8.5, 14.5)]),
            ],
            Self::Minus => vec![Line(vec![(2.5, 8.5), (14.5, 8.5)])],
            Self::Duplicate => vec![
                frame((5.5, 5.5), (13.5, 13.5)),
                Line(vec![
                    (3.5, 10.5),
                    (2.5, 10.5),
                    (2.5, 2.5),
                    (10.5, 2.5),
                    (10.5, 3.5),
                ]),
            ],
            Self::Eye => {
                let lid = |sign: f32| {
                    (0..=12).map(move |step| {
                        let x = step as f32 / 6.0 - 1.0;
                        (8.0 + 6.5 * x, 8.0 - sign * 4.4 * (1.0 - x * x))
                    })
                };
                vec![
                    Line(lid(1.0).collect()),
                    Line(lid(-1.0).collect()),
                    Ring((8.0, 8.0), 2.2),
                    Dot((8.0, 8.0), 1.0),
                ]
            }
        }
    }
}

/// Side of the field that marks are placed on.
const UNITS: f32 = 16.0;
/// Thickness of lines, units.
const LINE: f32 = 1.2;

/// A part of an icon, in units of the field.
enum Mark {
    /// Joined line pieces.
    Line(Vec<(f32, f32)>),
    /// A convex area.
    Area(Vec<(f32, f32)>),
    /// A circle's outline.
    Ring((f32, f32), f32),
    /// A filled circle.
    Dot((f32, f32), f32),
}

/// Turns marks into shapes on the screen.
struct Pen {
    corner: Pos2,
    unit: f32,
    pixel: f32,
    colour: Color32,
}

impl Pen {
    fn shape(&self, mark: &Mark) -> Shape {
        let at = |&(x, y): &(f32, f32)| self.corner + egui::vec2(x, y) * self.unit;
        let points = |marks: &[(f32, f32)]| marks.iter().map(at).collect();
        // Whole pixels, for the same reason as the corner.
        let thickness = (LINE * self.unit * self.pixel).round().max(1.0) / self.pixel;
        let stroke = Stroke::new(thickness, self.colour);
        match mark {
            Mark::Line(line) => Shape::line(points(line), stroke),
            Mark::Area(area) => Shape::convex_polygon(points(area), self.colour, Stroke::NONE),
            Mark::Ring(centre, radius) => {
                Shape::circle_stroke(at(centre), radius * self.unit, stroke)
            }
            Mark::Dot(centre, radius) => {
                Shape::circle_filled(at(centre), radius * self.unit, self.colour)
            }
        }
    }
}

fn corners((left, top): (f32, f32), (right, bottom): (f32, f32)) -> Vec<(f32, f32)> {
    vec![(left, top), (right, top), (right, bottom), (left, bottom)]
}

fn frame(from: (f32, f32), to: (f32, f32)) -> Mark {
    let mut line = corners(from, to);
    // Past the first corner, which would else be notched.
    line.extend_from_within(..2);
    Mark::Line(line)
}

/// Part of a circle, from one angle to another, clockwise from the right.
fn arc((x, y): (f32, f32), radius: f32, from: f32, to: f32) -> Mark {
    let steps = ((to - from) / TAU * 40.0).ceil();
    let point = |step: i32| {
        let angle = from + (to - from) * step as f32 / steps;
        (x + radius * angle.cos(), y + radius * angle.sin())
    };
    Mark::Line((0..=steps as i32).map(point).collect())
}

/// An arrow to the left.
fn arrow(place: impl Fn((f32, f32)) -> (f32, f32)) -> Vec<Mark> {
    let line = |points: &[(f32, f32)]| Mark::Line(points.iter().map(|p| place(*p)).collect());
    vec![
        line(&[(14.0, 8.0), (2.8, 8.0)]),
        line(&[(7.0, 3.5), (2.5, 8.0), (7.0, 12.5)]),
    ]
}

/// Two triangles on both sides of an upright line, one of them empty.
fn mirror(place: impl Fn((f32, f32)) -> (f32, f32)) -> Vec<Mark> {
    let points = |points: &[(f32, f32)]| points.iter().map(|p| place(*p)).collect::<Vec<_>>();
    let mut marks = vec![
        Mark::Area(points(&[(6.2, 3.0), (6.2, 13.0), (0.8, 13.0)])),
        Mark::Line(points(&[
            (10.4, 4.4),
            (10.4, 12.5),
            (14.6, 12.5),
            (10.4, 4.4),
            (10.4, 6.0),
        ])),
    ];
    for top in [1.0, 5.0, 9.0, 13.0] {
        marks.push(Mark::Line(points(&[(8.5, top), (8.5, top + 2.2)])));
    }
    marks
}

/// A frame with a band from side to side.
fn stripes(place: impl Fn((f32, f32)) -> (f32, f32)) -> Vec<Mark> {
    let band = corners((2.5, 6.0), (13.5, 10.0));
    vec![
        frame((2.5, 2.5), (13.5, 13.5)),
        Mark::Area(band.into_iter().map(place).collect()),
    ]
}

/// A magnifying glass.
fn lens() -> Vec<Mark> {
    vec![
        Mark::Ring((6.5, 6.5), 4.6),
        Mark::Line(vec![(9.8, 9.8), (14.2, 14.2)]),
    ]
}

/// An arrow that bends back to the left.
fn turn(place: impl Fn((f32, f32)) -> (f32, f32)) -> Vec<Mark> {
    let mut bend = vec![(2.8, 6.0), (9.5, 6.0)];
    if let Mark::Line(arc) = arc((9.5, 9.75), 3.75, -0.5 * PI, 0.5 * PI) {
        bend.extend(arc);
    }
    bend.push((5.0, 13.5));
    let line = |points: &[(f32, f32)]| Mark::Line(points.iter().map(|p| place(*p)).collect());
    vec![line(&bend), line(&[(6.2, 2.2), (2.4, 6.0), (6.2, 9.8)])]
}
