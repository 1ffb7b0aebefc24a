//! The chart editor: beside the viewport, a canvas to paint, cut and turn the chart on, while the cloth follows.
//!
//! It edits the chart of the design and nothing else. Painting makes the chart the design's own: it has pixels and no
//! path, and the file it came from is never written.

mod bars;
mod canvas;
mod pyramid;
pub mod work;
pub mod yarn_name;

use egui::{Key, Ui};
use renderer_core::design::{Chart, ChartImage, Design};
use renderer_core::scene::ChartYarns;

use canvas::Canvas;
use work::ChartWork;

use crate::designer::widgets::Icon;

/// What the primary button and the space bar do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tool {
    /// Paints where the pointer goes.
    #[default]
    Pencil,
    /// Paints a straight line.
    Line,
    /// Paints the outline of a rectangle.
    Rectangle,
    /// Paints a rectangle.
    FilledRectangle,
    /// Paints all connected pixels of one colour.
    Fill,
    /// Takes the colour to paint with from the chart.
    Pick,
    /// Marks what is to be kept of the chart.
    Crop,
}

impl Tool {
    /// All tools, in the order of their buttons: icon, name, and what it does.
    const ALL: [(Self, Icon, &'static str, &'static str); 7] = [
        (
            Self::Pencil,
            Icon::Pencil,
            "Chart pencil",
            "Paints with the brush where the pointer goes (P). Right click, or Alt and click, takes a colour from the \
            chart.",
        ),
        (
            Self::Line,
            Icon::Line,
            "Chart line",
            "Paints a straight line (L). With Shift level, upright or diagonal.",
        ),
        (
            Self::Rectangle,
            Icon::Rectangle,
            "Chart rectangle",
            "Paints the outline of a rectangle (R). With Shift while dragging a square.",
        ),
        (
            Self::FilledRectangle,
            Icon::FilledRectangle,
            "Chart filled rectangle",
            "Paints a filled rectangle (Shift+R). With Shift while dragging a square.",
        ),
        (
            Self::Fill,
            Icon::Fill,
            "Chart fill",
            "Paints all connected pixels of the same colour (F).",
        ),
        (
            Self::Pick,
            Icon::Pick,
            "Chart pick",
            "Takes the colour to paint with from the chart (I).",
        ),
        (
            Self::Crop,
            Icon::Crop,
            "Chart crop",
            "Marks the part of the chart that is to be kept (C). With Shift a square.",
        ),
    ];

    /// Keys of the tools while the canvas has the focus, those of the pattern's editor; some with Shift.
    const KEYS: [(bool, Key, Self); 7] = [
        (false, Key::P, Self::Pencil),
        (false, Key::L, Self::Line),
        (false, Key::R, Self::Rectangle),
        (true, Key::R, Self::FilledRectangle),
        (false, Key::F, Self::Fill),
        (false, Key::I, Self::Pick),
        (false, Key::C, Self::Crop),
    ];
}

/// State of the editor.
pub struct ChartEditor {
    /// Whether it is open.
    pub is_open: bool,
    tool: Tool,
    brush: usize,
    /// Colour to paint with.
    pub colour: [u8; 4],
    shows_grid: bool,
    canvas: Canvas,
    work: ChartWork,
    resize: bars::Resize,
    /// The pixel under the pointer, or under the keys' cursor.
    under: Option<[i32; 2]>,
    /// Size of the chart that was last shown, to notice another.
    size: [usize; 2],
}

impl Default for ChartEditor {
    fn default() -> Self {
        Self {
            is_open: false,
            tool: Tool::default(),
            brush: 1,
            colour: [0x1f, 0x3a, 0x6e, 255],
            shows_grid: true,
            canvas: Canvas::default(),
            work: ChartWork::default(),
            resize: bars::Resize::default(),
            under: None,
            size: [0; 2],
        }
    }
}

impl ChartEditor {
    /// Shows the editor in all of `ui`. Returns what the history is to call a change, where that cannot be seen from
    /// the charts before and after.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        design: &mut Design,
        yarns: &mut ChartYarns,
    ) -> Option<String> {
        let mut name = self.work.take(&mut design.chart);
        self.notice(&design.chart);
        if let Some(named) = bars::show(ui, self, design, yarns) {
            name = Some(named);
        }
        let Design { chart, sheet, .. } = design;
        if chart.pixels.is_some() {
            bars::status(ui, self, chart, sheet);
            canvas::show(ui, self, chart, sheet);
        } else {
            ui.add_space(24.0);
            ui.vertical_centered(|ui| {
                ui.label("The cloth has one colour and no chart.");
                ui.weak("Open or paste an image in the Chart panel, or start with an empty chart.");
                ui.add_space(6.0);
                let [width, height] = bars::sheet_size(sheet);
                let text = format!("New chart of {width} × {height} px");
                let new = ui.button(text).on_hover_text(
                    "A chart with a pixel for every crossing of the cloth, in the colour that the cloth has.",
                );
                if new.clicked() {
                    let [r, g, b] = chart.colour.0;
                    bars::start_blank(chart, sheet, [r, g, b, 255]);
                    name = Some("new chart".into());
                }
            });
        }
        name
    }

    /// A chart of another size is seen whole.
    fn notice(&mut self, chart: &Chart) {
        let size = |image: &ChartImage| [image.width(), image.height()];
        let size = chart.pixels.as_ref().map_or([0; 2], size);
        if size != self.size {
            self.size = size;
            self.canvas.scale = None;
            self.canvas.reset();
            self.resize = bars::Resize::of(size);
        }
    }
}
