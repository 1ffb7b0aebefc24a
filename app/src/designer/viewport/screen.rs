//! How large the screen's pixels are, for views at true scale, and what else the view remembers from one start to the
//! next.
//!
//! Window systems do not report it reliably: they give a scale factor, from which 96 dots per inch at 100 % is assumed.
//! A user with a ruler knows better.

use std::path::{Path, PathBuf};

use egui::Context;
use serde::{Deserialize, Serialize};

use crate::files;

/// Dots per inch that window systems mean by a scale of 100 %.
const ASSUMED_DPI: f64 = 96.0;
/// Dots per inch that a screen may have: a wall of lamps, a telephone.
pub const DPI_RANGE: std::ops::RangeInclusive<f64> = 30.0..=1000.0;
/// Millimetres in an inch.
pub const MM_PER_INCH: f64 = 25.4;

/// What is remembered.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
struct Settings {
    /// Pixels of the screen in an inch, as the user measured them.
    dots_per_inch: Option<f64>,
    /// Whether there is a scale bar.
    scale_bar: bool,
    /// Whether the picture is shown as it is, though it could be denoised.
    plain: bool,
    /// Whether the user has turned, moved or zoomed a cloth before.
    knows_gestures: bool,
}

/// The settings and their file.
pub struct Screen {
    settings: Settings,
    stored: Settings,
    file: Option<PathBuf>,
    is_calibrating: bool,
}

impl Screen {
    /// Reads the settings from the folder; without one, or where there are none yet, starts with the usual ones.
    pub fn new(folder: Option<&Path>) -> Self {
        let file = folder.map(|folder| folder.join("view.json"));
        let text = file.as_ref().and_then(|file| std::fs::read(file).ok());
        let read = text.and_then(|text| serde_json::from_slice::<Settings>(&text).ok());
        let mut settings = read.unwrap_or_default();
        settings.dots_per_inch = settings.dots_per_inch.filter(|dpi| DPI_RANGE.contains(dpi));
        Self {
            settings,
            stored: settings,
            file,
            is_calibrating: false,
        }
    }

    /// Writes the settings if they have changed; an error that says what is lost otherwise.
    pub fn store(&mut self) -> Result<(), String> {
        if self.settings == self.stored || self.is_calibrating {
            return Ok(());
        }
        self.stored = self.settings;
        let Some(file) = &self.file else {
            return Ok(());
        };
        let write = || {
            let text = serde_json::to_vec_pretty(&self.settings).map_err(|e| e.to_string())?;
            let folder = file.parent().unwrap_or(Path::new("."));
            std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            files::write_atomically(file, &text).map_err(|e| e.to_string())
        };
        write().map_err(|error| {
            format!(
                "{error}. The screen's size and the view's settings last until the program ends."
            )
        })
    }

    /// Pixels of the screen in a millimetre.
    pub fn pixels_per_mm(&self, ctx: &Context) -> f64 {
        self.dots_per_inch(ctx) / MM_PER_INCH
    }

    /// Whether the user has measured the screen.
    pub fn is_calibrated(&self) -> bool {
        self.settings.dots_per_inch.is_some()
    }

    /// Pixels of the screen in an inch, measured or assumed.
    pub fn dots_per_inch(&self, ctx: &Context) -> f64 {
        let scale = ctx.native_pixels_per_point().unwrap_or(1.0);
        let assumed = ASSUMED_DPI * f64::from(scale);
        self.settings.dots_per_inch.unwrap_or(assumed)
    }

    /// Whether there is a scale bar.
    pub fn has_scale_bar(&self) -> bool {
        self.settings.scale_bar
    }

    /// Shows or hides the scale bar.
    pub fn toggle_scale_bar(&mut self) {
        self.settings.scale_bar = !self.settings.scale_bar;
    }

    /// Whether the picture is denoised where it can be.
    pub fn denoises(&self) -> bool {
        !self.settings.plain
    }

    /// Shows the picture denoised, or as it is.
    pub fn toggle_denoising(&mut self) {
        self.settings.plain = !self.settings.plain;
    }

    /// Whether to say how a cloth is turned, moved and zoomed.
    pub fn needs_hint(&self) -> bool {
        !self.settings.knows_gestures
    }

    /// Notes that the user knows.
    pub fn knows_gestures(&mut self) {
        self.settings.knows_gestures = true;
    }

    /// Whether the window that asks is open.
    pub fn is_calibrating(&mut self) -> &mut bool {
        &mut self.is_calibrating
    }

    /// Sets what the user has measured, or forgets it.
    pub fn set_dots_per_inch(&mut self, dpi: Option<f64>) {
        self.settings.dots_per_inch =
            dpi.map(|dpi| dpi.clamp(*DPI_RANGE.start(), *DPI_RANGE.end()));
    }
}
