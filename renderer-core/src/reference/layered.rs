//! `layered`: each layer of a loop's volume is a patch of its own, the middle patch moved along n̂ (MODEL.md §9).
//!
//! Every crossing of a layer's patch is an event at its own distance. Its slab is as long as the ray needs, with the
//! slope w′ of the crossing, through one layer's thickness, cut to u and v in [0, 1] and to what lies ahead of the
//! ray's origin. This keeps the rays that pass beside the middle patch, which `single` loses.

use super::tracer::Tracer;
use super::volume::LoopVolume;
use super::walk::LoopPlace;
use crate::geometry::tolerances::FLATTEST;
use crate::geometry::{Interval, PatchLine, Ray, Root};
use crate::render::Counters;

/// A ray's passage through one layer.
#[derive(Debug, Clone, Copy)]
pub struct LayerCrossing {
    root: Root,
    /// u, v and w in the middle of the slab.
    place: [f64; 3],
    /// The slab's part of the ray, mm from the crossing.
    interval: Interval,
}

impl LayerCrossing {
    /// Distance at which the crossing is sorted among others, mm.
    pub fn t(&self) -> f64 {
        self.root.t.max(0.0)
    }

    /// Distance of the slab's middle, mm.
    pub fn t_middle(&self) -> f64 {
        self.root.t + self.interval.middle()
    }

    /// u, v and w in the slab's middle.
    pub fn place(&self) -> [f64; 3] {
        self.place
    }

    /// Optical depth of the slab.
    pub fn optical_depth(&self, volume: &LoopVolume<'_>, counters: &mut Counters) -> f64 {
        counters.volume_samples += 1;
        volume.density_per_mm * volume.at(self.place).rho * self.interval.length()
    }
}

impl Tracer {
    /// The crossings of a ray with the layers of a loop; `ray` is relative to the loop's cell.
    pub(super) fn for_each_layer(
        &self,
        ray: &Ray,
        place: LoopPlace,
        counters: &mut Counters,
        mut found: impl FnMut(LayerCrossing, &mut Counters),
    ) {
        let frame = self.frame(place);
        let count = f64::from(self.scene.volumes.layers);
        let unit = Interval::new(0.0, 1.0);
        let line = PatchLine::new(&frame.patch, ray);
        for layer in 0..self.scene.volumes.layers {
            let w = (f64::from(layer) + 0.5) / count - 0.5;
            let offset = frame.normal * (w * frame.thickness);
            counters.patch_tests += 1;
            for &root in line.roots(offset).as_slice() {
                let slopes = frame.slopes(root.u, root.v, ray.direction);
                let reach = 0.5 / (count * slopes.w.abs().max(FLATTEST));
                let interval = Interval::new((-reach).max(-root.t), reach)
                    .clip_linear(root.u, slopes.u, unit)
                    .clip_linear(root.v, slopes.v, unit);
                if interval.is_empty() {
                    continue;
                }
                let middle = interval.middle();
                let crossing = LayerCrossing {
                    root,
                    place: [root.u + slopes.u * middle, root.v + slopes.v * middle, w],
                    interval,
                };
                found(crossing, counters);
            }
        }
    }
}
