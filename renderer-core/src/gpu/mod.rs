//! The GPU renderer: wgpu compute, in f32, on any adapter with compute shaders.
//!
//! A [`Scene`](crate::scene::Scene) is uploaded section by section (a section that is the same `Arc` as before keeps its
//! buffers), and samples are added to an accumulation in slices of tiles × samples under a time budget. The mean is
//! resolved on the device: to a display texture for a window, or to linear pixels that are read back.
//!
//! - [`adapters`]: what this machine has. [`context`]: device and queue, own or another's. [`DeviceWatch`]: whether it is lost. [`layout`]: the only mirrors of WGSL structs.
//! - [`shaders`]: the files of shaders/ put together. [`needs`]: what of them a scene uses. `pipelines`: the programs; `builder`: the
//!   thread that compiles tracing pipelines; `kept`: compiled ones that outlive the program.
//! - `upload`: a scene's buffers and textures. `accumulation`: the sums. `schedule`: what to draw next, and how much.
//! - `readback`: pictures, error estimate and counters back on the host. [`backend`]: all of it as a
//!   [`Backend`](crate::render::Backend).
//!
//! The paper's §6 lists six steps: 1 and 2 are [`crate::scene`]'s, 3 to 6 are named in shaders/trace.wgsl.

mod accumulation;
mod adapters;
pub mod backend;
mod builder;
pub mod context;
mod highlight;
mod kept;
pub mod layout;
pub mod needs;
mod pipelines;
mod readback;
mod schedule;
pub mod shaders;
mod shadow_memory;
mod upload;
mod watch;

pub use adapters::{AdapterSummary, adapters};
pub use backend::GpuBackend;
pub use context::GpuContext;
pub use kept::wanted_features;
pub use watch::DeviceWatch;
