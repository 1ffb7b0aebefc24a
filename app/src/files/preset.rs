//! Presets: reading them with the images they name, writing them so that the images are found again.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use renderer_core::design::preset::{self, PresetFault};
use renderer_core::design::{Design, ImageSlot};

use super::bundle::{Image, PRESET, Packer, is_bundle, save_bundle, unpack_input};
use super::embedded::read_embedded;
use super::image_paths::{explanation, found_as, same_form};
use super::image_words::words;
use super::images::{LoadedImage, decode_image, load_image};
use super::input::{Content, Input};
use super::outside::{Outside, OutsideImage, is_outside};
use super::own_images::{MOST_NAMES, OwnImages};
use super::paths::name_of_parts;
use super::{Carried, FileError, LARGEST_PRESET, UsedFile, write_atomically, write_error};
use crate::lettering::outline_text;

/// What a design was read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A preset file, its images beside it.
    Preset,
    /// A bundle.
    Bundle,
    /// A picture that carries its design.
    Picture,
    /// The program itself.
    Program,
}

/// A design as it was read.
#[derive(Debug, Clone)]
pub struct Opened {
    /// The design.
    pub design: Design,
    /// Its images that lie in no folder.
    pub carried: Carried,
    /// What it was read from.
    pub origin: Origin,
    /// What could not be read but can be done without, as sentences.
    pub warnings: Vec<String>,
    /// The files that it was read from: itself and its images.
    pub read: Vec<UsedFile>,
    /// Images outside the folder of its file that were opened.
    pub outside: Vec<OutsideImage>,
    /// Images outside the folder of its file that were not to be opened.
    pub left_out: Vec<OutsideImage>,
}

/// How a design is read.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reading<'a> {
    /// Fields set to other values before images are read: paths and values as on the command line.
    pub sets: &'a [(String, String)],
    /// What to do with images outside the folder of the file.
    pub outside: Outside<'a>,
}

/// Reads a preset, a bundle or a picture that carries its design, with the images it names, wherever they are: for
/// files that are known. Of a file that may be anybody's, [`read_design`] opens no more than it may.
///
/// # Errors
/// When any of them cannot be read or has faults; all faults of the preset are in the error.
pub fn load_design(path: &Path) -> Result<Design, FileError> {
    load_design_with(path, &[])
}

/// As [`load_design`], with fields set to other values (paths and values as on the command line) before images are
/// read.
///
/// # Errors
/// As [`load_design`], or when a field cannot be set.
pub fn load_design_with(path: &Path, sets: &[(String, String)]) -> Result<Design, FileError> {
    open_design_with(path, sets).map(|opened| opened.design)
}

/// As [`load_design`], with what else is to be known of the file.
///
/// # Errors
/// As [`load_design`].
pub fn open_design(path: &Path) -> Result<Opened, FileError> {
    open_design_with(path, &[])
}

/// As [`read_design`], for editing: images that were painted here are the design's own again, without a path. Also what
/// is known of their files, for [`save_edited`].
///
/// # Errors
/// As [`read_design`].
pub fn open_to_edit(path: &Path, outside: Outside<'_>) -> Result<(Opened, OwnImages), FileError> {
    let mut opened = read_design(
        path,
        Reading {
            outside,
            ..Reading::default()
        },
    )?;
    let own = match opened.origin {
        Origin::Preset => OwnImages::take(&mut opened.design, path),
        Origin::Bundle | Origin::Picture | Origin::Program => OwnImages::default(),
    };
    Ok((opened, own))
}

/// As [`load_design_with`], with what else is to be known of the file.
///
/// # Errors
/// As [`load_design_with`].
pub fn open_design_with(path: &Path, sets: &[(String, String)]) -> Result<Opened, FileError> {
    read_design(
        path,
        Reading {
            sets,
            ..Reading::default()
        },
    )
}

/// Reads a preset, a bundle or a picture that carries its design, with those of its images that it may open.
///
/// # Errors
/// When any of them cannot be read or has faults (all faults of the preset are in the error), when a field cannot be
/// set, and when the file names images that it may not open.
pub fn read_design(path: &Path, reading: Reading<'_>) -> Result<Opened, FileError> {
    let failed = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let mut input = Input::open(path).map_err(failed)?;
    let content = input.content().map_err(failed)?;
    if content == Content::Png {
        let unpacked = read_embedded(path, &mut input)?;
        Source::new(path, Origin::Picture, unpacked.carried).open(&unpacked.text, reading)
    } else if content == Content::Zip || is_bundle(path) {
        let unpacked = unpack_input(path, &mut input)?;
        Source::new(path, Origin::Bundle, unpacked.carried).open(&unpacked.text, reading)
    } else {
        let text = read_preset(path, &mut input)?;
        Source::new(path, Origin::Preset, Carried::default()).open(&text, reading)
    }
}

