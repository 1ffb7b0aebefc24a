//! Directions from two random numbers in [0, 1).

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::orthonormal_basis;

/// Uniform on the unit sphere: z = 1 − 2u, φ = 2πv.
pub fn sphere(u: f64, v: f64) -> DVec3 {
    polar(1.0 - 2.0 * u, v)
}

/// Cosine-weighted on the hemisphere about the unit vector `normal`: density cos θ/π; r = √u, φ = 2πv.
pub fn cosine_hemisphere(normal: DVec3, u: f64, v: f64) -> DVec3 {
    about(normal, polar((1.0 - u).sqrt(), v))
}

/// About the unit vector `axis` with density (p + 1)/2π·cos^p θ: cos θ = (1 − u)^(1/(p+1)), φ = 2πv.
pub fn power_lobe(axis: DVec3, exponent: f64, u: f64, v: f64) -> DVec3 {
    about(axis, polar((1.0 - u).powf(1.0 / (exponent + 1.0)), v))
}

/// Uniform on the cap of half-angle `angle` about the unit vector `axis`: cos θ = 1 − u(1 − cos `angle`), φ = 2πv.
pub fn cone(axis: DVec3, angle: f64, u: f64, v: f64) -> DVec3 {
    // 1 − cos a = 2 sin²(a/2) keeps its digits for suns as small as ours.
    let versine = 2.0 * u * (0.5 * angle).sin().powi(2);
    let sine = (versine * (2.0 - versine)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * v).sin_cos();
    about(
        axis,
        DVec3::new(sine * cos_phi, sine * sin_phi, 1.0 - versine),
    )
}

/// The direction at height `cosine` and azimuth 2π·`v`.
fn polar(cosine: f64, v: f64) -> DVec3 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * v).sin_cos();
    DVec3::new(sine * cos_phi, sine * sin_phi, cosine)
}

/// `local`, given about +z, turned to be about `axis`.
fn about(axis: DVec3, local: DVec3) -> DVec3 {
    let (x, y) = orthonormal_basis(axis);
    (x * local.x + y * local.y + axis * local.z).normalize_or(axis)
}
