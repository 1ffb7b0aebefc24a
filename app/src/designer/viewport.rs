//! The viewport: wishes a picture of the document from its camera, shows what the render thread has of it, and turns
//! drags, wheel and keys into camera moves.

use std::sync::Arc;

use eframe::CreationContext;
use egui::{
    Align2, Color32, CursorIcon, EventFilter, FontId, Key, Modifiers, PointerButton, Pos2, Rect,
    Response, Role, Sense, TextureHandle, TextureId, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use glam::DVec2;
use renderer_core::design::{CameraDesign, Design};
use renderer_core::gpu::DeviceWatch;
use renderer_core::image::Display;
use renderer_core::render::MAX_SIDE;

use super::camera_moves::{self, StandardView};
use super::live_light::LiveLight;
use super::render_thread::{Activity, RenderThread, Shown, Wish};
use super::renderer::{MakeBackend, Shot, for_window};
use super::style;
use crate::backend::BackendChoice;

/// Degrees of orbit for a point of drag.
const ORBIT_PER_POINT: f64 = 0.35;
/// Degrees of orbit for an arrow key.
const ORBIT_PER_KEY: f64 = 5.0;
/// Share of the picture's height that a key pans.
const PAN_PER_KEY: f64 = 0.05;
/// Zoom of a key.
const ZOOM_PER_KEY: f64 = 1.2;

/// The viewport.
pub struct Viewport {
    /// Where the cloth is seen from.
    pub camera: CameraDesign,
    /// Which light.
    pub light: LiveLight,
    thread: RenderThread,
    window: Option<egui_wgpu::RenderState>,
    watch: Option<DeviceWatch>,
    choice: BackendChoice,
    /// How often the backend was chosen.
    attempt: u32,
    shown: Shown,
    texture: Option<Texture>,
    texture_version: u64,
    wish: Option<Wish>,
    size: [u32; 2],
}

impl Viewport {
    /// A viewport that renders with what `make` makes of `choice`, or on the window's own device.
    pub fn new(make: MakeBackend, choice: BackendChoice, cc: &CreationContext<'_>) -> Self {
        let window = cc.wgpu_render_state.clone();
        let watch = window.as_ref().map(|window| {
            let repaint = cc.egui_ctx.clone();
            DeviceWatch::with_alarm(&window.device, move || repaint.request_repaint())
        });
        let make = for_window(make, window.clone().zip(watch.clone()));
        Self {
            camera: CameraDesign::default(),
            light: LiveLight::default(),
            thread: RenderThread::new(make, cc.egui_ctx.clone()),
            window,
            watch,
            choice,
            attempt: 0,
            shown: Shown::default(),
            texture: None,
            texture_version: 0,
            wish: None,
            // Until the window has told; a design may be opened before.
            size: [800, 600],
        }
    }

    /// What was last asked of the render thread.
    pub fn wish(&self) -> Option<&Wish> {
        self.wish.as_ref()
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
    pub fn shown(&self) -> &Shown {
        &self.shown
    }

    /// Size of the picture, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Brings the whole cloth into view.
    pub fn fit(&mut self, design: &Design) {
        camera_moves::fit(&mut self.camera, design, self.size);
    }

    /// Shows a standard view.
    pub fn look_standard(&mut self, view: StandardView, design: &Design) {
        self.camera = camera_moves::standard(view, &self.camera, design, self.size);
    }

    /// Shows the picture in all of `ui` and takes camera gestures. A design with faults is not rendered; the last
    /// good picture stays.
    pub fn show(&mut self, ui: &mut Ui, design: &Design, is_valid: bool) -> Response {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let pixels = rect.size() * ui.pixels_per_point();
        let limit = ui.input(|i| i.max_texture_side);
        let limit = MAX_SIDE.min(u32::try_from(limit).unwrap_or(MAX_SIDE));
        self.size = fitted([pixels.x, pixels.y], limit);
        let picture = Area {
            rect,
            size: self.size,
        };
        self.pointer(ui, &response, &picture);
        self.wheel(ui, &response, &picture);
        self.keys(ui, &response, &picture, design);
        if is_valid {
            self.wish_for(design);
        }
        self.paint(ui, &response, rect);
        response.widget_info(|| WidgetInfo {
            current_text_value: Some(progress_text(&self.shown)),
            ..WidgetInfo::labeled(Role::Image, true, "Viewport")
        });
        response.on_hover_cursor(CursorIcon::Grab)
    }

    fn wish_for(&mut self, design: &Design) {
        let known = self.wish.as_ref().filter(|wish| *wish.design == *design);
        let wish = Wish {
            design: known.map_or_else(|| Arc::new(design.clone()), |w| Arc::clone(&w.design)),
            camera: self.camera.clone(),
            size: self.size,
            display: Display::from(&design.view),
            choice: self.choice,
            attempt: self.attempt,
            light: self.light,
        };
        if self.wish.as_ref() == Some(&wish) {
            return;
        }
        let same_picture = self.wish.as_ref().is_some_and(|last| {
            let mut design = Design::clone(&last.design);
            design.view = wish.design.view.clone();
            design == *wish.design
                && (
                    &last.camera,
                    last.size,
                    last.choice,
                    last.attempt,
                    last.light,
                ) == (
                    &wish.camera,
                    wish.size,
                    wish.choice,
                    wish.attempt,
                    wish.light,
                )
        });
        self.thread.send(wish.clone(), same_picture);
        self.wish = Some(wish);
    }

    /// Takes what the render thread has to show, and returns what it has to tell. Before anything is laid out, so that a
    /// frame shows one state.
    pub fn take_news(&mut self, ctx: &egui::Context) -> Option<String> {
        let told = self.shown.news.0;
        self.shown = self.thread.shown();
        if self.shown.version != self.texture_version {
            self.texture_version = self.shown.version;
            if let Some(shot) = &self.shown.image {
                let old = self.texture.take();
                self.texture = Texture::of(shot, old, ctx, self.window.as_ref());
            }
        }
        let (count, news) = &self.shown.news;
        (*count != told).then(|| news.clone())
    }

    fn pointer(&mut self, ui: &Ui, response: &Response, picture: &Area) {
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        let delta = response.drag_delta();
        let Some(at) = response.interact_pointer_pos() else {
            return;
        };
        if delta == egui::Vec2::ZERO {
            return;
        }
        let shift = ui.input(|i| i.modifiers.shift);
        let pans = response.dragged_by(PointerButton::Middle)
            || response.dragged_by(PointerButton::Secondary)
            || shift;
        if pans {
            ui.set_cursor_icon(CursorIcon::Move);
            let (from, to) = (picture.pixel(at - delta), picture.pixel(at));
            camera_moves::pan(&mut self.camera, from, to, picture.size);
        } else {
            ui.set_cursor_icon(CursorIcon::Grabbing);
            camera_moves::orbit(
                &mut self.camera,
                -f64::from(delta.x) * ORBIT_PER_POINT,
                f64::from(delta.y) * ORBIT_PER_POINT,
            );
        }
    }

    fn wheel(&mut self, ui: &Ui, response: &Response, picture: &Area) {
        let Some(at) = response.hover_pos() else {
            return;
        };
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        let factor = f64::from(pinch) * (f64::from(scroll) / 300.0).exp();
        if factor != 1.0 {
            camera_moves::zoom(&mut self.camera, factor, picture.pixel(at), picture.size);
        }
    }

    fn keys(&mut self, ui: &Ui, response: &Response, picture: &Area, design: &Design) {
        let modifiers = ui.input(|i| i.modifiers);
        // With Ctrl, + and − are the size of the interface.
        if !response.has_focus() || modifiers.command {
            return;
        }
        let keep = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
        let presses = |key| ui.input(|i| i.num_presses(key) as f64);
        let right = presses(Key::ArrowRight) - presses(Key::ArrowLeft);
        let up = presses(Key::ArrowUp) - presses(Key::ArrowDown);
        let nearer = presses(Key::Plus) + presses(Key::Equals) - presses(Key::Minus);
        let centre = DVec2::new(f64::from(picture.size[0]), f64::from(picture.size[1])) / 2.0;
        if nearer != 0.0 {
            let factor = ZOOM_PER_KEY.powf(nearer);
            camera_moves::zoom(&mut self.camera, factor, centre, picture.size);
        }
        if modifiers == Modifiers::SHIFT {
            let step = PAN_PER_KEY * f64::from(picture.size[1]) * DVec2::new(right, -up);
            if step != DVec2::ZERO {
                camera_moves::pan(&mut self.camera, centre + step, centre, picture.size);
            }
        } else if modifiers.is_none() && (right, up) != (0.0, 0.0) {
            camera_moves::orbit(&mut self.camera, right * ORBIT_PER_KEY, up * ORBIT_PER_KEY);
        }
        if modifiers.is_none() && presses(Key::Home) + presses(Key::F) > 0.0 {
            self.fit(design);
        }
    }

    fn paint(&self, ui: &Ui, response: &Response, rect: Rect) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, style::viewport_ground(ui.visuals()));
        if let Some(texture) = &self.texture {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            painter.image(texture.id(), rect, whole, Color32::WHITE);
        }
        if response.has_focus() {
            let stroke = egui::Stroke::new(1.0, style::accent(ui.visuals()));
            painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Inside);
        }
        note(&painter, rect, &progress_text(&self.shown));
    }
}

