//! Renderer core: the towel model and everything that draws it. What a correct picture is: [`model`].
//!
#![doc = include_str!("../ARCHITECTURE.md")]

pub mod cpu;
pub mod denoise;
pub mod design;
pub mod geometry;
pub mod gpu;
pub mod image;

#[doc = include_str!("../MODEL.md")]
pub mod model {}

pub mod optics;
pub mod reference;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod transport;
