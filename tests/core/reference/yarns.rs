//! The skeleton: hits against dense sampling of the surface the scene defines, shadows, gaps, borders.

use glam::DVec3;
use renderer_core::design::{Design, Method, Pattern, SkeletonHeight};
use renderer_core::geometry::{Interval, Ray, clip_to_box};
use renderer_core::reference::{Grid, Scratch, SkeletonHit, Yarns};
use renderer_core::scene::{Scene, compile};

use super::cloth::{Random, tracer};

/// A bare weave of 8 × 6 yarns with every neighbour relation of over and under.
fn weave(height: SkeletonHeight, radii: [f64; 2], crimp: f64) -> Scene {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (8, 6);
    let mut pattern = Pattern::filled(4, 3, 0);
    for (i, j) in [(0, 0), (1, 1), (1, 2), (3, 0), (3, 2)] {
        pattern.set(i, j, 1);
    }
    design.weave.pattern = pattern;
    design.skeleton.height = height;
    [design.skeleton.warp_radius, design.skeleton.weft_radius] = radii;
    design.skeleton.crimp = crimp;
    compile(&design).expect("a valid design")
}

/// The nearest hit, as a renderer finds it: cell by cell.
fn hit(scene: &Scene, ray: &Ray) -> Option<SkeletonHit> {
    let yarns = Yarns::new(&scene.sheet, &scene.skeleton);
    let grid = Grid::new(&scene.sheet, &scene.loops, Some(yarns.height()));
    let cells = grid
        .walk(ray)
        .flat_map(|block| grid.walk_cells(ray, &block).collect::<Vec<_>>());
    let mut hits = cells.map(|span| {
        let [x, y] = scene.sheet.cell_centre(span.index[0], span.index[1]);
        yarns.hit(&grid, ray, &span, DVec3::new(x, y, 0.0))
    });
    hits.find_map(|hit| hit)
}

/// Values of all yarns' implicit functions at a point, and whether the point is over or under the yarn's strip: for
/// `winding` the distance to each tube, for `paper` the height over each strip, which has no height beside it. From
/// MODEL.md §7 through the scene's profile of over and under.
fn fields(scene: &Scene, point: DVec3) -> Vec<(f64, bool)> {
    let (sheet, skeleton) = (&scene.sheet, &scene.skeleton);
    let cells = [f64::from(sheet.warps), f64::from(sheet.wefts)];
    let pitch = [sheet.pitch_x_mm, sheet.pitch_y_mm];
    let place = [0, 1].map(|k| point[k] / pitch[k] + 0.5 * cells[k]);
    let mut fields = Vec::new();
    for set in 0..2 {
        let radius = f64::from([skeleton.warp_radius_mm, skeleton.weft_radius_mm][set]);
        for yarn in 0..cells[set] as i64 {
            let s = match set {
                0 => skeleton.warp_profile(yarn, place[1]),
                _ => skeleton.weft_profile(yarn, place[0]),
            };
            let across = (place[set] - 0.5 - yarn as f64) * pitch[set];
            let crimp = f64::from(skeleton.crimp_mm);
            let value = match skeleton.height {
                SkeletonHeight::Winding => {
                    (across.powi(2) + (point.z - crimp * s).powi(2)).sqrt() - radius
                }
                SkeletonHeight::Paper => {
                    point.z - s * (radius.powi(2) - across.powi(2)).max(0.0).sqrt()
                }
            };
            fields.push((value, across.abs() < radius));
        }
    }
    fields
}

/// Step of the dense search, mm.
const STEP: f64 = 1e-3;
/// Distance from surfaces at which rays leave them, mm.
const OFFSET_MM: f64 = 1e-6;

