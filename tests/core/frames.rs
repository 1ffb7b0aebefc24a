//! Loop frames against cases computed by hand (MODEL.md §4).

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use renderer_core::design::{Back, Design, Pattern};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{
    ChartYarns, Face, FrameSettings, Jitter, LoopCounts, LoopFinish, LoopInput, LoopPatch,
    MAX_LEAN, MAX_SKEW, MAX_TWIST, compile, loop_shape, warnings,
};

/// f32 rounding of lengths up to some mm, a few operations.
const ROUNDING: f64 = 2e-6;

/// The default design with coarse volumes: these tests are not about them.
fn plain() -> Design {
    let mut design = Design::default();
    (design.pile.layers, design.pile.resolution) = (1, 4);
    design.pile.variants = 1;
    design
}

/// A loop 2 mm wide that stands as it is given.
fn settings() -> FrameSettings {
    FrameSettings {
        base_width: 2.0,
        top_ratio: 1.0,
        thickness: 0.5,
        max_length: 10.0,
        lean: [0.0; 2],
        tilt: 1.0,
        twist: 1.0,
        stretch: 0.5,
        jitter: [0.0; 3],
    }
}

fn input(turbulence: [f64; 4]) -> LoopInput {
    LoopInput {
        face: Face::Front,
        root_heights: [0.25; 2],
        length: 3.0,
        turbulence,
        jitter: Jitter::default(),
        finish: LoopFinish::default(),
    }
}

fn shape(settings: &FrameSettings, input: &LoopInput) -> (LoopPatch, LoopCounts) {
    let mut counts = LoopCounts::default();
    let shape = loop_shape(settings, input, &mut counts).expect("the loop stands");
    (shape, counts)
}

fn assert_near(found: DVec3, expected: [f64; 3]) {
    let difference = (found - DVec3::from(expected)).abs().max_element();
    assert!(difference < ROUNDING, "{found}, not {expected:?}");
}

fn assert_corners(shape: &LoopPatch, expected: [[f64; 3]; 4]) {
    for (found, expected) in shape.corners(2.0).into_iter().zip(expected) {
        assert_near(found, expected);
    }
}

const PLANTED: LoopCounts = LoopCounts {
    planted: 1,
    dropped: 0,
    repaired: 0,
    raised: 0,
    capped: 0,
};

#[test]
fn upright() {
    let (shape, counts) = shape(&settings(), &input([0.0; 4]));
    assert_corners(
        &shape,
        [
            [0.0, -1.0, 0.25],
            [0.0, 1.0, 0.25],
            [0.0, 1.0, 3.25],
            [0.0, -1.0, 3.25],
        ],
    );
    // b along +y, c along +z.
    assert_near(shape.normal(2.0), [1.0, 0.0, 0.0]);
    assert_eq!(counts, PLANTED);
}

#[test]
fn tilted() {
    // a = (0.3, −0.4): θ = 0.5 towards (0.6, −0.8); the base edge is kept.
    let (shape, _) = shape(&settings(), &input([0.3, -0.4, 0.0, 0.0]));
    let (sin, cos) = 0.5_f64.sin_cos();
    let top = [3.0 * sin * 0.6, 3.0 * sin * -0.8, 0.25 + 3.0 * cos];
    assert_corners(
        &shape,
        [
            [0.0, -1.0, 0.25],
            [0.0, 1.0, 0.25],
            [top[0], top[1] + 1.0, top[2]],
            [top[0], top[1] - 1.0, top[2]],
        ],
    );
}

#[test]
fn twisted_by_a_right_angle() {
    let quarter = FrameSettings {
        twist: FRAC_PI_2,
        ..settings()
    };
    let (front, counts) = shape(&quarter, &input([0.0, 0.0, 0.0, 1.0]));
    // Right-handed about +z: y goes to −x.
    assert_corners(
        &front,
        [
            [0.0, -1.0, 0.25],
            [0.0, 1.0, 0.25],
            [-1.0, 0.0, 3.25],
            [1.0, 0.0, 3.25],
        ],
    );
    assert_eq!(counts, PLANTED);
    // On the back the axis is −z, so y goes to +x.
    let (back, _) = shape(
        &quarter,
        &LoopInput {
            face: Face::Back,
            ..input([0.0, 0.0, 0.0, 1.0])
        },
    );
    assert_corners(
        &back,
        [
            [0.0, -1.0, -0.25],
            [0.0, 1.0, -0.25],
            [1.0, 0.0, -3.25],
            [-1.0, 0.0, -3.25],
        ],
    );
}

