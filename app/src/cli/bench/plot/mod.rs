//! Run time against error as a picture: both axes logarithmic, a curve a setting, the Pareto front and the truth's noise.
//!
//! Colours are Okabe and Ito's, which the colour-blind tell apart, and every method has its own marker besides. All is
//! laid out in units of which the SVG has one a pixel and the PNG two, drawn at twice that and averaged.

mod axis;
mod canvas;

use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use plotters::prelude::{
    BitMapBackend, DrawingBackend, IntoDrawingArea, RGBColor, SVGBackend, Text, WHITE,
};
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};
use renderer_core::design::{Method, Sampler};

use self::axis::{Axis, label};
use self::canvas::{Canvas, Marker, Stroke, draw, register};
use super::measure::Findings;
use super::pareto::{self, Point};
use super::plan::{Setting, TRUTH, Target};
use super::truth::Known;
use super::{Conditions, summary};
use crate::clock;

/// Width and height, units.
const SIZE: [f64; 2] = [960.0, 600.0];
/// Left, top, right and lower border of the curves' field.
const FIELD: [f64; 4] = [84.0, 64.0, 690.0, 532.0];
/// Left border of the legend.
const LEGEND: f64 = 714.0;
/// Pixels a unit of the PNG.
const PNG_SCALE: u32 = 2;
/// Times as large that the PNG is drawn.
const OVERSAMPLING: u32 = 2;

const INK: RGBColor = RGBColor(34, 34, 34);
const GREY: RGBColor = RGBColor(120, 120, 120);
const GRID: RGBColor = RGBColor(226, 226, 226);
const FINE_GRID: RGBColor = RGBColor(243, 243, 243);
const FRONT: RGBColor = RGBColor(196, 196, 196);

/// What is drawn.
#[derive(Debug)]
pub struct Plot<'a> {
    preset: &'a str,
    conditions: &'a Conditions,
    findings: &'a Findings,
    points: Vec<Point>,
    axes: [Axis; 2],
}

/// Colour and marker of a setting: those of its method, unless it leaves out light of the target.
fn look_of(setting: &Setting, target: &Target) -> (RGBColor, Marker) {
    match setting.method {
        _ if setting.bounces < target.bounces => (RGBColor(70, 70, 70), Marker::Diamond),
        Method::Tracked if setting.traced_bounces > 0 => (RGBColor(86, 180, 233), Marker::Square),
        _ if setting.traced_bounces > 0 => (RGBColor(0, 158, 115), Marker::Up),
        Method::Single => (RGBColor(0, 114, 178), Marker::Circle),
        Method::Layered => (RGBColor(230, 159, 0), Marker::Square),
        Method::Exact => (RGBColor(0, 158, 115), Marker::Up),
        Method::SixFace => (RGBColor(204, 121, 167), Marker::Diamond),
        Method::Tracked => (RGBColor(213, 94, 0), Marker::Down),
    }
}

/// What the legend calls a setting.
fn title_of(setting: &Setting, target: &Target) -> String {
    let method = setting.method.name();
    if setting.bounces < target.bounces {
        format!("{method}, bounces = {}", setting.bounces)
    } else if setting.traced_bounces > 0 {
        format!("{method}, {} traced", setting.traced_bounces)
    } else {
        method
    }
}

/// The colour halfway to white.
fn faint(RGBColor(r, g, b): RGBColor) -> RGBColor {
    let mix = |channel: u8| (u16::from(channel) * 2 / 5 + 255 * 3 / 5) as u8;
    RGBColor(mix(r), mix(g), mix(b))
}

/// Line of a setting, and whether its markers are filled.
fn stroke_of(setting: &Setting, target: &Target) -> (Stroke, Marker, bool) {
    let (colour, marker) = look_of(setting, target);
    let is_random = setting.sampler == Sampler::Random;
    let stroke = Stroke {
        colour: if setting.shadows {
            colour
        } else {
            faint(colour)
        },
        width: 1.8,
        dash: is_random.then_some([5.0, 4.0]),
    };
    (stroke, marker, !is_random)
}

impl<'a> Plot<'a> {
    /// Of one preset and one target.
    pub fn new(preset: &'a str, conditions: &'a Conditions, findings: &'a Findings) -> Self {
        let points = summary::points(conditions, findings);
        let noise = findings.truth.noise;
        let [left, top, right, bottom] = FIELD;
        let axes = [
            Axis::new(points.iter().map(|point| point.cost), [left, right]),
            Axis::new(
                points.iter().map(|point| point.error).chain([noise]),
                [bottom, top],
            ),
        ];
        Self {
            preset,
            conditions,
            findings,
            points,
            axes,
        }
    }

