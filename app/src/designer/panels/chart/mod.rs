//! Chart: the image that colours the loops, how it lies on the cloth, its yarns, and the way to the chart editor.

mod reduce;
mod yarns;

use egui::{Color32, Stroke, Ui, vec2};
use renderer_core::design::{Chart, ChartImage, Design, Fit, ImageSlot, Sheet};
use renderer_core::scene::ChartYarns;

use crate::designer::chart_editor::ChartEditor;
use crate::designer::document::labels::label_of;
use crate::designer::panels::choice_row::{check, choice, colour};
use crate::designer::panels::image_preview::{Picture, file_label, reduced};
use crate::designer::panels::surroundings::Surroundings;
use crate::designer::shell::command::Command;
use crate::designer::widgets::{
    NumberField, Thumbnail, about_dropping, check_box, row, show_thumbnail,
};

/// Picture of the chart, its yarns, and the editor.
#[derive(Default)]
pub struct State {
    thumbnail: Thumbnail<Picture>,
    shows_grid: bool,
    yarns: yarns::State,
    reduce: reduce::State,
    /// The editor, which stands beside the viewport.
    pub editor: ChartEditor,
}

impl State {
    /// The editor, and the yarns of the chart, counted.
    pub fn editor_and_yarns(&mut self) -> (&mut ChartEditor, &mut ChartYarns) {
        (&mut self.editor, &mut self.yarns.counted)
    }

    /// Forgets what the last frame has shown.
    pub fn begin_frame(&mut self) {
        self.yarns.is_shown = false;
    }

    /// Whether the table of yarns was shown in this frame.
    pub fn has_yarn_table(&self) -> bool {
        self.yarns.is_shown
    }

    /// The chart that the cloth shows instead of the design's, while it is tried out.
    pub fn preview(&self, chart: &Chart) -> Option<&ChartImage> {
        self.reduce.preview(chart)
    }
}

/// Largest side of the picture of the chart, points.
const SIDE: usize = 132;
/// Lines of the yarn grid over the picture are at least this far apart, points.
const GRID_FROM: f32 = 4.0;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design, around: &mut Surroundings<'_>) {
    files(ui, &mut design.chart, around);
    let has_picture = around.woven.pixels.is_some();
    if has_picture {
        picture(ui, state, design, around.woven);
    }
    if !has_picture {
        ui.horizontal(|ui| edit_button(ui, &mut state.editor));
    }
    layout(ui, &mut design.chart);
    let mut name = yarns::show(ui, &mut state.yarns, design);
    if let Some(named) = reduce::show(ui, &mut state.reduce, &mut design.chart) {
        name = Some(named);
    }
    if name.is_some() {
        *around.step_name = name;
    }
}

fn files(ui: &mut Ui, chart: &mut Chart, around: &mut Surroundings<'_>) {
    ui.horizontal(|ui| {
        let what = format!("Chooses an image. {}", about_dropping(ui.ctx(), "One"));
        if ui.button("Open chart…").on_hover_text(what).clicked() {
            around.commands.push(Command::OpenImage(ImageSlot::Chart));
        }
        let paste = ui.button("Paste").accessible_name("Paste chart");
        if paste
            .on_hover_text("Makes the image in the clipboard the chart, or lays it on the chart that there is (Ctrl+V).")
            .clicked()
        {
            around.commands.push(Command::PasteChart);
        }
        let has_some = chart.pixels.is_some() || !chart.object.is_empty();
        let clear = ui.add_enabled(has_some, egui::Button::new("Clear chart"));
        if clear
            .on_hover_text("Removes the image and what lies on it; all loops have one colour again.")
            .clicked()
        {
            chart.pixels = None;
            chart.image = None;
            chart.object.clear();
        }
    });
}

fn edit_button(ui: &mut Ui, editor: &mut ChartEditor) {
    let edit = egui::Button::selectable(editor.is_open, "Edit chart…").frame_when_inactive(true);
    let edit = ui.add(edit).accessible_name("Edit chart");
    if edit
        .on_hover_text(
            "Opens the chart beside the cloth: paint, crop, turn and scale it, loop by loop.",
        )
        .clicked()
    {
        editor.is_open = !editor.is_open;
    }
}

