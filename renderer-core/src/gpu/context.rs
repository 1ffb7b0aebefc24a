//! The device that computes: our own without a window, or the one a window already has.

use std::sync::Arc;

use super::DeviceWatch;
use super::pipeline_cache::{PipelineCache, wanted_features};
use crate::render::RenderError;

/// Device, queue and what is known of their adapter. Clones share them.
#[derive(Debug, Clone)]
pub struct GpuContext {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, kind and driver of the adapter.
    pub info: Arc<wgpu::AdapterInfo>,
    /// What the device allows.
    pub limits: Arc<wgpu::Limits>,
    /// Whether the device is lost.
    pub watch: DeviceWatch,
    /// Where compiled pipelines are kept, if they are.
    pub(super) pipeline_cache: Option<Arc<PipelineCache>>,
}

/// Storage buffers that the tracing pass reads and writes.
pub const STORAGE_BUFFERS: u32 = 8;

impl GpuContext {
    /// A device of the best adapter there is: a discrete card before an integrated one before a software one.
    ///
    /// # Errors
    /// When there is no adapter that can compute.
    pub fn headless() -> Result<Self, RenderError> {
        let adapter = best_adapter().ok_or_else(|| {
            RenderError::NoAdapter("none was found that can run compute shaders".into())
        })?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("towel designer"),
            required_features: wanted_features(&adapter),
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| RenderError::NoAdapter(error.to_string()))?;
        let watch = DeviceWatch::new(&device);
        Self::from_device(device, queue, adapter.get_info(), watch)
    }

    /// Uses a device that is there already, and whoever watches it. Its limits should be its adapter's: what is lower
    /// is kept to.
    ///
    /// # Errors
    /// When the device's limits are below what any picture needs.
    pub fn from_device(
        device: wgpu::Device,
        queue: wgpu::Queue,
        info: wgpu::AdapterInfo,
        watch: DeviceWatch,
    ) -> Result<Self, RenderError> {
        let limits = device.limits();
        let context = Self {
            device,
            queue,
            info: Arc::new(info),
            limits: Arc::new(limits),
            watch,
            pipeline_cache: None,
        };
        context.check(
            "the number of storage buffers a shader needs",
            STORAGE_BUFFERS.into(),
            context.limits.max_storage_buffers_per_shader_stage.into(),
        )?;
        Ok(context)
    }

    /// A name for this kind of device's pipelines, fit for a file; `None` where the driver gives none out.
    pub fn pipelines_name(&self) -> Option<String> {
        let features = self.device.features();
        let can_keep = features.contains(wgpu::Features::PIPELINE_CACHE);
        can_keep.then(|| wgpu::util::pipeline_cache_key(&self.info))?
    }

    /// Starts from pipelines kept earlier, and lets `save` keep what is made from now on. `bytes` must be what `save`
    /// was given for a device of this [name](Self::pipelines_name), whole and unchanged: the caller sees to that, with
    /// a checksum. Those of another version of driver or program are passed over. Whatever is wrong, pictures are made
    /// all the same.
    #[must_use]
    pub fn keep_pipelines(
        mut self,
        bytes: Option<Vec<u8>>,
        save: impl Fn(&[u8]) + Send + Sync + 'static,
    ) -> Self {
        if self.pipelines_name().is_none() {
            return self;
        }
        let made = self.guarded(|| PipelineCache::new(&self.device, bytes, save));
        self.pipeline_cache = match made {
            Ok(cache) => Some(Arc::new(cache)),
            Err(error) => {
                tracing::warn!("pipelines are not kept: {error}");
                None
            }
        };
        self
    }

    /// True where the adapter is a processor in disguise: the cpu backend is faster then.
    pub fn is_software(&self) -> bool {
        is_software(&self.info)
    }

    /// An error that names what is too large, unless `value` is within `limit`.
    pub(super) fn check(
        &self,
        what: &'static str,
        value: u64,
        limit: u64,
    ) -> Result<(), RenderError> {
        if value <= limit {
            return Ok(());
        }
        Err(RenderError::BeyondAdapter {
            what,
            value,
            limit,
            adapter: self.info.name.clone(),
        })
    }

    /// Largest storage buffer that can be bound, bytes.
    pub(super) fn largest_binding(&self) -> u64 {
        self.limits
            .max_storage_buffer_binding_size
            .min(self.limits.max_buffer_size)
    }

    /// Runs `work`, and returns what the device finds wrong with it as an error instead of a panic.
    pub(super) fn guarded<T>(&self, work: impl FnOnce() -> T) -> Result<T, RenderError> {
        let scopes = [
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Validation,
        ]
        .map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let mut found = None;
        // Scopes are a stack: the last pushed is popped first.
        for scope in scopes.into_iter().rev() {
            found = found.or(pollster::block_on(scope.pop()));
        }
        match (self.watch.lost(), found) {
            (Some(reason), _) => Err(RenderError::Lost(reason.into())),
            (None, None) => Ok(result),
            (None, Some(wgpu::Error::OutOfMemory { source })) => {
                Err(RenderError::OutOfMemory(source.to_string()))
            }
            (None, Some(error)) => Err(RenderError::Device(error.to_string())),
        }
    }

    /// What a failure is reported as: that the device is lost, where that is why.
    pub(super) fn failed(&self, error: &dyn std::fmt::Display) -> RenderError {
        match self.watch.lost() {
            Some(reason) => RenderError::Lost(reason.into()),
            None => RenderError::Device(error.to_string()),
        }
    }

    /// Submits commands and waits until they are done.
    pub(super) fn submit_and_wait(
        &self,
        commands: wgpu::CommandEncoder,
    ) -> Result<(), RenderError> {
        let submission = self.guarded(|| self.queue.submit([commands.finish()]))?;
        self.device
            .poll(wgpu::PollType::Wait {
                submission_index: Some(submission),
                timeout: None,
            })
            .map_err(|error| self.failed(&error))?;
        // Work that a lost device dropped counts as done.
        self.guarded(|| ())
    }

    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }
}

/// True for an adapter that is a processor in disguise.
pub fn is_software(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu
}

/// The best adapter that can compute.
fn best_adapter() -> Option<wgpu::Adapter> {
    let by_rank = |adapter: &wgpu::Adapter| rank(&adapter.get_info());
    usable_adapters().into_iter().min_by_key(by_rank)
}

/// All adapters that can compute what we need. OpenGL is left to windows that run on it: without one it is seldom
/// there.
pub(super) fn usable_adapters() -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.retain(|adapter| {
        let flags = adapter.get_downlevel_capabilities().flags;
        flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
            && adapter.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
    });
    adapters
}

/// Smaller is better.
fn rank(info: &wgpu::AdapterInfo) -> u32 {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}