#[test]
fn on_the_back_only_the_normal_changes_sign() {
    let back = LoopInput {
        face: Face::Back,
        root_heights: [0.2, 0.3],
        ..input([0.3, -0.4, 0.0, 0.0])
    };
    let (shape, _) = shape(&settings(), &back);
    let (sin, cos) = 0.5_f64.sin_cos();
    assert_eq!((shape.root_z0, shape.root_z1), (-0.2, -0.3));
    let axis = DVec3::from_array(shape.axis.map(f64::from));
    assert_near(axis, [3.0 * sin * 0.6, 3.0 * sin * -0.8, -3.0 * cos]);
    assert_eq!(shape.face(), Face::Back);
}

#[test]
fn leans_stop_at_their_cap() {
    let (shape, _) = shape(&settings(), &input([1.0, 1.0, 0.0, 0.0]));
    let share = 0.5_f64.sqrt() * MAX_LEAN.sin();
    assert_near(
        DVec3::from_array(shape.axis.map(f64::from)),
        [3.0 * share, 3.0 * share, 3.0 * MAX_LEAN.cos()],
    );
}

#[test]
fn twist_stops_at_its_cap() {
    let wild = FrameSettings {
        twist: 7.0,
        ..settings()
    };
    let (shape, _) = shape(&wild, &input([0.0, 0.0, 0.0, -1.0]));
    let (sin, cos) = MAX_TWIST.sin_cos();
    assert_near(
        DVec3::from_array(shape.half_top.map(f64::from)),
        [sin, cos, 0.0],
    );
}

#[test]
fn stretched_and_shortened_to_the_limit() {
    let axis_z = |settings: &FrameSettings, stretch: f64| {
        let (shape, counts) = shape(settings, &input([0.0, 0.0, stretch, 0.0]));
        (f64::from(shape.axis[2]), counts.capped)
    };
    assert_eq!(axis_z(&settings(), 0.5), (3.75, 0));
    assert_eq!(axis_z(&settings(), -0.5), (2.25, 0));
    let short = FrameSettings {
        max_length: 3.5,
        ..settings()
    };
    assert_eq!(axis_z(&short, 0.5), (3.5, 1));
}

#[test]
fn a_length_of_zero_plants_nothing() {
    let mut counts = LoopCounts::default();
    let none = LoopInput {
        length: 0.0,
        ..input([0.0; 4])
    };
    assert_eq!(loop_shape(&settings(), &none, &mut counts), None);
    let vanishing = FrameSettings {
        stretch: 1.0,
        ..settings()
    };
    let gone = input([0.0, 0.0, -1.0, 0.0]);
    assert_eq!(loop_shape(&vanishing, &gone, &mut counts), None);
    assert_eq!(counts, LoopCounts::default());
}

#[test]
fn jitter_moves_lean_twist_and_length() {
    let jittery = FrameSettings {
        jitter: [0.5, 0.4, 0.1],
        ..settings()
    };
    let (shape, _) = shape(
        &jittery,
        &LoopInput {
            jitter: Jitter {
                lean: [0.0, 1.0],
                twist: 0.0,
                length: -1.0,
            },
            ..input([0.0; 4])
        },
    );
    let (sin, cos) = 0.5_f64.sin_cos();
    assert_near(
        DVec3::from_array(shape.axis.map(f64::from)),
        [0.0, 2.7 * sin, 2.7 * cos],
    );
}

#[test]
fn top_corners_stay_above_the_sheet() {
    // Leaning along x with a quarter twist, the half top edge is (−cos θ, 0, sin θ); its lower end is at L cos θ − sin
    // θ above the roots. With L = 1 and roots on the sheet that is zero at θ = 45°.
    let settings = FrameSettings {
        twist: FRAC_PI_2,
        ..settings()
    };
    let low = LoopInput {
        root_heights: [0.0; 2],
        length: 1.0,
        ..input([1.2, 0.0, 0.0, 1.0])
    };
    let (shape, counts) = shape(&settings, &low);
    let half = 0.5_f64.sqrt();
    assert_near(
        DVec3::from_array(shape.axis.map(f64::from)),
        [half, 0.0, half],
    );
    assert_eq!((counts.planted, counts.raised), (1, 1));
}

#[test]
fn patches_are_repaired_until_convex() {
    // Without twist α = 2(r² − 1)/(r + 1)² = 2(r − 1)/(r + 1) and β = 0: |α| = 1.8 at r = 19 and at r = 1/19.
    for (asked, kept) in [(40.0, 19.0), (18.9, 18.9), (0.01, 1.0 / 19.0), (0.06, 0.06)] {
        let settings = FrameSettings {
            top_ratio: asked,
            ..settings()
        };
        let (shape, counts) = shape(&settings, &input([0.0; 4]));
        let half_top = f64::from(shape.half_top[1]);
        assert!(
            (half_top - kept).abs() < 1e-6 * kept,
            "{half_top}, not {kept}"
        );
        assert_eq!(counts.repaired, u64::from(asked != kept));
        assert_eq!(counts.planted, 1);
    }
}

