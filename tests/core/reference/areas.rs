//! Area lights on all backends: closed forms of what a rectangle brings, far ones against suns, the same samples.

use std::f64::consts::PI;

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{AreaLight, Colour, Design, Method, Phase, Sun};
use renderer_core::optics::Light;
use renderer_core::render::Backend;
use renderer_core::scene::{Lights, compile};

use super::cloth::{block, block_extent, edit_lights, edit_pile, needle_camera, request};
use super::sky::{all, assert_mean, look_at_yarn, one_yarn};
use crate::support::closed::closed;
use crate::support::compare::{same_as_reference, shows_something};
use crate::support::device::{exact_gpu, finish, on_reference};
use crate::support::scenes::{request as request_of, small_towel};

/// Light of radiance 1 from a rectangle: azimuth and elevation, distance, width and height. Its radiance follows from
/// the irradiance that a design asks for by the form that [`toward_plane`] has too; a slip in either shows.
fn area([azimuth, elevation, distance, width, height]: [f64; 5]) -> AreaLight {
    AreaLight {
        azimuth,
        elevation,
        distance,
        width,
        height,
        irradiance: 2.0,
        colour: Colour::WHITE,
    }
}

/// The corners of that light, one after another, seen from the origin; written from its description alone.
fn corners(light: &AreaLight) -> [DVec3; 4] {
    let (azimuth, elevation) = (light.azimuth.to_radians(), light.elevation.to_radians());
    let away = DVec3::new(
        azimuth.cos() * elevation.cos(),
        azimuth.sin() * elevation.cos(),
        elevation.sin(),
    );
    let level = DVec3::new(-azimuth.sin(), azimuth.cos(), 0.0);
    let other = away.cross(level);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
        away * light.distance + level * (0.5 * x * light.width) + other * (0.5 * y * light.height)
    })
}

/// Irradiance per radiance on a plane with this normal at `point`, the polygon being wholly above that plane: Lambert's
/// formula, half the sum over its sides of the angle that one subtends times the cosine of its own plane's normal.
fn toward_plane(corners: [DVec3; 4], point: DVec3, normal: DVec3) -> f64 {
    let seen = corners.map(|corner| (corner - point).normalize());
    assert!(seen.iter().all(|direction| direction.dot(normal) > 0.0));
    let sides = (0..4).map(|k| {
        let (a, b) = (seen[k], seen[(k + 1) % 4]);
        a.angle_between(b) * a.cross(b).normalize().dot(normal)
    });
    0.5 * sides.sum::<f64>().abs()
}

/// Solid angle of the rectangle, by its two triangles (Van Oosterom and Strackee 1983).
fn solid_angle(corners: [DVec3; 4], point: DVec3) -> f64 {
    let [a, b, c, d] = corners.map(|corner| (corner - point).normalize());
    let triangle = |a: DVec3, b: DVec3, c: DVec3| {
        let above = a.dot(b.cross(c)).abs();
        2.0 * above.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    };
    triangle(a, b, c) + triangle(a, c, d)
}

/// Radiance of a light, of which its design tells the irradiance in the cloth's middle.
fn radiance(light: &AreaLight) -> f64 {
    let corners = corners(light);
    let towards = (corners[0] + corners[2]).normalize();
    light.irradiance / toward_plane(corners, DVec3::ZERO, towards)
}

/// Near and far, square and long, from above and from the side: azimuth, elevation, distance, width, height.
const LIGHTS: [[f64; 5]; 5] = [
    [30.0, 90.0, 12.0, 20.0, 8.0],
    [0.0, 60.0, 15.0, 12.0, 10.0],
    [200.0, 45.0, 11.0, 3.0, 14.0],
    [-75.0, 50.0, 400.0, 300.0, 200.0],
    [120.0, 35.0, 90_000.0, 9_000.0, 1.0],
];

#[test]
fn a_lambertian_point_has_the_form_factor() {
    let mut design = one_yarn();
    design.light.environment.radiance = 0.0;
    for (name, mut backend, methods) in all() {
        for numbers in LIGHTS {
            let light = area(numbers);
            design.light.area = vec![light.clone()];
            let scene = compile(&design).unwrap();
            let point = DVec3::new(0.0, 0.28, 0.22);
            let irradiance = radiance(&light) * toward_plane(corners(&light), point, DVec3::Z);
            let albedo = f64::from(scene.skeleton.albedo[0]);
            let expected = albedo * irradiance / PI;
            for &method in methods {
                let request = look_at_yarn(scene.clone(), DVec3::Z, method);
                let picture = finish(&mut *backend, &request);
                let what = format!("{numbers:?}, {name} {method:?}");
                assert_mean(&what, &picture, 0, expected, 1e-4);
            }
        }
    }
}

