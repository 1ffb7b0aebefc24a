//! Cloth without end: an excerpt shows what the whole cloth shows there, halved cloth is as bright from everywhere, and a scene
//! is as large as its picture.

use std::sync::Arc;

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{ChartImage, Colour, Design, Fit, Method, Pattern};
use renderer_core::image::{Picture, metrics};
use renderer_core::render::{Backend, Camera, Extent, RenderRequest, Sight, excerpt_for};
use renderer_core::scene::{Cancel, CompileError, Compiler, Excerpt, Scene, compile};

use crate::support::device::{exact_gpu, finish, reference};
use crate::support::scenes::{preset_path, request, small_towel};

/// The scene of an excerpt.
fn compiled(design: &Design, excerpt: Excerpt) -> Arc<Scene> {
    let mut compiler = Compiler::default();
    let scene = compiler.compile_excerpt(design, Some(excerpt), &Cancel::never());
    scene.unwrap()
}

/// The same picture from an excerpt.
fn of_excerpt(request: &RenderRequest, design: &Design, excerpt: Excerpt) -> RenderRequest {
    let sight = Sight::of(compiled(design, excerpt), design, &request.camera);
    RenderRequest {
        scene: sight.scene,
        camera: sight.camera,
        ..request.clone()
    }
}

/// All of a cloth, halved.
fn halved(design: &Design, halvings: u32) -> Excerpt {
    let whole = [design.sheet.warps, design.sheet.wefts];
    Excerpt {
        whole,
        halvings,
        first: [0, 0],
        cells: Excerpt::halved(whole, halvings),
    }
}

/// A towel on which every cell can be told from its neighbours: by chart, nap map, pattern, turbulence and water.
fn manifold() -> Design {
    let mut design = small_towel();
    (design.sheet.warps, design.sheet.wefts) = (60, 50);
    design.weave.pattern = Pattern::from_fn(3, 5, |i, j| [7, 0, 9, 1][(2 * i + 3 * j) % 4]);
    let picture = |blue: u8| {
        let texel = move |k: usize| [(k * 37 % 256) as u8, (k * 91 % 256) as u8, blue, 255];
        let texels: Vec<[u8; 4]> = (0..7 * 6).map(texel).collect();
        ChartImage::new(7, 6, &texels).unwrap()
    };
    design.chart.pixels = Some(picture(120));
    design.nap.pixels = Some(picture(255));
    design.chart.fit = Fit::Tile;
    (design.finish.wetness, design.finish.pulled) = (0.5, 0.1);
    design.quality.method = Method::Single;
    design.quality.bounces = 1;
    let camera = &mut design.view.cameras[0];
    camera.target = [9.0, -4.0, 0.0];
    (camera.distance, camera.azimuth) = (9.0, -70.0);
    design
}

/// How many pixels differ by more than a hundredth of what is white.
fn differing(a: &Picture, b: &Picture) -> usize {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let is_near = |a: &[f32; 4], b: &[f32; 4]| {
        // NaN is near nothing.
        (0..4).all(|c| (a[c] - b[c]).abs() <= 0.01 * a[c].abs().max(1.0))
    };
    pairs.filter(|(a, b)| !is_near(a, b)).count()
}

#[test]
fn an_excerpt_shows_what_the_whole_cloth_shows_there() {
    let mut design = manifold();
    let part = |first: [u32; 2]| Excerpt {
        whole: [60, 50],
        halvings: 0,
        first,
        cells: [36, 34],
    };
    for fit in [Fit::Tile, Fit::Stretch] {
        (design.chart.fit, design.nap.fit) = (fit, fit);
        let whole = request(&design, [40, 32]);
        let excerpt = of_excerpt(&whole, &design, part([22, 5]));
        let mut backends: [Box<dyn Backend>; 3] = [
            Box::new(CpuBackend::default()),
            Box::new(reference()),
            Box::new(exact_gpu()),
        ];
        for backend in &mut backends {
            let name = backend.kind().name();
            let [all, some] = [&whole, &excerpt].map(|request| finish(&mut **backend, request));
            // Places are rounded from another origin: what a ray grazes may change, found is up to one in two hundred.
            let differ = differing(&all, &some);
            assert!(differ <= 8, "{name}, {fit:?}: {differ}");
        }
        // Loops of the cells beside them would be noticed.
        let mut beside = excerpt.clone();
        beside.scene = compiled(&design, part([23, 5]));
        let [right, wrong] =
            [&excerpt, &beside].map(|request| finish(&mut CpuBackend::default(), request));
        assert!(differing(&right, &wrong) > 400, "{fit:?}");
    }
}

