//! Points that scatter: of a loop, of the ground.

use glam::{DMat3, DVec3, Vec3A};

use super::event::Event;
use super::ground::GroundHit;
use super::lanes::Lanes;
use super::patch::Patch;
use super::tracer::Tracer;
use crate::design::{Phase, SkeletonShading};
use crate::geometry::Ray;
use crate::optics::{Lobe, Vertex};

impl Tracer {
    /// The point at which an event scatters; the ray came to the cloth `start` mm from its origin.
    #[inline(always)]
    pub(super) fn event_vertex<L: Lanes>(&self, ray: &Ray, event: &Event, start: f64) -> Vertex {
        let cloth = &self.cloth;
        let mean = event
            .crossing
            .mean_point::<L>(&cloth.yarn(event.index), cloth.layers());
        // The crossing counts from the beginning of the block that found it.
        let t = start + f64::from(event.found_from) + f64::from(mean.t);
        self.loop_vertex::<L>(ray, event.index, t, mean.place, mean.shade)
    }

    /// The point of a loop at distance `t` of `ray` and at (u, v, w) inside the loop.
    #[inline(always)]
    pub(super) fn loop_vertex<L: Lanes>(
        &self,
        ray: &Ray,
        index: u32,
        t: f64,
        place: [f32; 3],
        shade: f32,
    ) -> Vertex {
        let cloth = &self.cloth;
        let patch = cloth.patch(index, [0.0; 2], Vec3A::ZERO);
        let normal = patch.normal().as_dvec3();
        let look = cloth.scene.looks[index as usize];
        let material = usize::from(look.material);
        let lobe = match cloth.optics.phase(material) {
            Phase::Isotropic => Lobe::Isotropic,
            Phase::FrameLambert => Lobe::Frame { normal, material },
            Phase::KajiyaKay => {
                let tangent = cloth.yarn(index).tangent(place);
                let [u, v, w] = jacobian(&patch, normal, self.cloth.thickness, place);
                let world = u * tangent.x + v * tangent.y + w * tangent.z;
                Lobe::Fibre {
                    tangent: world.normalize_or(normal),
                    material,
                }
            }
            Phase::GradientLambert => {
                let slopes = cloth.yarn(index).slopes::<L>(place);
                let [u, v, w] = jacobian(&patch, normal, self.cloth.thickness, place);
                // J⁻ᵀ times the slopes.
                let gradient =
                    (v.cross(w) * slopes.x + w.cross(u) * slopes.y + u.cross(v) * slopes.z)
                        / u.cross(v).dot(w);
                Lobe::gradient(gradient, f64::from(cloth.thickness), material)
            }
        };
        self.pile_vertex(ray, index, t, normal, shade, lobe)
    }

    /// A point of a loop at distance `t` of `ray`, with the unit normal of the loop's patch, that scatters as `lobe` and the
    /// share `shade` of its albedo.
    #[inline(always)]
    pub(super) fn pile_vertex(
        &self,
        ray: &Ray,
        index: u32,
        t: f64,
        normal: DVec3,
        shade: f32,
        lobe: Lobe,
    ) -> Vertex {
        let look = self.cloth.scene.looks[index as usize];
        Vertex {
            position: ray.at(t),
            t,
            normal: if normal.dot(ray.direction) > 0.0 {
                -normal
            } else {
                normal
            },
            albedo: DVec3::from_array(look.albedo()) * f64::from(shade),
            lobe,
            world_from_sheet: DMat3::IDENTITY,
        }
    }

    /// A point of the ground as a scatterer.
    #[inline(always)]
    pub(super) fn ground_vertex(&self, ray: &Ray, hit: &GroundHit) -> Vertex {
        let skeleton = &self.cloth.scene.skeleton;
        Vertex {
            position: ray.at(hit.t),
            t: hit.t,
            normal: hit.normal,
            albedo: DVec3::from_array(skeleton.albedo.map(f64::from)),
            lobe: match skeleton.shading {
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

/// ∂X/∂u, ∂X/∂v and ∂X/∂w.
#[inline(always)]
fn jacobian(patch: &Patch, normal: DVec3, thickness: f32, [u, v, _]: [f32; 3]) -> [DVec3; 3] {
    [
        (patch.along_u + patch.twist * (v - 0.5)).as_dvec3(),
        (patch.along_v + patch.twist * (u - 0.5)).as_dvec3(),
        normal * f64::from(thickness),
    ]
}
