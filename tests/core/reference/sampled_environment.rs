//! Skies with a small bright part, whose light tells where to look: what is drawn has the density it says, and pictures
//! are those of the same light that comes another way.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{
    Colour, Design, EnvironmentImage, EnvironmentKind, EnvironmentReader, Method, Phase,
    SkeletonShading, Sun,
};
use renderer_core::optics::environment_radiance;
use renderer_core::render::Backend;
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Lights, compile};

use super::sky::{all, assert_mean, half, look_at_yarn, one_yarn, picture};
use crate::agreement::{noisy, tracked};
use crate::support::closed::closed;
use crate::support::compare::{same_as_reference, same_means, shows_something};
use crate::support::device::{exact_gpu, finish, gpu, on_reference, reference, repeats};
use crate::support::scenes::{request as request_of, small_towel};

/// A unit vector at azimuth and elevation, degrees.
fn towards(azimuth: f64, elevation: f64) -> DVec3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    DVec3::new(
        azimuth.cos() * elevation.cos(),
        azimuth.sin() * elevation.cos(),
        elevation.sin(),
    )
}

/// A sky of radiance `around` with a disc of radiance `bright` in it, `degrees` wide.
fn sun_in_sky(width: usize, at: DVec3, degrees: f64, bright: f32, around: f32) -> EnvironmentImage {
    let edge = (0.5 * degrees).to_radians().cos();
    picture(width, |direction| {
        [if direction.dot(at) > edge {
            bright
        } else {
            around
        }; 3]
    })
}

fn lit_by(design: &mut Design, image: EnvironmentImage) {
    let environment = &mut design.light.environment;
    (environment.kind, environment.image) = (EnvironmentKind::Image, Some("sky.exr".into()));
    environment.radiance = 1.0;
    environment.pixels = Some(image);
}

/// Pictures of any size, an odd number of rows among them, and one that is all black.
fn pictures() -> Vec<EnvironmentImage> {
    let mut random = Pcg::new(3, 0);
    let mut all = Vec::new();
    for height in [1, 2, 3, 8, 31, 64] {
        for kind in 0..3 {
            let mut reader = EnvironmentReader::new(2 * height, height).unwrap();
            for y in 0..height {
                for x in 0..2 * height {
                    let value = match kind {
                        0 => random.next_float(),
                        1 => 1000.0 * random.next_float().powi(4),
                        _ => 0.0,
                    };
                    reader.add(x, y, [value, 0.5 * value, 0.0]);
                }
            }
            all.push(reader.finish().unwrap());
        }
    }
    all.push(sun_in_sky(256, towards(40.0, 30.0), 3.0, 5000.0, 1.0));
    all
}

#[test]
fn directions_have_the_density_they_say() {
    for image in pictures() {
        let light = image.light();
        let middle = 0.7;
        for below in [false, true] {
            let sign = if below { -1.0 } else { 1.0 };
            // Of all directions of the half, evenly: the density's mean times its solid angle is 1.
            let steps = 1024;
            let share = |k: usize| (k as f64 + 0.5) / f64::from(steps);
            let mut total = 0.0;
            let heights = 2048;
            for k in 0..heights {
                let fall = (k as f64 + 0.5) / heights as f64;
                for j in 0..steps as usize {
                    let (sine, cosine) = (TAU * share(j)).sin_cos();
                    let across = (fall * (2.0 - fall)).sqrt();
                    let up = sign * (1.0 - fall);
                    let direction = DVec3::new(across * cosine, across * sine, up);
                    total += light.density(direction, middle) * TAU;
                }
            }
            total /= heights as f64 * f64::from(steps);
            // A texel is some points wide at least, but next to the pole: there are few, of little light.
            assert!((total - 1.0).abs() < 0.05, "{image:?} {below}: {total}");

            // Of directions drawn by evenly spread numbers: means over the half, of 1 and of three functions of the
            // direction.
            let mut sums = [0.0; 4];
            for k in 0..steps as usize {
                for j in 0..steps as usize {
                    let numbers = [share(k) as f32, share(j) as f32];
                    let direction = light.direction(below, numbers, middle);
                    assert!(direction.is_normalized() && direction.z * sign >= 0.0);
                    let density = light.density(direction, middle);
                    assert!(density > 0.0, "{image:?} {direction}");
                    let DVec3 { x, y, z } = direction;
                    for (sum, of) in sums.iter_mut().zip([1.0, x * x, x * y, z]) {
                        *sum += of / density / f64::from(steps).powi(2);
                    }
                }
            }
            // ∫ x² = 2π/3, ∫ xy = 0, ∫ z = ±π over half a sphere.
            let expected = [TAU, TAU / 3.0, 0.0, sign * PI];
            for (sum, expected) in sums.iter().zip(expected) {
                // Dark texels have few points, of much weight: the mean of the darkest picture's is good to some
                // percent.
                assert!((sum - expected).abs() < 0.35, "{image:?} {below}: {sums:?}");
            }
        }
    }
}

