//! Surfaces of the ground yarns: energy, sampling, reciprocity, and `poulin_fournier` against a relief built in detail.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use glam::DVec3;
use renderer_core::design::{Design, Method, SkeletonShading};
use renderer_core::optics::{Lobe, Optics, SurfaceOptics};
use renderer_core::reference::Scratch;
use renderer_core::scene::compile;

use super::cloth::{Random, direction_bins, integral, shares_of_samples, tracer};

const NORMAL: DVec3 = DVec3::Z;
const ALONG: DVec3 = DVec3::Y;

fn surface(specular: f64, exponent: f64, spacing: f64) -> SurfaceOptics {
    SurfaceOptics {
        specular,
        exponent,
        spacing: 2.0 * spacing,
    }
}

/// Parameters that stress the surfaces: no highlight, nothing else, broad, sharp; touching, near and lone fibres.
fn surfaces() -> Vec<SurfaceOptics> {
    let mut all = Vec::new();
    for (specular, exponent) in [(0.0, 1.0), (1.0, 1.0), (0.4, 12.0), (1.0, 500.0)] {
        for spacing in [1.0, 1.2, 4.0] {
            all.push(surface(specular, exponent, spacing));
        }
    }
    all
}

/// Views from the normal to grazing, along the fibres, across them and between.
fn views() -> Vec<DVec3> {
    let mut views = vec![DVec3::Z];
    for tilt in [0.6_f64, 1.3, 1.52] {
        for turn in [0.0_f64, 0.8, FRAC_PI_2, -2.0] {
            views.push(DVec3::new(
                tilt.sin() * turn.cos(),
                tilt.sin() * turn.sin(),
                tilt.cos(),
            ));
        }
    }
    views
}

#[test]
fn no_surface_gains_energy() {
    for surface in surfaces() {
        for view in views().into_iter().step_by(2) {
            let phong = integral(NORMAL, |light| surface.phong(NORMAL, view, light));
            let fibres = integral(NORMAL, |light| surface.fibres(NORMAL, ALONG, view, light));
            // Rings of π/540 integrate the sharpest highlight to 10⁻⁴; the eight points of a fibre's highlight are good
            // to some 10⁻⁴ where its peak lies on the wall and to a percent of its light where it is cut off (p = 1: a
            // kink).
            assert!(phong < 1.0 + 1e-3, "{surface:?} from {view}: {phong}");
            assert!(fibres < 1.0 + 1e-3, "{surface:?} from {view}: {fibres}");
            if surface.specular == 0.0 {
                assert!((phong - 1.0).abs() < 1e-3, "{phong}");
                // Neighbours keep some of the light for themselves.
                assert!(fibres > 0.5, "{surface:?} from {view}: {fibres}");
            }
        }
        // Along the normal the highlight loses nothing.
        let straight = integral(NORMAL, |light| surface.phong(NORMAL, NORMAL, light));
        assert!((straight - 1.0).abs() < 1e-3, "{surface:?}: {straight}");
    }
}

#[test]
fn surfaces_are_reciprocal() {
    let mut random = Random::new(3);
    for surface in surfaces() {
        for _ in 0..500 {
            let [mut view, mut light] = [random.direction(), random.direction()];
            (view.z, light.z) = (view.z.abs(), light.z.abs());
            let phong = surface.phong(NORMAL, view, light) * view.z;
            let other = surface.phong(NORMAL, light, view) * light.z;
            assert!((phong - other).abs() < 1e-9 * phong.max(1.0));
            let fibres = surface.fibres(NORMAL, ALONG, view, light) * view.z;
            let other = surface.fibres(NORMAL, ALONG, light, view) * light.z;
            assert!(
                (fibres - other).abs() < 1e-9 * fibres.max(1.0),
                "{surface:?}"
            );
        }
    }
}

#[test]
fn nothing_reaches_a_surface_from_behind() {
    for surface in surfaces() {
        let (view, below) = (
            DVec3::new(0.3, 0.2, 0.8).normalize(),
            DVec3::new(0.5, -0.4, -0.1),
        );
        assert_eq!(surface.phong(NORMAL, view, below.normalize()), 0.0);
        assert_eq!(surface.fibres(NORMAL, ALONG, view, below.normalize()), 0.0);
    }
}

