//! Which yarns a chart asks for, and how many of its pixels each.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::sync::Arc;

use super::LoopsPerPixel;
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

/// A yarn, its pixels and its loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct YarnCount {
    /// Colour, or [`BARE`].
    pub colour: [u8; 4],
    /// How many pixels ask for it.
    pub pixels: u64,
    /// How many loops, or places of loops where it is [`BARE`], lie on these pixels.
    pub loops: u64,
}

/// Counts the yarns of a chart, and again those of its tiles that changed.
#[derive(Default)]
pub struct YarnCounts {
    of: Option<(ChartImage, Arc<LoopsPerPixel>)>,
    tiles: Vec<Counted>,
    yarns: Option<Vec<YarnCount>>,
}

struct Counted {
    tile: Tile,
    size: [usize; 2],
    /// `None` where there are more than [`YarnCounts::MOST`].
    yarns: Option<HashMap<[u8; 4], Count>>,
}

/// Pixels, and loops on them.
#[derive(Clone, Copy, Default)]
struct Count {
    pixels: u64,
    loops: u64,
}

impl YarnCounts {
    /// Most yarns that are counted: a chart of more is a photo, not a chart of yarns.
    pub const MOST: usize = 64;

    /// The yarns of a chart, those with most loops first; `None` where there are more than [`Self::MOST`].
    pub fn of(&mut self, image: &ChartImage, loops: &Arc<LoopsPerPixel>) -> Option<&[YarnCount]> {
        let same_loops = |of: &Arc<LoopsPerPixel>| Arc::ptr_eq(of, loops) || of == loops;
        let known = self.of.as_ref();
        if !known.is_some_and(|(_, of)| same_loops(of)) {
            self.tiles.clear();
        }
        if !known.is_some_and(|(of, of_loops)| of.is(image) && same_loops(of_loops)) {
            self.recount(image, loops);
            self.of = Some((image.clone(), loops.clone()));
        }
        self.yarns.as_deref()
    }

    fn recount(&mut self, image: &ChartImage, loops: &LoopsPerPixel) {
        let [across, down] = image.tiles();
        self.tiles.truncate(across * down);
        let mut totals: Option<HashMap<[u8; 4], Count>> = Some(HashMap::new());
        for k in 0..across * down {
            let (tx, ty) = (k % across, k / across);
            let (tile, size) = (image.tile(tx, ty), image.tile_size(tx, ty));
            let known = self.tiles.get(k);
            if known.is_none_or(|known| known.size != size || !known.tile.is(tile)) {
                let counted = Counted {
                    tile: tile.clone(),
                    size,
                    yarns: count(tile, size, |x, y| loops.at(tx * TILE + x, ty * TILE + y)),
                };
                match self.tiles.get_mut(k) {
                    Some(known) => *known = counted,
                    None => self.tiles.push(counted),
                }
            }
            match (&mut totals, &self.tiles[k].yarns) {
                (Some(sums), Some(yarns)) => {
                    for (&yarn, count) in yarns {
                        let sum = sums.entry(yarn).or_default();
                        sum.pixels += count.pixels;
                        sum.loops += count.loops;
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
                .map(|(colour, Count { pixels, loops })| YarnCount {
                    colour,
                    pixels,
                    loops,
                })
                .collect();
            // By colour where counts are equal, so that the order is always the same.
            yarns.sort_by_key(|yarn| (Reverse((yarn.loops, yarn.pixels)), yarn.colour));
            yarns
        });
    }
}

/// The yarns of a tile on whose pixel (x, y) so many loops lie; `None` if there are too many.
fn count(
    tile: &Tile,
    [width, height]: [usize; 2],
    loops: impl Fn(usize, usize) -> u64,
) -> Option<HashMap<[u8; 4], Count>> {
    let mut yarns: HashMap<[u8; 4], Count> = HashMap::new();
    if let Some((colours, numbers)) = tile.numbered() {
        let mut counts = [Count::default(); 256];
        for (y, row) in numbers.chunks_exact(TILE).take(height).enumerate() {
            for (x, &number) in row[..width].iter().enumerate() {
                let count = &mut counts[usize::from(number)];
                count.pixels += 1;
                count.loops += loops(x, y);
            }
        }
        for (&colour, count) in colours.iter().zip(counts) {
            if count.pixels > 0 {
                let sum = yarns.entry(yarn_of(colour)).or_default();
                sum.pixels += count.pixels;
                sum.loops += count.loops;
            }
        }
        return (yarns.len() <= YarnCounts::MOST).then_some(yarns);
    }
    for y in 0..height {
        for x in 0..width {
            let count = yarns.entry(yarn_of(tile.pixel(x, y))).or_default();
            count.pixels += 1;
            count.loops += loops(x, y);
        }
        if yarns.len() > YarnCounts::MOST {
            return None;
        }
    }
    Some(yarns)
}
