//! The viewport: requests a picture of the document from its camera, shows what the render thread has of it, and turns
//! gestures into camera moves.
//!
//! Longer than most files because it is all that the rest of the window may ask of the picture; how each thing is done
//! stands in the files beside it.

mod calibrate;
pub mod camera_moves;
pub mod command;
mod compare;
mod gestures;
mod loupe;
mod net;
mod overlay;
mod picture;
mod readout;
mod screen;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use eframe::CreationContext;
use egui::{Color32, Context, CursorIcon, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2};
use glam::DVec2;
use renderer_core::design::{CameraDesign, Design};
use renderer_core::geometry::Camera;
use renderer_core::gpu::DeviceWatch;
use renderer_core::image::Display;
use renderer_core::render::MAX_SIDE;
use renderer_core::scene::ChartComposer;

use crate::backend::BackendChoice;
use crate::designer::Setup;
use crate::designer::render_thread::draft_lighting::LiveLight;
use crate::designer::render_thread::renderer::for_window;
use crate::designer::render_thread::{News, RenderThread, Stage, ViewRequest, ViewState};
use crate::designer::shell::command::Command;
use crate::designer::widgets::style;
use camera_moves::StandardView;
use compare::{Compare, Snapshot};
use net::NetPoint;
use overlay::Corner;
use picture::{Enlarging, Texture};
pub use readout::Readout;
use screen::Screen;

/// The viewport.
pub struct Viewport {
    /// Where the cloth is seen from.
    pub camera: CameraDesign,
    /// Which light.
    pub light: LiveLight,
    /// Whether the points of a net that pulls the cloth are shown.
    pub shows_net: bool,
    /// The one that the pointer has.
    net_point: Option<NetPoint>,
    thread: RenderThread,
    window: Option<egui_wgpu::RenderState>,
    watch: Option<DeviceWatch>,
    choice: BackendChoice,
    /// How often the backend was chosen.
    attempt: u32,
    /// What the render thread published last.
    state: ViewState,
    texture: Option<Texture>,
    /// The picture with square pixels, while the loupe is on.
    squares: Option<Texture>,
    /// Which picture `texture` and `squares` show.
    versions: [u64; 2],
    /// What the render thread was asked for last.
    requested: Option<ViewRequest>,
    /// Whether that was of the document that is shown: then a change of its size is the user's.
    follows_size: bool,
    /// Size of the picture that is requested, pixels.
    size: [u32; 2],
    /// Height of the area on the screen, pixels.
    height_px: f64,
    screen: Screen,
    compare: Compare,
    has_loupe: bool,
    readout: Option<Readout>,
    composer: ChartComposer,
    /// Height of the picture at true scale, mm, as long as the camera keeps to it.
    true_height_mm: Option<f64>,
    /// The camera before it stood back because the area got smaller, and after.
    stood_back: Option<[CameraDesign; 2]>,
    /// Whether the last scroll came from fingers on a trackpad.
    fingers_scroll: bool,
}

impl Viewport {
    /// A viewport that renders with what the setup makes of its choice, or on the window's own device, and remembers
    /// its settings in the folder.
    pub fn new(setup: &Setup, cc: &CreationContext<'_>, folder: Option<&Path>) -> Self {
        let (make, choice) = (Arc::clone(&setup.make), setup.choice);
        let window = cc.wgpu_render_state.clone();
        let watch = window.as_ref().map(|window| {
            let repaint = cc.egui_ctx.clone();
            DeviceWatch::with_alarm(&window.device, move || repaint.request_repaint())
        });
        let make = for_window(make, window.clone().zip(watch.clone()));
        Self {
            camera: CameraDesign::default(),
            light: LiveLight::default(),
            shows_net: false,
            net_point: None,
            thread: RenderThread::new(make, Arc::clone(&setup.denoiser), cc.egui_ctx.clone()),
            window,
            watch,
            choice,
            attempt: 0,
            state: ViewState::default(),
            texture: None,
            squares: None,
            versions: [0; 2],
            requested: None,
            follows_size: false,
            // Until the window has a size; a design may be opened before.
            size: [800, 600],
            height_px: 600.0,
            screen: Screen::new(folder),
            compare: Compare::default(),
            has_loupe: false,
            readout: None,
            composer: ChartComposer::default(),
            true_height_mm: None,
            stood_back: None,
            fingers_scroll: false,
        }
    }

