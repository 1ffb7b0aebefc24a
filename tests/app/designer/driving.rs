//! The designer's window as tests drive it: started without system dialogs, clicked, typed into, waited for.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use renderer_core::denoise::DenoiseError;
use renderer_core::design::Design;
use renderer_core::image::Picture;
use renderer_core::render::{Backend, BackendKind, Counters, Progress, RenderError, RenderRequest};
use towel_designer::backend::BackendChoice;
use towel_designer::designer::{App, Folders, MakeBackend, Setup};

/// A backend that draws flat gray at once: these tests are about the window, not about the cloth.
pub(crate) struct FlatBackend {
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
}

impl Default for FlatBackend {
    fn default() -> Self {
        Self {
            size: [1, 1],
            samples: 0,
        }
    }
}

impl Backend for FlatBackend {
    fn kind(&self) -> BackendKind {
        BackendKind::Reference
    }

    fn device_name(&self) -> String {
        "flat".into()
    }

    fn begin(&mut self, request: &RenderRequest) -> Result<(), RenderError> {
        self.size = request.size;
        self.samples = request.settings.samples;
        Ok(())
    }

    fn advance(&mut self, _: Duration, _: &AtomicBool) -> Result<Progress, RenderError> {
        Ok(Progress {
            samples: self.samples,
            error_estimate: Some(0.0),
            done: true,
        })
    }

