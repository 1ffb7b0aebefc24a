//! `render`: a preset to a picture file, without a window.
//!
//! Everything that can be wrong with the arguments is found before the first ray: the preset, the chart, the camera,
//! the output. The picture is written last and at once, so that Ctrl-C leaves nothing behind.

use std::ffi::OsStr;
use std::iter;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use renderer_core::denoise::Denoise;
use renderer_core::design::{CameraDesign, Design, Method, Quality, Warning};
use renderer_core::geometry::Camera;
use renderer_core::image::{Background, Depth, Display, ExrLayer};
use renderer_core::render::{Backend, Optimisation, Optimisations, Settings};
use renderer_core::scene::lod::{LodBudget, LodCloth, LodCompiler, LodPlan};
use renderer_core::scene::{self, Cancel, ChartYarns, CompileError, Compiler};

use super::arguments::{self, BadArgument};
use super::read_design;
use super::stats::{Seconds, Stats};
use crate::advice::{Place, with_advice_on_denoiser};
use crate::backend::{self, BackendChoice};
use crate::denoiser;
use crate::files::{self, Opened, Origin, UsedFile, stem_of};
use crate::picture_file::{self, BAND_BYTES, Failure, Format, Made, PictureOrder, Standing};

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct RenderArguments {
    /// Preset, bundle, or picture that carries its design.
    preset: PathBuf,
    /// File to write: .png as displayed, .exr linear.
    #[arg(short, long, value_name = "OUT.png|OUT.exr")]
    output: PathBuf,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WxH", default_value = arguments::DEFAULT_SIZE, value_parser = arguments::size)]
    size: [u32; 2],
    /// Stop at this many samples a pixel.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(samples_range()))]
    samples: Option<u32>,
    /// Stop at this estimated relative error.
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = arguments::error_target)]
    error: Option<f64>,
    /// Stop after this many seconds of rendering, but not before the first whole sample.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = arguments::seconds)]
    time: Option<f64>,
    /// How a ray gathers light: single, layered, exact, six-face or tracked.
    #[arg(long, value_parser = arguments::method)]
    method: Option<Method>,
    /// Most scatterings of a path.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(bounces_range()))]
    bounces: Option<u32>,
    /// What to render with.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Seed of the noise.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u32>,
    /// Camera of the preset; its first unless given.
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Change a field of the preset, as in turbulence.seed=3 or light.sun[0].elevation=30.
    #[arg(long, value_name = "PATH=VALUE", value_parser = arguments::field_and_value)]
    set: Vec<(String, String)>,
    /// Render only this part of the picture.
    #[arg(long, value_name = "X,Y,W,H", value_parser = arguments::crop)]
    crop: Option<[u32; 4]>,
    /// Extra channels, for .exr.
    #[arg(long, value_name = "LAYERS", value_enum, value_delimiter = ',')]
    aov: Vec<AovArgument>,
    /// Bits a channel, for .png: 8 unless given.
    #[arg(long, value_name = "8|16", value_parser = ["8", "16"])]
    depth: Option<String>,
    /// Take noise out with Open Image Denoise, as far as that does good: a guess, which the file and --stats tell of; an
    /// .exr keeps the noisy picture too.
    #[arg(long)]
    denoise: bool,
    /// Leave the background out: alpha says how much of a pixel is cloth.
    #[arg(long)]
    transparent: bool,
    /// Pixels an inch on paper, which the file is to say; without, it has no size on paper.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = arguments::dots_per_inch)]
    dpi: Option<f64>,
    /// Leave the design out of a .png, which else carries it and opens again.
    #[arg(long)]
    no_design: bool,
    /// Open images that the preset names outside its own folder.
    #[arg(long)]
    allow_outside_images: bool,
    /// Most memory for the sums of the picture, in MB; larger pictures are made in bands, with the same result.
    #[arg(long, value_name = "MB", default_value_t = BAND_BYTES >> 20)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    memory: u64,
    /// Write times, sizes and quality as JSON.
    #[arg(long, value_name = "OUT.json")]
    stats: Option<PathBuf>,
    /// Count rays, cells, patch tests and so on for --stats; costs time.
    #[arg(long, requires = "stats")]
    counters: bool,
    /// Do work that is else left out where it cannot be seen, to compare time and picture; may be given several times.
    #[arg(long, alias = "no-skip", value_name = "NAME")]
    no_optimisation: Vec<Optimisation>,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, clap::ValueEnum)]
