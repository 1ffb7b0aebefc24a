//! ꟻLIP, what an eye makes of the difference of two pictures.

use renderer_core::design::ToneMap;
use renderer_core::image::metrics::{SizesDiffer, check_sizes};
use renderer_core::image::{Display, Picture};

/// Pixels to a degree of the eye's view, for [`flip`]: a screen of 0.7 m width and 3840 pixels, seen from 0.7 m.
const PIXELS_PER_DEGREE: f32 = 67.0;

/// ꟻLIP: how different the two look to someone who flips between them, 0 to 1, mean over all pixels (Andersson et al.
/// 2020). Both as displayed at `exposure` (stops) with a hard clip, 8 bits a channel; b is the truth.
///
/// # Errors
/// When the sizes differ.
pub fn flip(a: &Picture, b: &Picture, exposure: f64) -> Result<f64, SizesDiffer> {
    check_sizes(a, b)?;
    let display = Display {
        exposure,
        tone_map: ToneMap::None,
    };
    let shown = |picture: &Picture| {
        let colours = picture.pixels.iter().flat_map(|&[r, g, b, _]| {
            let shown = display.encode([r, g, b]);
            shown.map(|channel| (channel * 255.0).round() as u8)
        });
        let bytes: Vec<u8> = colours.collect();
        nv_flip::FlipImageRgb8::with_data(picture.size[0], picture.size[1], &bytes)
    };
    if b.pixels.is_empty() {
        return Ok(0.0);
    }
    let map = nv_flip::flip(shown(b), shown(a), PIXELS_PER_DEGREE).to_vec();
    Ok(map.iter().map(|&error| f64::from(error)).sum::<f64>() / map.len() as f64)
}
