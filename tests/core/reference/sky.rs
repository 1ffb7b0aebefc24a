//! Light from all around that varies with direction: closed forms of which side it lights, on all backends.

use std::f64::consts::{LN_2, PI, TAU};

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{
    Colour, Design, EnvironmentImage, EnvironmentKind, EnvironmentReader, Method, Pattern, Phase,
};
use renderer_core::gpu::GpuBackend;
use renderer_core::image::Picture;
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::scene::{Scene, Sky, compile};

use super::cloth::{block, block_extent, edit_lights, edit_pile, needle_camera, request};
use crate::support::compare::{same_samples, shows_something};
use crate::support::device::{exact_gpu, finish, gpu, on_reference, reference};
use crate::support::scenes::{request as request_of, small_towel};

/// A picture of the surroundings made from directions: row 0 at the zenith, the middle towards +y, azimuths falling
/// from left to right, as one sees who stands on the cloth and looks over its far edge.
pub fn picture(width: usize, light: impl Fn(DVec3) -> [f32; 3]) -> EnvironmentImage {
    let height = width / 2;
    let mut reader = EnvironmentReader::new(width, height).unwrap();
    for y in 0..height {
        let (across, up) = (PI * (y as f64 + 0.5) / height as f64).sin_cos();
        for x in 0..width {
            let azimuth = PI / 2.0 + PI - TAU * (x as f64 + 0.5) / width as f64;
            let (sine, cosine) = azimuth.sin_cos();
            reader.add(x, y, light(DVec3::new(across * cosine, across * sine, up)));
        }
    }
    reader.finish().unwrap()
}

/// White on one side, black on the other; fine enough that the blend at the border is nothing (10⁻⁵ of the light).
pub fn half(white: impl Fn(DVec3) -> bool) -> EnvironmentImage {
    picture(256, |direction| [f32::from(u8::from(white(direction))); 3])
}

