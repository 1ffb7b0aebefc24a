//! Cameras: pixel to ray, in f64, and the f32 bases of rays for tiles of pixels.

use glam::{DVec2, DVec3};

use crate::design::CameraDesign;
use crate::scene::SheetGeometry;

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Rays from one point; vertical angle of view, radians.
    Perspective {
        /// Vertical angle of view, radians.
        fov: f64,
    },
    /// Parallel rays; height of the picture, mm.
    Orthographic {
        /// Height of the picture, mm.
        height_mm: f64,
    },
}

/// A camera in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye, mm (for orthographic cameras: where depth is measured from).
    pub eye: DVec3,
    /// Unit vectors to the right, up and forward in the picture.
    pub right: DVec3,
    /// Up in the picture.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
    /// How it projects.
    pub projection: Projection,
}

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
    /// The camera a design describes.
    pub fn from_design(design: &CameraDesign) -> Self {
        let (azimuth, elevation) = (design.azimuth.to_radians(), design.elevation.to_radians());
        let towards_eye = DVec3::new(
            azimuth.cos() * elevation.cos(),
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
        );
        // The azimuth alone fixes "right", so the picture does not flip when looking straight down.
        let right = DVec3::new(-azimuth.sin(), azimuth.cos(), 0.0);
        let forward = -towards_eye;
        let projection = match design.orthographic_height {
            Some(height_mm) => Projection::Orthographic { height_mm },
            None => Projection::Perspective {
                fov: design.fov.to_radians(),
            },
        };
        let eye = DVec3::from_array(design.target) + towards_eye * design.distance;
        Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
            projection,
        }
    }

    /// Width of a pixel of a picture `height` pixels high, across the view where its middle meets the sheet's plane (or at the
    /// eye's height above it, for views past the sheet), mm.
    pub fn pixel_mm(&self, height: u32) -> f64 {
        let to_plane = -self.eye.z / self.forward.z;
        let distance = if to_plane > 0.0 && to_plane.is_finite() {
            to_plane.min(self.eye.length())
        } else {
            self.eye.z.abs()
        };
        self.pixel_mm_at_depth(distance, height)
    }

    /// Width of a pixel of a picture `height` pixels high, across the view at a point, mm.
    pub fn pixel_mm_at(&self, point: DVec3, height: u32) -> f64 {
        let depth = (point - self.eye).dot(self.forward);
        self.pixel_mm_at_depth(depth.max(0.0), height)
    }

    fn pixel_mm_at_depth(&self, depth: f64, height: u32) -> f64 {
        let across = match self.projection {
            Projection::Orthographic { height_mm } => height_mm,
            Projection::Perspective { fov } => 2.0 * depth * (0.5 * fov).tan(),
        };
        across / f64::from(height.max(1))
    }

    /// Where a point is in a picture of `size` pixels, from its top left; `None` behind the eye.
    pub fn pixel_of(&self, point: DVec3, size: [u32; 2]) -> Option<DVec2> {
        let from_eye = point - self.eye;
        let pixel_mm = self.pixel_mm_at(point, size[1]);
        let is_ahead = self.is_parallel() || from_eye.dot(self.forward) > 0.0;
        let offset = DVec2::new(from_eye.dot(self.right), -from_eye.dot(self.up)) / pixel_mm;
        let middle = DVec2::new(f64::from(size[0]), f64::from(size[1])) / 2.0;
        is_ahead.then_some(middle + offset)
    }

    /// Whether all rays have one direction.
    pub fn is_parallel(&self) -> bool {
        matches!(self.projection, Projection::Orthographic { .. })
    }

    /// Origin (mm) and unit direction of the ray through the point `pixel` (from the top left, pixel centres at ½) of a
    /// picture of `size` pixels.
    pub fn ray(&self, pixel: DVec2, size: [u32; 2]) -> (DVec3, DVec3) {
        let (origin, direction, ..) = self.basis(pixel, size);
        (origin, direction / direction.length())
    }

    /// Origin and unnormalised direction at `pixel`, then their changes for a pixel right and down.
    fn basis(&self, pixel: DVec2, size: [u32; 2]) -> (DVec3, DVec3, [DVec3; 2], [DVec3; 2]) {
        let (width, height) = (f64::from(size[0]), f64::from(size[1]));
        let offset = pixel - DVec2::new(width, height) / 2.0;
        let plane = |scale: f64| (self.right * scale, -self.up * scale);
        match self.projection {
            Projection::Perspective { fov } => {
                let (dx, dy) = plane(2.0 * (fov / 2.0).tan() / height);
                (
                    self.eye,
                    self.forward + dx * offset.x + dy * offset.y,
                    [DVec3::ZERO; 2],
                    [dx, dy],
                )
            }
            Projection::Orthographic { height_mm } => {
                let (dx, dy) = plane(height_mm / height);
                (
                    self.eye + dx * offset.x + dy * offset.y,
                    self.forward,
                    [dx, dy],
                    [DVec3::ZERO; 2],
                )
            }
        }
    }

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

/// Parameter at which a ray enters a box and the axis across the face it enters by; for a ray that misses, where it passes
/// nearest to the middle. At least 0, and without a face where the ray starts inside.
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
