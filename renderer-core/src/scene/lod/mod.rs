//! Levels of detail (MODEL.md §15): which parts of a large cloth a picture needs at which level, and the scenes made of
//! them.
//!
//! ```text
//! Design + Camera ──LodPlan──► LodRegions ──LodCompiler──► LodCloth ──view──► LodView: one Level or several,
//!                                                                                     and who shows which
//! ```
//!
//! - `region`: a rectangle of a cloth's cells at one level of detail ([`LodRegion`]), and what of a design changes with
//!   it.
//! - `visibility`: what of a sheet a camera sees, and how fine. `plan`: which regions that takes, within a budget
//!   ([`LodPlan`], [`LodBudget`]).
//! - `view`: makes them ([`LodCompiler`]), and gives each its camera ([`LodView`]).
//! - `levels`: the list of levels, never empty ([`Levels`]), and the level that each row of pixels shows
//!   ([`LodSelector`]).
//!
//! Level cloth only: bent cloth is made whole. Nothing of this is in the paper.

mod levels;
mod plan;
mod region;
mod view;
mod visibility;

pub use levels::{Level, LevelRows, Levels, LodSelector};
pub use plan::{LodBudget, LodPlan};
pub use region::{LodRegion, SPREAD};
pub use view::{LodCloth, LodCompiler, LodView};
