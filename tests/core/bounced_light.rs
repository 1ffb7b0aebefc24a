//! Light that goes on where a live view cuts its paths off, as learned from paths that do not end there.

use std::sync::Arc;

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Colour, Design, Method};
use renderer_core::image::{Picture, metrics};
use renderer_core::render::bounced_light::{BouncedKey, BouncedLight, learns};
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::scene::{Scene, compile};

use crate::support::closed::closed;
use crate::support::device::{exact_gpu, finish};
use crate::support::scenes::{load_design, preset_path, request, small_towel};

/// The middle of a picture of white terry near by, nothing but cloth.
const SIZE: [u32; 2] = [400, 300];
const CROP: [u32; 4] = [180, 135, 40, 30];

fn white(bounces: u32) -> Design {
    let mut design = load_design(&preset_path("hotel-white"));
    design.view.cameras.retain(|camera| camera.name == "near");
    design.quality.bounces = bounces;
    design
}

/// `samples` of a picture whose paths are cut off at their first scattering unless all are `traced`.
fn drawn(backend: &mut dyn Backend, design: &Design, traced: bool, samples: u32) -> Picture {
    let mut request = request(closed(design, u32::from(!traced)), SIZE);
    (request.crop, request.settings.samples) = (CROP, samples);
    finish(backend, &request)
}

/// A picture of 64 samples cut off at their first scattering, after 128 that taught the correction from an eye nearby.
fn learned(backend: &mut dyn Backend, design: &Design) -> Picture {
    let mut request = request(closed(design, 1), SIZE);
    (request.crop, request.settings.samples) = (CROP, 128);
    request.settings.cached_shadows = 128;
    request.settings.learns_bounces = true;
    finish(backend, &request);
    request.view.levels.nearest.camera.eye.x += 0.01;
    request.settings.samples = 64;
    finish(backend, &request)
}

#[test]
fn estimates_become_as_bright_as_what_paths_find() {
    let design = white(64);
    let mut cpu = CpuBackend::default();
    let truth = metrics::mean(&drawn(&mut cpu, &design, true, 128));
    let [estimated, learned] = [
        drawn(&mut cpu, &design, false, 64),
        learned(&mut cpu, &design),
    ]
    .map(|picture| metrics::mean(&picture) / truth - 1.0);
    eprintln!("mean, estimated {estimated:+.4}, learned {learned:+.4}");
    assert!(learned.abs() < 0.02, "{learned}");
    assert!(estimated.abs() > 0.03, "{estimated}");
}

#[test]
fn the_gpu_learns_too() {
    // As many scatterings as software Vulkan follows where others are cut off.
    let design = white(5);
    let mut cpu = CpuBackend::default();
    let truth = metrics::mean(&drawn(&mut cpu, &design, true, 256));
    let off = |picture: &Picture| metrics::mean(picture) / truth - 1.0;
    let estimated = off(&drawn(&mut cpu, &design, false, 64));
    let by_gpu = off(&learned(&mut exact_gpu(), &design));
    eprintln!("mean, estimated {estimated:+.4}, learned by the GPU {by_gpu:+.4}");
    // 0.040 and 0.019 here: few paths reach each of the texels of so small a picture.
    assert!(by_gpu.abs() < 0.7 * estimated.abs(), "{estimated} {by_gpu}");
}

/// A request of the small towel that learns.
fn learning() -> RenderRequest {
    let mut design = small_towel();
    design.quality.method = Method::Tracked;
    design.quality.bounces = 8;
    let mut request = request(closed(&design, 1), SIZE);
    (
        request.settings.cached_shadows,
        request.settings.learns_bounces,
    ) = (8, true);
    request
}

#[test]
fn ratios_begin_at_one_and_go_where_paths_lead() {
    let light = BouncedLight::new(BouncedKey::new(&learning()).unwrap());
    let entry = light.entry(DVec3::new(0.2, 0.1, 0.5), [0.5; 3]);
    assert_eq!(light.correction(entry), DVec3::ONE);
    // Twice what was estimated of red, half of green, nothing of blue.
    for paths in [8, 248] {
        for _ in 0..paths {
            light.add(entry, DVec3::new(1.0, 0.25, 0.0), DVec3::splat(0.5));
        }
        light.finalise();
        let ratios = light.correction(entry);
        // Eight paths that found what was estimated are counted in: half at first, next to nothing in the end.
        let known = if paths == 8 { 0.5 } else { 256.0 / 264.0 };
        let expected = DVec3::new(1.0 + known, 1.0 - 0.5 * known, (1.0 - known).max(0.2));
        assert!(
            (ratios - expected).abs().max_element() < 0.01,
            "{ratios} {expected}"
        );
        assert_eq!(light.is_learning(entry), paths == 8);
    }
    let other = light.entry(DVec3::new(0.2, 0.1, -0.5), [0.5; 3]);
    assert_eq!(light.correction(other), DVec3::ONE);
}

#[test]
fn what_was_learned_holds_while_only_the_camera_moves() {
    let request = learning();
    let key = BouncedKey::new(&request).unwrap();
    let same = |edit: &dyn Fn(&mut RenderRequest)| {
        let mut edited = request.clone();
        edit(&mut edited);
        BouncedKey::new(&edited).is_some_and(|other| key.is_same(&other))
    };
    assert!(same(
        &|request| request.view.levels.nearest.camera.eye.x += 0.5
    ));
    assert!(!same(&|request| request.settings.bounces = 7));
    assert!(!same(&|request| request.settings.seed += 1));
    let mut dyed = small_towel();
    dyed.chart.colour = Colour([40, 60, 120]);
    let looks = compile(&dyed).unwrap().looks;
    assert!(!same(&|request| {
        let mut scene = Scene::clone(request.scene());
        scene.looks = looks.clone();
        request.view.levels.nearest.scene = Arc::new(scene);
    }));
    // Nothing is estimated, or later, or nothing is to be learned.
    for edit in [
        (|request| request.settings.traced_bounces = 0) as fn(&mut RenderRequest),
        |request| request.settings.traced_bounces = 2,
        |request| request.settings.cached_shadows = 0,
        |request| request.settings.learns_bounces = false,
    ] {
        let mut edited = request.clone();
        edit(&mut edited);
        assert!(BouncedKey::new(&edited).is_none(), "{:?}", edited.settings);
    }
}

#[test]
fn one_block_of_sixteen_learns_in_a_sample() {
    let mut count = 0;
    for block in 0..64_u32 {
        for number in 0..64 {
            let [x, y] = [block % 8 * 8, block / 8 * 8];
            let learned = learns(5, [x, y], number);
            // All pixels of a block alike.
            assert_eq!(learns(5, [x + 7, y + 3], number), learned);
            count += u32::from(learned);
        }
    }
    // 4096/16 with a spread of 15.
    assert!((210..=302).contains(&count), "{count}");
}
