//! Phase functions: energy, sampling, and the fibre's direction.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use renderer_core::design::{Design, Method, Phase, SkeletonDesign, Weave};
use renderer_core::geometry::main_axis;
use renderer_core::geometry::{Ray, orthonormal_basis};
use renderer_core::optics::{Lobe, Optics};
use renderer_core::reference::Scratch;
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Material, PileOptics, Section, Skeleton, Volumes, compile};

use super::cloth::{
    ALL_PHASES, Random, all_loops, direction_bins, integral, shares_of_samples, tracer,
};

fn optics(phase: Phase, transmission: f32, specular: f32, exponent: f32) -> Optics {
    let pile = PileOptics {
        materials: vec![Material {
            density_per_mm: 1.0,
            kind: 0,
            phase,
            transmission,
            specular,
            exponent,
        }],
    };
    let skeleton = Skeleton::new(&Weave::default(), &SkeletonDesign::default());
    Optics::new(&pile, &skeleton)
}

fn frame(normal: DVec3) -> Lobe {
    Lobe::Frame {
        normal,
        material: 0,
    }
}

fn fibre(tangent: DVec3) -> Lobe {
    Lobe::Fibre {
        tangent,
        material: 0,
    }
}

/// All lobes with parameters that stress them.
fn lobes(axis: DVec3) -> Vec<(Optics, Lobe)> {
    let mut lobes = vec![(optics(Phase::Isotropic, 0.0, 0.0, 1.0), Lobe::Isotropic)];
    for transmission in [0.0, 0.3, 1.0] {
        let optics = optics(Phase::FrameLambert, transmission, 0.0, 1.0);
        lobes.push((optics.clone(), frame(axis)));
        for x in [0.0, 0.6, 20.0] {
            lobes.push((optics.clone(), Lobe::gradient(axis * x, 1.0, 0)));
        }
    }
    for (specular, exponent) in [(0.0, 1.0), (1.0, 1.0), (0.4, 12.0), (1.0, 500.0)] {
        let optics = optics(Phase::KajiyaKay, 0.0, specular, exponent);
        lobes.push((optics, fibre(axis)));
    }
    lobes.push((optics(Phase::Isotropic, 0.0, 0.0, 1.0), Lobe::Surface(axis)));
    lobes
}

#[test]
fn every_phase_keeps_its_energy() {
    let axis = DVec3::new(0.2, -0.6, 0.5).normalize();
    let mut random = Random::new(1);
    let mut views: Vec<_> = (0..4).map(|_| random.direction()).collect();
    views.extend([axis, -axis, axis.any_orthonormal_vector()]);
    for (optics, lobe) in lobes(axis) {
        for &view in &views {
            let sum = integral(axis, |light| optics.value(lobe, view, light));
            // Exactly 1 for all of them: rings of π/540 integrate the sharpest highlight (0.1 rad) to 10⁻⁴, the
            // table of 257 norms is linear between entries to 10⁻⁴.
            assert!(
                (sum - 1.0).abs() < 1e-3,
                "{lobe:?} {optics:?} from {view}: {sum}"
            );
        }
    }
}

#[test]
fn samples_follow_the_value() {
    let axis = DVec3::new(-0.3, 0.1, 0.9).normalize();
    let mut random = Random::new(2);
    for (optics, lobe) in lobes(axis) {
        let view = random.direction();
        let expected = direction_bins(axis, |light| optics.value(lobe, view, light));
        let (found, deviation) =
            shares_of_samples(axis, |numbers| optics.sample(lobe, view, numbers));
        for (bin, (e, f)) in expected.iter().zip(&found).enumerate() {
            // Bins are integrated to some 10⁻³ of the whole where a highlight is sharp.
            let allowed = 5.0 * deviation[bin] + 2e-3;
            assert!(
                (e - f).abs() < allowed,
                "{lobe:?} {optics:?}: bin {bin} is {f}, not {e} ± {allowed}"
            );
        }
    }
}

#[test]
fn frame_lambert_reflects_and_lets_through() {
    let optics = optics(Phase::FrameLambert, 0.3, 0.0, 1.0);
    let lobe = frame(DVec3::Z);
    let view = DVec3::new(0.5, 0.0, 0.8).normalize();
    let light = DVec3::new(0.0, 0.6, 0.8);
    assert!((optics.value(lobe, view, light) - 0.7 * 0.8 / PI).abs() < 1e-7);
    assert!((optics.value(lobe, view, -light) - 0.3 * 0.8 / PI).abs() < 1e-7);
    assert!((optics.value(lobe, -view, light) - 0.3 * 0.8 / PI).abs() < 1e-7);
}

