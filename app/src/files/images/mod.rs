//! Reading and encoding the images of a design.
//!
//! - `format`: which format a file's bytes are
//! - `flat`: pictures of colours, decoded and turned upright
//! - `palette`, `tiff`: pictures whose pixels are numbers of palette entries
//! - `profile`, `primaries`: colours of other colour spaces
//! - `jpeg`, `png`: what of these files their decoders do not tell
//! - `hdr`, `exr`: pictures of linear light
//! - `encode`: files of pixels as they are kept

mod encode;
mod exr;
mod flat;
mod format;
mod hdr;
mod jpeg;
mod palette;
mod png;
mod primaries;
mod profile;
mod tiff;

use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

use image::{DynamicImage, ImageFormat};
use renderer_core::design::{
    ChartImage, EnvironmentFault, EnvironmentImage, EnvironmentReader, HeightImage, ImagePixels,
    ImageSlot, PixelKind, srgb_to_linear,
};

use super::FileError;
use super::image_words::words;
pub(super) use encode::encode_image;
use flat::Flat;
use format::{FLAT_NAMES, Format};

/// Most memory that decoding a chart may take, bytes: a chart of the largest size with 16 bits a channel.
const CHART_MEMORY: u64 = (ChartImage::MAX_SIDE * ChartImage::MAX_SIDE * 8) as u64 + (16 << 20);

/// Most memory that decoding a picture of the surroundings may take, bytes: the largest with 16 bytes a pixel.
const ENVIRONMENT_MEMORY: u64 =
    (EnvironmentImage::MAX_WIDTH * EnvironmentImage::MAX_WIDTH / 2 * 16) as u64 + (16 << 20);

/// Largest file of pixels that is read, bytes; OpenEXR files, which are read piece by piece, may be larger. The largest
/// chart with 16 bits a channel, not compressed, fits.
const LARGEST_FILE: u64 = CHART_MEMORY + (64 << 20);

/// An image of a design, as it was read.
#[derive(Debug, Clone)]
pub struct LoadedImage {
    /// Its pixels.
    pub pixels: ImagePixels,
    /// What of the file could not be understood or is damaged, as sentences that name the file.
    pub warnings: Vec<String>,
}

/// What is read from a picture's bytes, and ends of sentences about what was wrong with them.
pub(super) struct Decoded {
    pub(super) pixels: ImagePixels,
    pub(super) notes: Vec<String>,
}

/// Reads an image of a design, by its content, whatever its file is called:
///
/// - charts are PNG, JPEG, WebP, GIF (the first picture), BMP, TIFF, TGA or PPM, sides up to [`ChartImage::MAX_SIDE`];
///   colours of other colour spaces become sRGB. Where the pixels are numbers of palette entries, each entry stays a
///   yarn of its own: of two with one colour the second is changed by the smallest step that tells them apart, since a
///   yarn of a chart is known by its colour;
/// - nap maps and height pictures are the same files, the latter with sides up to [`HeightImage::MAX_SIDE`] and 16 bits
///   where the file has them. Their numbers are data: they are taken as they are, whatever colour space the file names;
/// - pictures of the surroundings are Radiance HDR or OpenEXR with linear light, or as charts; equirectangular, at most
///   [`EnvironmentImage::MAX_WIDTH`] wide.
///
/// All are turned upright where the file says how its camera was held.
///
/// # Errors
/// When it cannot be read, is something else, has another proportion, is too large or has pixels that are no numbers.
pub fn load_image(slot: ImageSlot, path: &Path) -> Result<LoadedImage, FileError> {
    let decoded = decode_file(slot, path).map_err(|what| FileError::Image {
        path: path.to_owned(),
        slot,
        what,
    })?;
    let (place, name) = (path.display(), words(slot).name);
    let notes = decoded.notes.iter();
    Ok(LoadedImage {
        pixels: decoded.pixels,
        warnings: notes
            .map(|note| format!("{place}: {name}: {note}"))
            .collect(),
    })
}

/// As [`load_image`], of a file's bytes; errors and notes are ends of sentences about it.
pub(super) fn decode_image(slot: ImageSlot, bytes: &[u8]) -> Result<Decoded, String> {
    decode(slot, bytes, || Ok(Cursor::new(bytes)))
}

fn decode_file(slot: ImageSlot, path: &Path) -> Result<Decoded, String> {
    let failed = |error: io::Error| format!("cannot be read: {error}");
    // What is no file may never end, or wait for ever.
    let found = fs::metadata(path).map_err(failed)?;
    if !found.is_file() {
        return Err("cannot be read: it is no regular file".into());
    }
    let mut file = File::open(path).map_err(failed)?;
    let mut start = [0; 4];
    let is_exr = file.read_exact(&mut start).is_ok()
        && format::of(&start).is_ok_and(|found| found == Format::Exr);
    let mut bytes = start.to_vec();
    if !is_exr {
        let size = found.len();
        if size > LARGEST_FILE {
            return Err(format!(
                "is {size} bytes large, allowed are at most {LARGEST_FILE}"
            ));
        }
        bytes.clear();
        let whole = File::open(path).map_err(failed)?;
        let mut whole = whole.take(LARGEST_FILE);
        whole.read_to_end(&mut bytes).map_err(failed)?;
    }
    decode(slot, &bytes, || Ok(BufReader::new(File::open(path)?)))
}

