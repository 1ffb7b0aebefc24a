//! The designer: a window with the document's panels, the cloth rendered live, and the presets.
//!
//! ```text
//! panels ──edit──► Document ──ViewRequest──► render thread ──pictures──► viewport
//!    └────────── Command ──► App: files, dialogs, camera, export
//! ```
//!
//! Panels edit the document and nothing else; whatever else they, menus and keys want is a [`Command`], which `app`
//! carries out. What takes time happens on other threads: rendering (`render_thread`), thumbnails beside it
//! (`presets::thumbnails`), reading files (`tasks`), exporting (`export`), system dialogs (`shell::dialogs`).
//!
//! | module | what is in it |
//! | --- | --- |
//! | `app` | the window: its state, its frame and layout, what commands do, opening and saving |
//! | `document` | the design being edited, its history and its file; settings; what is kept in case the program dies |
//! | `panels` | the panels that edit the design, one file each |
//! | `chart_editor` | the chart, painted beside the cloth |
//! | `viewport` | the cloth: camera, gestures, what is drawn over the picture |
//! | `render_thread` | the thread that renders for the viewport |
//! | `presets` | the list of presets, and the thread that draws thumbnails |
//! | `export` | the export window and its job |
//! | `new_design` | the window that starts a design, and the cloths it starts with |
//! | `shell` | menus, bars, messages, questions, dialogs, and the commands they give |
//! | `tasks` | results to come from other threads |
//! | `widgets` | controls that know nothing of towels, and their look |

mod app;
mod chart_editor;
mod document;
mod export;
mod new_design;
pub mod panels;
mod presets;
mod render_thread;
mod shell;
mod tasks;
mod viewport;
mod widgets;

use std::path::PathBuf;

pub use app::{
    App, SMALLEST_WINDOW, WindowHandoff, has_glyph, in_a_window, run, use_fonts, use_system_fonts,
};
pub use document::Document;
pub use document::folders::Folders;
pub use document::labels::label_of;
pub use document::settings::denoiser_folder;
pub use new_design::{Cloth, ClothKind};
pub use panels::length_pictures;
pub use presets::thumbnails;
pub use render_thread::draft_lighting::{CACHED_SHADOWS, LiveLight};
pub use render_thread::renderer::{DisplayFrame, MakeBackend, for_window, noise_left, softened};
pub use render_thread::workers;
pub use render_thread::{
    Denoising, DeviceInUse, Priority, RenderThread, Seen, Stage, ViewRequest, ViewState,
};
pub use shell::command::Command;
pub use viewport::camera_moves;
pub use widgets::{Icon, colour_space, shapes};

use crate::backend::BackendChoice;
use crate::denoiser::MakeDenoiser;

/// What the designer starts with.
pub struct Setup {
    /// Preset to open.
    pub preset: Option<PathBuf>,
    /// Backend to render with.
    pub choice: BackendChoice,
    /// How backends are made.
    pub make: MakeBackend,
    /// How a denoiser is made.
    pub denoiser: MakeDenoiser,
    /// Whether to try the system's file dialogs before our own.
    pub system_dialogs: bool,
    /// Where to keep what outlives the program; without, nothing is kept.
    pub folders: Option<Folders>,
}
