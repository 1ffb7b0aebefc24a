//! The fast renderer as a backend.

use super::{Instructions, Scratch, Tracer, wide};
use crate::design::Method;
use crate::render::accumulation::Sample;
use crate::render::progressive::Threads;
use crate::render::{BackendKind, RenderRequest};
use crate::transport::{HostBackend, HostTracer};

/// All processor cores.
pub type CpuBackend = HostBackend<Tracer>;

impl Default for CpuBackend {
    fn default() -> Self {
        Self::with_instructions(Instructions::default())
    }
}

impl CpuBackend {
    /// Draws with such instructions.
    pub fn with_instructions(instructions: Instructions) -> Self {
        Self::new(Threads::All, instructions)
    }
}

impl HostTracer for Tracer {
    type Scratch = Scratch;
    type Options = Instructions;

    const KIND: BackendKind = BackendKind::Cpu;

    fn device_name(_threads: Threads) -> String {
        match rayon::current_num_threads() {
            1 => "1 core".into(),
            cores => format!("{cores} cores"),
        }
    }

    fn knows(method: Method) -> bool {
        !matches!(method, Method::Exact | Method::SixFace)
    }

    fn prepare(request: &RenderRequest, instructions: Instructions, last: Option<&Self>) -> Self {
        Self::new(request, instructions, last)
    }

    fn sample(&self, pixel: [u32; 2], number: u32, scratch: &mut Scratch) -> Sample {
        wide::sample(self, pixel, number, scratch)
    }

    fn learn(&self, samples: u32) {
        self.learn_light(samples);
    }

    fn bytes(&self) -> u64 {
        self.held_bytes()
    }
}
