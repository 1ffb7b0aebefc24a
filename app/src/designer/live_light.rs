//! Which light the viewport shows: estimated bounces, soon clear, or traced ones, as in an export.

use renderer_core::design::Design;
use renderer_core::render::Settings;

/// How the viewport gets the light of many bounces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LiveLight {
    /// Estimated after the first scattering, unless the design itself says after which.
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
                "Light that bounces on between the loops is estimated: clear much sooner, a little off in brightness and depth. Exports are not affected."
            }
            Self::True => "Every bounce of light is traced, as in an export.",
        }
    }

    /// Whether the two differ for a design: not if its light scatters once, nor if it says itself what to estimate.
    pub fn matters(design: &Design) -> bool {
        let closing = |light: Self| light.settings(design).closing_bounce();
        closing(Self::Fast) != closing(Self::True)
    }

    /// The settings of a picture of a design with this light.
    pub fn settings(self, design: &Design) -> Settings {
        let mut settings = Settings::from(&design.quality);
        if self == Self::Fast && settings.traced_bounces == 0 {
            settings.traced_bounces = 1;
        }
        settings
    }
}
