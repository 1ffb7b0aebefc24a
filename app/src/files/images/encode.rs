//! Files of pixels as they are kept: what is read from one is the same image.

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use renderer_core::design::{EnvironmentImage, HeightImage, ImagePixels};
use renderer_core::image::{encode_chart_png, encode_exr_channels};

/// A file of pixels as they are kept, and its ending: what is read from it is the same image.
pub(in crate::files) fn encode_image(
    pixels: &ImagePixels,
) -> Result<(Vec<u8>, &'static str), String> {
    match pixels {
        ImagePixels::Colours(image) => encode_chart_png(image, &[])
            .map(|bytes| (bytes, "png"))
            .map_err(|error| error.to_string()),
        ImagePixels::Light(image) => encode_environment(image)
            .map(|bytes| (bytes, "exr"))
            .map_err(|error| error.to_string()),
        ImagePixels::Heights(image) => encode_height(image)
            .map(|bytes| (bytes, "png"))
            .map_err(|error| error.to_string()),
    }
}

/// A PNG of a height picture, 16 bits a pixel.
fn encode_height(picture: &HeightImage) -> Result<Vec<u8>, ImageError> {
    let bytes: Vec<u8> = picture
        .greys()
        .iter()
        .flat_map(|g| g.to_ne_bytes())
        .collect();
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(&bytes, width, height, ExtendedColorType::L16)?;
    Ok(file)
}

/// An EXR of the surroundings as they are kept.
fn encode_environment(
    environment: &EnvironmentImage,
) -> Result<Vec<u8>, renderer_core::image::ImageError> {
    let size = [environment.width() as u32, environment.height() as u32];
    let channel = |c: usize| environment.pixels().iter().map(|pixel| pixel[c]).collect();
    let channels = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    encode_exr_channels(size, channels)
}
