//! From the reflectance of finished cloth to the single-scatter albedo of its fibres (MODEL.md §6): light scatters many
//! times in the pile, which darkens and saturates, so the albedo must be higher than the colour that is wanted.
//!
//! Light that leaves the cloth after n scatterings in the pile and m on ground yarns is ω^n·σ^m of what it is without
//! absorption, ω the albedo of the loops and σ that of the ground yarns. So under a uniform sky the cloth reflects
//!   R(ω, σ) = Σ_n ω^n · (c_n + g_n·Σ_m p_n(m)·σ^m),
//! c_n the share of light that meets pile alone, g_n that which meets ground yarns as well, m ≥ 1 times on average
//! m̄_n. m is taken to be distributed geometrically: Σ_m p(m)·σ^m = σ(1−q)/(1−qσ), q = 1 − 1/m̄. Paths of at most b
//! scatterings keep the terms with n + m ≤ b. [`super::scattering_orders`] holds c, g and m̄, measured on the default
//! terry; cloth that is much thinner or less dense gives back a little less.
//!
//! What cloth can reflect ends where its loops have the albedo `max_albedo`: for 0.985, on the default ground yarns and
//! seen as by the default camera, at 0.61 (sRGB 205) however often light scatters, at 0.60 with 64 bounces and 0.48
//! with 16. A brighter colour is darkened to that, its hue kept. So white is the whitest cotton that the bounces can
//! show; what the tail beyond 64 bounces would add to it is 2 %, ΔE 0.6, and less to every other colour.

use super::finish::wet_reflectance;
use super::scattering_orders::{
    BIN_ENDS, BINS, Column, FRAME_LAMBERT, GRADIENT_LAMBERT, ISOTROPIC, KAJIYA_KAY,
};
use crate::design::Phase;

/// Reflectances for which the inverse is tabulated; between them it is linear to a thousandth.
const ENTRIES: usize = 1024;

/// Albedos at which R is tabulated for that, closer together where it is steeper.
const ALBEDOS: usize = 512;

/// With so small a share of all the light that cloth can reflect, a picture keeps the proportions of its colours, since
/// hardly any of them would be bright enough; with the larger share it shows each as it is.
const PROPORTIONS_UP_TO: f64 = 0.4;
const COLOURS_FROM: f64 = 0.7;

/// What decides how colours become albedos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dye {
    /// Phase function of the pile.
    pub phase: Phase,
    /// Share of light that its surfaces let through, for the phases that have one.
    pub transmission: f64,
    /// Albedo of the ground yarns, red, green and blue.
    pub ground: [f64; 3],
    /// Most scatterings of a path.
    pub bounces: u32,
    /// Most light that one scattering in the pile may give back.
    pub max_albedo: f64,
}

/// Albedo for each reflectance.
#[derive(Debug, Clone, PartialEq)]
pub struct AlbedoTable {
    channels: [Channel; 3],
    /// What all colours are multiplied with first.
    scale: f64,
}

/// One of red, green and blue.
#[derive(Debug, Clone, PartialEq)]
struct Channel {
    /// Albedo at reflectance k/(ENTRIES − 1).
    albedos: Vec<f64>,
    /// Reflectance of the brightest yarn.
    brightest: f64,
}

impl AlbedoTable {
    /// The conversion for `dye`.
    pub fn new(dye: &Dye) -> Self {
        let column = column(dye.phase, dye.transmission);
        let channels = dye.ground.map(|ground| {
            let terms = terms(&column, ground, dye.bounces);
            Channel::new(&terms, dye.max_albedo)
        });
        // What more bounces would add, the same for all colours.
        let all = dye.ground.map(|ground| {
            let terms = terms(&column, ground, BIN_ENDS[BINS - 1]);
            reflectance(&terms, dye.max_albedo)
        });
        let shares = channels.iter().zip(all).filter(|(_, all)| *all > 0.0);
        let share = shares.fold(1.0, |share: f64, (channel, all)| {
            share.min(channel.brightest / all)
        });
        let blend =
            ((share - PROPORTIONS_UP_TO) / (COLOURS_FROM - PROPORTIONS_UP_TO)).clamp(0.0, 1.0);
        Self {
            channels,
            scale: share + (1.0 - share) * blend,
        }
    }

    /// The reflectance that cloth of a colour is given: the colour itself, or the brightest of its hue that yarn can
    /// be.
    pub fn reached(&self, linear_rgb: [f64; 3]) -> [f64; 3] {
        let channels = self.channels.iter().zip(linear_rgb);
        let darken = channels.fold(1.0, |darken: f64, (channel, wanted)| {
            let wanted = wanted * self.scale;
            if wanted > channel.brightest {
                darken.min(channel.brightest / wanted)
            } else {
                darken
            }
        });
        linear_rgb.map(|wanted| wanted * self.scale * darken)
    }
}

