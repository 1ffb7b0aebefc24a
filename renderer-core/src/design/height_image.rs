//! The pixels of a height picture: grey values of 16 bits, shared, so that copying a design copies no pixels.

use std::sync::Arc;

/// A picture of heights, row 0 at the top (the far edge of the sheet).
#[derive(Clone)]
pub struct HeightImage {
    width: usize,
    height: usize,
    /// Row by row.
    greys: Arc<[u16]>,
}

impl HeightImage {
    /// Largest width and height in pixels.
    pub const MAX_SIDE: usize = 8192;

    /// A picture of rows of grey values from black, 0, to white, 65535; top row first. `None` unless there are `width`
    /// × `height` of them, with sides of 1 to [`Self::MAX_SIDE`].
    pub fn new(width: usize, height: usize, greys: Vec<u16>) -> Option<Self> {
        let sides = 1..=Self::MAX_SIDE;
        let is_whole = width.checked_mul(height) == Some(greys.len());
        (sides.contains(&width) && sides.contains(&height) && is_whole).then(|| Self {
            width,
            height,
            greys: greys.into(),
        })
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All grey values, row by row from the top.
    pub fn greys(&self) -> &[u16] {
        &self.greys
    }

    /// The grey values of row `y` from the top.
    pub fn row(&self, y: usize) -> &[u16] {
        &self.greys[y * self.width..][..self.width]
    }
}

impl PartialEq for HeightImage {
    fn eq(&self, other: &Self) -> bool {
        (self.width, self.height) == (other.width, other.height)
            && (Arc::ptr_eq(&self.greys, &other.greys) || self.greys == other.greys)
    }
}

impl std::fmt::Debug for HeightImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "HeightImage({} x {})", self.width, self.height)
    }
}
