//! The fast renderer as a backend.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::{Instructions, Scratch, Tracer};
use crate::design::Method;
use crate::image::Picture;
use crate::render::levels::Tracers;
use crate::render::progressive::{Progressive, Threads};
use crate::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};

/// All processor cores.
#[derive(Debug, Default)]
pub struct CpuBackend {
    instructions: Instructions,
    work: Option<(Tracers<Tracer>, Progressive)>,
}

impl CpuBackend {
    /// Draws with such instructions.
    pub fn with_instructions(instructions: Instructions) -> Self {
        Self {
            instructions,
            work: None,
        }
    }
}

impl Backend for CpuBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        match rayon::current_num_threads() {
            1 => "1 core".into(),
            cores => format!("{cores} cores"),
        }
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if let Some((_, progressive)) = &mut self.work
            && progressive.go_on_with(request)
        {
            return Ok(());
        }
        if let Method::Exact | Method::SixFace = request.settings.method {
            return Err(RenderError::Method {
                backend: BackendKind::Cpu,
                method: request.settings.method,
            });
        }
        // The old sums go before there is room for new ones.
        let last = self.work.take().map(|(tracers, _)| tracers);
        let progressive = Progressive::new(request)?;
        let tracers = Tracers::new(request, last.as_ref(), |request, last| {
            Tracer::new(request, self.instructions, last)
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
            Threads::All,
            deadline,
            cancel,
            |pixel, sample, scratch: &mut Scratch| {
                tracers
                    .of_sample(pixel, sample)
                    .sample(pixel, sample, scratch)
            },
            |samples| {
                for tracer in tracers.iter() {
                    tracer.learn_shadows(samples);
                }
            },
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
