//! Terry: an uncut loop, two legs and an arch. The centre line lies near the patch's plane, a little bent so that no
//! two variants are alike. The arch is half an ellipse, a circle where the loop is long enough.

use glam::DVec3;

use super::strand::{End, PIECES, Strand};
use super::{LoopSize, MARGIN, signed, variant_random};
use crate::design::Pile;
use crate::sampling::Pcg;

pub(super) fn terry(pile: &Pile, size: LoopSize, variant: u32) -> Strand {
    let mut random = variant_random(variant, 1);
    let line = centre_line(pile.yarn_diameter, size, &mut random);
    Strand::new(pile, line, End::Rooted, variant, &mut random)
}

/// Legs and arch of one variant: bent sideways, out of plane and in leg spacing.
fn centre_line(diameter: f64, size: LoopSize, random: &mut Pcg) -> Vec<DVec3> {
    let margin = diameter * (0.5 + MARGIN);
    let spacing =
        (size.width - 2.0 * margin).max(0.0) * (1.0 - 0.12 * f64::from(random.next_float()));
    let top = (size.length - margin).max(0.3 * size.length);
    let rise = (spacing / 2.0).min(top);
    let room = (size.thickness / 2.0 - 0.5 * diameter).max(0.0);
    let (bend, sway, slack) = (signed(random) * room, signed(random) * room, signed(random));
    let asymmetry = 0.25 * slack * (size.width / 2.0 - margin - spacing / 2.0).max(0.0);
    let leg = top - rise;
    let half_girth = std::f64::consts::PI * rise / 2.0;
    let total = 2.0 * (leg + half_girth);
    (0..=PIECES)
        .map(|k| {
            let s = total * k as f64 / PIECES as f64;
            let (side, from_root) = if s < total / 2.0 {
                (-1.0, s)
            } else {
                (1.0, total - s)
            };
            let (x, y) = if from_root <= leg {
                (spacing / 2.0, from_root)
            } else {
                let angle = (from_root - leg) / half_girth * std::f64::consts::FRAC_PI_2;
                (spacing / 2.0 * angle.cos(), leg + rise * angle.sin())
            };
            let height = y / top;
            DVec3::new(
                side * x + asymmetry * height,
                y,
                (bend * side + sway) * 0.5 * height,
            )
        })
        .collect()
}