    fn picture(&mut self) -> Result<Picture, RenderError> {
        let [width, height] = self.size;
        Ok(Picture {
            size: self.size,
            pixels: vec![[0.5, 0.5, 0.5, 1.0]; (width * height) as usize],
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

pub(crate) fn designer(preset: Option<PathBuf>) -> Harness<'static, App> {
    designer_of_size(preset, vec2(1280.0, 720.0))
}

pub(crate) fn designer_of_size(preset: Option<PathBuf>, size: Vec2) -> Harness<'static, App> {
    let setup = Setup {
        preset,
        ..setup(flat())
    };
    window(size, setup)
}

/// A designer whose first frames are shown.
pub(crate) fn window(size: Vec2, setup: Setup) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_step_dt(1.0 / 60.0)
        .build_eframe(|cc| App::new(cc, setup));
    harness.run_steps(3);
    harness
}

/// A window without system dialogs, a design of its own and folders, whose backend nobody has chosen.
pub(crate) fn setup(make: MakeBackend) -> Setup {
    Setup {
        preset: None,
        choice: BackendChoice::Auto,
        make,
        denoiser: Arc::new(|| Err(DenoiseError::NotFound)),
        system_dialogs: false,
        folders: None,
    }
}

/// Flat gray, whichever backend is asked for.
pub(crate) fn flat() -> MakeBackend {
    Arc::new(|_| Ok(Box::new(FlatBackend::default())))
}

/// The program's folders in the home of its user.
pub(crate) fn folders_in(home: &Path) -> Folders {
    Folders {
        config: home.join("config"),
        cache: home.join("cache"),
        state: home.join("state"),
        presets: home.join("presets"),
    }
}

/// Longest time in which what is waited for comes, on a busy machine with a software GPU.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

/// Shows frames as a window does: when one is asked for, by this thread or another, until `done`.
#[track_caller]
pub(crate) fn wait(
    harness: &mut Harness<'_, App>,
    what: &str,
    done: impl Fn(&Harness<'_, App>) -> bool,
) {
    let (ask, asked) = channel();
    let here = std::thread::current().id();
    harness.ctx.set_request_repaint_callback(move |_| {
        // What a frame itself asks for it tells in its output. Nobody may wait any more.
        if std::thread::current().id() != here {
            let _ = ask.send(());
        }
    });
    let end = Instant::now() + PATIENCE;
    loop {
        harness.step();
        if done(harness) {
            return;
        }
        let left = end.saturating_duration_since(Instant::now());
        assert!(!left.is_zero(), "{what} has not come");
        let outputs = harness.output().viewport_output.values();
        let delay = outputs.map(|viewport| viewport.repaint_delay).min();
        // Without an answer it is time for the next frame, or for giving up.
        let _ = asked.recv_timeout(delay.map_or(left, |delay| delay.min(left)));
        asked.try_iter().for_each(drop);
    }
}

/// Shows frames until none of the threads that draw has anything left to do, and for a second of frames more, in which
/// what is due later is asked for.
#[track_caller]
pub(crate) fn rest(harness: &mut Harness<'_, App>) {
    let mut quiet = 0;
    for _ in 0..10_000 {
        harness.step();
        quiet = if harness.state().wait_for_rest(Duration::ZERO) {
            quiet + 1
        } else {
            0
        };
        if quiet == 60 {
            return;
        }
        assert!(harness.state().wait_for_rest(PATIENCE), "it never rests");
    }
    panic!("it never rests");
}

pub(crate) fn design<'h>(harness: &'h Harness<'_, App>) -> &'h Design {
    &harness.state().document().design
}

/// The design that the renderer was last asked to draw.
pub(crate) fn requested(harness: &Harness<'_, App>) -> Arc<Design> {
    Arc::clone(
        &harness
            .state()
            .viewport()
            .requested()
            .expect("a request")
            .design,
    )
}

#[track_caller]
pub(crate) fn click(harness: &mut Harness<'_, App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

/// Opens a panel that starts closed. Scrolled to first, since only what is seen can be clicked.
#[track_caller]
pub(crate) fn open_panel(harness: &mut Harness<'_, App>, title: &str) {
    harness
        .get_by_role_and_label(Role::DisclosureTriangle, title)
        .scroll_to_me();
    harness.run_steps(20);
    harness
        .get_by_role_and_label(Role::DisclosureTriangle, title)
        .click();
    harness.run_steps(20);
}

/// Opens what panels hide because it is seldom needed.
#[track_caller]
pub(crate) fn open_seldom_needed(harness: &mut Harness<'_, App>) {
    for heading in [
        "More about loops",
        "Light in the pile",
        "Fineness of the volume",
        "More about clumps",
        "More about ground yarns",
        "More about quality",
    ] {
        open_panel(harness, heading);
    }
}

/// Types a number into the field of that name.
#[track_caller]
pub(crate) fn type_number(harness: &mut Harness<'_, App>, label: &str, text: &str) {
    let field = harness.get_by_role_and_label(Role::SpinButton, label);
    field.scroll_to_me();
    harness.run_steps(4);
    harness
        .get_by_role_and_label(Role::SpinButton, label)
        .click();
    harness.run_steps(2);
    harness.event(Event::Text(text.into()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}

/// Middle of a cell of the stitch pattern on the screen, row 0 at the bottom.
pub(crate) fn cell(harness: &Harness<'_, App>, col: usize, row: usize) -> Pos2 {
    let rect = harness
        .get_by_role_and_label(Role::Grid, "Stitch pattern")
        .rect();
    let pattern = &design(harness).weave.pattern;
    let side = vec2(
        (rect.width() - 1.0) / pattern.cols() as f32,
        (rect.height() - 1.0) / pattern.rows() as f32,
    );
    let from_corner = vec2(col as f32 + 0.5, row as f32 + 0.5) * side;
    Pos2::new(
        rect.left() + from_corner.x,
        rect.bottom() - 1.0 - from_corner.y,
    )
}

#[track_caller]
pub(crate) fn paint_cell(harness: &mut Harness<'_, App>, col: usize, row: usize) {
    let at = cell(harness, col, row);
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(3);
}

/// Chooses from the menu of that name.
#[track_caller]
pub(crate) fn choose(harness: &mut Harness<'_, App>, name: &str, choice: &str) {
    harness.get_by_role_and_label(Role::ComboBox, name).click();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, choice).click();
    harness.run_steps(4);
}

/// Drags from one place in the window to another, in steps.
pub(crate) fn drag(harness: &mut Harness<'_, App>, from: Pos2, to: Pos2) {
    harness.drag_at(from);
    harness.run_steps(2);
    for step in 1..=4 {
        harness.hover_at(from + (to - from) * (step as f32 / 4.0));
        harness.run_steps(1);
    }
    harness.drop_at(to);
    harness.run_steps(3);
}

/// Replaces the text of the file dialog's path field.
#[track_caller]
pub(crate) fn type_path(harness: &mut Harness<'_, App>, path: &Path) {
    let field = harness.get_by_role_and_label(Role::TextInput, "Path");
    field.focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text(path.to_string_lossy().into_owned()));
    harness.run_steps(3);
}

pub(crate) fn write_chart(path: &Path) {
    let mut chart = image::RgbImage::new(8, 4);
    for (x, _, pixel) in chart.enumerate_pixels_mut() {
        *pixel = image::Rgb(if x < 4 {
            [200, 30, 30]
        } else {
            [250, 250, 240]
        });
    }
    chart.save(path).expect("a chart");
}

/// A file as the window system hands it over when it is dropped.
#[derive(Debug)]
pub(crate) struct Dropped(pub(crate) PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// What a busy machine sees: several events of the pointer within a single frame.
pub(crate) fn in_frames(harness: &mut Harness<'_, App>, frames: Vec<Vec<Event>>) {
    for events in frames {
        harness.input_mut().events.extend(events);
        harness.step();
    }
    harness.run_steps(3);
}

/// The first button, pressed or let go.
pub(crate) fn first_button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    }
}
