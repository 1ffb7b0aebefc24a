//! Ray against patch, frames, inversion, clipping and bases, against closed forms and brute force.

use glam::{DVec2, DVec3};
use renderer_core::geometry::{
    BilinearPatch, Interval, LoopFrame, Ray, clip_to_box, orthonormal_basis, quadratic_roots,
};
use renderer_core::sampling::Pcg;

/// Random numbers for one test.
pub struct Random(Pcg);

impl Random {
    pub fn new(seed: u32) -> Self {
        Self(Pcg::new(seed, 0))
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_float())
    }

    pub fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.within(-size, size)))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(1.0);
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// Four corners far from any symmetry: a square with every corner moved by up to `twist` of its side.
    pub fn patch(&mut self, twist: f64) -> BilinearPatch {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        BilinearPatch::from_corners(square.map(|(x, y)| DVec3::new(x, y, 0.0) + self.vector(twist)))
    }

    /// A convex loop frame: |α| + |β| at most 1.8, as compile guarantees.
    pub fn frame(&mut self) -> LoopFrame {
        loop {
            let frame = LoopFrame::new(self.patch(0.6), self.within(0.05, 0.8));
            let area = frame.patch.along_u.cross(frame.patch.along_v).length();
            let [alpha, beta] = frame.skew();
            if alpha.abs() + beta.abs() <= 1.8 && area > 0.05 {
                return frame;
            }
        }
    }
}

fn towards(origin: DVec3, target: DVec3) -> Ray {
    Ray {
        origin,
        direction: (target - origin).normalize(),
    }
}

#[test]
fn quadratic_roots_keep_their_digits() {
    // x² − 10⁸x + 1: the naive formula loses the small root's digits altogether.
    let mut roots = quadratic_roots(1.0, -1e8, 1.0).expect("two roots");
    roots.sort_by(f64::total_cmp);
    assert!((roots[0] * 1e8 - 1.0).abs() < 1e-15, "{roots:?}");
    assert!((roots[1] / 1e8 - 1.0).abs() < 1e-15, "{roots:?}");

    // Linear, double, constant and nothing at all.
    let linear = quadratic_roots(0.0, 2.0, -3.0).expect("one root");
    assert!(linear.contains(&1.5), "{linear:?}");
    assert!(linear.iter().any(|root| root.is_infinite()));
    assert_eq!(quadratic_roots(2.0, -4.0, 2.0), Some([1.0, 1.0]));
    assert_eq!(quadratic_roots(3.0, 0.0, 0.0), Some([0.0, 0.0]));
    assert_eq!(quadratic_roots(1.0, 0.0, 1.0), None);
    assert_eq!(quadratic_roots(0.0, 0.0, 1.0), None);
    assert_eq!(quadratic_roots(0.0, 0.0, 0.0), None);
    assert_eq!(quadratic_roots(f64::NAN, 1.0, 1.0), None);
}

#[test]
fn parallelogram_has_its_closed_form() {
    let patch = BilinearPatch {
        centre: DVec3::new(2.0, 1.0, 3.0),
        along_u: DVec3::new(2.0, 0.0, 0.0),
        along_v: DVec3::new(1.0, 4.0, 0.0),
        twist: DVec3::ZERO,
    };
    let ray = |x, y| Ray {
        origin: DVec3::new(x, y, 10.0),
        direction: -DVec3::Z,
    };
    // v from y, then u from x: (x − 2 − v′)/2.
    let roots = patch.roots(&ray(2.3, 2.0));
    let [root] = *roots.as_slice() else {
        panic!("{roots:?}")
    };
    assert!((root.t - 7.0).abs() < 1e-14);
    assert!((root.v - 0.75).abs() < 1e-15);
    assert!((root.u - 0.525).abs() < 1e-15);
    assert!(patch.roots(&ray(3.7, 2.0)).as_slice().is_empty());
    assert!(patch.roots(&ray(2.0, 3.1)).as_slice().is_empty());
}

#[test]
fn saddle_has_its_closed_form() {
    // z = k·x·y over the unit square about the origin; the ray x = y at height z meets it at x = ±√(z/k).
    let k = 2.0;
    let patch = BilinearPatch {
        centre: DVec3::ZERO,
        along_u: DVec3::X,
        along_v: DVec3::Y,
        twist: DVec3::Z * k,
    };
    for z in [0.02, 0.1, 0.3, 0.499] {
        let ray = Ray {
            origin: DVec3::new(-3.0, -3.0, z),
            direction: DVec3::new(1.0, 1.0, 0.0).normalize(),
        };
        let x = (z / k).sqrt();
        let roots = patch.roots(&ray);
        let [first, second] = *roots.as_slice() else {
            panic!("two crossings at height {z}, not {roots:?}")
        };
        assert!((first.u - (0.5 - x)).abs() < 1e-14 && (first.v - first.u).abs() < 1e-14);
        assert!((second.u - (0.5 + x)).abs() < 1e-14);
        assert!((first.t - (3.0 - x) * 2.0_f64.sqrt()).abs() < 1e-13);
    }
}