enum AovArgument {
    Depth,
    Normal,
    Albedo,
    Alpha,
}

fn samples_range() -> std::ops::RangeInclusive<i64> {
    let field = Quality::FIELDS.samples;
    field.min as i64..=field.max as i64
}

fn bounces_range() -> std::ops::RangeInclusive<i64> {
    let field = Quality::FIELDS.bounces;
    field.min as i64..=field.max as i64
}

impl RenderArguments {
    /// The files to write.
    fn outputs(&self) -> Vec<UsedFile> {
        let picture = UsedFile::new(&self.output, "the picture (-o)");
        let stats = self.stats.iter();
        let stats = stats.map(|stats| UsedFile::new(stats, "the file of --stats"));
        iter::once(picture).chain(stats).collect()
    }
}

/// Renders and writes.
pub fn run(arguments: &RenderArguments) -> anyhow::Result<()> {
    let start = Instant::now();
    let mut seconds = Seconds::default();
    let asked = timed(&mut seconds.open, || Asked::check(arguments))?;
    let denoiser = match arguments.denoise {
        true => Some(denoiser(&asked)?),
        false => None,
    };

    let mut maker = LodCompiler::new(Compiler::new(optimisations(arguments).into()));
    let cloth = timed(&mut seconds.compile, || asked.cloth(&mut maker))?;
    asked.warn(&scene::warnings(
        &asked.opened.design,
        &cloth.scenes.nearest,
        &mut ChartYarns::default(),
    ));

    let order = asked.order(&cloth)?;
    let choice = arguments.backend.for_method(order.settings.method);
    let mut backend = timed(&mut seconds.pipelines, || backend::make(choice))?;
    let before = start.elapsed();
    let made = make(&order, &mut *backend, denoiser, arguments)?;
    seconds.add(before, &made);

    if let Some(path) = &arguments.stats {
        seconds.total = start.elapsed().as_secs_f64();
        let compile = maker.last_report();
        let stats = Stats::new(&order, &cloth, compile, &*backend, &made, seconds);
        let json = serde_json::to_string_pretty(&stats)? + "\n";
        files::write_atomically(path, json.as_bytes())?;
    }
    Ok(())
}

/// What takes the noise out, or why there is nothing that does.
fn denoiser(asked: &Asked<'_>) -> anyhow::Result<Box<dyn Denoise>> {
    denoiser::make().map_err(|error| {
        let preset = asked.arguments.preset.display();
        let advice = with_advice_on_denoiser(&error, Place::CommandLine);
        anyhow::anyhow!("{preset}: cannot be denoised: {advice}")
    })
}

/// What is to be rendered, found good before the first ray.
struct Asked<'a> {
    arguments: &'a RenderArguments,
    format: Format,
    opened: Opened,
    camera: Camera,
}

impl<'a> Asked<'a> {
    /// Reads the preset, and makes sure that the outputs can be written.
    fn check(arguments: &'a RenderArguments) -> anyhow::Result<Self> {
        let format = format(arguments)?;
        let mut opened = read_design(
            &arguments.preset,
            &arguments.set,
            arguments.allow_outside_images,
        )?;
        let shown = camera(&opened.design, arguments)?.clone();
        let camera = Camera::from_design(&shown);
        // A picture that is opened shows what it showed.
        opened.design.view.current = Some(shown);
        let outputs = arguments.outputs();
        files::check_apart(&opened.read, &outputs)?;
        for output in &outputs {
            files::check_writable(&output.path)?;
        }
        Ok(Self {
            arguments,
            format,
            opened,
            camera,
        })
    }

