//! The renderer of machines without a GPU: [`crate::reference`] on all cores, until it has code of its own.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::image::Picture;
use crate::reference::ReferenceBackend;
use crate::render::progressive::Threads;
use crate::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};

/// All processor cores.
#[derive(Debug, Default)]
pub struct CpuBackend {
    reference: ReferenceBackend,
}

impl Backend for CpuBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        match rayon::current_num_threads() {
            1 => "1 core".into(),
            cores => format!("{cores} cores"),
        }
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.reference.begin(request)
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        Ok(self.reference.advance_with(Threads::All, slice, cancel))
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        self.reference.picture()
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        self.reference.counters()
    }

    fn device_bytes(&self) -> u64 {
        self.reference.device_bytes()
    }
}
