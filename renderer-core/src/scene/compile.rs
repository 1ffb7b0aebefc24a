//! From a design to a scene, section by section (steps 1 and 2 of the paper's §6).
//!
//! Each section has inputs; if they equal those of the last design, it keeps its `Arc`. Which parts of a design a section
//! depends on:
//!
//! | section  | sheet | weave | chart, length           | pile             | turbulence | skeleton     | light | quality |
//! | -------- | ----- | ----- | ----------------------- | ---------------- | ---------- | ------------ | ----- | ------- |
//! | sheet    | ×     |       |                         |                  |            |              |       |         |
//! | loops    | ×     | ×     | each cell's length      | shape of frames  | ×          | yarns' shape |       |         |
//! | looks    | ×     | ×     | colours, table          | optics, variants | seed       | colour       |       | bounces |
//! | volumes  |       |       | reference length, kinds | yarn, volume     |            |              |       |         |
//! | pile     |       |       | table                   | phase, density   |            |              |       |         |
//! | skeleton |       | ×     |                         |                  |            | ×            |       |         |
//! | lights   |       |       |                         |                  |            |              | ×     |         |
//!
//! The view and the rest of quality belong to requests; no section depends on them. Sections that are cheap are made
//! anew and kept when equal; loops, looks and volumes have their inputs compared.

use std::sync::Arc;

use rayon::prelude::*;

use super::cancel::{Cancel, Cancelled};
use super::chart::ChartOnSheet;
use super::frames::{FrameSettings, Jitter, LoopInput, loop_hash, loop_shape};
use super::grid::{self, NoGrid, Planted};
use super::length::{CellLengths, LengthRule};
use super::looks::{Materials, looks};
use super::skeleton::{Face, RootHeights};
use super::turbulence::TurbulenceField;
use super::volumes::rasterise_unless_cancelled;
use super::{
    Lights, LoopCounts, LoopPatch, Loops, PileOptics, Scene, Section, SheetGeometry, Skeleton,
    Volumes,
};
use crate::design::{
    Back, Chart, Colour, Design, Fault, Filter, Length, Phase, Pile, PileKind, Turbulence, Warning,
    Weave,
};

/// Why a design has no scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompileError {
    /// Values that are not allowed.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Fault>),
    /// The lists of loops in cells are too long.
    #[error(
        "pile.max_length allows {loops} loops to reach too many cells: their lists exceed {limit} entries; use shorter or wider-set pile, or less of sheet.warps and sheet.wefts"
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

/// A filter of this radius, in waves of the turbulence, still leaves a tenth of it.
const MAX_FILTER_WAVES: f64 = 0.75;

/// What a designer should know about a design and its scene.
pub fn warnings(design: &Design, scene: &Scene) -> Vec<Warning> {
    let mut warnings = design.warnings();
    let counts = scene.loops.counts;
    if counts.planted == 0 {
        let text = "no loops: the pattern, the chart and the loop length leave none";
        warnings.push(Warning::new("weave.pattern", text));
    }
    let turbulence = &design.turbulence;
    let pitch_mm = scene.sheet.pitch_x_mm.max(scene.sheet.pitch_y_mm);
    let waves = turbulence.filter_radius * pitch_mm * turbulence.frequency;
    if turbulence.filter != Filter::None && waves > MAX_FILTER_WAVES {
        let text = format!(
            "the turbulence's filter reaches over {waves:.1} of its waves, more than {MAX_FILTER_WAVES}: little of it is left but at the cloth's edges"
        );
        warnings.push(Warning::new("turbulence.filter_radius", text));
    }
    let mut tell = |count: u64, what: &str| {
        if count > 0 {
            let text = format!("{count} of {} loops {what}", counts.planted);
            warnings.push(Warning::new("pile", text));
        }
    };
    tell(counts.dropped, "were left out: their frame is degenerate");
    tell(
        counts.repaired,
        "have another top width than asked: their frame would cross itself",
    );
    warnings
}

/// Compiles one design after another and keeps what did not change.
#[derive(Debug, Default)]
pub struct Compiler {
    last: Option<Last>,
}

/// The last scene and what it was made from.
#[derive(Debug)]
struct Last {
    scene: Arc<Scene>,
    turbulence: Arc<TurbulenceField>,
    turbulence_inputs: (SheetGeometry, Turbulence),
    loops_inputs: LoopsInputs,
    looks_inputs: LooksInputs,
    volumes_inputs: VolumesInputs,
}

