//! The bars of the chart editor: tools and colours, changes of the whole chart, and what is under the pointer.

use egui::{
    Align, Button, ComboBox, Layout, Panel, Popup, PopupCloseBehavior, RichText, Stroke, Ui, vec2,
};
use renderer_core::design::chart_edit::{
    BARE, LARGEST_BRUSH, Resampling, YarnCount, flip_x, flip_y, resize, rotate_right,
};
use renderer_core::design::{Chart, ChartImage, ChartObject, Colour, Design, Fit, Sheet};
use renderer_core::scene::{ChartOnSheet, ChartYarns};

use super::canvas::{ZOOM_STEP, colour_at, crop_marked, marked_part};
use super::work::put;
use super::yarn_name::yarn_name;
use super::{ChartEditor, Tool, has_canvas};
use crate::designer::widgets::style;
use crate::designer::widgets::{Icon, IconButton, NumberField, check_box, colour_well};

/// Most yarns that have a swatch to paint with.
const MOST_SWATCHES: usize = 24;

/// What the form for another size says.
pub struct Resize {
    size: [usize; 2],
    keeps_proportions: bool,
    resampling: Resampling,
}

impl Default for Resize {
    fn default() -> Self {
        Self {
            size: [1; 2],
            keeps_proportions: true,
            resampling: Resampling::Nearest,
        }
    }
}

impl Resize {
    /// A form that starts with the size that there is.
    pub fn of(size: [usize; 2]) -> Self {
        Self {
            size,
            ..Self::default()
        }
    }
}

/// Size of a chart with a pixel for every crossing, as far as charts go.
pub fn sheet_size(sheet: &Sheet) -> [usize; 2] {
    [sheet.warps, sheet.wefts].map(|cells| (cells as usize).min(ChartImage::MAX_SIDE))
}

/// Makes the chart one colour, with a pixel for every crossing.
pub fn start_blank(chart: &mut Chart, sheet: &Sheet, colour: [u8; 4]) {
    let [width, height] = sheet_size(sheet);
    if let Some(blank) = ChartImage::filled(width, height, colour) {
        put(chart, blank);
    }
}

/// Shows the bars above the canvas. Returns what the history is to call a change made here.
pub fn show(
    ui: &mut Ui,
    editor: &mut ChartEditor,
    design: &mut Design,
    yarns: &mut ChartYarns,
) -> Option<String> {
    let mut name = None;
    ui.horizontal(|ui| {
        ui.strong("Chart editor");
        if editor.work.is_busy() {
            ui.spinner();
            ui.weak("working…");
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = ui.button("Close editor");
            if close
                .on_hover_text("Gives the room back to the cloth.")
                .clicked()
            {
                editor.is_open = false;
            }
        });
    });
    if !has_canvas(&design.chart) {
        return None;
    }
    let image = design.chart.pixels.clone();
    let swatches = yarns.of_design(design).unwrap_or_default();
    editor.offer_paint(&design.chart, &swatches);
    let Design { chart, sheet, .. } = design;
    ui.add_enabled_ui(!editor.work.is_busy(), |ui| {
        ui.horizontal_wrapped(|ui| {
            tools(ui, editor);
            ui.separator();
            if let Some(image) = &image {
                changes(ui, editor, image);
                resize_form(ui, editor, image, sheet);
            }
            let new = ui.button("New");
            if new
                .on_hover_text("Starts an empty chart: a pixel for every crossing of the cloth, in the colour chosen \
                    below.")
                .clicked()
            {
                start_blank(chart, sheet, editor.colour);
                name = Some("new chart".into());
            }
        });
        ui.horizontal_wrapped(|ui| colours(ui, editor, &mut chart.object, &swatches));
        if let Some(image) = &image {
            crop_row(ui, editor, image);
        }
    });
    name
}

fn tools(ui: &mut Ui, editor: &mut ChartEditor) {
    ui.spacing_mut().item_spacing.x = 2.0;
    for group in [Tool::ALL, Tool::OBJECTS] {
        for (tool, icon, name, what) in group {
            let button = IconButton::new(icon, name, what).on(editor.tool == tool);
            if ui.add(button).clicked() {
                editor.tool = tool;
            }
        }
        ui.add_space(6.0);
    }
    let brush = NumberField::new(&mut editor.brush, "px", 1..=LARGEST_BRUSH).speed(0.1);
    brush
        .suffix(" px")
        .show(ui)
        .accessible_name("Brush size")
        .on_hover_text("Width of the brush in pixels of the chart; the keys [ and ] change it.");
}

