//! Chooses and makes the backend that the user or the machine asks for.
//!
//! `auto` takes the GPU where an adapter is hardware, and the processor otherwise: on software Vulkan the same picture
//! takes several times as long as on the processor itself. The processor's backends need no Vulkan, not even its
//! loader.

mod processor;

use directories::ProjectDirs;
use renderer_core::design::Method;
use renderer_core::gpu::{self, AdapterSummary, GpuBackend, GpuContext};
use renderer_core::reference::ReferenceBackend;
use renderer_core::render::{Backend, BackendKind, RenderError};

use crate::files;
use processor::Processor;

/// What the user asks for, on the command line or in the status bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, clap::ValueEnum)]
pub enum BackendChoice {
    /// The GPU where there is one, else the processor.
    #[default]
    Auto,
    /// The GPU, or a software adapter where that is all there is.
    Gpu,
    /// All processor cores.
    Cpu,
    /// Plain scalar f64 on one core: slow, and what the others are held to.
    Reference,
}

impl BackendChoice {
    /// What a choice comes to for a method: the GPU does not draw `six-face`, so `auto` does not take it for that.
    pub fn for_method(self, method: Method) -> Self {
        match (self, method) {
            (Self::Auto, Method::SixFace) => Self::Cpu,
            _ => self,
        }
    }
}

/// Which backend a choice leads to on a machine with these adapters.
pub fn resolve(choice: BackendChoice, adapters: &[AdapterSummary]) -> BackendKind {
    match choice {
        BackendChoice::Gpu => BackendKind::Gpu,
        BackendChoice::Cpu => BackendKind::Cpu,
        BackendChoice::Reference => BackendKind::Reference,
        BackendChoice::Auto if adapters.iter().any(|adapter| adapter.is_hardware) => {
            BackendKind::Gpu
        }
        BackendChoice::Auto => BackendKind::Cpu,
    }
}

/// Makes the backend. Adapters are looked for only where the choice depends on them. Where `auto` finds a GPU that does
/// not start, it says so and takes the processor.
///
/// # Errors
/// When the GPU is asked for and there is none that can be used.
pub fn make(choice: BackendChoice) -> Result<Box<dyn Backend>, RenderError> {
    let adapters = match choice {
        BackendChoice::Auto => gpu::adapters(),
        _ => Vec::new(),
    };
    Ok(match resolve(choice, &adapters) {
        BackendKind::Gpu => match (gpu_backend(), choice) {
            (Ok(gpu), _) => Box::new(gpu),
            (Err(error), BackendChoice::Auto) => {
                tracing::warn!("{error}; using the processor");
                Box::new(Processor::default())
            }
            (Err(error), _) => return Err(error),
        },
        BackendKind::Cpu => Box::new(Processor::default()),
        BackendKind::Reference => Box::new(ReferenceBackend::default()),
    })
}

fn gpu_backend() -> Result<GpuBackend, RenderError> {
    GpuBackend::new(with_kept_pipelines(GpuContext::headless()?))
}

/// Lets a device keep its compiled pipelines in the platform's folder for such things.
pub fn with_kept_pipelines(context: GpuContext) -> GpuContext {
    match ProjectDirs::from("", "", "towel-designer") {
        Some(folders) => files::keep_pipelines(context, &folders.cache_dir().join("pipelines")),
        None => context,
    }
}
