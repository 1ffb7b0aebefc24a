//! What the processor leaves out: with each skip off it draws the same picture, and its counter moves.
//!
//! Without a skip loops are solved from other blocks, and what a shadow ray passes adds up in another order: pictures
//! by `single` and `layered` are the same to f32 rounding, not to the bit. `tracked` spends its random numbers where
//! loops may be: without a skip on other places, so that only its distribution stays.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, Method};
use renderer_core::image::Picture;
use renderer_core::render::{Backend, Counters, Optimisation, RenderRequest};

use super::scenes::{CAMERAS, LOOPS};
use crate::support::agreement::same_distribution;
use crate::support::compare::{ROUNDING, same_as_reference};
use crate::support::device::{finish, on_reference, repeats};
use crate::support::scenes::{load_design, preset_path, request, small_towel};

const COMPOSITED: [Method; 2] = [Method::Single, Method::Layered];

fn without(request: &RenderRequest, skip: Optimisation) -> RenderRequest {
    let mut request = request.clone();
    request.settings.optimisations = request.settings.optimisations.without(skip);
    request
}

/// Pictures and counters with the skip and without.
fn on_and_off(request: &RenderRequest, skip: Optimisation) -> [(Picture, Counters); 2] {
    let mut request = request.clone();
    request.settings.counters = true;
    [request.clone(), without(&request, skip)].map(|request| {
        let mut cpu = CpuBackend::default();
        let picture = finish(&mut cpu, &request);
        (picture, cpu.counters().unwrap())
    })
}

/// Towels from near and far, at a slant and from the side, with loops of every size.
fn requests(method: Method) -> Vec<RenderRequest> {
    let edits = LOOPS.iter().chain(&CAMERAS[1..]);
    edits
        .map(|(_, edit)| {
            let mut design = small_towel();
            design.quality.method = method;
            edit(&mut design);
            request(&design, [48, 40])
        })
        .collect()
}

/// Fails unless samples are alike to rounding, but for a few at edges.
fn assert_same(request: &RenderRequest, on: &Picture, off: &Picture) {
    let near = |(a, b): (&[f32; 4], &[f32; 4])| {
        (0..4).all(|c| (a[c] - b[c]).abs() <= ROUNDING * a[c].abs().max(1.0))
    };
    let same = on
        .pixels
        .iter()
        .zip(&off.pixels)
        .filter(|&(a, b)| near((a, b)));
    let count = on.pixels.len();
    // One in five hundred is more than two roundings flip.
    assert!(same.count() + count / 500 >= count);
    // And it is what the reference draws.
    same_as_reference(request, &on_reference(request), off).unwrap();
}

/// Sums of counters over several pictures, with the skip and without, of the same samples.
fn totals(method: Method, skip: Optimisation) -> [Counters; 2] {
    let mut totals = [Counters::default(); 2];
    for request in requests(method) {
        let [on, off] = on_and_off(&request, skip);
        assert_same(&request, &on.0, &off.0);
        totals[0] += on.1;
        totals[1] += off.1;
    }
    totals
}

#[test]
fn without_empty_cells_the_samples_are_the_same() {
    for method in COMPOSITED {
        let [some, none] = totals(method, Optimisation::EmptyCells);
        assert!(some.skipped_cells > some.cells / 20, "{some:?}");
        assert_eq!(none.skipped_cells, 0);
        assert!(some.patch_tests < none.patch_tests / 2, "{some:?} {none:?}");
        // About as many cells are walked through: where all of a block's loops are solved at once, a dark shadow ray
        // has all of them behind it a little earlier.
        assert!(
            some.cells.abs_diff(none.cells) <= none.cells / 20,
            "{some:?} {none:?}"
        );
    }
}

#[test]
fn without_remembering_tests_the_samples_are_the_same() {
    for method in COMPOSITED {
        let [some, none] = totals(method, Optimisation::RepeatedTests);
        assert!(some.repeated_tests > some.patch_tests / 100, "{some:?}");
        assert_eq!(none.repeated_tests, 0);
        assert!(some.patch_tests < none.patch_tests, "{some:?} {none:?}");
    }
}

#[test]
fn dark_shadow_rays_end() {
    for method in COMPOSITED {
        let mut design = load_design(&preset_path("paper-fig12"));
        (design.quality.method, design.quality.bounces) = (method, 1);
        design.quality.samples = 2;
        let [(on, some), (off, none)] =
            on_and_off(&request(&design, [48, 40]), Optimisation::OpaqueRays);
        assert!(some.ended_rays > some.shadow_rays / 20, "{some:?}");
        assert!(none.ended_rays == 0 && none.volume_samples > some.volume_samples);
        // What is left out is below 10⁻⁴ of the light, and suns and sky give a pixel some units of radiance; all else
        // is the same to the bit.
        let mut most = 0.0_f32;
        for (a, b) in on.pixels.iter().zip(&off.pixels) {
            for c in 0..4 {
                most = most.max(b[c] - a[c]);
                assert!((0.0..5e-4).contains(&(b[c] - a[c])), "{a:?} {b:?}");
            }
        }
        assert!(most > 0.0, "{method:?}: nothing was left out");
    }
}

#[test]
fn tracked_pictures_have_the_same_distribution_without_skips() {
    let mut design = small_towel();
    design.quality.method = Method::Tracked;
    (design.quality.samples, design.quality.bounces) = (16, 2);
    let request = request(&design, [16, 12]);
    let on = repeats(&mut CpuBackend::default(), &request, 100);
    for (skip, counter) in [
        (
            Optimisation::EmptyCells,
            (|c| c.skipped_cells) as fn(&Counters) -> u64,
        ),
        (Optimisation::OpaqueRays, |c| c.ended_rays),
    ] {
        let [(_, some), (_, none)] = on_and_off(&request, skip);
        assert!(counter(&some) > some.rays / 100, "{skip}: {some:?}");
        assert_eq!(counter(&none), 0, "{skip}");
        let off = repeats(&mut CpuBackend::default(), &without(&request, skip), 900);
        same_distribution(&on, &off).unwrap_or_else(|error| panic!("{skip}: {error}"));
    }
}

#[test]
fn shadow_rays_end_at_the_ground_before_loops_are_looked_at() {
    for method in [Method::Single, Method::Layered, Method::Tracked] {
        let mut design: Design = small_towel();
        design.quality.method = method;
        // A sun behind the cloth: the ground is in the way of most of its light.
        design.light.sun[0].elevation = -60.0;
        let [(_, counted), _] = on_and_off(&request(&design, [48, 40]), Optimisation::HiddenGround);
        assert!(
            counted.hidden_rays > counted.shadow_rays / 20,
            "{counted:?}"
        );
        assert!(counted.hidden_rays < counted.shadow_rays);
        design.skeleton.visible = false;
        let [(_, counted), _] = on_and_off(&request(&design, [48, 40]), Optimisation::HiddenGround);
        assert_eq!(counted.hidden_rays, 0);
    }
}

#[test]
fn few_patches_are_tested() {
    let design = load_design(&preset_path("paper-fig1"));
    let mut request = request(&design, [160, 120]);
    request.settings.samples = 1;
    let [(_, counted), _] = on_and_off(&request, Optimisation::EmptyCells);
    let rays = counted.rays + counted.shadow_rays;
    let tests = counted.patch_tests as f64 / rays as f64;
    eprintln!("paper-fig1: {tests:.2} patches a ray, {counted:?}");
    assert!(counted.shadow_rays > counted.rays / 2, "{counted:?}");
    assert!(tests <= 4.0, "{tests:.2} patches a ray");
}
