//! What menu and toolbar have for the view: standard and saved views, scale, loupe, comparison, backend, light.

use egui::{Button, Id, Key, TextEdit, Ui};
use renderer_core::design::{CameraDesign, Design};

use crate::backend::BackendChoice;
use crate::designer::render_thread::Denoising;
use crate::designer::render_thread::draft_lighting::LiveLight;
use crate::designer::shell::command::{Command, keys_of};
use crate::designer::shell::command_buttons::{item, tool};
use crate::designer::viewport::Viewport;
use crate::designer::viewport::camera_moves::StandardView;
use crate::designer::viewport::command::{KEYS, ViewCommand};
use crate::designer::widgets::{check_box, radio_button};

/// Backends in menu order.
pub const BACKENDS: [BackendChoice; 4] = [
    BackendChoice::Auto,
    BackendChoice::Gpu,
    BackendChoice::Cpu,
    BackendChoice::Reference,
];

/// Width of what comes in the toolbar from the standard views on, points: in less they are a menu.
const ROOM_FOR_VIEWS: f32 = 500.0;

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

/// Something of the view that is on or off.
struct Toggle {
    name: &'static str,
    what: &'static str,
    command: ViewCommand,
    is_on: fn(&Viewport) -> bool,
}

const TOGGLES: [Toggle; 3] = [
    Toggle {
        name: "Orthographic",
        what: "Parallel projection: far loops look as large as near ones, so that sizes can be compared and measured.",
        command: ViewCommand::Orthographic,
        is_on: Viewport::is_orthographic,
    },
    Toggle {
        name: "Scale bar",
        what: "A bar in the corner of the picture that tells millimetres of cloth.",
        command: ViewCommand::ScaleBar,
        is_on: Viewport::has_scale_bar,
    },
    Toggle {
        name: "Loupe",
        what: "A circle under the pointer that shows every pixel of the picture four times as large.",
        command: ViewCommand::Loupe,
        is_on: Viewport::has_loupe,
    },
];

const TRUE_SCALE: &str = "Shows the cloth as large as it is: a millimetre of cloth is a millimetre of screen, in \
    parallel projection.";

/// What denoising does.
pub const DENOISE: &str = "Takes noise out of the picture after the first sample and at every doubling, the less the \
    clearer it is by itself. What is taken out is a guess: fine detail may be smoother than it will be. Exports are not \
    affected.";

/// The menu "View".
pub fn menu(ui: &mut Ui, design: &Design, viewport: &Viewport, commands: &mut Vec<Command>) {
    item(ui, "Fit", true, Command::Fit, commands);
    ui.menu_button("Standard views", |ui| {
        for view in StandardView::ALL {
            item(ui, view.name(), true, Command::Standard(view), commands);
        }
    });
    ui.menu_button("Saved views", |ui| {
        saved_views(ui, &design.view.cameras, commands);
    });
    ui.separator();
    line(
        ui,
        "True scale 1:1",
        TRUE_SCALE,
        ViewCommand::TrueScale,
        commands,
    );
    for toggle in &TOGGLES {
        let mut is_on = (toggle.is_on)(viewport);
        let text = format!("{}{}", toggle.name, key_text(&toggle.command));
        let check = check_box(ui, &mut is_on, text).on_hover_text(toggle.what);
        if check.accessible_name(toggle.name).clicked() {
            commands.push(Command::View(toggle.command.clone()));
            ui.close();
        }
    }
    denoise(ui, viewport, commands);
    ui.menu_button("Compare", |ui| compare(ui, viewport, commands));
    line(
        ui,
        "Cloth alone",
        "The cloth fills the screen; F11 or Escape brings the panels back.",
        ViewCommand::Alone,
        commands,
    );
    ui.separator();
    ui.menu_button("Backend", |ui| {
        backends(ui, viewport.choice(), commands);
    });
    ui.add_enabled_ui(LiveLight::matters(design), |ui| {
        ui.menu_button("Light in the viewport", |ui| {
            live_lights(ui, viewport.light, commands);
        })
        .response
        .on_disabled_hover_text(
            "This design leaves nothing to choose: it traces one scattering, or says itself after how many it \
            estimates.",
        );
    });
}

/// Whether the picture is denoised; where it cannot be, why, and how one gets what it takes.
fn denoise(ui: &mut Ui, viewport: &Viewport, commands: &mut Vec<Command>) {
    let (can_be, what) = match &viewport.state().denoising {
        Denoising::Ready(by) => (true, format!("{DENOISE}\nBy {by}.")),
        Denoising::Looking => (false, "A denoiser is being looked for.".to_owned()),
        Denoising::Missing(why) => (false, why.clone()),
    };
    ui.add_enabled_ui(can_be, |ui| {
        let mut is_on = can_be && viewport.denoises();
        let check = check_box(ui, &mut is_on, "Denoise")
            .on_hover_text(&what)
            .on_disabled_hover_text(&what);
        if check.clicked() {
            commands.push(Command::View(ViewCommand::Denoise));
            ui.close();
        }
    });
}

/// Tells the program how large the screen is.
pub fn size_of_the_screen(ui: &mut Ui, commands: &mut Vec<Command>) {
    line(
        ui,
        "Size of the screen…",
        "Tells how large the screen's pixels are, by a real ruler, so that 1:1 is true.",
        ViewCommand::Calibrate,
        commands,
    );
}

