//! Tiles that are left out: those that show background alone, and those whose error is small enough.

mod converged;

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use glam::{DVec2, DVec3};
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{CameraDesign, Colour, Design};
use renderer_core::geometry::Camera;
use renderer_core::gpu::GpuBackend;
use renderer_core::image::Picture;
use renderer_core::render::{
    Backend, Counters, Optimisation, Progress, RenderRequest, background_tiles, cloth_box,
};
use renderer_core::sampling::Pcg;

use crate::support::device::gpu;
use crate::support::scenes::{request, small_towel};

const TILE: usize = 16;

/// Draws to the end.
fn draw(backend: &mut dyn Backend, request: &RenderRequest) -> (Picture, Counters, Progress) {
    backend.begin(request).unwrap();
    let never = AtomicBool::new(false);
    loop {
        let progress = backend.advance(Duration::from_secs(1), &never).unwrap();
        if progress.done {
            return (
                backend.picture().unwrap(),
                backend.counters().unwrap(),
                progress,
            );
        }
    }
}

/// Both backends.
fn backends() -> (GpuBackend, CpuBackend) {
    (gpu(), CpuBackend::default())
}

fn without(request: &RenderRequest, skip: Optimisation) -> RenderRequest {
    let mut request = request.clone();
    request.settings.optimisations = request.settings.optimisations.without(skip);
    request
}

/// A small towel seen from far, with much around it.
fn far_towel(background: Colour) -> Design {
    let mut design = small_towel();
    design.view.cameras[0].distance = 60.0;
    design.light.background = background;
    design.quality.samples = 5;
    design
}

/// All numbers of the pixels of a tile.
fn numbers(picture: &Picture, [column, row]: [usize; 2]) -> Vec<u32> {
    let [width, height] = picture.size.map(|side| side as usize);
    let mut numbers = Vec::new();
    for y in row * TILE..((row + 1) * TILE).min(height) {
        for x in column * TILE..((column + 1) * TILE).min(width) {
            let at = y * width + x;
            numbers.extend(picture.pixels[at].map(f32::to_bits));
            if let Some(aov) = &picture.aov {
                numbers.push(aov.depth[at].to_bits());
                numbers.extend(aov.normal[at].map(f32::to_bits));
                numbers.extend(aov.albedo[at].map(f32::to_bits));
            }
        }
    }
    numbers
}

fn all_numbers(picture: &Picture) -> Vec<Vec<u32>> {
    let [columns, rows] = picture.size.map(|side| (side as usize).div_ceil(TILE));
    (0..columns * rows)
        .map(|tile| numbers(picture, [tile % columns, tile / columns]))
        .collect()
}

#[test]
fn tiles_of_background_are_what_tracing_makes_of_them() {
    let (mut gpu, mut cpu) = backends();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let name = backend.kind().name();
        // White adds up without rounding: same bits. Other sums are rounded with every sample, at most 5 times by half
        // of 2⁻²³ of them.
        for (background, tolerance) in [
            (Colour::WHITE, 0.0),
            (Colour([77, 130, 201]), 5.0 * 2.0_f32.powi(-24)),
        ] {
            let mut request = request(&far_towel(background), [100, 83]);
            (request.settings.counters, request.settings.aov) = (true, true);
            let (on, skipped, progress) = draw(backend, &request);
            let (off, traced, _) = draw(backend, &without(&request, Optimisation::BackgroundTiles));
            assert_eq!(progress.samples, 5);
            // 42 tiles of 5 samples.
            assert!(skipped.skipped_tiles.is_multiple_of(5), "{skipped:?}");
            assert!(
                (50..200).contains(&skipped.skipped_tiles),
                "{name}: {skipped:?}"
            );
            assert_eq!(traced.skipped_tiles, 0);
            assert!(skipped.rays < traced.rays - traced.rays / 5);
            assert_eq!(on.aov, off.aov);
            for (a, b) in on.pixels.iter().zip(&off.pixels) {
                for c in 0..4 {
                    assert!(
                        (a[c] - b[c]).abs() <= tolerance * b[c],
                        "{name}: {a:?} {b:?}"
                    );
                }
            }
            let estimates =
                [&request, &without(&request, Optimisation::BackgroundTiles)].map(|request| {
                    let mut request = request.clone();
                    request.settings.samples = 16;
                    draw(backend, &request).2.error_estimate.unwrap()
                });
            let [on, off] = estimates;
            assert!((on / off - 1.0).abs() < 1e-5, "{name}: {on} {off}");
        }
    }
}

