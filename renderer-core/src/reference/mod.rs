//! The plain renderer: scalar f64, written from the model's equations (MODEL.md §5 to §9); what the others are held to.
//!
//! §6 of the paper (Yi Wang, "A Layered Method for Realistic Rendering of Towels and Carpets") has six steps. Steps 1
//! and 2, skeleton and loop frames, are [`crate::scene`]'s. For each ray:
//!
//! - step 3, reflection of the yarn loops the ray crosses: `single` and `layered` find the crossings of a loop, `exact`
//!   and `six_face` its parts inside the loop; [`crate::optics`] says how the chosen point scatters;
//! - step 4, transmission through the loops: `first_event` composites crossings front to back, and shadow rays
//!   multiply what they let through; `march` does both piece by piece, `tracked` with random free paths instead;
//! - step 5, the skeleton and the loops on its other side, seen through its gaps: `skeleton`, and the one grid
//!   walk (`walk`) over loops of both faces;
//! - step 6, the sum of all these: [`PathTracer`](crate::transport::PathTracer), which meets the cloth by `medium`.
//!
//! Cloth that is bent is met segment by segment: `form`. Frames of loops are made once, and nothing is skipped beyond
//! what the blocks' lists say of where loops are and, for `tracked`, the part of a ray that can be in a loop, so that
//! it stays plain.

mod backend;
mod exact;
mod first_event;
mod form;
mod layered;
mod lookup;
mod march;
mod medium;
mod scratch;
mod single;
mod six_face;
mod skeleton;
mod tracer;
mod tracked;
mod volume;
mod walk;

pub use backend::ReferenceBackend;
pub use scratch::Scratch;
pub use skeleton::{SkeletonHit, Yarns};
pub use tracer::Tracer;
pub use walk::{Grid, LoopPlace, Span};
