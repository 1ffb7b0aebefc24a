//! The bars around the panels: menu, toolbar, status.

use egui::{Button, MenuBar, RichText, ThemePreference, Ui};
use renderer_core::design::CameraDesign;

use super::camera_moves::StandardView;
use super::command::{Command, keys_of};
use super::document::Document;
use super::live_light::LiveLight;
use super::render_thread::Shown;
use super::viewport::{Viewport, progress_text};
use crate::backend::BackendChoice;

/// Backends in menu order.
pub const BACKENDS: [BackendChoice; 4] = [
    BackendChoice::Auto,
    BackendChoice::Gpu,
    BackendChoice::Cpu,
    BackendChoice::Reference,
];

/// What menus call a backend.
pub fn backend_name(choice: BackendChoice) -> &'static str {
    match choice {
        BackendChoice::Auto => "auto",
        BackendChoice::Gpu => "gpu",
        BackendChoice::Cpu => "cpu",
        BackendChoice::Reference => "reference",
    }
}

fn backend_what(choice: BackendChoice) -> &'static str {
    match choice {
        BackendChoice::Auto => "The GPU where there is one, else all processor cores.",
        BackendChoice::Gpu => "The GPU, or a software adapter where that is all there is.",
        BackendChoice::Cpu => "All processor cores.",
        BackendChoice::Reference => "Plain and slow; what the others are held to.",
    }
}

/// The menu bar.
pub fn menu(ui: &mut Ui, document: &Document, viewport: &Viewport, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| {
            item(ui, "New", true, Command::New, commands);
            item(ui, "Open…", true, Command::Open, commands);
            ui.separator();
            item(ui, "Save", true, Command::Save, commands);
            item(ui, "Save as…", true, Command::SaveAs, commands);
            ui.separator();
            item(ui, "Open chart…", true, Command::OpenChart, commands);
            item(
                ui,
                "Open surroundings…",
                true,
                Command::OpenEnvironment,
                commands,
            );
            item(ui, "Export PNG…", true, Command::Export, commands);
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
        ui.menu_button("View", |ui| view_menu(ui, document, viewport, commands));
        ui.menu_button("Help", |ui| {
            item(ui, "Keys and version", true, Command::Help, commands);
        });
    });
}

fn view_menu(ui: &mut Ui, document: &Document, viewport: &Viewport, commands: &mut Vec<Command>) {
    item(ui, "Fit", true, Command::Fit, commands);
    for view in StandardView::ALL {
        item(ui, view.name(), true, Command::Standard(view), commands);
    }
    ui.separator();
    ui.menu_button("Cameras", |ui| {
        cameras(ui, &document.design.view.cameras, commands);
    });
    ui.menu_button("Backend", |ui| {
        backends(ui, viewport.choice(), commands);
    });
    ui.menu_button("Light in the viewport", |ui| {
        live_lights(ui, viewport.light, commands);
    });
    ui.menu_button("Theme", |ui| {
        let mut theme = ui.ctx().options(|options| options.theme_preference);
        for (choice, name) in [
            (ThemePreference::System, "As the system"),
            (ThemePreference::Dark, "Dark"),
            (ThemePreference::Light, "Light"),
        ] {
            if ui.radio_value(&mut theme, choice, name).clicked() {
                ui.ctx().set_theme(theme);
            }
        }
    });
}

fn cameras(ui: &mut Ui, cameras: &[CameraDesign], commands: &mut Vec<Command>) {
    for camera in cameras {
        if ui.button(&camera.name).clicked() {
            commands.push(Command::Look(camera.clone()));
        }
    }
}

fn backends(ui: &mut Ui, now: BackendChoice, commands: &mut Vec<Command>) {
    for choice in BACKENDS {
        let radio = ui.radio(choice == now, backend_name(choice));
        if radio.on_hover_text(backend_what(choice)).clicked() {
            commands.push(Command::Backend(choice));
            ui.close();
        }
    }
}

fn live_lights(ui: &mut Ui, now: LiveLight, commands: &mut Vec<Command>) {
    for light in LiveLight::ALL {
        let radio = ui.radio(light == now, light.name());
        if radio.on_hover_text(light.what()).clicked() {
            commands.push(Command::LiveLight(light));
            ui.close();
        }
    }
}

