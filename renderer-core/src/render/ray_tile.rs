//! Rays of tiles of pixels as f32 bases: what a renderer in f32 makes its camera rays from, anywhere on a large sheet.

use glam::{DVec2, DVec3};

use crate::geometry::Camera;
use crate::scene::SheetGeometry;

/// Rays of one tile of pixels, relative to a cell, for f32 arithmetic anywhere on a large sheet.
///
/// The ray of the point (x, y), in pixels from the tile's reference point, has the direction
/// normalize(`direction` + x·`direction_dx` + y·`direction_dy`) and starts at
/// `origin` + (x·`origin_dx` + y·`origin_dy`) / (1 + x·`shrink`₀ + y·`shrink`₁), mm, x and y from the centre of cell
/// `cell`, z from the sheet; that is (`depth_offset` + x·`depth_slope`₀ + y·`depth_slope`₁) / (1 + …) unnormalised
/// directions from the eye.
///
/// Where possible all these points lie in one face of the box around the cloth: then no ray has far to go to what it
/// meets, and f32 knows its points to 10⁻⁷ mm or so. From points in a plane across the view it would be a hundred times
/// worse: voxels of dense pile turn 10⁻⁵ mm into a thousandth of what light comes through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayTile {
    /// The cell that offsets are relative to.
    pub cell: [i32; 2],
    /// Origin of the reference ray, mm.
    pub origin: DVec3,
    /// Change of the origin for one pixel to the right, mm.
    pub origin_dx: DVec3,
    /// Change of the origin for one pixel down, mm.
    pub origin_dy: DVec3,
    /// Direction of the reference ray: forward part of length 1 for perspective.
    pub direction: DVec3,
    /// Change of the direction for one pixel to the right.
    pub direction_dx: DVec3,
    /// Change of the direction for one pixel down.
    pub direction_dy: DVec3,
    /// How much closer together origins get for a pixel right and down.
    pub shrink: [f64; 2],
    /// How many times the unnormalised direction lies between the eye and `origin`.
    pub depth_offset: f64,
    /// Its change for a pixel right and down.
    pub depth_slope: [f64; 2],
}

/// Rays of a tile must not differ more than this in how fast they come nearer to a face, if they are to start on it.
const MOST_SHRINK: f64 = 0.25;
/// Pixels from a tile's reference point to its farthest sample.
const TILE_REACH: f64 = 8.0;

impl Camera {
    /// The ray basis of the tile whose reference point is `pixel`; the origin is moved along the reference ray to where
    /// it enters the box around the cloth (its least and greatest corner), so that f32 offsets from it stay small.
    pub fn ray_tile(
        &self,
        pixel: DVec2,
        size: [u32; 2],
        sheet: &SheetGeometry,
        [low, high]: [DVec3; 2],
    ) -> RayTile {
        let (eye, direction, [origin_dx, origin_dy], [direction_dx, direction_dy]) =
            self.basis(pixel, size);
        let (depth_offset, face) = entry(eye, direction, low, high);
        let origin = eye + direction * depth_offset;
        // Across the view: where rays are after as many unnormalised directions as the reference ray.
        let mut steps = [
            origin_dx + direction_dx * depth_offset,
            origin_dy + direction_dy * depth_offset,
        ];
        let (mut shrink, mut depth_slope) = ([0.0; 2], [0.0; 2]);
        if let Some(axis) = face {
            let closer = [direction_dx, direction_dy].map(|change| change[axis] / direction[axis]);
            if TILE_REACH * (closer[0].abs() + closer[1].abs()) <= MOST_SHRINK {
                // Along each ray to the face.
                shrink = closer;
                depth_slope = [origin_dx, origin_dy].map(|change| -change[axis] / direction[axis]);
                steps = steps.map(|step| step - direction * (step[axis] / direction[axis]));
            }
        }
        let cell_of = |x: f64, pitch: f64, count: u32| {
            (x / pitch + f64::from(count) / 2.0)
                .floor()
                .clamp(-1.0, f64::from(count)) as i32
        };
        let cell = [
            cell_of(origin.x, sheet.pitch_x_mm, sheet.warps),
            cell_of(origin.y, sheet.pitch_y_mm, sheet.wefts),
        ];
        let [cx, cy] = sheet.cell_centre(i64::from(cell[0]), i64::from(cell[1]));
        RayTile {
            cell,
            origin: origin - DVec3::new(cx, cy, 0.0),
            origin_dx: steps[0],
            origin_dy: steps[1],
            direction,
            direction_dx,
            direction_dy,
            shrink,
            depth_offset,
            depth_slope,
        }
    }
}

/// Parameter at which a ray enters a box and the axis across the face it enters by; for a ray that misses, where it
/// passes nearest to the middle. At least 0, and without a face where the ray starts inside.
fn entry(origin: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> (f64, Option<usize>) {
    let (mut enter, mut leave, mut face) = (0.0_f64, f64::INFINITY, None);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d != 0.0 {
            let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
            if a.min(b) > enter {
                (enter, face) = (a.min(b), Some(axis));
            }
            leave = leave.min(a.max(b));
        } else if o < low[axis] || o > high[axis] {
            leave = f64::NEG_INFINITY;
        }
    }
    if enter <= leave {
        (enter, face)
    } else {
        let nearest = ((low + high) / 2.0 - origin).dot(direction) / direction.length_squared();
        (nearest.max(0.0), None)
    }
}
