//! Which tiles of a picture show nothing but background: those whose rays all miss the box around the cloth.
//!
//! Found by planes with the box on one side and all rays through the tile on the other: the box's faces, the sides of
//! the tile's pyramid of rays, and planes through an edge of the box and the eye. That finds almost all there are; what
//! it does not find is traced.

use glam::{DVec2, DVec3};

use super::RenderRequest;
use crate::geometry::Camera;
use crate::scene::Scene;

/// The box is taken this much larger on each side, as a share of its size and in mm: rays in f32 miss by up to 10⁻⁴ mm
/// what they should hit, and may count yarns a thousandth thicker.
const ROOMY: f64 = 1e-3;
/// Distances below this, mm, are rounding.
const ROUNDING_MM: f64 = 1e-9;
/// Changes of a unit direction below this are rounding: over all of a scene they come to less than [`ROUNDING_MM`].
const ROUNDING: f64 = 1e-13;

/// Corners of the box that holds all loops and ground yarns, in world space, mm: least and greatest.
pub fn cloth_box(scene: &Scene) -> [DVec3; 2] {
    if let Some(form) = &*scene.form {
        return form.bounds();
    }
    let [least, greatest] = scene.loops.borders_mm(&scene.sheet).map(DVec2::from_array);
    let [low, high] = scene.heights_mm();
    [least.extend(low), greatest.extend(high)]
}

/// A plane through `point`; the box lies where `normal` does not point, up to `box_reach` beyond the plane.
struct Plane {
    normal: DVec3,
    point: DVec3,
    box_reach: f64,
}

impl Plane {
    /// The plane and its back: the box may lie on either side.
    fn both_sides(normal: DVec3, point: DVec3, corners: &[DVec3; 8]) -> impl Iterator<Item = Self> {
        [normal, -normal]
            .into_iter()
            .filter_map(move |normal| Self::new(normal, point, corners))
    }

    /// `None` where the normal vanishes.
    fn new(normal: DVec3, point: DVec3, corners: &[DVec3; 8]) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let reach = |corner: &DVec3| normal.dot(*corner - point);
        Some(Self {
            normal,
            point,
            box_reach: corners.iter().map(reach).fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// Whether all mixtures of these rays stay beyond the box.
    fn separates(&self, rays: &[(DVec3, DVec3); 4]) -> bool {
        let least =
            |of: &dyn Fn(&(DVec3, DVec3)) -> f64| rays.iter().map(of).fold(f64::INFINITY, f64::min);
        let start = least(&|(origin, _)| self.normal.dot(*origin - self.point));
        let change = least(&|(_, direction)| self.normal.dot(*direction));
        // They start beyond and come no nearer, or start from the plane and leave it.
        let comes_nearer = change < -ROUNDING;
        (!comes_nearer && self.box_reach < start - ROUNDING_MM)
            || (self.box_reach <= ROUNDING_MM && start >= -ROUNDING_MM && change > ROUNDING)
    }
}

/// Finds tiles of background of one picture.
struct Finder<'a> {
    camera: &'a Camera,
    size: [u32; 2],
    low: DVec3,
    high: DVec3,
    corners: [DVec3; 8],
    /// Planes that are the same for all tiles.
    planes: Vec<Plane>,
}

impl<'a> Finder<'a> {
    fn new(scene: &Scene, camera: &'a Camera, size: [u32; 2]) -> Self {
        let [low, high] = cloth_box(scene);
        let room = (high - low) * ROOMY + ROOMY;
        let (low, high) = (low - room, high + room);
        let corner = |index: usize| {
            DVec3::select(
                glam::BVec3::new(index & 1 != 0, index & 2 != 0, index & 4 != 0),
                high,
                low,
            )
        };
        let corners: [DVec3; 8] = std::array::from_fn(corner);
        let (eye, forward) = (camera.eye, camera.forward);
        let faces = DVec3::AXES.into_iter().flat_map(|axis| {
            let sides = [(axis, high), (-axis, low)];
            sides.map(|(normal, point)| Plane::new(normal, point, &corners))
        });
        // Each edge joins two corners whose indices differ in one bit.
        let edges = (0..8).flat_map(|from| {
            let ends = [1, 2, 4].map(|bit| (from, from | bit));
            ends.into_iter().filter(|(from, to)| from != to)
        });
        let is_parallel = camera.is_parallel();
        let through_edges = edges.flat_map(|(from, to)| {
            let (a, b) = (corners[from], corners[to]);
            let (normal, point) = if is_parallel {
                ((b - a).cross(forward), a)
            } else {
                ((a - eye).cross(b - eye), eye)
            };
            Plane::both_sides(normal, point, &corners)
        });
        // Only planes that have the box on one side can part it from anything.
        let planes = (faces.flatten().chain(through_edges))
            .filter(|plane| plane.box_reach <= ROUNDING_MM)
            .collect();
        Self {
            camera,
            size,
            low,
            high,
            corners,
            planes,
        }
    }

    /// Whether the ray through `pixel` meets the box.
    fn meets(&self, pixel: DVec2) -> bool {
        let (origin, direction) = self.camera.ray(pixel, self.size);
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let a = (self.low[axis] - origin[axis]) / direction[axis];
            let b = (self.high[axis] - origin[axis]) / direction[axis];
            // Where a ray in a face makes 0/0, min and max take the other number.
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }

    /// Whether all rays through a part of the picture miss the box.
    fn is_background(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> bool {
        let (least, greatest) = (
            DVec2::new(f64::from(x), f64::from(y)),
            DVec2::new(f64::from(x + width), f64::from(y + height)),
        );
        // Most tiles of most pictures show cloth: that is cheap to see.
        if self.meets((least + greatest) / 2.0) {
            return false;
        }
        let rays = [
            least,
            DVec2::new(greatest.x, least.y),
            greatest,
            DVec2::new(least.x, greatest.y),
        ]
        .map(|pixel| self.camera.ray(pixel, self.size));
        self.planes.iter().any(|plane| plane.separates(&rays))
            || (0..4).any(|side| self.side_separates(&rays, side))
    }

    /// Whether a side of the pyramid of rays, or of their prism, has the box outside.
    fn side_separates(&self, rays: &[(DVec3, DVec3); 4], side: usize) -> bool {
        let ((a, a_direction), (b, b_direction)) = (rays[side], rays[(side + 1) % 4]);
        let normal = if self.camera.is_parallel() {
            (b - a).cross(a_direction)
        } else {
            a_direction.cross(b_direction)
        };
        Plane::both_sides(normal, a, &self.corners).any(|plane| plane.separates(rays))
    }
}

/// For each tile of `side` pixels, row by row, whether it shows nothing but background, in whichever of its levels of
/// detail.
pub fn background_tiles(request: &RenderRequest, side: u32) -> Vec<bool> {
    let levels = request.view.levels.iter();
    let finders: Vec<_> = levels
        .map(|level| Finder::new(&level.scene, &level.camera, request.size))
        .collect();
    let levels_of = request.view.rows(request.size[1]);
    let [left, top, width, height] = request.crop;
    let [columns, rows] = [width, height].map(|length| length.div_ceil(side));
    (0..columns * rows)
        .map(|tile| {
            let corner = [tile % columns * side, tile / columns * side];
            let size = [width - corner[0], height - corner[1]].map(|rest| rest.min(side));
            let corner = [left + corner[0], top + corner[1]];
            let levels = levels_of.of_rows(corner[1], corner[1] + size[1] - 1);
            let mut finders = finders[levels].iter();
            finders.all(|finder| finder.is_background(corner, size))
        })
        .collect()
}
