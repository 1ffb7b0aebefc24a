//! Colours of other colour spaces, converted to sRGB: by the ICC profile that a file carries, or by what a PNG says of
//! its colours otherwise. A picture that says nothing is sRGB.

use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageFormat, Rgb, RgbImage};
use moxcms::{
    CicpColorPrimaries, CicpProfile, ColorProfile, DataColorSpace, Layout, MatrixCoefficients,
    ToneReprCurve, TransferCharacteristics, Transform16BitExecutor, TransformOptions, XyY,
};
use rayon::prelude::*;

use super::jpeg::Survey;
use super::png::{self, Described};
use super::primaries::Primaries;
use super::tiff;

/// The colour space of a picture.
pub(super) enum Profile {
    /// sRGB, said or not.
    Srgb,
    /// Another.
    Other(Box<ColorProfile>),
    /// One that could not be read, and why.
    Unread(String),
}

impl Profile {
    /// The colour space that a file names.
    pub(super) fn of(
        format: ImageFormat,
        bytes: &[u8],
        decoder: &mut impl ImageDecoder,
        survey: Option<&Survey>,
    ) -> Self {
        let of_decoder = |decoder: &mut _, is_there: bool| {
            let icc = ImageDecoder::icc_profile(decoder).map_err(|error| error.to_string())?;
            match icc {
                Some(icc) => of_icc(&icc).map(Some),
                None if is_there => Err("it is broken".to_owned()),
                None => Ok(None),
            }
        };
        let found = match format {
            ImageFormat::Png => match png::described(bytes) {
                Described::Srgb => Ok(None),
                Described::Profile => of_decoder(decoder, true),
                Described::CodePoints(points) => of_code_points(points).map(Some),
                Described::Encoded {
                    primaries,
                    exponent,
                } => of_encoding(primaries, exponent).map(Some),
            },
            // Its decoder takes a profile that it cannot read for none.
            ImageFormat::Tiff => {
                tiff::profile(bytes).and_then(|profile| profile.map(of_icc).transpose())
            }
            ImageFormat::Bmp => of_bmp(bytes).map(of_icc).transpose(),
            _ => of_decoder(decoder, survey.is_some_and(|survey| survey.has_profile)),
        };
        match found {
            Ok(None) => Self::Srgb,
            Ok(Some(profile)) => Self::Other(Box::new(profile)),
            Err(why) => Self::Unread(why),
        }
    }

    /// Whether nothing is to be converted.
    pub(super) fn is_srgb(&self) -> bool {
        matches!(self, Self::Srgb)
    }

    /// A picture's colours in sRGB. `notes` takes what could not be understood.
    pub(super) fn to_srgb(&self, image: DynamicImage, notes: &mut Vec<String>) -> DynamicImage {
        let kind = match image.color().has_color() {
            true => Kind::Colours,
            false => Kind::Greys,
        };
        let conversion = match self {
            Self::Srgb => return image,
            Self::Unread(why) => Err(unread(why)),
            Self::Other(profile) => Conversion::new(profile, kind),
        };
        match conversion {
            Ok(conversion) if conversion.changes_nothing() => image,
            Ok(conversion) => conversion.applied(image),
            Err(why) => {
                notes.push(format!("{why}: its colours are taken as sRGB"));
                image
            }
        }
    }

    /// As [`Self::to_srgb`], of inks in the four channels, from none to all.
    pub(super) fn inks_to_srgb(&self, inks: DynamicImage, notes: &mut Vec<String>) -> DynamicImage {
        let conversion = match self {
            Self::Srgb => Err("has inks (CMYK) and no colour profile".to_owned()),
            Self::Unread(why) => Err(unread(why)),
            Self::Other(profile) => Conversion::new(profile, Kind::Inks),
        };
        match conversion {
            Ok(conversion) => conversion.applied(inks),
            Err(why) => {
                notes.push(format!("{why}: its colours are an estimate"));
                estimated(&inks)
            }
        }
    }
}

