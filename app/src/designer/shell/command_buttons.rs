//! Buttons that give a command: lines of menus and buttons of the toolbar, with the command's keys.

use egui::{Button, Ui};

use super::command::{Command, keys_of};

/// A line of a menu with its keys.
pub fn item(ui: &mut Ui, text: &str, enabled: bool, command: Command, commands: &mut Vec<Command>) {
    let keys = keys_of(ui.ctx(), &command);
    let button = Button::new(text).shortcut_text(keys);
    if ui.add_enabled(enabled, button).clicked() {
        commands.push(command);
    }
}

/// A button of the toolbar.
pub fn tool(
    ui: &mut Ui,
    text: &str,
    what: &str,
    enabled: bool,
    command: Command,
    commands: &mut Vec<Command>,
) {
    let keys = keys_of(ui.ctx(), &command);
    let tooltip = if keys.is_empty() {
        what.into()
    } else {
        format!("{what} {keys}")
    };
    // The menu bar has lines of the same names; a screen reader should tell them apart.
    let button = ui
        .add_enabled(enabled, Button::new(text))
        .accessible_name(format!("Toolbar: {text}"));
    let button = button
        .on_hover_text(&tooltip)
        .on_disabled_hover_text(tooltip);
    if button.clicked() {
        commands.push(command);
    }
}
