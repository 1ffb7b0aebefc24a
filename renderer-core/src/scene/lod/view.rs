//! From a design to what a picture of it is made from: the scenes of its levels of detail, and the camera in the space
//! of each.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Level, LevelRows, Levels, LodBudget, LodPlan, LodRegion, LodSelector};
use crate::design::{Back, Chart, Design, LengthMap, Pattern, Warning};
use crate::geometry::Camera;
use crate::scene::grid::MAX_ENTRIES;
use crate::scene::warnings::warnings_of_design;
use crate::scene::{
    Cancel, ChartComposer, ChartYarns, CompileError, CompileReport, Compiler, LoopCounts, Scene,
};

/// The cloth as one camera sees it, level by level.
#[derive(Debug, Clone, PartialEq)]
pub struct LodView {
    /// From near to far.
    pub levels: Levels<Level>,
    /// How fine the rows of the picture need the cloth.
    pub selector: LodSelector,
}

/// A cloth made for a picture, level by level.
#[derive(Debug, Clone, PartialEq)]
pub struct LodCloth {
    /// What was to be made.
    pub plan: LodPlan,
    /// The whole cloth, or one scene for each of the plan's regions.
    pub scenes: Levels<Arc<Scene>>,
}

impl LodCloth {
    /// Loops of all levels.
    pub fn counts(&self) -> LoopCounts {
        let counts = self.scenes.iter().map(|scene| scene.loops.counts);
        counts.fold(LoopCounts::default(), LoopCounts::plus)
    }

    /// What a camera sees of it in a picture of `size` pixels.
    pub fn view(&self, design: &Design, camera: &Camera, size: [u32; 2]) -> LodView {
        LodView {
            levels: self.scenes.map(|scene| Level {
                scene: Arc::clone(scene),
                camera: match &scene.sheet.region {
                    Some(region) => region.camera(design, camera),
                    None => *camera,
                },
            }),
            selector: self.plan.selector(design, camera, size),
        }
    }
}

/// Makes cloth for one picture after another and keeps what did not change: a compiler for the whole cloth and one for
/// each level of detail.
#[derive(Debug, Default)]
pub struct LodCompiler {
    composer: ChartComposer,
    whole: Compiler,
    by_lod: BTreeMap<u32, Compiler>,
}

impl LodCompiler {
    /// Leaves out what such a compiler leaves out.
    pub fn new(compiler: Compiler) -> Self {
        Self {
            composer: ChartComposer::default(),
            whole: compiler,
            by_lod: BTreeMap::new(),
        }
    }

    /// The compiler of whole cloth.
    pub fn whole(&mut self) -> &mut Compiler {
        &mut self.whole
    }

    /// Whether all loops that a plan names of a design are there already.
    pub fn has_loops_of(&mut self, design: &Design, plan: &LodPlan) -> bool {
        if plan.regions.is_empty() {
            return self.whole.has_loops_of(design, None);
        }
        let design = &*self.composer.design(design);
        plan.regions.iter().all(|region| {
            let compiler = self.by_lod.get_mut(&region.lod);
            compiler.is_some_and(|compiler| compiler.has_loops_of(design, Some(*region)))
        })
    }

    /// What was done for the cloth made last, all levels together.
    pub fn last_report(&self) -> CompileReport {
        let mut reports = self.by_lod.values().map(Compiler::last_report);
        match reports.next() {
            Some(first) => reports.fold(*first, |sum, report| sum.plus(report)),
            None => *self.whole.last_report(),
        }
    }

    /// Makes what a plan names of a design.
    ///
    /// # Errors
    /// As [`Compiler::compile_unless_cancelled`].
    pub fn make(
        &mut self,
        design: &Design,
        plan: LodPlan,
        cancel: &Cancel<'_>,
    ) -> Result<LodCloth, CompileError> {
        self.by_lod.retain(|lod, _| {
            let mut planned = plan.regions.iter();
            planned.any(|region| region.lod == *lod)
        });
        let scenes = match plan.regions.split_first() {
            None => Levels::one(self.whole.compile_unless_cancelled(design, cancel)?),
            Some((first, others)) => {
                // Once for all levels.
                let design = &*self.composer.design(design);
                let mut compile = |region: &LodRegion| self.compile_region(design, *region, cancel);
                Levels {
                    nearest: compile(first)?,
                    farther: others.iter().map(compile).collect::<Result<_, _>>()?,
                }
            }
        };
        Ok(LodCloth { plan, scenes })
    }

