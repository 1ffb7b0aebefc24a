//! What the shaders leave out: with each skip off the GPU draws the same picture, to the bit where the skip is exact;
//! and its counter moves.

use renderer_core::design::{Design, Method, Pattern};
use renderer_core::gpu::GpuBackend;
use renderer_core::image::Picture;
use renderer_core::render::{Backend, Counters, Optimisation, RenderRequest};

use crate::support::compare::same_means;
use crate::support::device::{finish, gpu, repeats};
use crate::support::scenes::{load_design, preset_path, request, small_towel};

const METHODS: [Method; 4] = [
    Method::Single,
    Method::Layered,
    Method::Exact,
    Method::Tracked,
];

fn draw(gpu: &mut GpuBackend, request: &RenderRequest) -> (Picture, Counters) {
    (finish(gpu, request), gpu.counters().unwrap())
}

/// Pictures and counters with the skip and without.
fn both(gpu: &mut GpuBackend, design: &Design, skip: Optimisation) -> [(Picture, Counters); 2] {
    let mut request = request(design, [48, 40]);
    request.settings.counters = true;
    let on = draw(gpu, &request);
    request.settings.optimisations = request.settings.optimisations.without(skip);
    [on, draw(gpu, &request)]
}

/// Dense pile from above; gaps from the side and from behind; the ground alone. All are drawn by the same pipeline.
fn designs() -> Vec<Design> {
    let mut dense = small_towel();
    dense.weave.pattern = Pattern::filled(1, 1, 9);
    let mut grazing = small_towel();
    grazing.view.cameras[0].elevation = 5.0;
    let mut below = small_towel();
    below.view.cameras[0].elevation = -35.0;
    let mut bare = small_towel();
    bare.length.value = 0.0;
    let mut designs = vec![dense, grazing, below, bare];
    for design in &mut designs {
        design.quality.samples = 2;
    }
    designs
}

#[test]
fn ground_that_pile_hides_is_not_looked_for() {
    let mut gpu = gpu();
    for method in METHODS {
        let mut hidden = Vec::new();
        for mut design in designs() {
            design.quality.method = method;
            let [(on, some), (off, none)] = both(&mut gpu, &design, Optimisation::HiddenGround);
            assert_eq!(on, off, "{}", method.name());
            assert_eq!(none.hidden_rays, 0);
            assert!(some.hidden_rays <= some.rays);
            assert_eq!(some.rays, none.rays);
            hidden.push(some.hidden_rays as f64 / some.rays as f64);
        }
        eprintln!("{}: hidden {hidden:.2?}", method.name());
        // Much of the ground under dense pile; nothing where there is no pile.
        assert!(hidden[0] > 0.15 && hidden[3] == 0.0, "{hidden:?}");
    }
}

#[test]
fn shadow_rays_end_in_the_dark() {
    let mut gpu = gpu();
    for method in METHODS {
        let mut design = load_design(&preset_path("paper-fig12"));
        (design.quality.method, design.quality.bounces) = (method, 1);
        design.quality.samples = 2;
        let [(on, some), (off, none)] = both(&mut gpu, &design, Optimisation::OpaqueRays);
        eprintln!("{}: {some:?} without {none:?}", method.name());
        assert!(some.ended_rays > some.shadow_rays / 20, "{some:?}");
        assert!(none.ended_rays == 0 && none.volume_samples > some.volume_samples);
        if method == Method::Tracked {
            // Other random numbers: the same expectation.
            let mut request = request(&design, [24, 24]);
            let on = repeats(&mut gpu, &request, 100);
            request.settings.optimisations = request
                .settings
                .optimisations
                .without(Optimisation::OpaqueRays);
            let off = repeats(&mut gpu, &request, 900);
            same_means(&on, &off).unwrap();
            continue;
        }
        // What is left out is below 10⁻⁴ of the light: suns and sky give a pixel some units of radiance.
        let mut most = 0.0_f32;
        for (a, b) in on.pixels.iter().zip(&off.pixels) {
            for c in 0..4 {
                most = most.max(b[c] - a[c]);
                assert!((0.0..5e-4).contains(&(b[c] - a[c])), "{a:?} {b:?}");
            }
        }
        assert!(most > 0.0, "{}: nothing was left out", method.name());
    }
}
