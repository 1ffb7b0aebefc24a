//! `quiet`: how long after an edit or a turn of the camera the window's picture is quiet, with denoising and without, and
//! what denoising is worth at each number of samples.
//!
//! The render thread runs as the window drives it, once with a denoiser and once without, in turns, each from rest:
//! in a new window, which has drawn the design before an edit small, before a turn whole. Every frame that it shows is kept with its time and held to a converged picture afterwards, as a screen shows both: 8 bits a
//! channel, small previews enlarged. relRMSE is that of the light that the screen emits.
//!
//! The curve is of pictures in linear light, by a backend alone: plain, denoised, and mixed as the window mixes them; its
//! last line is denoised from the converged picture itself, which is the bias that samples do not remove.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use egui::ColorImage;
use renderer_core::denoise::{Denoise, DenoiseError, DenoiseQuality, Mix, Step};
use renderer_core::design::{CameraDesign, Design, srgb_to_linear};
use renderer_core::geometry::Camera;
use renderer_core::image::{Display, Picture, metrics};
use renderer_core::render::{Backend, RenderRequest};
use renderer_core::scene::Cancel;
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodView};
use towel_designer::backend::{self, BackendChoice};
use towel_designer::cli::arguments;
use towel_designer::clock::{Spent, timed};
use towel_designer::denoiser::{self, MakeDenoiser};
use towel_designer::designer::{
    DisplayFrame, LiveLight, RenderThread, ViewRequest, for_window, workers,
};
use towel_designer::files;

use crate::csv::{number, optional, table};
use crate::drawing::median;
use crate::flip::flip;

/// How long a backend works before it is asked again.
const SLICE: Duration = Duration::from_millis(100);
/// How often the stop watch looks.
const LOOKING: Duration = Duration::from_millis(1);
/// Longest wait for anything to come to rest.
const PATIENCE: Duration = Duration::from_secs(600);
/// Between two edits the picture is so many times smaller.
const SMALLER: u32 = 30;
/// The errors whose time is reported.
const WANTED: [(&str, f64); 2] = [("relRMSE", 0.3), ("FLIP", 0.1)];

/// What to measure.
#[derive(Debug, clap::Args)]
pub struct QuietArguments {
    /// Preset to edit.
    preset: PathBuf,
    /// The edit, as in skeleton.colour=#806040.
    #[arg(long, required_unless_present = "orbit", value_name = "PATH=VALUE", value_parser = arguments::field_and_value)]
    edit: Vec<(String, String)>,
    /// Turn the camera about its target by so many degrees instead.
    #[arg(
        long,
        value_name = "DEGREES",
        conflicts_with = "edit",
        allow_negative_numbers = true
    )]
    orbit: Option<f64>,
    /// Which of the preset's cameras looks, by name.
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Hold pictures to the light of an export, not to what the window's own would become.
    #[arg(long)]
    true_light: bool,
    /// Size of the window's picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = arguments::size)]
    size: [u32; 2],
    /// Samples up to which the window goes on, and the curve.
    #[arg(long, value_name = "N", default_value = "16", value_parser = clap::value_parser!(u32).range(1..=4096))]
    samples: u32,
    /// Samples of the converged picture.
    #[arg(long, value_name = "N", default_value = "512", value_parser = clap::value_parser!(u32).range(1..=65536))]
    truth: u32,
    /// How often the edit is made, with and without denoising.
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(0..=100))]
    repeats: u32,
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Write the curve as CSV too.
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

/// A frame of the window, and when it came.
struct Frame {
    at: Duration,
    image: Arc<ColorImage>,
}

/// A design, and the camera that looks at it.
struct Seen {
    design: Arc<Design>,
    camera: CameraDesign,
}

impl Seen {
    /// The preset with some edits, seen by the camera that is asked for.
    fn new(arguments: &QuietArguments, edits: &[(String, String)]) -> anyhow::Result<Self> {
        let mut design = files::load_design_with(&arguments.preset, edits)?;
        (design.quality.samples, design.quality.error) = (arguments.samples, 0.0);
        let mut cameras = design.view.cameras.iter();
        let camera = match &arguments.camera {
            Some(name) => cameras.find(|camera| camera.name == *name),
            None => cameras.next(),
        };
        let camera = camera.ok_or_else(|| anyhow!("the preset has no such camera"))?;
        Ok(Self {
            camera: camera.clone(),
            design: Arc::new(design),
        })
    }

    /// This design from a camera that has turned about its target by so many degrees.
    fn turned(&self, degrees: f64) -> Self {
        let mut camera = self.camera.clone();
        camera.azimuth += degrees;
        Self {
            camera,
            design: Arc::clone(&self.design),
        }
    }
}

