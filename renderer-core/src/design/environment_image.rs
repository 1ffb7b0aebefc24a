//! The pixels of a picture of the surroundings: linear light, equirectangular, twice as wide as high.
//!
//! Files have any size up to [`EnvironmentImage::MAX_WIDTH`]; what is kept is at most [`EnvironmentImage::KEPT_WIDTH`]
//! wide, reduced by area averaging as the pixels come in, so that a large file never lies in memory as a whole here.

use std::sync::Arc;

use crate::sampling::PiecewiseConstant2D;

/// A picture of the surroundings, row 0 at the zenith.
#[derive(Clone)]
pub struct EnvironmentImage {
    width: usize,
    height: usize,
    /// Linear red, green and blue, row by row.
    pixels: Arc<[[f32; 3]]>,
    light: PiecewiseConstant2D,
    level_radiance: [f64; 3],
    file_width: usize,
    mended: usize,
}

/// Why pixels make no environment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EnvironmentFault {
    /// Not twice as wide as high.
    #[error(
        "has {width} x {height} pixels; an equirectangular picture is twice as wide as high, as {} x {height}",
        2 * .height
    )]
    Proportion {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Larger than allowed.
    #[error(
        "has {width} x {height} pixels, allowed are at most {} x {}",
        EnvironmentImage::MAX_WIDTH,
        EnvironmentImage::MAX_WIDTH / 2
    )]
    Size {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// A pixel that is not a number.
    #[error("the pixel in column {x}, row {y} is not a number (NaN)")]
    NotANumber {
        /// Column, from 0 at the left.
        x: usize,
        /// Row, from 0 at the top.
        y: usize,
    },
}

impl EnvironmentImage {
    /// Most pixels in a row of a file.
    pub const MAX_WIDTH: usize = 8192;
    /// Most pixels in a row that are kept: a third of a degree each, far finer than light that a pile scatters can
    /// show.
    pub const KEPT_WIDTH: usize = 1024;
    /// The brightest that a pixel may be; brighter ones, infinite ones too, are made this bright. A noon sun is about
    /// 10⁵ times as bright as its sky, and sums of this many thousands of it are still finite in f32.
    pub const BRIGHTEST: f32 = 1e6;

    /// Whether a picture may have this size.
    ///
    /// # Errors
    /// When it is empty, too large or not twice as wide as high.
    pub fn check_size(width: usize, height: usize) -> Result<(), EnvironmentFault> {
        if width > Self::MAX_WIDTH || height > Self::MAX_WIDTH / 2 {
            Err(EnvironmentFault::Size { width, height })
        } else if height == 0 || width != 2 * height {
            Err(EnvironmentFault::Proportion { width, height })
        } else {
            Ok(())
        }
    }

    /// Width in pixels, as kept.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels, as kept.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels as kept, row by row from the zenith.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The pixel at column `x`, row `y` from the top.
    pub fn pixel(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixels[y * self.width + x]
    }

    /// Where its light comes from.
    pub fn light(&self) -> &PiecewiseConstant2D {
        &self.light
    }

    /// The radiance of light from everywhere that lights a level plane from above as this picture does, linear RGB.
    pub fn level_radiance(&self) -> [f64; 3] {
        self.level_radiance
    }

    /// This picture as one that renderers look at by the phase alone however uneven its light: what looking by its
    /// light is held against.
    pub fn drawn_by_phase(&self) -> Self {
        Self {
            light: self.light.taken_as_even(),
            ..self.clone()
        }
    }

    /// Width and height of the file in pixels.
    pub fn file_size(&self) -> [usize; 2] {
        [self.file_width, self.file_width / 2]
    }

    /// How many pixels of the file were negative or brighter than [`Self::BRIGHTEST`] and were moved into that range.
    pub fn mended(&self) -> usize {
        self.mended
    }
}

impl PartialEq for EnvironmentImage {
    fn eq(&self, other: &Self) -> bool {
        (self.file_width, self.mended) == (other.file_width, other.mended)
            && self.light.is_uneven() == other.light.is_uneven()
            && (Arc::ptr_eq(&self.pixels, &other.pixels) || self.pixels == other.pixels)
    }
}