/// Whole pixels, as many as fit into `limit` on the longer side.
fn fitted([width, height]: [f32; 2], limit: u32) -> [u32; 2] {
    let scale = (limit as f32 / width.max(height)).min(1.0);
    [width, height].map(|side| ((side * scale).round() as u32).clamp(1, limit))
}

/// The picture as egui draws it.
enum Texture {
    /// egui's own.
    Owned(TextureHandle),
    /// One that the renderer draws into, on the window's device, and egui's name for it.
    Shared(wgpu::Texture, TextureId),
}

impl Texture {
    /// A texture that shows `shot`: the old one if that can be made to.
    fn of(
        shot: &Shot,
        old: Option<Self>,
        ctx: &egui::Context,
        window: Option<&egui_wgpu::RenderState>,
    ) -> Option<Self> {
        let free = |id: TextureId| {
            if let Some(window) = window {
                window.renderer.write().free_texture(&id);
            }
        };
        match (shot, old) {
            (Shot::Pixels(image), Some(Self::Owned(mut texture))) => {
                texture.set(Arc::clone(image), TextureOptions::LINEAR);
                Some(Self::Owned(texture))
            }
            (Shot::Pixels(image), old) => {
                if let Some(Self::Shared(_, id)) = old {
                    free(id);
                }
                let image = Arc::clone(image);
                let texture = ctx.load_texture("picture", image, TextureOptions::LINEAR);
                Some(Self::Owned(texture))
            }
            (Shot::Texture(texture), Some(Self::Shared(shown, id))) if *texture == shown => {
                Some(Self::Shared(shown, id))
            }
            (Shot::Texture(texture), old) => {
                if let Some(Self::Shared(_, id)) = old {
                    free(id);
                }
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                let window = window?;
                let linear = wgpu::FilterMode::Linear;
                let mut renderer = window.renderer.write();
                let id = renderer.register_native_texture(&window.device, &view, linear);
                Some(Self::Shared(texture.clone(), id))
            }
        }
    }

