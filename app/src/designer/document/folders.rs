//! Where the designer keeps what outlives it: settings, the user's presets, pictures of presets, unsaved designs.

use std::path::PathBuf;

use directories::ProjectDirs;

/// The folders; none need exist yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// Settings.
    pub config: PathBuf,
    /// What can be made anew: thumbnails.
    pub cache: PathBuf,
    /// Unsaved designs, until they are saved or given up.
    pub state: PathBuf,
    /// The user's own presets.
    pub presets: PathBuf,
}

impl Folders {
    /// The user's folders as the platform has them; `None` for users without a home.
    pub fn of_user() -> Option<Self> {
        let folders = ProjectDirs::from("", "", "towel-designer")?;
        let state = folders.state_dir().unwrap_or(folders.data_local_dir());
        Some(Self {
            config: folders.config_dir().into(),
            cache: folders.cache_dir().into(),
            state: state.join("unsaved"),
            presets: folders.data_dir().join("presets"),
        })
    }
}
