//! The denoiser of this machine: where it is looked for, and how one gets it.

use std::path::PathBuf;
use std::sync::Arc;

use renderer_core::denoise::{self, Denoise, DenoiseError, Denoiser, Places, Searched};

use crate::advice::{Place, with_advice_on_denoiser};
use crate::designer::{Folders, denoiser_folder};

/// Makes a denoiser; an error says why there is none.
pub type MakeDenoiser = Arc<dyn Fn() -> Result<Box<dyn Denoise>, DenoiseError> + Send + Sync>;

/// The folder of the user's cache into which `app/run` puts the library, in a folder of its version.
const BROUGHT: &str = "open-image-denoise";

/// Looks for the library in the places of this machine and user.
pub fn search() -> Searched {
    let folders = Folders::of_user();
    let named = folders
        .as_ref()
        .and_then(|folders| denoiser_folder(&folders.config));
    let mut places = Places::of_machine(named);
    places.folders.extend(
        folders
            .map(|folders| brought(folders.cache.join(BROUGHT)))
            .into_iter()
            .flatten(),
    );
    denoise::find(&places)
}

/// Folders of the versions that were brought, the last first.
fn brought(folder: PathBuf) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    // One that begins with a dot is still being unpacked.
    let whole = entries.filter(|entry| !entry.file_name().to_string_lossy().starts_with('.'));
    let mut folders: Vec<PathBuf> = whole.map(|entry| entry.path().join("lib")).collect();
    folders.sort_unstable_by(|a, b| b.cmp(a));
    folders
}

/// The denoiser of this machine.
///
/// # Errors
/// When there is none that can be used.
pub fn make() -> Result<Box<dyn Denoise>, DenoiseError> {
    let Searched { found, refused } = search();
    for refused in &refused {
        tracing::warn!("{refused}");
    }
    // One that is there but cannot be used tells more than that none was found.
    let library = found.map_err(|error| refused.into_iter().next().unwrap_or(error))?;
    Ok(Box::new(Denoiser::new(&library)?))
}

/// What `info` says of it: its lines.
pub fn report() -> Vec<String> {
    let Searched { found, refused } = search();
    let made = found.and_then(|library| {
        let denoiser = Denoiser::new(&library)?;
        Ok(format!(
            "denoiser: {}, {}",
            denoiser.name(),
            library.path().display()
        ))
    });
    let line = made.unwrap_or_else(|error| {
        format!(
            "denoiser: none: {}",
            with_advice_on_denoiser(&error, Place::CommandLine)
        )
    });
    let refused = refused.iter().map(|error| format!("  not used: {error}"));
    std::iter::once(line).chain(refused).collect()
}
