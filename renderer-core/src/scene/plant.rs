//! Where loops stand, and their frames: from pattern, lengths and turbulence to the loops that the grid then bins
//! (MODEL.md §2 and §4).

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::box_of;
use super::faces::Faces;
use super::finish::Finishing;
use super::frames::{FrameRules, FrameSettings, Jitter, LoopInput, loop_hash, loop_shape};
use super::grid::{Planted, WholePile};
use super::length::Cells;
use super::skeleton::{Face, RootHeights};
use super::turbulence::{TurbulenceField, Wanted};
use super::{Cancel, CellSet, LoopCounts, LoopPatch, SheetGeometry, VisibleCells};
use crate::design::{Turbulence, Weave};

/// Everything that the loops' shapes follow from.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoopsInputs {
    pub(super) sheet: SheetGeometry,
    pub(super) weave: Weave,
    pub(super) roots: RootHeights,
    pub(super) cells: Cells,
    pub(super) frames: FrameRules,
    pub(super) finishing: Finishing,
    pub(super) turbulence: Turbulence,
}

/// Which frames are computed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Frames<'a> {
    /// Those of the loops that stand in these cells.
    Of(&'a CellSet),
    /// Those of the loops that stand in these cells, to keep the loops that reach visible cells.
    Visible(&'a CellSet, &'a VisibleCells),
}

/// Loops of one weft.
#[derive(Default)]
struct Row {
    patches: Vec<LoopPatch>,
    warps: Vec<u32>,
    counts: LoopCounts,
    frames_made: u64,
}

impl Row {
    fn with_room_for(loops: usize) -> Self {
        Self {
            patches: Vec::with_capacity(loops),
            warps: Vec::with_capacity(loops),
            ..Self::default()
        }
    }
}

impl LoopsInputs {
    /// The cells in which a loop stands.
    pub(super) fn standing(&self) -> CellSet {
        let (warps, wefts) = (self.sheet.warps as usize, self.sheet.wefts as usize);
        let faces = self.faces();
        CellSet::from_fn(warps, wefts, |i, j| {
            faces.at(i, j) != [false; 2] && self.cells.length_mm(j * warps + i) > 0.0
        })
    }

    /// How many loops stand in these cells.
    pub(super) fn loops_in(&self, cells: &CellSet) -> u64 {
        let faces = self.faces();
        let of_row = |j: usize| {
            cells
                .row(j)
                .map(|i| u64::from(faces.count_at(i, j)))
                .sum::<u64>()
        };
        (0..cells.wefts()).into_par_iter().map(of_row).sum()
    }

    /// What the grid has to know of the whole pile, which stands in these cells; the turbulence has those of
    /// [`Self::sampled`].
    pub(super) fn whole_pile(&self, turbulence: &TurbulenceField, standing: &CellSet) -> WholePile {
        let ([low, high], step) = self.roots.range();
        let longest = self
            .frames
            .longest_mm(self.cells.longest_mm(), &self.finishing);
        let half_top = self.frames.half_top_mm(step);
        let largest = longest.max(half_top).max(high).max(-low);
        let (cells, faces) = (Self::sampled(standing), self.faces());
        let samples = (0..cells.wefts()).into_par_iter().flat_map_iter(|j| {
            let Row { patches, warps, .. } = self.row(turbulence, &faces, &cells, None, j);
            let cells = warps.into_iter().map(move |i| [i, j as u32]);
            cells.zip(patches)
        });
        WholePile {
            // Patches are stored as f32.
            largest_mm: largest * (1.0 + f64::from(f32::EPSILON)),
            loops: self.loops_in(standing),
            samples: samples.collect(),
        }
    }

    /// Some cells from all over the sheet, to choose the size of blocks by.
    pub(super) fn sampled(standing: &CellSet) -> CellSet {
        /// Enough to know the mean length of lists to a few per cent.
        const SAMPLES: usize = 4096;
        standing.every(standing.len() / SAMPLES + 1)
    }

    /// What frames in these cells need of the turbulence: channels that move nothing are not needed.
    pub(super) fn wanted(&self, frames: Frames<'_>, standing: &CellSet) -> Wanted {
        let settings = self.frames.common();
        let tilts = self.frames.all().iter().any(|row| row.tilt != 0.0);
        let (Frames::Of(cells) | Frames::Visible(cells, _)) = frames;
        Wanted {
            cells: cells.clone().or(&Self::sampled(standing)),
            channels: [tilts, tilts, settings.stretch != 0.0, settings.twist != 0.0],
        }
    }

