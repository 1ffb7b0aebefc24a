//! What surrounds the cloth and the panels: menus, bars, messages, questions and system dialogs, and the commands that
//! they give (`app` carries them out).

pub mod bars;
pub mod command;
pub mod command_buttons;
pub mod dialogs;
pub mod help;
pub mod keyboard_focus;
pub mod notices;
pub mod questions;
pub mod status;
pub mod view_bar;

use command::Command;
use dialogs::Dialogs;
use keyboard_focus::KeyboardFocus;
use notices::Notices;

/// The state of what surrounds the cloth and the panels.
pub struct Shell {
    /// What was asked for in this frame, to be carried out at its end.
    pub commands: Vec<Command>,
    /// Messages over the cloth.
    pub notices: Notices,
    /// The dialog that asks for a file.
    pub dialogs: Dialogs,
    /// What has the keyboard.
    pub focus: KeyboardFocus,
    /// Whether keys and version are shown.
    pub help_is_open: bool,
    /// Whether the presets were shown in the last frame.
    pub has_presets: bool,
    /// Whether the cloth fills the window, without panels.
    pub is_alone: bool,
    /// Frames left to wait for what the clipboard was asked for.
    pub pasting: Option<u32>,
}

impl Shell {
    /// The shell at the start.
    pub fn new(dialogs: Dialogs) -> Self {
        Self {
            commands: Vec::new(),
            notices: Notices::default(),
            dialogs,
            focus: KeyboardFocus::default(),
            help_is_open: false,
            has_presets: true,
            is_alone: false,
            pasting: None,
        }
    }
}
