//! Twisted: a strand of plied yarn that stands on one leg and is cut at its end, as in frieze and shag carpets. It
//! wavers on its way up, the more the higher: yarn that was set under twist curls when it is cut free.

use std::f64::consts::TAU;

use glam::DVec3;

use super::strand::{End, PIECES, Strand};
use super::{LoopSize, MARGIN, signed, variant_random};
use crate::design::Pile;
use crate::sampling::Pcg;

pub(super) fn twisted(pile: &Pile, size: LoopSize, variant: u32) -> Strand {
    let mut random = variant_random(variant, 4);
    let line = centre_line(pile.yarn_diameter, size, &mut random);
    Strand::new(pile, line, End::Cut, variant, &mut random)
}

/// The way of one variant: a slow wave and a fast one to each side, as far as the volume has room.
fn centre_line(diameter: f64, size: LoopSize, random: &mut Pcg) -> Vec<DVec3> {
    let margin = diameter * (0.5 + MARGIN);
    let top = (size.length - margin).max(0.3 * size.length);
    let room = [size.width, size.thickness].map(|side| (side / 2.0 - margin).max(0.0));
    let mut wave = |room: f64| {
        let (slow, fast) = (signed(random), signed(random));
        let (slow_phase, fast_phase) = (TAU * signed(random), TAU * signed(random));
        move |height: f64| {
            let waver = 0.65 * slow * ((2.2 * height + slow_phase).sin() - slow_phase.sin())
                + 0.35 * fast * ((7.0 * height + fast_phase).sin() - fast_phase.sin());
            // The sines differ by up to 2.
            0.5 * room * waver
        }
    };
    let (x, z) = (wave(room[0]), wave(room[1]));
    (0..=PIECES)
        .map(|k| {
            let height = k as f64 / PIECES as f64;
            DVec3::new(x(height), top * height, z(height))
        })
        .collect()
}