fn changes(ui: &mut Ui, editor: &mut ChartEditor, image: &ChartImage) {
    type Change = fn(&ChartImage) -> ChartImage;
    let all: [(Icon, &str, &str, &str, Change); 3] = [
        (
            Icon::Rotate,
            "Rotate chart",
            "Turns the chart by a quarter, clockwise.",
            "rotate chart",
            rotate_right,
        ),
        (
            Icon::MirrorHorizontally,
            "Flip chart horizontally",
            "Exchanges left and right.",
            "flip chart",
            flip_x,
        ),
        (
            Icon::MirrorVertically,
            "Flip chart vertically",
            "Exchanges far and near edge.",
            "flip chart",
            flip_y,
        ),
    ];
    for (icon, name, what, step, change) in all {
        if ui.add(IconButton::new(icon, name, what)).clicked() {
            let work = move |image: &ChartImage| Some(change(image));
            editor.work.start(ui.ctx(), step, image, work);
        }
    }
    ui.add_space(4.0);
}

fn resize_form(ui: &mut Ui, editor: &mut ChartEditor, image: &ChartImage, sheet: &Sheet) {
    let open = ui
        .button("Size…")
        .on_hover_text("Scales the chart to another number of pixels.");
    let mut apply = false;
    Popup::from_toggle_button_response(&open)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| {
            ui.set_width(250.0);
            let form = &mut editor.resize;
            let shape = image.height() as f64 / image.width() as f64;
            let [width, height] = &mut form.size;
            ui.horizontal(|ui| {
                let wide = side(ui, width, "Chart width");
                ui.label("×");
                let high = side(ui, height, "Chart height");
                ui.weak("px");
                let other = |value: f64| (value.round() as usize).clamp(1, ChartImage::MAX_SIDE);
                if form.keeps_proportions && wide {
                    *height = other(*width as f64 * shape);
                } else if form.keeps_proportions && high {
                    *width = other(*height as f64 / shape);
                }
            });
            check_box(ui, &mut form.keeps_proportions, "Keep proportions")
                .on_hover_text("Width and height change together.");
            let [warps, wefts] = sheet_size(sheet);
            let to_sheet = ui.button(format!("As the cloth: {warps} × {wefts}"));
            if to_sheet
                .on_hover_text("A pixel for every crossing of warp and weft.")
                .clicked()
            {
                form.size = [warps, wefts];
            }
            ui.horizontal(|ui| {
                let label = ui.label("Pixels");
                let text = |resampling| match resampling {
                    Resampling::Nearest => "nearest",
                    Resampling::Average => "averaged",
                };
                let combo = ComboBox::from_id_salt("resampling")
                    .selected_text(text(form.resampling))
                    .show_ui(ui, |ui| {
                        for (choice, what) in [
                            (Resampling::Nearest, "Keeps the yarns there are."),
                            (
                                Resampling::Average,
                                "Mixes colours: smoother, for photos that are reduced to yarns afterwards.",
                            ),
                        ] {
                            ui.selectable_value(&mut form.resampling, choice, text(choice))
                                .on_hover_text(what);
                        }
                    });
                combo.response.labelled_by(label.id);
            });
            ui.add_space(4.0);
            let differs = form.size != [image.width(), image.height()];
            let button = ui.add_enabled(differs, Button::new("Resize chart"));
            if button.on_hover_text("Scales the chart.").clicked() {
                apply = true;
                ui.close();
            }
        });
    if apply {
        let ([width, height], resampling) = (editor.resize.size, editor.resize.resampling);
        let work = move |image: &ChartImage| resize(image, width, height, resampling);
        editor.work.start(ui.ctx(), "resize chart", image, work);
    }
}

/// A side of the chart to be typed. Returns whether it has changed.
fn side(ui: &mut Ui, value: &mut usize, name: &str) -> bool {
    let side = NumberField::new(value, "px", 1..=ChartImage::MAX_SIDE);
    side.show(ui).accessible_name(name).changed()
}

/// The colour to paint with, which the chosen object takes too.
fn colours(
    ui: &mut Ui,
    editor: &mut ChartEditor,
    objects: &mut [ChartObject],
    yarns: &[YarnCount],
) {
    let before = editor.colour;
    paints(ui, editor, yarns);
    let chosen = editor
        .objects
        .selected
        .and_then(|index| objects.get_mut(index));
    if let Some(object) = chosen.filter(|_| before != editor.colour && editor.tool == Tool::Select)
    {
        let [r, g, b, alpha] = editor.colour;
        object.bare = alpha == 0;
        if !object.bare {
            object.colour = Colour([r, g, b]);
        }
    }
}

