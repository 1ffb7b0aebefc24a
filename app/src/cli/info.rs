//! `info`: version, adapters, limits, and what would be used.

use std::io::Write;

use renderer_core::gpu;
use renderer_core::render::MAX_SIDE;

use crate::backend::{self, BackendChoice};
use crate::denoiser;

/// Prints everything to stdout.
pub fn run() -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "towel-designer {}", env!("CARGO_PKG_VERSION"))?;
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    writeln!(
        out,
        "processor: {cores} threads, pictures up to {MAX_SIDE} x {MAX_SIDE} pixels"
    )?;
    let adapters = gpu::adapters();
    if adapters.is_empty() {
        writeln!(
            out,
            "adapters: none; for a GPU, install its Vulkan driver (on Debian and Ubuntu: mesa-vulkan-drivers)"
        )?;
    }
    for adapter in &adapters {
        let kind = if adapter.is_hardware {
            "GPU"
        } else {
            "software"
        };
        writeln!(
            out,
            "adapter: {} ({kind}, {}, {})",
            adapter.name,
            adapter.api,
            adapter.driver.trim()
        )?;
        writeln!(
            out,
            "  textures up to {0} x {0} pixels, storage buffers up to {1} MiB, buffers up to {2} MiB",
            adapter.texture_side,
            adapter.storage_buffer >> 20,
            adapter.buffer >> 20
        )?;
    }
    let chosen = backend::resolve(BackendChoice::Auto, &adapters);
    for line in denoiser::report() {
        writeln!(out, "{line}")?;
    }
    writeln!(out, "--backend auto uses: {}", chosen.name())?;
    Ok(())
}
