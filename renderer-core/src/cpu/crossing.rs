//! A ray's way through a loop for `single` and `layered` (MODEL.md §9), in f32: intervals, slabs, optical depth.
//!
//! `single`, the paper's §5.2: at a crossing (u₀, v₀, t₀) of the middle patch the ray is mapped linearly into the loop:
//! (u, v, w) = (u₀, v₀, 0) + τ·J⁻¹·direction, τ = t − t₀. Kept are the τ within the box, on this crossing's side of the middle
//! between two crossings, within √(h/(2|κ|)), and ahead of the ray's origin; the slabs of the layers cut them into pieces.
//! `layered`: every layer is a patch of its own, and each crossing of one a piece.

use glam::Vec3A;

use super::patch::{Patch, Root, Slopes, Span};
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

/// One layer's piece of a crossing.
struct Slab {
    /// u, v and w in its middle.
    place: [f32; 3],
    tau: f32,
    /// Its length along the ray, mm.
    length: f32,
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
    /// The crossings of the middle patch. The ray's point is `travelled` mm from its origin.
    #[inline]
    pub fn of_middle(
        patch: &Patch,
        thickness: f32,
        direction: Vec3A,
        travelled: f32,
        mut found: impl FnMut(Self),
    ) {
        let roots = patch.roots(direction, Vec3A::ZERO);
        let roots = roots.as_slice();
        if roots.is_empty() {
            return;
        }
        let normal = patch.normal();
        for (index, &root) in roots.iter().enumerate() {
            let slopes = patch.slopes(normal, thickness, direction, &root);
            let bent = (0.5 * thickness / slopes.bend.abs().max(1e-20)).sqrt();
            let reach = (0.5 / slopes.w.abs()).min(bent);
            let mut span = Span {
                low: (-reach).max(-root.t - travelled),
                high: reach,
            };
            if let [first, second] = *roots {
                let middle = 0.5 * (first.t + second.t) - root.t;
                if index == 0 {
                    span.high = span.high.min(middle);
                } else {
                    span.low = span.low.max(middle);
                }
            }
            let span = span
                .clip(root.u, slopes.u, 0.0, 1.0)
                .clip(root.v, slopes.v, 0.0, 1.0);
            if !span.is_empty() {
                found(Self {
                    root,
                    slopes,
                    span,
                    layer: None,
                });
            }
        }
    }

    /// The crossings of all layers' patches, and in `tests` how many were solved.
    pub fn of_layers(
        patch: &Patch,
        thickness: f32,
        layers: usize,
        direction: Vec3A,
        travelled: f32,
        mut found: impl FnMut(Self),
    ) {
        let normal = patch.normal();
        let count = layers as f32;
        for layer in 0..layers {
            let w = (layer as f32 + 0.5) / count - 0.5;
            let roots = patch.roots(direction, normal * (w * thickness));
            for &root in roots.as_slice() {
                let slopes = patch.slopes(normal, thickness, direction, &root);
                let reach = 0.5 / (count * slopes.w.abs());
                let span = Span {
                    low: (-reach).max(-root.t - travelled),
                    high: reach,
                };
                let span = span
                    .clip(root.u, slopes.u, 0.0, 1.0)
                    .clip(root.v, slopes.v, 0.0, 1.0);
                if !span.is_empty() {
                    found(Self {
                        root,
                        slopes,
                        span,
                        layer: Some(w),
                    });
                }
            }
        }
    }

    /// Distance from the ray's point, mm; negative behind it.
    pub fn t(&self) -> f32 {
        self.root.t
    }

    fn place(&self, tau: f32) -> [f32; 3] {
        [
            self.root.u + self.slopes.u * tau,
            self.root.v + self.slopes.v * tau,
            self.layer.unwrap_or(self.slopes.w * tau),
        ]
    }

    fn slab(&self, part: Span) -> Slab {
        Slab {
            place: self.place(part.middle()),
            tau: part.middle(),
            length: part.length(),
        }
    }

    /// Calls `visit` for the pieces of the crossing in `layers` layers, front to back.
    #[inline]
    fn for_each_slab(&self, layers: usize, mut visit: impl FnMut(Slab)) {
        if self.layer.is_some() {
            return visit(self.slab(self.span));
        }
        let count = layers as f32;
        let slope = self.slopes.w;
        let layer_at = |tau: f32| ((slope * tau + 0.5) * count).floor().clamp(0.0, count - 1.0);
        let (first, last) = (layer_at(self.span.low), layer_at(self.span.high));
        let pieces = (last - first).abs() as usize;
        // The edge where the ray leaves the first slab, and the way from one to the next.
        let way = 1.0 / (slope.abs() * count);
        let edge = if slope > 0.0 { first + 1.0 } else { first };
        let leaves = (edge / count - 0.5) / slope;
        let mut low = self.span.low;
        for piece in 0..=pieces {
            let high = if piece == pieces {
                self.span.high
            } else {
                self.span.high.min(leaves + piece as f32 * way)
            };
            if low < high {
                visit(self.slab(Span { low, high }));
                low = high;
            }
        }
    }

    /// Optical depth of the crossing.
    #[inline]
    pub fn optical_depth(&self, yarn: &Yarn<'_>, layers: usize, counters: &mut Counters) -> f32 {
        let mut sum = 0.0;
        self.for_each_slab(layers, |slab| {
            counters.volume_samples += 1;
            let [u, v, w] = slab.place;
            sum += yarn.rho(u, v, w) * slab.length;
        });
        sum * yarn.density
    }

    /// The mean over its slabs, weighted by what each takes from the ray.
    pub fn mean_point(&self, yarn: &Yarn<'_>, layers: usize) -> MeanPoint {
        let (mut transmittance, mut weight, mut tau, mut shade) = (1.0, 0.0, 0.0, 0.0);
        self.for_each_slab(layers, |slab| {
            let [u, v, w] = slab.place;
            let left = transmittance * (-yarn.density * yarn.rho(u, v, w) * slab.length).exp();
            let taken = transmittance - left;
            if taken > 0.0 {
                weight += taken;
                tau += taken * slab.tau;
                shade += taken * yarn.shade(slab.place);
                transmittance = left;
            }
        });
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
