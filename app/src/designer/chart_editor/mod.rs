//! The chart editor: beside the viewport, a canvas to paint, cut and turn the chart on, while the cloth follows.
//!
//! It edits the chart of the design and nothing else. Painting makes the chart the design's own: it has pixels and no
//! path, and the file it came from is never written. Stripes, shapes, letters and pictures lie on the chart as objects
//! until they are flattened.

mod bars;
mod canvas;
mod object_bar;
mod object_gestures;
pub mod objects;
mod overlay;
mod pyramid;
mod rulers;
mod snap;
pub mod work;
pub mod yarn_name;

use egui::{Key, Ui};
use renderer_core::design::chart_edit::{BARE, YarnCount};
use renderer_core::design::chart_objects::ChartCanvas;
use renderer_core::design::{Chart, ChartImage, Design, ObjectKind};
use renderer_core::scene::{ChartComposer, ChartYarns};

use canvas::Canvas;
use objects::Objects;
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
    /// Chooses, moves, scales and turns what lies on the chart.
    Select,
    /// Lays something of this kind on the chart.
    Add(ObjectKind),
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

    /// Tools for what lies on the chart, as [`Self::ALL`].
    const OBJECTS: [(Self, Icon, &'static str, &'static str); 7] = [
        (
            Self::Select,
            Icon::Arrow,
            "Select objects",
            "Chooses what lies on the chart; drag it, its corners to scale it, the round handle to turn it (V). Alt lets go \
            of edges and guides.",
        ),
        (
            Self::Add(ObjectKind::StripeAcross),
            Icon::StripeAcross,
            "Stripe across",
            "Drag over the breadth of a stripe from side to side (S).",
        ),
        (
            Self::Add(ObjectKind::StripeAlong),
            Icon::StripeAlong,
            "Stripe along",
            "Drag over the breadth of a stripe from the near edge to the far one (Shift+S).",
        ),
        (
            Self::Add(ObjectKind::Rectangle),
            Icon::FilledRectangle,
            "Rectangle object",
            "Drag a rectangle that can be changed later (B). With Shift a square on the cloth.",
        ),
        (
            Self::Add(ObjectKind::Ellipse),
            Icon::Ellipse,
            "Ellipse object",
            "Drag an ellipse that can be changed later (E). With Shift a circle on the cloth.",
        ),
        (
            Self::Add(ObjectKind::Line),
            Icon::Line,
            "Line object",
            "Drag a straight line that can be changed later (N). With Shift level, upright or diagonal.",
        ),
        (
            Self::Add(ObjectKind::Text),
            Icon::Letters,
            "Text object",
            "Drag as high as the letters are to be (T).",
        ),
    ];

    /// Keys of the tools while the canvas has the focus, those of the pattern's editor; some with Shift.
    const KEYS: [(bool, Key, Self); 14] = [
        (false, Key::P, Self::Pencil),
        (false, Key::L, Self::Line),
        (false, Key::R, Self::Rectangle),
        (true, Key::R, Self::FilledRectangle),
        (false, Key::F, Self::Fill),
        (false, Key::I, Self::Pick),
        (false, Key::C, Self::Crop),
        (false, Key::V, Self::Select),
        (false, Key::S, Self::Add(ObjectKind::StripeAcross)),
        (true, Key::S, Self::Add(ObjectKind::StripeAlong)),
        (false, Key::B, Self::Add(ObjectKind::Rectangle)),
        (false, Key::E, Self::Add(ObjectKind::Ellipse)),
        (false, Key::N, Self::Add(ObjectKind::Line)),
        (false, Key::T, Self::Add(ObjectKind::Text)),
    ];

    /// Whether it is for what lies on the chart rather than for its pixels.
    fn is_for_objects(self) -> bool {
        matches!(self, Self::Select | Self::Add(_))
    }
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
    /// What lies on the chart.
    pub objects: Objects,
    composer: ChartComposer,
    work: ChartWork,
    resize: bars::Resize,
    /// The pixel under the pointer, or under the keys' cursor.
    under: Option<[i32; 2]>,
    /// Size of the chart that was last shown, to notice another.
    size: [usize; 2],
    /// Whether a yarn of the chart that is there has been offered to paint with.
    offered: bool,
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
            objects: Objects::default(),
            composer: ChartComposer::default(),
            work: ChartWork::default(),
            resize: bars::Resize::default(),
            under: None,
            size: [0; 2],
            offered: false,
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
        if has_canvas(&design.chart) {
            bars::status(ui, self, &design.chart, &design.sheet);
            name = object_bar::show(ui, self, design).or(name);
            canvas::show(ui, self, design);
        } else {
            let Design { chart, sheet, .. } = design;
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

    /// Offers a yarn of the chart to paint with, once for each chart.
    fn offer_paint(&mut self, chart: &Chart, yarns: &[YarnCount]) {
        let is_new = self.offered != chart.pixels.is_some();
        self.offered = chart.pixels.is_some();
        if let (true, Some(paint)) = (is_new, first_paint(yarns)) {
            self.colour = paint;
        }
    }

    /// Has what was just laid on the chart chosen, and the tool for that.
    pub fn choose_last(&mut self, chart: &Chart) {
        self.tool = Tool::Select;
        self.objects.selected = chart.object.len().checked_sub(1);
    }

    /// A chart of another size is seen whole.
    fn notice(&mut self, chart: &Chart) {
        let size = |image: &ChartImage| [image.width(), image.height()];
        let size = chart.pixels.as_ref().map_or([0; 2], size);
        self.objects.keep_within(chart);
        if size != self.size {
            self.size = size;
            self.canvas.scale = None;
            self.canvas.reset();
            self.resize = bars::Resize::of(size);
        }
    }
}

/// Whether there is something to paint on.
fn has_canvas(chart: &Chart) -> bool {
    chart.pixels.is_some() || !chart.object.is_empty()
}

/// The canvas of a chart, its pixels those of the image below the objects.
fn chart_canvas(design: &Design) -> ChartCanvas {
    ChartCanvas::of(&design.chart, &design.sheet)
}

/// Which of a chart's yarns is offered to paint with: the second, or what is there already where there is but one,
/// since that one would not show.
fn first_paint(yarns: &[YarnCount]) -> Option<[u8; 4]> {
    let mut yarns = yarns.iter().filter(|yarn| yarn.colour != BARE);
    yarns.nth(1).map(|yarn| yarn.colour)
}
