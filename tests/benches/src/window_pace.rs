//! Measures how smoothly the window goes while it renders: the times between its frames, against those of the same
//! window with nothing to render.
//!
//! The designer itself runs, in a real window that asks for one frame after the other. Frames are timed in four phases:
//! the picture is done and nothing runs; the picture is being rendered; the design changes three times a second, so
//! that scenes are made and pictures begun all the time; a pattern of 64 × 64 stitches is painted, a cell in every
//! frame.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Context, Ui};
use renderer_core::design::Pattern;
use towel_designer::backend::{self, BackendChoice};
use towel_designer::denoiser;
use towel_designer::designer::{App, Setup, Stage, in_a_window};

/// Frames at the beginning of a phase that are not counted: caches fill, pipelines are made.
const SETTLING: Duration = Duration::from_millis(800);
/// Time between two edits.
const EDITS: Duration = Duration::from_millis(333);
/// Columns and rows of the pattern that is painted.
const PAINTED_SIDE: usize = 64;
/// Longest wait for the first picture.
const PATIENCE: Duration = Duration::from_secs(300);

/// What happens during a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// The preset is being opened and drawn once.
    Opening,
    /// Nothing but frames.
    Idle,
    /// The picture is being rendered.
    Rendering,
    /// The design changes all the time.
    Editing,
    /// A large pattern is painted, without a pause.
    Painting,
}

/// The times between frames of a phase.
#[derive(Debug, Clone)]
pub struct Frames {
    /// Which phase.
    pub phase: Phase,
    /// From frame to frame, seconds, shortest first.
    pub seconds: Vec<f64>,
    /// Samples of the picture at the end.
    pub samples: u32,
}

impl Frames {
    /// The time that this share of the frames does not exceed, seconds.
    pub fn percentile(&self, share: f64) -> f64 {
        let last = self.seconds.len().saturating_sub(1);
        let index = (share * last as f64).round() as usize;
        self.seconds.get(index).copied().unwrap_or(f64::NAN)
    }
}

/// What was measured.
#[derive(Debug, Clone, Default)]
pub struct Pace {
    /// Idle, rendering, editing, painting.
    pub phases: Vec<Frames>,
    /// What rendered.
    pub device: String,
    /// What drew the window.
    pub adapter: String,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
}

/// Opens the designer with a preset and measures for `time` a phase.
///
/// # Errors
/// When no window can be opened or the preset cannot be drawn.
pub fn measure(preset: PathBuf, choice: BackendChoice, time: Duration) -> anyhow::Result<Pace> {
    let result: Arc<Mutex<Result<Pace, String>>> =
        Arc::new(Mutex::new(Err("the window was closed".into())));
    let for_app = Arc::clone(&result);
    in_a_window(move |cc| {
        let setup = Setup {
            preset: Some(preset),
            choice,
            make: Arc::new(backend::make),
            denoiser: Arc::new(denoiser::make),
            system_dialogs: false,
            folders: None,
        };
        let adapter = cc.wgpu_render_state.as_ref();
        let adapter = adapter.map_or_else(String::new, |state| state.adapter.get_info().name);
        Box::new(Measured {
            app: App::new(cc, setup),
            time,
            phase: Phase::Opening,
            since: Instant::now(),
            last_frame: None,
            last_edit: Instant::now(),
            seconds: Vec::new(),
            painted: 0,
            pace: Pace {
                adapter,
                ..Pace::default()
            },
            result: for_app,
        })
    })?;
    let result = result.lock().unwrap_or_else(PoisonError::into_inner);
    result.clone().map_err(anyhow::Error::msg)
}

/// The designer with a stop watch.
struct Measured {
    app: App,
    time: Duration,
    phase: Phase,
    /// When the phase began.
    since: Instant,
    last_frame: Option<Instant>,
    last_edit: Instant,
    seconds: Vec<f64>,
    /// The cell of the pattern that is painted next.
    painted: usize,
    pace: Pace,
    result: Arc<Mutex<Result<Pace, String>>>,
}

