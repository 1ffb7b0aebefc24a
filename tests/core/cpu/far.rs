//! Sheets 10⁵ cells wide: the last cells look like the first, and both as the reference draws them.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, Method, Pattern, SkeletonHeight};
use renderer_core::image::Picture;

use crate::support::compare::{MAX_FLIPS, same_samples, shows_something};
use crate::support::device::{finish, on_reference};
use crate::support::scenes::{request, small_towel};

const SIZE: [u32; 2] = [48, 40];

/// A sheet 10⁵ warps or wefts long, seen around the warp or weft `at`.
fn carpet(along_warps: bool, at: u32) -> Design {
    let mut design = small_towel();
    let sheet = &mut design.sheet;
    (sheet.warps, sheet.wefts) = if along_warps {
        (100_000, 4)
    } else {
        (4, 100_000)
    };
    let cells = f64::from(at) - 50_000.0;
    let [x, y] = if along_warps {
        [cells * sheet.pitch_x(), 0.0]
    } else {
        [0.0, cells * sheet.pitch_y()]
    };
    design.view.cameras[0].target = [x, y, 0.0];
    design
}

/// The far cloth without disorder, so that a cloth repeats with its pattern of 4 × 4.
fn ordered(mut design: Design) -> Design {
    design.weave.pattern = Pattern::try_from(vec![
        vec![7, 0, 9, 0],
        vec![0, 8, 1, 7],
        vec![0, 1, 7, 0],
        vec![7, 1, 0, 0],
    ])
    .unwrap();
    let pile = &mut design.pile;
    pile.variants = 1;
    (pile.tilt, pile.twist, pile.jitter) = (0.0, 0.0, 0.0);
    (pile.twist_jitter, pile.stretch, pile.length_jitter) = (0.0, 0.0, 0.0);
    (pile.lean_x, pile.lean_y) = (25.0, 15.0);
    design
}

#[test]
fn the_ends_of_a_carpet_are_the_references() {
    let mut cpu = CpuBackend::default();
    for along_warps in [true, false] {
        for at in [0, 100_000] {
            for method in [Method::Single, Method::Layered] {
                let mut design = carpet(along_warps, at);
                design.quality.method = method;
                let request = request(&design, SIZE);
                let expected = on_reference(&request);
                shows_something(&expected).unwrap();
                same_samples(&request, &expected, &finish(&mut cpu, &request))
                    .unwrap_or_else(|error| panic!("{along_warps} {at} {method:?}: {error}"));
            }
        }
    }
}

/// Pixels that differ by more than rounding.
fn different(a: &Picture, b: &Picture) -> usize {
    let near = |(a, b): &(&[f32; 4], &[f32; 4])| {
        (0..4).all(|c| (a[c] - b[c]).abs() <= 1e-3 * a[c].abs().max(1.0))
    };
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs.filter(|pair| !near(pair)).count()
}

#[test]
fn the_last_cells_look_like_the_first() {
    let mut cpu = CpuBackend::default();
    let allowed = MAX_FLIPS * f64::from(SIZE[0] * SIZE[1]);
    for (along_warps, height) in [
        (true, SkeletonHeight::Winding),
        (false, SkeletonHeight::Paper),
    ] {
        for method in [Method::Single, Method::Layered] {
            let [first, last, shifted] = [48, 99_952, 49].map(|at| {
                let mut design = ordered(carpet(along_warps, at));
                design.skeleton.height = height;
                design.quality.method = method;
                finish(&mut cpu, &request(&design, SIZE))
            });
            shows_something(&first).unwrap();
            // Rays that pass an edge by less than f64 knows a place 4·10⁴ mm away, 10⁻¹¹ mm, are none of so few; but
            // what lies within a block is f32, and its rounding starts from other numbers.
            let count = different(&first, &last);
            assert!(count as f64 <= allowed, "{along_warps} {method:?}: {count}");
            // One cell on the pattern is another.
            assert!(different(&first, &shifted) as f64 > 20.0 * allowed);
        }
    }
}
