//! Where each optimisation can be turned off.

use renderer_core::design::Method;
use renderer_core::render::{BackendKind, Optimisation};

/// What has to be done to see what an optimisation is worth.
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

/// The switch of an optimisation where this backend draws by this method.
pub fn switch_of(optimisation: Optimisation, backend: BackendKind, method: Method) -> Switch {
    // Who asks the processor for these gets the reference on all cores, which leaves out next to nothing.
    let is_plain = matches!(method, Method::Exact | Method::SixFace);
    let is_fast_processor = backend == BackendKind::Cpu && !is_plain;
    let is_gpu = backend == BackendKind::Gpu && method != Method::SixFace;
    let is_tracked = method == Method::Tracked;
    match optimisation {
        Optimisation::BackgroundTiles => Switch::Drawing,
        Optimisation::ConvergedTiles => Switch::Target,
        Optimisation::EmptyCells | Optimisation::RepeatedTests if is_fast_processor => {
            Switch::Drawing
        }
        Optimisation::OpaqueRays if is_fast_processor || is_gpu => Switch::Drawing,
        Optimisation::HiddenGround | Optimisation::UnusedShading if is_gpu => Switch::Drawing,
        Optimisation::WeighedEvents if is_fast_processor && is_tracked => Switch::Drawing,
        Optimisation::LastLooks if (is_fast_processor || is_gpu) && is_tracked => Switch::Drawing,
        Optimisation::LaterLights => Switch::Drawing,
        Optimisation::UnchangedSections => Switch::Compiling,
        _ => Switch::None,
    }
}

/// The optimisations that have curves of their own on the plot of run time against error: those that change what a
/// sample costs, and those that change how many are drawn up to an error.
pub fn curve_optimisations(backend: BackendKind, method: Method) -> Vec<Optimisation> {
    let has_curve = |optimisation: &Optimisation| {
        matches!(
            switch_of(*optimisation, backend, method),
            Switch::Drawing | Switch::Target
        )
    };
    Optimisation::ALL.into_iter().filter(has_curve).collect()
}

/// The optimisations that change what a sample costs.
pub fn drawing_optimisations(backend: BackendKind, method: Method) -> Vec<Optimisation> {
    let changes =
        |optimisation: &Optimisation| switch_of(*optimisation, backend, method) == Switch::Drawing;
    Optimisation::ALL.into_iter().filter(changes).collect()
}