    /// As [`RenderThread::wait_for_rest`].
    pub fn wait_for_rest(&self, patience: Duration) -> bool {
        self.thread.wait_for_rest(patience)
    }

    /// What was last asked of the render thread.
    pub fn requested(&self) -> Option<&ViewRequest> {
        self.requested.as_ref()
    }

    /// Which backend is chosen.
    pub fn choice(&self) -> BackendChoice {
        self.choice
    }

    /// Renders with this backend; tries it again if it had failed.
    pub fn choose(&mut self, choice: BackendChoice) {
        self.choice = choice;
        self.attempt += 1;
    }

    /// The watch over the window's own device, if there is one.
    pub fn watch(&self) -> Option<&DeviceWatch> {
        self.watch.as_ref()
    }

    /// State of the picture.
    pub fn state(&self) -> &ViewState {
        &self.state
    }

    /// Size of the picture, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What lies under the pointer.
    pub fn readout(&self) -> Option<&Readout> {
        self.readout.as_ref()
    }

    /// Looks at another document from here.
    pub fn look_anew(&mut self, camera: CameraDesign) {
        self.camera = camera;
        self.follows_size = false;
    }

    /// Brings the whole cloth into view.
    pub fn fit(&mut self, design: &Design) {
        camera_moves::fit(&mut self.camera, design, self.size);
    }

    /// Shows a standard view.
    pub fn look_standard(&mut self, view: StandardView, design: &Design) {
        self.camera = camera_moves::standard(view, &self.camera, design, self.size);
    }

    /// Whether the projection is parallel.
    pub fn is_orthographic(&self) -> bool {
        self.camera.orthographic_height.is_some()
    }

    /// Changes between perspective and parallel projection; what the camera looks at keeps its size.
    pub fn toggle_orthographic(&mut self) {
        let height_mm = camera_moves::picture_height_mm(&self.camera);
        if self.camera.orthographic_height.take().is_some() {
            camera_moves::set_distance_for_height(&mut self.camera, height_mm);
        } else {
            self.camera.orthographic_height = Some(height_mm.clamp(1e-3, 1e6));
        }
    }

    /// Shows a millimetre of cloth as a millimetre of screen, in parallel projection, and keeps to it when the window
    /// changes its size.
    pub fn show_true_scale(&mut self, ctx: &Context) {
        let height_mm = self.height_px / self.screen.pixels_per_mm(ctx);
        self.camera.orthographic_height = Some(height_mm);
        self.true_height_mm = Some(height_mm);
    }

    /// How many times as large as the cloth the screen shows it; `None` in perspective, where that differs over the
    /// picture.
    pub fn magnification(&self, ctx: &Context) -> Option<f64> {
        let height_mm = self.camera.orthographic_height?;
        Some(self.height_px / self.screen.pixels_per_mm(ctx) / height_mm)
    }

    /// Whether the user has measured how large the screen's pixels are.
    pub fn screen_is_measured(&self) -> bool {
        self.screen.is_calibrated()
    }

    /// Shows or hides the window that asks how large the screen's pixels are.
    pub fn toggle_calibration(&mut self) {
        let is_calibrating = self.screen.is_calibrating();
        *is_calibrating = !*is_calibrating;
    }

    /// Whether there is a scale bar.
    pub fn has_scale_bar(&self) -> bool {
        self.screen.has_scale_bar()
    }

    /// Shows or hides the scale bar.
    pub fn toggle_scale_bar(&mut self) {
        self.screen.toggle_scale_bar();
    }

