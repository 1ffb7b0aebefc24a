//! A chart on the screen: only what is seen becomes textures, at about the resolution it is seen with.
//!
//! On level n a block of 128 × 128 texels shows 2ⁿ × 2ⁿ tiles of the chart. A block is made when it is first seen, and
//! where one of its tiles is another than it was, that part is drawn anew. Each frame works for a few milliseconds at
//! most; until all is there, what was shown before stays.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use egui::{
    Color32, ColorImage, Painter, Pos2, Rect, TextureFilter, TextureHandle, TextureOptions, Vec2,
    pos2,
};
use renderer_core::design::{ChartImage, OPAQUE_FROM, TILE, Tile};

/// The coarsest level: one block shows a chart of the largest size.
const COARSEST: u32 = 6;
/// How long a frame may work on textures.
const BUDGET: Duration = Duration::from_millis(6);
/// Blocks that are kept; each takes 64 kB.
const MOST_BLOCKS: usize = 600;

const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::NEAREST
};

/// Level, column and row of a block.
type Key = (u32, usize, usize);

/// Textures of what was last seen of a chart.
#[derive(Default)]
pub struct Pyramid {
    blocks: HashMap<Key, Block>,
    frame: u64,
}

struct Block {
    texture: TextureHandle,
    /// What is drawn, row by row of the block's tiles; `None` beyond the chart.
    tiles: Vec<Option<(Tile, [usize; 2])>>,
    seen: u64,
}

/// How a chart lies on the screen.
#[derive(Debug, Clone, Copy)]
pub struct Placement {
    /// Where its upper left corner is.
    pub corner: Pos2,
    /// Width and height of a pixel of the chart, points.
    pub scale: Vec2,
}

impl Placement {
    /// Place on the screen of a place in the chart, pixels.
    pub fn at(&self, x: f32, y: f32) -> Pos2 {
        pos2(
            self.corner.x + x * self.scale.x,
            self.corner.y + y * self.scale.y,
        )
    }
}

impl Pyramid {
    /// Paints what of `image` lies in `painter`'s clip rectangle. Returns whether all of it is as it should be; if not,
    /// another frame is asked for.
    pub fn paint(&mut self, painter: &Painter, image: &ChartImage, placement: Placement) -> bool {
        let start = Instant::now();
        self.frame += 1;
        let level = level(placement.scale.max_elem() * painter.pixels_per_point());
        let tiles = image.tiles();
        let side = TILE << level;
        let clip = painter.clip_rect();
        let span = |low: f32, high: f32, axis: usize, size: usize| {
            let (corner, scale) = (placement.corner[axis], placement.scale[axis]);
            let block = |at: f32| ((at - corner) / scale / side as f32).floor();
            let last = size.div_ceil(side);
            (block(low).max(0.0) as usize).min(last)
                ..((block(high) + 1.0).max(0.0) as usize).min(last)
        };
        let columns = span(clip.left(), clip.right(), 0, image.width());
        let rows = span(clip.top(), clip.bottom(), 1, image.height());
        let mut is_complete = true;
        for by in rows {
            for bx in columns.clone() {
                let key = (level, bx, by);
                if start.elapsed() < BUDGET {
                    self.update(painter, image, tiles, key);
                } else {
                    is_complete &= self
                        .blocks
                        .get(&key)
                        .is_some_and(|block| block.shows(image, key));
                }
                if let Some(block) = self.blocks.get_mut(&key) {
                    block.seen = self.frame;
                    let (left, top) = ((bx * side) as f32, (by * side) as f32);
                    let right = ((bx + 1) * side).min(image.width()) as f32;
                    let bottom = ((by + 1) * side).min(image.height()) as f32;
                    let place =
                        Rect::from_min_max(placement.at(left, top), placement.at(right, bottom));
                    let part = pos2((right - left) / side as f32, (bottom - top) / side as f32);
                    let part = Rect::from_min_max(Pos2::ZERO, part);
                    painter.image(block.texture.id(), place, part, Color32::WHITE);
                }
            }
        }
        if self.blocks.len() > MOST_BLOCKS {
            let frame = self.frame;
            self.blocks.retain(|_, block| block.seen == frame);
        }
        if !is_complete {
            painter.ctx().request_repaint();
        }
        is_complete
    }

