//! One loop of the pile, seen close, as it will be drawn: it shows what the yarn's numbers do. It turns under the
//! pointer, when it is dragged, and by the arrow keys; otherwise it stands still and nothing is drawn.
//!
//! It turns in steps. Each is drawn once and kept until the pile changes, so that the second turn costs nothing. While
//! a slider is dragged, a new picture is asked for only when the last has shown something: so there is always one to
//! see.

use egui::{
    Align2, Color32, ColorImage, FontId, Rect, Response, Role, Sense, Stroke, StrokeKind,
    TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use renderer_core::design::{
    Back, CameraDesign, Chart, ChartImage, Colour, Design, Environment, Length, LengthMap, Light,
    Metering, Method, OPAQUE_FROM, Pattern, Pile, Quality, Sheet, SkeletonDesign, Sun, View, Weave,
};

use renderer_core::scene::luma;

use crate::designer::presets::thumbnails::{
    DrawnThumbnail, ThumbnailJob, ThumbnailKey, ThumbnailRenderer, ThumbnailSubject,
};
use crate::designer::widgets::arrow_keys;
use crate::designer::widgets::style;

/// Steps of a whole turn.
const STEPS: usize = 36;
/// Shortest time between two steps, seconds.
const STEP_SECONDS: f64 = 0.07;
/// Points to drag for a step.
const STEP_POINTS: f32 = 7.0;
/// The step shown first: obliquely, so that width and thickness show.
const FIRST_STEP: usize = 3;
/// Side of the picture, points.
const SIDE: f32 = 164.0;
/// Most pixels along a side.
const MOST_PIXELS: f32 = 256.0;
/// Finest volume, along its sides and through its thickness.
const MOST_VOXELS: u32 = 64;
const MOST_LAYERS: u32 = 32;
/// Height of the eye, degrees.
const ELEVATION: f64 = 14.0;
/// Samples of a picture that turns, and of one that stands.
const SAMPLES: [u32; 2] = [6, 40];

/// Everything the picture depends on but the direction.
#[derive(Debug, Clone, PartialEq)]
struct Look {
    pile: Pile,
    length_mm: f64,
    colour: Colour,
    side_px: u32,
}

/// Picture of one step.
#[derive(Clone)]
struct Turned {
    texture: TextureHandle,
    samples: u32,
}

/// The pictures drawn so far, and how the loop is turned.
pub struct LoopPicture {
    /// A chart and its mean colour.
    mean: Option<(ChartImage, Colour)>,
    look: Option<Look>,
    steps: Vec<Option<Turned>>,
    step: usize,
    /// Step and samples of the picture in work, and whether something of it has been shown.
    asked: Option<(usize, u32, bool)>,
    shown: Option<Result<TextureHandle, String>>,
    turned_at: f64,
    /// Points dragged that make no whole step yet.
    dragged: f32,
}

impl Default for LoopPicture {
    fn default() -> Self {
        Self {
            mean: None,
            look: None,
            steps: vec![None; STEPS],
            step: FIRST_STEP,
            asked: None,
            shown: None,
            turned_at: 0.0,
            dragged: 0.0,
        }
    }
}

/// Shows the loop in the mean colour of the chart as it is woven, and in words what there is to see.
pub fn show(
    ui: &mut Ui,
    picture: &mut LoopPicture,
    design: &Design,
    woven: &Chart,
    thumbnails: &mut ThumbnailRenderer,
) {
    ui.add_space(2.0);
    ui.horizontal_top(|ui| {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(SIDE), Sense::click_and_drag());
        let colour = picture.colour(woven);
        let look = Look::new(ui, design, colour);
        if ui.is_rect_visible(rect) {
            let turns = picture.turn(ui, &response);
            picture.follow(ui, look.clone(), turns, thumbnails);
        }
        picture.paint(ui, &response, rect, &look);
        let text = match &picture.shown {
            Some(Err(error)) => format!("not drawn: {error}"),
            _ => format!("turned by {}°", picture.step * 360 / STEPS),
        };
        response.widget_info(|| WidgetInfo {
            current_text_value: Some(text.clone()),
            ..WidgetInfo::labeled(Role::Image, ui.is_enabled(), "One loop")
        });
        ui.vertical(|ui| describe(ui, &look));
    });
}

fn describe(ui: &mut Ui, look: &Look) {
    let pile = &look.pile;
    ui.label(format!("One {}", pile.kind.label()));
    let hundredths = |mm: f64| (mm * 100.0).round() / 100.0;
    ui.label(format!("{} mm long", hundredths(look.length_mm)));
    ui.label(format!("{} mm yarn", hundredths(pile.yarn_diameter)));
    if let Some([one, several]) = pile.kind.plies_are() {
        let plies = if pile.plies == 1 { one } else { several };
        ui.label(format!("{} {plies}", pile.plies));
    }
    ui.add_space(4.0);
    ui.weak("Turns under the pointer, when dragged, and by the arrow keys.");
}

