//! Scenes for a coarse preview: rays meet in them what they meet in the whole scene.

use std::sync::Arc;

use renderer_core::design::{AreaLight, CameraDesign, Design, Method, Sun};
use renderer_core::geometry::Camera;
use renderer_core::reference::{Scratch, Tracer};
use renderer_core::render::accumulation::Sample;
use renderer_core::render::{CoarsePreview, RenderRequest, Settings};
use renderer_core::scene::lod::LodView;
use renderer_core::scene::{Compiler, PreviewScene, Scene};

use crate::support::scenes::small_towel;

const STRIDE: u32 = 16;

/// A towel of 150 × 120 crossings that stands in the sun alone, of few enough bounces that every ray is known.
fn towel() -> Design {
    let mut design = small_towel();
    (design.sheet.warps, design.sheet.wefts) = (150, 120);
    design.pile.tilt = 60.0;
    design.light.environment.radiance = 0.0;
    design
}

/// The coarse picture: the first sample of every 16th pixel of every 16th row.
fn coarse(scene: &Arc<Scene>, design: &Design, camera: &Camera, size: [u32; 2]) -> Vec<Sample> {
    let request = RenderRequest {
        view: LodView::of(Arc::clone(scene), *camera),
        size,
        crop: [0, 0, size[0], size[1]],
        settings: Settings::from(&design.quality),
    };
    let tracer = Tracer::new(&request);
    let mut scratch = Scratch::default();
    let rows = (0..size[1]).step_by(STRIDE as usize);
    rows.flat_map(|y| (0..size[0]).step_by(STRIDE as usize).map(move |x| [x, y]))
        .map(|pixel| tracer.sample(pixel, 0, &mut scratch))
        .collect()
}

/// Coarse pictures of the whole scene and of the one for a coarse preview, and the share of loops that the latter has.
fn both(
    design: &Design,
    camera: &CameraDesign,
    size: [u32; 2],
    around_mm: f64,
) -> ([Vec<Sample>; 2], f64) {
    let camera = Camera::from_design(camera);
    let settings = Settings::from(&design.quality);
    let seen = CoarsePreview {
        design,
        camera: &camera,
        size,
        stride: STRIDE,
        settings: &settings,
        around_mm,
    }
    .cells();
    let mut compiler = Compiler::default();
    let PreviewScene::Part(part) = compiler
        .compile_visible(design, &seen, &renderer_core::scene::Cancel::never())
        .unwrap()
    else {
        panic!("there was no scene before");
    };
    let whole = compiler.compile(design).unwrap();
    let share = part.loops.counts.planted as f64 / whole.loops.counts.planted as f64;
    (
        [&whole, &part].map(|scene| coarse(scene, design, &camera, size)),
        share,
    )
}

fn cameras() -> Vec<(&'static str, CameraDesign)> {
    let base = small_towel().view.cameras[0].clone();
    let with = |edit: fn(&mut CameraDesign)| {
        let mut camera = base.clone();
        edit(&mut camera);
        camera
    };
    vec![
        ("whole", with(|c| c.distance = 230.0)),
        ("near", with(|c| c.distance = 40.0)),
        (
            "edge",
            with(|c| {
                c.distance = 40.0;
                c.target = [56.0, 40.0, 0.0];
            }),
        ),
        (
            "grazing",
            with(|c| {
                c.distance = 60.0;
                c.elevation = 9.0;
            }),
        ),
        (
            "below",
            with(|c| {
                c.distance = 80.0;
                c.elevation = -50.0;
            }),
        ),
        (
            "straight down",
            with(|c| {
                c.distance = 90.0;
                c.elevation = 90.0;
            }),
        ),
        ("parallel", with(|c| c.orthographic_height = Some(60.0))),
    ]
}