#[test]
fn kajiya_kay_has_its_highlight_cone() {
    let optics = optics(Phase::KajiyaKay, 0.0, 0.5, 40.0);
    let lobe = fibre(DVec3::X);
    let at = |theta: f64, phi: f64| {
        DVec3::new(
            theta.cos(),
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
        )
    };
    let view = at(0.8, 0.3);
    // Brightest where θ_l = π − θ_v, equally at every azimuth.
    let peak = optics.value(lobe, view, at(PI - 0.8, 0.0));
    for phi in [1.0, 3.0, 5.0] {
        assert!((optics.value(lobe, view, at(PI - 0.8, phi)) - peak).abs() < 1e-12);
    }
    for off in [-0.2, 0.2] {
        assert!(optics.value(lobe, view, at(PI - 0.8 + off, 0.0)) < 0.9 * peak);
    }
    // Away from the cone only the diffuse part is left: (1 − s)·sin θ/π².
    let diffuse = optics.value(lobe, view, at(0.6, 2.0));
    assert!((diffuse - 0.5 * 0.6_f64.sin() / PI.powi(2)).abs() < 1e-6);
}

#[test]
fn main_axes_are_found() {
    let mut random = Random::new(3);
    for _ in 0..2_000 {
        let axis = random.direction();
        let (x, y) = orthonormal_basis(axis);
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        // Second largest eigenvalue up to 0.8 of the largest.
        let matrix = outer(axis) * random.within(0.1, 50.0);
        let size = matrix.col(0).length() + matrix.col(1).length() + matrix.col(2).length();
        let minor = random.within(0.0, 0.25) * size;
        let matrix = matrix + outer(x) * minor + outer(y) * (0.5 * minor);
        let found = main_axis(matrix);
        // 0.8²⁵⁶ is 10⁻²⁵; what is left is rounding.
        assert!(
            (found.dot(axis).abs() - 1.0).abs() < 1e-9,
            "{found} for {axis}"
        );
    }
    assert_eq!(main_axis(DMat3::ZERO), DVec3::Y);
}

#[test]
fn fibres_follow_the_frame_of_their_loop() {
    // All fibres along v in the reference loop: then along ∂X/∂v wherever they are hit.
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (5, 5);
    design.pile.phase = Phase::KajiyaKay;
    design.pile.tilt = 90.0;
    design.skeleton.visible = false;
    let mut scene = compile(&design).expect("a valid design");
    let mut volumes = Volumes::clone(&scene.volumes);
    for tangent in &mut volumes.tangents {
        *tangent = [0, 127, 0, 0, 0, 0, 0, 0];
    }
    scene.volumes = Section::new(volumes);
    let loops = all_loops(&scene);
    let tracer = tracer(scene.clone(), Method::Tracked);
    let (mut scratch, mut random, mut pcg) = (Scratch::default(), Random::new(4), Pcg::new(8, 8));
    let mut found = 0;
    for _ in 0..400 {
        let ray: Ray = random.ray_at(&scene);
        let Some(vertex) = tracer.collision(&ray, &mut pcg, &mut scratch) else {
            continue;
        };
        let Lobe::Fibre { tangent, .. } = vertex.lobe else {
            panic!("{vertex:?}")
        };
        // One of the loops at the point has this direction along v.
        let fits = loops.iter().any(|brute| {
            brute
                .frame
                .invert(vertex.position - brute.origin)
                .is_some_and(|[u, v, _]| {
                    let [_, along_v] = brute.frame.patch.tangents(u, v);
                    (along_v.normalize().dot(tangent).abs() - 1.0).abs() < 1e-9
                })
        });
        assert!(fits, "{vertex:?}");
        found += 1;
    }
    assert!(found > 100, "{found}");
}

