//! What a thread keeps from ray to ray.

use super::event::{Event, Overlap, PileEvent};
use super::frames::Frames;
use super::mailbox::Mailbox;
use crate::render::Counters;
use crate::transport::Candidate;

/// Memory that rays reuse, one for each thread, and what they counted.
#[derive(Debug, Default)]
pub struct Scratch {
    pub(super) counters: Counters,
    pub(super) mailbox: Mailbox,
    /// Events of blocks to come, the nearest last.
    pub(super) pending: Vec<Event>,
    /// The frames that a ray may be in, within a block.
    pub(super) along: Vec<Frames>,
    pub(super) overlaps: Vec<Overlap>,
    /// Places at which a camera ray may scatter in one of its segments.
    pub(super) places: Vec<PileEvent>,
    pub(super) candidates: Vec<Candidate>,
}

impl AsMut<Counters> for Scratch {
    fn as_mut(&mut self) -> &mut Counters {
        &mut self.counters
    }
}