fn samples_follow(
    what: &str,
    value: impl Fn(DVec3) -> f64,
    sample: impl Fn([f64; 2]) -> (DVec3, f64),
) {
    let expected = direction_bins(NORMAL, value);
    let (found, deviation) = shares_of_samples(NORMAL, sample);
    for (bin, (e, f)) in expected.iter().zip(&found).enumerate() {
        // Bins are integrated to some 10⁻³ of the whole where a highlight is sharp.
        let allowed = 5.0 * deviation[bin] + 4e-3;
        assert!(
            (e - f).abs() < allowed,
            "{what}: bin {bin} is {f}, not {e} ± {allowed}"
        );
    }
}

#[test]
fn surface_samples_follow_the_value() {
    for surface in surfaces() {
        for view in views().into_iter().step_by(3) {
            samples_follow(
                &format!("phong {surface:?} from {view}"),
                |light| surface.phong(NORMAL, view, light),
                |numbers| surface.sample_phong(NORMAL, view, numbers),
            );
            samples_follow(
                &format!("fibres {surface:?} from {view}"),
                |light| surface.fibres(NORMAL, ALONG, view, light),
                |numbers| surface.sample_fibres(NORMAL, ALONG, view, numbers),
            );
        }
    }
}

/// A relief of half-cylinders of radius 1 with their axes `spacing` apart, met by rays in detail: the mean over one
/// period of what each facet reflects to the view, over the period as the view sees it.
fn relief(surface: &SurfaceOptics, view: DVec3, light: DVec3, shade: bool) -> f64 {
    const STEPS: u32 = 40_000;
    let d = surface.spacing;
    // A ray across the fibres is free if it passes all other cylinders (and its own is behind it).
    let is_free = |x: f64, z: f64, normal: DVec3, direction: DVec3| {
        let length = direction.x.hypot(direction.z);
        let (dx, dz) = (direction.x / length, direction.z / length);
        normal.dot(direction) > 0.0
            && (-40..=40).all(|k| {
                let (to_x, to_z) = (f64::from(k) * d - x, -z);
                let ahead = to_x * dx + to_z * dz;
                let beside = to_x * dz - to_z * dx;
                // From a point of the cylinder itself, or behind.
                ahead <= 1e-9 || beside.abs() >= 1.0 - 1e-12
            })
    };
    let mut sum = 0.0;
    // The wall's length, then the floor's.
    for (length, on_wall) in [(PI, true), (d - 2.0, false)] {
        for step in 0..STEPS {
            let s = length * (f64::from(step) + 0.5) / f64::from(STEPS);
            let (x, z, normal) = if on_wall {
                let phi = s - FRAC_PI_2;
                (phi.sin(), phi.cos(), DVec3::new(phi.sin(), 0.0, phi.cos()))
            } else {
                (1.0 + s, 0.0, DVec3::Z)
            };
            if !is_free(x, z, normal, view) || (shade && !is_free(x, z, normal, light)) {
                continue;
            }
            let mirrored = (2.0 * normal.dot(view) * normal - view).dot(light).max(0.0);
            let highlight = 0.5 * (surface.exponent + 2.0) * mirrored.powf(surface.exponent);
            let reflects = FRAC_1_PI * (1.0 - surface.specular + surface.specular * highlight);
            let step = length / f64::from(STEPS);
            sum += step * reflects * normal.dot(view) * normal.dot(light).max(0.0);
        }
    }
    sum / (d * view.z)
}

#[test]
fn fibres_are_a_relief_of_cylinders() {
    let mut random = Random::new(5);
    let mut lit = 0;
    for (specular, exponent) in [(0.0, 1.0), (1.0, 4.0), (0.5, 60.0)] {
        for spacing in [1.0, 1.1, 1.7, 5.0] {
            let surface = surface(specular, exponent, spacing);
            for _ in 0..12 {
                let [mut view, mut light] = [random.direction(), random.direction()];
                (view.z, light.z) = (view.z.abs().max(0.05), light.z.abs().max(0.05));
                let (view, light) = (view.normalize(), light.normalize());
                let found = surface.fibres(NORMAL, ALONG, view, light);
                let expected = relief(&surface, view, light, true);
                lit += u32::from(expected > 0.05);
                // 40 000 steps are exact to 10⁻⁴; eight points of a broad highlight cut off by a neighbour to a
                // percent.
                assert!(
                    (found - expected).abs() < 2e-4 + 0.01 * specular * expected,
                    "{surface:?}, {view} and {light}: {found}, not {expected}"
                );
            }
        }
    }
    assert!(lit > 60, "{lit}");
}

