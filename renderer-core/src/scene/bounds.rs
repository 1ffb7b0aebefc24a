//! Where the volume of a loop can be: parallelepipeds that hold it, and their height range over a cell. mm, relative to
//! the loop's own cell.
//!
//! The volume is X = P(½,½) + u′b + v′c + u′v′A + w·h·n̂ with |u′|, |v′|, |w| ≤ ½, b and c the patch's edges in its
//! middle. Split into k × l parts, each with its own b and c, the term in A is at most |A|/(4kl): with A = αb + βc +
//! γn̂ it fits into a parallelepiped with slightly longer edges (1 + α/(2l) …), which for α = β = γ = 0 is the volume
//! itself.
//!
//! Over a cell, the highest point of a parallelepiped is a linear programme in three bounded unknowns. Its dual has two
//! unknowns (λ, μ), the slopes of a plane above the volume, and its optimum is one of ten vertices that do not depend
//! on the cell. Any (λ, μ) gives a valid bound. So a cell costs eight multiply-adds: the two vertices that follow the
//! thickness alone are left out, for a range that is half a per cent wider on the default pile. And they are f32, four
//! at a time, with what rounding may do added to each bound.

use glam::{DVec3, Vec3};

use super::LoopPatch;

/// How much of the thickness the bulge of a part may add before the patch is split, where parts are not too many.
const BULGE: f64 = 0.05;
/// Numbers of parts along u and v, the fewest first.
const SPLITS: [[u32; 2]; 9] = [
    [1, 1],
    [1, 2],
    [1, 3],
    [2, 2],
    [2, 3],
    [2, 4],
    [3, 3],
    [3, 4],
    [4, 4],
];
/// Slopes above this are left out: rounding would eat the bound.
const STEEPEST: f32 = 64.0;
/// What f32 rounding may do to the bound of a plane without slopes, as a share of the largest number in it. With u =
/// 2⁻²⁴: four u for each edge and six for their sum and the cell's part, ten for the plane over a cell; together
/// 1.2·10⁻⁶.
const ROUNDING: f64 = 2e-6;

/// Smallest box that holds the volume: that of its eight corners, since every point is a mean of them.
pub(super) fn box_of(patch: &LoopPatch, base_width_mm: f32, thickness_mm: f32) -> [DVec3; 2] {
    Solid::new(patch, base_width_mm, thickness_mm).bounds()
}

/// The volume of a loop.
pub(super) struct Solid {
    corners: [DVec3; 4],
    middle: DVec3,
    b: DVec3,
    c: DVec3,
    a: DVec3,
    normal: DVec3,
    half_thickness: f64,
    /// α, β and γ in the middle of the patch.
    decomposed: [f64; 3],
}

impl Solid {
    /// The volume around a patch.
    #[inline(always)]
    pub(super) fn new(patch: &LoopPatch, base_width_mm: f32, thickness_mm: f32) -> Self {
        let corners = patch.corners(base_width_mm);
        let [p0, p1, p2, p3] = corners;
        let [b, c, a] = patch.coefficients(base_width_mm);
        let area = b.cross(c);
        let inverse = 1.0 / area.length_squared();
        let (normal, decomposed) = if inverse.is_finite() {
            let normal = area * inverse.sqrt();
            let alpha = a.cross(c).dot(area) * inverse;
            let beta = b.cross(a).dot(area) * inverse;
            (normal, [alpha, beta, normal.dot(a)])
        } else {
            // Only a patch that compile should have dropped comes here.
            (DVec3::X, [1.0; 3])
        };
        Self {
            corners,
            middle: 0.25 * (p0 + p1 + p2 + p3),
            b,
            c,
            a,
            normal,
            half_thickness: 0.5 * f64::from(thickness_mm),
            decomposed,
        }
    }

