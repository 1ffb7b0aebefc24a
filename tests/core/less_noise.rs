//! What takes noise from `tracked` leaves the mean where it is: pictures with it and without it, of independent samples,
//! block by block.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Colour, Design, Phase, PileKind};
use renderer_core::image::Picture;
use renderer_core::render::{Backend, Optimisation, Optimisations, RenderRequest};

use crate::agreement::{SIZE, backlit_towel, noisy, thin_towel, tracked};
use crate::support::compare::same_means;
use crate::support::device::{gpu, repeats};
use crate::support::scenes::{load_design, preset_path, request, small_towel};

/// What takes noise away.
const QUIETING: [Optimisation; 2] = [Optimisation::WeighedEvents, Optimisation::LastLooks];

/// `request` with all noise, but for what is saved at later scatterings.
fn with_later_lights_saved(request: &RenderRequest) -> RenderRequest {
    let mut saving = request.clone();
    saving.settings.optimisations =
        (QUIETING.into_iter()).fold(saving.settings.optimisations, Optimisations::without);
    saving
}

/// Designs in which it meets something else each: one scattering but for the last.
fn designs() -> Vec<(&'static str, Design)> {
    let mut fur = small_towel();
    (fur.pile.kind, fur.pile.density) = (PileKind::Fur, 100.0);
    let phase = |phase: Phase| {
        let mut design = small_towel();
        (design.pile.phase, design.pile.transmission) = (phase, 0.3);
        design
    };
    let mut below = small_towel();
    below.view.cameras[0].elevation = -35.0;
    let mut bent = load_design(&preset_path("rolled-towel"));
    bent.view.cameras.truncate(1);
    let one = |design: Design| tracked(design, 1);
    vec![
        ("thin", one(thin_towel())),
        ("backlit", one(backlit_towel())),
        ("fur", one(fur)),
        ("isotropic", one(phase(Phase::Isotropic))),
        ("frame lambert", one(phase(Phase::FrameLambert))),
        ("gradient lambert", one(phase(Phase::GradientLambert))),
        ("fibres", one(phase(Phase::KajiyaKay))),
        ("from below", one(below)),
        ("bent", one(bent)),
        (
            "area lights",
            one(load_design(&preset_path("studio-softbox"))),
        ),
        (
            "picture of a sky",
            one(load_design(&preset_path("evening-hall"))),
        ),
        ("three scatterings", tracked(small_towel(), 3)),
    ]
}

/// Fails unless pictures have the same means with each kind of quieting, and with both.
fn assert_same_means(backend: &mut dyn Backend, what: &str, request: &RenderRequest) {
    let noise = repeats(backend, &noisy(request.clone()), 5_000);
    let without = |one: Optimisation| {
        let mut request = request.clone();
        request.settings.optimisations = request.settings.optimisations.without(one);
        request
    };
    let both = request.clone();
    for quiet in [both, without(QUIETING[0]), without(QUIETING[1])] {
        let pictures = repeats(backend, &quiet, 6_000);
        let left_out = quiet.settings.optimisations;
        same_means(&noise, &pictures)
            .unwrap_or_else(|error| panic!("{what}, {left_out:?}: {error}"));
    }
}

#[test]
fn on_the_processor_means_stay() {
    for (what, design) in designs() {
        assert_same_means(&mut CpuBackend::default(), what, &request(&design, SIZE));
    }
}

#[test]
fn with_the_light_of_further_scatterings_estimated_means_stay() {
    let mut design = tracked(small_towel(), 6);
    design.pile.phase = Phase::GradientLambert;
    let mut request = request(&design, SIZE);
    request.settings.traced_bounces = 1;
    assert_same_means(&mut CpuBackend::default(), "cut off", &request);
}

#[test]
fn on_the_gpu_means_stay() {
    let mut gpu = gpu();
    for bounces in [1, 3] {
        let design = tracked(small_towel(), bounces);
        let request = request(&design, SIZE);
        assert_same_means(&mut gpu, &format!("{bounces} bounces"), &request);
    }
}

#[test]
fn rays_saved_at_later_scatterings_leave_means() {
    let white = |mut design: Design| {
        design.chart.colour = Colour::WHITE;
        design
    };
    for (what, design) in [
        ("sun and sky", white(small_towel())),
        ("area lights", load_design(&preset_path("studio-softbox"))),
        (
            "picture of a sky",
            load_design(&preset_path("evening-hall")),
        ),
    ] {
        let request = request(&tracked(design, 6), SIZE);
        let mut cpu = CpuBackend::default();
        let all = repeats(&mut cpu, &noisy(request.clone()), 5_000);
        let mut saving = with_later_lights_saved(&request);
        saving.settings.counters = true;
        let pictures = repeats(&mut cpu, &saving, 6_000);
        let saved = cpu.counters().unwrap().shadow_rays;
        same_means(&all, &pictures).unwrap_or_else(|error| panic!("{what}: {error}"));
        repeats(&mut cpu, &noisy(saving), 7_000);
        let traced = cpu.counters().unwrap().shadow_rays;
        assert!(4 * saved < 3 * traced, "{what}: {saved} of {traced} rays");
    }
}

/// Variance of the channels, summed over all pixels.
fn variance(pictures: &[Picture]) -> f64 {
    let count = pictures.len() as f64;
    let mut sum = 0.0;
    for pixel in 0..pictures[0].pixels.len() {
        for c in 0..3 {
            let values = pictures
                .iter()
                .map(|picture| f64::from(picture.pixels[pixel][c]));
            let mean = values.clone().sum::<f64>() / count;
            sum += values.map(|value| (value - mean).powi(2)).sum::<f64>();
        }
    }
    sum
}

#[test]
fn thin_strands_have_half_the_noise() {
    let design = tracked(load_design(&preset_path("peer-towel")), 1);
    let mut request = request(&design, [512, 512]);
    request.crop = [240, 240, 24, 24];
    let [noise, quiet] = [noisy(request.clone()), request]
        .map(|request| variance(&repeats(&mut CpuBackend::default(), &request, 1)));
    // Of 16 samples 0.122 and 0.057.
    assert!(quiet < 0.6 * noise, "{quiet} of {noise}");
}
