//! The device of the tests: the machine's best adapter, hardware or software. Without one the tests fail: a green suite
//! that has drawn nothing would be worse.

use std::sync::{Mutex, OnceLock, PoisonError};

use super::compare::REPEATS;
pub use super::drawing::{finish, finish_in_slices};
use renderer_core::gpu::{GpuBackend, GpuContext};
use renderer_core::image::Picture;
use renderer_core::reference::ReferenceBackend;
use renderer_core::render::{Backend, RenderRequest};

/// The one device of all tests.
pub fn context() -> GpuContext {
    static CONTEXT: OnceLock<GpuContext> = OnceLock::new();
    CONTEXT
        .get_or_init(|| match GpuContext::headless() {
            Ok(context) => context,
            Err(error) => panic!(
                "the GPU tests need an adapter, a software one will do; on Debian and Ubuntu: \
                 apt-get install mesa-vulkan-drivers ({error})"
            ),
        })
        .clone()
}

/// A GPU backend that filters voxels as exactly as the reference does, for comparisons to the last digits.
pub fn exact_gpu() -> GpuBackend {
    let mut backend = gpu();
    backend.set_filter_f32(true);
    backend
}

/// A GPU backend as users have it. All of a process share what they compile, which takes software Vulkan longer than
/// the pictures.
pub fn gpu() -> GpuBackend {
    static FIRST: Mutex<Option<GpuBackend>> = Mutex::new(None);
    let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
    first.get_or_insert_with(compiling_gpu).beside()
}

/// A GPU backend that compiles all that it needs itself.
pub fn compiling_gpu() -> GpuBackend {
    GpuBackend::new(context()).unwrap()
}

/// Pictures of a request with [`REPEATS`] consecutive seeds.
pub fn repeats(
    backend: &mut dyn Backend,
    request: &RenderRequest,
    first_seed: u32,
) -> Vec<Picture> {
    let mut request = request.clone();
    (0..REPEATS as u32)
        .map(|k| {
            request.settings.seed = first_seed + k;
            finish(backend, &request)
        })
        .collect()
}

/// The reference on all cores: what every other backend is held to.
pub fn reference() -> ReferenceBackend {
    ReferenceBackend::on_all_cores()
}

/// The picture that the reference draws.
pub fn on_reference(request: &RenderRequest) -> Picture {
    finish(&mut reference(), request)
}