    /// Whether the picture is denoised where it can be.
    pub fn denoises(&self) -> bool {
        self.screen.denoises()
    }

    /// Shows the picture denoised, or as it is.
    pub fn toggle_denoising(&mut self) {
        self.screen.toggle_denoising();
    }

    /// Whether there is a loupe.
    pub fn has_loupe(&self) -> bool {
        self.has_loupe
    }

    /// Shows or hides the loupe.
    pub fn toggle_loupe(&mut self) {
        self.has_loupe = !self.has_loupe;
    }

    /// Keeps the present picture, its design and its camera, and shows them beside what comes; false if there is no
    /// picture yet.
    pub fn take_snapshot(&mut self, ctx: &Context) -> bool {
        let (Some(frame), Some(requested)) = (&self.state.picture.frame, &self.requested) else {
            return false;
        };
        let window = self.window.as_ref();
        let Some(kept) = picture::kept(frame, window) else {
            return false;
        };
        let old = self.compare.snapshot.take().map(|old| old.texture);
        Texture::drop_shared(old, window);
        let Some(texture) = Texture::of(&kept, None, ctx, window, Enlarging::Smooth) else {
            return false;
        };
        self.compare.snapshot = Some(Snapshot {
            design: Arc::clone(&requested.design),
            camera: requested.camera.clone(),
            texture,
            size: requested.size,
        });
        self.compare.is_on = true;
        true
    }

    /// Design and camera of the snapshot.
    pub fn snapshot(&self) -> Option<(&Arc<Design>, &CameraDesign)> {
        let snapshot = self.compare.snapshot.as_ref()?;
        Some((&snapshot.design, &snapshot.camera))
    }

    /// Whether the snapshot is shown.
    pub fn is_comparing(&self) -> bool {
        self.compare.shown().is_some()
    }

    /// Shows or hides the snapshot.
    pub fn toggle_compare(&mut self) {
        self.compare.is_on = !self.compare.is_on;
    }

