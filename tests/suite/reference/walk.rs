//! The grid walk: cells in order, without gaps.

use glam::DVec3;
use renderer_core::design::Interpolation;
use renderer_core::geometry::{Interval, Ray, clip_to_box};
use renderer_core::reference::Grid;

use super::cloth::{Random, wild_towel};

#[test]
fn cells_follow_each_other_without_gaps() {
    let scene = wild_towel(Interpolation::Nearest);
    let grid = Grid::new(&scene.sheet, &scene.loops, None);
    let [low, high] = grid.bounds();
    let mut random = Random::new(1);
    let mut longest = 0;
    for case in 0..4_000 {
        let mut ray = random.ray_at(&scene);
        if case % 4 == 0 {
            // From within.
            ray.origin = ray.at(random.within(38.0, 42.0));
        }
        let whole = clip_to_box(&ray, Interval::new(0.0, f64::INFINITY), low, high);
        let spans: Vec<_> = grid.walk(&ray).collect();
        longest = longest.max(spans.len());
        if whole.is_empty() {
            assert!(spans.is_empty());
            continue;
        }
        // To the bit: a hit on a border must lie in one cell, not in none or both.
        assert_eq!(spans[0].enter, whole.low);
        // The end is the crossing of the last border or of the box, equal but for rounding.
        assert!((spans[spans.len() - 1].leave - whole.high).abs() < 1e-12);
        for pair in spans.windows(2) {
            assert_eq!(pair[0].leave, pair[1].enter);
            let step: i64 = (0..2)
                .map(|k| (pair[0].cell[k] - pair[1].cell[k]).abs())
                .sum();
            // Two where the ray passes exactly through a corner.
            assert!((1..=2).contains(&step), "{pair:?}");
        }
        for span in &spans {
            let middle = ray.at(0.5 * (span.enter + span.leave));
            // Rounding at 40 mm is 10⁻¹⁴; a span shorter than that may lie beside its cell.
            let [x, y] = scene.sheet.cell_centre(span.cell[0], span.cell[1]);
            assert!((middle.x - x).abs() <= 0.5 * scene.sheet.pitch_x_mm + 1e-12);
            assert!((middle.y - y).abs() <= 0.5 * scene.sheet.pitch_y_mm + 1e-12);
        }
    }
    assert!(longest > 12, "{longest}");
}

#[test]
fn rays_along_borders_and_axes_end() {
    let scene = wild_towel(Interpolation::Nearest);
    let grid = Grid::new(&scene.sheet, &scene.loops, None);
    let [low, high] = grid.bounds();
    let middle_z = 0.5 * (low.z + high.z);
    for direction in [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ] {
        for corner in [low, high, DVec3::ZERO] {
            let origin = DVec3::new(corner.x, corner.y, middle_z) - direction * 60.0;
            let ray = Ray { origin, direction };
            let spans = grid.walk(&ray).count();
            assert!(spans <= 40, "{direction} through {corner}: {spans} cells");
        }
    }
}
