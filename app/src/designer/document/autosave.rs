//! What is kept without being asked for: the unsaved design, and settings. Written on a thread of its own, a moment
//! after the last change, so that neither a gesture nor a large chart makes the window wait.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use egui::Context;
use renderer_core::design::CameraDesign;

use super::Document;
use crate::files::{AutosaveFile, Packer, RecoveryFile, Unsaved, write_atomically};

/// How long after the last change an unsaved design is written.
const AFTER: Duration = Duration::from_secs(2);

enum Message {
    /// Write this a moment from now, unless something newer comes.
    Unsaved(Box<Unsaved>),
    /// All is saved or given up: remove what was written.
    Clear,
    /// The unsaved design that follows was left behind there: remove that once it is written.
    Replaces(RecoveryFile),
    /// Write a file now.
    File(PathBuf, String),
}

/// Handle of the thread, which starts with the first message. When dropped, what is still to be written is written.
pub struct Autosave {
    folder: PathBuf,
    ctx: Context,
    thread: Option<(Sender<Message>, JoinHandle<()>)>,
    failure: Arc<Mutex<Option<String>>>,
    /// The revision of the document that was sent last, and the view; none if there was nothing unsaved.
    sent: Option<(u64, CameraDesign)>,
}

impl Autosave {
    /// Keeps unsaved designs in `folder`.
    pub fn new(folder: PathBuf, ctx: &Context) -> Self {
        Self {
            folder,
            ctx: ctx.clone(),
            thread: None,
            failure: Arc::default(),
            sent: None,
        }
    }

    /// Looks at the document and from where it is seen after every frame; costs little while both stay the same. Where
    /// one has only looked around is kept once a gesture is over.
    pub fn look(&mut self, document: &Document, view: &CameraDesign, gesture_goes_on: bool) {
        let revision = document.is_unsaved().then(|| document.revision());
        let sent = self.sent.as_ref();
        let is_seen_so = gesture_goes_on || sent.is_none_or(|(_, seen)| seen == view);
        if revision == sent.map(|(revision, _)| *revision) && is_seen_so {
            return;
        }
        // While a value has a fault, what was kept before stays: a preset with a fault could not be read again.
        if revision.is_some() && !document.design.faults().is_empty() {
            return;
        }
        self.sent = revision.map(|revision| (revision, view.clone()));
        self.send(match revision {
            Some(_) => {
                let mut unsaved = document.unsaved();
                unsaved.design.view.current = Some(view.clone());
                Message::Unsaved(Box::new(unsaved))
            }
            None => Message::Clear,
        });
    }

    /// A document takes the place of another: their revisions are not comparable.
    pub fn forget(&mut self) {
        if self.sent.take().is_some() {
            self.send(Message::Clear);
        }
    }

    /// The document is what was left behind; that stays until it is written again.
    pub fn replace(&mut self, recovery: RecoveryFile) {
        self.send(Message::Replaces(recovery));
    }

    /// Writes a small file.
    pub fn write(&mut self, path: &Path, text: String) {
        self.send(Message::File(path.to_owned(), text));
    }

    /// Why something could not be written, once.
    pub fn take_failure(&self) -> Option<String> {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take()
    }

    fn send(&mut self, message: Message) {
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
            let thread = std::thread::Builder::new().name("autosave".into());
            let thread = thread.spawn(move || worker.run(&receiver));
            self.thread = thread.ok().map(|thread| (sender, thread));
        }
        if let Some((sender, _)) = &self.thread {
            // The thread ends only with this handle.
            let _ = sender.send(message);
        }
    }
}

impl Drop for Autosave {
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
    /// Reported once, not after every gesture.
    last_failure: Option<String>,
    keep: Option<AutosaveFile>,
    replaced: Option<RecoveryFile>,
    packer: Packer,
}

impl Worker {
    fn run(mut self, messages: &Receiver<Message>) {
        let mut waiting: Option<(Instant, Box<Unsaved>)> = None;
        loop {
            let message = match &waiting {
                None => messages.recv().map_err(RecvTimeoutError::from),
                Some((due, _)) => {
                    messages.recv_timeout(due.saturating_duration_since(Instant::now()))
                }
            };
            match message {
                Ok(Message::Unsaved(unsaved)) => waiting = Some((Instant::now() + AFTER, unsaved)),
                Ok(Message::Clear) => {
                    waiting = None;
                    if let Some(keep) = &self.keep {
                        keep.clear();
                    }
                    self.discard_replaced();
                }
                Ok(Message::Replaces(recovery)) => self.replaced = Some(recovery),
                Ok(Message::File(path, text)) => self.write(&path, &text),
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
            None => {
                AutosaveFile::new(folder).map_err(|error| format!("{}: {error}", folder.display()))
            }
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
        self.report(why);
    }

    fn discard_replaced(&mut self) {
        if let Some(recovery) = self.replaced.take() {
            recovery.discard();
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
        self.report(written);
    }

    fn report(&mut self, result: Result<(), String>) {
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
