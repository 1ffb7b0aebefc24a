//! The plain renderer: scalar f64, written from the model's equations (MODEL.md §5 to §9); what the others are held to.
//!
//! §6 of the paper (Yi Wang, "A Layered Method for Realistic Rendering of Towels and Carpets") has six steps. Steps 1
//! and 2, skeleton and loop frames, are [`crate::scene`]'s. For each ray:
//!
//! - step 3, reflection of the yarn loops the ray crosses: `single` and `layered` find the crossings of a loop, `exact`
//!   and `six_face` its parts inside the loop; [`crate::optics`] says how the chosen point scatters;
//! - step 4, transmission through the loops: `first_event` composites crossings front to back, and shadow rays
//!   multiply what they let through; `march` does both piece by piece, `tracked` with random free paths instead;
//! - step 5, the skeleton and the loops on its other side, seen through its gaps: `skeleton`, and the one grid
//!   walk (`walk`) over loops of both faces;
//! - step 6, the sum of all these: [`PathTracer`](crate::transport::PathTracer), which meets the cloth by `medium`.
//!
//! Cloth that is bent is met segment by segment: `form`. Frames of loops are made once, and nothing is skipped beyond
//! what the blocks' lists say of where loops are and, for `tracked`, the part of a ray that can be in a loop, so that
//! it stays plain.

mod backend;
mod exact;
mod first_event;
mod form;
mod layered;
mod lookup;
mod march;
mod medium;
mod single;
mod six_face;
mod skeleton;
mod tracked;
mod volume;
mod walk;

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use crate::geometry::{Camera, Interval, LoopFrame, Ray};
use crate::optics::Optics;
use crate::render::{Counters, RenderRequest, Settings};
use crate::scene::{Loops, Scene};

pub use backend::ReferenceBackend;
pub use skeleton::{SkeletonHit, Yarns};
pub use walk::{Grid, LoopPlace, Span};

/// Draws samples of one request.
#[derive(Debug)]
pub struct Tracer {
    scene: Arc<Scene>,
    camera: Camera,
    size: [u32; 2],
    settings: Settings,
    grid: Grid,
    /// The frame of each loop: every ray needs some, and most are needed by many.
    frames: Arc<Vec<LoopFrame>>,
    yarns: Option<Yarns>,
    optics: Arc<Optics>,
    /// Extinction of the densest material, 1/mm.
    densest_per_mm: f64,
    /// Share of looks at the environment that go to the other side of the ground.
    looks_down: f64,
}

/// Memory that rays reuse, one for each thread, and what they counted.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Work done since it was last taken.
    pub counters: Counters,
    events: Vec<first_event::Event>,
    overlaps: Vec<tracked::Overlap>,
    along: Vec<(LoopPlace, Interval)>,
    met: march::Met,
}

impl AsMut<Counters> for Scratch {
    fn as_mut(&mut self) -> &mut Counters {
        &mut self.counters
    }
}

impl Tracer {
    /// Prepares for `request`.
    pub fn new(request: &RenderRequest) -> Self {
        let frames = Arc::new(frames(&request.scene().loops));
        let optics = Optics::new(&request.scene().pile, &request.scene().skeleton);
        Self::with(request, frames, Arc::new(optics))
    }

    /// Prepares for another request; frames are kept if the loops are the same, phase functions if
    /// pile and skeleton are.
    pub fn again(&self, request: &RenderRequest) -> Self {
        let frames = if request.scene().loops == self.scene.loops {
            Arc::clone(&self.frames)
        } else {
            Arc::new(frames(&request.scene().loops))
        };
        let (new, old) = (request.scene(), &self.scene);
        let optics = if new.pile == old.pile && new.skeleton == old.skeleton {
            Arc::clone(&self.optics)
        } else {
            Arc::new(Optics::new(&new.pile, &new.skeleton))
        };
        Self::with(request, frames, optics)
    }

    fn with(request: &RenderRequest, frames: Arc<Vec<LoopFrame>>, optics: Arc<Optics>) -> Self {
        let scene = Arc::clone(request.scene());
        let yarns = scene
            .skeleton
            .visible
            .then(|| Yarns::new(&scene.sheet, &scene.skeleton));
        let materials = scene.pile.materials.iter();
        let densest = materials.fold(0.0, |d: f64, m| d.max(f64::from(m.density_per_mm)));
        Self {
            camera: *request.camera(),
            size: request.size,
            settings: request.settings,
            grid: Grid::new(
                &scene.sheet,
                &scene.loops,
                yarns.as_ref().map(Yarns::height),
            ),
            frames,
            optics,
            densest_per_mm: densest,
            looks_down: f64::from(scene.skeleton.worth_looking_down(&scene.sheet)),
            yarns,
            scene,
        }
    }

    /// The camera's ray through `point`, in pixels from the top left.
    pub fn camera_ray(&self, point: DVec2) -> Ray {
        let (origin, direction) = self.camera.ray(point, self.size);
        Ray { origin, direction }
    }

    /// Bytes of the frames of all loops, which are made from the scene's shapes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&**self.frames) as u64
    }

    /// The grid of blocks.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

/// The frames of all loops, each relative to its own cell.
fn frames(loops: &Loops) -> Vec<LoopFrame> {
    let thickness = f64::from(loops.thickness_mm);
    let frame = |index| {
        let patch = walk::patch_of(&loops.patch(index), loops.base_width_mm);
        LoopFrame::new(patch, thickness)
    };
    (0..loops.shapes.len()).into_par_iter().map(frame).collect()
}