    /// The loops, ordered by cell, and how many frames were made for them; not all of them if `cancel` says so
    /// afterwards.
    pub(super) fn plant(
        &self,
        turbulence: &TurbulenceField,
        frames: Frames<'_>,
        standing: &CellSet,
        cancel: &Cancel<'_>,
    ) -> (Planted, u64) {
        let faces = self.faces();
        let rows: Vec<Row> = (0..self.sheet.wefts as usize)
            .into_par_iter()
            .map(|j| {
                if cancel.is_cancelled() {
                    return Row::default();
                }
                match frames {
                    Frames::Of(cells) => self.row(turbulence, &faces, cells, None, j),
                    Frames::Visible(cells, visible) => {
                        self.row(turbulence, &faces, cells, Some(visible), j)
                    }
                }
            })
            .collect();
        let count = rows.iter().map(|row| row.patches.len()).sum();
        let mut planted = Planted {
            patches: Vec::with_capacity(count),
            warps: Vec::with_capacity(count),
            row_starts: Vec::with_capacity(rows.len() + 1),
            base_width_mm: self.frames.common().base_width as f32,
            thickness_mm: self.frames.common().thickness as f32,
            counts: LoopCounts::default(),
            whole: self.whole_pile(turbulence, standing),
        };
        let mut frames_made = 0;
        for row in rows {
            planted.row_starts.push(planted.patches.len());
            planted.patches.extend_from_slice(&row.patches);
            planted.warps.extend_from_slice(&row.warps);
            planted.counts = planted.counts.plus(row.counts);
            frames_made += row.frames_made;
        }
        planted.row_starts.push(planted.patches.len());
        (planted, frames_made)
    }

    fn row(
        &self,
        turbulence: &TurbulenceField,
        faces: &Faces,
        cells: &CellSet,
        visible: Option<&VisibleCells>,
        j: usize,
    ) -> Row {
        let mut row = Row::with_room_for(cells.row_len(j));
        for i in cells.row(j) {
            let (length, settings) = self.of_cell(i, j);
            for (face, stands) in FACES.into_iter().zip(faces.at(i, j)) {
                if !stands {
                    continue;
                }
                let input = self.input(turbulence, [i, j], face, length);
                let mut counts = row.counts;
                let shape = loop_shape(settings, &input, &mut counts);
                row.frames_made += 1;
                if let (Some(shape), Some(visible)) = (&shape, visible)
                    && !visible.meets_loop([i as i64, j as i64], self.box_of(shape))
                {
                    continue;
                }
                row.counts = counts;
                if let Some(shape) = shape {
                    row.patches.push(shape);
                    row.warps.push(i as u32);
                }
            }
        }
        row
    }

    /// Length of a cell's loops before turbulence, mm, and the settings of their frames.
    fn of_cell(&self, i: usize, j: usize) -> (f64, &FrameSettings) {
        let cell = j * self.sheet.warps as usize + i;
        let settings = self.frames.of_row(self.cells.row(cell));
        (self.cells.length_mm(cell), settings)
    }

    fn box_of(&self, shape: &LoopPatch) -> [DVec3; 2] {
        let common = self.frames.common();
        box_of(shape, common.base_width as f32, common.thickness as f32)
    }

    fn input(
        &self,
        turbulence: &TurbulenceField,
        [i, j]: [usize; 2],
        face: Face,
        length: f64,
    ) -> LoopInput {
        let original = self.sheet.original(i, j);
        let [warp, weft] = original.map(|index| index as u32);
        let hash = loop_hash(self.turbulence.seed, warp, weft, face);
        let place_mm = self.sheet.place_mm(i, j);
        LoopInput {
            face,
            root_heights: self.roots.at(i, j, face),
            length,
            turbulence: turbulence.at(i, j).map(f64::from),
            jitter: Jitter::new(hash),
            finish: self.finishing.of_loop(hash, face, original, place_mm),
        }
    }

    fn faces(&self) -> Faces {
        Faces::new(&self.weave)
    }
}

const FACES: [Face; 2] = [Face::Front, Face::Back];

impl LoopCounts {
    /// Those of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            planted: self.planted + other.planted,
            dropped: self.dropped + other.dropped,
            repaired: self.repaired + other.repaired,
            raised: self.raised + other.raised,
            capped: self.capped + other.capped,
        }
    }
}
