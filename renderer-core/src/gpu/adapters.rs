//! Which adapters this machine has, for `info` and for the choice between GPU and processor.

use super::context::{is_software, usable_adapters};

/// What there is to know about an adapter before using it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdapterSummary {
    /// Name, as its driver tells it.
    pub name: String,
    /// The interface it is reached through: Vulkan, Metal or DX12.
    pub api: String,
    /// Driver and its version.
    pub driver: String,
    /// Whether it is a GPU, rather than a processor that acts as one.
    pub is_hardware: bool,
    /// Largest side of a 2D texture, pixels.
    pub texture_side: u32,
    /// Largest buffer that a shader can read, bytes.
    pub storage_buffer: u64,
    /// Largest buffer, bytes.
    pub buffer: u64,
}

/// All adapters that can compute, without a window. Empty where no driver is installed, which is no error.
pub fn adapters() -> Vec<AdapterSummary> {
    let summary = |adapter: wgpu::Adapter| {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        AdapterSummary {
            is_hardware: !is_software(&info),
            name: info.name,
            api: info.backend.to_string(),
            driver: format!("{} {}", info.driver, info.driver_info),
            texture_side: limits.max_texture_dimension_2d,
            storage_buffer: limits.max_storage_buffer_binding_size,
            buffer: limits.max_buffer_size,
        }
    };
    usable_adapters().into_iter().map(summary).collect()
}
