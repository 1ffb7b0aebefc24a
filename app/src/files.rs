//! All file reading and writing. Every error names its file; every write is atomic: the bytes go to a temporary file in
//! the same directory, reach the disk, and replace the old file at once, so that a crash or a full disk leaves it whole.

use std::fs;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Component, Path, PathBuf};

use exr::prelude::{MetaData, Vec2, read_first_rgba_layer_from_file};
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};
use renderer_core::design::preset::{self, PresetFault, SetError};
use renderer_core::design::{
    ChartImage, Design, EnvironmentFault, EnvironmentImage, EnvironmentReader, Fault,
    srgb_to_linear,
};

/// Largest preset file, bytes; the largest stitch pattern takes less than a tenth of it.
const LARGEST_PRESET: u64 = 16 << 20;
/// Most memory that decoding a chart may take, bytes: a chart of the largest size with 16 bits a channel.
const CHART_MEMORY: u64 = (ChartImage::MAX_SIDE * ChartImage::MAX_SIDE * 8) as u64 + (16 << 20);

/// Most memory that decoding a picture of the surroundings may take, bytes: the largest with 16 bytes a pixel.
const ENVIRONMENT_MEMORY: u64 =
    (EnvironmentImage::MAX_WIDTH * EnvironmentImage::MAX_WIDTH / 2 * 16) as u64 + (16 << 20);

