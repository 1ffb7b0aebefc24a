//! One edit of each kind that a designer makes, and how it is taken back.

use renderer_core::design::{CameraDesign, ChartImage, Design, Pattern};

use towel_designer::designer::camera_moves::picture_height_mm;

/// What is edited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edit {
    /// The camera goes around the cloth.
    Camera,
    /// It goes on along the cloth by half of what it sees: of cloth without end, beyond what is made.
    Pan,
    /// The suns move, or where there is none, the sky gets brighter.
    Light,
    /// All loops have another colour.
    Colour,
    /// All loops get longer.
    Length,
    /// Another turbulence.
    Turbulence,
    /// One stitch of the pattern.
    Pattern,
    /// A chart is put on the cloth, or a bar painted on the one that is there.
    Chart,
}

impl Edit {
    /// Each kind.
    pub const ALL: [Self; 8] = [
        Self::Camera,
        Self::Pan,
        Self::Light,
        Self::Colour,
        Self::Length,
        Self::Turbulence,
        Self::Pattern,
        Self::Chart,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Pan => "pan",
            Self::Light => "light",
            Self::Colour => "colour",
            Self::Length => "length",
            Self::Turbulence => "turbulence",
            Self::Pattern => "pattern",
            Self::Chart => "chart",
        }
    }
}

/// The camera of a preset, or where an edit has moved it.
pub fn camera(original: &CameraDesign, edit: Edit, forth: bool) -> CameraDesign {
    let mut camera = original.clone();
    match edit {
        Edit::Camera if forth => camera.azimuth += a_little(camera.azimuth),
        Edit::Pan if forth => camera.target[0] += 0.5 * picture_height_mm(original),
        _ => {}
    }
    camera
}

/// Some degrees, towards 0: angles have limits.
fn a_little(angle: f64) -> f64 {
    if angle > 0.0 { -7.0 } else { 7.0 }
}

/// Edits `design`, or takes the edit back to what `original` has.
pub fn edit(design: &mut Design, edit: Edit, original: &Design, forth: bool) {
    if !forth {
        match edit {
            Edit::Camera | Edit::Pan => {}
            Edit::Light => design.light = original.light.clone(),
            Edit::Colour => design.chart.colour = original.chart.colour,
            Edit::Length => design.length = original.length.clone(),
            Edit::Turbulence => design.turbulence = original.turbulence.clone(),
            Edit::Pattern => design.weave = original.weave.clone(),
            Edit::Chart => design.chart = original.chart.clone(),
        }
        return;
    }
    match edit {
        Edit::Camera | Edit::Pan => {}
        Edit::Light => match design.light.sun.first_mut() {
            Some(sun) => sun.azimuth += a_little(sun.azimuth),
            None => design.light.environment.radiance += 0.1,
        },
        Edit::Colour => {
            let [r, g, b] = design.chart.colour.0;
            // Another brightness too, so that grey ones change.
            design.chart.colour.0 = [g / 2 + 60, b / 2 + 40, r / 2 + 20];
        }
        Edit::Length => {
            let longer = |length: f64| length * 1.05;
            design.length.value = longer(design.length.value);
            design.length.max = longer(design.length.max);
            for row in &mut design.length.table {
                row.length = longer(row.length);
            }
        }
        Edit::Turbulence => design.turbulence.seed = design.turbulence.seed.wrapping_add(1),
        Edit::Pattern => {
            let other = match design.weave.pattern.at(0, 0) {
                0 => 7,
                _ => 0,
            };
            design.weave.pattern = with_corner(&design.weave.pattern, other);
        }
        Edit::Chart => {
            let chart = &mut design.chart;
            let blank = || ChartImage::filled(64, 64, [190, 170, 150, 255]);
            chart.pixels = chart.pixels.take().or_else(blank).map(|mut image| {
                let (width, height) = (image.width(), image.height());
                let rows = height / 3..height / 3 + height / 6 + 1;
                image.fill_rectangle(0..width, rows, [40, 90, 160, 255]);
                image
            });
        }
    }
}

/// The pattern with another stitch in its corner. Where it is a single one, a repeat of two, so that loops remain.
fn with_corner(pattern: &Pattern, value: u8) -> Pattern {
    let (cols, rows) = (pattern.cols().max(2), pattern.rows().max(2));
    Pattern::from_fn(cols, rows, |col, row| match (col, row) {
        (0, 0) => value,
        _ => pattern.at(col as i64, row as i64),
    })
}
