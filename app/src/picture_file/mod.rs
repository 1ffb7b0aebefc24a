//! Final pictures, rendered and written: what the export window and `render` share.
//!
//! A picture whose sums would not fit into memory (or onto the device) is made in bands, whole rows from top to bottom,
//! each rendered to its end and written before the next begins. The samples of a pixel depend on its place in the whole
//! picture alone, so a picture that stops at a number of samples has the same bits in any number of bands. The other
//! stops are shared out: each band stops at the estimated error by itself, and of the time each gets what its rows are
//! of all rows, with what the bands before it left over.
//!
//! Nothing has the file's name before everything is in it.

mod bands;
mod denoised;
mod time_left;

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use renderer_core::denoise::{Denoise, DenoiseError};
use renderer_core::image::{
    About, Background, Depth, Display, ExrLayer, ExrLook, ImageError, Picture, PngLook, metrics,
    write_exr_rows, write_png_rows,
};
use renderer_core::render::progressive::check_size;
use renderer_core::render::{Backend, Counters, RenderError, RenderRequest, Settings};
use renderer_core::scene::lod::LodView;

use crate::clock::{Spent, timed};
use crate::files::{self, Draft, FileError};
pub use bands::{BAND_BYTES, Bands};
pub use denoised::DenoisedPicture;
use denoised::{Band, Denoising};
pub use time_left::TimeLeft;

/// What kind of file to make.
#[derive(Debug, Clone, PartialEq)]
pub enum Format {
    /// As displayed.
    Png(Depth),
    /// Linear radiance, with these extra channels.
    Exr(Vec<ExrLayer>),
}

/// A picture to make.
#[derive(Debug, Clone)]
pub struct PictureOrder {
    /// The cloth and its light, and from where it is seen.
    pub view: LodView,
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// The part to make: x, y, width, height.
    pub crop: [u32; 4],
    /// How, and at how many samples and which error to stop.
    pub settings: Settings,
    /// When to stop, whatever else; but not before the first whole sample.
    pub time: Option<Duration>,
    /// The kind of file.
    pub format: Format,
    /// How a PNG shows it.
    pub display: Display,
    /// Leaves this background out.
    pub transparent: Option<Background>,
    /// What the file says of the picture.
    pub about: About,
    /// What a PNG carries beside the picture, as whole chunks.
    pub chunks: Vec<Vec<u8>>,
    /// Most bytes that the sums and the picture of a band may take.
    pub band_bytes: u64,
}

/// Where the work stands.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Standing {
    /// Share of the whole work, 0 to 1.
    pub share: f64,
    /// The band in work, from 1, and how many there are.
    pub band: [u32; 2],
    /// Whole samples of each of its pixels.
    pub samples: u32,
    /// Its estimated error.
    pub error: Option<f64>,
    /// Whether it waits for the device, which compiles what it draws with.
    pub waits_for_device: bool,
}

