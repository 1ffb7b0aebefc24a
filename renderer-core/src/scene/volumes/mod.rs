//! The voxels inside a yarn loop (MODEL.md §5): an arch of round yarn whose centre line lies in the middle of the patch,
//! or an upright tuft. Lengths in mm at the reference size.

use rayon::prelude::*;

use super::Volumes;
use crate::design::{Phase, Pile, PileKind};

/// Fills the volumes of all kinds and variants for loops of the reference length.
pub fn rasterise(pile: &Pile, kinds: &[PileKind], reference_length_mm: f64) -> Volumes {
    let size = [
        pile.base_width,
        reference_length_mm.max(0.05),
        pile.thickness,
    ];
    let with_tangents = pile.phase == Phase::KajiyaKay;
    let (side, layers) = (pile.resolution as usize, pile.layers as usize);
    let count = kinds.len() * pile.variants as usize * layers * side * side;
    let voxel = |index: usize| {
        let at = |n: usize, k: usize, size: f64| ((k % n) as f64 + 0.5) / n as f64 * size;
        let (a, b) = (index, index / side);
        let layer = index / (side * side);
        let kind = kinds[layer / layers / pile.variants as usize];
        let w = at(layers, layer, size[2]) - 0.5 * size[2];
        yarn(
            pile,
            kind,
            size,
            [at(side, a, size[0]), at(side, b, size[1]), w],
        )
    };
    let yarns: Vec<(f64, [f64; 2])> = (0..count).into_par_iter().map(voxel).collect();
    let byte = |x: f64| (x * 255.0).round() as u8;
    let tangent = |&(density, [x, y]): &(f64, [f64; 2])| {
        [x * x, y * y, 0.0, x * y, 0.0, 0.0, 0.0, 0.0].map(|t| (t * density * 127.0).round() as i8)
    };
    Volumes {
        resolution: pile.resolution,
        layers: pile.layers,
        variants: pile.variants,
        kinds: kinds.to_vec(),
        interpolation: pile.interpolation,
        root_blend: pile.root_blend as f32,
        voxels: yarns
            .iter()
            .map(|&(density, _)| [byte(density); 2])
            .collect(),
        tangents: if with_tangents {
            yarns.iter().map(tangent).collect()
        } else {
            Vec::new()
        },
        reference_size_mm: size.map(|s| s as f32),
    }
}

/// Density and fibre direction (in the patch's plane) of the yarn at a point.
fn yarn(
    pile: &Pile,
    kind: PileKind,
    [width, length, thickness]: [f64; 3],
    [x, y, w]: [f64; 3],
) -> (f64, [f64; 2]) {
    let radius = 0.5 * pile.yarn_diameter.min(width).min(thickness).min(length);
    let from_middle = x - 0.5 * width;
    let (distance, tangent) = match kind {
        PileKind::Cut => (from_middle.abs(), [0.0, 1.0]),
        PileKind::Terry => {
            // Legs at ± `leg`, joined by half a circle that touches the patch's top with its outer side.
            let leg = (0.5 * width - radius).min(length - radius);
            let above = (y - (length - radius - leg)).max(0.0);
            let from_centre = from_middle.hypot(above).max(1e-9);
            let along = [-above / from_centre, from_middle / from_centre];
            ((from_centre - leg).abs(), along)
        }
    };
    // Density falls off over the yarn's outer fifth.
    let edge = ((1.0 - distance.hypot(w) / radius) / 0.2).clamp(0.0, 1.0);
    (edge * edge * (3.0 - 2.0 * edge), tangent)
}
