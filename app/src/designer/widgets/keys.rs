//! Arrow keys for widgets that are dragged on: canvases, pictures that turn, the viewport.

use egui::{EventFilter, Key, Response, Ui};

/// How often the arrow keys were pressed, right and up positive, while the widget has the focus; `None` without it. The
/// arrows then belong to the widget and do not move the focus.
pub fn arrow_keys(ui: &Ui, response: &Response) -> Option<[i32; 2]> {
    if !response.has_focus() {
        return None;
    }
    let keep = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
    let presses = |key| ui.input(|i| i.num_presses(key)) as i32;
    Some([
        presses(Key::ArrowRight) - presses(Key::ArrowLeft),
        presses(Key::ArrowUp) - presses(Key::ArrowDown),
    ])
}
