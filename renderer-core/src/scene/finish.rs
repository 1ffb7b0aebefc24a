//! Wear and finish: what happens to loops after weaving (MODEL.md §13). A map brushes the front's pile one way or
//! another; shears cut a face level; some loops that they did not reach are pulled out; water darkens the yarn, thins
//! it and gathers loops into clumps. mm and radians.
//!
//! All of it is decided here, before anything is drawn: renderers see loops, materials and volumes as ever.

use super::frames::MAX_LEAN;
use super::nap::NapOnSheet;
use super::skeleton::Face;
use super::{LoopPatch, SheetGeometry, Skeleton};
use crate::design::{Design, Finish, Pile, PileKind, Sheared};
use crate::sampling::{hash_with, unit_float};

/// Refractive index of water.
const WATER: f64 = 1.33;
/// Share of diffuse light that a surface of water reflects from outside (Lekner and Dorf 1988, R̄ for n = 1.33).
const FILM_REFLECTS: f64 = 0.066;
/// Share of the tip's way to the middle of its clump that soaked loops lean.
const GATHERING: f64 = 0.75;
/// By how much of their diameter soaked yarns get thinner, and by how much of their width soaked loops close.
const THINNING: f64 = 0.25;
/// The bits of a loop's hash that pulling follows; 0 to 4 are its jitter and variant.
const PULLED_BITS: u32 = 5;

/// What a design does to its loops after weaving; what does nothing is left out, so that equal loops have equal inputs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finishing {
    nap: Option<NapOnSheet>,
    shear_mm: [Option<f64>; 2],
    pulled: Option<Pulled>,
    clumps: Option<Clumps>,
}

/// Loops pulled out.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pulled {
    share: f64,
    by_mm: f64,
}

/// Loops that water gathers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Clumps {
    size_mm: f64,
    wetness: f64,
    seed: u32,
}

/// What happens to one loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoopFinish {
    /// How it is brushed besides its settings' lean, along x and y, radians.
    pub lean: [f64; 2],
    /// Height over the sheet's plane above which nothing of it is left, mm.
    pub shear_mm: Option<f64>,
    /// By how much it is longer if nothing of it is shorn, mm; the pull lays it over, the more the longer it gets.
    pub pulled_mm: f64,
    /// Where its tip is drawn to, along x and y, mm from where it stood.
    pub drawn_mm: [f64; 2],
}

impl Finishing {
    pub(super) fn new(design: &Design, sheet: &SheetGeometry) -> Self {
        let finish = &design.finish;
        let longer_mm = finish.longer_mm();
        Self {
            nap: NapOnSheet::new(&design.nap, sheet),
            shear_mm: [Face::Front, Face::Back].map(|face| shear_mm(finish, face)),
            pulled: (longer_mm > 0.0).then_some(Pulled {
                share: finish.pulled,
                by_mm: longer_mm,
            }),
            clumps: (finish.wetness > 0.0).then_some(Clumps {
                size_mm: finish.clump_size,
                wetness: finish.wetness,
                seed: design.turbulence.seed,
            }),
        }
    }

    /// What happens to the loop with this hash of a cell of the whole cloth; the middle of its cell is at a place, mm
    /// from the cloth's low corner.
    pub(super) fn of_loop(
        &self,
        hash: u32,
        face: Face,
        [i, j]: [usize; 2],
        place_mm: [f64; 2],
    ) -> LoopFinish {
        let is_pulled =
            |pulled: &Pulled| f64::from(unit_float(hash_with(hash, PULLED_BITS))) < pulled.share;
        let by_mm = |pulled: Pulled| pulled.by_mm;
        let nap = self.nap.as_ref().filter(|_| face == Face::Front);
        LoopFinish {
            lean: nap.map_or([0.0; 2], |nap| nap.lean(i, j)),
            shear_mm: self.shear_mm[usize::from(face == Face::Back)],
            pulled_mm: self.pulled.filter(is_pulled).map_or(0.0, by_mm),
            drawn_mm: self
                .clumps
                .map_or([0.0; 2], |clumps| clumps.draw_mm(place_mm)),
        }
    }

    /// By how much loops get longer at most, mm.
    pub(super) fn longer_mm(&self) -> f64 {
        self.pulled.map_or(0.0, |pulled| pulled.by_mm)
    }