#[test]
fn degenerate_patches_are_dropped() {
    // The axis leans along y by 1 rad, and the base edge rises as steeply: both are parallel, b × c = 0.
    let along = LoopInput {
        root_heights: [0.0, 2.0 / 1.0_f64.tan()],
        ..input([0.0, 1.0, 0.0, 0.0])
    };
    let mut counts = LoopCounts::default();
    assert_eq!(loop_shape(&settings(), &along, &mut counts), None);
    assert_eq!(counts.dropped, 1);
    assert_eq!(counts.planted, 0);
}

/// |α| + |β| by the closed forms of MODEL.md §4, for roots at one height.
fn skew_by_formula(r: f64, phi: f64, s: f64, base_width: f64, length: f64) -> f64 {
    let d = 1.0 + r * r + 2.0 * r * phi.cos();
    let alpha = 2.0 * (r * r - 1.0) / d;
    let beta = -2.0 * (base_width * s / length) * (r - 1.0) * r * (1.0 - phi.cos()) / d;
    alpha.abs() + beta.abs()
}

/// α and β of a shape: A's parts along b and c in the plane across n̂.
fn skew_of(shape: &LoopPatch, base_width: f32) -> f64 {
    let [b, c, a] = shape.coefficients(base_width);
    let normal = shape.normal(base_width);
    let area = b.cross(c).dot(normal);
    (a.cross(c).dot(normal).abs() + b.cross(a).dot(normal).abs()) / area
}

#[test]
fn every_loop_is_convex_above_the_sheet_and_keeps_its_length() {
    let mut random = Pcg::new(11, 0);
    let mut next = || f64::from(random.next_float());
    let mut seen = LoopCounts::default();
    for _ in 0..50_000 {
        let base_width = 0.2 + 4.0 * next();
        let settings = FrameSettings {
            base_width,
            top_ratio: 8.0_f64.powf(4.0 * next() - 2.0),
            twist: MAX_TWIST,
            tilt: 1.5,
            stretch: 0.0,
            ..settings()
        };
        let mut value = || 2.0 * next() - 1.0;
        let turbulence = [value(), value(), value(), value()];
        let level = value() > 0.0;
        let root = 0.3 * value().abs();
        let input = LoopInput {
            root_heights: [root, if level { root } else { 0.3 * value().abs() }],
            length: 5.0 * value().abs() + 0.05,
            ..input(turbulence)
        };
        let mut counts = LoopCounts::default();
        let Some(shape) = loop_shape(&settings, &input, &mut counts) else {
            seen.dropped += 1;
            continue;
        };
        seen.repaired += counts.repaired;
        seen.raised += counts.raised;
        let width = base_width as f32;
        let skew = skew_of(&shape, width);
        // Shapes are f32: with |b × c| down to 10⁻³·w₀L the skew's relative rounding is 10³·6e-8·10.
        assert!(
            skew < MAX_SKEW + 1e-3,
            "{settings:?} {input:?}: skew {skew}"
        );
        let axis = DVec3::from_array(shape.axis.map(f64::from));
        assert!((axis.length() / input.length - 1.0).abs() < 1e-6);
        let half_top = DVec3::from_array(shape.half_top.map(f64::from));
        if level && counts.repaired == 0 {
            let ratio = 2.0 * half_top.length() / base_width;
            let s = axis.y / axis.length();
            let phi = settings.twist * turbulence[3];
            let formula = skew_by_formula(ratio, phi, s, base_width, input.length);
            assert!((skew - formula).abs() < 1e-3, "{skew}, formula {formula}");
        }
        // Upright loops may not clear the sheet: very short ones on uneven roots.
        let lowest = root.min(input.root_heights[1]) + axis.z - half_top.z.abs();
        let lean = axis.x.hypot(axis.y);
        assert!(
            lowest > -1e-5 - 0.5 * (root - input.root_heights[1]).abs() || lean < 1e-5,
            "{settings:?} {input:?}: {lowest}"
        );
    }
    assert!(seen.repaired > 1000 && seen.raised > 1000, "{seen:?}");
}

