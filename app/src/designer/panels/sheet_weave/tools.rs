//! Buttons of the weave editor: tools, zoom, and what changes the whole pattern.

use egui::{
    Key, Modifiers, Popup, PopupCloseBehavior, Rect, Response, Role, Sense, StrokeKind, Ui, Vec2,
    WidgetInfo,
};
use renderer_core::design::{Anchor, Keep, NewCells, Pattern, Weave};

use super::{State, icon_button, ready};
use crate::designer::widgets::{GridEditor, GridTool, Icon, IconButton, NumberField};

/// Tools and zoom.
pub(super) fn tools(ui: &mut Ui, editor: &mut GridEditor, is_enlarged: &mut bool) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for tool in GridTool::ALL {
            let button = IconButton::new(tool.icon(), tool.name(), tool.what());
            if ui.add(button.on(editor.tool == tool)).clicked() {
                editor.tool = tool;
            }
        }
        ui.separator();
        if icon_button(
            ui,
            Icon::ZoomOut,
            "Smaller cells",
            "Shows smaller cells (− on the grid, Ctrl and wheel).",
        ) {
            editor.zoom_by(-1.0);
        }
        if icon_button(
            ui,
            Icon::ZoomIn,
            "Larger cells",
            "Shows larger cells (+ on the grid, Ctrl and wheel).",
        ) {
            editor.zoom_by(1.0);
        }
        if ui
            .button("Fit")
            .accessible_name("Fit the pattern")
            .on_hover_text("Shows the whole pattern.")
            .clicked()
        {
            editor.zoom_to_fit();
        }
        if !*is_enlarged {
            ui.separator();
            let what = "Opens the editor in a large window beside the picture.";
            if icon_button(ui, Icon::Enlarge, "Enlarge the weave editor", what) {
                *is_enlarged = true;
                editor.zoom_to_fit();
            }
        }
    });
}

/// Icon, name, explanation and doing of a button that changes the whole pattern.
type Whole = (Icon, &'static str, &'static str, fn(&Pattern) -> Pattern);

/// What each button does to the whole pattern.
const WHOLE: [Whole; 7] = [
    (
        Icon::MirrorHorizontally,
        "Mirror left and right",
        "Exchanges left and right of the pattern (M).",
        Pattern::mirrored_left_right,
    ),
    (
        Icon::MirrorVertically,
        "Mirror near and far",
        "Exchanges the near and the far side of the pattern (Shift+M).",
        Pattern::mirrored_near_far,
    ),
    (
        Icon::Rotate,
        "Rotate",
        "Turns the pattern by a quarter, clockwise (T).",
        Pattern::turned,
    ),
    (
        Icon::ShiftLeft,
        "Shift left",
        "Moves the pattern by one warp to the left; what leaves comes in at the right (Ctrl+Left).",
        |pattern| pattern.shifted(-1, 0),
    ),
    (
        Icon::ShiftRight,
        "Shift right",
        "Moves the pattern by one warp to the right; what leaves comes in at the left (Ctrl+Right).",
        |pattern| pattern.shifted(1, 0),
    ),
    (
        Icon::ShiftUp,
        "Shift up",
        "Moves the pattern by one weft to the far side; what leaves comes in at the near one (Ctrl+Up).",
        |pattern| pattern.shifted(0, 1),
    ),
    (
        Icon::ShiftDown,
        "Shift down",
        "Moves the pattern by one weft to the near side; what leaves comes in at the far one (Ctrl+Down).",
        |pattern| pattern.shifted(0, -1),
    ),
];

/// Keys of [`WHOLE`], in its order.
const KEYS: [(Modifiers, Key); 7] = [
    (Modifiers::NONE, Key::M),
    (Modifiers::SHIFT, Key::M),
    (Modifiers::NONE, Key::T),
    (Modifiers::COMMAND, Key::ArrowLeft),
    (Modifiers::COMMAND, Key::ArrowRight),
    (Modifiers::COMMAND, Key::ArrowUp),
    (Modifiers::COMMAND, Key::ArrowDown),
];

/// Ready patterns, changes of the whole pattern, and its size.
pub(super) fn changes(ui: &mut Ui, state: &mut State, weave: &mut Weave) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (icon, name, what, change) in WHOLE {
            if icon_button(ui, icon, name, what) {
                weave.pattern = change(&weave.pattern);
            }
        }
    });
    ui.horizontal(|ui| {
        ready::menu(ui, weave);
        ui.separator();
        size(ui, state, &mut weave.pattern);
    });
}

