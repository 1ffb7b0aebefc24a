//! The cloth as paths meet it: whatever the method, in f64.

use glam::DVec3;

use super::scratch::Scratch;
use super::tracer::Tracer;
use crate::design::Method;
use crate::geometry::Ray;
use crate::optics::Vertex;
use crate::render::accumulation::Sample;
use crate::sampling::Pcg;
use crate::transport::{Medium, PathInputs, PathTracer, Start};

impl Tracer {
    /// Sample `number` of `pixel` of the whole picture.
    pub fn sample(&self, pixel: [u32; 2], number: u32, scratch: &mut Scratch) -> Sample {
        PathTracer::new(self, pixel, number, scratch).sample(pixel)
    }
}

impl Medium for Tracer {
    type Scratch = Scratch;

    /// Hits are precise to 10⁻⁹ mm.
    const SURFACE_OFFSET_MM: f64 = 1e-6;

    const SKIPS_DARK_LIGHTS: bool = false;

    fn inputs(&self) -> PathInputs<'_> {
        PathInputs {
            scene: &self.scene,
            optics: &self.optics,
            camera: &self.camera,
            size: self.size,
            settings: &self.settings,
            looks_down: self.looks_down,
        }
    }

    fn first_event(
        &self,
        ray: &Ray,
        xi: f64,
        choice: f64,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        match self.settings.method {
            Method::Exact | Method::SixFace => self.marched_event(ray, xi, choice, scratch),
            _ => self.first_event(ray, xi, scratch),
        }
    }

    /// Rays of either start are in the world.
    fn collision(
        &self,
        ray: &Ray,
        _start: Start,
        pcg: &mut Pcg,
        scratch: &mut Scratch,
    ) -> Option<Vertex> {
        self.collision(ray, pcg, scratch)
    }

    /// All of it is in the world.
    fn leave(&self, vertex: &Vertex, direction: DVec3) -> Ray {
        let ray = vertex.leave(direction, Self::SURFACE_OFFSET_MM);
        match &*self.scene.form {
            Some(mesh) => Ray {
                origin: mesh.world_of(ray.origin),
                ..ray
            },
            None => ray,
        }
    }

    fn composited_visibility(&self, ray: &Ray, scratch: &mut Scratch) -> f64 {
        match self.settings.method {
            Method::Exact | Method::SixFace => self.marched_visibility(ray, scratch),
            _ => self.composited_visibility(ray, scratch),
        }
    }

    fn tracked_visibility(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Scratch) -> f64 {
        self.tracked_visibility(ray, pcg, scratch)
    }
}
