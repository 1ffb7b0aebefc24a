//! What a yarn of the chart is called, in the editor and in the panel.

use renderer_core::design::Colour;

/// What a yarn is called: by its place in the list and its colour.
pub fn yarn_name(index: usize, colour: [u8; 4]) -> String {
    let [r, g, b, _] = colour;
    format!("yarn {}, {}", index + 1, String::from(Colour([r, g, b])))
}
