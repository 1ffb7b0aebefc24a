//! The grid walk: blocks and their cells in order, without gaps.

use glam::DVec3;
use renderer_core::design::Interpolation;
use renderer_core::geometry::{Interval, Ray, clip_to_box};
use renderer_core::reference::{Grid, Span};
use renderer_core::scene::Scene;

use super::cloth::{Random, wild_towel};

/// Checks that a point is in the block or the cell of a span, `cells` cells wide.
fn check_within(scene: &Scene, span: &Span, cells: i64, point: DVec3) {
    let [first, last] = [0, cells - 1].map(|k| {
        let [i, j] = span.index.map(|index| index * cells + k);
        scene.sheet.cell_centre(i, j)
    });
    let pitch = [scene.sheet.pitch_x_mm, scene.sheet.pitch_y_mm];
    for axis in 0..2 {
        let half = 0.5 * pitch[axis] + 1e-12;
        let range = first[axis] - half..=last[axis] + half;
        assert!(range.contains(&point[axis]), "{span:?}: {point}");
    }
}

#[test]
fn blocks_and_cells_follow_each_other_without_gaps() {
    let scene = wild_towel(Interpolation::Nearest);
    let grid = Grid::new(&scene.sheet, &scene.loops, None);
    let [low, high] = grid.bounds();
    let b = i64::from(scene.loops.block_cells);
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
                .map(|k| (pair[0].index[k] - pair[1].index[k]).abs())
                .sum();
            // Two where the ray passes exactly through a corner.
            assert!((1..=2).contains(&step), "{pair:?}");
        }
        for span in &spans {
            let middle = ray.at(0.5 * (span.enter + span.leave));
            // Rounding at 40 mm is 10⁻¹⁴; a span shorter than that may lie beside its block.
            check_within(&scene, span, b, middle);
            // The cells inside take over from each other in the same way.
            let cells: Vec<_> = grid.walk_cells(&ray, span).collect();
            assert_eq!(cells[0].enter, span.enter);
            assert_eq!(cells[cells.len() - 1].leave, span.leave);
            for pair in cells.windows(2) {
                assert_eq!(pair[0].leave, pair[1].enter);
            }
            for cell in &cells {
                assert_eq!(scene.loops.block_of(cell.index), span.index);
                check_within(&scene, cell, 1, ray.at(0.5 * (cell.enter + cell.leave)));
            }
        }
    }
    assert!(longest > 6, "{longest}");
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
            assert!(spans <= 40, "{direction} through {corner}: {spans} blocks");
        }
    }
}
