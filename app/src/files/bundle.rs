//! Bundles (`.towel`): a design in one file, a zip archive of `preset.toml` and the images it names.
//!
//! The preset is a preset as any other; its images are members of the archive and named as such, never files outside,
//! so that a bundle looks the same everywhere and cannot reach into the machine that opens it.

use std::collections::BTreeMap;
use std::fs;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use renderer_core::design::{Design, ImagePixels, ImageSlot, preset};

use super::image_paths::same_form;
use super::image_words::file_stem;
use super::images::{decode_image, encode_image};
use super::input::{Input, open_file};
use super::strip::stripped;
use super::zip::{self, Archive};
use super::{Carried, FileError, LARGEST_PRESET, write_atomically};

/// Ending of bundles, without the dot.
pub const BUNDLE_ENDING: &str = "towel";
/// The member that is the preset.
pub(super) const PRESET: &str = "preset.toml";
/// Largest bundle, bytes: all images as large as they may be.
pub(super) const LARGEST_BUNDLE: u64 = 3 << 29;
/// Largest image in a bundle, unpacked, bytes: a chart of 8192 x 8192 noise takes half of it.
pub(super) const LARGEST_IMAGE: usize = 512 << 20;

/// Where large images stay outside, most bytes of images together.
const MOST_AT_ONCE: usize = 24 << 20;

/// Whether a file's name is that of a bundle.
pub fn is_bundle(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case(BUNDLE_ENDING))
}

/// A design with the files it takes along, ready to be written.
pub(super) struct Packed {
    text: String,
    images: Carried,
    /// Images that were too large.
    pub left_out: Vec<LeftOut>,
}

/// An image that a design does not take along.
pub(super) struct LeftOut {
    /// Which.
    pub slot: ImageSlot,
    /// The name by which the preset goes on naming it: never a path, which would tell of the machine.
    pub name: String,
    /// Its size, bytes.
    pub size: usize,
}

/// The last images that were packed, so that packing a design again costs little while its images stay the same.
#[derive(Default)]
pub struct Packer {
    /// For each image its pixels and its file.
    last: BTreeMap<ImageSlot, (ImagePixels, Image)>,
}

/// An image's file: a name that says its format, and its bytes.
#[derive(Clone)]
pub(super) struct Image {
    /// Its name.
    pub name: String,
    /// Its content.
    pub bytes: Arc<[u8]>,
}

impl Packer {
    /// Packs a design whose relative image paths are names of `carried` files or start at `folder`. With `most`, images
    /// of more bytes stay outside.
    pub(super) fn pack(
        &mut self,
        design: &Design,
        carried: &Carried,
        folder: &Path,
        most: Option<usize>,
    ) -> Result<Packed, String> {
        let mut design = design.clone();
        let mut packed = Packed {
            text: String::new(),
            images: Carried::default(),
            left_out: Vec::new(),
        };
        for slot in ImageSlot::of(&design) {
            if let Some(image) = self.image(slot, &design, carried, folder)? {
                let name = packed.take(slot, image, most);
                slot.set_path(&mut design, Some(name));
            } else {
                // A path to an image that the design does not have.
                slot.set_path(&mut design, None);
            }
        }
        packed.text = preset::write(&design).map_err(|error| error.to_string())?;
        Ok(packed)
    }

    /// The file of an image of a design: the one it was read from where that still has the image's pixels, else one
    /// made of them.
    pub(super) fn image(
        &mut self,
        slot: ImageSlot,
        design: &Design,
        carried: &Carried,
        folder: &Path,
    ) -> Result<Option<Image>, String> {
        let Some(pixels) = slot.pixels(design) else {
            return Ok(None);
        };
        let found = Found::new(slot.path(design), carried, folder);
        let image = match self.last.get(&slot) {
            Some((last, image)) if *last == pixels => image.clone(),
            _ => found.image(slot, &pixels)?,
        };
        self.last.insert(slot, (pixels, image.clone()));
        Ok(Some(image))
    }
}

/// What there is of an image outside memory.
struct Found {
    name: String,
    bytes: Option<Arc<[u8]>>,
}

impl Found {
    fn new(path: Option<&str>, carried: &Carried, folder: &Path) -> Self {
        let Some(path) = path else {
            return Self {
                name: String::new(),
                bytes: None,
            };
        };
        let name = file_name(path).to_owned();
        if let Some(bytes) = carried.get(path) {
            return Self {
                name,
                bytes: Some(Arc::clone(bytes)),
            };
        }
        let file = folder.join(path);
        let file = std::path::absolute(&file).unwrap_or(file);
        let bytes = match fs::metadata(&file) {
            Ok(found) if found.is_file() && found.len() <= LARGEST_IMAGE as u64 => {
                fs::read(&file).ok()
            }
            _ => None,
        };
        Self {
            name,
            bytes: bytes.map(Arc::from),
        }
    }

    /// Its file, without what that says beside the pixels, if it has the right pixels, or else one made of them.
    fn image(&self, slot: ImageSlot, pixels: &ImagePixels) -> Result<Image, String> {
        let is_same = |bytes: &Vec<u8>| {
            decode_image(slot, bytes).is_ok_and(|decoded| decoded.pixels == *pixels)
        };
        let bytes = self.bytes.as_deref().map(stripped);
        if let Some(bytes) = bytes.filter(is_same) {
            return Ok(Image {
                name: self.name.clone(),
                bytes: bytes.into(),
            });
        }
        let stem = Path::new(&self.name).file_stem();
        let stem = stem.map_or(file_stem(slot).into(), |stem| stem.to_string_lossy());
        let (bytes, ending) = encode_image(pixels)?;
        Ok(Image {
            name: format!("{stem}.{ending}"),
            bytes: bytes.into(),
        })
    }
}