/// Changes the whole pattern as the keys pressed ask for.
pub(super) fn take_keys(ui: &Ui, pattern: &mut Pattern) {
    for ((modifiers, key), (.., change)) in KEYS.into_iter().zip(WHOLE) {
        let pressed = ui.input(|i| i.modifiers.matches_exact(modifiers) && i.key_pressed(key));
        if pressed {
            *pattern = change(pattern);
        }
    }
}

/// Columns and rows, and what happens to the content when they change.
fn size(ui: &mut Ui, state: &mut State, pattern: &mut Pattern) {
    let (mut cols, mut rows) = (pattern.cols(), pattern.rows());
    let side = |ui: &mut Ui, value| {
        let side = NumberField::new(value, "", 1..=Pattern::MAX_SIDE);
        side.speed(0.1).show(ui)
    };
    let wide = side(ui, &mut cols)
        .accessible_name("Pattern columns")
        .on_hover_text(
            "Columns of the pattern: its repeat along the weft. What is painted is kept.",
        );
    ui.label("×");
    let long = side(ui, &mut rows)
        .accessible_name("Pattern rows")
        .on_hover_text("Rows of the pattern: its repeat along the warp. What is painted is kept.");
    let resized =
        |from: &Pattern, cols, rows| from.resized(cols, rows, state.anchor, state.new_cells);
    if (cols, rows) != (pattern.cols(), pattern.rows()) {
        let start = state
            .before_resizing
            .take()
            // The pattern may have been changed by other means since.
            .filter(|start| resized(start, pattern.cols(), pattern.rows()) == *pattern)
            .unwrap_or_else(|| pattern.clone());
        *pattern = resized(&start, cols, rows);
        state.before_resizing = Some(start);
    }
    let goes_on = |response: &Response| response.dragged() || response.has_focus();
    if !(goes_on(&wide) || goes_on(&long)) {
        state.before_resizing = None;
    }
    let button = IconButton::new(
        Icon::Crop,
        "How the size changes",
        "Which side of the pattern stays when its size changes, and what new cells are.",
    );
    let button = ui.add(button);
    Popup::menu(&button)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| how_size_changes(ui, &mut state.anchor, &mut state.new_cells));
}

fn how_size_changes(ui: &mut Ui, anchor: &mut Anchor, new_cells: &mut NewCells) {
    ui.strong("What is painted stays");
    egui::Grid::new("anchor")
        .spacing([2.0, 2.0])
        .min_col_width(0.0)
        .show(ui, |ui| {
            for (y, far) in [
                (Keep::Last, "far"),
                (Keep::Middle, "middle"),
                (Keep::First, "near"),
            ] {
                for (x, left) in [
                    (Keep::First, "left"),
                    (Keep::Middle, "middle"),
                    (Keep::Last, "right"),
                ] {
                    let name = if far == left {
                        "in the middle".into()
                    } else {
                        format!("{far} {left}")
                    };
                    let here = Anchor { x, y };
                    let button = corner(ui, *anchor == here, &format!("Keep {name}"));
                    if button.clicked() {
                        *anchor = here;
                    }
                }
                ui.end_row();
            }
        });
    ui.add_space(4.0);
    ui.strong("New cells");
    ui.radio_value(new_cells, NewCells::Weft, "are flat")
        .on_hover_text("New cells are 0: weft over warp, no loop.");
    ui.radio_value(new_cells, NewCells::Repeat, "repeat the pattern")
        .on_hover_text("New cells go on with the pattern as it repeats over the cloth.");
}

/// One of the nine places where content can stay.
fn corner(ui: &mut Ui, is_chosen: bool, name: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(18.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_chosen, name));
    let look = ui.style().interact_selectable(&response, is_chosen);
    let painter = ui.painter();
    painter.rect(
        rect,
        look.corner_radius,
        look.weak_bg_fill,
        look.bg_stroke,
        StrokeKind::Inside,
    );
    let side = if is_chosen { 9.0 } else { 3.0 };
    let mark = Rect::from_center_size(rect.center(), Vec2::splat(side));
    painter.rect_filled(mark, 1.0, look.text_color());
    response.on_hover_text(name)
}
