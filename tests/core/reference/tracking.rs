//! `tracked`: density at points against brute force, transmittance against quadrature, collisions against both.

use glam::DVec3;
use renderer_core::design::{Interpolation, Method};
use renderer_core::geometry::{Interval, Ray, clip_to_box};
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Material, Scene, Section};

use super::cloth::{
    BruteLoop, Random, all_loops, block, block_extent, edit_pile, tracer, wild_towel,
};

/// σ at a point by MODEL.md §5, over all loops.
fn brute_extinction(scene: &Scene, loops: &[BruteLoop], point: DVec3) -> f64 {
    let (mut sigma, mut sum_rho) = (0.0, 0.0);
    for brute in loops {
        if let Some(place) = brute.frame.invert(point - brute.origin) {
            let rho = brute.rho(&scene.volumes, place);
            sigma += brute.density * rho;
            sum_rho += rho;
        }
    }
    if sum_rho > 1.5 {
        sigma * 1.5 / sum_rho
    } else {
        sigma
    }
}

/// A towel whose loops are of two materials.
pub fn towel_of_two_yarns(interpolation: Interpolation) -> Scene {
    let mut scene = wild_towel(interpolation);
    edit_pile(&mut scene, |pile| {
        let first = pile.materials[0];
        pile.materials = vec![
            Material {
                density_per_mm: 3.0,
                ..first
            },
            Material {
                density_per_mm: 1.2,
                ..first
            },
        ];
    });
    let mut looks = scene.looks.clone().to_vec();
    for (k, look) in looks.iter_mut().enumerate() {
        look.material = (k % 2) as u8;
        look.albedo = [if k % 2 == 0 { u16::MAX } else { 0 }; 3];
    }
    scene.looks = Section::new(looks);
    scene
}

#[test]
fn density_at_points_is_that_of_all_loops() {
    let scene = towel_of_two_yarns(Interpolation::Linear);
    let loops = all_loops(&scene);
    let tracer = tracer(scene.clone(), Method::Tracked);
    let mut scratch = Scratch::default();
    let [low, high] = tracer.grid().bounds();
    let mut random = Random::new(1);
    let (mut solid, mut crowded) = (0, 0);
    for _ in 0..20_000 {
        let point = DVec3::new(
            random.within(low.x, high.x),
            random.within(low.y, high.y),
            random.within(low.z, high.z),
        );
        let expected = brute_extinction(&scene, &loops, point);
        let sigma = tracer.extinction(point, &mut scratch);
        assert!(
            (sigma - expected).abs() < 1e-10,
            "{sigma} {expected} at {point}"
        );
        solid += usize::from(sigma > 0.5);
        crowded += usize::from(sigma > 3.0);
        assert!(sigma <= 1.5 * 3.0 + 1e-12);
    }
    assert!(solid > 1_000 && crowded > 50, "{solid} {crowded}");
}

/// ∫σ along a ray by midpoints 2 µm apart.
pub fn optical_depth(scene: &Scene, loops: &[BruteLoop], ray: &Ray, bounds: [DVec3; 2]) -> f64 {
    let [low, high] = bounds;
    let part = clip_to_box(ray, Interval::new(0.0, f64::INFINITY), low, high);
    let steps = (part.length() / 0.002).ceil().max(1.0);
    let step = part.length() / steps;
    // Only loops near the ray can hold its points.
    let near: Vec<_> = loops
        .iter()
        .filter(|brute| {
            let centre = brute.origin + brute.frame.patch.centre - ray.origin;
            centre.reject_from_normalized(ray.direction).length() < 3.5
        })
        .collect();
    (0..steps as u32)
        .map(|k| {
            let point = ray.at(part.low + (f64::from(k) + 0.5) * step);
            let (mut sigma, mut sum_rho) = (0.0, 0.0);
            for brute in &near {
                if let Some(place) = brute.frame.invert(point - brute.origin) {
                    let rho = brute.rho(&scene.volumes, place);
                    sigma += brute.density * rho;
                    sum_rho += rho;
                }
            }
            step * if sum_rho > 1.5 {
                sigma * 1.5 / sum_rho
            } else {
                sigma
            }
        })
        .sum()
}

/// Mean of `count` random values and the deviation of that mean.
fn mean_of(count: u32, mut value: impl FnMut() -> f64) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..count {
        let x = value();
        sum += x;
        squares += x * x;
    }
    let n = f64::from(count);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

/// A ray of which between a tenth and nine tenths come through, and how much does.
fn half_open_ray(
    random: &mut Random,
    scene: &Scene,
    loops: &[BruteLoop],
    tracer: &Tracer,
) -> (Ray, f64) {
    loop {
        let ray = random.ray_at(scene);
        let mut scratch = Scratch::default();
        // A cheap guess first.
        let guess = tracer.tracked_visibility(&ray, &mut random.0, &mut scratch);
        if (0.05..0.95).contains(&guess) {
            let through = (-optical_depth(scene, loops, &ray, tracer.grid().bounds())).exp();
            if (0.1..0.9).contains(&through) {
                return (ray, through);
            }
        }
    }
}

