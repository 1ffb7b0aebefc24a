//! Parsers of single arguments. Their messages say what is allowed; clap adds the argument and the value.

use renderer_core::design::{Method, Shaped, read_number};
use renderer_core::render::MAX_SIDE;

/// An argument that cannot be used, found after parsing.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct BadArgument(pub String);

/// Size of a picture that nothing else is said of, as [`size`] reads it.
pub const DEFAULT_SIZE: &str = "800x600";

/// `WxH`, each side 1 to [`MAX_SIDE`].
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let allowed = || format!("allowed is WIDTHxHEIGHT, each 1 to {MAX_SIDE} pixels");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(allowed)?;
    let side = |text: &str| {
        let side = text.parse().ok();
        side.filter(|side| (1..=MAX_SIDE).contains(side))
            .ok_or_else(allowed)
    };
    Ok([side(width)?, side(height)?])
}

/// `X,Y,W,H`; whether it lies inside the picture is known only with its size.
pub fn crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.parse().ok()).collect();
    numbers
        .and_then(|numbers| <[u32; 4]>::try_from(numbers).ok())
        .ok_or_else(|| "allowed is X,Y,WIDTH,HEIGHT in pixels from the top left".into())
}

/// `PATH=VALUE`.
pub fn field_and_value(text: &str) -> Result<(String, String), String> {
    text.split_once('=')
        .map(|(path, value)| (path.trim().to_owned(), value.trim().to_owned()))
        .ok_or_else(|| "allowed is PATH=VALUE, as in pile.tilt=30".into())
}

/// A method by its name in presets.
pub fn method(text: &str) -> Result<Method, String> {
    Method::ALL
        .iter()
        .copied()
        .find(|method| method.name() == text)
        .ok_or_else(|| format!("allowed is {}", Method::shape().allowed()))
}

/// An error to stop at, as a share or in per cent.
pub fn error_target(text: &str) -> Result<f64, String> {
    within(text, "", 1.0, "a number above 0, up to 1")
}

/// A time limit in seconds; other units may be written.
pub fn seconds(text: &str) -> Result<f64, String> {
    const WEEK: f64 = 7.0 * 24.0 * 3600.0;
    let allowed = format!("a number of seconds above 0, up to {WEEK} (a week)");
    within(text, "s", WEEK, &allowed)
}

/// A number above 0, up to `most`, as people type it.
fn within(text: &str, unit: &str, most: f64, allowed: &str) -> Result<f64, String> {
    let number =
        read_number(text, unit, false).map_err(|why| format!("{why} Allowed is {allowed}"))?;
    if number > 0.0 && number <= most {
        Ok(number)
    } else {
        Err(format!("allowed is {allowed}"))
    }
}

/// Pixels an inch.
pub fn dots_per_inch(text: &str) -> Result<f64, String> {
    let dots = text.parse().ok();
    dots.filter(|dots| (1.0..=100_000.0).contains(dots))
        .ok_or_else(|| "allowed is a number of pixels an inch, 1 to 100000".into())
}
