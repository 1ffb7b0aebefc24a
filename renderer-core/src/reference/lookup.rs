//! From the scene's records to what rays meet: patches, frames, volumes, yarns, and the points that scatter.

use glam::{DMat3, DVec3};

use super::skeleton::SkeletonHit;
use super::tracer::Tracer;
use super::volume::LoopVolume;
use super::walk::{BlockLoops, LoopPlace, Span};
use crate::design::{Phase, SkeletonShading};
use crate::geometry::{Interval, LoopFrame, Ray};
use crate::optics::{Lobe, Vertex};

impl Tracer {
    /// World position of the origin of coordinates of a loop planted in `cell`.
    pub(super) fn cell_origin(&self, [i, j]: [i64; 2]) -> DVec3 {
        let [x, y] = self.scene.sheet.cell_centre(i, j);
        DVec3::new(x, y, 0.0)
    }

    /// The skeleton in one block.
    pub(super) fn skeleton_hit(&self, ray: &Ray, block: &Span) -> Option<SkeletonHit> {
        let yarns = self.yarns.as_ref()?;
        let height = yarns.height();
        if !block.heights(ray).overlaps(Interval::new(-height, height)) {
            return None;
        }
        let mut cells = self.grid.walk_cells(ray, block);
        cells.find_map(|span| yarns.hit(&self.grid, ray, &span, self.cell_origin(span.index)))
    }

    /// The loops listed in a block.
    pub(super) fn loops_in(&self, block: [i64; 2]) -> BlockLoops<'_> {
        BlockLoops::new(&self.scene.loops, block)
    }

    /// A loop's frame, relative to its own cell.
    pub(super) fn frame(&self, place: LoopPlace) -> &LoopFrame {
        &self.frames[place.index]
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
        let frame = self.frame(place);
        let look = self.scene.looks[place.index];
        let material = usize::from(look.material);
        let lobe = match self.optics.phase(material) {
            Phase::Isotropic => Lobe::Isotropic,
            Phase::FrameLambert => Lobe::Frame {
                normal: frame.normal,
                material,
            },
            Phase::KajiyaKay => {
                let tangent = self.volume(place).tangent(inside);
                let [along_u, along_v, along_w] = frame.jacobian(inside[0], inside[1]);
                let world = along_u * tangent.x + along_v * tangent.y + along_w * tangent.z;
                Lobe::Fibre {
                    tangent: world.normalize_or(frame.normal),
                    material,
                }
            }
            Phase::GradientLambert => {
                let slopes = self.volume(place).slopes(inside);
                let gradient = frame.gradient(inside[0], inside[1], slopes);
                Lobe::gradient(gradient, frame.thickness, material)
            }
        };
        let albedo = DVec3::from_array(look.albedo());
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
            world_from_sheet: DMat3::IDENTITY,
        }
    }

    /// A point of the skeleton as a scatterer.
    pub(super) fn skeleton_vertex(&self, ray: &Ray, hit: SkeletonHit) -> Vertex {
        Vertex {
            position: ray.at(hit.t),
            t: hit.t,
            normal: hit.normal,
            albedo: DVec3::from_array(self.scene.skeleton.albedo.map(f64::from)),
            lobe: match self.scene.skeleton.shading {
                SkeletonShading::Phong => Lobe::Phong(hit.normal),
                SkeletonShading::PoulinFournier if hit.along != DVec3::ZERO => Lobe::Fibres {
                    normal: hit.normal,
                    along: hit.along,
                },
                // Fibres met end on have no direction.
                SkeletonShading::Lambert | SkeletonShading::PoulinFournier => {
                    Lobe::Surface(hit.normal)
                }
            },
            world_from_sheet: DMat3::IDENTITY,
        }
    }
}
