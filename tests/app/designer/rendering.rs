//! Rendering for the window: failures of backends are answered and reported, nothing runs when nothing changes, scenes
//! that nobody waits for are given up.
//!
//! Longer than most files because all of it is played by the same scripted backends.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex};

use renderer_core::render::MAX_SIDE;
use renderer_core::sampling::{hash_with, unit_float};
use renderer_core::scene::{Cancel, CompileError, Compiler};
use towel_designer::designer::{MakeBackend, Seen, Stage, noise_left, softened};

use super::*;

/// What a scripted backend does when it is asked to draw.
#[derive(Clone, Copy)]
enum Act {
    Lose,
    Panic,
}

/// What scripted backends do, and what they were asked.
#[derive(Default)]
struct Script {
    /// Backends made of the GPU, and of the processor.
    made: [AtomicU32; 2],
    /// Calls of any backend.
    calls: AtomicU64,
    /// What GPUs do, one after the other; then they draw.
    acts: Mutex<VecDeque<Act>>,
    /// Pictures with a larger side are too much for GPUs' memory; 0: none.
    memory_side: AtomicU32,
    /// Largest side of the GPUs' textures; 0: no limit.
    texture_side: AtomicU32,
    /// GPUs cannot be made.
    has_no_adapter: bool,
    /// GPUs are not ready to draw, and the processor gets no further than a first sample.
    compiles: AtomicBool,
    /// GPUs are not ready to draw, and the processor is as fast as ever.
    is_late: AtomicBool,
    /// Slices that GPUs and the processor drew.
    drew: [Count; 2],
    /// Pictures begun: their sizes, and how many loops their scenes have.
    begun: Mutex<Vec<([u32; 2], u64)>>,
    /// Samples that GPUs and the processor get as far as, one in each slice; `None`: all at once.
    limits: Mutex<Option<[u32; 2]>>,
    /// Pictures taken: whether of the processor, their sizes and samples.
    taken: Mutex<Vec<(bool, [u32; 2], u32)>>,
}

/// A number that grows, and can be waited for.
#[derive(Default)]
struct Count {
    number: Mutex<u32>,
    grows: Condvar,
}

impl Count {
    fn add(&self) {
        *self.number.lock().unwrap() += 1;
        self.grows.notify_all();
    }

    fn get(&self) -> u32 {
        *self.number.lock().unwrap()
    }

    fn wait_for(&self, more: u32) {
        let number = self.number.lock().unwrap();
        let is_less = |number: &mut u32| *number < more;
        let (number, _) = (self.grows.wait_timeout_while(number, PATIENCE, is_less)).unwrap();
        assert!(*number >= more, "{number} of {more}");
    }
}

impl Script {
    fn make(self: &Arc<Self>) -> MakeBackend {
        let script = Arc::clone(self);
        Arc::new(move |choice| {
            let on_gpu = choice != BackendChoice::Cpu;
            script.made[usize::from(!on_gpu)].fetch_add(1, Ordering::SeqCst);
            if on_gpu && script.has_no_adapter {
                return Err(RenderError::NoAdapter("none was found".into()));
            }
            let flat = FlatBackend::default();
            Ok(Box::new(Scripted {
                script: Arc::clone(&script),
                on_gpu,
                flat,
                request: None,
                samples: 0,
            }))
        })
    }

    fn made(&self) -> [u32; 2] {
        [0, 1].map(|which| self.made[which].load(Ordering::SeqCst))
    }
}

struct Scripted {
    script: Arc<Script>,
    on_gpu: bool,
    flat: FlatBackend,
    request: Option<RenderRequest>,
    samples: u32,
}

impl Scripted {
    fn count(&self) {
        self.script.calls.fetch_add(1, Ordering::SeqCst);
    }
}

impl Backend for Scripted {
    fn kind(&self) -> BackendKind {
        if self.on_gpu {
            BackendKind::Gpu
        } else {
            BackendKind::Cpu
        }
    }

    fn device_name(&self) -> String {
        "scripted".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.count();
        let loops = request.scene().loops.counts.planted;
        let mut begun = self.script.begun.lock().unwrap();
        begun.push((request.size, loops));
        drop(begun);
        let side = self.script.memory_side.load(Ordering::SeqCst);
        if self.on_gpu && side > 0 && request.size.iter().any(|&s| s > side) {
            return Err(RenderError::OutOfMemory("no room for the sums".into()));
        }
        let mut before = self.request.replace(request.clone());
        if let Some(before) = &mut before {
            before.settings.samples = request.settings.samples;
        }
        if before.as_ref() != Some(request) {
            self.samples = 0;
        }
        self.flat.begin(request)
    }

