//! From the reflectance of finished cloth to the single-scatter albedo of its fibres (MODEL.md §6): light scatters many
//! times in the pile, which darkens and saturates, so the albedo must be higher than the colour that is wanted.
//!
//! With isotropic scattering R(ω) = Σ_n c_n·ωⁿ exactly, c_n the share of sky light that leaves the pile after n
//! scatterings when nothing is absorbed; a path of at most b bounces keeps the first b terms. [`ESCAPE`] was measured on
//! the default bath terry with white loops: the mean radiance of `tracked` pictures of it, albedo 1, under a uniform sky. Where the bounces do not suffice, colours are scaled to what the brightest yarn reaches, so
//! that a picture of few bounces is darker but has the chart's hues.

/// c_n for n = 1, 2, …: share of a uniform sky's light, seen at 60° elevation, that leaves white terry after exactly n
/// scatterings.
const ESCAPE: [f64; 64] = [
    0.11581, 0.07333, 0.05378, 0.04175, 0.03411, 0.02882, 0.02492, 0.02191, 0.01951, 0.01756,
    0.01593, 0.01455, 0.01336, 0.01234, 0.01144, 0.01064, 0.00994, 0.00931, 0.00874, 0.00822,
    0.00776, 0.00733, 0.00694, 0.00659, 0.00626, 0.00595, 0.00567, 0.00541, 0.00517, 0.00494,
    0.00473, 0.00453, 0.00435, 0.00417, 0.00401, 0.00386, 0.00371, 0.00357, 0.00344, 0.00332,
    0.00321, 0.00310, 0.00299, 0.00289, 0.00280, 0.00271, 0.00263, 0.00254, 0.00247, 0.00239,
    0.00232, 0.00226, 0.00219, 0.00213, 0.00207, 0.00201, 0.00196, 0.00191, 0.00186, 0.00181,
    0.00177, 0.00172, 0.00168, 0.00164,
];

/// Entries of the inverse table; neighbouring entries differ by at most 0.005 in albedo, interpolation by far less.
const ENTRIES: usize = 1024;

/// Albedo for each reflectance, for one number of bounces.
#[derive(Debug, Clone, PartialEq)]
pub struct AlbedoTable {
    /// Albedo at reflectance k/(ENTRIES − 1).
    albedos: Vec<f64>,
    max_albedo: f64,
    /// The reflectance above which yarn would need more than `max_albedo`.
    brightest: f64,
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
            brightest: full,
        }
    }
}

/// Single-scatter albedo of each channel whose cloth reflects `linear_rgb` (each in [0, 1]).
///
/// A colour brighter than the yarn can be is darkened until its brightest channel is as bright as can be: capping each
/// channel alone would turn cream into grey.
pub fn albedo_from_reflectance(linear_rgb: [f64; 3], table: &AlbedoTable) -> [f64; 3] {
    let brightest = linear_rgb.into_iter().fold(0.0, f64::max);
    let darken = if brightest > table.brightest {
        table.brightest / brightest
    } else {
        1.0
    };
    linear_rgb.map(|reflectance| {
        let position = (reflectance * darken).clamp(0.0, 1.0) * (ENTRIES - 1) as f64;
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
