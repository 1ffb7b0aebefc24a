//! A ray in a block, and the loops that it may meet there, in f32 relative to the block.

use glam::Vec3A;

/// The part of a ray in a block, relative to the centre of the block's first cell (x, y) and to the sheet (z), mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockRay {
    /// Where it enters.
    pub point: Vec3A,
    /// Unit vector.
    pub direction: Vec3A,
    /// Length of the part.
    pub length: f32,
}

/// A loop that a block lists.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listed {
    /// Index in [`crate::scene::Loops::shapes`].
    pub index: u32,
    /// Centre of its own cell, relative to that of the block's first, mm.
    pub cell: [f32; 2],
}
