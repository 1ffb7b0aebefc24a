//! Shadows that a picture's first samples share (`Settings::cached_shadows`): the grid, what is saved, what it costs in
//! accuracy, and when what was learned is kept.

use std::collections::HashSet;
use std::sync::Arc;

use glam::DVec3;
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{AreaLight, Colour, Design, Method};
use renderer_core::geometry::{Camera, Projection};
use renderer_core::image::{Picture, metrics};
use renderer_core::render::shadow_cache::{ShadowGrid, TEXEL_PX};
use renderer_core::render::{Backend, Counters, RenderRequest};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Scene, compile};

use crate::support::closed::closed;
use crate::support::device::{exact_gpu, finish};
use crate::support::scenes::{request, small_towel};

/// Texels of the towel's cache see hundreds of rays a sample.
const SIZE: [u32; 2] = [128, 96];
/// Where it matters only whether they are known.
const SMALL: [u32; 2] = [72, 54];

fn towel(method: Method, bounces: u32, samples: u32, cached: u32) -> RenderRequest {
    let mut design = small_towel();
    (design.quality.method, design.quality.samples) = (method, samples);
    design.quality.bounces = bounces;
    with_counters(&design, cached)
}

/// A counted picture whose light is estimated after the first of several scatterings, as in a view that shares shadows.
fn with_counters(design: &Design, cached: u32) -> RenderRequest {
    let traced_bounces = u32::from(design.quality.bounces > 1);
    let mut request = request(closed(design, traced_bounces), SIZE);
    request.settings.counters = true;
    request.settings.cached_shadows = cached;
    request
}

/// A request for a picture of [`SMALL`] pixels, else as given.
fn smaller(request: RenderRequest) -> RenderRequest {
    RenderRequest {
        size: SMALL,
        crop: [0, 0, SMALL[0], SMALL[1]],
        ..request
    }
}

fn draw(backend: &mut dyn Backend, request: &RenderRequest) -> (Picture, Counters) {
    (finish(backend, request), backend.counters().unwrap())
}

fn grid(pixel_mm: f64, edit: impl Fn(&mut Design)) -> ShadowGrid {
    let mut design = small_towel();
    edit(&mut design);
    ShadowGrid::new(&compile(&design).unwrap(), pixel_mm)
}

#[test]
fn points_ask_texels_around_them() {
    // Texels of half a cell, of one and of four.
    for pixel_mm in [0.07, 0.2, 0.5] {
        let grid = grid(pixel_mm, |_| {});
        let [x, y, _] = grid.texels.map(|n| n as usize);
        assert!(grid.layers_below > 0 && grid.layers_below < grid.texels[2]);
        let below_plane = x * y * grid.layers_below as usize;
        let mut random = Pcg::new(7, 0);
        let mut next = || f64::from(random.next_float());
        for _ in 0..10_000 {
            let [px, py] = [next(), next()].map(|share| 20.0 * share - 10.0);
            let point = DVec3::new(px, py, 6.0 * next() - 3.0);
            let texel = grid.texel(point, [next(), next(), next()]);
            assert!(grid.index(texel) < grid.texel_count());
            // Never through the plane of the sheet, where shadows change most.
            assert_eq!(grid.index(texel) < below_plane, point.z < 0.0, "{point}");
            let own = grid.texel(point, [0.5; 3]);
            for (a, b) in texel.into_iter().zip(own) {
                assert!(a.abs_diff(b) <= 1);
            }
        }
        // A point asks its two nearest texels along x by their distance from it.
        let cells = f64::from(1_u32 << grid.shift) / f64::from(grid.per_cell);
        let left = -0.5 * f64::from(small_towel().sheet.warps);
        let times = |place: f64| {
            let point = DVec3::new((left + place * cells) * pitch(), 0.1, 1.0);
            let column = |r: f64| grid.texel(point, [r, 0.5, 0.5])[0];
            (0..1000)
                .filter(|k| column((f64::from(*k) + 0.5) / 1000.0) == place as usize)
                .count()
        };
        // In the middle of a texel always that one; a quarter from its edge three times of four.
        assert_eq!(times(1.5), 1000, "{grid:?}");
        assert!((745..=755).contains(&times(1.25)) && (745..=755).contains(&times(1.75)));
    }
}

