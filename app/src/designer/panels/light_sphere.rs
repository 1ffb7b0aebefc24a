//! Suns on a sphere that they light: the cloth's sky seen from straight above, its far edge at the top. A sun over the
//! middle shines down on the cloth, one at the rim grazes it. Each shows as the disc it is in the sky; suns below the
//! cloth's plane show hollow, through the sphere.

use egui::{
    Align2, Color32, ColorImage, CursorIcon, FontId, Key, Pos2, Rect, Response, Role, Sense, Shape,
    Stroke, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use glam::DVec3;
use renderer_core::design::{Colour, Environment, EnvironmentKind, Light, Sun};

use crate::designer::style;
use crate::designer::widgets::arrow_keys;

/// Which sun is selected, whether it is held, and the sphere's picture.
#[derive(Default)]
pub struct LightSphere {
    /// Index of the selected sun.
    pub selected: usize,
    is_held: bool,
    shading: Option<(Shading, TextureHandle)>,
}

/// What the picture of the sphere shows.
#[derive(Debug, Clone, PartialEq)]
struct Shading {
    suns: Vec<Sun>,
    /// Light from straight above, from the horizon and from below.
    sky: [[f64; 3]; 3],
}

/// Largest radius of the sphere, points.
const RADIUS: f32 = 64.0;
/// Room around it, for suns at the rim.
const MARGIN: f32 = 12.0;
/// Pixels of the sphere's picture.
const PIXELS: usize = 160;
/// How near the pointer must be to a sun to take it, points.
const REACH: f32 = 11.0;
/// Degrees for an arrow key.
const DEGREES_PER_KEY: f64 = 5.0;

/// Shows the sphere and moves suns on it; true when one was moved.
pub fn show(ui: &mut Ui, sphere: &mut LightSphere, light: &mut Light) -> bool {
    let side = 2.0 * (RADIUS + MARGIN);
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::click_and_drag());
    let disc = Disc {
        centre: rect.center(),
        radius: RADIUS,
    };
    sphere.selected = sphere.selected.min(light.sun.len().saturating_sub(1));
    let before = light.sun.clone();
    pointer(ui, sphere, &response, &disc, &mut light.sun);
    keyboard(ui, sphere, &response, &mut light.sun);
    paint(ui, sphere, &response, &disc, light);
    let text = light.sun.get(sphere.selected).map_or_else(
        || "no sun".into(),
        |sun| {
            format!(
                "sun {} of {}: azimuth {:.0}°, elevation {:.0}°",
                sphere.selected + 1,
                light.sun.len(),
                sun.azimuth,
                sun.elevation
            )
        },
    );
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(text.clone()),
        ..WidgetInfo::labeled(Role::Canvas, ui.is_enabled(), "Suns on a sphere")
    });
    response.on_hover_cursor(CursorIcon::Crosshair).on_hover_text(
        "Drag a sun over the sphere: in the middle it shines straight down on the cloth, at the rim it grazes it; up is the \
         cloth's far edge. Keys: arrows move the sun, Page up and Page down choose another.",
    );
    light.sun != before
}

/// The sphere on the screen.
struct Disc {
    centre: Pos2,
    radius: f32,
}

impl Disc {
    fn place(&self, direction: DVec3) -> Pos2 {
        let offset = vec2(direction.x as f32, -direction.y as f32);
        self.centre + offset * self.radius
    }

    /// Direction of the sphere's point there, or of the nearest at its rim; x and y alone.
    fn direction(&self, at: Pos2) -> [f64; 2] {
        let offset = (at - self.centre) / self.radius;
        let offset = offset / offset.length().max(1.0);
        [f64::from(offset.x), f64::from(-offset.y)]
    }
}

fn direction(sun: &Sun) -> DVec3 {
    let (azimuth, elevation) = (sun.azimuth.to_radians(), sun.elevation.to_radians());
    let across = elevation.cos();
    DVec3::new(
        azimuth.cos() * across,
        azimuth.sin() * across,
        elevation.sin(),
    )
}

