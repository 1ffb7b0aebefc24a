//! `single`, the paper's §5.2: one crossing of a ray with a loop's middle patch stands for the ray's whole passage
//! through the loop (MODEL.md §9).
//!
//! At a crossing (u₀, v₀, t₀) the ray is mapped linearly into the loop: (u, v, w) = (u₀, v₀, 0) + τ·J⁻¹·direction,
//! τ = t − t₀. Kept is the interval of τ within the box, on this crossing's side of the middle between two
//! crossings, within √(h/(2|κ|)) (where the neglected quadratic part of w has grown to half a thickness at most), and
//! ahead of the ray's origin. The slabs of the volume's layers cut it into pieces, each sampled once in its middle.
//!
//! A ray that passes beside the middle patch misses the loop, even where it passes through the loop's volume: that is
//! the method's bias.

use super::tracer::Tracer;
use super::volume::{LoopVolume, VolumePoint};
use super::walk::LoopPlace;
use crate::geometry::tolerances::FLATTEST;
use crate::geometry::{Interval, LoopFrame, Ray, Root, Slopes};
use crate::render::Counters;

/// A ray's passage through a loop, as the crossing of the middle patch describes it.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    root: Root,
    slopes: Slopes,
    /// The τ that count, mm.
    interval: Interval,
}

/// One layer's piece of a crossing.
struct Slab {
    /// u, v and w in its middle.
    place: [f64; 3],
    /// τ in its middle, mm.
    tau: f64,
    /// Its length along the ray, mm.
    length: f64,
}

/// Where a crossing scatters: its opacity-weighted mean depth and shade.
pub struct MeanPoint {
    /// Distance from the ray's origin, mm.
    pub t: f64,
    /// u, v and w there.
    pub place: [f64; 3],
    /// Mean factor on the albedo.
    pub shade: f64,
}

impl Crossing {
    /// Distance at which the crossing is sorted among others, mm.
    pub fn t(&self) -> f64 {
        self.root.t.max(0.0)
    }

    fn place(&self, tau: f64) -> [f64; 3] {
        [
            self.root.u + self.slopes.u * tau,
            self.root.v + self.slopes.v * tau,
            self.slopes.w * tau,
        ]
    }

    /// The pieces of the crossing in `layers` layers, front to back.
    fn slabs(&self, layers: u32) -> impl Iterator<Item = Slab> {
        let count = f64::from(layers);
        let slope = self.slopes.w;
        let layer_at = |tau: f64| {
            ((slope * tau + 0.5) * count)
                .floor()
                .clamp(0.0, count - 1.0) as i64
        };
        let (first, last) = (layer_at(self.interval.low), layer_at(self.interval.high));
        let (step, pieces) = ((last - first).signum(), (last - first).abs());
        (0..=pieces).filter_map(move |piece| {
            let layer = (first + step * piece) as f64;
            let range = Interval::new(layer / count - 0.5, (layer + 1.0) / count - 0.5);
            let part = self.interval.clip_linear(0.0, slope, range);
            (!part.is_empty()).then(|| Slab {
                place: self.place(part.middle()),
                tau: part.middle(),
                length: part.length(),
            })
        })
    }

    /// Optical depth of the crossing.
    pub fn optical_depth(
        &self,
        volume: &LoopVolume<'_>,
        layers: u32,
        counters: &mut Counters,
    ) -> f64 {
        let mut depth = 0.0;
        for slab in self.slabs(layers) {
            counters.volume_samples += 1;
            depth += volume.density_per_mm * volume.at(slab.place).rho * slab.length;
        }
        depth
    }

    /// The mean over its slabs, weighted by what each takes from the ray.
    pub fn mean_point(&self, volume: &LoopVolume<'_>, layers: u32) -> MeanPoint {
        let (mut transmittance, mut weight, mut tau, mut shade) = (1.0, 0.0, 0.0, 0.0);
        for slab in self.slabs(layers) {
            let VolumePoint { rho, shade: factor } = volume.at(slab.place);
            let left = transmittance * (-volume.density_per_mm * rho * slab.length).exp();
            let taken = transmittance - left;
            weight += taken;
            tau += taken * slab.tau;
            shade += taken * factor;
            transmittance = left;
        }
        let tau = tau / weight;
        MeanPoint {
            t: self.root.t + tau,
            place: self.place(tau),
            shade: shade / weight,
        }
    }
}

impl Tracer {
    /// The crossings of a ray with the middle patch of a loop, with the loop's frame; `ray` is relative to the loop's
    /// cell.
    pub(super) fn for_each_crossing(
        &self,
        ray: &Ray,
        place: LoopPlace,
        counters: &mut Counters,
        mut found: impl FnMut(Crossing, &mut Counters),
    ) {
        counters.patch_tests += 1;
        let frame = self.frame(place);
        let roots = frame.patch.roots(ray);
        let roots = roots.as_slice();
        if roots.is_empty() {
            return;
        }
        for (index, &root) in roots.iter().enumerate() {
            let mut side = Interval::new(f64::NEG_INFINITY, f64::INFINITY);
            if let [first, second] = *roots {
                let middle = 0.5 * (first.t + second.t) - root.t;
                if index == 0 {
                    side.high = middle;
                } else {
                    side.low = middle;
                }
            }
            let crossing = crossing(frame, ray, root, side);
            if !crossing.interval.is_empty() {
                found(crossing, counters);
            }
        }
    }
}

/// The crossing at `root`, cut to the part with τ in `side`.
fn crossing(frame: &LoopFrame, ray: &Ray, root: Root, side: Interval) -> Crossing {
    let mut slopes = frame.slopes(root.u, root.v, ray.direction);
    if slopes.w.abs() < FLATTEST {
        slopes.w = FLATTEST.copysign(slopes.w);
    }
    let curvature = frame.lift * slopes.u * slopes.v;
    let reach = (0.5 / slopes.w.abs()).min((0.5 * frame.thickness / curvature.abs()).sqrt());
    let unit = Interval::new(0.0, 1.0);
    let interval = Interval::new((-reach).max(-root.t), reach)
        .intersect(side)
        .clip_linear(root.u, slopes.u, unit)
        .clip_linear(root.v, slopes.v, unit);
    Crossing {
        root,
        slopes,
        interval,
    }
}