#[test]
fn a_point_that_scatters_equally_takes_the_solid_angle() {
    // So dense that all scatter at the block's face, and nothing shades.
    let mut scene = block(1);
    edit_pile(&mut scene, |pile| pile.materials[0].density_per_mm = 2000.0);
    let (middle, half) = block_extent(&scene);
    let point = middle + DVec3::new(half.x, 0.0, 0.0);
    for (name, mut backend, methods) in all() {
        for numbers in LIGHTS {
            let light = area(numbers);
            let lights = Design {
                light: renderer_core::design::Light {
                    area: vec![light.clone()],
                    ..Design::default().light
                },
                ..Design::default()
            };
            let mut scene = scene.clone();
            let areas = Lights::new(&lights.light).areas;
            edit_lights(&mut scene, |lights| lights.areas = areas);
            let expected = radiance(&light) * solid_angle(corners(&light), point) / (4.0 * PI);
            for &method in methods {
                let mut request = request(scene.clone(), method, 1);
                request.view.levels.nearest.camera = needle_camera(middle, DVec3::X);
                (request.size, request.crop) = ([16, 16], [0, 0, 16, 16]);
                request.settings.samples = 16;
                request.settings.shadows = false;
                let picture = finish(&mut *backend, &request);
                let what = format!("{numbers:?}, {name} {method:?}");
                // `single` scatters in the middle of the crossing's light, `layered` in its only layer's: at half a
                // thickness.
                let moved = point - DVec3::new(half.x, 0.0, 0.0);
                let other = radiance(&light) * solid_angle(corners(&light), moved) / (4.0 * PI);
                assert_mean(
                    &what,
                    &picture,
                    0,
                    expected,
                    1e-3 + (expected - other).abs(),
                );
            }
        }
    }
}

#[test]
fn a_small_light_far_away_is_a_sun() {
    let (mut cpu, mut gpu) = (CpuBackend::default(), exact_gpu());
    for method in [Method::Single, Method::Layered] {
        let mut design = small_towel();
        design.quality.method = method;
        design.light.sun = vec![Sun {
            angular_diameter: 0.0,
            ..Sun::default()
        }];
        let request = request_of(&design, [48, 40]);
        let expected = on_reference(&request);
        shows_something(&expected).unwrap();
        let Sun {
            azimuth,
            elevation,
            irradiance,
            ..
        } = design.light.sun[0];
        let mut with_area = |irradiance: f64| {
            design.light.sun.clear();
            design.light.area = vec![AreaLight {
                azimuth,
                elevation,
                irradiance,
                distance: 100_000.0,
                width: 1.0,
                height: 1.0,
                ..AreaLight::default()
            }];
            request_of(&design, [48, 40])
        };
        let (same, brighter) = (with_area(irradiance), with_area(irradiance * 1.01));
        // The cloth is 10 mm wide: directions and distances differ by 10⁻⁴.
        for backend in [&mut cpu as &mut dyn Backend, &mut gpu] {
            let name = backend.kind().name();
            let drawn = finish(backend, &same);
            same_as_reference(&request, &expected, &drawn)
                .unwrap_or_else(|error| panic!("{name} {method:?}: {error}"));
            let drawn = finish(backend, &brighter);
            assert!(same_as_reference(&request, &expected, &drawn).is_err());
        }
    }
}