#[test]
fn rays_towards_a_patch_point_find_it() {
    let mut random = Random::new(1);
    for case in 0..20_000 {
        let patch = random.patch([0.0, 0.2, 1.0][case % 3]);
        let (u, v) = (random.within(0.0, 1.0), random.within(0.0, 1.0));
        let target = patch.at(u, v);
        let [along_u, along_v] = patch.tangents(u, v);
        let distance = [0.5, 10.0, 1e5][case / 3 % 3];
        // Every fourth ray grazes: at 10⁻⁴ to the tangent plane.
        let direction = if case % 4 == 3 {
            let normal = along_u.cross(along_v).normalize();
            (along_u * random.within(-1.0, 1.0) + along_v * random.within(-1.0, 1.0)).normalize()
                + normal * 1e-4
        } else {
            random.direction()
        }
        .normalize();
        let ray = towards(target - direction * distance, target);
        let sine = direction
            .dot(along_u.cross(along_v).normalize_or_zero())
            .abs();
        // Rounding of the far origin, magnified by the angle at which the ray meets the patch. The point itself may
        // be on a fold seen edge-on, where u changes as the square root of it.
        let rounding = 1e-15 * (distance + 2.0);
        if sine < 1e-6 || along_u.cross(along_v).length() < 0.02 {
            continue;
        }
        let tolerance = 50.0 * rounding / sine.powi(2) / along_u.cross(along_v).length();
        let margin = tolerance.max(1e-9);
        if !(margin..1.0 - margin).contains(&u) || !(margin..1.0 - margin).contains(&v) {
            continue;
        }
        let roots = patch.roots(&ray);
        let nearest = roots
            .as_slice()
            .iter()
            .map(|root| (root.t - distance).abs() + (root.u - u).abs() + (root.v - v).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(
            nearest < tolerance,
            "case {case}: off by {nearest:e}, allowed {tolerance:e}; {roots:?} for ({u}, {v}) at {distance}"
        );
        for root in roots.as_slice() {
            let gap = (patch.at(root.u, root.v) - ray.at(root.t)).length();
            assert!(
                gap < tolerance.max(1e-9),
                "case {case}: {gap:e} beside the patch"
            );
        }
        assert!(roots.as_slice().is_sorted_by_key(|root| root.t));
    }
}

/// Crossings of a ray with a patch, counted on 96² pairs of triangles seen along the ray; `None` if one passes so near
/// to an edge of the patch or a fold that triangles cannot tell.
fn crossings_of_triangles(patch: &BilinearPatch, ray: &Ray) -> Option<usize> {
    const STEPS: usize = 96;
    let (x, y) = orthonormal_basis(ray.direction);
    let seen = |i: usize, j: usize| {
        let point = patch.at(i as f64 / STEPS as f64, j as f64 / STEPS as f64) - ray.origin;
        DVec2::new(point.dot(x), point.dot(y))
    };
    let mut count = 0;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let corner = [
                seen(i, j),
                seen(i + 1, j),
                seen(i + 1, j + 1),
                seen(i, j + 1),
            ];
            for triangle in [[0, 1, 2], [0, 2, 3]] {
                let points = triangle.map(|k| corner[k]);
                let sides = [0, 1, 2].map(|k| points[k].perp_dot(points[(k + 1) % 3]));
                if sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0) {
                    count += 1;
                }
            }
        }
    }
    // Too close to call: the outline's edges pass the ray within a triangle's width, or the map folds near it.
    let outline = (0..STEPS).flat_map(|k| {
        [
            [seen(k, 0), seen(k + 1, 0)],
            [seen(k, STEPS), seen(k + 1, STEPS)],
            [seen(0, k), seen(0, k + 1)],
            [seen(STEPS, k), seen(STEPS, k + 1)],
        ]
    });
    let clearance = outline
        .map(|[a, b]| {
            let along = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            (a + (b - a) * along).length()
        })
        .fold(f64::INFINITY, f64::min);
    (clearance > 1e-3).then_some(count)
}

