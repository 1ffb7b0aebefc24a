//! What is kept without being asked for: the unsaved design, and settings. Written on a thread of its own, a moment
//! after the last change, so that neither a gesture nor a large chart makes the window wait.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use egui::Context;

use super::document::Document;
use crate::files::{Keep, LeftBehind, Packer, Unsaved, write_atomically};

/// How long after the last change an unsaved design is written.
const AFTER: Duration = Duration::from_secs(2);

enum Order {
    /// Write this a moment from now, unless something newer comes.
    Unsaved(Box<Unsaved>),
    /// All is saved or given up: remove what was written.
    Clear,
    /// The unsaved design that follows was left behind there: remove that once it is written.
    Replaces(LeftBehind),
    /// Write a file now.
    File(PathBuf, String),
}

/// Handle of the thread, which starts with the first order. When dropped, what is still to be written is written.
pub struct Keeper {
    folder: PathBuf,
    ctx: Context,
    thread: Option<(Sender<Order>, JoinHandle<()>)>,
    failure: Arc<Mutex<Option<String>>>,
    /// What the thread was last told of: the document's revision, or that there is nothing unsaved.
    told: Option<u64>,
}

impl Keeper {
    /// Keeps unsaved designs in `folder`.
    pub fn new(folder: PathBuf, ctx: &Context) -> Self {
        Self {
            folder,
            ctx: ctx.clone(),
            thread: None,
            failure: Arc::default(),
            told: None,
        }
    }

    /// Looks at the document after every frame; costs nothing while it stays the same.
    pub fn look(&mut self, document: &Document) {
        let revision = document.is_unsaved().then(|| document.revision());
        if revision == self.told {
            return;
        }
        // While a value has a fault, what was kept before stays: a preset with a fault could not be read again.
        if revision.is_some() && !document.design.faults().is_empty() {
            return;
        }
        self.told = revision;
        self.tell(match revision {
            Some(_) => Order::Unsaved(Box::new(document.unsaved())),
            None => Order::Clear,
        });
    }

    /// A document takes the place of another: their revisions are not comparable.
    pub fn forget(&mut self) {
        if self.told.take().is_some() {
            self.tell(Order::Clear);
        }
    }

    /// The document is what was left behind; that stays until it is written again.
    pub fn replace(&mut self, left_behind: LeftBehind) {
        self.tell(Order::Replaces(left_behind));
    }

    /// Writes a small file.
    pub fn write(&mut self, path: &Path, text: String) {
        self.tell(Order::File(path.to_owned(), text));
    }

    /// Why something could not be written, once.
    pub fn take_failure(&self) -> Option<String> {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take()
    }

    fn tell(&mut self, order: Order) {
        if self.thread.is_none() {
            let (sender, receiver) = channel();
            let worker = Worker {
                folder: self.folder.clone(),
                ctx: self.ctx.clone(),
                failure: Arc::clone(&self.failure),
                last_failure: None,
                keep: None,
                replaced: None,
                packer: Packer::default(),
            };
            let thread = std::thread::Builder::new().name("keeper".into());
            let thread = thread.spawn(move || worker.run(&receiver));
            self.thread = thread.ok().map(|thread| (sender, thread));
        }
        if let Some((sender, _)) = &self.thread {
            // The thread ends only with this handle.
            let _ = sender.send(order);
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.thread.take() {
            drop(sender);
            let _ = thread.join();
        }
    }
}

struct Worker {
    folder: PathBuf,
    ctx: Context,
    failure: Arc<Mutex<Option<String>>>,
    /// Told once, not after every gesture.
    last_failure: Option<String>,
    keep: Option<Keep>,
    replaced: Option<LeftBehind>,
    packer: Packer,
}

impl Worker {
    fn run(mut self, orders: &Receiver<Order>) {
        let mut waiting: Option<(Instant, Box<Unsaved>)> = None;
        loop {
            let order = match &waiting {
                None => orders.recv().map_err(RecvTimeoutError::from),
                Some((due, _)) => {
                    orders.recv_timeout(due.saturating_duration_since(Instant::now()))
                }
            };
            match order {
                Ok(Order::Unsaved(unsaved)) => waiting = Some((Instant::now() + AFTER, unsaved)),
                Ok(Order::Clear) => {
                    waiting = None;
                    if let Some(keep) = &self.keep {
                        keep.clear();
                    }
                    self.discard_replaced();
                }
                Ok(Order::Replaces(left_behind)) => self.replaced = Some(left_behind),
                Ok(Order::File(path, text)) => self.write(&path, &text),
                Err(RecvTimeoutError::Timeout) => {
                    if let Some((_, unsaved)) = waiting.take() {
                        self.keep(&unsaved);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    if let Some((_, unsaved)) = waiting.take() {
                        self.keep(&unsaved);
                    }
                    return;
                }
            }
        }
    }

    fn keep(&mut self, unsaved: &Unsaved) {
        let folder = &self.folder;
        let keep = match self.keep.take() {
            Some(keep) => Ok(keep),
            None => Keep::new(folder).map_err(|error| format!("{}: {error}", folder.display())),
        };
        let result = keep.and_then(|keep| {
            let written = keep.write(unsaved, &mut self.packer);
            self.keep = Some(keep);
            written
        });
        if result.is_ok() {
            self.discard_replaced();
        }
        let why = result.map_err(|error| {
            format!(
                "{error}\nIf the program ended now, unsaved changes would be lost: save the design."
            )
        });
        self.tell(why);
    }

    fn discard_replaced(&mut self) {
        if let Some(left_behind) = self.replaced.take() {
            left_behind.discard();
        }
    }

    fn write(&mut self, path: &Path, text: &str) {
        let folder = path.parent().unwrap_or(Path::new(""));
        let made = std::fs::create_dir_all(folder);
        let written = made
            .map_err(|error| format!("{}: {error}", folder.display()))
            .and_then(|()| {
                write_atomically(path, text.as_bytes()).map_err(|error| error.to_string())
            });
        self.tell(written);
    }

    fn tell(&mut self, result: Result<(), String>) {
        let failure = result.err();
        if failure.is_some() && failure != self.last_failure {
            *self.failure.lock().unwrap_or_else(PoisonError::into_inner) = failure.clone();
            self.ctx.request_repaint();
        }
        if failure.is_some() {
            self.last_failure = failure;
        }
    }
}
