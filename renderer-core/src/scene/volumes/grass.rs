//! Grass: a tuft of flat blades that bend outwards and taper to a point, each with a rib along its middle.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Field, LoopSize, MARGIN, Yarn, falloff, signed, variant_random};
use crate::design::Pile;
use crate::sampling::Pcg;

/// Thickness of a blade over its width.
const FLATNESS: f64 = 0.12;
/// Half the thickness over which a blade is drawn at least, in layers: thinner ones would fall between the points
/// averaged.
const LEAST_LAYERS: f64 = 0.6;
/// How much less of its light the rib gives back.
const RIB_SHADE: f64 = 0.2;

pub(super) struct Grass {
    blades: Vec<Blade>,
}

/// One blade, mm: (x, z) is its place across the tuft.
struct Blade {
    root: DVec2,
    /// Unit vector towards which it bends; its face looks there.
    out: DVec2,
    /// How far its tip is bent from the root.
    bend: f64,
    height: f64,
    /// Half of each at its widest.
    half_width: f64,
    half_thickness: f64,
    /// Share of the material that is there where it is drawn thicker than it is.
    filled: f64,
}

impl Grass {
    pub(super) fn new(pile: &Pile, size: LoopSize, variant: u32) -> Self {
        let mut random = variant_random(variant, 6);
        let half = DVec2::new(size.width, size.thickness) * (0.5 * (1.0 - MARGIN));
        let half_width = 0.5 * pile.yarn_diameter;
        let half_thickness = FLATNESS * half_width;
        let voxel =
            (size.width / f64::from(pile.resolution)).max(size.thickness / f64::from(pile.layers));
        let drawn = half_thickness.max(LEAST_LAYERS * voxel);
        let first = TAU * f64::from(random.next_float());
        let blade = |number: u32| {
            // Around the tuft in equal parts, a little off.
            let part = TAU / f64::from(pile.plies);
            let angle = first + part * (f64::from(number) + 0.35 * signed(&mut random));
            let out = DVec2::from_angle(angle);
            let root = out * half * (0.25 * f64::from(random.next_float()));
            // As far as the volume has room.
            let room =
                (half - root.abs() - drawn).max(DVec2::ZERO) / out.abs().max(DVec2::splat(1e-6));
            let bend = room.min_element().min(size.length)
                * (0.35 + 0.65 * f64::from(random.next_float()));
            Blade {
                root,
                out,
                bend,
                height: size.length * (0.98 - 0.4 * f64::from(random.next_float())),
                half_width,
                half_thickness: drawn,
                filled: half_thickness / drawn,
            }
        };
        Self {
            blades: (0..pile.plies).map(blade).collect(),
        }
    }
}

impl Blade {
    /// Its middle at a share of its height, and its direction there.
    fn at(&self, share: f64) -> (DVec2, DVec3) {
        let place = self.root + self.out * (self.bend * share * share);
        let slope = self.out * (2.0 * self.bend * share);
        let along = DVec3::new(slope.x, self.height, slope.y);
        (place, along.normalize_or(DVec3::Y))
    }

    /// Half its width at a share of its height: a sheath below, widest at a third, then a long point.
    fn half_width_at(&self, share: f64) -> f64 {
        let sheath = (0.55 + 1.35 * share).min(1.0);
        self.half_width * sheath * (1.0 - share.powi(3)).max(0.0)
    }
}

impl Field for Grass {
    fn yarn(&self, point: DVec3) -> Yarn {
        let across = DVec2::new(point.x, point.z);
        let mut best = Yarn::default();
        for blade in &self.blades {
            let share = point.y / blade.height;
            if share > 1.0 {
                continue;
            }
            let (place, along) = blade.at(share);
            let from = across - place;
            let half_width = blade.half_width_at(share).max(1e-9);
            let side = from.dot(blade.out.perp()) / half_width;
            let depth = from.dot(blade.out) / blade.half_thickness;
            let density = blade.filled * falloff(side.abs()) * falloff(depth.abs());
            if density > best.density {
                best = Yarn {
                    density,
                    shade: 1.0 - RIB_SHADE * (1.0 - 4.0 * side.abs()).max(0.0),
                    tangent: along,
                };
            }
        }
        best
    }

    fn surface(&self, random: &mut Pcg) -> (DVec3, DVec3, DVec3) {
        let number = (f64::from(random.next_float()) * self.blades.len() as f64) as usize;
        let share = 0.1 + 0.8 * f64::from(random.next_float());
        match self.blades.get(number) {
            Some(blade) => {
                let (place, along) = blade.at(share);
                let out = DVec3::new(blade.out.x, 0.0, blade.out.y);
                (
                    DVec3::new(place.x, share * blade.height, place.y),
                    out,
                    along,
                )
            }
            // A tuft has one blade at least.
            None => (DVec3::ZERO, DVec3::X, DVec3::Y),
        }
    }
}
