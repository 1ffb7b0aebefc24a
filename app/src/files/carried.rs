//! Image files that lie in no folder: they came with a design in a bundle, in a picture or in the program itself.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::image_paths::same_form;

/// Files by the names that the design has for them; `./chart.png` and `chart.png` are the same file, whatever form the
/// accents have.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Carried(BTreeMap<String, Arc<[u8]>>);

impl Carried {
    /// The file that the design calls `name`.
    pub fn get(&self, name: &str) -> Option<&Arc<[u8]>> {
        self.0.get(&same_form(name))
    }

    /// Adds a file.
    pub fn insert(&mut self, name: &str, bytes: impl Into<Arc<[u8]>>) {
        self.0.insert(same_form(name), bytes.into());
    }

    /// All files with their names, in the order of these.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Arc<[u8]>)> {
        self.0.iter().map(|(name, bytes)| (name.as_str(), bytes))
    }
}
