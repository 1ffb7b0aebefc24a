//! Cloth without end, level by level of detail: a picture needs cells in proportion to its own size, each row is drawn
//! as fine as it shows the cloth, levels give way to each other without a step, and every renderer draws them alike.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Colour, Design, Method};
use renderer_core::geometry::Camera;
use renderer_core::image::{Picture, metrics};
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::sampling::hash;
use renderer_core::scene::lod::{
    Level, Levels, LodBudget, LodCloth, LodCompiler, LodPlan, LodRegion, LodSelector, LodView,
};
use renderer_core::scene::{Cancel, CompileError, Scene, compile};

use crate::lod_regions::{at_lod, compiled, differing};
use crate::support::device::{exact_gpu, finish, reference};
use crate::support::scenes::{load_design, preset_path, request, small_towel};

/// A cloth of 10⁸ cells.
fn endless() -> Design {
    let mut design = small_towel();
    (design.sheet.warps, design.sheet.wefts) = (10_000, 10_000);
    design
}

fn seen_from(design: &mut Design, distance: f64) -> Camera {
    design.view.cameras[0].distance = distance;
    Camera::from_design(&design.view.cameras[0])
}

fn cells(plan: &LodPlan) -> u64 {
    plan.regions.iter().map(LodRegion::len).sum()
}

fn planned(design: &Design, camera: &Camera, size: [u32; 2], most: LodBudget) -> LodPlan {
    LodPlan::new(design, camera, size, most, None)
}

/// The request of a plan whose scenes are all the same small one: for asking which level a row shows.
fn without_scenes(design: &Design, camera: &Camera, size: [u32; 2], plan: &LodPlan) -> LodView {
    let mut small = design.clone();
    (small.sheet.warps, small.sheet.wefts) = (2, 2);
    let scene = Arc::new(compile(&small).unwrap());
    let farther = plan.regions[1..].iter();
    let farther = farther.map(|_| Arc::clone(&scene)).collect();
    let cloth = LodCloth {
        plan: plan.clone(),
        scenes: Levels {
            nearest: scene,
            farther,
        },
    };
    cloth.view(design, camera, size)
}

#[test]
fn a_scene_is_as_large_as_its_picture_not_as_the_cloth() {
    let mut design = endless();
    let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
    let size = [80, 60];
    let mut most = 0;
    for distance in [20.0, 100.0, 500.0, 2500.0, 1e4, 5e4, 2e5] {
        let camera = seen_from(&mut design, distance);
        let plan = planned(&design, &camera, size, LodBudget::FINAL);
        most = most.max(cells(&plan));
        // Near by it is the cloth itself; from afar loops are a quarter as wide as a pixel at most.
        let first = &plan.regions[0];
        let pixel_mm = camera.pixel_mm_at(DVec3::ZERO, size[1]);
        let grown_mm = pitch / first.scale();
        assert!(
            first.lod == 0 || grown_mm <= 0.25 * pixel_mm,
            "{distance}: {first:?}"
        );
        assert!(first.lod > 0 || pixel_mm < 16.0 * pitch, "{distance}");
        for pair in plan.regions.windows(2) {
            assert_eq!(pair[1].lod, pair[0].lod + 1, "{distance}");
        }
    }
    // 64 to 256 cells a pixel and a quarter of that, and what is beside the picture.
    assert!(most < 600 * u64::from(size[0] * size[1]), "{most}");

    // A cloth of a hundredth of the cells has the same scene.
    let camera = seen_from(&mut design, 40.0);
    let bytes = |design: &Design| {
        let plan = planned(design, &camera, size, LodBudget::LIVE);
        let cloth = LodCompiler::default().make(design, plan, &Cancel::never());
        let cloth = cloth.unwrap();
        let bytes = |scene: &Arc<Scene>| scene.loops.bytes() + 8 * scene.looks.len();
        let first = cloth.plan.regions[0].cells;
        (first, cloth.scenes.iter().map(bytes).sum::<usize>())
    };
    let mut smaller = design.clone();
    (smaller.sheet.warps, smaller.sheet.wefts) = (2496, 2496);
    let ([columns, rows], large) = bytes(&design);
    let (cells, small) = bytes(&smaller);
    // Regions begin at multiples of 32 cells, which lie otherwise.
    assert!(columns.abs_diff(cells[0]) <= 64 && rows.abs_diff(cells[1]) <= 64);
    assert!(
        (0.5..2.0).contains(&(large as f64 / small as f64)),
        "{large} {small}"
    );
}

