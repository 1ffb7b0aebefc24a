//! Which light the viewport shows: estimated bounces, soon clear, or traced ones, as in an export.

use renderer_core::design::Design;
use renderer_core::render::Settings;

/// First samples whose shadows neighbouring points share, and some of which go on where others end, so that the estimate
/// gets right; the later ones are sharper, and outweigh these as they get many.
pub const CACHED_SHADOWS: u32 = 64;

/// How the viewport gets the light of many bounces, and shadows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LiveLight {
    /// Bounces are estimated after the first scattering, and shadows shared at first.
    #[default]
    Fast,
    /// As the design says: what an export shows.
    True,
}

impl LiveLight {
    /// Both, in menu order.
    pub const ALL: [Self; 2] = [Self::Fast, Self::True];

    /// What menus call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast light",
            Self::True => "true light",
        }
    }

    /// What it does.
    pub fn what(self) -> &'static str {
        match self {
            Self::Fast => {
                "Light that bounces on between the loops is estimated, better as the view looks on, and shadows are soft \
                at first: clear much sooner, and still so when the camera moves. Exports are not affected."
            }
            Self::True => "Every shadow and every bounce of light is traced, as in an export.",
        }
    }

    /// Whether the two differ for a design: not if it has neither bounces nor shadows.
    pub fn matters(design: &Design) -> bool {
        let [fast, whole] = [Self::Fast, Self::True].map(|light| light.settings(design));
        fast.path_cutoff() != whole.path_cutoff()
            || fast.caches_shadows(0) != whole.caches_shadows(0)
    }

    /// The settings of a picture of a design with this light.
    pub fn settings(self, design: &Design) -> Settings {
        let mut settings = Settings::from(&design.quality);
        if self == Self::Fast {
            settings.traced_bounces = 1;
            settings.cached_shadows = CACHED_SHADOWS;
            settings.learns_bounces = true;
        }
        settings
    }
}