#[test]
fn number_of_crossings_agrees_with_triangles() {
    let mut random = Random::new(2);
    let mut seen = [0; 3];
    for _ in 0..4_000 {
        let patch = random.patch(1.0);
        let target = patch.centre + random.vector(0.7);
        let ray = towards(target - random.direction() * 5.0, target);
        let roots = patch.roots(&ray);
        // Two crossings closer than a triangle may be lost between triangles.
        if let [a, b] = roots.as_slice()
            && (a.u - b.u).hypot(a.v - b.v) < 0.05
        {
            continue;
        }
        let Some(count) = crossings_of_triangles(&patch, &ray) else {
            continue;
        };
        // A fold without real roots, but so near that flat triangles reach across it.
        let nearly_two = roots.as_slice().is_empty() && count == 2;
        if nearly_two {
            continue;
        }
        assert_eq!(roots.as_slice().len(), count, "{patch:?} {ray:?}");
        seen[count] += 1;
    }
    assert!(seen.iter().all(|&cases| cases > 30), "{seen:?}");
}

#[test]
fn degenerate_patches_and_rays_give_finite_roots() {
    let mut random = Random::new(3);
    let p = [(); 4].map(|()| random.vector(1.0));
    let line = [p[0], p[1], p[1] * 2.0 - p[0], p[0] * 3.0 - p[1] * 2.0];
    let patches = [
        [p[0], p[0], p[0], p[0]],
        line,
        [p[0], p[1], p[1], p[0]],
        [p[0], p[1], p[2], p[2]],
        [p[0], p[0], p[2], p[3]],
        [p[0], p[1], p[0] + p[2] - p[1], p[2]],
    ]
    .map(BilinearPatch::from_corners);
    for patch in patches {
        let [along_u, along_v] = patch.tangents(0.3, 0.3);
        let directions = [
            along_u,
            along_v,
            along_u + along_v,
            along_u.cross(along_v),
            DVec3::X,
            random.direction(),
        ];
        for direction in directions.map(|d| d.normalize_or(DVec3::Z)) {
            for origin in [
                patch.at(0.3, 0.3),
                patch.at(0.3, 0.3) - direction * 2.0,
                p[3],
            ] {
                for root in patch.roots(&Ray { origin, direction }).as_slice() {
                    assert!(root.t.is_finite() && root.u.is_finite() && root.v.is_finite());
                    let gap = patch.at(root.u, root.v) - (origin + direction * root.t);
                    assert!(gap.length() < 1e-6, "{patch:?} {root:?} off by {gap}");
                }
            }
        }
    }
}

#[test]
fn a_triangle_is_hit_as_one() {
    // Top edge of no width: P2 = P3.
    let patch = BilinearPatch::from_corners([
        DVec3::ZERO,
        DVec3::X,
        DVec3::new(0.5, 1.0, 0.0),
        DVec3::new(0.5, 1.0, 0.0),
    ]);
    for (x, y, inside) in [
        (0.5, 0.5, true),
        (0.5, 0.99, true),
        (0.2, 0.6, false),
        (0.5, 1.01, false),
    ] {
        let ray = Ray {
            origin: DVec3::new(x, y, 1.0),
            direction: -DVec3::Z,
        };
        assert_eq!(
            patch.roots(&ray).as_slice().len(),
            usize::from(inside),
            "({x}, {y})"
        );
    }
}

#[test]
fn corners_are_the_patch_ends() {
    let corners = [(); 4].map({
        let mut random = Random::new(4);
        move |()| random.vector(2.0)
    });
    let patch = BilinearPatch::from_corners(corners);
    for ((u, v), corner) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .into_iter()
        .zip(corners)
    {
        assert!((patch.at(u, v) - corner).length() < 1e-15);
    }
    // MODEL.md §4: P0 + uB + vC + uvA.
    let [p0, p1, p2, p3] = corners;
    let (u, v) = (0.3, 0.8);
    let expected = p0 + (p1 - p0) * u + (p3 - p0) * v + (p0 - p1 + p2 - p3) * (u * v);
    assert!((patch.at(u, v) - expected).length() < 1e-15);
}

#[test]
fn inversion_undoes_the_map() {
    let mut random = Random::new(5);
    for _ in 0..20_000 {
        let frame = random.frame();
        let inside = [
            random.within(0.0, 1.0),
            random.within(0.0, 1.0),
            random.within(-0.5, 0.5),
        ];
        let Some(found) = frame.invert(frame.at(inside)) else {
            // Only a point on the very border may be lost to rounding.
            let border = inside.map(|x| x - x.round()).iter().any(|d| d.abs() < 1e-9)
                || inside[2].abs() > 0.5 - 1e-9;
            assert!(border, "{inside:?} of {frame:?} was not found");
            continue;
        };
        // The map's smallest stretch in these frames is about 0.05 · 0.1; rounding 10⁻¹⁵ over it, with room.
        for (a, b) in inside.into_iter().zip(found) {
            assert!((a - b).abs() < 1e-10, "{inside:?} became {found:?}");
        }
    }
}

