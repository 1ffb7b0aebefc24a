//! What is known of a picture before it is drawn, and how what is drawn is joined with it, so that no picture in the
//! window is worse than the one before.
//!
//! An edit leaves most of a picture as it was, and another camera sees the same cloth from elsewhere: the last picture,
//! moved to where the new camera sees its cloth ([`ShownPicture::from`]), is a guess without noise. A picture that is drawn has
//! noise, and may be small. Both are joined as estimates with errors of their own (the weight of each is the inverse of
//! its mean square error, as in empirical Bayes shrinkage): in every neighbourhood the mean square of their difference is
//! the sum of both errors, that of the drawn one is known from how far it was from its own earlier samples, and the rest
//! is the guess's. Small pictures correct what is as coarse as they are, and leave finer detail as it was.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use renderer_core::design::Design;
use renderer_core::geometry::{Camera, Ray};
use renderer_core::image::Picture;
use renderer_core::scene::lod::LodCloth;

/// Pixels around each over which errors are averaged: 49 pixels of three channels tell a mean square to an eighth.
const AROUND: usize = 3;
/// Errors of what is drawn count so many times: where an estimate is wrong, noise is worse than what was known.
const CAUTION: f32 = 1.25;
/// Variance of a sample of a pixel of cloth, by the square of its value, before any is measured.
const USUAL_NOISE: f32 = 0.5;
/// Brightness may be multiplied by so much to keep detail; the rest is added.
const MOST_GAIN: f32 = 4.0;
/// Side of the cells of a picture at whose corners rays are cast, pixels,
const CELL: usize = 16;
/// and of those into which cells at the cloth's outline are divided.
const OUTLINE_CELL: usize = 4;

/// A picture and what it shows: from where, and of which cloth.
#[derive(Clone)]
pub struct ShownPicture {
    /// Linear light.
    pub picture: Arc<Picture>,
    /// The camera in the cloth's world.
    pub camera: Camera,
    /// What the light meter said, stops.
    pub metered_stops: f64,
    /// The cloth's middle surface.
    pub surface: Surface,
}

/// The surface through the middle of the pile, which pictures are taken to show.
#[derive(Clone)]
pub struct Surface {
    cloth: Arc<LodCloth>,
    /// Half of width and length, mm.
    half_mm: DVec2,
    /// Height of the front's and of the back's surface over the sheet, mm.
    heights_mm: [f64; 2],
}

impl Surface {
    /// That of a design's cloth.
    pub fn new(design: &Design, cloth: &Arc<LodCloth>) -> Self {
        let sheet = &design.sheet;
        let half_mm = DVec2::new(
            f64::from(sheet.warps) * sheet.pitch_x(),
            f64::from(sheet.wefts) * sheet.pitch_y(),
        ) / 2.0;
        let pile = design.length.longest().min(design.pile.max_length);
        Self {
            cloth: Arc::clone(cloth),
            half_mm,
            heights_mm: [pile / 2.0, -pile / 2.0],
        }
    }

    /// Whether it is bent, so that finding a ray's end takes a while.
    fn is_bent(&self) -> bool {
        self.cloth.scenes.nearest.form.is_some()
    }

    /// Where a ray of the world meets it.
    fn hit(&self, (origin, direction): (DVec3, DVec3)) -> Option<DVec3> {
        if let Some(form) = &*self.cloth.scenes.nearest.form {
            let (at, is_front) = form.pick(&Ray { origin, direction }, self.heights_mm)?;
            let height = self.heights_mm[usize::from(!is_front)];
            return Some(form.world_of(at.extend(height)));
        }
        let height = self.heights_mm[usize::from(direction.z > 0.0)];
        let distance = (height - origin.z) / direction.z;
        let point = origin + direction * distance;
        let is_there = distance > 0.0 && point.is_finite();
        (is_there && point.truncate().abs().cmple(self.half_mm).all()).then_some(point)
    }
}

