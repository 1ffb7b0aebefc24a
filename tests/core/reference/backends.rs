//! The backends on processors: the same bytes whatever the slices, threads and pauses.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{CameraDesign, Design, Interpolation, Method};
use renderer_core::geometry::Camera;
use renderer_core::image::Picture;
use renderer_core::image::metrics;
use renderer_core::reference::ReferenceBackend;
use renderer_core::render::accumulation::{Accumulation, Pass, Sample};
use renderer_core::render::{
    Backend, BackendKind, Counters, Optimisation, Optimisations, Progress, RenderError,
    RenderRequest, Settings,
};
use renderer_core::sampling::Sampler;
use renderer_core::sampling::scramble_of;
use renderer_core::scene::compile;
use renderer_core::scene::lod::LodView;

use super::cloth::wild_towel;

const FOREVER: Duration = Duration::from_secs(3600);

/// A small towel seen from the side, `method`, 5 samples.
fn request(method: Method) -> RenderRequest {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (12, 14);
    (
        design.pile.layers,
        design.pile.resolution,
        design.pile.variants,
    ) = (5, 8, 2);
    let camera = Camera::from_design(&CameraDesign {
        distance: 22.0,
        ..CameraDesign::default()
    });
    RenderRequest {
        view: LodView::of(Arc::new(compile(&design).expect("a valid design")), camera),
        size: [61, 45],
        crop: [0, 0, 61, 45],
        settings: Settings {
            method,
            bounces: 3,
            traced_bounces: 0,
            step_mm: 0.05,
            samples: 5,
            error: 0.0,
            seed: 7,
            sampler: Sampler::Owen,
            shadows: true,
            aov: true,
            counters: true,
            optimisations: Optimisations::ALL,
            cached_shadows: 0,
            learns_bounces: false,
        },
    }
}

/// Works in slices until done.
fn finish(backend: &mut dyn Backend, slice: Duration) -> Progress {
    let cancel = AtomicBool::new(false);
    loop {
        let progress = backend.advance(slice, &cancel).expect("no device can fail");
        if progress.done {
            return progress;
        }
    }
}

fn render(backend: &mut dyn Backend, request: &RenderRequest, slice: Duration) -> Picture {
    backend.begin(request).expect("a valid size");
    let progress = finish(backend, slice);
    assert_eq!(progress.samples, request.settings.samples);
    backend.picture().expect("no device can fail")
}

/// Makes a backend.
type Make = fn() -> Box<dyn Backend>;

/// The backends that use all cores, and the methods that each draws.
const ON_ALL_CORES: [(Make, &[Method]); 2] = [
    (|| Box::new(CpuBackend::default()), FAST_METHODS),
    (|| Box::new(ReferenceBackend::on_all_cores()), Method::ALL),
];

/// The methods of the fast renderer.
const FAST_METHODS: &[Method] = &[Method::Single, Method::Layered, Method::Tracked];

/// Does something with so many threads.
fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    pool.expect("threads").install(work)
}

fn counters(backend: &mut dyn Backend) -> Counters {
    backend.counters().expect("no device can fail")
}

#[test]
fn same_bytes_whatever_slices_and_threads() {
    for (make, methods) in ON_ALL_CORES {
        for &method in methods {
            let request = request(method);
            let (expected, counted) = on_threads(1, || {
                let mut backend = make();
                let picture = render(backend.as_mut(), &request, FOREVER);
                (picture, counters(backend.as_mut()))
            });
            let lit = expected.pixels.iter().filter(|p| p[3] > 0.5 && p[0] > 0.01);
            assert!(
                lit.count() > 500,
                "the towel fills a good part of the picture"
            );

            let mut used = make();
            let name = used.kind().name();
            for slice in [FOREVER, Duration::ZERO, Duration::from_micros(300)] {
                assert!(
                    render(used.as_mut(), &request, slice) == expected,
                    "{name} {method:?} {slice:?}"
                );
                assert_eq!(counters(used.as_mut()), counted);
                // Something else in between, so that the next round starts anew.
                let mut other = request.clone();
                other.settings.seed += 1;
                assert!(render(used.as_mut(), &other, FOREVER) != expected);
            }
            // Another cloth in between.
            let mut other = request.clone();
            other.view.levels.nearest.scene = Arc::new(wild_towel(Interpolation::Linear));
            let picture = render(used.as_mut(), &other, FOREVER);
            assert!(picture == render(make().as_mut(), &other, FOREVER));
            assert!(picture != expected);
            assert!(render(used.as_mut(), &request, FOREVER) == expected);
            // Another number of threads than the machine's.
            let picture = on_threads(3, || render(make().as_mut(), &request, FOREVER));
            assert!(picture == expected, "{name} {method:?} on three threads");
            if used.kind() == BackendKind::Reference {
                let alone = render(&mut ReferenceBackend::default(), &request, FOREVER);
                assert!(alone == expected, "{method:?} on one core");
            }
        }
    }
}