#[test]
fn points_outside_are_not_inverted() {
    let mut random = Random::new(6);
    for _ in 0..20_000 {
        let frame = random.frame();
        let point = frame.patch.centre + random.vector(1.5);
        if let Some(inside) = frame.invert(point) {
            // A point is inside exactly if it is the image of coordinates inside.
            assert!((frame.at(inside) - point).length() < 1e-10);
        } else {
            // Dense search: no image of the box comes near the point.
            let mut nearest = f64::INFINITY;
            for i in 0..=8 {
                for j in 0..=8 {
                    for k in 0..=4 {
                        let place = [
                            f64::from(i) / 8.0,
                            f64::from(j) / 8.0,
                            f64::from(k) / 4.0 - 0.5,
                        ];
                        let [a, b, c] = frame.jacobian(place[0], place[1]);
                        // A step of the search box moves its image by at most this; a much nearer image of the middle
                        // of a step means the point is inside.
                        let reach = (a.length() + b.length()) / 16.0 + c.length() / 8.0;
                        let gap = (frame.at(place) - point).length() / reach;
                        let inner =
                            (1..8).contains(&i) && (1..8).contains(&j) && (1..4).contains(&k);
                        nearest = nearest.min(if inner { gap } else { f64::INFINITY });
                    }
                }
            }
            assert!(nearest > 0.05, "{point} lies in {frame:?}");
        }
    }
}

#[test]
fn a_clipped_span_holds_every_point_inside() {
    let mut random = Random::new(10);
    let (mut inside, mut short) = (0, 0);
    for _ in 0..4_000 {
        let frame = random.frame();
        let ray = towards(random.vector(3.0), frame.patch.centre + random.vector(0.6));
        let whole = Interval::new(0.0, 8.0);
        let span = frame.clip(&ray, whole);
        short += usize::from(span.length() < 0.5 * whole.length());
        for step in 0..400 {
            let t = f64::from(step) * 0.02;
            if frame.invert(ray.at(t)).is_some() {
                // Rounding of the span's ends.
                assert!(
                    span.low - 1e-12 <= t && t <= span.high + 1e-12,
                    "{t} not in {span:?}"
                );
                inside += 1;
            }
        }
    }
    assert!(inside > 20_000 && short > 3_000, "{inside} {short}");
}

#[test]
fn slopes_are_the_derivatives_of_the_inverse() {
    let mut random = Random::new(7);
    for _ in 0..5_000 {
        let frame = random.frame();
        let (u, v) = (random.within(0.1, 0.9), random.within(0.1, 0.9));
        let direction = random.direction();
        let slopes = frame.slopes(u, v, direction);
        let [a, b, c] = frame.jacobian(u, v);
        let image = a * slopes.u + b * slopes.v + c * slopes.w;
        assert!(
            (image - direction).length() < 1e-9,
            "{image} is not {direction}"
        );
    }
}

#[test]
fn an_interval_is_clipped_to_a_box() {
    let mut random = Random::new(8);
    let (low, high) = (DVec3::new(-1.0, -2.0, 0.0), DVec3::new(1.0, 0.5, 0.7));
    let inside = |p: DVec3| p.cmpge(low).all() && p.cmple(high).all();
    let mut hits = 0;
    for case in 0..2_000 {
        let mut direction = random.direction();
        if case % 5 == 0 {
            direction = DVec3::AXES[case / 5 % 3];
        }
        let ray = Ray {
            origin: random.vector(2.5),
            direction,
        };
        let part = clip_to_box(&ray, Interval::new(0.0, f64::INFINITY), low, high);
        for step in 0..400 {
            let t = f64::from(step) * 0.02;
            let near_edge = (t - part.low).abs().min((t - part.high).abs()) < 1e-9;
            assert!(near_edge || inside(ray.at(t)) == (part.low <= t && t <= part.high));
        }
        hits += usize::from(!part.is_empty());
    }
    assert!((100..1900).contains(&hits), "{hits}");
}

#[test]
fn bases_are_orthonormal_and_right_handed() {
    let mut random = Random::new(9);
    let special = [
        DVec3::Z,
        -DVec3::Z,
        DVec3::X,
        DVec3::new(1e-9, 0.0, -1.0).normalize(),
    ];
    let axes = special
        .into_iter()
        .chain((0..1_000).map(|_| random.direction()));
    for axis in axes {
        let (x, y) = orthonormal_basis(axis);
        assert!((x.length() - 1.0).abs() < 1e-14 && (y.length() - 1.0).abs() < 1e-14);
        assert!((x.cross(y) - axis).length() < 1e-14, "{axis}");
    }
}
