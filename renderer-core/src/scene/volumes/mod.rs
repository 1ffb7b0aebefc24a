//! The voxels inside a yarn loop (MODEL.md §5; the paper's §5.2 and figure 10).
//!
//! A kind of pile is a [`Field`]: density, shade and fibre direction at any point of the reference loop, in mm (x along
//! u, y along v from the root, z along the thickness). [`rasterise`] averages the field over each voxel and adds stray
//! fibres. Loops of another length or width stretch the reference loop.

mod cut;
mod fur;
mod grass;
mod hair;
mod strand;
mod terry;
mod twisted;

use glam::DVec3;
use rayon::prelude::*;

use super::{Cancel, Volumes};
use crate::design::{Phase, Pile, PileKind};
use crate::sampling::{Pcg, hash_with};
use hair::Hair;

/// Points averaged along each axis of a voxel. Two are enough: fields fall off over about a voxel's width.
const SUPERSAMPLES: usize = 2;

/// Share of the yarn's diameter left free around the yarn inside its patch, for stray fibres.
const MARGIN: f64 = 0.12;

/// How much less of its light yarn gives back between fibres. Small: a hundredth is as much as white cotton absorbs at
/// one scattering, and light scatters dozens of times.
const GROOVE_SHADE: f64 = 0.01;

/// Size of the reference loop, mm.
#[derive(Debug, Clone, Copy)]
struct LoopSize {
    width: f64,
    length: f64,
    thickness: f64,
}

/// What the yarn is like at a point.
#[derive(Debug, Clone, Copy, Default)]
struct Yarn {
    /// ρ in [0, 1].
    density: f64,
    /// Multiplies the albedo.
    shade: f64,
    /// Unit vector along the fibres, mm space.
    tangent: DVec3,
}

/// A kind of pile: the yarn at every point of the reference loop.
trait Field: Sync {
    /// The yarn at `point`, mm from the middle of the root.
    fn yarn(&self, point: DVec3) -> Yarn;

    /// A random point on the yarn's surface with the outward normal and the yarn's direction there: where a stray
    /// fibre leaves it.
    fn surface(&self, random: &mut Pcg) -> (DVec3, DVec3, DVec3);
}

/// Voxels for the given kinds of pile, `pile.variants` of each, of yarn of `pile.yarn_diameter`.
///
/// `reference_length_mm` is the length of the loop that the volumes are drawn for; anything above zero.
pub fn rasterise(pile: &Pile, kinds: &[PileKind], reference_length_mm: f64) -> Volumes {
    let yarns: Vec<(PileKind, f64)> = kinds
        .iter()
        .map(|&kind| (kind, pile.yarn_diameter))
        .collect();
    rasterise_unless_cancelled(pile, &yarns, reference_length_mm, &Cancel::never())
}

/// Voxels for kinds of pile that have a diameter of their yarn each, mm, `pile.variants` of each kind; not whole if
/// `cancel` says so afterwards. `reference_length_mm` is the length of the loop that they are drawn for.
pub(super) fn rasterise_unless_cancelled(
    pile: &Pile,
    yarns: &[(PileKind, f64)],
    reference_length_mm: f64,
    cancel: &Cancel<'_>,
) -> Volumes {
    let size = LoopSize {
        width: pile.base_width,
        length: reference_length_mm.max(0.05),
        thickness: pile.thickness,
    };
    let with_tangents = pile.phase == Phase::KajiyaKay;
    let piles: Vec<(PileKind, Pile)> = yarns
        .iter()
        .map(|&(kind, yarn_diameter)| {
            let pile = Pile {
                yarn_diameter,
                ..pile.clone()
            };
            (kind, pile)
        })
        .collect();
    let volumes: Vec<(&(PileKind, Pile), u32)> = piles
        .iter()
        .flat_map(|pile| (0..pile.1.variants).map(move |variant| (pile, variant)))
        .collect();
    let cells: Vec<Vec<Cell>> = volumes
        .par_iter()
        .map(|&((kind, pile), variant)| match kind {
            PileKind::Terry => volume(terry::terry, pile, size, variant, cancel),
            PileKind::Twisted => volume(twisted::twisted, pile, size, variant, cancel),
            PileKind::Cut => volume(cut::Cut::new, pile, size, variant, cancel),
            PileKind::Fur => volume(fur::Fur::new, pile, size, variant, cancel),
            PileKind::Grass => volume(grass::Grass::new, pile, size, variant, cancel),
        })
        .collect();
    let cells = || cells.iter().flatten();
    Volumes {
        resolution: pile.resolution,
        layers: pile.layers,
        variants: pile.variants,
        kinds: yarns.iter().map(|&(kind, _)| kind).collect(),
        interpolation: pile.interpolation,
        root_blend: pile.root_blend as f32,
        voxels: cells().map(Cell::voxel).collect(),
        tangents: if with_tangents {
            cells().map(Cell::tangent).collect()
        } else {
            Vec::new()
        },
        reference_size_mm: [size.width as f32, size.length as f32, size.thickness as f32],
    }
}

