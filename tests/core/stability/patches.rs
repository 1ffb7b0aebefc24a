//! A million rays against patches: the shader's f32 solver against the f64 one, and that one against a search of its
//! own.
//!
//! What counts. ε = 2⁻²⁴ is the rounding of a direction's component. A case's *size* is its patch's longest side, t the
//! distance to the patch, and its *rounding* δ = 8·ε·(t + size): eight roundings of the longest vectors involved.
//!
//! - A case is *clear* ("away from edges") if the number of crossings stays the same when the ray is shifted by 2·δ, or
//!   turned about one of five points near the patch so that it moves by 2·δ over the patch's size, in any of eight
//!   directions, and the patch at once made larger or smaller by the tolerance of u and v. Then the shader must find
//!   that number.
//! - Where a crossing is found, u and v are right to max(10⁻⁴, 4·ε·(t + size)/width), width being the patch's smaller
//!   extent as seen along the ray: the smallest singular value of the projected (∂P/∂u, ∂P/∂v), the inverse of how far
//!   u and v move when the ray is shifted. Left out is only what is *folded*: where over that tolerance the patch's
//!   twist changes the width by a quarter of it, so that this linear estimate says nothing.
//! - t is right to 10⁻⁵ of the larger of t and the size where the width is at least a [`CONDITION`]th of the size: that
//!   leaves out rays that meet the patch at a small angle, and patches much longer than wide.
//! - Every crossing, clear or not, must lie on the ray to δ: what is found is the crossing of a ray moved by no more.
//!   Where rays run along the surface they may be moved along it by some more.
//!
//! `families` says how much of each family these words leave out.

use glam::{DVec2, Vec3};
use rayon::prelude::*;
use renderer_core::geometry::{BilinearPatch, LoopFrame, Ray, Root, orthonormal_basis};
use renderer_core::sampling::Pcg;

use super::families::{FAMILIES, Family, loop_edges};
use crate::support::patches::{Case, Random, THICKNESS, answered, asked, inverted};

/// 2⁻²⁴.
const EPSILON: f64 = 5.960_464_477_539_063e-8;
const CONDITION: f64 = 8.0;
const U_V_TOLERANCE: f64 = 1e-4;
const T_TOLERANCE: f64 = 1e-5;

fn size_of(case: &Case) -> f64 {
    let across = case.half_top - case.half_base;
    let sides = [
        2.0 * case.half_base,
        2.0 * case.half_top,
        case.axis + across,
        case.axis - across,
        case.axis,
    ];
    f64::from(sides.map(Vec3::length).into_iter().fold(0.0, f32::max))
}

fn distance_of(case: &Case) -> f64 {
    let ray = case.ray();
    (case.patch().centre - ray.origin).dot(ray.direction).abs()
}

fn rounding(case: &Case) -> f64 {
    8.0 * EPSILON * (distance_of(case) + size_of(case))
}

fn tolerance(case: &Case) -> f64 {
    U_V_TOLERANCE.max(4.0 * EPSILON * distance_of(case) / size_of(case))
}

/// The patch continued on all sides, or cut: u and v from −`by` to 1 + `by`.
fn widened(patch: &BilinearPatch, by: f64) -> BilinearPatch {
    let scale = 1.0 + 2.0 * by;
    BilinearPatch {
        centre: patch.centre,
        along_u: patch.along_u * scale,
        along_v: patch.along_v * scale,
        twist: patch.twist * (scale * scale),
    }
}

/// The number of crossings, if rounding cannot change it.
fn clear_count(case: &Case) -> Option<usize> {
    let (patch, ray) = (case.patch(), case.ray());
    let roots = patch.roots(&ray);
    let count = roots.as_slice().len();
    // Where the patch comes to a point, u there is uncertain by more.
    let uncertain = roots.as_slice().iter().map(|root| tolerance_at(case, root));
    let by = uncertain.fold(tolerance(case), f64::max).min(0.45);
    let [small, large] = [-by, by].map(|by| widened(&patch, by));
    let (shift, size) = (2.0 * rounding(case), size_of(case));
    let near = ray.at((patch.centre - ray.origin).dot(ray.direction));
    let (x, y) = orthonormal_basis(ray.direction);
    let same = |moved: &Ray| {
        [&small, &large]
            .iter()
            .all(|patch| patch.roots(moved).as_slice().len() == count)
    };
    let all = same(&ray)
        && (0..8).all(|k| {
            let angle = f64::from(k) * std::f64::consts::FRAC_PI_4;
            let aside = (x * angle.cos() + y * angle.sin()) * shift;
            let shifted = Ray {
                origin: ray.origin + aside,
                direction: ray.direction,
            };
            let direction = (ray.direction + aside / size).normalize();
            let turned = |about: f64| {
                let pivot = near + ray.direction * (about * size);
                same(&Ray {
                    origin: pivot - direction * size,
                    direction,
                })
            };
            same(&shifted) && [-1.0, -0.5, 0.0, 0.5, 1.0].into_iter().all(turned)
        });
    all.then_some(count)
}

