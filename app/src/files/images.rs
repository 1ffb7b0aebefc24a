//! Reading charts and pictures of the surroundings.

use std::fs;
use std::io::BufReader;
use std::path::Path;

use exr::prelude::{MetaData, Vec2, read_first_rgba_layer_from_file};
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};
use renderer_core::design::{
    ChartImage, EnvironmentFault, EnvironmentImage, EnvironmentReader, srgb_to_linear,
};

use super::FileError;

/// Most memory that decoding a chart may take, bytes: a chart of the largest size with 16 bits a channel.
const CHART_MEMORY: u64 = (ChartImage::MAX_SIDE * ChartImage::MAX_SIDE * 8) as u64 + (16 << 20);

/// Most memory that decoding a picture of the surroundings may take, bytes: the largest with 16 bytes a pixel.
const ENVIRONMENT_MEMORY: u64 =
    (EnvironmentImage::MAX_WIDTH * EnvironmentImage::MAX_WIDTH / 2 * 16) as u64 + (16 << 20);

/// Reads a chart image: PNG or JPEG, sides up to [`ChartImage::MAX_SIDE`].
///
/// # Errors
/// When it cannot be read, is something else or is too large.
pub fn load_chart(path: &Path) -> Result<ChartImage, FileError> {
    let fault = |what: String| FileError::Chart {
        path: path.to_owned(),
        what,
    };
    let open = || {
        ImageReader::open(path)
            .and_then(ImageReader::with_guessed_format)
            .map_err(|error| fault(format!("cannot be read: {error}")))
    };
    let mut reader = open()?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err(fault("is neither a PNG nor a JPEG file".into()));
    }
    let broken = |error: ImageError| fault(format!("is broken: {error}"));
    let (width, height) = open()?.into_dimensions().map_err(broken)?;
    let most = ChartImage::MAX_SIDE;
    if width as usize > most || height as usize > most {
        return Err(fault(format!(
            "has {width} x {height} pixels, allowed are at most {most} x {most}"
        )));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(CHART_MEMORY);
    reader.limits(limits);
    let pixels = reader.decode().map_err(broken)?.into_rgba8();
    let pixels: Vec<[u8; 4]> = pixels.pixels().map(|pixel| pixel.0).collect();
    ChartImage::new(width as usize, height as usize, &pixels)
        .ok_or_else(|| fault("has no pixels".into()))
}

/// Reads a picture of the surroundings: Radiance HDR or OpenEXR with linear light, or PNG or JPEG, taken as sRGB;
/// equirectangular, at most [`EnvironmentImage::MAX_WIDTH`] wide.
///
/// # Errors
/// When it cannot be read, is something else, has another proportion, is too large or has pixels that are no numbers.
pub fn load_environment(path: &Path) -> Result<EnvironmentImage, FileError> {
    read_environment(path).map_err(|what| FileError::Environment {
        path: path.to_owned(),
        what,
    })
}

fn read_environment(path: &Path) -> Result<EnvironmentImage, String> {
    // Without its name, which may promise what the content is not.
    let open = || {
        let file = fs::File::open(path);
        file.and_then(|file| ImageReader::new(BufReader::new(file)).with_guessed_format())
            .map_err(|error| format!("cannot be read: {error}"))
    };
    let broken = |error: ImageError| format!("is broken: {error}");
    let mut reader = open()?;
    match reader.format() {
        Some(ImageFormat::OpenExr) => return read_exr_environment(path),
        Some(ImageFormat::Hdr | ImageFormat::Png | ImageFormat::Jpeg) => {}
        _ => return Err("is none of .hdr, .exr, .png and .jpg".into()),
    }
    let (width, height) = open()?.into_dimensions().map_err(broken)?;
    let told = |fault: EnvironmentFault| fault.to_string();
    let mut environment = EnvironmentReader::new(width as usize, height as usize).map_err(told)?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(ENVIRONMENT_MEMORY);
    reader.limits(limits);
    match reader.decode().map_err(broken)? {
        DynamicImage::ImageRgb32F(linear) => {
            for (x, y, pixel) in linear.enumerate_pixels() {
                environment.add(x as usize, y as usize, pixel.0);
            }
        }
        encoded => {
            let linear: Vec<f32> = (0..=u16::MAX)
                .map(|value| srgb_to_linear(f64::from(value) / 65535.0) as f32)
                .collect();
            for (x, y, pixel) in encoded.into_rgb16().enumerate_pixels() {
                let colour = pixel.0.map(|value| linear[usize::from(value)]);
                environment.add(x as usize, y as usize, colour);
            }
        }
    }
    environment.finish().map_err(told)
}

/// Channels R, G and B of the first layer that has them; alpha is left out.
fn read_exr_environment(path: &Path) -> Result<EnvironmentImage, String> {
    let broken = |error: exr::error::Error| format!("is broken: {error}");
    // Asked first: decoding what is too large would take its time.
    for header in MetaData::read_from_file(path, false)
        .map_err(broken)?
        .headers
    {
        let Vec2(width, height) = header.layer_size;
        if width > EnvironmentImage::MAX_WIDTH || height > EnvironmentImage::MAX_WIDTH / 2 {
            return Err(EnvironmentFault::Size { width, height }.to_string());
        }
    }
    let image = read_first_rgba_layer_from_file(
        path,
        |Vec2(width, height), _| EnvironmentReader::new(width, height),
        |environment, Vec2(x, y), (r, g, b, _): (f32, f32, f32, f32)| {
            if let Ok(environment) = environment {
                environment.add(x, y, [r, g, b]);
            }
        },
    )
    .map_err(broken)?;
    image
        .layer_data
        .channel_data
        .pixels
        .and_then(EnvironmentReader::finish)
        .map_err(|fault| fault.to_string())
}