impl ShownPicture {
    /// As another reading of the light meter has it: other lights light white to another radiance, and show it as before.
    pub fn metered(&self, metered_stops: f64) -> Self {
        let gain = (self.metered_stops - metered_stops).exp2() as f32;
        if gain == 1.0 {
            return self.clone();
        }
        let mut picture = Picture::clone(&self.picture);
        picture.pixels.par_iter_mut().for_each(|[r, g, b, _]| {
            *r *= gain;
            *g *= gain;
            *b *= gain;
        });
        Self {
            picture: Arc::new(picture),
            metered_stops,
            ..self.clone()
        }
    }

    /// This picture as another camera sees its cloth, in a picture of `size` pixels: `background` beside the cloth, and
    /// the mean of the picture's cloth where the picture does not reach.
    pub fn from(&self, camera: &Camera, size: [u32; 2], background: [f32; 3]) -> Picture {
        let width = size[0] as usize;
        let mean = self.mean_of_cloth();
        let places = Places::new(self, camera, size);
        let mut pixels = vec![[0.0; 4]; width * size[1] as usize];
        let [r, g, b] = background;
        pixels
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    *pixel = match places.at(x, y) {
                        Place::Beside => [r, g, b, 0.0],
                        Place::Unknown => mean,
                        Place::At(at) => bilinear(&self.picture, at).unwrap_or(mean),
                    };
                }
            });
        Picture {
            size,
            pixels,
            aov: None,
        }
    }

    fn mean_of_cloth(&self) -> [f32; 4] {
        let cloth = self
            .picture
            .pixels
            .iter()
            .step_by(7)
            .filter(|pixel| pixel[3] > 0.5);
        let (mut sum, mut count) = ([0.0_f64; 4], 0.0);
        for pixel in cloth {
            sum = std::array::from_fn(|c| sum[c] + f64::from(pixel[c]));
            count += 1.0;
        }
        sum.map(|sum| (sum / f64::max(count, 1.0)) as f32)
    }

    /// Where this picture shows what a ray of another camera meets.
    fn place(&self, ray: (DVec3, DVec3)) -> Place {
        let Some(point) = self.surface.hit(ray) else {
            return Place::Beside;
        };
        match self.camera.pixel_of(point, self.picture.size) {
            Some(at) => Place::At(at.as_vec2()),
            None => Place::Unknown,
        }
    }
}

/// Where a picture shows something.
#[derive(Clone, Copy)]
enum Place {
    /// It is no cloth.
    Beside,
    /// Nowhere.
    Unknown,
    /// At this point, pixels from the top left corner.
    At(glam::Vec2),
}

/// Where a picture shows what each pixel of another one does: found at the corners of cells, with straight lines
/// between, which in a cell are a hundredth of a pixel off.
struct Places<'a> {
    seen: &'a ShownPicture,
    camera: &'a Camera,
    size: [u32; 2],
    /// Corners in a row,
    columns: usize,
    /// and all of them.
    corners: Vec<Place>,
}

impl<'a> Places<'a> {
    fn new(seen: &'a ShownPicture, camera: &'a Camera, size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| (side as usize).div_ceil(OUTLINE_CELL) + 1);
        let mut places = Self {
            seen,
            camera,
            size,
            columns,
            corners: Vec::new(),
        };
        places.corners = places.cast(columns, rows);
        places
    }

    /// The places at all corners of the fine cells: from rays where cells are at the outline, else between those of the
    /// coarse ones.
    fn cast(&self, columns: usize, rows: usize) -> Vec<Place> {
        const STEPS: usize = CELL / OUTLINE_CELL;
        let ray = |column: usize, row: usize| {
            let corner = DVec2::new((column * OUTLINE_CELL) as f64, (row * OUTLINE_CELL) as f64);
            self.seen.place(self.camera.ray(corner, self.size))
        };
        let [wide, high] = [columns, rows].map(|fine| (fine - 1).div_ceil(STEPS) + 1);
        let coarse: Vec<Place> = (0..wide * high)
            .into_par_iter()
            .map(|index| ray(index % wide * STEPS, index / wide * STEPS))
            .collect();
        let fine = (0..columns * rows).into_par_iter().map(|index| {
            let (column, row) = (index % columns, index / columns);
            let (left, upper) = ((column / STEPS).min(wide - 2), (row / STEPS).min(high - 2));
            let around = [0, 1, wide, wide + 1].map(|k| coarse[upper * wide + left + k]);
            let share =
                [column - left * STEPS, row - upper * STEPS].map(|k| k as f32 / STEPS as f32);
            between(around, share, CELL as f32).unwrap_or_else(|| ray(column, row))
        });
        fine.collect()
    }

    fn at(&self, x: usize, y: usize) -> Place {
        let (column, row) = (x / OUTLINE_CELL, y / OUTLINE_CELL);
        let first = row * self.columns + column;
        let around = [0, 1, self.columns, self.columns + 1].map(|k| self.corners[first + k]);
        let share =
            [x % OUTLINE_CELL, y % OUTLINE_CELL].map(|k| (k as f32 + 0.5) / OUTLINE_CELL as f32);
        between(around, share, OUTLINE_CELL as f32).unwrap_or_else(|| {
            match self.seen.surface.is_bent() {
                // A ray for each pixel would take too long.
                true => around[0],
                false => {
                    let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    self.seen.place(self.camera.ray(middle, self.size))
                }
            }
        })
    }
}

