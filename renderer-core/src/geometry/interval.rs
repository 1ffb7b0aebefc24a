//! Closed intervals of a ray's parameter, and clipping: to a slab between two values, to a box.

use std::cmp::Ordering;

use glam::DVec3;

use super::Ray;

/// All t with `low` ≤ t ≤ `high`; empty where `low` > `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// From `low` to `high`.
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Whether it holds no value, or only one.
    pub fn is_empty(&self) -> bool {
        // NaN counts as empty.
        self.low.partial_cmp(&self.high) != Some(Ordering::Less)
    }

    /// Its length, 0 if it is empty.
    pub fn length(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }

    /// The value in its middle.
    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// What it shares with `other`.
    pub fn intersect(&self, other: Self) -> Self {
        Self {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }

    /// Whether it holds `value`; its ends belong to it.
    pub fn holds(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Whether it shares a value with `other`.
    pub fn overlaps(&self, other: Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }

    /// The part in which `value` + `slope`·t lies in `range`. A constant value keeps all or nothing.
    pub fn clip_linear(&self, value: f64, slope: f64, range: Self) -> Self {
        if slope == 0.0 {
            return if range.low <= value && value <= range.high {
                *self
            } else {
                Self::new(1.0, 0.0)
            };
        }
        let inverse = 1.0 / slope;
        let (a, b) = (
            (range.low - value) * inverse,
            (range.high - value) * inverse,
        );
        self.intersect(Self::new(a.min(b), a.max(b)))
    }
}

/// The part of `interval` in which the ray is inside the box from `low` to `high`.
pub fn clip_to_box(ray: &Ray, interval: Interval, low: DVec3, high: DVec3) -> Interval {
    (0..3).fold(interval, |interval, axis| {
        interval.clip_linear(
            ray.origin[axis],
            ray.direction[axis],
            Interval::new(low[axis], high[axis]),
        )
    })
}
