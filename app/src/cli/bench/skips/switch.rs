//! Where each skip can be turned off.

use renderer_core::design::Method;
use renderer_core::render::{BackendKind, Skip};

/// What has to be done to see what a skip is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// Samples.
    Drawing,
    /// Samples up to an error target.
    Target,
    /// A scene.
    Compiling,
    /// There is no switch.
    None,
}

/// The switch of a skip where this backend draws by this method.
pub fn switch_of(skip: Skip, backend: BackendKind, method: Method) -> Switch {
    // Who asks the processor for these gets the reference on all cores, which leaves out next to nothing.
    let is_plain = matches!(method, Method::Exact | Method::SixFace);
    let is_fast_processor = backend == BackendKind::Cpu && !is_plain;
    let is_gpu = backend == BackendKind::Gpu && method != Method::SixFace;
    match skip {
        Skip::BackgroundTiles => Switch::Drawing,
        Skip::ConvergedTiles => Switch::Target,
        Skip::EmptyCells | Skip::RepeatedTests if is_fast_processor => Switch::Drawing,
        Skip::OpaqueRays if is_fast_processor || is_gpu => Switch::Drawing,
        Skip::HiddenGround | Skip::UnusedShading if is_gpu => Switch::Drawing,
        Skip::UnchangedSections | Skip::UnplantedLoops => Switch::Compiling,
        _ => Switch::None,
    }
}

/// The skips that have curves of their own on the plot of run time against error: those that change what a sample costs, and
/// those that change how many are drawn up to an error.
pub fn curve_skips(backend: BackendKind, method: Method) -> Vec<Skip> {
    let has_curve = |skip: &Skip| {
        matches!(
            switch_of(*skip, backend, method),
            Switch::Drawing | Switch::Target
        )
    };
    Skip::ALL.into_iter().filter(has_curve).collect()
}

/// The skips that change what a sample costs.
pub fn drawing_skips(backend: BackendKind, method: Method) -> Vec<Skip> {
    let changes = |skip: &Skip| switch_of(*skip, backend, method) == Switch::Drawing;
    Skip::ALL.into_iter().filter(changes).collect()
}