/// The place between four corners of a cell; `None` if they are not of one piece of cloth.
fn between(corners: [Place; 4], [x, y]: [f32; 2], side: f32) -> Option<Place> {
    let mut at = [glam::Vec2::ZERO; 4];
    for (at, corner) in at.iter_mut().zip(corners) {
        match corner {
            Place::At(place) => *at = place,
            Place::Beside | Place::Unknown => {
                let all_beside = corners.iter().all(|c| matches!(c, Place::Beside));
                return all_beside.then_some(Place::Beside);
            }
        }
    }
    // Farther apart than a picture of several times the size would have them: one of them lies behind a fold.
    let far = |a: glam::Vec2, b: glam::Vec2| a.distance(b) > 4.0 * side;
    if far(at[0], at[1]) || far(at[0], at[2]) || far(at[3], at[1]) || far(at[3], at[2]) {
        return None;
    }
    let (upper, lower) = (at[0].lerp(at[1], x), at[2].lerp(at[3], x));
    Some(Place::At(upper.lerp(lower, y)))
}

/// The colour of a picture at a point in pixels from its top left corner; `None` outside.
fn bilinear(picture: &Picture, at: glam::Vec2) -> Option<[f32; 4]> {
    let [width, height] = picture.size.map(|side| side as usize);
    let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x <= width as f32 && at.y <= height as f32;
    is_inside.then(|| {
        let at = (at - 0.5).max(glam::Vec2::ZERO);
        let (x, y) = (
            (at.x as usize).min(width - 1),
            (at.y as usize).min(height - 1),
        );
        let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
        let (u, v) = (at.x.fract(), at.y.fract());
        let row = |y: usize| {
            (
                &picture.pixels[y * width + x],
                &picture.pixels[y * width + right],
            )
        };
        let (upper, lower) = (row(y), row(below));
        std::array::from_fn(|c| {
            let mix = |(a, b): (&[f32; 4], &[f32; 4])| a[c] + u * (b[c] - a[c]);
            mix(upper) + v * (mix(lower) - mix(upper))
        })
    })
}

/// What is known of the noise of a picture that is drawn.
pub struct Drawn<'a> {
    /// The picture, of full size or smaller.
    pub picture: &'a Picture,
    /// Samples of a pixel.
    pub samples: u32,
    /// How many samples an earlier state of the picture had, and that state.
    pub earlier: Option<(u32, &'a Picture)>,
    /// Its relRMSE, where that is known otherwise: of a denoised picture.
    pub error: Option<f64>,
}

/// Joins pictures; keeps what it has learnt of their noise.
pub struct Joining {
    /// Variance of a sample of a pixel of cloth by the square of its value.
    noise: f32,
    /// Weight that each pixel of the drawn picture had last. It has less noise with every sample, and never less weight.
    weights: Vec<f32>,
}

impl Default for Joining {
    fn default() -> Self {
        Self {
            noise: USUAL_NOISE,
            weights: Vec::new(),
        }
    }
}

