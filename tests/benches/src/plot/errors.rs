//! Run time against error as a picture: both axes logarithmic, a curve a setting, the Pareto front and the truth's
//! noise.

use plotters::prelude::{DrawingBackend, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, VPos};
use renderer_core::design::{Method, Sampler};
use renderer_core::render::Optimisation;
use towel_designer::clock;

use super::axis::Axis;
use super::canvas::{Canvas, Marker, Stroke, draw};
use super::field::{self, FIELD, LEGEND};
use super::{COLOURS, Figure, GREY, INK, MARKERS};
use crate::conditions::Conditions;
use crate::measure::{Findings, Row, points};
use crate::pareto::{self, Point};
use crate::plan::{Setting, TRUTH, Target};
use crate::truth::Known;

const FRONT: RGBColor = RGBColor(196, 196, 196);

/// Which settings a plot is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shows {
    /// Those that a user can choose.
    Choices,
    /// One method, the same without each optimisation, and both up to error targets.
    Optimisations,
}

impl Shows {
    /// Whether a plot has the setting of this index.
    fn has(self, target: &Target, index: usize) -> bool {
        let setting = &target.settings[index];
        match self {
            Self::Choices => setting.is_choice(),
            Self::Optimisations => target.settings.iter().any(|other| {
                other.without.is_some()
                    && *other
                        == Setting {
                            without: other.without,
                            to_error: other.to_error,
                            ..*setting
                        }
            }),
        }
    }
}

/// What is drawn.
#[derive(Debug)]
pub struct Plot<'a> {
    preset: &'a str,
    conditions: &'a Conditions,
    findings: &'a Findings,
    shows: Shows,
    /// Rows of the settings shown, and their points.
    rows: Vec<&'a Row>,
    points: Vec<Point>,
    axes: [Axis; 2],
}

/// Colour and marker of a setting: those of its method, unless it leaves out light of the target.
fn look_of(setting: &Setting, target: &Target) -> (RGBColor, Marker) {
    if let Some(optimisation) = setting.without {
        let index = Optimisation::ALL
            .iter()
            .position(|other| *other == optimisation);
        let index = index.unwrap_or_default();
        // Blue and its disc are those of `single`; nothing else is in the same plot.
        let colour = COLOURS[1 + index % (COLOURS.len() - 1)];
        return (colour, MARKERS[1 + index % (MARKERS.len() - 1)]);
    }
    match setting.method {
        _ if setting.to_error => (INK, Marker::Square),
        _ if setting.cached_shadows > 0 => (RGBColor(120, 94, 240), Marker::Diamond),
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
    if let Some(optimisation) = setting.without {
        return format!("without {optimisation}");
    }
    if setting.to_error {
        format!("{method}, up to an error")
    } else if setting.cached_shadows > 0 && setting.traced_bounces > 0 {
        format!("{method}, as the live view")
    } else if setting.cached_shadows > 0 {
        format!("{method}, {} cached", setting.cached_shadows)
    } else if setting.bounces < target.bounces {
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
    /// Of one preset and one target: everything that a user can choose.
    pub fn new(preset: &'a str, conditions: &'a Conditions, findings: &'a Findings) -> Self {
        Self::of(preset, conditions, findings, Shows::Choices)
    }

    /// One method with all optimisations and without each; `None` where no optimisation was measured.
    pub fn of_optimisations(
        preset: &'a str,
        conditions: &'a Conditions,
        findings: &'a Findings,
    ) -> Option<Self> {
        let settings = &findings.target.settings;
        settings
            .iter()
            .any(|setting| setting.without.is_some())
            .then(|| Self::of(preset, conditions, findings, Shows::Optimisations))
    }

    fn of(
        preset: &'a str,
        conditions: &'a Conditions,
        findings: &'a Findings,
        shows: Shows,
    ) -> Self {
        let is_shown = |row: &&Row| shows.has(&findings.target, row.setting);
        let rows: Vec<&Row> = findings.rows.iter().filter(is_shown).collect();
        let points = points(conditions, &rows, findings.truth.noise);
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
            shows,
            rows,
            points,
            axes,
        }
    }

    fn titles<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        let (conditions, findings) = (self.conditions, self.findings);
        let [width, height] = conditions.size;
        let without = match self.shows {
            Shows::Choices => "",
            Shows::Optimisations => ", with and without each optimisation",
        };
        let title = format!("{}: {}{without}", self.preset, findings.target.name());
        let [a, b] = findings.truth.samples;
        let under = format!(
            "{width} × {height} pixels, {} ({}); truth: {}, {} samples",
            conditions.backend.name(),
            conditions.device,
            TRUTH.name(),
            a + b,
        );
        field::titles(canvas, &title, &under)?;
        let x = if clock::cost_is_processor_time(conditions.backend) {
            "processor time of all cores [s]"
        } else {
            "time [s]"
        };
        field::axis_titles(canvas, [x, "error [relRMSE]"])
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
            .filter(|&row| self.rows[row].setting == index)
            .collect();
        let line: Vec<_> = rows
            .iter()
            .map(|&row| self.place(&self.points[row]))
            .collect();
        if line.len() > 1 {
            canvas.line(&line, stroke)?;
        }
        for (&row, &at) in rows.iter().zip(&line) {
            if self.rows[row].error == Known::BelowNoise {
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
        let is_drawn = |index: usize| self.rows.iter().any(|row| row.setting == index);
        let whole = |s: &Setting| s.sampler == Sampler::Owen && s.shadows;
        for (index, setting) in settings.iter().enumerate() {
            if !(whole(setting) && is_drawn(index)) {
                continue;
            }
            entry(&title_of(setting, target), &|y| sample(setting, y))?;
        }
        entry("", &|_| Ok(()))?;
        if self.shows == Shows::Choices {
            if let Some(setting) = shown(&|s| s.sampler == Sampler::Random && s.shadows) {
                entry("random sampler", &|y| sample(&setting, y))?;
            }
            if let Some(setting) = shown(&|s| s.sampler == Sampler::Owen && !s.shadows) {
                entry("no shadow rays", &|y| sample(&setting, y))?;
            }
            entry("", &|_| Ok(()))?;
        }
        entry("Pareto front", &|y| canvas.line(&ends(y), FRONT_STROKE))?;
        entry("noise of the truth", &|y| {
            canvas.line(&ends(y), NOISE_STROKE)
        })?;
        if self.rows.iter().any(|row| row.error == Known::BelowNoise) {
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
        let of_samples = [
            "Solid, filled: Owen sampler.",
            "From marker to marker the",
            "samples double, from 1 a pixel.",
        ];
        let of_targets = [
            "Squares: error targets, each the",
            "last by √2, each picture anew.",
        ];
        let has_targets = self.rows.iter().any(|row| row.wanted.is_some());
        let of_targets = of_targets.into_iter().filter(|_| has_targets);
        for line in of_samples.into_iter().chain(of_targets) {
            canvas.text(line, [LEGEND, y], 13.5, (HPos::Left, VPos::Center), GREY)?;
            y += 19.0;
        }
        Ok(())
    }
}

impl Figure for Plot<'_> {
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> anyhow::Result<()> {
        draw(canvas.area.fill(&WHITE))?;
        self.titles(canvas)?;
        field::grid(canvas, &self.axes)?;
        self.front(canvas)?;
        self.noise(canvas)?;
        // The most important last, on top.
        for index in (0..self.findings.target.settings.len()).rev() {
            if self.shows.has(&self.findings.target, index) {
                self.curve(canvas, index)?;
            }
        }
        self.legend(canvas)
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