/// A render thread between edits.
struct Window {
    thread: RenderThread,
    view: ViewRequest,
}

impl Window {
    fn new(arguments: &QuietArguments, seen: &Seen, denoiser: MakeDenoiser) -> Self {
        let make = for_window(Arc::new(backend::make), None);
        Self {
            thread: RenderThread::new(make, denoiser, egui::Context::default()),
            view: ViewRequest {
                camera: seen.camera.clone(),
                size: arguments.size,
                display: Display::from(&*seen.design),
                design: Arc::clone(&seen.design),
                choice: arguments.backend,
                attempt: 0,
                light: LiveLight::default(),
                denoises: true,
            },
        }
    }

    /// Shows a design at a fraction of its width and height, until nothing runs.
    fn rest(&mut self, seen: &Seen, smaller: u32) -> anyhow::Result<()> {
        let view = ViewRequest {
            size: self.view.size.map(|side| side.div_ceil(smaller)),
            design: Arc::clone(&seen.design),
            camera: seen.camera.clone(),
            ..self.view.clone()
        };
        self.thread.send(view, false);
        match self.thread.wait_for_rest(PATIENCE) {
            true => Ok(()),
            false => Err(anyhow!("the window does not come to rest")),
        }
    }

    /// What is shown of an edited design or from a camera that has turned, until it is done.
    fn frames(&mut self, seen: &Seen) -> anyhow::Result<Vec<Frame>> {
        (self.view.design, self.view.camera) = (Arc::clone(&seen.design), seen.camera.clone());
        let mut version = self.thread.state().picture.version;
        let (start, mut frames) = (Instant::now(), Vec::new());
        self.thread.send(self.view.clone(), false);
        loop {
            let is_over = self.thread.wait_for_rest(LOOKING);
            let state = self.thread.state();
            if let Some(error) = state.error {
                return Err(anyhow!(error));
            }
            if state.picture.version != version {
                version = state.picture.version;
                if let Some(DisplayFrame::Pixels(image)) = state.picture.frame {
                    let at = start.elapsed();
                    frames.push(Frame { at, image });
                }
            }
            if is_over {
                return Ok(frames);
            }
        }
    }
}

/// The light that a screen emits, where it enlarges a picture smoothly to this size.
fn emitted(image: &ColorImage, size: [u32; 2]) -> Picture {
    let [width, height] = image.size;
    let at = |x: usize, y: usize, c: usize| f64::from(image.pixels[y * width + x].to_array()[c]);
    let place = |at: u32, of: u32, from: usize| {
        let place = (f64::from(at) + 0.5) * from as f64 / f64::from(of) - 0.5;
        let place = place.clamp(0.0, (from - 1) as f64);
        let first = place.floor() as usize;
        (first, (first + 1).min(from - 1), place.fract())
    };
    let pixel = |index: u32| {
        let (x0, x1, x) = place(index % size[0], size[0], width);
        let (y0, y1, y) = place(index / size[0], size[1], height);
        let channel = |c: usize| {
            let above = at(x0, y0, c) + x * (at(x1, y0, c) - at(x0, y0, c));
            let below = at(x0, y1, c) + x * (at(x1, y1, c) - at(x0, y1, c));
            srgb_to_linear((above + y * (below - above)) / 255.0) as f32
        };
        [channel(0), channel(1), channel(2), 1.0]
    };
    Picture {
        size,
        pixels: (0..size[0] * size[1]).map(pixel).collect(),
        aov: None,
    }
}

/// The light that a screen emits of a picture in linear light: with the steps of its 8 bits.
fn emitted_of(picture: &Picture, display: Display) -> Picture {
    let bytes = |channel: f64| srgb_to_linear((channel * 255.0).round() / 255.0) as f32;
    let pixel = |&[r, g, b, _]: &[f32; 4]| {
        let [r, g, b] = display.encode([r, g, b]).map(bytes);
        [r, g, b, 1.0]
    };
    Picture {
        size: picture.size,
        pixels: picture.pixels.iter().map(pixel).collect(),
        aov: None,
    }
}

/// When each wanted error is reached for good; `None` where it is not.
fn times(frames: &[Frame], truth: &Picture) -> anyhow::Result<[Option<f64>; 2]> {
    let mut reached = [None; 2];
    for frame in frames {
        let shown = emitted(&frame.image, truth.size);
        let errors = [metrics::rel_rmse(&shown, truth)?, flip(&shown, truth, 0.0)?];
        for (k, (_, wanted)) in WANTED.iter().enumerate() {
            let at = reached[k].unwrap_or(frame.at.as_secs_f64());
            reached[k] = (errors[k] <= *wanted).then_some(at);
        }
    }
    Ok(reached)
}

