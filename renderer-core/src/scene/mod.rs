//! Scene: a design resolved into what a renderer draws, in millimetres, radians and linear light.
//!
//! [`compile`] carries out steps 1 and 2 of §6 of the paper (Yi Wang, "A Layered Method for Realistic Rendering of
//! Towels and Carpets"): the skeleton with its stitch plan, and the yarn loop frames. Every part is a [`Section`]; a
//! part whose inputs did not change keeps its `Arc`, and with it the GPU buffer made from it. All backends read the
//! same records: [`LoopShape`], [`LoopLook`], [`BlockHeader`], [`BlockEntry`] and the voxels of [`Volumes`] are the
//! scene, whatever precision a backend computes with.
//!
//! [`lod`] plans which parts of a large cloth a picture needs, and how fine.
//!
//! Geometry of a loop is relative to the centre of its own cell, so that a carpet 10⁵ cells wide looks the same in
//! its last cell as in its first.

mod albedo;
mod bounds;
mod cancel;
mod cells;
mod chart;
mod chart_composer;
mod chart_yarns;
mod compile;
mod cost;
mod curve;
mod faces;
mod finish;
mod form;
mod frames;
mod grid;
mod length;
mod lights;
pub mod lod;
mod looks;
mod loops;
mod nap;
mod noise_rows;
mod plant;
mod report;
pub mod scattering_orders;
mod skeleton;
mod turbulence;
mod types;
mod visible_cells;
mod volumes;
mod warnings;

pub use albedo::{AlbedoTable, Dye, albedo_from_reflectance};
pub use cancel::Cancel;
pub use cells::CellSet;
pub use chart::ChartOnSheet;
pub use chart_composer::ChartComposer;
pub use chart_yarns::ChartYarns;
pub use compile::{CompileError, Compiler, CompilerOptions, PreviewScene, compile};
pub use cost::costs;
pub use curve::MonotoneCurve;
pub use finish::{LoopFinish, wet_reflectance};
pub use form::{FormMesh, KUHN_TETRAHEDRA, KuhnTetrahedron, Net, TetMap, bent_box, net_through};
pub use frames::{
    FrameSettings, Jitter, LoopInput, MAX_LEAN, MAX_SKEW, MAX_TWIST, loop_hash, loop_shape,
};
pub use grid::PlantedLoop;
pub use length::{LengthRule, luma};
pub use loops::*;
pub use report::{CompileReport, SECTIONS, StageSeconds};
pub use skeleton::Face;
pub use turbulence::{CHANNELS, TurbulenceField};
pub use types::*;
pub use visible_cells::{PileReach, VisibleCells};
pub use volumes::rasterise;
pub use warnings::warnings;
