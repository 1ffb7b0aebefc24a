//! The picture never gets worse while it gets better: every frame that the window shows after an edit or a move of the
//! camera is nearer to the final picture than the one before it, and what is known is there at once where it belongs.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use egui::ColorImage;
use renderer_core::denoise::DenoiseError;
use renderer_core::design::{Colour, Design, Method};
use renderer_core::image::Display;
use towel_designer::backend::{self, BackendChoice};
use towel_designer::designer::{
    DisplayFrame, LiveLight, RenderThread, Stage, ViewRequest, camera_moves, for_window,
};

/// How long to wait for a frame before looking whether there will be any.
const TICK: Duration = Duration::from_millis(5);

/// A render thread whose frames are kept.
struct Reel {
    thread: RenderThread,
    view: ViewRequest,
    news: Receiver<()>,
    version: u64,
}

impl Reel {
    fn new() -> Self {
        let context = egui::Context::default();
        let (send, news) = channel();
        context.set_request_repaint_callback(move |_| send.send(()).unwrap_or_default());
        let mut design = Design::default();
        (design.sheet.warps, design.sheet.wefts) = (60, 60);
        // Light from everywhere and no shadows: what noise is left is that of where a ray ends, so that the last picture
        // is close to the true one.
        design.light.sun.clear();
        design.quality.shadows = false;
        design.quality.method = Method::Single;
        (design.quality.bounces, design.quality.samples) = (1, 48);
        design.view.cameras[0].distance = 90.0;
        let none = Arc::new(|| Err(DenoiseError::NotFound));
        let view = ViewRequest {
            camera: design.view.cameras[0].clone(),
            size: [200, 150],
            display: Display::from(&design),
            design: Arc::new(design),
            choice: BackendChoice::Cpu,
            attempt: 0,
            light: LiveLight::True,
            denoises: false,
        };
        let make = for_window(Arc::new(backend::make), None);
        Self {
            thread: RenderThread::new(make, none, context),
            view,
            news,
            version: 0,
        }
    }

    fn edit(&mut self, edit: impl FnOnce(&mut Design)) {
        let mut design = Design::clone(&self.view.design);
        edit(&mut design);
        self.view.display = Display::from(&design);
        self.view.design = Arc::new(design);
    }

    /// Asks for the view and takes all frames until the thread rests.
    fn frames(&mut self) -> Vec<Arc<ColorImage>> {
        self.thread.send(self.view.clone(), false);
        let mut frames = Vec::new();
        loop {
            let is_at_rest = self.thread.wait_for_rest(Duration::ZERO);
            let state = self.thread.state();
            if let Some(DisplayFrame::Pixels(image)) = &state.picture.frame
                && state.picture.version != self.version
            {
                self.version = state.picture.version;
                frames.push(Arc::clone(image));
            }
            if is_at_rest {
                assert!(state.stage == Stage::Idle && state.picture.progress.done);
                return frames;
            }
            // Of a frame there is news; that there is nothing more to come is none.
            self.news.recv_timeout(TICK).unwrap_or_default();
        }
    }
}

/// Root of the mean square difference, of 255.
fn distance(a: &ColorImage, b: &ColorImage) -> f64 {
    assert_eq!(a.size, b.size);
    let square = |a: u8, b: u8| (f64::from(a) - f64::from(b)).powi(2);
    let sum: f64 = (a.pixels.iter().zip(&b.pixels))
        .map(|(a, b)| square(a.r(), b.r()) + square(a.g(), b.g()) + square(a.b(), b.b()))
        .sum();
    (sum / (3 * a.pixels.len()) as f64).sqrt()
}

/// How far each frame is from the last.
fn distances(frames: &[Arc<ColorImage>]) -> Vec<f64> {
    let last = frames.last().expect("frames");
    frames.iter().map(|frame| distance(frame, last)).collect()
}

/// Whether no frame is farther from the last than any before it, by more than estimates of 147 numbers err: an eighth; and
/// by half a step of 8 bits. (A machine with other work shows other frames, of which one was 10 % farther.)
fn falls(distances: &[f64]) -> bool {
    let mut least = f64::INFINITY;
    distances.iter().all(|&distance| {
        let is_near = distance <= 1.125 * least + 0.5;
        least = least.min(distance);
        is_near
    })
}

#[test]
fn after_an_edit_every_frame_is_nearer_to_the_last() {
    let mut reel = Reel::new();
    let mut last = Arc::clone(reel.frames().last().expect("a picture"));
    type Edit = fn(&mut Design);
    let edits: [(&str, Edit); 5] = [
        ("a colour", |d| d.chart.colour = Colour([150, 60, 40])),
        ("a light", |d| {
            d.light.environment.colour = Colour([255, 200, 120]);
        }),
        ("a background", |d| {
            d.light.background = Colour([40, 60, 90]);
        }),
        ("the pile's length", |d| d.length.value *= 1.5),
        ("all loops", |d| d.turbulence.seed += 1),
    ];
    for (name, edit) in edits {
        reel.edit(edit);
        let mut frames = vec![last];
        frames.extend(reel.frames());
        let distances = distances(&frames);
        assert!(frames.len() > 3, "{name}: {} frames", frames.len());
        assert!(falls(&distances), "{name}: {distances:.2?}");
        assert!(distances[0] > 1.0, "{name} changes nothing");
        // A negative control.
        let mut shuffled = distances.clone();
        shuffled.swap(0, 2);
        assert!(!falls(&shuffled), "{name}: {distances:.2?}");
        last = Arc::clone(frames.last().expect("frames"));
    }
}

#[test]
fn another_camera_shows_what_is_known_at_once_and_then_only_better() {
    let mut reel = Reel::new();
    reel.edit(|design| design.chart.colour = Colour([150, 60, 40]));
    let before = Arc::clone(reel.frames().last().expect("a picture"));
    for (name, right, up) in [("a little", 2.0, 1.0), ("far", 40.0, -15.0)] {
        camera_moves::orbit(&mut reel.view.camera, right, up);
        let frames = reel.frames();
        let distances = distances(&frames);
        assert!(frames.len() > 3, "{name}: {} frames", frames.len());
        assert!(falls(&distances), "{name}: {distances:.2?}");
        // The first is what was known, in its new place: nearer than where it was.
        let unmoved = distance(&before, frames.last().expect("frames"));
        assert!(
            distances[0] < 0.95 * unmoved,
            "{name}: {} {unmoved}",
            distances[0]
        );
    }
}
