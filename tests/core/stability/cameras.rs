//! Extreme cameras and extreme pile: finite everywhere, and device and processor draw what the reference draws.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, Method, PileKind};
use renderer_core::gpu::GpuBackend;
use renderer_core::image::Picture;
use renderer_core::reference::ReferenceBackend;
use renderer_core::render::Backend;

use crate::support::compare::{same_as_reference, same_means, same_samples, shows_something};
use crate::support::device::{exact_gpu, finish, gpu, on_reference, reference, repeats};
use crate::support::scenes::{request, small_towel};

const SIZE: [u32; 2] = [20, 16];

type Edit = (&'static str, fn(&mut Design));

/// Cameras where they are seldom put.
const CAMERAS: [Edit; 8] = [
    ("inside the pile", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.target, camera.distance, camera.fov) = ([0.2, 0.1, 1.2], 0.7, 90.0);
    }),
    ("inside the pile, level", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.target, camera.distance) = ([0.3, 0.3, 1.0], 1.5);
        camera.elevation = 0.0;
    }),
    ("below the sheet", |d| d.view.cameras[0].elevation = -70.0),
    ("straight down", |d| d.view.cameras[0].elevation = 90.0),
    ("in the sheet's plane", |d| {
        d.view.cameras[0].elevation = 0.0;
    }),
    ("at 1 mm", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.target, camera.distance) = ([0.0, 0.0, 2.5], 1.0);
    }),
    ("at 100 m", |d| {
        // A tenth of a degree, the narrowest view there is, shows 170 mm there.
        (d.sheet.warps, d.sheet.wefts) = (150, 170);
        let camera = &mut d.view.cameras[0];
        (camera.distance, camera.fov) = (100_000.0, 0.1);
    }),
    ("at 100 m, orthographic", |d| {
        let camera = &mut d.view.cameras[0];
        (camera.distance, camera.orthographic_height) = (100_000.0, Some(11.0));
    }),
];

/// Pile at the ends of its ranges.
const PILES: [Edit; 8] = [
    ("density 0", |d| d.pile.density = 0.0),
    ("density 10⁶", |d| d.pile.density = 1e6),
    ("thinnest", |d| d.pile.thickness = 0.01),
    ("thinnest and densest", |d| {
        (d.pile.thickness, d.pile.density) = (0.01, 1e6);
    }),
    ("1 layer", |d| d.pile.layers = 1),
    ("64 layers", |d| d.pile.layers = 64),
    ("resolution 4", |d| d.pile.resolution = 4),
    ("resolution 128", |d| d.pile.resolution = 128),
];

fn finite(picture: &Picture) -> bool {
    picture
        .pixels
        .iter()
        .flatten()
        .all(|value| value.is_finite() && *value >= 0.0)
}

/// Samples that agree by the methods that draw them, and finite ones by the others.
fn assert_agree(exact: &mut GpuBackend, what: &str, design: &Design, methods: &[Method]) {
    let mut design = design.clone();
    for &method in methods {
        design.quality.method = method;
        let request = request(&design, SIZE);
        let expected = on_reference(&request);
        assert!(finite(&expected), "{what}, {method:?}");
        let alone = finish(&mut ReferenceBackend::default(), &request);
        assert_eq!(expected.pixels, alone.pixels, "{what}, {method:?}");
        for backend in [&mut *exact as &mut dyn Backend, &mut CpuBackend::default()] {
            // Some methods are for the reference alone.
            if backend.begin(&request).is_err() {
                continue;
            }
            let what = format!("{what}, {method:?}, {}", backend.kind().name());
            let drawn = finish(backend, &request);
            assert!(finite(&drawn), "{what}");
            shows_something(&drawn).unwrap_or_else(|error| panic!("{what}: {error}"));
            // In the densest pile a ray ends at the first piece that is not quite empty, and rounding decides which is.
            let ends_by_rounding = method == Method::Exact && design.pile.density > 1e5;
            if method != Method::Tracked && !ends_by_rounding {
                same_as_reference(&request, &expected, &drawn)
                    .unwrap_or_else(|error| panic!("{what}: {error}"));
            }
        }
    }
}

fn all_agree(methods: &[Method]) {
    let mut exact = exact_gpu();
    for (what, edit) in CAMERAS.into_iter().chain(PILES) {
        let mut design = small_towel();
        edit(&mut design);
        assert_agree(&mut exact, what, &design, methods);
    }
}

#[test]
fn extreme_cameras_and_piles_draw_the_same_samples() {
    all_agree(&[Method::Single]);
}

#[test]
#[ignore = "long: about 30 s"]
fn extreme_cameras_and_piles_draw_the_same_samples_by_every_method() {
    all_agree(Method::ALL);
}

#[test]
#[ignore = "long: about 60 s"]
fn extreme_cameras_and_piles_have_the_same_expectation() {
    // Free paths of a millionth of a millimetre take minutes on the processor; the device's are never so short.
    let mut piles = PILES.to_vec();
    piles.retain(|(what, _)| !["density 10⁶", "thinnest and densest"].contains(what));
    for (what, edit) in CAMERAS.into_iter().chain(piles) {
        let mut design = small_towel();
        edit(&mut design);
        design.quality.method = Method::Tracked;
        (design.quality.samples, design.quality.bounces) = (4, 3);
        let request = request(&design, [16, 12]);
        let expected = repeats(&mut reference(), &request, 200);
        for backend in [&mut gpu() as &mut dyn Backend, &mut CpuBackend::default()] {
            let name = backend.kind().name();
            same_means(&expected, &repeats(backend, &request, 100))
                .unwrap_or_else(|error| panic!("{what}, {name}: {error}"));
        }
    }
}

/// Loops of very different lengths share cells: the steps in which a cell tells the heights of its loops are coarse,
/// and a ray just below a loop's top must still find it.
#[test]
fn a_loop_is_found_up_to_its_very_top() {
    let mut design = small_towel();
    let pile = &mut design.pile;
    pile.kind = PileKind::Cut;
    (pile.stretch, pile.length_jitter, pile.tilt, pile.jitter) = (0.5, 0.4, 4.0, 0.0);
    (pile.lean_x, pile.lean_y, pile.density) = (0.0, 0.0, 60.0);
    (pile.max_length, design.length.value) = (30.0, 14.0);
    design.turbulence.frequency = 0.9;
    let camera = &mut design.view.cameras[0];
    (camera.elevation, camera.target) = (1.0, [0.0, 0.0, 15.0]);
    (camera.distance, camera.orthographic_height) = (60.0, Some(16.0));
    let mut exact = exact_gpu();
    let request = request(&design, [40, 90]);
    let expected = on_reference(&request);
    shows_something(&expected).unwrap();
    for backend in [&mut exact as &mut dyn Backend, &mut CpuBackend::default()] {
        same_samples(&request, &expected, &finish(backend, &request)).unwrap();
    }
}