#[test]
fn a_first_look_is_the_whole_scenes_coarse_picture_to_the_bit() {
    for method in [
        Method::Single,
        Method::Layered,
        Method::Exact,
        Method::SixFace,
    ] {
        for (view, camera) in cameras() {
            if method != Method::Single && !["near", "edge"].contains(&view) {
                continue;
            }
            let mut design = towel();
            design.quality.method = method;
            if view == "edge" {
                // All loops lean far to one side.
                (design.pile.lean_x, design.pile.tilt, design.pile.jitter) = (60.0, 3.0, 0.0);
            }
            let ([whole, part], share) = both(&design, &camera, [640, 480], 0.0);
            let hits = whole.iter().filter(|sample| sample.first.is_some()).count();
            assert!(hits > whole.len() / 6, "{view}: {hits} rays meet cloth");
            let differ = whole.iter().zip(&part).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{method:?} {view}: pixels of {}", whole.len());
            // From afar the rays are everywhere.
            let most = if view == "whole" { 1.0 } else { 0.8 };
            assert!((0.001..=most).contains(&share), "{view}: {share}");
        }
    }
}

#[test]
fn loops_that_only_lights_see_belong_to_a_first_look() {
    let mut by_areas = towel();
    by_areas.light.sun.clear();
    // One low at the side, that reaches down past the cloth; one below.
    by_areas.light.area = [(5.0, 200.0, 300.0), (-35.0, 70.0, 2000.0)]
        .map(|(elevation, azimuth, distance)| AreaLight {
            elevation,
            azimuth,
            distance,
            width: 60.0,
            height: 100.0,
            ..AreaLight::default()
        })
        .to_vec();
    let mut by_suns = towel();
    by_suns.light.sun = vec![
        Sun {
            elevation: 12.0,
            azimuth: 200.0,
            angular_diameter: 6.0,
            ..Sun::default()
        },
        Sun {
            elevation: -35.0,
            azimuth: 70.0,
            ..Sun::default()
        },
    ];
    for design in [by_suns, by_areas] {
        lights_are_followed(&design);
    }
}

fn lights_are_followed(design: &Design) {
    let (view, camera) = cameras().swap_remove(1);
    let ([whole, part], share) = both(design, &camera, [640, 480], 0.0);
    assert!(whole == part, "{view}");
    assert!(share < 0.9, "{share}");
    // Without the lights' ways it is another picture: the test can tell.
    let mut dark = design.clone();
    dark.quality.shadows = false;
    let camera = Camera::from_design(&camera);
    let seen = CoarsePreview {
        design: &dark,
        camera: &camera,
        size: [640, 480],
        stride: STRIDE,
        settings: &Settings::from(&dark.quality),
        around_mm: 0.0,
    }
    .cells();
    let made =
        Compiler::default().compile_visible(design, &seen, &renderer_core::scene::Cancel::never());
    let PreviewScene::Part(bare) = made.unwrap() else {
        panic!("there was no scene before");
    };
    assert!(coarse(&bare, design, &camera, [640, 480]) != whole);
}

#[test]
fn what_a_first_look_made_is_kept_and_a_scene_that_is_there_is_taken() {
    let design = towel();
    let camera = Camera::from_design(&cameras()[1].1);
    let settings = Settings::from(&design.quality);
    let look = |design: &Design| {
        CoarsePreview {
            design,
            camera: &camera,
            size: [640, 480],
            stride: STRIDE,
            settings: &settings,
            around_mm: 1.0,
        }
        .cells()
    };
    let never = renderer_core::scene::Cancel::never();
    let mut compiler = Compiler::default();
    let first = compiler.compile(&design).unwrap();
    // Nothing that loops follow from has changed.
    let mut edited = design.clone();
    edited.light.background.0 = [1, 2, 3];
    let PreviewScene::Whole(scene) = compiler
        .compile_visible(&edited, &look(&edited), &never)
        .unwrap()
    else {
        panic!("all loops were there");
    };
    assert!(scene.loops == first.loops && scene.looks == first.looks);

    edited.pile.lean_x += 5.0;
    edited.pile.plies += 1;
    let PreviewScene::Part(part) = compiler
        .compile_visible(&edited, &look(&edited), &never)
        .unwrap()
    else {
        panic!("the loops have changed");
    };
    let made = compiler.last_report().frames_made;
    let whole = compiler.compile(&edited).unwrap();
    assert!(made < compiler.last_report().frames_made);
    assert!(whole.volumes == part.volumes && whole.volumes != first.volumes);
    let fresh = Compiler::default().compile(&edited).unwrap();
    assert!(whole.loops.shapes == fresh.loops.shapes && *whole.looks == *fresh.looks);
    assert!(whole.loops.entries == fresh.loops.entries);
}