impl eframe::App for Measured {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        let now = Instant::now();
        let last = self.last_frame.replace(now);
        let is_settled = self.phase != Phase::Opening && self.since.elapsed() > SETTLING;
        if let (Some(last), true) = (last, is_settled) {
            self.seconds.push((now - last).as_secs_f64());
        }
        self.app.ui(ui, frame);
        if self.app.is_quitting() {
            return;
        }
        match self.next() {
            Ok(false) => ctx.request_repaint(),
            Ok(true) => {
                let pace = std::mem::take(&mut self.pace);
                self.end(&ctx, Ok(pace));
            }
            Err(error) => self.end(&ctx, Err(error)),
        }
    }
}

impl Measured {
    /// Goes on to the next phase when it is time; true at the end.
    fn next(&mut self) -> Result<bool, String> {
        let state = self.app.viewport().state();
        if let Some(error) = &state.error {
            return Err(error.clone());
        }
        let is_done = state.stage == Stage::Idle && state.picture.progress.done;
        let is_whole = is_done && !state.picture.is_reduced;
        let is_over = self.since.elapsed() > SETTLING + self.time;
        let is_open = self.app.document().path().is_some();
        let is_loading = self.app.is_loading();
        let design = &mut self.app.document_mut().design;
        match self.phase {
            Phase::Opening => {
                (design.quality.samples, design.quality.error) = (1, 0.0);
                if is_open && is_whole {
                    self.enter(Phase::Idle);
                } else if !is_loading && !is_open {
                    return Err("the preset cannot be opened; towel-designer check says why".into());
                } else if self.since.elapsed() > PATIENCE {
                    return Err(format!("no picture within {} s", PATIENCE.as_secs()));
                }
            }
            Phase::Idle if is_over => {
                // The same picture goes on.
                design.quality.samples = 1 << 20;
                self.enter(Phase::Rendering);
            }
            Phase::Rendering if is_over => self.enter(Phase::Editing),
            Phase::Editing if is_over => {
                let pattern = &mut design.weave.pattern;
                let repeat = |col, row| pattern.at(col as i64, row as i64);
                *pattern = Pattern::from_fn(PAINTED_SIDE, PAINTED_SIDE, repeat);
                self.enter(Phase::Painting);
            }
            Phase::Painting if is_over => {
                self.close_phase();
                return Ok(true);
            }
            Phase::Painting => {
                let pattern = &mut design.weave.pattern;
                let (col, row) = (self.painted % PAINTED_SIDE, self.painted / PAINTED_SIDE);
                let old = pattern.at(col as i64, row as i64);
                pattern.set(col, row, if old == 7 { 0 } else { 7 });
                self.painted = (self.painted + 1) % (PAINTED_SIDE * PAINTED_SIDE);
            }
            Phase::Editing if self.last_edit.elapsed() > EDITS => {
                self.last_edit = Instant::now();
                let turbulence = &mut design.turbulence;
                turbulence.seed = turbulence.seed.wrapping_add(1);
            }
            Phase::Idle | Phase::Rendering | Phase::Editing => {}
        }
        Ok(false)
    }

    fn enter(&mut self, phase: Phase) {
        self.close_phase();
        self.phase = phase;
        self.since = Instant::now();
    }

    fn close_phase(&mut self) {
        let mut seconds = std::mem::take(&mut self.seconds);
        if self.phase == Phase::Opening {
            return;
        }
        seconds.sort_by(f64::total_cmp);
        let state = self.app.viewport().state();
        self.pace.phases.push(Frames {
            phase: self.phase,
            seconds,
            samples: state.picture.progress.samples,
        });
        self.pace.size = self.app.viewport().size();
        if let Some(device) = &state.device {
            self.pace.device = format!("{}: {}", device.kind.name(), device.name);
        }
    }

    fn end(&mut self, ctx: &Context, result: Result<Pace, String>) {
        *self.result.lock().unwrap_or_else(PoisonError::into_inner) = result;
        self.app.quit(ctx);
    }
}