#[test]
fn views_along_the_cloth_show_what_is_near_as_it_is() {
    let mut design = endless();
    let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
    let view = &mut design.view.cameras[0];
    (view.elevation, view.azimuth) = (8.0, -70.0);
    let size = [320, 200];
    for (distance, elevation) in [(200.0, 8.0), (1000.0, 8.0), (1000.0, -20.0), (4000.0, 30.0)] {
        design.view.cameras[0].elevation = elevation;
        let camera = seen_from(&mut design, distance);
        for most in [LodBudget::FINAL, LodBudget::LIVE] {
            let plan = planned(&design, &camera, size, most);
            assert!(cells(&plan) <= most.cells, "{distance}: {}", cells(&plan));
            let rows = without_scenes(&design, &camera, size, &plan).rows(size[1]);
            let (mut seen, mut finest, mut coarsest) = (0, f64::INFINITY, 0.0_f64);
            for index in 0..4000_u32 {
                let number = |salt: u32| f64::from(hash(4 * index + salt)) / 2_f64.powi(32);
                let pixel = DVec2::new(number(0) * 320.0, number(1) * 200.0);
                let (origin, direction) = camera.ray(pixel, size);
                let t = -origin.z / direction.z;
                let at = origin + direction * t;
                let half = 0.5 * 10_000.0 * pitch - 100.0;
                if !(t > 0.0 && at.x.abs() < half && at.y.abs() < half) {
                    continue;
                }
                seen += 1;
                let (level, share) = rows.of_row(pixel.y as u32);
                for level in level..=level + usize::from(share > 0.0) {
                    let region = &plan.regions[level];
                    // What a row shows is there, in each of its levels.
                    for axis in 0..2 {
                        let cell = (at[axis] / pitch + 5000.0) * region.scale();
                        let from = f64::from(region.first[axis]);
                        let to = from + f64::from(region.cells[axis]);
                        assert!((from..to).contains(&cell), "{region:?} {cell}");
                    }
                }
                let loop_px = pitch / plan.regions[level].scale() / camera.pixel_mm_at(at, size[1]);
                if plan.regions[level].lod > 0 {
                    (finest, coarsest) = (finest.min(loop_px), coarsest.max(loop_px));
                }
            }
            assert!(seen > 500, "{seen}");
            // However far away, loops are about as wide in the picture: within a factor of two, and of what the plane
            // they are measured in lies beside the one that levels are chosen by.
            assert!(
                coarsest == 0.0 || coarsest <= 2.6 * finest,
                "{distance}, {elevation}°: {finest} to {coarsest} px"
            );
        }
    }
}

#[test]
fn small_bent_and_filtered_cloth_is_made_whole() {
    let mut design = endless();
    let camera = seen_from(&mut design, 40.0);
    let needs = |design: &Design| {
        let plan = LodPlan::new(design, &camera, [64, 48], LodBudget::LIVE, None);
        !plan.regions.is_empty()
    };
    assert!(needs(&design));
    let mut small = design.clone();
    small.sheet.wefts = 400;
    assert!(!needs(&small));
    let mut bent = design.clone();
    bent.form.kind = renderer_core::design::FormKind::Wave;
    let mut filtered = design.clone();
    filtered.turbulence.filter = renderer_core::design::Filter::Box;
    // What each may have is reported with what would allow more.
    for (design, advice) in [(&bent, "form.kind"), (&filtered, "turbulence.filter")] {
        assert!(!needs(design));
        let Err(CompileError::Invalid(faults)) = compile(design) else {
            panic!("too large");
        };
        let message = faults[0].to_string();
        assert!(
            faults.len() == 1 && message.contains("sheet.wefts") && message.contains(advice),
            "{message}"
        );
    }
    // What makes all of a cloth at once says so.
    assert!(design.faults().is_empty());
    let message = compile(&design).unwrap_err().to_string();
    assert!(message.contains("at most 16000000 crossings"), "{message}");
}