impl Joining {
    /// Another picture is drawn, or the same at another size.
    pub fn start(&mut self) {
        self.weights.clear();
    }

    /// The relRMSE to expect of a denoised picture of so many samples of which nothing else is known.
    pub fn error_denoised(&self, samples: u32) -> f64 {
        /// What denoising leaves of the error of few samples, as measured on white terry.
        const LEFT: f64 = 0.4;
        LEFT * (f64::from(self.noise) / f64::from(samples.max(1))).sqrt()
    }

    /// A picture of full size of what was known and what is drawn.
    pub fn join(&mut self, known: &Picture, drawn: &Drawn<'_>) -> Picture {
        let size = drawn.picture.size;
        let coarse = (size != known.size).then(|| reduced(known, size));
        let guess = coarse.as_ref().unwrap_or(known);
        let errors = self.errors(drawn);
        let distances = squares(drawn.picture, guess);
        let [errors, distances] = [errors, distances].map(|map| averaged(map, drawn.picture.size));
        let mut weights: Vec<f32> = (errors.par_iter().zip(&distances))
            .map(|(error, distance)| match *distance > 0.0 {
                true => ((distance - CAUTION * error) / distance).clamp(0.0, 1.0),
                // Both are the same.
                false => 1.0,
            })
            .collect();
        if drawn.error.is_none() {
            if self.weights.len() == weights.len() {
                let last = weights.par_iter_mut().zip(&self.weights);
                last.for_each(|(weight, last)| *weight = weight.max(*last));
            }
            self.weights.clone_from(&weights);
        }
        let mut target = guess.clone();
        let pixels = target.pixels.par_iter_mut().zip(&drawn.picture.pixels);
        pixels.zip(&weights).for_each(|((target, drawn), weight)| {
            *target = std::array::from_fn(|c| target[c] + weight * (drawn[c] - target[c]));
        });
        match &coarse {
            None => target,
            Some(coarse) => with_detail(known, coarse, &target),
        }
    }

    /// Mean square error of each pixel of a drawn picture, of three channels together.
    fn errors(&mut self, drawn: &Drawn<'_>) -> Vec<f32> {
        let samples = drawn.samples.max(1) as f32;
        let picture = drawn.picture;
        // Background has no noise.
        let square = |pixel: &[f32; 4]| match pixel[3] > 0.0 {
            true => pixel[..3].iter().map(|c| c * c).sum::<f32>(),
            false => 0.0,
        };
        let by_error = drawn.error.map(|error| (error * error) as f32);
        let Some((fewer, earlier)) = drawn.earlier.filter(|_| by_error.is_none()) else {
            let share = by_error.unwrap_or(self.noise / samples);
            return picture
                .pixels
                .par_iter()
                .map(|p| share * square(p))
                .collect();
        };
        // Means of n and of m of these samples differ by a variance of v/m − v/n.
        let scale = 1.0 / (samples * (1.0 / fewer.max(1) as f32 - 1.0 / samples));
        let measured = squares(picture, earlier);
        let total: f64 = measured.par_iter().map(|e| f64::from(*e)).sum();
        let light: f64 = picture
            .pixels
            .par_iter()
            .map(|p| f64::from(square(p)))
            .sum();
        if light > 0.0 {
            self.noise = (f64::from(scale * samples) * total / light) as f32;
        }
        measured.into_par_iter().map(|e| scale * e).collect()
    }
}

/// Squared difference of each pixel, of three channels together.
fn squares(a: &Picture, b: &Picture) -> Vec<f32> {
    let pairs = a.pixels.par_iter().zip(&b.pixels);
    pairs
        .map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum())
        .collect()
}

/// Means over the pixels around each.
fn averaged(map: Vec<f32>, size: [u32; 2]) -> Vec<f32> {
    let [width, height] = size.map(|side| side as usize);
    let around = |at: usize, end: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(end);
    let mean = |values: &mut dyn Iterator<Item = f32>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
        sum / f32::max(count, 1.0)
    };
    let mut across = vec![0.0; map.len()];
    let rows = across.par_chunks_mut(width).zip(map.par_chunks(width));
    rows.for_each(|(out, row)| {
        for (x, out) in out.iter_mut().enumerate() {
            *out = mean(&mut row[around(x, width)].iter().copied());
        }
    });
    let mut both = map;
    both.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (x, out) in out.iter_mut().enumerate() {
            *out = mean(&mut around(y, height).map(|y| across[y * width + x]));
        }
    });
    both
}