    fn advance(&mut self, slice: Duration, stop: &AtomicBool) -> Result<Progress, RenderError> {
        self.count();
        let compiles = self.script.compiles.load(Ordering::SeqCst);
        assert!(!(compiles && self.on_gpu), "it has nothing to draw with");
        self.script.drew[usize::from(!self.on_gpu)].add();
        if compiles {
            std::thread::yield_now();
            return Ok(Progress {
                samples: 1,
                ..Progress::default()
            });
        }
        if let Some(limits) = *self.script.limits.lock().unwrap() {
            let limit = limits[usize::from(!self.on_gpu)];
            let wanted = self.flat.samples;
            self.samples = self.samples.max((self.samples + 1).min(limit).min(wanted));
            return Ok(Progress {
                samples: self.samples,
                error_estimate: None,
                done: self.samples >= wanted,
            });
        }
        let act = self.script.acts.lock().unwrap().pop_front();
        match act.filter(|_| self.on_gpu) {
            Some(Act::Lose) => Err(RenderError::Lost("the driver was reset".into())),
            Some(Act::Panic) => panic!("index out of bounds"),
            None => self.flat.advance(slice, stop),
        }
    }

    fn is_ready(&mut self) -> Result<bool, RenderError> {
        let [compiles, is_late] =
            [&self.script.compiles, &self.script.is_late].map(|flag| flag.load(Ordering::SeqCst));
        Ok(!(self.on_gpu && (compiles || is_late)))
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        self.count();
        let mut taken = self.script.taken.lock().unwrap();
        taken.push((!self.on_gpu, self.flat.size, self.samples));
        drop(taken);
        self.flat.picture()
    }

    fn counters(&mut self) -> Result<Counters, RenderError> {
        self.flat.counters()
    }

    fn device_bytes(&self) -> u64 {
        0
    }

    fn largest_side(&self) -> u32 {
        match self.script.texture_side.load(Ordering::SeqCst) {
            side if self.on_gpu && side > 0 => side,
            _ => MAX_SIDE,
        }
    }
}

fn scripted(script: &Arc<Script>) -> Harness<'static, App> {
    let setup = Setup {
        choice: BackendChoice::Gpu,
        ..setup(script.make())
    };
    window(vec2(1280.0, 720.0), setup)
}

fn has_whole_picture(harness: &Harness<'_, App>) -> bool {
    let state = harness.state().viewport().state();
    state.picture.frame.is_some() && !state.picture.is_reduced && state.picture.progress.done
}

fn is_said(harness: &Harness<'_, App>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

#[test]
fn a_lost_gpu_is_started_again_once_then_the_processor_takes_over() {
    let script = Arc::new(Script::default());
    script.acts.lock().unwrap().push_back(Act::Lose);
    let mut harness = scripted(&script);
    wait(&mut harness, "the picture", has_whole_picture);
    harness.run_steps(2);
    assert_eq!(script.made(), [2, 0], "the GPU is started again");
    assert!(is_said(&harness, "the driver was reset"));
    assert_eq!(harness.state().viewport().state().instead, None);

    let before = design(&harness).clone();
    script.acts.lock().unwrap().push_back(Act::Lose);
    type_number(&mut harness, "Warps", "60");
    wait(&mut harness, "the processor's picture", |h| {
        h.state().viewport().state().instead.is_some() && has_whole_picture(h)
    });
    harness.run_steps(2);
    assert_eq!(script.made(), [2, 1]);
    assert!(is_said(&harness, "Rendered by the processor"));
    assert_eq!(design(&harness).sheet.warps, 60, "the design is whole");
    assert_eq!(harness.state().viewport().choice(), BackendChoice::Gpu);

    // It stays so with further edits, until the GPU is chosen again.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(*design(&harness), before);
    wait(&mut harness, "the picture undone", has_whole_picture);
    assert_eq!(script.made(), [2, 1]);
    click(&mut harness, "Backend");
    let gpu = harness.get_by_role_and_label(Role::RadioButton, "gpu");
    gpu.click();
    wait(&mut harness, "the GPU's picture", |h| {
        h.state().viewport().state().instead.is_none() && has_whole_picture(h)
    });
    assert_eq!(script.made(), [3, 1]);
    harness.run_steps(2);
    assert!(!is_said(&harness, "Rendered by the processor"));
}

#[test]
fn the_processor_draws_while_the_gpu_compiles() {
    let script = Arc::new(Script::default());
    script.compiles.store(true, Ordering::SeqCst);
    let mut harness = scripted(&script);
    let is_seen = |harness: &Harness<'_, App>| {
        let state = harness.state().viewport().state();
        state.picture.frame.is_some() && state.stage != Stage::Rendering(Seen::Nothing)
    };
    wait(&mut harness, "the processor's picture", is_seen);
    let drew = || [0, 1].map(|which| script.drew[which].get());
    assert_eq!((script.made(), drew()[0]), ([1, 1], 0));
    assert_eq!(shown_by(&harness), BY_PROCESSOR);
    // An edit does not wait either.
    type_number(&mut harness, "Warps", "60");
    let version = harness.state().viewport().state().picture.version;
    wait(&mut harness, "the edited picture", |h| {
        h.state().viewport().state().picture.version > version && is_seen(h)
    });
    assert_eq!(drew()[0], 0);
    script.compiles.store(false, Ordering::SeqCst);
    wait(&mut harness, "the GPU's picture", has_whole_picture);
    // The picture was there all the time: nothing is reported of the change.
    assert!(drew()[0] > 0 && script.made() == [1, 1]);
    assert_eq!(shown_by(&harness), BY_GPU);
    let by_processor = drew()[1];
    type_number(&mut harness, "Warps", "50");
    wait(&mut harness, "the next picture", has_whole_picture);
    harness.run_steps(2);
    assert_eq!(drew()[1], by_processor);
}