    /// Corners of the smallest box that holds it.
    #[inline(always)]
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let [p0, p1, p2, p3] = self.corners;
        let half = self.half_thickness * self.normal.abs();
        [
            p0.min(p1).min(p2).min(p3) - half,
            p0.max(p1).max(p2).max(p3) + half,
        ]
    }

    /// Parts that together hold it.
    #[inline(always)]
    pub(super) fn parts(&self) -> impl Iterator<Item = Part> {
        let [alpha, beta, gamma] = self.decomposed;
        let bulge = gamma.abs() / (8.0 * self.half_thickness * BULGE);
        let skew = (alpha.abs() + beta.abs()) / (4.0 * BULGE);
        let wanted = bulge.max(skew);
        let enough = |[k, l]: &[u32; 2]| f64::from(k * l) >= wanted;
        let split = SPLITS.into_iter().find(enough);
        let [across, along] = split.unwrap_or(SPLITS[SPLITS.len() - 1]);
        let (half_u, half_v) = (0.5 / f64::from(across), 0.5 / f64::from(along));
        let places = (0..along).flat_map(move |y| (0..across).map(move |x| (x, y)));
        places.map(move |(x, y)| {
            let u = f64::from(2 * x + 1) * half_u - 0.5;
            let v = f64::from(2 * y + 1) * half_v - 0.5;
            let (b, c) = (self.b + v * self.a, self.c + u * self.a);
            // Along the part's own b and c, and n̂, A has the coefficients (α, β, γ)/(1 + vα + uβ); the divisor is the
            // part's area over the middle's, above 0 as long as the patch is convex.
            let area = 1.0 + v * alpha + u * beta;
            let bulge = half_u * half_v / area.abs();
            Part {
                centre: self.middle + u * b + v * c - u * v * self.a,
                edges: [
                    b * (half_u + bulge * alpha.abs()),
                    c * (half_v + bulge * beta.abs()),
                    self.normal * (self.half_thickness + bulge * gamma.abs()),
                ],
            }
        })
    }

    /// Its patch seen from above, prepared for cells of half size `cell`.
    #[inline(always)]
    pub(super) fn footprint(&self, cell: [f64; 2]) -> Footprint {
        Footprint::new(self, cell)
    }
}

/// A parallelepiped: all centre ± first edge ± second edge ± third edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) centre: DVec3,
    edges: [DVec3; 3],
}

impl Part {
    /// Largest distance from the centre along x, y and z.
    #[inline(always)]
    pub(super) fn half_size(&self) -> DVec3 {
        let [p, q, r] = self.edges.map(DVec3::abs);
        p + q + r
    }
}

/// `max` and `min` that are one instruction each, for numbers that are not NaN.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// What rounding may do over cells of half size `cell` to something that reaches as far as `half` from its centre, mm.
#[inline(always)]
fn rounding(half: DVec3, cell: [f64; 2]) -> f32 {
    let largest = half.max_element() + cell[0].max(cell[1]);
    (2.0 * ROUNDING * largest) as f32
}

/// A part prepared for cells of one size.
pub(super) struct PartOverCells {
    /// Normals of the outline seen from above, and how far from the part's centre a cell's centre may be along them.
    outline: [[f32; 3]; 3],
    /// Over a cell at (x, y) from the centre, |z − λx − μy| ≤ K for each (λ, μ, K).
    lambda: [f32; PLANES],
    mu: [f32; PLANES],
    k: [f32; PLANES],
}

/// Vertices of the dual: no slope, slopes along x or y alone that follow an edge of the patch, slopes that follow two
/// edges.
const PLANES: usize = 8;

impl PartOverCells {
    /// Prepares a part for cells of half size `cell`.
    #[inline(always)]
    pub(super) fn new(part: &Part, cell: [f64; 2]) -> Self {
        let rounding = rounding(part.half_size(), cell);
        let [p, q, r] = part.edges.map(DVec3::as_vec3);
        let cell = cell.map(|half| half as f32);
        // Slopes as fractions, all with one division.
        let lambda = |p: Vec3, q: Vec3| p.z * q.y - p.y * q.z;
        let mu = |p: Vec3, q: Vec3| p.x * q.z - p.z * q.x;
        let below = |p: Vec3, q: Vec3| p.x * q.y - p.y * q.x;
        let (pq, qr, rp) = ((p, q), (q, r), (r, p));
        let pair = |f: &dyn Fn(Vec3, Vec3) -> f32| [pq, qr, rp].map(|(a, b)| f(a, b));
        let ([l0, l1, l2], [m0, m1, m2], [d0, d1, d2]) = (pair(&lambda), pair(&mu), pair(&below));
        let lambda = [0.0, p.z, q.z, 0.0, 0.0, l0, l1, l2];
        let mu = [0.0, 0.0, 0.0, p.z, q.z, m0, m1, m2];
        let below = [1.0, p.x, q.x, p.y, q.y, d0, d1, d2];
        let slope = |plane: usize| {
            let inverse = 1.0 / below[plane];
            let [lambda, mu]: [f32; 2] = [lambda[plane] * inverse, mu[plane] * inverse];
            // NaN fails the comparison, too. Level planes always bound.
            let usable = (lambda.abs() < STEEPEST) & (mu.abs() < STEEPEST);
            if usable { [lambda, mu] } else { [0.0, 0.0] }
        };
        let slopes: [[f32; 2]; PLANES] = std::array::from_fn(slope);
        let lambda = slopes.map(|[lambda, _]| lambda);
        let mu = slopes.map(|[_, mu]| mu);
        let k = std::array::from_fn(|plane| {
            let (lambda, mu) = (lambda[plane], mu[plane]);
            let over = |edge: Vec3| (edge.z - lambda * edge.x - mu * edge.y).abs();
            let (lambda, mu) = (lambda.abs(), mu.abs());
            let over_cell = lambda * cell[0] + mu * cell[1];
            over(p) + over(q) + over(r) + over_cell + (1.0 + lambda + mu) * rounding
        });
        let outline = [p, q, r].map(|edge| {
            let normal = [-edge.y, edge.x];
            let along = |e: Vec3| (normal[0] * e.x + normal[1] * e.y).abs();
            let over_cell = [0, 1].map(|axis| (cell[axis] + rounding) * normal[axis].abs());
            let reach = along(p) + along(q) + along(r) + over_cell[0] + over_cell[1];
            [normal[0], normal[1], reach]
        });
        Self {
            outline,
            lambda,
            mu,
            k,
        }
    }