/// A number of samples on the curve.
struct Row {
    samples: u32,
    /// Drawing them, and the denoising of the last.
    seconds: [f64; 2],
    /// relRMSE and FLIP of the plain, the denoised and the mixed picture.
    errors: [[f64; 2]; 3],
    /// What the mixture is told to be off by.
    told: Option<f64>,
}

/// Draws up to so many samples, and notes the time; the picture, and its estimated relRMSE.
fn draw(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    spent: &mut Spent,
) -> anyhow::Result<(Picture, Option<f64>)> {
    workers::with_all(|| backend.begin(request))?;
    let never = AtomicBool::new(false);
    loop {
        let progress = timed(spent, || {
            workers::with_all(|| backend.advance(SLICE, &never))
        })?;
        if progress.done {
            let picture = workers::with_all(|| backend.picture())?;
            return Ok((picture, progress.error_estimate));
        }
    }
}

fn curve(
    backend: &mut dyn Backend,
    mut request: RenderRequest,
    most: u32,
    truth: &Picture,
    exposure: f64,
    denoiser: &mut dyn Denoise,
) -> anyhow::Result<Vec<Row>> {
    let never = AtomicBool::new(false);
    let scale = exposure.exp2() as f32;
    let (mut rows, mut spent) = (Vec::new(), Spent::zero());
    let mut last: Option<Step> = None;
    let mut samples = 1;
    while samples <= most {
        request.settings.samples = samples;
        let (plain, error) = draw(backend, &request, &mut spent)?;
        let start = Instant::now();
        let denoised = denoiser.denoise(&plain, DenoiseQuality::High, scale, &never)?;
        let took = start.elapsed().as_secs_f64();
        let step = Step {
            samples,
            plain,
            error,
            denoised,
        };
        let mix = Mix::new(last.as_ref(), &step);
        let errors = |picture: &Picture| -> anyhow::Result<[f64; 2]> {
            Ok([
                metrics::rel_rmse(picture, truth)?,
                flip(picture, truth, exposure)?,
            ])
        };
        rows.push(Row {
            samples,
            seconds: [spent.wall.as_secs_f64(), took],
            errors: [
                errors(&step.plain)?,
                errors(&step.denoised)?,
                errors(&mix.picture)?,
            ],
            told: mix.error,
        });
        last = Some(step);
        samples *= 2;
    }
    Ok(rows)
}

/// Measures, prints tables, and writes.
///
/// # Errors
/// When the preset or the edit has faults, there is no denoiser, or the backend or the file refuses.
pub fn run(arguments: &QuietArguments) -> anyhow::Result<()> {
    if let Some(output) = &arguments.output {
        files::check_writable(output)?;
    }
    let before = Seen::new(arguments, &[])?;
    let after = match arguments.orbit {
        Some(degrees) => before.turned(degrees),
        None => Seen::new(arguments, &arguments.edit)?,
    };
    let mut denoiser = denoiser::make()?;
    let (mut compiler, never) = (LodCompiler::default(), Cancel::never());
    let mut view_of = |seen: &Seen| {
        let camera = Camera::from_design(&seen.camera);
        let budget = LodBudget::LIVE;
        LodView::new(
            &mut compiler,
            &seen.design,
            &camera,
            arguments.size,
            budget,
            &never,
        )
    };
    let view = view_of(&after)?;
    let settings = LiveLight::default().settings(&after.design);
    let mut request = RenderRequest::new(view, arguments.size, settings);
    let mut backend = backend::make(arguments.backend.for_method(settings.method))?;
    // Another seed than that of what is held to it.
    request.settings.seed = !settings.seed;
    request.settings.samples = arguments.truth;
    if arguments.true_light {
        let light = LiveLight::True.settings(&after.design);
        request.settings.traced_bounces = light.traced_bounces;
        request.settings.cached_shadows = light.cached_shadows;
        request.settings.learns_bounces = light.learns_bounces;
    }
    let (truth, _) = draw(&mut *backend, &request, &mut Spent::zero())?;
    request.settings = settings;

    let display = Display::from(&*after.design);
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{} by {}, {}",
        denoiser.name(),
        backend.kind().name(),
        backend.device_name()
    )?;
    let exposure = display.exposure;
    if arguments.orbit.is_some() {
        // What is learned from one camera is known to the next.
        let seen = RenderRequest::new(view_of(&before)?, arguments.size, settings);
        draw(&mut *backend, &seen, &mut Spent::zero())?;
    }
    let rows = curve(
        &mut *backend,
        request,
        arguments.samples,
        &truth,
        exposure,
        &mut *denoiser,
    )?;
    let bias = denoiser.denoise(
        &truth,
        DenoiseQuality::High,
        exposure.exp2() as f32,
        &AtomicBool::new(false),
    )?;
    let bias = [
        metrics::rel_rmse(&bias, &truth)?,
        flip(&bias, &truth, exposure)?,
    ];
    out.write_all(curve_text(&rows, bias).as_bytes())?;
    if let Some(output) = &arguments.output {
        files::write_atomically(output, curve_csv(&rows, bias).as_bytes())?;
    }

    let shown = emitted_of(&truth, display);
    let none: MakeDenoiser = Arc::new(|| Err(DenoiseError::NotFound));
    let denoisers = [none, Arc::new(denoiser::make)];
    // A small picture knows nothing of the shadows that one of full size would.
    let smaller = match arguments.orbit {
        Some(_) => 1,
        None => SMALLER,
    };
    let mut all = Vec::new();
    for _ in 0..arguments.repeats {
        let mut pair = [[None; 2]; 2];
        for (denoiser, times_of) in denoisers.iter().zip(&mut pair) {
            let mut window = Window::new(arguments, &before, Arc::clone(denoiser));
            window.rest(&before, smaller)?;
            *times_of = times(&window.frames(&after)?, &shown)?;
        }
        all.push(pair);
    }
    out.write_all(window_text(&all).as_bytes())?;
    Ok(())
}