/// Everything that the loops' shapes follow from.
#[derive(Debug, PartialEq)]
struct LoopsInputs {
    sheet: SheetGeometry,
    weave: Weave,
    roots: RootHeights,
    lengths: CellLengths,
    frames: FrameSettings,
    turbulence: Turbulence,
}

/// Everything that the looks follow from, besides which loops there are.
#[derive(Debug, PartialEq)]
struct LooksInputs {
    chart: Chart,
    length: Length,
    pile: Pile,
    /// How much of the light comes back depends on these two: see `albedo`.
    bounces: u32,
    ground: Colour,
    seed: u32,
}

/// Everything that the volumes follow from.
#[derive(Debug, PartialEq)]
struct VolumesInputs {
    pile: Pile,
    kinds: Vec<PileKind>,
    reference_length_mm: f64,
}

impl Compiler {
    /// The scene of a design. Sections whose inputs are those of the last design keep their `Arc`; if all do, the scene
    /// is the same `Arc`.
    ///
    /// # Errors
    /// When the design has values that are not allowed, or is too large. The last scene is kept for comparison.
    pub fn compile(&mut self, design: &Design) -> Result<Arc<Scene>, CompileError> {
        self.compile_unless_cancelled(design, &Cancel::never())
    }

    /// The same, given up with [`CompileError::Cancelled`] soon after `cancel` says so.
    ///
    /// # Errors
    /// As [`Self::compile`], or when given up.
    pub fn compile_unless_cancelled(
        &mut self,
        design: &Design,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<Scene>, CompileError> {
        let faults = design.faults();
        if !faults.is_empty() {
            return Err(CompileError::Invalid(faults));
        }
        let last = self.last.as_ref();
        let old = last.map(|last| &*last.scene);

        let sheet = SheetGeometry::new(design);
        let skeleton = Skeleton::new(&design.weave, &design.skeleton);
        let materials = Materials::new(design);
        let optics = PileOptics::new(design, &materials);

        let turbulence_inputs = (sheet, design.turbulence.clone());
        let turbulence = match last.filter(|last| last.turbulence_inputs == turbulence_inputs) {
            Some(last) => Arc::clone(&last.turbulence),
            None => {
                let field = TurbulenceField::unless_cancelled(&sheet, &design.turbulence, cancel);
                Arc::new(field)
            }
        };
        cancel.check()?;

        let chart = ChartOnSheet::new(&design.chart, sheet.warps, sheet.wefts);
        let rule = LengthRule::new(&design.length);
        let loops_inputs = LoopsInputs {
            sheet,
            weave: design.weave.clone(),
            roots: RootHeights::new(&skeleton, &sheet, design.pile.base_width),
            lengths: CellLengths::new(&rule, &chart, sheet.warps, sheet.wefts),
            frames: FrameSettings::new(&design.pile),
            turbulence: design.turbulence.clone(),
        };
        let loops = match last.filter(|last| last.loops_inputs == loops_inputs) {
            Some(last) => last.scene.loops.clone(),
            None => Section::new(loops_inputs.build(&turbulence, cancel)?),
        };

        let looks_inputs = LooksInputs {
            chart: design.chart.clone(),
            length: design.length.clone(),
            pile: design.pile.clone(),
            bounces: design.quality.bounces,
            ground: design.skeleton.colour,
            seed: design.turbulence.seed,
        };
        let same_looks =
            |last: &&Last| last.looks_inputs == looks_inputs && last.scene.loops == loops;
        let looks = match last.filter(same_looks) {
            Some(last) => last.scene.looks.clone(),
            None => keep(
                old.map(|old| &old.looks),
                looks(design, &sheet, &loops, &materials, cancel),
            ),
        };
        cancel.check()?;

        let volumes_inputs = VolumesInputs::new(design, &materials);
        let volumes = match last.filter(|last| last.volumes_inputs == volumes_inputs) {
            Some(last) => last.scene.volumes.clone(),
            None => Section::new(volumes_inputs.build(cancel)),
        };
        cancel.check()?;

        let scene = Scene {
            sheet: keep(old.map(|old| &old.sheet), sheet),
            loops,
            looks,
            volumes,
            pile: keep(old.map(|old| &old.pile), optics),
            skeleton: keep(old.map(|old| &old.skeleton), skeleton),
            lights: keep(old.map(|old| &old.lights), Lights::new(&design.light)),
        };
        let scene = match last.filter(|last| *last.scene == scene) {
            Some(last) => Arc::clone(&last.scene),
            None => Arc::new(scene),
        };
        self.last = Some(Last {
            scene: Arc::clone(&scene),
            turbulence,
            turbulence_inputs,
            loops_inputs,
            looks_inputs,
            volumes_inputs,
        });
        Ok(scene)
    }

    /// The turbulence of the last scene.
    pub fn turbulence(&self) -> Option<&Arc<TurbulenceField>> {
        self.last.as_ref().map(|last| &last.turbulence)
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
        }
    }
}