#[test]
fn regions_are_kept_while_they_hold_what_is_seen() {
    let mut design = endless();
    let size = [320, 240];
    let seen = |design: &Design, x: f64, last: Option<&LodPlan>| {
        let mut view = design.view.cameras[0].clone();
        view.target[0] = x;
        let camera = Camera::from_design(&view);
        LodPlan::new(design, &camera, size, LodBudget::LIVE, last)
    };
    seen_from(&mut design, 300.0);
    let first = seen(&design, 0.0, None);
    assert_eq!(seen(&design, 3.0, Some(&first)), first);
    let there = seen(&design, 200.0, Some(&first));
    assert_ne!(there, first);
    assert_eq!(there, seen(&design, 200.0, None));
    let [near, far] = [&first, &there].map(|plan| &plan.regions[0]);
    assert!(!near.holds(far) && near.holds(near));
    // One that is halved more often is not what is seen.
    let mut coarse = first.clone();
    coarse.regions = vec![at_lod(&design, 4)];
    assert_eq!(seen(&design, 0.0, Some(&coarse)), first);
    // Beside the cloth something is made all the same, and views along the cloth's plane have an end.
    assert!(cells(&seen(&design, 1e5, None)) > 0);
    for elevation in [0.0, 0.01] {
        design.view.cameras[0].elevation = elevation;
        assert!(cells(&seen(&design, 0.0, None)) <= LodBudget::LIVE.cells);
    }
}

/// A view along a cloth of three levels, of which only the first is the cloth's own: rows of each, and of two at a
/// time.
fn three_levels() -> (Design, RenderRequest) {
    let mut design = small_towel();
    (design.sheet.warps, design.sheet.wefts) = (96, 96);
    design.quality.method = Method::Single;
    let view = &mut design.view.cameras[0];
    (view.elevation, view.distance, view.fov) = (14.0, 60.0, 50.0);
    let whole = request(&design, [40, 48]);
    let level = |lod: u32| {
        let region = at_lod(&design, lod);
        Level {
            scene: compiled(&design, region),
            camera: region.camera(&design, whole.camera()),
        }
    };
    let view = LodView {
        levels: Levels {
            nearest: whole.view.levels.nearest.clone(),
            farther: vec![level(1), level(2)],
        },
        // From ¹⁄₆ in the first row to 1 in the last.
        selector: LodSelector {
            at_top: 0.1,
            down: 0.95,
        },
    };
    (design, RenderRequest { view, ..whole })
}

#[test]
fn rows_show_levels_in_turn() {
    let (_, request) = three_levels();
    let rows = request.view.rows(48);
    let of_rows: Vec<_> = (0..48).map(|row| rows.of_row(row)).collect();
    // From the picture's lower edge up: the first alone, then ever more of the next, without a step.
    assert_eq!(of_rows[47], (0, 0.0));
    assert_eq!(of_rows[0], (2, 0.0));
    let depth = |&(level, share): &(usize, f32)| level as f32 + share;
    for pair in of_rows.windows(2) {
        let step = depth(&pair[0]) - depth(&pair[1]);
        assert!((0.0..0.3).contains(&step), "{pair:?}");
    }
    assert_eq!(rows.of_rows(0, 47), 0..=2);
    assert_eq!(rows.of_rows(46, 47), 0..=0);
    // A picture without levels has one.
    assert_eq!(LodSelector::default().rows(1, 48).of_rows(0, 47), 0..=0);
}

