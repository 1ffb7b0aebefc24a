//! The picture does not depend on how the work is cut up: bit for bit.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use renderer_core::cpu::CpuBackend;
use renderer_core::design::Method;
use renderer_core::image::Picture;
use renderer_core::reference::ReferenceBackend;
use renderer_core::render::{Backend, RenderRequest};

use crate::support::device::{finish, finish_in_slices, gpu, reference};
use crate::support::scenes::{request, small_towel};

const SLICES: [Duration; 3] = [
    Duration::ZERO,
    Duration::from_micros(300),
    Duration::from_millis(7),
];

fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    let pixels = picture.pixels.iter();
    pixels.map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Paths of several bounces, whose lengths differ most, in tiles of several sizes.
fn long_paths(samples: u32, method: Method, size: [u32; 2]) -> RenderRequest {
    let mut design = small_towel();
    design.quality.method = method;
    (design.quality.samples, design.quality.bounces) = (samples, 4);
    request(&design, size)
}

/// Whole, in slices, and cancelled again and again.
fn assert_order_is_free(make: &dyn Fn() -> Box<dyn Backend>, request: &RenderRequest) -> Picture {
    let whole = finish(make().as_mut(), request);
    for slice in SLICES {
        let sliced = finish_in_slices(make().as_mut(), request, slice);
        assert_eq!(bits(&whole), bits(&sliced), "{slice:?}");
    }
    // A backend that has drawn something else is as good as a new one; targets may grow on the way.
    let mut used = make();
    let mut other = request.clone();
    other.settings.seed += 1;
    finish(used.as_mut(), &other);
    let mut first = request.clone();
    first.settings.samples = 1;
    finish(used.as_mut(), &first);
    used.begin(request).unwrap();
    let cancelled = AtomicBool::new(true);
    used.advance(Duration::ZERO, &cancelled).unwrap();
    assert_eq!(bits(&whole), bits(&finish(used.as_mut(), request)));
    whole
}

#[test]
fn the_device_draws_the_same_in_any_slices() {
    let make = || -> Box<dyn Backend> { Box::new(gpu()) };
    for method in [Method::Tracked, Method::Single] {
        assert_order_is_free(&make, &long_paths(3, method, [36, 21]));
    }
}

#[test]
fn the_processor_draws_the_same_in_any_slices_on_any_cores() {
    let fast = || -> Box<dyn Backend> { Box::new(CpuBackend::default()) };
    let plain = || -> Box<dyn Backend> { Box::new(reference()) };
    for method in [Method::Tracked, Method::Single, Method::Layered] {
        let request = long_paths(3, method, [52, 37]);
        for make in [&fast as &dyn Fn() -> Box<dyn Backend>, &plain] {
            let all = assert_order_is_free(make, &request);
            // Other tiles: a crop's begin elsewhere, and are smaller at its edges.
            let mut part = request.clone();
            part.crop = [5, 3, 30, 21];
            let part = finish(make().as_mut(), &part);
            for (index, pixel) in part.pixels.iter().enumerate() {
                let (x, y) = (index % 30 + 5, index / 30 + 3);
                assert_eq!(*pixel, all.pixels[y * 52 + x], "{x},{y}");
            }
        }
        let one = assert_order_is_free(&|| Box::new(ReferenceBackend::default()), &request);
        assert_eq!(bits(&finish(&mut reference(), &request)), bits(&one));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let one = pool.unwrap().install(|| finish(fast().as_mut(), &request));
        assert_eq!(bits(&finish(fast().as_mut(), &request)), bits(&one));
    }
}

#[test]
fn another_order_of_samples_would_be_noticed() {
    let mut request = long_paths(2, Method::Tracked, [52, 37]);
    let picture = finish(&mut CpuBackend::default(), &request);
    request.settings.seed += 1;
    let other = finish(&mut CpuBackend::default(), &request);
    assert_ne!(bits(&picture), bits(&other));
}
