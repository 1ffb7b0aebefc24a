//! Preset files: a design as commented TOML, `format = 1`.
//!
//! - [`parse`] reads a file and reports every fault in it with line and column; nothing is half read. [`parse_noting`]
//!   also says what of it means nothing any more.
//! - [`write()`] writes every field with its unit, range and meaning. What it writes, [`parse`] reads back equal.
//! - [`set`] changes one field by its path, as `--set pile.tilt=30` does.
//!
//! Types, names and ranges come from [`Shape`](super::Shape), the same description that `section!` makes for the
//! designer's sliders. Fields that a file leaves out have their defaults, so `format = 1` alone is a plain white towel.

mod faults;
mod path;
mod read;
mod retired;
mod set;
mod write;

use std::fmt;

pub use faults::MOST_FAULTS;
pub use read::{parse, parse_noting, position_of};
pub use set::{SetError, set};
pub use write::write;

/// One thing wrong in a preset file, or to be said of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PresetFault {
    /// Line, from 1.
    pub line: usize,
    /// Character within the line, from 1.
    pub column: usize,
    /// Field at fault, as in `light.sun[0].elevation`; empty where the text is no TOML, and where faults
    /// are only counted.
    pub path: String,
    /// What is wrong and what is allowed; names the field.
    pub message: String,
}

impl fmt::Display for PresetFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}
