//! Compiled pipelines that outlive the program, where the driver gives them out: what took seconds the first time is there
//! at once the next. Whoever owns the disk reads and writes the bytes; this side knows only what they are for.

use std::sync::{Arc, Mutex, PoisonError};

use super::GpuContext;

/// Keeps bytes until the program runs again.
type Save = Box<dyn Fn(&[u8]) + Send + Sync>;

/// The driver's cache of pipelines.
pub struct KeptPipelines {
    cache: wgpu::PipelineCache,
    save: Save,
    /// What is kept already.
    kept: Mutex<Vec<u8>>,
}

impl std::fmt::Debug for KeptPipelines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("KeptPipelines").field(&self.cache).finish()
    }
}

impl KeptPipelines {
    /// What pipelines are looked for in, and added to.
    pub(super) fn cache(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Keeps what has been made by now, if it is more than before.
    pub(super) fn save(&self) {
        let Some(bytes) = self.cache.get_data() else {
            return;
        };
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if *kept != bytes {
            (self.save)(&bytes);
            *kept = bytes;
        }
    }
}

/// What a device needs, as far as its adapter has it, for [`GpuContext::keep_pipelines`].
pub fn wanted_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    adapter.features() & wgpu::Features::PIPELINE_CACHE
}

impl GpuContext {
    /// A name for this kind of device's pipelines, fit for a file; `None` where the driver gives none out.
    pub fn pipelines_name(&self) -> Option<String> {
        let features = self.device.features();
        let can_keep = features.contains(wgpu::Features::PIPELINE_CACHE);
        can_keep.then(|| wgpu::util::pipeline_cache_key(&self.info))?
    }

    /// Starts from pipelines kept earlier, and lets `save` keep what is made from now on. `bytes` must be what `save` was
    /// given for a device of this [name](Self::pipelines_name), whole and unchanged: the caller sees to that, with a
    /// checksum. Those of another version of driver or program are passed over. Whatever is wrong, pictures are made all the
    /// same.
    #[must_use]
    pub fn keep_pipelines(
        mut self,
        bytes: Option<Vec<u8>>,
        save: impl Fn(&[u8]) + Send + Sync + 'static,
    ) -> Self {
        if self.pipelines_name().is_none() {
            return self;
        }
        let made = self.guarded(|| new_cache(&self.device, bytes.as_deref()));
        self.kept = match made {
            Ok(cache) => Some(Arc::new(KeptPipelines {
                cache,
                save: Box::new(save),
                kept: Mutex::new(bytes.unwrap_or_default()),
            })),
            Err(error) => {
                tracing::warn!("pipelines are not kept: {error}");
                None
            }
        };
        self
    }
}

#[expect(
    unsafe_code,
    reason = "wgpu has no safe way to start from kept pipelines"
)]
fn new_cache(device: &wgpu::Device, bytes: Option<&[u8]>) -> wgpu::PipelineCache {
    let descriptor = wgpu::PipelineCacheDescriptor {
        label: Some("pipelines"),
        data: bytes,
        fallback: true,
    };
    // SAFETY: the bytes are what `PipelineCache::get_data` returned, as `keep_pipelines` demands of its caller, who checks
    // length and checksum of what comes from the disk. wgpu itself passes over bytes of another adapter, driver
    // or layout (`fallback`), and the driver is bound by Vulkan to check what is left.
    unsafe { device.create_pipeline_cache(&descriptor) }
}