#[test]
fn a_picture_that_the_processor_finished_first_is_not_called_the_gpus() {
    let script = Arc::new(Script::default());
    script.is_late.store(true, Ordering::SeqCst);
    let mut harness = scripted(&script);
    wait(&mut harness, "the processor's picture", has_whole_picture);
    assert_eq!(script.drew[0].get(), 0);
    assert_eq!(shown_by(&harness), BY_PROCESSOR);
    // Once the GPU is ready nothing is drawn again. The next picture is its own.
    script.is_late.store(false, Ordering::SeqCst);
    assert_rest(&mut harness, &script, "when the GPU gets ready");
    type_number(&mut harness, "Warps", "60");
    wait(&mut harness, "the GPU's picture", |h| {
        shown_by(h) == BY_GPU && has_whole_picture(h)
    });
}

/// Whether the newest picture has its full size and so many samples, or more.
fn has_samples(harness: &Harness<'_, App>, samples: u32) -> bool {
    let state = harness.state().viewport().state();
    state.picture.frame.is_some()
        && !state.picture.is_reduced
        && state.picture.progress.samples >= samples
}

/// Who draws what is shown, and whether that is only a stand-in.
fn shown_by(harness: &Harness<'_, App>) -> (Option<BackendKind>, bool) {
    let state = harness.state().viewport().state();
    (
        state.device.as_ref().map(|device| device.kind),
        state.device.as_ref().is_some_and(|device| device.stands_in),
    )
}

/// Samples of the pictures of full size that the window was given, one after the other, and whether by the processor.
fn taken(harness: &Harness<'_, App>, script: &Script) -> Vec<(u32, bool)> {
    let whole = harness.state().viewport().state().size;
    let taken = script.taken.lock().unwrap();
    let whole = taken.iter().filter(|(_, size, _)| *size == whole);
    whole.map(|&(by, _, samples)| (samples, by)).collect()
}

/// No picture has fewer samples than the one before, and the GPU's come last.
#[track_caller]
fn assert_no_step_back(taken: &[(u32, bool)]) {
    let is_ordered = (taken.windows(2)).all(|two| two[0].0 <= two[1].0 && two[0].1 >= two[1].1);
    assert!(is_ordered, "{taken:?}");
}

const BY_PROCESSOR: (Option<BackendKind>, bool) = (Some(BackendKind::Cpu), true);
const BY_GPU: (Option<BackendKind>, bool) = (Some(BackendKind::Gpu), false);