    /// The cloth as the picture needs it.
    fn cloth(&self, maker: &mut LodCompiler) -> Result<LodCloth, CompileError> {
        let design = &self.opened.design;
        let plan = LodPlan::new(
            design,
            &self.camera,
            self.arguments.size,
            LodBudget::FINAL,
            None,
        );
        maker.make(design, plan, &Cancel::never())
    }

    /// What the picture shows: the design's name, which one that was read from a picture has from there.
    fn title(&self) -> String {
        let preset = &self.arguments.preset;
        let of_picture = match self.opened.origin {
            Origin::Picture => files::picture_title(preset),
            Origin::Preset | Origin::Bundle | Origin::Program => None,
        };
        of_picture.unwrap_or_else(|| stem_of(preset))
    }

    /// Prints what is to be said of the preset and its cloth.
    fn warn(&self, of_cloth: &[Warning]) {
        let of_files = self.opened.warnings.iter().map(String::as_str);
        let warnings = of_files.chain(of_cloth.iter().map(|warning| warning.text.as_str()));
        print_warnings(self.arguments, warnings);
    }

    /// The picture to make.
    fn order(&self, cloth: &LodCloth) -> anyhow::Result<PictureOrder> {
        let arguments = self.arguments;
        let design = &self.opened.design;
        let [width, height] = arguments.size;
        let background = Background(design.background_radiance());
        Ok(PictureOrder {
            view: cloth.view(design, &self.camera, arguments.size),
            size: arguments.size,
            crop: arguments.crop.unwrap_or([0, 0, width, height]),
            settings: settings(design, arguments, &self.format),
            time: arguments.time.map(Duration::from_secs_f64),
            about: picture_file::about(&self.title(), arguments.dpi),
            chunks: match self.format {
                Format::Png(_) if !arguments.no_design => design_chunks(&self.opened, arguments)?,
                Format::Png(_) | Format::Exr(_) => Vec::new(),
            },
            format: self.format.clone(),
            display: Display::from(design),
            transparent: arguments.transparent.then_some(background),
            band_bytes: arguments.memory << 20,
        })
    }
}

/// Makes the picture, with a progress bar.
fn make(
    order: &PictureOrder,
    backend: &mut dyn Backend,
    denoiser: Option<Box<dyn Denoise>>,
    arguments: &RenderArguments,
) -> Result<Made, Failure> {
    let bar = Bar::new(arguments.quiet);
    let never = AtomicBool::new(false);
    let show = |standing: &Standing| bar.show(standing);
    let made = picture_file::make(order, backend, denoiser, &arguments.output, &never, show)?;
    drop(bar);
    let pixels = made.nonfinite_pixels;
    if pixels > 0 {
        eprintln!("warning: {pixels} pixels are not finite, which is a fault of this program");
    }
    Ok(made)
}

/// Prints warnings, unless nothing is to be printed.
fn print_warnings<'w>(arguments: &RenderArguments, warnings: impl Iterator<Item = &'w str>) {
    for warning in warnings.filter(|_| !arguments.quiet) {
        eprintln!("warning: {warning}");
    }
}

/// Runs `work` and notes how long it took.
fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *seconds = start.elapsed().as_secs_f64();
    result
}

/// The format that the output's extension asks for; arguments that do not fit it are refused.
fn format(arguments: &RenderArguments) -> Result<Format, BadArgument> {
    let extension = arguments.output.extension().and_then(OsStr::to_str);
    let extension = extension.unwrap_or_default().to_ascii_lowercase();
    let output = arguments.output.display();
    match extension.as_str() {
        "png" if !arguments.aov.is_empty() => Err(BadArgument(format!(
            "--aov needs an .exr file, but the output is {output}"
        ))),
        "png" => Ok(Format::Png(match arguments.depth.as_deref() {
            Some("16") => Depth::Sixteen,
            _ => Depth::Eight,
        })),
        "exr" if arguments.depth.is_some() => Err(BadArgument(format!(
            "--depth is for .png files; {output} has 32-bit floats"
        ))),
        "exr" => {
            let mut layers: Vec<ExrLayer> = arguments
                .aov
                .iter()
                .map(|aov| match aov {
                    AovArgument::Depth => ExrLayer::Depth,
                    AovArgument::Normal => ExrLayer::Normal,
                    AovArgument::Albedo => ExrLayer::Albedo,
                    AovArgument::Alpha => ExrLayer::Alpha,
                })
                .collect();
            if arguments.denoise {
                layers.push(ExrLayer::Noisy);
            }
            layers.sort();
            layers.dedup();
            Ok(Format::Exr(layers))
        }
        _ => Err(BadArgument(format!(
            "the output is {output}, allowed are names that end in .png or .exr"
        ))),
    }
}

