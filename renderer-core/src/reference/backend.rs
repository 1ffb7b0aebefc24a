//! The reference renderer as a backend.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::{Scratch, Tracer};
use crate::image::Picture;
use crate::render::levels::Tracers;
use crate::render::progressive::{Progressive, Threads};
use crate::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};

/// Plain f64, on one thread unless told otherwise.
#[derive(Debug)]
pub struct ReferenceBackend {
    threads: Threads,
    work: Option<(Tracers<Tracer>, Progressive)>,
}

impl Default for ReferenceBackend {
    fn default() -> Self {
        Self {
            threads: Threads::One,
            work: None,
        }
    }
}

impl ReferenceBackend {
    /// The same samples, drawn by all cores.
    pub fn on_all_cores() -> Self {
        Self {
            threads: Threads::All,
            work: None,
        }
    }
}

impl Backend for ReferenceBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Reference
    }

    fn device_name(&self) -> String {
        match self.threads {
            Threads::One => "f64, one core".into(),
            Threads::All => format!("f64, {} cores", rayon::current_num_threads()),
        }
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if let Some((_, progressive)) = &mut self.work
            && progressive.go_on_with(request)
        {
            return Ok(());
        }
        // The old sums go before there is room for new ones.
        let last = self.work.take().map(|(tracers, _)| tracers);
        let progressive = Progressive::new(request)?;
        let tracers = Tracers::new(request, last.as_ref(), |request, last| match last {
            Some(tracer) => tracer.again(request),
            None => Tracer::new(request),
        });
        self.work = Some((tracers, progressive));
        Ok(())
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        let deadline = Instant::now() + slice;
        let Some((tracers, progressive)) = &mut self.work else {
            return Ok(Progress {
                done: true,
                ..Progress::default()
            });
        };
        progressive.advance(
            self.threads,
            deadline,
            cancel,
            |pixel, sample, scratch: &mut Scratch| {
                tracers
                    .of_sample(pixel, sample)
                    .sample(pixel, sample, scratch)
            },
            |_| {},
        );
        Ok(progressive.progress())
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        Ok(match &self.work {
            Some((_, progressive)) => progressive.picture(),
            None => Picture::default(),
        })
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        Ok(match &self.work {
            Some((_, progressive)) => progressive.counters(),
            None => Counters::default(),
        })
    }

    fn device_bytes(&self) -> u64 {
        match &self.work {
            Some((tracers, progressive)) => {
                tracers.iter().map(Tracer::bytes).sum::<u64>() + progressive.bytes()
            }
            None => 0,
        }
    }
}
