//! LOD regions: the part of a large cloth that one picture shows, made as fine as the picture shows it. So cloth has no
//! end, and a scene is as large as its picture, not as the cloth.
//!
//! A cloth seen from far away is drawn at LOD n: with 2ⁿ times fewer loops along each side, each the copy of a real one
//! out of its 2ⁿ × 2ⁿ neighbours, in the mean of their colours, and 2ⁿ times as large in every direction. Light goes
//! through pile that is grown evenly as it goes through the pile itself, since extinction times length stays what it
//! is: the mean radiance of a pixel that covers many loops is the same from every side and under every light, which it
//! is not if densities are averaged (what passes between two loops does not pass through their mean). What changes is
//! the texture below a pixel, and the noise that is left of it; and light that is lost between loops of unlike colours
//! is not lost where these are mixed. In place of growing the loops, the world shrinks: the region's scene has the
//! cloth's own loops, volumes and ground weave, and its camera stands 2ⁿ times as near.
//!
//! Level cloth only. Lengths in mm.

use glam::DVec3;

use crate::design::{Design, Pattern};
use crate::geometry::{Camera, Projection};
use crate::sampling::hash_with;
use crate::scene::SheetGeometry;

/// Shortest waves of the texture of cloth at LOD 1 and beyond, in its loops, that keep their size in the cloth: some
/// pixels.
const SEEN_WAVE: f64 = 16.0;

/// Height of the tips of the pile, as a share of its length: it leans. Views along the cloth see little else of it, and
/// levels whose tips lie elsewhere would draw twice what a chart draws, side by side.
const TIPS: f64 = 0.8;

/// Cells along each side, out of all that a cell at some LOD covers, whose colours are mixed.
pub const SPREAD: u32 = 4;

/// A rectangle of the cells of a cloth at one level of detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LodRegion {
    /// Warps and wefts of the whole cloth at LOD 0.
    pub whole: [u32; 2],
    /// LOD n: each of its loops stands for 2ⁿ × 2ⁿ.
    pub lod: u32,
    /// First warp and weft of the region, counted at this LOD.
    pub first: [u32; 2],
    /// How many warps and wefts it has.
    pub cells: [u32; 2],
}

impl LodRegion {
    /// Cells that a cloth may have to be made whole, so that no camera asks for another scene.
    pub const WHOLE_CELLS: f64 = 4e6;

    /// Whether cloth is made in regions.
    pub fn is_needed(design: &Design) -> bool {
        let [warps, wefts] = [design.sheet.warps, design.sheet.wefts].map(f64::from);
        warps * wefts > Self::WHOLE_CELLS && design.has_parts()
    }

    /// Warps and wefts of a cloth at some LOD; what cannot be halved is rounded up.
    pub fn cells_at(whole: [u32; 2], lod: u32) -> [u32; 2] {
        whole.map(|cells| cells.div_ceil(1 << lod))
    }

    /// Size of the region's world in that of the cloth: 2⁻ⁿ.
    pub fn scale(&self) -> f64 {
        0.5_f64.powi(self.lod as i32)
    }

