//! Bounced light that is estimated after some scattering (`Settings::traced_bounces`): the same on all backends, near
//! the traced light, and nothing of it where all bounces are traced.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, Method};
use renderer_core::image::metrics::{mean_luminance, rel_rmse};
use renderer_core::render::{Backend, RenderRequest};

use crate::gpu_vs_reference::both;
use crate::support::closed::closed;
use crate::support::compare::{same_means, same_samples};
use crate::support::device::{exact_gpu, finish, on_reference, repeats};
use crate::support::scenes::{load_design, preset_path, request, small_towel};

#[test]
fn all_backends_estimate_the_same_light() {
    let mut design = small_towel();
    design.quality.bounces = 16;
    let (mut gpu, mut cpu) = (exact_gpu(), CpuBackend::default());
    for method in [Method::Single, Method::Layered] {
        design.quality.method = method;
        let request = request(closed(&design, 1), [48, 40]);
        let expected = on_reference(&request);
        for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
            let name = backend.kind().name();
            same_samples(&request, &expected, &finish(backend, &request))
                .unwrap_or_else(|error| panic!("{name}, {method:?}: {error}"));
        }
    }
    // With free paths the samples differ, their mean does not.
    design.quality.method = Method::Tracked;
    design.quality.samples = 4;
    let [gpu, expected] = both(closed(&design, 2), [24, 24]);
    same_means(&expected, &gpu).unwrap();
    let cpu = repeats(&mut cpu, &request(closed(&design, 2), [24, 24]), 1000);
    same_means(&expected, &cpu).unwrap();
    // Fewer orders of bounced light show.
    design.quality.bounces = 6;
    let [fewer, _] = both(closed(&design, 2), [24, 24]);
    assert!(same_means(&expected, &fewer).is_err());
}

/// 24 × 24 pixels of the middle of a picture.
fn detail(design: &Design, traced_bounces: u32) -> RenderRequest {
    let mut request = request(closed(design, traced_bounces), [800, 600]);
    request.crop = [388, 288, 24, 24];
    request
}

#[test]
fn the_estimate_is_near_the_traced_light() {
    let mut design = load_design(&preset_path("hotel-white"));
    (design.quality.samples, design.quality.error) = (16, 0.0);
    for camera in ["middle", "near"] {
        design
            .view
            .cameras
            .sort_by_key(|other| other.name != camera);
        let traced = mean_luminance(&on_reference(&detail(&design, 0)));
        // A tenth is what the estimate claims after the first scattering, a fifth after later ones; the sampling error
        // of these means is 1 %.
        for (after, least) in [(1, 0.9), (4, 0.8)] {
            let ratio = mean_luminance(&on_reference(&detail(&design, after))) / traced;
            assert!(
                (least..1.1).contains(&ratio),
                "{camera}, after {after}: {ratio}"
            );
        }
        // What is left out without it is far more.
        design.quality.bounces = 1;
        let ratio = mean_luminance(&on_reference(&detail(&design, 0))) / traced;
        assert!(ratio < 0.5, "{camera}: {ratio}");
        design.quality.bounces = 64;
    }
}

#[test]
fn nothing_is_estimated_where_every_bounce_is_traced() {
    let mut design = small_towel();
    design.quality.method = Method::Tracked;
    (design.quality.bounces, design.quality.samples) = (4, 2);
    let traced = on_reference(&request(&design, [24, 20]));
    for after in [4, 5, 64] {
        let same = on_reference(&request(closed(&design, after), [24, 20]));
        assert_eq!(same, traced, "{after}");
    }
    let estimated = on_reference(&request(closed(&design, 3), [24, 20]));
    assert!(rel_rmse(&estimated, &traced).unwrap() > 0.001);
}