/// Width of the small towel's cells, mm.
fn pitch() -> f64 {
    10.0 / small_towel().sheet.warps_per_cm
}

#[test]
fn texels_are_some_pixels_wide_and_fit_their_room() {
    let of = |cells: u32, pixel_mm: f64| {
        grid(pixel_mm, |design| {
            (design.sheet.warps, design.sheet.wefts) = (cells, cells);
            // Bare cloth compiles at once.
            design.length.value = 0.0;
        })
    };
    let narrow = 10.0 / small_towel().sheet.wefts_per_cm;
    let narrow = narrow.min(pitch());
    let width_mm =
        |grid: &ShadowGrid| narrow * f64::from(1_u32 << grid.shift) / f64::from(grid.per_cell);
    for cells in [16, 128, 512, 1024, 4000] {
        for pixel_mm in [0.01, 0.1, 1.0, 10.0] {
            let grid = of(cells, pixel_mm);
            let [x, y] = grid.pages();
            assert!(x * y <= 1 << 20, "{grid:?}");
            let room = grid.most_pages() * grid.page_entries();
            assert!((1..=1 << 22).contains(&room), "{grid:?}");
            let whole_sheet = grid.texels[0] == 1 && grid.texels[1] == 1;
            assert!(
                whole_sheet || width_mm(&grid) >= TEXEL_PX * pixel_mm,
                "{grid:?}"
            );
            // No wider than need be, where there is room.
            if cells == 16 && pixel_mm > 0.05 && !whole_sheet {
                assert!(width_mm(&grid) < 2.0 * TEXEL_PX * pixel_mm, "{grid:?}");
            }
        }
    }
}

#[test]
fn every_texel_has_a_place_of_its_own() {
    let grid = grid(0.2, |design| {
        (design.sheet.warps, design.sheet.wefts) = (41, 23);
        design.length.value = 2.0;
    });
    let [x, y, z] = grid.texels.map(|n| n as usize);
    let mut places = HashSet::new();
    for texel in (0..z).flat_map(|z| (0..y).flat_map(move |y| (0..x).map(move |x| [x, y, z]))) {
        let (page, place) = grid.place(texel);
        let [across, along] = grid.pages();
        assert!(page < (across * along) as usize);
        assert!(place % grid.lights as usize == 0 && place < grid.page_entries());
        assert!(places.insert((page, place)), "{texel:?}");
    }
    // Wider ones are whole cells.
    let of_cells = grid.of_cells(&compile(&small_towel()).unwrap(), 100);
    assert!(
        of_cells.texel_count() <= 100
            && of_cells.per_cell == 1
            && of_cells.texels[2] == grid.texels[2]
    );
}

#[test]
fn pixels_are_as_wide_as_they_look() {
    let mut design = small_towel();
    let width = |design: &Design| Camera::from_design(&design.view.cameras[0]).pixel_mm(100);
    let camera = &mut design.view.cameras[0];
    (camera.target, camera.distance, camera.fov, camera.elevation) = ([0.0; 3], 50.0, 90.0, 30.0);
    assert!((width(&design) - 1.0).abs() < 1e-9);
    // Level rays never meet the sheet.
    design.view.cameras[0].elevation = 0.0;
    assert!(width(&design).is_finite());
    design.view.cameras[0].orthographic_height = Some(30.0);
    assert_eq!(width(&design), 0.3);
}