/// The camera asked for.
fn camera<'d>(
    design: &'d Design,
    arguments: &RenderArguments,
) -> Result<&'d CameraDesign, BadArgument> {
    let cameras = &design.view.cameras;
    let found = match &arguments.camera {
        None => design.view.opening(),
        Some(name) => cameras.iter().find(|camera| camera.name == *name),
    };
    found.ok_or_else(|| {
        let names: Vec<String> = cameras.iter().map(|c| format!("{:?}", c.name)).collect();
        BadArgument(format!(
            "{}: there is no camera {:?}, allowed are {}",
            arguments.preset.display(),
            arguments.camera.as_deref().unwrap_or_default(),
            names.join(", ")
        ))
    })
}

/// The preset's quality, with what the arguments say instead.
fn settings(design: &Design, arguments: &RenderArguments, format: &Format) -> Settings {
    let preset = Settings::from(&design.quality);
    let given =
        arguments.samples.is_some() || arguments.error.is_some() || arguments.time.is_some();
    let (samples, error) = if given {
        let most = Quality::FIELDS.samples.max as u32;
        (
            arguments.samples.unwrap_or(most),
            arguments.error.unwrap_or(0.0),
        )
    } else {
        (preset.samples, preset.error)
    };
    Settings {
        method: arguments.method.unwrap_or(preset.method),
        bounces: arguments.bounces.unwrap_or(preset.bounces),
        samples,
        error,
        seed: arguments.seed.unwrap_or(preset.seed),
        aov: matches!(format, Format::Exr(layers) if layers.iter().any(|l| !matches!(l, ExrLayer::Alpha | ExrLayer::Noisy))),
        counters: arguments.counters,
        optimisations: optimisations(arguments),
        ..preset
    }
}

/// The work to leave out.
fn optimisations(arguments: &RenderArguments) -> Optimisations {
    let off = arguments.no_optimisation.iter();
    off.fold(Optimisations::ALL, |all, &one| all.without(one))
}

/// The progress bar: drawn on stderr, and only if that is a terminal.
struct Bar(ProgressBar);

impl Bar {
    const LENGTH: u64 = 1000;

    fn new(quiet: bool) -> Self {
        let bar = if quiet {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(Self::LENGTH)
        };
        let style = ProgressStyle::with_template("{bar:30} {msg} · {elapsed} · {eta} left");
        Self(match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        })
    }

    fn show(&self, standing: &Standing) {
        self.0
            .set_position((standing.share * Self::LENGTH as f64) as u64);
        if standing.waits_for_device {
            self.0.set_message("preparing the GPU");
            return;
        }
        let error = standing.error.filter(|error| *error > 0.0);
        let error = error.map_or_else(String::new, |error| format!(" · error {error:.4}"));
        let [band, bands] = standing.band;
        let band = match bands {
            1 => String::new(),
            _ => format!("band {band} of {bands} · "),
        };
        self.0
            .set_message(format!("{band}{} samples{error}", standing.samples));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// What a PNG carries of the design it shows.
fn design_chunks(opened: &Opened, arguments: &RenderArguments) -> anyhow::Result<Vec<Vec<u8>>> {
    let folder = arguments.preset.parent().unwrap_or(Path::new(""));
    let embedded = files::embedded(&opened.design, &opened.carried, folder);
    let embedded = embedded.map_err(anyhow::Error::msg)?;
    print_warnings(arguments, embedded.warnings.iter().map(String::as_str));
    Ok(embedded.chunks)
}
