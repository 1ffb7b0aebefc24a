//! Colours as users see them: 8-bit sRGB, written `#rrggbb`.

use serde::{Deserialize, Serialize};

/// An sRGB colour of 8 bits a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// White, `#ffffff`.
    pub const WHITE: Self = Self([255; 3]);

    /// Linear light of each channel in [0, 1] (IEC 61966-2-1).
    pub fn linear(self) -> [f64; 3] {
        self.0.map(|c| srgb_to_linear(f64::from(c) / 255.0))
    }

    /// The nearest 8-bit colour to linear light; values outside [0, 1] are clipped.
    pub fn from_linear(linear: [f64; 3]) -> Self {
        Self(linear.map(|c| (linear_to_srgb(c.clamp(0.0, 1.0)) * 255.0).round() as u8))
    }
}

/// One channel of sRGB, [0, 1], to linear light.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// One channel of linear light, [0, 1], to sRGB.
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

impl TryFrom<String> for Colour {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let digits = text
            .strip_prefix('#')
            .filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()));
        let number = digits.and_then(|d| u32::from_str_radix(d, 16).ok());
        let [_, r, g, b] = number
            .ok_or_else(|| format!("{text:?} is not a colour, allowed is \"#rrggbb\""))?
            .to_be_bytes();
        Ok(Self([r, g, b]))
    }
}

impl From<Colour> for String {
    fn from(Colour([r, g, b]): Colour) -> Self {
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
