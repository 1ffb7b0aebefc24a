//! Which levels of detail of a cloth a picture needs, and which cells of each.

use super::visibility::{COARSEST_LOD, LevelCells, Visibility};
use super::{LodRegion, LodSelector};
use crate::design::Design;
use crate::geometry::Camera;

/// How much of a cloth is made at most, where it is made in regions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LodBudget {
    /// Most cells of all levels together.
    pub cells: u64,
    /// Cells beyond what is seen on each side, as a share of it: so far the camera moves without another region.
    pub margin: f64,
}

impl LodBudget {
    /// For looking while designing: made in about a second.
    pub const LIVE: Self = Self {
        cells: 1 << 20,
        margin: 0.125,
    };
    /// For a picture that stays.
    pub const FINAL: Self = Self {
        cells: 1 << 22,
        margin: 0.0,
    };

    fn has_room_for(&self, regions: &[LodRegion]) -> bool {
        regions.iter().map(LodRegion::len).sum::<u64>() <= self.cells
    }
}

/// The regions of a cloth that a picture shows.
#[derive(Debug, Clone, PartialEq)]
pub struct LodPlan {
    /// From near to far, each one LOD coarser than the one before; none if the whole cloth is made.
    pub regions: Vec<LodRegion>,
    /// How far apart the loops of a level are where it begins to give way to the next, pixels.
    loop_pixels: f64,
}

/// [`LodPlan::loop_pixels`] unless that takes too many loops: 64 of them in a pixel vary so little that a zoom from
/// level to level shows no more change from frame to frame than the cloth itself (measured in the tests of levels).
const LOOP_PIXELS: f64 = 0.125;
/// By how much it grows until there are few enough.
const GROWTH: f64 = std::f64::consts::SQRT_2;

impl LodPlan {
    /// The whole cloth.
    pub fn whole() -> Self {
        Self {
            regions: Vec::new(),
            loop_pixels: LOOP_PIXELS,
        }
    }

    /// What a picture of `size` pixels shows of a design. Regions of the `last` plan are kept while they hold what is
    /// seen.
    pub fn new(
        design: &Design,
        camera: &Camera,
        size: [u32; 2],
        budget: LodBudget,
        last: Option<&Self>,
    ) -> Self {
        if !LodRegion::is_needed(design) || !design.faults().is_empty() {
            return Self::whole();
        }
        let visibility = Visibility::new(design, camera, size);
        let (levels, loop_pixels) = finest_within(budget, &visibility);
        let needed = regions(&levels, 0.0);
        let roomy = regions(&levels, budget.margin);
        let last = last.map_or(&[][..], |last| &last.regions);
        // The best first: nothing new while the camera moves, then room for it to move, then what is seen now.
        let choices = [
            kept_or(last, &needed, &roomy),
            kept_or(last, &needed, &needed),
            roomy,
        ];
        let mut choices = choices.into_iter();
        let within = choices.find(|regions| budget.has_room_for(regions));
        Self {
            regions: within.unwrap_or(needed),
            loop_pixels,
        }
    }

    /// How fine the rows of a picture need the first level's loops.
    pub(super) fn selector(&self, design: &Design, camera: &Camera, size: [u32; 2]) -> LodSelector {
        match self.regions.first() {
            Some(first) => {
                Visibility::new(design, camera, size).fineness(self.loop_pixels, first.lod)
            }
            None => LodSelector::default(),
        }
    }
}

/// The cells that each level shows, with loops as far apart as the budget makes them, and how far that is, pixels.
fn finest_within(budget: LodBudget, visibility: &Visibility<'_>) -> (Vec<LevelCells>, f64) {
    let mut loop_pixels = LOOP_PIXELS;
    loop {
        let levels = visibility.levels(loop_pixels);
        let needed = regions(&levels, 0.0);
        let is_coarsest = needed.iter().all(|region| region.lod == COARSEST_LOD);
        if is_coarsest || budget.has_room_for(&needed) {
            return (levels, loop_pixels);
        }
        loop_pixels *= GROWTH;
    }
}

/// The regions that have these cells, and a share of them more on each side.
fn regions(levels: &[LevelCells], margin: f64) -> Vec<LodRegion> {
    levels.iter().map(|cells| cells.region(margin)).collect()
}

/// For each level the region of the `last` plan that holds what is `needed`, else the `new` one.
fn kept_or(last: &[LodRegion], needed: &[LodRegion], new: &[LodRegion]) -> Vec<LodRegion> {
    let levels = needed.iter().zip(new);
    levels
        .map(|(needed, new)| *last.iter().find(|last| last.holds(needed)).unwrap_or(new))
        .collect()
}