    /// As SVG.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn svg(&self) -> anyhow::Result<String> {
        register()?;
        let mut text = String::new();
        let [width, height] = SIZE.map(|side| side as u32);
        {
            let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
            self.draw(&Canvas {
                area: &area,
                scale: 1.0,
                text_rise: 0.0,
            })?;
            draw(area.present())?;
        }
        Ok(text)
    }

    /// As PNG.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn png(&self) -> anyhow::Result<Vec<u8>> {
        register()?;
        let [width, height] = SIZE.map(|side| side as u32 * PNG_SCALE);
        let [drawn_width, drawn_height] = [width, height].map(|side| side * OVERSAMPLING);
        let mut pixels = vec![0; (drawn_width * drawn_height * 3) as usize];
        {
            let area = BitMapBackend::with_buffer(&mut pixels, (drawn_width, drawn_height))
                .into_drawing_area();
            self.draw(&Canvas {
                area: &area,
                scale: f64::from(PNG_SCALE * OVERSAMPLING),
                text_rise: 0.16,
            })?;
            draw(area.present())?;
        }
        let image = RgbImage::from_fn(width, height, |x, y| {
            image::Rgb([0, 1, 2].map(|c| {
                let inside = (0..OVERSAMPLING * OVERSAMPLING).map(|k| {
                    let (x, y) = (
                        x * OVERSAMPLING + k % OVERSAMPLING,
                        y * OVERSAMPLING + k / OVERSAMPLING,
                    );
                    u32::from(pixels[((y * drawn_width + x) * 3 + c) as usize])
                });
                (inside.sum::<u32>() / (OVERSAMPLING * OVERSAMPLING)) as u8
            }))
        });
        let mut file = Vec::new();
        image.write_with_encoder(PngEncoder::new_with_quality(
            &mut file,
            CompressionType::Best,
            FilterType::Adaptive,
        ))?;
        Ok(file)
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        draw(canvas.area.fill(&WHITE))?;
        self.titles(canvas)?;
        self.grid(canvas)?;
        self.front(canvas)?;
        self.noise(canvas)?;
        // The most important last, on top.
        for index in (0..self.findings.target.settings.len()).rev() {
            self.curve(canvas, index)?;
        }
        self.legend(canvas)
    }

    fn titles<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        let [left, _, right, bottom] = FIELD;
        let (conditions, findings) = (self.conditions, self.findings);
        let [width, height] = conditions.size;
        let title = format!("{}: {}", self.preset, findings.target.name());
        let above = (HPos::Left, VPos::Center);
        canvas.text(&title, [left, 22.0], 19.0, above, INK)?;
        let [a, b] = findings.truth.samples;
        let under = format!(
            "{width} × {height} pixels, {} ({}); truth: {}, {} samples",
            conditions.backend.name(),
            conditions.device,
            TRUTH.name(),
            a + b,
        );
        canvas.text(&under, [left, 45.0], 14.0, above, GREY)?;
        let x = if clock::cost_is_processor_time(conditions.backend) {
            "processor time of all cores [s]"
        } else {
            "time [s]"
        };
        let middle = (HPos::Center, VPos::Center);
        canvas.text(x, [(left + right) / 2.0, bottom + 46.0], 16.0, middle, INK)?;
        let style = canvas
            .text_style(16.0, HPos::Center, VPos::Center, INK)
            .transform(FontTransform::Rotate270);
        let at = canvas.point([22.0, (FIELD[1] + bottom) / 2.0]);
        draw(canvas.area.draw(&Text::new("error [relRMSE]", at, style)))
    }

    fn grid<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        let [left, top, right, bottom] = FIELD;
        // Fine lines under coarse ones.
        for coarse in [false, true] {
            let stroke = Stroke {
                colour: if coarse { GRID } else { FINE_GRID },
                width: 1.0,
                dash: None,
            };
            for (value, labelled) in self.axes[0].ticks() {
                if labelled == coarse {
                    let x = self.axes[0].place(value);
                    canvas.line(&[[x, top], [x, bottom]], stroke)?;
                }
            }
            for (value, labelled) in self.axes[1].ticks() {
                if labelled == coarse {
                    let y = self.axes[1].place(value);
                    canvas.line(&[[left, y], [right, y]], stroke)?;
                }
            }
        }
        for (value, _) in self.axes[0].ticks().into_iter().filter(|tick| tick.1) {
            let at = [self.axes[0].place(value), bottom + 17.0];
            canvas.text(&label(value), at, 14.0, (HPos::Center, VPos::Center), INK)?;
        }
        for (value, _) in self.axes[1].ticks().into_iter().filter(|tick| tick.1) {
            let at = [left - 9.0, self.axes[1].place(value)];
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

    /// The place of a point in the field.
    fn place(&self, point: &Point) -> [f64; 2] {
        [
            self.axes[0].place(point.cost),
            self.axes[1].place(point.error),
        ]
    }

    fn front<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        let front = pareto::front(&self.points);
        let mut line: Vec<[f64; 2]> = Vec::new();
        // Stairs: until the next point is paid for, the error is that of the last.
        for at in front.iter().map(|&index| self.place(&self.points[index])) {
            line.extend(line.last().map(|&[_, y]| [at[0], y]));
            line.push(at);
        }
        if line.len() > 1 {
            canvas.line(&line, FRONT_STROKE)?;
        }
        // Round ends and corners.
        for &at in &line {
            canvas.disc(at, 0.5 * FRONT_STROKE.width, FRONT_STROKE.colour)?;
        }
        Ok(())
    }

    fn noise<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        let y = self.axes[1].place(self.findings.truth.noise);
        canvas.line(&[[FIELD[0], y], [FIELD[2], y]], NOISE_STROKE)
    }

    fn curve<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>, index: usize) -> anyhow::Result<()> {
        let (stroke, marker, filled) =
            stroke_of(&self.findings.target.settings[index], &self.findings.target);
        let rows: Vec<usize> = (0..self.points.len())
            .filter(|&row| self.findings.rows[row].setting == index)
            .collect();
        let line: Vec<_> = rows
            .iter()
            .map(|&row| self.place(&self.points[row]))
            .collect();
        if line.len() > 1 {
            canvas.line(&line, stroke)?;
        }
        for (&row, &at) in rows.iter().zip(&line) {
            if self.findings.rows[row].error == Known::BelowNoise {
                canvas.line(
                    &below(at),
                    Stroke {
                        dash: None,
                        ..stroke
                    },
                )?;
            }
            canvas.marker(at, marker, stroke.colour, filled)?;
        }
        Ok(())
    }

    fn legend<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        let target = &self.findings.target;
        let mut y = FIELD[1] + 8.0;
        let mut entry = |text: &str, show: &dyn Fn(f64) -> anyhow::Result<()>| {
            show(y)?;
            canvas.text(
                text,
                [LEGEND + 46.0, y],
                14.5,
                (HPos::Left, VPos::Center),
                INK,
            )?;
            y += 24.0;
            anyhow::Ok(y)
        };
        let ends = |y: f64| [[LEGEND, y], [LEGEND + 36.0, y]];
        let sample = |setting: &Setting, y: f64| {
            let (stroke, marker, filled) = stroke_of(setting, target);
            canvas.line(&ends(y), stroke)?;
            canvas.marker([LEGEND + 18.0, y], marker, stroke.colour, filled)
        };
        let settings = &target.settings;
        let shown =
            |wanted: &dyn Fn(&Setting) -> bool| settings.iter().copied().find(|s| wanted(s));
        let is_drawn = |index: usize| self.findings.rows.iter().any(|row| row.setting == index);
        let whole = |s: &Setting| s.sampler == Sampler::Owen && s.shadows;
        for (index, setting) in settings.iter().enumerate() {
            if !(whole(setting) && is_drawn(index)) {
                continue;
            }
            entry(&title_of(setting, target), &|y| sample(setting, y))?;
        }
        entry("", &|_| Ok(()))?;
        if let Some(setting) = shown(&|s| s.sampler == Sampler::Random && s.shadows) {
            entry("random sampler", &|y| sample(&setting, y))?;
        }
        if let Some(setting) = shown(&|s| s.sampler == Sampler::Owen && !s.shadows) {
            entry("no shadow rays", &|y| sample(&setting, y))?;
        }
        entry("", &|_| Ok(()))?;
        entry("Pareto front", &|y| canvas.line(&ends(y), FRONT_STROKE))?;
        entry("noise of the truth", &|y| {
            canvas.line(&ends(y), NOISE_STROKE)
        })?;
        if self
            .findings
            .rows
            .iter()
            .any(|row| row.error == Known::BelowNoise)
        {
            entry("below that noise", &|y| {
                canvas.line(
                    &below([LEGEND + 18.0, y - 3.0]),
                    Stroke {
                        colour: GREY,
                        width: 1.8,
                        dash: None,
                    },
                )?;
                canvas.marker([LEGEND + 18.0, y - 3.0], Marker::Circle, GREY, true)
            })?;
        }
        let mut y = entry("", &|_| Ok(()))?;
        for line in [
            "Solid, filled: Owen sampler.",
            "From marker to marker the",
            "samples double, from 1 a pixel.",
        ] {
            canvas.text(line, [LEGEND, y], 13.5, (HPos::Left, VPos::Center), GREY)?;
            y += 19.0;
        }
        Ok(())
    }
}

const FRONT_STROKE: Stroke = Stroke {
    colour: FRONT,
    width: 9.0,
    dash: None,
};
const NOISE_STROKE: Stroke = Stroke {
    colour: GREY,
    width: 1.4,
    dash: Some([2.0, 4.0]),
};

/// A mark that says that a point lies somewhere below `at`.
fn below([x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    [[x, y], [x, y + 13.0]]
}
