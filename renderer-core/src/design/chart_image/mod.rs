//! The pixels of a chart as shared tiles of 128 × 128, so that copying a design or painting on it copies tiles, not
//! images.

mod tile;

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

pub use tile::{TILE, Tile};

/// Pixels below this alpha plant nothing.
pub const OPAQUE_FROM: u8 = 128;

/// An 8-bit sRGB image with straight alpha, row 0 at the top (the far edge of the sheet).
#[derive(Clone)]
pub struct ChartImage {
    width: usize,
    height: usize,
    /// Row by row. Shared as a whole too: a design that is compared every frame compares one pointer.
    tiles: Arc<Vec<Tile>>,
}

impl ChartImage {
    /// Largest width and height in pixels.
    pub const MAX_SIDE: usize = 8192;

    /// An image from rows of pixels, top row first. `None` unless `pixels` holds `width` × `height` of them,
    /// with sides of 1 to [`Self::MAX_SIDE`].
    pub fn new(width: usize, height: usize, pixels: &[[u8; 4]]) -> Option<Self> {
        if pixels.len() != width.checked_mul(height)? {
            return None;
        }
        Self::from_fn(width, height, |x, y| pixels[y * width + x])
    }

    /// An image of one colour. `None` unless the sides are 1 to [`Self::MAX_SIDE`].
    pub fn filled(width: usize, height: usize, colour: [u8; 4]) -> Option<Self> {
        is_allowed(width, height).then(|| Self {
            width,
            height,
            tiles: Arc::new(vec![
                Tile::filled(colour);
                width.div_ceil(TILE) * height.div_ceil(TILE)
            ]),
        })
    }

    /// An image whose pixel at column x, row y is `pixel(x, y)`. `None` unless the sides are 1 to [`Self::MAX_SIDE`].
    pub fn from_fn(
        width: usize,
        height: usize,
        pixel: impl Fn(usize, usize) -> [u8; 4] + Sync,
    ) -> Option<Self> {
        Self::from_fn_with(width, height, || (), |(), x, y| pixel(x, y))
    }

