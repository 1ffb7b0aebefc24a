//! What a piece of work costs: time by the clock and, where the system tells it, time of the processor.
//!
//! On a busy machine the clock tells more of the others than of us; the time that all threads of this process have
//! spent on a core does not. It is the cost of the processor's backends; a GPU's work shows on the clock alone.

use std::fs;
use std::ops::AddAssign;
use std::time::{Duration, Instant};

use renderer_core::render::BackendKind;

/// Time spent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spent {
    /// By the clock.
    pub wall: Duration,
    /// On all cores together; `None` where the system does not tell.
    pub processor: Option<Duration>,
}

impl AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.wall += other.wall;
        self.processor = match (self.processor, other.processor) {
            (Some(a), Some(b)) => Some(a + b),
            _ => None,
        };
    }
}

impl Spent {
    /// Nothing yet, with both clocks running.
    pub fn zero() -> Self {
        Self {
            wall: Duration::ZERO,
            processor: Some(Duration::ZERO),
        }
    }

    /// Seconds that a picture by this backend is said to cost.
    pub fn cost(&self, backend: BackendKind) -> f64 {
        self.processor
            .filter(|_| cost_is_processor_time(backend))
            .unwrap_or(self.wall)
            .as_secs_f64()
    }
}

/// Whether [`Spent::cost`] is time of the processor.
pub fn cost_is_processor_time(backend: BackendKind) -> bool {
    backend != BackendKind::Gpu && processor_time().is_some()
}

/// Does `work` and adds what it cost.
pub fn timed<T>(spent: &mut Spent, work: impl FnOnce() -> T) -> T {
    let (start, before) = (Instant::now(), processor_time());
    let result = work();
    let processor = match (before, processor_time()) {
        (Some(before), Some(after)) => Some(after.saturating_sub(before)),
        _ => None,
    };
    *spent += Spent {
        wall: start.elapsed(),
        processor,
    };
    result
}

/// Time that all living threads of this process have been on a core; Linux tells it to the nanosecond.
fn processor_time() -> Option<Duration> {
    let threads = fs::read_dir("/proc/self/task").ok()?;
    let mut sum = Duration::ZERO;
    for thread in threads.flatten() {
        // A thread may have ended since it was listed.
        let Ok(text) = fs::read_to_string(thread.path().join("schedstat")) else {
            continue;
        };
        sum += Duration::from_nanos(text.split_whitespace().next()?.parse().ok()?);
    }
    (!sum.is_zero()).then_some(sum)
}
