//! Vectors of four loops at once: each component holds the four loops' numbers, which vector instructions take together.

use glam::{Vec3A, Vec4};

/// How many loops are looked at together: about as many as the ray meets in a block by their heights.
pub(super) const LANES: usize = 4;

/// A vector for each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vectors {
    pub x: Vec4,
    pub y: Vec4,
    pub z: Vec4,
}

impl Vectors {
    /// The same vector in each lane.
    #[inline(always)]
    pub fn splat(v: Vec3A) -> Self {
        Self {
            x: Vec4::splat(v.x),
            y: Vec4::splat(v.y),
            z: Vec4::splat(v.z),
        }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Each lane's vector times its number.
    #[inline(always)]
    pub fn scaled(self, by: Vec4) -> Self {
        Self {
            x: self.x * by,
            y: self.y * by,
            z: self.z * by,
        }
    }

    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }

    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    /// |x| + |y| + |z|.
    #[inline(always)]
    pub fn size(self) -> Vec4 {
        self.x.abs() + self.y.abs() + self.z.abs()
    }
}