#[test]
fn the_gpus_picture_is_shown_once_it_is_as_clear_as_the_processors() {
    let script = Arc::new(Script::default());
    script.is_late.store(true, Ordering::SeqCst);
    *script.limits.lock().unwrap() = Some([10, u32::MAX]);
    let mut harness = scripted(&script);
    open_panel(&mut harness, "View & quality");
    // So many that it has no end.
    type_number(&mut harness, "Samples", "1000000");
    wait(&mut harness, "the processor's picture", |h| {
        has_samples(h, 20)
    });
    assert_eq!(shown_by(&harness), BY_PROCESSOR);
    // The GPU begins, and what the processor had stays.
    script.is_late.store(false, Ordering::SeqCst);
    script.drew[0].wait_for(41);
    harness.run_steps(2);
    assert!(has_samples(&harness, 20) && shown_by(&harness) == BY_PROCESSOR);
    let by_processor = script.drew[1].get();
    *script.limits.lock().unwrap() = Some([u32::MAX; 2]);
    wait(&mut harness, "the GPU's picture", |h| shown_by(h) == BY_GPU);
    assert_eq!(script.drew[1].get(), by_processor);
    assert_no_step_back(&taken(&harness, &script));
}

#[test]
fn mixing_neighbours_leaves_as_much_noise_as_is_reckoned_with() {
    let size = [200, 200];
    let noise = |index: u32| {
        let value = unit_float(hash_with(7, index)) - 0.5;
        [value, value, value, 1.0]
    };
    let picture = Picture {
        size,
        pixels: (0..size[0] * size[1]).map(noise).collect(),
        aov: None,
    };
    let variance = |picture: &Picture| {
        let squares = picture.pixels.iter().map(|p| f64::from(p[0]).powi(2));
        squares.sum::<f64>() / picture.pixels.len() as f64
    };
    for softness in [0.0, 0.2, 0.6, 1.0] {
        let left = variance(&softened(&picture, softness)) / variance(&picture);
        let reckoned = f64::from(noise_left(softness));
        // A variance of 40 000 numbers is known to 0.7 %, nine of which share each number; and there are edges.
        assert!((left / reckoned - 1.0).abs() < 0.08, "{left} {reckoned}");
    }
    assert_eq!(noise_left(0.0), 1.0);
}

#[test]
fn more_samples_than_the_processor_ended_with_are_the_gpus_without_a_step_back() {
    let script = Arc::new(Script::default());
    script.is_late.store(true, Ordering::SeqCst);
    *script.limits.lock().unwrap() = Some([u32::MAX; 2]);
    let mut harness = scripted(&script);
    open_panel(&mut harness, "View & quality");
    type_number(&mut harness, "Samples", "50");
    wait(&mut harness, "the processor's picture", has_whole_picture);
    assert_eq!(shown_by(&harness), BY_PROCESSOR);
    script.is_late.store(false, Ordering::SeqCst);
    // What it has is more than is asked for.
    type_number(&mut harness, "Samples", "30");
    wait(&mut harness, "the same picture", |h| {
        design(h).quality.samples == 30 && has_whole_picture(h)
    });
    assert_eq!(script.drew[0].get(), 0);
    assert!(has_samples(&harness, 50) && shown_by(&harness) == BY_PROCESSOR);
    type_number(&mut harness, "Samples", "90");
    wait(&mut harness, "the GPU's picture", |h| {
        has_samples(h, 90) && has_whole_picture(h)
    });
    assert_eq!(shown_by(&harness), BY_GPU);
    assert_no_step_back(&taken(&harness, &script));
}

#[test]
fn without_an_adapter_the_processor_renders_and_says_so() {
    let script = Arc::new(Script {
        has_no_adapter: true,
        ..Script::default()
    });
    let mut harness = scripted(&script);
    wait(&mut harness, "the picture", has_whole_picture);
    harness.run_steps(2);
    assert_eq!(script.made(), [1, 1]);
    assert!(is_said(&harness, "no GPU adapter: none was found"));
    assert_eq!(harness.state().viewport().state().error, None);
}

#[test]
fn without_memory_pictures_get_smaller_then_the_processor_takes_over() {
    let script = Arc::new(Script::default());
    script.memory_side.store(600, Ordering::SeqCst);
    let mut harness = scripted(&script);
    let [width, height] = harness.state().viewport().size();
    assert!(
        width > 600,
        "the window is too small for this test: {width}"
    );
    wait(&mut harness, "the picture", has_whole_picture);
    harness.run_steps(2);
    let state = harness.state().viewport().state();
    let [drawn, drawn_height] = state.size;
    assert!(drawn <= 600, "{drawn}");
    // Both sides rounded to whole pixels: half a pixel of some hundred.
    let stretch = f64::from(drawn * height) / f64::from(drawn_height * width);
    assert!((stretch - 1.0).abs() < 0.005, "{stretch}");
    assert_eq!(state.instead, None);
    assert!(is_said(&harness, "enlarged"));

    script.memory_side.store(100, Ordering::SeqCst);
    type_number(&mut harness, "Warps", "60");
    wait(&mut harness, "the processor's picture", |h| {
        h.state().viewport().state().instead.is_some() && has_whole_picture(h)
    });
    assert!(script.made()[1] == 1);
    assert!(is_said(&harness, "out of memory"));
}