#[test]
fn crops_are_parts_of_the_whole() {
    for (make, methods) in ON_ALL_CORES {
        for &method in methods {
            let mut request = request(method);
            // What tracing makes of background is a rounding off what is put where nothing else is seen, by tiles.
            request.settings.optimisations = request
                .settings
                .optimisations
                .without(Optimisation::BackgroundTiles);
            let whole = render(make().as_mut(), &request, FOREVER);
            let [x, y, width, height] = [13, 9, 30, 33];
            request.crop = [x, y, width, height];
            let crop = render(make().as_mut(), &request, FOREVER);
            assert_eq!(crop.size, [width, height]);
            for row in 0..height as usize {
                let start = (row + y as usize) * whole.size[0] as usize + x as usize;
                let expected = &whole.pixels[start..start + width as usize];
                assert_eq!(
                    &crop.pixels[row * width as usize..][..width as usize],
                    expected
                );
            }
        }
    }
}

#[test]
fn a_coarse_whole_picture_comes_first() {
    let request = request(Method::Single);
    let mut cpu = CpuBackend::default();
    cpu.begin(&request).expect("a valid size");
    let mut distances = Vec::new();
    let finished = render(&mut CpuBackend::default(), &request, FOREVER);
    let cancel = AtomicBool::new(false);
    loop {
        let progress = cpu
            .advance(Duration::ZERO, &cancel)
            .expect("no device can fail");
        let picture = cpu.picture().expect("no device can fail");
        // No pixel is ever empty: the background is not black.
        assert!(picture.pixels.iter().all(|p| *p != [0.0; 4]));
        let squares = picture.pixels.iter().zip(&finished.pixels);
        let sum: f32 = squares.map(|(a, b)| (a[3] - b[3]).powi(2)).sum();
        distances.push(sum.sqrt());
        if progress.samples > 0 {
            break;
        }
    }
    // It takes many slices to the first whole sample, and the picture gets nearer to the final one on the way.
    assert!(distances.len() > 30, "{distances:?}");
    assert!(
        distances[distances.len() - 1] < 0.6 * distances[0],
        "{distances:?}"
    );
}

#[test]
fn cancelling_stops_at_once_and_loses_nothing() {
    let request = request(Method::Single);
    for (make, _) in ON_ALL_CORES {
        let expected = render(make().as_mut(), &request, FOREVER);
        let mut backend = make();
        backend.begin(&request).expect("a valid size");
        let cancelled = AtomicBool::new(true);
        for _ in 0..3 {
            let progress = backend
                .advance(FOREVER, &cancelled)
                .expect("no device can fail");
            assert_eq!((progress.samples, progress.done), (0, false));
        }
        finish(backend.as_mut(), Duration::from_micros(200));
        assert!(backend.picture().expect("no device can fail") == expected);
    }
}

