//! Rays through bent cloth: which straight pieces of them go through the flat one.
//!
//! Plain: every tetrahedron of every facet whose box the ray meets is clipped against, and the parts are sorted. Level cloth has
//! one piece, the whole ray.

use glam::{DMat3, DVec3};

use super::{SkeletonHit, Span, Tracer};
use crate::geometry::{Interval, Ray};
use crate::optics::Vertex;
use crate::scene::{FormMesh, KUHN_TETRAHEDRA};

/// A part of a ray within which world and sheet differ by an affine map only.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    /// The ray in sheet space; t = 0 is where the whole ray starts, told as if the map were this one all the way.
    pub ray: Ray,
    /// The part, mm of the sheet.
    pub part: Interval,
    /// World mm in a mm of the sheet along the ray.
    world_per_sheet: f64,
    /// Turns directions of the sheet to those of the world.
    world_from_sheet: DMat3,
}

impl Stretch {
    /// A vertex found at a distance of this stretch's ray, as one of the whole ray.
    pub fn place(&self, vertex: Vertex) -> Vertex {
        Vertex {
            t: vertex.t * self.world_per_sheet,
            world_from_sheet: self.world_from_sheet,
            ..vertex
        }
    }
}

impl Tracer {
    /// The stretches of a ray in world space, in the order in which they begin.
    pub(super) fn stretches(&self, ray: &Ray) -> Vec<Stretch> {
        let whole = Interval::new(0.0, f64::INFINITY);
        let Some(mesh) = &*self.scene.form else {
            return vec![Stretch {
                ray: *ray,
                part: whole,
                world_per_sheet: 1.0,
                world_from_sheet: DMat3::IDENTITY,
            }];
        };
        let mut stretches = Vec::new();
        for facet in mesh.facets_along(ray) {
            stretches.extend(
                (KUHN_TETRAHEDRA.iter())
                    .filter_map(|tetrahedron| stretch(mesh, ray, facet, *tetrahedron)),
            );
        }
        let start = |stretch: &Stretch| stretch.part.low * stretch.world_per_sheet;
        stretches.sort_by(|a, b| start(a).total_cmp(&start(b)));
        stretches
    }

    /// The blocks along a ray in world space, stretch by stretch.
    pub(super) fn spans(&self, ray: &Ray) -> impl Iterator<Item = (Stretch, Span)> {
        let stretches = self.stretches(ray).into_iter();
        stretches.flat_map(|stretch| {
            let spans = self.grid.walk_part(&stretch.ray, stretch.part);
            spans.map(move |span| (stretch, span))
        })
    }

    /// A point of the skeleton that a stretch meets.
    pub(super) fn ground_vertex(&self, stretch: &Stretch, hit: SkeletonHit) -> Vertex {
        stretch.place(self.skeleton_vertex(&stretch.ray, hit))
    }

    /// How the directions of a vertex of bent cloth are turned into the world's.
    pub(super) fn turn_of(&self, vertex: &Vertex) -> Option<DMat3> {
        (self.scene.form.is_some()).then_some(vertex.world_from_sheet)
    }

    /// The ray in world space that leaves a vertex towards a direction of the sheet.
    pub(super) fn leave(&self, vertex: &Vertex, direction: DVec3, offset_mm: f64) -> Ray {
        let ray = vertex.leave(direction, offset_mm);
        match &*self.scene.form {
            Some(mesh) => Ray {
                origin: mesh.world_of(ray.origin),
                ..ray
            },
            None => ray,
        }
    }
}

/// The part of a ray in a tetrahedron.
fn stretch(
    mesh: &FormMesh,
    ray: &Ray,
    facet: [i64; 2],
    tetrahedron: [usize; 3],
) -> Option<Stretch> {
    let map = mesh.tet(facet, tetrahedron);
    let coordinates_per_mm = map.per_coordinate.inverse();
    let origin = coordinates_per_mm * (ray.origin - map.origin);
    let slope = coordinates_per_mm * ray.direction;
    // 1 ≥ s[first] ≥ s[second] ≥ s[third] ≥ 0.
    let [first, second, third] = tetrahedron;
    let not_negative = Interval::new(0.0, f64::INFINITY);
    let part = not_negative
        .clip_linear(1.0 - origin[first], -slope[first], not_negative)
        .clip_linear(
            origin[first] - origin[second],
            slope[first] - slope[second],
            not_negative,
        )
        .clip_linear(
            origin[second] - origin[third],
            slope[second] - slope[third],
            not_negative,
        )
        .clip_linear(origin[third], slope[third], not_negative);
    if part.is_empty() {
        return None;
    }
    let way = slope * mesh.facet_mm();
    let sheet_per_world = way.length();
    Some(Stretch {
        ray: Ray {
            origin: mesh.sheet_of(facet, origin),
            direction: way / sheet_per_world,
        },
        part: Interval::new(part.low * sheet_per_world, part.high * sheet_per_world),
        world_per_sheet: 1.0 / sheet_per_world,
        world_from_sheet: map.rotation(),
    })
}