#[test]
fn all_backends_draw_the_same_samples_under_area_lights() {
    let (mut cpu, mut gpu) = (CpuBackend::default(), exact_gpu());
    for (method, phase, traced_bounces) in [
        (Method::Single, Phase::Isotropic, 0),
        (Method::Layered, Phase::FrameLambert, 0),
        (Method::Single, Phase::KajiyaKay, 1),
    ] {
        let mut design = small_towel();
        design.quality.method = method;
        if traced_bounces > 0 {
            design.quality.bounces = 8;
        }
        design.pile.phase = phase;
        // With a sun, so that lights are told apart by their numbers.
        design.light.area = [
            [200.0, 35.0, 40.0, 30.0, 50.0],
            [20.0, 80.0, 30.0, 20.0, 20.0],
            [-60.0, -40.0, 60.0, 30.0, 10.0],
        ]
        .map(area)
        .to_vec();
        design.light.area[1].colour = Colour([255, 80, 0]);
        let request = request_of(closed(&design, traced_bounces), [48, 40]);
        let expected = on_reference(&request);
        shows_something(&expected).unwrap();
        design.light.area[0].distance *= 1.05;
        let moved = request_of(closed(&design, traced_bounces), [48, 40]);
        for backend in [&mut cpu as &mut dyn Backend, &mut gpu] {
            let name = backend.kind().name();
            same_as_reference(&request, &expected, &finish(backend, &request))
                .unwrap_or_else(|error| panic!("{name}, {method:?} {phase:?}: {error}"));
            let moved = finish(backend, &moved);
            assert!(same_as_reference(&request, &expected, &moved).is_err());
        }
    }
}

#[test]
fn a_light_shines_on_one_side() {
    let light = area([0.0, 90.0, 10.0, 4.0, 4.0]);
    let design = renderer_core::design::Light {
        sun: Vec::new(),
        area: vec![light],
        ..Design::default().light
    };
    let lights = Lights::new(&design);
    let (light, _) = Light::of(&lights, 0, 1).expect("the light");
    assert!(Light::of(&lights, 1, 1).is_none());
    let at = |z: f64| light.towards(DVec3::new(0.0, 0.0, z), [0.5, 0.5]);
    let (direction, before) = at(9.0);
    assert!(direction.distance(DVec3::Z) < 1e-12, "{direction}");
    assert!(before.x > 0.0);
    for z in [10.000_1, 11.0] {
        let (direction, behind) = at(z);
        assert!(direction.is_normalized() && behind == DVec3::ZERO, "{z}");
    }
}

#[test]
fn a_light_in_the_cloth_is_refused_and_one_that_touches_it_is_drawn() {
    for (azimuth, elevation) in [(0.0, 90.0), (35.0, 0.0), (-120.0, 20.0), (90.0, -60.0)] {
        let mut design = small_towel();
        (design.sheet.warps, design.sheet.wefts) = (60, 20);
        design.length.value = 8.0;
        let nearest = design.nearest_area_mm(azimuth, elevation);
        let light = AreaLight {
            distance: nearest,
            ..area([azimuth, elevation, 0.0, 500.0, 500.0])
        };
        design.light.area = vec![light];
        assert_eq!(design.faults(), [], "{azimuth} {elevation}");
        let request = request_of(&design, [16, 12]);
        let gpu: &mut dyn Backend = &mut exact_gpu();
        for backend in [&mut CpuBackend::default() as &mut dyn Backend, gpu] {
            let picture = finish(backend, &request);
            let finite = |pixel: &[f32; 4]| pixel.iter().all(|value| value.is_finite());
            assert!(picture.pixels.iter().all(finite));
        }
        // All of the cloth is before it.
        let plane = corners(&design.light.area[0])[0];
        let facing = -(corners(&design.light.area[0])[2] + plane).normalize();
        let [low, high] = renderer_core::render::cloth_box(request.scene());
        for k in 0..8 {
            let side = |axis: usize| {
                if k >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            let corner = DVec3::new(side(0), side(1), side(2));
            assert!((corner - plane).dot(facing) > 0.0, "{corner}");
        }
        design.light.area[0].distance -= 1.0;
        let message = compile(&design).unwrap_err().to_string();
        let expected = format!(
            "light.area[0].distance is {}, allowed is at least {nearest} mm from azimuth {azimuth}°",
            nearest - 1.0
        );
        assert!(message.contains(&expected), "{message}");
    }
    let mut design = small_towel();
    design.light.area = vec![AreaLight {
        width: 0.0,
        ..AreaLight::default()
    }];
    let message = compile(&design).unwrap_err().to_string();
    let expected = "light.area[0].width is 0, allowed is 1 to 100000 mm";
    assert!(message.contains(expected), "{message}");
    design.light.area = vec![AreaLight::default(); 5];
    let message = compile(&design).unwrap_err().to_string();
    let expected = "light.area is 5 area lights, allowed is at most 4 area lights";
    assert!(message.contains(expected), "{message}");
}