fn pointer(ui: &Ui, sphere: &mut LightSphere, response: &Response, disc: &Disc, suns: &mut [Sun]) {
    let is_down = response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down());
    let Some(at) = response.interact_pointer_pos().filter(|_| is_down) else {
        sphere.is_held = false;
        return;
    };
    if !sphere.is_held {
        sphere.is_held = true;
        response.request_focus();
        let distance = |sun: &Sun| disc.place(direction(sun)).distance(at);
        let nearest =
            (0..suns.len()).min_by(|&a, &b| distance(&suns[a]).total_cmp(&distance(&suns[b])));
        if let Some(near) = nearest.filter(|&index| distance(&suns[index]) < REACH) {
            // Taken where it is; it moves when the pointer does.
            sphere.selected = near;
            return;
        }
    } else if response.drag_delta() == Vec2::ZERO {
        return;
    }
    if let Some(sun) = suns.get_mut(sphere.selected) {
        move_to(sun, disc.direction(at));
    }
}

/// Moves a sun to where x and y of its direction are these, above the cloth or below as it was.
fn move_to(sun: &mut Sun, [x, y]: [f64; 2]) {
    let tenths = |degrees: f64| (degrees * 10.0).round() / 10.0;
    let across = x.hypot(y);
    let elevation = tenths(across.min(1.0).acos().to_degrees());
    sun.elevation = elevation.copysign(sun.elevation);
    // Straight above, the azimuth means nothing, and keeps what it was.
    if across > 1e-3 {
        sun.azimuth = tenths(y.atan2(x).to_degrees());
    }
}

fn keyboard(ui: &Ui, sphere: &mut LightSphere, response: &Response, suns: &mut [Sun]) {
    let Some(arrows) = arrow_keys(ui, response) else {
        return;
    };
    let presses = |key| ui.input(|i| i.num_presses(key));
    let last = suns.len().saturating_sub(1);
    sphere.selected = (sphere.selected + presses(Key::PageDown)).min(last);
    sphere.selected = sphere.selected.saturating_sub(presses(Key::PageUp));
    let Some(sun) = suns.get_mut(sphere.selected).filter(|_| arrows != [0, 0]) else {
        return;
    };
    let [right, up] = arrows.map(|presses| f64::from(presses) * DEGREES_PER_KEY);
    // Azimuths grow against the clock as the sphere is seen; the right key goes with it.
    let azimuth = sun.azimuth - right;
    sun.azimuth = if azimuth.abs() > 180.0 {
        azimuth - 360.0 * azimuth.signum()
    } else {
        azimuth
    };
    sun.elevation = (sun.elevation + up).clamp(-90.0, 90.0);
}

fn paint(ui: &Ui, sphere: &mut LightSphere, response: &Response, disc: &Disc, light: &Light) {
    let visuals = ui.visuals();
    let painter = ui.painter_at(response.rect);
    let shading = Shading {
        suns: light.sun.clone(),
        sky: sky(&light.environment),
    };
    if sphere.shading.as_ref().is_none_or(|(of, _)| *of != shading) {
        let options = TextureOptions::LINEAR;
        let texture = ui.ctx().load_texture("sphere", shaded(&shading), options);
        sphere.shading = Some((shading, texture));
    }
    let ball = Rect::from_center_size(disc.centre, Vec2::splat(2.0 * disc.radius));
    let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    if let Some((_, texture)) = &sphere.shading {
        painter.image(texture.id(), ball, whole, Color32::WHITE);
    }
    let rim = if response.has_focus() {
        Stroke::new(2.0, style::accent(visuals))
    } else {
        Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color)
    };
    painter.circle_stroke(disc.centre, disc.radius, rim);
    let edge = disc.centre + vec2(0.0, disc.radius + 1.0);
    let font = FontId::proportional(10.0);
    let colour = visuals.weak_text_color();
    painter.text(edge, Align2::CENTER_TOP, "near edge", font, colour);
    // The selected sun last, so that none lies over it.
    let others = (0..light.sun.len()).filter(|&index| index != sphere.selected);
    for index in others.chain(Some(sphere.selected)) {
        if let Some(sun) = light.sun.get(index) {
            paint_sun(&painter, visuals, disc, sun, index == sphere.selected);
        }
    }
    if light.sun.is_empty() {
        let font = FontId::proportional(12.0);
        let colour = visuals.strong_text_color();
        painter.text(disc.centre, Align2::CENTER_CENTER, "No sun", font, colour);
    }
}

