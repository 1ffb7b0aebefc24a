//! Giving up a compilation that nobody waits for any more: the design has changed again meanwhile.

use std::sync::atomic::{AtomicBool, Ordering};

/// Whether to give up. Once it says so it stays with it, so that work left out halfway is never taken for whole.
pub struct Cancel<'a> {
    ask: &'a (dyn Fn() -> bool + Sync),
    is_cancelled: AtomicBool,
}

/// The work was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cancelled;

impl Cancel<'static> {
    /// Never gives up.
    pub fn never() -> Self {
        Self::when(&|| false)
    }
}

impl<'a> Cancel<'a> {
    /// Gives up as soon as `ask` says so. It is asked every few thousand cells or voxels, on any thread.
    pub fn when(ask: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self {
            ask,
            is_cancelled: AtomicBool::new(false),
        }
    }

    /// Whether work may be left out: nobody will see it.
    pub(super) fn is_cancelled(&self) -> bool {
        let is_cancelled = self.is_cancelled.load(Ordering::Relaxed) || (self.ask)();
        if is_cancelled {
            self.is_cancelled.store(true, Ordering::Relaxed);
        }
        is_cancelled
    }

    /// An error if the work before may not be whole.
    pub(super) fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }
}
