//! What is found along a ray: events of compositing, loops around a collision.

use super::crossing::Crossing;

/// Something that takes light from a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Event {
    /// Place in the order of events, mm from where the ray came to the cloth.
    pub t: f32,
    /// What is taken, as an optical depth.
    pub depth: f32,
    /// Index of the loop.
    pub index: u32,
    pub crossing: Crossing,
    /// Where the block begins that the crossing counts from, mm from where the ray came to the cloth.
    pub found_from: f32,
}

/// One loop at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    pub index: u32,
    pub place: [f32; 3],
    /// Extinction by this loop, 1/mm.
    pub sigma: f32,
}

/// A place where some of what comes along a ray scatters in pile.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PileEvent {
    /// Distance along the ray, mm.
    pub t: f64,
    pub index: u32,
    pub place: [f32; 3],
    /// How much of all that comes along the ray.
    pub share: f32,
}
