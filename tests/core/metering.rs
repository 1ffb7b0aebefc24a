//! Exposure by a light meter: what it reads, what it makes white, and which files have one.

use std::f64::consts::PI;

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{
    AreaLight, Colour, Design, EnvironmentKind, EnvironmentReader, Metering, Sun, preset,
};
use renderer_core::image::Display;
use renderer_core::optics::environment_radiance;
use renderer_core::render::Backend;
use renderer_core::scene::{Lights, compile};

use crate::support::device::finish;
use crate::support::scenes::request;

/// A design under its environment alone.
fn under(edit: impl FnOnce(&mut Design)) -> Design {
    let mut design = Design::default();
    design.light.sun.clear();
    edit(&mut design);
    design
}

/// A picture of a bright window in the upper half, over a ground that must not count.
fn room() -> Design {
    under(|design| {
        let environment = &mut design.light.environment;
        environment.kind = EnvironmentKind::Image;
        environment.image = Some("room.hdr".into());
        let mut reader = EnvironmentReader::new(64, 32).unwrap();
        for y in 0..32 {
            for x in 0..64 {
                let window = if (4..10).contains(&y) && x < 20 {
                    6.0
                } else {
                    0.5
                };
                let value = if y < 16 { window } else { 40.0 };
                reader.add(x, y, [value, 0.5 * value, 0.25]);
            }
        }
        environment.pixels = Some(reader.finish().unwrap());
    })
}

/// ∫ L cos over the upper half of all directions, by the middle rule.
fn integrated(design: &Design) -> DVec3 {
    let lights = Lights::new(&design.light);
    let (rows, columns) = (400, 800);
    let mut sum = DVec3::ZERO;
    for row in 0..rows {
        // Equal steps of the squared sine: each has the same part of ∫ cos dω.
        let sine = ((f64::from(row) + 0.5) / f64::from(rows)).sqrt();
        for column in 0..columns {
            let angle = 2.0 * PI * (f64::from(column) + 0.5) / f64::from(columns);
            let direction = DVec3::new(
                sine * angle.cos(),
                sine * angle.sin(),
                (1.0 - sine * sine).sqrt(),
            );
            sum += environment_radiance(&lights, direction);
        }
    }
    sum * PI / f64::from(rows * columns)
}

#[test]
fn the_meter_reads_what_lights_a_level_plane() {
    let gradient = under(|design| design.light.environment.kind = EnvironmentKind::Gradient);
    let tinted = under(|design| design.light.environment.colour = Colour([200, 120, 40]));
    // Texels are flat for the meter and smooth for renderers: a border of the window is a texel wide.
    for (name, design, tolerance) in [
        ("gradient", gradient, 1e-4),
        ("constant", tinted, 1e-9),
        ("image", room(), 0.01),
    ] {
        let (expected, read) = (integrated(&design), design.light.level_irradiance());
        let difference = (DVec3::from_array(read) - expected).abs() / expected;
        assert!(
            difference.max_element() < tolerance,
            "{name}: {read:?}, not {expected}"
        );
    }

    let dark = || under(|design| design.light.environment.radiance = 0.0);
    let green = |design: &Design| design.light.level_irradiance()[1];
    let mut sun = dark();
    sun.light.sun = vec![Sun {
        elevation: 90.0,
        irradiance: 2.0,
        angular_diameter: 120.0,
        ..Sun::default()
    }];
    // MODEL.md §8: ¾ of a small sun's.
    assert!((green(&sun) - 1.5).abs() < 1e-12);
    sun.light.sun[0].elevation = 30.0;
    assert!((green(&sun) - 0.75).abs() < 1e-12);
    sun.light.sun[0].elevation = -30.0;
    assert_eq!(green(&sun), 0.0);
    assert_eq!(
        sun.metered_stops(),
        0.0,
        "dark above: nothing to make white"
    );
    let mut area = dark();
    area.light.area = vec![AreaLight {
        elevation: 30.0,
        irradiance: 2.0,
        ..AreaLight::default()
    }];
    assert!((green(&area) - 1.0).abs() < 1e-12);
}

#[test]
fn white_cloth_shows_as_white_and_the_background_in_its_colour_under_any_light() {
    let mut dim = Design::default();
    dim.light.environment.radiance = 0.05;
    dim.light.sun[0].irradiance = 0.1;
    for design in [Design::default(), dim, room()] {
        let display = Display::from(&design);
        let [r, g, b] = design.light.level_irradiance();
        // A level sheet that reflects what 16 bounces show of white terry, in the light's mean colour.
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let shown = display.encode([(0.48 * luminance / PI) as f32; 3])[0] * 255.0;
        assert!((shown - 221.0).abs() < 0.5, "{shown}");
        let lights = &compile(&design).unwrap().lights;
        let background = display.encode(lights.background.map(|c| c as f32));
        let background = background.map(|c| (c * 255.0).round() as u8);
        assert_eq!(background, design.light.background.0);
    }
    // Where fewer bounces are shown, less of the light counts as white.
    let mut paper = Design::default();
    paper.quality.bounces = 1;
    let brighter = (paper.exposure() - Design::default().exposure()).exp2();
    assert!((brighter - 0.48 / 0.11).abs() < 1e-9, "{brighter}");
    let mut brighter = Design::default();
    brighter.view.exposure = 1.0;
    assert_eq!(brighter.exposure(), Design::default().exposure() + 1.0);
    brighter.view.metering = Metering::None;
    assert_eq!(Display::from(&brighter).exposure, 1.0);
}

#[test]
fn a_file_with_an_exposure_alone_keeps_the_light_as_it_is() {
    let metering = |text: &str| preset::parse(text).unwrap().view.metering;
    assert_eq!(metering("format = 1"), Metering::Incident);
    assert_eq!(
        metering("format = 1\n[view]\ntone_map = 'filmic'"),
        Metering::Incident
    );
    assert_eq!(
        metering("format = 1\n[view]\nexposure = 0.0"),
        Metering::None
    );
    assert_eq!(metering("format = 1\nview.exposure = 1.5"), Metering::None);
    let both = "format = 1\n[view]\nexposure = 1.5\nmetering = 'incident'";
    assert_eq!(metering(both), Metering::Incident);
    // What is written has both.
    for metering in [Metering::Incident, Metering::None] {
        let mut design = Design::default();
        (design.view.metering, design.view.exposure) = (metering, 0.5);
        let text = preset::write(&design).unwrap();
        assert_eq!(preset::parse(&text).unwrap(), design);
    }
}

#[test]
fn the_default_towel_reads_as_white() {
    let design = Design::default();
    let mut request = request(&design, [48, 48]);
    request.settings.samples = 32;
    let picture = finish(&mut CpuBackend::default() as &mut dyn Backend, &request);
    let display = Display::from(&design);
    let mut shown: Vec<f64> = picture
        .pixels
        .iter()
        .filter(|pixel| pixel[3] > 0.99)
        .map(|&[r, g, b, _]| display.encode([r, g, b])[1] * 255.0)
        .collect();
    shown.sort_by(f64::total_cmp);
    let at = |share: f64| shown[(share * (shown.len() - 1) as f64) as usize];
    assert!((205.0..235.0).contains(&at(0.5)), "{}", at(0.5));
    assert!((225.0..=246.0).contains(&at(0.85)), "{}", at(0.85));
    // Against the light as it is, which was a grey towel.
    let mut grey = design.clone();
    grey.view.metering = Metering::None;
    assert!(Display::from(&grey).exposure < display.exposure - 0.5);
}
