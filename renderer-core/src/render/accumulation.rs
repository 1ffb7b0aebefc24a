//! Accumulation on the host: sums per pixel, their mean, and an estimate of the mean's error.
//!
//! Pixels are stored tile by tile, so that each tile can be drawn by another thread. A pixel adds its samples in their
//! order 0, 1, 2 …, whatever the order of tiles, slices and threads, so that its sums have the same bits every time.

use glam::DVec3;

use super::Counters;
use super::convergence::PixelErrors;
use crate::image::{Aov, Picture};
use crate::sampling::{RUN, SCRAMBLES, samples_of, scramble_of};

/// Side of a tile, pixels.
pub const TILE_SIDE: u32 = 16;

/// Steps between the pixels drawn by the passes of the first sample: a coarse whole picture first.
const STRIDES: [u32; 5] = [16, 8, 4, 2, 1];

/// One number for the three of a colour, of which the error is estimated: the sum of its channels, all with the sign +
/// in one pixel of every 2 × 2 and one of them with − in each of the other three.
///
/// Summed over the four pixels its variance is four times the channels' variances, however these depend on each other:
/// every product of two channels has the sign + twice and − twice. That is the error that relRMSE measures, which is no
/// single weighted sum's (luminance misses what is blue), from a third of the memory.
fn signed_sum(rgb: DVec3, [x, y]: [u32; 2]) -> f64 {
    let signs = match (x % 2, y % 2) {
        (0, 0) => DVec3::ONE,
        (1, 0) => DVec3::new(-1.0, 1.0, 1.0),
        (0, _) => DVec3::new(1.0, -1.0, 1.0),
        _ => DVec3::new(1.0, 1.0, -1.0),
    };
    rgb.dot(signs)
}

/// What one sample of a pixel found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Linear radiance, background included.
    pub radiance: DVec3,
    /// Where the ray met the cloth, if it did.
    pub first: Option<FirstHit>,
}

/// The first scattering of a sample; means where it may be at several points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Share of what came along the ray that met cloth.
    pub share: f64,
    /// Distance from the eye, mm.
    pub depth_mm: f64,
    /// Unit normal, turned towards the eye, world space.
    pub normal: DVec3,
    /// Albedo, linear.
    pub albedo: DVec3,
}

/// One pass over all tiles. The first sample takes a pass for every stride, each later sample one pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Pass(u32);

impl Pass {
    /// The pass after this one.
    pub fn next(self) -> Self {
        Self(self.0 + 1)
    }

    /// Which sample of a pixel this pass draws.
    pub fn sample(self) -> u32 {
        self.0.saturating_sub(STRIDES.len() as u32 - 1)
    }

    /// Whole samples of every pixel before this pass.
    pub fn samples_before(self) -> u32 {
        self.sample()
    }

    /// Whether this pass draws the pixel (x, y) of a tile.
    fn draws(self, x: u32, y: u32) -> bool {
        let on = |stride: u32| x.is_multiple_of(stride) && y.is_multiple_of(stride);
        match self.0 as usize {
            0 => on(STRIDES[0]),
            level if level < STRIDES.len() => on(STRIDES[level]) && !on(STRIDES[level - 1]),
            _ => true,
        }
    }
}

/// Sums of one pixel.
#[derive(Debug, Clone, Copy, Default)]
struct PixelSums {
    radiance: DVec3,
    /// Sums of [`signed_sum`], a scramble each.
    signed: [f64; SCRAMBLES as usize],
    samples: u32,
    covered: f32,
}

impl PixelSums {
    /// Estimated variance of the mean of all its samples' [`signed_sum`]; 0 where one scramble has all of them.
    fn variance(&self) -> f64 {
        let mean = self.signed.iter().sum::<f64>() / f64::from(self.samples);
        let (mut spread, mut scrambles) = (0.0, 0);
        for (scramble, sum) in (0..).zip(self.signed) {
            let samples = samples_of(scramble, self.samples);
            if samples > 0 {
                spread += f64::from(samples) * (sum / f64::from(samples) - mean).powi(2);
                scrambles += 1;
            }
        }
        if scrambles < 2 {
            return 0.0;
        }
        spread / (f64::from(scrambles - 1) * f64::from(self.samples))
    }
}

/// Sums of one pixel's extra channels over the samples that met cloth.
#[derive(Debug, Clone, Copy, Default)]
struct AovSums {
    depth: f64,
    normal: DVec3,
    albedo: DVec3,
}

/// Whether a tile is drawn on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Standing {
    Drawn,
    /// It shows nothing but background: its only sample is that, and what each further sample would be.
    Background,
    /// Its error is as small as it has to be.
    Converged,
}

/// A square of pixels (smaller at the picture's right and lower edges).
#[derive(Debug, Clone)]
pub struct Tile {
    origin: [u32; 2],
    size: [u32; 2],
    pixels: Vec<PixelSums>,
    aov: Vec<AovSums>,
    standing: Standing,
    /// The pass this tile is in, and the row it draws next.
    pass: Pass,
    row: u32,
    /// Work done in this tile.
    pub counters: Counters,
}

