//! Images outside the folder of the file that names them.
//!
//! A preset or a picture from a stranger may name any file of the machine that opens it, or of another machine (on
//! Windows `\\host\share\…` alone tells that host who is there). So images are opened unasked only from the file's own
//! folder and the folders in it. For others the window asks, and the command line has a flag. What was allowed
//! once, and what this program itself has saved, is known: the same file may open the same images again, here.

use std::fmt;
use std::fs;
use std::path::{Component, Path, PathBuf};

use renderer_core::design::{Design, ImageSlot, preset};
use serde::{Deserialize, Serialize};

use super::bundle::is_bundle;
use super::draft::folder_of;
use super::image_words::words;
use super::{FileError, write_atomically};

/// Most files that are known.
const MOST_KNOWN: usize = 500;
/// Largest list of them that is read, bytes.
const LARGEST_LIST: u64 = 4 << 20;

/// What to do with images outside the folder of the file that names them.
#[derive(Debug, Clone, Copy, Default)]
pub enum Outside<'a> {
    /// Open them: the file is the user's own, or they said so.
    #[default]
    Open,
    /// Open those that are known, and else nothing.
    Known(&'a KnownOutside),
    /// Open the design without them.
    LeaveOut,
}

impl Outside<'_> {
    /// Whether the file at `path` may open this image.
    pub(super) fn opens(self, path: &Path, image: &str) -> bool {
        match self {
            Self::Open => true,
            Self::Known(known) => known.has(path, image),
            Self::LeaveOut => false,
        }
    }
}

/// An image outside the folder of the file that names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideImage {
    /// Which.
    pub slot: ImageSlot,
    /// As the file names it.
    pub name: String,
}

impl fmt::Display for OutsideImage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {:?}", self.slot.field(), self.name)
    }
}

impl OutsideImage {
    /// As in a question: "the chart image /home/…/chart.png".
    pub fn sentence(&self) -> String {
        format!("the {} {}", words(self.slot).name, self.name)
    }
}

/// Whether a file in `folder` names an image elsewhere. The names alone decide: to look at what is at a path may be
/// what should not be done.
pub(super) fn is_outside(folder: &Path, image: &str) -> bool {
    if image.split(['/', '\\']).any(|part| part == "..") {
        return true;
    }
    let path = Path::new(image);
    let is_whole = |part| matches!(part, Component::Prefix(_) | Component::RootDir);
    if !path.components().any(is_whole) {
        // What is a path from the root on another platform, or of another machine, is none of this folder.
        return image.starts_with('\\');
    }
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    !path.starts_with(folder)
}

/// The images that a design read from a file in `folder` names elsewhere.
pub(super) fn outside_images<'d>(
    folder: &Path,
    design: &'d Design,
) -> impl Iterator<Item = OutsideImage> + use<'d> {
    let folder = folder.to_owned();
    ImageSlot::of(design).filter_map(move |slot| {
        let name = slot.path(design).filter(|name| is_outside(&folder, name))?;
        Some(OutsideImage {
            slot,
            name: name.to_owned(),
        })
    })
}

/// Files whose images outside their folders may be opened unasked.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct KnownOutside {
    /// The latest first.
    file: Vec<Known>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Known {
    path: PathBuf,
    images: Vec<String>,
}

impl KnownOutside {
    /// Name of the list in the configuration folder.
    pub const FILE: &str = "outside-images.toml";

    /// Reads the list in `folder`; what cannot be read is unknown.
    pub fn load(folder: &Path) -> Self {
        let path = folder.join(Self::FILE);
        let is_small = |found: fs::Metadata| found.is_file() && found.len() <= LARGEST_LIST;
        let text = match fs::metadata(&path).is_ok_and(is_small) {
            true => fs::read_to_string(&path).unwrap_or_default(),
            false => String::new(),
        };
        toml::from_str(&text).unwrap_or_default()
    }

    /// Adds what the preset or picture at `path` names outside its folder to the list in `folder`.
    ///
    /// # Errors
    /// When the list cannot be written.
    pub fn note(folder: &Path, path: &Path, images: &[OutsideImage]) -> Result<(), FileError> {
        let Some(path) = key(path).filter(|path| path.to_str().is_some()) else {
            return Ok(());
        };
        let mut known = Self::load(folder);
        let images: Vec<String> = images.iter().map(|image| image.name.clone()).collect();
        let before = known.clone();
        known.file.retain(|known| known.path != path);
        if !images.is_empty() {
            known.file.insert(0, Known { path, images });
        }
        known.file.truncate(MOST_KNOWN);
        if known == before {
            return Ok(());
        }
        let made = fs::create_dir_all(folder);
        let list = folder.join(Self::FILE);
        made.map_err(|source| super::write_error(&list, source))?;
        let text = toml::to_string(&known).unwrap_or_default();
        write_atomically(&list, text.as_bytes())
    }

    /// As [`Self::note`], of a design that the user has just saved to `path`. What cannot be noted is asked about when
    /// the file is opened again.
    pub fn note_saved(folder: &Path, path: &Path) {
        if is_bundle(path) {
            return;
        }
        let Ok(text) = fs::read_to_string(path) else {
            return;
        };
        let design = preset::parse(&text).unwrap_or_default();
        let images: Vec<_> = outside_images(folder_of(path), &design).collect();
        let _ = Self::note(folder, path, &images);
    }

    fn has(&self, path: &Path, image: &str) -> bool {
        let path = key(path);
        let mut known = self.file.iter();
        known.any(|known| {
            Some(&known.path) == path.as_ref() && known.images.iter().any(|known| known == image)
        })
    }
}

/// The path by which a file is known.
fn key(path: &Path) -> Option<PathBuf> {
    path.canonicalize()
        .or_else(|_| std::path::absolute(path))
        .ok()
}