/// What went wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// A file could not be read.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A preset has faults.
    #[error("{}", fault_lines(.path, .faults))]
    Preset {
        /// The file.
        path: PathBuf,
        /// All its faults.
        faults: Vec<PresetFault>,
    },
    /// A field cannot be set to what was asked.
    #[error("--set {0}")]
    Set(#[from] SetError),
    /// Fields that were set do not go together.
    #[error("{}: with what was set, {fault}", .path.display())]
    Together {
        /// The preset.
        path: PathBuf,
        /// The first fault.
        fault: Fault,
    },
    /// A preset is no text, or far too large.
    #[error("{}: {what}", .path.display())]
    NoPreset {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: String,
    },
    /// A chart image cannot be used.
    #[error("{}: chart image: {what}", .path.display())]
    Chart {
        /// The image.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// A picture of the surroundings cannot be used.
    #[error("{}: environment image: {what}", .path.display())]
    Environment {
        /// The image.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// A file could not be written; the old one, if any, is untouched.
    #[error("{}: cannot be written: {source}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl FileError {
    /// Whether what the user gave is at fault, rather than the machine.
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}

fn fault_lines(path: &Path, faults: &[PresetFault]) -> String {
    let line = |fault: &PresetFault| format!("{}:{fault}", path.display());
    faults.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Reads a preset and the images it names.
///
/// # Errors
/// When any of them cannot be read or has faults; all faults of the preset are in the error.
pub fn load_design(path: &Path) -> Result<Design, FileError> {
    load_design_with(path, &[])
}

/// As [`load_design`], with fields set to other values (paths and values as on the command line) before images are read.
///
/// # Errors
/// As [`load_design`], or when a field cannot be set.
pub fn load_design_with(path: &Path, sets: &[(String, String)]) -> Result<Design, FileError> {
    let (text, mut design) = read_preset(path)?;
    for (field, value) in sets {
        design = preset::set(&design, field, value)?;
    }
    if let Some(fault) = design.faults().into_iter().next() {
        let path = path.to_owned();
        return Err(FileError::Together { path, fault });
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut faults = Vec::new();
    let mut failed = |field: &str, error: FileError| -> Result<(), FileError> {
        if sets.iter().any(|(set, _)| set == field) {
            // The preset is not to blame.
            return Err(error);
        }
        let (line, column) = preset::position_of(&text, field);
        faults.push(PresetFault {
            line,
            column,
            path: field.into(),
            message: format!("{field}: {error}"),
        });
        Ok(())
    };
    if let Some(image) = &design.chart.image {
        match load_chart(&folder.join(image)) {
            Ok(pixels) => design.chart.pixels = Some(pixels),
            Err(error) => failed("chart.image", error)?,
        }
    }
    if let Some(image) = &design.light.environment.image {
        match load_environment(&folder.join(image)) {
            Ok(pixels) => design.light.environment.pixels = Some(pixels),
            Err(error) => failed("light.environment.image", error)?,
        }
    }
    if faults.is_empty() {
        Ok(design)
    } else {
        faults.sort_by_key(|fault| (fault.line, fault.column));
        let path = path.to_owned();
        Err(FileError::Preset { path, faults })
    }
}

/// A preset's text and what it says.
fn read_preset(path: &Path) -> Result<(String, Design), FileError> {
    let failed = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let no_preset = |what: String| FileError::NoPreset {
        path: path.to_owned(),
        what,
    };
    let size = fs::metadata(path).map_err(failed)?.len();
    if size > LARGEST_PRESET {
        return Err(no_preset(format!(
            "is {size} bytes large, a preset has at most {LARGEST_PRESET}"
        )));
    }
    let text = String::from_utf8(fs::read(path).map_err(failed)?)
        .map_err(|_| no_preset("is no preset: a preset is UTF-8 text (TOML)".into()))?;
    match preset::parse(&text) {
        Ok(design) => Ok((text, design)),
        Err(faults) => Err(FileError::Preset {
            path: path.to_owned(),
            faults,
        }),
    }
}

/// Reads a chart image: PNG or JPEG, sides up to [`ChartImage::MAX_SIDE`].
///
/// # Errors
/// When it cannot be read, is something else or is too large.
pub fn load_chart(path: &Path) -> Result<ChartImage, FileError> {
    let fault = |what: String| FileError::Chart {
        path: path.to_owned(),
        what,
    };
    let open = || {
        ImageReader::open(path)
            .and_then(ImageReader::with_guessed_format)
            .map_err(|error| fault(format!("cannot be read: {error}")))
    };
    let mut reader = open()?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err(fault("is neither a PNG nor a JPEG file".into()));
    }
    let broken = |error: ImageError| fault(format!("is broken: {error}"));
    let (width, height) = open()?.into_dimensions().map_err(broken)?;
    let most = ChartImage::MAX_SIDE;
    if width as usize > most || height as usize > most {
        return Err(fault(format!(
            "has {width} x {height} pixels, allowed are at most {most} x {most}"
        )));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(CHART_MEMORY);
    reader.limits(limits);
    let pixels = reader.decode().map_err(broken)?.into_rgba8();
    let pixels: Vec<[u8; 4]> = pixels.pixels().map(|pixel| pixel.0).collect();
    ChartImage::new(width as usize, height as usize, &pixels)
        .ok_or_else(|| fault("has no pixels".into()))
}

/// Reads a picture of the surroundings: Radiance HDR or OpenEXR with linear light, or PNG or JPEG, taken as sRGB;
/// equirectangular, at most [`EnvironmentImage::MAX_WIDTH`] wide.
///
/// # Errors
/// When it cannot be read, is something else, has another proportion, is too large or has pixels that are no numbers.
pub fn load_environment(path: &Path) -> Result<EnvironmentImage, FileError> {
    read_environment(path).map_err(|what| FileError::Environment {
        path: path.to_owned(),
        what,
    })
}

fn read_environment(path: &Path) -> Result<EnvironmentImage, String> {
    // Without its name, which may promise what the content is not.
    let open = || {
        let file = fs::File::open(path);
        file.and_then(|file| ImageReader::new(BufReader::new(file)).with_guessed_format())
            .map_err(|error| format!("cannot be read: {error}"))
    };
    let broken = |error: ImageError| format!("is broken: {error}");
    let mut reader = open()?;
    match reader.format() {
        Some(ImageFormat::OpenExr) => return read_exr_environment(path),
        Some(ImageFormat::Hdr | ImageFormat::Png | ImageFormat::Jpeg) => {}
        _ => return Err("is none of .hdr, .exr, .png and .jpg".into()),
    }
    let (width, height) = open()?.into_dimensions().map_err(broken)?;
    let told = |fault: EnvironmentFault| fault.to_string();
    let mut environment = EnvironmentReader::new(width as usize, height as usize).map_err(told)?;
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
    environment.finish().map_err(told)
}

/// Channels R, G and B of the first layer that has them; alpha is left out.
fn read_exr_environment(path: &Path) -> Result<EnvironmentImage, String> {
    let broken = |error: exr::error::Error| format!("is broken: {error}");
    // Asked first: decoding what is too large would take its time.
    for header in MetaData::read_from_file(path, false)
        .map_err(broken)?
        .headers
    {
        let Vec2(width, height) = header.layer_size;
        if width > EnvironmentImage::MAX_WIDTH || height > EnvironmentImage::MAX_WIDTH / 2 {
            return Err(EnvironmentFault::Size { width, height }.to_string());
        }
    }
    let image = read_first_rgba_layer_from_file(
        path,
        |Vec2(width, height), _| EnvironmentReader::new(width, height),
        |environment, Vec2(x, y), (r, g, b, _): (f32, f32, f32, f32)| {
            if let Ok(environment) = environment {
                environment.add(x, y, [r, g, b]);
            }
        },
    )
    .map_err(broken)?;
    image
        .layer_data
        .channel_data
        .pixels
        .and_then(EnvironmentReader::finish)
        .map_err(|fault| fault.to_string())
}

/// Writes a preset to `to`. `from` is the file the design was read from, which its relative paths of images refer to;
/// they are changed so that they lead to the same images from the new place. Returns the design as written.
///
/// # Errors
/// When the file cannot be written.
pub fn save_design(design: &Design, to: &Path, from: Option<&Path>) -> Result<Design, FileError> {
    let mut design = design.clone();
    for image in design.image_paths_mut().into_iter().flatten() {
        let file = match from {
            Some(from) => from.parent().unwrap_or(Path::new("")).join(&*image),
            None => PathBuf::from(&*image),
        };
        let moved = from.and_then(Path::parent) != to.parent();
        if moved || file.is_absolute() {
            *image = image_path_from(to, &file);
        }
    }
    let text = preset::write(&design).map_err(|error| FileError::Write {
        path: to.to_owned(),
        source: io::Error::other(error),
    })?;
    write_atomically(to, text.as_bytes())?;
    Ok(design)
}

/// The path by which a preset at `preset` names an image (relative to the working directory, or absolute):
/// relative where the two share more than the root, with forward slashes.
pub fn image_path_from(preset: &Path, image: &Path) -> String {
    let folder = match preset.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let absolute = |path: &Path| {
        path.canonicalize()
            .or_else(|_| std::path::absolute(path))
            .unwrap_or_else(|_| path.to_owned())
    };
    let (folder, image) = (absolute(folder), absolute(image));
    let (here, there): (Vec<_>, Vec<_>) =
        (folder.components().collect(), image.components().collect());
    let shared = here.iter().zip(&there).take_while(|(a, b)| a == b).count();
    let only_root_shared = there[..shared]
        .iter()
        .all(|part| matches!(part, Component::Prefix(_) | Component::RootDir));
    if only_root_shared {
        return image.to_string_lossy().into_owned();
    }
    let up = here[shared..].iter().map(|_| "..".to_owned());
    let down = there[shared..]
        .iter()
        .map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Writes a file so that it is either whole or untouched.
///
/// # Errors
/// When the directory or the disk refuses.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_atomically_with(path, |file| file.write_all(bytes))
}

/// As [`write_atomically`], for files that are made piece by piece.
///
/// # Errors
/// When the directory or the disk refuses, or `write` does.
pub fn write_atomically_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    replace(path, write).map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Through a symbolic link the file it points to is replaced, not the link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&target).is_ok_and(|existing| !existing.is_file() && !existing.is_dir()) {
        // A device or pipe (`/dev/stdout`) cannot be replaced, only written to.
        return write(&mut fs::OpenOptions::new().write(true).open(&target)?);
    }
    let mut file = BufWriter::new(temporary_beside(&target)?);
    write(&mut file)?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    sync_folder(&target)
}

/// Whether `path` could be written now, without changing it: asked before minutes of rendering.
///
/// # Errors
/// When it could not, with the reason.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let check = || -> io::Result<()> {
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        match fs::metadata(&target) {
            Ok(existing) if existing.is_dir() => Err(io::Error::other("is a directory")),
            Ok(existing) if existing.permissions().readonly() => {
                Err(io::Error::other("is write-protected"))
            }
            Ok(existing) if !existing.is_file() => Ok(()),
            _ => temporary_beside(&target).map(drop),
        }
    };
    check().map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

/// A temporary file in the same directory, removed when dropped, with the permissions that the target has or would get.
fn temporary_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::other("is not the name of a file"))?;
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let prefix = format!(".{}.", name.to_string_lossy());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(match fs::metadata(target) {
            Ok(existing) => existing.permissions(),
            // What the process's umask leaves of it, as for any new file.
            Err(_) => fs::Permissions::from_mode(0o666),
        });
    }
    builder.tempfile_in(folder).map_err(|error| {
        // tempfile's message names its random file; only the reason matters here.
        match error.kind() {
            io::ErrorKind::NotFound if !folder.is_dir() => {
                io::Error::other(format!("there is no directory {}", folder.display()))
            }
            kind => io::Error::from(kind),
        }
    })
}

/// Makes the rename itself reach the disk.
#[cfg(unix)]
fn sync_folder(target: &Path) -> io::Result<()> {
    match target.parent() {
        Some(folder) if folder != Path::new("") => fs::File::open(folder)?.sync_all(),
        _ => fs::File::open(".")?.sync_all(),
    }
}

#[cfg(not(unix))]
fn sync_folder(_target: &Path) -> io::Result<()> {
    Ok(())
}
