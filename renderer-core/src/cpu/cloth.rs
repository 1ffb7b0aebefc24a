//! A scene as rays of the fast renderer meet it: what it derives from the scene's sections, kept as long as they are.

use std::sync::Arc;

use glam::{Vec2, Vec3A};

use super::ground::Ground;
use super::patch::Patch;
use super::volume::{VoxelTable, Yarn};
use super::walk::Grid;
use crate::optics::Optics;
use crate::scene::{LoopShape, Scene};

/// Free paths that may end in a frame, from which on it is worth looking where in it there is yarn.
const WORTH_LOOKING: f32 = 6.0;

/// The cloth and its light.
#[derive(Debug, Clone)]
pub(super) struct Cloth {
    pub scene: Arc<Scene>,
    pub grid: Grid,
    /// The ground weave, if it is drawn.
    pub ground: Option<Arc<Ground>>,
    pub optics: Arc<Optics>,
    /// Share of looks at the environment that go to the other side of the ground.
    pub looks_down: f64,
    /// Extinction of the densest material, 1/mm.
    pub densest: f32,
    /// The way through a loop's frame from which on it is worth looking where in it there is yarn, mm.
    pub worth_looking_mm: f32,
    pub thickness: f32,
    /// Size of a cell, mm.
    pub pitch: Vec2,
    /// Blocks in a millimetre.
    pub blocks_per_mm: Vec2,
    /// Unit of loops' shapes, and width of their roots, mm.
    pub length_unit: f32,
    pub base_width: f32,
    voxels: Arc<VoxelTable>,
}

impl Cloth {
    /// Prepares a scene; what `last` has of the same sections is kept.
    pub fn new(scene: &Arc<Scene>, last: Option<&Self>) -> Self {
        let kept = |same: fn(&Scene, &Scene) -> bool| last.filter(|last| same(&last.scene, scene));
        let grid = Grid::new(&scene.sheet, &scene.loops);
        let ground = match kept(|a, b| a.skeleton == b.skeleton && a.sheet == b.sheet) {
            Some(last) => last.ground.clone(),
            None => (scene.skeleton.visible)
                .then(|| Arc::new(Ground::new(&scene.sheet, &scene.skeleton))),
        };
        let voxels = match kept(|a, b| a.volumes == b.volumes && a.pile == b.pile) {
            Some(last) => Arc::clone(&last.voxels),
            None => Arc::new(VoxelTable::new(&scene.volumes, &scene.pile)),
        };
        let optics = match kept(|a, b| a.pile == b.pile && a.skeleton == b.skeleton) {
            Some(last) => Arc::clone(&last.optics),
            None => Arc::new(Optics::new(&scene.pile, &scene.skeleton)),
        };
        let densities = scene.pile.materials.iter().map(|m| m.density_per_mm);
        let densest = densities.fold(0.0, f32::max);
        Self {
            looks_down: f64::from(scene.skeleton.worth_looking_down(&scene.sheet)),
            densest,
            worth_looking_mm: WORTH_LOOKING / densest,
            thickness: scene.loops.thickness_mm,
            pitch: grid.pitch().as_vec2(),
            blocks_per_mm: (1.0 / (grid.pitch() * grid.block_cells as f64)).as_vec2(),
            length_unit: scene.loops.length_unit_mm,
            base_width: scene.loops.base_width_mm,
            scene: Arc::clone(scene),
            grid,
            ground,
            optics,
            voxels,
        }
    }

    /// The patch of a loop whose cell's centre is at `cell`, seen from `point`.
    #[inline(always)]
    pub fn patch(&self, index: u32, [x, y]: [f32; 2], point: Vec3A) -> Patch {
        let LoopShape {
            axis,
            root_z0,
            half_top,
            root_z1,
        } = self.scene.loops.shapes[index as usize];
        let unit = self.length_unit;
        let vector = |units: [i16; 3]| Vec3A::from_array(units.map(f32::from)) * unit;
        let (axis, half_top) = (vector(axis), vector(half_top));
        let (z0, z1) = (f32::from(root_z0) * unit, f32::from(root_z1) * unit);
        let half_base = Vec3A::new(0.0, 0.5 * self.base_width, 0.5 * (z1 - z0));
        let root = Vec3A::new(0.0, 0.0, 0.5 * (z0 + z1));
        Patch {
            middle: Vec3A::new(x, y, 0.0) - point + root + axis * 0.5,
            along_u: half_base + half_top,
            along_v: axis,
            twist: (half_top - half_base) * 2.0,
        }
    }

    /// The volume of a loop.
    #[inline(always)]
    pub fn yarn(&self, index: u32) -> Yarn<'_> {
        self.voxels.yarn(self.scene.looks[index as usize])
    }

    /// Whether long ways through a loop's frame are mostly air, and it may be asked where.
    #[inline(always)]
    pub fn is_sparse(&self) -> bool {
        self.voxels.is_sparse()
    }

    /// Layers of the volumes.
    pub fn layers(&self) -> usize {
        self.voxels.layers()
    }

    /// Bytes of what is derived from the scene.
    pub fn bytes(&self) -> u64 {
        self.voxels.bytes()
    }
}
