//! Linear light to displayed 8-bit colour by table: the viewport converts a megapixel for every published picture.
//!
//! The table is indexed by the upper bits of the number itself, ten of its mantissa: neighbouring entries differ by
//! a thousandth, a quarter of what 8-bit sRGB can show at its steepest.

use renderer_core::design::ToneMap;
use renderer_core::image::Display;

/// Lower bits of an f32 that do not count.
const DROPPED_BITS: u32 = 13;
/// Entries: all positive numbers and zero.
const ENTRIES: usize = 1 << (31 - DROPPED_BITS);

/// The table of one display setting.
pub struct DisplayTable {
    display: Option<Display>,
    entries: Vec<u8>,
}

impl Default for DisplayTable {
    fn default() -> Self {
        let mut table = Self {
            display: None,
            entries: Vec::new(),
        };
        table.set(Display {
            exposure: 0.0,
            tone_map: ToneMap::None,
        });
        table
    }
}

impl DisplayTable {
    /// Makes the table show as `display` says.
    pub fn set(&mut self, display: Display) {
        if self.display == Some(display) {
            return;
        }
        self.display = Some(display);
        self.entries = (0..ENTRIES)
            .map(|index| {
                // The middle of the numbers that share the entry.
                let bits = ((index as u32) << DROPPED_BITS) | (1 << (DROPPED_BITS - 1));
                let value = f32::from_bits(bits);
                let value = if index == 0 { 0.0 } else { value };
                (display.encode([value; 3])[0] * 255.0).round() as u8
            })
            .collect();
    }

    /// Displayed colour of linear light; negative numbers and NaN are black.
    pub fn encode(&self, linear: [f32; 3]) -> [u8; 3] {
        linear.map(|value| {
            let index = value.max(0.0).to_bits() >> DROPPED_BITS;
            self.entries.get(index as usize).copied().unwrap_or(0)
        })
    }
}
