//! Linear light by other primaries than those of sRGB, as matrices.
//!
//! A white stays white: where whites differ, cone responses are scaled as Bradford's matrix has them.

use glam::{DMat3, DVec3};
use moxcms::{Chromaticity, ColorPrimaries};

/// CIE chromaticities x, y of red, green, blue and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Primaries(pub(super) [[f64; 2]; 4]);

/// Those of sRGB, whose white is D65.
const SRGB: Primaries = Primaries([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]]);

/// The white whose X, Y and Z are equal.
const EQUAL_ENERGY: [f64; 2] = [1.0 / 3.0; 2];

/// From X, Y, Z to responses of cones (Bradford).
const CONES: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

impl Primaries {
    /// Whether they are those of sRGB, to the third decimal, as files round them.
    pub(super) fn is_srgb(&self) -> bool {
        let pairs = self.0.iter().flatten().zip(SRGB.0.iter().flatten());
        pairs.into_iter().all(|(a, b)| (a - b).abs() < 1.5e-3)
    }

    /// The white.
    pub(super) fn white(&self) -> [f64; 2] {
        self.0[3]
    }

    /// As the library for profiles has them.
    pub(super) fn of_library(&self) -> ColorPrimaries {
        let [red, green, blue] =
            [0, 1, 2].map(|k| Chromaticity::new(self.0[k][0] as f32, self.0[k][1] as f32));
        ColorPrimaries { red, green, blue }
    }

    /// From linear red, green, blue by these primaries to those of sRGB; `None` where they span no colours.
    pub(super) fn to_srgb(self) -> Option<DMat3> {
        let matrix = SRGB.to_xyz()?.inverse() * adapted(self.white()) * self.to_xyz()?;
        matrix.is_finite().then_some(matrix)
    }

    /// From red, green, blue to X, Y, Z, white having Y = 1; `None` where they span no colours.
    fn to_xyz(self) -> Option<DMat3> {
        let [r, g, b, white] = self.0.map(xyz);
        let columns = DMat3::from_cols(r, g, b);
        // Areas of triangles of real primaries are above 0.01; a hundred-thousandth is a line.
        let is_possible = columns.is_finite() && columns.determinant().abs() > 1e-5;
        let sums = is_possible.then(|| columns.inverse() * white)?;
        let matrix = columns * DMat3::from_diagonal(sums);
        (matrix.is_finite() && matrix.determinant().abs() > 1e-9).then_some(matrix)
    }
}

/// X, Y, Z of a chromaticity, with Y = 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// From X, Y, Z under a white to X, Y, Z under that of sRGB.
fn adapted(white: [f64; 2]) -> DMat3 {
    let scale = (CONES * xyz(SRGB.white())) / (CONES * xyz(white));
    CONES.inverse() * DMat3::from_diagonal(scale) * CONES
}

/// From X, Y, Z whose white is that of equal energy, as Radiance has it, to linear sRGB.
pub(super) fn srgb_of_xyz() -> Option<DMat3> {
    Some(SRGB.to_xyz()?.inverse() * adapted(EQUAL_ENERGY))
}
