//! `exact` and `six-face` against every loop looked at without a grid, quadrature and closed forms.

use glam::DVec3;
use renderer_core::design::{Back, Design, Interpolation, Method, Pattern};
use renderer_core::geometry::{Interval, Ray, clip_to_box};
use renderer_core::image::Picture;
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::scene::{Scene, Section, Volumes, compile};

use super::cloth::{Random, all_loops, block, block_extent, blocks, edit_pile, request};
use super::tracking::{optical_depth, towel_of_two_yarns};
use crate::support::compare::same_means;
use crate::support::device::{reference, repeats};
use crate::support::scenes::small_towel;

/// A tracer with steps of `step_mm`.
fn stepping(scene: Scene, method: Method, step_mm: f64) -> Tracer {
    let mut request = request(scene, method, 1);
    request.settings.step_mm = step_mm;
    Tracer::new(&request)
}

#[test]
fn transmittance_is_the_quadrature_over_all_loops() {
    for interpolation in [Interpolation::Linear, Interpolation::Nearest] {
        let scene = towel_of_two_yarns(interpolation);
        let loops = all_loops(&scene);
        let exact = stepping(scene.clone(), Method::Exact, 0.002);
        let six_face = stepping(scene.clone(), Method::SixFace, 0.002);
        let mut scratch = Scratch::default();
        let mut random = Random::new(11);
        let (mut partly, mut worst, mut squares) = (0, [0.0_f64; 2], [0.0; 2]);
        while partly < 150 {
            let ray = random.ray_at(&scene);
            let found = [&exact, &six_face].map(|it| it.marched_visibility(&ray, &mut scratch));
            if found[0] == 0.0 && partly % 2 == 1 {
                continue;
            }
            let through = (-optical_depth(&scene, &loops, &ray, exact.grid().bounds())).exp();
            for (k, found) in found.into_iter().enumerate() {
                // Below 10⁻⁴ a shadow ray counts as dark.
                let error = (found - if through < 1e-4 { 0.0 } else { through }).abs();
                worst[k] = worst[k].max(error);
                squares[k] += error * error;
            }
            partly += usize::from((0.01..0.99).contains(&through));
        }
        // The quadrature knows where loops and slabs begin and end to 1 µm at most, and there σ may jump by 3/mm: 3e-3
        // for an end in the worst case, and seldom.
        let rms = squares.map(|sum| f64::sqrt(sum / 150.0));
        assert!(
            worst[0] < 3e-3 && rms[0] < 3e-4,
            "{interpolation:?}: {worst:?} {rms:?}"
        );
        assert!(
            worst[1] < 5e-3 && rms[1] < 6e-4,
            "six-face {interpolation:?}: {worst:?} {rms:?}"
        );
    }
}

#[test]
fn a_uniform_block_lets_through_the_closed_form_and_is_met_where_it_says() {
    let scene = block(5);
    let (middle, half) = block_extent(&scene);
    for (method, step) in [
        (Method::Exact, 9.0),
        (Method::Exact, 0.01),
        (Method::SixFace, 0.05),
    ] {
        let tracer = stepping(scene.clone(), method, step);
        let mut scratch = Scratch::default();
        for direction in [
            DVec3::X,
            -DVec3::Y,
            DVec3::Z,
            DVec3::new(1.0, 2.0, -0.5).normalize(),
        ] {
            let ray = Ray {
                origin: middle - direction * 25.0,
                direction,
            };
            let inside = clip_to_box(&ray, Interval::new(0.0, 99.0), middle - half, middle + half);
            let through = (-inside.length()).exp();
            let found = tracer.marched_visibility(&ray, &mut scratch);
            assert!(
                (found - through).abs() < 1e-9,
                "{method:?}: {found}, not {through}"
            );
            for xi in [0.999, 0.7, 0.5 + 0.5 * through] {
                let vertex = tracer.marched_event(&ray, xi, 0.5, &mut scratch);
                let vertex = vertex.expect("xi is above the transmittance");
                let t = inside.low - f64::ln(xi);
                assert!(
                    (vertex.t - t).abs() < 1e-9,
                    "{method:?}: {}, not {t}",
                    vertex.t
                );
                assert!((vertex.position - ray.at(t)).length() < 1e-9);
            }
            assert_eq!(
                tracer.marched_event(&ray, 0.99 * through, 0.5, &mut scratch),
                None
            );
            // From inside only what lies ahead counts.
            let from_middle = Ray {
                origin: middle,
                direction,
            };
            let ahead = (-0.5 * inside.length()).exp();
            let found = tracer.marched_visibility(&from_middle, &mut scratch);
            assert!(
                (found - ahead).abs() < 1e-9,
                "{method:?}: {found}, not {ahead}"
            );
        }
    }
}

