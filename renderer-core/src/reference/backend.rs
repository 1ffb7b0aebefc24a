//! The reference renderer as a backend.

use super::scratch::Scratch;
use super::tracer::Tracer;
use crate::design::Method;
use crate::render::accumulation::Sample;
use crate::render::progressive::Threads;
use crate::render::{BackendKind, RenderRequest};
use crate::transport::{HostBackend, HostTracer};

/// Plain f64, on one thread unless another number is asked for.
pub type ReferenceBackend = HostBackend<Tracer>;

impl Default for ReferenceBackend {
    fn default() -> Self {
        Self::new(Threads::One, ())
    }
}

impl ReferenceBackend {
    /// Draws on all cores, and the same samples as on one.
    pub fn on_all_cores() -> Self {
        Self::new(Threads::All, ())
    }
}

impl HostTracer for Tracer {
    type Scratch = Scratch;
    type Options = ();

    const KIND: BackendKind = BackendKind::Reference;

    fn device_name(threads: Threads) -> String {
        match threads {
            Threads::One => "f64, one core".into(),
            Threads::All => format!("f64, {} cores", rayon::current_num_threads()),
        }
    }

    fn knows(_method: Method) -> bool {
        true
    }

    fn prepare(request: &RenderRequest, _options: (), last: Option<&Self>) -> Self {
        match last {
            Some(tracer) => tracer.again(request),
            None => Self::new(request),
        }
    }

    fn sample(&self, pixel: [u32; 2], number: u32, scratch: &mut Scratch) -> Sample {
        self.sample(pixel, number, scratch)
    }

    /// Samples learn nothing from each other.
    fn learn(&self, _samples: u32) {}

    fn bytes(&self) -> u64 {
        self.bytes()
    }
}