    /// Lowest and highest point of the part, from its centre, over the cell whose centre is at (x, y) from it, a cell
    /// that the part's box reaches; `None` where the part does not.
    #[inline(always)]
    pub(super) fn z_range(&self, [x, y]: [f32; 2]) -> Option<[f32; 2]> {
        let apart = self
            .outline
            .map(|[nx, ny, reach]| (nx * x + ny * y).abs() > reach);
        if apart[0] | apart[1] | apart[2] {
            return None;
        }
        let mut lows = [0.0; PLANES];
        let mut highs = [0.0; PLANES];
        for plane in 0..PLANES {
            let middle = self.lambda[plane] * x + self.mu[plane] * y;
            lows[plane] = middle - self.k[plane];
            highs[plane] = middle + self.k[plane];
        }
        // Halves with halves, so that several numbers are compared at once.
        let mut half = PLANES / 2;
        while half > 0 {
            for plane in 0..half {
                lows[plane] = larger(lows[plane], lows[plane + half]);
                highs[plane] = smaller(highs[plane], highs[plane + half]);
            }
            half /= 2;
        }
        let (low, high) = (lows[0], highs[0]);
        // At a touching corner rounding may cross the two.
        Some([smaller(low, high), larger(low, high)])
    }
}

/// A patch seen from above, prepared for cells of one size. Every point of the patch is a mean of its corners, so it is
/// within their hull, which is bounded by lines between two of them.
pub(super) struct Footprint {
    pub(super) centre: DVec3,
    pub(super) half_size: DVec3,
    /// Across each line: its normal, and where along it a cell's centre may be from the patch's middle.
    normal_x: [f32; LINES],
    normal_y: [f32; LINES],
    low: [f32; LINES],
    high: [f32; LINES],
}

/// Pairs of corners; two come twice, so that fours come out even.
const PAIRS: [[usize; 2]; LINES] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [0, 2],
    [1, 3],
    [0, 1],
    [1, 2],
];
const LINES: usize = 8;

impl Footprint {
    #[inline(always)]
    fn new(solid: &Solid, cell: [f64; 2]) -> Self {
        let from_middle = solid.corners.map(|corner| corner - solid.middle);
        let half_size = from_middle
            .iter()
            .fold(DVec3::ZERO, |half, corner| half.max(corner.abs()));
        let rounding = rounding(half_size, cell);
        let cell = cell.map(|half| half as f32 + rounding);
        let corners = from_middle.map(DVec3::as_vec3);
        let mut new = Self {
            centre: solid.middle,
            half_size,
            normal_x: [0.0; LINES],
            normal_y: [0.0; LINES],
            low: [0.0; LINES],
            high: [0.0; LINES],
        };
        for (line, [from, to]) in PAIRS.into_iter().enumerate() {
            let along = corners[to] - corners[from];
            let (x, y) = (-along.y, along.x);
            let [d0, d1, d2, d3] = corners.map(|corner| x * corner.x + y * corner.y);
            let reach = cell[0] * x.abs() + cell[1] * y.abs();
            (new.normal_x[line], new.normal_y[line]) = (x, y);
            new.low[line] = smaller(smaller(d0, d1), smaller(d2, d3)) - reach;
            new.high[line] = larger(larger(d0, d1), larger(d2, d3)) + reach;
        }
        new
    }

    /// Whether the patch may reach the cell whose centre is at (x, y) from the patch's middle.
    #[inline(always)]
    pub(super) fn reaches(&self, [x, y]: [f32; 2]) -> bool {
        let apart: [bool; LINES] = std::array::from_fn(|line| {
            let place = self.normal_x[line] * x + self.normal_y[line] * y;
            (place < self.low[line]) | (place > self.high[line])
        });
        !apart.into_iter().fold(false, |any, apart| any | apart)
    }
}
