//! Rays through bent cloth: which straight segments of them go through the flat one.
//!
//! Plain: every tetrahedron of every facet whose box the ray meets is clipped against, and the parts are sorted. Level
//! cloth has one piece, the whole ray.

use glam::DMat3;

use super::skeleton::SkeletonHit;
use super::tracer::Tracer;
use super::walk::Span;
use crate::geometry::{Interval, Ray};
use crate::optics::Vertex;
use crate::scene::{FormMesh, KUHN_TETRAHEDRA};

/// A part of a ray within which world and sheet differ by an affine map only.
#[derive(Debug, Clone, Copy)]
pub(super) struct RaySegment {
    /// The ray in sheet space; t = 0 is where the whole ray starts, as if the map were this one from there on.
    pub ray: Ray,
    /// The part, mm of the sheet.
    pub part: Interval,
    /// World mm in a mm of the sheet along the ray.
    world_per_sheet: f64,
    /// Turns directions of the sheet to those of the world.
    world_from_sheet: DMat3,
}

impl RaySegment {
    /// A vertex found at a distance of this segment's ray, as one of the whole ray.
    pub fn place(&self, vertex: Vertex) -> Vertex {
        Vertex {
            t: vertex.t * self.world_per_sheet,
            world_from_sheet: self.world_from_sheet,
            ..vertex
        }
    }
}

impl Tracer {
    /// The segments of a ray in world space, in the order in which they begin.
    pub(super) fn segments(&self, ray: &Ray) -> Vec<RaySegment> {
        let whole = Interval::new(0.0, f64::INFINITY);
        let Some(mesh) = &*self.scene.form else {
            return vec![RaySegment {
                ray: *ray,
                part: whole,
                world_per_sheet: 1.0,
                world_from_sheet: DMat3::IDENTITY,
            }];
        };
        let mut segments = Vec::new();
        for facet in mesh.facets_along(ray) {
            segments.extend(
                (KUHN_TETRAHEDRA.iter())
                    .filter_map(|tetrahedron| segment(mesh, ray, facet, *tetrahedron)),
            );
        }
        let start = |segment: &RaySegment| segment.part.low * segment.world_per_sheet;
        segments.sort_by(|a, b| start(a).total_cmp(&start(b)));
        segments
    }

    /// The blocks along a ray in world space, segment by segment.
    pub(super) fn spans(&self, ray: &Ray) -> impl Iterator<Item = (RaySegment, Span)> {
        let segments = self.segments(ray).into_iter();
        segments.flat_map(|segment| {
            let spans = self.grid.walk_part(&segment.ray, segment.part);
            spans.map(move |span| (segment, span))
        })
    }

    /// A point of the skeleton that a segment meets.
    pub(super) fn ground_vertex(&self, segment: &RaySegment, hit: SkeletonHit) -> Vertex {
        segment.place(self.skeleton_vertex(&segment.ray, hit))
    }
}

/// The part of a ray in a tetrahedron.
fn segment(
    mesh: &FormMesh,
    ray: &Ray,
    facet: [i64; 2],
    tetrahedron: [usize; 3],
) -> Option<RaySegment> {
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
    let direction = slope * mesh.facet_mm();
    let sheet_per_world = direction.length();
    Some(RaySegment {
        ray: Ray {
            origin: mesh.sheet_of(facet, origin),
            direction: direction / sheet_per_world,
        },
        part: Interval::new(part.low * sheet_per_world, part.high * sheet_per_world),
        world_per_sheet: 1.0 / sheet_per_world,
        world_from_sheet: map.rotation(),
    })
}