#[test]
fn targets_may_grow_without_a_new_start() {
    for (make, _) in ON_ALL_CORES {
        let mut request = request(Method::Single);
        request.settings.samples = 2;
        let mut used = make();
        render(used.as_mut(), &request, FOREVER);
        let rays = counters(used.as_mut()).rays;
        request.settings.samples = 5;
        let grown = render(used.as_mut(), &request, FOREVER);
        let all = counters(used.as_mut()).rays;
        assert!(rays * 2 < all && all < rays * 3, "{rays} then {all}");
        assert!(grown == render(make().as_mut(), &request, FOREVER));

        // Fewer samples than there are: the picture of fewer samples, not the one at hand.
        request.settings.samples = 3;
        let shrunk = render(used.as_mut(), &request, FOREVER);
        assert!(shrunk == render(make().as_mut(), &request, FOREVER));
    }
}

#[test]
fn an_error_target_ends_at_a_power_of_two() {
    let mut request = request(Method::Single);
    request.settings.bounces = 1;
    request.crop = [14, 10, 36, 24];
    (request.settings.samples, request.settings.error) = (1 << 16, 0.09);
    let mut cpu = CpuBackend::default();
    cpu.begin(&request).expect("a valid size");
    let progress = finish(&mut cpu, FOREVER);
    // More than the fewest samples at which an error may end a picture, or the rule would not be seen.
    assert!(
        progress.samples.is_power_of_two() && (32..1 << 10).contains(&progress.samples),
        "{progress:?}"
    );
    let estimate = progress.error_estimate.expect("enough samples");
    assert!(estimate <= 0.09, "{estimate}");
    let picture = cpu.picture().expect("no device can fail");

    // The estimate tells the true error: against 8 times the samples (an error 2.8 times smaller, which adds
    // 6 %). The estimate's own spread over 864 pixels of uneven noise is some 10 %.
    (request.settings.samples, request.settings.error) = (8 * progress.samples, 0.0);
    request.settings.seed += 1;
    let truth = render(&mut CpuBackend::default(), &request, FOREVER);
    let error = metrics::rel_rmse(&picture, &truth).expect("equal sizes");
    assert!(
        (0.8..1.25).contains(&(error / estimate)),
        "true {error}, estimated {estimate}"
    );
}

#[test]
fn the_error_estimate_is_the_spread_of_four_scrambles() {
    // Every sample of scramble s has the value (1 + s)·(1, 2, −1): independent means m_s, of which the variance of the
    // mean m of all n samples is Σ n_s(m_s − m)²/((k − 1)·n) times 1, 4 and 1; k scrambles have n_s samples.
    let colour = DVec3::new(1.0, 2.0, -1.0);
    let size = [36, 18];
    for (samples, mean, variance) in [
        (16, 1.5, 8.0 * 0.5 / 16.0),
        (32, 2.5, 8.0 * 5.0 / (3.0 * 32.0)),
        (
            40,
            2.2,
            (16.0 * 1.44 + 8.0 * (0.04 + 0.64 + 3.24)) / (3.0 * 40.0),
        ),
    ] {
        let mut accumulation = Accumulation::new(size, false);
        let last = (0..4 + samples - 1).fold(Pass::default(), |pass, _| pass.next());
        for tile in &mut accumulation.tiles {
            while !tile.has_finished(last) {
                tile.draw_row(|_, number| Sample {
                    radiance: colour * (1.0 + f64::from(scramble_of(number))),
                    first: None,
                });
            }
        }
        let (_, whole) = accumulation.errors().expect("enough samples");
        let estimate = whole.relative();
        // The mean of the three channels' means is 2/3 of `mean`.
        let expected = f64::sqrt(variance * (1.0 + 4.0 + 1.0) / 3.0) / (2.0 / 3.0 * mean);
        assert!(
            (estimate / expected - 1.0).abs() < 1e-9,
            "{samples} samples: {estimate} {expected}"
        );
        let [r, g, b] = [1.0, 2.0, -1.0].map(|c: f64| (c * mean) as f32);
        assert_eq!(accumulation.picture().pixels[0], [r, g, b, 0.0]);
    }

    let mut young = Accumulation::new([3, 3], false);
    assert!(young.errors().is_none());
    let black = Sample {
        radiance: DVec3::ZERO,
        first: None,
    };
    let sixteenth = (0..4 + 15).fold(Pass::default(), |pass, _| pass.next());
    while !young.tiles[0].has_finished(sixteenth) {
        young.tiles[0].draw_row(|_, _| black);
    }
    let (_, whole) = young.errors().expect("enough samples");
    assert_eq!(whole.relative(), 0.0);
}