fn unread(why: &str) -> String {
    format!("has a colour profile that cannot be read ({why})")
}

/// Inks as colours without a profile: each takes its light away, black all light.
fn estimated(inks: &DynamicImage) -> DynamicImage {
    let inks = inks.to_rgba8();
    RgbImage::from_fn(inks.width(), inks.height(), |x, y| {
        let [c, m, y, k] = inks.get_pixel(x, y).0.map(u32::from);
        Rgb([c, m, y].map(|ink| (((255 - ink) * (255 - k) + 127) / 255) as u8))
    })
    .into()
}

/// A picture with 16 bits a channel.
pub(super) fn deepened(image: DynamicImage) -> DynamicImage {
    match image.color().has_color() {
        true => image.into_rgba16().into(),
        false => image.into_luma_alpha16().into(),
    }
}

fn of_icc(icc: &[u8]) -> Result<ColorProfile, String> {
    ColorProfile::new_from_slice(icc).map_err(|error| error.to_string())
}

/// The profile within a BMP of the fifth version.
fn of_bmp(bytes: &[u8]) -> Option<&[u8]> {
    let number = |at: usize| {
        let bytes = bytes.get(at..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes) as usize)
    };
    // The header follows 14 bytes; its size says its version, and the profile is so far from it.
    let is_embedded = number(14)? == 124 && bytes.get(70..74)? == b"DEBM";
    let (start, size) = (number(126)?.checked_add(14)?, number(130)?);
    is_embedded.then(|| bytes.get(start..start.checked_add(size)?))?
}

fn of_code_points([primaries, transfer, matrix, full]: [u8; 4]) -> Result<ColorProfile, String> {
    let unknown = || format!("its code points are {primaries}, {transfer}, {matrix}, {full}");
    // Code points of nothing but a matrix of 0 and the full range are allowed in a PNG.
    let is_rgb = (matrix, full) == (0, 1);
    let known = CicpColorPrimaries::try_from(primaries)
        .ok()
        .zip(TransferCharacteristics::try_from(transfer).ok());
    let (color_primaries, transfer_characteristics) =
        known.filter(|_| is_rgb).ok_or_else(unknown)?;
    let profile = ColorProfile::new_from_cicp(CicpProfile {
        color_primaries,
        transfer_characteristics,
        matrix_coefficients: MatrixCoefficients::Identity,
        full_range: true,
    });
    match profile.red_trc {
        Some(_) => Ok(profile),
        None => Err(unknown()),
    }
}

fn of_encoding(
    primaries: Option<Primaries>,
    exponent: Option<f64>,
) -> Result<ColorProfile, String> {
    let mut profile = ColorProfile::new_srgb();
    profile.cicp = None;
    if let Some(primaries) = primaries.filter(|primaries| !primaries.is_srgb()) {
        if primaries.to_srgb().is_none() {
            return Err("its chromaticities are those of no colours".into());
        }
        let [x, y] = primaries.white();
        profile.update_rgb_colorimetry(XyY { x, y, yb: 1.0 }, primaries.of_library());
    }
    if let Some(exponent) = exponent {
        if !(0.1..=10.0).contains(&exponent) {
            return Err(format!("its gamma is {exponent}"));
        }
        let curve = ToneReprCurve::Parametric(vec![(1.0 / exponent) as f32]);
        profile.red_trc = Some(curve.clone());
        profile.green_trc = Some(curve.clone());
        profile.blue_trc = Some(curve);
    }
    Ok(profile)
}

/// What the channels of a picture are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Colours,
    Greys,
    Inks,
}

/// From a colour space to sRGB. Pixels have four channels of 16 bits, before and after.
struct Conversion {
    transform: Arc<Transform16BitExecutor>,
    space: DataColorSpace,
}

