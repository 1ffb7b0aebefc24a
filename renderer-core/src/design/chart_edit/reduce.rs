//! From an image of any number of colours to a few yarns.
//!
//! The yarns are the means of clusters of colours in Oklab (k-means with the starts of k-means++, Arthur and
//! Vassilvitskii 2007; the best of some starts from fixed seeds). A cluster with one colour that outweighs the others,
//! as the flat parts of a logo have beside its smooth edges, takes that colour exactly.
//!
//! Longer than most files because choosing yarns and giving them to pixels share distances and what is remembered of
//! them.

use std::collections::HashMap;

use rayon::prelude::*;

use super::oklab::{
    linear, linear_from_oklab, nearest_srgb, oklab, oklab_from_linear, squared_distance,
};
use super::yarns::{BARE, yarn_of};
use crate::design::{ChartImage, TILE};
use crate::sampling::Pcg;

/// Most yarns to reduce to.
pub const MOST_YARNS: usize = 64;

/// How yarns are mixed where none of them is the colour of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dither {
    /// Not: each pixel is of the nearest yarn.
    #[default]
    None,
    /// In a regular pattern of 8 × 8 pixels.
    Ordered,
    /// What a pixel misses is made up for by its neighbours (Floyd and Steinberg 1976).
    Diffusion,
}

/// A colour of the image, or several that are nearly equal, and how many pixels have it.
#[derive(Clone, Copy)]
struct Point {
    lab: [f32; 3],
    colour: [u8; 3],
    pixels: u64,
}

/// Most colours that are kept apart exactly; beyond, those are taken together that share the upper 6 bits of each
/// channel.
const MOST_EXACT: usize = 1 << 16;
const BINS: usize = 1 << 18;
/// Starts of which the best is taken.
const STARTS: u32 = 3;
/// Rounds after which clusters hardly move any more.
const MOST_ROUNDS: usize = 32;
/// Points that one piece of work sums; fixed, so that sums do not depend on how many processors there are.
const PIECE: usize = 4096;
/// A colour that makes up this share of its cluster is the yarn.
const OUTWEIGHING: f64 = 0.3;

/// The best `count` yarns for an image, the commonest first; fewer if it has no more colours. Transparent pixels have
/// none.
pub fn choose_yarns(image: &ChartImage, count: usize) -> Vec<[u8; 3]> {
    let mut points = exact_points(image).unwrap_or_else(|| binned_points(image));
    points.sort_unstable_by_key(|point| (std::cmp::Reverse(point.pixels), point.colour));
    let count = count.clamp(1, MOST_YARNS);
    if points.len() <= count {
        return points.into_iter().map(|point| point.colour).collect();
    }
    let clusterings = (0..STARTS).map(|start| cluster(&points, count, start));
    let best = clusterings.min_by(|a, b| a.error.total_cmp(&b.error));
    best.map_or_else(Vec::new, |best| best.yarns(&points))
}

/// All colours of an image and their pixels; `None` if they are too many.
fn exact_points(image: &ChartImage) -> Option<Vec<Point>> {
    let mut counts: HashMap<[u8; 3], u64> = HashMap::new();
    let [across, down] = image.tiles();
    for (tx, ty) in (0..down).flat_map(|ty| (0..across).map(move |tx| (tx, ty))) {
        let (tile, [width, height]) = (image.tile(tx, ty), image.tile_size(tx, ty));
        let mut add = |colour: [u8; 4], pixels: u64| {
            if let (true, [r, g, b, 255]) = (pixels > 0, yarn_of(colour)) {
                *counts.entry([r, g, b]).or_default() += pixels;
            }
        };
        if let Some((colours, numbers)) = tile.numbered() {
            let mut pixels = [0; 256];
            for row in numbers.chunks_exact(TILE).take(height) {
                for &number in &row[..width] {
                    pixels[usize::from(number)] += 1;
                }
            }
            for (&colour, pixels) in colours.iter().zip(pixels) {
                add(colour, pixels);
            }
        } else {
            for y in 0..height {
                for x in 0..width {
                    add(tile.pixel(x, y), 1);
                }
            }
        }
        if counts.len() > MOST_EXACT {
            return None;
        }
    }
    let point = |(colour, pixels)| Point {
        lab: oklab(colour),
        colour,
        pixels,
    };
    Some(counts.into_iter().map(point).collect())
}

