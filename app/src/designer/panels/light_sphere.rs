//! Suns and area lights on a sphere that they light: the cloth's sky seen from straight above, its far edge at the top.
//! A light over the middle shines down on the cloth, one at the rim grazes it. Each shows as the disc or the rectangle
//! that it is in the sky; lights below the cloth's plane show hollow, through the sphere.

use egui::{
    Align2, Color32, ColorImage, CursorIcon, FontId, Key, Pos2, Rect, Response, Role, Sense, Shape,
    Stroke, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use glam::DVec3;
use renderer_core::design::{Colour, Environment, EnvironmentKind, Light};

use crate::designer::widgets::arrow_keys;
use crate::designer::widgets::style;

/// A light by its kind and its number among its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightSource {
    /// A sun.
    Sun(usize),
    /// An area light.
    Area(usize),
}

impl LightSource {
    /// All lights of a design: suns, then area lights.
    pub fn all(light: &Light) -> impl Iterator<Item = Self> + use<> {
        let areas = (0..light.area.len()).map(Self::Area);
        (0..light.sun.len()).map(Self::Sun).chain(areas)
    }

    /// The light at a place in that order.
    pub fn of(light: &Light, index: usize) -> Option<Self> {
        Self::all(light).nth(index)
    }

    /// What it is called.
    pub fn name(self) -> String {
        match self {
            Self::Sun(index) => format!("Sun {}", index + 1),
            Self::Area(index) => format!("Area light {}", index + 1),
        }
    }

    fn azimuth_and_elevation(self, light: &mut Light) -> [&mut f64; 2] {
        match self {
            Self::Sun(index) => {
                let sun = &mut light.sun[index];
                [&mut sun.azimuth, &mut sun.elevation]
            }
            Self::Area(index) => {
                let area = &mut light.area[index];
                [&mut area.azimuth, &mut area.elevation]
            }
        }
    }

    /// Where it is in the sky.
    fn spot(self, light: &Light) -> Spot {
        match self {
            Self::Sun(index) => {
                let sun = &light.sun[index];
                let towards = direction(sun.azimuth, sun.elevation);
                let (sin, cos) = (sun.angular_diameter / 2.0).to_radians().sin_cos();
                let (first, second) = towards.any_orthonormal_pair();
                let edge = (0..EDGE_POINTS)
                    .map(|k| k as f64 * std::f64::consts::TAU / EDGE_POINTS as f64)
                    .map(|t| towards * cos + (first * t.cos() + second * t.sin()) * sin);
                Spot {
                    towards,
                    edge: edge.collect(),
                    colour: sun.colour,
                    irradiance: sun.irradiance,
                }
            }
            Self::Area(index) => {
                let area = &light.area[index];
                let towards = direction(area.azimuth, area.elevation);
                let (sine, cosine) = area.azimuth.to_radians().sin_cos();
                let level = DVec3::new(-sine, cosine, 0.0);
                let [x, y] = [area.width, area.height].map(|side| 0.5 * side / area.distance);
                let (x, y) = (level * x, towards.cross(level) * y);
                let corners = [-x - y, x - y, x + y, y - x];
                let edge = (0..EDGE_POINTS).map(|k| {
                    let (side, step) = (4 * k / EDGE_POINTS, 4 * k % EDGE_POINTS);
                    let share = step as f64 / EDGE_POINTS as f64;
                    let (from, to) = (corners[side], corners[(side + 1) % 4]);
                    (towards + from.lerp(to, share)).normalize_or(towards)
                });
                Spot {
                    towards,
                    edge: edge.collect(),
                    colour: area.colour,
                    irradiance: area.irradiance,
                }
            }
        }
    }
}

/// A light as it is seen from the cloth's middle.
#[derive(Debug, Clone, PartialEq)]
struct Spot {
    /// Unit vector to its middle.
    towards: DVec3,
    /// Unit vectors to its edge, all around.
    edge: Vec<DVec3>,
    colour: Colour,
    irradiance: f64,
}

/// Which light is selected, whether it is held, and the sphere's picture.
#[derive(Default)]
pub struct LightSphere {
    /// Place of the selected light among all of them.
    pub selected: usize,
    is_held: bool,
    shading: Option<(Shading, TextureHandle)>,
}

