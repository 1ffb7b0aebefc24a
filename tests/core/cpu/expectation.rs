//! `tracked` pictures of the processor are draws of what the reference's are draws of, with what would be noticed.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Colour, Interpolation, Pattern, Phase, SkeletonShading};

use super::scenes::{GROUNDS, LIGHTS, LOOKS, LOOPS, UNBENT, traced_bounces};
use crate::agreement::{
    SIZE, Wrong, assert_agree_and_tell, one_scattering, tracked, unlike_presets_agree,
};
use crate::support::closed::closed;
use crate::support::scenes::{Case, small_towel};

/// Compares a towel of several scatterings; the test sees 3 % of the whole.
fn agree<'a>(case: impl Into<Case<'a>>, bounces: u32, wrongs: &[Wrong]) {
    let case = case.into();
    let design = tracked(case.design.clone(), bounces);
    let case = closed(&design, case.traced_bounces);
    assert_agree_and_tell(&mut CpuBackend::default(), case, SIZE, wrongs, 0.04);
}

#[test]
fn one_scattering_agrees_at_256_samples() {
    one_scattering(
        &mut CpuBackend::default(),
        SIZE,
        &[("density", |d| d.pile.density *= 1.15)],
        &[("phase", |d| d.pile.transmission = 0.45)],
        [0.05, 0.1],
    );
}

#[test]
#[ignore = "long: about 30 s"]
fn one_scattering_agrees_at_256_samples_to_a_few_percent() {
    one_scattering(
        &mut CpuBackend::default(),
        [64, 48],
        &[("density + 3 %", |d| d.pile.density *= 1.03)],
        &[("phase", |d| d.pile.transmission = 0.33)],
        [0.01, 0.026],
    );
}

#[test]
fn every_phase_agrees_whatever_the_bounces() {
    for (bounces, phase) in [
        (2, Phase::FrameLambert),
        (3, Phase::KajiyaKay),
        (4, Phase::GradientLambert),
        (5, Phase::Isotropic),
    ] {
        let mut design = small_towel();
        (design.pile.phase, design.pile.transmission) = (phase, 0.3);
        design.pile.interpolation = match bounces {
            3 => Interpolation::Nearest,
            _ => Interpolation::Linear,
        };
        agree(&design, bounces, &[]);
    }
}

#[test]
fn a_missing_bounce_is_noticed() {
    let wrongs: [Wrong; 2] = [
        ("one bounce less", |d| d.quality.bounces = 4),
        ("one bounce more", |d| d.quality.bounces = 6),
    ];
    agree(&small_towel(), 5, &wrongs);
}

#[test]
fn closed_paths_agree() {
    let mut design = small_towel();
    design.pile.phase = Phase::FrameLambert;
    agree(
        closed(&design, 1),
        16,
        &[("nothing by bounces", |d| d.quality.bounces = 1)],
    );
    design.pile.phase = Phase::Isotropic;
    let fewer: Wrong = ("fewer orders", |d| d.quality.bounces = 6);
    agree(closed(&design, 2), 16, &[fewer]);
}

/// Wide loops of half the density that a free path needs, all bright before black: what passes is set by how densities
/// that overlap are held together (MODEL.md §5).
#[test]
fn crowded_loops_let_the_same_light_through() {
    let mut design = small_towel();
    (LOOPS[LOOPS.len() - 1].1)(&mut design);
    design.skeleton.visible = false;
    design.light.sun.clear();
    design.light.environment.radiance = 0.0;
    design.light.background = Colour::WHITE;
    agree(&design, 1, &[("density", |d| d.pile.density *= 1.1)]);
}

/// Patches without a bend are met by a square that has no square term.
#[test]
fn unbent_loops_agree() {
    let mut design = small_towel();
    (UNBENT.1)(&mut design);
    agree(&design, 1, &[("density", |d| d.pile.density *= 0.3)]);
}

/// Of their frames the parts that hold yarn are looked for: none may be missed.
#[test]
fn sparse_piles_agree() {
    for (name, edit) in LOOPS
        .iter()
        .filter(|(name, _)| ["fur", "grass"].contains(name))
    {
        eprintln!("{name}");
        let mut design = small_towel();
        edit(&mut design);
        let scene = renderer_core::scene::compile(&design).unwrap();
        let voxels = &scene.volumes.voxels;
        let full = voxels.iter().filter(|voxel| voxel[0] > 0).count();
        assert!(10 * full < voxels.len(), "{name} is not sparse: {full}");
        agree(&design, 1, &[("density", |d| d.pile.density *= 0.4)]);
    }
}

#[test]
fn materials_yarns_and_skies_agree() {
    // Several materials under several suns; bare ground that shines under a picture of the sky.
    let mut design = small_towel();
    (LOOKS[LOOKS.len() - 2].1)(&mut design);
    (LIGHTS[3].1)(&mut design);
    agree(&design, 2, &[]);
    let mut ground = small_towel();
    ground.weave.pattern = Pattern::filled(1, 1, 1);
    (GROUNDS[GROUNDS.len() - 1].1)(&mut ground);
    (LIGHTS[5].1)(&mut ground);
    agree(
        &ground,
        2,
        &[("lambert", |d| {
            d.skeleton.shading = SkeletonShading::Lambert;
        })],
    );
}

#[test]
#[ignore = "long: about 120 s"]
fn every_shape_and_ground_agrees() {
    for (name, edit) in LOOPS.iter().chain(&GROUNDS).chain(&LOOKS).chain(&LIGHTS) {
        eprintln!("{name}");
        let mut design = small_towel();
        edit(&mut design);
        agree(closed(&design, traced_bounces(&design)), 3, &[]);
    }
}

#[test]
#[ignore = "long: about 120 s"]
fn unlike_presets_agree_at_256_samples() {
    unlike_presets_agree(&mut CpuBackend::default());
}