#[test]
fn a_picture_of_background_is_done_at_once() {
    let mut design = far_towel(Colour([10, 200, 30]));
    design.view.cameras[0].target = [500.0, 0.0, 0.0];
    let mut request = request(&design, [40, 30]);
    request.settings.counters = true;
    let (mut gpu, mut cpu) = backends();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let (picture, counters, progress) = draw(backend, &request);
        let [r, g, b] = request.scene().lights.background.map(|c| c as f32);
        assert!(picture.pixels.iter().all(|pixel| *pixel == [r, g, b, 0.0]));
        assert_eq!((counters.rays, counters.skipped_tiles), (0, 6 * 5));
        assert_eq!((progress.samples, progress.error_estimate), (5, Some(0.0)));
        // More samples are there as soon as they are asked for.
        request.settings.samples = 9;
        assert_eq!(draw(backend, &request).2.samples, 9);
        request.settings.samples = 5;
    }
}

/// Cameras around, above, below, beside and inside the cloth, of both kinds.
fn cameras() -> Vec<CameraDesign> {
    let mut random = Pcg::new(11, 5);
    let mut cameras = Vec::new();
    for index in 0..60 {
        let mut number = |low: f64, high: f64| low + f64::from(random.next_float()) * (high - low);
        cameras.push(CameraDesign {
            target: [number(-9.0, 9.0), number(-9.0, 9.0), number(-1.0, 3.0)],
            azimuth: number(-180.0, 180.0),
            elevation: number(-89.0, 89.0),
            distance: [0.5, 4.0, 20.0, 60.0][index % 4],
            fov: number(10.0, 110.0),
            orthographic_height: (index % 3 == 0).then(|| number(5.0, 60.0)),
            ..CameraDesign::default()
        });
    }
    cameras
}

/// Whether a ray meets a box.
fn meets((origin, direction): (DVec3, DVec3), [low, high]: [DVec3; 2]) -> bool {
    let (a, b) = ((low - origin) / direction, (high - origin) / direction);
    a.min(b).max_element().max(0.0) <= a.max(b).min_element()
}

/// Tiles among `found` through which a ray meets the box; and tiles that were not found though no ray comes near it.
fn wrong_tiles(request: &RenderRequest, found: &[bool]) -> [u32; 2] {
    let [low, high] = cloth_box(request.scene());
    let wide = [low - 0.1, high + 0.1];
    let columns = request.crop[2].div_ceil(TILE as u32);
    let mut wrong = [0; 2];
    for (tile, &is_background) in (0_u32..).zip(found) {
        let corner = [tile % columns, tile / columns].map(|index| f64::from(index) * TILE as f64);
        let places = (0..17 * 17).map(|k| DVec2::new(f64::from(k % 17), f64::from(k / 17)));
        let rays = places.map(|place| {
            let pixel = DVec2::from_array(corner) + place;
            request.camera().ray(pixel, request.size)
        });
        let rays: Vec<_> = rays.collect();
        wrong[0] += u32::from(is_background && rays.iter().any(|ray| meets(*ray, [low, high])));
        wrong[1] += u32::from(!is_background && !rays.iter().any(|ray| meets(*ray, wide)));
    }
    wrong
}

#[test]
fn exactly_the_tiles_without_cloth_are_found() {
    let mut request = request(&small_towel(), [160, 128]);
    let (mut tiles, mut background, mut shifted) = (0, 0, 0);
    for camera in cameras() {
        request.view.levels.nearest.camera = Camera::from_design(&camera);
        let found = background_tiles(&request, TILE as u32);
        tiles += found.len();
        background += found.iter().filter(|is| **is).count();
        let wrong = wrong_tiles(&request, &found);
        assert_eq!(wrong, [0, 0], "{camera:?}");
        let mut moved = found.clone();
        moved.rotate_right(1);
        shifted += wrong_tiles(&request, &moved)[0];
    }
    // Both kinds are there, and tiles found one beside where they are would be noticed.
    assert!(background > tiles / 5 && background < 4 * tiles / 5);
    assert!(shifted > 50, "{shifted}");
}
