//! How far two pictures are apart, and what one picture is like (MODEL.md §11). Linear RGB; alpha does not count.

use super::Picture;

/// Why two pictures cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "pictures of {}x{} and {}x{} pixels cannot be compared",
    .a[0], .a[1], .b[0], .b[1]
)]
pub struct SizesDiffer {
    /// Size of the first.
    pub a: [u32; 2],
    /// Size of the second.
    pub b: [u32; 2],
}

/// relRMSE = sqrt(mean((a−b)²)) / mean(b) over all channels of all pixels; b is the truth. 0 for two black pictures.
///
/// # Errors
/// When the sizes differ.
pub fn rel_rmse(a: &Picture, b: &Picture) -> Result<f64, SizesDiffer> {
    let (mut squares, mut truth, mut count) = (0.0, 0.0, 0.0);
    for (a, b) in pairs(a, b)? {
        squares += (a - b) * (a - b);
        truth += b;
        count += 1.0;
    }
    Ok(if squares == 0.0 {
        0.0
    } else {
        (squares / count).sqrt() / (truth / count)
    })
}

/// Mean of all channels of all pixels, what relRMSE is relative to.
pub fn mean(picture: &Picture) -> f64 {
    let channels = picture.pixels.iter().flat_map(|pixel| &pixel[..3]);
    let sum: f64 = channels.map(|&channel| f64::from(channel)).sum();
    sum / (3 * picture.pixels.len()).max(1) as f64
}

/// The largest absolute difference of any channel; NaN if any difference is.
///
/// # Errors
/// When the sizes differ.
pub fn max_abs_difference(a: &Picture, b: &Picture) -> Result<f64, SizesDiffer> {
    Ok(pairs(a, b)?.fold(0.0, |largest: f64, (a, b)| {
        let difference = (a - b).abs();
        // f64::max would drop a NaN.
        if difference > largest || difference.is_nan() {
            difference
        } else {
            largest
        }
    }))
}

/// How many pixels have a channel, alpha included, that is infinite or NaN.
pub fn nonfinite_pixels(picture: &Picture) -> u64 {
    let nonfinite = |pixel: &&[f32; 4]| pixel.iter().any(|channel| !channel.is_finite());
    picture.pixels.iter().filter(nonfinite).count() as u64
}

/// Mean luminance (Rec. 709 weights on linear light); 0 for a picture without pixels.
pub fn mean_luminance(picture: &Picture) -> f64 {
    let luminance = |&[r, g, b, _]: &[f32; 4]| {
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    };
    let sum: f64 = picture.pixels.iter().map(luminance).sum();
    sum / picture.pixels.len().max(1) as f64
}

/// Red, green and blue of both pictures, pixel by pixel.
fn pairs<'p>(
    a: &'p Picture,
    b: &'p Picture,
) -> Result<impl Iterator<Item = (f64, f64)> + 'p, SizesDiffer> {
    check_sizes(a, b)?;
    let channels = a.pixels.iter().zip(&b.pixels);
    Ok(channels.flat_map(|(a, b)| (0..3).map(move |c| (f64::from(a[c]), f64::from(b[c])))))
}

/// Whether two pictures have the same size.
///
/// # Errors
/// When they do not.
pub fn check_sizes(a: &Picture, b: &Picture) -> Result<(), SizesDiffer> {
    if a.size == b.size && a.pixels.len() == b.pixels.len() {
        Ok(())
    } else {
        Err(SizesDiffer {
            a: a.size,
            b: b.size,
        })
    }
}