#[test]
fn crowded_blocks_let_through_the_closed_form() {
    // Five blocks 0.8 mm thick every sixth of a mm: one, then two, three, four and five deep; σ is 1/mm, then 1.5/mm.
    let scene = blocks(5, 5, 60.0);
    let (middle, half) = block_extent(&scene);
    let ray = Ray {
        origin: middle - DVec3::X * 25.0,
        direction: DVec3::X,
    };
    let pitch = scene.sheet.pitch_x_mm;
    let length = 4.0 * pitch + 2.0 * half.x;
    let depth = 2.0 * pitch + 1.5 * (length - 2.0 * pitch);
    for (method, step, tolerance) in [
        (Method::Exact, 9.0, 1e-9),
        (Method::Exact, 0.01, 1e-9),
        // The ends of blocks fall anywhere within steps of six-face.
        (Method::SixFace, 1e-3, 1e-3),
    ] {
        let tracer = stepping(scene.clone(), method, step);
        let mut scratch = Scratch::default();
        let found = tracer.marched_visibility(&ray, &mut scratch);
        assert!(
            (found - f64::exp(-depth)).abs() < tolerance,
            "{method:?} {step}: {found}, not {}",
            f64::exp(-depth)
        );
        // Where the first 1.5 mm-depths are spent: e^−0.2 lies in the second block already.
        let vertex = tracer.marched_event(&ray, f64::exp(-0.2), 0.0, &mut scratch);
        let t = 25.0 - 2.0 * pitch - half.x + pitch + (0.2 - pitch) / 1.5;
        let found = vertex.expect("the blocks are met").t;
        assert!(
            (found - t).abs() < tolerance,
            "{method:?} {step}: {found}, not {t}"
        );
    }
}

/// The slope of log error against log step, through the first and the last.
fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let last = steps.len() - 1;
    (errors[0] / errors[last]).ln() / (steps[0] / steps[last]).ln()
}

/// Root mean square of the differences of optical depths.
fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

#[test]
fn errors_fall_with_the_step_at_the_order_of_the_method() {
    // Few, large voxels, so that pieces between cuts are much longer than the smaller steps.
    let scene = towel_of_two_yarns(Interpolation::Linear);
    let mut random = Random::new(21);
    let rays: Vec<Ray> = (0..400).map(|_| random.ray_at(&scene)).collect();
    let depths = |method, step| -> Vec<f64> {
        let tracer = stepping(scene.clone(), method, step);
        let mut scratch = Scratch::default();
        rays.iter()
            .map(|ray| tracer.marched_visibility(ray, &mut scratch))
            .collect()
    };
    let truth = depths(Method::Exact, 0.0005);
    let steps = [0.05, 0.025, 0.0125, 0.00625];
    let errors = |method| steps.map(|step| rms_difference(&depths(method, step), &truth));
    let (exact, six_face) = (errors(Method::Exact), errors(Method::SixFace));
    let (exact_order, six_face_order) = (order(&steps, &exact), order(&steps, &six_face));
    eprintln!(
        "exact {exact:.6?} order {exact_order:.2}, six-face {six_face:.6?} order {six_face_order:.2}"
    );
    // σ is smooth between the cuts of exact: the midpoint rule is of second order. six-face meets the ends of loops,
    // where σ jumps, anywhere in a step: first order.
    assert!(exact_order > 1.7, "{exact:?}: {exact_order}");
    assert!(six_face_order > 0.9, "{six_face:?}: {six_face_order}");
    assert!(six_face[3] > 5.0 * exact[3], "{six_face:?} {exact:?}");
}