/// Mean radiance of a design's first camera.
fn mean(request: &RenderRequest) -> f64 {
    metrics::mean_luminance(&finish(&mut CpuBackend::default(), request))
}

#[test]
fn halved_cloth_is_as_bright_from_everywhere() {
    for name in ["hotel-white", "harbour-stripe"] {
        let mut design = towel_designer::files::load_design(&preset_path(name)).unwrap();
        design.chart.pixels = None;
        design.chart.colour = Colour([180, 60, 40]);
        (design.sheet.warps, design.sheet.wefts) = (256, 256);
        (design.quality.bounces, design.quality.samples) = (2, 128);
        for (elevation, azimuth) in [(90.0, -90.0), (30.0, 40.0)] {
            let camera = &mut design.view.cameras[0];
            (camera.elevation, camera.azimuth) = (elevation, azimuth);
            camera.orthographic_height = Some(80.0);
            let whole = request(&design, [24, 24]);
            let bright = mean(&whole);
            for halvings in [1, 3] {
                let half = of_excerpt(&whole, &design, halved(&design, halvings));
                let ratio = mean(&half) / bright;
                eprintln!("{name}, {elevation}°, {azimuth}°, halved {halvings} times: {ratio:.4}");
                // Found: 0.97 to 1.02, much of which is noise.
                assert!((0.95..1.05).contains(&ratio), "{name}: {ratio}");
            }
            // Grown loops of another density would be noticed.
            let mut airy = design.clone();
            airy.pile.density /= 2.0;
            let half = of_excerpt(&whole, &airy, halved(&airy, 1));
            let ratio = mean(&half) / bright;
            assert!(!(0.95..1.05).contains(&ratio), "{name}: {ratio}");
        }
    }
}

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

#[test]
fn a_scene_is_as_large_as_its_picture_not_as_the_cloth() {
    let mut design = endless();
    let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
    let size = [320, 240];
    let mut most = 0;
    for distance in [20.0, 100.0, 500.0, 2500.0, 1e4, 5e4, 2e5] {
        let camera = seen_from(&mut design, distance);
        let excerpt = excerpt_for(&design, &camera, size, Extent::FINAL, None).unwrap();
        most = most.max(excerpt.len());
        // Near by it is the cloth itself; from afar loops are as wide as a pixel at most.
        let pixel_mm = camera.pixel_mm_at(glam::DVec3::ZERO, size[1]);
        let grown_mm = pitch / excerpt.scale();
        assert!(
            excerpt.halvings == 0 || grown_mm <= pixel_mm,
            "{distance}: {excerpt:?}"
        );
        assert!(excerpt.halvings > 0 || pixel_mm < 4.0 * pitch, "{distance}");
    }
    // 16 to 64 cells a pixel where it is nearest, and what is beside the picture.
    assert!(most < 100 * u64::from(size[0] * size[1]), "{most}");

    // A cloth of a hundredth of the cells has the same scene.
    let camera = seen_from(&mut design, 40.0);
    let bytes = |design: &Design| {
        let excerpt = excerpt_for(design, &camera, size, Extent::LIVE, None).unwrap();
        let scene = compiled(design, excerpt);
        (excerpt.cells, scene.loops.bytes() + 8 * scene.looks.len())
    };
    let mut smaller = design.clone();
    (smaller.sheet.warps, smaller.sheet.wefts) = (2496, 2496);
    let ([columns, rows], large) = bytes(&design);
    let (cells, small) = bytes(&smaller);
    // Excerpts begin at multiples of 32 cells, which lie otherwise.
    assert!(columns.abs_diff(cells[0]) <= 64 && rows.abs_diff(cells[1]) <= 64);
    assert!(
        (0.5..2.0).contains(&(large as f64 / small as f64)),
        "{large} {small}"
    );
}

#[test]
fn small_bent_and_filtered_cloth_is_made_whole() {
    let mut design = endless();
    let camera = seen_from(&mut design, 40.0);
    let needs =
        |design: &Design| excerpt_for(design, &camera, [64, 48], Extent::LIVE, None).is_some();
    assert!(needs(&design));
    let mut small = design.clone();
    small.sheet.wefts = 400;
    assert!(!needs(&small));
    let mut bent = design.clone();
    bent.form.kind = renderer_core::design::FormKind::Wave;
    let mut filtered = design.clone();
    filtered.turbulence.filter = renderer_core::design::Filter::Box;
    // What each may have is told with what would allow more.
    for (design, advice) in [(&bent, "form.kind"), (&filtered, "turbulence.filter")] {
        assert!(!needs(design));
        let Err(CompileError::Invalid(faults)) = compile(design) else {
            panic!("too large");
        };
        let told = faults[0].to_string();
        assert!(
            faults.len() == 1 && told.contains("sheet.wefts") && told.contains(advice),
            "{told}"
        );
    }
    // What makes all of a cloth at once says so.
    assert!(design.faults().is_empty());
    let told = compile(&design).unwrap_err().to_string();
    assert!(told.contains("at most 16000000 crossings"), "{told}");
}