impl Tile {
    /// Whether nothing of `pass` is left to draw.
    pub fn has_finished(&self, pass: Pass) -> bool {
        self.standing != Standing::Drawn || self.pass.0 > pass.0
    }

    /// Whether the tile is drawn as long as the picture is.
    pub fn is_drawn(&self) -> bool {
        self.standing == Standing::Drawn
    }

    /// Ends the tile: its error is as small as it has to be.
    pub fn end(&mut self) {
        self.standing = Standing::Converged;
    }

    /// Makes the tile one that shows `background` alone.
    fn fill(&mut self, background: DVec3) {
        self.standing = Standing::Background;
        self.pixels.fill(PixelSums {
            radiance: background,
            samples: 1,
            ..PixelSums::default()
        });
    }

    /// The error of its pixels; `None` until two scrambles have had their first runs everywhere.
    ///
    /// The means mᵢ of the k scrambles that have samples are independent. With nᵢ samples of n each varies about as
    /// 1/nᵢ, so the variance of the mean m of all is Σ nᵢ(mᵢ − m)²/((k − 1)·n). Samples within one scramble are not
    /// independent, and their own spread would tell nothing about it (MODEL.md §10).
    pub fn errors(&self) -> Option<PixelErrors> {
        let mut errors = PixelErrors::default();
        for pixel in &self.pixels {
            if self.standing != Standing::Background && pixel.samples < 2 * RUN {
                return None;
            }
            errors += PixelErrors {
                variance: pixel.variance(),
                sum: pixel.radiance.element_sum() / f64::from(pixel.samples),
                pixels: 1,
            };
        }
        Some(errors)
    }

    /// Draws the next row of the current pass with `draw(pixel of the accumulation, sample)`.
    pub fn draw_row(&mut self, mut draw: impl FnMut([u32; 2], u32) -> Sample) {
        let (pass, y) = (self.pass, self.row);
        for x in (0..self.size[0]).filter(|&x| pass.draws(x, y)) {
            let sample = draw([self.origin[0] + x, self.origin[1] + y], pass.sample());
            self.add([x, y], pass.sample(), &sample);
        }
        self.row += 1;
        if self.row == self.size[1] {
            (self.pass, self.row) = (pass.next(), 0);
        }
    }

    fn add(&mut self, [x, y]: [u32; 2], number: u32, sample: &Sample) {
        let index = (y * self.size[0] + x) as usize;
        let pixel = &mut self.pixels[index];
        pixel.radiance += sample.radiance;
        // Tiles have an even side, so that the pattern of signs goes on from one to the next.
        pixel.signed[scramble_of(number) as usize] += signed_sum(sample.radiance, [x, y]);
        pixel.samples += 1;
        if let Some(first) = &sample.first {
            pixel.covered += first.share as f32;
            if let Some(aov) = self.aov.get_mut(index) {
                aov.depth += first.share * first.depth_mm;
                aov.normal += first.share * first.normal;
                aov.albedo += first.share * first.albedo;
            }
        }
    }

    /// Index of (x, y), or of the nearest coarser pixel that has a sample.
    fn nearest_drawn(&self, x: u32, y: u32) -> Option<usize> {
        STRIDES
            .iter()
            .rev()
            .map(|stride| ((y - y % stride) * self.size[0] + x - x % stride) as usize)
            .find(|&index| self.pixels[index].samples > 0)
    }
}

/// Sums of all pixels of a picture.
#[derive(Debug, Clone)]
pub struct Accumulation {
    size: [u32; 2],
    /// The tiles, row by row.
    pub tiles: Vec<Tile>,
}

impl Accumulation {
    /// Nothing yet, for a picture of `size` pixels; `aov` makes room for extra channels.
    pub fn new(size: [u32; 2], aov: bool) -> Self {
        let [columns, rows] = size.map(|side| side.div_ceil(TILE_SIDE));
        let tile = |index: u32| {
            let origin = [index % columns * TILE_SIDE, index / columns * TILE_SIDE];
            let tile_size = [0, 1].map(|axis| TILE_SIDE.min(size[axis] - origin[axis]));
            let count = (tile_size[0] * tile_size[1]) as usize;
            Tile {
                origin,
                size: tile_size,
                pixels: vec![PixelSums::default(); count],
                aov: vec![AovSums::default(); if aov { count } else { 0 }],
                standing: Standing::Drawn,
                pass: Pass::default(),
                row: 0,
                counters: Counters::default(),
            }
        };
        Self {
            size,
            tiles: (0..columns * rows).map(tile).collect(),
        }
    }

    /// Bytes of all sums.
    pub fn bytes(&self) -> u64 {
        let tile = |tile: &Tile| size_of_val(&*tile.pixels) + size_of_val(&*tile.aov);
        self.tiles.iter().map(|t| tile(t) as u64).sum()
    }