/// The image's colours by the upper bits of their channels, each bin with its mean.
fn binned_points(image: &ChartImage) -> Vec<Point> {
    #[derive(Clone, Copy, Default)]
    struct Bin {
        pixels: u64,
        sum: [u64; 3],
    }
    let [across, down] = image.tiles();
    let whole = (0..down)
        .into_par_iter()
        .fold(
            || vec![Bin::default(); BINS],
            |mut bins, ty| {
                for tx in 0..across {
                    let (tile, [width, height]) = (image.tile(tx, ty), image.tile_size(tx, ty));
                    for y in 0..height {
                        for x in 0..width {
                            let [r, g, b, alpha] = yarn_of(tile.pixel(x, y));
                            if alpha == 0 {
                                continue;
                            }
                            let [i, j, k] = [r, g, b].map(|value| usize::from(value >> 2));
                            let bin = &mut bins[i << 12 | j << 6 | k];
                            bin.pixels += 1;
                            for (sum, value) in bin.sum.iter_mut().zip([r, g, b]) {
                                *sum += u64::from(value);
                            }
                        }
                    }
                }
                bins
            },
        )
        // Whole numbers: the order of the sums does not matter.
        .reduce_with(|mut bins, others| {
            for (bin, other) in bins.iter_mut().zip(others) {
                bin.pixels += other.pixels;
                for (sum, other) in bin.sum.iter_mut().zip(other.sum) {
                    *sum += other;
                }
            }
            bins
        });
    let filled = whole.into_iter().flatten().filter(|bin| bin.pixels > 0);
    filled
        .map(|bin| {
            let colour = bin
                .sum
                .map(|sum| ((sum + bin.pixels / 2) / bin.pixels) as u8);
            Point {
                lab: oklab(colour),
                colour,
                pixels: bin.pixels,
            }
        })
        .collect()
}

struct Clustering {
    /// Cluster of each point.
    of_point: Vec<u8>,
    centres: Vec<[f32; 3]>,
    /// Sum of the squared distances of all pixels.
    error: f64,
}

fn cluster(points: &[Point], count: usize, start: u32) -> Clustering {
    let mut centres = starts(points, count, start);
    let mut last = (vec![0; points.len()], f64::INFINITY);
    for round in 0.. {
        let sums = assign(points, &centres);
        let error = sums.error;
        // No pixel has changed its yarn, or as good as none.
        let is_settled = error >= last.1 * (1.0 - 1e-5) || round == MOST_ROUNDS;
        last = (sums.of_point, error);
        if is_settled {
            break;
        }
        for (centre, sum) in centres.iter_mut().zip(&sums.clusters) {
            // An empty cluster stays where it is; it can only be one whose centre coincides with another's.
            if sum.pixels > 0.0 {
                *centre = sum.lab.map(|value| (value / sum.pixels) as f32);
            }
        }
    }
    Clustering {
        of_point: last.0,
        centres,
        error: last.1,
    }
}

/// Points far from each other: each is drawn with a probability that grows with the square of its distance to those
/// before.
fn starts(points: &[Point], count: usize, start: u32) -> Vec<[f32; 3]> {
    let mut random = Pcg::new(start, 0);
    // The commonest colour is one of the yarns, or near one.
    let mut centres = vec![points[0].lab];
    let mut distances = vec![f32::INFINITY; points.len()];
    while let (Some(&newest), true) = (centres.last(), centres.len() < count) {
        let mut whole = 0.0;
        for (distance, point) in distances.iter_mut().zip(points) {
            *distance = distance.min(squared_distance(point.lab, newest));
            whole += f64::from(*distance) * point.pixels as f64;
        }
        let mut left = f64::from(random.next_float()) * whole;
        let drawn = distances.iter().zip(points).find(|(distance, point)| {
            left -= f64::from(**distance) * point.pixels as f64;
            left < 0.0
        });
        let Some((_, drawn)) = drawn else { break };
        centres.push(drawn.lab);
    }
    centres
}

#[derive(Clone, Copy, Default)]
struct Sum {
    lab: [f64; 3],
    pixels: f64,
}

struct Sums {
    of_point: Vec<u8>,
    clusters: Vec<Sum>,
    error: f64,
}

/// Gives every point to the nearest centre.
fn assign(points: &[Point], centres: &[[f32; 3]]) -> Sums {
    let pieces: Vec<Sums> = points
        .par_chunks(PIECE)
        .map(|piece| {
            let mut sums = Sums {
                of_point: Vec::with_capacity(piece.len()),
                clusters: vec![Sum::default(); centres.len()],
                error: 0.0,
            };
            for point in piece {
                let (nearest, distance) = nearest(point.lab, centres);
                let (sum, weight) = (&mut sums.clusters[nearest], point.pixels as f64);
                for (sum, value) in sum.lab.iter_mut().zip(point.lab) {
                    *sum += weight * f64::from(value);
                }
                sum.pixels += weight;
                sums.error += weight * f64::from(distance);
                sums.of_point.push(nearest as u8);
            }
            sums
        })
        .collect();
    let mut whole = Sums {
        of_point: Vec::with_capacity(points.len()),
        clusters: vec![Sum::default(); centres.len()],
        error: 0.0,
    };
    for piece in pieces {
        whole.of_point.extend(piece.of_point);
        whole.error += piece.error;
        for (sum, piece) in whole.clusters.iter_mut().zip(piece.clusters) {
            sum.pixels += piece.pixels;
            for (sum, value) in sum.lab.iter_mut().zip(piece.lab) {
                *sum += value;
            }
        }
    }
    whole
}