impl Look {
    fn new(ui: &Ui, design: &Design, colour: Colour) -> Self {
        let side = (SIDE * ui.pixels_per_point()).min(MOST_PIXELS);
        Self {
            // How loops lie and differ from each other does not show on one.
            pile: Pile {
                variants: 1,
                lean_x: 0.0,
                lean_y: 0.0,
                tilt: 0.0,
                twist: 0.0,
                stretch: 0.0,
                jitter: 0.0,
                twist_jitter: 0.0,
                length_jitter: 0.0,
                max_length: Pile::FIELDS.max_length.max,
                // Finer volumes take seconds and show no more on so small a picture.
                resolution: design.pile.resolution.min(MOST_VOXELS),
                layers: design.pile.layers.min(MOST_LAYERS),
                ..design.pile.clone()
            },
            length_mm: design.length.longest().min(design.pile.max_length),
            colour,
            side_px: side.round().max(16.0) as u32,
        }
    }

    /// What is behind the loop: dark behind light yarn, light behind dark yarn, in both themes.
    fn ground(&self) -> Colour {
        Colour(
            [if luma(self.colour.0) > 0.4 {
                0x4c
            } else {
                0xb4
            }; 3],
        )
    }

    /// Height of the picture, mm.
    fn height_mm(&self) -> f64 {
        let (sin, cos) = ELEVATION.to_radians().sin_cos();
        let across = self.pile.base_width.max(self.pile.top_width);
        1.05 * (self.length_mm * cos + across * sin).max(across + self.pile.thickness)
    }

    /// A cloth of this one loop.
    fn subject(&self, step: usize) -> ThumbnailSubject {
        let azimuth = 360.0 * step as f64 / STEPS as f64;
        let height_mm = self.height_mm();
        let design = Design {
            sheet: Sheet {
                warps: 1,
                wefts: 1,
                // As wide as can be, so that no loop reaches over too many cells.
                warps_per_cm: Sheet::FIELDS.warps_per_cm.min,
                wefts_per_cm: Sheet::FIELDS.wefts_per_cm.min,
            },
            weave: Weave {
                pattern: Pattern::filled(1, 1, 7),
                back: Back::None,
            },
            chart: Chart {
                colour: self.colour,
                ..Chart::default()
            },
            length: Length {
                map: LengthMap::Constant,
                value: self.length_mm,
                ..Length::default()
            },
            pile: self.pile.clone(),
            // Nothing that would lift the loop's roots off the sheet's plane.
            skeleton: SkeletonDesign {
                visible: false,
                warp_radius: SkeletonDesign::FIELDS.warp_radius.min,
                weft_radius: SkeletonDesign::FIELDS.weft_radius.min,
                crimp: 0.0,
                ..SkeletonDesign::default()
            },
            light: Light {
                // The loop turns, the light stays: to the left of the eye and above it.
                sun: vec![Sun {
                    azimuth: (azimuth + 300.0) % 360.0,
                    elevation: 35.0,
                    irradiance: 3.0,
                    angular_diameter: 20.0,
                    ..Sun::default()
                }],
                environment: Environment {
                    radiance: 0.35,
                    ..Environment::default()
                },
                background: self.ground(),
                ..Light::default()
            },
            view: View {
                // As bright as those of other loops, on the panel's own ground.
                metering: Metering::None,
                ..View::default()
            },
            quality: Quality {
                method: Method::Tracked,
                ..Quality::default()
            },
            ..Design::default()
        };
        let camera = CameraDesign {
            azimuth,
            elevation: ELEVATION,
            target: [0.0, 0.0, 0.5 * self.length_mm],
            distance: 4.0 * height_mm,
            orthographic_height: Some(height_mm),
            ..CameraDesign::default()
        };
        ThumbnailSubject { design, camera }
    }
}

/// The mean of a chart's opaque pixels, of a large one an even selection, in linear light.
fn mean_colour(chart: &ChartImage) -> Colour {
    let step = chart.width().max(chart.height()).div_ceil(128);
    let rows = (0..chart.height()).step_by(step);
    let places = rows.flat_map(|y| (0..chart.width()).step_by(step).map(move |x| (x, y)));
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for [r, g, b, alpha] in places.map(|(x, y)| chart.pixel(x, y)) {
        if alpha >= OPAQUE_FROM {
            let light = Colour([r, g, b]).linear();
            sum = std::array::from_fn(|c| sum[c] + light[c]);
            count += 1.0;
        }
    }
    if count == 0.0 {
        return Colour::WHITE;
    }
    Colour::from_linear(sum.map(|channel| channel / count))
}

impl LoopPicture {
    /// Colour of the loop: the chart's mean, or that of the cloth.
    fn colour(&mut self, chart: &Chart) -> Colour {
        let Some(image) = &chart.pixels else {
            return chart.colour;
        };
        match &self.mean {
            Some((of, mean)) if of == image => *mean,
            _ => {
                let mean = mean_colour(image);
                self.mean = Some((image.clone(), mean));
                mean
            }
        }
    }

