//! Chooses and makes the backend that the user or the machine asks for.

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
