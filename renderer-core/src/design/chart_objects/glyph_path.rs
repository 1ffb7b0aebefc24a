//! Outlines of letters as a preset has them: M, L, Q, C and Z with numbers, a subset of SVG's path data, y upwards.

use std::fmt::Write;

/// Straight pieces that a curve is drawn as: less than a hundredth of its length beside it.
const PIECES: usize = 12;

/// Closed lines and curves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GlyphPath {
    steps: Vec<Step>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Move([f64; 2]),
    Line([f64; 2]),
    Quadratic([f64; 2], [f64; 2]),
    Cubic([f64; 2], [f64; 2], [f64; 2]),
    Close,
}

/// The lowest and highest x and y of something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lowest.
    pub low: [f64; 2],
    /// Highest.
    pub high: [f64; 2],
}

impl Bounds {
    /// Width and height.
    pub fn size(&self) -> [f64; 2] {
        [0, 1].map(|k| self.high[k] - self.low[k])
    }
}

impl GlyphPath {
    /// What is allowed in a preset.
    pub const ALLOWED: &str = "M x y, L x y, Q x y x y, C x y x y x y and Z, beginning with M, at most 1000000 characters";
    /// Longest text of a path, bytes.
    const LONGEST: usize = 1_000_000;

    /// Begins a line here.
    pub fn move_to(&mut self, to: [f64; 2]) {
        self.steps.push(Step::Move(to));
    }

    /// Goes straight on.
    pub fn line_to(&mut self, to: [f64; 2]) {
        self.steps.push(Step::Line(to));
    }

    /// Goes on in a curve with one control point.
    pub fn quadratic_to(&mut self, control: [f64; 2], to: [f64; 2]) {
        self.steps.push(Step::Quadratic(control, to));
    }

    /// Goes on in a curve with two control points.
    pub fn cubic_to(&mut self, first: [f64; 2], second: [f64; 2], to: [f64; 2]) {
        self.steps.push(Step::Cubic(first, second, to));
    }

    /// Goes back to where the line began.
    pub fn close(&mut self) {
        self.steps.push(Step::Close);
    }

    /// Whether there is nothing to fill.
    pub fn is_empty(&self) -> bool {
        self.bounds().is_none()
    }

    /// Reads what a preset has.
    ///
    /// # Errors
    /// What of it is not allowed.
    pub fn read(text: &str) -> Result<Self, String> {
        if text.len() > Self::LONGEST {
            return Err(format!("{} characters", text.len()));
        }
        let mut path = Self::default();
        let mut words = text.split_ascii_whitespace();
        while let Some(word) = words.next() {
            let mut place = || -> Result<[f64; 2], String> {
                let mut number = || {
                    let word = words
                        .next()
                        .ok_or_else(|| format!("{word} without numbers"))?;
                    let number = word.parse().ok().filter(|n: &f64| n.abs() < 1e9);
                    number.ok_or_else(|| format!("{word:?} for a number"))
                };
                Ok([number()?, number()?])
            };
            let step = match word {
                "M" => Step::Move(place()?),
                "L" => Step::Line(place()?),
                "Q" => Step::Quadratic(place()?, place()?),
                "C" => Step::Cubic(place()?, place()?, place()?),
                "Z" => Step::Close,
                other => return Err(format!("{other:?}")),
            };
            if path.steps.is_empty() && !matches!(step, Step::Move(_)) {
                return Err(format!("{word} at its beginning"));
            }
            path.steps.push(step);
        }
        Ok(path)
    }

    /// As a preset has it; numbers are rounded to whole ones.
    pub fn write(&self) -> String {
        let mut text = String::new();
        for step in &self.steps {
            let (letter, places): (_, &[[f64; 2]]) = match step {
                Step::Move(to) => ("M", &[*to]),
                Step::Line(to) => ("L", &[*to]),
                Step::Quadratic(control, to) => ("Q", &[*control, *to]),
                Step::Cubic(first, second, to) => ("C", &[*first, *second, *to]),
                Step::Close => ("Z", &[]),
            };
            let space = if text.is_empty() { "" } else { " " };
            text.push_str(space);
            text.push_str(letter);
            for [x, y] in places {
                // Writing into a string does not fail.
                let _ = write!(text, " {} {}", x.round(), y.round());
            }
        }
        text
    }

    /// Its closed lines, curves as straight pieces.
    pub fn contours(&self) -> Vec<Vec<[f64; 2]>> {
        let mut all: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut now: Vec<[f64; 2]> = Vec::new();
        for step in &self.steps {
            let from = now.last().copied().unwrap_or_default();
            match *step {
                Step::Move(to) => {
                    all.push(std::mem::replace(&mut now, vec![to]));
                }
                Step::Line(to) => now.push(to),
                Step::Quadratic(control, to) => now.extend(pieces(|t| {
                    let s = 1.0 - t;
                    mix(&[(s * s, from), (2.0 * s * t, control), (t * t, to)])
                })),
                Step::Cubic(first, second, to) => now.extend(pieces(|t| {
                    let s = 1.0 - t;
                    mix(&[
                        (s * s * s, from),
                        (3.0 * s * s * t, first),
                        (3.0 * s * t * t, second),
                        (t * t * t, to),
                    ])
                })),
                Step::Close => {}
            }
        }
        all.push(now);
        all.retain(|contour| contour.len() > 2);
        all
    }

    /// The bounds of its lines; `None` where there is nothing to fill.
    pub fn bounds(&self) -> Option<Bounds> {
        let contours = self.contours();
        let mut places = contours.iter().flatten();
        let first = *places.next()?;
        let start = Bounds {
            low: first,
            high: first,
        };
        Some(places.fold(start, |bounds, place| Bounds {
            low: [0, 1].map(|k| bounds.low[k].min(place[k])),
            high: [0, 1].map(|k| bounds.high[k].max(place[k])),
        }))
    }
}

/// Places along a curve, without its beginning.
fn pieces(at: impl Fn(f64) -> [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    (1..=PIECES).map(move |k| at(k as f64 / PIECES as f64))
}

fn mix(parts: &[(f64, [f64; 2])]) -> [f64; 2] {
    let sum = |k: usize| parts.iter().map(|(share, place)| share * place[k]).sum();
    [sum(0), sum(1)]
}
