//! What the files of this folder draw samples with: the scene and what is made of it once.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use crate::geometry::{Camera, LoopFrame, Ray};
use crate::optics::Optics;
use crate::render::{RenderRequest, Settings};
use crate::scene::{Loops, Scene};

use super::skeleton::Yarns;
use super::walk::{self, Grid};

/// Draws samples of one request.
#[derive(Debug)]
pub struct Tracer {
    pub(super) scene: Arc<Scene>,
    pub(super) camera: Camera,
    pub(super) size: [u32; 2],
    pub(super) settings: Settings,
    pub(super) grid: Grid,
    /// The frame of each loop: every ray needs some, and most are needed by many.
    pub(super) frames: Arc<Vec<LoopFrame>>,
    pub(super) yarns: Option<Yarns>,
    pub(super) optics: Arc<Optics>,
    /// Extinction of the densest material, 1/mm.
    pub(super) densest_per_mm: f64,
    /// Share of looks at the environment that go to the other side of the ground.
    pub(super) looks_down: f64,
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
