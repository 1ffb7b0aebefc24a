//! From a design to a scene, section by section (steps 1 and 2 of the paper's §6).
//!
//! Each section has inputs; if they equal those of the last design, it keeps its `Arc`. Which parts of a design a
//! section depends on:
//!
//! - sheet: `sheet`.
//! - loops: `sheet`, `weave`, the shape of frames in `pile`, `finish`, `nap`, `turbulence`, the yarns' shape in
//!   `skeleton`, and each cell's length (`chart`, `length`).
//! - looks: the loops, colours (`chart`), the table of `length`, optics and variants of `pile`, shears and water
//!   (`finish`), the seed of `turbulence`, the colour of `skeleton`, `bounces` of `quality`.
//! - volumes: the longest loop and the kinds of pile that `length` may ask for, yarn and volume of `pile`, of `finish`
//!   water and whether anything is shorn.
//! - pile: the table of `length`, phase and density of `pile`, of `finish` water and whether anything is shorn.
//! - skeleton: `weave`, `skeleton`, water (`finish`).
//! - form: `form`, `sheet`, the loops, the yarns' shape in `skeleton`.
//! - lights: `light`.
//!
//! The form of level cloth depends on nothing; that of any other is made anew when the loops are, whose height it must
//! hold.
//!
//! The view and the rest of quality belong to requests; no section depends on them. Sections that are cheap are made
//! anew and kept when equal; loops, looks and volumes have their inputs compared.
//!
//! Longer than most files because what each section depends on stands beside what makes it.

use std::sync::Arc;
use std::time::Instant;

use super::cancel::{Cancel, Cancelled};
use super::chart::ChartOnSheet;
use super::chart_composer::ChartComposer;
use super::chart_yarns::ChartYarns;
use super::faces::LoopSpacing;
use super::finish::{Finishing, wet_pile};
use super::frames::FrameRules;
use super::grid::{self, NoGrid};
use super::length::Cells;
use super::lod::LodRegion;
use super::looks::{Materials, looks};
use super::plant::{Frames, LoopsInputs};
use super::report::{CompileReport, SECTIONS, timed};
use super::skeleton::RootHeights;
use super::turbulence::TurbulenceField;
use super::types::heights_mm;
use super::volumes::rasterise_unless_cancelled;
use super::warnings::warnings_of_loops;
use super::{
    CellSet, FormMesh, Lights, LoopLook, Loops, PileOptics, Scene, Section, SheetGeometry,
    Skeleton, VisibleCells, Volumes,
};
use crate::design::{
    Chart, Colour, Design, Fault, Form, FormKind, Length, Phase, Pile, PileKind, Sheared,
    Turbulence, Warning,
};

/// Why a design has no scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompileError {
    /// Values that are not allowed.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Fault>),
    /// The lists of loops in cells are too long.
    #[error(
        "pile.max_length allows {loops} loops to reach too many cells: their lists exceed {limit} entries"
    )]
    TooManyEntries {
        /// Loops planted.
        loops: u64,
        /// Most entries.
        limit: u64,
    },
    /// Nobody waits for the scene any more.
    #[error("given up")]
    Cancelled,
}

impl From<Cancelled> for CompileError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// The scene of a design.
///
/// # Errors
/// When the design has values that are not allowed, or is too large.
pub fn compile(design: &Design) -> Result<Scene, CompileError> {
    Compiler::default()
        .compile(design)
        .map(|scene| Scene::clone(&scene))
}

/// Work that a compiler leaves out; it never changes a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompilerOptions {
    /// Sections whose inputs did not change are kept.
    pub keeps_unchanged: bool,
}

impl Default for CompilerOptions {
    fn default() -> Self {
        Self {
            keeps_unchanged: true,
        }
    }
}

/// Compiles one design after another and keeps what did not change.
#[derive(Debug, Default)]
pub struct Compiler {
    options: CompilerOptions,
    /// The last whole scene.
    scene: Option<Arc<Scene>>,
    composer: ChartComposer,
    cells: Option<(CellsInputs, Cells)>,
    turbulence: Option<(TurbulenceInputs, Arc<TurbulenceField>)>,
    loops: Option<(LoopsInputs, Section<Loops>)>,
    looks: Option<(LooksOfLoops, Section<Vec<LoopLook>>)>,
    volumes: Option<(VolumesInputs, Section<Volumes>)>,
    form: Option<(FormInputs, Section<Option<FormMesh>>)>,
    report: CompileReport,
}

