//! `exact` and `six-face` against every loop looked at without a grid, quadrature and closed forms.

use glam::DVec3;
use renderer_core::design::{Interpolation, Method};
use renderer_core::geometry::{Interval, Ray, clip_to_box};
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::scene::Scene;

use super::cloth::{Random, all_loops, block, block_extent, blocks, request};
use super::tracking::{optical_depth, towel_of_two_yarns};

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
        // The quadrature knows where loops and slabs begin and end to 1 µm at most, and there σ may jump by 3/mm: 3e-3 for
        // an end in the worst case, and seldom.
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
