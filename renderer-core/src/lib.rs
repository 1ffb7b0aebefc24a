//! Renderer core: the towel model and everything that draws it.
//!
//! ```text
//! Design ──compile──► Scene ──► gpu, cpu or reference ──► accumulation ──► Picture, viewport texture
//! ```
//!
//! - [`design`]: what a user edits, and preset files.
//! - [`scene`]: a design resolved: loop frames, cell lists, loop volumes, skeleton, lights.
//! - [`geometry`], [`sampling`]: bilinear patches and random sequences, without knowledge of scenes.
//! - [`optics`]: how points scatter, and what light comes from where.
//! - [`render`]: what the backends share: request, camera, progress.
//! - [`mod@reference`]: plain scalar f64, the oracle. [`cpu`]: all cores. [`gpu`]: wgpu compute.
//! - [`image`]: pictures, their display, files and differences.

pub mod cpu;
pub mod design;
pub mod geometry;
pub mod gpu;
pub mod image;
pub mod optics;
pub mod reference;
pub mod render;
pub mod sampling;
pub mod scene;
