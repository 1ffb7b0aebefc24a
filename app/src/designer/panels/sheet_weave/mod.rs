//! Sheet & weave: size of the ground weave, and the stitch pattern on a grid, in the panel or in a large window of its
//! own beside the picture.

mod legend;
mod ready;
mod tools;

use egui::{Context, RichText, ScrollArea, Ui, Vec2, Window, vec2};
use renderer_core::design::{
    Anchor, Back, Design, Field, NewCells, Pattern, STITCHES, Sheet, Weave,
};

use crate::designer::panels::choice_row::choice;
use crate::designer::panels::number_row::number;
use crate::designer::widgets::style::{ROW_HEIGHT, VALUE_WIDTH};
use crate::designer::widgets::{
    GridAccess, GridCell, GridEditor, GridView, Icon, IconButton, NumberField, grid_editor, row,
    subheading,
};
use legend::stitch_name;

/// What the panel remembers.
pub struct State {
    editor: GridEditor,
    /// The editor is in the large window.
    is_enlarged: bool,
    /// Where content stays when the pattern gets another size.
    anchor: Anchor,
    /// What cells are that it gains.
    new_cells: NewCells,
    /// The pattern before its size began to change, so that what a drag cuts off comes back when it returns.
    before_resizing: Option<Pattern>,
}

impl Default for State {
    fn default() -> Self {
        Self {
            editor: GridEditor::new(7),
            is_enlarged: false,
            anchor: Anchor::default(),
            new_cells: NewCells::default(),
            before_resizing: None,
        }
    }
}

/// Largest height of the grid in the panel, points.
const HEIGHT_IN_PANEL: f32 = 234.0;
/// Width of the legend in the large window, points.
const LEGEND_WIDTH: f32 = 156.0;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design) {
    let fields = Sheet::FIELDS;
    let sheet = &mut design.sheet;
    number(ui, &fields.warps, &mut sheet.warps);
    number(ui, &fields.wefts, &mut sheet.wefts);
    number(ui, &fields.warps_per_cm, &mut sheet.warps_per_cm);
    number(ui, &fields.wefts_per_cm, &mut sheet.wefts_per_cm);
    size(ui, sheet);
    let weave = &mut design.weave;
    choice(
        ui,
        "Back",
        "What stands on the back of the cloth.",
        &mut weave.back,
    );
    subheading(ui, "Stitch pattern");
    if state.is_enlarged {
        ui.horizontal(|ui| {
            ui.weak("Open in the weave editor.");
            if ui
                .button("Edit here")
                .on_hover_text("Closes the weave editor and brings the pattern back here.")
                .clicked()
            {
                state.is_enlarged = false;
            }
        });
    } else {
        legend::brushes(ui, &mut state.editor);
        tools::tools(ui, &mut state.editor, &mut state.is_enlarged);
        tools::changes(ui, state, weave);
        let room = vec2(ui.available_width(), HEIGHT_IN_PANEL);
        ui.horizontal_top(|ui| {
            edit(ui, state, weave, room, false);
            legend::repeat_preview(ui, &weave.pattern);
        });
        place(ui, state, &weave.pattern);
    }
    tell_of_bare_back(ui, weave);
}

/// Width and length of the cloth, which are read and typed in cm and kept as numbers of yarns.
fn size(ui: &mut Ui, sheet: &mut Sheet) {
    let what = "Width and length of the cloth: changes how many yarns there are, not how closely they stand.";
    row(ui, "Size", what, |ui, _| {
        let fields = Sheet::FIELDS;
        let width = Side {
            name: "Width of the cloth",
            field: &fields.warps,
            per_cm: sheet.warps_per_cm,
        };
        side(ui, &width, &mut sheet.warps);
        ui.label("×");
        let length = Side {
            name: "Length of the cloth",
            field: &fields.wefts,
            per_cm: sheet.wefts_per_cm,
        };
        side(ui, &length, &mut sheet.wefts);
        ui.weak("cm");
    });
}

/// A side of the cloth.
struct Side<'a> {
    name: &'static str,
    /// The number of its yarns.
    field: &'a Field,
    per_cm: f64,
}

