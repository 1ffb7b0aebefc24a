//! `single` and `layered` against every loop tested without a grid, from the conventions' formulas.

use glam::{DMat3, DVec3};
use renderer_core::design::{Interpolation, Method};
use renderer_core::geometry::Ray;
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::scene::Scene;

use super::cloth::{
    BruteLoop, Random, all_loops, block, block_extent, request, tracer, wild_towel,
};

/// What takes light from a ray: distance, optical depth, and where it scatters.
#[derive(Debug, Clone, Copy)]
struct BruteEvent {
    t: f64,
    depth: f64,
    t_scatter: f64,
    index: usize,
}

/// (u′, v′, w′) by a matrix inverse.
fn slopes(brute: &BruteLoop, u: f64, v: f64, direction: DVec3) -> DVec3 {
    let [a, b, c] = brute.frame.jacobian(u, v);
    let mut slopes = DMat3::from_cols(a, b, c).inverse() * direction;
    slopes.z = slopes.z.abs().max(1e-6).copysign(slopes.z);
    slopes
}

/// The ends of all τ with `low` ≤ value + slope·τ ≤ `high`.
fn between(value: f64, slope: f64, low: f64, high: f64) -> [f64; 2] {
    let mut ends = [(low - value) / slope, (high - value) / slope];
    ends.sort_by(f64::total_cmp);
    ends
}

fn single_events(scene: &Scene, brute: &BruteLoop, ray: &Ray, events: &mut Vec<BruteEvent>) {
    let ray = ray.relative_to(brute.origin);
    let roots = brute.frame.patch.roots(&ray);
    let roots = roots.as_slice();
    let h = brute.frame.thickness;
    for (k, root) in roots.iter().enumerate() {
        let slope = slopes(brute, root.u, root.v, ray.direction);
        let curvature = brute.frame.patch.twist.dot(brute.frame.normal) * slope.x * slope.y;
        let reach = (0.5 / slope.z.abs()).min((h / (2.0 * curvature.abs())).sqrt());
        let (mut lows, mut highs) = (vec![-reach, -root.t], vec![reach]);
        for [low, high] in [
            between(root.u, slope.x, 0.0, 1.0),
            between(root.v, slope.y, 0.0, 1.0),
        ] {
            lows.push(low);
            highs.push(high);
        }
        if let Some(other) = roots.get(1 - k.min(1)).filter(|_| roots.len() == 2) {
            let middle = 0.5 * (other.t - root.t);
            if middle > 0.0 { &mut highs } else { &mut lows }.push(middle);
        }
        let low = lows.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let high = highs.into_iter().fold(f64::INFINITY, f64::min);
        let layers = scene.volumes.layers;
        let mut pieces = Vec::new();
        for layer in 0..layers {
            let n = f64::from(layers);
            let l = f64::from(layer);
            let [from, to] = between(0.0, slope.z, l / n - 0.5, (l + 1.0) / n - 0.5);
            let (from, to) = (from.max(low), to.min(high));
            if from < to {
                let tau = 0.5 * (from + to);
                let w = match scene.volumes.interpolation {
                    Interpolation::Nearest => (l + 0.5) / n - 0.5,
                    Interpolation::Linear => slope.z * tau,
                };
                let place = [root.u + slope.x * tau, root.v + slope.y * tau, w];
                let rho = brute.rho(&scene.volumes, place);
                pieces.push((tau, brute.density * rho * (to - from)));
            }
        }
        pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let depth: f64 = pieces.iter().map(|piece| piece.1).sum();
        if depth > 0.0 {
            let (mut through, mut sum, mut weight) = (1.0, 0.0, 0.0);
            for (tau, depth) in pieces {
                let alpha = 1.0 - (-depth).exp();
                sum += through * alpha * (root.t + tau);
                weight += through * alpha;
                through *= 1.0 - alpha;
            }
            events.push(BruteEvent {
                t: root.t.max(0.0),
                depth,
                t_scatter: sum / weight,
                index: brute.index,
            });
        }
    }
}

fn layered_events(scene: &Scene, brute: &BruteLoop, ray: &Ray, events: &mut Vec<BruteEvent>) {
    let ray = ray.relative_to(brute.origin);
    let n = f64::from(scene.volumes.layers);
    for layer in 0..scene.volumes.layers {
        let w = (f64::from(layer) + 0.5) / n - 0.5;
        let offset = brute.frame.normal * (w * brute.frame.thickness);
        let mut patch = brute.frame.patch;
        patch.centre += offset;
        for root in patch.roots(&ray).as_slice() {
            let slope = slopes(brute, root.u, root.v, ray.direction);
            let reach = 0.5 / (n * slope.z.abs());
            let across = between(root.u, slope.x, 0.0, 1.0);
            let up = between(root.v, slope.y, 0.0, 1.0);
            let low = (-reach).max(-root.t).max(across[0]).max(up[0]);
            let high = reach.min(across[1]).min(up[1]);
            if low < high {
                let tau = 0.5 * (low + high);
                let place = [root.u + slope.x * tau, root.v + slope.y * tau, w];
                let depth = brute.density * brute.rho(&scene.volumes, place) * (high - low);
                if depth > 0.0 {
                    events.push(BruteEvent {
                        t: root.t.max(0.0),
                        depth,
                        t_scatter: root.t + tau,
                        index: brute.index,
                    });
                }
            }
        }
    }
}