/// Where any field has first changed its sign along the ray inside the sheet, by steps; and whether a second one
/// follows within `doubt`, so that a renderer may have missed both.
fn dense_hit(scene: &Scene, ray: &Ray, doubt: f64) -> Option<(f64, bool)> {
    let half = DVec3::new(
        0.5 * f64::from(scene.sheet.warps) * scene.sheet.pitch_x_mm,
        0.5 * f64::from(scene.sheet.wefts) * scene.sheet.pitch_y_mm,
        1.0,
    );
    let part = clip_to_box(ray, Interval::new(0.0, 1e3), -half, half);
    if part.is_empty() {
        return None;
    }
    let mut last = fields(scene, ray.at(part.low));
    if last.iter().any(|(f, _)| *f < 0.0) && scene.skeleton.height == SkeletonHeight::Winding {
        return Some((part.low, false));
    }
    let mut first: Option<(f64, usize)> = None;
    for k in 1..=(part.length() / STEP) as u32 {
        let t = part.low + f64::from(k) * STEP;
        if let Some((found, _)) = first
            && t > found + doubt
        {
            return Some((found, false));
        }
        let now = fields(scene, ray.at(t));
        for (yarn, pair) in last.iter().zip(&now).enumerate() {
            let ((a, in_before), (b, in_now)) = pair;
            if (in_before | in_now) && (*a > 0.0) != (*b > 0.0) {
                match first {
                    None => first = Some((t, yarn)),
                    Some((found, other)) if other == yarn => return Some((found, true)),
                    Some(_) => {}
                }
            }
        }
        last = now;
    }
    first.map(|(t, _)| (t, false))
}

fn random_ray(random: &mut Random, scene: &Scene) -> Ray {
    let target = DVec3::new(
        random.within(-0.5, 0.5) * f64::from(scene.sheet.warps) * scene.sheet.pitch_x_mm,
        random.within(-0.5, 0.5) * f64::from(scene.sheet.wefts) * scene.sheet.pitch_y_mm,
        random.within(-0.3, 0.3),
    );
    let mut direction = random.direction();
    if random.within(0.0, 1.0) < 0.1 {
        direction = DVec3::Z.copysign(direction);
    }
    Ray {
        origin: target - direction * 8.0,
        direction,
    }
}

/// Returns how many rays missed.
fn compare_with_dense(scene: &Scene, seed: u32, doubt: f64) -> u32 {
    let mut random = Random::new(seed);
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..600 {
        let ray = random_ray(&mut random, scene);
        let found = hit(scene, &ray);
        match dense_hit(scene, &ray, doubt) {
            // In and out again within a step: either answer is right.
            Some((_, true)) => {}
            Some((expected, false)) => {
                let Some(found) = found else {
                    panic!("nothing found at {expected}: {ray:?}")
                };
                // In the last step before the change, to the precision of the bisection.
                let before = expected - found.t;
                assert!(
                    (-1e-8..STEP + 1e-8).contains(&before),
                    "{found:?}, not {expected}: {ray:?}"
                );
                assert!(found.normal.dot(ray.direction) <= 0.0);
                assert!((found.normal.length() - 1.0).abs() < 1e-12);
                hits += 1;
            }
            None => {
                assert!(found.is_none(), "{found:?} out of nothing: {ray:?}");
                misses += 1;
            }
        }
    }
    assert!(hits > 200, "{hits}");
    misses
}

#[test]
fn winding_yarns_are_hit_where_they_are() {
    let misses = compare_with_dense(&weave(SkeletonHeight::Winding, [0.22, 0.15], 0.2), 1, 0.02);
    assert!(misses > 10, "{misses}");
    // Wider than their pitch: neighbours reach into each other's cells.
    let misses = compare_with_dense(&weave(SkeletonHeight::Winding, [0.5, 0.7], 0.3), 2, 0.02);
    assert_eq!(misses, 0, "no gaps are left");
    // Without crimp all yarns are straight.
    compare_with_dense(&weave(SkeletonHeight::Winding, [0.2, 0.2], 0.0), 3, 0.02);
}

#[test]
fn the_papers_height_field_is_hit_where_it_is() {
    // 16 steps over a strip up to 0.44 mm wide, met at up to 80°: two crossings closer than a step are missed.
    compare_with_dense(&weave(SkeletonHeight::Paper, [0.22, 0.2], 0.2), 4, 0.3);
}