fn side(ui: &mut Ui, side: &Side<'_>, yarns: &mut u32) {
    let &Side {
        name,
        field,
        per_cm,
    } = side;
    let before = f64::from(*yarns) / per_cm;
    let mut cm = before;
    let response = NumberField::new(&mut cm, "cm", field.min / per_cm..=field.max / per_cm)
        .speed(0.1)
        .max_decimals(1)
        .size(vec2(VALUE_WIDTH, ROW_HEIGHT))
        .show(ui)
        .accessible_name(name)
        .on_hover_text(format!(
            "{name}, in cm; the yarns stand as closely as before."
        ));
    if response.changed() && cm != before {
        *yarns = (cm * per_cm).round().clamp(field.min, field.max) as u32;
    }
}

/// Shows the large window, if it is open.
pub fn show_window(ctx: &Context, state: &mut State, design: &mut Design) {
    if !state.is_enlarged {
        return;
    }
    let weave = &mut design.weave;
    let mut is_open = true;
    let screen = ctx.content_rect();
    Window::new("Weave editor")
        .open(&mut is_open)
        .collapsible(false)
        .resizable(true)
        .default_pos(screen.min + vec2(372.0, 76.0))
        .default_size([450.0, 470.0])
        .min_size([400.0, 300.0])
        .max_size(screen.size() - vec2(24.0, 60.0))
        .show(ctx, |ui| {
            tools::tools(ui, &mut state.editor, &mut state.is_enlarged);
            tools::changes(ui, state, weave);
            ui.separator();
            let status = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
            let room = ui.available_size() - vec2(LEGEND_WIDTH + 14.0, status);
            ui.horizontal_top(|ui| {
                ui.allocate_ui(room, |ui| {
                    ui.set_min_size(room);
                    edit(ui, state, weave, room - Vec2::splat(10.0), true);
                });
                ui.vertical(|ui| {
                    ScrollArea::vertical().id_salt("legend").show(ui, |ui| {
                        legend::list(ui, &mut state.editor);
                        tell_of_bare_back(ui, weave);
                    });
                });
            });
            place(ui, state, &weave.pattern);
        });
    state.is_enlarged &= is_open;
}

/// The grid, and the keys that change the whole pattern while it has the focus.
fn edit(ui: &mut Ui, state: &mut State, weave: &mut Weave, room: Vec2, repeats: bool) {
    let cells = STITCHES.map(|value| {
        let (ground, ink) = legend::stitch_colours(value, ui.visuals());
        GridCell {
            value,
            ground,
            ink,
            name: stitch_name(value),
        }
    });
    let response = grid_editor(
        ui,
        "Stitch pattern",
        &mut state.editor,
        &cells,
        &mut weave.pattern,
        GridView { room, repeats },
    );
    if response.has_focus() {
        tools::take_keys(ui, &mut weave.pattern);
    }
}

/// Where the pointer or the cursor is, or how large the shape is that is drawn out.
fn place(ui: &mut Ui, state: &State, pattern: &Pattern) {
    let [col, row] = state.editor.place();
    let value = pattern.at(col.into(), row.into());
    let text = match state.editor.shape_size() {
        Some([cols, rows]) => format!("{cols} × {rows} cells"),
        None => format!(
            "Column {}, row {}: {value} {}",
            col + 1,
            row + 1,
            stitch_name(value)
        ),
    };
    ui.label(RichText::new(text).small().weak());
}

/// Loops that the pattern asks for and the back does not have.
fn tell_of_bare_back(ui: &mut Ui, weave: &Weave) {
    let uses_back = weave.pattern.values().iter().any(|v| matches!(v, 8 | 9));
    if uses_back && weave.back != Back::Pattern {
        let text = "Loops of 8 and 9 on the back stand only where the back follows the pattern.";
        ui.label(RichText::new(text).small().weak());
    }
}

impl GridAccess for Pattern {
    fn size(&self) -> [usize; 2] {
        [self.cols(), self.rows()]
    }

    fn values(&self) -> &[u8] {
        Pattern::values(self)
    }

    fn set(&mut self, col: usize, row: usize, value: u8) {
        Pattern::set(self, col, row, value);
    }
}

/// A button with an icon.
fn icon_button(ui: &mut Ui, icon: Icon, name: &str, tooltip: &str) -> bool {
    ui.add(IconButton::new(icon, name, tooltip)).clicked()
}