/// Reads a picture of these bytes; of an OpenEXR file the start is enough, and `open` opens all of it.
fn decode<R: io::BufRead + io::Seek + Send>(
    slot: ImageSlot,
    bytes: &[u8],
    open: impl Fn() -> io::Result<R>,
) -> Result<Decoded, String> {
    let format = format::of(bytes);
    let mut notes = Vec::new();
    let pixels = match (slot.kind(), format) {
        (PixelKind::Colours, Ok(Format::Flat(format))) => {
            read_chart(slot, format, bytes, &mut notes).map(ImagePixels::Colours)
        }
        (PixelKind::Heights, Ok(Format::Flat(format))) => {
            read_height(format, bytes, &mut notes).map(ImagePixels::Heights)
        }
        (PixelKind::Light, Ok(Format::Flat(format))) => {
            read_encoded_light(format, bytes, &mut notes).map(ImagePixels::Light)
        }
        (PixelKind::Light, Ok(Format::Hdr)) => hdr::read(bytes, &mut notes).map(ImagePixels::Light),
        (PixelKind::Light, Ok(Format::Exr)) => exr::read(open).map(ImagePixels::Light),
        (_, Ok(Format::Hdr)) => Err(not_allowed(slot, Some("a Radiance HDR picture"))),
        (_, Ok(Format::Exr)) => Err(not_allowed(slot, Some("an OpenEXR picture"))),
        (_, Err(foreign)) => Err(not_allowed(slot, foreign)),
    };
    pixels.map(|pixels| Decoded { pixels, notes })
}

/// That a file has a format that is not read, and which are.
fn not_allowed(slot: ImageSlot, what: Option<&str>) -> String {
    let light = match slot.kind() {
        PixelKind::Light => ".hdr, .exr, ",
        PixelKind::Colours | PixelKind::Heights => "",
    };
    match what {
        Some(what) => format!("is {what}, allowed are {light}{FLAT_NAMES}"),
        None => format!("is none of {light}{FLAT_NAMES}"),
    }
}

fn read_chart(
    slot: ImageSlot,
    format: ImageFormat,
    bytes: &[u8],
    notes: &mut Vec<String>,
) -> Result<ChartImage, String> {
    let flat = read_flat(format, bytes, ChartImage::MAX_SIDE, notes)?;
    let pixels = match slot {
        ImageSlot::Chart | ImageSlot::Object(_) => flat.yarns(notes)?,
        _ => flat.data(notes)?.into_rgba8(),
    };
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let (pixels, _) = pixels.as_chunks::<4>();
    ChartImage::new(width, height, pixels).ok_or_else(|| "has no pixels".into())
}

fn read_height(
    format: ImageFormat,
    bytes: &[u8],
    notes: &mut Vec<String>,
) -> Result<HeightImage, String> {
    let flat = read_flat(format, bytes, HeightImage::MAX_SIDE, notes)?;
    let pixels = flat.data(notes)?.into_luma_alpha16();
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let over_black = |[grey, alpha]: [u16; 2]| {
        let (grey, alpha, whole) = (u32::from(grey), u32::from(alpha), u32::from(u16::MAX));
        ((grey * alpha + whole / 2) / whole) as u16
    };
    let greys = pixels.pixels().map(|pixel| over_black(pixel.0)).collect();
    HeightImage::new(width, height, greys).ok_or_else(|| "has no pixels".into())
}

/// A picture of colours with sides of at most `most` pixels.
fn read_flat(
    format: ImageFormat,
    bytes: &[u8],
    most: usize,
    notes: &mut Vec<String>,
) -> Result<Flat, String> {
    let check_size = |[width, height]: [usize; 2]| {
        if width > most || height > most {
            return Err(format!(
                "has {width} x {height} pixels, allowed are at most {most} x {most}"
            ));
        }
        Ok(())
    };
    Flat::read(format, bytes, check_size, CHART_MEMORY, notes)
}

/// Surroundings of colours as displayed, or of a TIFF's floating-point light.
fn read_encoded_light(
    format: ImageFormat,
    bytes: &[u8],
    notes: &mut Vec<String>,
) -> Result<EnvironmentImage, String> {
    let why = |fault: EnvironmentFault| fault.to_string();
    let check_size =
        |[width, height]: [usize; 2]| EnvironmentImage::check_size(width, height).map_err(why);
    let flat = Flat::read(format, bytes, check_size, ENVIRONMENT_MEMORY, notes)?;
    let image = flat.deep_colours(notes);
    let mut environment =
        EnvironmentReader::new(image.width() as usize, image.height() as usize).map_err(why)?;
    match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            for (x, y, pixel) in image.into_rgb32f().enumerate_pixels() {
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