/// The view's part of the toolbar.
pub fn toolbar(ui: &mut Ui, design: &Design, viewport: &Viewport, commands: &mut Vec<Command>) {
    tool(
        ui,
        "Fit",
        "Brings the whole cloth into view (F or Home in the viewport).",
        true,
        Command::Fit,
        commands,
    );
    if ui.available_width() > ROOM_FOR_VIEWS {
        standard_views(ui, commands);
    } else {
        let menu = ui.menu_button("Look", |ui| standard_views(ui, commands));
        menu.response
            .accessible_name("Toolbar: Look")
            .on_hover_text("Standard views of the cloth, and its true size.");
    }
    ui.separator();
    let menu = ui.menu_button("Views", |ui| {
        saved_views(ui, &design.view.cameras, commands);
    });
    menu.response
        .accessible_name("Toolbar: Views")
        .on_hover_text("Saved views: shows one (Alt+1 to Alt+9), or saves the present one.");
    let menu = ui.menu_button("Compare", |ui| compare(ui, viewport, commands));
    menu.response
        .accessible_name("Toolbar: Compare")
        .on_hover_text("Keeps a snapshot of the picture and shows it beside what you change.");
}

fn standard_views(ui: &mut Ui, commands: &mut Vec<Command>) {
    for view in StandardView::ALL {
        let command = Command::Standard(view);
        tool(ui, view.name(), view.what(), true, command, commands);
    }
    let command = Command::View(ViewCommand::TrueScale);
    tool(ui, "1:1", TRUE_SCALE, true, command, commands);
}

/// Saved views to choose from, and a field to save the present one.
fn saved_views(ui: &mut Ui, cameras: &[CameraDesign], commands: &mut Vec<Command>) {
    for (index, camera) in cameras.iter().enumerate() {
        let command = Command::View(ViewCommand::Camera(index));
        item(ui, &camera.name, true, command, commands);
    }
    ui.separator();
    let id = Id::unique("name of a new view");
    let mut name = ui
        .data(|data| data.get_temp::<String>(id))
        .unwrap_or_default();
    let field = TextEdit::singleline(&mut name)
        .hint_text("name of this view")
        .char_limit(40)
        .align(egui::Align2::LEFT_CENTER)
        .desired_width(150.0);
    let field = ui
        .add(field)
        .on_hover_text("A name for the view you see now.");
    let field = field.accessible_name("Name of a new view");
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    let save = ui.button("Save this view");
    let save = save.on_hover_text("Saves the view you see now in the design, under that name.");
    if save.clicked() || entered {
        commands.push(Command::View(ViewCommand::SaveCamera(std::mem::take(
            &mut name,
        ))));
        ui.close();
    }
    ui.data_mut(|data| data.insert_temp(id, name));
}

/// Snapshot and comparison.
fn compare(ui: &mut Ui, viewport: &Viewport, commands: &mut Vec<Command>) {
    line(
        ui,
        "Take snapshot",
        "Keeps the present picture with its design and view, in place of an earlier snapshot.",
        ViewCommand::Snapshot,
        commands,
    );
    let has_snapshot = viewport.snapshot().is_some();
    ui.add_enabled_ui(has_snapshot, |ui| {
        let mut is_on = viewport.is_comparing();
        let text = format!("Show beside the picture{}", key_text(&ViewCommand::Compare));
        let check = check_box(ui, &mut is_on, text);
        let check = check
            .on_hover_text("The snapshot left of the divider, the cloth as it is now right of it.")
            .on_disabled_hover_text("Take a snapshot first.");
        if check.accessible_name("Show beside the picture").clicked() {
            commands.push(Command::View(ViewCommand::Compare));
            ui.close();
        }
        line(
            ui,
            "Restore snapshot",
            "Makes the design and the view what they were when the snapshot was taken. Undo takes that back.",
            ViewCommand::Restore,
            commands,
        );
    });
}

/// A line of a menu with its key in the viewport.
fn line(ui: &mut Ui, text: &str, what: &str, command: ViewCommand, commands: &mut Vec<Command>) {
    let global = keys_of(ui.ctx(), &Command::View(command.clone()));
    let keys = if global.is_empty() {
        key_text(&command).trim().to_owned()
    } else {
        global
    };
    let button = ui.add(Button::new(text).shortcut_text(keys));
    if button.accessible_name(text).on_hover_text(what).clicked() {
        commands.push(Command::View(command));
    }
}

/// The key of a command in the viewport, in brackets.
fn key_text(command: &ViewCommand) -> String {
    let key = KEYS.iter().find(|(other, _)| other == command);
    key.map_or_else(String::new, |(_, key)| format!("  ({})", key.name()))
}

/// Backends to choose from.
pub fn backends(ui: &mut Ui, now: BackendChoice, commands: &mut Vec<Command>) {
    for choice in BACKENDS {
        let radio = radio_button(ui, choice == now, backend_name(choice));
        if radio.on_hover_text(backend_what(choice)).clicked() {
            commands.push(Command::Backend(choice));
            ui.close();
        }
    }
}

/// Lights to choose from.
pub fn live_lights(ui: &mut Ui, now: LiveLight, commands: &mut Vec<Command>) {
    for light in LiveLight::ALL {
        let radio = radio_button(ui, light == now, light.name());
        if radio.on_hover_text(light.what()).clicked() {
            commands.push(Command::LiveLight(light));
            ui.close();
        }
    }
}