    /// Turns by pointer and keys; whether it is turning.
    fn turn(&mut self, ui: &Ui, response: &Response) -> bool {
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        if let Some([right, _]) = arrow_keys(ui, response) {
            self.turn_by(right);
        }
        if response.dragged() {
            self.dragged += response.drag_delta().x;
            let steps = (self.dragged / STEP_POINTS).trunc();
            self.dragged -= steps * STEP_POINTS;
            // What is pulled to the right comes from the left.
            self.turn_by(-steps as i32);
            return true;
        }
        self.dragged = 0.0;
        if !response.hovered() {
            return false;
        }
        let now = ui.input(|i| i.time);
        let wait = self.turned_at + STEP_SECONDS - now;
        // The next step waits until this one can be seen; whoever has drawn it asks for a frame.
        if self.steps[self.step].is_some() {
            if wait <= 0.0 {
                self.turned_at = now;
                self.turn_by(1);
            }
            let wait = wait.max(0.0) + f64::EPSILON;
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_secs_f64(wait));
        }
        true
    }

    fn turn_by(&mut self, steps: i32) {
        self.step = (self.step as i32 + steps).rem_euclid(STEPS as i32) as usize;
    }

    /// Takes what has been drawn and asks for what is missing.
    fn follow(&mut self, ui: &Ui, look: Look, turns: bool, thumbnails: &mut ThumbnailRenderer) {
        if let (Some(drawn), Some(asked)) = (thumbnails.take(&ThumbnailKey::Loop), self.asked) {
            self.take(ui, drawn, asked);
        }
        if self.look.as_ref() != Some(&look) {
            self.steps.fill(None);
            // The picture in work is of another pile; it may still be shown, but not kept.
            if let Some((_, samples, _)) = &mut self.asked {
                *samples = 0;
            }
            self.look = Some(look.clone());
        }
        let samples = SAMPLES[usize::from(!turns)];
        if let Some(turned) = &self.steps[self.step] {
            self.shown = Some(Ok(turned.texture.clone()));
            if turned.samples >= samples {
                return;
            }
        }
        match self.asked {
            Some((step, of, _)) if step == self.step && of >= samples => {}
            Some((.., false)) => {}
            _ => {
                let step = self.step;
                self.asked = Some((step, samples, false));
                thumbnails.draw(ThumbnailJob {
                    key: ThumbnailKey::Loop,
                    size: [look.side_px; 2],
                    samples,
                    is_urgent: true,
                    subject: Box::new(move || Ok(look.subject(step))),
                });
            }
        }
    }

    fn take(&mut self, ui: &Ui, drawn: DrawnThumbnail, (step, samples, _): (usize, u32, bool)) {
        let texture = drawn.image.map(|image| texture(ui, image));
        if let (true, Ok(texture)) = (drawn.is_final && samples > 0, &texture) {
            let texture = texture.clone();
            self.steps[step] = Some(Turned { texture, samples });
        }
        // What failed would fail again; it is asked for anew when something changes.
        let goes_on = !drawn.is_final || texture.is_err();
        self.shown = Some(texture);
        self.asked = goes_on.then_some((step, samples, true));
    }

    fn paint(&self, ui: &Ui, response: &Response, rect: Rect, look: &Look) {
        let painter = ui.painter_at(rect);
        let Colour([r, g, b]) = look.ground();
        painter.rect_filled(rect, 3.0, Color32::from_rgb(r, g, b));
        match &self.shown {
            Some(Ok(texture)) => {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                painter.image(texture.id(), rect, whole, Color32::WHITE);
                scale_bar(ui, rect, look);
            }
            Some(Err(error)) => {
                let font = FontId::proportional(11.0);
                let colour = Color32::WHITE;
                let text = format!("Not drawn: {error}");
                let galley = painter.layout(text, font, colour, SIDE - 12.0);
                painter.galley(rect.min + vec2(6.0, 6.0), galley, colour);
            }
            None => {}
        }
        let outline = if response.has_focus() {
            Stroke::new(1.0, style::accent(ui.visuals()))
        } else {
            ui.visuals().widgets.noninteractive.bg_stroke
        };
        painter.rect_stroke(rect, 3.0, outline, StrokeKind::Inside);
    }
}

fn texture(ui: &Ui, image: ColorImage) -> TextureHandle {
    ui.ctx().load_texture("loop", image, TextureOptions::LINEAR)
}

/// A bar of a round number of mm, about a quarter of the picture long.
fn scale_bar(ui: &Ui, rect: Rect, look: &Look) {
    let height_mm = look.height_mm();
    let quarter = height_mm / 4.0;
    let unit = 10_f64.powf(quarter.log10().floor());
    let factors = [5.0, 2.0, 1.0];
    let factor = factors.into_iter().find(|f| f * unit <= quarter);
    let mm = unit * factor.unwrap_or(1.0);
    let length = rect.height() * (mm / height_mm) as f32;
    let from = rect.left_bottom() + vec2(8.0, -8.0);
    let Colour([ground, ..]) = look.ground();
    let colour = Color32::from_gray(if ground < 0x80 { 0xe0 } else { 0x20 });
    let painter = ui.painter_at(rect);
    painter.line_segment([from, from + vec2(length, 0.0)], Stroke::new(2.0, colour));
    painter.text(
        from + vec2(0.0, -3.0),
        Align2::LEFT_BOTTOM,
        format!("{mm} mm"),
        FontId::proportional(11.0),
        colour,
    );
}