    /// Makes a block, or draws those of its tiles anew that are others than they were.
    fn update(&mut self, painter: &Painter, image: &ChartImage, tiles: [usize; 2], key: Key) {
        let (level, bx, by) = key;
        let texels = TILE >> level;
        let of_block = |k: usize| {
            [
                (bx << level) + k % (1 << level),
                (by << level) + k / (1 << level),
            ]
        };
        let present = |[tx, ty]: [usize; 2]| {
            (tx < tiles[0] && ty < tiles[1]).then(|| (image.tile(tx, ty), image.tile_size(tx, ty)))
        };
        let count = 1_usize << (2 * level);
        let block = self.blocks.entry(key).or_insert_with(|| Block {
            texture: painter.ctx().load_texture(
                "chart block",
                ColorImage::filled([TILE, TILE], Color32::TRANSPARENT),
                OPTIONS,
            ),
            tiles: vec![None; count],
            seen: 0,
        });
        let differs = |block: &Block, k: usize| {
            let now = present(of_block(k));
            match (&block.tiles[k], now) {
                (None, None) => false,
                (Some((tile, size)), Some((now, now_size))) => !tile.is(now) || *size != now_size,
                _ => true,
            }
        };
        let stale: Vec<usize> = (0..count).filter(|&k| differs(block, k)).collect();
        // One upload for many parts.
        if stale.len() > count / 8 + 1 {
            let mut whole = ColorImage::filled([TILE, TILE], Color32::TRANSPARENT);
            for k in 0..count {
                let Some((tile, size)) = present(of_block(k)) else {
                    continue;
                };
                let (left, top) = (k % (1 << level) * texels, k / (1 << level) * texels);
                for y in 0..texels {
                    for x in 0..texels {
                        whole[(left + x, top + y)] = texel(tile, size, level, x, y);
                    }
                }
            }
            block.texture.set(whole, OPTIONS);
        } else {
            for &k in &stale {
                let Some((tile, size)) = present(of_block(k)) else {
                    continue;
                };
                let pixels = (0..texels * texels)
                    .map(|t| texel(tile, size, level, t % texels, t / texels))
                    .collect();
                let part = ColorImage::new([texels, texels], pixels);
                let at = [k % (1 << level) * texels, k / (1 << level) * texels];
                block.texture.set_partial(at, part, OPTIONS);
            }
        }
        for k in stale {
            block.tiles[k] = present(of_block(k)).map(|(tile, size)| (tile.clone(), size));
        }
    }
}

impl Block {
    fn shows(&self, image: &ChartImage, (level, bx, by): Key) -> bool {
        let [across, down] = image.tiles();
        self.tiles.iter().enumerate().all(|(k, drawn)| {
            let (tx, ty) = (
                (bx << level) + k % (1 << level),
                (by << level) + k / (1 << level),
            );
            match drawn {
                Some((tile, _)) if tx < across && ty < down => tile.is(image.tile(tx, ty)),
                None => tx >= across || ty >= down,
                Some(_) => false,
            }
        })
    }
}

/// The level whose texels are about as large as the screen's pixels, `scale` of which show a pixel of the chart.
fn level(scale: f32) -> u32 {
    let halvings = (1.0 / scale.max(1e-6)).log2().floor();
    (halvings.max(0.0) as u32).min(COARSEST)
}

/// Colour of a texel: the mean of up to four of the pixels it stands for.
fn texel(tile: &Tile, [width, height]: [usize; 2], level: u32, x: usize, y: usize) -> Color32 {
    let pixel = |x: usize, y: usize| seen(tile.pixel(x.min(width - 1), y.min(height - 1)), x, y);
    if level == 0 {
        return pixel(x, y);
    }
    let (left, top, step) = (x << level, y << level, 1 << (level - 1));
    let mut sum = [2_u16; 3];
    for (dx, dy) in [(0, 0), (step, 0), (0, step), (step, step)] {
        let [r, g, b, _] = pixel(left + dx, top + dy).to_array();
        for (sum, value) in sum.iter_mut().zip([r, g, b]) {
            *sum += u16::from(value);
        }
    }
    let [r, g, b] = sum.map(|sum| (sum / 4) as u8);
    Color32::from_rgb(r, g, b)
}

/// What a pixel looks like: those without yarn as a fine chequer of grays.
fn seen([r, g, b, alpha]: [u8; 4], x: usize, y: usize) -> Color32 {
    if alpha < OPAQUE_FROM {
        return Color32::from_gray(if (x + y).is_multiple_of(2) {
            0x8c
        } else {
            0xa4
        });
    }
    Color32::from_rgb(r, g, b)
}