    /// Shows the picture in all of `ui` and takes camera gestures. A design with faults is not rendered; the last
    /// good picture stays.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        design: &Design,
        is_valid: bool,
        commands: &mut Vec<Command>,
    ) -> Response {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let pixels = rect.size() * ui.pixels_per_point();
        let limit = ui.input(|i| i.max_texture_side);
        let limit = MAX_SIDE.min(u32::try_from(limit).unwrap_or(MAX_SIDE));
        let before = std::mem::replace(&mut self.size, fitted([pixels.x, pixels.y], limit));
        self.height_px = f64::from(pixels.y);
        let area = Area {
            rect,
            size: self.size,
        };
        self.keep_true_scale(ui.ctx());
        self.keep_all_in_view(design, before);
        self.follow_size(design);
        self.compare.interact(ui, rect);
        let drags_net = self.drag_net(ui, &response, &area, design, commands);
        self.gestures(ui, &response, &area, design, drags_net, commands);
        if is_valid {
            self.request(design);
        }
        self.read_out(ui, &response, &area, design);
        self.paint(ui, &response, &area, design);
        if self.screen.needs_hint() && self.texture.is_some() {
            overlay::hint(ui, rect);
        }
        calibrate::show(ui.ctx(), &mut self.screen);
        let bar = self.scale_bar_mm(&area);
        let bar = bar.map_or_else(String::new, |mm| format!(" · scale bar {mm} mm"));
        response.widget_info(|| WidgetInfo {
            current_text_value: Some(progress_text(&self.state) + &bar),
            ..WidgetInfo::labeled(Role::Image, true, "Viewport")
        });
        response.on_hover_cursor(CursorIcon::Grab)
    }

    /// Writes what is to be remembered; an error that says what is lost if that cannot be.
    pub fn store_settings(&mut self) -> Result<(), String> {
        self.screen.store()
    }

    /// Goes on at true scale after the window or the measure of its pixels has changed, until the camera is set
    /// otherwise.
    fn keep_true_scale(&mut self, ctx: &Context) {
        if self.true_height_mm.is_none() {
            return;
        }
        if self.camera.orthographic_height == self.true_height_mm {
            self.show_true_scale(ctx);
        } else {
            self.true_height_mm = None;
        }
    }

    /// Stands back where the whole cloth was seen and would be no more because the area has changed from the size
    /// `before`, say when the chart editor opens beside it; and comes back when there is room again, unless the camera
    /// was set otherwise meanwhile.
    fn keep_all_in_view(&mut self, design: &Design, before: [u32; 2]) {
        // Nobody has seen anything yet; at true scale size matters more.
        if self.size == before || self.texture.is_none() || self.true_height_mm.is_some() {
            return;
        }
        let stood_back = self.stood_back.take();
        let nearer = stood_back.filter(|[_, after]| self.camera == *after);
        let all_was_seen =
            nearer.is_some() || camera_moves::shows_all(&self.camera, design, before);
        if let Some([nearer, _]) = nearer {
            self.camera = nearer;
        }
        if all_was_seen && !camera_moves::shows_all(&self.camera, design, self.size) {
            let nearer = self.camera.clone();
            camera_moves::fit(&mut self.camera, design, self.size);
            self.stood_back = Some([nearer, self.camera.clone()]);
        }
    }

    /// Fits cloth that has got another size where all of it was seen before; whoever has gone nearer looks at a detail.
    fn follow_size(&mut self, design: &Design) {
        let keeps_scale = self.true_height_mm.is_some();
        let last = self.requested.as_ref().map(|last| &last.design);
        let Some(last) = last.filter(|last| last.sheet != design.sheet && !keeps_scale) else {
            return;
        };
        if self.follows_size && camera_moves::shows_all(&self.camera, last, self.size) {
            camera_moves::fit(&mut self.camera, design, self.size);
        }
    }

    /// Asks the render thread for a picture of the design, unless that is what it was asked for last.
    fn request(&mut self, design: &Design) {
        self.follows_size = true;
        let last = self.requested.as_ref();
        let known = last.filter(|last| *last.design == *design);
        let request = ViewRequest {
            design: known.map_or_else(|| Arc::new(design.clone()), |w| Arc::clone(&w.design)),
            camera: self.camera.clone(),
            size: self.size,
            // An environment's light is not summed up anew in every frame.
            display: known.map_or_else(|| Display::from(design), |w| w.display),
            choice: self.choice,
            attempt: self.attempt,
            light: self.light,
            denoises: self.denoises(),
        };
        if last != Some(&request) {
            let same_samples = last.is_some_and(|last| request.has_samples_of(last));
            self.thread.send(request.clone(), same_samples);
            self.requested = Some(request);
        }
    }

    /// Takes what the render thread has to show, and returns news of it. Before anything is laid out, so that a frame
    /// shows one state.
    pub fn take_news(&mut self, ctx: &Context) -> Option<News> {
        let reported = self.state.news.0;
        self.state = self.thread.state();
        let version = self.state.picture.version;
        if let Some(frame) = &self.state.picture.frame {
            let window = self.window.as_ref();
            if self.versions[0] != version {
                let old = self.texture.take();
                self.texture = Texture::of(frame, old, ctx, window, Enlarging::Smooth);
                self.versions[0] = version;
            }
            if self.has_loupe && self.versions[1] != version {
                let old = self.squares.take();
                self.squares = Texture::of(frame, old, ctx, window, Enlarging::Pixels);
                self.versions[1] = version;
            }
        }
        let (count, news) = &self.state.news;
        (*count != reported).then(|| news.clone())
    }

    fn read_out(&mut self, ui: &Ui, response: &Response, area: &Area, design: &Design) {
        let camera = Camera::from_design(&self.camera);
        let pointer = response.hover_pos().filter(|_| !response.dragged());
        let readout = pointer
            .zip(self.state.scene.cloth.as_ref())
            .and_then(|(at, cloth)| {
                let design = self.composer.design(design);
                Readout::new(&design, cloth, &camera, area.pixel(at), area.size)
            });
        if readout != self.readout {
            self.readout = readout;
            // The status bar was laid out before.
            ui.ctx().request_repaint();
        }
    }

    /// Millimetres of cloth in a point of the screen, in the plane through what the camera looks at.
    fn mm_per_point(&self, area: &Area) -> f64 {
        camera_moves::picture_height_mm(&self.camera) / f64::from(area.rect.height())
    }

    /// Length of the scale bar, if there is one.
    fn scale_bar_mm(&self, area: &Area) -> Option<f64> {
        let mm = overlay::bar_mm(self.mm_per_point(area));
        (self.screen.has_scale_bar() && mm.is_finite()).then_some(mm)
    }

    fn paint(&self, ui: &Ui, response: &Response, area: &Area, design: &Design) {
        let rect = area.rect;
        let painter = ui.painter_at(rect);
        if let Some(texture) = &self.texture {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            painter.image(texture.id(), rect, whole, Color32::WHITE);
        } else {
            painter.rect_filled(rect, 0.0, style::viewport_ground(ui.visuals()));
        }
        self.compare.paint(ui, &painter, rect);
        self.paint_net(ui, &painter, area, design);
        overlay::note(
            &painter,
            rect.shrink(10.0),
            Corner::LeftBottom,
            &progress_text(&self.state),
        );
        if let Some(mm) = self.scale_bar_mm(area) {
            let length = (mm / self.mm_per_point(area)) as f32;
            let place = rect.shrink(10.0);
            overlay::scale_bar(&painter, place, mm, length, self.is_orthographic());
        }
        if let (true, Some(squares)) = (self.has_loupe, &self.squares) {
            let at = response.hover_pos().unwrap_or(rect.center());
            loupe::paint(&painter, at, squares.id(), rect);
        }
        if response.has_focus() {
            let stroke = egui::Stroke::new(1.0, style::accent(ui.visuals()));
            painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Inside);
        }
    }
}