/// The centre nearest to a colour, the first of equals, and the square of its distance.
#[inline]
fn nearest(lab: [f32; 3], centres: &[[f32; 3]]) -> (usize, f32) {
    let mut best = (0, f32::INFINITY);
    for (k, &centre) in centres.iter().enumerate() {
        let distance = squared_distance(lab, centre);
        if distance < best.1 {
            best = (k, distance);
        }
    }
    best
}

impl Clustering {
    /// The yarn of each cluster, that of the largest first.
    fn yarns(&self, points: &[Point]) -> Vec<[u8; 3]> {
        let mut clusters = vec![(0_u64, None::<Point>); self.centres.len()];
        // Points come with the commonest first.
        for (point, &cluster) in points.iter().zip(&self.of_point) {
            let (pixels, commonest) = &mut clusters[usize::from(cluster)];
            *pixels += point.pixels;
            commonest.get_or_insert(*point);
        }
        let mut yarns: Vec<(u64, [u8; 3])> = clusters
            .into_iter()
            .zip(&self.centres)
            .filter_map(|((pixels, commonest), &centre)| {
                let commonest = commonest?;
                let outweighs = commonest.pixels as f64 >= OUTWEIGHING * pixels as f64;
                let colour = if outweighs {
                    commonest.colour
                } else {
                    nearest_srgb(linear_from_oklab(centre))
                };
                Some((pixels, colour))
            })
            .collect();
        yarns.sort_unstable_by_key(|&(pixels, colour)| (std::cmp::Reverse(pixels), colour));
        let mut colours: Vec<[u8; 3]> = Vec::new();
        for (_, colour) in yarns {
            if !colours.contains(&colour) {
                colours.push(colour);
            }
        }
        colours
    }
}

/// The image in these yarns alone; transparent pixels stay bare. Without yarns it is the image itself.
pub fn reduce_to(image: &ChartImage, yarns: &[[u8; 3]], dither: Dither) -> ChartImage {
    let yarns = &yarns[..yarns.len().min(MOST_YARNS)];
    let labs: Vec<[f32; 3]> = yarns.iter().map(|&yarn| oklab(yarn)).collect();
    if labs.is_empty() {
        return image.clone();
    }
    let colour = |number: usize| {
        let [r, g, b] = yarns[number];
        [r, g, b, 255]
    };
    match dither {
        Dither::None => image.map_colours_with(
            || Remembered::new(|rgb| nearest(oklab(rgb), &labs).0),
            |remembered, pixel| match yarn_of(pixel) {
                [r, g, b, 255] => colour(remembered.get([r, g, b])),
                _ => BARE,
            },
        ),
        Dither::Ordered => {
            let mixes = Mixes::new(yarns, &labs);
            let (width, height) = (image.width(), image.height());
            ChartImage::from_fn_with(
                width,
                height,
                || Remembered::new(|rgb| mixes.of(rgb)),
                |remembered, x, y| match yarn_of(image.pixel(x, y)) {
                    [r, g, b, 255] => {
                        let mix = remembered.get([r, g, b]);
                        colour(mix.at(x, y))
                    }
                    _ => BARE,
                },
            )
            .unwrap_or_else(|| image.clone())
        }
        Dither::Diffusion => {
            let numbers = diffused(image, yarns, &labs);
            let width = image.width();
            ChartImage::from_fn(width, image.height(), |x, y| match numbers[y * width + x] {
                NO_YARN => BARE,
                number => colour(usize::from(number)),
            })
            .unwrap_or_else(|| image.clone())
        }
    }
}

/// Remembers what a function gave for the colours seen last.
struct Remembered<T, F> {
    slots: Vec<Option<([u8; 3], T)>>,
    function: F,
}

impl<T: Copy, F: Fn([u8; 3]) -> T> Remembered<T, F> {
    const BITS: u32 = 14;

    fn new(function: F) -> Self {
        Self {
            slots: vec![None; 1 << Self::BITS],
            function,
        }
    }

    #[inline]
    fn get(&mut self, colour: [u8; 3]) -> T {
        let [r, g, b] = colour;
        let hash = u32::from_le_bytes([r, g, b, 0]).wrapping_mul(0x9E37_79B1);
        let slot = &mut self.slots[(hash >> (32 - Self::BITS)) as usize];
        match slot {
            Some((known, value)) if *known == colour => *value,
            _ => {
                let value = (self.function)(colour);
                *slot = Some((colour, value));
                value
            }
        }
    }
}

