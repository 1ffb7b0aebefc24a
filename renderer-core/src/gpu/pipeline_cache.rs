//! Compiled pipelines that outlive the program, where the driver gives them out: what took seconds the first time is
//! there at once the next. Whoever owns the disk reads and writes the bytes; this side knows only what they are for.

use std::sync::{Mutex, PoisonError};

/// Keeps bytes until the program runs again.
type Save = Box<dyn Fn(&[u8]) + Send + Sync>;

/// The driver's cache of pipelines.
pub struct PipelineCache {
    cache: wgpu::PipelineCache,
    save: Save,
    /// What is kept already.
    saved: Mutex<Vec<u8>>,
}

impl std::fmt::Debug for PipelineCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("PipelineCache").field(&self.cache).finish()
    }
}

impl PipelineCache {
    /// Starts from `bytes`, whole and unchanged what `save` was given for a device of this kind.
    pub(super) fn new(
        device: &wgpu::Device,
        bytes: Option<Vec<u8>>,
        save: impl Fn(&[u8]) + Send + Sync + 'static,
    ) -> Self {
        Self {
            cache: new_cache(device, bytes.as_deref()),
            save: Box::new(save),
            saved: Mutex::new(bytes.unwrap_or_default()),
        }
    }

    /// What pipelines are looked for in, and added to.
    pub(super) fn cache(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Keeps what has been made by now, if it is more than before.
    pub(super) fn save(&self) {
        let Some(bytes) = self.cache.get_data() else {
            return;
        };
        let mut saved = self.saved.lock().unwrap_or_else(PoisonError::into_inner);
        if *saved != bytes {
            (self.save)(&bytes);
            *saved = bytes;
        }
    }
}

/// What a device needs, as far as its adapter has it, to keep its pipelines.
pub fn wanted_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    adapter.features() & wgpu::Features::PIPELINE_CACHE
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
    // SAFETY: the bytes are what `PipelineCache::get_data` returned, as `GpuContext::keep_pipelines` demands of its
    // caller, who checks length and checksum of what comes from the disk. wgpu itself passes over bytes of another
    // adapter, driver or layout (`fallback`), and the driver is bound by Vulkan to check what is left.
    unsafe { device.create_pipeline_cache(&descriptor) }
}
