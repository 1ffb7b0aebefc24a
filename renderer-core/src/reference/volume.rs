//! Reading the voxels inside a loop (MODEL.md §5): bilinear in u and v, clamped; nearest or linear across layers.
//!
//! What is interpolated is ρ, ρ·shade and ρ·ttᵀ; the last two are divided by ρ afterwards.

use glam::{DMat3, DVec3};

use crate::design::Interpolation;
use crate::geometry::main_axis;
use crate::scene::{LoopLook, Material, PileOptics, Volumes};

/// The volume of one loop.
#[derive(Debug, Clone, Copy)]
pub struct LoopVolume<'a> {
    volumes: &'a Volumes,
    /// Index of its first voxel.
    first: usize,
    /// Extinction where ρ = 1, 1/mm.
    pub density_per_mm: f64,
}

/// What a point of a volume holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumePoint {
    /// ρ, faded out towards the root.
    pub rho: f64,
    /// Factor on the albedo.
    pub shade: f64,
}

/// Two neighbouring texels and the share of the second.
#[derive(Clone, Copy)]
struct Pair {
    near: usize,
    far: usize,
    share: f64,
}

impl Pair {
    /// The texels about `place` in [0, 1] among `count`, texel k being centred at (k + ½)/count; clamped at the ends.
    fn linear(place: f64, count: u32) -> Self {
        let last = f64::from(count - 1);
        let x = (place * f64::from(count) - 0.5).clamp(0.0, last);
        let near = x as usize;
        Self {
            near,
            far: (near + 1).min(count as usize - 1),
            share: x - near as f64,
        }
    }

    fn nearest(place: f64, count: u32) -> Self {
        // A negative place becomes 0.
        let index = ((place * f64::from(count)) as usize).min(count as usize - 1);
        Self {
            near: index,
            far: index,
            share: 0.0,
        }
    }

    /// The near texel (0) or the far one (1), with its weight.
    fn term(self, which: usize) -> (usize, f64) {
        match which {
            0 => (self.near, 1.0 - self.share),
            _ => (self.far, self.share),
        }
    }
}

impl<'a> LoopVolume<'a> {
    /// The volume of a loop that looks like `look`.
    pub fn new(volumes: &'a Volumes, pile: &PileOptics, look: LoopLook) -> Self {
        let Material {
            density_per_mm,
            kind,
            ..
        } = pile.materials[usize::from(look.material)];
        let layers = (kind * volumes.variants + u32::from(look.variant)) * volumes.layers;
        Self {
            volumes,
            first: layers as usize * (volumes.resolution as usize).pow(2),
            density_per_mm: f64::from(density_per_mm),
        }
    }

    /// The voxels around (u, v, w) with their weights.
    fn around(&self, [u, v, w]: [f64; 3]) -> [(usize, f64); 8] {
        let resolution = self.volumes.resolution;
        let across = match self.volumes.interpolation {
            Interpolation::Linear => Pair::linear(w + 0.5, self.volumes.layers),
            Interpolation::Nearest => Pair::nearest(w + 0.5, self.volumes.layers),
        };
        let (along_u, along_v) = (Pair::linear(u, resolution), Pair::linear(v, resolution));
        let side = resolution as usize;
        let mut voxels = [(0, 0.0); 8];
        for (corner, voxel) in voxels.iter_mut().enumerate() {
            let (layer, layer_weight) = across.term(corner >> 2);
            let (row, row_weight) = along_v.term(corner >> 1 & 1);
            let (column, column_weight) = along_u.term(corner & 1);
            *voxel = (
                self.first + (layer * side + row) * side + column,
                layer_weight * row_weight * column_weight,
            );
        }
        voxels
    }

    /// ρ and shade at (u, v, w).
    pub fn at(&self, place: [f64; 3]) -> VolumePoint {
        let (mut rho, mut rho_shade) = (0.0, 0.0);
        for (voxel, weight) in self.around(place) {
            let [density, shaded] = self.volumes.voxels[voxel];
            rho += weight * f64::from(density);
            rho_shade += weight * f64::from(shaded);
        }
        VolumePoint {
            rho: rho / 255.0 * fade(place[1], f64::from(self.volumes.root_blend)),
            shade: if rho > 0.0 { rho_shade / rho } else { 1.0 },
        }
    }

    /// ∂ρ/∂u, ∂ρ/∂v and ∂ρ/∂w at (u, v, w), without the fade towards the root: central differences, a voxel to each
    /// side along u and v, a layer to each side along w; beyond the volume its border goes on.
    pub fn slopes(&self, place: [f64; 3]) -> DVec3 {
        let rho = |place| -> f64 {
            let weighted =
                |(voxel, weight): (usize, f64)| weight * f64::from(self.volumes.voxels[voxel][0]);
            self.around(place).map(weighted).iter().sum::<f64>() / 255.0
        };
        let side = self.volumes.resolution;
        let along = |axis: usize, count: u32| {
            let step = 1.0 / f64::from(count);
            let (mut ahead, mut behind) = (place, place);
            ahead[axis] += step;
            behind[axis] -= step;
            (rho(ahead) - rho(behind)) / (2.0 * step)
        };
        DVec3::new(
            along(0, side),
            along(1, side),
            along(2, self.volumes.layers),
        )
    }

    /// The fibre's direction at (u, v, w) in the coordinates (u, v, w), not normalised: the main axis of the mean ttᵀ.
    pub fn tangent(&self, place: [f64; 3]) -> DVec3 {
        let mut sums = [0.0; 6];
        for (voxel, weight) in self.around(place) {
            for (sum, value) in sums.iter_mut().zip(self.volumes.tangents[voxel]) {
                *sum += weight * f64::from(value);
            }
        }
        let [xx, yy, zz, xy, xz, yz] = sums;
        let tensor = DMat3::from_cols(
            DVec3::new(xx, xy, xz),
            DVec3::new(xy, yy, yz),
            DVec3::new(xz, yz, zz),
        );
        main_axis(tensor) / DVec3::from_array(self.volumes.reference_size_mm.map(f64::from))
    }
}

/// Share of the density that a loop has at height `v` above its root.
fn fade(v: f64, root_blend: f64) -> f64 {
    if root_blend <= 0.0 {
        return 1.0;
    }
    let x = (v / root_blend).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
