//! A ray's way through a loop for `single` and `layered` (MODEL.md §9), in f32: intervals, slabs, optical depth.
//!
//! `single`, the paper's §5.2: at a crossing (u₀, v₀, t₀) of the middle patch the ray is mapped linearly into the loop:
//! (u, v, w) = (u₀, v₀, 0) + τ·J⁻¹·direction, τ = t − t₀. Kept are the τ within the box, on this crossing's side of the
//! middle between two crossings, within √(h/(2|κ|)), and ahead of the ray's origin; the slabs of the layers cut them
//! into pieces. `layered`: every layer is a patch of its own, and each crossing of one a piece.

use glam::Vec3A;

use super::lanes::Lanes;
use super::patch::{Patch, Root, Roots, Slopes, Span};
use super::volume::Yarn;
use crate::render::Counters;

/// A ray's way through a loop, or through one layer of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    root: Root,
    slopes: Slopes,
    /// The τ that count, mm.
    span: Span,
    /// w at the root; of a layer's crossing all of w.
    layer: Option<f32>,
}

/// Where a crossing scatters: its opacity-weighted mean depth and shade.
pub(super) struct MeanPoint {
    /// Distance from the ray's point, mm.
    pub t: f32,
    /// u, v and w there.
    pub place: [f32; 3],
    /// Mean factor on the albedo.
    pub shade: f32,
}

impl Crossing {
    /// Crossing number `which` of the middle patch; `None` where none of the ray is left of it. The ray's point is
    /// `travelled` mm from its origin.
    #[inline(always)]
    pub fn of_middle(
        patch: &Patch,
        normal: Vec3A,
        thickness: f32,
        direction: Vec3A,
        travelled: f32,
        roots: &Roots,
        which: usize,
    ) -> Option<Self> {
        let root = roots.as_slice()[which];
        let slopes = patch.slopes(normal, thickness, direction, &root);
        let bent = (0.5 * thickness / slopes.bend.abs().max(1e-20)).sqrt();
        let reach = (0.5 / slopes.w.abs()).min(bent);
        let mut span = Span {
            low: (-reach).max(-root.t - travelled),
            high: reach,
        };
        if let [first, second] = *roots.as_slice() {
            let middle = 0.5 * (first.t + second.t) - root.t;
            if which == 0 {
                span.high = span.high.min(middle);
            } else {
                span.low = span.low.max(middle);
            }
        }
        let span = span
            .clip(root.u, slopes.u, 0.0, 1.0)
            .clip(root.v, slopes.v, 0.0, 1.0);
        (!span.is_empty()).then_some(Self {
            root,
            slopes,
            span,
            layer: None,
        })
    }

    /// The crossing at `root` of the patch of the layer whose middle is at `w`, one of `layers`.
    #[inline(always)]
    pub fn of_layer(
        patch: &Patch,
        normal: Vec3A,
        thickness: f32,
        direction: Vec3A,
        travelled: f32,
        root: Root,
        [w, layers]: [f32; 2],
    ) -> Option<Self> {
        let slopes = patch.slopes(normal, thickness, direction, &root);
        let reach = 0.5 / (layers * slopes.w.abs());
        let span = Span {
            low: (-reach).max(-root.t - travelled),
            high: reach,
        };
        let span = span
            .clip(root.u, slopes.u, 0.0, 1.0)
            .clip(root.v, slopes.v, 0.0, 1.0);
        (!span.is_empty()).then_some(Self {
            root,
            slopes,
            span,
            layer: Some(w),
        })
    }

    /// Distance from the ray's point, mm; negative behind it.
    #[inline(always)]
    pub fn t(&self) -> f32 {
        self.root.t
    }

    #[inline(always)]
    fn place(&self, tau: f32) -> [f32; 3] {
        [
            self.root.u + self.slopes.u * tau,
            self.root.v + self.slopes.v * tau,
            self.layer.unwrap_or(self.slopes.w * tau),
        ]
    }

    /// The pieces of the crossing in `layers` layers, front to back.
    #[inline(always)]
    fn slabs(&self, layers: usize) -> Slabs {
        if self.layer.is_some() {
            return Slabs {
                low: self.span.low,
                high: self.span.high,
                leaves: self.span.high,
                way: 0.0,
                left: 1,
            };
        }
        let count = layers as f32;
        let slope = self.slopes.w;
        let first = self.layer_at(self.span.low, count);
        let last = self.layer_at(self.span.high, count);
        // The edge where the ray leaves the first slab, and the way from one to the next.
        let edge = if slope > 0.0 { first + 1.0 } else { first };
        Slabs {
            low: self.span.low,
            high: self.span.high,
            leaves: (edge / count - 0.5) / slope,
            way: 1.0 / (slope.abs() * count),
            left: (last - first).abs() as usize + 1,
        }
    }

    #[inline(always)]
    fn layer_at(&self, tau: f32, count: f32) -> f32 {
        ((self.slopes.w * tau + 0.5) * count)
            .floor()
            .clamp(0.0, count - 1.0)
    }

    /// Optical depth of the crossing.
    #[inline(always)]
    pub fn optical_depth<L: Lanes>(
        &self,
        yarn: &Yarn<'_>,
        layers: usize,
        counters: &mut Counters,
    ) -> f32 {
        let mut sum = 0.0;
        for part in self.slabs(layers) {
            counters.volume_samples += 1;
            sum += yarn.rho::<L>(self.place(part.middle())) * part.length();
        }
        sum * yarn.density
    }

    /// The mean over its slabs, weighted by what each takes from the ray.
    #[inline(always)]
    pub fn mean_point<L: Lanes>(&self, yarn: &Yarn<'_>, layers: usize) -> MeanPoint {
        let (mut transmittance, mut weight, mut tau, mut shade) = (1.0, 0.0, 0.0, 0.0);
        for part in self.slabs(layers) {
            let place = self.place(part.middle());
            // Not as a difference of transmittances: thin pile would have none of its digits left.
            let depth = yarn.density * yarn.rho::<L>(place) * part.length();
            let taken = transmittance * -(-depth).exp_m1();
            if taken > 0.0 {
                weight += taken;
                tau += taken * part.middle();
                shade += taken * yarn.shade(place);
                transmittance -= taken;
            }
        }
        if weight <= 0.0 {
            // So thin that f32 sees no difference: its middle.
            (weight, tau) = (1.0, self.span.middle());
            shade = yarn.shade(self.place(tau));
        }
        let tau = tau / weight;
        MeanPoint {
            t: self.root.t + tau,
            place: self.place(tau),
            shade: shade / weight,
        }
    }
}

/// Iterator over the pieces of a crossing.
struct Slabs {
    low: f32,
    high: f32,
    leaves: f32,
    way: f32,
    left: usize,
}

impl Iterator for Slabs {
    type Item = Span;

    #[inline(always)]
    fn next(&mut self) -> Option<Span> {
        while self.left > 0 {
            self.left -= 1;
            let high = if self.left == 0 {
                self.high
            } else {
                self.high.min(self.leaves)
            };
            let part = Span {
                low: self.low,
                high,
            };
            self.leaves += self.way;
            if !part.is_empty() {
                self.low = high;
                return Some(part);
            }
        }
        None
    }
}
