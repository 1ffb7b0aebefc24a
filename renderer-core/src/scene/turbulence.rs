//! Turbulence: the smooth disorder of the loops (MODEL.md §3, the paper's §4.2 and figure 11). No units: every value is
//! in [−1, 1]; the strengths that turn it into angles and lengths belong to the frames.
//!
//! Four channels, one value a cell: the sum of octaves of the `noise` crate's noise in f64, at the cell's place in mm
//! from the sheet's low corner, then an optional filter over neighbouring cells. A filter averages, so it would weaken
//! the disorder; the field is rescaled about its mean to the deviation it had before.

use rayon::prelude::*;

use super::noise_rows::{Noise, NoiseRow};
use super::{Cancel, CellSet, SheetGeometry};
use crate::design::{Filter, Turbulence};

/// What each channel moves, in the order of [`TurbulenceField::at`].
pub const CHANNELS: [&str; 4] = ["tilt x", "tilt y", "stretch", "twist"];

/// The four channels of every cell, each in [−1, 1].
///
/// Compile asks for no more than it needs: the cells where loops stand and the channels that move them. What was not
/// asked for is 0. Under a filter every cell depends on its neighbours and on the deviation of all, so it has all
/// cells.
#[derive(Debug, Clone, PartialEq)]
pub struct TurbulenceField {
    warps: usize,
    values: Vec<[f32; 4]>,
    known: Wanted,
}

/// What is asked of a field.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wanted {
    pub(super) cells: CellSet,
    pub(super) channels: [bool; 4],
}

impl Wanted {
    /// Everything.
    pub(super) fn all(sheet: &SheetGeometry) -> Self {
        Self {
            cells: CellSet::all(sheet.warps as usize, sheet.wefts as usize),
            channels: [true; 4],
        }
    }
}

impl TurbulenceField {
    /// Computes the field of a sheet.
    pub fn new(sheet: &SheetGeometry, turbulence: &Turbulence) -> Self {
        Self::of(sheet, turbulence, Wanted::all(sheet), &Cancel::never())
    }

    /// The part of the field that is wanted; not whole if `cancel` says so afterwards.
    pub(super) fn of(
        sheet: &SheetGeometry,
        turbulence: &Turbulence,
        wanted: Wanted,
        cancel: &Cancel<'_>,
    ) -> Self {
        let (warps, wefts) = (sheet.warps as usize, sheet.wefts as usize);
        let weights = kernel(turbulence.filter, turbulence.filter_radius);
        let is_filtered = weights.len() > 1;
        let mut field = Self {
            warps,
            values: vec![[0.0; 4]; warps * wefts],
            known: Wanted {
                cells: CellSet::none(warps, wefts),
                channels: wanted.channels,
            },
        };
        let cells = if is_filtered {
            CellSet::all(warps, wefts)
        } else {
            wanted.cells
        };
        field.add(sheet, turbulence, &cells, cancel);
        if is_filtered && !cancel.is_cancelled() {
            let before = field.mean_and_deviation();
            field.smooth(&weights, cancel);
            field.rescale(before);
        }
        field
    }

    /// Whether the field has what is wanted.
    pub(super) fn has(&self, wanted: &Wanted) -> bool {
        self.has_channels(wanted) && self.known.cells.holds(&wanted.cells)
    }

    /// Whether the field has the channels that are wanted, be it in other cells.
    pub(super) fn has_channels(&self, wanted: &Wanted) -> bool {
        let channels = self.known.channels.iter().zip(wanted.channels);
        channels
            .into_iter()
            .all(|(&known, wanted)| known || !wanted)
    }

    /// Computes more cells of a field without a filter; not all of them if `cancel` says so afterwards.
    pub(super) fn add(
        &mut self,
        sheet: &SheetGeometry,
        turbulence: &Turbulence,
        cells: &CellSet,
        cancel: &Cancel<'_>,
    ) {
        let noise = Noise::new(turbulence, self.known.channels);
        let known = &self.known.cells;
        let rows = self.values.par_chunks_mut(self.warps).enumerate();
        rows.for_each_init(NoiseRow::default, |row, (j, values)| {
            if cancel.is_cancelled() {
                return;
            }
            row.start(cells.row(j).filter(|&i| !known.contains(i, j)), sheet);
            let [_, y_mm] = sheet.place_mm(0, j);
            noise.fill(row, y_mm, values);
        });
        if !cancel.is_cancelled() {
            let known = std::mem::replace(&mut self.known.cells, CellSet::none(0, 0));
            self.known.cells = known.or(cells);
        }
    }

    /// Values of the cell at warp `i` and weft `j`, in the order of [`CHANNELS`].
    pub fn at(&self, i: usize, j: usize) -> [f32; 4] {
        self.values[j * self.warps + i]
    }

    /// Number of cells along the weft.
    pub fn warps(&self) -> usize {
        self.warps
    }