/// Two yarns and how much of the second of them.
#[derive(Clone, Copy)]
struct Mix {
    yarns: [u8; 2],
    /// Of 64 pixels.
    second: u8,
}

impl Mix {
    /// Number of the yarn at a place of the pattern.
    fn at(self, x: usize, y: usize) -> usize {
        let is_second = THRESHOLDS[y % 8 * 8 + x % 8] < self.second;
        usize::from(self.yarns[usize::from(is_second)])
    }
}

/// Bayer's matrix of 8 × 8: every number below 64 once, neighbours far apart.
const THRESHOLDS: [u8; 64] = {
    let mut thresholds = [0; 64];
    let mut k = 0;
    while k < 64 {
        let (x, y) = (k % 8, k / 8);
        let mut bit = 0;
        while bit < 3 {
            let (low_x, low_y) = ((x >> bit) & 1, (y >> bit) & 1);
            thresholds[k] |= (((low_x ^ low_y) << 1 | low_y) << (2 * (2 - bit))) as u8;
            bit += 1;
        }
        k += 1;
    }
    thresholds
};

/// Yarns to mix colours of. Light mixes: a mixture is a mean of linear light.
struct Mixes<'a> {
    lights: Vec<[f32; 3]>,
    labs: &'a [[f32; 3]],
}

/// How much a mixture is punished for the contrast of its yarns, which shows as grain.
const GRAIN: f32 = 0.1;

impl<'a> Mixes<'a> {
    fn new(yarns: &[[u8; 3]], labs: &'a [[f32; 3]]) -> Self {
        Self {
            lights: yarns.iter().map(|&yarn| linear(yarn)).collect(),
            labs,
        }
    }

    /// The best mixture of the nearest yarn and any other.
    fn of(&self, colour: [u8; 3]) -> Mix {
        let (light, lab) = (linear(colour), oklab(colour));
        let (first, _) = nearest(lab, self.labs);
        let mut least = f32::INFINITY;
        let mut best = Mix {
            yarns: [first as u8; 2],
            second: 0,
        };
        let from = self.lights[first];
        for (second, &to) in self.lights.iter().enumerate() {
            let way: [f32; 3] = std::array::from_fn(|c| to[c] - from[c]);
            let length: f32 = way.iter().map(|w| w * w).sum();
            let along: f32 = (0..3).map(|c| way[c] * (light[c] - from[c])).sum();
            if length == 0.0 || along <= 0.0 {
                continue;
            }
            let parts = (64.0 * along / length).round().min(64.0);
            let mixed = std::array::from_fn(|c| from[c] + way[c] * parts / 64.0);
            let evenness = parts / 64.0 * (1.0 - parts / 64.0);
            let grain = GRAIN * evenness * squared_distance(self.labs[first], self.labs[second]);
            let miss = squared_distance(oklab_from_linear(mixed), lab) + grain;
            if miss < least {
                least = miss;
                best = Mix {
                    yarns: [first as u8, second as u8],
                    second: parts as u8,
                };
            }
        }
        best
    }
}

/// Number of pixels without yarn.
const NO_YARN: u8 = u8::MAX;

/// Numbers of the yarns of all pixels, errors of light handed on to neighbours; every second row is walked backwards.
fn diffused(image: &ChartImage, yarns: &[[u8; 3]], labs: &[[f32; 3]]) -> Vec<u8> {
    let (width, height) = (image.width(), image.height());
    let lights: Vec<[f32; 3]> = yarns.iter().map(|&yarn| linear(yarn)).collect();
    let mut numbers = vec![NO_YARN; width * height];
    // A pixel more at both ends takes what leaves the image.
    let mut here = vec![[0.0_f32; 3]; width + 2];
    let mut below = here.clone();
    for y in 0..height {
        let is_back = y % 2 == 1;
        for step in 0..width {
            let x = if is_back { width - 1 - step } else { step };
            let [r, g, b, 255] = yarn_of(image.pixel(x, y)) else {
                continue;
            };
            let light = linear([r, g, b]);
            // What no yarn can make up for must not pile up; what a white pixel is too bright by must be kept.
            let wanted: [f32; 3] =
                std::array::from_fn(|c| (light[c] + here[x + 1][c]).clamp(-1.0, 2.0));
            let (number, _) = nearest(oklab_from_linear(wanted), labs);
            numbers[y * width + x] = number as u8;
            let (ahead, behind) = if is_back { (x, x + 2) } else { (x + 2, x) };
            for c in 0..3 {
                let miss = (wanted[c] - lights[number][c]) / 16.0;
                here[ahead][c] += 7.0 * miss;
                below[behind][c] += 3.0 * miss;
                below[x + 1][c] += 5.0 * miss;
                below[ahead][c] += miss;
            }
        }
        std::mem::swap(&mut here, &mut below);
        below.fill([0.0; 3]);
    }
    numbers
}
