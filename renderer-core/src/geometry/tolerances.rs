//! Precisions that several renderers work with: each would find a little more or less with other numbers.

/// Smallest |w′|, 1/mm: keeps slabs finite for a ray that runs along the patch; u and v end it long before.
pub const FLATTEST: f64 = 1e-6;

/// Where a line of constant p, seen along the ray, is so much shorter than the patch (squared) that p needs another
/// step: in twisted patches, whose lines differ in direction, and in pointed ones. For f32.
pub const SHORT: f32 = 0.01;

/// Projected areas are positive, since compile makes every loop convex, and above this (mm²), since it drops the
/// degenerate; below, products of slopes would not be finite in f32.
pub const SMALLEST_AREA: f32 = 1e-9;

/// By how much loops are taken to be thicker where the part of a ray is looked for that may be in them: in f32 rounding
/// of the bent surfaces' coefficients is below a ten-thousandth of usual thicknesses.
pub const WIDENED: f32 = 1.001;

/// Steps over a strip of the paper's height field of ground yarns.
pub const PAPER_STEPS: u32 = 16;

/// Smallest step towards a tube, in its radii: a chord shorter than this may be missed.
pub const SMALLEST_STEP: f64 = 1.0 / 64.0;

/// Bounds of a tube are this much too wide: where they only just touch it, rounding would put their edge inside.
pub const ROOMY: f64 = 1.001;
