//! How a picture is divided into bands.

use renderer_core::image::EXR_BLOCK_ROWS;

/// Most bytes that the sums and the picture of a band take unless given otherwise.
pub const BAND_BYTES: u64 = 512 << 20;

/// Bytes of a pixel while it is made: its sums (64 on the processor), what is shown of it (16), and some room for what
/// is encoded of it.
const PIXEL_BYTES: u64 = 96;
/// Bytes of a pixel while it is made with depth, normal and albedo.
const PIXEL_BYTES_WITH_AOV: u64 = 208;
/// Heights of bands are multiples of this: of the renderers' tiles, so that rays have the same bits as in one band, and
/// of the blocks of EXR files.
const STEP: u32 = EXR_BLOCK_ROWS;

/// The rows of a picture, from top to bottom.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bands {
    crop: [u32; 4],
    pixel_bytes: u64,
    height: u32,
    done: u32,
    bands_done: u32,
}

impl Bands {
    /// Bands of the part `crop` of a picture, of at most `bytes` each if that is at all possible.
    pub fn new(crop: [u32; 4], aov: bool, bytes: u64) -> Self {
        let pixel_bytes = if aov {
            PIXEL_BYTES_WITH_AOV
        } else {
            PIXEL_BYTES
        };
        let rows = bytes / (pixel_bytes * u64::from(crop[2].max(1)));
        let height = if rows >= u64::from(crop[3]) {
            crop[3]
        } else {
            (rows as u32 / STEP * STEP).max(STEP)
        };
        Self {
            crop,
            pixel_bytes,
            height,
            done: 0,
            bands_done: 0,
        }
    }

    /// The band to make next.
    pub fn next(&self) -> [u32; 4] {
        let [x, y, width, height] = self.crop;
        let rows = self.height.min(height - self.done.min(height));
        [x, y + self.done, width, rows]
    }

    /// Notes that a band is made.
    pub fn finish(&mut self, band: [u32; 4]) {
        self.done += band[3];
        self.bands_done += 1;
    }

    /// Makes the bands that are left half as high. False if they are as low as can be.
    pub fn make_lower(&mut self) -> bool {
        let lower = (self.next()[3] / 2).div_ceil(STEP) * STEP;
        let is_lower = lower < self.next()[3];
        if is_lower {
            self.height = lower;
        }
        is_lower
    }

    /// How many bands there are, those that are done included.
    pub fn count(&self) -> u32 {
        self.bands_done + (self.crop[3] - self.done).div_ceil(self.height)
    }

    /// Bytes that a band takes.
    pub fn bytes(&self, band: [u32; 4]) -> u64 {
        self.pixel_bytes * u64::from(band[2]) * u64::from(band[3])
    }

    /// Which share of the rows is done before a band, and after it.
    pub fn shares(&self, band: [u32; 4]) -> [f64; 2] {
        [self.done, self.done + band[3]].map(|rows| f64::from(rows) / f64::from(self.crop[3]))
    }
}
