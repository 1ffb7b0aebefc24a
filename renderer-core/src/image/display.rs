//! From linear light to what a screen shows: exposure, tone map, sRGB.
//!
//! Displayed value = sRGB(tone map(linear × 2^exposure)), MODEL.md §11; a design's exposure is what its meter says and
//! its own (`Design::exposure`). The viewport, PNG files and FLIP all use it;
//! EXR files hold the linear picture and never come here.

use crate::design::{Design, ToneMap, linear_to_srgb};

/// How linear light is displayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Display {
    /// Brightness in stops: light is multiplied by 2^exposure.
    pub exposure: f64,
    /// What happens to light above white.
    pub tone_map: ToneMap,
}

impl From<&Design> for Display {
    fn from(design: &Design) -> Self {
        Self {
            exposure: design.exposure(),
            tone_map: design.view.tone_map,
        }
    }
}

/// Linear value above which `filmic` departs from the identity: dark and middle tones, where a chart's colours live,
/// look the same under both tone maps.
pub(crate) const SHOULDER: f64 = 0.6;

impl Display {
    /// sRGB-encoded colour in [0, 1] of linear light; NaN shows as black.
    pub fn encode(&self, linear: [f32; 3]) -> [f64; 3] {
        let scale = self.exposure.exp2();
        linear.map(|channel| {
            let light = (f64::from(channel) * scale).max(0.0);
            let shown = match self.tone_map {
                ToneMap::None => light.min(1.0),
                ToneMap::Filmic => filmic(light),
            };
            linear_to_srgb(shown)
        })
    }
}

/// The shoulder of a film's curve without its toe: x up to the shoulder s, then 1 − (1−s)²/(x + 1 − 2s), which leaves s
/// with slope 1 and approaches 1 for ever brighter light.
fn filmic(light: f64) -> f64 {
    let room = 1.0 - SHOULDER;
    if light <= SHOULDER {
        light
    } else {
        1.0 - room * room / (light - SHOULDER + room)
    }
}
