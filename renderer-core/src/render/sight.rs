//! What a picture of a design is made from: the scenes of its levels of detail, and the camera in the space of each.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::levels::{Level, Levels};
use super::{Camera, Extent, LevelPlan, RenderRequest, Settings};
use crate::design::Design;
use crate::scene::{Cancel, CompileError, CompileReport, Compiler, Excerpt, LoopCounts, Scene};

/// A scene for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Sight {
    /// The cloth, or the nearest part of it that the picture shows.
    pub scene: Arc<Scene>,
    /// The camera in the scene's space.
    pub camera: Camera,
    /// What is farther away.
    pub levels: Levels,
}

/// A cloth made for a picture, level by level.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloth {
    /// What was to be made.
    pub plan: LevelPlan,
    /// The whole cloth, or the first of the plan's excerpts.
    pub nearest: Arc<Scene>,
    /// The other excerpts.
    pub farther: Vec<Arc<Scene>>,
}

impl Cloth {
    /// All scenes, from near to far.
    pub fn scenes(&self) -> impl Iterator<Item = &Arc<Scene>> {
        std::iter::once(&self.nearest).chain(&self.farther)
    }

    /// Loops of all levels.
    pub fn counts(&self) -> LoopCounts {
        let counts = self.scenes().map(|scene| scene.loops.counts);
        counts.fold(LoopCounts::default(), LoopCounts::plus)
    }

    /// What a camera sees of it in a picture of `size` pixels.
    pub fn sight(&self, design: &Design, camera: &Camera, size: [u32; 2]) -> Sight {
        let level = |scene: &Arc<Scene>| Level {
            scene: Arc::clone(scene),
            camera: match &scene.sheet.excerpt {
                Some(excerpt) => excerpt.camera(design, camera),
                None => *camera,
            },
        };
        let Level {
            scene,
            camera: of_nearest,
        } = level(&self.nearest);
        Sight {
            scene,
            camera: of_nearest,
            levels: Levels {
                farther: self.farther.iter().map(level).collect(),
                fineness: self.plan.fineness(design, camera, size),
            },
        }
    }
}

/// Makes cloth for one picture after another and keeps what did not change: a compiler for the whole cloth and for each number
/// of halvings.
#[derive(Debug, Default)]
pub struct ClothMaker {
    whole: Compiler,
    halved: BTreeMap<u32, Compiler>,
}

impl ClothMaker {
    /// Leaves out what such a compiler leaves out.
    pub fn new(compiler: Compiler) -> Self {
        Self {
            whole: compiler,
            halved: BTreeMap::new(),
        }
    }

    /// The compiler of whole cloth.
    pub fn whole(&mut self) -> &mut Compiler {
        &mut self.whole
    }

    /// Whether all loops that a plan names of a design are there already.
    pub fn has_loops_of(&mut self, design: &Design, plan: &LevelPlan) -> bool {
        if plan.excerpts.is_empty() {
            return self.whole.has_loops_of(design, None);
        }
        plan.excerpts.iter().all(|excerpt| {
            let compiler = self.halved.get_mut(&excerpt.halvings);
            compiler.is_some_and(|compiler| compiler.has_loops_of(design, Some(*excerpt)))
        })
    }

    /// What was done for the cloth made last, all levels together.
    pub fn last_report(&self) -> CompileReport {
        let mut halved = self.halved.values().map(Compiler::last_report);
        match halved.next() {
            Some(first) => halved.fold(*first, |sum, report| sum.plus(report)),
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
        plan: LevelPlan,
        cancel: &Cancel<'_>,
    ) -> Result<Cloth, CompileError> {
        self.halved.retain(|halvings, _| {
            let mut planned = plan.excerpts.iter();
            planned.any(|excerpt| excerpt.halvings == *halvings)
        });
        let Some((first, others)) = plan.excerpts.split_first() else {
            let nearest = self.whole.compile_unless_cancelled(design, cancel)?;
            return Ok(Cloth {
                plan,
                nearest,
                farther: Vec::new(),
            });
        };
        let nearest = self.make_excerpt(design, *first, cancel)?;
        let farther = others
            .iter()
            .map(|excerpt| self.make_excerpt(design, *excerpt, cancel));
        let farther = farther.collect::<Result<_, _>>()?;
        Ok(Cloth {
            plan,
            nearest,
            farther,
        })
    }

    fn make_excerpt(
        &mut self,
        design: &Design,
        excerpt: Excerpt,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<Scene>, CompileError> {
        let Self { whole, halved } = self;
        let compiler = halved.entry(excerpt.halvings);
        let compiler = compiler.or_insert_with(|| whole.fresh());
        // Volumes are those of the cloth's yarns, whatever part of it is made.
        compiler.share_volumes(whole);
        let made = compiler.compile_excerpt(design, excerpt, cancel);
        whole.share_volumes(compiler);
        made
    }
}

impl Sight {
    /// Makes what a picture of `size` pixels shows.
    ///
    /// # Errors
    /// As [`Compiler::compile_unless_cancelled`].
    pub fn new(
        maker: &mut ClothMaker,
        design: &Design,
        camera: &Camera,
        size: [u32; 2],
        most: Extent,
        cancel: &Cancel<'_>,
    ) -> Result<Self, CompileError> {
        let plan = LevelPlan::new(design, camera, size, most, None);
        Ok(maker
            .make(design, plan, cancel)?
            .sight(design, camera, size))
    }

    /// The level that most samples of a row of a picture `height` pixels high show.
    pub fn at_row(&self, row: u32, height: u32) -> Level {
        let (level, share_of_next) = self.levels.rows(height).of_row(row);
        let index = level + usize::from(share_of_next > 0.5);
        let farther = index.checked_sub(1);
        let farther = farther.and_then(|index| self.levels.farther.get(index));
        farther.cloned().unwrap_or(Level {
            scene: Arc::clone(&self.scene),
            camera: self.camera,
        })
    }

    /// A whole picture of it.
    pub fn request(self, size: [u32; 2], settings: Settings) -> RenderRequest {
        RenderRequest {
            scene: self.scene,
            camera: self.camera,
            levels: self.levels,
            size,
            crop: [0, 0, size[0], size[1]],
            settings,
        }
    }
}
