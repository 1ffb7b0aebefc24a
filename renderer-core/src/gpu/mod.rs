//! The GPU renderer: wgpu compute, in f32, on any adapter with compute shaders.
//!
//! A [`Scene`](crate::scene::Scene) is uploaded section by section (a section that is the same `Arc` as before keeps
//! its buffers), and samples are added to an accumulation in slices of tiles × samples under a time budget. The mean is
//! resolved on the device: to a display texture for a window, or to linear pixels that are read back.
//!
//! - [`adapters`]: what this machine has. [`context`]: device and queue, own or another's. [`DeviceWatch`]: whether it
//!   is lost.
//! - [`layout`]: the only mirrors of WGSL structs. [`constants`]: numbers that both sides share. `bindings`: what
//!   programs are bound to.
//! - [`shaders`]: the files of shaders/ put together; [`dead_branches`]: without what a pipeline does not use.
//!   `program`: one of them on the device. [`pipeline_key`]: what of the tracing program a scene uses. `pipelines`: all
//!   programs; `pipeline_compiler`: the thread that compiles tracing pipelines; `pipeline_cache`: compiled ones that
//!   outlive the program.
//! - `scene_bindings`: what of a scene is bound, in one table, with `scene_constants` and `scene_textures`. `upload`: a
//!   scene on the device. `accumulation`: the sums. `schedule`: what to draw next, and how much. `work`: a picture in
//!   the making.
//! - `readback`: pictures, error estimate and counters back on the host. [`backend`]: all of it as a
//!   [`Backend`](crate::render::Backend).
//!
//! The paper's §6 lists six steps: 1 and 2 are [`crate::scene`]'s, 3 to 6 are named in shaders/trace.wgsl.

mod accumulation;
mod adapters;
pub mod backend;
mod bindings;
pub mod constants;
pub mod context;
pub mod dead_branches;
mod highlight;
pub mod layout;
mod pipeline_cache;
mod pipeline_compiler;
pub mod pipeline_key;
mod pipelines;
mod program;
mod readback;
mod scene_bindings;
mod scene_constants;
mod scene_textures;
mod schedule;
pub mod shaders;
mod shadow_memory;
mod upload;
mod watch;
mod work;

pub use adapters::{AdapterSummary, adapters};
pub use backend::GpuBackend;
pub use context::GpuContext;
pub use pipeline_cache::wanted_features;
pub use watch::DeviceWatch;
