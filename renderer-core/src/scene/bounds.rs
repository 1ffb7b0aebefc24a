//! Where the volume of a loop can be: parallelepipeds that hold it, and their exact height range over a cell. f64, mm,
//! relative to the loop's own cell.
//!
//! The volume is X = P(½,½) + u′b + v′c + u′v′A + w·h·n̂ with |u′|, |v′|, |w| ≤ ½, b and c the patch's edges in its
//! middle. Split into k × k parts, each with its own b and c, the term in A is at most |A|/(4k²): with A = αb + βc + γn̂
//! it fits into a parallelepiped with slightly longer edges (1 + α/(2k) …), which for α = β = γ = 0 is the volume itself.
//!
//! Over a cell, the highest point of a parallelepiped is a linear programme in three bounded unknowns. Its dual has
//! two unknowns (λ, μ), the slopes of a plane above the volume, and its optimum is one of ten vertices that do not
//! depend on the cell. So a cell costs ten multiply-adds, and the range is exact; any (λ, μ) gives a valid bound.

use glam::DVec3;

use super::LoopPatch;

/// Most parts along each side of a patch.
const MAX_PARTS: usize = 4;
/// How much of the thickness the bulge of a part may add before the patch is split.
const BULGE: f64 = 0.05;
/// Slopes above this are left out: rounding would eat the bound.
const STEEPEST: f64 = 1e4;

/// Smallest box that holds the volume: that of its eight corners, since every point is a mean of them.
pub(super) fn box_of(patch: &LoopPatch, base_width_mm: f32, thickness_mm: f32) -> [DVec3; 2] {
    let [p0, p1, p2, p3] = patch.corners(base_width_mm);
    let half = 0.5 * f64::from(thickness_mm) * patch.normal(base_width_mm).abs();
    [
        p0.min(p1).min(p2).min(p3) - half,
        p0.max(p1).max(p2).max(p3) + half,
    ]
}

/// A parallelepiped: all centre ± first edge ± second edge ± third edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) centre: DVec3,
    edges: [DVec3; 3],
}

impl Part {
    /// Largest distance from the centre along x, y and z.
    pub(super) fn half_size(&self) -> DVec3 {
        let [p, q, r] = self.edges.map(DVec3::abs);
        p + q + r
    }
}

/// What parts are to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Held {
    /// The patch, w = 0.
    Patch,
    /// The whole volume.
    Volume,
}

/// Parts that together hold the loop's volume or its patch.
pub(super) fn parts(
    patch: &LoopPatch,
    base_width_mm: f32,
    thickness_mm: f32,
    held: Held,
) -> impl Iterator<Item = Part> {
    let [b, c, a] = patch.coefficients(base_width_mm);
    let normal = patch.normal(base_width_mm);
    let [p0, p1, p2, p3] = patch.corners(base_width_mm);
    let middle = 0.25 * (p0 + p1 + p2 + p3);
    let half_thickness = 0.5 * f64::from(thickness_mm);
    let [alpha, beta, gamma] = decompose(a, b, c, normal);
    let bulge = gamma.abs() / (8.0 * half_thickness * BULGE);
    let skew = (alpha.abs() + beta.abs()) / (4.0 * BULGE);
    let count = (bulge.max(skew).sqrt().ceil() as usize).clamp(1, MAX_PARTS);
    let half = 0.5 / count as f64;
    (0..count * count).map(move |index| {
        let [u, v] = [index % count, index / count].map(|k| (2 * k + 1) as f64 * half - 0.5);
        let (b, c) = (b + v * a, c + u * a);
        let [alpha, beta, gamma] = decompose(a, b, c, normal).map(f64::abs);
        Part {
            centre: middle + u * b + v * c - u * v * a,
            edges: [
                b * (half + half * half * alpha),
                c * (half + half * half * beta),
                normal
                    * (half * half * gamma
                        + if held == Held::Volume {
                            half_thickness
                        } else {
                            0.0
                        }),
            ],
        }
    })
}

/// (α, β, γ) with a = αb + βc + γn̂; b and c are not parallel, and n̂ not in their plane.
fn decompose(a: DVec3, b: DVec3, c: DVec3, normal: DVec3) -> [f64; 3] {
    let volume = b.cross(c).dot(normal);
    let share = |numerator: f64| numerator / volume;
    let parts = [
        share(a.cross(c).dot(normal)),
        share(b.cross(a).dot(normal)),
        share(b.cross(c).dot(a)),
    ];
    if parts.iter().all(|part| part.is_finite()) {
        parts
    } else {
        // Only a patch that compile should have dropped comes here.
        [1.0; 3]
    }
}

