//! Fields that were part of a design once: they are read and mean nothing, and whoever opens the file
//! learns it.

use toml::de::{DeTable, DeValue};

/// A field of earlier preset files.
pub(super) struct Retired {
    section: &'static str,
    name: &'static str,
    /// What it means now.
    pub now: &'static str,
}

const RETIRED: [Retired; 2] = [
    Retired {
        section: "quality",
        name: "traced_bounces",
        now: "whether bounces are estimated is up to the view, not to the design",
    },
    Retired {
        section: "quality",
        name: "cached_shadows",
        now: "whether shadows are shared is up to the view, not to the design",
    },
];

impl Retired {
    /// Its path.
    pub fn path(&self) -> String {
        format!("{}.{}", self.section, self.name)
    }

    /// The retired field of this path.
    pub fn at(path: &str) -> Option<&'static Self> {
        RETIRED.iter().find(|retired| retired.path() == path)
    }

    /// Takes all of them out of a file; those that said something, and the byte where each does. Files of earlier
    /// programs name every field; 0, which switched these off, is what holds now.
    pub fn take_out(root: &mut DeTable<'_>) -> Vec<(&'static Self, usize)> {
        let mut found = Vec::new();
        for retired in &RETIRED {
            let section = root.get_mut(retired.section).map(toml::Spanned::get_mut);
            let Some(DeValue::Table(section)) = section else {
                continue;
            };
            let Some(value) = section.remove(retired.name) else {
                continue;
            };
            let integer = value.get_ref().as_integer();
            if integer.is_none_or(|integer| integer.as_str() != "0") {
                found.push((retired, value.span().start));
            }
        }
        found
    }
}