#[test]
fn gradients_point_out_of_the_yarn() {
    // ρ = (20 + 3a + 5b + 4l)/255 in voxel (a, b, l) of 16³, all other voxels of the tower likewise: a ramp that
    // bilinear filtering reproduces and central differences measure exactly, away from the border.
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (5, 5);
    (
        design.pile.resolution,
        design.pile.layers,
        design.pile.variants,
    ) = (16, 16, 1);
    (design.pile.tilt, design.pile.top_width) = (90.0, 1.3);
    (design.pile.phase, design.pile.root_blend) = (Phase::GradientLambert, 0.0);
    design.pile.density = 1.0;
    design.skeleton.visible = false;
    let mut scene = compile(&design).expect("a valid design");
    let mut volumes = Volumes::clone(&scene.volumes);
    for (k, voxel) in volumes.voxels.iter_mut().enumerate() {
        let (a, b, l) = (k % 16, k / 16 % 16, k / 256);
        voxel[0] = (20 + 3 * a + 5 * b + 4 * l) as u8;
    }
    scene.volumes = Section::new(volumes);
    let loops = all_loops(&scene);
    let thickness = f64::from(scene.loops.thickness_mm);
    let tracer = tracer(scene.clone(), Method::Tracked);
    let (mut scratch, mut random, mut pcg) = (Scratch::default(), Random::new(6), Pcg::new(9, 9));
    let mut found = 0;
    for _ in 0..3_000 {
        let ray = random.ray_at(&scene);
        let Some(vertex) = tracer.collision(&ray, &mut pcg, &mut scratch) else {
            continue;
        };
        let Lobe::Gradient { normal, share, .. } = vertex.lobe else {
            panic!("{vertex:?}")
        };
        // ∇ρ of each loop at the point, by differences in space: half a micrometre to each side.
        let mut inner = 0;
        let fits = loops.iter().any(|brute| {
            let rho = |point: DVec3| {
                let [u, v, w] = brute.frame.invert(point - brute.origin)?;
                let inside = [u, v, w + 0.5].map(|x| x * 16.0 - 0.5);
                let is_inner = inside.iter().all(|x| (1.0..14.0).contains(x));
                is_inner
                    .then(|| (20.0 + 3.0 * inside[0] + 5.0 * inside[1] + 4.0 * inside[2]) / 255.0)
            };
            let step = 5e-4;
            let along = |axis: DVec3| {
                let (ahead, behind) =
                    (vertex.position + axis * step, vertex.position - axis * step);
                Some((rho(ahead)? - rho(behind)?) / (2.0 * step))
            };
            let (Some(x), Some(y), Some(z)) = (along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
            else {
                return false;
            };
            inner += 1;
            let gradient = DVec3::new(x, y, z);
            let x = gradient.length() * thickness;
            // The differences err by the square of the step over the loop's size.
            (gradient.normalize() + normal).length() < 1e-5
                && (share - x * x / (1.0 + x * x)).abs() < 1e-5
        });
        // Where a loop holds the point near its border the scattering loop may be that one.
        let holding = loops
            .iter()
            .filter(|brute| brute.frame.invert(vertex.position - brute.origin).is_some());
        if inner > 0 && holding.count() == inner {
            assert!(fits, "{vertex:?}");
            found += 1;
        }
    }
    assert!(found > 100, "{found}");
}

#[test]
fn a_density_without_slope_is_no_surface() {
    let optics = optics(Phase::GradientLambert, 0.0, 0.0, 1.0);
    let (view, light) = (DVec3::Z, DVec3::new(0.6, 0.0, -0.8));
    let value = |x: f64| optics.value(Lobe::gradient(-DVec3::Z * x, 1.0, 0), view, light);
    assert_eq!(value(0.0), 0.25 / PI);
    // Half surface where ρ changes by 1 over the thickness; nothing passes a surface without transmission.
    assert!((value(1.0) - 0.125 / PI).abs() < 1e-12);
    assert!(value(1e6) < 1e-12);
}

#[test]
fn each_phase_makes_its_own_lobe() {
    for &phase in ALL_PHASES {
        let mut design = Design::default();
        (design.sheet.warps, design.sheet.wefts) = (5, 5);
        design.pile.phase = phase;
        design.skeleton.visible = false;
        let scene = compile(&design).expect("a valid design");
        let mut random = Random::new(5);
        for method in [Method::Single, Method::Layered] {
            let tracer = tracer(scene.clone(), method);
            let mut scratch = Scratch::default();
            let vertex = (0..200)
                .find_map(|_| tracer.first_event(&random.ray_at(&scene), 0.9, &mut scratch))
                .expect("the towel is hit");
            match (phase, vertex.lobe) {
                (Phase::Isotropic, Lobe::Isotropic) => {}
                (Phase::FrameLambert, Lobe::Frame { normal, .. }) => {
                    assert!((normal.dot(vertex.normal).abs() - 1.0).abs() < 1e-12);
                }
                (Phase::KajiyaKay, Lobe::Fibre { tangent: axis, .. })
                | (Phase::GradientLambert, Lobe::Gradient { normal: axis, .. }) => {
                    assert!((axis.length() - 1.0).abs() < 1e-12);
                }
                other => panic!("{other:?}"),
            }
        }
    }
}