/// One loop whose voxels are samples, in `layers` layers, of one smooth density.
fn smooth_loop(layers: u32, twist: f64) -> Scene {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (1, 1);
    design.weave.pattern = Pattern::filled(1, 1, 7);
    design.weave.back = Back::None;
    design.pile.layers = layers;
    design.pile.interpolation = Interpolation::Nearest;
    (design.pile.twist, design.pile.twist_jitter) = (twist, twist / 2.0);
    (design.pile.tilt, design.pile.lean_y) = (60.0, 30.0);
    design.skeleton.visible = false;
    let mut scene = compile(&design).expect("a valid design");
    let mut volumes = Volumes::clone(&scene.volumes);
    let resolution = 16;
    (volumes.resolution, volumes.variants, volumes.root_blend) = (resolution, 1, 0.0);
    volumes.tangents.clear();
    volumes.voxels.clear();
    let bump = |index: u32, count: u32| {
        let x = (f64::from(index) + 0.5) / f64::from(count);
        f64::sin(std::f64::consts::PI * x)
    };
    for layer in 0..layers {
        for row in 0..resolution {
            for column in 0..resolution {
                let rho = bump(layer, layers)
                    * bump(row, resolution)
                    * (0.3 + 0.7 * bump(column, resolution));
                volumes.voxels.push([(255.0 * rho).round() as u8; 2]);
            }
        }
    }
    scene.volumes = Section::new(volumes);
    let mut looks = scene.looks.clone().to_vec();
    for look in &mut looks {
        look.variant = 0;
    }
    scene.looks = Section::new(looks);
    edit_pile(&mut scene, |pile| pile.materials[0].density_per_mm = 2.0);
    scene
}

#[test]
fn slabs_converge_as_layers_grow() {
    // Flat loops: the linear map of `single` is exact and its bias is none, for rays that hit the mid patch well
    // inside. Twisted loops: the patches of `layered` follow the volume, and in the limit are all of it.
    for (method, twist) in [
        (Method::Single, 0.0),
        (Method::Layered, 0.0),
        (Method::Layered, 100.0),
    ] {
        let layers = [4, 8, 16, 32, 64];
        let mut errors = Vec::new();
        for count in layers {
            let scene = smooth_loop(count, twist);
            let loops = all_loops(&scene);
            let slabs = stepping(scene.clone(), method, 0.01);
            let exact = stepping(scene.clone(), Method::Exact, 0.01);
            let mut scratch = Scratch::default();
            let mut random = Random::new(5);
            let (mut found, mut truth) = (Vec::new(), Vec::new());
            while found.len() < 300 {
                // Through the mid patch, not along it.
                let brute = &loops[found.len() % loops.len()];
                let (u, v) = (random.within(0.3, 0.7), random.within(0.3, 0.7));
                let direction = random.direction();
                if direction.dot(brute.frame.normal).abs() < 0.5 {
                    continue;
                }
                let target = brute.origin + brute.frame.at([u, v, 0.0]);
                let ray = Ray {
                    origin: target - direction * 40.0,
                    direction,
                };
                found.push(slabs.composited_visibility(&ray, &mut scratch));
                truth.push(exact.marched_visibility(&ray, &mut scratch));
            }
            errors.push(rms_difference(&found, &truth));
        }
        let thicknesses = layers.map(|count| 1.0 / f64::from(count));
        let measured = order(&thicknesses, &errors);
        eprintln!("{method:?} {twist}: {errors:.6?} order {measured:.2}");
        assert!(measured > 0.9, "{method:?} {twist}: {errors:?}: {measured}");
        assert!(errors[4] < 1e-3, "{method:?} {twist}: {errors:?}");
    }
}

#[test]
fn exact_and_tracked_pictures_have_the_same_expectation() {
    let mut design = small_towel();
    (design.quality.samples, design.quality.bounces) = (4, 1);
    let pictures = |method, density: f64, first_seed: u32| -> Vec<Picture> {
        let mut design = design.clone();
        design.quality.method = method;
        design.pile.density *= density;
        let request = crate::support::scenes::request(&design, [24, 24]);
        repeats(&mut reference(), &request, first_seed)
    };
    let exact = pictures(Method::Exact, 1.0, 100);
    same_means(&exact, &pictures(Method::Tracked, 1.0, 900)).unwrap();
    // Pile half as dense again is seen, and so is the bias of the paper's method.
    assert!(same_means(&exact, &pictures(Method::Tracked, 1.5, 900)).is_err());
    assert!(same_means(&exact, &pictures(Method::Single, 1.0, 900)).is_err());
}