fn paint_sun(
    painter: &egui::Painter,
    visuals: &egui::Visuals,
    disc: &Disc,
    sun: &Sun,
    is_selected: bool,
) {
    let towards = direction(sun);
    let Colour([r, g, b]) = sun.colour;
    let fill = Color32::from_rgb(r, g, b);
    // The edge of its disc in the sky, where it is on this side of the sphere.
    let (sin, cos) = (sun.angular_diameter / 2.0).to_radians().sin_cos();
    let (first, second) = towards.any_orthonormal_pair();
    let side = if sun.elevation < 0.0 { -1.0 } else { 1.0 };
    let points: Vec<Pos2> = (0..48)
        .map(|k| f64::from(k) * std::f64::consts::TAU / 48.0)
        .map(|t| towards * cos + (first * t.cos() + second * t.sin()) * sin)
        .map(|edge| {
            // Beyond the rim it goes on behind; shown at the rim.
            let hidden = edge.z * side < 0.0;
            let flat = DVec3::new(edge.x, edge.y, 0.0);
            disc.place(if hidden {
                flat.normalize_or_zero()
            } else {
                edge
            })
        })
        .collect();
    let line = Stroke::new(1.0, visuals.strong_text_color().gamma_multiply(0.7));
    painter.add(Shape::convex_polygon(
        points,
        fill.gamma_multiply(0.35),
        line,
    ));
    let at = disc.place(towards);
    let outline = Stroke::new(1.5, Color32::from_gray(0x20));
    let core = if side < 0.0 {
        Color32::TRANSPARENT
    } else {
        fill
    };
    painter.circle(at, 4.5, core, outline);
    if side < 0.0 {
        painter.circle_stroke(at, 4.5, Stroke::new(2.0, fill));
    }
    if is_selected {
        let accent = Stroke::new(2.0, style::accent(visuals));
        painter.circle_stroke(at, 8.0, accent);
    }
}

/// Light from straight above, from the horizon and from below, as far as a small sphere shows it: an image counts as its
/// brightness alone.
fn sky(environment: &Environment) -> [[f64; 3]; 3] {
    let of = |colour: Colour| colour.linear().map(|c| c * environment.radiance);
    match environment.kind {
        EnvironmentKind::Constant => [of(environment.colour); 3],
        EnvironmentKind::Gradient => [
            of(environment.zenith),
            of(environment.horizon),
            of(environment.ground),
        ],
        EnvironmentKind::Image => [[0.5 * environment.radiance; 3]; 3],
    }
}

/// A matt gray sphere in that light, seen from above.
fn shaded(shading: &Shading) -> ColorImage {
    let [zenith, horizon, ground] = shading.sky;
    let suns: Vec<(DVec3, [f64; 3])> = shading
        .suns
        .iter()
        .map(|sun| {
            let strength = sun.irradiance / std::f64::consts::PI;
            (direction(sun), sun.colour.linear().map(|c| c * strength))
        })
        .collect();
    let colour = |x: f64, y: f64| -> Color32 {
        let across = x * x + y * y;
        let normal = DVec3::new(x, y, (1.0 - across).max(0.0).sqrt());
        // A point that looks to the side sees as much sky as ground.
        let up = normal.z;
        let light: [f64; 3] = std::array::from_fn(|c| {
            let around = 0.5 * (horizon[c] + 0.5 * (zenith[c] + ground[c]));
            let from_sky = around + up * (0.5 * (zenith[c] + horizon[c]) - around);
            let from_suns = suns
                .iter()
                .map(|(towards, light)| light[c] * normal.dot(*towards).max(0.0));
            0.6 * (from_sky + from_suns.sum::<f64>())
        });
        let Colour([r, g, b]) = Colour::from_linear(light);
        // One pixel of softness at the rim.
        let coverage = ((1.0 - across.sqrt()) * PIXELS as f64 / 2.0).clamp(0.0, 1.0);
        Color32::from_rgba_unmultiplied(r, g, b, (255.0 * coverage).round() as u8)
    };
    let at = |k: usize| 2.0 * (k as f64 + 0.5) / PIXELS as f64 - 1.0;
    let pixels = (0..PIXELS * PIXELS).map(|k| colour(at(k % PIXELS), -at(k / PIXELS)));
    ColorImage::new([PIXELS, PIXELS], pixels.collect())
}