/// Where a preset's text came from, and with it its images.
pub(super) struct Source<'a> {
    path: &'a Path,
    origin: Origin,
    carried: Carried,
}

impl<'a> Source<'a> {
    pub(super) fn new(path: &'a Path, origin: Origin, carried: Carried) -> Self {
        Self {
            path,
            origin,
            carried,
        }
    }

    /// Reads the text and the images it names.
    pub(super) fn open(self, text: &str, reading: Reading<'_>) -> Result<Opened, FileError> {
        let Reading { sets, outside } = reading;
        let (mut design, mut warnings) = self.parse(text)?;
        for (field, value) in sets {
            design = preset::set(&design, field, value)?;
        }
        warnings.extend(self.outline_texts(&mut design, sets));
        if let Some(fault) = design.faults().into_iter().next() {
            let path = self.path_of_text();
            return Err(FileError::Together { path, fault });
        }
        let mut faults = Vec::new();
        let (mut opened_outside, mut left_out) = (Vec::new(), Vec::new());
        let mut read = self.own_file();
        for slot in ImageSlot::of(&design) {
            // A file that was asked for on the command line is one, and the preset is not to blame for it.
            let is_set = sets.iter().any(|(set, _)| *set == slot.field());
            let folder = self.folder_of_images(is_set);
            let Some(named) = slot.path(&design) else {
                continue;
            };
            // Before anything is looked for there.
            let is_file = self.file_of_image(named, folder).is_some();
            if !is_set && is_file && is_outside(self.folder(), named) {
                let name = named.to_owned();
                if !outside.opens(self.path, named) {
                    left_out.push(OutsideImage { slot, name });
                    continue;
                }
                opened_outside.push(OutsideImage { slot, name });
            }
            self.name_as_found(slot, &mut design);
            let Some(image) = slot.path(&design) else {
                continue;
            };
            let file = self.file_of_image(image, folder);
            match self.read_image(slot, image, file.as_deref()) {
                Ok(loaded) => {
                    slot.set_pixels(&mut design, Some(loaded.pixels));
                    warnings.extend(loaded.warnings);
                    let what = format!("the {} of the design", words(slot).name);
                    read.extend(file.map(|file| UsedFile::new(file, what)));
                }
                Err(ReadError::File(error)) if is_set => return Err(error),
                Err(error) if self.origin == Origin::Picture => {
                    let (path, name) = (self.path.display(), words(slot).name);
                    warnings.push(format!("{path}: opened without its {name}: {error}"));
                    slot.leave_out(&mut design);
                }
                Err(error) => faults.push(fault_at(text, &slot.field(), &error)),
            }
        }
        if !faults.is_empty() {
            faults.sort_by_key(|fault| (fault.line, fault.column));
            let path = self.path_of_text();
            return Err(FileError::Preset { path, faults });
        }
        if !left_out.is_empty() && !matches!(outside, Outside::LeaveOut) {
            return Err(FileError::Outside {
                path: self.path.to_owned(),
                images: left_out,
            });
        }
        for image in &left_out {
            image.slot.leave_out(&mut design);
        }
        Ok(Opened {
            design,
            carried: self.carried,
            origin: self.origin,
            warnings,
            read,
            outside: opened_outside,
            left_out,
        })
    }

    /// The file itself, where it is one.
    fn own_file(&self) -> Vec<UsedFile> {
        match self.origin {
            Origin::Preset | Origin::Bundle | Origin::Picture => {
                vec![UsedFile::new(self.path, "the file of the design")]
            }
            Origin::Program => Vec::new(),
        }
    }

    /// The folder that the file is in: for what another program hands over, which is in none, the one that the program
    /// works in.
    fn folder(&self) -> &Path {
        let is_handed_over = ["/dev", "/proc"]
            .iter()
            .any(|root| self.path.starts_with(root));
        let folder = self.path.parent().filter(|_| !is_handed_over);
        folder.unwrap_or(Path::new(""))
    }

