//! Pictures as bytes of files: PNG (as displayed) and OpenEXR (linear).

use std::io::{self, Cursor};

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, WritableImage};
use exr::prelude::{LayerAttributes, SmallVec};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::rows::{PngLook, write_png_rows};
use super::{About, Aov, Display, Picture};

/// Why a picture could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The PNG encoder failed.
    #[error("PNG: {0}")]
    Png(#[from] image::ImageError),
    /// Rows and header do not fit together.
    #[error("{0}")]
    Rows(&'static str),
    /// A PNG could not be encoded, or its file could not take it.
    #[error("PNG: {0}")]
    Encoding(#[from] png::EncodingError),
    /// The EXR encoder failed.
    #[error("EXR: {0}")]
    Exr(#[from] exr::error::Error),
}

impl ImageError {
    /// Why the file could not take the picture, if that was it.
    ///
    /// # Errors
    /// Gives itself back if it was something else.
    pub fn into_io(self) -> Result<io::Error, Self> {
        match self {
            Self::Encoding(png::EncodingError::IoError(error))
            | Self::Exr(exr::error::Error::Io(error))
            | Self::Png(image::ImageError::IoError(error)) => Ok(error),
            other => Err(other),
        }
    }
}

/// Bits of a PNG's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits a channel.
    Eight,
    /// 16 bits a channel.
    Sixteen,
}

/// A PNG of the picture as displayed. With `transparent`, the background is left out and alpha (straight, not
/// premultiplied, as PNG has it) says how much of a pixel is cloth.
///
/// # Errors
/// When the encoder refuses.
pub fn encode_png(
    picture: &Picture,
    display: Display,
    depth: Depth,
    transparent: Option<Background>,
) -> Result<Vec<u8>, ImageError> {
    let about = About::default();
    let look = PngLook {
        display,
        depth,
        transparent,
        about: &about,
        chunks: &[],
    };
    let mut file = Vec::new();
    write_png_rows(&mut file, picture.size, &look, || {
        Ok::<_, ImageError>(picture)
    })?;
    Ok(file)
}

/// A PNG of gray values with straight alpha, row 0 at the top.
///
/// # Errors
/// When the encoder refuses.
pub fn encode_png_gray_alpha(size: [u32; 2], pixels: &[[u8; 2]]) -> Result<Vec<u8>, ImageError> {
    let mut file = Vec::new();
    let [width, height] = size;
    let bytes = pixels.as_flattened();
    PngEncoder::new(&mut file).write_image(bytes, width, height, ExtendedColorType::La8)?;
    Ok(file)
}

/// Linear colour behind the cloth, which transparent files leave out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Background(pub [f64; 3]);

impl Background {
    /// Light of the cloth alone, premultiplied with its coverage.
    pub(super) fn removed(self, rgb: [f32; 3], alpha: f32) -> [f32; 3] {
        let Self(background) = self;
        std::array::from_fn(|c| (rgb[c] - (1.0 - alpha) * background[c] as f32).max(0.0))
    }
}

/// Extra channels of an EXR file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ExrLayer {
    /// `depth.Z`: distance from the eye, mm.
    Depth,
    /// `normal.X`, `normal.Y`, `normal.Z`: world space.
    Normal,
    /// `albedo.R`, `albedo.G`, `albedo.B`.
    Albedo,
    /// `alpha.A`: share of the pixel that cloth covers.
    Alpha,
    /// `noisy.R`, `noisy.G`, `noisy.B`: the colours before denoising.
    Noisy,
}

/// An OpenEXR file of linear radiance in f32: channels `R`, `G`, `B`, with `transparent` also `A` (then the background
/// is left out and colours are premultiplied, as EXR has it), and the channels of `layers` that the picture has.
///
/// # Errors
/// When the encoder refuses.
pub fn encode_exr(
    picture: &Picture,
    layers: &[ExrLayer],
    transparent: Option<Background>,
) -> Result<Vec<u8>, ImageError> {
    encode_exr_channels(picture.size, exr_channels(picture, layers, transparent))
}

/// Names and values of the channels of a picture, or of some of its rows.
pub(super) fn exr_channels(
    picture: &Picture,
    layers: &[ExrLayer],
    transparent: Option<Background>,
) -> Vec<(&'static str, Vec<f32>)> {
    let colour = |c: usize| -> Vec<f32> {
        picture
            .pixels
            .iter()
            .map(|&[r, g, b, alpha]| match transparent {
                Some(background) => background.removed([r, g, b], alpha)[c],
                None => [r, g, b][c],
            })
            .collect()
    };
    let alpha = || -> Vec<f32> { picture.pixels.iter().map(|pixel| pixel[3]).collect() };
    let mut channels = vec![("R", colour(0)), ("G", colour(1)), ("B", colour(2))];
    if transparent.is_some() {
        channels.push(("A", alpha()));
    }
    for layer in layers {
        match (layer, &picture.aov) {
            (ExrLayer::Alpha, _) => channels.push(("alpha.A", alpha())),
            (_, None) => {}
            (ExrLayer::Depth, Some(Aov { depth, .. })) => channels.push(("depth.Z", depth.clone())),
            (ExrLayer::Normal, Some(Aov { normal, .. })) => {
                channels.extend(split(["normal.X", "normal.Y", "normal.Z"], normal));
            }
            (ExrLayer::Albedo, Some(Aov { albedo, .. })) => {
                channels.extend(split(["albedo.R", "albedo.G", "albedo.B"], albedo));
            }
            (ExrLayer::Noisy, Some(Aov { noisy, .. })) => {
                let names = ["noisy.R", "noisy.G", "noisy.B"];
                let Some(background) = transparent else {
                    channels.extend(split(names, noisy));
                    continue;
                };
                let pixels = noisy.iter().zip(&picture.pixels);
                let removed: Vec<_> = pixels
                    .map(|(&rgb, pixel)| background.removed(rgb, pixel[3]))
                    .collect();
                channels.extend(split(names, &removed));
            }
        }
    }
    channels
}

fn split<'a>(names: [&'a str; 3], values: &[[f32; 3]]) -> [(&'a str, Vec<f32>); 3] {
    std::array::from_fn(|c| (names[c], values.iter().map(|value| value[c]).collect()))
}

/// An OpenEXR file of named f32 channels, row 0 at the top.
///
/// # Errors
/// When the encoder refuses.
pub fn encode_exr_channels(
    size: [u32; 2],
    channels: Vec<(&str, Vec<f32>)>,
) -> Result<Vec<u8>, ImageError> {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values)))
        .collect();
    let layer = Layer::new(
        (size[0] as usize, size[1] as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut file)?;
    Ok(file.into_inner())
}