    /// All cells, row by row from the near edge.
    pub fn values(&self) -> &[[f32; 4]] {
        &self.values
    }

    /// Mean and standard deviation of each channel over the sheet.
    pub fn mean_and_deviation(&self) -> [[f64; 2]; 4] {
        let count = self.values.len().max(1) as f64;
        let sum = |f: &(dyn Fn(f64, usize) -> f64 + Sync)| -> [f64; 4] {
            let add = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|c| a[c] + b[c]);
            let row_sum = |row: &[[f32; 4]]| {
                row.iter().fold([0.0; 4], |a, value| {
                    add(a, std::array::from_fn(|c| f(f64::from(value[c]), c)))
                })
            };
            // Rows are added in order, so that the sum does not depend on the number of threads.
            let rows: Vec<[f64; 4]> = self.values.par_chunks(self.warps).map(row_sum).collect();
            rows.into_iter().fold([0.0; 4], add)
        };
        let mean = sum(&|value, _| value).map(|s| s / count);
        let variance = sum(&|value, c| (value - mean[c]).powi(2)).map(|s| s / count);
        std::array::from_fn(|c| [mean[c], variance[c].sqrt()])
    }

    /// Convolves rows and columns with `weights` (centre first, both sides alike); edge cells continue outwards.
    fn smooth(&mut self, weights: &[f32], cancel: &Cancel<'_>) {
        let warps = self.warps;
        let wefts = self.values.len() / warps;
        let mut rows_done = vec![[0.0; 4]; self.values.len()];
        let blend = |target: &mut [f32; 4], weight: f32, value: [f32; 4]| {
            for (t, v) in target.iter_mut().zip(value) {
                *t += weight * v;
            }
        };
        let rows = rows_done.par_chunks_mut(warps);
        rows.zip(self.values.par_chunks(warps))
            .for_each(|(out, row)| {
                if cancel.is_cancelled() {
                    return;
                }
                for (i, sum) in out.iter_mut().enumerate() {
                    blend(sum, weights[0], row[i]);
                    for (d, &weight) in weights.iter().enumerate().skip(1) {
                        blend(sum, weight, row[i.saturating_sub(d)]);
                        blend(sum, weight, row[(i + d).min(warps - 1)]);
                    }
                }
            });
        let columns = self.values.par_chunks_mut(warps).enumerate();
        columns.for_each(|(j, out)| {
            if cancel.is_cancelled() {
                return;
            }
            out.fill([0.0; 4]);
            let mut add_row = |weight: f32, j: usize| {
                for (sum, value) in out.iter_mut().zip(&rows_done[j * warps..(j + 1) * warps]) {
                    blend(sum, weight, *value);
                }
            };
            add_row(weights[0], j);
            for (d, &weight) in weights.iter().enumerate().skip(1) {
                add_row(weight, j.saturating_sub(d));
                add_row(weight, (j + d).min(wefts - 1));
            }
        });
    }

    /// Stretches every channel about its mean to the deviation in `wanted`, and clamps it.
    fn rescale(&mut self, wanted: [[f64; 2]; 4]) {
        let now = self.mean_and_deviation();
        let gain: [f32; 4] = std::array::from_fn(|c| {
            // A channel that a wide filter made constant, to f32 rounding, stays constant.
            if now[c][1] > 1e-6 {
                (wanted[c][1] / now[c][1]) as f32
            } else {
                1.0
            }
        });
        let mean = now.map(|[mean, _]| mean as f32);
        self.values.par_iter_mut().for_each(|value| {
            *value = std::array::from_fn(|c| {
                (mean[c] + gain[c] * (value[c] - mean[c])).clamp(-1.0, 1.0)
            });
        });
    }
}

/// Weights at 0, 1, 2 … cells from the centre; they add up to one over both sides. One weight alone is no filter.
fn kernel(filter: Filter, radius: f64) -> Vec<f32> {
    let weight = |d: usize| match filter {
        Filter::None => f64::from(u8::from(d == 0)),
        // A fraction of a cell weighs as much, so that the radius acts without jumps.
        Filter::Box => (radius + 1.0 - d as f64).clamp(0.0, 1.0),
        Filter::Gaussian if d == 0 => 1.0,
        // The radius is two deviations; three are kept, beyond which weights are below 1 %.
        Filter::Gaussian if d as f64 <= 1.5 * radius + 0.5 => {
            (-0.5 * (2.0 * d as f64 / radius).powi(2)).exp()
        }
        Filter::Gaussian => 0.0,
    };
    let weights: Vec<f64> = (0..)
        .map(weight)
        .take_while(|&weight| weight > 0.0)
        .collect();
    let sum = 2.0 * weights.iter().sum::<f64>() - weights[0];
    weights.iter().map(|weight| (weight / sum) as f32).collect()
}