/// A part's outline seen from above, prepared for cells of one size.
pub(super) struct Outline {
    centre: DVec3,
    /// Normals (x, y) and how far from the part's centre a cell's centre may be along them.
    normals: [[f64; 3]; 3],
}

impl Outline {
    /// Prepares a part for cells of half size `cell`.
    pub(super) fn new(part: &Part, cell: [f64; 2]) -> Self {
        let edges = part.edges;
        let normals = edges.map(|edge| {
            let normal = [-edge.y, edge.x];
            let along = |e: &DVec3| (normal[0] * e.x + normal[1] * e.y).abs();
            let cell_reach = cell[0] * normal[0].abs() + cell[1] * normal[1].abs();
            let reach = edges.iter().map(along).sum::<f64>() + cell_reach;
            [normal[0], normal[1], reach]
        });
        Self {
            centre: part.centre,
            normals,
        }
    }

    /// Whether the part may reach the cell whose centre is at `cell`, a cell that the part's box reaches.
    pub(super) fn reaches(&self, cell: [f64; 2]) -> bool {
        let (x, y) = (cell[0] - self.centre.x, cell[1] - self.centre.y);
        let apart = |[nx, ny, reach]: &[f64; 3]| (nx * x + ny * y).abs() > *reach;
        !self.normals.iter().any(apart)
    }
}

/// A part prepared for cells of one size.
pub(super) struct PartOverCells {
    centre: DVec3,
    outline: Outline,
    /// Over a cell at (x, y) from the centre, |z − λx − μy| ≤ K for each (λ, μ, K).
    lambda: [f64; PLANES],
    mu: [f64; PLANES],
    k: [f64; PLANES],
}

/// Vertices of the dual: no slope, slopes along x or y alone that follow one edge, slopes that follow two edges.
const PLANES: usize = 10;

impl PartOverCells {
    /// Prepares a part for cells of half size `cell`.
    pub(super) fn new(part: &Part, cell: [f64; 2]) -> Self {
        let edges = part.edges;
        let along_both = |p: DVec3, q: DVec3| {
            let inverse = 1.0 / (p.x * q.y - p.y * q.x);
            [
                (p.z * q.y - p.y * q.z) * inverse,
                (p.x * q.z - p.z * q.x) * inverse,
            ]
        };
        let [p, q, r] = edges;
        let slopes = [
            [0.0, 0.0],
            [p.z / p.x, 0.0],
            [q.z / q.x, 0.0],
            [r.z / r.x, 0.0],
            [0.0, p.z / p.y],
            [0.0, q.z / q.y],
            [0.0, r.z / r.y],
            along_both(p, q),
            along_both(q, r),
            along_both(r, p),
        ];
        let slopes = slopes.map(|[lambda, mu]| {
            // NaN fails the comparison, too. Level planes always bound.
            let usable = lambda.abs() < STEEPEST && mu.abs() < STEEPEST;
            if usable { [lambda, mu] } else { [0.0, 0.0] }
        });
        let off = |[lambda, mu]: [f64; 2]| {
            let over_edges = edges.map(|e| (e.z - lambda * e.x - mu * e.y).abs());
            let over_cell = lambda.abs() * cell[0] + mu.abs() * cell[1];
            over_edges.iter().sum::<f64>() + over_cell
        };
        Self {
            centre: part.centre,
            outline: Outline::new(part, cell),
            lambda: slopes.map(|[lambda, _]| lambda),
            mu: slopes.map(|[_, mu]| mu),
            k: slopes.map(off),
        }
    }

    /// Lowest and highest point of the part over the cell whose centre is at `cell`, a cell that the part's box
    /// reaches; `None` where the part does not.
    pub(super) fn z_range(&self, cell: [f64; 2]) -> Option<[f64; 2]> {
        if !self.outline.reaches(cell) {
            return None;
        }
        let (x, y) = (cell[0] - self.centre.x, cell[1] - self.centre.y);
        let [mut low, mut high] = [-self.k[0], self.k[0]];
        for plane in 1..PLANES {
            let middle = self.lambda[plane] * x + self.mu[plane] * y;
            let [floor, ceiling] = [middle - self.k[plane], middle + self.k[plane]];
            // Not f64::max and min: these are one instruction each, since nothing is NaN.
            low = if floor > low { floor } else { low };
            high = if ceiling < high { ceiling } else { high };
        }
        // At a touching corner rounding may cross the two.
        Some([low.min(high) + self.centre.z, high.max(low) + self.centre.z])
    }
}
