//! What a list of presets shows of a file, without reading it whole into a design.

use std::path::Path;

use renderer_core::design::{ImageSlot, preset};

use super::bundle::{LARGEST_IMAGE, is_bundle, read_bundle};
use super::image_paths::found_as;
use super::input::read_file;
use super::outside::is_outside;
use super::{Carried, KnownOutside, LARGEST_PRESET, Outside, Shipped};

/// What is to be said of a preset before it is opened.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Outline {
    /// The comment it begins with, as one paragraph.
    pub comment: String,
    /// A number that differs between any two presets that look different.
    pub content: u64,
}

impl Outline {
    /// Of a preset or bundle; empty for what cannot be read, and for what is no file. Of images outside the preset's
    /// folder those that are `known` count.
    pub fn of_file(path: &Path, known: &KnownOutside) -> Self {
        if is_bundle(path) {
            let Ok(unpacked) = read_bundle(path) else {
                return Self::default();
            };
            return Self::of_text(&unpacked.text, &unpacked.carried);
        }
        let text = read_file(path, LARGEST_PRESET).ok();
        let Some(text) = text.and_then(|text| String::from_utf8(text).ok()) else {
            return Self::default();
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut images = Carried::default();
        let design = preset::parse(&text).unwrap_or_default();
        let outside = Outside::Known(known);
        for name in ImageSlot::of(&design).filter_map(|slot| slot.path(&design)) {
            if is_outside(folder, name) && !outside.opens(path, name) {
                continue;
            }
            let file = found_as(folder, name).map(|file| folder.join(file));
            if let Some(Ok(bytes)) = file.map(|file| read_file(&file, LARGEST_IMAGE as u64)) {
                images.insert(name, bytes);
            }
        }
        Self::of_text(&text, &images)
    }

    /// Of a preset that comes with the program.
    pub fn of_shipped(shipped: &Shipped) -> Self {
        Self::of_text(shipped.text, &shipped.images())
    }

    fn of_text(text: &str, images: &Carried) -> Self {
        let lines = text.lines().map_while(|line| line.strip_prefix('#'));
        let words: Vec<&str> = lines.map(str::trim).collect();
        let comment = words.join(" ").trim().to_owned();
        let mut hash = Fnv::default();
        hash.add(text.as_bytes());
        for (name, bytes) in images.iter() {
            hash.add(name.as_bytes());
            hash.add(bytes);
        }
        Self {
            comment,
            content: hash.0,
        }
    }
}

/// Fowler, Noll and Vo's hash (FNV-1a, 64 bits): the same on every machine and in every version.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Adds a part, and where it ends.
    fn add(&mut self, bytes: &[u8]) {
        let length = (bytes.len() as u64).to_le_bytes();
        for byte in bytes.iter().chain(&length) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
