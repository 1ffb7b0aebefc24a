//! Linear pictures, their display, their files and their differences.

mod about;
mod chart_png;
pub(crate) mod display;
mod files;
pub mod metrics;
mod rows;

pub use about::About;
pub use chart_png::{encode_chart_png, png_text};
pub use display::Display;
pub use files::{
    Background, Depth, ExrLayer, ImageError, encode_exr, encode_exr_channels, encode_png,
    encode_png_gray_alpha,
};
pub use rows::{EXR_BLOCK_ROWS, ExrLook, PngLook, write_exr_rows, write_png_rows};

/// What a backend made: linear radiance, row 0 at the top.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Picture {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Linear RGB radiance (background included) and alpha: the share of the pixel that cloth covers.
    pub pixels: Vec<[f32; 4]>,
    /// Extra channels, when the request asked for them.
    pub aov: Option<Aov>,
}

/// Extra channels of a picture, each the mean over the samples that met cloth; zero where none did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Aov {
    /// Distance from the eye to the first scattering, mm.
    pub depth: Vec<f32>,
    /// Normal at the first scattering, world space: the loop's n̂ turned towards the eye, or the skeleton's normal.
    pub normal: Vec<[f32; 3]>,
    /// Albedo of the first scattering, linear.
    pub albedo: Vec<[f32; 3]>,
    /// Of a picture that is denoised, its colours before that (not only where cloth is); else nothing.
    pub noisy: Vec<[f32; 3]>,
}
