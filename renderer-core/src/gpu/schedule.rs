//! What to draw next: slices of tiles × samples that fit a time budget.
//!
//! The first sample comes as five passes over all tiles, on ever finer lattices of pixels, so that a coarse whole
//! picture is there at once (as on the CPU). Later passes add one or more whole samples. A pass never goes beyond the
//! next power of two of samples: there the error is looked at, and tiles may end (MODEL.md §10). Tiles are counted here
//! among those that are drawn.

use std::ops::Range;
use std::time::Duration;

use super::constants::{COARSEST, TILE, TILE_PIXELS, WORKGROUP};

/// Most workgroups in one dimension of a dispatch, in WebGPU.
const MAX_WORKGROUPS: u32 = 65_535;

/// One dispatch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dispatch {
    /// The tiles to work on.
    pub tiles: Range<u32>,
    /// The samples to add.
    pub samples: Range<u32>,
    /// Lattice of the pixels to work on: those that are not on the next coarser one; 0: all pixels.
    pub stride: u32,
}

impl Dispatch {
    /// Most whole tiles of one dispatch.
    pub const MOST_TILES: u32 = MAX_WORKGROUPS * WORKGROUP / TILE_PIXELS;

    /// How many pixels of each tile are worked on.
    pub fn pixels_per_tile(&self) -> u32 {
        match self.stride {
            0 => TILE_PIXELS,
            COARSEST => 1,
            stride => 3 * (TILE / (2 * stride)).pow(2),
        }
    }

    /// Paths to trace.
    pub fn paths(&self) -> u64 {
        self.tiles.len() as u64 * self.samples.len() as u64 * u64::from(self.pixels_per_tile())
    }

    /// Workgroups to dispatch.
    pub fn workgroups(&self) -> u32 {
        (self.tiles.len() as u32 * self.pixels_per_tile()).div_ceil(WORKGROUP)
    }
}

/// Which samples and lattices the tiles before and after a point have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Drawn {
    /// The tile at which it changes, as the schedule counts them.
    pub split_tile: u32,
    /// Samples and lattice before it.
    pub before: (u32, u32),
    /// Samples and lattice from it on.
    pub after: (u32, u32),
}

/// Where the drawing of a picture stands.
#[derive(Debug, Clone)]
pub struct Schedule {
    tiles: u32,
    /// Samples that all pixels have.
    samples: u32,
    /// Lattice of the first sample's pass that is being drawn; 0 once the first sample is whole.
    stride: u32,
    /// Samples that the pass being drawn ends with.
    pass_end: u32,
    next_tile: u32,
}

impl Schedule {
    /// Nothing drawn yet.
    pub fn new(tiles: u32) -> Self {
        Self {
            tiles,
            samples: 0,
            stride: COARSEST,
            pass_end: 1,
            next_tile: 0,
        }
    }

    /// Goes on with fewer tiles; only between passes.
    pub fn set_tiles(&mut self, tiles: u32) {
        self.tiles = tiles;
    }

    /// Whole samples of every pixel.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// True between passes.
    pub fn is_between_passes(&self) -> bool {
        self.next_tile == 0
    }

    /// The next dispatch of about `paths` paths, towards `target` samples, within the tiles up to `buffer_end(tile)`.
    pub fn next(&mut self, paths: u64, target: u32, buffer_end: impl Fn(u32) -> u32) -> Dispatch {
        let whole_sample = u64::from(self.tiles) * u64::from(TILE_PIXELS);
        if self.next_tile == 0 && self.stride == 0 {
            let power = (self.samples + 1).next_power_of_two();
            let most = power.min(target.max(self.samples + 1)) - self.samples;
            let fitting = (paths / whole_sample).clamp(1, u64::from(most)) as u32;
            self.pass_end = self.samples + fitting;
        }
        let mut dispatch = Dispatch {
            tiles: self.next_tile..self.next_tile + 1,
            samples: self.samples..self.pass_end,
            stride: self.stride,
        };
        let most_in_dispatch = MAX_WORKGROUPS * WORKGROUP / dispatch.pixels_per_tile();
        let room = (buffer_end(self.next_tile) - self.next_tile).min(most_in_dispatch);
        let fitting = (paths / dispatch.paths()).clamp(1, u64::from(room)) as u32;
        dispatch.tiles.end += fitting - 1;
        dispatch
    }

    /// Notes that `dispatch`, the last one handed out, is done.
    pub fn finish(&mut self, dispatch: &Dispatch) {
        self.next_tile = dispatch.tiles.end;
        if self.next_tile < self.tiles {
            return;
        }
        self.next_tile = 0;
        self.stride /= 2;
        if self.stride == 0 {
            self.samples = self.pass_end;
        }
    }

    /// What has been drawn.
    pub fn drawn(&self) -> Drawn {
        let (before, after) = match self.stride {
            0 if self.next_tile == 0 => ((self.samples, 1), (self.samples, 1)),
            0 => ((self.pass_end, 1), (self.samples, 1)),
            COARSEST => ((1, COARSEST), (1, COARSEST)),
            stride => ((1, stride), (1, 2 * stride)),
        };
        Drawn {
            split_tile: self.next_tile,
            before,
            after,
        }
    }
}

/// How many paths a second the device traces, learned from finished dispatches.
#[derive(Debug, Clone, Default)]
pub struct Pace {
    paths_per_second: Option<f64>,
}

/// Paths of the first dispatch, when nothing is known: little even for a slow device.
const FIRST_PATHS: u64 = 2048;
/// Dispatches that take less are no danger to anybody, and so short that handing them out counts.
const SHORT_DISPATCH: Duration = Duration::from_millis(4);
/// A dispatch is at most this many times what the last one was expected to hold: costs differ over a picture.
const GROWTH: f64 = 4.0;

impl Pace {
    /// Paths that take about `time`.
    pub fn paths_in(&self, time: Duration) -> u64 {
        self.paths_per_second
            .map_or(FIRST_PATHS, |pace| (pace * time.as_secs_f64()) as u64)
    }

    /// Learns from a finished dispatch. In a short one it is not the paths that take the time, so that it tells only if
    /// the device is faster than thought. A device that turns out slower is believed at once (the picture may have
    /// become a costly one, and a driver's watchdog waits a second or two), a faster one by and by.
    pub fn learn(&mut self, paths: u64, time: Duration) {
        let measured = paths as f64 / time.as_secs_f64().max(1e-6);
        let is_slower = self.paths_per_second.is_some_and(|old| measured < old);
        if is_slower && time < SHORT_DISPATCH {
            return;
        }
        self.paths_per_second = Some(match self.paths_per_second {
            Some(old) if measured > old => (0.5 * (old + measured)).min(old * GROWTH),
            _ => measured,
        });
    }
}
