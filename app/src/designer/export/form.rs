//! What picture to make: kind of file, size, when to stop.

use std::time::Duration;

use egui::{ComboBox, Grid, Ui};
use renderer_core::design::{CameraDesign, Design, Method, Quality};
use renderer_core::image::ExrLayer;
use renderer_core::render::MAX_SIDE;

use crate::backend::BackendChoice;
use crate::designer::document::settings::ExportSettings;
use crate::designer::shell::view_bar::{BACKENDS, backend_name};
use crate::designer::viewport::camera_moves;
use crate::designer::widgets::{NumberField, check_box};
use crate::picture_file::{BAND_BYTES, Bands};

/// Kinds of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FileType {
    Png8,
    Png16,
    Exr,
}

impl FileType {
    const ALL: [Self; 3] = [Self::Png8, Self::Png16, Self::Exr];

    fn name(self) -> &'static str {
        match self {
            Self::Png8 => "PNG, 8 bit",
            Self::Png16 => "PNG, 16 bit",
            Self::Exr => "EXR, linear light",
        }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Png8 => "What the viewport shows, for screens and print.",
            Self::Png16 => "The same with finer steps, for retouching.",
            Self::Exr => "The light itself, before exposure and tone map, for compositing.",
        }
    }

    /// The end of the file's name.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png8 | Self::Png16 => "png",
            Self::Exr => "exr",
        }
    }
}

/// What the window asks for.
pub(super) struct Form {
    pub file_type: FileType,
    pub size: [u32; 2],
    pub samples: u32,
    pub transparent: bool,
    /// Whether noise is taken out of it.
    pub denoise: bool,
    /// Whether a PNG takes its design along.
    pub takes_design: bool,
    pub dots_per_inch: f64,
    pub choice: BackendChoice,
    /// Width over height that stays.
    proportion: Option<f64>,
    error: Option<f64>,
    seconds: Option<f64>,
    viewport: [u32; 2],
    /// How much of the cloth is as high as the picture, at the middle of the view, mm.
    cloth_mm: f64,
}

/// Quality by name: how many samples it is, and what that is for. Numbers of one's own have no name.
const QUALITIES: [(&str, u32, &str); 3] = [
    (
        "Draft",
        16,
        "Noisy, soon there: to see whether all is right.",
    ),
    (
        "Good",
        64,
        "For screens: a little noise is left where one looks closely.",
    ),
    ("Best", 256, "For print: clean but for the darkest parts."),
];
/// What a quality is called that has no name.
const OWN: &str = "Own";

/// Millimetres of an inch.
const INCH_MM: f64 = 25.4;

/// Sizes to choose from, pixels.
const SIZES: [(&str, [u32; 2]); 5] = [
    ("Full HD, 1920 × 1080", [1920, 1080]),
    ("4K, 3840 × 2160", [3840, 2160]),
    ("Square, 2048 × 2048", [2048, 2048]),
    ("A4 at 300 dpi, 3508 × 2480", [3508, 2480]),
    ("A3 at 300 dpi, 4961 × 3508", [4961, 3508]),
];

impl Form {
    pub fn new(choice: BackendChoice) -> Self {
        Self {
            file_type: FileType::Png8,
            size: [1600, 1200],
            samples: Quality::default().samples,
            transparent: false,
            denoise: false,
            takes_design: true,
            dots_per_inch: 300.0,
            choice,
            proportion: None,
            error: None,
            seconds: None,
            viewport: [800, 600],
            cloth_mm: 0.0,
        }
    }

    /// Takes over size and quality of the last picture; where there was none what a design asks for, at twice the
    /// viewport's size.
    pub fn begin(
        &mut self,
        design: &Design,
        camera: &CameraDesign,
        last: Option<ExportSettings>,
        viewport: [u32; 2],
    ) {
        self.viewport = viewport;
        self.cloth_mm = camera_moves::picture_height_mm(camera);
        let quality = &design.quality;
        let last = last.unwrap_or(ExportSettings {
            size: viewport.map(|side| 2 * side),
            samples: quality.samples,
            error: (quality.error > 0.0).then_some(quality.error),
            seconds: None,
            dots_per_inch: self.dots_per_inch,
        });
        self.set_size(last.size);
        (self.samples, self.error, self.seconds) = (last.samples, last.error, last.seconds);
        self.dots_per_inch = last.dots_per_inch;
    }

    /// Size and quality, to be remembered.
    pub fn settings(&self) -> ExportSettings {
        ExportSettings {
            size: self.size,
            samples: self.samples,
            error: self.error,
            seconds: self.seconds,
            dots_per_inch: self.dots_per_inch,
        }
    }

