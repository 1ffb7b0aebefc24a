//! Denoising in the viewport: when pictures are denoised, what is shown meanwhile, and that nothing waits for it. The
//! renderer and the denoiser are played, so that each step is taken when the test says so.

use std::sync::atomic::Ordering::SeqCst;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Condvar, Mutex};

use renderer_core::denoise::{Denoise, DenoiseQuality};
use renderer_core::image::Display;
use towel_designer::designer::{
    Denoising, DisplayFrame, MakeBackend, RenderThread, ViewRequest, ViewState, for_window,
};

use super::*;

/// What may happen, and what has happened.
#[derive(Default)]
struct Play {
    state: Mutex<Stand>,
    changed: Condvar,
}

#[derive(Default)]
struct Stand {
    /// Samples that a picture of full size may have so far.
    allowed: u32,
    /// Samples that it has.
    drawn: u32,
    /// Pictures that may be denoised so far.
    released: usize,
    /// Samples of the pictures that the denoiser was given, in order.
    given: Vec<u32>,
    /// Pictures whose denoising was given up.
    cancelled: usize,
    /// The denoiser fails from now on.
    fails: bool,
}

impl Play {
    fn change(&self, change: impl FnOnce(&mut Stand)) {
        change(&mut self.state.lock().unwrap());
        self.changed.notify_all();
    }

    #[track_caller]
    fn wait_for(&self, what: &str, is_so: impl Fn(&Stand) -> bool) {
        let state = self.state.lock().unwrap();
        let waited = self
            .changed
            .wait_timeout_while(state, PATIENCE, |state| !is_so(state));
        let (state, timeout) = waited.unwrap();
        assert!(!timeout.timed_out(), "{what}: given {:?}", state.given);
    }

    fn given(&self) -> Vec<u32> {
        self.state.lock().unwrap().given.clone()
    }
}

/// Samples of the picture at its full size.
const SAMPLES: u32 = 16;

/// Draws a picture whose red is the number of its samples.
struct Paced {
    play: Arc<Play>,
    size: [u32; 2],
    wanted: u32,
    samples: u32,
}

impl Backend for Paced {
    fn kind(&self) -> BackendKind {
        BackendKind::Cpu
    }

    fn device_name(&self) -> String {
        "paced".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        (self.size, self.samples) = (request.size, 0);
        self.wanted = request.settings.samples;
        Ok(())
    }

    fn advance(&mut self, slice: Duration, cancel: &AtomicBool) -> Result<Progress, RenderError> {
        // Small ones come at once.
        let is_whole = self.wanted == SAMPLES;
        if is_whole {
            let state = self.play.state.lock().unwrap();
            let is_late = |state: &mut Stand| state.allowed <= self.samples && !cancel.load(SeqCst);
            let (mut state, _) = self
                .play
                .changed
                .wait_timeout_while(state, slice, is_late)
                .unwrap();
            self.samples += u32::from(state.allowed > self.samples);
            state.drawn = self.samples;
            self.play.changed.notify_all();
        } else {
            self.samples = self.wanted;
        }
        Ok(Progress {
            samples: self.samples,
            error_estimate: None,
            done: self.samples >= self.wanted,
        })
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        let [width, height] = self.size;
        let red = self.samples as f32 / 32.0;
        Ok(Picture {
            size: self.size,
            pixels: vec![[red, 0.0, 0.0, 1.0]; (width * height) as usize],
            aov: None,
        })
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        Ok(Counters::default())
    }

    fn device_bytes(&self) -> u64 {
        0
    }
}

/// Makes pictures blue.
struct Gated(Arc<Play>);

impl Denoise for Gated {
    fn name(&self) -> String {
        "a gate".into()
    }

    fn denoise(
        &mut self,
        picture: &Picture,
        _: DenoiseQuality,
        _: f32,
        cancel: &AtomicBool,
    ) -> Result<Picture, DenoiseError> {
        let samples = (picture.pixels[0][0] * 32.0).round() as u32;
        let mut number = 0;
        self.0.change(|state| {
            state.given.push(samples);
            number = state.given.len();
        });
        let mut state = self.0.state.lock().unwrap();
        while state.released < number {
            if cancel.load(SeqCst) {
                state.cancelled += 1;
                drop(state);
                self.0.changed.notify_all();
                return Err(DenoiseError::Cancelled);
            }
            state = self
                .0
                .changed
                .wait_timeout(state, Duration::from_millis(5))
                .unwrap()
                .0;
        }
        if state.fails {
            return Err(DenoiseError::Failed("out of memory".into()));
        }
        let mut blue = picture.clone();
        blue.pixels.fill([0.0, 0.0, 0.5, 1.0]);
        Ok(blue)
    }
}

/// A render thread that nobody looks at.
struct Stage {
    play: Arc<Play>,
    thread: RenderThread,
    view: ViewRequest,
    news: Receiver<()>,
}

