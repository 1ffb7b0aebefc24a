//! Where a designer's camera stands: from azimuth, elevation and distance to a [`Camera`].

use glam::DVec3;

use super::CameraDesign;
use crate::geometry::{Camera, Projection};

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
}