    /// As [`Self::from_fn`], with something that each piece of the work keeps from pixel to pixel.
    pub fn from_fn_with<S>(
        width: usize,
        height: usize,
        keep: impl Fn() -> S + Sync + Send,
        pixel: impl Fn(&mut S, usize, usize) -> [u8; 4] + Sync,
    ) -> Option<Self> {
        let across = width.div_ceil(TILE);
        let tile = |(pixels, kept): &mut (Vec<[u8; 4]>, S), k: usize| {
            let (left, top) = (k % across * TILE, k / across * TILE);
            pixels.clear();
            pixels.extend((0..TILE * TILE).map(|k| {
                // Beyond the image its nearest pixel, which adds no colour to the tile.
                let (x, y) = (left + k % TILE, top + k / TILE);
                pixel(kept, x.min(width - 1), y.min(height - 1))
            }));
            Tile::new(pixels)
        };
        is_allowed(width, height).then(|| Self {
            width,
            height,
            tiles: Arc::new(
                (0..across * height.div_ceil(TILE))
                    .into_par_iter()
                    .map_init(|| (Vec::new(), keep()), tile)
                    .collect(),
            ),
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
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 4] {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.tile(x / TILE, y / TILE).pixel(x % TILE, y % TILE)
    }

    /// Columns and rows of tiles.
    pub fn tiles(&self) -> [usize; 2] {
        [self.width.div_ceil(TILE), self.height.div_ceil(TILE)]
    }

    /// The tile that holds the pixels from column `tx` × [`TILE`], row `ty` × [`TILE`] on.
    #[inline]
    pub fn tile(&self, tx: usize, ty: usize) -> &Tile {
        &self.tiles[ty * self.width.div_ceil(TILE) + tx]
    }

    /// Width and height of the part of a tile that lies in the image.
    pub fn tile_size(&self, tx: usize, ty: usize) -> [usize; 2] {
        [
            TILE.min(self.width - tx * TILE),
            TILE.min(self.height - ty * TILE),
        ]
    }

    /// Gives the part of row `y` in columns `xs` a colour; what lies outside the image is left out. Tiles that other
    /// images share are copied first.
    pub fn fill_row(&mut self, y: usize, xs: Range<usize>, colour: [u8; 4]) {
        let (from, to) = (xs.start, xs.end.min(self.width));
        if y >= self.height || from >= to {
            return;
        }
        let across = self.width.div_ceil(TILE);
        let tiles = Arc::make_mut(&mut self.tiles);
        for tx in from / TILE..=(to - 1) / TILE {
            let left = tx * TILE;
            tiles[y / TILE * across + tx].fill(
                y % TILE,
                from.max(left) - left,
                to.min(left + TILE) - left,
                colour,
            );
        }
    }

    /// Gives a rectangle a colour; what lies outside the image is left out.
    pub fn fill_rectangle(&mut self, xs: Range<usize>, ys: Range<usize>, colour: [u8; 4]) {
        let (xs, ys) = (
            xs.start..xs.end.min(self.width),
            ys.start..ys.end.min(self.height),
        );
        if xs.is_empty() || ys.is_empty() {
            return;
        }
        let [across, _] = self.tiles();
        for ty in ys.start / TILE..=(ys.end - 1) / TILE {
            for tx in xs.start / TILE..=(xs.end - 1) / TILE {
                let [width, height] = self.tile_size(tx, ty);
                let clip = |range: &Range<usize>, start: usize, size: usize| {
                    range.start.max(start)..range.end.min(start + size)
                };
                let (in_x, in_y) = (clip(&xs, tx * TILE, width), clip(&ys, ty * TILE, height));
                if in_x.len() == width && in_y.len() == height {
                    Arc::make_mut(&mut self.tiles)[ty * across + tx] = Tile::filled(colour);
                } else {
                    for y in in_y {
                        self.fill_row(y, in_x.clone(), colour);
                    }
                }
            }
        }
    }

    /// The image with every colour replaced. Of tiles with few colours only their lists of colours are new.
    pub fn map_colours(&self, map: impl Fn([u8; 4]) -> [u8; 4] + Sync) -> Self {
        self.map_colours_with(|| (), |(), colour| map(colour))
    }

    /// As [`Self::map_colours`], with something that each piece of the work keeps from colour to colour.
    pub fn map_colours_with<S>(
        &self,
        keep: impl Fn() -> S + Sync + Send,
        map: impl Fn(&mut S, [u8; 4]) -> [u8; 4] + Sync,
    ) -> Self {
        let mapped = |kept: &mut S, tile: &Tile| tile.mapped(|colour| map(kept, colour));
        Self {
            width: self.width,
            height: self.height,
            tiles: Arc::new(self.tiles.par_iter().map_init(keep, mapped).collect()),
        }
    }

    /// Whether both are one image in memory: then they are equal, else they may be.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tiles, &other.tiles)
            && (self.width, self.height) == (other.width, other.height)
    }

    /// Uses the tiles of `other` wherever they are equal to this image's, so that they are in memory once and comparing
    /// the two again costs nothing.
    pub fn share_with(&mut self, other: &Self) {
        if Arc::ptr_eq(&self.tiles, &other.tiles)
            || (self.width, self.height) != (other.width, other.height)
        {
            return;
        }
        let [across, _] = self.tiles();
        let mut all = true;
        for k in 0..self.tiles.len() {
            let [width, height] = self.tile_size(k % across, k / across);
            let (own, theirs) = (&self.tiles[k], &other.tiles[k]);
            if own.is(theirs) {
                continue;
            }
            if own.equals(theirs, width, height) {
                Arc::make_mut(&mut self.tiles)[k] = theirs.clone();
            } else {
                all = false;
            }
        }
        if all {
            self.tiles = Arc::clone(&other.tiles);
        }
    }

    /// Bytes of pixels that this image holds in memory and `other` does not.
    pub fn bytes_beside(&self, other: Option<&Self>) -> usize {
        let same_size = |other: &&Self| (self.width, self.height) == (other.width, other.height);
        let other = other.filter(same_size);
        if other.is_some_and(|other| Arc::ptr_eq(&self.tiles, &other.tiles)) {
            return 0;
        }
        let bytes =
            |(k, tile): (usize, &Tile)| tile.bytes_beside(other.map(|other| &other.tiles[k]));
        self.tiles.iter().enumerate().map(bytes).sum()
    }
}

fn is_allowed(width: usize, height: usize) -> bool {
    let sides = 1..=ChartImage::MAX_SIDE;
    sides.contains(&width) && sides.contains(&height)
}

impl PartialEq for ChartImage {
    fn eq(&self, other: &Self) -> bool {
        if (self.width, self.height) != (other.width, other.height) {
            return false;
        }
        let [across, down] = self.tiles();
        Arc::ptr_eq(&self.tiles, &other.tiles)
            || (0..across * down).all(|k| {
                let [width, height] = self.tile_size(k % across, k / across);
                self.tiles[k].equals(&other.tiles[k], width, height)
            })
    }
}

impl std::fmt::Debug for ChartImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ChartImage({} x {})", self.width, self.height)
    }
}