impl Stage {
    fn new() -> Self {
        let play = Arc::<Play>::default();
        let context = egui::Context::default();
        let (send, news) = channel();
        context.set_request_repaint_callback(move |_| send.send(()).unwrap_or_default());
        let there = Arc::clone(&play);
        let make: MakeBackend = Arc::new(move |_| {
            Ok(Box::new(Paced {
                play: Arc::clone(&there),
                size: [1, 1],
                wanted: 0,
                samples: 0,
            }))
        });
        let there = Arc::clone(&play);
        let denoiser =
            Arc::new(move || Ok(Box::new(Gated(Arc::clone(&there))) as Box<dyn Denoise>));
        let mut design = Design::default();
        (design.sheet.warps, design.sheet.wefts) = (8, 8);
        (design.quality.samples, design.quality.error) = (SAMPLES, 0.0);
        let view = ViewRequest {
            camera: design.view.cameras[0].clone(),
            size: [40, 30],
            display: Display::from(&design),
            design: Arc::new(design),
            choice: BackendChoice::Cpu,
            attempt: 0,
            light: LiveLight::default(),
            denoises: true,
        };
        let mut stage = Self {
            play,
            thread: RenderThread::new(for_window(make, None), denoiser, context),
            view,
            news,
        };
        stage.send(false);
        stage
    }

    fn send(&mut self, same_samples: bool) {
        self.thread.send(self.view.clone(), same_samples);
    }

    /// Another design, so that the picture begins anew.
    fn edit(&mut self) {
        let mut design = Design::clone(&self.view.design);
        design.quality.seed += 1;
        self.view.design = Arc::new(design);
        self.send(false);
    }

    fn allow(&self, samples: u32) {
        self.play.change(|state| state.allowed = samples);
    }

    fn release(&self) {
        self.play.change(|state| state.released += 1);
    }

    #[track_caller]
    fn wait(&self, what: &str, is_so: impl Fn(&ViewState) -> bool) -> ViewState {
        let start = std::time::Instant::now();
        loop {
            let state = self.thread.state();
            if is_so(&state) {
                return state;
            }
            let left = PATIENCE.saturating_sub(start.elapsed());
            let picture = &state.picture;
            assert!(
                !left.is_zero(),
                "{what}: {:?} {:?}",
                picture.progress,
                picture.denoised
            );
            let tick = left.min(Duration::from_millis(5));
            self.news.recv_timeout(tick).unwrap_or_default();
        }
    }

    /// Lets so many samples be drawn, and waits until they are.
    #[track_caller]
    fn draw(&self, samples: u32) {
        self.allow(samples);
        self.play
            .wait_for("samples", |state| state.drawn == samples);
    }

    #[track_caller]
    fn wait_for_denoised(&self, samples: u32) -> ViewState {
        self.wait(&format!("denoised of {samples}"), |state| {
            state
                .picture
                .denoised
                .is_some_and(|part| part.samples == samples)
        })
    }
}

/// Whether the picture shows what the denoiser made; `Mix` mixes some red into it.
fn is_blue(state: &ViewState) -> bool {
    let Some(DisplayFrame::Pixels(image)) = &state.picture.frame else {
        panic!("no pixels");
    };
    // What an edit leaves of it is less than what a plain picture with noise could be told from.
    image.pixels[0].b() > 24
}

#[test]
fn pictures_are_denoised_at_doublings_and_nothing_waits_for_it_nor_flickers() {
    let mut stage = Stage::new();
    stage.allow(1);
    stage.play.wait_for("the first", |state| state.given == [1]);
    // The denoiser is at work: samples come, and plain pictures are shown.
    let state = stage.wait("the first sample", |state| {
        state.picture.progress.samples == 1
    });
    assert!(!is_blue(&state));
    stage.draw(2);
    assert_eq!(
        (state.denoising.clone(), state.picture.denoised),
        (Denoising::Ready("a gate".into()), None)
    );
    stage.draw(3);
    assert_eq!(stage.play.given(), [1], "one at a time");

    // What comes after that shows no plain picture any more.
    stage.release();
    let shown = stage.wait_for_denoised(1);
    assert!(is_blue(&shown));
    stage
        .play
        .wait_for("the doubling that was passed", |state| {
            state.given == [1, 3]
        });
    stage.release();
    stage.wait_for_denoised(3);
    for samples in 4..=SAMPLES - 1 {
        let before = stage.thread.state().picture.version;
        stage.draw(samples);
        if samples.is_power_of_two() {
            stage
                .play
                .wait_for("a doubling", |state| state.given.last() == Some(&samples));
            stage.release();
            stage.wait_for_denoised(samples);
        }
        let state = stage.thread.state();
        assert!(is_blue(&state), "at {samples}");
        let shown = u64::from(samples.is_power_of_two());
        assert_eq!(state.picture.version, before + shown, "at {samples}");
    }
    assert_eq!(stage.play.given(), [1, 3, 4, 8]);
    stage.allow(SAMPLES);
    stage
        .play
        .wait_for("the last", |state| state.given == [1, 3, 4, 8, SAMPLES]);
    stage.wait("the end", |state| state.picture.progress.done);
    assert!(
        !stage.thread.wait_for_rest(Duration::ZERO),
        "it is still denoised"
    );
    stage.release();
    stage.wait_for_denoised(SAMPLES);
    assert!(stage.thread.wait_for_rest(PATIENCE));

    // Plain and back, without denoising again.
    stage.view.denoises = false;
    stage.send(true);
    let plain = stage.wait("the plain picture", |state| {
        state.picture.denoised.is_none()
    });
    assert!(!is_blue(&plain));
    stage.view.denoises = true;
    stage.send(true);
    assert!(is_blue(&stage.wait_for_denoised(SAMPLES)));
    // Another exposure shows the same picture.
    let before = stage.thread.state().picture.version;
    stage.view.display.exposure += 1.0;
    stage.send(true);
    let brighter = stage.wait("another exposure", |state| state.picture.version > before);
    assert!(is_blue(&brighter));
    assert_eq!(stage.play.given().len(), 5);
}

