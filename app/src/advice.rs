//! What helps when the renderer cannot do what it was asked: the renderer states facts, and what one can do about them
//! depends on where one is, at the command line or at the window.

use renderer_core::denoise::{DenoiseError, Places};
use renderer_core::render::{BackendKind, RenderError};
use renderer_core::scene::CompileError;

use crate::files::FileError;

/// Where advice is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// At the command line.
    CommandLine,
    /// Beside the viewport.
    Viewport,
    /// At the window that exports pictures.
    Export,
}

impl Place {
    /// How another backend is taken there.
    fn taking_backend(self, backend: &str) -> String {
        match self {
            Self::CommandLine => format!("use --backend {backend}"),
            Self::Viewport => format!("choose the backend {backend} in the status bar"),
            Self::Export => format!("choose the backend {backend} in the export window"),
        }
    }

    /// What the user does to the picture that does not fit.
    fn smaller(self) -> &'static str {
        match self {
            Self::CommandLine => "use a smaller picture or cloth",
            Self::Viewport | Self::Export => "make the cloth smaller",
        }
    }
}

/// The error, and what helps if anything does: `FACT; ADVICE`.
pub fn with_advice(error: &RenderError, place: Place) -> String {
    match advice(error, place) {
        Some(advice) => format!("{error}; {advice}"),
        None => error.to_string(),
    }
}

/// As [`with_advice`], of cloth that cannot be made: there it is the same everywhere.
pub fn with_advice_on_cloth(error: &CompileError) -> String {
    match error {
        CompileError::TooManyEntries { .. } => {
            format!("{error}; shorter or wider-set pile helps, and so do fewer warps and wefts")
        }
        CompileError::Invalid(_) | CompileError::Cancelled => error.to_string(),
    }
}

/// As [`with_advice`], of a file at the command line.
pub fn with_advice_on_file(error: &FileError) -> String {
    match error {
        FileError::Outside { .. } => format!(
            "{error}; if the file is from somebody you trust, use --allow-outside-images, or open it in the window once"
        ),
        _ => error.to_string(),
    }
}

/// As [`with_advice`], of a denoiser.
pub fn with_advice_on_denoiser(error: &DenoiseError, place: Place) -> String {
    let without = match place {
        Place::CommandLine => "or leave out --denoise",
        Place::Viewport => "the picture stays as it is without",
        Place::Export => "or export without",
    };
    match error {
        DenoiseError::NotFound => format!(
            "{error}; app/run brings it on Debian and Ubuntu, Blender has it in its folder, other systems have packages \
            of it (oidn, openimagedenoise), and {} takes its file from anywhere; {without}",
            Places::LIBRARY
        ),
        DenoiseError::SwitchedOff => {
            format!(
                "{error}; give {} the library's file, or unset it; {without}",
                Places::LIBRARY
            )
        }
        DenoiseError::Load { .. } | DenoiseError::Symbol { .. } | DenoiseError::Version { .. } => {
            format!(
                "{error}; {} can name another file; {without}",
                Places::LIBRARY
            )
        }
        DenoiseError::Failed(_) => format!("{error}; {without}"),
        DenoiseError::Cancelled => error.to_string(),
    }
}

/// What helps.
fn advice(error: &RenderError, place: Place) -> Option<String> {
    let processor = || place.taking_backend(BackendKind::Cpu.name());
    Some(match error {
        RenderError::NoAdapter(_) => format!(
            "install a Vulkan driver (on Debian and Ubuntu: mesa-vulkan-drivers) or {}",
            processor()
        ),
        RenderError::BeyondAdapter { .. } | RenderError::OutOfMemory(_) => {
            format!("{} or {}", place.smaller(), processor())
        }
        RenderError::Method { backend, .. } => {
            let plainer = match backend {
                BackendKind::Gpu => BackendKind::Cpu,
                BackendKind::Cpu | BackendKind::Reference => BackendKind::Reference,
            };
            let method = match place {
                Place::CommandLine => "another method",
                Place::Viewport | Place::Export => "another method under View & quality",
            };
            format!("{} or {method}", place.taking_backend(plainer.name()))
        }
        RenderError::Device(_) | RenderError::Lost(_) => format!("try again or {}", processor()),
        RenderError::Size(_) => return None,
    })
}
