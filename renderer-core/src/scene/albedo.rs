//! From the reflectance of finished cloth to the single-scatter albedo of its fibres (MODEL.md §6): many scatterings
//! darken and saturate, so the albedo must be higher than the colour that is wanted.
//!
//! Method: van de Hulst's approximation of the reflectance of a deep isotropic medium under uniform sky,
//! R = (1 − s)(1 − 0.139 s)/(1 + 1.17 s) with s = sqrt(1 − albedo), inverted exactly.

use crate::design::Pile;

/// What the conversion depends on besides the colour.
#[derive(Debug, Clone, PartialEq)]
pub struct AlbedoTable {
    max_albedo: f64,
}

impl AlbedoTable {
    /// The conversion for a pile.
    pub fn new(pile: &Pile) -> Self {
        Self {
            max_albedo: pile.max_albedo,
        }
    }
}

/// Single-scatter albedo of each channel whose cloth reflects `linear_rgb` (each in [0, 1]).
pub fn albedo_from_reflectance(linear_rgb: [f64; 3], table: &AlbedoTable) -> [f64; 3] {
    linear_rgb.map(|reflectance| {
        // 0.139 s² − (1.139 + 1.17 R) s + (1 − R) = 0; the smaller root lies in [0, 1].
        let half = 0.5 * (1.139 + 1.17 * reflectance);
        let s = (1.0 - reflectance) / (half + (half * half - 0.139 * (1.0 - reflectance)).sqrt());
        (1.0 - s * s).clamp(0.0, table.max_albedo)
    })
}
