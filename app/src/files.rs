//! All file reading and writing. Every error names its file; every write is atomic: the bytes go to a temporary file in
//! the same directory, reach the disk, and replace the old file at once, so that a crash or a full disk leaves it whole.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Component, Path, PathBuf};

use image::{ImageFormat, ImageReader, Limits};
use renderer_core::design::preset::{self, PresetFault, SetError};
use renderer_core::design::{ChartImage, Design, Fault};

/// Largest preset file, bytes; the largest stitch pattern takes less than a tenth of it.
const LARGEST_PRESET: u64 = 16 << 20;
/// Most memory that decoding a chart may take, bytes: a chart of the largest size with 16 bits a channel.
const CHART_MEMORY: u64 = (ChartImage::MAX_SIDE * ChartImage::MAX_SIDE * 8) as u64 + (16 << 20);

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

/// Reads a preset and the chart image it names.
///
/// # Errors
/// When either cannot be read or has faults; all faults of the preset are in the error.
pub fn load_design(path: &Path) -> Result<Design, FileError> {
    load_design_with(path, &[])
}

/// As [`load_design`], with fields set to other values (paths and values as on the command line) before the chart is read.
///
/// # Errors
/// As [`load_design`], or when a field cannot be set.
pub fn load_design_with(path: &Path, sets: &[(String, String)]) -> Result<Design, FileError> {
    let mut design = read_preset(path)?;
    for (field, value) in sets {
        design = preset::set(&design, field, value)?;
    }
    if let Some(fault) = design.faults().into_iter().next() {
        let path = path.to_owned();
        return Err(FileError::Together { path, fault });
    }
    if let Some(chart) = chart_file(&design, path) {
        design.chart.pixels = Some(load_chart(&chart)?);
    }
    Ok(design)
}

fn read_preset(path: &Path) -> Result<Design, FileError> {
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
    preset::parse(&text).map_err(|faults| FileError::Preset {
        path: path.to_owned(),
        faults,
    })
}

/// The file of a design's chart image, whose path is relative to the preset at `preset`.
fn chart_file(design: &Design, preset: &Path) -> Option<PathBuf> {
    let image = design.chart.image.as_ref()?;
    Some(preset.parent().unwrap_or(Path::new("")).join(image))
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
    let broken = |error: image::ImageError| fault(format!("is broken: {error}"));
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

/// Writes a preset to `to`. `from` is the file the design was read from, which its relative chart path refers to; the
/// path is changed so that it leads to the same image from the new place. Returns the design as written.
///
/// # Errors
/// When the file cannot be written.
pub fn save_design(design: &Design, to: &Path, from: Option<&Path>) -> Result<Design, FileError> {
    let mut design = design.clone();
    if let Some(image) = &design.chart.image {
        let chart = match from {
            Some(from) => from.parent().unwrap_or(Path::new("")).join(image),
            None => PathBuf::from(image),
        };
        let moved = from.and_then(Path::parent) != to.parent();
        if moved || chart.is_absolute() {
            design.chart.image = Some(chart_path_from(to, &chart));
        }
    }
    let text = preset::write(&design).map_err(|error| FileError::Write {
        path: to.to_owned(),
        source: io::Error::other(error),
    })?;
    write_atomically(to, text.as_bytes())?;
    Ok(design)
}

/// The path by which a preset at `preset` names the image `chart` (relative to the working directory, or absolute):
/// relative where the two share more than the root, with forward slashes.
pub fn chart_path_from(preset: &Path, chart: &Path) -> String {
    let folder = match preset.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let absolute = |path: &Path| {
        path.canonicalize()
            .or_else(|_| std::path::absolute(path))
            .unwrap_or_else(|_| path.to_owned())
    };
    let (folder, chart) = (absolute(folder), absolute(chart));
    let (here, there): (Vec<_>, Vec<_>) =
        (folder.components().collect(), chart.components().collect());
    let shared = here.iter().zip(&there).take_while(|(a, b)| a == b).count();
    let only_root_shared = there[..shared]
        .iter()
        .all(|part| matches!(part, Component::Prefix(_) | Component::RootDir));
    if only_root_shared {
        return chart.to_string_lossy().into_owned();
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
