//! Denoising of a final picture, band by band.
//!
//! What the denoiser makes of a pixel depends on those around it, so that each band is given with rows of the bands above
//! and below it, or one would see where they meet; therefore a band is denoised once the next is rendered. How much
//! of the picture is denoised is measured at the first band that shows cloth, and is the same for all below.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use renderer_core::denoise::{Denoise, DenoiseError, DenoiseQuality, Mix, Step};
use renderer_core::image::Picture;

/// Rows of its neighbours that a band is denoised with.
const AROUND: usize = 64;

/// A band as it was rendered.
pub struct Band {
    /// All samples.
    pub picture: Picture,
    /// How many.
    pub samples: u32,
    /// The relRMSE that the backend estimates of it, where it does.
    pub error: Option<f64>,
    /// The picture when it had fewer, and how many.
    pub earlier: Option<(u32, Picture)>,
}

/// What was done to a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DenoisedPicture {
    /// By what, as in `Open Image Denoise 2.5.1 on CPU`.
    pub by: String,
    /// The share of the picture that is denoised; the rest is plain.
    pub share: f64,
    /// Estimated relRMSE to the truth, bias included; `None` where the samples do not tell.
    pub error: Option<f64>,
    /// relRMSE to the picture as it was before.
    pub distance: f64,
    /// How long it took.
    pub took: Duration,
}

/// What denoises a picture's bands, and what it has done so far.
pub struct Denoising {
    denoiser: Box<dyn Denoise>,
    scale: f32,
    /// The last rows of the band above, as rendered.
    above: Vec<[f32; 4]>,
    /// What the first band with cloth tells.
    mix: Option<(f64, Option<f64>)>,
    squares: f64,
    sum: f64,
    values: f64,
    took: Duration,
}

impl Denoising {
    /// White is 1 in the picture's values times `scale`.
    pub fn new(denoiser: Box<dyn Denoise>, scale: f32) -> Self {
        Self {
            denoiser,
            scale,
            above: Vec::new(),
            mix: None,
            squares: 0.0,
            sum: 0.0,
            values: 0.0,
            took: Duration::ZERO,
        }
    }

    /// The band, denoised; its extra channels tell what it was.
    pub fn denoise(
        &mut self,
        band: Band,
        below: Option<&Picture>,
        cancel: &AtomicBool,
    ) -> Result<Picture, DenoiseError> {
        let start = Instant::now();
        let Band {
            mut picture,
            samples,
            error,
            earlier,
        } = band;
        let [width, height] = picture.size.map(|side| side as usize);
        let (high, scale) = (DenoiseQuality::High, self.scale);
        let rows_above = self.above.len() / width.max(1);
        let mut pixels = std::mem::take(&mut self.above);
        pixels.extend_from_slice(&picture.pixels);
        let below = below.map_or(&[][..], |below| &below.pixels[..]);
        pixels.extend_from_slice(&below[..below.len().min(AROUND * width)]);
        let around = Picture {
            size: [picture.size[0], (pixels.len() / width.max(1)) as u32],
            pixels,
            aov: None,
        };
        let mut denoised = self.denoiser.denoise(&around, high, scale, cancel)?;
        denoised.pixels.drain(..rows_above * width);
        denoised.pixels.truncate(width * height);
        denoised.size = picture.size;
        let last_rows = height.saturating_sub(AROUND) * width;
        self.above = picture.pixels[last_rows..].to_vec();

        let aov = picture.aov.take();
        let now = Step {
            samples,
            plain: picture,
            error,
            denoised,
        };
        let (share, _) = match self.mix {
            Some(known) => known,
            None => {
                let earlier = earlier.filter(|_| error.is_some());
                let before = earlier.map(|(samples, plain)| -> Result<Step, DenoiseError> {
                    Ok(Step {
                        samples,
                        denoised: self.denoiser.denoise(&plain, high, scale, cancel)?,
                        plain,
                        error: None,
                    })
                });
                let mix = Mix::new(before.transpose()?.as_ref(), &now);
                // A band of background alone tells nothing.
                if error != Some(0.0) {
                    self.mix = Some((mix.share, mix.error));
                }
                (mix.share, mix.error)
            }
        };
        let mut made = now.mixed(share);
        let mut aov = aov.unwrap_or_default();
        aov.noisy = now
            .plain
            .pixels
            .iter()
            .map(|&[r, g, b, _]| [r, g, b])
            .collect();
        made.aov = Some(aov);
        for (after, before) in made.pixels.iter().zip(&now.plain.pixels) {
            for c in 0..3 {
                self.squares += f64::from(after[c] - before[c]).powi(2);
                self.sum += f64::from(before[c]);
                self.values += 1.0;
            }
        }
        self.took += start.elapsed();
        Ok(made)
    }

    /// Whether the next band has to tell how much is denoised.
    pub fn has_to_measure(&self) -> bool {
        self.mix.is_none()
    }

    /// What was done so far.
    pub fn done(&self) -> DenoisedPicture {
        let (share, error) = self.mix.unwrap_or((1.0, None));
        let is_black = self.sum <= 0.0;
        DenoisedPicture {
            by: self.denoiser.name(),
            share,
            error,
            distance: match is_black {
                true => 0.0,
                false => (self.squares / self.values).sqrt() / (self.sum / self.values),
            },
            took: self.took,
        }
    }
}

impl DenoisedPicture {
    /// What the file says of it.
    pub fn comment(&self, is_whole: bool) -> String {
        let share = 100.0 * self.share;
        let distance = match is_whole {
            true => format!(", relRMSE to the plain picture {:.3}", self.distance),
            false => String::new(),
        };
        let error = self
            .error
            .map_or_else(String::new, |error| format!(", estimated error {error:.3}"));
        format!(
            "Denoised by {}: {share:.0} % of the picture, the rest is plain{distance}{error}",
            self.by
        )
    }
}