#[test]
fn only_uneven_skies_are_drawn() {
    let is_drawn = |image: EnvironmentImage| image.light().is_uneven();
    assert!(!is_drawn(half(|_| true)));
    assert!(!is_drawn(half(|_| false)));
    assert!(!is_drawn(half(|d| d.z > 0.0)));
    assert!(!is_drawn(half(|d| d.x > 0.0)));
    // Overcast: three times as bright at the zenith as at the horizon (Moon and Spencer), over dark ground.
    assert!(!is_drawn(picture(128, |d| {
        [if d.z > 0.0 {
            1.0 + 2.0 * d.z as f32
        } else {
            0.1
        }; 3]
    })));
    assert!(is_drawn(half(|d| d.x > 0.0 && d.y > 0.0)));
    for elevation in [80.0, 10.0, -50.0] {
        let at = towards(20.0, elevation);
        assert!(is_drawn(sun_in_sky(256, at, 2.0, 3000.0, 1.0)));
    }
    // A weak sun in a bright sky is none; so is one below, if hardly any light comes from there.
    assert!(!is_drawn(sun_in_sky(256, DVec3::Z, 4.0, 20.0, 1.0)));
    assert!(!is_drawn(picture(256, |d| {
        let spot = d.dot(-DVec3::Z) > 0.999;
        [if d.z > 0.0 || spot { 1.0 } else { 1e-4 }; 3]
    })));
}

#[test]
fn a_small_sun_in_a_picture_lights_by_its_closed_form() {
    // The yarn is a warp: its top faces up, its side to +x.
    for (at, rotation) in [
        (towards(30.0, 55.0), 0.0),
        (towards(-20.0, 4.0), 0.0),
        (towards(100.0, 60.0), -90.0),
    ] {
        let mut design = one_yarn();
        lit_by(&mut design, sun_in_sky(512, at, 3.0, 1000.0, 0.1));
        design.light.environment.rotation = rotation;
        let scene = compile(&design).unwrap();
        assert!(scene.lights.sky.importance_table().is_some());
        for (name, mut backend, methods) in all() {
            for normal in [DVec3::Z, DVec3::X] {
                let expected =
                    f64::from(scene.skeleton.albedo[0]) / PI * irradiance(&scene.lights, normal);
                for &method in methods {
                    let request = look_at_yarn(scene.clone(), normal, method);
                    let picture = finish(&mut *backend, &request);
                    let what = format!("{at} turned by {rotation}°, {normal}, {name} {method:?}");
                    // By the phase alone 16 samples of 256 pixels would hit the sun three times: no such small
                    // deviation.
                    assert_mean(&what, &picture, 0, expected, 2e-3 * expected);
                }
            }
        }
    }
}

