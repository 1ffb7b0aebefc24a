//! The fast renderer on all processor cores, for machines without a GPU: `single`, `layered` and `tracked` in f32, held
//! to [`mod@crate::reference`] by the same samples and the same means.
//!
//! ```text
//! transport ──► medium ──► form: segments ──► composite (single, layered) or tracked
//!                                               ├──► walk over blocks ──► block: listed loops ──► patch, frames
//!                                               ├──► ground: cells of the weave
//!                                               └──► crossing: slabs ──► volume: voxels
//! ```
//!
//! What makes it fast: coordinates relative to the block a ray is in, so that f32 is enough; 16-byte shapes decoded
//! where they are needed instead of frames in memory; loops solved once a ray; ground yarns looked for only in their
//! layer; voxels stored by fours. Everything that is left out has a name in [`crate::render::Optimisation`].

mod backend;
mod batch;
mod block;
mod block_ray;
mod candidates;
mod cloth;
mod composite;
mod crossing;
mod event;
mod form;
mod frames;
mod ground;
mod lanes;
mod mailbox;
mod medium;
mod patch;
mod scratch;
mod tracer;
mod tracked;
mod vertex;
mod volume;
mod walk;
mod wide;

pub use backend::CpuBackend;
pub use lanes::Instructions;
pub use scratch::Scratch;
pub use tracer::Tracer;
