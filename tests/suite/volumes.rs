//! The voxels inside loops.

use renderer_core::design::{Phase, Pile, PileKind};
use renderer_core::scene::{Volumes, rasterise};

/// ρ of a voxel, [0, 1].
fn density(volumes: &Volumes, variant: u32, layer: u32, b: u32, a: u32) -> f64 {
    let Volumes {
        resolution, layers, ..
    } = *volumes;
    let index = ((variant * layers + layer) * resolution + b) * resolution + a;
    f64::from(volumes.voxels[index as usize][0]) / 255.0
}

fn terry() -> (Pile, Volumes) {
    let pile = Pile {
        hairiness: 0.0,
        base_width: 2.4,
        ..Pile::default()
    };
    let volumes = rasterise(&pile, &[PileKind::Terry], 3.0);
    (pile, volumes)
}

#[test]
fn every_volume_has_its_voxels() {
    let pile = Pile {
        layers: 5,
        resolution: 12,
        variants: 3,
        ..Pile::default()
    };
    let volumes = rasterise(&pile, &[PileKind::Terry, PileKind::Cut], 3.0);
    assert_eq!(volumes.voxels.len(), 2 * 3 * 5 * 12 * 12);
    assert!(
        volumes.tangents.is_empty(),
        "isotropic pile needs no fibre directions"
    );
}

/// The loop is an arch: solid legs at both sides, a solid top between them, a hole under the arch, air above and around.
#[test]
fn terry_is_an_arch() {
    let (pile, volumes) = terry();
    let (res, layer) = (pile.resolution, pile.layers / 2);
    let column = |x_mm: f64| ((x_mm / pile.base_width + 0.5) * f64::from(res)) as u32;
    let row = |y_mm: f64| (y_mm / 3.0 * f64::from(res)) as u32;
    for variant in 0..pile.variants {
        let most = |b: u32, columns: std::ops::Range<u32>| {
            columns
                .map(|a| density(&volumes, variant, layer, b, a))
                .fold(0.0, f64::max)
        };
        assert!(
            most(row(0.8), 0..column(0.0)) > 0.7,
            "left leg of variant {variant}"
        );
        assert!(
            most(row(0.8), column(0.0)..res) > 0.7,
            "right leg of variant {variant}"
        );
        assert!(
            density(&volumes, variant, layer, row(0.6), column(0.0)) < 0.2,
            "hole of variant {variant}"
        );
        let middle: Vec<f64> = (0..res)
            .map(|b| density(&volumes, variant, layer, b, column(0.0)))
            .collect();
        assert!(
            middle[res as usize * 2 / 3..].iter().any(|&d| d > 0.7),
            "top of variant {variant}"
        );
        assert_eq!(most(res - 1, 0..res), 0.0, "air above variant {variant}");
        for face in [0, pile.layers - 1] {
            let face_most = (0..res).map(|b| {
                (0..res)
                    .map(|a| density(&volumes, variant, face, b, a))
                    .fold(0.0, f64::max)
            });
            assert!(
                face_most.fold(0.0, f64::max) < 0.4,
                "the yarn of variant {variant} touches its volume's face"
            );
        }
    }
}

#[test]
fn variants_differ_and_are_repeatable() {
    let (pile, volumes) = terry();
    let size = (pile.layers * pile.resolution * pile.resolution) as usize;
    let variant = |v: usize| &volumes.voxels[v * size..(v + 1) * size];
    assert_ne!(variant(0), variant(1));
    assert_eq!(
        volumes.voxels,
        rasterise(&pile, &[PileKind::Terry], 3.0).voxels
    );
}

/// More hair adds density and takes none away.
#[test]
fn hair_adds_fuzz_around_the_yarn() {
    let (bald_pile, bald) = terry();
    let hairy = rasterise(
        &Pile {
            hairiness: 1.0,
            ..bald_pile
        },
        &[PileKind::Terry],
        3.0,
    );
    let grown = bald
        .voxels
        .iter()
        .zip(&hairy.voxels)
        .filter(|(b, h)| b[0] == 0 && h[0] > 0)
        .count();
    assert!(
        bald.voxels
            .iter()
            .zip(&hairy.voxels)
            .all(|(b, h)| h[0] >= b[0])
    );
    assert!(
        grown as f64 > 0.02 * bald.voxels.len() as f64,
        "only {grown} voxels gained fuzz"
    );
}

/// Fibre directions in a straight leg run along it (yy dominates); their tensor's trace is ρ.
#[test]
fn fibres_run_along_the_yarn() {
    let pile = Pile {
        hairiness: 0.0,
        phase: Phase::KajiyaKay,
        ..Pile::default()
    };
    let volumes = rasterise(&pile, &[PileKind::Terry], 6.0);
    let (res, layer) = (pile.resolution as usize, pile.layers as usize / 2);
    let mut checked = 0;
    for b in res / 8..res / 3 {
        for a in 0..res {
            let index = (layer * res + b) * res + a;
            let rho = f64::from(volumes.voxels[index][0]) / 255.0;
            let t = volumes.tangents[index].map(|value| f64::from(value) / 127.0);
            // Rounding: half a step of 1/127 for each of three terms, half of 1/255 for the density.
            assert!((t[0] + t[1] + t[2] - rho).abs() < 1.5 / 127.0 + 0.5 / 255.0);
            if rho > 0.5 {
                assert!(
                    t[1] > t[0] + t[2],
                    "voxel ({a}, {b}) runs across its leg: {t:?}"
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 20);
}

/// A cut tuft is wider at its tip than at its root.
#[test]
fn cut_pile_blooms() {
    let pile = Pile {
        hairiness: 0.0,
        variants: 1,
        ..Pile::default()
    };
    let volumes = rasterise(&pile, &[PileKind::Cut], 3.0);
    let width = |b: u32| {
        (0..pile.resolution)
            .filter(|&a| density(&volumes, 0, pile.layers / 2, b, a) > 0.05)
            .count()
    };
    assert!(width(pile.resolution * 3 / 4) > width(1) + 3);
}