impl Packed {
    /// Takes an image along, if it is not too large. Returns how the preset names it.
    fn take(&mut self, slot: ImageSlot, image: Image, most: Option<usize>) -> String {
        let mut name = image.name;
        while self.is_taken(&name) {
            name = format!("{}-{name}", file_stem(slot));
        }
        let size = image.bytes.len();
        let taken: usize = self.images.iter().map(|(_, bytes)| bytes.len()).sum();
        if most.is_some_and(|most| size > most || taken + size > MOST_AT_ONCE) {
            let name = name.clone();
            self.left_out.push(LeftOut { slot, name, size });
        } else {
            self.images.insert(&name, image.bytes);
        }
        name
    }

    /// Whether something else has the name.
    fn is_taken(&self, name: &str) -> bool {
        let mut left_out = self.left_out.iter();
        name == PRESET
            || self.images.get(name).is_some()
            || left_out.any(|left_out| left_out.name == name)
    }

    /// The bundle.
    pub fn archive(&self) -> Result<Vec<u8>, String> {
        self.archive_with(None)
    }

    /// The bundle with a member more.
    pub fn archive_with(&self, more: Option<(&str, &[u8])>) -> Result<Vec<u8>, String> {
        let preset = std::iter::once((PRESET, self.text.as_bytes())).chain(more);
        let images = self.images.iter().map(|(name, bytes)| (name, &**bytes));
        zip::write(preset.chain(images)).map_err(|error| error.to_string())
    }
}

/// The last part of a path of any platform; without characters that other platforms have no file names of.
fn file_name(path: &str) -> &str {
    let name = path.rsplit(['/', '\\', ':']).next().unwrap_or(path);
    if name.contains(['<', '>', '"', '|', '?', '*']) {
        ""
    } else {
        name
    }
}

/// Writes a design as a bundle; relative image paths are names of `carried` files or start at `folder`.
///
/// # Errors
/// When the file cannot be written.
pub fn save_bundle(
    design: &Design,
    carried: &Carried,
    folder: &Path,
    to: &Path,
) -> Result<(), FileError> {
    let packed = Packer::default().pack(design, carried, folder, None);
    let archive = packed.and_then(|packed| packed.archive());
    let archive = archive.map_err(|error| FileError::Write {
        path: to.to_owned(),
        source: std::io::Error::other(error),
    })?;
    write_atomically(to, &archive)
}

/// The text of a bundle's preset and the images it names.
pub(super) struct Unpacked {
    /// The preset.
    pub text: String,
    /// Images.
    pub carried: Carried,
}

/// Reads a bundle's file.
pub(super) fn read_bundle(path: &Path) -> Result<Unpacked, FileError> {
    let file = open_file(path).map_err(|source| FileError::Read {
        path: path.to_owned(),
        source,
    })?;
    unpack_input(path, &mut Input::File(BufReader::new(file)))
}

/// Reads a bundle that was opened.
pub(super) fn unpack_input(path: &Path, input: &mut Input) -> Result<Unpacked, FileError> {
    let archive = input.read_all(LARGEST_BUNDLE);
    let archive = archive.map_err(|source| FileError::Read {
        path: path.to_owned(),
        source,
    })?;
    unpack(&archive).map_err(|what| FileError::Bundle {
        path: path.to_owned(),
        what,
    })
}

/// Unpacks the preset of an archive and those of its members that it names. Other programs may have packed the archive
/// anew: with a folder around everything, with files of their own, with other forms of names.
pub(super) fn unpack(archive: &[u8]) -> Result<Unpacked, String> {
    let mut archive = Archive::open(archive)?;
    let preset = preset_member(&archive)?;
    let text = archive.read(&preset, LARGEST_PRESET as usize)?;
    let text = String::from_utf8(text.unwrap_or_default())
        .map_err(|_| format!("is broken: its {preset} is no text"))?;
    let folder = preset.rfind('/').map_or("", |end| &preset[..=end]);
    let mut carried = Carried::default();
    // A preset with faults names no images; who reads the text reports the faults.
    let design = preset::parse(&text).unwrap_or_default();
    for name in ImageSlot::of(&design).filter_map(|slot| slot.path(&design)) {
        let member = format!("{folder}{}", same_form(name));
        if let Some(bytes) = archive.read(&member, LARGEST_IMAGE)? {
            carried.insert(name, bytes);
        }
    }
    Ok(Unpacked { text, carried })
}

/// The member that is the preset: the outermost of its name, or else the outermost preset of any name.
fn preset_member(archive: &Archive<'_>) -> Result<String, String> {
    let depth = |name: &str| name.matches('/').count();
    let file_of = |name: &str| name.rsplit('/').next().unwrap_or_default().to_lowercase();
    let outermost = |is_wanted: &dyn Fn(&str) -> bool| -> Vec<&str> {
        let wanted = || archive.names().filter(|name| is_wanted(&file_of(name)));
        let least = wanted().map(depth).min();
        wanted().filter(|name| Some(depth(name)) == least).collect()
    };
    let mut presets = outermost(&|file| file == PRESET);
    if presets.is_empty() {
        presets = outermost(&|file| file.ends_with(".toml"));
    }
    match presets[..] {
        [preset] => Ok(preset.into()),
        [] => Err(format!("is no bundle: it has no {PRESET}")),
        [first, second, ..] => Err(format!(
            "is no bundle: it has several presets, {first} and {second} among them; unpack it and open one of these"
        )),
    }
}