#[test]
fn an_excerpt_is_kept_while_it_holds_what_is_seen() {
    let mut design = endless();
    let size = [320, 240];
    let seen = |design: &Design, x: f64, last: Option<&Excerpt>| {
        let mut view = design.view.cameras[0].clone();
        view.target[0] = x;
        let camera = Camera::from_design(&view);
        excerpt_for(design, &camera, size, Extent::LIVE, last).unwrap()
    };
    seen_from(&mut design, 300.0);
    let first = seen(&design, 0.0, None);
    assert_eq!(seen(&design, 3.0, Some(&first)), first);
    let there = seen(&design, 200.0, Some(&first));
    assert_ne!(there, first);
    assert_eq!(there, seen(&design, 200.0, None));
    assert!(!first.holds(&there) && first.holds(&first));
    // One that is halved more often is not what is seen.
    let coarse = halved(&design, 4);
    assert_ne!(seen(&design, 0.0, Some(&coarse)), coarse);
    // Beside the cloth something is made all the same, and views along the cloth's plane have an end.
    assert!(!seen(&design, 1e5, None).is_empty());
    design.view.cameras[0].elevation = 0.0;
    assert!(seen(&design, 0.0, None).len() <= Extent::LIVE.cells);
}

#[test]
fn patterns_larger_than_what_is_merged_keep_their_size() {
    // Stripes of 16 warps: loops on half of them.
    let mut design = small_towel();
    (design.sheet.warps, design.sheet.wefts) = (256, 64);
    design.weave.pattern = Pattern::from_fn(32, 2, |i, _| if i < 16 { 7 } else { 0 });
    for (halvings, first) in [(0, 0), (0, 5), (1, 3), (2, 8), (3, 1)] {
        let excerpt = Excerpt {
            first: [first, 0],
            cells: [24, 8],
            ..halved(&design, halvings)
        };
        let scene = compiled(&design, excerpt);
        for i in 0..24 {
            let middle = ((first + i) << halvings) + (1 << halvings) / 2;
            let expected = middle % 32 < 16;
            let stands = scene
                .loops
                .loop_at([i, 3], renderer_core::scene::Face::Front)
                .is_some();
            assert_eq!(stands, expected, "halved {halvings} times, warp {i}");
        }
    }
}

#[test]
#[ignore = "long: about 60 s"]
fn zooming_jumps_no_more_than_without_halving() {
    let mut design = towel_designer::files::load_design(&preset_path("paper-fig12")).unwrap();
    design.chart.pixels = None;
    (design.sheet.warps, design.sheet.wefts) = (1024, 1024);
    design.quality.method = Method::Tracked;
    (design.quality.bounces, design.quality.samples) = (1, 256);
    let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
    let size = [24, 24];
    // From 6 to 12 cells a pixel: halved once from 8 on.
    let frames = (0..15).map(|k| 6.0 * 1.05_f64.powi(k) * pitch * 24.0);
    let mut pictures = frames.map(|height| {
        design.view.cameras[0].orthographic_height = Some(height);
        let whole = request(&design, size);
        let is_halved = height >= 8.0 * pitch * 24.0;
        let shown = of_excerpt(&whole, &design, halved(&design, u32::from(is_halved)));
        [whole, shown].map(|request| finish(&mut CpuBackend::default(), &request))
    });
    let mut last = pictures.next().unwrap();
    let mut largest = [0.0_f64; 2];
    for picture in pictures {
        for (side, largest) in largest.iter_mut().enumerate() {
            let jump = metrics::rel_rmse(&picture[side], &last[side]).unwrap();
            *largest = largest.max(jump);
            eprintln!("JUMP {side} {jump:.4}");
        }
        last = picture;
    }
    let [without, with] = largest;
    eprintln!("jumps: {without:.4} without, {with:.4} with halving");
    // Found: up to 5 % more, of which one or two are noise: pixels have a quarter of the loops, and so more left of their texture.
    assert!(with <= without * 1.1, "{with} {without}");
}
