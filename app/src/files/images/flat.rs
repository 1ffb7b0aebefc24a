//! Pictures of colours as displayed: decoded, turned upright, and handed over as colours in sRGB, as the yarns of a
//! palette, or as the numbers that the file has.

use std::borrow::Cow;
use std::io::Cursor;

use image::metadata::Orientation;
use image::{
    DynamicImage, GrayAlphaImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits,
    RgbaImage,
};
use renderer_core::design::OPAQUE_FROM;

use super::jpeg::{self, Survey};
use super::palette::{self, Palette};
use super::profile::{self, Profile};
use super::{png, tiff};

/// A picture as its file has it, upright.
pub(super) struct Flat {
    pixels: Pixels,
    profile: Profile,
}

/// What the pixels are.
enum Pixels {
    /// Red, green and blue, or grey, of 8 or 16 bits; linear light where they are floating-point numbers.
    Colours(DynamicImage),
    /// Cyan, magenta, yellow and black in the four channels, from no ink to all of it.
    Inks(DynamicImage),
    /// Numbers of palette entries, with alpha.
    Numbers(GrayAlphaImage, Palette),
}

impl Flat {
    /// Reads a picture whose size (upright) `check_size` allows, with at most `memory` bytes. `notes` takes ends of
    /// sentences about what is damaged or could not be understood.
    ///
    /// # Errors
    /// When it is broken, too large, or of a kind that is not read.
    pub(super) fn read(
        format: ImageFormat,
        bytes: &[u8],
        check_size: impl Fn([usize; 2]) -> Result<(), String>,
        memory: u64,
        notes: &mut Vec<String>,
    ) -> Result<Self, String> {
        let survey = (format == ImageFormat::Jpeg).then(|| jpeg::survey(bytes));
        let plan = Plan::of(format, bytes, survey.as_ref());
        let mut decoder = match plan.format == format {
            true => decoder_of(format, &plan.file, memory)?,
            false => decoder_of(format, bytes, memory)?,
        };
        let orientation = orientation(format, bytes, &mut decoder);
        let (width, height) = decoder.dimensions();
        let [width, height] = [width as usize / plan.pixels_per_number(), height as usize];
        check_size(match orientation {
            Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH => [height, width],
            _ => [width, height],
        })?;
        let profile = Profile::of(format, bytes, &mut decoder, survey.as_ref());
        let image = match plan.format == format {
            true => decoded(decoder, memory)?,
            false => decoded(decoder_of(plan.format, &plan.file, memory)?, memory)?,
        };
        let mut pixels = plan.then.pixels(image);
        if survey.is_some_and(|survey| !survey.is_whole) {
            notes.push(
                "ends in the middle of its picture: what is missing is grey or blurred".into(),
            );
        }
        pixels.turn(orientation);
        Ok(Self { pixels, profile })
    }

    /// The colours of a chart, in sRGB; of a palette each entry that is used is a colour of its own.
    pub(super) fn yarns(self, notes: &mut Vec<String>) -> Result<RgbaImage, String> {
        match self.pixels {
            Pixels::Numbers(numbers, mut palette) => {
                palette.convert(&self.profile, notes);
                let mut used = [false; 256];
                for pixel in numbers.pixels() {
                    let [number, _] = pixel.0;
                    used[usize::from(number)] |= palette.colour(pixel.0)[3] >= OPAQUE_FROM;
                }
                palette.tell_apart(&used);
                Ok(palette.colours_of(&numbers))
            }
            Pixels::Colours(image) => {
                refuse_light(&image)?;
                Ok(self.profile.to_srgb(image, notes).into_rgba8())
            }
            Pixels::Inks(image) => Ok(self.profile.inks_to_srgb(image, notes).into_rgba8()),
        }
    }

    /// The numbers of the file, whatever colours they are meant to be.
    pub(super) fn data(self, notes: &mut Vec<String>) -> Result<DynamicImage, String> {
        match self.pixels {
            Pixels::Numbers(numbers, palette) => Ok(palette.colours_of(&numbers).into()),
            Pixels::Colours(image) => {
                refuse_light(&image)?;
                Ok(image)
            }
            Pixels::Inks(image) => Ok(self.profile.inks_to_srgb(image, notes)),
        }
    }

    /// Colours in sRGB, of 16 bits where they had to be converted; floating-point numbers stay linear light.
    pub(super) fn deep_colours(self, notes: &mut Vec<String>) -> DynamicImage {
        let image = match self.pixels {
            Pixels::Numbers(numbers, palette) => palette.colours_of(&numbers).into(),
            Pixels::Inks(image) => return self.profile.inks_to_srgb(image, notes),
            Pixels::Colours(image) => image,
        };
        if is_light(&image) || self.profile.is_srgb() {
            return image;
        }
        self.profile.to_srgb(profile::deepened(image), notes)
    }
}