/// What was made.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Made {
    /// Whole samples a pixel: the fewest of any band.
    pub samples: u32,
    /// Estimated error of the whole picture.
    pub error_estimate: Option<f64>,
    /// Number of bands.
    pub bands: u32,
    /// Work done, if counted.
    pub counters: Counters,
    /// Pixels that are not finite.
    pub nonfinite_pixels: u64,
    /// Most bytes on the device.
    pub device_bytes: u64,
    /// Most bytes of a band: its sums and its picture.
    pub band_bytes: u64,
    /// Giving the scene to the backend.
    pub upload: Duration,
    /// Making pipelines.
    pub pipelines: Duration,
    /// From the start of rendering to the first whole sample of the first band.
    pub first: Duration,
    /// Adding samples.
    pub render: Spent,
    /// What denoising has done, where it was asked for.
    pub denoised: Option<DenoisedPicture>,
    /// Encoding and writing.
    pub write: Duration,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// It was asked for no longer.
    #[error("cancelled")]
    Cancelled,
    /// The backend cannot do it.
    #[error("{0}")]
    Render(#[from] RenderError),
    /// The file cannot be written.
    #[error("{0}")]
    File(#[from] FileError),
    /// The picture cannot be encoded.
    #[error("{0}")]
    Image(#[from] ImageError),
    /// It cannot be denoised.
    #[error("{0}")]
    Denoise(#[from] DenoiseError),
}

/// What the file of a picture of the design of that name says of it.
pub fn about(name: &str, dots_per_inch: Option<f64>) -> About {
    About {
        title: Some(name.to_owned()),
        software: Some(concat!("Towel Designer ", env!("CARGO_PKG_VERSION")).to_owned()),
        comment: None,
        dots_per_inch,
    }
}

/// How long a backend works between looks at the clock.
const SLICE: Duration = Duration::from_millis(100);
/// How often a wait for the device looks whether it is over.
const LOOK: Duration = Duration::from_millis(5);

/// Renders the picture, takes its noise out where there is a denoiser, and writes it to `path`; tells `tell` where it
/// stands about ten times a second.
///
/// # Errors
/// When the backend or the file refuses, or `cancel` becomes true; an old file is untouched then.
pub fn make(
    order: &PictureOrder,
    backend: &mut dyn Backend,
    denoiser: Option<Box<dyn Denoise>>,
    path: &Path,
    cancel: &AtomicBool,
    mut tell: impl FnMut(&Standing),
) -> Result<Made, Failure> {
    check_size(order.size, order.crop)?;
    let begun = Instant::now();
    let mut draft = Draft::new(path)?;
    let mut work = Work {
        order,
        backend,
        cancel,
        // What denoising needs beside the picture is about what extra channels are.
        bands: Bands::new(
            order.crop,
            order.settings.aov || denoiser.is_some(),
            order.band_bytes,
        ),
        denoising: denoiser
            .map(|denoiser| Denoising::new(denoiser, order.display.exposure.exp2() as f32)),
        next: None,
        made: Made {
            samples: u32::MAX,
            render: Spent::zero(),
            ..Made::default()
        },
        errors: Some(Errors::default()),
        begun,
    };
    let size = [order.crop[2], order.crop[3]];
    // What the file says of the picture stands before its rows.
    let mut first = Some(work.next_rows(&mut tell)?);
    let mut about = order.about.clone();
    if let Some(denoising) = &work.denoising {
        about.comment = Some(denoising.done().comment(work.bands.count() == 1));
    }
    let next = || match first.take() {
        Some(first) => Ok(first),
        None => work.next_rows(&mut tell),
    };
    match &order.format {
        Format::Png(depth) => {
            let look = PngLook {
                display: order.display,
                depth: *depth,
                transparent: order.transparent,
                about: &about,
                chunks: &order.chunks,
            };
            write_png_rows(&mut draft, size, &look, next)
        }
        Format::Exr(layers) => {
            let look = ExrLook {
                layers: layers.clone(),
                transparent: order.transparent,
                about,
            };
            write_exr_rows(&mut draft, size, &look, next)
        }
    }
    .map_err(|failure| match failure {
        Failure::Image(error) => match error.into_io() {
            Ok(source) => files::write_error(path, source).into(),
            Err(error) => Failure::Image(error),
        },
        other => other,
    })?;
    let Work {
        mut made,
        errors,
        denoising,
        ..
    } = work;
    if cancel.load(Ordering::Relaxed) {
        return Err(Failure::Cancelled);
    }
    draft.finish()?;
    made.denoised = denoising.map(|denoising| denoising.done());
    made.error_estimate = errors.and_then(|errors| errors.whole());
    made.write = begun
        .elapsed()
        .saturating_sub(made.upload + made.pipelines + made.render.wall)
        .saturating_sub(made.denoised.as_ref().map_or(Duration::ZERO, |d| d.took));
    Ok(made)
}

/// What is needed from band to band.
struct Work<'a> {
    order: &'a PictureOrder,
    backend: &'a mut dyn Backend,
    cancel: &'a AtomicBool,
    bands: Bands,
    made: Made,
    /// `None` as soon as a band has no estimate.
    errors: Option<Errors>,
    denoising: Option<Denoising>,
    /// A band that is rendered and not yet denoised.
    next: Option<Band>,
    begun: Instant,
}

impl Work<'_> {
    /// The next rows as the file gets them.
    fn next_rows(&mut self, tell: &mut impl FnMut(&Standing)) -> Result<Picture, Failure> {
        let band = match self.next.take() {
            Some(band) => band,
            None => self.next_band(tell)?,
        };
        if self.denoising.is_none() {
            return Ok(band.picture);
        }
        if self.bands.next()[3] > 0 {
            self.next = Some(self.next_band(tell)?);
        }
        let Some(denoising) = &mut self.denoising else {
            return Ok(band.picture);
        };
        let below = self.next.as_ref().map(|next| &next.picture);
        match denoising.denoise(band, below, self.cancel) {
            Err(DenoiseError::Cancelled) => Err(Failure::Cancelled),
            denoised => Ok(denoised?),
        }
    }

    /// Renders the next band to its end; a lower one if the device has no room for it.
    fn next_band(&mut self, tell: &mut impl FnMut(&Standing)) -> Result<Band, Failure> {
        let (crop, samples, error, band) = loop {
            let crop = self.bands.next();
            match self.band(crop, tell) {
                Ok((samples, error, band)) => break (crop, samples, error, band),
                Err(Failure::Render(
                    RenderError::BeyondAdapter { .. } | RenderError::OutOfMemory(_),
                )) if self.bands.make_lower() => {}
                Err(failure) => return Err(failure),
            }
        };
        let made = &mut self.made;
        made.bands += 1;
        made.samples = made.samples.min(samples);
        made.counters += self.backend.counters()?;
        made.nonfinite_pixels += metrics::nonfinite_pixels(&band.picture);
        made.device_bytes = made.device_bytes.max(self.backend.device_bytes());
        made.band_bytes = made.band_bytes.max(self.bands.bytes(crop));
        match (error, &mut self.errors) {
            (Some(error), Some(errors)) => errors.add(error, &band.picture),
            _ => self.errors = None,
        }
        self.bands.finish(crop);
        Ok(band)
    }

    /// Renders one band: its samples, its error, and itself.
    fn band(
        &mut self,
        crop: [u32; 4],
        tell: &mut impl FnMut(&Standing),
    ) -> Result<(u32, Option<f64>, Band), Failure> {
        let order = self.order;
        let request = RenderRequest {
            crop,
            ..RenderRequest::new(order.view.clone(), order.size, order.settings)
        };
        let beginning = Instant::now();
        let begun = self.backend.begin_soon(&request);
        self.made.upload += beginning.elapsed();
        begun?;
        let waiting = Instant::now();
        let ready = self.wait_for_device(crop, tell);
        self.made.pipelines += waiting.elapsed();
        ready?;
        if self.made.bands == 0 {
            // Time is that of rendering: a device's pipelines may take seconds.
            self.begun = Instant::now();
        }
        let mut spent = Spent::zero();
        let rendered = timed(&mut spent, || {
            let mut earlier = None;
            let (samples, error) = self.render(crop, &mut earlier, tell)?;
            let band = Band {
                picture: self.backend.picture()?,
                samples,
                error,
                earlier,
            };
            Ok((samples, error, band))
        });
        self.made.render += spent;
        rendered
    }

    /// Waits until the band begun can be drawn. A driver may compile for many seconds, in which nobody should have to
    /// wait who wants the picture no longer.
    fn wait_for_device(
        &mut self,
        crop: [u32; 4],
        tell: &mut impl FnMut(&Standing),
    ) -> Result<(), Failure> {
        let [share, _] = self.bands.shares(crop);
        let mut reported = None::<Instant>;
        while !self.backend.is_ready()? {
            if self.cancel.load(Ordering::Relaxed) {
                return Err(Failure::Cancelled);
            }
            if reported.is_none_or(|then| then.elapsed() >= SLICE) {
                tell(&Standing {
                    share,
                    band: [self.made.bands + 1, self.bands.count()],
                    waits_for_device: true,
                    ..Standing::default()
                });
                reported = Some(Instant::now());
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Adds samples to a band until it is done. Its samples and its error; where it tells how
    /// much is denoised, `earlier` is its state at the last power of two of samples.
    fn render(
        &mut self,
        crop: [u32; 4],
        earlier: &mut Option<(u32, Picture)>,
        tell: &mut impl FnMut(&Standing),
    ) -> Result<(u32, Option<f64>), Failure> {
        let settings = &self.order.settings;
        let [done, after] = self.bands.shares(crop);
        let begun = self.begun.elapsed();
        let limit = self.order.time.map(|time| time.mul_f64(after));
        let is_first = self.made.bands == 0;
        let is_measured = (self.denoising.as_ref()).is_some_and(Denoising::has_to_measure);
        loop {
            let left = limit.map(|limit| limit.saturating_sub(self.begun.elapsed()));
            // Past its time a band without samples goes on until it has one.
            let slice = left
                .filter(|left| !left.is_zero())
                .map_or(SLICE, |left| left.min(SLICE));
            let progress = self.backend.advance(slice, self.cancel)?;
            if self.cancel.load(Ordering::Relaxed) {
                return Err(Failure::Cancelled);
            }
            let elapsed = self.begun.elapsed();
            if is_first && progress.samples > 0 && self.made.first.is_zero() {
                self.made.first = elapsed;
            }
            let samples = f64::from(progress.samples) / f64::from(settings.samples.max(1));
            let time = limit.map_or(0.0, |limit| {
                let whole = limit.saturating_sub(begun).as_secs_f64();
                (elapsed - begun).as_secs_f64() / whole.max(1e-3)
            });
            // An error falls with about the square root of the samples, so its inverse square shows how far it is.
            let error = progress.error_estimate.filter(|error| *error > 0.0);
            let error = error.map_or(0.0, |error| (settings.error / error).powi(2));
            let share = samples.max(time).max(error).clamp(0.0, 1.0);
            tell(&Standing {
                share: done + (after - done) * share,
                band: [self.made.bands + 1, self.bands.count()],
                samples: progress.samples,
                error: progress.error_estimate,
                waits_for_device: false,
            });
            let is_late = limit.is_some_and(|limit| elapsed >= limit);
            if progress.done || (is_late && progress.samples > 0) {
                return Ok((progress.samples, progress.error_estimate));
            }
            let last = earlier.as_ref().map_or(0, |(samples, _)| *samples);
            let is_doubled = progress.samples >= (last + 1).next_power_of_two();
            if is_doubled && is_measured {
                *earlier = Some((progress.samples, self.backend.picture()?));
            }
        }
    }
}

/// The errors of bands, for that of the whole: relRMSE² · mean² is a mean over pixels, and so is the mean.
#[derive(Default)]
struct Errors {
    variance: f64,
    sum: f64,
    pixels: f64,
}

impl Errors {
    fn add(&mut self, error: f64, picture: &Picture) {
        let pixels = picture.pixels.len() as f64;
        let mean = metrics::mean(picture);
        self.variance += pixels * (error * mean).powi(2);
        self.sum += pixels * mean;
        self.pixels += pixels;
    }

    fn whole(&self) -> Option<f64> {
        (self.pixels > 0.0).then(|| {
            if self.sum > 0.0 {
                (self.variance / self.pixels).sqrt() / (self.sum / self.pixels)
            } else {
                0.0
            }
        })
    }
}