    /// Gives texts on the chart their outlines where they have none, or another text or font by now. Returns what is to
    /// be said of them.
    fn outline_texts(&self, design: &mut Design, sets: &[(String, String)]) -> Vec<String> {
        let place = self.path.display();
        let mut said = Vec::new();
        for (index, object) in design.chart.object.iter_mut().enumerate() {
            let field = |name: &str| format!("chart.object[{index}].{name}");
            let is_other =
                |(set, _): &(String, String)| [field("text"), field("font")].contains(set);
            if sets.iter().any(is_other) {
                object.outline = None;
            }
            let what = outline_text(object);
            said.extend(what.map(|what| format!("{place}: {} {what}", field("text"))));
        }
        said
    }

    /// The design that the text says, without its images, and what of the text means nothing any more.
    fn parse(&self, text: &str) -> Result<(Design, Vec<String>), FileError> {
        let path = self.path_of_text();
        match preset::parse_noting(text) {
            Ok((design, notes)) => {
                let place = path.display();
                let warnings = notes.iter().map(|note| format!("{place}:{note}"));
                Ok((design, warnings.collect()))
            }
            Err(faults) => Err(FileError::Preset { path, faults }),
        }
    }

    /// The file that messages about the text name.
    fn path_of_text(&self) -> PathBuf {
        match self.origin {
            Origin::Bundle => self.path.join(PRESET),
            Origin::Preset | Origin::Picture | Origin::Program => self.path.to_owned(),
        }
    }

    /// Where paths of images start; `None` where only what is carried counts.
    fn folder_of_images(&self, is_set: bool) -> Option<&Path> {
        match self.origin {
            Origin::Preset => Some(self.folder()),
            _ if is_set => Some(self.folder()),
            Origin::Bundle | Origin::Picture | Origin::Program => None,
        }
    }

    /// Names an image as this system does, where the design has its path in another form; only a path that leads
    /// nowhere stays.
    fn name_as_found(&self, slot: ImageSlot, design: &mut Design) {
        let Some(path) = slot.path(design) else {
            return;
        };
        let folder = self.folder_of_images(false);
        let found = match folder {
            Some(folder) => found_as(folder, path),
            None => (self.carried.get(path)).map(|_| same_form(path)),
        };
        if let Some(found) = found {
            slot.set_path(design, Some(found));
        }
    }

    /// The file that an image is to be read from; `None` where it is carried, or nowhere.
    fn file_of_image(&self, image: &str, folder: Option<&Path>) -> Option<PathBuf> {
        if let Some(folder) = folder {
            return Some(folder.join(image));
        }
        // What a picture did not take along, earlier programs named by its whole path.
        let is_whole = self.origin == Origin::Picture && Path::new(image).is_absolute();
        (is_whole && self.carried.get(image).is_none()).then(|| image.into())
    }

    fn read_image(
        &self,
        slot: ImageSlot,
        image: &str,
        file: Option<&Path>,
    ) -> Result<LoadedImage, ReadError> {
        if let Some(file) = file {
            return load_image(slot, file).map_err(|error| match explanation(image) {
                Some(why) if !file.exists() => ReadError::Carried(format!("{error}; {why}")),
                _ => ReadError::File(error),
            });
        }
        if let Some(bytes) = self.carried.get(image) {
            let of_image = |what: &String| format!("{image} {what}");
            let decoded = decode_image(slot, bytes);
            let decoded = decoded.map_err(|what| ReadError::Carried(of_image(&what)))?;
            let place = self.path.display();
            return Ok(LoadedImage {
                pixels: decoded.pixels,
                warnings: (decoded.notes.iter())
                    .map(|note| format!("{place}: {}", of_image(note)))
                    .collect(),
            });
        }
        let what = match self.origin {
            Origin::Bundle => "the bundle does not hold it, and files outside are not read",
            _ => "it is not there",
        };
        Err(ReadError::Carried(format!("{image}: {what}")))
    }
}

/// What is wrong with a field, where the text has it.
fn fault_at(text: &str, field: &str, error: &ReadError) -> PresetFault {
    let (line, column) = preset::position_of(text, field);
    PresetFault {
        line,
        column,
        path: field.into(),
        message: format!("{field}: {error}"),
    }
}

/// Why an image could not be read.
#[derive(Debug, thiserror::Error)]
enum ReadError {
    #[error("{0}")]
    File(FileError),
    #[error("{0}")]
    Carried(String),
}

/// A preset's text.
fn read_preset(path: &Path, input: &mut Input) -> Result<String, FileError> {
    let bytes = input.read_all(LARGEST_PRESET);
    let bytes = bytes.map_err(|source| FileError::Read {
        path: path.to_owned(),
        source,
    })?;
    String::from_utf8(bytes).map_err(|_| FileError::NoPreset {
        path: path.to_owned(),
        what: "is no preset: a preset is UTF-8 text (TOML)".into(),
    })
}