/// What its decoder is to be given of a file, so that it tells what the file has.
struct Plan<'a> {
    format: ImageFormat,
    file: Cow<'a, [u8]>,
    then: Then,
}

/// What is to be made of the pixels that come out.
enum Then {
    Colours,
    Inks,
    /// Inks of a JPEG whose Adobe segment has this transform.
    JpegInks(Option<u8>),
    Numbers(Palette, palette::Packing),
}

impl<'a> Plan<'a> {
    fn of(format: ImageFormat, bytes: &'a [u8], survey: Option<&Survey>) -> Self {
        let plan = |format, file, then| Self { format, file, then };
        if let Some(survey) = survey
            && let Some(file) = survey.inks_as_tiff(bytes)
        {
            let then = Then::JpegInks(survey.adobe_transform);
            return plan(ImageFormat::Tiff, file.into(), then);
        }
        if format == ImageFormat::Tiff
            && let Some(file) = tiff::with_inks_as_colours(bytes)
        {
            return plan(format, file.into(), Then::Inks);
        }
        match palette::find(format, bytes) {
            Some(found) => {
                let then = Then::Numbers(found.palette, found.packing);
                plan(format, found.file.into(), then)
            }
            None => plan(format, bytes.into(), Then::Colours),
        }
    }

    /// Pixels that the decoder takes for one of the picture.
    fn pixels_per_number(&self) -> usize {
        match &self.then {
            Then::Numbers(_, packing) => packing.pixels_per_number(),
            _ => 1,
        }
    }
}

impl Then {
    fn pixels(self, image: DynamicImage) -> Pixels {
        match self {
            Self::Colours => Pixels::Colours(image),
            Self::Inks => Pixels::Inks(image),
            Self::JpegInks(transform) => Pixels::Inks(jpeg::inks(image.into_rgba8(), transform)),
            Self::Numbers(palette, packing) => Pixels::Numbers(packing.numbers(image), palette),
        }
    }
}

impl Pixels {
    fn turn(&mut self, orientation: Orientation) {
        if orientation == Orientation::NoTransforms {
            return;
        }
        match self {
            Self::Colours(image) | Self::Inks(image) => image.apply_orientation(orientation),
            Self::Numbers(numbers, _) => {
                let mut image = DynamicImage::ImageLumaA8(std::mem::take(numbers));
                image.apply_orientation(orientation);
                *numbers = image.into_luma_alpha8();
            }
        }
    }
}

/// Whether pixels are floating-point numbers.
fn is_light(image: &DynamicImage) -> bool {
    matches!(
        image,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    )
}

fn refuse_light(image: &DynamicImage) -> Result<(), String> {
    if is_light(image) {
        return Err("has floating-point numbers, allowed are 8 or 16 bits a channel".into());
    }
    Ok(())
}

/// The decoder of a file, with limits.
fn decoder_of(
    format: ImageFormat,
    file: &[u8],
    memory: u64,
) -> Result<impl ImageDecoder + '_, String> {
    let mut reader = ImageReader::with_format(Cursor::new(file), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(memory);
    reader.limits(limits);
    reader.into_decoder().map_err(|error| why(&error))
}

fn decoded(decoder: impl ImageDecoder, memory: u64) -> Result<DynamicImage, String> {
    let needed = decoder.total_bytes();
    if needed > memory {
        return Err(format!(
            "takes {needed} bytes of memory, allowed are at most {memory}"
        ));
    }
    DynamicImage::from_decoder(decoder).map_err(|error| why(&error))
}

/// Why a picture could not be decoded, as the end of a sentence.
fn why(error: &ImageError) -> String {
    match error {
        ImageError::Unsupported(what) => format!("is of a kind that is not read: {what}"),
        error => format!("is broken: {error}"),
    }
}

/// How a picture must be turned to be upright.
fn orientation(format: ImageFormat, bytes: &[u8], decoder: &mut impl ImageDecoder) -> Orientation {
    let found = match format {
        // Its decoder does not see what stands behind the pixels.
        ImageFormat::Png => {
            png::chunk(bytes, *b"eXIf").and_then(|chunk| Orientation::from_exif_chunk(chunk.data))
        }
        _ => decoder.orientation().ok(),
    };
    found.unwrap_or(Orientation::NoTransforms)
}
