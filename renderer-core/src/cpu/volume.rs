//! Densities inside loops (MODEL.md §5), a byte each and all layers of a place together: so small, and what a look needs
//! so near to each other, that looks seldom wait for memory.

use glam::{DMat3, DVec3};

use super::lanes::{LANES, Lanes};
use crate::design::Interpolation;
use crate::geometry::main_axis;
use crate::scene::{LoopLook, PileOptics, Section, Volumes};

/// All volumes of a scene.
#[derive(Debug)]
pub(super) struct VoxelTable {
    /// ρ of the voxels, 255 = 1: of a volume by rows along v, columns along u and layers along w, which are next to each
    /// other; then as many zeros as a look from the last voxel reaches beyond it.
    rho: Vec<u8>,
    /// Of sparse volumes, for each and each (l, b, a) from 0 to layers, side and side: how many of the voxels before it
    /// along all three axes are not empty. Nobody looks where others are empty.
    full_before: Vec<u32>,
    /// Voxels along u and along v.
    side: usize,
    layers: usize,
    /// Voxels of a volume.
    volume_size: usize,
    linear: bool,
    /// Share of the loop, from its root, over which density fades in.
    root_blend: f32,
    /// For each material: its first volume, and extinction of solid yarn, 1/mm.
    materials: Vec<(usize, f32)>,
    /// Shade and directions of fibres, which are read only where a ray ends.
    volumes: Section<Volumes>,
}

/// The volume of one loop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Yarn<'a> {
    table: &'a VoxelTable,
    volume: usize,
    /// Index of the volume's first voxel.
    first: usize,
    /// Extinction where ρ = 1, 1/mm.
    pub density: f32,
}

impl VoxelTable {
    pub fn new(volumes: &Section<Volumes>, pile: &PileOptics) -> Self {
        let (side, layers) = (volumes.resolution as usize, volumes.layers as usize);
        let volume_size = layers * side * side;
        let rho = |index: usize| {
            let (place, layer) = (index % volume_size / layers, index % layers);
            volumes.voxels[index / volume_size * volume_size + layer * side * side + place][0]
        };
        let voxels = 0..volumes.voxels.len();
        let reach = (side + 1) * layers + 1;
        let looked_into = match is_sparse(&volumes.voxels) {
            true => &volumes.voxels[..],
            false => &[],
        };
        Self {
            rho: voxels.map(rho).chain(vec![0; reach]).collect(),
            full_before: (looked_into.chunks(volume_size))
                .flat_map(|voxels| full_before(voxels, [side, side, layers]))
                .collect(),
            side,
            layers,
            volume_size,
            linear: volumes.interpolation == Interpolation::Linear,
            root_blend: volumes.root_blend,
            materials: (pile.materials.iter())
                .map(|material| {
                    let first = (material.kind * volumes.variants) as usize;
                    (first, material.density_per_mm)
                })
                .collect(),
            volumes: volumes.clone(),
        }
    }

    /// The volume of a loop that looks like `look`.
    #[inline(always)]
    pub fn yarn(&self, look: LoopLook) -> Yarn<'_> {
        let (first, density) = self.materials[usize::from(look.material)];
        let volume = first + usize::from(look.variant);
        Yarn {
            table: self,
            volume,
            first: volume * self.volume_size,
            density,
        }
    }

    /// A voxel, the one beside it along w, and these two of the next column, a byte each.
    #[inline(always)]
    fn square(&self, voxel: usize) -> u32 {
        let rho = &self.rho[voxel..voxel + self.layers + 2];
        let [a, b] = [rho[0], rho[1]];
        let [c, d] = [rho[self.layers], rho[self.layers + 1]];
        u32::from_le_bytes([a, b, c, d])
    }

    /// Whether long ways through a loop's frame are mostly air, and it may be asked where.
    pub fn is_sparse(&self) -> bool {
        !self.full_before.is_empty()
    }

    pub fn layers(&self) -> usize {
        self.layers
    }

    /// Bytes of the voxels.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.rho) + size_of_val(&*self.full_before)) as u64
    }
}

/// Between the four voxels of eight [`VoxelTable::square`]s.
#[inline(always)]
fn in_square<L: Lanes>(squares: &[u32; LANES], up: L, right: L) -> L {
    let words = L::load_words(squares);
    let (a, b) = (L::field(words, 0, 255), L::field(words, 8, 255));
    let (c, d) = (L::field(words, 16, 255), L::field(words, 24, 255));
    let (here, beside) = (a + up * (b - a), c + up * (d - c));
    here + right * (beside - here)
}

/// Less than a tenth of the voxels of fur and grass are not empty, but 0.2 of those of shag and more of terry's.
fn is_sparse(voxels: &[[u8; 2]]) -> bool {
    let full = voxels.iter().filter(|voxel| voxel[0] > 0).count();
    10 * full < voxels.len()
}