/// Whole pixels, as many as fit into `limit` on the longer side.
fn fitted([width, height]: [f32; 2], limit: u32) -> [u32; 2] {
    let scale = (limit as f32 / width.max(height)).min(1.0);
    [width, height].map(|side| ((side * scale).round() as u32).clamp(1, limit))
}

/// The picture on the screen.
struct Area {
    rect: Rect,
    size: [u32; 2],
}

impl Area {
    /// Pixel of the picture at a place on the screen.
    fn pixel(&self, at: Pos2) -> DVec2 {
        let share = (at - self.rect.min) / self.rect.size();
        DVec2::new(f64::from(share.x), f64::from(share.y))
            * DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]))
    }
}

/// Samples and time, as the corner of the picture and the status bar show them.
pub fn progress_text(state: &ViewState) -> String {
    let picture = &state.picture;
    match (state.stage, &picture.frame) {
        (Stage::Compiling, _) => return "Planting loops…".into(),
        (Stage::Idle, None) => return String::new(),
        (Stage::Rendering(_), None) => return "First picture…".into(),
        (Stage::Idle | Stage::Rendering(_), Some(_)) => {}
    }
    let seconds = seconds_text(picture.seconds);
    if picture.is_reduced {
        return format!("preview · {seconds}");
    }
    let samples = picture.progress.samples;
    let plural = if samples == 1 { "" } else { "s" };
    let done = if picture.progress.done {
        " · done"
    } else {
        ""
    };
    format!("{samples} sample{plural} · {seconds}{done}")
}

/// `0.42 s`, `12 s`, `3 min 05 s`.
pub fn seconds_text(seconds: f64) -> String {
    if seconds < 10.0 {
        format!("{seconds:.2} s")
    } else if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else {
        let whole = seconds.round() as u64;
        format!("{} min {:02} s", whole / 60, whole % 60)
    }
}