/// ∫ L cos over the hemisphere about `normal`, on a grid far finer than the picture's texels.
fn irradiance(lights: &Lights, normal: DVec3) -> f64 {
    let (rows, columns) = (2048, 4096);
    let mut sum = 0.0;
    for row in 0..rows {
        let (sine, cosine) = (PI * (f64::from(row) + 0.5) / f64::from(rows)).sin_cos();
        let area = sine * (PI / f64::from(rows)) * (TAU / f64::from(columns));
        for column in 0..columns {
            let (y, x) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
            let direction = DVec3::new(sine * x, sine * y, cosine);
            let facing = direction.dot(normal);
            if facing > 0.0 {
                sum += environment_radiance(lights, direction).x * facing * area;
            }
        }
    }
    sum
}

#[test]
fn all_backends_draw_the_same_samples_of_a_drawn_sky() {
    let (mut cpu, mut gpu) = (CpuBackend::default(), exact_gpu());
    let grounds = [
        SkeletonShading::Lambert,
        SkeletonShading::Phong,
        SkeletonShading::PoulinFournier,
    ];
    let cases = [
        (Method::Single, Phase::Isotropic, 1),
        (Method::Layered, Phase::FrameLambert, 0),
        (Method::Single, Phase::KajiyaKay, 0),
    ];
    for (index, (method, phase, traced_bounces)) in cases.into_iter().enumerate() {
        let mut design = small_towel();
        design.quality.method = method;
        if traced_bounces > 0 {
            design.quality.bounces = 8;
        }
        design.pile.phase = phase;
        design.skeleton.shading = grounds[index % 3];
        design.skeleton.specular = 0.4;
        let at = towards(-70.0, 40.0);
        let image = sun_in_sky(128, at, 12.0, 60.0, 0.2);
        lit_by(&mut design, image);
        design.light.environment.rotation = -35.0;
        let request = request_of(closed(&design, traced_bounces), [48, 40]);
        assert!(request.scene().lights.sky.importance_table().is_some());
        let expected = on_reference(&request);
        shows_something(&expected).unwrap();
        design.light.environment.rotation += 0.3;
        let turned = request_of(closed(&design, traced_bounces), [48, 40]);
        for backend in [&mut cpu as &mut dyn Backend, &mut gpu] {
            let name = backend.kind().name();
            same_as_reference(&request, &expected, &finish(backend, &request))
                .unwrap_or_else(|error| panic!("{name}, {method:?} {phase:?}: {error}"));
            let turned = finish(backend, &turned);
            assert!(same_as_reference(&request, &expected, &turned).is_err());
        }
    }
}

/// A towel lit by a sun alone.
fn sunny(edit: &dyn Fn(&mut Design)) -> (Design, Sun) {
    let mut design = tracked(small_towel(), 5);
    // Black, since of what has no noise the last digit counts.
    design.light.background = Colour([0; 3]);
    edit(&mut design);
    let sun = Sun {
        azimuth: 150.0,
        elevation: 40.0,
        irradiance: 3.0,
        angular_diameter: 16.0,
        ..Sun::default()
    };
    design.light.environment.radiance = 0.0;
    design.light.sun = vec![sun.clone()];
    (design, sun)
}