/// What the picture of the sphere shows.
#[derive(Debug, Clone, PartialEq)]
struct Shading {
    spots: Vec<Spot>,
    /// Light from straight above, from the horizon and from below.
    sky: [[f64; 3]; 3],
}

/// Largest radius of the sphere, points.
const RADIUS: f32 = 64.0;
/// Room around it, for lights at the rim.
const MARGIN: f32 = 12.0;
/// Pixels of the sphere's picture.
const PIXELS: usize = 160;
/// How near the pointer must be to a light to take it, points.
const REACH: f32 = 11.0;
/// Degrees for an arrow key.
const DEGREES_PER_KEY: f64 = 5.0;
/// Points of a light's edge.
const EDGE_POINTS: usize = 48;

/// Shows the sphere and moves lights on it; what the history is to call that if one was moved.
pub fn show(ui: &mut Ui, sphere: &mut LightSphere, light: &mut Light) -> Option<&'static str> {
    let side = 2.0 * (RADIUS + MARGIN);
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::click_and_drag());
    let disc = Disc {
        centre: rect.center(),
        radius: RADIUS,
    };
    let count = LightSource::all(light).count();
    sphere.selected = sphere.selected.min(count.saturating_sub(1));
    let before = light.clone();
    pointer(ui, sphere, &response, &disc, light);
    keyboard(ui, sphere, &response, light);
    paint(ui, sphere, &response, &disc, light);
    let text = LightSource::of(light, sphere.selected).map_or_else(
        || "no light".into(),
        |source| {
            let [azimuth, elevation] = source.azimuth_and_elevation(light);
            format!(
                "{} of {count}: azimuth {azimuth:.0}°, elevation {elevation:.0}°",
                source.name().to_lowercase(),
            )
        },
    );
    response.widget_info(|| WidgetInfo {
        current_text_value: Some(text.clone()),
        ..WidgetInfo::labeled(Role::Canvas, ui.is_enabled(), "Lights on a sphere")
    });
    response.on_hover_cursor(CursorIcon::Crosshair).on_hover_text(
        "Drag a light over the sphere: in the middle it shines straight down on the cloth, at the rim it grazes it; \
         up is the cloth's far edge. Keys: arrows move the light, Page up and Page down choose another.",
    );
    if light.sun != before.sun {
        Some("moved sun")
    } else {
        (light.area != before.area).then_some("moved area light")
    }
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

fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let across = elevation.cos();
    DVec3::new(
        azimuth.cos() * across,
        azimuth.sin() * across,
        elevation.sin(),
    )
}

fn pointer(ui: &Ui, sphere: &mut LightSphere, response: &Response, disc: &Disc, light: &mut Light) {
    let is_down = response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down());
    let Some(at) = response.interact_pointer_pos().filter(|_| is_down) else {
        sphere.is_held = false;
        return;
    };
    if !sphere.is_held {
        sphere.is_held = true;
        response.request_focus();
        let distances = LightSource::all(light).map(|source| {
            let [azimuth, elevation] = source.azimuth_and_elevation(light);
            disc.place(direction(*azimuth, *elevation)).distance(at)
        });
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((near, _)) = nearest.filter(|&(_, distance)| distance < REACH) {
            // Taken where it is; it moves when the pointer does.
            sphere.selected = near;
            return;
        }
    } else if response.drag_delta() == Vec2::ZERO {
        return;
    }
    if let Some(source) = LightSource::of(light, sphere.selected) {
        move_to(source.azimuth_and_elevation(light), disc.direction(at));
    }
}

/// Moves a light to where x and y of its direction are these, above the cloth or below as it was.
fn move_to([azimuth, elevation]: [&mut f64; 2], [x, y]: [f64; 2]) {
    let tenths = |degrees: f64| (degrees * 10.0).round() / 10.0;
    let across = x.hypot(y);
    let height = tenths(across.min(1.0).acos().to_degrees());
    *elevation = height.copysign(*elevation);
    // Straight above, the azimuth means nothing, and keeps what it was.
    if across > 1e-3 {
        *azimuth = tenths(y.atan2(x).to_degrees());
    }
}

