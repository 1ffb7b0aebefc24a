//! Charts that were painted here: each is a PNG of its own beside its preset, which alone uses it. An image that was
//! imported is never written.
//!
//! While a design is edited, such a chart has pixels and no path ([`Chart::image`] is left out), so that every state of the
//! history is whole in itself; the path appears in the file alone. The PNG says whose it is in a text chunk.

use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use renderer_core::design::{Chart, ChartImage, Design};
use renderer_core::image::{encode_chart_png, png_text};

use super::write::write_together;
use super::{FileError, write_atomically};

/// Keyword of the text that names the preset a chart belongs to.
const KEYWORD: &str = "Towel Designer chart of";

/// Most names that are tried for a new file.
const MOST_NAMES: usize = 1000;

/// The PNG that belongs to a preset, and what it holds.
#[derive(Debug, Clone)]
pub struct OwnChart {
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

/// The file name of the preset that a chart belongs to, as the chart tells it.
fn owner(chart: &Path) -> Option<String> {
    png_text(BufReader::new(File::open(chart).ok()?), KEYWORD)
}

fn name_of(file: &Path) -> String {
    let name = file.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// A chart that is about to be named by a preset: in its file already, or to be written first.
pub(super) enum Prepared {
    /// There.
    There(OwnChart),
    /// To be written.
    New {
        path: PathBuf,
        bytes: Vec<u8>,
        pixels: ChartImage,
    },
}

impl Prepared {
    /// How the preset names it.
    pub(super) fn name(&self) -> String {
        let (Self::There(OwnChart { path, .. }) | Self::New { path, .. }) = self;
        name_of(path)
    }

    /// Writes the chart, if need be, and its preset: either both are new or none, but for a crash between two renames.
    ///
    /// # Errors
    /// When a file cannot be written; then both are as they were.
    pub(super) fn write_with(
        self,
        preset: &Path,
        text: &[u8],
    ) -> Result<Option<OwnChart>, FileError> {
        match self {
            Self::There(own) => {
                write_atomically(preset, text)?;
                Ok(Some(own))
            }
            Self::New {
                path,
                bytes,
                pixels,
            } => {
                write_together(&[(&path, &bytes), (preset, text)])?;
                let own = stamp(&path).map(|stamp| OwnChart {
                    path,
                    pixels,
                    stamp,
                });
                Ok(own.ok())
            }
        }
    }
}

impl OwnChart {
    /// Takes the chart of a design just read from `preset` for its own, if it is: from then on its pixels are the design's.
    pub(super) fn take(chart: &mut Chart, preset: &Path) -> Option<Self> {
        let (image, pixels) = (chart.image.as_ref()?, chart.pixels.as_ref()?);
        let path = preset.parent().unwrap_or(Path::new("")).join(image);
        if owner(&path)? != name_of(preset) {
            return None;
        }
        let own = Self {
            stamp: stamp(&path).ok()?,
            pixels: pixels.clone(),
            path,
        };
        chart.image = None;
        Some(own)
    }

    /// Whether the file still holds these pixels for this preset.
    fn holds(&self, preset: &Path, pixels: &ChartImage) -> bool {
        self.path.parent() == preset.parent()
            && self.is_untouched()
            && owner(&self.path).is_some_and(|owner| owner == name_of(preset))
            && self.pixels == *pixels
    }

    fn is_untouched(&self) -> bool {
        stamp(&self.path).is_ok_and(|stamp| stamp == self.stamp)
    }

    /// Makes the chart of a design that is to be written to `preset` ready, if it was painted here.
    ///
    /// # Errors
    /// When the chart cannot be encoded or no name is free.
    pub(super) fn prepare(
        design: &Design,
        preset: &Path,
        known: Option<&Self>,
    ) -> Result<Option<Prepared>, FileError> {
        let (None, Some(pixels)) = (&design.chart.image, &design.chart.pixels) else {
            return Ok(None);
        };
        if let Some(known) = known.filter(|known| known.holds(preset, pixels)) {
            return Ok(Some(Prepared::There(known.clone())));
        }
        let failed = |path: &Path, source| FileError::Write {
            path: path.to_owned(),
            source,
        };
        let path = free_name(preset, known)
            .ok_or_else(|| failed(preset, io::Error::other("no name for its chart is free")))?;
        let bytes = encode_chart_png(pixels, &[(KEYWORD, &name_of(preset))])
            .map_err(|error| failed(&path, io::Error::other(error)))?;
        Ok(Some(Prepared::New {
            path,
            bytes,
            pixels: pixels.clone(),
        }))
    }
}

/// A name beside `preset` that is free or belongs to it: `NAME-chart.png`, `NAME-chart-2.png` and so on. What the preset's
/// chart was written to before is only used again if nobody else has written there since.
fn free_name(preset: &Path, known: Option<&OwnChart>) -> Option<PathBuf> {
    let stem = preset.file_stem().unwrap_or_default().to_string_lossy();
    (1..=MOST_NAMES)
        .map(|k| match k {
            1 => preset.with_file_name(format!("{stem}-chart.png")),
            k => preset.with_file_name(format!("{stem}-chart-{k}.png")),
        })
        .find(|path| {
            if fs::symlink_metadata(path).is_err() {
                return true;
            }
            let is_ours = owner(path).is_some_and(|owner| owner == name_of(preset));
            let is_touched =
                known.is_some_and(|known| known.path == *path && !known.is_untouched());
            is_ours && !is_touched
        })
}
