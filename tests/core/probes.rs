//! Parts of the shaders on their own: WGSL appended to the tracing program runs them on chosen inputs.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use renderer_core::geometry::{LoopFrame, Root};
use renderer_core::sampling::Sampler;
use renderer_core::sampling::{self, Pcg, Set};

use crate::support::patches::{Case, Random, THICKNESS, answered, asked, truth};
use crate::support::probe::{Probe, ask};

/// A loop 1.9 mm wide and 3 mm long, with its top edge turned by up to `twist` mm, and a ray from `distance` mm towards
/// a point up to `beside` times the patch's size away from its middle.
fn case(random: &mut Random, twist: f32, distance: f32, beside: f32) -> Case {
    let half_base = Vec3::new(0.0, 0.95, 0.0) + random.vector(0.1);
    let axis = Vec3::new(0.0, 0.0, 3.0) + random.vector(1.5);
    let half_top = half_base * random.within(0.6, 1.4) + random.vector(twist);
    let middle = Vec3::new(0.0, 0.0, random.within(-0.3, 0.3));
    let target = middle
        + axis * (0.5 + random.within(-0.5, 0.5) * beside)
        + half_base * random.within(-1.0, 1.0) * beside;
    let direction = random.direction();
    Case {
        half_base,
        axis,
        half_top,
        middle,
        origin: target - direction * distance,
        direction,
        cell: [0; 2],
    }
}

/// Whether the roots are the same up to what moving the ray by `tolerance` mm does; the patch is some mm in size, so
/// that u and v move by as much, and t by as much over the cosine at which the ray meets the patch.
fn are_roots_of(case: &Case, found: &[Root], tolerance: f64) -> bool {
    let (a, b) = case.direction.as_dvec3().any_orthonormal_pair();
    let mut shifts = vec![DVec3::ZERO];
    for k in 0..12 {
        let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
        let aside = a * angle.cos() + b * angle.sin();
        shifts.extend([0.02, 0.2, 1.0].map(|part| aside * part * tolerance));
    }
    shifts.iter().any(|&shift| {
        let expected = truth(case, shift);
        expected.len() == found.len()
            && expected.iter().zip(found).all(|(e, f)| {
                let moved = case.patch().at(e.u, e.v) - case.patch().at(f.u, f.v);
                moved.length() < 30.0 * tolerance && (e.t - f.t).abs() < 30.0 * tolerance
            })
    })
}

#[test]
fn patches_are_met_where_they_are_in_f64() {
    let mut random = Random(Pcg::new(7, 1));
    // Twist of the top edge, distance of the origin, reach beside the patch, tolerance. f32 resolves 6e-8 of the
    // distance; some ten operations, divided by cosines down to a few hundredths where rays graze.
    for (twist, distance, beside, tolerance) in [
        (0.05, 2.0, 1.0, 4e-6),
        (1.5, 2.0, 1.3, 4e-6),
        (3.0, 8.0, 1.5, 8e-6),
        (1.0, 300.0, 1.2, 2e-4),
    ] {
        let cases: Vec<Case> = (0..4000)
            .map(|_| case(&mut random, twist, distance, beside))
            .collect();
        let (mut met, mut met_twice, mut wrong) = (0, 0, 0);
        for (case, answer) in cases.iter().zip(asked(&cases)) {
            let found = answered(&answer);
            met += u32::from(!found.is_empty());
            met_twice += u32::from(found.len() == 2);
            if !are_roots_of(case, &found, tolerance) {
                wrong += 1;
            }
        }
        assert!(met > 1000, "only {met} rays meet a patch");
        assert!(twist < 1.0 || met_twice > 10, "only {met_twice} twice");
        // Rays in a ruling line's direction have no stable answer.
        assert!(wrong <= 4, "{wrong} of 4000 with twist {twist}");
    }
}

#[test]
fn a_wrong_root_would_be_noticed() {
    let mut random = Random(Pcg::new(8, 1));
    let cases: Vec<Case> = (0..200).map(|_| case(&mut random, 1.5, 2.0, 1.0)).collect();
    let mut noticed = 0;
    let mut tried = 0;
    for (case, answer) in cases.iter().zip(asked(&cases)) {
        let mut found = answered(&answer);
        if let Some(first) = found.first_mut() {
            tried += 1;
            first.u += 2e-3;
            noticed += u32::from(!are_roots_of(case, &found, 4e-6));
        }
    }
    assert!(tried > 100 && noticed == tried, "{noticed} of {tried}");
}

