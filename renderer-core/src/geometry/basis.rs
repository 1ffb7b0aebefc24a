//! An orthonormal basis about a direction, without branches.
//!
//! Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.

use glam::DVec3;

/// Two unit vectors that make a right-handed orthonormal basis (first, second, `axis`); `axis` has length 1.
pub fn orthonormal_basis(axis: DVec3) -> (DVec3, DVec3) {
    let sign = 1.0_f64.copysign(axis.z);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    (
        DVec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        DVec3::new(b, sign + axis.y * axis.y * a, -axis.y),
    )
}
