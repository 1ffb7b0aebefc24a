//! What the file of a picture says of itself, in the standard places of its format.

use exr::meta::attribute::{Chromaticities, Text};
use exr::meta::header::Header;
use exr::prelude::Vec2;
use png::{PixelDimensions, SrgbRenderingIntent, Unit};

use super::ImageError;

/// Inches of a metre.
const INCHES_PER_METRE: f64 = 1.0 / 0.0254;

/// What is said of a picture, beside its pixels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct About {
    /// What it shows.
    pub title: Option<String>,
    /// What made it.
    pub software: Option<String>,
    /// What was done to it: that it is denoised, by what, and how far it is from what it was.
    pub comment: Option<String>,
    /// Pixels an inch, where the picture has a size on paper.
    pub dots_per_inch: Option<f64>,
}

impl About {
    /// Writes it into a PNG whose pixels are sRGB: chunks `sRGB`, `pHYs` (pixels a metre) and texts `Title`,
    /// `Software` and `Comment`.
    pub(super) fn describe_png<W: std::io::Write>(
        &self,
        encoder: &mut png::Encoder<'_, W>,
    ) -> Result<(), ImageError> {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        if let Some(dots) = self.dots_per_inch {
            let per_metre = (dots * INCHES_PER_METRE).round() as u32;
            encoder.set_pixel_dims(Some(PixelDimensions {
                xppu: per_metre,
                yppu: per_metre,
                unit: Unit::Meter,
            }));
        }
        let texts = [
            ("Title", &self.title),
            ("Software", &self.software),
            ("Comment", &self.comment),
        ];
        for (keyword, text) in texts {
            let Some(text) = text else { continue };
            let text: String = text.chars().filter(|c| !c.is_control()).collect();
            // `tEXt` is Latin-1.
            if text.chars().all(|c| u32::from(c) < 256) {
                encoder.add_text_chunk(keyword.into(), text)?;
            } else {
                encoder.add_itxt_chunk(keyword.into(), text)?;
            }
        }
        Ok(())
    }

    /// Writes it into an OpenEXR header of linear RGB with the primaries of sRGB: attributes `chromaticities`,
    /// `xDensity` (pixels an inch), `software` and `comments`. There is none for a title.
    pub(super) fn describe_exr(&self, header: &mut Header) {
        header.shared_attributes.chromaticities = Some(Chromaticities {
            red: Vec2(0.64, 0.33),
            green: Vec2(0.3, 0.6),
            blue: Vec2(0.15, 0.06),
            white: Vec2(0.3127, 0.329),
        });
        header.own_attributes.horizontal_density = self.dots_per_inch.map(|dots| dots as f32);
        let text = |text: &Option<String>| {
            let text = text.as_ref();
            text.map(|text| Text::from_bytes_unchecked(text.as_bytes().into()))
        };
        header.own_attributes.software_name = text(&self.software);
        header.own_attributes.comments = text(&self.comment);
    }
}