#[test]
fn normals_are_gradients() {
    for height in [SkeletonHeight::Winding, SkeletonHeight::Paper] {
        let scene = weave(height, [0.22, 0.15], 0.2);
        let mut random = Random::new(5);
        let mut checked = 0;
        for _ in 0..400 {
            let ray = random_ray(&mut random, &scene);
            let Some(found) = hit(&scene, &ray) else {
                continue;
            };
            let point = ray.at(found.t);
            // Cut ends at the sheet's border face outwards.
            let [x, y] = scene.sheet.cell_centre(-1, -1).map(f64::abs);
            let half = [
                x - 0.5 * scene.sheet.pitch_x_mm,
                y - 0.5 * scene.sheet.pitch_y_mm,
            ];
            let on_border = |axis: usize| (point[axis].abs() - half[axis]).abs() < 1e-9;
            if let Some(axis) = (0..2).find(|&axis| on_border(axis)) {
                let outwards = found.normal[axis] * point[axis].signum();
                if height == SkeletonHeight::Winding && outwards == 1.0 {
                    continue;
                }
            }
            let here = fields(&scene, point);
            let (yarn, _) = here
                .iter()
                .enumerate()
                .filter(|(_, (_, inside))| *inside)
                .map(|(yarn, (f, _))| (yarn, f.abs()))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .expect("yarns");
            const SMALL: f64 = 1e-6;
            let slope = |axis: DVec3| {
                let [up, down] =
                    [1.0, -1.0].map(|s| fields(&scene, point + axis * (s * SMALL))[yarn].0);
                (up - down) / (2.0 * SMALL)
            };
            let [x, y, z] = DVec3::AXES.map(slope);
            let gradient = DVec3::new(x, y, z).normalize();
            // At the strip's edges the paper's field is infinitely steep.
            if gradient.z.abs() < 0.05 {
                continue;
            }
            assert!(
                (gradient.dot(found.normal).abs() - 1.0).abs() < 1e-4,
                "{gradient} {found:?}"
            );
            checked += 1;
        }
        assert!(checked > 100, "{checked}");
    }
}

#[test]
fn light_passes_only_through_gaps() {
    let scene = weave(SkeletonHeight::Winding, [0.2, 0.15], 0.2);
    let gap = scene.skeleton.gap_share(&scene.sheet);
    let tracer = tracer(scene.clone(), Method::Single);
    let mut scratch = Scratch::default();
    let (width, height) = (8.0 * scene.sheet.pitch_x_mm, 6.0 * scene.sheet.pitch_y_mm);
    const SIDE: u32 = 200;
    let mut open = 0.0;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE) - 0.5;
            let ray = Ray {
                origin: DVec3::new(at(i) * width, at(j) * height, -5.0),
                direction: DVec3::Z,
            };
            open += tracer.composited_visibility(&ray, &mut scratch);
        }
    }
    // 200 points over 8 gaps know their width to half a point at each side: 3 %.
    let share = open / f64::from(SIDE * SIDE);
    assert!((share / gap - 1.0).abs() < 0.05, "{share} {gap}");
}

#[test]
fn rays_leave_the_surface_they_start_on() {
    for height in [SkeletonHeight::Winding, SkeletonHeight::Paper] {
        let scene = weave(height, [0.22, 0.15], 0.2);
        let tracer = tracer(scene.clone(), Method::Single);
        let mut scratch = Scratch::default();
        let mut random = Random::new(6);
        let mut free = 0;
        let mut found = 0;
        for _ in 0..500 {
            let mut ray = random_ray(&mut random, &scene);
            let target = ray.at(8.0);
            ray = Ray {
                origin: target.with_z(5.0),
                direction: -DVec3::Z,
            };
            let Some(vertex) = tracer.first_event(&ray, 0.5, &mut scratch) else {
                continue;
            };
            found += 1;
            // Straight back to where the eye is: that way was free.
            let back = vertex.leave(DVec3::Z, OFFSET_MM);
            assert_eq!(
                tracer.composited_visibility(&back, &mut scratch),
                1.0,
                "{vertex:?}"
            );
            // Along the normal nearly always.
            let out = vertex.leave(vertex.normal, OFFSET_MM);
            free += usize::from(tracer.composited_visibility(&out, &mut scratch) == 1.0);
            // Into the cloth never, where yarns are solid.
            if height == SkeletonHeight::Winding {
                let inwards = vertex.leave(-vertex.normal, OFFSET_MM);
                assert_eq!(tracer.composited_visibility(&inwards, &mut scratch), 0.0);
            }
        }
        assert!(found > 300 && free * 10 > found * 6, "{free} of {found}");
    }
}
