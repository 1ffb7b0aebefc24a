//! Cut pile: a tuft of fibres that spreads from its root and ends in a ragged brush (velour, cut carpets).

use std::f64::consts::TAU;

use glam::DVec3;
use noise::{NoiseFn, Perlin};

use super::{Field, GROOVE_SHADE, LoopSize, MARGIN, Yarn, falloff, signed, variant_random};
use crate::design::Pile;
use crate::sampling::Pcg;

pub(super) struct Cut {
    size: LoopSize,
    root_radius: f64,
    /// Half widths at the tip, mm, along the patch and along its thickness.
    tip: [f64; 2],
    /// How far the tip hangs to one side, mm.
    sway: f64,
    noise: Perlin,
    /// Fibre clumps across the tuft.
    across: f64,
}

impl Cut {
    pub(super) fn new(pile: &Pile, size: LoopSize, variant: u32) -> Self {
        let mut random = variant_random(variant, 2);
        let radius = pile.yarn_diameter / 2.0;
        let tip = [size.width, size.thickness]
            .map(|side| (side / 2.0 * (1.0 - MARGIN)).max(0.25 * radius));
        Self {
            size,
            root_radius: radius.min(tip[0]).min(tip[1]),
            tip,
            sway: 0.1 * size.width * signed(&mut random),
            noise: Perlin::new(variant.wrapping_add(977)),
            across: f64::from(pile.fibres).sqrt(),
        }
    }

    /// Half widths of the tuft at a share of its height: a bundle below that blooms above.
    fn half_widths(&self, height: f64) -> [f64; 2] {
        let bloom = height.clamp(0.0, 1.0).powf(0.7);
        self.tip
            .map(|tip| self.root_radius + (tip - self.root_radius) * bloom)
    }
}

impl Field for Cut {
    fn yarn(&self, point: DVec3) -> Yarn {
        let height = point.y / self.size.length;
        let [half_x, half_z] = self.half_widths(height);
        let (x, z) = (
            (point.x - self.sway * height * height) / half_x,
            point.z / half_z,
        );
        let radius = x.hypot(z);
        if radius > 1.0 {
            return Yarn::default();
        }
        // The same fibre keeps its place (x, z) in the bundle all the way up.
        let fibre = self
            .noise
            .get([x * self.across, z * self.across, height * 0.8]);
        let end = 1.0
            - 0.5 * MARGIN
            - 0.1
                * (0.5
                    + 0.5
                        * self
                            .noise
                            .get([x * self.across * 1.7, z * self.across * 1.7, 9.3]));
        let brush = ((end - height) / 0.06 + 0.5).clamp(0.0, 1.0);
        // Fibres that spread leave room between them.
        let packed = (self.root_radius * self.root_radius / (half_x * half_z)).sqrt();
        let streak = (0.5 + 0.9 * fibre).clamp(0.0, 1.0);
        let density = falloff(radius) * brush * (0.35 + 0.65 * packed) * (1.0 - 0.6 * streak);
        let spread = DVec3::new(
            x * (self.tip[0] - self.root_radius),
            self.size.length,
            z * (self.tip[1] - self.root_radius),
        );
        Yarn {
            density,
            shade: 1.0 - GROOVE_SHADE * streak,
            tangent: spread.normalize_or(DVec3::Y),
        }
    }

    fn surface(&self, random: &mut Pcg) -> (DVec3, DVec3, DVec3) {
        let height = 0.3 + 0.65 * f64::from(random.next_float());
        let [half_x, half_z] = self.half_widths(height);
        let angle = TAU * f64::from(random.next_float());
        let out = DVec3::new(angle.cos(), 0.0, angle.sin());
        let point = DVec3::new(
            0.9 * half_x * out.x + self.sway * height * height,
            height * self.size.length,
            0.9 * half_z * out.z,
        );
        (point, out, DVec3::Y)
    }
}