/// A part of all directions that is white.
type Side = (&'static str, fn(DVec3) -> bool);
const RIGHT: Side = ("right", |d| d.x > 0.0);
const LEFT: Side = ("left", |d| d.x < 0.0);
const ABOVE: Side = ("above", |d| d.z > 0.0);
const BELOW: Side = ("below", |d| d.z < 0.0);
const FAR: Side = ("far", |d| d.y > 0.0);
const FAR_RIGHT: Side = ("far right", |d| d.x > 0.0 && d.y > 0.0);

/// A straight white warp of radius 0.22 mm along y, and next to nothing else.
pub fn one_yarn() -> Design {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (1, 1);
    design.weave.pattern = Pattern::filled(1, 1, 1);
    (design.skeleton.crimp, design.skeleton.weft_radius) = (0.0, 0.005);
    design.skeleton.colour = Colour::WHITE;
    design.light.sun.clear();
    design.light.environment.radiance = 1.0;
    // No loop stands; their volumes need not be large.
    let pile = &mut design.pile;
    (pile.variants, pile.layers, pile.resolution, pile.fibres) = (1, 1, 4, 1);
    design
}

/// 16 × 16 pixels that all see the yarn's point whose normal is `normal`, away from the weft.
pub fn look_at_yarn(scene: Scene, normal: DVec3, method: Method) -> RenderRequest {
    let mut request = request(scene, method, 1);
    request.view.levels.nearest.camera =
        needle_camera(DVec3::new(0.0, 0.28, 0.0) + 0.22 * normal, normal);
    (request.size, request.crop) = ([16, 16], [0, 0, 16, 16]);
    request.settings.samples = 16;
    request
}

/// Mean of a channel, and the deviation of that mean; pixels are independent.
fn mean(picture: &Picture, channel: usize) -> (f64, f64) {
    let values = || picture.pixels.iter().map(|pixel| f64::from(pixel[channel]));
    let count = picture.pixels.len() as f64;
    let mean = values().sum::<f64>() / count;
    let squares: f64 = values().map(|value| (value - mean).powi(2)).sum();
    (mean, squares.sqrt() / count)
}

/// Requires the mean of a picture to be as expected: 4.5 deviations fail a right picture in 10⁵, `bias` is the
/// picture's own.
pub fn assert_mean(what: &str, picture: &Picture, channel: usize, expected: f64, bias: f64) {
    let (mean, deviation) = mean(picture, channel);
    assert!(
        (mean - expected).abs() < 4.5 * deviation + bias,
        "{what}: {mean} ± {deviation}, not {expected}"
    );
    assert!(deviation < 0.02, "{what} tells nothing: ± {deviation}");
}

/// All backends, and the methods that each is asked for: every one of the reference and of the processor, on the GPU
/// one of each program.
pub fn all() -> [(&'static str, Box<dyn Backend>, &'static [Method]); 3] {
    let gpu: GpuBackend = gpu();
    let fast = &[Method::Single, Method::Layered, Method::Tracked];
    [
        ("reference", Box::new(reference()), Method::ALL),
        ("processor", Box::new(CpuBackend::default()), fast),
        ("GPU", Box::new(gpu), &[Method::Single, Method::Tracked]),
    ]
}

#[test]
fn a_picture_lights_what_faces_its_bright_side() {
    // Radiance of white Lambert is the cosine-weighted share of the hemisphere that is white.
    let cases = [
        (RIGHT, 0.0, DVec3::X, 1.0),
        (LEFT, 0.0, DVec3::X, 0.0),
        (LEFT, 0.0, -DVec3::X, 1.0),
        (ABOVE, 0.0, DVec3::Z, 1.0),
        (BELOW, 0.0, DVec3::Z, 0.0),
        (BELOW, 0.0, -DVec3::Z, 1.0),
        (ABOVE, 0.0, DVec3::X, 0.5),
        (FAR, 0.0, DVec3::X, 0.5),
        // Turning goes the way azimuths grow, from +x to +y.
        (FAR, -90.0, DVec3::X, 1.0),
        (FAR, 90.0, DVec3::X, 0.0),
        (FAR_RIGHT, 0.0, DVec3::X, 0.5),
        (FAR_RIGHT, 90.0, DVec3::X, 0.0),
        (FAR_RIGHT, -90.0, DVec3::X, 0.5),
        (FAR_RIGHT, 360.0, DVec3::X, 0.5),
        (ABOVE, 77.0, DVec3::Z, 1.0),
    ];
    let mut design = one_yarn();
    let environment = &mut design.light.environment;
    (environment.kind, environment.image) = (EnvironmentKind::Image, Some("sky.exr".into()));
    for (name, mut backend, methods) in all() {
        for ((side, white), rotation, normal, expected) in cases {
            design.light.environment.pixels = Some(half(white));
            design.light.environment.rotation = rotation;
            let scene = compile(&design).unwrap();
            for &method in methods {
                let request = look_at_yarn(scene.clone(), normal, method);
                let picture = finish(&mut *backend, &request);
                let what = format!("{side} turned by {rotation}° on {normal}, {name} {method:?}");
                assert_mean(&what, &picture, 0, expected, 1e-3);
            }
        }
    }
}

#[test]
fn a_gradient_lights_by_its_closed_form() {
    let mut design = one_yarn();
    let environment = &mut design.light.environment;
    environment.kind = EnvironmentKind::Gradient;
    environment.zenith = Colour([255, 0, 0]);
    environment.horizon = Colour([0, 255, 0]);
    environment.ground = Colour([0, 0, 255]);
    let scene = compile(&design).unwrap();
    // ∫₀¹ 2μ·smoothstep(0, 1, μ) dμ = 0.7: what faces up takes 0.7 of the zenith. Of the ground it is 0.7 within the
    // haze, a share haze² of the projected hemisphere, and all beyond.
    let ground = 1.0 - 0.3 * Sky::HAZE.powi(2);
    let cases = [
        (DVec3::Z, [0.7, 0.3, 0.0]),
        (-DVec3::Z, [0.0, 1.0 - ground, ground]),
    ];
    for (name, mut backend, methods) in all() {
        for (normal, expected) in cases {
            for &method in methods {
                let request = look_at_yarn(scene.clone(), normal, method);
                let picture = finish(&mut *backend, &request);
                for (channel, expected) in expected.into_iter().enumerate() {
                    let what = format!("{normal}, channel {channel}, {name} {method:?}");
                    assert_mean(&what, &picture, channel, expected, 1e-4);
                }
            }
        }
    }
}

#[test]
fn a_deep_isotropic_block_is_lit_from_the_right_side() {
    // 48 mean free paths thick and more to all other sides: half a space, seen straight on. Light from the hemisphere
    // it faces, scattered once: ½∫₀¹ μ/(1+μ) dμ = ½(1 − ln 2). Half of the hemisphere gives half, its back nothing.
    let whole = 0.5 * (1.0 - LN_2);
    let cases = [
        (RIGHT, whole),
        (LEFT, 0.0),
        (ABOVE, 0.5 * whole),
        (FAR, 0.5 * whole),
    ];
    let mut scene = block(1);
    edit_pile(&mut scene, |pile| pile.materials[0].density_per_mm = 60.0);
    let (middle, _) = block_extent(&scene);
    for (name, mut backend, _) in all() {
        for ((side, white), expected) in cases {
            let mut scene = scene.clone();
            edit_lights(&mut scene, |lights| {
                lights.environment = [1.0; 3];
                lights.sky = Sky::Image {
                    image: half(white),
                    middle: PI / 2.0,
                };
            });
            let mut request = request(scene, Method::Tracked, 1);
            request.view.levels.nearest.camera = needle_camera(middle, DVec3::X);
            (request.size, request.crop) = ([32, 32], [0, 0, 32, 32]);
            request.settings.samples = 16;
            let picture = finish(&mut *backend, &request);
            assert_mean(&format!("{side}, {name}"), &picture, 0, expected, 1e-4);
        }
    }
}

/// A towel under a constant light, a gradient of that colour everywhere, and a picture of it.
fn equal_surroundings() -> [Design; 3] {
    let mut constant = small_towel();
    let colour = Colour([200, 120, 40]);
    constant.light.environment.colour = colour;
    constant.light.environment.radiance = 0.75;
    let mut gradient = constant.clone();
    let environment = &mut gradient.light.environment;
    environment.kind = EnvironmentKind::Gradient;
    (environment.zenith, environment.horizon, environment.ground) = (colour, colour, colour);
    let mut image = constant.clone();
    let environment = &mut image.light.environment;
    (environment.kind, environment.image) = (EnvironmentKind::Image, Some("sky.exr".into()));
    (environment.colour, environment.rotation) = (Colour([1, 2, 3]), 33.0);
    let linear = colour.linear().map(|c| c as f32);
    environment.pixels = Some(picture(32, |_| linear));
    [constant, gradient, image]
}

#[test]
fn equal_colours_all_around_are_a_constant_light() {
    let (mut cpu, mut gpu) = (CpuBackend::default(), exact_gpu());
    for (method, bounces) in [
        (Method::Single, 1),
        (Method::Layered, 3),
        (Method::Tracked, 4),
    ] {
        let pictures = equal_surroundings().map(|mut design| {
            (design.quality.method, design.quality.bounces) = (method, bounces);
            design.quality.samples = 2;
            let request = request_of(&design, [24, 20]);
            [
                on_reference(&request),
                finish(&mut cpu, &request),
                finish(&mut gpu, &request),
            ]
        });
        let [constant, gradient, image] = &pictures;
        for (k, backend) in ["reference", "processor", "GPU"].into_iter().enumerate() {
            shows_something(&constant[k]).unwrap();
            for (kind, other) in [("gradient", gradient), ("image", image)] {
                for (a, b) in constant[k].pixels.iter().zip(&other[k].pixels) {
                    // The same paths; only the last digits of the colour may differ (f32 texels, one blend of each).
                    let near = (0..4).all(|c| (a[c] - b[c]).abs() <= 1e-5 * a[c].abs());
                    assert!(near, "{backend} {method:?} {kind}: {b:?}, not {a:?}");
                }
            }
        }
    }
}

#[test]
fn all_backends_draw_the_same_samples_under_every_sky() {
    let (mut cpu, mut gpu) = (CpuBackend::default(), exact_gpu());
    for (kind, method, phase) in [
        (EnvironmentKind::Gradient, Method::Single, Phase::Isotropic),
        (EnvironmentKind::Image, Method::Single, Phase::KajiyaKay),
        (EnvironmentKind::Image, Method::Layered, Phase::FrameLambert),
    ] {
        let mut design = small_towel();
        design.quality.method = method;
        design.pile.phase = phase;
        let environment = &mut design.light.environment;
        (environment.kind, environment.image) = (kind, Some("sky.exr".into()));
        (environment.radiance, environment.rotation) = (2.0, -115.0);
        // Bright and dark patches of some 20°, other ones in each channel; 0 to 2.
        environment.pixels = Some(picture(256, |d| {
            let wave = |k: f64| (1.0 + (9.0 * d.x + k).sin() * (8.0 * d.y + k).cos()) as f32;
            [wave(0.0), wave(1.0), wave(2.0) * (1.0 + d.z as f32)]
        }));
        let request = request_of(&design, [48, 40]);
        let expected = on_reference(&request);
        shows_something(&expected).unwrap();
        design.light.environment.rotation += 0.2;
        let turned = request_of(&design, [48, 40]);
        for backend in [&mut cpu as &mut dyn Backend, &mut gpu] {
            let name = backend.kind().name();
            same_samples(&request, &expected, &finish(backend, &request))
                .unwrap_or_else(|error| panic!("{name}, {kind:?} {method:?}: {error}"));
            // The comparison sees a picture turned by a fifth of a degree.
            if kind == EnvironmentKind::Image {
                let turned = finish(backend, &turned);
                assert!(same_samples(&request, &expected, &turned).is_err());
            }
        }
    }
}

#[test]
fn a_sky_that_gives_no_light_is_none() {
    // No radiance: no shadow rays for it, whatever the picture.
    let mut design = small_towel();
    let environment = &mut design.light.environment;
    (environment.kind, environment.image) = (EnvironmentKind::Image, Some("sky.exr".into()));
    environment.radiance = 0.0;
    environment.pixels = Some(half(|_| true));
    let mut dark = small_towel();
    dark.light.environment.radiance = 0.0;
    for backend in [
        &mut reference() as &mut dyn Backend,
        &mut CpuBackend::default(),
    ] {
        let [a, b] = [&design, &dark].map(|design| {
            let mut request = request_of(design, [16, 16]);
            request.settings.counters = true;
            let picture = finish(backend, &request);
            (picture.pixels, backend.counters().unwrap().shadow_rays)
        });
        assert!(a == b);
        assert!(a.0.iter().any(|pixel| pixel[3] > 0.0), "cloth is seen");
    }
}
