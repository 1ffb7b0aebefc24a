//! Rays through bent cloth: from one of its tetrahedra to the next through the face they share, and across the air
//! between layers by the boxes around facets.
//!
//! Level cloth has one segment, the whole ray, and costs nothing more.

use glam::{DMat3, DVec3};

use super::tracer::Tracer;
use crate::geometry::Ray;
use crate::optics::Vertex;
use crate::scene::{FormMesh, KuhnTetrahedron, TetMap};
use crate::transport::Start;

/// Segments of one ray: far more than there are in any; rounding must not send a ray around an edge for ever.
const MOST_SEGMENTS: u32 = 1 << 16;
/// Boxes that wait to be looked into: three for each of up to 12 levels, and one.
const MOST_WAITING: usize = 48;

/// A part of a ray within which world and sheet differ by an affine map only.
#[derive(Debug, Clone, Copy)]
pub(super) struct RaySegment {
    /// The ray in sheet space; t = 0 is where the whole ray starts, as if the map were this one from there on.
    pub ray: Ray,
    /// The part, mm of the sheet.
    pub part: [f64; 2],
    /// World mm in a mm of the sheet along the ray.
    world_per_sheet: f64,
    /// Turns directions of the sheet to those of the world; the same for level cloth.
    world_from_sheet: Option<DMat3>,
}

impl RaySegment {
    /// A vertex found at a distance of this segment's ray, as one of the whole ray.
    #[inline(always)]
    pub fn place(&self, vertex: Vertex) -> Vertex {
        match self.world_from_sheet {
            Some(world_from_sheet) => Vertex {
                t: vertex.t * self.world_per_sheet,
                world_from_sheet,
                ..vertex
            },
            None => vertex,
        }
    }
}

/// The segments of a ray, front to back.
#[derive(Debug)]
pub(super) enum RaySegments<'a> {
    /// The ray, until it is taken.
    Level(Option<Ray>),
    Bent(BentSegments<'a>),
}

/// A ray's way through bent cloth.
#[derive(Debug)]
pub(super) struct BentSegments<'a> {
    mesh: &'a FormMesh,
    /// World.
    ray: Ray,
    /// How far it has come, mm of the world.
    t: f64,
    /// The tetrahedron it is in.
    inside: Option<([i64; 2], KuhnTetrahedron)>,
    steps_left: u32,
}

impl Tracer {
    /// The segments of a ray.
    #[inline(always)]
    pub(super) fn segments(&self, ray: &Ray, start: Start) -> RaySegments<'_> {
        match &*self.cloth.scene.form {
            Some(mesh) => RaySegments::Bent(BentSegments::new(mesh, ray, start)),
            None => RaySegments::Level(Some(*ray)),
        }
    }
}

impl Iterator for RaySegments<'_> {
    type Item = RaySegment;

    #[inline(always)]
    fn next(&mut self) -> Option<RaySegment> {
        match self {
            Self::Level(ray) => ray.take().map(|ray| RaySegment {
                ray,
                part: [0.0, f64::INFINITY],
                world_per_sheet: 1.0,
                world_from_sheet: None,
            }),
            Self::Bent(segments) => segments.next_segment(),
        }
    }
}

impl<'a> BentSegments<'a> {
    fn new(mesh: &'a FormMesh, ray: &Ray, start: Start) -> Self {
        let (origin, inside) = match start {
            Start::Eye => (ray.origin, mesh.holding(ray.origin)),
            Start::Cloth => {
                let (facet, coordinates) = mesh.cell_coordinates_of(ray.origin);
                let tetrahedron = FormMesh::tetrahedron_of(coordinates);
                (
                    mesh.tet(facet, tetrahedron).at(coordinates),
                    Some((facet, tetrahedron)),
                )
            }
        };
        Self {
            mesh,
            ray: Ray {
                origin,
                direction: ray.direction,
            },
            t: 0.0,
            inside,
            steps_left: MOST_SEGMENTS,
        }
    }

    #[inline(never)]
    fn next_segment(&mut self) -> Option<RaySegment> {
        while self.steps_left > 0 {
            self.steps_left -= 1;
            let (facet, tetrahedron) = match self.inside {
                Some(inside) => inside,
                None => {
                    let (t, facet, tetrahedron) = self.entry()?;
                    self.t = t;
                    (facet, tetrahedron)
                }
            };
            let map = self.mesh.tet(facet, tetrahedron);
            let coordinates_per_mm = map.per_coordinate.inverse();
            let origin = coordinates_per_mm * (self.ray.origin - map.origin);
            let slope = coordinates_per_mm * self.ray.direction;
            let (leaves, next) = exit(facet, tetrahedron, origin, slope);
            let from = self.t;
            self.t = leaves.max(from);
            self.inside = next.filter(|&(facet, _)| self.mesh.has(facet));
            if from < self.t {
                return Some(self.segment(facet, &map, origin, slope, from));
            }
        }
        None
    }

