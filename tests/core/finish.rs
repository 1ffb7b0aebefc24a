//! Wear and finish: shorn faces are level, as many loops are pulled as asked for, water gathers loops and darkens them.

use renderer_core::design::{Back, Design, Pattern, PileKind, Sheared};
use renderer_core::scene::{Face, LoopPatch, PlantedLoop, Scene, compile, wet_reflectance};

/// Loops on both faces of every second crossing.
fn terry() -> Design {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (80, 60);
    design.weave.back = Back::Mirror;
    let pile = &mut design.pile;
    (pile.layers, pile.resolution, pile.variants) = (3, 8, 2);
    design
}

/// All loops of one face.
fn loops(scene: &Scene, face: Face) -> Vec<(PlantedLoop, LoopPatch)> {
    let rows = (0..scene.sheet.wefts).flat_map(|j| scene.loops.planted_in_row(&scene.sheet, j));
    rows.filter(|planted| planted.face == face)
        .map(|planted| (planted, scene.loops.patch(planted.index as usize)))
        .collect()
}

/// Height of the highest corner over the sheet's plane, along the face's normal, mm.
fn highest(scene: &Scene, patch: &LoopPatch) -> f64 {
    let corners = patch.corners(scene.loops.base_width_mm);
    let heights = corners.map(|corner| patch.face().sign() * corner.z);
    heights[2].max(heights[3])
}

fn kind_of(scene: &Scene, planted: &PlantedLoop) -> PileKind {
    let look = scene.looks[planted.index as usize];
    let material = scene.pile.materials[usize::from(look.material)];
    scene.volumes.kinds[material.kind as usize]
}

#[test]
fn shears_leave_tufts_of_even_height_and_lower_loops_alone() {
    for face in [Face::Front, Face::Back] {
        let natural = compile(&terry()).unwrap();
        let mut design = terry();
        design.finish.shear_height = 2.2;
        design.finish.sheared = match face {
            Face::Front => Sheared::Front,
            Face::Back => Sheared::Back,
        };
        let shorn = compile(&design).unwrap();
        // Root, axis and half top edge are each rounded to half a unit.
        let rounding = 2.0 * f64::from(shorn.loops.length_unit_mm);
        let mut counts = [0; 2];
        for ((planted, before), (_, after)) in loops(&natural, face).iter().zip(loops(&shorn, face))
        {
            let (was, is) = (highest(&natural, before), highest(&shorn, &after));
            if was > 2.2 + rounding {
                assert!((is - 2.2).abs() <= rounding, "{was} {is}");
                assert_eq!(kind_of(&shorn, planted), PileKind::Cut);
                // What is left leans as it did.
                let lean = |patch: &LoopPatch| [0, 1].map(|k| patch.axis[k] / patch.axis[2]);
                for (a, b) in lean(before).into_iter().zip(lean(&after)) {
                    assert!((a - b).abs() < 2e-3, "{before:?} {after:?}");
                }
                counts[0] += 1;
            } else if was < 2.2 - rounding {
                assert_eq!(*before, after);
                assert_eq!(kind_of(&shorn, planted), PileKind::Terry);
                counts[1] += 1;
            }
        }
        assert!(counts[0] > 300 && counts[1] > 100, "{counts:?}");
        // Above the middles that reach the shears nothing is askew.
        let other = if face == Face::Front {
            Face::Back
        } else {
            Face::Front
        };
        for ((planted, before), (_, after)) in
            loops(&natural, other).iter().zip(loops(&shorn, other))
        {
            assert_eq!(*before, after, "the other face is left alone");
            assert_eq!(kind_of(&shorn, planted), PileKind::Terry);
        }
    }
}

#[test]
fn shears_below_the_roots_leave_nothing() {
    let mut design = terry();
    design.finish.sheared = Sheared::Both;
    design.finish.shear_height = 0.05;
    let scene = compile(&design).unwrap();
    assert_eq!(scene.loops.shapes.len(), 0);
    assert_eq!(scene.loops.counts.dropped, 0);
}