/// A scene for a coarse preview.
#[derive(Debug, Clone)]
pub enum PreviewScene {
    /// With all loops, since they were there already.
    Whole(Arc<Scene>),
    /// With those loops only that reach the visible cells.
    Part(Arc<Scene>),
}

/// What looks follow from, and the loops that they are of.
type LooksOfLoops = (LooksInputs, Section<Loops>);

/// Everything that the form follows from: itself, the sheet with its loops, and the lowest and highest point over the
/// sheet.
type FormInputs = (Form, SheetGeometry, Section<Loops>, [f64; 2]);

/// Everything that the turbulence follows from.
type TurbulenceInputs = (SheetGeometry, Turbulence);

/// Everything that follows from the chart in each cell for frames.
#[derive(Debug, Clone, PartialEq)]
struct CellsInputs {
    chart: Chart,
    /// How far apart the pattern plants loops, where that counts.
    averaged_over: Option<[LoopSpacing; 2]>,
    length: Length,
    sheet: SheetGeometry,
}

/// Everything that the looks follow from, besides which loops there are.
#[derive(Debug, Clone, PartialEq)]
struct LooksInputs {
    chart: Chart,
    length: Length,
    pile: Pile,
    /// How much of the light comes back depends on these two: see `albedo`.
    bounces: u32,
    ground: Colour,
    wetness: f64,
    /// At which height follows from the loops.
    sheared: Sheared,
    seed: u32,
}

/// Everything that the volumes follow from.
#[derive(Debug, Clone, PartialEq)]
struct VolumesInputs {
    pile: Pile,
    /// Kinds of pile, and the diameter of the yarn of each, mm.
    yarns: Vec<(PileKind, f64)>,
    /// That of the longest loop there may be. Arch, twist and stray fibres are drawn in mm, so that this shows in every
    /// voxel; an edit of lengths that leaves the longest alone keeps the volumes.
    reference_length_mm: f64,
}

/// What was made from inputs, if they were the same.
fn kept<I: PartialEq, T: Clone>(last: Option<&(I, T)>, inputs: &I) -> Option<T> {
    last.filter(|(last, _)| last == inputs)
        .map(|(_, made)| made.clone())
}

impl Compiler {
    /// A compiler with these options.
    pub fn new(options: CompilerOptions) -> Self {
        Self {
            options,
            ..Self::default()
        }
    }

    /// The scene of a design. Sections whose inputs are those of the last design keep their `Arc`; if all do, the scene
    /// is the same `Arc`.
    ///
    /// # Errors
    /// When the design has values that are not allowed, or is too large. The last scene is kept for comparison.
    pub fn compile(&mut self, design: &Design) -> Result<Arc<Scene>, CompileError> {
        self.compile_unless_cancelled(design, &Cancel::never())
    }

