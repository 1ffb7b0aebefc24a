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
    let volumes = rasterise(&pile, PileKind::ALL, 3.0);
    let volume = 3 * 5 * 12 * 12;
    assert_eq!(volumes.voxels.len(), PileKind::ALL.len() * volume);
    for (kind, voxels) in PileKind::ALL.iter().zip(volumes.voxels.chunks(volume)) {
        let full = voxels.iter().filter(|voxel| voxel[0] > 0).count();
        assert!(
            full > volume / 50 && full < volume,
            "{kind:?}: {full} voxels of {volume}"
        );
    }
    assert!(
        volumes.tangents.is_empty(),
        "isotropic pile needs no fibre directions"
    );
}

/// The loop is an arch: solid legs at both sides, a solid top between them, a hole under the arch, air above and
/// around.
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

/// A pile with room around it, and the sums of ρ of each row of its first variant, from the root up.
fn rows(kind: PileKind, edit: impl Fn(&mut Pile)) -> (Pile, Volumes, Vec<f64>) {
    let mut pile = Pile {
        hairiness: 0.0,
        variants: 2,
        base_width: 4.0,
        thickness: 4.0,
        yarn_diameter: 1.4,
        layers: 24,
        ..Pile::default()
    };
    edit(&mut pile);
    let volumes = rasterise(&pile, &[kind], 12.0);
    let sum = |b: u32| {
        (0..pile.layers)
            .flat_map(|layer| (0..pile.resolution).map(move |a| (layer, a)))
            .map(|(layer, a)| density(&volumes, 0, layer, b, a))
            .sum()
    };
    let rows = (0..pile.resolution).map(sum).collect();
    (pile, volumes, rows)
}

/// No kind is cut off by the faces of its volume.
#[test]
fn no_kind_outgrows_its_volume() {
    for &kind in PileKind::ALL {
        let (pile, volumes, rows) = rows(kind, |_| ());
        assert_eq!(rows[pile.resolution as usize - 1], 0.0, "{kind:?} above");
        let (last, last_layer) = (pile.resolution - 1, pile.layers - 1);
        for variant in 0..pile.variants {
            for b in 0..pile.resolution {
                let sides = (0..pile.layers).flat_map(|layer| [(layer, 0), (layer, last)]);
                let faces = (0..pile.resolution).flat_map(|a| [(0, a), (last_layer, a)]);
                for (layer, a) in sides.chain(faces) {
                    let rho = density(&volumes, variant, layer, b, a);
                    assert!(rho < 0.25, "{kind:?}: {rho} at ({a}, {b}) of layer {layer}");
                }
            }
        }
    }
}

/// A twisted strand is as thick above as below, until it is cut; twist and plies show.
#[test]
fn twisted_pile_is_a_strand() {
    let (pile, volumes, strand) = rows(PileKind::Twisted, |_| ());
    let section = |rows: &[f64]| rows.iter().sum::<f64>() / rows.len() as f64;
    let (below, above) = (section(&strand[4..12]), section(&strand[18..26]));
    assert!(
        (above / below - 1.0).abs() < 0.15,
        "{below} below, {above} above"
    );
    // Wherever it is cut through it is solid somewhere, and stands on one leg: two in the volume would be twice as
    // much.
    let solid = |b: u32| {
        let most = |layer| (0..pile.resolution).map(move |a| (layer, a));
        let all = (0..pile.layers).flat_map(most);
        all.map(|(layer, a)| density(&volumes, 0, layer, b, a))
            .fold(0.0, f64::max)
    };
    assert!((1..26).all(|b| solid(b) > 0.6));
    let (_, _, terry) = rows(PileKind::Terry, |_| ());
    let ratio = section(&terry[4..12]) / below;
    assert!((1.7..2.3).contains(&ratio), "legs of terry: {ratio}");
    let (_, _, untwisted) = rows(PileKind::Twisted, |pile| pile.twist_per_cm = 0.0);
    assert_ne!(strand, untwisted);
}

/// Fur is dense below and thins out in two steps: the undercoat ends below two thirds, guard hairs near the top.
#[test]
fn fur_has_an_undercoat_and_guard_hairs() {
    let (_, _, rows) = rows(PileKind::Fur, |pile| pile.fibres = 90);
    let (root, middle, top) = (rows[3], rows[22], rows[29]);
    assert!(
        middle < 0.4 * root,
        "{middle} of {root} above the undercoat"
    );
    assert!(
        top > 0.0 && top < 0.5 * middle,
        "{top} at the tips, {middle} below"
    );
}

/// Grass has as many blades as there are plies, flat ones, and their ribs are darker.
#[test]
fn grass_has_blades() {
    let total = |plies: u32| -> f64 {
        let (_, _, rows) = rows(PileKind::Grass, |pile| pile.plies = plies);
        rows.iter().sum()
    };
    let ratio = total(4) / total(1);
    // Blades are of several heights.
    assert!(
        (2.5..6.0).contains(&ratio),
        "four blades are {ratio} of one"
    );
    let (pile, volumes, _) = rows(PileKind::Grass, |pile| pile.plies = 1);
    let ribbed = volumes
        .voxels
        .iter()
        .filter(|v| v[0] > 30 && v[1] < v[0])
        .count();
    let plain = volumes
        .voxels
        .iter()
        .filter(|v| v[0] > 30 && v[1] == v[0])
        .count();
    assert!(
        ribbed > 10 && plain > 10,
        "{ribbed} of the rib, {plain} beside it"
    );
    assert!(pile.yarn_diameter < pile.base_width);
}
