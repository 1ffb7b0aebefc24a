//! All file reading and writing. Every error names its file; every write is atomic.
//!
//! - `preset`: presets, and the images they name
//! - `images`: the images of a design, read and encoded
//! - `image_words`: what they are called, and which files they are
//! - `image_paths`: the paths that designs name them by, whatever system wrote these
//! - `input`: what may be opened at all: files, and pipes that bring a design
//! - `bundle`, `zip`: a design and its images in one file
//! - `embedded`: designs in exported pictures
//! - `strip`: pictures without what is said beside their pixels
//! - `shipped`: the presets that are part of the program
//! - `pipelines`: what a GPU driver compiled
//! - `own_images`: images that were painted here
//! - `outside`: images outside the folder of the file that names them
//! - `unsaved`: designs in no file yet, kept for the case that the program dies
//! - `draft`, `write`: files that are whole or untouched
//! - `apart`, `paths`: that no file is written over another that is needed, and how files are called

mod apart;
mod bundle;
mod carried;
mod draft;
mod embedded;
mod image_paths;
mod image_words;
mod images;
mod input;
mod outline;
mod outside;
mod own_images;
mod paths;
mod pipelines;
mod preset;
mod shipped;
mod stamp;
mod strip;
mod unsaved;
mod write;
mod zip;

use std::io;
use std::path::{Path, PathBuf};

use renderer_core::design::preset::{PresetFault, SetError};
use renderer_core::design::{Fault, ImageSlot};

pub use apart::{UsedFile, check_apart};
pub use bundle::{BUNDLE_ENDING, Packer, is_bundle, save_bundle};
pub use carried::Carried;
pub use draft::Draft;
pub use embedded::{Embedded, carries_design, embedded, picture_title};
pub use image_words::{ImageWords, dropped, words};
pub use images::{LoadedImage, load_image};
pub use outline::Outline;
pub use outside::{KnownOutside, Outside, OutsideImage};
pub use own_images::OwnImages;
pub use paths::{absolute, picture_name, stem_of};
pub use pipelines::keep_pipelines;
pub use preset::{
    Opened, Origin, Reading, image_path_from, load_design, load_design_with, open_design,
    open_design_with, open_to_edit, read_design, save, save_design, save_edited,
};
pub use shipped::Shipped;
pub use stamp::Stamp;
pub use unsaved::{AutosaveFile, RecoveryFile, Unsaved};
pub use write::{check_writable, write_atomically, write_atomically_with, write_error};

/// Largest preset file, bytes; the largest stitch pattern takes less than a tenth of it.
const LARGEST_PRESET: u64 = 16 << 20;

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
    /// A bundle, or a picture that should carry one, cannot be used.
    #[error("{}: {what}", .path.display())]
    Bundle {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// An image cannot be used.
    #[error("{}: {}: {what}", .path.display(), words(*.slot).name)]
    Image {
        /// The image's file.
        path: PathBuf,
        /// What it is to be.
        slot: ImageSlot,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// A file that a command is to write is one that it reads, or another that it writes.
    #[error("{}: is {what}, and would be lost: choose another name", .path.display())]
    NotApart {
        /// The file.
        path: PathBuf,
        /// What it is already.
        what: String,
    },
    /// A file names images outside its own folder, which are not opened unasked.
    #[error("{}", outside_lines(.path, .images))]
    Outside {
        /// The file.
        path: PathBuf,
        /// The images, as it names them.
        images: Vec<OutsideImage>,
    },
    /// A file is whole, and could not take its name; the old one, if any, is untouched.
    #[error("{}: cannot be written: {source}; what was made is whole, and kept as {}", .path.display(), .kept.display())]
    Kept {
        /// The file.
        path: PathBuf,
        /// Where it is instead.
        kept: PathBuf,
        /// Why.
        source: io::Error,
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
        !matches!(self, Self::Write { .. } | Self::Kept { .. })
    }
}

fn fault_lines(path: &Path, faults: &[PresetFault]) -> String {
    let line = |fault: &PresetFault| format!("{}:{fault}", path.display());
    faults.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn outside_lines(path: &Path, images: &[OutsideImage]) -> String {
    let names: Vec<String> = images.iter().map(ToString::to_string).collect();
    format!(
        "{}: names images outside its own folder, which are not opened unless that is allowed: {}",
        path.display(),
        names.join(", ")
    )
}