#[test]
fn known_shadows_save_rays_and_leave_the_mean() {
    for (method, bounces) in [
        (Method::Single, 1),
        (Method::Layered, 8),
        (Method::Tracked, 8),
    ] {
        let name = method.name();
        let mut cpu = CpuBackend::default();
        let (plain, all) = draw(&mut cpu, &towel(method, bounces, 16, 0));
        let (shared, some) = draw(&mut cpu, &towel(method, bounces, 16, 16));
        assert_eq!(all.cached_rays, 0);
        // Light from a near rectangle is shared as a sun's is: each texel learns its own.
        let lit = |cached| {
            let mut design = small_towel();
            design.light.sun.clear();
            design.light.area = vec![AreaLight {
                distance: 20.0,
                width: 12.0,
                height: 12.0,
                irradiance: 3.0,
                ..AreaLight::default()
            }];
            (design.quality.method, design.quality.samples) = (method, 16);
            design.quality.bounces = bounces;
            with_counters(&design, cached)
        };
        let [(apart, _), (together, few)] = [0, 16].map(|cached| draw(&mut cpu, &lit(cached)));
        assert!(few.cached_rays > 10_000, "{name}: {few:?}");
        let brightness = metrics::mean(&together) / metrics::mean(&apart) - 1.0;
        eprintln!("{name}: area light, mean {brightness:+.4}");
        assert!(brightness.abs() < 0.008, "{name}: {brightness}");

        let asked = some.shadow_rays + some.cached_rays;
        let share = some.cached_rays as f64 / asked as f64;
        let brightness = metrics::mean(&shared) / metrics::mean(&plain) - 1.0;
        let error = metrics::rel_rmse(&shared, &plain).unwrap();
        eprintln!("{name}: {share:.3} cached, mean {brightness:+.4}, relRMSE {error:.3}");
        assert!(share > 0.4, "{some:?}");
        // Means of a texel are made by the points that ask it: 0.0003 to 0.0025 here. Means that stand in for those of
        // bounced light, or these for them, are 0.012 off and more.
        assert!(brightness.abs() < 0.008, "{name}: {brightness}");
        // Blurred over a few pixels: another picture, but no other cloth.
        assert!((0.005..0.25).contains(&error), "{name}: {error}");
    }
}

#[test]
fn the_first_sample_and_later_ones_are_traced() {
    // One sample learns; what it draws is what is drawn without. Of more, the bias falls with their number.
    let towel = |method, bounces, samples, cached| smaller(towel(method, bounces, samples, cached));
    let mut cpu = CpuBackend::default();
    let plain = finish(&mut cpu, &towel(Method::Single, 1, 1, 0));
    let learning = finish(&mut CpuBackend::default(), &towel(Method::Single, 1, 1, 1));
    assert_eq!(plain, learning);

    let mut truth = towel(Method::Single, 1, 512, 0);
    truth.settings.seed = 77;
    let truth = finish(&mut cpu, &truth);
    let error = |cached| {
        let (picture, counters) = draw(
            &mut CpuBackend::default(),
            &towel(Method::Single, 1, 256, cached),
        );
        (
            metrics::rel_rmse(&picture, &truth).unwrap(),
            counters.cached_rays,
        )
    };
    let [(none, _), (some, few), (all, many)] = [0, 8, 64].map(error);
    eprintln!("relRMSE of 256 samples: {none:.4}, 8 cached {some:.4}, 64 cached {all:.4}");
    assert!(few > 0 && many > 6 * few);
    assert!(some < all && some < 1.5 * none, "{none} {some} {all}");
}