    /// By how much loops lean more along x or y than their settings say at most, radians.
    pub(super) fn more_lean(&self) -> f64 {
        if self.pulled.is_some() || self.clumps.is_some() {
            return 2.0 * MAX_LEAN;
        }
        self.nap.as_ref().map_or(0.0, NapOnSheet::strength)
    }
}

impl Clumps {
    /// From a place to where water draws the tip of its loop: towards the nearest of scattered middles, one in each
    /// square of the clumps' size (Worley's cells).
    fn draw_mm(&self, place_mm: [f64; 2]) -> [f64; 2] {
        let square = place_mm.map(|mm| (mm / self.size_mm).floor() as i64);
        let mut nearest = ([0.0; 2], f64::INFINITY);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let at = [square[0] + dx, square[1] + dy];
            let hash = hash_with(
                hash_with(hash_with(self.seed, 0xc1), at[0] as u32),
                at[1] as u32,
            );
            let way: [f64; 2] = std::array::from_fn(|axis| {
                let within = f64::from(unit_float(hash_with(hash, axis as u32)));
                (at[axis] as f64 + within) * self.size_mm - place_mm[axis]
            });
            let distance = way[0].hypot(way[1]);
            if distance < nearest.1 {
                nearest = (way, distance);
            }
        }
        nearest.0.map(|mm| mm * GATHERING * self.wetness)
    }
}

/// Height over the sheet's plane above which shears cut this face, mm.
pub(super) fn shear_mm(finish: &Finish, face: Face) -> Option<f64> {
    let is_shorn = match finish.sheared {
        Sheared::None => false,
        Sheared::Front => face == Face::Front,
        Sheared::Back => face == Face::Back,
        Sheared::Both => true,
    };
    is_shorn.then_some(finish.shear_height)
}

/// Whether shears have reached a loop: its highest corner is where they cut, to the rounding of stored shapes.
pub(super) fn is_shorn(patch: &LoopPatch, face: Face, shear_mm: f64, length_unit_mm: f32) -> bool {
    let root = 0.5 * (f64::from(patch.root_z0) + f64::from(patch.root_z1));
    let middle = face.sign() * (root + f64::from(patch.axis[2]));
    let highest = middle + f64::from(patch.half_top[2]).abs();
    // Four components of half a unit each.
    (highest - shear_mm).abs() <= 2.0 * f64::from(length_unit_mm)
}

/// What kind of pile is left of a kind that is shorn: loops become tufts.
pub(super) fn shorn(kind: PileKind) -> PileKind {
    match kind {
        PileKind::Terry => PileKind::Cut,
        kind => kind,
    }
}

/// A pile with water in it: yarns are drawn together, so they are thinner and as much denser, their stray fibres lie on
/// them, and loops close.
pub(super) fn wet_pile(pile: &Pile, wetness: f64) -> Pile {
    let thinner = 1.0 - THINNING * wetness;
    Pile {
        top_width: pile.top_width * thinner,
        yarn_diameter: pile.yarn_diameter * thinner,
        hairiness: pile.hairiness * (1.0 - wetness),
        density: pile.density / (thinner * thinner),
        ..pile.clone()
    }
}

/// What a cloth of reflectance `dry` reflects when a share `wetness` of its yarns is covered by water, without the
/// film's own mirror image of the light: the film lets a share of the light in and throws most of what comes back onto
/// the yarn again, where more is absorbed (Ångström 1925; Lekner and Dorf 1988, "Why some things are darker when wet",
/// with p = 1 − (1 − R̄)/n² for the share thrown back).
pub fn wet_reflectance(dry: f64, wetness: f64) -> f64 {
    let thrown_back = 1.0 - (1.0 - FILM_REFLECTS) / (WATER * WATER);
    let wet = (1.0 - FILM_REFLECTS) * (1.0 - thrown_back) * dry / (1.0 - thrown_back * dry);
    (1.0 - wetness) * dry + wetness * wet
}

impl Skeleton {
    /// This ground weave with water on a share of its yarns: only their albedo changes.
    pub(super) fn wet(self, wetness: f64) -> Self {
        Self {
            albedo: self
                .albedo
                .map(|albedo| wet_reflectance(f64::from(albedo), wetness) as f32),
            ..self
        }
    }
}
