//! Rays, bilinear patches, the frames of loops, boxes and bases, in f64 and without knowledge of scenes.
//!
//! Space: any, in mm. A caller translates so that a patch is near the origin ([`BilinearPatch::roots`] itself moves the
//! ray's origin next to the patch), and directions have length 1.

mod basis;
mod camera;
mod frame;
mod frame_line;
mod interval;
mod main_axis;
mod patch;
pub mod tolerances;

pub use basis::orthonormal_basis;
pub use camera::{Camera, Projection};
pub use frame::{LoopFrame, Slopes};
pub use frame_line::{FrameLine, InsideParts};
pub use interval::{Interval, clip_to_box};
pub use main_axis::main_axis;
pub use patch::{BilinearPatch, PatchLine, Root, Roots, quadratic_roots};

use glam::DVec3;

/// A half line: `origin` + t·`direction`, t ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, mm.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// This ray in coordinates whose origin is `centre`.
    pub fn relative_to(&self, centre: DVec3) -> Self {
        Self {
            origin: self.origin - centre,
            direction: self.direction,
        }
    }
}
