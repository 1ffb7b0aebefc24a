//! The bars above the panels: menu and toolbar; what they have for the view is in `view_bar`.

use egui::{MenuBar, Ui};
use renderer_core::design::ImageSlot;

use crate::designer::document::Document;
use crate::designer::document::settings::{SCALES, Settings, ThemeChoice};
use crate::designer::shell::command::Command;
use crate::designer::shell::command_buttons::{item, tool};
use crate::designer::shell::view_bar;
use crate::designer::viewport::Viewport;
use crate::designer::widgets::{UnitSystem, check_box, radio_button, shortened};

const PRESETS: &str = "The designs to start from, beside the cloth.";

/// The menu bar.
pub fn menu(
    ui: &mut Ui,
    document: &Document,
    viewport: &Viewport,
    settings: &Settings,
    has_presets: bool,
    commands: &mut Vec<Command>,
) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            item(ui, "New…", true, Command::AskForNew, commands);
            item(ui, "New plain design", true, Command::New, commands);
            item(ui, "Open…", true, Command::Open, commands);
            ui.menu_button("Open recent", |ui| recent(ui, settings, commands));
            ui.separator();
            item(ui, "Save", true, Command::Save, commands);
            item(ui, "Save as…", true, Command::SaveAs, commands);
            item(ui, "Save as bundle…", true, Command::SaveAsBundle, commands);
            ui.separator();
            let open = Command::OpenImage;
            let chart = open(ImageSlot::Chart);
            item(ui, "Open chart…", true, chart, commands);
            item(
                ui,
                "Open surroundings…",
                true,
                open(ImageSlot::Environment),
                commands,
            );
            item(ui, "Export picture…", true, Command::Export, commands);
            ui.separator();
            item(ui, "Quit", true, Command::Quit, commands);
        });
        ui.menu_button("Edit", |ui| {
            let (undo, redo) = (document.undo_name(), document.redo_name());
            let named = |verb: &str, name: Option<&str>| match name {
                Some(name) => format!("{verb} {name}"),
                None => verb.into(),
            };
            item(
                ui,
                &named("Undo", undo),
                undo.is_some(),
                Command::Undo,
                commands,
            );
            item(
                ui,
                &named("Redo", redo),
                redo.is_some(),
                Command::Redo,
                commands,
            );
            ui.separator();
            item(ui, "Paste chart", true, Command::PasteChart, commands);
            item(ui, "Chart editor", true, Command::EditChart, commands);
        });
        ui.menu_button("View", |ui| {
            view_bar::menu(ui, &document.design, viewport, commands);
        });
        ui.menu_button("Display", |ui| {
            let mut shows = has_presets;
            let check = check_box(ui, &mut shows, "Presets");
            if check.on_hover_text(PRESETS).clicked() {
                commands.push(Command::ShowPresets(shows));
                ui.close();
            }
            let scale = settings.scale;
            ui.menu_button("Interface scale", |ui| scales(ui, scale, commands));
            ui.menu_button("Theme", |ui| themes(ui, settings.theme, commands));
            ui.menu_button("Units", |ui| units(ui, settings.units, commands));
            view_bar::size_of_the_screen(ui, commands);
        });
        ui.menu_button("Help", |ui| {
            item(ui, "Keys and version", true, Command::Help, commands);
        });
    });
}

/// The files last opened or saved.
fn recent(ui: &mut Ui, settings: &Settings, commands: &mut Vec<Command>) {
    if settings.recent.is_empty() {
        ui.weak("None yet");
        return;
    }
    for path in &settings.recent {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let button = ui.button(shortened(&name.to_string_lossy(), 48));
        if button.on_hover_text(path.display().to_string()).clicked() {
            commands.push(Command::OpenPreset(path.clone()));
            ui.close();
        }
    }
    ui.separator();
    item(ui, "Clear the list", true, Command::ClearRecent, commands);
}

fn scales(ui: &mut Ui, now: u32, commands: &mut Vec<Command>) {
    item(ui, "Larger", true, Command::ScaleStep(1), commands);
    item(ui, "Smaller", true, Command::ScaleStep(-1), commands);
    ui.separator();
    for scale in SCALES {
        if radio_button(ui, scale == now, format!("{scale} %")).clicked() {
            commands.push(Command::Scale(scale));
            ui.close();
        }
    }
}

/// What lengths are shown in.
fn units(ui: &mut Ui, now: UnitSystem, commands: &mut Vec<Command>) {
    for (choice, name, what) in [
        (
            UnitSystem::Metric,
            "Metric",
            "Millimetres and centimetres; ends and picks a centimetre.",
        ),
        (
            UnitSystem::Inch,
            "Inches",
            "Inches; ends and picks an inch. Designs stay metric.",
        ),
    ] {
        let button = radio_button(ui, now == choice, name).on_hover_text(what);
        if button.clicked() {
            commands.push(Command::Units(choice));
            ui.close();
        }
    }
}

/// Light or dark.
fn themes(ui: &mut Ui, now: ThemeChoice, commands: &mut Vec<Command>) {
    for (choice, name) in [
        (ThemeChoice::System, "As the system"),
        (ThemeChoice::Dark, "Dark"),
        (ThemeChoice::Light, "Light"),
    ] {
        if radio_button(ui, now == choice, name).clicked() {
            commands.push(Command::Theme(choice));
            ui.close();
        }
    }
}

/// The toolbar.
pub fn toolbar(
    ui: &mut Ui,
    document: &Document,
    viewport: &Viewport,
    has_presets: bool,
    commands: &mut Vec<Command>,
) {
    ui.horizontal_centered(|ui| {
        tool(
            ui,
            "New",
            "Starts a new design: a towel, a mat, a carpet.",
            true,
            Command::AskForNew,
            commands,
        );
        tool(ui, "Open", "Opens a preset.", true, Command::Open, commands);
        let unsaved = document.is_unsaved() || document.path().is_none();
        tool(
            ui,
            "Save",
            "Saves the design.",
            unsaved,
            Command::Save,
            commands,
        );
        ui.separator();
        let (undo, redo) = (document.undo_name(), document.redo_name());
        let undo_what = undo.map_or("Nothing to undo.".into(), |name| {
            format!("Takes back: {name}.")
        });
        let redo_what = redo.map_or("Nothing to redo.".into(), |name| {
            format!("Repeats: {name}.")
        });
        tool(
            ui,
            "Undo",
            &undo_what,
            undo.is_some(),
            Command::Undo,
            commands,
        );
        tool(
            ui,
            "Redo",
            &redo_what,
            redo.is_some(),
            Command::Redo,
            commands,
        );
        ui.separator();
        view_bar::toolbar(ui, &document.design, viewport, commands);
        ui.separator();
        tool(
            ui,
            "Export",
            "Renders the picture in full quality and writes it to a file.",
            true,
            Command::Export,
            commands,
        );
        if !has_presets {
            let command = Command::ShowPresets(true);
            tool(ui, "Presets", PRESETS, true, command, commands);
        }
    });
}