impl std::fmt::Debug for EnvironmentImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EnvironmentImage({} x {})", self.width, self.height)
    }
}

/// Takes the pixels of a file in any order and averages them down to the size that is kept.
#[derive(Debug)]
pub struct EnvironmentReader {
    width: usize,
    kept_width: usize,
    /// Sum of colour × covered area of each kept pixel.
    sums: Vec<[f64; 3]>,
    mended: usize,
    not_a_number: Option<[usize; 2]>,
}

impl EnvironmentReader {
    /// For a file of `width` × `height` pixels.
    ///
    /// # Errors
    /// When that is no size for an environment.
    pub fn new(width: usize, height: usize) -> Result<Self, EnvironmentFault> {
        EnvironmentImage::check_size(width, height)?;
        let kept_width = width.min(EnvironmentImage::KEPT_WIDTH);
        Ok(Self {
            width,
            kept_width,
            sums: vec![[0.0; 3]; kept_width * kept_width / 2],
            mended: 0,
            not_a_number: None,
        })
    }

    /// Adds the pixel at column `x`, row `y` from the top.
    pub fn add(&mut self, x: usize, y: usize, colour: [f32; 3]) {
        if colour.iter().any(|value| value.is_nan()) {
            self.not_a_number.get_or_insert([x, y]);
            return;
        }
        let in_range = colour.map(|value| value.clamp(0.0, EnvironmentImage::BRIGHTEST));
        self.mended += usize::from(in_range != colour);
        let (columns, rows) = (self.covered(x), self.covered(y));
        for (row, height) in rows.into_iter().filter(|(_, height)| *height > 0.0) {
            for (column, width) in columns.into_iter().filter(|(_, width)| *width > 0.0) {
                let sum = &mut self.sums[row * self.kept_width + column];
                for (sum, value) in sum.iter_mut().zip(in_range) {
                    *sum += f64::from(value) * width * height;
                }
            }
        }
    }

    /// The one or two kept pixels that pixel `index` of a row or column covers, each with the length of the part.
    fn covered(&self, index: usize) -> [(usize, f64); 2] {
        // In units of 1/(file's width × kept width) of the row, so that all is whole numbers.
        let (start, end) = (index * self.kept_width, (index + 1) * self.kept_width);
        let first = start / self.width;
        let border = ((first + 1) * self.width).min(end);
        let share = |length: usize| length as f64 / self.width as f64;
        let second = if end > border { first + 1 } else { first };
        [
            (first, share(border - start)),
            (second, share(end - border)),
        ]
    }

    /// The picture, once every pixel was added.
    ///
    /// # Errors
    /// When a pixel was not a number.
    pub fn finish(self) -> Result<EnvironmentImage, EnvironmentFault> {
        if let Some([x, y]) = self.not_a_number {
            return Err(EnvironmentFault::NotANumber { x, y });
        }
        let (width, height) = (self.kept_width, self.kept_width / 2);
        let pixels: Arc<[_]> = self.sums.iter().map(|sum| sum.map(|c| c as f32)).collect();
        Ok(EnvironmentImage {
            width,
            height,
            light: PiecewiseConstant2D::new(width, height, &pixels),
            level_radiance: level_radiance(width, height, &pixels),
            pixels,
            file_width: self.width,
            mended: self.mended,
        })
    }
}

/// Mean of the upper half's pixels, each by the cosine of its height times its solid angle: in a row between the angles a
/// and b from the zenith, sin²b − sin²a of the whole.
fn level_radiance(width: usize, height: usize, pixels: &[[f32; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let border = |row: usize| {
        let angle = std::f64::consts::PI * row as f64 / height as f64;
        angle.min(std::f64::consts::FRAC_PI_2).sin().powi(2)
    };
    for (row, pixels) in pixels.chunks(width).take(height.div_ceil(2)).enumerate() {
        let weight = (border(row + 1) - border(row)) / width as f64;
        for pixel in pixels {
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += f64::from(*value) * weight;
            }
        }
    }
    sum
}
