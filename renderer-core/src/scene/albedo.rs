//! From the reflectance of finished cloth to the single-scatter albedo of its fibres (MODEL.md §6): light scatters many
//! times in the pile, which darkens and saturates, so the albedo must be higher than the colour that is wanted.
//!
//! With isotropic scattering R(ω) = Σ_n c_n·ωⁿ exactly, c_n the share of sky light that leaves the pile after n
//! scatterings when nothing is absorbed; a path of at most b bounces keeps the first b terms. [`ESCAPE`] was measured on
//! the default bath terry. Where the bounces do not suffice, colours are scaled to what the brightest yarn reaches, so
//! that a picture of few bounces is darker but has the chart's hues.

/// c_n for n = 1, 2, …: share of a uniform sky's light, seen at 60° elevation, that leaves white terry after exactly n
/// scatterings.
const ESCAPE: [f64; 64] = [
    0.16760, 0.10399, 0.07277, 0.05459, 0.04252, 0.03475, 0.02881, 0.02464, 0.02126, 0.01859,
    0.01653, 0.01486, 0.01333, 0.01210, 0.01103, 0.01014, 0.00925, 0.00865, 0.00794, 0.00745,
    0.00701, 0.00661, 0.00604, 0.00577, 0.00538, 0.00520, 0.00483, 0.00464, 0.00450, 0.00422,
    0.00398, 0.00385, 0.00371, 0.00344, 0.00339, 0.00320, 0.00309, 0.00304, 0.00287, 0.00272,
    0.00270, 0.00265, 0.00253, 0.00240, 0.00240, 0.00230, 0.00216, 0.00214, 0.00209, 0.00199,
    0.00196, 0.00197, 0.00185, 0.00181, 0.00175, 0.00176, 0.00169, 0.00165, 0.00165, 0.00160,
    0.00151, 0.00150, 0.00147, 0.00141,
];

/// Entries of the inverse table; neighbouring entries differ by at most 0.005 in albedo, interpolation by far less.
const ENTRIES: usize = 1024;

/// Albedo for each reflectance, for one number of bounces.
#[derive(Debug, Clone, PartialEq)]
pub struct AlbedoTable {
    /// Albedo at reflectance k/(ENTRIES − 1).
    albedos: Vec<f64>,
    max_albedo: f64,
}

impl AlbedoTable {
    /// The conversion for paths of at most `bounces` scatterings in yarn of at most `max_albedo`.
    pub fn new(bounces: u32, max_albedo: f64) -> Self {
        // What the bounces lack is taken off every colour alike.
        let full = reflectance(ESCAPE.len(), max_albedo);
        let scale = if full > 0.0 {
            reflectance(bounces as usize, max_albedo) / full
        } else {
            0.0
        };
        let albedos = (0..ENTRIES)
            .map(|k| {
                inverse(scale * k as f64 / (ENTRIES - 1) as f64, bounces as usize).min(max_albedo)
            })
            .collect();
        Self {
            albedos,
            max_albedo,
        }
    }
}

/// Single-scatter albedo of each channel whose cloth reflects `linear_rgb` (each in [0, 1]).
pub fn albedo_from_reflectance(linear_rgb: [f64; 3], table: &AlbedoTable) -> [f64; 3] {
    linear_rgb.map(|reflectance| {
        let position = reflectance.clamp(0.0, 1.0) * (ENTRIES - 1) as f64;
        let below = (position as usize).min(ENTRIES - 2);
        let share = position - below as f64;
        let albedo = table.albedos[below] * (1.0 - share) + table.albedos[below + 1] * share;
        albedo.min(table.max_albedo)
    })
}

/// Σ_{n ≤ bounces} c_n·ωⁿ.
fn reflectance(bounces: usize, albedo: f64) -> f64 {
    ESCAPE
        .iter()
        .take(bounces)
        .rev()
        .fold(0.0, |sum, c| (sum + c) * albedo)
}

/// The albedo in [0, 1] at which `reflectance` has a value, or 1 where it stays below.
fn inverse(value: f64, bounces: usize) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // 2⁻⁴⁰ is far below the 16 bits that albedos are stored with.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if reflectance(bounces, middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