#[test]
fn a_window_beyond_the_texture_limit_shows_a_smaller_picture_enlarged() {
    let script = Arc::new(Script::default());
    script.texture_side.store(512, Ordering::SeqCst);
    let mut harness = scripted(&script);
    wait(&mut harness, "the picture", has_whole_picture);
    harness.run_steps(2);
    let state = harness.state().viewport().state();
    assert_eq!(state.size.iter().max(), Some(&512));
    let Some(DisplayFrame::Pixels(image)) = &state.picture.frame else {
        panic!("no pixels");
    };
    assert_eq!(image.size.iter().max(), Some(&512));
    assert!(is_said(&harness, "enlarged"));
}

#[test]
fn a_panic_of_a_backend_is_reported_and_the_next_edit_draws_again() {
    let script = Arc::new(Script::default());
    script.acts.lock().unwrap().push_back(Act::Panic);
    let mut harness = scripted(&script);
    wait(&mut harness, "the error", |h| {
        h.state().viewport().state().error.is_some()
    });
    harness.run_steps(2);
    assert!(is_said(&harness, "index out of bounds"));
    type_number(&mut harness, "Warps", "60");
    wait(&mut harness, "the picture", has_whole_picture);
    harness.run_steps(2);
    assert_eq!(harness.state().viewport().state().error, None);
    assert!(!is_said(&harness, "index out of bounds"));
    assert_eq!(design(&harness).sheet.warps, 60);
}

/// Nothing is asked of backends and no frame is asked for, however many frames are shown.
#[track_caller]
fn assert_rest(harness: &mut Harness<'_, App>, script: &Script, when: &str) {
    // Tooltips come after a while, animations end.
    harness.run_steps(120);
    let is_at_rest = |harness: &Harness<'_, App>| harness.state().wait_for_rest(PATIENCE);
    assert!(is_at_rest(harness), "a thread is at work {when}");
    let calls = script.calls.load(Ordering::SeqCst);
    for _ in 0..5 {
        harness.step();
        assert!(is_at_rest(harness), "a thread is at work {when}");
        let delay = harness
            .output()
            .viewport_output
            .values()
            .map(|viewport| viewport.repaint_delay)
            .min();
        assert_eq!(delay, Some(Duration::MAX), "a frame is asked for {when}");
    }
    assert_eq!(
        script.calls.load(Ordering::SeqCst),
        calls,
        "a backend is at work {when}"
    );
}

#[test]
fn nothing_runs_when_nothing_changes() {
    let script = Arc::new(Script::default());
    let mut harness = scripted(&script);
    wait(&mut harness, "the picture", has_whole_picture);
    assert_rest(&mut harness, &script, "after convergence");

    let save = harness.get_by_label("Toolbar: Save").rect().center();
    harness.hover_at(save);
    assert_rest(&mut harness, &script, "under a tooltip");

    let picture = harness.get_by_label("Viewport").rect().center();
    harness.hover_at(picture);
    assert_rest(&mut harness, &script, "with the pointer on the cloth");

    harness
        .get_by_role_and_label(Role::SpinButton, "Warps")
        .click();
    harness.run_steps(2);
    assert!(harness.ctx.text_edit_focused());
    assert_rest(&mut harness, &script, "while a text cursor waits");

    let version = harness.state().viewport().state().picture.version;
    type_number(&mut harness, "Wefts", "60");
    wait(&mut harness, "the picture", |h| {
        h.state().viewport().state().picture.version > version && has_whole_picture(h)
    });
    assert_rest(&mut harness, &script, "after an edit");
}

