//! The threads that draw: one for each core, behind those of the window in priority.
//!
//! The window's own frames then come as smoothly as without rendering, even where the window itself is drawn by the
//! processor, and rendering still takes every core that nothing else wants.

use std::sync::OnceLock;

use rayon::{ThreadPool, ThreadPoolBuilder};
use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

/// In 0 to 99, where 50 is usual: on Linux a niceness of 10, a tenth of the share of a usual thread where both want a
/// core. At the lowest priority pictures would stand still while a slider is dragged.
const PRIORITY: u8 = 25;

/// Makes this thread stand behind those of the window. Where that is not allowed nothing changes.
pub fn stand_back() {
    let Ok(value) = ThreadPriorityValue::try_from(PRIORITY) else {
        return;
    };
    if let Err(error) = set_current_thread_priority(ThreadPriority::Crossplatform(value)) {
        tracing::debug!("rendering at the usual priority: {error:?}");
    }
}

/// Runs `work` so that what it does in parallel is done by the threads that draw.
pub fn with_all<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let make = || {
        let pool = ThreadPoolBuilder::new()
            .thread_name(|_| "draw".into())
            .start_handler(|_| stand_back());
        pool.build().ok()
    };
    match POOL.get_or_init(make) {
        Some(pool) => pool.install(work),
        None => work(),
    }
}
