//! The direction of a bundle of fibres, from the mean of their ttᵀ.

use glam::{DMat3, DVec3};

/// The unit eigenvector of the largest eigenvalue of a symmetric matrix that is (nearly) positive semidefinite; the y
/// axis, along the loop, for a matrix without a direction.
///
/// Repeated squaring: M² has the same eigenvectors and squared eigenvalues, so that after 8 squarings anything below
/// 0.9 of the largest has dropped below 10⁻¹¹ of it.
pub fn main_axis(matrix: DMat3) -> DVec3 {
    let mut power = matrix;
    for _ in 0..8 {
        let trace = power.x_axis.x + power.y_axis.y + power.z_axis.z;
        if trace <= 0.0 {
            return DVec3::Y;
        }
        power *= 1.0 / trace;
        power = power * power;
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = columns.into_iter().fold(DVec3::ZERO, |longest, column| {
        if column.length_squared() > longest.length_squared() {
            column
        } else {
            longest
        }
    });
    longest.normalize_or(DVec3::Y)
}
