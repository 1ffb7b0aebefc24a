//! What is the same for all measurements of a run.

use std::fmt;
use std::time::Duration;

use renderer_core::render::BackendKind;

/// What is the same for all measurements of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Width and height of the window's picture, pixels.
    pub window: [u32; 2],
    /// What renders.
    pub backend: BackendKind,
    /// Its adapter or cores.
    pub device: String,
    /// Time for each preset.
    pub budget: Duration,
}

impl fmt::Display for Conditions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        let (backend, device) = (self.backend.name(), &self.device);
        write!(f, "{width} × {height} pixels, {backend} ({device})")
    }
}