fn curve_text(rows: &[Row], bias: [f64; 2]) -> String {
    let mut text = String::from(
        "samples  seconds  denoising   relRMSE plain  denoised  mixed  (told)   FLIP plain  denoised  mixed\n",
    );
    for row in rows {
        let ([seconds, denoising], [plain, denoised, mixed]) = (row.seconds, row.errors);
        let told = row
            .told
            .map_or_else(|| "–".into(), |told| format!("{told:.3}"));
        let _ = writeln!(
            text,
            "{:>7} {seconds:>8.2} {denoising:>10.2} {:>15.3} {:>9.3} {:>6.3} {told:>7} {:>12.3} {:>9.3} {:>6.3}",
            row.samples, plain[0], denoised[0], mixed[0], plain[1], denoised[1], mixed[1],
        );
    }
    let _ = writeln!(text, "converged{:>35.3} (bias) {:>35.3}", bias[0], bias[1]);
    text
}

fn curve_csv(rows: &[Row], bias: [f64; 2]) -> String {
    let header = "samples,seconds of samples,seconds of denoising,relRMSE plain,relRMSE denoised,relRMSE mixed,\
        relRMSE estimated of mixed,FLIP plain,FLIP denoised,FLIP mixed";
    let lines = rows.iter().map(|row| {
        let of = |k: usize| row.errors.map(|errors| number(errors[k]));
        let mut fields = vec![row.samples.to_string()];
        fields.extend(row.seconds.map(number));
        fields.extend(of(0));
        fields.push(optional(row.told));
        fields.extend(of(1));
        fields.join(",")
    });
    let last = format!("converged,,,,{},,,,{},", number(bias[0]), number(bias[1]));
    table(header, lines.chain([last]))
}

/// A line a pair, and the median of the ratios; `[plain, denoised]`, each to both errors.
fn window_text(all: &[[[Option<f64>; 2]; 2]]) -> String {
    let mut text = String::new();
    for (k, (name, wanted)) in WANTED.iter().enumerate() {
        let seconds =
            |time: Option<f64>| time.map_or_else(|| "not".into(), |s| format!("{s:.2} s"));
        let _ = writeln!(
            text,
            "window, from the change to {name} {wanted}: plain, denoised, ratio"
        );
        let mut ratios = Vec::new();
        for [plain, denoised] in all {
            let (plain, denoised) = (plain[k], denoised[k]);
            let ratio = plain
                .zip(denoised)
                .map(|(plain, denoised)| denoised / plain);
            let shown = ratio.map_or_else(|| "–".into(), |ratio| format!("{ratio:.3}"));
            let _ = writeln!(
                text,
                "  {:>10} {:>10} {shown:>8}",
                seconds(plain),
                seconds(denoised)
            );
            ratios.extend(ratio);
        }
        let _ = writeln!(
            text,
            "  median ratio {:.3} of {}",
            median(ratios.iter().copied()),
            ratios.len()
        );
    }
    text
}
