//! The cloth as paths meet it, in lanes of one kind.

use std::marker::PhantomData;

use glam::DVec3;

use super::lanes::Lanes;
use super::{Scratch, Tracer};
use crate::geometry::Ray;
use crate::optics::Vertex;
use crate::render::accumulation::Sample;
use crate::render::bounced_light::BouncedLight;
use crate::render::shadow_cache::ShadowCache;
use crate::sampling::Pcg;
use crate::transport::{Candidate, Medium, PathInputs, PathTracer, Start};

/// A tracer that computes in lanes `L`.
struct InLanes<'a, L> {
    tracer: &'a Tracer,
    lanes: PhantomData<L>,
}

impl Tracer {
    /// Sample `number` of `pixel`, in eight lanes of `L` and in the instructions of whoever it is inlined into.
    #[inline(always)]
    pub(super) fn sample_in<L: Lanes>(
        &self,
        pixel: [u32; 2],
        number: u32,
        scratch: &mut Scratch,
    ) -> Sample {
        let medium = InLanes::<L> {
            tracer: self,
            lanes: PhantomData,
        };
        PathTracer::new(&medium, pixel, number, scratch).sample(pixel)
    }
}

impl<L: Lanes> Medium for InLanes<'_, L> {
    type Scratch = Scratch;

    const SURFACE_OFFSET_MM: f64 = 2e-6;

    const SKIPS_DARK_LIGHTS: bool = true;

    #[inline(always)]
    fn inputs(&self) -> PathInputs<'_> {
        let tracer = self.tracer;
        PathInputs {
            scene: &tracer.cloth.scene,
            optics: &tracer.cloth.optics,
            camera: &tracer.camera,
            size: tracer.size,
            settings: &tracer.settings,
            looks_down: tracer.cloth.looks_down,
        }
    }

    #[inline(always)]
    fn shadow_cache(&self, number: u32) -> Option<&ShadowCache> {
        self.tracer.shadow_cache(number)
    }

    #[inline(always)]
    fn bounced_light(&self) -> Option<&BouncedLight> {
        self.tracer.bounced_light.as_deref()
    }

    #[inline(always)]
    fn first_event(
        &self,
        ray: &Ray,
        xi: f64,
        _choice: f64,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        self.tracer.first_event::<L>(ray, xi, scratch)
    }

    #[inline(always)]
    fn collision(
        &self,
        ray: &Ray,
        start: Start,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        self.tracer.collision::<L>(ray, start, pcg, scratch)
    }

    #[inline(always)]
    fn tracks_last_looks(&self) -> bool {
        self.tracer.tracks_last_looks
    }

    #[inline(always)]
    fn weighs_candidates(&self) -> bool {
        self.tracer.weighs_candidates
    }

    #[inline(always)]
    fn candidates(
        &self,
        ray: &Ray,
        pcg: &mut Pcg,
        points: &mut Vec<Candidate>,
        scratch: &mut Scratch,
    ) -> f64 {
        self.tracer.candidates::<L>(ray, pcg, points, scratch)
    }

    #[inline(always)]
    fn room(&self, scratch: &mut Scratch) -> Vec<Candidate> {
        std::mem::take(&mut scratch.candidates)
    }

    #[inline(always)]
    fn keep_room(&self, points: Vec<Candidate>, scratch: &mut Scratch) {
        scratch.candidates = points;
    }

    #[inline(always)]
    fn own_transmittance(&self, point: &Candidate, direction: DVec3) -> f64 {
        match &point.place {
            Some(place) => self
                .tracer
                .own_transmittance::<L>(place, direction.as_vec3a()),
            None => 1.0,
        }
    }

    /// Its origin is one of the sheet.
    #[inline(always)]
    fn leave(&self, vertex: &Vertex, direction: DVec3) -> Ray {
        vertex.leave(direction, Self::SURFACE_OFFSET_MM)
    }

    #[inline(always)]
    fn composited_visibility(&self, ray: &Ray, scratch: &mut Scratch) -> f64 {
        self.tracer.composited_visibility::<L>(ray, scratch)
    }

    #[inline(always)]
    fn tracked_visibility(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Scratch) -> f64 {
        self.tracer.tracked_visibility::<L>(ray, pcg, scratch)
    }
}
