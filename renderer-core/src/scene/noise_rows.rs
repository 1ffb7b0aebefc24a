//! Noise of the turbulence's channels along a weft (MODEL.md §3). The `noise` crate defines it: its tables, and its
//! functions to the bit.
//!
//! Along a weft neighbours lie in the same cell of the noise's lattice, so octaves are summed one after the other over
//! the whole weft. For Perlin noise, what a lattice cell's corners give is then looked up once a lattice cell instead
//! of once a point; the arithmetic is the crate's, operation by operation. Measured on one core, that takes 6 to 10 ns
//! a point where the crate takes 24 to 93 (50 to 2 points along a lattice cell). Noise is some 7 % of the time in which
//! many loops are compiled; with the crate's it would be a third or more.

use std::f64::consts::SQRT_2;

use noise::core::simplex::simplex_2d;
use noise::core::worley::{ReturnType, distance_functions, worley_2d};
use noise::permutationtable::{NoiseHasher, PermutationTable};

use super::SheetGeometry;
use crate::design::{NoiseKind, Turbulence};
use crate::sampling::{hash_with, unit_float};

/// Mean of 2|n| − 1 for one octave of Perlin noise is −0.315; without this loops would have a hidden lean.
const FOLDED_MEAN: f64 = 0.315;

/// Some cells of a weft, and scratch space for their noise.
#[derive(Default)]
pub(super) struct NoiseRow {
    warps: Vec<usize>,
    /// Place of each along the weft, mm.
    x_mm: Vec<f64>,
    /// Sum of the octaves of each.
    sums: Vec<f64>,
}

impl NoiseRow {
    /// Takes the cells at these warps.
    pub(super) fn start(&mut self, warps: impl Iterator<Item = usize>, sheet: &SheetGeometry) {
        self.warps.clear();
        self.warps.extend(warps);
        let x_mm = |&i: &usize| sheet.place_mm(i, 0)[0];
        self.x_mm.clear();
        self.x_mm.extend(self.warps.iter().map(x_mm));
    }

    fn add(&mut self, amplitude: f64, mut noise: impl FnMut(f64) -> f64) {
        for (sum, &x_mm) in self.sums.iter_mut().zip(&self.x_mm) {
            *sum += amplitude * noise(x_mm).clamp(-1.0, 1.0);
        }
    }
}

/// Noise of all channels.
pub(super) struct Noise<'a> {
    turbulence: &'a Turbulence,
    /// Those that are wanted, with their numbers.
    channels: Vec<(usize, Channel)>,
}

impl<'a> Noise<'a> {
    /// The noise of those channels that are wanted.
    pub(super) fn new(turbulence: &'a Turbulence, wanted: [bool; 4]) -> Self {
        let wanted = (0..4).filter(|&c| wanted[c]);
        let channel = |c: usize| (c, Channel::new(turbulence, c as u32));
        Self {
            turbulence,
            channels: wanted.map(channel).collect(),
        }
    }

    /// Puts T_c of MODEL.md §3 of the cells of `row` into `values`, which has all cells of the weft.
    pub(super) fn fill(&self, row: &mut NoiseRow, y_mm: f64, values: &mut [[f32; 4]]) {
        let turbulence = self.turbulence;
        for (c, channel) in &self.channels {
            row.sums.clear();
            row.sums.resize(row.warps.len(), 0.0);
            let (mut frequency, mut amplitude) = (turbulence.frequency, 1.0);
            let mut amplitudes = 0.0;
            for _ in 0..turbulence.octaves {
                channel.add_octave(turbulence.kind, frequency, amplitude, row, y_mm);
                amplitudes += amplitude;
                frequency *= turbulence.lacunarity;
                amplitude *= turbulence.gain;
            }
            for (&i, &sum) in row.warps.iter().zip(&row.sums) {
                values[i][*c] = (sum / amplitudes).clamp(-1.0, 1.0) as f32;
            }
        }
    }
}

/// Noise of one channel.
struct Channel {
    lattice: Lattice,
    /// Moves the lattice; never an integer, where Perlin noise is zero.
    offset: [f64; 2],
}

impl Channel {
    fn new(turbulence: &Turbulence, channel: u32) -> Self {
        let seed = hash_with(turbulence.seed, channel);
        let offset = [1, 2].map(|axis| 0.1 + 0.8 * f64::from(unit_float(hash_with(seed, axis))));
        Self {
            lattice: Lattice::new(seed),
            offset,
        }
    }

