//! Paths: from a camera ray to radiance (MODEL.md §8 and §9; the paper's §6, step 6).
//!
//! The method decides how the first point that scatters is found and how light reaches it. There the suns (and for
//! `single` and `layered` the environment) are sampled with one shadow ray each.

use glam::{DVec2, DVec3};

use super::{Lobe, LoopPlace, Scratch, SkeletonHit, Tracer, Vertex};
use crate::design::Phase;
use crate::geometry::{BilinearPatch, LoopFrame, Ray};
use crate::render::accumulation::{FirstHit, Sample};
use crate::sampling::{self, Set, directions};

use super::volume::LoopVolume;
use super::walk::{CellLoops, patch_of};

/// One path in the making.
pub(super) struct PathTracer<'a> {
    tracer: &'a Tracer,
    scratch: &'a mut Scratch,
    pixel: [u32; 2],
    seed: u32,
    number: u32,
}

impl<'a> PathTracer<'a> {
    pub(super) fn new(
        tracer: &'a Tracer,
        pixel: [u32; 2],
        number: u32,
        scratch: &'a mut Scratch,
    ) -> Self {
        Self {
            tracer,
            scratch,
            pixel,
            seed: sampling::pixel_seed(tracer.settings.seed, pixel),
            number,
        }
    }

    fn random(&self, set: Set) -> [f64; 4] {
        sampling::sample(self.seed, self.number, set).map(f64::from)
    }

    /// The radiance along the camera's ray, and what it met first.
    pub(super) fn sample(mut self) -> Sample {
        let tracer = self.tracer;
        let [x, y, pick, _] = self.random(Set::Film);
        let [column, row] = self.pixel.map(f64::from);
        let ray = tracer.camera_ray(DVec2::new(column + x, row + y));
        let Some(first) = tracer.first_event(&ray, 1.0 - pick, self.scratch) else {
            return Sample {
                radiance: DVec3::from_array(tracer.scene.lights.background),
                first: None,
            };
        };
        Sample {
            radiance: self.radiance_from(&first, -ray.direction),
            first: Some(FirstHit {
                depth_mm: first.t,
                normal: first.normal,
                albedo: first.albedo,
            }),
        }
    }

    /// Radiance that leaves `vertex` towards `view`.
    fn radiance_from(&mut self, vertex: &Vertex, view: DVec3) -> DVec3 {
        (self.sunlight(vertex, view, 1) + self.skylight(vertex, view, 1)) * vertex.albedo
    }

    /// Light of the suns scattered towards `view`, but for the albedo.
    fn sunlight(&mut self, vertex: &Vertex, view: DVec3, bounce: u32) -> DVec3 {
        let tracer = self.tracer;
        let mut light = DVec3::ZERO;
        for (sun, number) in tracer.scene.lights.suns.iter().zip(0..) {
            let [u, v, ..] = self.random(Set::Sun {
                bounce,
                sun: number,
            });
            let centre = DVec3::from_array(sun.direction);
            let direction = directions::cone(centre, sun.angular_radius, u, v);
            let value = tracer.optics.value(vertex.lobe, view, direction);
            if value > 0.0 {
                let visibility =
                    tracer.composited_visibility(&vertex.leave(direction), self.scratch);
                light += DVec3::from_array(sun.irradiance) * (value * visibility);
            }
        }
        light
    }

    /// Light of the environment scattered towards `view`, but for the albedo, by one shadow ray.
    fn skylight(&mut self, vertex: &Vertex, view: DVec3, bounce: u32) -> DVec3 {
        let tracer = self.tracer;
        let radiance = DVec3::from_array(tracer.scene.lights.environment);
        if radiance == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let [u, v, ..] = self.random(Set::Environment { bounce });
        let (direction, weight) = tracer.optics.sample(vertex.lobe, view, [u, v]);
        let visibility = tracer.composited_visibility(&vertex.leave(direction), self.scratch);
        radiance * (weight * visibility)
    }
}

impl Tracer {
    /// The loops listed in a cell.
    pub(super) fn loops_in(&self, cell: [i64; 2]) -> CellLoops<'_> {
        CellLoops::new(&self.scene.sheet, &self.scene.loops, cell)
    }

    /// A loop's patch, relative to its own cell.
    pub(super) fn patch(&self, place: LoopPlace) -> BilinearPatch {
        let loops = &self.scene.loops;
        patch_of(&loops.shapes[place.index], loops.base_width_mm)
    }

    /// The frame about a loop's patch.
    pub(super) fn frame(&self, patch: BilinearPatch) -> LoopFrame {
        LoopFrame::new(patch, f64::from(self.scene.loops.thickness_mm))
    }

    /// A loop's volume.
    pub(super) fn volume(&self, place: LoopPlace) -> LoopVolume<'_> {
        let look = self.scene.looks[place.index];
        LoopVolume::new(&self.scene.volumes, &self.scene.pile, look)
    }

    /// The point of a loop at distance `t` of `ray` and at (u, v, w) inside the loop, as a scatterer.
    pub(super) fn loop_vertex(
        &self,
        ray: &Ray,
        place: LoopPlace,
        t: f64,
        inside: [f64; 3],
        shade: f64,
    ) -> Vertex {
        let frame = self.frame(self.patch(place));
        let lobe = match self.optics.phase() {
            Phase::Isotropic => Lobe::Isotropic,
            Phase::FrameLambert => Lobe::Frame(frame.normal),
            Phase::KajiyaKay => {
                let tangent = self.volume(place).tangent(inside);
                let [along_u, along_v, along_w] = frame.jacobian(inside[0], inside[1]);
                let world = along_u * tangent.x + along_v * tangent.y + along_w * tangent.z;
                Lobe::Fibre(world.normalize_or(frame.normal))
            }
        };
        let albedo = DVec3::from_array(self.scene.looks[place.index].albedo());
        Vertex {
            position: ray.at(t),
            t,
            normal: if frame.normal.dot(ray.direction) > 0.0 {
                -frame.normal
            } else {
                frame.normal
            },
            albedo: albedo * shade,
            lobe,
        }
    }

    /// A point of the skeleton as a scatterer.
    pub(super) fn skeleton_vertex(&self, ray: &Ray, hit: SkeletonHit) -> Vertex {
        Vertex {
            position: ray.at(hit.t),
            t: hit.t,
            normal: hit.normal,
            albedo: DVec3::from_array(self.scene.skeleton.albedo.map(f64::from)),
            lobe: Lobe::Surface(hit.normal),
        }
    }
}
