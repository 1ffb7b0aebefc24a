//! Tracing pipelines, made on a thread of their own: compiling one takes a driver seconds, in which a window has to go
//! on.
//!
//! There is one thread, and it makes one pipeline at a time: of all that is wanted meanwhile only the last counts, so
//! that nothing piles up while a design changes. Of several backends that wait for different pipelines each asks again
//! until its own is there. What is made is kept. A pipeline fits the key it was made for and no others.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::render::RenderError;

use super::GpuContext;
use super::bindings::{self, entry};
use super::constants::{COUNTERS_IN_ALL, SUMS_WITH_AOV};
use super::layout::{RayTile, Slice};
use super::pipeline_key::PipelineKey;
use super::program::Program;

/// How often a wait looks whether it is cancelled.
const LOOK: Duration = Duration::from_millis(5);

/// The thread and what it has made.
#[derive(Debug)]
pub struct PipelineCompiler {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    context: GpuContext,
    program: Program,
    state: Mutex<State>,
    news: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// The next one to make, and a scene to try it on.
    wanted: Option<(PipelineKey, wgpu::BindGroup)>,
    making: Option<PipelineKey>,
    made: HashMap<PipelineKey, wgpu::ComputePipeline>,
    /// Reported once.
    failed: Option<(PipelineKey, RenderError)>,
    stop: bool,
}

impl Shared {
    /// Nobody panics while holding the lock; if somebody did, the data would still be whole.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self) {
        let mut state = self.lock();
        while !state.stop {
            let Some((key, scene)) = state.wanted.take() else {
                state = self
                    .news
                    .wait(state)
                    .unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            state.making = Some(key);
            drop(state);
            let made = catch_unwind(AssertUnwindSafe(|| self.make(key, &scene)));
            let made = made.unwrap_or_else(|_| {
                Err(RenderError::Device(
                    "a pipeline could not be made: its compiler panicked".into(),
                ))
            });
            state = self.lock();
            state.making = None;
            match made {
                Ok(pipeline) => {
                    state.made.insert(key, pipeline);
                }
                Err(error) => state.failed = Some((key, error)),
            }
            self.news.notify_all();
        }
    }

    /// Makes a pipeline and runs it on nothing: some drivers compile only when they have to.
    fn make(
        &self,
        key: PipelineKey,
        scene: &wgpu::BindGroup,
    ) -> Result<wgpu::ComputePipeline, RenderError> {
        let context = &self.context;
        let pipeline = self
            .program
            .pipeline(context, "trace_main", &key.constants())?;
        let encoder = context.guarded(|| {
            let zeros = |size: usize, usage| {
                context.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("nothing"),
                    size: size as u64,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let storage = wgpu::BufferUsages::STORAGE;
            let rays = zeros(size_of::<RayTile>(), storage);
            let sums = zeros(16 * SUMS_WITH_AOV as usize, storage);
            let slice = zeros(size_of::<Slice>(), wgpu::BufferUsages::UNIFORM);
            let totals = zeros(8 * COUNTERS_IN_ALL as usize, storage);
            let group = context
                .device
                .create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("nothing"),
                    layout: &self.program.group,
                    entries: &[
                        entry(bindings::RAY_TILES, &rays),
                        entry(bindings::SUMS, &sums),
                        entry(bindings::SLICE, &slice),
                        entry(bindings::TOTALS, &totals),
                    ],
                });
            let mut encoder = context.encoder();
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, scene, &[]);
            pass.set_bind_group(1, &group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
            drop(pass);
            encoder
        })?;
        context.submit_and_wait(encoder)?;
        if let Some(cache) = &context.pipeline_cache {
            cache.save();
        }
        Ok(pipeline)
    }
}

impl PipelineCompiler {
    /// Makes pipelines of `program`.
    ///
    /// # Errors
    /// When there is no thread to be had.
    pub fn new(context: &GpuContext, program: Program) -> Result<Self, RenderError> {
        let shared = Arc::new(Shared {
            context: context.clone(),
            program,
            state: Mutex::default(),
            news: Condvar::new(),
        });
        let thread = Arc::clone(&shared);
        let started = std::thread::Builder::new()
            .name("pipelines".into())
            .spawn(move || thread.work())
            .map_err(|error| {
                RenderError::Device(format!("no thread to make pipelines with: {error}"))
            })?;
        Ok(Self {
            shared,
            thread: Some(started),
        })
    }

    /// The layout of the program's group 1.
    pub fn group(&self) -> &wgpu::BindGroupLayout {
        &self.shared.program.group
    }

    /// A pipeline of the program's entry point `baseline_main`, made now.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn baseline(&self, key: PipelineKey) -> Result<wgpu::ComputePipeline, RenderError> {
        let Shared {
            context, program, ..
        } = &*self.shared;
        program.pipeline(context, "baseline_main", &key.constants())
    }

    /// The pipeline for `key` if it is made; else it is from now on the next one to make, first run with `scene` as its
    /// group 0.
    ///
    /// # Errors
    /// When it was tried, and could not be made.
    pub fn get(
        &self,
        key: PipelineKey,
        scene: &wgpu::BindGroup,
    ) -> Result<Option<wgpu::ComputePipeline>, RenderError> {
        let mut state = self.shared.lock();
        if let Some((_, error)) = state.failed.take_if(|(failed, _)| *failed == key) {
            return Err(error);
        }
        if let Some(pipeline) = state.made.get(&key) {
            return Ok(Some(pipeline.clone()));
        }
        if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
            let ended = "the thread that makes pipelines has ended";
            return Err(RenderError::Device(ended.into()));
        }
        if state.making != Some(key) {
            state.wanted = Some((key, scene.clone()));
            self.shared.news.notify_all();
        }
        Ok(None)
    }

    /// The pipeline for `key`, waited for, at most until `deadline` or `cancel`.
    ///
    /// # Errors
    /// When it could not be made.
    pub fn wait(
        &self,
        key: PipelineKey,
        scene: &wgpu::BindGroup,
        deadline: Option<Instant>,
        cancel: &AtomicBool,
    ) -> Result<Option<wgpu::ComputePipeline>, RenderError> {
        loop {
            let pipeline = self.get(key, scene)?;
            let is_late = deadline.is_some_and(|deadline| Instant::now() >= deadline);
            if pipeline.is_some() || is_late || cancel.load(Ordering::Relaxed) {
                return Ok(pipeline);
            }
            let state = self.shared.lock();
            // News that came between the two locks are seen after one look.
            drop(self.shared.news.wait_timeout(state, LOOK));
        }
    }
}

impl Drop for PipelineCompiler {
    fn drop(&mut self) {
        self.shared.lock().stop = true;
        self.shared.news.notify_all();
        if let Some(thread) = self.thread.take() {
            // A driver that is left compiling while the program ends may crash it.
            let _ = thread.join();
        }
    }
}