/// All events ahead of a ray, in order.
fn brute_events(scene: &Scene, loops: &[BruteLoop], ray: &Ray, method: Method) -> Vec<BruteEvent> {
    let mut events = Vec::new();
    for brute in loops {
        match method {
            Method::Layered => layered_events(scene, brute, ray, &mut events),
            _ => single_events(scene, brute, ray, &mut events),
        }
    }
    events.retain(|event| event.depth > 0.0);
    events.sort_by(|a, b| a.t.total_cmp(&b.t));
    events
}

#[test]
fn the_grid_finds_what_brute_force_finds() {
    for interpolation in [Interpolation::Nearest, Interpolation::Linear] {
        let scene = wild_towel(interpolation);
        let loops = all_loops(&scene);
        for method in [Method::Single, Method::Layered] {
            let tracer = tracer(scene.clone(), method);
            let mut scratch = Scratch::default();
            let mut random = Random::new(2);
            let (mut partly, mut hits, mut twice) = (0, 0, 0);
            for _ in 0..3_000 {
                let ray = random.ray_at(&scene);
                let mut events = brute_events(&scene, &loops, &ray, method);
                // Behind the camera nothing counts; in front of the cloth there is nothing.
                events.retain(|event| event.t > 0.0);
                let expected: f64 = events.iter().map(|event| (-event.depth).exp()).product();
                let visibility = tracer.composited_visibility(&ray, &mut scratch);
                // Below 10⁻⁴ a shadow ray counts as dark. Otherwise rounding: t is known to 10⁻¹⁴, and slopes
                // at grazing angles magnify it.
                if visibility == 0.0 {
                    assert!(expected < 1.0001e-4, "{expected} for {ray:?}");
                } else {
                    assert!(
                        (visibility - expected).abs() < 1e-8,
                        "{visibility} {expected} {ray:?}"
                    );
                }
                partly += usize::from((0.01..0.99).contains(&expected));
                twice += usize::from(
                    events
                        .windows(2)
                        .any(|e| e[0].index == e[1].index && method == Method::Single),
                );

                let xi = random.within(0.0, 1.0);
                let vertex = tracer.first_event(&ray, xi, &mut scratch);
                let mut through = 1.0;
                let chosen = events.iter().find(|event| {
                    through *= (-event.depth).exp();
                    through < xi
                });
                if (through - xi).abs() < 1e-9 {
                    continue;
                }
                assert_eq!(vertex.is_some(), chosen.is_some(), "{ray:?} at {xi}");
                let (Some(vertex), Some(chosen)) = (vertex, chosen) else {
                    continue;
                };
                assert!(
                    (vertex.t - chosen.t_scatter).abs() < 1e-7,
                    "{vertex:?} {chosen:?}"
                );
                assert!((vertex.position - ray.at(vertex.t)).length() < 1e-12);
                let normal = loops[chosen.index].frame.normal;
                assert!((vertex.normal.dot(normal).abs() - 1.0).abs() < 1e-12);
                assert!(vertex.normal.dot(ray.direction) <= 0.0);
                hits += 1;
            }
            assert!(partly > 300 && hits > 1_000, "{partly} {hits}");
            assert!(twice > 3 || method == Method::Layered, "{twice}");
        }
    }
}

#[test]
fn shadow_rays_from_inside_see_only_what_lies_ahead() {
    // A block of density 1/mm: from depth d inside, along the normal, the layers ahead let e^−d through.
    for method in [Method::Single, Method::Layered] {
        let scene = block(40);
        let (middle, half) = block_extent(&scene);
        let tracer = tracer(scene, method);
        let mut scratch = Scratch::default();
        for share in [-0.99, -0.5, 0.013, 0.4, 0.9] {
            let ray = Ray {
                origin: middle + DVec3::X * (share * half.x),
                direction: DVec3::X,
            };
            let ahead = (1.0 - share) * half.x;
            let visibility = tracer.composited_visibility(&ray, &mut scratch);
            assert!(
                (visibility - (-ahead).exp()).abs() < 1e-9,
                "{method:?} {share}: {visibility}"
            );
            // The same for a ray that starts outside.
            let far = Ray {
                origin: ray.origin - DVec3::X * 30.0,
                direction: DVec3::X,
            };
            let visibility = tracer.composited_visibility(&far, &mut scratch);
            assert!((visibility - (-2.0 * half.x).exp()).abs() < 1e-9);
        }
    }
}