#[test]
fn loops_stand_where_the_pattern_says() {
    let mut design = plain();
    design.sheet.warps = 5;
    design.sheet.wefts = 4;
    design.weave.pattern = Pattern::try_from(vec![vec![7, 0, 8], vec![1, 9, 0]]).unwrap();
    let planted = |back: Back| {
        let mut design = design.clone();
        design.weave.back = back;
        let scene = compile(&design).unwrap();
        assert_eq!(scene.looks.len(), scene.loops.shapes.len());
        assert_eq!(scene.loops.counts.planted, scene.loops.shapes.len() as u64);
        let rows = (0..4).flat_map(|j| scene.loops.planted_in_row(&scene.sheet, j));
        let all: Vec<_> = rows.collect();
        // Every shape is some loop's, and rows of blocks name them in order.
        let mut indices: Vec<u32> = all.iter().map(|planted| planted.index).collect();
        indices.sort_unstable();
        assert!(indices.iter().zip(0..).all(|(&index, k)| index == k));
        let block_rows = 0..scene.loops.sheet_block_rows(&scene.sheet);
        let in_order =
            block_rows.flat_map(|row| scene.loops.planted_in_block_row(&scene.sheet, row));
        let in_order: Vec<_> = in_order.collect();
        assert!(
            in_order
                .iter()
                .zip(0..)
                .all(|(planted, k)| planted.index == k)
        );
        assert_eq!(in_order.len(), all.len());
        assert!(in_order.iter().all(|planted| all.contains(planted)));
        let on = |face: Face| -> Vec<[u32; 2]> {
            let here = all.iter().filter(|planted| planted.face == face);
            here.map(|planted| planted.cell).collect()
        };
        (on(Face::Front), on(Face::Back))
    };
    let front = vec![
        [0, 0],
        [3, 0],
        [1, 1],
        [4, 1],
        [0, 2],
        [3, 2],
        [1, 3],
        [4, 3],
    ];
    assert_eq!(planted(Back::None), (front.clone(), vec![]));
    assert_eq!(planted(Back::Mirror), (front.clone(), front.clone()));
    let back = vec![[2, 0], [1, 1], [4, 1], [2, 2], [1, 3], [4, 3]];
    assert_eq!(planted(Back::Pattern), (front, back));
}

#[test]
fn roots_stand_on_the_skeleton() {
    let mut design = plain();
    design.sheet.warps_per_cm = 10.0;
    design.sheet.wefts_per_cm = 10.0;
    design.pile.base_width = 1.0;
    (design.skeleton.warp_radius, design.skeleton.weft_radius) = (0.2, 0.2);
    design.skeleton.crimp = 0.3;
    let scene = compile(&design).unwrap();
    for planted in scene.loops.planted_in_row(&scene.sheet, 6) {
        // Roots lie half a cell from the crossing, where the warp passes the middle: its upper side is at its radius.
        let patch = scene.loops.patch(planted.index as usize);
        let height = 0.2 * planted.face.sign() as f32;
        // Half a unit, and f32's rounding.
        let off = 0.5 * scene.loops.length_unit_mm + 1e-6;
        assert!((patch.root_z0 - height).abs() < off && (patch.root_z1 - height).abs() < off);
    }
}

#[test]
fn neighbouring_loops_share_a_lie() {
    // MODEL.md §3's bound on the turbulence, times the strengths, bounds how far the axes of neighbours differ.
    let mut design = plain();
    design.weave.pattern = Pattern::filled(1, 1, 7);
    design.weave.back = Back::None;
    design.turbulence.frequency = 0.05;
    design.turbulence.octaves = 1;
    let pile = &mut design.pile;
    (pile.tilt, pile.twist, pile.stretch) = (40.0, 60.0, 0.2);
    (pile.jitter, pile.twist_jitter, pile.length_jitter) = (0.0, 0.0, 0.0);
    let scene = compile(&design).unwrap();
    let step = 3.9 * 0.05 * scene.sheet.pitch_x_mm.max(scene.sheet.pitch_y_mm);
    let length = design.length.value;
    // The axis turns by at most tilt·√2·step, and grows by stretch·step.
    let bound = length * 1.2 * 40.0_f64.to_radians() * 2.0_f64.sqrt() * step + length * 0.2 * step;
    let rows = (0..scene.sheet.wefts).flat_map(|j| scene.loops.planted_in_row(&scene.sheet, j));
    let axes: Vec<DVec3> = rows
        .map(|planted| {
            let patch = scene.loops.patch(planted.index as usize);
            DVec3::from_array(patch.axis.map(f64::from))
        })
        .collect();
    let largest = axes
        .windows(2)
        .zip(0..)
        .filter(|(_, k)| (k + 1) % scene.sheet.warps != 0)
        .map(|(pair, _)| pair[0].distance(pair[1]))
        .fold(0.0, f64::max);
    assert!(
        largest < bound && largest > 0.05 * bound,
        "{largest}, bound {bound}"
    );
}

#[test]
fn what_was_changed_is_reported() {
    let mut design = plain();
    design.pile.top_width = 25.0;
    design.pile.base_width = 1.0;
    let scene = compile(&design).unwrap();
    assert_eq!(scene.loops.counts.repaired, scene.loops.counts.planted);
    let message = warnings(&design, &scene, &mut ChartYarns::default());
    assert!(
        message
            .iter()
            .any(|w| w.path == "pile" && w.text.contains("16800 of 16800")),
        "{message:?}"
    );
    assert!(
        warnings(
            &plain(),
            &compile(&plain()).unwrap(),
            &mut ChartYarns::default()
        )
        .is_empty()
    );
}