#[test]
fn a_sun_in_a_picture_is_a_sun_whatever_the_bounces() {
    // Light of an importance-sampled environment that came by the way on as well, or not at every scattering, would
    // make another picture.
    type Edit<'a> = (&'a str, &'a dyn Fn(&mut Design));
    let edits: [Edit<'_>; 1] = [("tracked", &|_| {})];
    for (what, edit) in edits {
        let (mut design, sun) = sunny(edit);
        let by_sun = repeats(&mut reference(), &noisy(request_of(&design, [16, 12])), 500);
        design.light.sun.clear();
        let image = sun_in_sky(
            1024,
            towards(sun.azimuth, sun.elevation),
            sun.angular_diameter,
            1.0,
            0.0,
        );
        lit_by(&mut design, image);
        // As bright on a plane that faces it, whatever texels make of its edge.
        let lights = Lights::new(&design.light);
        let facing = irradiance(&lights, towards(sun.azimuth, sun.elevation));
        let radiance = sun.irradiance / facing;
        for backend in [
            &mut reference() as &mut dyn Backend,
            &mut CpuBackend::default(),
            &mut gpu(),
        ] {
            let mut drawn = |radiance: f64| {
                design.light.environment.radiance = radiance;
                // What saves rays adds noise, in which a tenth more light would not show.
                let request = noisy(request_of(&design, [16, 12]));
                assert!(request.scene().lights.sky.importance_table().is_some());
                repeats(backend, &request, 900)
            };
            let (same, brighter) = (drawn(radiance), drawn(1.1 * radiance));
            let name = backend.kind().name();
            same_means(&by_sun, &same).unwrap_or_else(|error| panic!("{what}, {name}: {error}"));
            assert!(same_means(&by_sun, &brighter).is_err(), "{what}, {name}");
        }
    }
}

#[test]
fn a_drawn_sky_needs_no_shadows_to_be_counted_once() {
    // Nothing in the way and one scattering: the same mean as by a sun.
    let (mut design, sun) = sunny(&|d| {
        (d.quality.shadows, d.quality.bounces) = (false, 2);
    });
    let by_sun = repeats(&mut reference(), &request_of(&design, [16, 12]), 500);
    design.light.sun.clear();
    let at = towards(sun.azimuth, sun.elevation);
    lit_by(
        &mut design,
        sun_in_sky(1024, at, sun.angular_diameter, 1.0, 0.0),
    );
    let facing = irradiance(&Lights::new(&design.light), at);
    design.light.environment.radiance = sun.irradiance / facing;
    let request = request_of(&design, [16, 12]);
    for backend in [
        &mut reference() as &mut dyn Backend,
        &mut CpuBackend::default(),
        &mut gpu(),
    ] {
        let drawn = repeats(backend, &request, 900);
        same_means(&by_sun, &drawn)
            .unwrap_or_else(|error| panic!("{}: {error}", backend.kind().name()));
    }
}

#[test]
fn looking_by_light_and_by_the_phase_draw_the_same_picture() {
    // A part of the sky so wide that the phase finds it often, and light of several colours all around.
    let at = towards(60.0, 35.0);
    let image = picture(256, |d| {
        let spot = if d.dot(at) > 0.9 { 8.0 } else { 0.0 };
        [spot + 0.1, spot * 0.5 + 0.1 * d.z.max(0.0) as f32, 0.2]
    });
    for (method, bounces, phase) in [
        (Method::Tracked, 5, Phase::Isotropic),
        (Method::Tracked, 3, Phase::KajiyaKay),
        (Method::Single, 1, Phase::GradientLambert),
        (Method::Layered, 4, Phase::Isotropic),
    ] {
        let mut design = tracked(small_towel(), bounces);
        design.light.background = Colour([0; 3]);
        // So near that there is cloth in every block: one that is nearly black has too few bright samples for a mean.
        design.view.cameras[0].distance = 15.0;
        (design.quality.method, design.pile.phase) = (method, phase);
        design.light.sun.clear();
        let request = |design: &mut Design, image: EnvironmentImage| {
            lit_by(design, image);
            request_of(&*design, [16, 12])
        };
        let by_phase = request(&mut design, image.drawn_by_phase());
        let by_light = request(&mut design, image.clone());
        assert!(by_phase.scene().lights.sky.importance_table().is_none());
        assert!(by_light.scene().lights.sky.importance_table().is_some());
        let expected = repeats(&mut reference(), &by_phase, 40);
        for backend in [
            &mut reference() as &mut dyn Backend,
            &mut CpuBackend::default(),
            &mut gpu(),
        ] {
            let drawn = repeats(backend, &by_light, 4000);
            let name = backend.kind().name();
            same_means(&expected, &drawn)
                .unwrap_or_else(|error| panic!("{method:?} {phase:?}, {name}: {error}"));
        }
    }
}