    /// The number of pixels times samples that is made at most.
    pub fn most_samples(&self) -> f64 {
        let pixels = self.size.map(f64::from);
        pixels[0] * pixels[1] * f64::from(self.samples)
    }

    /// Whether the picture may be done before it has all of its samples.
    pub fn may_end_sooner(&self) -> bool {
        self.error.is_some()
    }

    /// The error to stop at; 0 for none.
    pub fn error_target(&self) -> f64 {
        self.error.unwrap_or(0.0)
    }

    /// The time to stop after.
    pub fn time_limit(&self) -> Option<Duration> {
        self.seconds.map(Duration::from_secs_f64)
    }

    /// Extra channels of an EXR file.
    pub fn layers(&self) -> Vec<ExrLayer> {
        self.denoise
            .then_some(ExrLayer::Noisy)
            .into_iter()
            .collect()
    }

    fn set_size(&mut self, size: [u32; 2]) {
        self.size = size.map(|side| side.clamp(1, MAX_SIDE));
        if let Some(proportion) = &mut self.proportion {
            *proportion = f64::from(self.size[0]) / f64::from(self.size[1]);
        }
    }

    /// One side was changed: the other follows where the proportion stays.
    fn follow(&mut self, changed: usize) {
        let Some(proportion) = self.proportion else {
            return;
        };
        let side = f64::from(self.size[changed]);
        let other = if changed == 0 {
            side / proportion
        } else {
            side * proportion
        };
        self.size[1 - changed] = (other.round() as u32).clamp(1, MAX_SIDE);
    }

