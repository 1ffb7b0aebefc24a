//! What draws samples of one request: the cloth, and what is skipped.

use std::sync::Arc;

use super::Instructions;
use super::cloth::Cloth;
use super::ground::GroundHit;
use super::scratch::Scratch;
use crate::design::Method;
use crate::geometry::{Camera, Ray};
use crate::render::bounced_light::{BouncedKey, BouncedLight};
use crate::render::shadow_cache::{ShadowCache, ShadowKey};
use crate::render::{Optimisation, RenderRequest, Settings};

/// Draws samples of one request.
#[derive(Debug)]
pub struct Tracer {
    pub(super) cloth: Cloth,
    pub(super) camera: Camera,
    pub(super) size: [u32; 2],
    pub(super) settings: Settings,
    pub(super) instructions: Instructions,
    pub(super) skips_empty: bool,
    pub(super) remembers_tests: bool,
    pub(super) ends_opaque_rays: bool,
    pub(super) weighs_candidates: bool,
    pub(super) tracks_last_looks: bool,
    /// What earlier samples, and pictures of the same cloth in the same light, know of shadows.
    pub(super) shadow_cache: Option<Arc<ShadowCache>>,
    /// What they know of light that goes on where paths are cut off.
    pub(super) bounced_light: Option<Arc<BouncedLight>>,
}

impl Tracer {
    /// Prepares for `request`; what `last` derived from parts of its scene that did not change is kept.
    pub(super) fn new(
        request: &RenderRequest,
        instructions: Instructions,
        last: Option<&Self>,
    ) -> Self {
        let settings = request.settings;
        let optimisations = settings.optimisations;
        let kept = last.and_then(|last| last.shadow_cache.as_ref());
        let shadow_cache = ShadowKey::new(request).map(|key| match kept {
            Some(kept) if kept.key().is_same(&key) && !kept.is_crowded() => Arc::clone(kept),
            _ => Arc::new(ShadowCache::new(key)),
        });
        let kept = last.and_then(|last| last.bounced_light.as_ref());
        let bounced_light = BouncedKey::new(request).map(|key| match kept {
            Some(kept) if kept.key().is_same(&key) => Arc::clone(kept),
            _ => Arc::new(BouncedLight::new(key)),
        });
        Self {
            cloth: Cloth::new(request.scene(), last.map(|last| &last.cloth)),
            camera: *request.camera(),
            size: request.size,
            settings,
            instructions,
            skips_empty: optimisations.has(Optimisation::EmptyCells),
            remembers_tests: optimisations.has(Optimisation::RepeatedTests),
            ends_opaque_rays: optimisations.has(Optimisation::OpaqueRays),
            tracks_last_looks: settings.method == Method::Tracked
                && optimisations.has(Optimisation::LastLooks),
            // With more scatterings most of the noise, and of the time, is theirs.
            weighs_candidates: settings.method == Method::Tracked
                && settings.path_cutoff().unwrap_or(settings.bounces) == 1
                && optimisations.has(Optimisation::WeighedEvents),
            shadow_cache,
            bounced_light,
        }
    }

    /// The cache that shadows of sample `number` of a pixel may come from.
    #[inline(always)]
    pub(super) fn shadow_cache(&self, number: u32) -> Option<&ShadowCache> {
        let cache = self.shadow_cache.as_deref();
        cache.filter(|_| self.settings.caches_shadows(number))
    }

    /// Lets later samples know what the first `samples` have learned of shadows and of light that goes on.
    pub(super) fn learn_light(&self, samples: u32) {
        if let Some(cache) = self.shadow_cache(samples) {
            cache.finalise();
        }
        if let Some(bounced) = &self.bounced_light
            && self.settings.caches_shadows(samples - 1)
        {
            bounced.finalise();
        }
    }

    /// Bytes of what is held beside the scene.
    pub(super) fn held_bytes(&self) -> u64 {
        self.cloth.bytes()
            + self.shadow_cache.as_ref().map_or(0, |cache| cache.bytes())
            + self.bounced_light.as_ref().map_or(0, |light| light.bytes())
    }

    /// The part of a ray, out of `part`, in the box around loops and ground.
    pub(super) fn part_in_cloth(&self, ray: &Ray, part: [f64; 2]) -> [f64; 2] {
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
    pub(super) fn ground_layer(&self, ray: &Ray, part: [f64; 2]) -> [f64; 2] {
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
    pub(super) fn ground_hit(&self, ray: &Ray, part: [f64; 2]) -> Option<GroundHit> {
        let ground = self.cloth.ground.as_ref()?;
        if part[0] < part[1] {
            ground.hit(&self.cloth.grid, ray, part)
        } else {
            None
        }
    }

    /// Whether a part of a shadow ray meets the ground. Rays that go down seldom get past it, and looking for it is
    /// cheap.
    #[inline(always)]
    pub(super) fn is_blocked_by_ground(
        &self,
        ray: &Ray,
        part: [f64; 2],
        scratch: &mut Scratch,
    ) -> bool {
        let layer = self.ground_layer(ray, part);
        let blocked = self.ground_hit(ray, layer).is_some();
        scratch.counters.hidden_rays += u64::from(blocked);
        blocked
    }
}