#[test]
fn sizes_are_checked() {
    let valid = request(Method::Single);
    for (make, _) in ON_ALL_CORES {
        let mut backend = make();
        let mut fault = |size, crop| {
            let request = RenderRequest {
                size,
                crop,
                ..valid.clone()
            };
            match backend.begin(&request) {
                Err(RenderError::Size(message)) => message,
                other => panic!("{other:?}"),
            }
        };
        assert!(fault([0, 5], [0, 0, 1, 1]).contains("0x5"));
        assert!(fault([5, 20_000], [0, 0, 1, 1]).contains("16384"));
        assert!(fault([10, 10], [5, 5, 6, 1]).contains("5,5,6,1"));
        assert!(fault([10, 10], [0, 0, 0, 1]).contains("10x10"));
        assert!(fault([10, 10], [u32::MAX, 0, 2, 1]).contains("4294967295"));
    }
}

#[test]
fn methods_that_the_fast_renderer_lacks_are_refused() {
    let mut cpu = CpuBackend::default();
    for &method in Method::ALL {
        let begun = cpu.begin(&request(method));
        if FAST_METHODS.contains(&method) {
            begun.expect("one of its methods");
            continue;
        }
        let message = begun.expect_err("none of its methods");
        assert!(matches!(message, RenderError::Method { .. }), "{message}");
        let message = message.to_string();
        assert!(
            message.contains(&method.name()) && message.contains("the cpu backend"),
            "{message}"
        );
    }
}

#[test]
fn nothing_begun_is_done_and_empty() {
    let kinds = [BackendKind::Cpu, BackendKind::Reference];
    let alone: Make = || Box::new(ReferenceBackend::default());
    let [(fast, _), (plain, _)] = ON_ALL_CORES;
    for (make, kind) in [fast, plain, alone]
        .into_iter()
        .zip([kinds[0], kinds[1], kinds[1]])
    {
        let mut backend = make();
        assert_eq!(backend.kind(), kind);
        assert!(!backend.device_name().is_empty());
        assert!(finish(backend.as_mut(), FOREVER).done);
        assert_eq!(
            backend.picture().expect("no device can fail"),
            Picture::default()
        );
    }
}

#[test]
fn extra_channels_are_means_over_covered_samples() {
    for (make, methods) in ON_ALL_CORES {
        for &method in methods {
            extra_channels_are_means(make().as_mut(), request(method));
        }
    }
}

fn extra_channels_are_means(backend: &mut dyn Backend, mut request: RenderRequest) {
    let picture = render(backend, &request, FOREVER);
    let aov = picture.aov.as_ref().expect("asked for");
    let mut partly_covered = 0;
    for (index, pixel) in picture.pixels.iter().enumerate() {
        let (depth, normal) = (aov.depth[index], aov.normal[index]);
        let length = normal.map(|x| x * x).iter().sum::<f32>().sqrt();
        if pixel[3] == 0.0 {
            assert!(depth == 0.0 && length == 0.0);
            continue;
        }
        partly_covered += usize::from(pixel[3] < 1.0);
        // The sheet is 10 mm wide and 22 mm away; means of unit vectors are shorter.
        assert!((10.0..34.0).contains(&depth), "{depth}");
        assert!(length <= 1.0 + 1e-5);
        assert!(aov.albedo[index].iter().all(|a| (0.0..=1.0).contains(a)));
    }
    assert!(partly_covered > 20);

    request.settings.aov = false;
    let plain = render(backend, &request, FOREVER);
    assert!(plain.aov.is_none() && plain.pixels == picture.pixels);
    request.settings.counters = false;
    render(backend, &request, FOREVER);
    assert_eq!(counters(backend), Counters::default());
}