#[test]
fn every_event_is_chosen_with_its_share_of_the_light() {
    let scene = wild_towel(Interpolation::Linear);
    let loops = all_loops(&scene);
    let mut random = Random::new(4);
    for method in [Method::Single, Method::Layered] {
        let tracer = tracer(scene.clone(), method);
        let mut scratch = Scratch::default();
        let (ray, events) = loop {
            let ray = random.ray_at(&scene);
            let events = brute_events(&scene, &loops, &ray, method);
            if events.len() > 3 && events[1].t > 0.0 {
                break (ray, events);
            }
        };
        const STEPS: u32 = 20_000;
        let mut found = 0.0;
        let mut deep = 0.0;
        for step in 0..STEPS {
            let xi = (f64::from(step) + 0.5) / f64::from(STEPS);
            if let Some(vertex) = tracer.first_event(&ray, xi, &mut scratch) {
                found += 1.0;
                deep += vertex.t;
            }
        }
        let (mut through, mut expected, mut expected_deep) = (1.0, 0.0, 0.0);
        for event in &events {
            let alpha = 1.0 - (-event.depth).exp();
            expected += through * alpha;
            expected_deep += through * alpha * event.t_scatter;
            through *= 1.0 - alpha;
        }
        // The thresholds are known to 1/STEPS each.
        let n = f64::from(STEPS);
        assert!((found / n - expected).abs() < 2.0 / n);
        assert!((deep / n - expected_deep).abs() < 45.0 * 2.0 * events.len() as f64 / n);
    }
}

#[test]
fn work_is_counted() {
    let layers = 7;
    let scene = block(layers);
    let (middle, _) = block_extent(&scene);
    let ray = |direction: DVec3| Ray {
        origin: middle - direction * 20.0,
        direction,
    };
    let count = |method: Method, work: &dyn Fn(&Tracer, &mut Scratch)| {
        let mut scratch = Scratch::default();
        work(&tracer(scene.clone(), method), &mut scratch);
        scratch.counters
    };
    // Across the sheet's only block and its margin, through the one loop.
    let cells = u64::from(scene.loops.blocks[0]);
    assert_eq!((cells, scene.loops.margin[0]), (2, 1));
    let along_x = |tracer: &Tracer, scratch: &mut Scratch| {
        tracer.composited_visibility(&ray(DVec3::X), scratch);
    };
    let single = count(Method::Single, &along_x);
    let lists = |cells: u64, tests: u64| (cells, tests);
    assert_eq!((single.rays, single.shadow_rays), (0, 1));
    // The loop's patch is in the one block of cells only.
    assert_eq!(lists(single.cells, single.patch_tests), (cells, 1));
    assert_eq!(single.volume_samples, u64::from(layers));
    assert_eq!(single.contributing_hits, 1);
    let layered = count(Method::Layered, &along_x);
    // It is 0.8 mm thick and its cell, the first of the block, 0.75 mm wide: the block to the left lists it as well.
    assert_eq!(layered.patch_tests, 2 * u64::from(layers));
    assert_eq!(layered.volume_samples, u64::from(layers));
    assert_eq!(layered.contributing_hits, u64::from(layers));
    // Past the sheet: no block.
    let beside = count(Method::Single, &|tracer, scratch| {
        let mut ray = ray(DVec3::X);
        ray.origin.y += 100.0;
        tracer.first_event(&ray, 1.0, scratch);
    });
    assert_eq!((beside.rays, beside.shadow_rays, beside.cells), (1, 0, 0));
    // Above the loop, inside the grid's box: blocks, but no test.
    let mut tall = scene.clone();
    let mut loops = renderer_core::scene::Loops::clone(&tall.loops);
    loops.z_range_mm[1] += 5.0;
    tall.loops = renderer_core::scene::Section::new(loops);
    let mut scratch = Scratch::default();
    let mut above = ray(DVec3::X);
    above.origin.z = f64::from(scene.loops.z_range_mm[1]) + 1.0;
    tracer(tall, Method::Single).composited_visibility(&above, &mut scratch);
    assert_eq!(
        lists(scratch.counters.cells, scratch.counters.patch_tests),
        (cells, 0)
    );
}

#[test]
fn single_loses_rays_beside_the_middle_patch_and_layered_keeps_them() {
    // Across a corner of the block, inside its volume but above the middle patch's end.
    let scene = block(16);
    let (middle, half) = block_extent(&scene);
    let direction = DVec3::new(1.0, 0.0, 1.0).normalize();
    // Through the point a quarter of the thickness before the middle patch, just below the top.
    let ray = Ray {
        origin: middle + DVec3::new(-0.5 * half.x, 0.0, half.z - 0.1 * half.x) - direction * 9.0,
        direction,
    };
    let mut scratch = Scratch::default();
    let single = Tracer::new(&request(scene.clone(), Method::Single, 1));
    assert_eq!(single.composited_visibility(&ray, &mut scratch), 1.0);
    let layered = Tracer::new(&request(scene, Method::Layered, 1));
    let kept = layered.composited_visibility(&ray, &mut scratch);
    // The true way through: from w = −½ (0.5·half.x behind) to the top (0.1·half.x ahead), times √2. Layers of a
    // sixteenth of the thickness know its ends to half a layer each.
    let depth = 0.6 * half.x * 2.0_f64.sqrt();
    assert!(
        (-kept.ln() - depth).abs() < 2.0 * half.x / 16.0 * 1.5,
        "{kept}"
    );
}
