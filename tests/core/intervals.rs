//! The parts of a ray inside a loop's frame, and its crossings with the frame's surfaces, against sampling.

use glam::DVec3;
use renderer_core::geometry::{FrameLine, Interval, LoopFrame, Ray};

use crate::geometry::Random;

const WHOLE: Interval = Interval {
    low: f64::NEG_INFINITY,
    high: f64::INFINITY,
};

/// A ray through the box of a frame, some of them in or across special planes.
fn ray_at(random: &mut Random, frame: &LoopFrame, kind: u32) -> Ray {
    let place = [0.0; 3].map(|_| random.within(-0.1, 1.1));
    let target = frame.at([place[0], place[1], place[2] - 0.5]);
    let direction = match kind % 8 {
        // Along n̂, along the patch's tangents, across a corner.
        0 => frame.normal,
        1 => frame.patch.tangents(place[0], place[1])[0],
        2 => frame.patch.tangents(place[0], place[1])[1],
        3 => target - frame.at([0.0, 0.0, 0.0]),
        _ => random.direction(),
    };
    let direction = direction.normalize_or(DVec3::X);
    Ray {
        origin: target - direction * random.within(-1.0, 30.0),
        direction,
    }
}

#[test]
fn a_ray_is_inside_where_points_of_it_are() {
    let mut random = Random::new(31);
    let (mut met, mut twice) = (0, 0);
    for kind in 0..20_000 {
        let frame = random.frame();
        let ray = ray_at(&mut random, &frame, kind);
        let line = FrameLine::new(&frame, &ray);
        let inside = line.inside(WHOLE);
        let parts = inside.as_slice();
        met += usize::from(!parts.is_empty());
        twice += usize::from(parts.len() == 2);
        for part in parts {
            assert!(part.low < part.high && part.length() < 10.0, "{part:?}");
        }
        // Within a rounding error of an end either answer is right.
        let near_end = |t: f64| {
            let mut ends = parts.iter().flat_map(|part| [part.low, part.high]);
            ends.any(|end| (end - t).abs() < 1e-7)
        };
        let about = (frame.patch.centre - ray.origin).dot(ray.direction);
        for step in 0..60 {
            let t = about + (f64::from(step) / 30.0 - 1.0) * 1.6 + random.within(0.0, 0.05);
            let point = frame.invert(ray.at(t));
            let held = parts.iter().any(|part| part.holds(t));
            if held != point.is_some() && !near_end(t) {
                // A ray within a face is in and out by rounding.
                let [u, v, w] = line.at(t);
                let on_face = [u, 1.0 - u, v, 1.0 - v, 0.5 - w, 0.5 + w];
                assert!(
                    on_face.iter().any(|x| x.abs() < 1e-7),
                    "{held} {point:?} at {t}: {parts:?} {frame:?} {ray:?}"
                );
            }
            if let (true, Some(point)) = (held, point) {
                for (a, b) in point.into_iter().zip(line.at(t)) {
                    assert!((a - b).abs() < 1e-9);
                }
            }
        }
    }
    assert!(met > 8_000, "{met}");
    // MODEL.md §4: the shell is a saddle, and up to 5 % of the rays that hit it do so twice.
    assert!(twice > met / 200 && twice < met / 8, "{twice} of {met}");
}

#[test]
fn a_span_is_only_cut() {
    let mut random = Random::new(32);
    for kind in 0..3_000 {
        let frame = random.frame();
        let ray = ray_at(&mut random, &frame, kind);
        let line = FrameLine::new(&frame, &ray);
        let about = (frame.patch.centre - ray.origin).dot(ray.direction);
        let (a, b) = (random.within(-1.0, 1.0), random.within(-1.0, 1.0));
        let span = Interval::new(about + a.min(b), about + a.max(b));
        let expected: f64 = line
            .inside(WHOLE)
            .as_slice()
            .iter()
            .map(|part| part.intersect(span).length())
            .sum();
        let found = line.inside(span);
        let found: f64 = found.as_slice().iter().map(Interval::length).sum();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn surfaces_are_crossed_where_the_coordinate_has_their_value() {
    let mut random = Random::new(33);
    let mut crossings = [0; 3];
    for _ in 0..4_000 {
        let frame = random.frame();
        let ray = ray_at(&mut random, &frame, 7);
        let line = FrameLine::new(&frame, &ray);
        let inside = line.inside(WHOLE);
        for part in inside.as_slice() {
            let value = random.within(0.0, 1.0);
            let w_crossings = line.crossings_w(value - 0.5);
            let candidates = [
                vec![line.crossing_u(value)],
                vec![line.crossing_v(value)],
                w_crossings.as_slice().iter().map(|root| root.t).collect(),
            ];
            let (from, to) = (line.at(part.low), line.at(part.high));
            for (axis, found) in candidates.into_iter().enumerate() {
                let level = if axis == 2 { value - 0.5 } else { value };
                let found: Vec<f64> = found.into_iter().filter(|&t| part.holds(t)).collect();
                for &t in &found {
                    assert!((line.at(t)[axis] - level).abs() < 1e-7);
                    crossings[axis] += 1;
                }
                // Between values below and above there is one, or an odd number.
                if (from[axis] - level) * (to[axis] - level) < -1e-9 {
                    assert!(found.len() % 2 == 1, "{axis}: {found:?} in {part:?}");
                }
            }
        }
    }
    assert!(crossings.iter().all(|&count| count > 500), "{crossings:?}");
}
