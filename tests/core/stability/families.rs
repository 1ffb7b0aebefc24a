//! Families of patches and rays that are hard on a solver.

use std::f32::consts::TAU;

use glam::{DVec3, Mat3, Vec2, Vec3};

use crate::support::patches::{Case, PITCH, Random};

/// One family, and what of it may be left out; the words are those of `patches`.
pub struct Family {
    pub name: &'static str,
    pub case: fn(&mut Random) -> Case,
    /// Largest share of cases that are not clear.
    pub unclear: f64,
    /// Largest shares of crossings that are folded, and narrow.
    pub folded: f64,
    pub narrow: f64,
    /// How many roundings a crossing may lie off the ray.
    pub off_ray: f64,
}

/// Rays that run along the surface where they meet it: rounding moves them along it as well.
const ALONG: f64 = 256.0;

/// All of them. The shares are what was found, rounded up.
pub const FAMILIES: [Family; 14] = [
    family("ordinary", ordinary, [0.005, 0.005, 0.45], 1.0),
    family("grazing", grazing, [0.8, 0.32, 0.85], ALONG),
    family("planar", planar, [0.005, 0.005, 0.4], 1.0),
    family("nearly planar", nearly_planar, [0.005, 0.005, 0.4], 1.0),
    family("twisted up to folding", twisted, [0.005, 0.015, 0.55], 1.0),
    family("slivers", slivers, [0.03, 0.04, 0.9], 1.0),
    family(
        "coincident corners",
        coincident,
        [0.015, 0.045, 0.75],
        ALONG,
    ),
    family("in the patch's plane", in_plane, [0.45, 0.0, 0.0], 1.0),
    family("touching the patch", touching, [1.0, 0.0, 0.0], ALONG),
    family("through edges", edges, [1.0, 0.0, 0.0], 1.0),
    family("through corners", corners, [1.0, 0.0, 0.0], 1.0),
    family(
        "along edges and lines",
        along_lines,
        [0.7, 0.05, 1.0],
        ALONG,
    ),
    family("huge and tiny", scaled, [0.005, 0.01, 0.45], 1.0),
    family("far cells", far_cells, [0.065, 0.025, 0.4], 1.0),
];

const fn family(
    name: &'static str,
    case: fn(&mut Random) -> Case,
    [unclear, folded, narrow]: [f64; 3],
    off_ray: f64,
) -> Family {
    Family {
        name,
        case,
        unclear,
        folded,
        narrow,
        off_ray,
    }
}

/// The edges of a patch.
#[derive(Clone, Copy)]
pub struct Edges {
    half_base: Vec3,
    axis: Vec3,
    half_top: Vec3,
    middle: Vec3,
}

impl Edges {
    /// The point P(u, v).
    fn at(&self, u: f32, v: f32) -> Vec3 {
        let across = self.half_base + (self.half_top - self.half_base) * v;
        self.middle + self.axis * v + across * (2.0 * u - 1.0)
    }

    /// ∂P/∂u and ∂P/∂v.
    fn tangents(&self, u: f32, v: f32) -> [Vec3; 2] {
        let spread = self.half_top - self.half_base;
        [
            (self.half_base + spread * v) * 2.0,
            self.axis + spread * (2.0 * u - 1.0),
        ]
    }

    /// A ray through a point, from a distance.
    pub fn through(self, target: Vec3, direction: Vec3, distance: f32) -> Case {
        Case {
            half_base: self.half_base,
            axis: self.axis,
            half_top: self.half_top,
            middle: self.middle,
            origin: target - direction * distance,
            direction,
            cell: [0; 2],
        }
    }
}

/// A loop some mm in size, as compile makes them: base about along y, axis leaning, top edge turned and stretched.
pub fn loop_edges(random: &mut Random) -> Edges {
    let half_base = Vec3::new(0.0, random.within(0.1, 1.5), random.within(-0.1, 0.1));
    let lean = random.direction() * random.within(0.0, 1.3);
    let axis = (Vec3::Z + lean).normalize_or(Vec3::Z) * random.within(0.5, 6.0);
    let turn = Mat3::from_axis_angle(axis.normalize(), random.within(-1.5, 1.5));
    Edges {
        half_base,
        axis,
        half_top: turn * half_base * random.within(0.3, 2.0),
        middle: Vec3::new(0.0, 0.0, random.within(-0.3, 0.3)),
    }
}

