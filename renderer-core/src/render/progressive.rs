//! The loop of a renderer on the host: from a request and a way to draw one sample to a growing picture.
//!
//! Work goes out pass by pass over tiles of 16 × 16 pixels; the clock and the cancel flag are looked at after every row
//! of a tile. What has been drawn when time runs out never changes what is drawn later: same request, same bytes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::accumulation::{Accumulation, Pass, Sample, TILE_SIDE, Tile};
use super::background::background_tiles;
use super::convergence::{has_estimate, is_decision, leads_on};
use super::{Counters, MAX_SIDE, Optimisation, Progress, RenderError, RenderRequest};
use crate::image::Picture;

/// Which threads draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threads {
    /// The caller's only.
    One,
    /// All cores.
    All,
}

/// A picture in the making.
#[derive(Debug)]
pub struct Progressive {
    request: RenderRequest,
    accumulation: Accumulation,
    pass: Pass,
    error_estimate: Option<f64>,
}

impl Progressive {
    /// Starts from nothing.
    ///
    /// # Errors
    /// When the size or the crop is not allowed.
    pub fn new(request: &RenderRequest) -> Result<Self, RenderError> {
        check_size(request.size, request.crop)?;
        let [_, _, width, height] = request.crop;
        let mut accumulation = Accumulation::new([width, height], request.settings.aov);
        if request
            .settings
            .optimisations
            .has(Optimisation::BackgroundTiles)
        {
            let background = DVec3::from_array(request.scene().lights.background);
            accumulation.fill_background(&background_tiles(request, TILE_SIDE), background);
        }
        let error_estimate = accumulation.is_background().then_some(0.0);
        Ok(Self {
            request: request.clone(),
            accumulation,
            pass: Pass::default(),
            error_estimate,
        })
    }

    /// Takes over the targets of `request` if it is the same picture and no target has been passed already, for no tile
    /// either; false if it needs a new start.
    pub fn go_on_with(&mut self, request: &RenderRequest) -> bool {
        let (old, new) = (self.request.settings, request.settings);
        let mut same = request.clone();
        (same.settings.samples, same.settings.error) = (old.samples, old.error);
        let has_ended_tiles = self.accumulation.has_converged_tiles();
        let fits = same == self.request
            && leads_on(old.error, new.error, has_ended_tiles)
            && new.samples >= self.pass.samples_before();
        if fits {
            self.request.settings = new;
        }
        fits
    }

    /// Draws until `deadline`, or until done or `cancel` is true. `draw(pixel of the whole picture, sample, scratch)`
    /// makes one sample; each thread has its own scratch. `drawn(samples)` is called when all pixels have that many.
    pub fn advance<S: Default + AsMut<Counters>>(
        &mut self,
        threads: Threads,
        deadline: Instant,
        cancel: &AtomicBool,
        draw: impl Fn([u32; 2], u32, &mut S) -> Sample + Sync,
        drawn: impl Fn(u32),
    ) {
        let out_of_time = || cancel.load(Ordering::Relaxed) || Instant::now() >= deadline;
        let [left, top, ..] = self.request.crop;
        while !self.is_done() && !cancel.load(Ordering::Relaxed) {
            let pass = self.pass;
            let tiles = &mut self.accumulation.tiles;
            // One tile always goes on, so that even the shortest slice gets somewhere.
            let first = tiles.iter().position(|tile| !tile.has_finished(pass));
            let draw_tile = |scratch: &mut S, (index, tile): (usize, &mut Tile)| {
                if Some(index) != first && out_of_time() {
                    return;
                }
                while !tile.has_finished(pass) {
                    tile.draw_row(|[x, y], sample| draw([left + x, top + y], sample, scratch));
                    tile.counters += std::mem::take(scratch.as_mut());
                    if out_of_time() {
                        return;
                    }
                }
            };
            match threads {
                Threads::One => {
                    let mut scratch = S::default();
                    tiles
                        .iter_mut()
                        .enumerate()
                        .for_each(|tile| draw_tile(&mut scratch, tile));
                }
                Threads::All => tiles
                    .par_iter_mut()
                    .enumerate()
                    .for_each_init(S::default, draw_tile),
            }
            if !tiles.iter().all(|tile| tile.has_finished(pass)) {
                return;
            }
            self.pass = pass.next();
            if self.pass.samples_before() > pass.samples_before() {
                drawn(self.pass.samples_before());
            }
            if has_estimate(self.pass.samples_before()) {
                self.estimate();
            }
            if out_of_time() {
                return;
            }
        }
    }

    /// Estimates the error, and ends the tiles that need no more samples.
    fn estimate(&mut self) {
        let Some((of_tiles, whole)) = self.accumulation.errors() else {
            return;
        };
        self.error_estimate = Some(whole.relative());
        let settings = &self.request.settings;
        let may_end =
            settings.error > 0.0 && settings.optimisations.has(Optimisation::ConvergedTiles);
        if may_end && is_decision(self.pass.samples_before()) {
            self.accumulation.end_tiles(&of_tiles, |errors| {
                errors.have_converged(&whole, settings.error)
            });
        }
    }

    /// Whether a target is reached (all samples, or at a power of two the error asked for) or no tile is left to draw.
    fn is_done(&self) -> bool {
        let settings = &self.request.settings;
        let samples = self.pass.samples_before();
        let is_precise = is_decision(samples)
            && self
                .error_estimate
                .is_some_and(|error| settings.error > 0.0 && error <= settings.error);
        samples >= settings.samples
            || is_precise
            || !self.accumulation.tiles.iter().any(Tile::is_drawn)
    }

    /// Where the picture stands.
    pub fn progress(&self) -> Progress {
        Progress {
            samples: self.samples(),
            error_estimate: self.error_estimate,
            done: self.is_done(),
        }
    }

    /// Samples of the pixels that are drawn, or that would be if there were any.
    fn samples(&self) -> u32 {
        if self.accumulation.is_background() {
            return self.request.settings.samples;
        }
        self.pass.samples_before()
    }

    /// The mean so far.
    pub fn picture(&self) -> Picture {
        self.accumulation.picture()
    }

    /// Work done so far; zeros unless the request asked for it.
    pub fn counters(&self) -> Counters {
        let mut sum = Counters::default();
        if self.request.settings.counters {
            sum += self.accumulation.left_out(self.samples());
            for tile in &self.accumulation.tiles {
                sum += tile.counters;
            }
        }
        sum
    }

    /// Bytes of the sums.
    pub fn bytes(&self) -> u64 {
        self.accumulation.bytes()
    }
}

/// Whether a picture of this size with this crop can be made.
///
/// # Errors
/// Tells what is allowed.
pub fn check_size(size: [u32; 2], crop: [u32; 4]) -> Result<(), RenderError> {
    if size.iter().any(|side| !(1..=MAX_SIDE).contains(side)) {
        let [width, height] = size;
        return Err(RenderError::Size(format!(
            "size is {width}x{height}, but both sides must be from 1 to {MAX_SIDE} pixels"
        )));
    }
    let fits = |axis: usize| {
        let (start, length) = (u64::from(crop[axis]), u64::from(crop[axis + 2]));
        length > 0 && start + length <= u64::from(size[axis])
    };
    if !(fits(0) && fits(1)) {
        let ([x, y, width, height], [full_width, full_height]) = (crop, size);
        return Err(RenderError::Size(format!(
            "crop is {x},{y},{width},{height}, but it must have at least one pixel and lie inside \
                 {full_width}x{full_height}"
        )));
    }
    Ok(())
}