/// The picture, with what there is to say about it beside.
fn picture(ui: &mut Ui, state: &mut State, design: &Design, woven: &Chart) {
    let (chart, sheet) = (&design.chart, &design.sheet);
    let Some(image) = &woven.pixels else { return };
    let shown = state.reduce.preview(chart).unwrap_or(image).clone();
    let (width, height) = (shown.width(), shown.height());
    let shrink = (SIDE as f32 / width.max(height) as f32).min(8.0);
    let size = vec2(width as f32, height as f32) * shrink;
    let texture = state
        .thumbnail
        .texture(ui, "chart", Picture(shown), |Picture(image)| {
            reduced(image, SIDE)
        });
    ui.add_space(2.0);
    ui.horizontal_top(|ui| {
        let size = size.max(vec2(4.0, 4.0));
        let rect = show_thumbnail(ui, &texture, size, "Chart image").rect;
        if state.shows_grid {
            grid(ui, rect, chart, sheet, image);
        }
        ui.vertical(|ui| {
            file_label(ui, chart.image.as_deref(), "painted here", [width, height]);
            match chart.object.len() {
                0 => {}
                1 => drop(ui.weak("1 object lies on it")),
                count => drop(ui.weak(format!("{count} objects lie on it"))),
            }
            edit_button(ui, &mut state.editor);
            check_box(ui, &mut state.shows_grid, "Grid").on_hover_text(
                "Lines between the crossings of the cloth, or every tenth or hundredth of them.",
            );
        });
    });
}

/// Lines between crossings, of as many as fit.
fn grid(ui: &Ui, rect: egui::Rect, chart: &Chart, sheet: &Sheet, image: &ChartImage) {
    let cells = match chart.fit {
        Fit::Stretch => [sheet.warps as f32, sheet.wefts as f32],
        Fit::Tile | Fit::Place => [image.width() as f32, image.height() as f32],
    };
    let stroke = Stroke::new(1.0, Color32::from_black_alpha(120));
    for (axis, cells) in cells.into_iter().enumerate() {
        let distance = rect.size()[axis] / cells;
        let every = [1.0, 10.0, 100.0, 1000.0].into_iter();
        let Some(every) = every
            .into_iter()
            .find(|every| distance * every >= GRID_FROM)
        else {
            continue;
        };
        for k in 1..(cells / every).ceil() as usize {
            let at = rect.min[axis] + k as f32 * distance * every;
            if axis == 0 {
                ui.painter().vline(at, rect.y_range(), stroke);
            } else {
                ui.painter().hline(rect.x_range(), at, stroke);
            }
        }
    }
}

/// How the chart lies on the cloth.
fn layout(ui: &mut Ui, chart: &mut Chart) {
    let has_image = chart.pixels.is_some();
    if has_image {
        ui.add_space(4.0);
        choice(
            ui,
            "Fit",
            "How the chart's pixels are laid over the loops.",
            &mut chart.fit,
        );
    }
    if !has_image || chart.fit == Fit::Place {
        let (label, what) = if has_image {
            (
                "Around it",
                "Colour of the cloth around the chart and where it is transparent.",
            )
        } else {
            ("Colour", "Colour of all loops where there is no image.")
        };
        colour(ui, label, what, &mut chart.colour);
    }
    if !has_image {
        return;
    }
    match chart.fit {
        Fit::Stretch => check(
            ui,
            "Average",
            "Each loop takes the mean colour of the pixels around it: for photographs. Without it a loop has the colour of \
             the pixel at its middle, and no colour that the chart has not.",
            &mut chart.average,
        ),
        Fit::Tile => {
            check(
                ui,
                "Mirror x",
                "Every second repeat along the weft is mirrored.",
                &mut chart.mirror_x,
            );
            check(
                ui,
                "Mirror y",
                "Every second repeat along the warp is mirrored.",
                &mut chart.mirror_y,
            );
            check(
                ui,
                "Half drop",
                "Every second column of repeats is shifted by half a repeat.",
                &mut chart.half_drop,
            );
        }
        Fit::Place => {
            let fields = Chart::FIELDS;
            for (field, value) in [
                (&fields.offset_x, &mut chart.offset_x),
                (&fields.offset_y, &mut chart.offset_y),
            ] {
                let label = label_of(field.name);
                row(ui, &label, field.what, |ui, label| {
                    let offset = NumberField::new(value, field.unit, field.min..=field.max);
                    let offset = offset.speed(0.3).show(ui);
                    offset.labelled_by(label.id).on_hover_text(field.what);
                    ui.weak(field.unit);
                });
            }
            let what = "Puts the chart into the middle of the cloth.";
            row(ui, "", what, |ui, _| {
                let centred = (chart.offset_x, chart.offset_y) == (0, 0);
                let centre = ui.add_enabled(!centred, egui::Button::new("Centre"));
                if centre
                    .accessible_name("Centre chart")
                    .on_hover_text(what)
                    .clicked()
                {
                    (chart.offset_x, chart.offset_y) = (0, 0);
                }
            });
        }
    }
}
