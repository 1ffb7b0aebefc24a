//! The fast renderer on all processor cores, for machines without a GPU: `single`, `layered` and `tracked` in f32, held to
//! [`mod@crate::reference`] by the same samples and the same means.
//!
//! ```text
//! path ──► form: stretches ──► composite (single, layered) or tracked ──► walk over blocks ──► block: listed loops ──► patch, frames
//!            │                                          └──► ground: cells of the weave
//!            └──► crossing: slabs ──► volume: voxels
//! ```
//!
//! What makes it fast: coordinates relative to the block a ray is in, so that f32 is enough; 16-byte shapes decoded where they
//! are needed instead of frames in memory; loops solved once a ray; ground yarns looked for only in their layer; voxels
//! stored by fours. Everything that is left out has a name in [`crate::render::Optimisation`].

mod backend;
mod batch;
mod block;
mod cloth;
mod composite;
mod crossing;
mod form;
mod frames;
mod ground;
mod lanes;
mod mailbox;
mod patch;
mod path;
mod tracked;
mod vertex;
mod volume;
mod walk;
mod wide;

use std::sync::Arc;

use crate::geometry::Camera;
use crate::geometry::Ray;
use crate::render::accumulation::Sample;
use crate::render::shadow_cache::{ShadowCache, ShadowKey};
use crate::render::{Counters, Optimisation, RenderRequest, Settings};

pub use backend::CpuBackend;
pub use wide::Instructions;

/// Draws samples of one request.
#[derive(Debug)]
struct Tracer {
    cloth: cloth::Cloth,
    camera: Camera,
    size: [u32; 2],
    settings: Settings,
    instructions: Instructions,
    skips_empty: bool,
    remembers_tests: bool,
    ends_opaque_rays: bool,
    /// What earlier samples, and pictures of the same cloth in the same light, know of shadows.
    shadow_cache: Option<Arc<ShadowCache>>,
}

/// Memory that rays reuse, one for each thread, and what they counted.
#[derive(Debug, Default)]
struct Scratch {
    counters: Counters,
    mailbox: mailbox::Mailbox,
    /// Events of blocks to come, the nearest last.
    pending: Vec<composite::Event>,
    /// The frames that a ray may be in, within a block.
    along: Vec<frames::Frames>,
    overlaps: Vec<tracked::Overlap>,
}

impl AsMut<Counters> for Scratch {
    fn as_mut(&mut self) -> &mut Counters {
        &mut self.counters
    }
}

impl Tracer {
    /// Prepares for `request`; what `last` derived from parts of its scene that did not change is kept.
    fn new(request: &RenderRequest, instructions: Instructions, last: Option<&Self>) -> Self {
        let settings = request.settings;
        let optimisations = settings.optimisations;
        let kept = last.and_then(|last| last.shadow_cache.as_ref());
        let shadow_cache = ShadowKey::new(request).map(|key| match kept {
            Some(kept) if kept.key().is_same(&key) => Arc::clone(kept),
            _ => Arc::new(ShadowCache::new(key)),
        });
        Self {
            cloth: cloth::Cloth::new(request.scene(), last.map(|last| &last.cloth)),
            camera: *request.camera(),
            size: request.size,
            settings,
            instructions,
            skips_empty: optimisations.has(Optimisation::EmptyCells),
            remembers_tests: optimisations.has(Optimisation::RepeatedTests),
            ends_opaque_rays: optimisations.has(Optimisation::OpaqueRays),
            shadow_cache,
        }
    }

    /// The cache that shadows of sample `number` of a pixel may come from.
    #[inline(always)]
    fn shadow_cache(&self, number: u32) -> Option<&ShadowCache> {
        let cache = self.shadow_cache.as_deref();
        cache.filter(|_| self.settings.caches_shadows(number))
    }

    /// Lets later samples know the shadows of the first `samples`.
    fn learn_shadows(&self, samples: u32) {
        if let Some(cache) = self.shadow_cache(samples) {
            cache.settle();
        }
    }

    /// Bytes of what is held beside the scene.
    fn bytes(&self) -> u64 {
        self.cloth.bytes() + self.shadow_cache.as_ref().map_or(0, |cache| cache.bytes())
    }

    /// Sample `number` of `pixel` of the whole picture.
    fn sample(&self, pixel: [u32; 2], number: u32, scratch: &mut Scratch) -> Sample {
        wide::sample(self, pixel, number, scratch)
    }

    /// The same in eight lanes of `L`, in the instructions of whoever it is inlined into.
    #[inline(always)]
    fn sample_here<L: lanes::Lanes>(
        &self,
        pixel: [u32; 2],
        number: u32,
        scratch: &mut Scratch,
    ) -> Sample {
        path::PathTracer::new(self, pixel, number, scratch).sample::<L>(pixel)
    }

    /// The part of a ray, out of `part`, in the box around loops and ground.
    fn part_in_cloth(&self, ray: &Ray, part: [f64; 2]) -> [f64; 2] {
        let grid = &self.cloth.grid;
        let ground = self
            .cloth
            .ground
            .as_ref()
            .map_or(0.0, |ground| ground.height);
        let [low, high] = grid.loop_heights;
        grid.clip_blocks(ray, part, [low.min(-ground), high.max(ground)])
    }

    /// The part of a ray, out of `part`, in the layer that ground yarns are in; empty if there are none.
    #[inline(always)]
    fn ground_layer(&self, ray: &Ray, part: [f64; 2]) -> [f64; 2] {
        match &self.cloth.ground {
            Some(ground) => {
                let heights = [-ground.height, ground.height];
                self.cloth.grid.clip_heights(ray, part[0], part[1], heights)
            }
            None => [f64::INFINITY; 2],
        }
    }

    /// Where a ray meets the ground in a part of it that is in the ground's layer.
    #[inline(always)]
    fn ground_hit(&self, ray: &Ray, part: [f64; 2]) -> Option<ground::GroundHit> {
        let ground = self.cloth.ground.as_ref()?;
        if part[0] < part[1] {
            ground.hit(&self.cloth.grid, ray, part)
        } else {
            None
        }
    }

    /// Whether a part of a shadow ray meets the ground. Rays that go down seldom get past it, and looking for it is cheap.
    #[inline(always)]
    fn is_blocked_by_ground(&self, ray: &Ray, part: [f64; 2], scratch: &mut Scratch) -> bool {
        let layer = self.ground_layer(ray, part);
        let blocked = self.ground_hit(ray, layer).is_some();
        scratch.counters.hidden_rays += u64::from(blocked);
        blocked
    }
}
