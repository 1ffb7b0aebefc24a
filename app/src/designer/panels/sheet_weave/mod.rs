//! Sheet & weave: size of the ground weave, and the stitch pattern on a grid, in the panel or in a large window of its
//! own beside the picture.

mod legend;
mod ready;
mod size;
mod tools;

use egui::{Context, RichText, ScrollArea, Ui, Vec2, Window, vec2};
use renderer_core::design::{Anchor, Back, Design, NewCells, Pattern, STITCHES, Weave};

use crate::designer::panels::choice_row::choice;
use crate::designer::widgets::{
    GridAccess, GridCell, GridEditor, GridView, Icon, IconButton, grid_editor, subheading,
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
    /// The size that was asked for in cm.
    wanted: size::Wanted,
}

impl Default for State {
    fn default() -> Self {
        Self {
            editor: GridEditor::new(7),
            is_enlarged: false,
            anchor: Anchor::default(),
            new_cells: NewCells::default(),
            before_resizing: None,
            wanted: size::Wanted::default(),
        }
    }
}

/// Largest height of the grid in the panel, points.
const HEIGHT_IN_PANEL: f32 = 234.0;
/// Width of the legend in the large window, points.
const LEGEND_WIDTH: f32 = 156.0;

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut State, design: &mut Design) {
    size::show(ui, &mut state.wanted, &mut design.sheet);
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
