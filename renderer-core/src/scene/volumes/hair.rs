//! Stray fibres: thin curls that leave the yarn and give the cloth its fuzz (the paper's §3, third observation).
//!
//! A fibre is far thinner than a voxel, so it is drawn as a little density in each voxel it passes.

use glam::DVec3;

use super::{Cell, Field, LoopSize, Yarn, signed, variant_random};
use crate::design::Pile;

/// Density that a fibre adds to a voxel for each voxel length it runs in it.
const DENSITY: f64 = 0.11;

/// Stray fibres of one loop.
pub(super) struct Hair {
    count: u32,
    /// Length of a fibre, mm.
    length: f64,
    variant: u32,
    size: LoopSize,
    cells: [usize; 3],
}

impl Hair {
    pub(super) fn new(pile: &Pile, size: LoopSize, variant: u32) -> Self {
        // Full hairiness lets out one and a half fibres for each fibre of the yarn along the whole loop.
        let count = (pile.hairiness * 1.5 * f64::from(pile.fibres)).round() as u32;
        let cells = [pile.resolution, pile.resolution, pile.layers].map(|n| n as usize);
        Self {
            count,
            length: 1.2 * pile.yarn_diameter,
            variant,
            size,
            cells,
        }
    }

    /// Draws all fibres into `cells` (u fastest, then v, then layers).
    pub(super) fn draw(&self, field: &impl Field, cells: &mut [Cell]) {
        let mut random = variant_random(self.variant, 3);
        let step = self.size.width / self.cells[0] as f64;
        for _ in 0..self.count {
            let (mut point, out, axis) = field.surface(&mut random);
            let sense = if random.next_float() < 0.5 { 1.0 } else { -1.0 };
            let mut direction =
                (axis * sense + out * (0.6 + 0.4 * signed(&mut random))).normalize_or(out);
            let length = self.length * (0.4 + 0.6 * f64::from(random.next_float()));
            for _ in 0..(length / step).ceil() as usize {
                if let Some(index) = self.index(point) {
                    cells[index].add(
                        Yarn {
                            density: DENSITY,
                            shade: 1.0,
                            tangent: direction,
                        },
                        1.0,
                    );
                }
                let curl = DVec3::new(
                    signed(&mut random),
                    signed(&mut random),
                    signed(&mut random),
                );
                direction = (direction + 0.45 * curl).normalize_or(direction);
                point += direction * step;
            }
        }
    }

    /// The voxel that holds a point, if any.
    fn index(&self, point: DVec3) -> Option<usize> {
        let uvw = DVec3::new(
            point.x / self.size.width + 0.5,
            point.y / self.size.length,
            point.z / self.size.thickness + 0.5,
        );
        let [a, b, layer] =
            std::array::from_fn(|axis| (uvw[axis] * self.cells[axis] as f64).floor());
        let inside = |value: f64, axis: usize| value >= 0.0 && value < self.cells[axis] as f64;
        (inside(a, 0) && inside(b, 1) && inside(layer, 2))
            .then(|| (layer as usize * self.cells[1] + b as usize) * self.cells[0] + a as usize)
    }
}