    /// Number of cells.
    pub fn len(&self) -> u64 {
        u64::from(self.cells[0]) * u64::from(self.cells[1])
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether it has all cells of another at the same LOD.
    pub fn holds(&self, other: &Self) -> bool {
        (self.whole, self.lod) == (other.whole, other.lod)
            && [0, 1].iter().all(|&axis| {
                self.first[axis] <= other.first[axis]
                    && self.first[axis] + self.cells[axis] >= other.first[axis] + other.cells[axis]
            })
    }

    /// The cell of the whole cloth whose loops stand in cell (i, j) of the region: one of those that it covers, by
    /// chance, so that lengths and kinds keep their shares.
    pub fn original(&self, i: usize, j: usize) -> [usize; 2] {
        let (hash, side) = (self.hash(i, j), 1_u32 << self.lod);
        self.within(i, j, [0, 1].map(|axis| hash_with(hash, axis) & (side - 1)))
    }

    /// Cells of the whole cloth spread over all those that cell (i, j) covers: all of them, or one out of each of
    /// sixteen equal parts.
    pub fn spread_originals(&self, i: usize, j: usize) -> impl Iterator<Item = [usize; 2]> {
        let (hash, side) = (self.hash(i, j), 1_u32 << self.lod);
        let parts = side.min(SPREAD);
        let part_side = side / parts;
        (0..parts * parts).map(move |part| {
            let corner = [part % parts, part / parts];
            let within = [0, 1].map(|axis| {
                let by_chance = hash_with(hash, 2 + 2 * part + axis as u32) & (part_side - 1);
                corner[axis] * part_side + by_chance
            });
            self.within(i, j, within)
        })
    }

    /// Random bits of a cell.
    fn hash(&self, i: usize, j: usize) -> u32 {
        let [x, y] = [self.first[0] + i as u32, self.first[1] + j as u32];
        hash_with(hash_with(hash_with(self.lod, 0xe7), x), y)
    }

    /// The cell at a place among those that cell (i, j) covers.
    fn within(&self, i: usize, j: usize, place: [u32; 2]) -> [usize; 2] {
        let cell_at_lod = [self.first[0] as usize + i, self.first[1] as usize + j];
        [0, 1].map(|axis| {
            let cell = (cell_at_lod[axis] << self.lod) + place[axis] as usize;
            cell.min(self.whole[axis] as usize - 1)
        })
    }

    /// The design of the region: what belongs to the cloth, and not to its yarn, shrinks with the world. Chart and nap
    /// map stay those of the whole cloth: their cells are [`Self::original`]. Area lights are moved by
    /// [`Self::region_from_world`].
    pub(in crate::scene) fn design(&self, whole: &Design) -> Design {
        let mut design = whole.clone();
        [design.sheet.warps, design.sheet.wefts] = self.cells;
        design.weave.pattern = self.pattern(&whole.weave.pattern);
        design.turbulence.frequency =
            1.0 / self.texture_mm(whole, 1.0 / whole.turbulence.frequency);
        design.finish.clump_size = self.texture_mm(whole, whole.finish.clump_size);
        design
    }

    /// How long waves of the cloth's texture are that have this length in the cloth, mm. Waves that can be seen keep
    /// their size in the cloth. Shorter ones keep theirs in loops: how alike neighbours lie decides how bright pile is
    /// (a tenth, where waves of five loops shrink to two).
    fn texture_mm(&self, design: &Design, mm: f64) -> f64 {
        let pitch = design.sheet.pitch_x().max(design.sheet.pitch_y());
        (mm * self.scale()).max(mm.min(SEEN_WAVE * pitch))
    }

    /// The stitch pattern as it begins at the region's first cell. Repeats that a cell at this LOD covers are drawn as
    /// large as the loops; of larger ones every 2ⁿth stitch is left, so that what the pattern draws keeps its size.
    fn pattern(&self, whole: &Pattern) -> Pattern {
        let side = 1_usize << self.lod;
        let period = |repeat: usize| {
            if repeat <= 2 * side {
                (repeat, 1)
            } else {
                (repeat / common_divisor(repeat, side), side)
            }
        };
        let [(cols, across), (rows, along)] = [whole.cols(), whole.rows()].map(period);
        let stitch = |index: usize, axis: usize, step: usize| {
            ((index + self.first[axis] as usize) * step + step / 2) as i64
        };
        Pattern::from_fn(cols, rows, |col, row| {
            whole.at(stitch(col, 0, across), stitch(row, 1, along))
        })
    }

    /// Where the region's world has a point of the cloth's: a similarity that keeps the height `still_mm`.
    pub fn region_from_world(&self, design: &Design, point: DVec3, still_mm: f64) -> DVec3 {
        let pitch = [design.sheet.pitch_x(), design.sheet.pitch_y()];
        let of_axis = |axis: usize| {
            let from_low = point[axis] + 0.5 * f64::from(self.whole[axis]) * pitch[axis];
            let middle = f64::from(self.first[axis]) + 0.5 * f64::from(self.cells[axis]);
            from_low * self.scale() - middle * pitch[axis]
        };
        let z = (point.z - still_mm) * self.scale() + still_mm;
        DVec3::new(of_axis(0), of_axis(1), z)
    }

    /// The camera that sees in the region's scene what `camera` sees of the cloth. The tips of the pile on its side of
    /// the cloth stay where they are in the picture.
    pub fn camera(&self, design: &Design, camera: &Camera) -> Camera {
        let tips_mm = TIPS * design.length.longest().min(design.pile.max_length);
        let eye = self.region_from_world(design, camera.eye, tips_mm.copysign(camera.eye.z));
        let projection = match camera.projection {
            Projection::Orthographic { height_mm } => Projection::Orthographic {
                height_mm: height_mm * self.scale(),
            },
            perspective @ Projection::Perspective { .. } => perspective,
        };
        Camera {
            eye,
            projection,
            ..*camera
        }
    }
}

fn common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

impl SheetGeometry {
    /// Warps and wefts of the cloth that this sheet is a region of, or its own.
    pub fn whole_cells(&self) -> [u32; 2] {
        self.region
            .map_or([self.warps, self.wefts], |region| region.whole)
    }

    /// Lengths in that cloth's world as a multiple of those in this sheet's.
    pub fn cloth_scale(&self) -> f64 {
        self.region.map_or(1.0, |region| 1.0 / region.scale())
    }

    /// The cell of the whole cloth whose loops stand in a cell.
    pub fn original(&self, i: usize, j: usize) -> [usize; 2] {
        match &self.region {
            Some(region) => region.original(i, j),
            None => [i, j],
        }
    }

    /// From the low corner of the cloth, at this LOD, to the middle of a cell, mm.
    pub(in crate::scene) fn place_mm(&self, i: usize, j: usize) -> [f64; 2] {
        let [x, y] = self.region.map_or([0; 2], |region| region.first);
        [
            (f64::from(x) + i as f64 + 0.5) * self.pitch_x_mm,
            (f64::from(y) + j as f64 + 0.5) * self.pitch_y_mm,
        ]
    }
}
