//! The pixels of a chart as shared tiles of 128 × 128, so that copying a design or painting on it copies tiles, not images.

use std::sync::Arc;

/// Side of a tile in pixels.
pub const TILE: usize = 128;

/// RGBA pixels of one tile, row by row; the parts of edge tiles beyond the image are transparent.
type Tile = Arc<[[u8; 4]]>;

/// An 8-bit sRGB image with straight alpha, row 0 at the top (the far edge of the sheet).
#[derive(Clone)]
pub struct ChartImage {
    width: usize,
    height: usize,
    tiles: Vec<Tile>,
}

impl ChartImage {
    /// Largest width and height in pixels.
    pub const MAX_SIDE: usize = 8192;

    /// An image from rows of pixels, top row first. `None` unless `pixels` holds `width` × `height` of them,
    /// with sides of 1 to [`Self::MAX_SIDE`].
    pub fn new(width: usize, height: usize, pixels: &[[u8; 4]]) -> Option<Self> {
        let sides = 1..=Self::MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) || pixels.len() != width * height {
            return None;
        }
        let tile = |tx: usize, ty: usize| -> Tile {
            (0..TILE * TILE)
                .map(|k| {
                    let (x, y) = (tx * TILE + k % TILE, ty * TILE + k / TILE);
                    if x < width && y < height {
                        pixels[y * width + x]
                    } else {
                        [0; 4]
                    }
                })
                .collect()
        };
        let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let tiles = (0..across * down)
            .map(|k| tile(k % across, k / across))
            .collect();
        Some(Self {
            width,
            height,
            tiles,
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

    /// The pixel at column `x`, row `y` from the top; positions outside read the nearest edge.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 4] {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.tiles[(y / TILE) * self.width.div_ceil(TILE) + x / TILE][(y % TILE) * TILE + x % TILE]
    }
}

impl PartialEq for ChartImage {
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&Tile, &Tile)| Arc::ptr_eq(a, b) || a == b;
        (self.width, self.height) == (other.width, other.height)
            && self.tiles.iter().zip(&other.tiles).all(same)
    }
}

impl std::fmt::Debug for ChartImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ChartImage({} x {})", self.width, self.height)
    }
}