/// A line of a menu with its keys.
fn item(ui: &mut Ui, text: &str, enabled: bool, command: Command, commands: &mut Vec<Command>) {
    let keys = keys_of(ui.ctx(), &command);
    let button = Button::new(text).shortcut_text(keys);
    if ui.add_enabled(enabled, button).clicked() {
        commands.push(command);
    }
}

/// The toolbar.
pub fn toolbar(ui: &mut Ui, document: &Document, commands: &mut Vec<Command>) {
    ui.horizontal_centered(|ui| {
        tool(
            ui,
            "New",
            "Starts a new design.",
            true,
            Command::New,
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
        tool(
            ui,
            "Fit",
            "Brings the whole cloth into view (F or Home in the viewport).",
            true,
            Command::Fit,
            commands,
        );
        for view in StandardView::ALL {
            let command = Command::Standard(view);
            tool(ui, view.name(), view.what(), true, command, commands);
        }
        ui.separator();
        let menu = ui.menu_button("Camera", |ui| {
            cameras(ui, &document.design.view.cameras, commands);
        });
        menu.response
            .on_hover_text("Shows the cloth as a saved camera sees it.");
        ui.separator();
        tool(
            ui,
            "Export PNG",
            "Renders the picture in full quality and writes it to a file.",
            true,
            Command::Export,
            commands,
        );
    });
}

fn tool(
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

/// The status bar.
pub fn status(ui: &mut Ui, viewport: &Viewport, commands: &mut Vec<Command>) {
    let shown = viewport.shown();
    egui::Sides::new().shrink_left().truncate().show(
        ui,
        |ui| left_of_status(ui, viewport, shown),
        |ui| {
            let name = match &shown.device {
                Some((kind, device)) => format!("{}: {}", kind.name(), short(device, 44)),
                None => backend_name(viewport.choice()).into(),
            };
            let button = ui.menu_button(name, |ui| backends(ui, viewport.choice(), commands));
            let device = shown.device.as_ref().map_or("", |(_, device)| device);
            let tooltip = format!(
                "{device}\nChosen: {}. Click to render with another backend.",
                backend_name(viewport.choice())
            );
            button
                .response
                .accessible_name("Backend")
                .on_hover_text(tooltip.trim_start());
            let light = viewport.light;
            let button = ui.menu_button(light.name(), |ui| live_lights(ui, light, commands));
            button
                .response
                .accessible_name("Light in the viewport")
                .on_hover_text(light.what());
        },
    );
}

fn left_of_status(ui: &mut Ui, viewport: &Viewport, shown: &Shown) {
    let mut parts = vec![progress_text(shown)];
    if let (false, Some(error)) = (shown.is_reduced, shown.progress.error_estimate) {
        parts.push(format!("error {:.1} %", 100.0 * error));
    }
    let counts = shown.counts;
    parts.push(format!("{} loops", counts.planted));
    if counts.dropped > 0 {
        parts.push(format!("{} dropped", counts.dropped));
    }
    parts.push(size_text(viewport.size(), shown.size));
    parts.push(format!("{:.1} MB", shown.device_bytes as f64 / 1e6));
    parts.retain(|part| !part.is_empty());
    ui.label(RichText::new(parts.join("   ·   ")).weak());
    if !shown.warnings.is_empty() {
        let lines: Vec<String> = shown.warnings.iter().map(ToString::to_string).collect();
        let count = lines.len();
        let plural = if count == 1 { "" } else { "s" };
        let text = format!("{count} warning{plural}");
        ui.colored_label(ui.visuals().warn_fg_color, text)
            .on_hover_text(lines.join("\n"));
    }
}

/// Size of the picture, and of the smaller one that is enlarged to it where the backend cannot draw it whole.
fn size_text([width, height]: [u32; 2], drawn: [u32; 2]) -> String {
    let is_smaller = drawn[0] > 0 && drawn[0].max(drawn[1]) < width.max(height);
    if is_smaller {
        let [width, height] = drawn;
        return format!("{width} × {height} px, enlarged: more is beyond the GPU");
    }
    format!("{width} × {height} px")
}

/// At most `most` characters, with an ellipsis where some are left out.
fn short(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.into();
    }
    let kept: String = text.chars().take(most - 1).collect();
    format!("{}…", kept.trim_end())
}
