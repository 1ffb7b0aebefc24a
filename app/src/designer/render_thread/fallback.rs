//! What to do when a backend fails: start it again, draw a smaller picture, or leave it to the processor. The document
//! knows nothing of it.

use std::time::{Duration, Instant};

use renderer_core::render::{BackendKind, MAX_SIDE, RenderError};

use crate::backend::BackendChoice;

/// A device lost twice within this time is given up.
const SOON: Duration = Duration::from_secs(30);
/// Pictures are not made smaller than this for want of memory.
const SMALLEST_SIDE: u32 = 512;

/// What went wrong so far with the backend that the user chose, and what it led to.
#[derive(Default)]
pub struct Fallback {
    /// The choice, and how often it was made.
    choice: (BackendChoice, u32),
    lost: Option<Instant>,
    largest_side: Option<u32>,
    processor_because: Option<String>,
}

/// What to do after a failure.
#[derive(Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Try again, which may lead to a new backend or a smaller picture; with something to report, once.
    Again(Option<String>),
    /// Nothing helps: report it.
    Report,
}

impl Fallback {
    /// Notes what is chosen; another choice, or the same made again, starts afresh. True if it does.
    pub fn choose(&mut self, choice: BackendChoice, attempt: u32) -> bool {
        let is_new = self.choice != (choice, attempt);
        let had_failed = self.processor_because.is_some() || self.largest_side.is_some();
        if is_new {
            *self = Self {
                choice: (choice, attempt),
                ..Self::default()
            };
        }
        is_new && had_failed
    }

    /// What to render with.
    pub fn effective(&self, choice: BackendChoice) -> BackendChoice {
        match self.processor_because {
            Some(_) => BackendChoice::Cpu,
            None => choice,
        }
    }

    /// A picture's size as memory allows.
    pub fn fitted(&self, size: [u32; 2], backends_limit: u32) -> [u32; 2] {
        let limit = self.largest_side.unwrap_or(MAX_SIDE).min(backends_limit);
        let longest = size[0].max(size[1]);
        if longest <= limit {
            return size;
        }
        let scale = f64::from(limit) / f64::from(longest);
        size.map(|side| ((f64::from(side) * scale).round() as u32).clamp(1, limit))
    }

    /// What stays true until the user chooses otherwise, if something does.
    pub fn standing(&self) -> Option<String> {
        let because = self.processor_because.as_ref()?;
        Some(format!(
            "{because} The processor renders instead, more slowly; the design is unharmed. To try the GPU again, \
            choose it in the status bar."
        ))
    }

    /// What to do after `error` of a backend of that kind (none could be made: `None`) that drew a picture whose larger
    /// side has so many pixels.
    pub fn remedy(
        &mut self,
        error: &RenderError,
        kind: Option<BackendKind>,
        larger_side: u32,
    ) -> Remedy {
        let is_gpu = match kind {
            Some(kind) => kind == BackendKind::Gpu,
            None => !matches!(
                self.effective(self.choice.0),
                BackendChoice::Cpu | BackendChoice::Reference
            ),
        };
        match error {
            RenderError::Method { .. } | RenderError::Size(_) => return Remedy::Report,
            _ if !is_gpu => return Remedy::Report,
            RenderError::Lost(_) | RenderError::Device(_) => {
                let was_lost = self.lost.replace(Instant::now());
                if was_lost.is_none_or(|lost| lost.elapsed() > SOON) {
                    return Remedy::Again(Some(format!("{error}. It was started again.")));
                }
                self.processor_because = Some(format!("{error}, and again soon after."));
            }
            RenderError::OutOfMemory(_) if larger_side > SMALLEST_SIDE => {
                self.largest_side = Some((larger_side / 2).max(SMALLEST_SIDE));
            }
            RenderError::OutOfMemory(_)
            | RenderError::BeyondAdapter { .. }
            | RenderError::NoAdapter(_) => {
                self.processor_because = Some(format!("{error}."));
            }
        }
        Remedy::Again(None)
    }
}
