//! Light without shadows (`quality.shadows = false`): nothing stands between a scattering point and a light.

use std::f64::consts::PI;

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, Method, Phase, Sampler};
use renderer_core::image::Picture;
use renderer_core::render::{Backend, RenderError};

use crate::agreement::noisy;
use crate::support::compare::{same_means, same_samples};
use crate::support::device::{exact_gpu, finish, gpu, on_reference, reference, repeats};
use crate::support::scenes::{request, small_towel};

/// Isotropic pile without yarns, so that a point's light has a closed form.
fn bare_pile() -> Design {
    let mut design = small_towel();
    design.skeleton.visible = false;
    design.pile.phase = Phase::Isotropic;
    design.quality.shadows = false;
    design
}

#[test]
fn without_shadows_every_point_has_all_its_light() {
    let mut design = bare_pile();
    for &method in Method::ALL {
        design.quality.method = method;
        // Of one point a ray: the mean albedo of several tells nothing of the light that each gives.
        let mut request = noisy(request(&design, [40, 32]));
        request.settings.aov = true;
        let lights = &request.scene().lights;
        // albedo/4π of every sun's irradiance, and the albedo's share of the environment's radiance from all sides.
        let light = [0, 1, 2].map(|c| {
            let suns: f64 = lights.suns.iter().map(|sun| sun.irradiance[c]).sum();
            suns / (4.0 * PI) + lights.environment[c]
        });
        assert!(light.iter().all(|&light| light > 0.0));
        for backend in [
            &mut gpu() as &mut dyn Backend,
            &mut CpuBackend::default(),
            &mut reference(),
        ] {
            // Only the reference draws all methods.
            if matches!(backend.begin(&request), Err(RenderError::Method { .. })) {
                continue;
            }
            let picture = finish(backend, &request);
            let albedo = &picture.aov.as_ref().unwrap().albedo;
            let mut covered = 0;
            for (pixel, albedo) in picture.pixels.iter().zip(albedo) {
                if pixel[3] > 0.0 {
                    covered += 1;
                    for c in 0..3 {
                        let expected = f64::from(albedo[c]) * light[c];
                        // A dozen f32 operations.
                        let error = (f64::from(pixel[c]) - expected).abs();
                        assert!(error < 1e-5, "{method:?}: {pixel:?} {expected}");
                    }
                }
            }
            assert!(covered > 100, "{method:?}: {covered}");
        }
        // With shadows most of these points have less, and none has more.
        request.settings.shadows = true;
        let (lit, shaded) = {
            let shaded = on_reference(&request);
            request.settings.shadows = false;
            (on_reference(&request), shaded)
        };
        let darker = lit.pixels.iter().zip(&shaded.pixels);
        let darker = darker.filter(|(lit, shaded)| shaded[1] < 0.9 * lit[1]);
        assert!(darker.count() > 100, "{method:?}");
    }
}

#[test]
fn both_samplers_and_no_shadows_draw_the_same_samples_on_all_backends() {
    let mut design = small_towel();
    let pictures: Vec<Picture> = [
        (Sampler::Owen, false),
        (Sampler::Random, true),
        (Sampler::Random, false),
    ]
    .into_iter()
    .map(|(sampler, shadows)| {
        (design.quality.sampler, design.quality.shadows) = (sampler, shadows);
        let request = request(&design, [40, 32]);
        let expected = on_reference(&request);
        for backend in [
            &mut exact_gpu() as &mut dyn Backend,
            &mut CpuBackend::default(),
        ] {
            let name = backend.kind().name();
            same_samples(&request, &expected, &finish(backend, &request))
                .unwrap_or_else(|error| panic!("{name}, {sampler:?}, shadows {shadows}: {error}"));
        }
        expected
    })
    .collect();
    assert!(pictures[0] != pictures[2] && pictures[1] != pictures[2]);
}

#[test]
fn paths_without_shadows_have_the_same_expectation_on_all_backends() {
    let mut design = small_towel();
    design.quality.shadows = false;
    design.quality.sampler = Sampler::Random;
    design.quality.samples = 4;
    for (method, bounces) in [(Method::Tracked, 4), (Method::Single, 3)] {
        (design.quality.method, design.quality.bounces) = (method, bounces);
        let request = request(&design, [24, 24]);
        let expected = repeats(&mut reference(), &request, 900);
        for backend in [&mut gpu() as &mut dyn Backend, &mut CpuBackend::default()] {
            let name = backend.kind().name();
            same_means(&expected, &repeats(backend, &request, 100))
                .unwrap_or_else(|error| panic!("{name}, {method:?}: {error}"));
        }
    }
}