/// [`VoxelTable::full_before`] of a volume: its voxels summed up along each axis in turn.
fn full_before(voxels: &[[u8; 2]], [columns, rows, layers]: [usize; 3]) -> Vec<u32> {
    let strides = [1, columns + 1, (columns + 1) * (rows + 1)];
    let mut sums = vec![0; strides[2] * (layers + 1)];
    for (index, voxel) in voxels.iter().enumerate() {
        let (a, b, layer) = (
            index % columns,
            index / columns % rows,
            index / (columns * rows),
        );
        let place = (layer + 1) * strides[2] + (b + 1) * strides[1] + a + 1;
        sums[place] = u32::from(voxel[0] > 0);
    }
    for (stride, count) in strides.into_iter().zip([columns, rows, layers]) {
        for place in stride..sums.len() {
            // Zeros stand before the first along each axis.
            if place / stride % (count + 1) != 0 {
                sums[place] += sums[place - stride];
            }
        }
    }
    sums
}

impl Yarn<'_> {
    /// Whether ρ is 0 everywhere from the lowest to the highest u, v and w, of a sparse volume.
    #[inline(always)]
    pub fn is_empty(&self, u: [f32; 2], v: [f32; 2], w: [f32; 2]) -> bool {
        let table = self.table;
        // The voxels that a look within the range blends.
        let range = |[low, high]: [f32; 2], count: usize, blends: bool| {
            let place = |x: f32| {
                let x = x * count as f32 - if blends { 0.5 } else { 0.0 };
                (x.max(0.0) as usize).min(count - 1)
            };
            [
                place(low),
                (place(high) + usize::from(blends)).min(count - 1) + 1,
            ]
        };
        let [a0, a1] = range(u, table.side, true);
        let [b0, b1] = range(v, table.side, true);
        let [l0, l1] = range([w[0] + 0.5, w[1] + 0.5], table.layers, table.linear);
        let across = table.side + 1;
        let first = self.volume * (table.layers + 1) * across * across;
        let before =
            |l: usize, b: usize, a: usize| table.full_before[first + (l * across + b) * across + a];
        let row = |l: usize, b: usize| before(l, b, a1) - before(l, b, a0);
        let layer = |l: usize| row(l, b1) - row(l, b0);
        layer(l1) == layer(l0)
    }

    /// ρ at (u, v, w), faded out towards the root.
    #[inline(always)]
    pub fn rho<L: Lanes>(&self, place: [f32; 3]) -> f32 {
        self.unfaded_rho::<L>(place) * self.fade(place[1])
    }

    /// ρ at (u, v, w), without the fade.
    #[inline(always)]
    fn unfaded_rho<L: Lanes>(&self, [u, v, w]: [f32; 3]) -> f32 {
        let table = self.table;
        let (side, layers) = (table.side as f32, table.layers as f32);
        let x = (u * side - 0.5).clamp(0.0, side - 1.0);
        let y = (v * side - 0.5).clamp(0.0, side - 1.0);
        let z = if table.linear {
            ((w + 0.5) * layers - 0.5).clamp(0.0, layers - 1.0)
        } else {
            ((w + 0.5) * layers).clamp(0.0, layers - 1.0).trunc()
        };
        let (column, row, layer) = (x as u32, y as u32, z as u32);
        let place = (row as usize * table.side + column as usize) * table.layers;
        let voxel = self.first + place + layer as usize;
        // Beyond the last row, column or layer it looks at what is not there, which has no share.
        let corners = |from: usize| {
            let pair = |from: usize| [table.rho[from], table.rho[from + 1]];
            let ([a, b], [c, d]) = (pair(from), pair(from + table.layers));
            [a, b, c, d]
        };
        let ([a, b, c, d], [e, f, g, h]) =
            (corners(voxel), corners(voxel + table.side * table.layers));
        let corners = [a, b, c, d, e, f, g, h];
        // Many looks are into air.
        if corners == [0; LANES] {
            return 0.0;
        }
        // Of each corner, its share along an axis: 1 − x of those that are not ahead, x of those that are.
        let share = |x: f32, ahead: [f32; LANES]| {
            let ahead = L::load(&ahead);
            let one = L::splat(1.0);
            (one - ahead) + (ahead + ahead - one) * L::splat(x)
        };
        let weights = share(z - layer as f32, [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0])
            * share(x - column as f32, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])
            * share(y - row as f32, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        (weights * L::bytes(corners)).sum() * (1.0 / 255.0)
    }

    /// ρ at eight places (u, v, w), faded out towards the root; a loop's borders go on beyond it.
    #[inline(always)]
    pub fn rhos<L: Lanes>(&self, [u, v, w]: [L; 3]) -> L {
        let table = self.table;
        let (zero, half, one) = (L::splat(0.0), L::splat(0.5), L::splat(1.0));
        let (side, layers) = (L::splat(table.side as f32), L::splat(table.layers as f32));
        let x = (u * side - half).max(zero).min(side - one);
        let y = (v * side - half).max(zero).min(side - one);
        let z = (w + half) * layers - if table.linear { half } else { zero };
        let z = z.max(zero).min(layers - one);
        let ((column, _), (row, _), (layer, _)) = (x.whole(), y.whole(), z.whole());
        let (_, voxels) = ((row * side + column) * layers + layer).whole();
        let next_row = table.side * table.layers;
        let (mut near, mut far) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            let voxel = self.first + voxels[lane] as usize;
            near[lane] = table.square(voxel);
            far[lane] = table.square(voxel + next_row);
        }
        let up = if table.linear { z - layer } else { zero };
        let (right, ahead) = (x - column, y - row);
        let near = in_square::<L>(&near, up, right);
        let rho = near + ahead * (in_square::<L>(&far, up, right) - near);
        let rho = rho * L::splat(1.0 / 255.0);
        let blend = table.root_blend;
        if blend <= 0.0 {
            return rho;
        }
        let x = (v * L::splat(1.0 / blend)).max(zero).min(one);
        rho * x * x * (L::splat(3.0) - x - x)
    }

    /// Share of the density that a loop has at height `v` above its root.
    #[inline(always)]
    fn fade(&self, v: f32) -> f32 {
        let blend = self.table.root_blend;
        if v >= blend {
            return 1.0;
        }
        let x = (v / blend).max(0.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// The eight voxels around (u, v, w), with their weights.
    fn around(&self, [u, v, w]: [f32; 3]) -> [(usize, f32); 8] {
        let table = self.table;
        let pair = |place: f32, count: usize| {
            let x = (place * count as f32 - 0.5).clamp(0.0, (count - 1) as f32);
            let near = x as usize;
            let share = x - near as f32;
            [(near, 1.0 - share), ((near + 1).min(count - 1), share)]
        };
        let nearest = |place: f32, count: usize| {
            let index = ((place * count as f32) as usize).min(count - 1);
            [(index, 1.0), (index, 0.0)]
        };
        let across = match table.linear {
            true => pair(w + 0.5, table.layers),
            false => nearest(w + 0.5, table.layers),
        };
        let (columns, rows) = (pair(u, table.side), pair(v, table.side));
        // Not `map`, which is not inlined.
        let mut around = [(0, 0.0); 8];
        for (corner, voxel) in around.iter_mut().enumerate() {
            let (layer, layer_weight) = across[corner >> 2];
            let (row, row_weight) = rows[corner >> 1 & 1];
            let (column, column_weight) = columns[corner & 1];
            let index = self.first + (layer * table.side + row) * table.side + column;
            *voxel = (index, layer_weight * row_weight * column_weight);
        }
        around
    }

    /// Factor on the albedo at (u, v, w); 1 where nothing is.
    pub fn shade(&self, place: [f32; 3]) -> f32 {
        let (mut rho, mut shaded) = (0.0, 0.0);
        for (voxel, weight) in self.around(place) {
            let [density, shade] = self.table.volumes.voxels[voxel];
            rho += weight * f32::from(density);
            shaded += weight * f32::from(shade);
        }
        if rho > 0.0 { shaded / rho } else { 1.0 }
    }

    /// ∂ρ/∂u, ∂ρ/∂v and ∂ρ/∂w at (u, v, w), without the fade: central differences, a voxel to each side along u and v,
    /// a layer to each side along w; beyond the volume its border goes on.
    #[inline(always)]
    pub fn slopes<L: Lanes>(&self, place: [f32; 3]) -> DVec3 {
        let table = self.table;
        let mut slopes = DVec3::ZERO;
        // A loop, and no closure: see `wide`.
        for (axis, count) in [table.side, table.side, table.layers]
            .into_iter()
            .enumerate()
        {
            let step = 1.0 / count as f32;
            let mut rise = 0.0;
            for step in [step, -step] {
                let mut beside = place;
                beside[axis] += step;
                rise += self.unfaded_rho::<L>(beside) * step.signum();
            }
            slopes[axis] = f64::from(rise / (2.0 * step));
        }
        slopes
    }

    /// The fibre's direction at (u, v, w) in the coordinates (u, v, w), not normalised: the main axis of the mean ttᵀ.
    pub fn tangent(&self, place: [f32; 3]) -> DVec3 {
        let volumes = &self.table.volumes;
        let mut sums = [0.0; 6];
        for (voxel, weight) in self.around(place) {
            for (sum, value) in sums.iter_mut().zip(volumes.tangents[voxel]) {
                *sum += f64::from(weight) * f64::from(value);
            }
        }
        let [xx, yy, zz, xy, xz, yz] = sums;
        let tensor = DMat3::from_cols(
            DVec3::new(xx, xy, xz),
            DVec3::new(xy, yy, yz),
            DVec3::new(xz, yz, zz),
        );
        main_axis(tensor) / DVec3::from_array(volumes.reference_size_mm.map(f64::from))
    }
}