    /// Shows the form. Whether the picture is to be made.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        design: &Design,
        camera: &CameraDesign,
        estimate: &str,
    ) -> bool {
        self.cloth_mm = camera_moves::picture_height_mm(camera);
        Grid::new("export")
            .num_columns(2)
            .spacing([12.0, 6.0])
            .show(ui, |ui| {
                self.file_type(ui);
                self.sizes(ui);
                self.quality(ui);
                self.stops(ui);
                ui.label("Background");
                check_box(ui, &mut self.transparent, "transparent").on_hover_text(
                    "Leaves the background out: the cloth alone, to be laid over something else.",
                );
                ui.end_row();
                ui.label("Noise");
                check_box(ui, &mut self.denoise, "denoise").on_hover_text(
                    "Takes noise out with Open Image Denoise, as far as that does good: a guess, which the file tells \
                     of. EXR files keep the noisy picture as well. Off, the picture is what was traced.",
                );
                ui.end_row();
                self.design(ui);
                self.backend(ui);
            });
        ui.add_space(4.0);
        let [width, height] = self.size;
        let bands = Bands::new([0, 0, width, height], false, BAND_BYTES);
        let pixels = f64::from(width) * f64::from(height) / 1e6;
        let memory = bands.bytes(bands.next()) as f64 / 1e6;
        let pieces = match bands.count() {
            1 => String::new(),
            count => format!(", made in {count} bands"),
        };
        ui.weak(format!(
            "{pixels:.1} megapixels, about {memory:.0} MB of memory{pieces}. The picture shows the cloth as the \
            viewport does."
        ));
        ui.label(estimate);
        ui.add_space(6.0);
        let fault = self.in_the_way(design);
        if let Some(fault) = &fault {
            ui.colored_label(ui.visuals().error_fg_color, fault);
        }
        let button = egui::Button::new("Choose file and export…");
        ui.add_enabled(fault.is_none(), button).clicked()
    }

    /// Why the picture cannot be made, and what to do.
    fn in_the_way(&self, design: &Design) -> Option<String> {
        if let Some(fault) = design.faults().first() {
            return Some(format!(
                "The design has a fault: {fault}. Mend it in its panel, then export."
            ));
        }
        let six_face = design.quality.method == Method::SixFace;
        (six_face && self.choice == BackendChoice::Gpu).then(|| {
            "The GPU does not draw by the method six-face: choose the backend auto or cpu, or another method under \
             View & quality."
                .into()
        })
    }

    fn file_type(&mut self, ui: &mut Ui) {
        let label = ui.label("File");
        ComboBox::from_id_salt("export file")
            .width(170.0)
            .selected_text(self.file_type.name())
            .show_ui(ui, |ui| {
                for file_type in FileType::ALL {
                    ui.selectable_value(&mut self.file_type, file_type, file_type.name())
                        .on_hover_text(file_type.what());
                }
            })
            .response
            .labelled_by(label.id)
            .on_hover_text(self.file_type.what());
        ui.end_row();
    }

    fn design(&mut self, ui: &mut Ui) {
        ui.label("Design");
        if self.file_type == FileType::Exr {
            ui.weak("not in EXR files");
        } else {
            check_box(ui, &mut self.takes_design, "in the file").on_hover_text(
                "The picture opens again as a design, with its images. Without, it is a picture and nothing more.",
            );
        }
        ui.end_row();
    }

    fn sizes(&mut self, ui: &mut Ui) {
        ui.label("Size");
        ui.horizontal(|ui| {
            let before = self.size;
            for (axis, name) in [(0, "Export width"), (1, "Export height")] {
                if axis == 1 {
                    ui.label("×");
                }
                let side = NumberField::new(&mut self.size[axis], "px", 1..=MAX_SIDE);
                side.speed(4.0)
                    .show(ui)
                    .accessible_name(name)
                    .on_hover_text(format!("Pixels, 1 to {MAX_SIDE}."));
            }
            ui.weak("px");
            if let Some(axis) = (0..2).find(|&axis| self.size[axis] != before[axis]) {
                self.follow(axis);
            }
            ui.menu_button("Sizes…", |ui| {
                let [width, height] = self.viewport;
                for times in [1, 2] {
                    let size = [times * width, times * height];
                    let name = format!("Viewport × {times}, {} × {}", size[0], size[1]);
                    self.size_to_choose(ui, &name, size);
                }
                for (name, size) in SIZES {
                    self.size_to_choose(ui, name, size);
                }
            });
        });
        ui.end_row();
        ui.label("");
        let mut keeps = self.proportion.is_some();
        if check_box(ui, &mut keeps, "keep the proportion")
            .on_hover_text("Width and height change together.")
            .changed()
        {
            let now = f64::from(self.size[0]) / f64::from(self.size[1]);
            self.proportion = keeps.then_some(now);
        }
        ui.end_row();
        ui.label("Print");
        ui.horizontal(|ui| self.print(ui));
        ui.end_row();
        ui.label("");
        ui.horizontal(|ui| self.true_size(ui));
        ui.end_row();
    }

    fn size_to_choose(&mut self, ui: &mut Ui, name: &str, size: [u32; 2]) {
        if ui.button(name).clicked() {
            self.set_size(size);
            ui.close();
        }
    }

    /// The size on paper.
    fn print(&mut self, ui: &mut Ui) {
        let per_mm = self.dots_per_inch / INCH_MM;
        let in_mm = self.size.map(|side| f64::from(side) / per_mm);
        let pixels = |mm: f64, dots_per_inch: f64| {
            ((mm * dots_per_inch / INCH_MM).round() as u32).clamp(1, MAX_SIDE)
        };
        for (axis, name) in [(0, "Print width"), (1, "Print height")] {
            if axis == 1 {
                ui.label("×");
            }
            let mut mm = in_mm[axis];
            // A picture of few pixels is less than a millimetre on paper, and stays as it is.
            let field = NumberField::new(&mut mm, "mm", 1.0..=f64::from(MAX_SIDE))
                .max_decimals(1)
                .show(ui)
                .accessible_name(name)
                .on_hover_text("Size on paper, mm: changes the number of pixels.");
            if field.changed() && mm != in_mm[axis] {
                self.size[axis] = pixels(mm, self.dots_per_inch);
                self.follow(axis);
            }
        }
        ui.weak("mm at");
        let mut dots = self.dots_per_inch;
        let field = NumberField::new(&mut dots, "dpi", 10.0..=2400.0)
            .max_decimals(0)
            .show(ui)
            .accessible_name("Print resolution")
            .on_hover_text(
                "Pixels an inch on paper: changes the number of pixels, keeps the size on paper.",
            );
        ui.weak("dpi");
        if field.changed() {
            self.dots_per_inch = dots;
            self.size = in_mm.map(|mm| pixels(mm, dots));
        }
    }

    /// How large the cloth is on paper beside what it is, and a button that makes both the same.
    fn true_size(&mut self, ui: &mut Ui) {
        let paper_mm = f64::from(self.size[1]) / self.dots_per_inch * INCH_MM;
        let share = paper_mm / self.cloth_mm;
        let is_known = share.is_finite() && share > 0.0;
        let what = "Makes the picture as large on paper as the cloth that it shows: of a view in perspective, the cloth \
            at its middle. Where that is more pixels than a picture can have, the resolution is lower.";
        let button = ui.add_enabled(is_known, egui::Button::new("True size"));
        if button.on_hover_text(what).clicked() {
            self.set_true_size();
        }
        if is_known {
            ui.weak(format!("the cloth is printed at {}", percent(share)));
        }
    }

    fn set_true_size(&mut self) {
        let [width, height] = self.size.map(f64::from);
        let inches = self.cloth_mm / INCH_MM;
        let most = f64::from(MAX_SIDE) / (inches * (width / height).max(1.0));
        self.dots_per_inch = self.dots_per_inch.min(most).clamp(10.0, 2400.0);
        let high = inches * self.dots_per_inch;
        self.set_size([high * width / height, high].map(|side| side.round() as u32));
    }

    /// Draft, Good or Best: each sets the numbers below.
    fn quality(&mut self, ui: &mut Ui) {
        let has_stops = self.error.is_some() || self.seconds.is_some();
        let named = QUALITIES
            .iter()
            .find(|(_, samples, _)| !has_stops && *samples == self.samples);
        let (name, what) = named.map_or((OWN, "As the numbers below say."), |(name, _, what)| {
            (*name, *what)
        });
        let label = ui.label("Quality");
        ComboBox::from_id_salt("export quality")
            .width(170.0)
            .selected_text(name)
            .show_ui(ui, |ui| {
                for (choice, samples, what) in QUALITIES {
                    let text = format!("{choice}, {samples} samples");
                    if ui
                        .selectable_label(choice == name, text)
                        .on_hover_text(what)
                        .clicked()
                    {
                        (self.samples, self.error, self.seconds) = (samples, None, None);
                    }
                }
            })
            .response
            .labelled_by(label.id)
            .on_hover_text(what);
        ui.end_row();
    }

    fn stops(&mut self, ui: &mut Ui) {
        ui.label("Stop at").on_hover_text(
            "Whichever is reached first. A picture made in bands stops at the error band by band, and shares out \
             its time by rows.",
        );
        let field = Quality::FIELDS.samples;
        ui.horizontal(|ui| {
            NumberField::new(&mut self.samples, "samples", field.min..=field.max)
                .show(ui)
                .accessible_name("Export samples")
                .on_hover_text(field.what.trim());
            ui.weak("samples a pixel");
        });
        ui.end_row();
        ui.label("");
        optional(
            ui,
            &mut self.error,
            Quantity {
                name: "estimated error",
                unit: "%",
                start: 0.01,
                scale: 100.0,
                range: 0.01..=100.0,
                what: "Noise left in the picture, as a share of its brightness; 1 % looks clean.",
            },
        );
        ui.end_row();
        ui.label("");
        optional(
            ui,
            &mut self.seconds,
            Quantity {
                name: "time",
                unit: "min",
                start: 600.0,
                scale: 1.0 / 60.0,
                range: 0.05..=10_000.0,
                what: "Minutes of rendering; the picture is as good as it got by then.",
            },
        );
        ui.end_row();
    }

    fn backend(&mut self, ui: &mut Ui) {
        let label = ui.label("Backend");
        ComboBox::from_id_salt("export backend")
            .selected_text(backend_name(self.choice))
            .show_ui(ui, |ui| {
                for choice in BACKENDS {
                    ui.selectable_value(&mut self.choice, choice, backend_name(choice));
                }
            })
            .response
            .labelled_by(label.id)
            .on_hover_text("What to render with; auto takes the GPU where there is one.");
        ui.end_row();
    }
}

/// A number that may be left out.
struct Quantity {
    name: &'static str,
    unit: &'static str,
    /// Value when it is switched on.
    start: f64,
    /// What the value is multiplied by to be shown.
    scale: f64,
    /// What may be shown.
    range: std::ops::RangeInclusive<f64>,
    what: &'static str,
}

fn optional(ui: &mut Ui, value: &mut Option<f64>, quantity: Quantity) {
    ui.horizontal(|ui| {
        let mut on = value.is_some();
        if check_box(ui, &mut on, quantity.name)
            .on_hover_text(quantity.what)
            .changed()
        {
            *value = on.then_some(quantity.start);
        }
        if let Some(value) = value {
            let mut shown = *value * quantity.scale;
            let field = NumberField::new(&mut shown, quantity.unit, quantity.range)
                .speed(0.05)
                .max_decimals(2)
                .show(ui)
                .accessible_name(format!("Export {}", quantity.name))
                .on_hover_text(quantity.what);
            if field.changed() {
                *value = shown / quantity.scale;
            }
            ui.weak(quantity.unit);
        }
    });
}

/// `100 %`, `64 %`, `4.2 %`.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        ..9.95 => format!("{percent:.1} %"),
        _ => format!("{percent:.0} %"),
    }
}