    /// Adds one octave to the sums of a row.
    fn add_octave(
        &self,
        kind: NoiseKind,
        frequency: f64,
        amplitude: f64,
        row: &mut NoiseRow,
        y_mm: f64,
    ) {
        let lattice = &self.lattice;
        let y = frequency * y_mm + self.offset[1];
        let x = |x_mm: f64| frequency * x_mm + self.offset[0];
        match kind {
            NoiseKind::Fbm => {
                let mut perlin = PerlinRow::new(lattice, y);
                row.add(amplitude, |x_mm| perlin.at(x(x_mm)));
            }
            NoiseKind::Turbulence => {
                let mut perlin = PerlinRow::new(lattice, y);
                let folded = |n: f64| 2.0 * n.abs() - 1.0 + FOLDED_MEAN;
                row.add(amplitude, |x_mm| folded(perlin.at(x(x_mm))));
            }
            NoiseKind::Simplex => {
                row.add(amplitude, |x_mm| simplex_2d([x(x_mm), y].into(), lattice).0);
            }
            NoiseKind::Worley => row.add(amplitude, |x_mm| {
                let distance = distance_functions::euclidean;
                worley_2d(lattice, distance, ReturnType::Distance, [x(x_mm), y].into())
            }),
        }
    }
}

/// The crate's [`PermutationTable`], read once: its own look-up is not inlined into the noise.
struct Lattice([u8; 256]);

impl Lattice {
    fn new(seed: u32) -> Self {
        let table = PermutationTable::new(seed);
        // The hash of a single number is its entry in the table.
        Self(std::array::from_fn(|k| table.hash(&[k as isize]) as u8))
    }
}

impl NoiseHasher for Lattice {
    #[inline(always)]
    fn hash(&self, place: &[isize]) -> usize {
        // As the crate does it, for any number of dimensions.
        let mut places = place.iter().map(|&coordinate| coordinate as u8);
        let first = places.next().unwrap_or_default();
        let index = places.fold(first, |a, b| self.0[usize::from(a)] ^ b);
        usize::from(self.0[usize::from(index)])
    }
}

/// What a corner of the lattice gives to a point at (x, y) from it: `x_sign`·x + `y_part`.
#[derive(Clone, Copy, Default)]
struct Corner {
    x_sign: f64,
    y_part: f64,
}

/// Two-dimensional Perlin noise, as `noise::core::perlin::perlin_2d` computes it, for points with the same y.
struct PerlinRow<'a> {
    lattice: &'a Lattice,
    /// Rows of the lattice below and above the points.
    rows: [isize; 2],
    /// Height of the points over each.
    y: [f64; 2],
    /// How much the upper row weighs.
    y_weight: f64,
    /// The lattice's column left of the last point, and the corners around that: at its foot, then at its head.
    column: isize,
    left: [Corner; 2],
    right: [Corner; 2],
}

impl<'a> PerlinRow<'a> {
    fn new(lattice: &'a Lattice, y: f64) -> Self {
        let row = floor(y);
        let above = y - row as f64;
        let mut this = Self {
            lattice,
            rows: [row, row + 1],
            y: [above, above - 1.0],
            y_weight: quintic(above),
            column: isize::MIN,
            left: [Corner::default(); 2],
            right: [Corner::default(); 2],
        };
        this.enter(0);
        this
    }

    fn enter(&mut self, column: isize) {
        self.column = column;
        let corners = |column: isize| {
            [0, 1].map(|k| {
                let gradient = self.lattice.hash(&[column, self.rows[k]]);
                let sign = |bit: usize| if gradient & bit == 0 { 1.0 } else { -1.0 };
                Corner {
                    x_sign: sign(1),
                    y_part: sign(2) * self.y[k],
                }
            })
        };
        (self.left, self.right) = (corners(column), corners(column + 1));
    }

    #[inline]
    fn at(&mut self, x: f64) -> f64 {
        /// Brings the noise to [−1, 1].
        const SCALE: f64 = 2.0 / SQRT_2;
        let column = floor(x);
        if column != self.column {
            self.enter(column);
        }
        let right_of = x - column as f64;
        let blend = |[low, high]: [f64; 2], weight: f64| high * weight + low * (1.0 - weight);
        let side = |corners: &[Corner; 2], x: f64| {
            blend(
                corners.map(|corner| corner.x_sign * x + corner.y_part),
                self.y_weight,
            )
        };
        let sides = [
            side(&self.left, right_of),
            side(&self.right, right_of - 1.0),
        ];
        (blend(sides, quintic(right_of)) * SCALE).clamp(-1.0, 1.0)
    }
}

/// The whole number below `x`, and that of a whole number up to zero too, as the crate has it.
#[inline]
fn floor(x: f64) -> isize {
    x as isize - isize::from(x <= 0.0)
}

#[inline]
fn quintic(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
}