#[test]
fn grazing_and_degenerate_patches_give_no_nonsense() {
    let up = Vec3::Z;
    let flat = Case {
        half_base: Vec3::Y,
        axis: up * 2.0,
        half_top: Vec3::Y,
        middle: Vec3::ZERO,
        origin: Vec3::new(-3.0, 0.3, 0.7),
        direction: Vec3::X,
        cell: [0; 2],
    };
    let cases = [
        flat,
        // In the patch's own plane, along each edge, and along an edge itself.
        Case {
            origin: Vec3::new(0.0, -3.0, 0.5),
            direction: Vec3::Y,
            ..flat
        },
        Case {
            origin: Vec3::new(0.0, 0.2, -3.0),
            direction: up,
            ..flat
        },
        Case {
            origin: Vec3::new(0.0, -1.0, -3.0),
            direction: up,
            ..flat
        },
        // Top edge of no width, base of no width, no length, nothing at all.
        Case {
            half_top: Vec3::ZERO,
            ..flat
        },
        Case {
            half_base: Vec3::ZERO,
            ..flat
        },
        Case {
            axis: Vec3::ZERO,
            ..flat
        },
        Case {
            half_base: Vec3::ZERO,
            half_top: Vec3::ZERO,
            axis: Vec3::ZERO,
            ..flat
        },
        // A saddle met along its axis, and a bow-tie.
        Case {
            half_top: Vec3::X,
            origin: Vec3::new(-3.0, 0.0, 1.0),
            ..flat
        },
        Case {
            half_top: -Vec3::Y,
            ..flat
        },
    ];
    // `asked` requires that everything is finite.
    let answers = asked(&cases);
    let [u, v, t, count] = answers[0].first;
    assert_eq!(count, 1.0);
    assert!((u - 0.65).abs() < 1e-6 && (v - 0.35).abs() < 1e-6 && (t - 3.0).abs() < 1e-6);
    for (case, answer) in cases.iter().zip(&answers).skip(4) {
        for root in answered(answer) {
            let off = case.patch().at(root.u, root.v) - case.ray().at(root.t);
            assert!(off.length() < 1e-5, "{case:?} {root:?}");
        }
    }
}

#[test]
fn slopes_and_inversion_are_those_of_the_frame() {
    let mut random = Random(Pcg::new(9, 1));
    let cases: Vec<Case> = (0..4000)
        .map(|_| case(&mut random, 0.7, 2.0, 1.0))
        .collect();
    let mut checked = 0;
    for (case, answer) in cases.iter().zip(asked(&cases)) {
        let frame = LoopFrame::new(case.patch(), f64::from(THICKNESS));
        let [alpha, beta] = frame.skew();
        if answer.first[3] < 1.0 || alpha.abs() + beta.abs() > 1.8 {
            continue;
        }
        let [u, v, t, _] = answer.first.map(f64::from);
        let slopes = frame.slopes(u, v, case.direction.as_dvec3());
        // Some tens of f32 operations, divided by the projected area of a loop near the limit of convexity (a tenth).
        let near = |a: f64, b: f32, scale: f64| (a - f64::from(b)).abs() < 2e-5 * scale.max(1.0);
        let size = slopes.u.abs().max(slopes.v.abs()).max(slopes.w.abs());
        assert!(
            near(slopes.u, answer.slopes[0], size)
                && near(slopes.v, answer.slopes[1], size)
                && near(slopes.w, answer.slopes[2], size)
                && near(
                    frame.lift * slopes.u * slopes.v,
                    answer.slopes[3],
                    size * size
                ),
            "{slopes:?} {answer:?}"
        );
        // The point of a root is in the middle of the thickness, at the root's u and v.
        let point = case.ray().at(t);
        if let Some(inside) = frame.invert(point) {
            for (expected, found) in inside.iter().zip(answer.inverted) {
                assert!(near(*expected, found, 5.0), "{inside:?} {answer:?}");
            }
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
#[repr(C)]
struct SampleAnswer {
    sets: [[[u32; 4]; 3]; 5],
    free_paths: [u32; 4],
}

#[test]
fn random_numbers_are_equal_to_the_bit() {
    let mut random = Pcg::new(3, 3);
    let mut word = || {
        let [high, low] = [random.next_float(), random.next_float()].map(|x| (x * 65536.0) as u32);
        high << 16 | low
    };
    let mut probes: Vec<[u32; 4]> = (0..3000)
        .map(|k| [word() % 16_384, word() % 16_384, word() >> (k % 32), word()])
        .collect();
    probes.extend([[0; 4], [u32::MAX; 4], [16_383, 0, 1, 0]]);
    let probe = Probe {
        entry: "probe_samples",
        bindings: [2, 3],
        answer_size: size_of::<SampleAnswer>() as u64,
        scene: None,
    };
    let answers: Vec<SampleAnswer> = ask(&probe, &probes);
    for (&[x, y, sample, seed], answer) in probes.iter().zip(&answers) {
        let pixel = sampling::pixel_seed(seed, [x, y]);
        let bounce = 1 + sample % 64;
        let sets = [
            Set::Film,
            Set::Sun {
                bounce,
                sun: sample % 8,
            },
            Set::Environment { bounce },
            Set::Onward { bounce },
            Set::Area {
                bounce,
                area: sample % 4,
            },
        ];
        let mut generator = Pcg::new(pixel, sample);
        let mut next = || generator.next_float().to_bits();
        let expected = SampleAnswer {
            sets: sets.map(|set| {
                [
                    sampling::owen_bits(pixel, sample, set),
                    sampling::sample(Sampler::Owen, pixel, sample, set).map(f32::to_bits),
                    sampling::random_bits(pixel, sample, set),
                ]
            }),
            free_paths: [next(), next(), next(), 0],
        };
        assert_eq!(
            *answer, expected,
            "pixel {x},{y}, sample {sample}, seed {seed}"
        );
    }
}