    fn segment(
        &self,
        facet: [i64; 2],
        map: &TetMap,
        origin: DVec3,
        slope: DVec3,
        from: f64,
    ) -> RaySegment {
        let direction = slope * self.mesh.facet_mm();
        let sheet_per_world = direction.length();
        RaySegment {
            ray: Ray {
                origin: self.mesh.sheet_of(facet, origin),
                direction: direction / sheet_per_world,
            },
            part: [from * sheet_per_world, self.t * sheet_per_world],
            world_per_sheet: 1.0 / sheet_per_world,
            world_from_sheet: Some(map.rotation()),
        }
    }

    /// Where the ray next comes into the cloth from outside.
    fn entry(&self) -> Option<(f64, [i64; 2], KuhnTetrahedron)> {
        let mesh = self.mesh;
        let inverse = 1.0 / self.ray.direction;
        let mut nearest = None;
        let mut nearest_t = f64::INFINITY;
        let top = mesh.levels.len() - 1;
        let mut waiting = [(0, [0_u32; 2]); MOST_WAITING];
        waiting[0] = (top, [0, 0]);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (level, [x, y]) = waiting[count];
            let [columns, _] = mesh.levels[level];
            let first = mesh.first_box(level) + (y * columns + x) as usize;
            let [low, high] = mesh.boxes[first].map(|c| DVec3::from_array(c.map(f64::from)));
            let a = (low - self.ray.origin) * inverse;
            let b = (high - self.ray.origin) * inverse;
            // NaN, of a ray in a face's plane, leaves the other number.
            let enters = a.min(b).max_element().max(self.t);
            let leaves = a.max(b).min_element();
            if !(enters <= leaves && enters < nearest_t) {
                continue;
            }
            if level > 0 {
                let [columns, rows] = mesh.levels[level - 1];
                for [i, j] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                    let child = [2 * x + i, 2 * y + j];
                    if child[0] < columns && child[1] < rows {
                        waiting[count] = (level - 1, child);
                        count += 1;
                    }
                }
                continue;
            }
            let facet = [i64::from(x), i64::from(y)];
            mesh.outer_faces(facet, |tetrahedron, corners, opposite| {
                if let Some(t) = self.meets(corners, opposite)
                    && self.t < t
                    && t < nearest_t
                {
                    (nearest, nearest_t) = (Some((t, facet, tetrahedron)), t);
                }
            });
        }
        nearest
    }

    /// Where the ray goes through a triangle towards the side on which `opposite` lies.
    fn meets(&self, corners: [DVec3; 3], opposite: DVec3) -> Option<f64> {
        let direction = self.ray.direction;
        let [a, b, c] = corners.map(|corner| corner - self.ray.origin);
        let normal = (b - a).cross(c - a);
        let speed = normal.dot(direction);
        if speed * normal.dot(opposite - corners[0]) <= 0.0 {
            return None;
        }
        // Volumes over the three sides: neighbouring triangles have the same of the side they share.
        let sides = [b.cross(a), c.cross(b), a.cross(c)].map(|side| side.dot(direction));
        let within = sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0);
        within.then(|| normal.dot(a) / speed)
    }
}

/// Where a ray leaves a tetrahedron, and into which it goes; `None` out of the cloth. `origin` and `slope` are
/// coordinates of the facet.
fn exit(
    facet: [i64; 2],
    [first, second, third]: KuhnTetrahedron,
    origin: DVec3,
    slope: DVec3,
) -> (f64, Option<([i64; 2], KuhnTetrahedron)>) {
    // What must stay above 0: 1 − s[first], s[first] − s[second], s[second] − s[third], s[third].
    let faces = [
        (1.0 - origin[first], -slope[first]),
        (origin[first] - origin[second], slope[first] - slope[second]),
        (origin[second] - origin[third], slope[second] - slope[third]),
        (origin[third], slope[third]),
    ];
    let (mut leaves, mut through) = (f64::INFINITY, 0);
    for (index, (value, slope)) in faces.into_iter().enumerate() {
        if slope < 0.0 && -value / slope < leaves {
            (leaves, through) = (-value / slope, index);
        }
    }
    let across = |axis: usize, step: i64, tetrahedron: KuhnTetrahedron| {
        (axis < 2).then(|| {
            let mut next = facet;
            next[axis] += step;
            (next, tetrahedron)
        })
    };
    let next = match through {
        0 => across(first, 1, [second, third, first]),
        1 => Some((facet, [second, first, third])),
        2 => Some((facet, [first, third, second])),
        _ => across(third, -1, [third, first, second]),
    };
    (leaves, next)
}
