//! Charts and nap maps that were painted here: each is a PNG of its own beside its preset, which alone uses it. An image that
//! was imported is never written.
//!
//! While a design is edited, such an image has pixels and no path (`chart.image` is left out), so that every state of the
//! history is whole in itself; the path appears in the file alone. The PNG says whose it is in a text chunk.

use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use renderer_core::design::{ChartImage, Design};
use renderer_core::image::{encode_chart_png, png_text};

use super::write::write_together;
use super::{FileError, write_atomically};

/// What is painted here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Painted {
    Chart,
    Nap,
}

impl Painted {
    const ALL: [Self; 2] = [Self::Chart, Self::Nap];

    /// Keyword of the text that names the preset an image belongs to.
    fn keyword(self) -> &'static str {
        match self {
            Self::Chart => "Towel Designer chart of",
            Self::Nap => "Towel Designer nap map of",
        }
    }

    /// How its files' names end.
    fn ending(self) -> &'static str {
        match self {
            Self::Chart => "chart",
            Self::Nap => "nap",
        }
    }

    /// Its path and pixels in a design.
    fn of(self, design: &mut Design) -> (&mut Option<String>, &mut Option<ChartImage>) {
        match self {
            Self::Chart => (&mut design.chart.image, &mut design.chart.pixels),
            Self::Nap => (&mut design.nap.image, &mut design.nap.pixels),
        }
    }
}

/// Most names that are tried for a new file.
const MOST_NAMES: usize = 1000;

/// The PNGs that belong to a preset.
#[derive(Debug, Clone, Default)]
pub struct OwnImages([Option<OwnImage>; 2]);

/// A PNG that belongs to a preset, and what it holds.
#[derive(Debug, Clone)]
struct OwnImage {
    painted: Painted,
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

/// The file name of the preset that an image belongs to, as the image tells it.
fn owner(painted: Painted, image: &Path) -> Option<String> {
    png_text(BufReader::new(File::open(image).ok()?), painted.keyword())
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
        for own in self.own.0.iter().flatten() {
            *own.painted.of(design).0 = Some(name_of(&own.path));
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
        Ok(OwnImages(self.own.0.map(|own| own.and_then(stamped))))
    }
}

impl OwnImages {
    /// Takes those images of a design just read from `preset` for its own that are: from then on their pixels are the
    /// design's.
    pub(super) fn take(design: &mut Design, preset: &Path) -> Self {
        Self(Painted::ALL.map(|painted| OwnImage::take(painted, design, preset)))
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
        for (slot, painted) in Painted::ALL.into_iter().enumerate() {
            let mut design = design.clone();
            let (None, Some(pixels)) = painted.of(&mut design) else {
                continue;
            };
            let known = known.0[slot].as_ref();
            if let Some(known) = known.filter(|known| known.holds(preset, pixels)) {
                prepared.own.0[slot] = Some(known.clone());
                continue;
            }
            let failed = |path: &Path, source| FileError::Write {
                path: path.to_owned(),
                source,
            };
            let path = free_name(painted, preset, known).ok_or_else(|| {
                let what = format!("no name for its {} is free", painted.ending());
                failed(preset, io::Error::other(what))
            })?;
            let bytes = encode_chart_png(pixels, &[(painted.keyword(), &name_of(preset))])
                .map_err(|error| failed(&path, io::Error::other(error)))?;
            prepared.own.0[slot] = Some(OwnImage {
                painted,
                path: path.clone(),
                pixels: pixels.clone(),
                stamp: Stamp::default(),
            });
            prepared.new.push((path, bytes));
        }
        Ok(prepared)
    }
}

impl OwnImage {
    fn take(painted: Painted, design: &mut Design, preset: &Path) -> Option<Self> {
        let (image, pixels) = painted.of(design);
        let path = preset
            .parent()
            .unwrap_or(Path::new(""))
            .join(image.as_ref()?);
        if owner(painted, &path)? != name_of(preset) {
            return None;
        }
        let own = Self {
            painted,
            stamp: stamp(&path).ok()?,
            pixels: pixels.clone()?,
            path,
        };
        *image = None;
        Some(own)
    }

    /// Whether the file still holds these pixels for this preset.
    fn holds(&self, preset: &Path, pixels: &ChartImage) -> bool {
        self.path.parent() == preset.parent()
            && self.is_untouched()
            && owner(self.painted, &self.path).is_some_and(|owner| owner == name_of(preset))
            && self.pixels == *pixels
    }

    fn is_untouched(&self) -> bool {
        stamp(&self.path).is_ok_and(|stamp| stamp == self.stamp)
    }
}

/// A name beside `preset` that is free or belongs to it: `NAME-chart.png`, `NAME-chart-2.png` and so on. What the preset's
/// image was written to before is only used again if nobody else has written there since.
fn free_name(painted: Painted, preset: &Path, known: Option<&OwnImage>) -> Option<PathBuf> {
    let stem = preset.file_stem().unwrap_or_default().to_string_lossy();
    let ending = painted.ending();
    (1..=MOST_NAMES)
        .map(|k| match k {
            1 => preset.with_file_name(format!("{stem}-{ending}.png")),
            k => preset.with_file_name(format!("{stem}-{ending}-{k}.png")),
        })
        .find(|path| {
            if fs::symlink_metadata(path).is_err() {
                return true;
            }
            let is_ours = owner(painted, path).is_some_and(|owner| owner == name_of(preset));
            let is_touched =
                known.is_some_and(|known| known.path == *path && !known.is_untouched());
            is_ours && !is_touched
        })
}