    /// The scene of a design, or what was begun of it is given up with [`CompileError::Cancelled`] soon after `cancel`
    /// says so.
    ///
    /// # Errors
    /// As [`Self::compile`], or when given up.
    pub fn compile_unless_cancelled(
        &mut self,
        design: &Design,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<Scene>, CompileError> {
        self.scene_of(design, None, cancel)
    }

    /// The scene of a region of a design.
    ///
    /// # Errors
    /// As [`Self::compile_unless_cancelled`].
    pub fn compile_region(
        &mut self,
        design: &Design,
        region: LodRegion,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<Scene>, CompileError> {
        self.scene_of(design, Some(region), cancel)
    }

    fn scene_of(
        &mut self,
        design: &Design,
        region: Option<LodRegion>,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<Scene>, CompileError> {
        match self.make(design, region, None, cancel)? {
            PreviewScene::Whole(scene) | PreviewScene::Part(scene) => Ok(scene),
        }
    }

    /// One that leaves out the same work and has made nothing yet.
    pub fn fresh(&self) -> Self {
        Self::new(self.options)
    }

    /// Takes over the volumes of another compiler, for designs of the same yarns.
    pub fn share_volumes(&mut self, other: &Self) {
        if other.volumes.is_some() {
            self.volumes = other.volumes.clone();
        }
    }

    /// A scene for a coarse preview of a design whose loops changed: in the `visible` cells it is what
    /// [`Self::compile`] gives, elsewhere loops may be missing. What can be kept is kept for that.
    ///
    /// # Errors
    /// As [`Self::compile_unless_cancelled`].
    pub fn compile_visible(
        &mut self,
        design: &Design,
        visible: &VisibleCells,
        cancel: &Cancel<'_>,
    ) -> Result<PreviewScene, CompileError> {
        self.make(design, None, Some(visible), cancel)
    }

    /// Whether the loops of a design, or of a region of it, are there already, so that a scene for a coarse preview
    /// saves nothing.
    pub fn has_loops_of(&mut self, whole: &Design, region: Option<LodRegion>) -> bool {
        let whole = &*self.composer.design(whole);
        let shrunk = region.map(|region| region.design(whole));
        let design = shrunk.as_ref().unwrap_or(whole);
        let sheet = sheet_of(design, region);
        // What each cell asks for takes time to tell.
        let are_there = (self.loops.as_ref()).is_some_and(|(inputs, _)| inputs.sheet == sheet);
        are_there && {
            let inputs = self.loops_inputs(design, &sheet);
            kept(self.loops.as_ref(), &inputs).is_some()
        }
    }

    /// What the last compilation did; of one that failed, as far as it came.
    pub fn last_report(&self) -> &CompileReport {
        &self.report
    }

    fn make(
        &mut self,
        whole: &Design,
        region: Option<LodRegion>,
        visible: Option<&VisibleCells>,
        cancel: &Cancel<'_>,
    ) -> Result<PreviewScene, CompileError> {
        let start = Instant::now();
        self.report = CompileReport::default();
        check(whole, region)?;
        if !self.options.keeps_unchanged {
            *self = Self::new(self.options);
        }
        let whole = &*self.composer.design(whole);
        let shrunk = region.map(|region| region.design(whole));
        let design = shrunk.as_ref().unwrap_or(whole);
        let last = self.scene.clone();
        let last = last.as_deref();
        let materials = Materials::new(design);
        let optics = PileOptics::new(&materials);
        let ClothShape {
            sheet,
            skeleton,
            loops_inputs,
            loops,
            form,
            is_part,
        } = self.shape(design, region, visible, cancel)?;
        let looks_inputs = (LooksInputs::new(design), loops.clone());
        let looks = match kept(self.looks.as_ref(), &looks_inputs) {
            Some(looks) => looks,
            None => {
                let new = timed(&mut self.report.seconds.looks, || {
                    looks(design, &sheet, &loops, &materials, cancel)
                });
                keep(last.map(|last| &last.looks), new)
            }
        };
        cancel.check()?;
        let volumes = self.volumes_of(VolumesInputs::new(design, &materials, &optics), cancel)?;
        let lights = Lights {
            background: design.background_radiance(),
            ..Lights::new(&design.light)
        };
        let lights = match region {
            Some(region) => lights.in_region(&region, whole),
            None => lights,
        };
        let scene = Scene {
            sheet: keep(last.map(|last| &last.sheet), sheet),
            loops,
            looks,
            volumes,
            pile: keep(last.map(|last| &last.pile), optics),
            skeleton: keep(last.map(|last| &last.skeleton), skeleton),
            form,
            lights: keep(last.map(|last| &last.lights), lights),
        };
        self.report.kept = last.map_or([false; SECTIONS.len()], |last| scene.same_sections(last));
        self.report.seconds.total = start.elapsed().as_secs_f64();
        if is_part {
            return Ok(PreviewScene::Part(Arc::new(scene)));
        }
        self.loops = Some((loops_inputs, scene.loops.clone()));
        self.looks = Some((looks_inputs, scene.looks.clone()));
        let scene = match self.scene.take().filter(|last| **last == scene) {
            Some(last) => last,
            None => Arc::new(scene),
        };
        self.scene = Some(Arc::clone(&scene));
        Ok(PreviewScene::Whole(scene))
    }

    /// Finds out whether a design, or a region of it, has a scene, and what is to be known of it, as [`warnings`](super::warnings) tells:
    /// makes all that can be refused, and nothing that only shows.
    ///
    /// # Errors
    /// As [`Self::compile_unless_cancelled`].
    pub fn check(
        &mut self,
        whole: &Design,
        region: Option<LodRegion>,
        cancel: &Cancel<'_>,
    ) -> Result<Vec<Warning>, CompileError> {
        self.report = CompileReport::default();
        check(whole, region)?;
        let composed = self.composer.design(whole);
        let shrunk = region.map(|region| region.design(&composed));
        let design = shrunk.as_ref().unwrap_or(&composed);
        let shape = self.shape(design, region, None, cancel)?;
        let warnings = warnings_of_loops(
            whole,
            &shape.sheet,
            shape.loops.counts,
            &mut ChartYarns::default(),
        );
        self.loops = Some((shape.loops_inputs, shape.loops));
        Ok(warnings)
    }

    /// How long the lists of loops in cells are, all together.
    ///
    /// # Errors
    /// As [`Self::compile_unless_cancelled`].
    pub(super) fn entries(
        &mut self,
        whole: &Design,
        region: LodRegion,
        cancel: &Cancel<'_>,
    ) -> Result<usize, CompileError> {
        check(whole, Some(region))?;
        let whole = &*self.composer.design(whole);
        let shape = self.shape(&region.design(whole), Some(region), None, cancel)?;
        Ok(shape.loops.entries.len())
    }

    /// Where loops and cloth are: whatever of a scene can be refused. Before all else, since the rest may take minutes.
    fn shape(
        &mut self,
        design: &Design,
        region: Option<LodRegion>,
        visible: Option<&VisibleCells>,
        cancel: &Cancel<'_>,
    ) -> Result<ClothShape, CompileError> {
        let sheet = sheet_of(design, region);
        let skeleton = Skeleton::new(&design.weave, &design.skeleton).wet(design.finish.wetness);
        let loops_inputs = self.loops_inputs(design, &sheet);
        let kept_loops = kept(self.loops.as_ref(), &loops_inputs);
        let is_part = visible.is_some() && kept_loops.is_none();
        let loops = match kept_loops {
            Some(loops) => loops,
            None => Section::new(self.build_loops(&loops_inputs, visible, cancel)?),
        };
        let form = self.form_of(&design.form, &sheet, &loops, &skeleton)?;
        Ok(ClothShape {
            sheet,
            skeleton,
            loops_inputs,
            loops,
            form,
            is_part,
        })
    }

    fn volumes_of(
        &mut self,
        inputs: VolumesInputs,
        cancel: &Cancel<'_>,
    ) -> Result<Section<Volumes>, CompileError> {
        if let Some(volumes) = kept(self.volumes.as_ref(), &inputs) {
            return Ok(volumes);
        }
        let seconds = &mut self.report.seconds.volumes;
        let volumes = Section::new(timed(seconds, || inputs.build(cancel)));
        cancel.check()?;
        self.volumes = Some((inputs, volumes.clone()));
        Ok(volumes)
    }

    fn loops_inputs(&mut self, design: &Design, sheet: &SheetGeometry) -> LoopsInputs {
        let skeleton = Skeleton::new(&design.weave, &design.skeleton);
        LoopsInputs {
            sheet: *sheet,
            weave: design.weave.clone(),
            roots: RootHeights::new(&skeleton, sheet, design.pile.base_width),
            cells: self.cells_of(design, *sheet),
            frames: FrameRules::new(design),
            finishing: Finishing::new(design, sheet),
            turbulence: design.turbulence.clone(),
        }
    }

    /// The form; a level one is kept whatever the loops are.
    fn form_of(
        &mut self,
        form: &Form,
        sheet: &SheetGeometry,
        loops: &Section<Loops>,
        skeleton: &Skeleton,
    ) -> Result<Section<Option<FormMesh>>, CompileError> {
        let heights = heights_mm(loops, skeleton);
        if form.kind == FormKind::Flat
            && let Some((_, made)) = &self.form
            && made.is_none()
        {
            return Ok(made.clone());
        }
        let inputs = (form.clone(), *sheet, loops.clone(), heights);
        if let Some(made) = kept(self.form.as_ref(), &inputs) {
            return Ok(made);
        }
        let made = timed(&mut self.report.seconds.form, || {
            FormMesh::new(form, sheet, loops, heights)
        });
        let made = Section::new(made.map_err(|fault| CompileError::Invalid(vec![fault]))?);
        self.form = Some((inputs, made.clone()));
        Ok(made)
    }

    fn cells_of(&mut self, design: &Design, sheet: SheetGeometry) -> Cells {
        let inputs = CellsInputs {
            chart: design.chart.clone(),
            averaged_over: ChartOnSheet::averaged_over(&design.chart, &design.weave),
            length: design.length.clone(),
            sheet,
        };
        if let Some(cells) = kept(self.cells.as_ref(), &inputs) {
            return cells;
        }
        let cells = timed(&mut self.report.seconds.lengths, || {
            let chart = ChartOnSheet::new(&design.chart, &design.weave, sheet.whole_cells());
            Cells::new(&design.length, &chart, &sheet)
        });
        self.cells = Some((inputs, cells.clone()));
        cells
    }

    fn build_loops(
        &mut self,
        inputs: &LoopsInputs,
        visible: Option<&VisibleCells>,
        cancel: &Cancel<'_>,
    ) -> Result<Loops, CompileError> {
        let (standing, cells) = timed(&mut self.report.seconds.lengths, || {
            let standing = inputs.standing();
            let cells = visible.map(|visible| visible.planted_in().and(&standing));
            (standing, cells)
        });
        let frames = match (visible, &cells) {
            (Some(visible), Some(cells)) => Frames::Visible(cells, visible),
            _ => Frames::Of(&standing),
        };
        let turbulence = self.turbulence_of(inputs, frames, &standing, cancel)?;
        let (planted, frames_made) = timed(&mut self.report.seconds.frames, || {
            inputs.plant(&turbulence, frames, &standing, cancel)
        });
        cancel.check()?;
        let sheet = &inputs.sheet;
        self.report.frames_made = frames_made;
        self.report.frames_left_out =
            2 * u64::from(sheet.warps) * u64::from(sheet.wefts) - frames_made;
        let loops = planted.counts.planted;
        let built = timed(&mut self.report.seconds.grid, || {
            grid::build(sheet, &planted, cancel)
        });
        built.map_err(|error| match error {
            NoGrid::TooManyEntries => CompileError::TooManyEntries {
                loops,
                limit: grid::MAX_ENTRIES,
            },
            NoGrid::Cancelled => CompileError::Cancelled,
        })
    }

    /// The turbulence that frames need: that of the last design, as far as it has it.
    fn turbulence_of(
        &mut self,
        inputs: &LoopsInputs,
        frames: Frames<'_>,
        standing: &CellSet,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<TurbulenceField>, CompileError> {
        let wanted = inputs.wanted(frames, standing);
        let (sheet, turbulence) = (inputs.sheet, &inputs.turbulence);
        let last = self.turbulence.take();
        let last = last.filter(|((old_sheet, old), field)| {
            *old_sheet == sheet && old == turbulence && field.has_channels(&wanted)
        });
        let field = timed(&mut self.report.seconds.turbulence, || match last {
            Some((_, field)) if field.has(&wanted) => field,
            Some((_, mut field)) => {
                Arc::make_mut(&mut field).add(&sheet, turbulence, &wanted.cells, cancel);
                field
            }
            None => Arc::new(TurbulenceField::of(&sheet, turbulence, wanted, cancel)),
        });
        cancel.check()?;
        self.turbulence = Some(((sheet, turbulence.clone()), Arc::clone(&field)));
        Ok(field)
    }
}

impl Scene {
    /// Which sections are those of another scene, in the order of [`SECTIONS`].
    pub fn same_sections(&self, other: &Self) -> [bool; SECTIONS.len()] {
        [
            self.sheet == other.sheet,
            self.loops == other.loops,
            self.looks == other.looks,
            self.volumes == other.volumes,
            self.pile == other.pile,
            self.skeleton == other.skeleton,
            self.form == other.form,
            self.lights == other.lights,
        ]
    }
}

/// Where loops and cloth of a design are, and of which inputs the loops were made.
struct ClothShape {
    sheet: SheetGeometry,
    skeleton: Skeleton,
    loops_inputs: LoopsInputs,
    loops: Section<Loops>,
    form: Section<Option<FormMesh>>,
    /// Whether only the loops were made that are seen.
    is_part: bool,
}

/// Fails where a design, or all of it where no region of it is asked for, cannot have a scene.
fn check(design: &Design, region: Option<LodRegion>) -> Result<(), CompileError> {
    let mut faults = design.faults();
    if region.is_none()
        && let Some(fault) = design.sheet.fault_of_all_cells()
        && faults.iter().all(|other| other.path != fault.path)
    {
        faults.push(fault);
    }
    if faults.is_empty() {
        Ok(())
    } else {
        Err(CompileError::Invalid(faults))
    }
}

/// The sheet of a design, or of a region of a larger one.
fn sheet_of(design: &Design, region: Option<LodRegion>) -> SheetGeometry {
    SheetGeometry {
        region,
        ..SheetGeometry::new(design)
    }
}

/// The old section if it has this value, else a new one.
fn keep<T: PartialEq>(old: Option<&Section<T>>, new: T) -> Section<T> {
    match old {
        Some(old) if **old == new => old.clone(),
        _ => Section::new(new),
    }
}

impl SheetGeometry {
    /// The sheet of a design.
    pub fn new(design: &Design) -> Self {
        Self {
            warps: design.sheet.warps,
            wefts: design.sheet.wefts,
            pitch_x_mm: design.sheet.pitch_x(),
            pitch_y_mm: design.sheet.pitch_y(),
            region: None,
        }
    }
}

impl LooksInputs {
    fn new(design: &Design) -> Self {
        Self {
            chart: design.chart.clone(),
            length: design.length.clone(),
            pile: design.pile.clone(),
            bounces: design.quality.bounces,
            ground: design.skeleton.colour,
            wetness: design.finish.wetness,
            sheared: design.finish.sheared,
            seed: design.turbulence.seed,
        }
    }
}

impl VolumesInputs {
    /// The volumes' pile is the design's with everything that only concerns frames and light at its default, so that
    /// volumes cannot depend on it.
    fn new(design: &Design, materials: &Materials, optics: &PileOptics) -> Self {
        let defaults = Pile::default();
        let reference_length_mm = design.length.longest().min(design.pile.max_length);
        let pile = Pile {
            top_width: defaults.top_width,
            // Materials tell the kinds and diameters.
            kind: defaults.kind,
            yarn_diameter: defaults.yarn_diameter,
            density: defaults.density,
            max_albedo: defaults.max_albedo,
            max_length: defaults.max_length,
            lean_x: defaults.lean_x,
            lean_y: defaults.lean_y,
            tilt: defaults.tilt,
            twist: defaults.twist,
            stretch: defaults.stretch,
            jitter: defaults.jitter,
            twist_jitter: defaults.twist_jitter,
            length_jitter: defaults.length_jitter,
            transmission: defaults.transmission,
            specular: defaults.specular,
            exponent: defaults.exponent,
            // Only fibres need their directions in the volumes.
            phase: if optics.has(Phase::KajiyaKay) {
                Phase::KajiyaKay
            } else {
                defaults.phase
            },
            ..wet_pile(&design.pile, design.finish.wetness)
        };
        Self {
            pile,
            yarns: materials.yarns.clone(),
            reference_length_mm,
        }
    }

    fn build(&self, cancel: &Cancel<'_>) -> Volumes {
        rasterise_unless_cancelled(&self.pile, &self.yarns, self.reference_length_mm, cancel)
    }
}
