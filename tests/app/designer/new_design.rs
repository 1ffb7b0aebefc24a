//! New designs: every kind of cloth, at its usual and at its most, is a design without faults whose parts fit each
//! other; and the window that asks for one.

use egui::vec2;
use egui_kittest::kittest::Queryable;
use renderer_core::design::{Back, Design, PileKind, Sheared};
use towel_designer::designer::{Cloth, ClothKind};

use super::{choose, click, design, designer_of_size, type_number};

#[test]
fn every_cloth_is_without_faults_at_its_usual_and_at_its_most() {
    for kind in ClothKind::ALL {
        let usual = kind.usual();
        let made = usual.design();
        assert_eq!(made.faults(), [], "{kind:?}");
        assert_eq!(made.warnings(), [], "{kind:?}");
        for per_cm in kind.densities() {
            for (weight, pile_mm) in [(150.0, 0.5), (2000.0, 60.0)] {
                for back in [Back::Mirror, Back::Pattern, Back::None] {
                    let cloth = Cloth {
                        size_mm: [300.0, 400.0],
                        weight,
                        pile_mm,
                        per_cm: [per_cm; 2],
                        back,
                        ..usual.clone()
                    };
                    assert_eq!(cloth.design().faults(), [], "{cloth:?}");
                }
            }
        }
    }
}

#[test]
fn heavier_terry_has_longer_loops_and_denser_cloth_finer_yarn() {
    let towel = ClothKind::Towel.usual();
    let at = |weight| Cloth {
        weight,
        ..towel.clone()
    };
    let heights = [300.0, 400.0, 600.0].map(|weight| at(weight).loop_mm());
    assert!(
        heights[0] < heights[1] && heights[1] < heights[2],
        "{heights:?}"
    );
    // The trade's heights for these weights: 3.5 to 7 mm at most, some 3 mm for the published towel of 433 g/m².
    assert!(
        (2.5..4.0).contains(&at(433.0).loop_mm()),
        "{}",
        at(433.0).loop_mm()
    );
    let dense = Cloth {
        per_cm: [20.0, 22.0],
        ..towel.clone()
    };
    let (usual, dense) = (towel.design(), dense.design());
    assert!(dense.pile.yarn_diameter < 0.8 * usual.pile.yarn_diameter);
    assert!(dense.turbulence.frequency > 1.2 * usual.turbulence.frequency);

    let carpet = ClothKind::Carpet.usual().design();
    assert_eq!(
        (carpet.weave.back, carpet.pile.kind),
        (Back::None, PileKind::Cut)
    );
    assert_eq!(carpet.length.value, 11.0);
    // Tufts stand side by side: no ground is seen between them.
    assert!(carpet.pile.top_width >= 10.0 / carpet.sheet.warps_per_cm);
    assert_eq!(
        ClothKind::BeachTowel.usual().design().finish.sheared,
        Sheared::Front
    );
    assert_eq!(
        ClothKind::Blank.usual().design().pile,
        Design::default().pile
    );
}

#[test]
fn the_window_starts_a_towel_of_the_size_and_weight_asked_for() {
    let mut harness = designer_of_size(None, vec2(1280.0, 720.0));
    click(&mut harness, "Toolbar: New");
    // The window comes to rest in the middle.
    harness.run_steps(12);
    click(&mut harness, "Hand towel");
    type_number(&mut harness, "Width of the new cloth", "20 in");
    type_number(&mut harness, "Length of the new cloth", "2*45");
    type_number(&mut harness, "Weight", "500");
    choose(&mut harness, "Reverse side", "no pile");
    click(&mut harness, "Create");
    harness.run_steps(3);
    let made = design(&harness);
    let expected = Cloth {
        size_mm: [508.0, 900.0],
        weight: 500.0,
        back: Back::None,
        ..ClothKind::HandTowel.usual()
    };
    assert_eq!(*made, expected.design());
    assert!((f64::from(made.sheet.warps) / made.sheet.warps_per_cm - 50.8).abs() < 0.1);
    assert!(!harness.state().document().is_unsaved());
    // The view shows all of it.
    assert_eq!(harness.state().viewport().camera.name, "whole");
    assert!(harness.query_by_label("Create").is_none());

    // With changes, they are asked about first; Cancel keeps everything.
    type_number(&mut harness, "Warps", "250");
    click(&mut harness, "Toolbar: New");
    // The window comes to rest in the middle.
    harness.run_steps(12);
    click(&mut harness, "Carpet");
    click(&mut harness, "Create");
    assert!(harness.query_by_label("Save changes?").is_some());
    click(&mut harness, "Cancel");
    assert_eq!(design(&harness).sheet.warps, 250);
}