fn keyboard(ui: &Ui, sphere: &mut LightSphere, response: &Response, light: &mut Light) {
    let Some(arrows) = arrow_keys(ui, response) else {
        return;
    };
    let presses = |key| ui.input(|i| i.num_presses(key));
    let last = LightSource::all(light).count().saturating_sub(1);
    sphere.selected = (sphere.selected + presses(Key::PageDown)).min(last);
    sphere.selected = sphere.selected.saturating_sub(presses(Key::PageUp));
    let Some(source) = LightSource::of(light, sphere.selected).filter(|_| arrows != [0, 0]) else {
        return;
    };
    let [azimuth, elevation] = source.azimuth_and_elevation(light);
    let [right, up] = arrows.map(|presses| f64::from(presses) * DEGREES_PER_KEY);
    // Azimuths grow against the clock as the sphere is seen; the right key goes with it.
    let turned = *azimuth - right;
    *azimuth = if turned.abs() > 180.0 {
        turned - 360.0 * turned.signum()
    } else {
        turned
    };
    *elevation = (*elevation + up).clamp(-90.0, 90.0);
}

fn paint(ui: &Ui, sphere: &mut LightSphere, response: &Response, disc: &Disc, light: &Light) {
    let visuals = ui.visuals();
    let painter = ui.painter_at(response.rect);
    let shading = Shading {
        spots: LightSource::all(light)
            .map(|source| source.spot(light))
            .collect(),
        sky: sky(&light.environment),
    };
    let spots = shading.spots.clone();
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
    // The selected light last, so that none lies over it.
    let others = (0..spots.len()).filter(|&index| index != sphere.selected);
    for index in others.chain(Some(sphere.selected)) {
        if let Some(spot) = spots.get(index) {
            paint_spot(&painter, visuals, disc, spot, index == sphere.selected);
        }
    }
    if spots.is_empty() {
        let font = FontId::proportional(12.0);
        let colour = visuals.strong_text_color();
        painter.text(disc.centre, Align2::CENTER_CENTER, "No sun", font, colour);
    }
}

fn paint_spot(
    painter: &egui::Painter,
    visuals: &egui::Visuals,
    disc: &Disc,
    spot: &Spot,
    is_selected: bool,
) {
    let Colour([r, g, b]) = spot.colour;
    let fill = Color32::from_rgb(r, g, b);
    let is_below = spot.towards.z < 0.0;
    let side = if is_below { -1.0 } else { 1.0 };
    // Its edge in the sky, where it is on this side of the sphere.
    let points: Vec<Pos2> = spot
        .edge
        .iter()
        .map(|edge| {
            // Beyond the rim it goes on behind; shown at the rim.
            let hidden = edge.z * side < 0.0;
            let flat = DVec3::new(edge.x, edge.y, 0.0);
            disc.place(if hidden {
                flat.normalize_or_zero()
            } else {
                *edge
            })
        })
        .collect();
    let line = Stroke::new(1.0, visuals.strong_text_color().gamma_multiply(0.7));
    painter.add(Shape::convex_polygon(
        points,
        fill.gamma_multiply(0.35),
        line,
    ));
    let at = disc.place(spot.towards);
    let outline = Stroke::new(1.5, Color32::from_gray(0x20));
    let core = if is_below { Color32::TRANSPARENT } else { fill };
    painter.circle(at, 4.5, core, outline);
    if is_below {
        painter.circle_stroke(at, 4.5, Stroke::new(2.0, fill));
    }
    if is_selected {
        let accent = Stroke::new(2.0, style::accent(visuals));
        painter.circle_stroke(at, 8.0, accent);
    }
}

/// Light from straight above, from the horizon and from below, as far as a small sphere shows it: an image counts as
/// its brightness alone.
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
    let sources: Vec<(DVec3, [f64; 3])> = shading
        .spots
        .iter()
        .map(|spot| {
            let strength = spot.irradiance / std::f64::consts::PI;
            (spot.towards, spot.colour.linear().map(|c| c * strength))
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
            let from_sources = sources
                .iter()
                .map(|(towards, light)| light[c] * normal.dot(*towards).max(0.0));
            0.6 * (from_sky + from_sources.sum::<f64>())
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
