//! A picture in work, and the ladder of sizes it climbs: a small one first, then twice that, up to the full size.

use std::time::{Duration, Instant};

use renderer_core::render::{Progress, RenderRequest};

use super::renderer::noise_left;

/// Pictures are published at most this often.
const PUBLISHING: Duration = Duration::from_millis(50);
/// A first picture that takes longer than this is drawn smaller.
const FIRST_PICTURE: f64 = 0.1;
/// Samples of a picture of reduced size.
const REDUCED_SAMPLES: u32 = 4;
/// Pictures of fewer samples are shown softer: less sharp, but less noisy,
const SHARP_FROM: f32 = 32.0;
/// unless they are smaller than this: there is no sharpness to give away.
const SOFT_UP_TO: u32 = 2;
/// Smallest first picture: this fraction of the full width and height.
const MOST_REDUCED: u32 = 16;

/// A picture in work.
pub struct RenderJob {
    /// The picture at full size.
    pub request: RenderRequest,
    /// Whether nothing is left to do.
    pub is_done: bool,
    /// Seconds of work on it.
    pub seconds: f64,
    /// Width and height of the picture in work are those of the request divided by this.
    divisor: u32,
    samples: u32,
    /// relRMSE that the backend expects of its noise.
    error_estimate: Option<f64>,
    /// Samples of the picture that another backend has drawn of this one, which is seen already.
    seen: u32,
    /// Samples from which on the picture is no noisier than that: those of fewer are not published before it is done.
    quiet_from: u32,
    /// Seconds on the picture of the present divisor.
    rung_seconds: f64,
    published: Instant,
    publishing_took: Duration,
}

impl RenderJob {
    /// Starts with a picture whose first sample is there in a tenth of a second, at `cost` seconds for a sample of a
    /// pixel; with the smallest where nothing is known.
    pub fn new(request: RenderRequest, cost: Option<f64>) -> Self {
        let divisor = first_divisor(cost, request.size);
        Self {
            request,
            is_done: false,
            seconds: 0.0,
            divisor,
            samples: 0,
            error_estimate: None,
            seen: 0,
            quiet_from: 0,
            rung_seconds: 0.0,
            published: Instant::now(),
            publishing_took: Duration::ZERO,
        }
    }

    /// Whether `request` is the picture in work, at its full size, and only says otherwise when it is done.
    pub fn goes_on_as(&self, request: &RenderRequest) -> bool {
        let mut same = request.clone();
        (same.settings.samples, same.settings.error) =
            (self.request.settings.samples, self.request.settings.error);
        self.divisor == 1 && same == self.request
    }

    /// Takes over the targets of a request that [goes on](Self::goes_on_as) with this picture.
    pub fn go_on_as(&mut self, request: RenderRequest) {
        self.request = request;
        self.is_done = false;
    }

    /// What the backend has to draw now: the picture at a fraction of its size with few samples, or all of it.
    pub fn in_work(&self) -> RenderRequest {
        if self.divisor == 1 {
            return self.request.clone();
        }
        reduced(&self.request, self.divisor)
    }

    /// Notes work of `seconds`. Seconds for a sample of a pixel if they are known, and whether the picture should be
    /// published.
    pub fn note(&mut self, progress: Progress, seconds: f64) -> (Option<f64>, bool) {
        self.seconds += seconds;
        self.rung_seconds += seconds;
        if progress.samples < self.samples {
            // The backend could not go on from what it had.
            (self.samples, self.rung_seconds) = (0, seconds);
        }
        if progress.samples == self.samples && !progress.done {
            return (None, false);
        }
        let is_first = self.samples == 0;
        (self.samples, self.error_estimate) = (progress.samples, progress.error_estimate);
        let [width, height] = self.in_work().size;
        let samples = f64::from(progress.samples.max(1));
        let cost = self.rung_seconds / (f64::from(width) * f64::from(height) * samples);
        let is_due = self.published.elapsed() > (4 * self.publishing_took).max(PUBLISHING);
        let is_news = progress.samples >= self.quiet_from && (is_first || is_due);
        (Some(cost), (progress.done && !self.is_behind()) || is_news)
    }

    /// Notes that the picture was published, which took so long.
    pub fn published(&mut self, took: Duration) {
        (self.published, self.publishing_took) = (Instant::now(), took);
    }

    /// Goes on to a picture twice as large; false if this was the full size.
    pub fn climb(&mut self) -> bool {
        if self.divisor == 1 {
            self.is_done = true;
            return false;
        }
        self.divisor /= 2;
        (self.samples, self.seen, self.quiet_from) = (0, 0, 0);
        self.error_estimate = None;
        self.rung_seconds = 0.0;
        true
    }

    /// Notes that another backend starts on the picture in work. One that shows its pictures as sharp as they are
    /// (not `softens`) has to have more samples than one that mixes neighbouring pixels, until it is no noisier.
    pub fn start_again(&mut self, softens: bool) {
        self.seen = self.seen.max(self.samples);
        let softness = if softens {
            0.0
        } else {
            self.softness(self.seen)
        };
        self.quiet_from = (self.seen as f32 / noise_left(softness)).ceil() as u32;
        self.samples = 0;
        self.error_estimate = None;
        self.rung_seconds = 0.0;
    }

    /// Whether the picture in work has fewer samples than one of it that is seen already.
    pub fn is_behind(&self) -> bool {
        self.samples < self.seen
    }

    /// Whether the picture in work is as good as is requested, so that its backend will call it done.
    pub fn has_met_target(&self) -> bool {
        let wanted = self.in_work().settings;
        let is_met = |error: f64| wanted.error > 0.0 && error <= wanted.error;
        self.samples >= wanted.samples || self.error_estimate.is_some_and(is_met)
    }

    /// Whether the picture in work has no sample yet, nor has one been seen.
    pub fn is_new(&self) -> bool {
        self.samples == 0 && self.seen == 0
    }

    /// Whether the picture in work is a small one.
    pub fn is_reduced(&self) -> bool {
        self.divisor > 1
    }

    /// How much a picture of so many samples is better shown as the mean of neighbouring pixels: all for the first
    /// sample, then less with every doubling, so that it gets sharp as noise goes, and never at once.
    pub fn softness(&self, samples: u32) -> f32 {
        if self.divisor > SOFT_UP_TO {
            return 0.0;
        }
        let doublings = (samples.max(1) as f32).log2();
        (1.0 - doublings / SHARP_FROM.log2()).max(0.0)
    }
}

/// The picture of a request with few samples, its width and height divided by `divisor`.
pub fn reduced(request: &RenderRequest, divisor: u32) -> RenderRequest {
    let mut reduced = request.clone();
    reduced.size = request.size.map(|side| side.div_ceil(divisor));
    reduced.crop = [0, 0, reduced.size[0], reduced.size[1]];
    reduced.settings.samples = REDUCED_SAMPLES;
    reduced.settings.error = 0.0;
    reduced
}

/// The divisor at which one sample takes less than [`FIRST_PICTURE`].
pub fn first_divisor(cost: Option<f64>, size: [u32; 2]) -> u32 {
    let Some(cost) = cost else {
        return MOST_REDUCED;
    };
    let whole = cost * f64::from(size[0]) * f64::from(size[1]);
    let mut divisor = 1;
    while divisor < MOST_REDUCED && whole / f64::from(divisor * divisor) > FIRST_PICTURE {
        divisor *= 2;
    }
    divisor
}