#[test]
fn as_many_loops_are_pulled_as_asked_for_and_by_as_much() {
    let mut design = terry();
    design.finish.pulled = 0.1;
    design.finish.pulled_length = 3.0;
    let (natural, pulled) = (compile(&terry()).unwrap(), compile(&design).unwrap());
    let length = |patch: &LoopPatch| patch.axis.iter().map(|a| a * a).sum::<f32>().sqrt();
    let unit = pulled.loops.length_unit_mm;
    let mut count = 0;
    let pairs = [Face::Front, Face::Back].into_iter().flat_map(|face| {
        let before = loops(&natural, face);
        before.into_iter().zip(loops(&pulled, face))
    });
    let pairs: Vec<_> = pairs.collect();
    for ((_, before), (_, after)) in &pairs {
        let longer = length(after) - length(before);
        if (longer - 3.0).abs() < 2.0 * unit {
            count += 1;
        } else {
            assert!(longer.abs() < 2.0 * unit, "{longer}");
        }
    }
    let (all, share) = (pairs.len() as f64, 0.1);
    let deviation = (all * share * (1.0 - share)).sqrt();
    // Five deviations of a binomial count.
    assert!(
        (f64::from(count) - all * share).abs() < 5.0 * deviation,
        "{count} of {all}"
    );

    // Tufts are not pulled.
    design.finish.sheared = Sheared::Both;
    design.finish.shear_height = 0.6;
    let shorn = compile(&design).unwrap();
    let all = [Face::Front, Face::Back].map(|face| loops(&shorn, face));
    for (_, patch) in all.iter().flatten() {
        assert!(highest(&shorn, patch) < 0.6 + 2.0 * f64::from(shorn.loops.length_unit_mm));
    }
}

/// Between neighbouring loops of one face: the distance of their tips over that of their roots, the middle one of all.
fn gathering(design: &Design) -> f64 {
    let scene = compile(design).unwrap();
    let sheet = &scene.sheet;
    let places: Vec<[[f64; 2]; 2]> = loops(&scene, Face::Front)
        .iter()
        .map(|(planted, patch)| {
            let root = sheet.cell_centre(planted.cell[0].into(), planted.cell[1].into());
            let tip = [0, 1].map(|k| root[k] + f64::from(patch.axis[k]));
            [root, tip]
        })
        .collect();
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let pairs = places.iter().zip(&places[1..]);
    let mut ratios: Vec<f64> = pairs
        .map(|(a, b)| (distance(a[0], b[0]), distance(a[1], b[1])))
        .filter(|&(roots, _)| roots < 2.0)
        .map(|(roots, tips)| tips / roots)
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios[ratios.len() / 2]
}

#[test]
fn water_gathers_loops() {
    let mut design = terry();
    design.weave.pattern = Pattern::filled(1, 1, 7);
    let pile = &mut design.pile;
    (pile.tilt, pile.jitter) = (0.0, 0.0);
    (pile.lean_x, pile.lean_y) = (0.0, 0.0);
    design.finish.clump_size = 5.0;
    assert!((gathering(&design) - 1.0).abs() < 1e-3);
    let mut last = 1.0;
    for wetness in [0.3, 0.6, 1.0] {
        design.finish.wetness = wetness;
        let now = gathering(&design);
        // Three quarters of the way, times the wetness.
        let expected = 1.0 - 0.75 * wetness;
        assert!(
            now < last && (now - expected).abs() < 0.03,
            "{wetness}: {now}"
        );
        last = now;
    }
}

#[test]
fn water_darkens_as_light_that_is_thrown_back_again_and_again() {
    // Rays: in through the film, back from the yarn, out through the film or onto the yarn once more.
    let (outside, inside) = (0.066, 1.0 - (1.0 - 0.066) / (1.33 * 1.33));
    for k in 0..=20 {
        let dry = f64::from(k) / 20.0;
        let (mut light, mut out) = (1.0 - outside, 0.0);
        for _ in 0..200 {
            light *= dry;
            out += light * (1.0 - inside);
            light *= inside;
        }
        assert!((wet_reflectance(dry, 1.0) - out).abs() < 1e-12, "{dry}");
        assert_eq!(wet_reflectance(dry, 0.0), dry);
        let half = wet_reflectance(dry, 0.5);
        assert!((half - 0.5 * (dry + out)).abs() < 1e-12);
        // Lekner and Dorf: black and white change least, wet white stays brighter than wet grey.
        assert!(out <= dry);
    }
}

#[test]
fn water_thins_yarn_and_colours_yarn_and_ground() {
    let dry = compile(&terry()).unwrap();
    let mut design = terry();
    design.finish.wetness = 1.0;
    let wet = compile(&design).unwrap();
    let mass = |scene: &Scene| -> u64 {
        let voxels = scene.volumes.voxels.iter();
        voxels.map(|&[density, _]| u64::from(density)).sum()
    };
    // Yarn of three quarters of the diameter is as much yarn: it is denser by as much as its section is smaller.
    let [before, after] = [&dry, &wet].map(|scene| scene.pile.materials[0].density_per_mm);
    assert!((after / before - 16.0 / 9.0).abs() < 1e-6);
    assert!(mass(&wet) < mass(&dry) * 3 / 4);
    for channel in 0..3 {
        let ground = f64::from(dry.skeleton.albedo[channel]);
        let expected = wet_reflectance(ground, 1.0);
        assert!((f64::from(wet.skeleton.albedo[channel]) - expected).abs() < 1e-6);
        assert!(wet.looks[0].albedo[channel] < dry.looks[0].albedo[channel]);
    }
}
