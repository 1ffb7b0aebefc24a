//! What menus, buttons, shortcuts and panels can ask the designer to do, and the keys for it.

use std::path::PathBuf;

use egui::{Context, Key, KeyboardShortcut, Modifiers};
use renderer_core::design::{CameraDesign, Design, ImageSlot};

use crate::backend::BackendChoice;
use crate::designer::document::settings::ThemeChoice;
use crate::designer::render_thread::draft_lighting::LiveLight;
use crate::designer::viewport::camera_moves::StandardView;
use crate::designer::viewport::command::{self as view, ViewCommand};
use crate::designer::widgets::UnitSystem;

/// Something to do that is no edit of the design.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Start a plain new design.
    New,
    /// Ask what the new design is to be.
    AskForNew,
    /// Start with this design.
    Start(Box<Design>),
    /// Ask for a preset to open.
    Open,
    /// Open this preset, bundle or picture that carries its design.
    OpenPreset(PathBuf),
    /// Open this preset or picture, which names images outside its folder, with or without these.
    OpenPresetWith(PathBuf, OutsideChoice),
    /// Open a copy of the program's own preset of this name.
    OpenShipped(String),
    /// Save to the document's file, or ask for one.
    Save,
    /// Ask for a file to save to.
    SaveAs,
    /// Ask for a bundle to save to.
    SaveAsBundle,
    /// Save here, whatever is there.
    SaveTo(PathBuf),
    /// Open what a program that ended without saving has left behind, or remove it.
    Recovery(RecoveryChoice),
    /// Something to do with the user's own presets.
    Presets(PresetCommand),
    /// Scale the interface to this many percent.
    Scale(u32),
    /// Make the interface one step larger (`1`) or smaller (`-1`).
    ScaleStep(i32),
    /// Light or dark.
    Theme(ThemeChoice),
    /// Show lengths in these units.
    Units(UnitSystem),
    /// Show the presets, or hide them.
    ShowPresets(bool),
    /// Forget the recent files.
    ClearRecent,
    /// Open the export window.
    Export,
    /// Leave the program.
    Quit,
    /// Take back the last gesture.
    Undo,
    /// Repeat the gesture last taken back.
    Redo,
    /// Ask for an image of the design.
    OpenImage(ImageSlot),
    /// Lay the picture in this file on the chart.
    AddPicture(PathBuf),
    /// Use this file as an image of the design.
    UseImage(ImageSlot, PathBuf),
    /// Make the image in the clipboard the chart, or lay it on the chart that there is.
    PasteChart,
    /// Open or close the chart editor.
    EditChart,
    /// Move a point of the net that pulls the cloth, mm.
    MoveNetPoint {
        /// Its row.
        row: usize,
        /// Its place in that.
        column: usize,
        /// Where to.
        to: [f64; 3],
    },
    /// Show the cloth from here.
    Look(CameraDesign),
    /// Show the cloth from a standard view.
    Standard(StandardView),
    /// Bring the whole cloth into view, keeping the direction.
    Fit,
    /// Render with this backend.
    Backend(BackendChoice),
    /// Render the viewport with this light.
    LiveLight(LiveLight),
    /// Do something with the view.
    View(ViewCommand),
    /// Show or hide keys and version.
    Help,
}

impl Command {
    /// With the name that was typed for it.
    pub fn with_name(self, name: &str) -> Self {
        match self {
            Self::Presets(command) => Self::Presets(command.with_name(name)),
            other => other,
        }
    }
}

/// What to do about images outside the folder of the file that names them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutsideChoice {
    /// Open them.
    Open,
    /// Open the design without them.
    LeaveOut,
}

/// What to do with a design that was left behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryChoice {
    /// Open it.
    Recover,
    /// Remove it.
    Discard,
    /// Leave it where it is; the next start asks again.
    Later,
}

/// Something to do with presets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PresetCommand {
    /// Ask for a name and save the design under it.
    AskToSave,
    /// Save the design under this name.
    Save(String),
    /// Save it there, whatever is there.
    SaveTo(PathBuf),
    /// Copy a preset into the user's folder.
    Duplicate(Place),
    /// Ask for another name.
    AskToRename(PathBuf),
    /// Give it this name.
    Rename(PathBuf, String),
    /// Ask whether to delete it.
    AskToDelete(PathBuf),
    /// Delete it.
    Delete(PathBuf),
    /// Show it in the file manager.
    Reveal(PathBuf),
}

impl PresetCommand {
    /// With the name that was typed for it.
    pub fn with_name(self, name: &str) -> Self {
        match self {
            Self::Save(_) => Self::Save(name.into()),
            Self::Rename(path, _) => Self::Rename(path, name.into()),
            other => other,
        }
    }
}

/// Where a preset is.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Place {
    /// In the program, under this name.
    Program(String),
    /// In a file.
    File(PathBuf),
}

/// Keys of the commands that have some, as the help lists them.
pub const SHORTCUTS: &[(Command, KeyboardShortcut, &str)] = &[
    (Command::New, ctrl(Key::N), "New plain design"),
    (Command::Open, ctrl(Key::O), "Open a preset"),
    (Command::Save, ctrl(Key::S), "Save"),
    (Command::SaveAs, shift(Key::S), "Save as"),
    (Command::Export, ctrl(Key::E), "Export a picture"),
    (Command::Undo, ctrl(Key::Z), "Undo"),
    (Command::Redo, shift(Key::Z), "Redo"),
    (Command::Redo, ctrl(Key::Y), "Redo"),
    (Command::Quit, ctrl(Key::Q), "Quit"),
    (Command::ScaleStep(1), ctrl(Key::Plus), "Larger interface"),
    (Command::ScaleStep(1), ctrl(Key::Equals), "Larger interface"),
    (
        Command::ScaleStep(-1),
        ctrl(Key::Minus),
        "Smaller interface",
    ),
    (Command::Scale(100), ctrl(Key::Num0), "Interface at 100 %"),
    (
        Command::Help,
        KeyboardShortcut::new(Modifiers::NONE, Key::F1),
        "Help",
    ),
];

const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

const fn shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
}

/// Takes the shortcuts pressed in this frame. Undo and redo belong to a text field while one is being typed in.
pub fn take_shortcuts(ctx: &Context, commands: &mut Vec<Command>) {
    let typing = ctx.text_edit_focused();
    // Those with Shift first: egui's matching ignores a Shift that a shortcut does not name.
    let (with, without): (Vec<_>, Vec<_>) = SHORTCUTS
        .iter()
        .partition(|(_, shortcut, _)| shortcut.modifiers.shift);
    for (command, shortcut, _) in with.into_iter().chain(without) {
        let is_history = matches!(command, Command::Undo | Command::Redo);
        if !(typing && is_history) && ctx.input_mut(|i| i.consume_shortcut(shortcut)) {
            commands.push(command.clone());
        }
    }
    for (command, shortcut) in &view::SHORTCUTS {
        if !typing && ctx.input_mut(|i| i.consume_shortcut(shortcut)) {
            commands.push(Command::View(command.clone()));
        }
    }
}

/// The keys of a command as text, for menus and tooltips; empty if it has none.
pub fn keys_of(ctx: &Context, command: &Command) -> String {
    let shortcut = match command {
        Command::View(command) => {
            let found = view::SHORTCUTS.iter().find(|(other, _)| other == command);
            found.map(|(_, shortcut)| shortcut)
        }
        command => {
            let found = SHORTCUTS.iter().find(|(other, ..)| other == command);
            found.map(|(_, shortcut, _)| shortcut)
        }
    };
    shortcut.map_or_else(String::new, |shortcut| ctx.format_shortcut(shortcut))
}
