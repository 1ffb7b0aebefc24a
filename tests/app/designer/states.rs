//! The window in states that together show all it has, for the tests of how it looks: every panel with every row,
//! menus, windows, questions and messages, in whichever theme, scale and size.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Theme, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use towel_designer::designer::panels::Panels;
use towel_designer::designer::{App, Setup};

use super::*;

/// How a window is shown.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    pub theme: Theme,
    /// Pixels of the screen for a point.
    pub scale: f32,
    /// Size of the window, points.
    pub size: Vec2,
}

/// A state of the window, and how a user comes to it.
pub struct State {
    pub name: &'static str,
    pub reach: fn(&mut Harness<'static, App>),
}

/// High enough for all panels with all that they have; egui leaves out what a scroll area hides.
pub const TALL: f32 = 5700.0;

/// What a window of any size can show.
pub const STATES: [State; 20] = [
    State {
        name: "started",
        reach: |_| {},
    },
    State {
        name: "menu File",
        reach: |h| click(h, "File"),
    },
    State {
        name: "menu Edit",
        reach: |h| {
            type_number(h, "Warps", "250");
            click(h, "Edit");
        },
    },
    State {
        name: "menu View",
        reach: |h| click(h, "View"),
    },
    State {
        name: "menu Display",
        reach: |h| click(h, "Display"),
    },
    State {
        name: "saved views",
        reach: |h| {
            click(h, "Toolbar: Views");
        },
    },
    State {
        name: "compare",
        reach: |h| {
            click(h, "Toolbar: Compare");
        },
    },
    State {
        name: "help",
        reach: |h| {
            h.key_press(Key::F1);
            h.run_steps(8);
        },
    },
    State {
        name: "export",
        reach: |h| {
            h.key_press_modifiers(Modifiers::COMMAND, Key::E);
            h.run_steps(8);
        },
    },
    State {
        name: "file browser",
        reach: |h| {
            h.key_press_modifiers(Modifiers::COMMAND, Key::O);
            h.run_steps(8);
        },
    },
    State {
        name: "question",
        reach: |h| {
            type_number(h, "Warps", "250");
            h.key_press_modifiers(Modifiers::COMMAND, Key::N);
            h.run_steps(8);
        },
    },
    State {
        name: "message",
        reach: |h| {
            h.event(egui::Event::Paste("some text".into()));
            h.run_steps(4);
        },
    },
    State {
        name: "weave editor",
        reach: |h| {
            click(h, "Enlarge the weave editor");
            h.run_steps(8);
        },
    },
    State {
        name: "ready patterns",
        reach: |h| {
            h.get_by_label("Ready patterns…").scroll_to_me();
            h.run_steps(20);
            click(h, "Ready patterns…");
            h.run_steps(8);
        },
    },
    State {
        name: "chart editor",
        reach: |h| {
            h.get_by_label("Edit chart").scroll_to_me();
            h.run_steps(20);
            click(h, "Edit chart");
            h.run_steps(20);
        },
    },
    State {
        name: "chart objects",
        reach: |h| {
            reach(h, "chart editor");
            for kind in ["stripe across", "text"] {
                click(h, "Add an object");
                h.get_by_role_and_label(Role::Button, kind).click();
                h.run_steps(8);
            }
        },
    },
    State {
        name: "new design",
        reach: |h| {
            click(h, "Toolbar: New");
            h.run_steps(16);
        },
    },
    State {
        name: "size of the screen",
        reach: |h| {
            click(h, "Display");
            click(h, "Size of the screen…");
            h.run_steps(8);
        },
    },
    State {
        name: "name for a preset",
        reach: |h| {
            if h.query_by_label("Save as preset…").is_none() {
                click(h, "Toolbar: Presets");
            }
            click(h, "Save as preset…");
            h.run_steps(8);
        },
    },
    State {
        name: "true scale and snapshot",
        reach: |h| {
            click(h, "View");
            click(h, "True scale 1:1");
            click(h, "Toolbar: Compare");
            click(h, "Take snapshot");
            h.run_steps(8);
        },
    },
];

/// A small design with what panels have most to show of: a chart of three yarns with a length each, two views, a sky.
fn write_preset(folder: &Path) -> PathBuf {
    let colour = |x: u32, y: u32| match (y % 12, (x as i32 - 15).pow(2) + (y as i32 - 20).pow(2)) {
        (_, ..40) => [0xd9, 0x58, 0x4a],
        (0..3, _) => [0x1f, 0x3a, 0x5f],
        _ => [0xf6, 0xf1, 0xe6],
    };
    image::RgbImage::from_fn(30, 40, |x, y| image::Rgb(colour(x, y)))
        .save(folder.join("chart.png"))
        .expect("written");
    let preset = folder.join("striped.toml");
    let text = r##"
        format = 1
        sheet = { warps = 30, wefts = 40 }
        chart.image = "chart.png"
        turbulence.seed = 11
        form = { kind = "wave", steepness = 8 }
        light.environment.kind = "gradient"
        quality.samples = 16

        [length]
        map = "lut"
        table = [
          { colour = "#f6f1e6", length = 3.0 },
          { colour = "#1f3a5f", length = 2.6 },
          { colour = "#d9584a", length = 3.6, kind = "cut" },
        ]

        [view]
        cameras = [{ name = "whole" }, { name = "motif", distance = 60.0 }]
    "##;
    std::fs::write(&preset, text).expect("written");
    preset
}

/// The designer with a design that has a chart. The folder is its user's home.
pub fn start(look: Look) -> (Harness<'static, App>, tempfile::TempDir) {
    let home = tempfile::tempdir().expect("a folder");
    let setup = Setup {
        preset: Some(write_preset(home.path())),
        folders: Some(folders_in(home.path())),
        ..setup(flat())
    };
    let mut harness = Harness::builder()
        .with_size(look.size)
        .with_pixels_per_point(look.scale)
        .with_theme(look.theme)
        .with_step_dt(1.0 / 60.0)
        // Where the pointer is last is of no interest.
        .with_render_cursor(false)
        .build_eframe(|cc| App::new(cc, setup));
    harness.run_steps(3);
    wait(&mut harness, "the design", |h| {
        h.state().document().name() == "striped"
    });
    // In a small window they give way to the cloth.
    let has_presets = harness.query_by_label("Toolbar: Presets").is_none();
    wait(&mut harness, "the presets", |h| {
        !has_presets || h.query_by_label("Preset harbour-stripe").is_some()
    });
    harness.run_steps(20);
    (harness, home)
}

/// Shows the presets, or hides them.
pub fn show_presets(harness: &mut Harness<'static, App>) {
    click(harness, "Display");
    let check = harness.get_by_role_and_label(Role::CheckBox, "Presets");
    check.click();
    harness.run_steps(6);
}

/// Waits until the picture is whole.
#[track_caller]
pub fn wait_for_picture(harness: &mut Harness<'static, App>) {
    wait(harness, "the picture", |h| {
        let state = h.state().viewport().state();
        // Not what was known before it is drawn.
        let is_whole = state.picture.progress.done && !state.picture.is_reduced;
        is_whole && !state.is_busy()
    });
    harness.run_steps(2);
}

/// Brings the window into one of the states.
#[track_caller]
pub fn reach(harness: &mut Harness<'static, App>, name: &str) {
    let state = STATES.iter().find(|state| state.name == name);
    (state.expect("a state of that name").reach)(harness);
}

/// Opens every panel and what panels hide because it is seldom needed.
pub fn open_everything(harness: &mut Harness<'static, App>) {
    for title in Panels::titles().skip(2) {
        open_panel(harness, title);
    }
    open_seldom_needed(harness);
    harness.event(egui::Event::PointerGone);
    // Thumbnails come from other threads.
    rest(harness);
}

/// Chooses what decides on the length of loops.
pub fn choose_length_map(harness: &mut Harness<'static, App>, map: LengthMap) {
    choose(harness, "Lengths", map.label());
    harness.run_steps(20);
}

/// Size of a window as high as all panels.
pub fn tall(width: f32) -> Vec2 {
    vec2(width, TALL)
}

/// Whether a widget takes the keyboard.
pub fn takes_focus(node: &egui_kittest::Node<'_>) -> bool {
    let node = node.accesskit_node();
    let is_shown = !node.is_hidden() && !node.is_disabled() && node.role() != Role::Unknown;
    is_shown && node.data().supports_action(egui::accesskit::Action::Focus)
}
