//! What the same cloth costs in other light, bent in other ways, with pile of other kinds and after what is done to it:
//! a sample's time, the noise of some samples, and from both the time to a given noise.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;
use std::time::{Duration, Instant};

use renderer_core::design::{
    AreaLight, ChartImage, Colour, Design, Environment, EnvironmentImage, EnvironmentKind,
    EnvironmentReader, Finish, Fit, Form, FormKind, HeightImage, LengthEntry, LengthMap, Light,
    Phase, PileKind, Sheared, Sun, nap_edit,
};
use renderer_core::render::Backend;
use renderer_core::scene::{Compiler, net_through};
use towel_designer::clock::{Spent, cost_is_processor_time};
use towel_designer::designer::panels::LightPreset;

use crate::conditions::Conditions;
use crate::csv::{OfPresets, number, optional, quoted, table};
use crate::drawing::{self, draw};
use crate::units::seconds;

/// Pixels along each side of the height picture.
const HILL: usize = 64;
/// Samples of each picture.
const SAMPLES: u32 = 32;
/// The noise to which the time is reported, relRMSE.
const WANTED: f64 = 0.05;
/// How long a picture may take even where there is no time.
const LONGEST: Duration = Duration::from_secs(2);

/// A light, a form or a pile, and what became of measuring it.
#[derive(Debug, Clone)]
pub struct VariantRow {
    /// Which.
    pub name: &'static str,
    /// What was found, or why nothing was.
    pub found: Result<Found, String>,
}

/// What a picture of that costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// One sample.
    pub sample: Spent,
    /// relRMSE of 32 of them, as the backend estimates it.
    pub noise: f64,
}

impl Found {
    /// Seconds until the noise is [`WANTED`], by the clock of costs.
    fn to_wanted(self, conditions: &Conditions) -> f64 {
        let one = match self.sample.processor {
            Some(time) if cost_is_processor_time(conditions.backend) => time,
            _ => self.sample.wall,
        };
        one.as_secs_f64() * f64::from(SAMPLES) * (self.noise / WANTED).powi(2)
    }
}

/// The preset in its own light, then in each kind alone, then in the lights that the designer has ready.
pub fn lights(design: &Design) -> Vec<(&'static str, Design)> {
    let lit = |(name, light)| {
        let design = Design {
            light,
            ..design.clone()
        };
        (name, design)
    };
    let ready = LightPreset::ALL.map(|ready| (ready.name(), ready.applied_to(design)));
    each_light(design)
        .into_iter()
        .chain(ready)
        .map(lit)
        .collect()
}

/// The preset's cloth level, then bent in each way, as long as it is for its pile.
pub fn forms(design: &Design) -> Vec<(&'static str, Design)> {
    let pile = design.reach_mm();
    let bent = |name, form| {
        let design = Design {
            form,
            ..design.clone()
        };
        (name, design)
    };
    let of_kind = |kind| Form {
        kind,
        radius: 2.0 * pile,
        wavelength: 40.0 * pile,
        layers: 2,
        ..Form::default()
    };
    let width = f64::from(design.sheet.warps) * design.sheet.pitch_x();
    let length = f64::from(design.sheet.wefts) * design.sheet.pitch_y();
    let level_net = Form {
        kind: FormKind::Net,
        net: net_through([4, 4], |across, along| {
            [width * (across - 0.5), length * (along - 0.5), 0.0]
        }),
        ..Form::default()
    };
    // A hill in the middle, as high as the pile.
    let hill = |index: usize| {
        let [x, y] = [index % HILL, index / HILL].map(|at| (at as f64 + 0.5) / HILL as f64 * TAU);
        let share = 0.25 * (1.0 - x.cos()) * (1.0 - y.cos());
        (share * f64::from(u16::MAX)) as u16
    };
    let picture = Form {
        kind: FormKind::Height,
        height: pile,
        smooth: pile.max(Form::FIELDS.smooth.min),
        image: Some("bench".into()),
        pixels: HeightImage::new(HILL, HILL, (0..HILL * HILL).map(hill).collect()),
        ..Form::default()
    };
    vec![
        bent("level", Form::default()),
        bent("a net that leaves it level", level_net),
        bent("waves", of_kind(FormKind::Wave)),
        bent("rolled up", of_kind(FormKind::Roll)),
        bent("over a rail", of_kind(FormKind::Hanging)),
        bent("a stack of two layers", of_kind(FormKind::Stack)),
        bent("a hill by a height picture", picture),
    ]
}