/// Single-scatter albedo of each channel whose cloth reflects `linear_rgb` (each in [0, 1]).
pub fn albedo_from_reflectance(linear_rgb: [f64; 3], table: &AlbedoTable) -> [f64; 3] {
    wet_albedo_from_reflectance(linear_rgb, table, 0.0)
}

/// Single-scatter albedo of each channel of cloth that reflects `linear_rgb` (each in [0, 1]) when it is dry, and of
/// whose yarns a share `wetness` is wet.
pub(super) fn wet_albedo_from_reflectance(
    linear_rgb: [f64; 3],
    table: &AlbedoTable,
    wetness: f64,
) -> [f64; 3] {
    let reached = table.reached(linear_rgb);
    [0, 1, 2].map(|c| table.channels[c].albedo(wet_reflectance(reached[c], wetness)))
}

impl Channel {
    fn new(terms: &[f64], max_albedo: f64) -> Self {
        let forward: Vec<(f64, f64)> = (0..ALBEDOS)
            .map(|k| {
                let rest = 1.0 - k as f64 / (ALBEDOS - 1) as f64;
                let albedo = max_albedo * (1.0 - rest * rest);
                (reflectance(terms, albedo), albedo)
            })
            .collect();
        let albedos = (0..ENTRIES)
            .map(|k| interpolated(&forward, k as f64 / (ENTRIES - 1) as f64))
            .collect();
        Self {
            albedos,
            brightest: reflectance(terms, max_albedo),
        }
    }

    fn albedo(&self, reflectance: f64) -> f64 {
        let position = reflectance.clamp(0.0, 1.0) * (ENTRIES - 1) as f64;
        let below = (position as usize).min(ENTRIES - 2);
        let share = position - below as f64;
        self.albedos[below] * (1.0 - share) + self.albedos[below + 1] * share
    }
}

/// The value at `x` of a line through points with rising x; constant beyond its ends.
fn interpolated(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|&(place, _)| place < x);
    let (Some(&before), Some(&after)) = (
        points.get(after.saturating_sub(1)),
        points.get(after.min(points.len() - 1)),
    ) else {
        return 0.0;
    };
    if after.0 <= before.0 {
        return after.1;
    }
    let share = ((x - before.0) / (after.0 - before.0)).clamp(0.0, 1.0);
    before.1 + (after.1 - before.1) * share
}

/// What was measured for a phase function; between the transmissions that were measured a parabola.
fn column(phase: Phase, transmission: f64) -> Column {
    let measured = match phase {
        Phase::Isotropic => return ISOTROPIC,
        Phase::KajiyaKay => return KAJIYA_KAY,
        Phase::FrameLambert => &FRAME_LAMBERT,
        Phase::GradientLambert => &GRADIENT_LAMBERT,
    };
    let k = transmission;
    let weights = [
        (2.0 * k - 1.0) * (k - 1.0),
        4.0 * k * (1.0 - k),
        k * (2.0 * k - 1.0),
    ];
    let mean = |part: fn(&Column) -> &[f64; BINS]| {
        let mut mean = [0.0; BINS];
        for (weight, column) in weights.into_iter().zip(measured) {
            for (sum, value) in mean.iter_mut().zip(part(column)) {
                *sum += weight * value;
            }
        }
        mean
    };
    Column {
        pile: mean(|column| &column.pile),
        ground: mean(|column| &column.ground),
        on_ground: mean(|column| &column.on_ground),
    }
}

/// The factors of ω^0, ω^1, … in R of paths of at most `bounces` scatterings.
fn terms(column: &Column, ground: f64, bounces: u32) -> Vec<f64> {
    let mut terms = Vec::new();
    let mut first = 0;
    for (bin, &last) in BIN_ENDS.iter().enumerate() {
        // Within a bin light goes out as n^−1.5, as it does from bin to bin.
        let decay = |n: u32| f64::from(n.max(1)).powf(-1.5);
        let whole: f64 = (first..=last).map(decay).sum();
        let again = 1.0 - 1.0 / column.on_ground[bin].max(1.0);
        for n in (first..=last).take_while(|&n| n <= bounces) {
            // σ(1−q)·(1 + qσ + …), cut after m = bounces − n.
            let mean = ground * (1.0 - again) / (1.0 - again * ground)
                * (1.0 - (again * ground).powi((bounces - n) as i32));
            terms.push((column.pile[bin] + column.ground[bin] * mean) * decay(n) / whole);
        }
        first = last + 1;
    }
    terms
}

/// Σ terms_n·ω^n.
fn reflectance(terms: &[f64], albedo: f64) -> f64 {
    terms
        .iter()
        .rev()
        .fold(0.0, |sum, term| sum * albedo + term)
}
