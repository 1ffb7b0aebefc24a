//! Help: keys, gestures, version.

use egui::{Align2, Context, Grid, RichText, Ui, Window};

use super::command::SHORTCUTS;

/// What pointer and keys do where.
const GESTURES: &[(&str, &str)] = &[
    ("Viewport: drag", "Orbit"),
    ("Viewport: Shift, middle or right drag", "Pan"),
    ("Viewport: wheel, pinch", "Zoom to the pointer"),
    (
        "Viewport: two fingers, Alt+two fingers",
        "Pan, orbit (trackpads; not on X11)",
    ),
    ("Viewport: arrows, Shift+arrows", "Orbit, pan"),
    ("Viewport: + and −", "Zoom"),
    ("Viewport: F, Home", "Fit the cloth"),
    ("Viewport: T, O", "True scale 1:1, orthographic or not"),
    ("Viewport: L, B", "Loupe, scale bar"),
    ("Viewport: S, C", "Take a snapshot, compare with it"),
    ("Alt+1 … Alt+9", "Saved views"),
    ("F11", "The cloth alone, and back (also Escape)"),
    (
        "Pattern: arrows, space, 0 1 7 8 9",
        "Move, paint, paint that stitch",
    ),
    (
        "Pattern: P L R Shift+R F I",
        "Pencil, line, rectangle, filled rectangle, fill, pick",
    ),
    (
        "Pattern: Shift+arrows, space or Enter, Escape",
        "Draw out a line or rectangle, paint it, take it back",
    ),
    ("Pattern: right click, Alt and click", "Pick the stitch"),
    ("Pattern: Shift while drawing out", "Straight line, square"),
    (
        "Pattern: M, Shift+M, T, Ctrl+arrows",
        "Mirror, rotate, shift the pattern",
    ),
    ("Pattern: + and −, Ctrl and wheel", "Size of the cells"),
    (
        "Chart: P L R Shift+R F I C, [ and ]",
        "Tools as for the pattern, crop, size of the brush",
    ),
    (
        "Chart: arrows, Shift+arrows, space or Enter",
        "Move by one or ten pixels, paint",
    ),
    (
        "Chart: wheel, middle or right drag, Home",
        "Zoom, pan, whole chart",
    ),
    ("Chart: right click, Alt and click", "Pick the colour"),
    (
        "Curve: arrows, Page up/down, Delete",
        "Move, select, remove a point",
    ),
    ("Number: double click on label or slider", "Reset"),
];

/// Shows the help window.
pub fn show(ctx: &Context, is_open: &mut bool) {
    Window::new("Keys and version")
        .open(is_open)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            ui.label(format!("Towel Designer {}", env!("CARGO_PKG_VERSION")));
            ui.weak("Every yarn loop, live.");
            ui.add_space(8.0);
            Grid::new("keys")
                .num_columns(2)
                .min_row_height(16.0)
                .spacing([24.0, 3.0])
                .show(ui, |ui| {
                    for (_, shortcut, what) in SHORTCUTS {
                        line(ui, &ctx.format_shortcut(shortcut), what);
                    }
                    for (gesture, what) in GESTURES {
                        line(ui, gesture, what);
                    }
                });
        });
}

fn line(ui: &mut Ui, keys: &str, what: &str) {
    ui.label(RichText::new(keys).strong());
    ui.label(what);
    ui.end_row();
}