fn paints(ui: &mut Ui, editor: &mut ChartEditor, yarns: &[YarnCount]) {
    let [r, g, b, alpha] = editor.colour;
    let mut rgb = [r, g, b];
    let label = ui.label("Paint");
    let button = colour_well(ui, &mut rgb)
        .labelled_by(label.id)
        .on_hover_text("Colour to paint with.");
    if button.changed() {
        editor.colour = [rgb[0], rgb[1], rgb[2], 255];
    }
    let text = if alpha == 0 {
        "bare".into()
    } else {
        String::from(Colour([r, g, b]))
    };
    ui.monospace(text);
    ui.separator();
    ui.spacing_mut().item_spacing.x = 3.0;
    for (index, yarn) in yarns
        .iter()
        .filter(|yarn| yarn.colour != BARE)
        .take(MOST_SWATCHES)
        .enumerate()
    {
        let [r, g, b, _] = yarn.colour;
        let name = format!("Paint with {}", yarn_name(index, yarn.colour));
        let mut button = Button::new("")
            .fill(egui::Color32::from_rgb(r, g, b))
            .stroke(Stroke::new(1.0, style::mark_outline(ui.visuals())))
            .min_size(vec2(20.0, 20.0));
        if editor.colour == yarn.colour {
            button = button.stroke(Stroke::new(2.0, ui.visuals().strong_text_color()));
        }
        if ui
            .add(button)
            .accessible_name(&name)
            .on_hover_text(&name)
            .clicked()
        {
            editor.colour = yarn.colour;
        }
    }
    let bare = ui.selectable_label(editor.colour == BARE, RichText::new("bare").small());
    if bare
        .accessible_name("Paint bare ground")
        .on_hover_text("Paints without yarn: no loops stand there, and the ground weave is seen.")
        .clicked()
    {
        editor.colour = BARE;
    }
}

/// What the crop tool has marked, and the button that cuts it out.
fn crop_row(ui: &mut Ui, editor: &mut ChartEditor, image: &ChartImage) {
    if editor.tool != Tool::Crop {
        return;
    }
    ui.horizontal(|ui| {
        let Some([a, b]) = editor.canvas.marked else {
            ui.weak("Drag over the part of the chart that is to be kept.");
            return;
        };
        let [xs, ys] = marked_part([a, b], image);
        let text = format!("Crop to {} × {}", xs.len(), ys.len());
        let is_some = !xs.is_empty() && !ys.is_empty();
        let button = ui.add_enabled(is_some, Button::new(text));
        if button
            .accessible_name("Crop to the marked part")
            .on_hover_text("Cuts everything else off. Enter does the same.")
            .clicked()
        {
            crop_marked(ui.ctx(), editor, image);
        }
        if ui
            .button("Unmark")
            .on_hover_text("Escape does the same.")
            .clicked()
        {
            editor.canvas.marked = None;
        }
    });
}

/// The bar below the canvas: pixel and crossing under the pointer, grid and zoom.
pub fn status(ui: &mut Ui, editor: &mut ChartEditor, chart: &Chart, sheet: &Sheet) {
    Panel::bottom("chart status")
        .frame(egui::Frame::new().inner_margin(egui::Margin::symmetric(0, 2)))
        .show_separator_line(false)
        .show(ui, |ui| {
            ui.horizontal(|ui| {
                let zoom_out = IconButton::new(Icon::ZoomOut, "Chart zoom out", "Shows more of the chart (−).");
                if ui.add(zoom_out).clicked() {
                    editor.canvas.zoom(1.0 / ZOOM_STEP);
                }
                let zoom_in = IconButton::new(Icon::ZoomIn, "Chart zoom in", "Shows the chart larger (+).");
                if ui.add(zoom_in).clicked() {
                    editor.canvas.zoom(ZOOM_STEP);
                }
                let whole = ui.button("Whole");
                if whole
                    .accessible_name("Show the whole chart")
                    .on_hover_text("Shows the whole chart (Home).")
                    .clicked()
                {
                    editor.canvas.scale = None;
                }
                check_box(ui, &mut editor.shows_grid, "Yarn grid").on_hover_text(
                    "Lines between the crossings of the cloth; of every tenth where they would be too dense.",
                );
                if let Some(place) = editor.under {
                    ui.separator();
                    let text = RichText::new(under(chart, sheet, place)).weak();
                    ui.add(egui::Label::new(text).truncate());
                }
            });
        });
}

/// `12, 40 · #c81e1e · warp 13, weft 98`.
fn under(chart: &Chart, sheet: &Sheet, [x, y]: [i32; 2]) -> String {
    let colour = colour_at(chart, [x, y]).unwrap_or_default();
    let mut text = format!("{x}, {y} · {colour}");
    if let (Fit::Stretch | Fit::Place, Some(image)) = (chart.fit, &chart.pixels) {
        let on_sheet = ChartOnSheet::pixel_by_pixel(chart, [sheet.warps, sheet.wefts]);
        let cell = on_sheet.cell_under(image, [x as usize, y as usize]);
        match cell {
            Some([i, j]) => text += &format!(" · warp {}, weft {}", i + 1, j + 1),
            None => text += " · beside the cloth",
        }
    }
    text
}
