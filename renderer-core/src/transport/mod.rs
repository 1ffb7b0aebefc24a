//! Light transport on the host, once for both renderers: paths from a camera ray to radiance, and the backend that
//! draws them.
//!
//! What a ray meets in cloth is for each renderer to find by itself, so that one can be held to the other:
//! [`mod@crate::cpu`] and [`mod@crate::reference`] are each a [`Medium`]. How points scatter and what light comes from
//! where is [`crate::optics`]'s. The WGSL twin of [`PathTracer`] is shaders/trace.wgsl.

mod host_backend;
mod medium;
mod path;
mod resampling;

pub use host_backend::{HostBackend, HostTracer};
pub use medium::{Candidate, LoopPlace, MOST_CANDIDATES, Medium, PathInputs, Start};
pub use path::PathTracer;