    fn id(&self) -> TextureId {
        match self {
            Self::Owned(texture) => texture.id(),
            Self::Shared(_, id) => *id,
        }
    }
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

/// Samples and time, as the corner of the picture and the status bar tell them.
pub fn progress_text(shown: &Shown) -> String {
    if shown.image.is_none() {
        return match shown.activity {
            Activity::Idle => String::new(),
            Activity::Compiling => "Planting loops…".into(),
            Activity::Rendering => "First picture…".into(),
        };
    }
    if shown.activity == Activity::Compiling {
        return "Planting loops…".into();
    }
    if shown.is_reduced {
        return format!("preview · {}", seconds_text(shown.seconds));
    }
    let samples = shown.progress.samples;
    let plural = if samples == 1 { "" } else { "s" };
    let done = if shown.progress.done { " · done" } else { "" };
    format!(
        "{samples} sample{plural} · {}{done}",
        seconds_text(shown.seconds)
    )
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

/// A legible line in the lower left corner, whatever the picture's colours.
fn note(painter: &egui::Painter, rect: Rect, text: &str) {
    if text.is_empty() {
        return;
    }
    let font = FontId::proportional(12.0);
    let galley = painter.layout_no_wrap(text.into(), font, Color32::from_gray(0xf2));
    let at = Align2::LEFT_BOTTOM.anchor_size(
        rect.left_bottom() + vec2(10.0, -10.0),
        galley.size() + vec2(12.0, 6.0),
    );
    painter.rect_filled(at, 4.0, Color32::from_black_alpha(150));
    painter.galley(at.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}
