//! All processor cores: fast code for what users draw by, and the plain reference for the yardsticks among the methods.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use renderer_core::cpu::CpuBackend;
use renderer_core::design::Method;
use renderer_core::image::Picture;
use renderer_core::reference::ReferenceBackend;
use renderer_core::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};

/// The backend of choice `cpu`.
#[derive(Debug)]
pub struct Processor {
    fast: CpuBackend,
    /// Draws `exact` and `six-face`.
    plain: ReferenceBackend,
    draws_plainly: bool,
}

impl Default for Processor {
    fn default() -> Self {
        Self {
            fast: CpuBackend::default(),
            plain: ReferenceBackend::on_all_cores(),
            draws_plainly: false,
        }
    }
}

impl Processor {
    fn current(&self) -> &dyn Backend {
        if self.draws_plainly {
            &self.plain
        } else {
            &self.fast
        }
    }

    fn current_mut(&mut self) -> &mut dyn Backend {
        if self.draws_plainly {
            &mut self.plain
        } else {
            &mut self.fast
        }
    }
}

impl Backend for Processor {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        self.current().device_name()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        let plainly = matches!(request.settings.method, Method::Exact | Method::SixFace);
        if plainly != self.draws_plainly {
            // What the other one holds would only take memory.
            *self = Self::default();
            self.draws_plainly = plainly;
        }
        self.current_mut().begin(request)
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        self.current_mut().advance(slice, cancel)
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        self.current_mut().picture()
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        self.current_mut().counters()
    }

    fn device_bytes(&self) -> u64 {
        self.current().device_bytes()
    }
}
