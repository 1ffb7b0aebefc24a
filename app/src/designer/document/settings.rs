//! What the window remembers from one start to the next: recent files, look, sizes, folders. A small TOML file in the
//! user's configuration folder; one that cannot be read is set aside, with a notice, and never stops the program.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use renderer_core::design::Quality;
use renderer_core::render::MAX_SIDE;
use serde::{Deserialize, Serialize};

use crate::designer::widgets::UnitSystem;

/// Most recent files that are remembered.
const MOST_RECENT: usize = 12;
/// Largest settings file that is read, bytes.
const LARGEST: u64 = 1 << 20;

/// Interface scales that a user can choose, percent.
pub const SCALES: [u32; 11] = [75, 80, 90, 100, 110, 125, 150, 175, 200, 225, 250];

/// Light or dark.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ThemeChoice {
    /// As the system has it.
    #[default]
    System,
    /// Dark.
    Dark,
    /// Light.
    Light,
}

/// What is remembered. Fields that a newer version has written are left out of account.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Light or dark.
    pub theme: ThemeChoice,
    /// What lengths are shown in.
    pub units: UnitSystem,
    /// Scale of the interface, percent.
    pub scale: u32,
    /// Width of the document's panels, points.
    pub panels_width: Option<f32>,
    /// Width of the presets, points.
    pub presets_width: Option<f32>,
    /// Whether presets are shown; without, where there is room for them.
    pub shows_presets: Option<bool>,
    /// Files last opened or saved, the latest first.
    pub recent: Vec<PathBuf>,
    /// Whether panels are open, by title.
    pub open_panels: BTreeMap<String, bool>,
    /// The folder last used for a purpose.
    pub folders: BTreeMap<String, PathBuf>,
    /// The folder that Open Image Denoise is taken from; without, it is looked for.
    pub denoiser_folder: Option<PathBuf>,
    /// How the last picture was exported.
    pub export: Option<ExportSettings>,
}

/// Size and quality of an exported picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExportSettings {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples of a pixel at which it is done.
    pub samples: u32,
    /// Estimated relRMSE at which it is done.
    pub error: Option<f64>,
    /// Seconds after which it is done.
    pub seconds: Option<f64>,
    /// Pixels an inch on paper.
    pub dots_per_inch: f64,
}

/// The folder that the settings in a folder name for Open Image Denoise, if they can be read and name one.
pub fn denoiser_folder(folder: &Path) -> Option<PathBuf> {
    let text = fs::read_to_string(folder.join(Settings::FILE)).ok()?;
    toml::from_str::<Settings>(&text).ok()?.denoiser_folder
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            theme: ThemeChoice::default(),
            units: UnitSystem::default(),
            scale: 100,
            panels_width: None,
            presets_width: None,
            shows_presets: None,
            recent: Vec::new(),
            open_panels: BTreeMap::new(),
            folders: BTreeMap::new(),
            denoiser_folder: None,
            export: None,
        }
    }
}

impl Settings {
    /// Name of the file in the configuration folder.
    pub const FILE: &str = "settings.toml";

    /// Reads the file in `folder`; without one there are defaults. A file that cannot be used is renamed, and the
    /// reason is returned beside the defaults.
    pub fn load(folder: &Path) -> (Self, Option<String>) {
        let path = folder.join(Self::FILE);
        let read = || -> Result<Option<Self>, String> {
            match fs::metadata(&path) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
                Err(error) => return Err(error.to_string()),
                Ok(metadata) if metadata.len() > LARGEST => {
                    return Err(format!("is {} bytes large", metadata.len()));
                }
                Ok(_) => {}
            }
            let text = fs::read_to_string(&path).map_err(|error| error.to_string())?;
            let settings: Self = toml::from_str(&text).map_err(|error| error.to_string())?;
            Ok(Some(settings.in_range()))
        };
        match read() {
            Ok(settings) => (settings.unwrap_or_default(), None),
            Err(error) => {
                let aside = path.with_extension("toml.broken");
                let place = match fs::rename(&path, &aside) {
                    Ok(()) => format!("It was renamed to {}.", aside.display()),
                    Err(error) => format!("It could not be renamed either: {error}."),
                };
                let what = format!(
                    "{}: {}\n{place} All settings have their first values again.",
                    path.display(),
                    error.trim_end()
                );
                (Self::default(), Some(what))
            }
        }
    }

    /// As text of the file.
    pub fn text(&self) -> String {
        let mut settings = self.clone();
        // A path that is no text cannot be written down.
        settings.recent.retain(|path| path.to_str().is_some());
        settings.folders.retain(|_, path| path.to_str().is_some());
        settings.denoiser_folder = settings
            .denoiser_folder
            .filter(|path| path.to_str().is_some());
        toml::to_string(&settings).unwrap_or_default()
    }

    /// What was edited by hand may be anything.
    fn in_range(mut self) -> Self {
        let (least, most) = (SCALES[0], SCALES[SCALES.len() - 1]);
        self.scale = self.scale.clamp(least, most);
        let usable = |width: &f32| width.is_finite() && (50.0..2000.0).contains(width);
        self.panels_width = self.panels_width.filter(usable);
        self.presets_width = self.presets_width.filter(usable);
        self.recent.truncate(MOST_RECENT);
        self.export = self.export.filter(ExportSettings::is_possible);
        self
    }

    /// Puts a file at the head of the recent ones.
    pub fn add_recent(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.remove_recent(&path);
        self.recent.insert(0, path);
        self.recent.truncate(MOST_RECENT);
    }

    /// Takes a file off the recent ones.
    pub fn remove_recent(&mut self, path: &Path) {
        self.recent.retain(|recent| recent != path);
    }

    /// The next larger (`1`) or smaller (`-1`) scale.
    pub fn next_scale(&self, step: i32) -> u32 {
        let larger = SCALES.into_iter().find(|scale| *scale > self.scale);
        let smaller = SCALES.into_iter().rev().find(|scale| *scale < self.scale);
        let next = if step > 0 { larger } else { smaller };
        next.unwrap_or(self.scale)
    }
}

impl ExportSettings {
    fn is_possible(&self) -> bool {
        let sides = self.size.iter().all(|side| (1..=MAX_SIDE).contains(side));
        let samples = Quality::FIELDS.samples;
        let is_within = |value: Option<f64>, most: f64| value.is_none_or(|v| v > 0.0 && v <= most);
        sides
            && (samples.min..=samples.max).contains(&f64::from(self.samples))
            && is_within(self.error, 1.0)
            && is_within(self.seconds, 600_000.0)
            && (10.0..=2400.0).contains(&self.dots_per_inch)
    }
}
