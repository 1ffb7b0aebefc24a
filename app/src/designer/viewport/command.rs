//! What can be asked of the view, and the keys for it.

use egui::{Key, KeyboardShortcut, Modifiers};

/// Something to do with the view. What changes the design (saving a view, restoring a snapshot) is one step of its
/// history.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ViewCommand {
    /// Show the cloth as the saved view of this number, from 0, sees it.
    Camera(usize),
    /// Save what is seen under this name, or under a free one if that is empty or taken.
    SaveCamera(String),
    /// Change between perspective and parallel projection.
    Orthographic,
    /// Show a millimetre of cloth as a millimetre of screen.
    TrueScale,
    /// Show or hide the window that asks how large the screen's pixels are.
    Calibrate,
    /// Show or hide the scale bar.
    ScaleBar,
    /// Show or hide the loupe.
    Loupe,
    /// Show the picture denoised, or as it is.
    Denoise,
    /// Keep the present picture for comparison.
    Snapshot,
    /// Show or hide the snapshot beside the picture.
    Compare,
    /// Go back to the design and view of the snapshot.
    Restore,
    /// Let the cloth fill the screen, or show the panels again.
    Alone,
}

/// Keys that work wherever the keyboard's focus is.
pub const SHORTCUTS: [(ViewCommand, KeyboardShortcut); 10] = [
    (ViewCommand::Camera(0), alt(Key::Num1)),
    (ViewCommand::Camera(1), alt(Key::Num2)),
    (ViewCommand::Camera(2), alt(Key::Num3)),
    (ViewCommand::Camera(3), alt(Key::Num4)),
    (ViewCommand::Camera(4), alt(Key::Num5)),
    (ViewCommand::Camera(5), alt(Key::Num6)),
    (ViewCommand::Camera(6), alt(Key::Num7)),
    (ViewCommand::Camera(7), alt(Key::Num8)),
    (ViewCommand::Camera(8), alt(Key::Num9)),
    (
        ViewCommand::Alone,
        KeyboardShortcut::new(Modifiers::NONE, Key::F11),
    ),
];

/// Keys that work while the viewport has the keyboard's focus.
pub const KEYS: [(ViewCommand, Key); 6] = [
    (ViewCommand::TrueScale, Key::T),
    (ViewCommand::Orthographic, Key::O),
    (ViewCommand::ScaleBar, Key::B),
    (ViewCommand::Loupe, Key::L),
    (ViewCommand::Snapshot, Key::S),
    (ViewCommand::Compare, Key::C),
];

const fn alt(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::ALT, key)
}