/// A distance from a hundredth of a mm to some hundred.
fn distance(random: &mut Random) -> f32 {
    10.0_f32.powf(random.within(-2.0, 2.5))
}

/// Towards a point on the patch, or a little beside it.
fn towards(random: &mut Random, edges: Edges) -> Case {
    let (u, v) = (random.within(-0.2, 1.2), random.within(-0.2, 1.2));
    let distance = distance(random);
    edges.through(edges.at(u, v), random.direction(), distance)
}

fn ordinary(random: &mut Random) -> Case {
    let edges = loop_edges(random);
    towards(random, edges)
}

/// At up to a hundredth to the tangent plane.
fn grazing(random: &mut Random) -> Case {
    let edges = loop_edges(random);
    let (u, v) = (random.within(0.0, 1.0), random.within(0.0, 1.0));
    let [along_u, along_v] = edges.tangents(u, v);
    let turn = Vec2::from_angle(random.within(0.0, TAU));
    let tangent = (along_u.normalize() * turn.x + along_v.normalize() * turn.y).normalize();
    let normal = along_u.cross(along_v).normalize_or(Vec3::X);
    let direction = (tangent + normal * 10.0_f32.powf(random.within(-5.0, -2.0))).normalize();
    let distance = distance(random);
    edges.through(edges.at(u, v), direction, distance)
}

/// A trapezoid, every other time a parallelogram.
fn planar(random: &mut Random) -> Case {
    let mut edges = loop_edges(random);
    let stretch = [1.0, random.within(0.3, 2.0)][usize::from(random.within(0.0, 1.0) < 0.5)];
    edges.half_top = edges.half_base * stretch;
    towards(random, edges)
}

fn nearly_planar(random: &mut Random) -> Case {
    let mut edges = loop_edges(random);
    let off = 10.0_f32.powf(random.within(-7.0, -2.0));
    edges.half_top = edges.half_base * random.within(0.5, 1.5) + random.vector(off);
    towards(random, edges)
}

/// The top edge turned by up to a half turn: a bow-tie in the end.
fn twisted(random: &mut Random) -> Case {
    let mut edges = loop_edges(random);
    let turn = Mat3::from_axis_angle(edges.axis.normalize(), random.within(-TAU / 2.0, TAU / 2.0));
    edges.half_top = turn * edges.half_base * random.within(0.3, 2.0);
    towards(random, edges)
}

/// A thousand to ten times as long as wide, or the other way round.
fn slivers(random: &mut Random) -> Case {
    let mut edges = loop_edges(random);
    let thin = 10.0_f32.powf(random.within(-3.0, -1.0));
    if random.within(0.0, 1.0) < 0.5 {
        edges.half_base *= thin;
        edges.half_top *= thin;
    } else {
        edges.axis *= thin;
    }
    towards(random, edges)
}

/// Two corners of the four in one place.
fn coincident(random: &mut Random) -> Case {
    let mut edges = loop_edges(random);
    match (random.within(0.0, 4.0)) as u32 {
        0 => edges.half_top = Vec3::ZERO,
        1 => edges.half_base = Vec3::ZERO,
        // P0 = P3: M − g = M + C′ − e.
        2 => edges.axis = edges.half_top - edges.half_base,
        // P0 = P2: M − g = M + C′ + e.
        _ => edges.axis = -edges.half_top - edges.half_base,
    }
    towards(random, edges)
}

/// Planes as they come, and those whose points f32 holds exactly.
fn plane(random: &mut Random) -> Edges {
    let mut edges = loop_edges(random);
    if random.within(0.0, 1.0) < 0.5 {
        (edges.half_base, edges.axis) = (Vec3::Y, Vec3::Z * 2.0);
        edges.middle = Vec3::ZERO;
    }
    edges.half_top = edges.half_base * [0.5, 1.0][usize::from(random.within(0.0, 1.0) < 0.5)];
    edges
}

