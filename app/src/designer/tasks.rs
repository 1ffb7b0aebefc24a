//! Work that may take a while (reading a preset with a large chart), on a thread of its own.

use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;

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

    /// As [`Self::poll`], but waits for it a little: for what is mostly done at once.
    pub fn poll_for(&self, patience: Duration) -> Poll<T> {
        match self.receiver.recv_timeout(patience) {
            Ok(result) => Poll::Ready(result),
            Err(RecvTimeoutError::Timeout) => Poll::Pending,
            Err(RecvTimeoutError::Disconnected) => Poll::Lost,
        }
    }
}

/// What follows its inputs but takes too long for a frame: made on another thread, one at a time; until the newest is
/// there, the one before it is shown.
pub struct Latest<K, T> {
    made: Option<(K, T)>,
    /// What is being made; without a task where that came to nothing.
    coming: Option<(K, Option<Task<T>>)>,
}

impl<K, T> Default for Latest<K, T> {
    fn default() -> Self {
        Self {
            made: None,
            coming: None,
        }
    }
}

impl<K: Clone + PartialEq + Send + 'static, T: Send + 'static> Latest<K, T> {
    /// The newest there is for `key`, with the inputs it was made from. Where these differ, `make` is started.
    pub fn get(
        &mut self,
        ctx: &Context,
        key: &K,
        make: impl FnOnce(&K) -> T + Send + 'static,
    ) -> Option<&(K, T)> {
        if let Some((of, task)) = &mut self.coming {
            match task.as_ref().map(Task::poll) {
                Some(Poll::Ready(result)) => {
                    self.made = Some((of.clone(), result));
                    self.coming = None;
                }
                Some(Poll::Lost) => *task = None,
                Some(Poll::Pending) | None => {}
            }
        }
        let is_made = self.made.as_ref().is_some_and(|(of, _)| of == key);
        let waits = match &self.coming {
            Some((of, task)) => task.is_some() || of == key,
            None => false,
        };
        if !is_made && !waits {
            let of = key.clone();
            let task = Task::start(ctx, move || make(&of));
            self.coming = Some((key.clone(), Some(task)));
        }
        self.made.as_ref()
    }
}
