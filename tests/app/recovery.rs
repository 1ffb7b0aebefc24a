//! A program that is killed loses nothing: the next one offers the unsaved design.

use std::fs;
use std::path::Path;
use std::time::Duration;

use towel_designer::files::RecoveryFile;

use crate::support::display::{Display, Program, wait};

const SMALL: &str = "format = 1\n\n[sheet]\nwarps = 24\nwefts = 24\n\n\
                     [quality]\nmethod = \"single\"\nbounces = 1\nsamples = 4\n";

/// Files of unsaved designs in the state folder that the window tests give the program.
fn kept(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_design = |path: &Path| path.extension().is_some_and(|ending| ending == "towel");
    entries.filter(|entry| is_design(&entry.path())).count()
}

#[test]
fn a_killed_program_leaves_its_design_to_the_next() {
    let folder = tempfile::tempdir().expect("a folder");
    let state = folder.path().join("home/state/towel-designer/unsaved");
    let preset = folder.path().join("small.toml");
    fs::write(&preset, SMALL).expect("written");
    let display = Display::start("1280x720x24");
    let start = |arguments: &[&str], title: &str| {
        Program::start(&display, folder.path(), arguments, title, [1280, 720])
    };
    let preset_text = preset.to_string_lossy().into_owned();
    let mut program = start(
        &[&preset_text, "--backend", "cpu"],
        "small - Towel Designer",
    );
    // The number of warps: a click on its field, typed over.
    display.xdotool("mousemove 243 101");
    wait("the unsaved mark", || {
        display.xdotool("click 1");
        std::thread::sleep(Duration::from_millis(500));
        display.xdotool("key ctrl+a");
        display.xdotool("type 31");
        display.xdotool("key Return");
        std::thread::sleep(Duration::from_millis(500));
        display.window("small\\* - Towel Designer")
    });
    wait("the unsaved design", || (kept(&state) == 1).then_some(()));
    // While it lives, nobody else is offered it.
    assert!(RecoveryFile::find(&state).is_none());
    program.process.0.kill().expect("killed");
    program.process.0.wait().expect("ended");
    drop(program);
    assert!(RecoveryFile::find(&state).is_some());

    let program = start(&["--backend", "cpu"], "untitled - Towel Designer");
    wait("the recovered design", || {
        // The question's first answer.
        display.xdotool("key Tab");
        display.xdotool("key space");
        std::thread::sleep(Duration::from_millis(500));
        display.window("small\\* - Towel Designer")
    });
    display.xdotool("key ctrl+s");
    wait("the saved mark", || {
        display.window("small - Towel Designer")
    });
    let saved = towel_designer::files::load_design(&preset).expect("a preset");
    assert_eq!(saved.sheet.warps, 31);
    program.quit(&display);
    assert_eq!(kept(&state), 0, "saved: nothing is left");
}