#[test]
fn light_along_the_view_meets_no_shadow() {
    let mut random = Random::new(6);
    for spacing in [1.0, 1.4, 3.0] {
        let surface = surface(0.3, 10.0, spacing);
        for _ in 0..12 {
            let mut view = random.direction();
            view.z = view.z.abs().max(0.05);
            let view = view.normalize();
            let found = surface.fibres(NORMAL, ALONG, view, view);
            let expected = relief(&surface, view, view, false);
            assert!(
                (found - expected).abs() < 2e-4 + 3e-3 * expected,
                "{found}, not {expected}"
            );
        }
    }
}

#[test]
fn a_lone_cylinder_has_its_closed_form() {
    // Lambert's cylinder, seen and lit at right angles to its axis δ apart: ½((π − δ)·cos δ + sin δ)/π for light of
    // unit irradiance and unit radius. Seen and lit from different sides the floor at its axis cuts nothing off.
    let spacing = 50.0;
    let surface = surface(0.0, 1.0, spacing);
    let d = 2.0 * spacing;
    for (view, light) in [(0.5_f64, -0.9_f64), (0.0, 0.0), (-1.2, 0.1), (1.1, -1.3)] {
        let at = |theta: f64| DVec3::new(theta.sin(), 0.0, theta.cos());
        let total = surface.fibres(NORMAL, ALONG, at(view), at(light)) * d * view.cos();
        // What the floor adds, between the two shadows.
        let floor = (d - 1.0 / view.cos() - 1.0 / light.cos()) * view.cos() * light.cos() / PI;
        let delta = (view - light).abs();
        let expected = 0.5 * ((PI - delta) * delta.cos() + delta.sin()) / PI;
        assert!(
            (total - floor - expected).abs() < 1e-10,
            "{}, not {expected}",
            total - floor
        );
    }
}

#[test]
fn fibres_far_apart_leave_the_floor() {
    let mut random = Random::new(7);
    let surface = surface(0.4, 30.0, 1e5);
    for _ in 0..100 {
        let [mut view, mut light] = [random.direction(), random.direction()];
        (view.z, light.z) = (view.z.abs().max(0.05), light.z.abs().max(0.05));
        let (view, light) = (view.normalize(), light.normalize());
        let (found, flat) = (
            surface.fibres(NORMAL, ALONG, view, light),
            surface.phong(NORMAL, view, light),
        );
        // A fibre's share is its width and shadows, up to 40 of 2·10⁵, and its highlight may be some ten times
        // brighter.
        assert!(
            (found - flat).abs() < 3e-3 * flat.max(1.0),
            "{found}, not {flat}"
        );
    }
}

#[test]
fn each_shading_makes_its_own_lobe_along_the_yarn() {
    for &shading in SkeletonShading::ALL {
        let mut design = Design::default();
        (design.sheet.warps, design.sheet.wefts) = (5, 5);
        design.weave.pattern = renderer_core::design::Pattern::filled(1, 1, 1);
        design.skeleton.shading = shading;
        let scene = compile(&design).expect("a valid design");
        let optics = Optics::new(&scene.pile, &scene.skeleton);
        let tracer = tracer(scene.clone(), Method::Single);
        let (mut random, mut scratch) = (Random::new(5), Scratch::default());
        let mut found = 0;
        for _ in 0..200 {
            let ray = random.ray_at(&scene);
            let Some(vertex) = tracer.first_event(&ray, 0.5, &mut scratch) else {
                continue;
            };
            let at_border = vertex.normal.z == 0.0;
            match (shading, vertex.lobe) {
                (SkeletonShading::Lambert, Lobe::Surface(normal))
                | (SkeletonShading::Phong, Lobe::Phong(normal)) => {
                    assert_eq!(normal, vertex.normal);
                }
                (SkeletonShading::PoulinFournier, Lobe::Surface(normal)) if at_border => {
                    assert_eq!(normal, vertex.normal);
                }
                (SkeletonShading::PoulinFournier, Lobe::Fibres { normal, along }) => {
                    assert_eq!(normal, vertex.normal);
                    assert!((along.length() - 1.0).abs() < 1e-12);
                    assert!(normal.dot(along).abs() < 1e-12, "{normal} {along}");
                    // Along warp or weft, and up or down with it.
                    assert!(along.x == 0.0 || along.y == 0.0, "{along}");
                }
                other => panic!("{other:?}"),
            }
            let value = optics.value(vertex.lobe, -ray.direction, vertex.normal);
            assert!(value > 0.0, "{vertex:?}");
            found += 1;
        }
        assert!(found > 50, "{found}");
    }
}
