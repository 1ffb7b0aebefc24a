//! Memory of rays on their way.

use crate::geometry::Interval;
use crate::render::Counters;

use super::first_event::Event;
use super::march::Met;
use super::tracked::Overlap;
use super::walk::LoopPlace;

/// Memory that rays reuse, one for each thread, and what they counted.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Work done since it was last taken.
    pub counters: Counters,
    pub(super) events: Vec<Event>,
    pub(super) overlaps: Vec<Overlap>,
    pub(super) along: Vec<(LoopPlace, Interval)>,
    pub(super) met: Met,
}

impl AsMut<Counters> for Scratch {
    fn as_mut(&mut self) -> &mut Counters {
        &mut self.counters
    }
}
