//! Help: keys, gestures, version.

use egui::{Align2, Context, Grid, RichText, ScrollArea, Ui, Window};

use crate::designer::shell::command::SHORTCUTS;

/// Something to know: keys or a gesture, and what they do.
type Line = (&'static str, &'static str);

/// What pointer and keys do in a part of the window.
struct Part(&'static str, &'static [Line]);

const CLOTH: Part = Part(
    "The cloth",
    &[
        ("Drag", "Turn it"),
        ("Shift, middle or right drag", "Move it"),
        ("Wheel, pinch", "Zoom to the pointer"),
        ("Two fingers", "Move it (trackpads; not on X11)"),
        ("Alt + two fingers", "Turn it"),
        ("Arrows, Shift + arrows", "Turn it, move it"),
        ("+ and −", "Zoom"),
        ("F or Home", "Fit it into the picture"),
        ("T", "True scale 1:1"),
        ("O", "Parallel projection or perspective"),
        ("L", "Loupe"),
        ("B", "Scale bar"),
        ("S", "Take a snapshot"),
        ("C", "Compare with the snapshot"),
        ("Alt+1 … Alt+9", "Saved views"),
        (
            "Drag a point of the net",
            "Pull the cloth; with Alt up and down",
        ),
        ("F11", "The cloth alone, and back"),
    ],
);

const PATTERN: Part = Part(
    "Stitch pattern",
    &[
        ("Arrows", "Move the cursor"),
        ("Space", "Paint"),
        ("0 1 7 8 9", "Paint that stitch"),
        ("P L R Shift+R F I", "Tools, from left to right"),
        ("Shift + arrows", "Draw out a line or rectangle"),
        ("Enter, Escape", "Paint it, take it back"),
        ("Right click, Alt + click", "Pick the stitch"),
        ("Shift while drawing out", "Straight line, square"),
        ("M, Shift+M", "Mirror the pattern"),
        ("T", "Rotate it"),
        ("Ctrl + arrows", "Shift it"),
        ("+ and −, Ctrl + wheel", "Size of the cells"),
    ],
);

const CHART: Part = Part(
    "Chart editor",
    &[
        ("P L R Shift+R F I C", "Tools, from left to right"),
        ("[ and ]", "Size of the brush"),
        ("Arrows, Shift + arrows", "Move by one or ten pixels"),
        ("Space or Enter", "Paint"),
        ("Right click, Alt + click", "Pick the colour"),
        ("Wheel", "Zoom"),
        ("Middle or right drag", "Move the chart"),
        ("Home", "The whole chart"),
    ],
);

const NUMBERS: Part = Part(
    "Numbers and curves",
    &[
        ("Double click", "Reset the number"),
        ("Drag on a value", "Change it finely"),
        ("Arrows", "Move a point of the curve"),
        ("Page up, Page down", "Select the next point"),
        ("Delete", "Remove the point"),
    ],
);

/// Width of the window from which the parts stand side by side, points.
const TWO_COLUMNS_FROM: f32 = 820.0;
/// What the window's frame, its title and the bars around it take of the height, points.
const AROUND: f32 = 110.0;
/// Width of the keys, points: all columns are alike.
const KEYS_WIDTH: f32 = 160.0;

/// Shows the help window.
pub fn show(ctx: &Context, is_open: &mut bool) {
    let room = ctx.content_rect();
    Window::new("Keys and version")
        .open(is_open)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(room.center())
        // As high as it has to be; a window's own default would scroll where there is room.
        .default_height(room.height() - AROUND)
        .show(ctx, |ui| {
            let version = concat!("Towel Designer ", env!("CARGO_PKG_VERSION"));
            ui.label(format!("{version}. Every yarn loop, live."));
            ui.add_space(4.0);
            ScrollArea::vertical()
                .max_height((room.height() - AROUND).max(100.0))
                .show(ui, |ui| {
                    if room.width() < TWO_COLUMNS_FROM {
                        everywhere(ui);
                        [CLOTH, PATTERN, CHART, NUMBERS]
                            .iter()
                            .for_each(|p| part(ui, p));
                        return;
                    }
                    ui.horizontal_top(|ui| {
                        ui.vertical(|ui| {
                            everywhere(ui);
                            part(ui, &CLOTH);
                        });
                        ui.add_space(28.0);
                        ui.vertical(|ui| {
                            [PATTERN, CHART, NUMBERS].iter().for_each(|p| part(ui, p));
                        });
                    });
                });
        });
}

/// The keys of commands, those of the same command in one line.
fn everywhere(ui: &mut Ui) {
    let mut lines: Vec<(String, &str)> = Vec::new();
    for (_, shortcut, what) in SHORTCUTS {
        let keys = ui.ctx().format_shortcut(shortcut);
        match lines.iter_mut().find(|(_, other)| other == what) {
            Some((all, _)) => *all = format!("{all}, {keys}"),
            None => lines.push((keys, what)),
        }
    }
    let lines = lines.iter().map(|(keys, what)| (keys.as_str(), *what));
    grid(ui, "Everywhere", lines);
}

fn part(ui: &mut Ui, Part(heading, lines): &Part) {
    grid(ui, heading, lines.iter().copied());
}

fn grid<'a>(ui: &mut Ui, heading: &str, lines: impl Iterator<Item = (&'a str, &'a str)>) {
    ui.add_space(6.0);
    ui.label(RichText::new(heading).strong());
    Grid::new(heading)
        .num_columns(2)
        .min_row_height(16.0)
        .min_col_width(KEYS_WIDTH)
        .spacing([12.0, 2.0])
        .show(ui, |ui| {
            for (keys, what) in lines {
                ui.label(keys);
                ui.weak(what);
                ui.end_row();
            }
        });
}