/// In the plane of a flat patch.
fn in_plane(random: &mut Random) -> Case {
    let edges = plane(random);
    let turn = Vec2::from_angle(random.within(0.0, TAU));
    let direction = (edges.half_base.normalize() * turn.x + edges.axis.normalize() * turn.y)
        .normalize_or(Vec3::Y);
    let target = edges.at(random.within(-1.0, 2.0), random.within(-1.0, 2.0));
    let distance = distance(random);
    edges.through(target, direction, distance)
}

/// In the tangent plane of a twisted patch, which the ray touches from outside or meets twice.
fn touching(random: &mut Random) -> Case {
    let edges = loop_edges(random);
    let (u, v) = (random.within(0.0, 1.0), random.within(0.0, 1.0));
    let [along_u, along_v] = edges.tangents(u, v);
    let turn = Vec2::from_angle(random.within(0.0, TAU));
    let direction = (along_u.normalize() * turn.x + along_v.normalize() * turn.y).normalize();
    let distance = distance(random);
    edges.through(edges.at(u, v), direction, distance)
}

fn edges(random: &mut Random) -> Case {
    let edges = loop_edges(random);
    let along = random.within(0.0, 1.0);
    let [u, v] = match (random.within(0.0, 4.0)) as u32 {
        0 => [0.0, along],
        1 => [1.0, along],
        2 => [along, 0.0],
        _ => [along, 1.0],
    };
    let distance = distance(random);
    edges.through(edges.at(u, v), random.direction(), distance)
}

fn corners(random: &mut Random) -> Case {
    let edges = loop_edges(random);
    let corner = (random.within(0.0, 4.0)) as u32;
    let target = edges.at((corner & 1) as f32, (corner >> 1) as f32);
    let distance = distance(random);
    edges.through(target, random.direction(), distance)
}

/// In the very direction of a line of constant u or v, on it or beside it.
fn along_lines(random: &mut Random) -> Case {
    let edges = if random.within(0.0, 1.0) < 0.5 {
        plane(random)
    } else {
        loop_edges(random)
    };
    let place = |x: f32| [0.0, 1.0, x][(4.0 * x) as usize % 3];
    let (u, v) = (
        place(random.within(0.0, 1.0)),
        place(random.within(0.0, 1.0)),
    );
    let which = usize::from(random.within(0.0, 1.0) < 0.5);
    let direction = edges.tangents(u, v)[which].normalize_or(Vec3::Z);
    let beside = random.vector(1.0) * [0.0, 1e-6, 0.1][(random.within(0.0, 3.0)) as usize % 3];
    let distance = distance(random);
    edges.through(edges.at(u, v) + beside, direction, distance)
}

/// An ordinary case ten thousand times smaller to ten thousand times larger.
fn scaled(random: &mut Random) -> Case {
    let by = 10.0_f32.powf(random.within(-4.0, 4.0));
    let mut case = ordinary(random);
    for length in [
        &mut case.half_base,
        &mut case.axis,
        &mut case.half_top,
        &mut case.middle,
        &mut case.origin,
    ] {
        *length *= by;
    }
    case
}

/// Up to 10⁵ cells from the ray's start to the patch.
fn far_cells(random: &mut Random) -> Case {
    let edges = loop_edges(random);
    let cells = 10.0_f32.powf(random.within(0.0, 5.0));
    let way = Vec2::from_angle(random.within(0.0, TAU)) * cells;
    let cell = [way.x as i32, way.y as i32];
    let start = Vec3::new(
        random.within(-0.4, 0.4),
        random.within(-0.4, 0.4),
        random.within(-3.0, 9.0),
    );
    let target = edges.at(random.within(-0.2, 1.2), random.within(-0.2, 1.2));
    let cell_mm = PITCH * glam::DVec2::new(f64::from(cell[0]), f64::from(cell[1]));
    let direction: DVec3 = cell_mm.extend(0.0) + (target - start).as_dvec3();
    Case {
        half_base: edges.half_base,
        axis: edges.axis,
        half_top: edges.half_top,
        middle: edges.middle,
        origin: start,
        direction: direction.normalize_or(DVec3::X).as_vec3(),
        cell,
    }
}