/// How a small picture lies over a large one from the same camera: both are as high, and share their middle.
struct Fit {
    small: glam::Vec2,
    large: glam::Vec2,
    /// Rows of the small one for a row of the large one.
    scale: f32,
}

impl Fit {
    fn new(small: [u32; 2], large: [u32; 2]) -> Self {
        let [small, large] = [small, large].map(|size| glam::UVec2::from(size).as_vec2());
        Self {
            small,
            large,
            scale: small.y / large.y,
        }
    }

    /// The point of the small picture over the middle of a pixel of the large one, within its borders.
    fn small_at(&self, x: usize, y: usize) -> glam::Vec2 {
        let at = glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let at = (at - 0.5 * self.large) * self.scale + 0.5 * self.small;
        at.clamp(glam::Vec2::ZERO, self.small)
    }

    /// The columns (`axis` 0) or rows (1) of the large picture under one of the small; at least one.
    fn under(&self, index: usize, axis: usize) -> std::ops::Range<usize> {
        let border = |index: usize| {
            let at = (index as f32 - 0.5 * self.small[axis]) / self.scale + 0.5 * self.large[axis];
            at.round().clamp(0.0, self.large[axis]) as usize
        };
        let start = border(index).min(self.large[axis] as usize - 1);
        start..border(index + 1).max(start + 1)
    }
}

/// A picture at a smaller size: means of squares of pixels.
fn reduced(picture: &Picture, size: [u32; 2]) -> Picture {
    let fit = Fit::new(size, picture.size);
    let width = picture.size[0] as usize;
    let wide = size[0] as usize;
    let mut pixels = vec![[0.0; 4]; wide * size[1] as usize];
    pixels
        .par_chunks_mut(wide)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let (columns, rows) = (fit.under(x, 0), fit.under(y, 1));
                let count = (columns.len() * rows.len()).max(1) as f32;
                for y in rows {
                    for from in &picture.pixels[y * width + columns.start..y * width + columns.end]
                    {
                        *pixel = std::array::from_fn(|c| pixel[c] + from[c]);
                    }
                }
                *pixel = pixel.map(|sum| sum / count);
            }
        });
    Picture {
        size,
        pixels,
        aov: None,
    }
}

/// A picture that is as `target` where one looks no closer than that, with the detail that `known` has beyond `coarse`,
/// which is `known` at their size: lighter and darker as its surroundings are.
fn with_detail(known: &Picture, coarse: &Picture, target: &Picture) -> Picture {
    /// Darker than what a screen shows as black.
    const BLACK: f32 = 1e-4;
    let width = known.size[0] as usize;
    let mut joined = known.clone();
    let fit = Fit::new(coarse.size, known.size);
    joined
        .pixels
        .par_chunks_mut(width.max(1))
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let at = fit.small_at(x, y);
                let (Some(from), Some(to)) = (bilinear(coarse, at), bilinear(target, at)) else {
                    continue;
                };
                *pixel = std::array::from_fn(|c| {
                    let gain = ((to[c] + BLACK) / (from[c] + BLACK)).min(MOST_GAIN);
                    (pixel[c] * gain + to[c] - from[c] * gain).max(0.0)
                });
            }
        });
    joined
}

/// A small picture at full size, smooth between its pixels.
pub fn enlarged(picture: &Picture, size: [u32; 2]) -> Picture {
    let width = size[0] as usize;
    let fit = Fit::new(picture.size, size);
    let pixels = (0..width * size[1] as usize).into_par_iter().map(|index| {
        bilinear(picture, fit.small_at(index % width, index / width)).unwrap_or_default()
    });
    Picture {
        size,
        pixels: pixels.collect(),
        aov: None,
    }
}