/// The preset's own pile, then all of it of each other kind, then cloth whose chart sets the pile of each loop, then
/// what is done to its own.
pub fn piles(design: &Design) -> Vec<(&'static str, Design)> {
    let own = || design.clone();
    let mut all = vec![("the preset's own", own())];
    for &kind in PileKind::ALL {
        let mut design = own();
        design.pile.kind = kind;
        design
            .length
            .table
            .iter_mut()
            .for_each(|row| row.kind = None);
        if design != own() {
            all.push((kind.label(), design));
        }
    }
    all.push(("a kind, lean and material by colour", by_colour(design)));
    let mut done = |name, change: &dyn Fn(&mut Design)| {
        let mut design = own();
        design.finish = Finish::default();
        change(&mut design);
        all.push((name, design));
    };
    done("shorn on the front", &|design| {
        design.finish.sheared = Sheared::Front;
        let least = Finish::FIELDS.shear_height.min;
        design.finish.shear_height = (0.6 * design.length.longest()).max(least);
    });
    done("a tenth of it pulled", &|design| design.finish.pulled = 0.1);
    done("soaked", &|design| design.finish.wetness = 1.0);
    done("combed in lanes", &|design| {
        let upright = nap_edit::upright(&design.sheet);
        design.nap.pixels = upright.map(|map| nap_edit::stripes(&map, &design.sheet));
    });
    all
}

/// The preset's cloth under a chart of squares in three colours, each of which has pile of its own.
fn by_colour(design: &Design) -> Design {
    const COLOURS: [[u8; 3]; 3] = [[200, 60, 40], [240, 230, 210], [40, 70, 120]];
    const SQUARE: usize = 8;
    const SIDE: usize = 3 * SQUARE;
    let texel = |k: usize| {
        let [r, g, b] = COLOURS[(k % SIDE / SQUARE + k / SIDE / SQUARE) % 3];
        [r, g, b, 255]
    };
    let texels: Vec<[u8; 4]> = (0..SIDE * SIDE).map(texel).collect();
    let mut design = design.clone();
    design.chart.image = Some("bench".into());
    design.chart.pixels = ChartImage::new(SIDE, SIDE, &texels);
    design.chart.fit = Fit::Tile;
    let length = design.length.longest();
    let row = |index: usize| LengthEntry {
        colour: Colour(COLOURS[index]),
        length: length * (1.0 - 0.2 * index as f64),
        ..LengthEntry::default()
    };
    design.length.map = LengthMap::Lut;
    design.length.table = vec![
        LengthEntry {
            kind: Some(PileKind::Cut),
            phase: Some(Phase::KajiyaKay),
            ..row(0)
        },
        LengthEntry {
            kind: Some(PileKind::Twisted),
            lean_y: Some(25.0),
            ..row(1)
        },
        row(2),
    ];
    design
}

/// The preset's own light, then each kind alone.
fn each_light(design: &Design) -> Vec<(&'static str, Light)> {
    let (azimuth, elevation, irradiance) = (130.0, 50.0, 3.0);
    let alone = |sun, area, environment| Light {
        sun,
        area,
        environment,
        ..design.light.clone()
    };
    let dark = Environment {
        radiance: 0.0,
        ..Environment::default()
    };
    let sun = |angular_diameter| Sun {
        azimuth,
        elevation,
        irradiance,
        angular_diameter,
        ..Sun::default()
    };
    let distance = (2.0 * design.nearest_area_mm(azimuth, elevation)).max(10.0);
    let area = AreaLight {
        azimuth,
        elevation,
        irradiance,
        distance,
        width: distance,
        height: distance,
        ..AreaLight::default()
    };
    let picture = |pixels: Option<EnvironmentImage>| {
        let environment = Environment {
            kind: EnvironmentKind::Image,
            image: Some("bench".into()),
            radiance: 1.0,
            pixels,
            ..Environment::default()
        };
        alone(Vec::new(), Vec::new(), environment)
    };
    let gradient = Environment {
        kind: EnvironmentKind::Gradient,
        radiance: 1.0,
        ..Environment::default()
    };
    let sunny = sky(Some((azimuth, elevation, irradiance)));
    let by_phase = sunny.as_ref().map(EnvironmentImage::drawn_by_phase);
    vec![
        ("the preset's own", design.light.clone()),
        (
            "a small sun",
            alone(vec![sun(0.5)], Vec::new(), dark.clone()),
        ),
        (
            "three suns around it",
            alone(
                [[255, 120, 90], [120, 255, 140], [110, 140, 255]]
                    .into_iter()
                    .zip([0.0, 120.0, 240.0])
                    .map(|(colour, turn)| Sun {
                        azimuth: turn - 90.0,
                        elevation: 25.0,
                        irradiance: irradiance / 3.0,
                        colour: Colour(colour),
                        ..sun(6.0)
                    })
                    .collect(),
                Vec::new(),
                dark.clone(),
            ),
        ),
        ("an area light", alone(Vec::new(), vec![area], dark)),
        ("a gradient", alone(Vec::new(), Vec::new(), gradient)),
        ("an overcast picture", picture(sky(None))),
        ("a picture with a sun", picture(sunny)),
        ("the same, looked at by the phase alone", picture(by_phase)),
    ]
}

