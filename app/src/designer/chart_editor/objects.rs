//! What lies on the chart: which of it is chosen, and what can be done with it as a whole.

use renderer_core::design::chart_objects::{ChartCanvas, Placed};
use renderer_core::design::{Chart, ChartImage, ChartObject, Colour, Design, ObjectKind, Sheet};
use renderer_core::scene::ChartComposer;

use super::object_gestures::Drag;
use super::snap::Caught;
use super::work::put;
use crate::lettering::Lettering;

/// A new picture takes at most this share of the chart.
const LARGEST_SHARE: f64 = 0.6;
/// Words that a new text begins with.
const FIRST_TEXT: &str = "Text";

/// What is remembered of objects.
pub struct Objects {
    /// The object that is chosen.
    pub selected: Option<usize>,
    /// The gesture that is under way.
    pub(super) drag: Option<Drag>,
    /// What the gesture has snapped to.
    pub(super) caught: Caught,
    /// Whether gestures snap.
    pub(super) snaps: bool,
    /// A text that its font cannot draw, as typed, and why.
    pub(super) refused_text: Option<(String, String)>,
}

impl Default for Objects {
    fn default() -> Self {
        Self {
            selected: None,
            drag: None,
            caught: Caught::default(),
            snaps: true,
            refused_text: None,
        }
    }
}

impl Objects {
    /// Forgets what is not there any more.
    pub(super) fn keep_within(&mut self, chart: &Chart) {
        self.selected = self.selected.filter(|&index| index < chart.object.len());
    }
}

/// A new object of a kind, as large as a tenth of the chart, in its middle.
pub fn new_object(kind: ObjectKind, colour: [u8; 4], canvas: &ChartCanvas) -> ChartObject {
    let side = canvas
        .size_mm()
        .iter()
        .fold(f64::INFINITY, |a, b| a.min(*b))
        / 10.0;
    let thickness = canvas.pixel_mm[0].max(canvas.pixel_mm[1]) * 2.0;
    let [r, g, b, alpha] = colour;
    let mut object = ChartObject {
        kind,
        width: rounded(side),
        height: rounded(if kind == ObjectKind::Line {
            thickness
        } else {
            side
        }),
        step_x: rounded(2.0 * side),
        step_y: rounded(2.0 * side),
        ..ChartObject::default()
    };
    if alpha == 0 {
        object.bare = true;
    } else {
        object.colour = Colour([r, g, b]);
    }
    if kind == ObjectKind::Text {
        // The program's own font has these letters.
        let _ = set_text(&mut object, FIRST_TEXT, None);
    }
    object
}

/// A tenth of a millimetre, so that fields show what there is.
pub fn rounded(mm: f64) -> f64 {
    ((mm * 10.0).round() / 10.0).max(0.1)
}

/// Gives a text other words or another font; it stays as high, and becomes as wide as the letters are.
///
/// # Errors
/// Why the letters cannot be drawn; then the text stays as it is.
pub fn set_text(object: &mut ChartObject, text: &str, font: Option<&str>) -> Result<(), String> {
    let lettering = Lettering::new(text, font)?;
    let lines = text.lines().count().max(1) as f64;
    let before = object
        .text
        .as_deref()
        .map_or(1, |text| text.lines().count().max(1)) as f64;
    object.height = rounded(object.height * lines / before);
    object.width = rounded(object.height * lettering.proportion());
    object.outline = Some(lettering.path.write());
    object.text = Some(text.to_owned());
    object.font = Some(lettering.font);
    Ok(())
}

/// Lays a picture on the chart, in its middle: a pixel for a loop side by side, undistorted on the cloth, and smaller
/// where that would hide most of the chart.
pub fn add_picture(design: &mut Design, pixels: ChartImage, path: Option<String>) -> bool {
    if design.chart.object.len() >= ChartObject::MAX {
        return false;
    }
    let canvas = ChartCanvas::of(&design.chart, &design.sheet);
    let [across, down] = [pixels.width() as f64, pixels.height() as f64];
    let room = canvas.size_mm().map(|side| LARGEST_SHARE * side);
    let pitch = design.sheet.pitch_x();
    let pixel = pitch.min(room[0] / across).min(room[1] / down);
    design.chart.object.push(ChartObject {
        kind: ObjectKind::Image,
        width: rounded(pixel * across),
        height: rounded(pixel * down),
        step_x: rounded(1.5 * pixel * across),
        step_y: rounded(1.5 * pixel * down),
        average: pixel < 0.99 * pitch && is_photograph(&pixels),
        image: path,
        pixels: Some(pixels),
        ..ChartObject::default()
    });
    true
}

/// Whether an image has more colours than yarns are woven with.
fn is_photograph(image: &ChartImage) -> bool {
    const YARNS: usize = 64;
    let mut colours = std::collections::HashSet::new();
    let step = (image.width() * image.height() / 100_000).max(1);
    for k in (0..image.width() * image.height()).step_by(step) {
        colours.insert(image.pixel(k % image.width(), k / image.width()));
        if colours.len() > YARNS {
            return true;
        }
    }
    false
}

/// Makes all objects up to this one, counted from the lowest, pixels of the chart.
pub fn flatten(design: &mut Design, composer: &mut ChartComposer, up_to: usize) {
    let mut lower = design.clone();
    lower.chart.object.truncate(up_to + 1);
    let flat = composer.chart(&lower);
    let chart = &mut design.chart;
    chart
        .object
        .drain(..=up_to.min(chart.object.len().saturating_sub(1)));
    (chart.fit, chart.average) = (flat.fit, flat.average);
    if let Some(pixels) = flat.pixels {
        put(chart, pixels);
    }
}

/// Makes the picture that an object is the chart, instead of what is there.
pub fn use_as_chart(chart: &mut Chart, index: usize) {
    let object = chart.object.remove(index);
    (chart.image, chart.pixels) = (object.image, object.pixels);
}

/// How many loops a width or height in mm is, to a tenth.
pub fn loops(mm: f64, pitch: f64) -> f64 {
    (mm / pitch * 10.0).round() / 10.0
}

/// Width and height of a crossing, mm.
pub fn pitch(sheet: &Sheet) -> [f64; 2] {
    [sheet.pitch_x(), sheet.pitch_y()]
}

/// The topmost object at a place, mm from the chart's middle, or within `margin` of it.
pub(super) fn object_at(
    chart: &Chart,
    canvas: &ChartCanvas,
    place: [f64; 2],
    margin: f64,
) -> Option<usize> {
    chart.object.iter().rposition(|object| {
        let mut all = Placed::all(object, canvas).into_iter();
        all.any(|placed| placed.holds(place, margin))
    })
}
