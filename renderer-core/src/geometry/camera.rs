//! Cameras (MODEL.md §12): pixel to ray, in f64. Space: any, in mm.

use glam::{DVec2, DVec3};

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

impl Camera {
    /// Width of a pixel of a picture `height` pixels high, across the view where its middle meets the sheet's plane (or
    /// at the eye's height above it, for views past the sheet), mm.
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
    pub(crate) fn basis(
        &self,
        pixel: DVec2,
        size: [u32; 2],
    ) -> (DVec3, DVec3, [DVec3; 2], [DVec3; 2]) {
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
}