/// The patch's smaller extent about a crossing, as seen along the ray, mm.
fn width_seen(case: &Case, root: &Root) -> f64 {
    let (x, y) = orthonormal_basis(case.ray().direction);
    let [a, b] = case
        .patch()
        .tangents(root.u, root.v)
        .map(|along| DVec2::new(along.dot(x), along.dot(y)));
    // Singular values of the 2 × 2 matrix (a, b): the sum of their squares and their product are known.
    let squares = a.length_squared() + b.length_squared();
    let product = a.perp_dot(b).abs();
    let difference = (squares * squares - 4.0 * product * product)
        .max(0.0)
        .sqrt();
    product / (0.5 * (squares + difference)).sqrt()
}

/// How far off u and v of a crossing may be.
fn tolerance_at(case: &Case, root: &Root) -> f64 {
    let rounding = 4.0 * EPSILON * (root.t.abs() + size_of(case));
    U_V_TOLERANCE.max(rounding / width_seen(case, root))
}

/// What one family showed.
#[derive(Debug, Default)]
struct Tally {
    cases: f64,
    unclear: f64,
    roots: f64,
    folded: f64,
    narrow: f64,
    twice: f64,
    /// Largest errors as shares of what is allowed.
    off_ray: f64,
    off_u_v: f64,
    off_t: f64,
    wrong: Vec<String>,
}

impl Tally {
    fn join(mut self, other: Self) -> Self {
        self.cases += other.cases;
        self.unclear += other.unclear;
        self.roots += other.roots;
        self.folded += other.folded;
        self.narrow += other.narrow;
        self.twice += other.twice;
        self.off_ray = self.off_ray.max(other.off_ray);
        self.off_u_v = self.off_u_v.max(other.off_u_v);
        self.off_t = self.off_t.max(other.off_t);
        self.wrong.extend(other.wrong);
        self.wrong.truncate(5);
        self
    }
}

/// Looks at one case.
fn judge(case: &Case, found: &[Root], family: &Family) -> Tally {
    let mut tally = Tally {
        cases: 1.0,
        ..Tally::default()
    };
    let (patch, ray) = (case.patch(), case.ray());
    for root in found {
        let off = (patch.at(root.u, root.v) - ray.at(root.t)).length();
        tally.off_ray = tally.off_ray.max(off / rounding(case));
    }
    if tally.off_ray > family.off_ray {
        tally.wrong.push(format!("off the ray: {case:?} {found:?}"));
    }
    let Some(count) = clear_count(case) else {
        tally.unclear = 1.0;
        return tally;
    };
    // One crossing that lies on a ray moved by no more than rounding is not invented, whatever the moves tried above
    // show.
    let moved = found.len() == 1 && count == 0 && tally.off_ray <= 1.0;
    if found.len() != count && !moved {
        tally
            .wrong
            .push(format!("{count} crossings: {case:?} {found:?}"));
        return tally;
    }
    tally.twice = f64::from(u8::from(count == 2));
    let expected = patch.roots(&ray);
    let pairs = expected.as_slice().iter().zip(found);
    let crossed = expected.as_slice().iter().rev().zip(found);
    let apart = |pairs: &mut dyn Iterator<Item = (&Root, &Root)>| -> f64 {
        pairs
            .map(|(a, b)| (a.u - b.u).hypot(a.v - b.v))
            .fold(0.0, f64::max)
    };
    // Two crossings at one distance may come in either order.
    let straight = apart(&mut pairs.clone()) <= apart(&mut crossed.clone());
    for k in 0..found.len().min(count) {
        let other = if straight { k } else { count - 1 - k };
        let (expected, found) = (&expected.as_slice()[other], &found[k]);
        tally.roots += 1.0;
        let (size, width) = (size_of(case), width_seen(case, expected));
        let tolerance = U_V_TOLERANCE.max(4.0 * EPSILON * (expected.t.abs() + size) / width);
        if tolerance * patch.twist.length() > 0.25 * width || width == 0.0 {
            tally.folded += 1.0;
            continue;
        }
        let u_v = (expected.u - found.u)
            .abs()
            .max((expected.v - found.v).abs())
            / tolerance;
        tally.off_u_v = tally.off_u_v.max(u_v);
        let mut t = 0.0;
        if width * CONDITION < size {
            tally.narrow += 1.0;
        } else {
            t = (expected.t - found.t).abs() / expected.t.abs().max(size) / T_TOLERANCE;
            tally.off_t = tally.off_t.max(t);
        }
        if u_v > 1.0 || t > 1.0 {
            tally
                .wrong
                .push(format!("{expected:?} is {found:?}: {case:?}"));
        }
    }
    tally
}

