//! Renderers on the host as backends.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use crate::design::Method;
use crate::image::Picture;
use crate::render::accumulation::Sample;
use crate::render::levels::Tracers;
use crate::render::progressive::{Progressive, Threads};
use crate::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};

/// Draws samples of one request, in memory that is each thread's own.
pub trait HostTracer: Send + Sync + Sized {
    /// That memory, and what its rays counted.
    type Scratch: Default + AsMut<Counters>;
    /// What there is to choose beside the request.
    type Options: Copy + Send;

    /// Which backend it is.
    const KIND: BackendKind;

    /// What draws, in words.
    fn device_name(threads: Threads) -> String;

    /// Whether it knows a method.
    fn knows(method: Method) -> bool;

    /// Prepares for `request`; what `last` derived from parts of its scene that did not change is kept.
    fn prepare(request: &RenderRequest, options: Self::Options, last: Option<&Self>) -> Self;

    /// Sample `number` of `pixel` of the whole picture.
    fn sample(&self, pixel: [u32; 2], number: u32, scratch: &mut Self::Scratch) -> Sample;

    /// Lets later samples know what the first `samples` of all pixels have learned.
    fn learn(&self, samples: u32);

    /// Bytes of what is held beside the scene.
    fn bytes(&self) -> u64;
}

/// A renderer on the host.
#[derive(Debug)]
pub struct HostBackend<T: HostTracer> {
    threads: Threads,
    options: T::Options,
    work: Option<(Tracers<T>, Progressive)>,
}

impl<T: HostTracer> HostBackend<T> {
    /// Draws on such threads, with such options.
    pub fn new(threads: Threads, options: T::Options) -> Self {
        Self {
            threads,
            options,
            work: None,
        }
    }
}

impl<T: HostTracer> Backend for HostBackend<T> {
    fn kind(&self) -> BackendKind {
        T::KIND
    }

    fn device_name(&self) -> String {
        T::device_name(self.threads)
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        if let Some((_, progressive)) = &mut self.work
            && progressive.go_on_with(request)
        {
            return Ok(());
        }
        if !T::knows(request.settings.method) {
            return Err(RenderError::Method {
                backend: T::KIND,
                method: request.settings.method,
            });
        }
        // The old sums go before there is room for new ones.
        let last = self.work.take().map(|(tracers, _)| tracers);
        let progressive = Progressive::new(request)?;
        let tracers = Tracers::new(request, last.as_ref(), |request, last| {
            T::prepare(request, self.options, last)
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
            |pixel, sample, scratch: &mut T::Scratch| {
                tracers
                    .of_sample(pixel, sample)
                    .sample(pixel, sample, scratch)
            },
            |samples| {
                for tracer in tracers.iter() {
                    tracer.learn(samples);
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
                tracers.iter().map(T::bytes).sum::<u64>() + progressive.bytes()
            }
            None => 0,
        }
    }
}