#[test]
fn a_moved_camera_finds_what_was_learned_and_another_cloth_or_light_nothing() {
    let mut gpu = exact_gpu();
    let mut cpu = CpuBackend::default();
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let name = backend.kind().name();
        let mut first = smaller(towel(Method::Single, 1, 4, 8));
        let (_, counters) = draw(backend, &first);
        assert!(counters.cached_rays > 0, "{name}");
        first.settings.samples = 1;
        let mut cached = |request: &RenderRequest| draw(backend, request).1.cached_rays;

        let mut moved = first.clone();
        moved.view.levels.nearest.camera.eye.x += 0.3;
        assert!(cached(&moved) > 150, "{name}");
        // Colours throw no shadows.
        let mut red = small_towel();
        red.quality.method = Method::Single;
        (red.quality.samples, red.quality.bounces) = (1, 1);
        red.chart.colour = Colour([120, 0, 0]);
        let other = |request: &RenderRequest, edit: fn(&mut Design)| {
            let mut design = red.clone();
            edit(&mut design);
            let mut compiled = smaller(with_counters(&design, 8));
            compiled.view.levels.nearest.camera = *request.camera();
            compiled
        };
        let mut scene = Scene::clone(first.scene());
        scene.looks = other(&first, |_| {}).scene().looks.clone();
        let mut dyed = first.clone();
        dyed.view.levels.nearest.scene = Arc::new(scene);
        assert!(cached(&dyed) > 150, "{name}");
        // Pictures of several seeds are averaged, and must not have learned from each other; another method sees other
        // shadows, and other texels have other numbers.
        for edit in [
            (|request| request.settings.seed += 1) as fn(&mut RenderRequest),
            |request| request.settings.method = Method::Layered,
            |request| {
                request.view.levels.nearest.camera.projection = Projection::Perspective { fov: 0.1 }
            },
        ] {
            let mut edited = first.clone();
            edit(&mut edited);
            assert_eq!(cached(&edited), 0, "{name}: {:?}", edited.settings);
            let mut again = first.clone();
            again.settings.samples = 4;
            assert!(cached(&again) > 150, "{name}");
        }
        // Cloth and light that have the same texels, and cloth that has not.
        for edit in [
            (|design| design.pile.density *= 2.0) as fn(&mut Design),
            |design| design.light.sun[0].azimuth += 40.0,
            |design| design.length.value *= 1.1,
        ] {
            assert_eq!(cached(&other(&first, edit)), 0, "{name}");
            // What was learned of the old cloth is gone with it.
            assert_eq!(cached(&first), 0, "{name}");
            let mut again = first.clone();
            again.settings.samples = 4;
            assert!(cached(&again) > 150, "{name}");
        }
        let mut plain = first.clone();
        plain.settings.cached_shadows = 0;
        assert_eq!(cached(&plain), 0, "{name}");
    }
}

#[test]
fn the_gpu_shares_the_same_shadows() {
    for (method, bounces) in [
        (Method::Single, 1),
        (Method::Layered, 8),
        (Method::Exact, 1),
    ] {
        let name = method.name();
        let request = towel(method, bounces, 6, 5);
        if method == Method::Exact {
            // The processor draws it by the reference, which caches nothing.
            let (_, counted) = draw(&mut exact_gpu(), &smaller(request));
            assert!(counted.cached_rays > 0, "{name}");
            continue;
        }
        let (drawn, counted) = draw(&mut exact_gpu(), &request);
        assert!(counted.cached_rays > 0, "{name}");
        let (expected, counters) = draw(&mut CpuBackend::default(), &request);
        let [a, b] = [counters.cached_rays, counted.cached_rays].map(|rays| rays as f64);
        assert!((a / b - 1.0).abs() < 0.01, "{name}: {a} {b}");
        let error = metrics::rel_rmse(&drawn, &expected).unwrap();
        eprintln!("{name}: relRMSE {error:.5}");
        // A pixel that turns on rounding is another ray in a texel's mean of hundreds, and in a picture of six samples:
        // 0.0005 and 0.0012. Direct shadows in the place of those of bounced light make 0.007 of it.
        assert!(error < 0.003, "{name}: {error}");
        let plain = towel(method, bounces, 6, 0);
        let other = finish(&mut CpuBackend::default(), &plain);
        assert!(metrics::rel_rmse(&drawn, &other).unwrap() > 2.0 * error);
        assert_ne!(drawn.pixels, other.pixels);
    }
}
