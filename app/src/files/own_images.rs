//! Images that were painted here (charts and nap maps): each is a PNG of its own beside its preset, which alone uses
//! it. An image that was imported is never written.
//!
//! While a design is edited, such an image has pixels and no path (`chart.image` is left out), so that every state of
//! the history is whole in itself; the path appears in the file alone. The PNG says whose it is in a text chunk.

use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use renderer_core::design::{ChartImage, Design, ImagePixels, ImageSlot};
use renderer_core::image::{encode_chart_png, png_text};

use super::image_words::{file_stem, words};
use super::paths::{name_of_parts, stem_of};
use super::write::{write_error, write_together};
use super::{FileError, UsedFile, write_atomically};

/// Most names that are tried for a new file.
pub(super) const MOST_NAMES: usize = 1000;

/// The PNGs that belong to a preset.
#[derive(Debug, Clone, Default)]
pub struct OwnImages(Vec<OwnImage>);

/// A PNG that belongs to a preset, and what it holds.
#[derive(Debug, Clone)]
struct OwnImage {
    slot: ImageSlot,
    path: PathBuf,
    pixels: ChartImage,
    stamp: Stamp,
}

/// How a file was left: who finds another stamp finds a file that somebody else has written.
type Stamp = (u64, Option<SystemTime>);

fn stamp(path: &Path) -> io::Result<Stamp> {
    let found = fs::metadata(path)?;
    Ok((found.len(), found.modified().ok()))
}

/// The file name of the preset that an image belongs to, as the image says.
fn owner(slot: ImageSlot, image: &Path) -> Option<String> {
    let keyword = words(slot).owner_keyword?;
    png_text(BufReader::new(File::open(image).ok()?), keyword)
}

fn name_of(file: &Path) -> String {
    let name = file.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Images that are about to be named by a preset.
#[derive(Default)]
pub(super) struct Prepared {
    own: OwnImages,
    /// Those of them that are to be written first, each with its content.
    new: Vec<(PathBuf, Vec<u8>)>,
}

impl Prepared {
    /// Names them in the design that is to be written.
    pub(super) fn name_in(&self, design: &mut Design) {
        for own in &self.own.0 {
            own.slot.set_path(design, Some(name_of(&own.path)));
        }
    }

    /// Writes what is to be written, and the preset: either all are new or none, but for a crash between two renames.
    ///
    /// # Errors
    /// When a file cannot be written; then all are as they were.
    pub(super) fn write_with(self, preset: &Path, text: &[u8]) -> Result<OwnImages, FileError> {
        if self.new.is_empty() {
            write_atomically(preset, text)?;
            return Ok(self.own);
        }
        let images = self.new.iter().map(|(path, bytes)| (&**path, &**bytes));
        let files: Vec<(&Path, &[u8])> = images.chain([(preset, text)]).collect();
        write_together(&files)?;
        let stamped = |own: OwnImage| {
            let stamp = stamp(&own.path).ok()?;
            Some(OwnImage { stamp, ..own })
        };
        Ok(OwnImages(
            self.own.0.into_iter().filter_map(stamped).collect(),
        ))
    }
}

impl OwnImages {
    /// Takes those images of a design just read from `preset` for its own that are: from then on their pixels are the
    /// design's.
    pub(super) fn take(design: &mut Design, preset: &Path) -> Self {
        Self(
            ImageSlot::of(design)
                .filter_map(|slot| OwnImage::take(slot, design, preset))
                .collect(),
        )
    }

    /// Their files, and what they are.
    pub fn files(&self) -> Vec<UsedFile> {
        let own = self.0.iter();
        own.map(|own| {
            let what = format!("the {} of the design", words(own.slot).name);
            UsedFile::new(&own.path, what)
        })
        .collect()
    }

    /// Makes those images of a design that is to be written to `preset` ready that were painted here.
    ///
    /// # Errors
    /// When an image cannot be encoded or no name is free.
    pub(super) fn prepare(
        design: &Design,
        preset: &Path,
        known: &Self,
    ) -> Result<Prepared, FileError> {
        let mut prepared = Prepared::default();
        for slot in ImageSlot::of(design) {
            let (Some(keyword), None, Some(ImagePixels::Colours(pixels))) = (
                words(slot).owner_keyword,
                slot.path(design),
                slot.pixels(design),
            ) else {
                continue;
            };
            let known = known.0.iter().find(|known| known.slot == slot);
            if let Some(known) = known.filter(|known| known.holds(preset, &pixels)) {
                prepared.own.0.push(known.clone());
                continue;
            }
            let path = free_name(slot, preset, known).ok_or_else(|| {
                let what = format!("no name for its {} is free", file_stem(slot));
                write_error(preset, io::Error::other(what))
            })?;
            let bytes = encode_chart_png(&pixels, &[(keyword, &name_of(preset))])
                .map_err(|error| write_error(&path, io::Error::other(error)))?;
            prepared.own.0.push(OwnImage {
                slot,
                path: path.clone(),
                pixels,
                stamp: Stamp::default(),
            });
            prepared.new.push((path, bytes));
        }
        Ok(prepared)
    }
}

impl OwnImage {
    fn take(slot: ImageSlot, design: &mut Design, preset: &Path) -> Option<Self> {
        let folder = preset.parent().unwrap_or(Path::new(""));
        let path = folder.join(slot.path(design)?);
        if owner(slot, &path)? != name_of(preset) {
            return None;
        }
        let Some(ImagePixels::Colours(pixels)) = slot.pixels(design) else {
            return None;
        };
        let stamp = stamp(&path).ok()?;
        slot.set_path(design, None);
        Some(Self {
            slot,
            path,
            pixels,
            stamp,
        })
    }

    /// Whether the file still holds these pixels for this preset.
    fn holds(&self, preset: &Path, pixels: &ChartImage) -> bool {
        self.path.parent() == preset.parent()
            && self.is_untouched()
            && owner(self.slot, &self.path).is_some_and(|owner| owner == name_of(preset))
            && self.pixels == *pixels
    }

    fn is_untouched(&self) -> bool {
        stamp(&self.path).is_ok_and(|stamp| stamp == self.stamp)
    }
}

/// A name beside `preset` that is free or belongs to it: `NAME-chart.png`, `NAME-chart-2.png` and so on. What the
/// preset's image was written to before is only used again if nobody else has written there since.
fn free_name(slot: ImageSlot, preset: &Path, known: Option<&OwnImage>) -> Option<PathBuf> {
    let stem = stem_of(preset);
    let ending = file_stem(slot);
    (1..=MOST_NAMES)
        .map(|k| match k {
            1 => format!("-{ending}.png"),
            k => format!("-{ending}-{k}.png"),
        })
        .map(|end| preset.with_file_name(name_of_parts(&stem, &end)))
        .find(|path| {
            if fs::symlink_metadata(path).is_err() {
                return true;
            }
            let is_ours = owner(slot, path).is_some_and(|owner| owner == name_of(preset));
            let is_touched =
                known.is_some_and(|known| known.path == *path && !known.is_untouched());
            is_ours && !is_touched
        })
}
