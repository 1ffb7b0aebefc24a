//! Presets: reading them with the images they name, writing them so that the images are found again.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use renderer_core::design::Design;
use renderer_core::design::preset::{self, PresetFault};

use super::{FileError, load_chart, load_environment, write_atomically};

/// Largest preset file, bytes; the largest stitch pattern takes less than a tenth of it.
const LARGEST_PRESET: u64 = 16 << 20;

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
