//! Which yarns a chart asks for, and how many of its pixels each.

use std::collections::HashMap;

use crate::design::{ChartImage, OPAQUE_FROM, TILE, Tile};

/// The "yarn" of pixels that plant nothing.
pub const BARE: [u8; 4] = [0; 4];

/// What a pixel asks for: a yarn of its colour, or none where it is transparent.
pub fn yarn_of([r, g, b, alpha]: [u8; 4]) -> [u8; 4] {
    if alpha < OPAQUE_FROM {
        BARE
    } else {
        [r, g, b, 255]
    }
}

/// A yarn and its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct YarnCount {
    /// Colour, or [`BARE`].
    pub colour: [u8; 4],
    /// How many pixels ask for it.
    pub pixels: u64,
}

/// Counts the yarns of a chart, and again those of its tiles that changed.
#[derive(Default)]
pub struct YarnCounts {
    of: Option<ChartImage>,
    tiles: Vec<Counted>,
    yarns: Option<Vec<YarnCount>>,
}

struct Counted {
    tile: Tile,
    size: [usize; 2],
    /// `None` where there are more than [`YarnCounts::MOST`].
    yarns: Option<Vec<([u8; 4], u32)>>,
}

impl YarnCounts {
    /// Most yarns that are counted: a chart of more is a photo, not a chart of yarns.
    pub const MOST: usize = 64;

    /// The yarns of a chart, the commonest first; `None` where there are more than [`Self::MOST`].
    pub fn of(&mut self, image: &ChartImage) -> Option<&[YarnCount]> {
        if self.of.as_ref().is_none_or(|of| !of.is(image)) {
            self.recount(image);
            self.of = Some(image.clone());
        }
        self.yarns.as_deref()
    }

    fn recount(&mut self, image: &ChartImage) {
        let [across, down] = image.tiles();
        self.tiles.truncate(across * down);
        let mut totals: Option<HashMap<[u8; 4], u64>> = Some(HashMap::new());
        for k in 0..across * down {
            let (tx, ty) = (k % across, k / across);
            let (tile, size) = (image.tile(tx, ty), image.tile_size(tx, ty));
            let known = self.tiles.get(k);
            if known.is_none_or(|known| known.size != size || !known.tile.is(tile)) {
                let counted = Counted {
                    tile: tile.clone(),
                    size,
                    yarns: count(tile, size),
                };
                match self.tiles.get_mut(k) {
                    Some(known) => *known = counted,
                    None => self.tiles.push(counted),
                }
            }
            match (&mut totals, &self.tiles[k].yarns) {
                (Some(sums), Some(yarns)) => {
                    for &(yarn, pixels) in yarns {
                        *sums.entry(yarn).or_default() += u64::from(pixels);
                    }
                    if sums.len() > Self::MOST {
                        totals = None;
                    }
                }
                _ => totals = None,
            }
            if totals.is_none() {
                self.tiles.truncate(k + 1);
                break;
            }
        }
        self.yarns = totals.map(|totals| {
            let mut yarns: Vec<YarnCount> = totals
                .into_iter()
                .map(|(colour, pixels)| YarnCount { colour, pixels })
                .collect();
            // By colour where counts are equal, so that the order is always the same.
            yarns.sort_by_key(|yarn| (std::cmp::Reverse(yarn.pixels), yarn.colour));
            yarns
        });
    }
}

/// The yarns of a tile; `None` if there are too many.
fn count(tile: &Tile, [width, height]: [usize; 2]) -> Option<Vec<([u8; 4], u32)>> {
    let mut yarns: HashMap<[u8; 4], u32> = HashMap::new();
    if let Some((colours, numbers)) = tile.numbered() {
        let mut counts = [0_u32; 256];
        for row in numbers.chunks_exact(TILE).take(height) {
            for &number in &row[..width] {
                counts[usize::from(number)] += 1;
            }
        }
        for (&colour, pixels) in colours.iter().zip(counts) {
            if pixels > 0 {
                *yarns.entry(yarn_of(colour)).or_default() += pixels;
            }
        }
        return (yarns.len() <= YarnCounts::MOST).then(|| yarns.into_iter().collect());
    }
    for y in 0..height {
        for x in 0..width {
            *yarns.entry(yarn_of(tile.pixel(x, y))).or_default() += 1;
        }
        if yarns.len() > YarnCounts::MOST {
            return None;
        }
    }
    Some(yarns.into_iter().collect())
}