#[test]
fn ratio_and_delta_tracking_agree_with_quadrature() {
    let scene = towel_of_two_yarns(Interpolation::Linear);
    let loops = all_loops(&scene);
    let tracer = tracer(scene.clone(), Method::Tracked);
    let mut scratch = Scratch::default();
    let mut random = Random::new(2);
    let mut pcg = Pcg::new(5, 5);
    for _ in 0..12 {
        let (ray, through) = half_open_ray(&mut random, &scene, &loops, &tracer);
        let (ratio, deviation) = mean_of(4_000, || {
            tracer.tracked_visibility(&ray, &mut pcg, &mut scratch)
        });
        // 4.5 deviations: one in 10⁵ for each of 24 comparisons. The quadrature itself is good to 10⁻⁴: voxel borders
        // are met to a step of 2 µm.
        let allowed = 4.5 * deviation + 2e-4;
        assert!(
            (ratio - through).abs() < allowed,
            "{ratio} ± {deviation}, not {through}: {ray:?}"
        );
        let (escaped, deviation) = mean_of(4_000, || {
            let met = tracer.collision(&ray, &mut pcg, &mut scratch);
            f64::from(u8::from(met.is_none()))
        });
        let allowed = 4.5 * deviation + 2e-4;
        assert!(
            (escaped - through).abs() < allowed,
            "{escaped} ± {deviation}, not {through}"
        );
    }
}

#[test]
fn a_collision_is_with_each_loop_by_its_share() {
    // Loops of the first material are white, of the second black, so a mean albedo is the first one's share. It is
    // compared with ∫ T·σ₁ along the ray.
    let scene = towel_of_two_yarns(Interpolation::Linear);
    let loops = all_loops(&scene);
    let tracer = tracer(scene.clone(), Method::Tracked);
    let mut scratch = Scratch::default();
    let mut random = Random::new(3);
    let mut pcg = Pcg::new(6, 6);
    for _ in 0..4 {
        let (ray, _) = half_open_ray(&mut random, &scene, &loops, &tracer);
        let [low, high] = tracer.grid().bounds();
        let part = clip_to_box(&ray, Interval::new(0.0, f64::INFINITY), low, high);
        let steps = (part.length() / 0.005).ceil();
        let step = part.length() / steps;
        let (mut depth, mut expected, mut expected_t) = (0.0, 0.0, 0.0);
        for k in 0..steps as u32 {
            let t = part.low + (f64::from(k) + 0.5) * step;
            let point = ray.at(t);
            let (mut sigma, mut first, mut sum_rho) = (0.0, 0.0, 0.0);
            for brute in &loops {
                if let Some(place) = brute.frame.invert(point - brute.origin) {
                    let rho = brute.rho(&scene.volumes, place);
                    // Shade is part of the albedo: the mean is compared without it below.
                    sigma += brute.density * rho;
                    if brute.index % 2 == 0 {
                        first += brute.density * rho;
                    }
                    sum_rho += rho;
                }
            }
            let crowding = if sum_rho > 1.5 { 1.5 / sum_rho } else { 1.0 };
            let taken = f64::exp(-depth) * -f64::exp_m1(-sigma * crowding * step);
            if sigma > 0.0 {
                expected += taken * first / sigma;
                expected_t += taken * t;
            }
            depth += sigma * crowding * step;
        }
        let count = 6_000;
        let (mut deep, mut met) = (0.0, 0.0);
        let (share, deviation) = mean_of(count, || {
            match tracer.collision(&ray, &mut pcg, &mut scratch) {
                Some(vertex) => {
                    deep += vertex.t;
                    met += 1.0;
                    f64::from(u8::from(vertex.albedo.x > 0.0))
                }
                None => 0.0,
            }
        });
        assert!(
            (share - expected).abs() < 4.5 * deviation + 1e-3,
            "{share} ± {deviation}, not {expected}"
        );
        // Depths of collisions spread over a few mm at most.
        let mean_t = expected_t / (1.0 - f64::exp(-depth));
        assert!(
            (deep / met - mean_t).abs() < 4.5 * 3.0 / f64::sqrt(met),
            "{} {mean_t}",
            deep / met
        );
    }
}

#[test]
fn a_uniform_block_lets_through_the_closed_form() {
    let scene = block(5);
    let (middle, half) = block_extent(&scene);
    let tracer = tracer(scene, Method::Tracked);
    let mut scratch = Scratch::default();
    let mut pcg = Pcg::new(7, 7);
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
        let (ratio, deviation) = mean_of(20_000, || {
            tracer.tracked_visibility(&ray, &mut pcg, &mut scratch)
        });
        assert!(
            (ratio - through).abs() < 4.5 * deviation,
            "{ratio} ± {deviation}, not {through}"
        );
        // In the middle of a uniform block every density is 1/mm.
        assert!((tracer.extinction(middle, &mut scratch) - 1.0).abs() < 1e-12);
    }
}