/// A sky three times as bright at the zenith as at the horizon, over dark ground, and maybe with a sun 2° wide in it.
fn sky(sun: Option<(f64, f64, f64)>) -> Option<EnvironmentImage> {
    const HEIGHT: usize = 256;
    let edge = 1.0_f64.to_radians();
    let mut reader = EnvironmentReader::new(2 * HEIGHT, HEIGHT).ok()?;
    for y in 0..HEIGHT {
        let (across, up) = (PI * (y as f64 + 0.5) / HEIGHT as f64).sin_cos();
        let overcast = if up > 0.0 { 0.3 + 0.6 * up } else { 0.1 };
        for x in 0..2 * HEIGHT {
            let azimuth = FRAC_PI_2 + PI - TAU * (x as f64 + 0.5) / (2 * HEIGHT) as f64;
            let mut light = overcast;
            if let Some((sun_azimuth, elevation, irradiance)) = sun {
                let (sine, cosine) = f64::to_radians(elevation).sin_cos();
                let turned = (azimuth - f64::to_radians(sun_azimuth)).cos();
                let facing = across * cosine * turned + up * sine;
                if facing > edge.cos() {
                    light += irradiance / (PI * edge.sin().powi(2));
                }
            }
            reader.add(x, y, [light as f32; 3]);
        }
    }
    reader.finish().ok()
}

/// Draws each design. One that has no room for its form is reported, not measured.
///
/// # Errors
/// When the backend fails.
pub fn measure(
    all: Vec<(&'static str, Design)>,
    backend: &mut dyn Backend,
    conditions: &Conditions,
    deadline: Instant,
    mut say: impl FnMut(&str),
) -> anyhow::Result<Vec<VariantRow>> {
    let mut compiler = Compiler::default();
    let mut lines = Vec::new();
    let count = all.len() as u32;
    for (index, (name, design)) in (0..).zip(all) {
        say(name);
        let left = deadline.saturating_duration_since(Instant::now());
        let until = Instant::now() + (left / (count - index)).max(LONGEST);
        let scene = match compiler.compile(&design) {
            Ok(scene) => scene,
            Err(error) => {
                let found = Err(error.to_string());
                lines.push(VariantRow { name, found });
                continue;
            }
        };
        let request = drawing::request(&design, &scene, conditions.size, SAMPLES)?;
        let drawn = draw(backend, &request, Some(until))?;
        let found = drawn.ok_or("time was up").and_then(|drawn| {
            let noise = drawn.estimate.ok_or("its noise is not known")?;
            let sample = drawing::per_sample(drawn.samples, SAMPLES);
            Ok(Found { sample, noise })
        });
        lines.push(VariantRow {
            name,
            found: found.map_err(String::from),
        });
    }
    Ok(lines)
}

const COLUMNS: &str = "measured,clock time of a sample [s],processor time of a sample [s],samples,\
    noise of these [relRMSE],time to a noise of 0.05 [s]";

/// The file of `what`: light, form or pile.
pub fn csv(what: &str, all: &OfPresets<'_, [VariantRow]>, conditions: &Conditions) -> String {
    let header = format!("preset,{what},{COLUMNS}");
    let lines = all
        .iter()
        .flat_map(|(preset, lines)| lines.iter().map(move |line| (preset, line)));
    let line = |(preset, line): (&&str, &VariantRow)| {
        let mut fields = vec![quoted(preset), quoted(line.name)];
        match &line.found {
            Err(why) => {
                fields.push(quoted(&format!("no: {why}")));
                fields.resize(header.split(',').count(), String::new());
            }
            Ok(found) => fields.extend([
                "yes".into(),
                number(found.sample.wall.as_secs_f64()),
                optional(found.sample.processor.map(|time| time.as_secs_f64())),
                SAMPLES.to_string(),
                number(found.noise),
                number(found.to_wanted(conditions)),
            ]),
        }
        fields.join(",")
    };
    table(&header, lines.map(line))
}

/// The section of the summary.
pub fn section(what: &str, lines: &[VariantRow], conditions: &Conditions) -> String {
    let mut text = format!(
        "\n| {what} | a sample, by the clock | processor time | noise of {SAMPLES} samples | time to a noise of \
            {WANTED} |\n\
         | --- | --- | --- | --- | --- |\n",
    );
    for line in lines {
        let rest = match &line.found {
            Err(why) => format!("not measured: {why} | | | "),
            Ok(found) => format!(
                "{} | {} | {:.4} | {}",
                seconds(found.sample.wall.as_secs_f64()),
                (found.sample.processor)
                    .map_or_else(|| "–".into(), |time| seconds(time.as_secs_f64())),
                found.noise,
                seconds(found.to_wanted(conditions)),
            ),
        };
        let _ = writeln!(text, "| {} | {rest} |", line.name);
    }
    text
}