#[test]
fn each_level_has_its_share_of_a_row_in_every_renderer() {
    let (design, mut request) = three_levels();
    (request.settings.samples, request.settings.bounces) = (16, 1);
    // Light and dark levels tell which of them was drawn.
    let mut black = design.clone();
    black.pile.max_albedo = 0.02;
    black.chart.colour = Colour([0, 0, 0]);
    black.chart.pixels = None;
    let region = at_lod(&black, 1);
    request.view.levels.farther[0].scene = compiled(&black, region);
    let mut backends: [Box<dyn Backend>; 3] = [
        Box::new(CpuBackend::default()),
        Box::new(reference()),
        Box::new(exact_gpu()),
    ];
    let alone = [0, 1, 2].map(|level| finish(&mut CpuBackend::default(), &request.at_level(level)));
    let row_mean = |picture: &Picture, row: usize| {
        let pixels = &picture.pixels[row * 40..][..40];
        pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / 40.0
    };
    let rows = request.view.rows(48);
    for backend in &mut backends {
        let name = backend.kind().name();
        let picture = finish(&mut **backend, &request);
        let (mut off, mut swapped, mut mixed) = (0.0, 0.0, 0.0);
        for row in 0..48 {
            let (level, share) = rows.of_row(row as u32);
            let next = (level + 1).min(2);
            let [own, other] = [level, next].map(|level| row_mean(&alone[level], row));
            let mix = |share: f64| own + (other - own) * share;
            let found = row_mean(&picture, row);
            off += (found - mix(f64::from(share))).abs();
            swapped += (found - mix(1.0 - f64::from(share))).abs();
            mixed += (own - other).abs();
        }
        eprintln!("{name}: {off:.3}, with shares exchanged {swapped:.3}, of {mixed:.3}");
        // Sixteen samples tell a share to a sixteenth or so: found is a fiftieth.
        assert!(off < 0.06 * mixed, "{name}: {off} of {mixed}");
        assert!(swapped > 0.3 * mixed, "{name}: {swapped} of {mixed}");
    }
}

#[test]
fn renderers_draw_the_same_level_in_each_sample() {
    let (_, mut request) = three_levels();
    (request.settings.samples, request.settings.aov) = (2, true);
    let expected = finish(&mut reference(), &request);
    let mut other = request.clone();
    other.view.selector.at_top += 0.1;
    let backends: [&mut dyn Backend; 2] = [&mut CpuBackend::default(), &mut exact_gpu()];
    for backend in backends {
        let name = backend.kind().name();
        let differ = differing(&expected, &finish(backend, &request));
        // As many as for one level: rays that f32 leads past an edge.
        assert!(differ <= 19, "{name}: {differ} of 1920");
        // Other shares would be noticed.
        let differ = differing(&expected, &finish(backend, &other));
        assert!(differ > 200, "{name}: {differ} of 1920");
        // And crops are parts of the whole.
        let mut crop = request.clone();
        crop.crop = [7, 13, 20, 21];
        let part = finish(backend, &crop);
        let whole = finish(backend, &request);
        let rows = (0..21).flat_map(|row| &whole.pixels[(13 + row) * 40 + 7..][..20]);
        let of_whole = Picture {
            pixels: rows.copied().collect(),
            ..part.clone()
        };
        // On the GPU rays begin at points that are rounded from another tile's middle.
        let differ = differing(&of_whole, &part);
        assert!(differ <= 4, "{name}: {differ} of 420");
    }
}

