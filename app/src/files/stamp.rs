//! Telling whether a file is still the one that was read.

use std::path::Path;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

/// When a file was last written, and its size: what differs once another program has written it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    modified: Option<SystemTime>,
    size: u64,
}

impl Stamp {
    /// Of the file as it is now; `None` if there is none.
    pub fn of(path: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(path).ok()?;
        Some(Self {
            modified: metadata.modified().ok(),
            size: metadata.len(),
        })
    }
}
