//! Reading and encoding the images of a design.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use exr::prelude::{MetaData, ReadChannels, ReadLayers, Vec2, read};
use image::codecs::png::PngEncoder;
use image::{
    DynamicImage, ExtendedColorType, ImageEncoder, ImageError, ImageFormat, ImageReader, Limits,
};
use renderer_core::design::{
    ChartImage, EnvironmentFault, EnvironmentImage, EnvironmentReader, HeightImage, ImagePixels,
    ImageSlot, PixelKind, srgb_to_linear,
};
use renderer_core::image::{encode_chart_png, encode_exr_channels};

use super::FileError;

/// Most memory that decoding a chart may take, bytes: a chart of the largest size with 16 bits a channel.
const CHART_MEMORY: u64 = (ChartImage::MAX_SIDE * ChartImage::MAX_SIDE * 8) as u64 + (16 << 20);

/// Most memory that decoding a picture of the surroundings may take, bytes: the largest with 16 bytes a pixel.
const ENVIRONMENT_MEMORY: u64 =
    (EnvironmentImage::MAX_WIDTH * EnvironmentImage::MAX_WIDTH / 2 * 16) as u64 + (16 << 20);

/// Reads an image of a design, by its content, whatever its file is called:
///
/// - charts and nap maps are PNG or JPEG, sides up to [`ChartImage::MAX_SIDE`];
/// - height pictures too, sides up to [`HeightImage::MAX_SIDE`]; 16 bits are kept;
/// - pictures of the surroundings are Radiance HDR or OpenEXR with linear light, or PNG or JPEG, taken as sRGB;
///   equirectangular, at most [`EnvironmentImage::MAX_WIDTH`] wide.
///
/// # Errors
/// When it cannot be read, is something else, has another proportion, is too large or has pixels that are no numbers.
pub fn load_image(slot: ImageSlot, path: &Path) -> Result<ImagePixels, FileError> {
    read_pixels(slot.kind(), || Ok(BufReader::new(File::open(path)?))).map_err(|what| {
        FileError::Image {
            path: path.to_owned(),
            slot,
            what,
        }
    })
}

/// As [`load_image`], of a file's bytes; the error is the end of a sentence about it.
pub(super) fn decode_image(slot: ImageSlot, bytes: &[u8]) -> Result<ImagePixels, String> {
    read_pixels(slot.kind(), || Ok(Cursor::new(bytes)))
}

fn read_pixels<R: BufRead + Seek + Send>(
    kind: PixelKind,
    open: impl Fn() -> io::Result<R>,
) -> Result<ImagePixels, String> {
    match kind {
        PixelKind::Colours => read_chart(open).map(ImagePixels::Colours),
        PixelKind::Light => read_environment(open).map(ImagePixels::Light),
        PixelKind::Heights => read_height(open).map(ImagePixels::Heights),
    }
}

/// A file of pixels as they are kept, and its ending: what is read from it is the same image.
pub(super) fn encode_image(pixels: &ImagePixels) -> Result<(Vec<u8>, &'static str), String> {
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

fn read_chart<R: BufRead + Seek>(open: impl Fn() -> io::Result<R>) -> Result<ChartImage, String> {
    let pixels = read_flat(open, ChartImage::MAX_SIDE)?.into_rgba8();
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let pixels: Vec<[u8; 4]> = pixels.pixels().map(|pixel| pixel.0).collect();
    ChartImage::new(width, height, &pixels).ok_or_else(|| "has no pixels".into())
}

fn read_height<R: BufRead + Seek>(open: impl Fn() -> io::Result<R>) -> Result<HeightImage, String> {
    let pixels = read_flat(open, HeightImage::MAX_SIDE)?.into_luma_alpha16();
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let over_black = |[grey, alpha]: [u16; 2]| {
        let (grey, alpha, whole) = (u32::from(grey), u32::from(alpha), u32::from(u16::MAX));
        ((grey * alpha + whole / 2) / whole) as u16
    };
    let greys = pixels.pixels().map(|pixel| over_black(pixel.0)).collect();
    HeightImage::new(width, height, greys).ok_or_else(|| "has no pixels".into())
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

/// A PNG or a JPEG with sides of at most `most` pixels.
fn read_flat<R: BufRead + Seek>(
    open: impl Fn() -> io::Result<R>,
    most: usize,
) -> Result<DynamicImage, String> {
    let mut reader = reader_of(&open)?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("is neither a PNG nor a JPEG file".into());
    }
    let (width, height) = reader_of(&open)?.into_dimensions().map_err(broken)?;
    if width as usize > most || height as usize > most {
        return Err(format!(
            "has {width} x {height} pixels, allowed are at most {most} x {most}"
        ));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(CHART_MEMORY);
    reader.limits(limits);
    reader.decode().map_err(broken)
}

/// A reader that goes by the content, not by a name, which may promise what the content is not.
fn reader_of<R: BufRead + Seek>(
    open: &impl Fn() -> io::Result<R>,
) -> Result<ImageReader<R>, String> {
    open()
        .and_then(|file| ImageReader::new(file).with_guessed_format())
        .map_err(|error| format!("cannot be read: {error}"))
}

#[allow(clippy::needless_pass_by_value, reason = "as `map_err` hands it over")]
fn broken(error: ImageError) -> String {
    format!("is broken: {error}")
}

fn read_environment<R: BufRead + Seek + Send>(
    open: impl Fn() -> io::Result<R>,
) -> Result<EnvironmentImage, String> {
    let mut reader = reader_of(&open)?;
    match reader.format() {
        Some(ImageFormat::OpenExr) => return read_exr_environment(open),
        Some(ImageFormat::Hdr | ImageFormat::Png | ImageFormat::Jpeg) => {}
        _ => return Err("is none of .hdr, .exr, .png and .jpg".into()),
    }
    let (width, height) = reader_of(&open)?.into_dimensions().map_err(broken)?;
    let why = |fault: EnvironmentFault| fault.to_string();
    let mut environment = EnvironmentReader::new(width as usize, height as usize).map_err(why)?;
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
    environment.finish().map_err(why)
}

/// Channels R, G and B of the first layer that has them; alpha is left out.
fn read_exr_environment<R: BufRead + Seek + Send>(
    open: impl Fn() -> io::Result<R>,
) -> Result<EnvironmentImage, String> {
    let open = || open().map_err(|error| format!("cannot be read: {error}"));
    let broken = |error: exr::error::Error| format!("is broken: {error}");
    // Asked first: decoding what is too large would take its time.
    for header in MetaData::read_from_buffered(open()?, false)
        .map_err(broken)?
        .headers
    {
        let Vec2(width, height) = header.layer_size;
        if width > EnvironmentImage::MAX_WIDTH || height > EnvironmentImage::MAX_WIDTH / 2 {
            return Err(EnvironmentFault::Size { width, height }.to_string());
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |Vec2(width, height), _| EnvironmentReader::new(width, height),
            |environment, Vec2(x, y), (r, g, b, _): (f32, f32, f32, f32)| {
                if let Ok(environment) = environment {
                    environment.add(x, y, [r, g, b]);
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(open()?)
        .map_err(broken)?;
    image
        .layer_data
        .channel_data
        .pixels
        .and_then(EnvironmentReader::finish)
        .map_err(|fault| fault.to_string())
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
