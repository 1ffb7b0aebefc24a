//! Work that may take a while (reading a preset with a large chart), on a thread of its own.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use egui::Context;

/// A result to come.
pub struct Task<T> {
    receiver: Receiver<T>,
}

/// Where a task stands.
pub enum Poll<T> {
    /// Still at work.
    Pending,
    /// Done.
    Ready(T),
    /// The thread ended without a result.
    Lost,
}

impl<T: Send + 'static> Task<T> {
    /// Starts `work`; asks `ctx` for a frame when it is done.
    pub fn start(ctx: &Context, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (sender, receiver) = channel();
        let ctx = ctx.clone();
        let run = move || {
            // Nobody listens any more when the window is closing.
            let _ = sender.send(work());
            ctx.request_repaint();
        };
        // If no thread can be had, the sender is dropped with the closure and the task counts as lost.
        let _ = std::thread::Builder::new().name("task".into()).spawn(run);
        Self { receiver }
    }

    /// Looks whether it is done.
    pub fn poll(&self) -> Poll<T> {
        match self.receiver.try_recv() {
            Ok(result) => Poll::Ready(result),
            Err(TryRecvError::Empty) => Poll::Pending,
            Err(TryRecvError::Disconnected) => Poll::Lost,
        }
    }
}