fn cases(family: &Family, seed: u32, count: usize) -> Vec<Case> {
    let mut random = Random(Pcg::new(seed, 0));
    (0..count).map(|_| (family.case)(&mut random)).collect()
}

fn compare_with_f64(count: usize) {
    let mut failures = Vec::new();
    let mut all = Tally::default();
    for (seed, family) in (100..).zip(&FAMILIES) {
        let cases = cases(family, seed, count);
        let answers = asked(&cases);
        let tally = cases
            .par_iter()
            .zip(&answers)
            .map(|(case, answer)| judge(case, &answered(answer), family))
            .reduce(Tally::default, Tally::join);
        let share = |count: f64| count / tally.roots.max(1.0);
        let unclear = tally.unclear / tally.cases;
        let (folded, narrow) = (share(tally.folded), share(tally.narrow));
        if !tally.wrong.is_empty()
            || unclear > family.unclear
            || folded > family.folded
            || narrow > family.narrow
        {
            failures.push(format!(
                "{}: {unclear} unclear, {folded} folded, {narrow} narrow, u and v off by {} of what is allowed, t by \
                 {}; {:#?}",
                family.name, tally.off_u_v, tally.off_t, tally.wrong
            ));
        }
        all = all.join(tally);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    // Enough was compared, two crossings of one ray too.
    assert!(all.roots > 0.3 * all.cases, "{all:?}");
    assert!(all.twice > 0.02 * all.cases, "{all:?}");
}

#[test]
fn rays_meet_patches_on_the_device_as_in_f64() {
    compare_with_f64(4_000);
}

#[test]
#[ignore = "long: about 20 s"]
fn a_million_rays_meet_patches_on_the_device_as_in_f64() {
    compare_with_f64(1_000_000 / FAMILIES.len());
}

#[test]
fn wrong_answers_would_be_noticed() {
    let family = &FAMILIES[0];
    let cases = cases(family, 1, 4000);
    let right = |case: &Case| case.patch().roots(&case.ray()).as_slice().to_vec();
    let mut tried = [0; 4];
    for case in &cases {
        let roots = right(case);
        assert!(judge(case, &roots, family).wrong.is_empty());
        let Some(count) = clear_count(case) else {
            continue;
        };
        let mut wrong = Vec::new();
        if count > 0 {
            // Lost; reported twice; off by three tolerances in u, along the patch.
            wrong.push((0, roots[1..].to_vec()));
            wrong.push((
                1,
                [roots.clone(), roots.clone()].concat()[..count + 1].to_vec(),
            ));
            let mut moved = roots.clone();
            moved[0].u += 3.0 * tolerance_at(case, &roots[0]);
            wrong.push((2, moved));
        } else {
            let centre = Root {
                t: distance_of(case),
                u: 0.5,
                v: 0.5,
            };
            wrong.push((3, vec![centre]));
        }
        for (kind, answer) in wrong {
            tried[kind] += 1;
            let seen = !judge(case, &answer, family).wrong.is_empty();
            assert!(seen, "{kind}: {case:?} {answer:?}");
        }
    }
    assert!(tried.iter().all(|&count| count > 500), "{tried:?}");
}

/// Crossings found by a search that shares nothing with the solver: seen along the ray, lines of constant v pass it on
/// one side or the other, by an area with one extremum in v. On both sides of that, v is found by bisection, and u on
/// the line.
fn searched(patch: &BilinearPatch, ray: &Ray, size: f64) -> Vec<[f64; 2]> {
    let (x, y) = orthonormal_basis(ray.direction);
    let near = ray.at((patch.centre - ray.origin).dot(ray.direction));
    let seen = |u: f64, v: f64| {
        let point = patch.at(u, v) - near;
        DVec2::new(point.dot(x), point.dot(y))
    };
    let side = |v: f64| seen(0.0, v).perp_dot(seen(1.0, v));
    let extremum = |sign: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..100 {
            let third = (high - low) / 3.0;
            if sign * side(low + third) < sign * side(high - third) {
                high -= third;
            } else {
                low += third;
            }
        }
        0.5 * (low + high)
    };
    let mut ends = [0.0, extremum(1.0), extremum(-1.0), 1.0];
    ends.sort_by(f64::total_cmp);
    let mut found = Vec::new();
    for pair in ends.windows(2) {
        let [mut low, mut high] = [pair[0], pair[1]];
        let low_side = side(low) > 0.0;
        if low_side == (side(high) > 0.0) {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if (side(middle) > 0.0) == low_side {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        let (a, b) = (seen(0.0, low), seen(1.0, low));
        let u = -a.dot(b - a) / (b - a).length_squared();
        // Where the line is seen from its end the side changes without a crossing.
        if (0.0..=1.0).contains(&u) && (a + (b - a) * u).length() < 1e-6 * size {
            found.push([u, low]);
        }
    }
    found
}

fn compare_with_search(count: usize) {
    for (seed, family) in (200..).zip(&FAMILIES) {
        let cases = cases(family, seed, count);
        let wrong = cases.par_iter().filter_map(|case| {
            let (patch, ray, size) = (case.patch(), case.ray(), size_of(case));
            let roots = patch.roots(&ray);
            let roots = roots.as_slice();
            for root in roots {
                let off = (patch.at(root.u, root.v) - ray.at(root.t)).length();
                // The same roundings in f64, and where the ray runs along the surface the square root of one.
                let allowed = 1e-15 * (distance_of(case) + size) * 100.0 * family.off_ray.powi(3);
                if off > allowed {
                    return Some(format!("{off:e} off the ray: {case:?} {root:?}"));
                }
            }
            clear_count(case)?;
            let found = searched(&patch, &ray, size);
            let same = found.len() == roots.len()
                && found.iter().all(|[u, v]| {
                    roots.iter().any(|root| {
                        let width = width_seen(case, root);
                        (root.u - u).hypot(root.v - v) < 1e-6 * (size / width).max(1.0)
                    })
                });
            (!same).then(|| format!("{roots:?}, but searched {found:?}: {case:?}"))
        });
        let wrong: Vec<String> = wrong.collect();
        assert!(
            wrong.is_empty(),
            "{}, {}: {:#?}",
            family.name,
            wrong.len(),
            &wrong[..wrong.len().min(4)]
        );
    }
}

#[test]
fn the_f64_solver_finds_what_a_search_finds() {
    compare_with_search(2_000);
}

#[test]
#[ignore = "long: about 10 s"]
fn the_f64_solver_finds_what_a_search_finds_a_million_times() {
    compare_with_search(1_000_000 / FAMILIES.len());
}

/// Points in loops as compile makes them, inverted on the device and in f64.
#[test]
fn points_are_inverted_on_the_device_as_in_f64() {
    let mut random = Random(Pcg::new(300, 0));
    let mut cases = Vec::new();
    while cases.len() < 60_000 {
        let edges = loop_edges(&mut random);
        let case = edges.through(Vec3::ZERO, Vec3::X, 0.0);
        let frame = LoopFrame::new(case.patch(), f64::from(THICKNESS));
        let [alpha, beta] = frame.skew();
        if alpha.abs() + beta.abs() > 1.8 {
            continue;
        }
        // In and around the loop, some on its faces.
        let place = |random: &mut Random| {
            let x = f64::from(random.within(-0.2, 1.2));
            [x, x.clamp(0.0, 1.0)][usize::from(random.within(0.0, 1.0) < 0.3)]
        };
        let [u, v, w] = [(); 3].map(|()| place(&mut random));
        let origin = frame.at([u, v, w - 0.5]).as_vec3();
        cases.push(Case { origin, ..case });
    }
    let mut inside = 0;
    for (case, answer) in cases.iter().zip(inverted(&cases)) {
        let frame = LoopFrame::new(case.patch(), f64::from(THICKNESS));
        let [u, v, w] = [0, 1, 2].map(|k| f64::from(answer[k]));
        let found = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v) && w.abs() <= 0.5;
        let point = case.origin.as_dvec3();
        // Where the shader puts the point, it is: to some roundings of the loop's size, magnified by how much the loop
        // is narrower at one end than in its middle (ten times at the limit of convexity).
        let rounding = 64.0 * EPSILON * (size_of(case) + point.length());
        if found {
            inside += 1;
            let off = (frame.at([u, v, w]) - point).length();
            assert!(off < rounding, "{off} {rounding} {case:?} {answer:?}");
        }
        // In or out as in f64, unless the point is within rounding of a face.
        let margins = frame.invert(point).map(|at| {
            let depth = [0, 1].map(|k| at[k].min(1.0 - at[k]));
            depth[0].min(depth[1]).min(0.5 - at[2].abs())
        });
        match margins {
            Some(margin) if margin > 1e-4 => assert!(found, "lost: {case:?} {answer:?}"),
            Some(_) => {}
            None if found => {
                let depth = [u.min(1.0 - u), v.min(1.0 - v), 0.5 - w.abs()];
                let margin = depth.into_iter().fold(1.0, f64::min);
                assert!(margin < 1e-4, "invented: {case:?} {answer:?}");
            }
            None => {}
        }
    }
    assert!((10_000..50_000).contains(&inside), "{inside}");
}