/// Saves a design: as a bundle where `to` has the name of one, else as a preset. `from` is the file the design was read
/// from, which its relative paths of images refer to; those of `carried` files come first.
///
/// # Errors
/// When the file, or an image beside it, cannot be written.
pub fn save(
    design: &Design,
    carried: &Carried,
    to: &Path,
    from: Option<&Path>,
) -> Result<(), FileError> {
    save_edited(design, carried, to, from, &OwnImages::default()).map(drop)
}

/// As [`save`]. An image that was painted here (it has pixels and no path) goes to a PNG of its own beside the preset,
/// unless `known` says that it is there; returned is what is known of them afterwards.
///
/// # Errors
/// As [`save`].
pub fn save_edited(
    design: &Design,
    carried: &Carried,
    to: &Path,
    from: Option<&Path>,
    known: &OwnImages,
) -> Result<OwnImages, FileError> {
    if is_bundle(to) {
        let folder = from.and_then(Path::parent).unwrap_or(Path::new(""));
        save_bundle(design, carried, folder, to).map(|()| OwnImages::default())
    } else {
        save_preset(design, carried, to, from, known).map(|(_, own)| own)
    }
}

/// Writes a preset to `to`. `from` is the file the design was read from, which its relative paths of images refer to;
/// they are changed so that they lead to the same images from the new place. Returns the design as written.
///
/// # Errors
/// When the file cannot be written.
pub fn save_design(design: &Design, to: &Path, from: Option<&Path>) -> Result<Design, FileError> {
    save_preset(design, &Carried::default(), to, from, &OwnImages::default())
        .map(|(design, _)| design)
}

/// Writes a preset, and beside it those of its images that lie in no file or that the preset could not name: what is
/// saved can be opened.
fn save_preset(
    design: &Design,
    carried: &Carried,
    to: &Path,
    from: Option<&Path>,
    known: &OwnImages,
) -> Result<(Design, OwnImages), FileError> {
    let failed = |why: String| FileError::Write {
        path: to.to_owned(),
        source: io::Error::other(why),
    };
    let old_folder = from.and_then(Path::parent).unwrap_or(Path::new(""));
    let new_folder = to.parent().unwrap_or(Path::new(""));
    let moved = from.and_then(Path::parent) != to.parent();
    let mut written = design.clone();
    let mut packer = Packer::default();
    for slot in ImageSlot::of(design) {
        let Some(path) = slot.path(design) else {
            continue;
        };
        let is_carried = carried.get(path).is_some();
        let file = old_folder.join(path);
        let mut path = path.to_owned();
        if !is_carried && (moved || file.is_absolute()) {
            path = image_path_from(to, &file);
        }
        if is_carried || !new_folder.join(&path).is_file() {
            let image = packer.image(slot, design, carried, old_folder);
            if let Some(image) = image.map_err(failed)? {
                path = write_beside(to, &image)?;
            }
        }
        slot.set_path(&mut written, Some(path));
    }
    let own = OwnImages::prepare(design, to, known)?;
    own.name_in(&mut written);
    let text = preset::write(&written).map_err(|error| failed(error.to_string()))?;
    let own = own.write_with(to, text.as_bytes())?;
    Ok((written, own))
}

/// Writes an image into the folder of a preset, under a name that no other file has; returns the name.
fn write_beside(preset: &Path, image: &Image) -> Result<String, FileError> {
    let name = Path::new(&image.name);
    let stem = name.file_stem().unwrap_or(name.as_os_str());
    let stem = stem.to_string_lossy();
    let ending = name.extension().unwrap_or_default().to_string_lossy();
    let is_same = |found: &fs::Metadata, file: &Path| {
        found.is_file()
            && found.len() == image.bytes.len() as u64
            && fs::read(file).is_ok_and(|bytes| *bytes == *image.bytes)
    };
    for number in 1..=MOST_NAMES {
        let name = match number {
            1 => name_of_parts(&stem, &format!(".{ending}")),
            _ => name_of_parts(&stem, &format!("-{number}.{ending}")),
        };
        let file = preset.with_file_name(&name);
        match fs::symlink_metadata(&file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                write_atomically(&file, &image.bytes)?;
                return Ok(name);
            }
            Ok(found) if is_same(&found, &file) => return Ok(name),
            _ => {}
        }
    }
    let what = format!("no name for its image {} is free", image.name);
    Err(write_error(preset, io::Error::other(what)))
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