impl VolumesInputs {
    /// The volumes' pile is the design's with everything that only concerns frames and light at its default, so that
    /// volumes cannot depend on it.
    fn new(design: &Design, materials: &Materials) -> Self {
        let defaults = Pile::default();
        let reference_length_mm = design.length.longest().min(design.pile.max_length);
        let pile = Pile {
            top_width: defaults.top_width,
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
            phase: match design.pile.phase {
                Phase::KajiyaKay => Phase::KajiyaKay,
                Phase::Isotropic | Phase::FrameLambert | Phase::GradientLambert => defaults.phase,
            },
            ..design.pile.clone()
        };
        Self {
            pile,
            kinds: materials.kinds.clone(),
            reference_length_mm,
        }
    }

    fn build(&self, cancel: &Cancel<'_>) -> Volumes {
        rasterise_unless_cancelled(&self.pile, &self.kinds, self.reference_length_mm, cancel)
    }
}

/// Loops of one weft.
#[derive(Default)]
struct Row {
    patches: Vec<LoopPatch>,
    warps: Vec<u32>,
    counts: LoopCounts,
}

impl LoopsInputs {
    fn build(
        &self,
        turbulence: &TurbulenceField,
        cancel: &Cancel<'_>,
    ) -> Result<Loops, CompileError> {
        let rows: Vec<Row> = (0..self.sheet.wefts)
            .into_par_iter()
            .map(|j| {
                if cancel.is_cancelled() {
                    Row::default()
                } else {
                    self.row(turbulence, j)
                }
            })
            .collect();
        cancel.check()?;
        let count = rows.iter().map(|row| row.patches.len()).sum();
        let mut planted = Planted {
            patches: Vec::with_capacity(count),
            warps: Vec::with_capacity(count),
            row_starts: Vec::with_capacity(rows.len() + 1),
            base_width_mm: self.frames.base_width as f32,
            thickness_mm: self.frames.thickness as f32,
            counts: LoopCounts::default(),
        };
        for row in rows {
            planted.row_starts.push(planted.patches.len());
            planted.patches.extend_from_slice(&row.patches);
            planted.warps.extend_from_slice(&row.warps);
            planted.counts = planted.counts.plus(row.counts);
        }
        planted.row_starts.push(planted.patches.len());
        grid::build(&self.sheet, planted, cancel).map_err(|error| match error {
            NoGrid::TooManyEntries => CompileError::TooManyEntries {
                loops: count as u64,
                limit: grid::MAX_ENTRIES,
            },
            NoGrid::Cancelled => CompileError::Cancelled,
        })
    }

    fn row(&self, turbulence: &TurbulenceField, j: u32) -> Row {
        let mut row = Row::default();
        for i in 0..self.sheet.warps {
            let (column, line) = (i as usize, j as usize);
            let faces = self.faces(i, j);
            if !faces.contains(&true) {
                continue;
            }
            let length = self.lengths.at(line * self.sheet.warps as usize + column);
            for (face, stands) in [Face::Front, Face::Back].into_iter().zip(faces) {
                if !stands {
                    continue;
                }
                let input = LoopInput {
                    face,
                    root_heights: self.roots.at(column, line, face),
                    length,
                    turbulence: turbulence.at(column, line).map(f64::from),
                    jitter: Jitter::new(loop_hash(self.turbulence.seed, i, j, face)),
                };
                if let Some(shape) = loop_shape(&self.frames, &input, &mut row.counts) {
                    row.patches.push(shape);
                    row.warps.push(i);
                }
            }
        }
        row
    }

    /// Whether a loop stands on the front and on the back of cell (i, j) (MODEL.md §2).
    fn faces(&self, i: u32, j: u32) -> [bool; 2] {
        let stitch = self.weave.pattern.stitch(i64::from(i), i64::from(j));
        let back = match self.weave.back {
            Back::Mirror => stitch.front,
            Back::Pattern => stitch.back,
            Back::None => false,
        };
        [stitch.front, back]
    }
}

impl LoopCounts {
    fn plus(self, other: Self) -> Self {
        Self {
            planted: self.planted + other.planted,
            dropped: self.dropped + other.dropped,
            repaired: self.repaired + other.repaired,
            raised: self.raised + other.raised,
            capped: self.capped + other.capped,
        }
    }
}
