//! The reference renderer as a backend.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::{Scratch, Tracer};
use crate::image::Picture;
use crate::render::progressive::{Progressive, Threads};
use crate::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};

/// Plain f64 on one thread.
#[derive(Debug, Default)]
pub struct ReferenceBackend {
    work: Option<(Tracer, Progressive)>,
}

impl ReferenceBackend {
    /// Works with `threads`; see [`Backend::advance`].
    pub(crate) fn advance_with(
        &mut self,
        threads: Threads,
        slice: Duration,
        cancel: &AtomicBool,
    ) -> Progress {
        let deadline = Instant::now() + slice;
        let Some((tracer, progressive)) = &mut self.work else {
            return Progress {
                done: true,
                ..Progress::default()
            };
        };
        progressive.advance(
            threads,
            deadline,
            cancel,
            |pixel, sample, scratch: &mut Scratch| tracer.sample(pixel, sample, scratch),
        );
        progressive.progress()
    }
}

impl Backend for ReferenceBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Reference
    }

    fn device_name(&self) -> String {
        "f64, one core".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if let Some((_, progressive)) = &mut self.work
            && progressive.go_on_with(request)
        {
            return Ok(());
        }
        // The old sums go before there is room for new ones.
        let last = self.work.take().map(|(tracer, _)| tracer);
        let progressive = Progressive::new(request)?;
        let tracer = match last {
            Some(tracer) => tracer.again(request),
            None => Tracer::new(request),
        };
        self.work = Some((tracer, progressive));
        Ok(())
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        Ok(self.advance_with(Threads::One, slice, cancel))
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
            Some((tracer, progressive)) => tracer.bytes() + progressive.bytes(),
            None => 0,
        }
    }
}