#[test]
fn shadows_are_cached_level_by_level() {
    let (_, mut request) = three_levels();
    (request.settings.samples, request.settings.counters) = (32, true);
    let backends: [&mut dyn Backend; 2] = [&mut CpuBackend::default(), &mut exact_gpu()];
    for backend in backends {
        let name = backend.kind().name();
        let mut drawn = |cached: u32| {
            request.settings.cached_shadows = cached;
            let picture = finish(backend, &request);
            let rays = backend.counters().unwrap().cached_rays;
            (metrics::mean_luminance(&picture), rays)
        };
        let [(traced, none), (cached, some)] = [drawn(0), drawn(32)];
        assert!(none == 0 && some > 1000, "{name}: {none}, {some}");
        // Another level's shadows would be half as long, and elsewhere.
        let ratio = cached / traced;
        eprintln!("{name}: {ratio:.4} with {some} rays from caches");
        assert!((0.98..1.02).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn depth_is_that_of_the_cloth_at_every_level() {
    let (design, mut request) = three_levels();
    request.settings.aov = true;
    let height_mm = 4.0 * design.length.longest();
    let backends: [&mut dyn Backend; 3] = [
        &mut CpuBackend::default(),
        &mut exact_gpu(),
        &mut reference(),
    ];
    for backend in backends {
        let name = backend.kind().name();
        let picture = finish(backend, &request);
        let depths = &picture.aov.as_ref().unwrap().depth;
        let mut met = 0;
        for (index, &depth) in depths.iter().enumerate() {
            let pixel = DVec2::new((index % 40) as f64 + 0.5, (index / 40) as f64 + 0.5);
            let (origin, direction) = request.camera().ray(pixel, [40, 48]);
            // Between the planes that hold all of the coarsest pile.
            let [near, far] = [height_mm, -height_mm].map(|z| (z - origin.z) / direction.z);
            if picture.pixels[index][3] < 1.0 || far < 0.0 {
                continue;
            }
            met += 1;
            let depth = f64::from(depth);
            assert!(
                (near - 1.0..far + 1.0).contains(&depth),
                "{name}, {pixel}: {near} {depth} {far}"
            );
        }
        assert!(met > 800, "{name}: {met}");
    }
}

#[test]
#[ignore = "long: about 100 s"]
fn zooming_jumps_no_more_than_without_levels() {
    let mut design = load_design(&preset_path("paper-fig12"));
    design.chart.pixels = None;
    (design.sheet.warps, design.sheet.wefts) = (2048, 2048);
    design.quality.method = Method::Tracked;
    (design.quality.bounces, design.quality.samples) = (1, 256);
    let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
    let size = [24, 24];
    let whole = Arc::new(compile(&design).unwrap());
    let mut maker = LodCompiler::default();
    // From 12 to 24 cells a pixel: from two levels to the next two.
    let frames = (0..15).map(|k| 12.0 * 1.05_f64.powi(k) * pitch * 24.0);
    let mut lod = Vec::new();
    let mut pictures = frames.map(|height| {
        design.view.cameras[0].orthographic_height = Some(height);
        let shown = request_by(&mut maker, &design, size);
        lod.push(shown.scene().sheet.region.unwrap().lod);
        let whole = RenderRequest {
            view: LodView::of(
                Arc::clone(&whole),
                Camera::from_design(&design.view.cameras[0]),
            ),
            ..shown.clone()
        };
        [whole, shown].map(|request| finish(&mut CpuBackend::default(), &request))
    });
    let mut last = pictures.next().unwrap();
    let mut largest = [0.0_f64; 2];
    for picture in pictures {
        let jumps = [0, 1].map(|side| metrics::rel_rmse(&picture[side], &last[side]).unwrap());
        eprintln!("{:.4} without, {:.4} with levels", jumps[0], jumps[1]);
        largest = [0, 1].map(|side| largest[side].max(jumps[side]));
        last = picture;
    }
    assert_eq!((lod[0], *lod.last().unwrap()), (0, 1));
    let [without, with] = largest;
    eprintln!("jumps: {without:.4} without, {with:.4} with levels");
    // Found: 0.1672 and 0.1673. The largest of fourteen noisy changes is known to a few hundredths of itself.
    assert!(with <= 1.03 * without, "{with} {without}");
}

/// A picture of a design's first camera.
fn request_by(maker: &mut LodCompiler, design: &Design, size: [u32; 2]) -> RenderRequest {
    let camera = Camera::from_design(&design.view.cameras[0]);
    let (extent, never) = (LodBudget::FINAL, Cancel::never());
    let view = LodView::new(maker, design, &camera, size, extent, &never);
    RenderRequest::new(view.unwrap(), size, (&design.quality).into())
}