    /// The error of each tile and of the whole picture; `None` until two scrambles have had their first runs
    /// everywhere.
    pub fn errors(&self) -> Option<(Vec<PixelErrors>, PixelErrors)> {
        let mut whole = PixelErrors::default();
        let of_tiles = self.tiles.iter().map(|tile| {
            let errors = tile.errors()?;
            whole += errors;
            Some(errors)
        });
        let of_tiles = of_tiles.collect::<Option<_>>()?;
        Some((of_tiles, whole))
    }

    /// Ends every tile that `is_done(its error)`.
    pub fn end_tiles(
        &mut self,
        errors: &[PixelErrors],
        mut is_done: impl FnMut(&PixelErrors) -> bool,
    ) {
        for (tile, errors) in self.tiles.iter_mut().zip(errors) {
            if tile.is_drawn() && is_done(errors) {
                tile.end();
            }
        }
    }

    /// Fills the tiles that show `background` alone.
    pub fn fill_background(&mut self, is_background: &[bool], background: DVec3) {
        for (tile, _) in (self.tiles.iter_mut().zip(is_background)).filter(|(_, is)| **is) {
            tile.fill(background);
        }
    }

    /// Samples of whole tiles that are left out of `samples` of each: of background, and of converged tiles.
    pub fn left_out(&self, samples: u32) -> Counters {
        let mut counters = Counters::default();
        for tile in &self.tiles {
            match tile.standing {
                Standing::Drawn => {}
                Standing::Background => counters.skipped_tiles += u64::from(samples),
                Standing::Converged => {
                    let drawn = tile.pass.samples_before();
                    counters.converged_tiles += u64::from(samples.saturating_sub(drawn));
                }
            }
        }
        counters
    }

    /// Whether any tile has ended before the picture.
    pub fn has_converged_tiles(&self) -> bool {
        (self.tiles.iter()).any(|tile| tile.standing == Standing::Converged)
    }

    /// Whether there is nothing but background.
    pub fn is_background(&self) -> bool {
        (self.tiles.iter()).all(|tile| tile.standing == Standing::Background)
    }

    /// The mean of the samples so far; a pixel that has none shows the nearest that has.
    pub fn picture(&self) -> Picture {
        let [width, height] = self.size.map(|side| side as usize);
        let has_aov = self.tiles.iter().any(|tile| !tile.aov.is_empty());
        let mut pixels = vec![[0.0; 4]; width * height];
        let mut aov = has_aov.then(|| Aov {
            depth: vec![0.0; width * height],
            normal: vec![[0.0; 3]; width * height],
            albedo: vec![[0.0; 3]; width * height],
            noisy: Vec::new(),
        });
        for (tile, source) in self.tiles.iter().zip(self.drawn_tiles()) {
            let Some(source) = source else { continue };
            for y in 0..tile.size[1] {
                for x in 0..tile.size[0] {
                    // A tile that borrows from another one shows that one's first pixel.
                    let found = if std::ptr::eq(tile, source) {
                        tile.nearest_drawn(x, y)
                    } else {
                        source.nearest_drawn(0, 0)
                    };
                    let Some(from) = found else { continue };
                    let to = (tile.origin[1] + y) as usize * width + (tile.origin[0] + x) as usize;
                    let sums = &source.pixels[from];
                    let scale = 1.0 / f64::from(sums.samples);
                    let [r, g, b] = (sums.radiance * scale).as_vec3().to_array();
                    pixels[to] = [r, g, b, (f64::from(sums.covered) * scale) as f32];
                    if let Some(aov) = aov.as_mut().filter(|_| sums.covered > 0.0) {
                        let (sums, scale) = (&source.aov[from], 1.0 / f64::from(sums.covered));
                        aov.depth[to] = (sums.depth * scale) as f32;
                        aov.normal[to] = (sums.normal * scale).as_vec3().to_array();
                        aov.albedo[to] = (sums.albedo * scale).as_vec3().to_array();
                    }
                }
            }
        }
        Picture {
            size: self.size,
            pixels,
            aov,
        }
    }

    /// For every tile the one that its pixels are taken from: itself if it has begun, else the nearest before it in the
    /// order of drawing, else the nearest after it; but never one of background, which would be taken for the cloth.
    fn drawn_tiles(&self) -> Vec<Option<&Tile>> {
        let mut last = None;
        let mut sources: Vec<_> = self
            .tiles
            .iter()
            .map(|tile| {
                if tile.standing == Standing::Background {
                    return Some(tile);
                }
                if tile.pixels[0].samples > 0 {
                    last = Some(tile);
                }
                last
            })
            .collect();
        let is_cloth = |tile: &&&Tile| tile.standing != Standing::Background;
        let first = sources.iter().flatten().find(is_cloth).copied();
        for source in sources.iter_mut().filter(|source| source.is_none()) {
            *source = first;
        }
        sources
    }
}