impl Conversion {
    /// The conversion of pixels of a kind; an error is what is wrong, as the end of a sentence.
    fn new(profile: &ColorProfile, kind: Kind) -> Result<Self, String> {
        let space = profile.color_space;
        let (from, to) = match (space, kind) {
            (DataColorSpace::Rgb, Kind::Colours | Kind::Greys) => (Layout::Rgba, Layout::Rgba),
            (DataColorSpace::Gray, Kind::Greys) => (Layout::GrayAlpha, Layout::Rgba),
            (DataColorSpace::Cmyk, Kind::Inks) => (Layout::Rgba, Layout::Rgb),
            _ => {
                let kind = match kind {
                    Kind::Colours => "red, green and blue",
                    Kind::Greys => "grey",
                    Kind::Inks => "inks",
                };
                return Err(format!(
                    "has a colour profile for {space:?}, but its pixels are {kind}"
                ));
            }
        };
        let options = TransformOptions {
            prefer_fixed_point: false,
            ..TransformOptions::default()
        };
        let srgb = ColorProfile::new_srgb();
        let transform = profile.create_transform_16bit(from, &srgb, to, options);
        transform
            .map(|transform| Self { transform, space })
            .map_err(|error| unread(&error.to_string()))
    }

    /// Whether it changes no colour by a step of 8 bits: profiles of sRGB, which many files carry, must not change
    /// colours by what their tables round.
    fn changes_nothing(&self) -> bool {
        /// One step of 8 bits.
        const STEP: u16 = 257;
        let levels = (0..=16).map(|k| k * (u16::MAX / 16));
        let pixels: Vec<u16> = match self.space {
            DataColorSpace::Gray => levels.flat_map(|v| [v, v, v, u16::MAX]).collect(),
            _ => levels
                .clone()
                .flat_map(|r| levels.clone().map(move |g| [r, g]))
                .flat_map(|[r, g]| levels.clone().map(move |b| [r, g, b, u16::MAX]))
                .flatten()
                .collect(),
        };
        let converted = self.row(&pixels);
        let mut pairs = pixels.iter().zip(&converted);
        pairs.all(|(before, after)| before.abs_diff(*after) < STEP)
    }

    /// Converts pixels; what cannot be converted stays.
    fn row(&self, pixels: &[u16]) -> Vec<u16> {
        let (fours, _) = pixels.as_chunks::<4>();
        let mut converted = pixels.to_vec();
        let done = match self.space {
            DataColorSpace::Gray => {
                let greys: Vec<u16> = fours.iter().flat_map(|p| [p[0], p[3]]).collect();
                self.transform.transform(&greys, &mut converted)
            }
            DataColorSpace::Cmyk => {
                let mut colours = vec![0; 3 * fours.len()];
                let done = self.transform.transform(pixels, &mut colours);
                let (to, _) = converted.as_chunks_mut::<4>();
                for (to, colour) in to.iter_mut().zip(colours.chunks_exact(3)) {
                    *to = [colour[0], colour[1], colour[2], u16::MAX];
                }
                done
            }
            _ => self.transform.transform(pixels, &mut converted),
        };
        match done {
            Ok(()) => converted,
            Err(_) => pixels.to_vec(),
        }
    }

    /// Converts a picture; its channels stay as deep as they are.
    fn applied(&self, image: DynamicImage) -> DynamicImage {
        let length = 4 * image.width().max(1) as usize;
        match image {
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_) => {
                let mut image = image.into_rgba16();
                let rows = image.par_chunks_exact_mut(length);
                rows.for_each(|row| row.copy_from_slice(&self.row(row)));
                image.into()
            }
            image => {
                let mut image = image.into_rgba8();
                image.par_chunks_exact_mut(length).for_each(|row| {
                    let deep: Vec<u16> = row.iter().map(|v| u16::from(*v) * 257).collect();
                    for (to, value) in row.iter_mut().zip(self.row(&deep)) {
                        *to = ((u32::from(value) + 128) / 257) as u8;
                    }
                });
                image.into()
            }
        }
    }
}
