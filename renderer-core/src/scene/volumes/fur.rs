//! Fur: a tuft of hairs that taper to their tips. Two in three are short and curl beside each other, the undercoat; the
//! others, the guard hairs, stand above it and lean together.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Field, LoopSize, MARGIN, Yarn, falloff, signed, variant_random};
use crate::design::Pile;
use crate::sampling::Pcg;

/// One hair in so many is a guard hair.
const GUARD_EVERY: u32 = 3;
/// How much of the way from its own place to the tuft's common tip a guard hair's tip goes.
const CLUMPING: f64 = 0.55;
/// Radius over which a hair is drawn at least, in voxels: thinner ones would fall between the points that are averaged.
const LEAST_RADIUS: f64 = 0.7;

pub(super) struct Fur {
    size: LoopSize,
    hairs: Vec<Hair>,
    /// Radius over which a hair is drawn at least, mm.
    least_radius: f64,
}

/// One hair, mm: (x, z) is its place across the tuft.
struct Hair {
    root: DVec2,
    /// From the root to the tip.
    lean: DVec2,
    curl: DVec2,
    curl_phase: f64,
    /// Turns of its curl from root to tip.
    curls: f64,
    height: f64,
    /// At its root.
    radius: f64,
}

impl Fur {
    pub(super) fn new(pile: &Pile, size: LoopSize, variant: u32) -> Self {
        let mut random = variant_random(variant, 5);
        let half = DVec2::new(size.width, size.thickness) * (0.5 * (1.0 - MARGIN));
        let disc = |random: &mut Pcg| {
            let (radius, angle) = (f64::from(random.next_float()).sqrt(), TAU * signed(random));
            DVec2::from_angle(angle) * radius
        };
        let tuft_radius = DVec2::splat(0.5 * pile.yarn_diameter).min(half);
        let common_tip = disc(&mut random) * 0.4 * half;
        // All hairs together have the section of the yarn.
        let radius = 0.5 * pile.yarn_diameter / f64::from(pile.fibres).sqrt();
        let hairs = (0..pile.fibres).map(|number| {
            let is_guard = number % GUARD_EVERY == 0;
            let root = disc(&mut random) * tuft_radius;
            let spread = disc(&mut random) * half;
            let share = f64::from(random.next_float());
            let (tip, height, curl) = if is_guard {
                (spread.lerp(common_tip, CLUMPING), 0.78 + 0.2 * share, 0.04)
            } else {
                (0.5 * (root + spread), 0.3 + 0.35 * share, 0.12)
            };
            Hair {
                root,
                lean: tip - root,
                curl: disc(&mut random) * curl * half,
                curl_phase: TAU * signed(&mut random),
                curls: 1.0 + 1.5 * f64::from(random.next_float()),
                height: height * size.length,
                radius: radius * if is_guard { 1.2 } else { 0.8 },
            }
        });
        let hairs = hairs.collect();
        Self {
            size,
            hairs,
            least_radius: LEAST_RADIUS * size.width / f64::from(pile.resolution),
        }
    }
}

impl Hair {
    /// Where it is at a share of its height, and its direction there.
    fn at(&self, share: f64) -> (DVec2, DVec3) {
        let turn = TAU * self.curls * share + self.curl_phase;
        let place = self.root + self.lean * share * share + self.curl * (share * turn.sin());
        let slope = self.lean * (2.0 * share)
            + self.curl * (turn.sin() + share * TAU * self.curls * turn.cos());
        let along = DVec3::new(slope.x, self.height, slope.y);
        (place, along.normalize_or(DVec3::Y))
    }
}

impl Field for Fur {
    fn yarn(&self, point: DVec3) -> Yarn {
        let across = DVec2::new(point.x, point.z);
        let (mut density, mut tangent) = (0.0, DVec3::ZERO);
        for hair in &self.hairs {
            let share = point.y / hair.height;
            if share > 1.0 {
                continue;
            }
            let (place, along) = hair.at(share);
            let radius = hair.radius * (1.0 - share).sqrt();
            let drawn = radius.max(self.least_radius);
            let distance = place.distance(across) / drawn;
            if distance < 1.0 {
                // Drawn wider it is as much thinner.
                let here = (radius / drawn).powi(2) * falloff(distance);
                density += here;
                tangent += along * here;
            }
        }
        Yarn {
            density: f64::min(density, 1.0),
            shade: 1.0,
            tangent: tangent.normalize_or(DVec3::Y),
        }
    }

    fn surface(&self, random: &mut Pcg) -> (DVec3, DVec3, DVec3) {
        let number = (f64::from(random.next_float()) * self.hairs.len() as f64) as usize;
        let share = 0.2 + 0.8 * f64::from(random.next_float());
        let angle = TAU * f64::from(random.next_float());
        let out = DVec3::new(angle.cos(), 0.0, angle.sin());
        match self.hairs.get(number) {
            Some(hair) => {
                let (place, along) = hair.at(share);
                let point = DVec3::new(place.x, share * hair.height, place.y);
                (point, out, along)
            }
            // A pile has one fibre at least.
            None => (DVec3::Y * share * self.size.length, out, DVec3::Y),
        }
    }
}