#[test]
fn a_scene_that_is_given_up_leaves_the_compiler_whole() {
    let mut first = Design::default();
    (first.sheet.warps, first.sheet.wefts) = (60, 60);
    let mut second = first.clone();
    second.turbulence.seed = 7;
    second.pile.fibres = 50;
    // Given up after ever more questions, so in all the parts of a compilation.
    for patience in [0, 10, 100, 300, 1000, 3000] {
        let mut compiler = Compiler::default();
        compiler.compile(&first).unwrap();
        let asked = AtomicU64::new(0);
        let ask = || asked.fetch_add(1, Ordering::SeqCst) >= patience;
        let given_up = compiler.compile_unless_cancelled(&second, &Cancel::when(&ask));
        assert!(
            matches!(given_up, Err(CompileError::Cancelled)),
            "not given up after {patience} questions"
        );
        let made = compiler.compile(&second).unwrap();
        let fresh = Compiler::default().compile(&second).unwrap();
        assert!(
            made.loops.shapes == fresh.loops.shapes && made.loops.entries == fresh.loops.entries
        );
        assert!(made.volumes.voxels == fresh.volumes.voxels && *made.looks == *fresh.looks);
    }
}

#[test]
fn an_edit_gives_up_a_scene_in_the_making() {
    let script = Arc::new(Script::default());
    let mut harness = scripted(&script);
    wait(&mut harness, "the picture", has_whole_picture);
    // A scene that takes longer than the time within which it is finished anyway: four million cells do on most
    // machines, more of them on any.
    let mut sides = [2000, 4000, 8000].into_iter();
    let is_any = sides.any(|side| is_given_up(&mut harness, &script, side));
    assert!(is_any, "64 million loops were finished for the sake of it");
}

/// Asks for a cloth of so many yarns both ways and, while its scene is being made, for a small one. Whether that was
/// shown without the large one being drawn, as it is where making it to its end takes a moment only.
fn is_given_up(harness: &mut Harness<'_, App>, script: &Script, side: u32) -> bool {
    let begun_before = script.begun.lock().unwrap().len();
    // Both at once, so that nothing but the scene of both is made.
    let sheet = &mut harness.state_mut().document_mut().design.sheet;
    (sheet.warps, sheet.wefts) = (side, side);
    wait(harness, "a scene in the making", |h| {
        h.state().viewport().state().stage == Stage::Compiling
    });
    let version = harness.state().viewport().state().picture.version;
    type_number(harness, "Wefts", "1");
    let small = u64::from(2 * side);
    wait(harness, "the small cloth", |h| {
        let state = h.state().viewport().state();
        state.picture.version > version
            && state.scene.counts.planted <= small
            && has_whole_picture(h)
    });
    let begun = script.begun.lock().unwrap()[begun_before..].to_vec();
    let all = u64::from(side) * u64::from(side);
    begun.iter().all(|(_, loops)| *loops < all / 2)
}

#[test]
fn an_edit_of_many_loops_is_seen_before_all_of_them_are_made() {
    let script = Arc::new(Script::default());
    let mut harness = scripted(&script);
    wait(&mut harness, "the picture", has_whole_picture);
    // A near view of many loops: only some of them are seen.
    type_number(&mut harness, "Warps", "700");
    type_number(&mut harness, "Wefts", "700");
    wait(&mut harness, "the large cloth", |h| {
        design(h).sheet.wefts == 700
            && h.state().viewport().state().scene.counts.planted > 200_000
            && has_whole_picture(h)
    });
    open_panel(&mut harness, "Pile");
    let edit = |harness: &mut Harness<'_, App>, field: &str, value: &str| {
        script.begun.lock().unwrap().clear();
        let before = harness.state().viewport().state().picture.version;
        type_number(harness, field, value);
        wait(harness, "the edited cloth", |h| {
            h.state().viewport().state().picture.version > before && has_whole_picture(h)
        });
        // The panel's picture of one loop is drawn, too.
        let mut begun = script.begun.lock().unwrap().clone();
        begun.retain(|&(_, loops)| loops > 1);
        (
            begun,
            harness.state().viewport().state().scene.counts.planted,
        )
    };
    let (begun, all) = edit(&mut harness, "Lean sideways", "30");
    let (_, seen) = begun[0];
    assert!(seen < all / 2, "{seen} of {all} loops are made first");
    let (_, last) = begun[begun.len() - 1];
    assert_eq!(last, all, "{begun:?}");
    assert!(
        begun[1..].iter().all(|&(_, loops)| loops == all),
        "{begun:?}"
    );

    // Loops that are there are not made again for a coarse preview.
    open_panel(&mut harness, "View & quality");
    let (begun, all) = edit(&mut harness, "Bounces", "5");
    assert!(begun.iter().all(|&(_, loops)| loops == all), "{begun:?}");
}