    /// Finds out whether what a plan names of a design can be made, and what is to be known of it, as
    /// [`Compiler::check`] does. Of regions only those are made that might be refused; of the others it is known by a
    /// part.
    ///
    /// # Errors
    /// As [`Compiler::compile_unless_cancelled`].
    pub fn check(
        &mut self,
        design: &Design,
        plan: &LodPlan,
        cancel: &Cancel<'_>,
    ) -> Result<Vec<Warning>, CompileError> {
        if plan.regions.is_empty() {
            return self.whole.check(design, None, cancel);
        }
        for region in &plan.regions {
            if !has_short_lists(design, region, cancel)? {
                self.whole.fresh().check(design, Some(*region), cancel)?;
            }
        }
        Ok(warnings_of_design(design, &mut ChartYarns::default()))
    }

    fn compile_region(
        &mut self,
        design: &Design,
        region: LodRegion,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<Scene>, CompileError> {
        let Self { whole, by_lod, .. } = self;
        let compiler = by_lod.entry(region.lod);
        let compiler = compiler.or_insert_with(|| whole.fresh());
        // Volumes are those of the cloth's yarns, whatever part of it is made.
        compiler.share_volumes(whole);
        let made = compiler.compile_region(design, region, cancel);
        whole.share_volumes(compiler);
        made
    }
}

/// Whether the lists of a region are far from being too long, whatever its chart and its weave: judged by a part of it
/// where loops stand on both faces of all crossings and are as long as any.
fn has_short_lists(
    design: &Design,
    region: &LodRegion,
    cancel: &Cancel<'_>,
) -> Result<bool, CompileError> {
    /// Sides of the part, cells: its border counts little.
    const SIDE: u32 = 256;
    /// How many times longer they might be than the part tells: loops lean and stretch from place to place.
    const UNLIKE: u64 = 4;
    let part = LodRegion {
        cells: region.cells.map(|cells| cells.min(SIDE)),
        ..*region
    };
    let mut dense = design.clone();
    (dense.length.value, dense.length.map) = (design.length.longest(), LengthMap::Constant);
    dense.chart = Chart::default();
    dense.weave.pattern = Pattern::filled(1, 1, 9);
    dense.weave.back = Back::Pattern;
    match Compiler::default().entries(&dense, part, cancel) {
        Ok(entries) => {
            let times = region.len().div_ceil(part.len());
            Ok(entries as u64 * times * UNLIKE < MAX_ENTRIES)
        }
        Err(CompileError::Cancelled) => Err(CompileError::Cancelled),
        Err(_) => Ok(false),
    }
}

impl LodView {
    /// A single scene, in which all rows are drawn.
    pub fn of(scene: Arc<Scene>, camera: Camera) -> Self {
        Self::of_level(Level { scene, camera })
    }

    /// A single level, in which all rows are drawn.
    pub fn of_level(level: Level) -> Self {
        Self {
            levels: Levels::one(level),
            selector: LodSelector::default(),
        }
    }

    /// Makes what a picture of `size` pixels shows.
    ///
    /// # Errors
    /// As [`Compiler::compile_unless_cancelled`].
    pub fn new(
        compiler: &mut LodCompiler,
        design: &Design,
        camera: &Camera,
        size: [u32; 2],
        budget: LodBudget,
        cancel: &Cancel<'_>,
    ) -> Result<Self, CompileError> {
        let plan = LodPlan::new(design, camera, size, budget, None);
        let cloth = compiler.make(design, plan, cancel)?;
        Ok(cloth.view(design, camera, size))
    }

    /// Which levels the rows of a whole picture `height` pixels high show.
    pub fn rows(&self, height: u32) -> LevelRows {
        self.selector.rows(self.levels.len(), height)
    }

    /// The level that most samples of a row of a picture `height` pixels high show.
    pub fn at_row(&self, row: u32, height: u32) -> &Level {
        let (level, share_of_next) = self.rows(height).of_row(row);
        let number = level + usize::from(share_of_next > 0.5);
        self.levels.get(number).unwrap_or(&self.levels.nearest)
    }
}
