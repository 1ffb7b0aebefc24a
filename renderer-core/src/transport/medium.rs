//! What a path asks of the cloth it goes through.

use glam::{DVec3, Vec3A};

use crate::geometry::{Camera, Ray};
use crate::optics::{Optics, Vertex};
use crate::render::bounced_light::BouncedLight;
use crate::render::shadow_cache::ShadowCache;
use crate::render::{Counters, Settings};
use crate::sampling::Pcg;
use crate::scene::Scene;

/// Where a ray starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At the camera, somewhere in the world.
    Eye,
    /// At a vertex, as [`Medium::leave`] made it.
    Cloth,
}

/// What a path needs to know beside the medium.
#[derive(Debug, Clone, Copy)]
pub struct PathInputs<'a> {
    /// The cloth and its lights.
    pub scene: &'a Scene,
    /// How its points scatter.
    pub optics: &'a Optics,
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// How it is drawn.
    pub settings: &'a Settings,
    /// Share of looks at the environment that go to the other side of the ground.
    pub looks_down: f64,
}

/// A point of a loop's volume.
#[derive(Debug, Clone, Copy)]
pub struct LoopPlace {
    /// Index of the loop.
    pub index: u32,
    /// u, v and w of the point.
    pub inside: [f32; 3],
    /// How u, v and w change along x, y and z, 1/mm.
    pub gradients: [Vec3A; 3],
}

/// A point at which some of what comes along a ray scatters.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// The point.
    pub vertex: Vertex,
    /// How much of all that comes along the ray.
    pub share: f64,
    /// Where it lies in its loop, for one of the pile that others compete with.
    pub place: Option<LoopPlace>,
}

/// Most candidates of a ray.
pub const MOST_CANDIDATES: usize = 8;

/// Cloth as rays meet it.
pub trait Medium {
    /// Memory that rays reuse, and what they counted.
    type Scratch: AsMut<Counters>;

    /// Distance from a surface at which rays leave it, mm: above the precision of its hits, far below any yarn.
    const SURFACE_OFFSET_MM: f64;

    /// Whether no shadow ray is followed to where no light comes from, as from an area light's back or a black part of
    /// the sky; else those alone are left out whose light would not be scattered.
    const SKIPS_DARK_LIGHTS: bool;

    /// What the path needs to know beside.
    fn inputs(&self) -> PathInputs<'_>;

    /// What earlier samples know of shadows, if sample `number` of a pixel may use it.
    #[inline(always)]
    fn shadow_cache(&self, _number: u32) -> Option<&ShadowCache> {
        None
    }

    /// What earlier samples know of the light that goes on where paths are cut off.
    #[inline(always)]
    fn bounced_light(&self) -> Option<&BouncedLight> {
        None
    }

    /// The point at which the transmittance along a camera ray falls below `xi`, by all methods but `tracked`; where
    /// several loops are met at once, `choice` in [0, 1) picks one. The point counts with weight 1.
    fn first_event(
        &self,
        ray: &Ray,
        xi: f64,
        choice: f64,
        scratch: &mut Self::Scratch,
    ) -> Option<Vertex>;

    /// Where a random free path ends; `None` if it leaves the cloth.
    fn collision(
        &self,
        ray: &Ray,
        start: Start,
        pcg: &mut Pcg,
        scratch: &mut Self::Scratch,
    ) -> Option<Vertex>;

    /// Whether the last ray of a path by `tracked`, which only looks for the environment, is followed as a shadow ray.
    #[inline(always)]
    fn tracks_last_looks(&self) -> bool {
        false
    }

    /// Whether camera rays have several candidates.
    #[inline(always)]
    fn weighs_candidates(&self) -> bool {
        false
    }

    /// Adds points at which a camera ray may scatter to `points`, at most [`MOST_CANDIDATES`], in their order along it;
    /// what share of the ray leaves the cloth. Shares are random, each with the right mean.
    fn candidates(
        &self,
        _ray: &Ray,
        _pcg: &mut Pcg,
        _points: &mut Vec<Candidate>,
        _scratch: &mut Self::Scratch,
    ) -> f64 {
        1.0
    }

    /// Room for candidates that is kept from ray to ray.
    fn room(&self, _scratch: &mut Self::Scratch) -> Vec<Candidate> {
        Vec::new()
    }

    /// Gives that room back.
    fn keep_room(&self, _points: Vec<Candidate>, _scratch: &mut Self::Scratch) {}

    /// About what share of the light from a direction of the sheet comes through a candidate's own loop.
    #[inline(always)]
    fn own_transmittance(&self, _point: &Candidate, _direction: DVec3) -> f64 {
        1.0
    }

    /// The ray that leaves a vertex towards a direction of the sheet. Its own direction is one of the world.
    fn leave(&self, vertex: &Vertex, direction: DVec3) -> Ray;

    /// Share of light that comes through along a ray that left a vertex, found as [`Self::first_event`] finds its
    /// point.
    fn composited_visibility(&self, ray: &Ray, scratch: &mut Self::Scratch) -> f64;

    /// Share of light that comes through along a ray that left a vertex: random, with the right mean.
    fn tracked_visibility(&self, ray: &Ray, pcg: &mut Pcg, scratch: &mut Self::Scratch) -> f64;
}