/// Sums over one voxel.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    density: f64,
    shaded: f64,
    /// xx, yy, zz, xy, xz, yz of Σ ρ·ttᵀ.
    directions: [f64; 6],
}

impl Cell {
    /// Adds yarn with the given weight, up to solid: denser than that fibres cannot be packed.
    fn add(&mut self, yarn: Yarn, weight: f64) {
        let density = (yarn.density * weight).min(1.0 - self.density);
        let t = yarn.tangent;
        self.density += density;
        self.shaded += density * yarn.shade;
        let products = [
            t.x * t.x,
            t.y * t.y,
            t.z * t.z,
            t.x * t.y,
            t.x * t.z,
            t.y * t.z,
        ];
        for (sum, product) in self.directions.iter_mut().zip(products) {
            *sum += density * product;
        }
    }

    fn voxel(&self) -> [u8; 2] {
        [self.density, self.shaded].map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
    }

    fn tangent(&self) -> [i8; 8] {
        let mut packed = [0; 8];
        for (byte, value) in packed.iter_mut().zip(self.directions) {
            *byte = (value.clamp(-1.0, 1.0) * 127.0).round() as i8;
        }
        packed
    }
}

/// All voxels of one loop: u fastest, then v, then layers.
fn volume<F: Field>(
    field: impl Fn(&Pile, LoopSize, u32) -> F,
    pile: &Pile,
    size: LoopSize,
    variant: u32,
    cancel: &Cancel<'_>,
) -> Vec<Cell> {
    let field = field(pile, size, variant);
    let (resolution, layers) = (pile.resolution as usize, pile.layers as usize);
    let mut cells = vec![Cell::default(); layers * resolution * resolution];
    let share = 1.0 / (SUPERSAMPLES * SUPERSAMPLES * SUPERSAMPLES) as f64;
    let middle = |index: usize, sub: usize, count: usize| {
        (index as f64 + (sub as f64 + 0.5) / SUPERSAMPLES as f64) / count as f64
    };
    cells
        .par_chunks_mut(resolution)
        .enumerate()
        .for_each(|(row, cells)| {
            if cancel.is_cancelled() {
                return;
            }
            let (layer, b) = (row / resolution, row % resolution);
            for (a, cell) in cells.iter_mut().enumerate() {
                for sub in 0..SUPERSAMPLES.pow(3) {
                    let (su, sv, sw) = (
                        sub % SUPERSAMPLES,
                        sub / SUPERSAMPLES % SUPERSAMPLES,
                        sub / SUPERSAMPLES.pow(2),
                    );
                    let point = DVec3::new(
                        (middle(a, su, resolution) - 0.5) * size.width,
                        middle(b, sv, resolution) * size.length,
                        (middle(layer, sw, layers) - 0.5) * size.thickness,
                    );
                    cell.add(field.yarn(point), share);
                }
            }
        });
    if !cancel.is_cancelled() {
        Hair::new(pile, size, variant).draw(&field, &mut cells);
    }
    cells
}

/// The random generator of one variant for one purpose.
fn variant_random(variant: u32, purpose: u32) -> Pcg {
    Pcg::new(hash_with(0x70e1, purpose), variant)
}

/// A random number in [−1, 1).
fn signed(random: &mut Pcg) -> f64 {
    2.0 * f64::from(random.next_float()) - 1.0
}

/// 1 inside, 0 outside, smooth over the outer part of a round yarn: `radius` is 1 at its surface.
fn falloff(radius: f64) -> f64 {
    const SOLID: f64 = 0.75;
    let x = ((1.0 - radius) / (1.0 - SOLID)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
