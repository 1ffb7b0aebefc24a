//! The light of further scatterings, estimated from one shadow ray instead of traced (not in the paper): for looking
//! while designing, when the many scatterings that make white pile glow cost too much.
//!
//! Light that has scattered n times before it reaches a point has lost its direction, but less of it comes to where the
//! pile is deep than to where it is open. With l the direction of a light, V its visibility from the point (floored,
//! since light goes round what blocks it), and l_z⁺ its cosine with the sheet's normal on the point's side, the mean
//! radiance around a point in a cloth of albedo a, per mean radiance E/4π that the light would bring unhindered, is
//!
//!   4·l_z⁺ · Σ_j g_j · S_j(a) · (V^β_j + ℓ),    S_j(a) = Σ_{m=1}^{orders} (a·r_j)^m.
//!
//! The three modes decay as the orders of light that leave white terry under a uniform sky do ([`crate::scene`]'s table
//! of escapes, fitted within 3 %); the slower a mode, the more even its light: β falls. g and ℓ are such that pictures
//! of white terry cut off at the first scattering agree with traced ones: `hotel-white` at 10/mm within 1 % in the
//! mean, 9 % (near) and 6 % (middle distance) relRMSE. Other piles differ by V alone, and points reached by later
//! scatterings lie deeper than those that the camera sees, so that paths cut off there come out too dark, by an eighth
//! after the fourth.

use glam::DVec3;

/// g, r and β of each mode.
pub(crate) const MODES: [[f64; 3]; 3] = [
    [0.0606, 0.5, 0.6],
    [0.0288, 0.88, 0.35],
    [0.00628, 0.975, 0.25],
];

/// ℓ: the share of that light that depth does not matter to.
pub(crate) const LEVEL: f64 = 0.9;

/// Least visibility: of what is blocked wholly, too.
pub(crate) const FLOOR: f64 = 1e-4;

/// The exponent with which [`Visibility`] takes means: the middle mode's.
const MIDDLE: f64 = MODES[1][2];

/// How much of a light reaches the surroundings of a point: means over many rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visibility {
    /// Mean of the rays' visibility V: what direct light needs.
    pub direct: f64,
    /// Mean of V^β of the middle mode, with the floor: what multiple scattering brings is no mean of V.
    pub diffuse: f64,
}

impl Visibility {
    /// By what a single ray finds.
    pub fn by(visibility: f64) -> Self {
        Self {
            direct: visibility,
            diffuse: visibility.max(FLOOR).powf(MIDDLE),
        }
    }

    /// The visibility that brings as much light of the middle mode.
    pub fn for_multiple_scattering(&self) -> f64 {
        self.diffuse.powf(MIDDLE.recip())
    }
}

/// Mean radiance by multiple scattering, of red, green and blue, at a point whose surroundings have albedo `albedo`,
/// per mean radiance that an unhindered light brings; `up` is l_z⁺.
pub fn multiple_scattering(visibility: f64, up: f64, albedo: DVec3, orders: u32) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for [share, decay, evenness] in MODES {
        let reach = visibility.max(FLOOR).powf(evenness) + LEVEL;
        let series = (albedo * decay).to_array().map(|x| {
            // Below 1, since the slowest mode decays.
            x * (1.0 - x.powf(f64::from(orders))) / (1.0 - x)
        });
        sum += DVec3::from_array(series) * (share * reach);
    }
    sum * (4.0 * up)
}
