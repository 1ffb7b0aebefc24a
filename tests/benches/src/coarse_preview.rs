//! Measures how long the viewport has nothing to show of an edit: the render thread as the window drives it, with
//! nobody looking but a stop watch.
//!
//! Every edit begins when nothing runs, as when a designer looks at the cloth and then changes something. So that the
//! whole picture of the edit before needs not be waited for, which may take a minute, the window is made small between
//! two edits until its picture is done: all that an edit can build on, the last scene and the cost of a sample, is
//! there then.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use renderer_core::denoise::DenoiseError;
use renderer_core::design::{CameraDesign, Design};
use renderer_core::geometry::Camera;
use renderer_core::image::Display;
use renderer_core::render::{Backend, RenderRequest};
use towel_designer::backend::BackendChoice;
use towel_designer::clock::{Spent, timed};
use towel_designer::designer::{
    DisplayFrame, LiveLight, MakeBackend, RenderThread, Stage, ViewRequest, ViewState, for_window,
    workers,
};

/// How many times as wide and high the picture is during an edit as between two. No power of two, by which pictures are
/// reduced for speed, so that nothing else has that size.
const LARGER: u32 = 30;
/// How often the stop watch looks.
const LOOKING: Duration = Duration::from_micros(300);
/// How long a backend works before it is asked again.
const SLICE: Duration = Duration::from_millis(50);
/// Longest wait for any one picture.
const PATIENCE: Duration = Duration::from_secs(300);

/// The first picture of an edit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstPicture {
    /// From the request to the picture.
    pub spent: Spent,
    /// Its width and height, pixels.
    pub size: [u32; 2],
}

/// The render thread and what was requested last.
pub struct LatencyProbe {
    thread: RenderThread,
    /// What is requested, at full size.
    view: ViewRequest,
}

impl LatencyProbe {
    /// Shows a design by its first camera, one sample a pixel, in a picture of so many pixels.
    ///
    /// # Errors
    /// When the design has no camera.
    pub fn new(
        make: MakeBackend,
        choice: BackendChoice,
        design: &Design,
        size: [u32; 2],
    ) -> anyhow::Result<Self> {
        let mut design = design.clone();
        (design.quality.samples, design.quality.error) = (1, 0.0);
        let camera = design.view.cameras.first().cloned();
        let view = ViewRequest {
            camera: camera.ok_or_else(|| anyhow!("the preset has no camera"))?,
            size,
            display: Display::from(&design),
            design: Arc::new(design),
            choice,
            attempt: 0,
            light: LiveLight::default(),
            denoises: false,
        };
        let no_denoiser = Arc::new(|| Err(DenoiseError::NotFound));
        let context = egui::Context::default();
        let thread = RenderThread::new(for_window(make, None), no_denoiser, context);
        Ok(Self { thread, view })
    }

    /// What is requested.
    pub fn design(&self) -> &Design {
        &self.view.design
    }

    /// Waits until nothing runs, and what is requested has been drawn small; false if time is up before.
    ///
    /// # Errors
    /// When there is no such picture.
    pub fn rest(&mut self, deadline: Instant) -> anyhow::Result<bool> {
        let size = self.view.size.map(|side| side.div_ceil(LARGER));
        let small = ViewRequest {
            size,
            ..self.view.clone()
        };
        self.thread.send(small, false);
        let is_drawn = |state: &ViewState| {
            state.stage == Stage::Idle && state.picture.progress.done && size_of(state) == size
        };
        Ok(self.wait(deadline, is_drawn)?.is_some())
    }

    /// Edits the design; the first picture of that, or `None` if time is up before.
    ///
    /// # Errors
    /// When there is no such picture.
    pub fn edit(
        &mut self,
        deadline: Instant,
        change: impl FnOnce(&mut Design),
    ) -> anyhow::Result<Option<FirstPicture>> {
        let mut design = Design::clone(&self.view.design);
        change(&mut design);
        self.view.design = Arc::new(design);
        self.first(deadline)
    }

    /// Moves the camera; the first picture of that, or `None` if time is up before.
    ///
    /// # Errors
    /// When there is no such picture.
    pub fn look(
        &mut self,
        deadline: Instant,
        change: impl FnOnce(&mut CameraDesign),
    ) -> anyhow::Result<Option<FirstPicture>> {
        change(&mut self.view.camera);
        self.first(deadline)
    }

    fn first(&mut self, deadline: Instant) -> anyhow::Result<Option<FirstPicture>> {
        let before = self.thread.state().picture.version;
        let mut spent = Spent::zero();
        let state = timed(&mut spent, || {
            self.thread.send(self.view.clone(), false);
            self.wait(deadline, |state| state.picture.version > before)
        })?;
        Ok(state.map(|state| FirstPicture {
            spent,
            size: size_of(&state),
        }))
    }

    fn wait(
        &self,
        deadline: Instant,
        is_there: impl Fn(&ViewState) -> bool,
    ) -> anyhow::Result<Option<ViewState>> {
        let start = Instant::now();
        loop {
            let state = self.thread.state();
            if let Some(error) = state.error {
                return Err(anyhow!(error));
            }
            if is_there(&state) {
                return Ok(Some(state));
            }
            if Instant::now() >= deadline || start.elapsed() > PATIENCE {
                return Ok(None);
            }
            std::thread::sleep(LOOKING);
        }
    }

    /// One sample of every pixel of the picture requested, by a backend of its own on the threads that draw for the
    /// window. `None` if time is up before.
    ///
    /// # Errors
    /// When the backend fails or nothing was shown yet.
    pub fn whole_sample(
        &self,
        backend: &mut dyn Backend,
        seed: u32,
        deadline: Instant,
    ) -> anyhow::Result<Option<Spent>> {
        let cloth = self.thread.state().scene.cloth;
        let size = self.view.size;
        let mut settings = self.view.light.settings(&self.view.design);
        settings.seed = seed;
        let cloth = cloth.ok_or_else(|| anyhow!("nothing was shown"))?;
        let camera = Camera::from_design(&self.view.camera);
        let view = cloth.view(&self.view.design, &camera, size);
        let request = RenderRequest::new(view, size, settings);
        workers::with_all(|| backend.begin(&request))?;
        let never = AtomicBool::new(false);
        let mut spent = Spent::zero();
        loop {
            let advance = || workers::with_all(|| backend.advance(SLICE, &never));
            if timed(&mut spent, advance)?.done {
                return Ok(Some(spent));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
        }
    }
}

/// Width and height of the picture shown, pixels.
fn size_of(state: &ViewState) -> [u32; 2] {
    match &state.picture.frame {
        Some(DisplayFrame::Pixels(image)) => image.size.map(|side| side as u32),
        Some(DisplayFrame::Texture(texture)) => [texture.width(), texture.height()],
        None => [0, 0],
    }
}
