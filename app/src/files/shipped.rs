//! The presets that come with the program, as part of it: nothing depends on where the program lies.

use std::path::Path;

use super::preset::{Reading, Source};
use super::{Carried, FileError, Opened, Origin};

// `FILES`: name and content of every preset and chart in the folder `presets`, made by build.rs.
include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// A preset that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shipped {
    /// Its name, that of its file without the ending.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

impl Shipped {
    /// All of them, by name.
    pub fn all() -> impl Iterator<Item = Self> {
        FILES.iter().filter_map(|(file, bytes)| {
            let name = file.strip_suffix(".toml")?;
            let text = std::str::from_utf8(bytes).ok()?;
            Some(Self { name, text })
        })
    }

    /// The preset of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|shipped| shipped.name == name)
    }

    /// Reads it.
    ///
    /// # Errors
    /// None that a test has not found.
    pub fn open(&self) -> Result<Opened, FileError> {
        let path = format!("{}.toml", self.name);
        let source = Source::new(Path::new(&path), Origin::Program, self.images());
        source.open(self.text, Reading::default())
    }

    /// The images it names.
    pub(super) fn images(&self) -> Carried {
        let mut images = Carried::default();
        for (file, bytes) in FILES {
            if !file.ends_with(".toml") && self.text.contains(file) {
                images.insert(file, *bytes);
            }
        }
        images
    }
}