#[test]
fn an_edit_gives_up_what_is_denoised_and_a_plain_view_denoises_nothing() {
    let mut stage = Stage::new();
    stage.allow(1);
    stage.play.wait_for("the first", |state| state.given == [1]);
    stage.edit();
    stage
        .play
        .wait_for("giving up", |state| state.cancelled == 1);
    stage
        .play
        .wait_for("the first of the next picture", |state| {
            state.given == [1, 1]
        });
    stage.play.change(|state| state.released = 2);
    stage.wait_for_denoised(1);
    // After an edit plain pictures are shown until the next is denoised.
    stage.edit();
    let state = stage.wait("a plain picture", |state| state.picture.denoised.is_none());
    assert!(!is_blue(&state));
    stage
        .play
        .wait_for("its denoising", |state| state.given == [1, 1, 1]);
    stage.release();
    stage.wait_for_denoised(1);

    stage.view.denoises = false;
    stage.edit();
    let state = stage.wait("a plain picture", |state| state.picture.denoised.is_none());
    stage.draw(5);
    assert!(!is_blue(&state));
    assert_eq!(stage.play.given(), [1, 1, 1]);
    // Switched on again it takes the picture as it is.
    stage.view.denoises = true;
    stage.send(true);
    stage
        .play
        .wait_for("the present picture", |state| state.given == [1, 1, 1, 5]);
    stage.release();
    stage.wait_for_denoised(5);
}

#[test]
fn a_denoiser_that_fails_is_reported_and_the_picture_goes_on_without() {
    let mut stage = Stage::new();
    stage.allow(1);
    stage.play.wait_for("the first", |state| state.given == [1]);
    stage
        .play
        .change(|state| (state.fails, state.released) = (true, 1));
    let state = stage.wait("the report", |state| state.news.0 == 1);
    assert_eq!(state.news.1.title, "No longer denoised");
    assert!(
        state.news.1.text.contains("out of memory"),
        "{}",
        state.news.1.text
    );
    assert!(matches!(&state.denoising, Denoising::Missing(why) if why.contains("out of memory")));
    stage.allow(SAMPLES);
    let state = stage.wait("the end", |state| state.picture.progress.done);
    assert!(!is_blue(&state) && state.error.is_none());
    assert!(stage.thread.wait_for_rest(PATIENCE));
    stage.edit();
    stage.wait("the next picture", |state| state.picture.progress.done);
    assert_eq!(stage.play.given(), [1]);
}

#[test]
fn the_window_says_what_is_denoised_and_a_click_shows_the_plain_picture_from_then_on() {
    let home = tempfile::tempdir().unwrap();
    let start = || {
        let denoiser = Arc::new(|| {
            let play = Play::default();
            play.change(|state| state.released = usize::MAX);
            Ok(Box::new(Gated(Arc::new(play))) as Box<dyn Denoise>)
        });
        let setup = Setup {
            denoiser,
            folders: Some(folders_in(home.path())),
            ..setup(flat())
        };
        window(vec2(1280.0, 720.0), setup)
    };
    let mut harness = start();
    let is_denoised =
        |h: &Harness<'_, App>| h.state().viewport().state().picture.denoised.is_some();
    wait(&mut harness, "a denoised picture", is_denoised);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("denoised of").is_some());
    click(&mut harness, "denoise");
    wait(&mut harness, "the plain picture", |h| !is_denoised(h));
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("denoised of").is_none());
    drop(harness);

    // The next start remembers it.
    let mut harness = start();
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.progress.done
    });
    assert!(!harness.state().viewport().denoises());
    click(&mut harness, "View");
    click(&mut harness, "Denoise");
    wait(&mut harness, "a denoised picture", is_denoised);

    // Where there is none, it says how to get one.
    let mut harness = designer(None);
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.progress.done
    });
    harness.run_steps(2);
    assert!(harness.query_by_label("no denoiser").is_some());
    let Denoising::Missing(why) = &harness.state().viewport().state().denoising else {
        panic!("there is one");
    };
    assert!(
        why.contains("app/run") && why.contains("OIDN_LIBRARY"),
        "{why}"
    );
}
