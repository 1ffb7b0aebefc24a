//! Whether files can be dropped on the window: not where it is one of Wayland, for which the window library (winit 0.30)
//! has no such thing yet.

use egui::{Context, Id};

fn key() -> Id {
    Id::unique("files cannot be dropped")
}

/// Notes that no files can be dropped on the window.
pub fn cannot_take_drops(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(key(), true));
}

/// What is said of dropping where a file can be chosen: `subject` names what may be dropped.
pub fn about_dropping(ctx: &Context, subject: &str) -> String {
    let cannot = ctx.data(|data| data.get_temp(key()).unwrap_or(false));
    if cannot {
        "Wayland brings no dropped files here; started with WAYLAND_DISPLAY= before its name, the program takes them."
            .into()
    } else {
        format!("{subject} can also be dropped on the window.")
    }
}
