//! Files of the designer: bundles, pictures that carry their design, the user's presets, settings, and designs that a
//! program left behind when it died. Every test has folders of its own.
//!
//! Longer than most files because all of it happens to one user with one set of folders.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use renderer_core::design::Design;
use towel_designer::designer::{App, Folders, Setup};
use towel_designer::files::{self, Carried, KnownOutside};

use crate::support::png;

use super::{
    Dropped, click, design, flat, folders_in, open_panel, setup, type_number, type_path, wait,
    window, write_chart,
};

/// A user with a home of their own.
pub(super) struct User(tempfile::TempDir);

impl User {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub(super) fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn folders(&self) -> Folders {
        folders_in(self.0.path())
    }

    /// Starts the designer; a harness dropped without being asked to quit is a program that died.
    pub(super) fn start(&self, preset: Option<PathBuf>) -> Harness<'static, App> {
        window(vec2(1280.0, 900.0), self.setup(preset))
    }

    fn setup(&self, preset: Option<PathBuf>) -> Setup {
        Setup {
            preset,
            folders: Some(self.folders()),
            ..setup(flat())
        }
    }

    /// A preset with a chart beside it.
    pub(super) fn preset(&self, name: &str) -> PathBuf {
        let path = self.at(name);
        write_chart(&self.at("chart.png"));
        let text =
            "# Stripes for a test.\nformat = 1\nsheet.warps = 31\nchart.image = \"chart.png\"\n";
        fs::write(&path, text).expect("written");
        path
    }

    /// The unsaved design that is kept.
    pub(super) fn kept_file(&self) -> PathBuf {
        let names = self.names("state");
        let kept = names.iter().find(|name| name.ends_with(".towel"));
        self.at("state").join(kept.expect("an unsaved design"))
    }

    pub(super) fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.at(folder)).into_iter().flatten();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// Waits until the document has this name.
#[track_caller]
pub(super) fn wait_for_document(harness: &mut Harness<'_, App>, name: &str) {
    wait(harness, name, |h| h.state().document().name() == name);
    harness.run_steps(3);
}

#[track_caller]
pub(super) fn wait_for_label(harness: &mut Harness<'_, App>, label: &str) {
    wait(harness, label, |h| h.query_by_label(label).is_some());
    harness.run_steps(2);
}

/// Whether a text that contains this is shown.
pub(super) fn is_reported(harness: &Harness<'_, App>, part: &str) -> bool {
    harness.query_all_by_label_contains(part).count() > 0
}

pub(super) fn key(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.run_steps(3);
}

/// Chooses a line of the File menu.
#[track_caller]
pub(super) fn file_menu(harness: &mut Harness<'_, App>, line: &str) {
    click(harness, "File");
    // With the keys, if it has some.
    harness.get_by_label_contains(line).click();
    harness.run_steps(3);
}

/// A click on the window's closing cross.
fn close(harness: &mut Harness<'_, App>) {
    let viewport = egui::ViewportId::ROOT;
    let info = harness.input_mut().viewports.get_mut(&viewport).unwrap();
    info.events.push(egui::ViewportEvent::Close);
    harness.run_steps(3);
}

#[test]
fn a_design_is_saved_as_a_bundle_and_goes_on_being_saved_there() {
    let user = User::new();
    let mut harness = user.start(Some(user.preset("one.toml")));
    wait_for_document(&mut harness, "one");
    file_menu(&mut harness, "Save as bundle…");
    let bundle = user.at("two.towel");
    type_path(&mut harness, &bundle);
    click(&mut harness, "Save file");
    wait_for_document(&mut harness, "two");
    fs::remove_file(user.at("chart.png")).unwrap();
    type_number(&mut harness, "Wefts", "44");
    assert!(harness.state().document().is_unsaved());
    key(&mut harness, Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saved", |h| {
        !h.state().document().is_unsaved()
    });
    let edited = design(&harness).clone();
    drop(harness);

    let mut again = user.start(Some(bundle.clone()));
    wait_for_document(&mut again, "two");
    assert_eq!(design(&again).sheet.wefts, 44);
    assert_eq!(design(&again).chart.pixels, edited.chart.pixels);
    // Undo after saving is unsaved again.
    type_number(&mut again, "Wefts", "55");
    key(&mut again, Modifiers::COMMAND, Key::S);
    wait(&mut again, "saved", |h| !h.state().document().is_unsaved());
    key(&mut again, Modifiers::COMMAND, Key::Z);
    assert!(again.state().document().is_unsaved());
    assert_eq!(files::load_design(&bundle).unwrap().sheet.wefts, 55);
}

#[test]
fn broken_bundles_change_nothing() {
    let user = User::new();
    let bundle = user.at("broken.towel");
    fs::write(&bundle, b"PK\x03\x04 and then nothing").unwrap();
    let mut harness = user.start(None);
    type_number(&mut harness, "Warps", "77");
    key(&mut harness, Modifiers::COMMAND, Key::O);
    click(&mut harness, "Discard changes");
    type_path(&mut harness, &bundle);
    click(&mut harness, "Open file");
    wait_for_label(&mut harness, "Preset not opened");
    assert!(is_reported(&harness, "broken.towel: is no bundle"));
    assert_eq!(design(&harness).sheet.warps, 77);
    assert!(harness.state().document().is_unsaved());
}

#[test]
fn an_exported_picture_opens_its_design_or_is_a_chart() {
    let user = User::new();
    let mut harness = user.start(Some(user.preset("one.toml")));
    wait_for_document(&mut harness, "one");
    type_number(&mut harness, "Wefts", "44");
    let exported = design(&harness).clone();
    let embedded = files::embedded(&exported, &Carried::default(), Path::new("")).unwrap();
    let picture = user.at("picture.png");
    let plain = fs::read(user.at("chart.png")).unwrap();
    fs::write(&picture, png::with_chunks(plain, &embedded.chunks)).unwrap();

    let drop_it = |harness: &mut Harness<'_, App>| {
        let dropped = Arc::new(Dropped(picture.clone()));
        harness.input_mut().dropped_files.push(dropped);
        harness.run_steps(3);
    };
    drop_it(&mut harness);
    assert_eq!(*design(&harness), exported, "asked first");
    click(&mut harness, "Cancel");
    assert_eq!(*design(&harness), exported);
    drop_it(&mut harness);
    click(&mut harness, "Use as chart");
    let name = picture.to_string_lossy().into_owned();
    wait(&mut harness, "the chart", |h| {
        design(h).chart.image.as_deref() == Some(&name)
    });
    harness.run_steps(3);
    drop_it(&mut harness);
    click(&mut harness, "Open its design");
    click(&mut harness, "Discard changes");
    wait_for_document(&mut harness, "picture");
    let document = harness.state().document();
    assert_eq!(document.path(), None, "the picture is not written to");
    assert!(!document.is_unsaved());
    assert_eq!(document.design.sheet.wefts, 44);
    assert_eq!(document.design.chart.pixels, exported.chart.pixels);
}

#[test]
fn shipped_presets_open_as_copies() {
    let user = User::new();
    let mut harness = user.start(None);
    wait_for_label(&mut harness, "Preset harbour-stripe");
    click(&mut harness, "Preset harbour-stripe");
    wait_for_document(&mut harness, "harbour-stripe");
    assert_eq!(harness.state().document().path(), None);
    assert!(!harness.state().document().is_unsaved());
    // Save asks where; the chart comes along.
    key(&mut harness, Modifiers::COMMAND, Key::S);
    type_path(&mut harness, &user.at("mine.toml"));
    click(&mut harness, "Save file");
    wait_for_document(&mut harness, "mine");
    let saved = files::load_design(&user.at("mine.toml")).unwrap();
    assert_eq!(saved.chart.pixels, design(&harness).chart.pixels);
    assert!(saved.chart.pixels.is_some());
}

#[test]
fn own_presets_are_kept_searched_copied_renamed_and_deleted() {
    let user = User::new();
    let mut harness = user.start(Some(user.preset("one.toml")));
    wait_for_document(&mut harness, "one");
    click(&mut harness, "Save as preset…");
    let field = harness.get_by_role_and_label(Role::TextInput, "Name");
    assert_eq!(field.value().as_deref(), Some("one"));
    key(&mut harness, Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("My stripes".into()));
    harness.run_steps(2);
    click(&mut harness, "Save preset");
    wait_for_label(&mut harness, "Preset My stripes");
    // Self-contained, and the document stays what it was.
    assert_eq!(user.names("presets"), ["My stripes.towel"]);
    assert_eq!(harness.state().document().name(), "one");

    let more = |harness: &mut Harness<'_, App>, name: &str, line: &str| {
        click(harness, &format!("More about {name}"));
        click(harness, line);
    };
    more(&mut harness, "My stripes", "Duplicate");
    wait_for_label(&mut harness, "Preset My stripes copy");
    more(&mut harness, "My stripes copy", "Rename…");
    key(&mut harness, Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("Bold".into()));
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    wait_for_label(&mut harness, "Preset Bold");
    assert_eq!(user.names("presets"), ["Bold.towel", "My stripes.towel"]);
    // A name that leads elsewhere is none.
    more(&mut harness, "Bold", "Rename…");
    key(&mut harness, Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("../Bold".into()));
    harness.run_steps(2);
    click(&mut harness, "Rename");
    assert!(is_reported(&harness, "A name cannot have any of"));
    assert_eq!(user.names("presets"), ["Bold.towel", "My stripes.towel"]);

    more(&mut harness, "My stripes", "Delete…");
    click(&mut harness, "Cancel");
    assert_eq!(user.names("presets").len(), 2);
    more(&mut harness, "My stripes", "Delete…");
    click(&mut harness, "Delete");
    wait(&mut harness, "its end", |h| {
        h.query_by_label("Preset My stripes").is_none()
    });
    assert_eq!(user.names("presets"), ["Bold.towel"]);

    harness.get_by_label("Search presets").focus();
    harness.run_steps(2);
    harness.event(egui::Event::Text("beach CHART".into()));
    harness.run_steps(3);
    assert!(harness.query_by_label("Preset harbour-stripe").is_some());
    assert!(harness.query_by_label("Preset Bold").is_none());
    assert!(harness.query_by_label("Preset hotel-white").is_none());
}

#[test]
fn pictures_of_presets_are_drawn_once() {
    let user = User::new();
    let path = user.preset("one.toml");
    let presets = user.at("presets");
    fs::create_dir(&presets).unwrap();
    fs::copy(&path, presets.join("one.toml")).unwrap();
    fs::copy(user.at("chart.png"), presets.join("chart.png")).unwrap();
    let kept = |user: &User| user.names("cache/presets").len();
    let mut harness = user.start(None);
    // Its own comes first in the list, and so is drawn first.
    wait(&mut harness, "a picture", |_| kept(&user) > 0);
    drop(harness);
    let before = kept(&user);
    assert!(before >= 1);
    let content = files::Outline::of_file(&presets.join("one.toml"), &KnownOutside::default());
    assert_eq!(content.comment, "Stripes for a test.");
    // Another chart, another picture, though the preset's text is the same.
    image::RgbImage::new(3, 3)
        .save(presets.join("chart.png"))
        .unwrap();
    assert_ne!(
        files::Outline::of_file(&presets.join("one.toml"), &KnownOutside::default()),
        content
    );
}

#[test]
fn settings_are_remembered_and_broken_ones_set_aside() {
    let user = User::new();
    let path = user.preset("one.toml");
    let mut harness = user.start(Some(path.clone()));
    wait_for_document(&mut harness, "one");
    key(&mut harness, Modifiers::COMMAND, Key::Plus);
    key(&mut harness, Modifiers::COMMAND, Key::Plus);
    assert_eq!(harness.ctx.zoom_factor(), 1.25);
    open_panel(&mut harness, "Light");
    click(&mut harness, "Display");
    click(&mut harness, "Theme");
    harness
        .get_by_role_and_label(Role::RadioButton, "Light")
        .click();
    harness.run_steps(3);
    harness.run_steps(10);
    drop(harness);

    let file = user.at("config/settings.toml");
    let text = fs::read_to_string(&file).unwrap();
    assert!(
        text.contains("scale = 125") && text.contains("theme = \"light\""),
        "{text}"
    );
    let harness = user.start(None);
    assert_eq!(harness.ctx.zoom_factor(), 1.25);
    drop(harness);
    let theme = |harness: &mut Harness<'_, App>, name: &str| {
        click(harness, "Display");
        click(harness, "Theme");
        let radio = harness.get_by_role_and_label(Role::RadioButton, name);
        radio.accesskit_node().toggled()
    };
    let mut harness = user.start(None);
    let chosen = theme(&mut harness, "Light");
    assert_eq!(chosen, Some(egui::accesskit::Toggled::True));
    drop(harness);

    fs::write(&file, "theme = \"purple\"\nrecent = 7\n").unwrap();
    let harness = user.start(None);
    assert!(is_reported(&harness, "Settings not read"));
    assert!(is_reported(&harness, "settings.toml.broken"));
    assert_eq!(harness.ctx.zoom_factor(), 1.0);
    assert!(user.at("config/settings.toml.broken").is_file());
    drop(harness);
    // Numbers from elsewhere are brought into range, unknown fields belong to a newer version.
    fs::write(&file, "scale = 900\npanels_width = nan\nfuture = true\n").unwrap();
    let harness = user.start(None);
    assert!(!is_reported(&harness, "Settings not read"));
    assert_eq!(harness.ctx.zoom_factor(), 2.5);
}

#[test]
fn recent_files_are_opened_and_forgotten_when_they_are_gone() {
    let user = User::new();
    let path = user.preset("one.toml");
    let mut harness = user.start(Some(path.clone()));
    wait_for_document(&mut harness, "one");
    key(&mut harness, Modifiers::COMMAND, Key::N);
    assert_eq!(harness.state().document().name(), "untitled");
    click(&mut harness, "File");
    click(&mut harness, "Open recent");
    click(&mut harness, "one.toml");
    wait_for_document(&mut harness, "one");
    key(&mut harness, Modifiers::COMMAND, Key::N);
    fs::remove_file(&path).unwrap();
    click(&mut harness, "File");
    click(&mut harness, "Open recent");
    click(&mut harness, "one.toml");
    wait_for_label(&mut harness, "Not opened");
    assert!(is_reported(&harness, "taken off the list of recent files"));
    click(&mut harness, "File");
    click(&mut harness, "Open recent");
    assert!(harness.query_by_label("one.toml").is_none());
}

/// Waits until an unsaved design is kept.
#[track_caller]
pub(super) fn wait_for_kept(user: &User, harness: &mut Harness<'_, App>) {
    wait(harness, "the unsaved design", |_| {
        user.names("state")
            .iter()
            .any(|name| name.ends_with(".towel"))
    });
}

#[test]
fn a_design_left_behind_is_recovered_with_its_chart_and_its_file() {
    let user = User::new();
    let path = user.preset("one.toml");
    let mut harness = user.start(Some(path.clone()));
    wait_for_document(&mut harness, "one");
    assert_eq!(user.names("state"), [""; 0], "nothing to keep yet");
    type_number(&mut harness, "Wefts", "44");
    wait_for_kept(&user, &mut harness);
    let edited = design(&harness).clone();
    // Another window at the same time does not take it.
    let other = user.start(None);
    assert!(other.query_by_label("Recover unsaved design?").is_none());
    drop(other);
    // The window goes away without having asked.
    drop(harness);
    fs::remove_file(user.at("chart.png")).unwrap();

    let mut harness = user.start(None);
    assert!(is_reported(&harness, "Recover unsaved design?"));
    assert!(is_reported(&harness, "one.toml"));
    click(&mut harness, "Later");
    drop(harness);
    let mut harness = user.start(None);
    click(&mut harness, "Recover");
    let document = harness.state().document();
    assert_eq!(document.path(), Some(path.as_path()));
    assert!(document.is_unsaved());
    assert_eq!(document.design.sheet.wefts, 44);
    assert_eq!(document.design.chart.pixels, edited.chart.pixels);
    key(&mut harness, Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saved", |h| {
        !h.state().document().is_unsaved()
    });
    harness.run_steps(3);
    drop(harness);
    let saved = files::load_design(&path).unwrap();
    assert_eq!(saved.chart.pixels, edited.chart.pixels, "with its chart");
    assert_eq!(user.names("state"), [""; 0], "saved: nothing is left");
    let harness = user.start(None);
    assert!(!is_reported(&harness, "Recover unsaved design?"));
}

#[test]
fn discarded_and_broken_designs_are_not_offered_again() {
    let user = User::new();
    let mut harness = user.start(None);
    type_number(&mut harness, "Wefts", "44");
    wait_for_kept(&user, &mut harness);
    drop(harness);
    let mut harness = user.start(None);
    click(&mut harness, "Discard");
    drop(harness);
    assert_eq!(user.names("state"), [""; 0]);

    fs::write(user.at("state/1-1.towel"), "no bundle").unwrap();
    let mut harness = user.start(None);
    click(&mut harness, "Recover");
    wait_for_label(&mut harness, "Not recovered");
    assert_eq!(*design(&harness), Design::default());
    drop(harness);
    assert_eq!(
        user.names("state")
            .iter()
            .filter(|n| n.ends_with("broken"))
            .count(),
        1
    );
    let harness = user.start(None);
    assert!(!is_reported(&harness, "Recover unsaved design?"));
}

#[test]
fn every_way_out_asks_about_unsaved_changes() {
    type Way = fn(&mut Harness<'_, App>, &Path);
    let user = User::new();
    let path = user.preset("one.toml");
    let mut harness = user.start(Some(path.clone()));
    wait_for_document(&mut harness, "one");
    wait_for_label(&mut harness, "Preset hotel-white");
    type_number(&mut harness, "Wefts", "44");
    let ways: [(&str, Way); 7] = [
        ("new", |h, _| key(h, Modifiers::COMMAND, Key::N)),
        ("open", |h, _| key(h, Modifiers::COMMAND, Key::O)),
        ("quit", |h, _| key(h, Modifiers::COMMAND, Key::Q)),
        ("close", |h, _| close(h)),
        ("drop", |h, path| {
            let dropped = Arc::new(Dropped(path.to_owned()));
            h.input_mut().dropped_files.push(dropped);
            h.run_steps(3);
        }),
        ("recent", |h, _| {
            click(h, "File");
            click(h, "Open recent");
            click(h, "one.toml");
        }),
        ("preset", |h, _| click(h, "Preset hotel-white")),
    ];
    for (way, go) in ways {
        go(&mut harness, &path);
        assert!(is_reported(&harness, "Save changes?"), "{way} does not ask");
        click(&mut harness, "Cancel");
        assert_eq!(design(&harness).sheet.wefts, 44, "{way}");
        assert!(harness.state().document().is_unsaved(), "{way}");
    }
    // Save, and go on with what was asked for.
    click(&mut harness, "Preset hotel-white");
    click(&mut harness, "Save changes");
    wait_for_document(&mut harness, "hotel-white");
    assert_eq!(files::load_design(&path).unwrap().sheet.wefts, 44);
}

#[test]
fn a_file_changed_by_another_program_is_asked_about() {
    let user = User::new();
    let path = user.preset("one.toml");
    let mut harness = user.start(Some(path.clone()));
    wait_for_document(&mut harness, "one");
    type_number(&mut harness, "Wefts", "44");
    let theirs = "format = 1\nsheet.warps = 99\n";
    fs::write(&path, theirs).unwrap();
    key(&mut harness, Modifiers::COMMAND, Key::S);
    assert!(is_reported(&harness, "Replace the changed file?"));
    click(&mut harness, "Cancel");
    assert_eq!(fs::read_to_string(&path).unwrap(), theirs);
    assert!(harness.state().document().is_unsaved());
    key(&mut harness, Modifiers::COMMAND, Key::S);
    click(&mut harness, "Replace");
    wait(&mut harness, "saved", |h| {
        !h.state().document().is_unsaved()
    });
    assert_eq!(files::load_design(&path).unwrap().sheet.wefts, 44);
    // Our own writing is no change by others.
    type_number(&mut harness, "Wefts", "45");
    key(&mut harness, Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saved", |h| {
        !h.state().document().is_unsaved()
    });
}

#[test]
fn what_cannot_be_written_is_reported_and_stays_in_the_window() {
    let user = User::new();
    fs::create_dir(user.at("gone")).unwrap();
    let path = user.preset("gone/one.toml");
    let mut harness = user.start(Some(path.clone()));
    wait_for_label(&mut harness, "Preset not opened");
    click(&mut harness, "Dismiss: Preset not opened");
    write_chart(&user.at("gone/chart.png"));
    key(&mut harness, Modifiers::COMMAND, Key::O);
    type_path(&mut harness, &path);
    click(&mut harness, "Open file");
    wait_for_document(&mut harness, "one");
    type_number(&mut harness, "Wefts", "44");
    fs::remove_dir_all(user.at("gone")).unwrap();
    key(&mut harness, Modifiers::COMMAND, Key::S);
    wait_for_label(&mut harness, "Not saved");
    assert!(is_reported(&harness, "there is no directory"));
    assert!(is_reported(&harness, "Save it to another place"));
    assert!(harness.state().document().is_unsaved());
    // Elsewhere it works, with the chart that has no file any more.
    key(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    type_path(&mut harness, &user.at("Räume & Läufer.toml"));
    click(&mut harness, "Save file");
    wait(&mut harness, "saved", |h| {
        !h.state().document().is_unsaved()
    });
    let saved = files::load_design(&user.at("Räume & Läufer.toml")).unwrap();
    assert_eq!(saved.chart.pixels, design(&harness).chart.pixels);
    assert_eq!(saved.sheet.wefts, 44);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_and_a_device_are_reported() {
    let user = User::new();
    let mut harness = user.start(None);
    type_number(&mut harness, "Wefts", "44");
    key(&mut harness, Modifiers::COMMAND, Key::S);
    // What /dev/full answers is what a full disk answers.
    fs::create_dir(user.at("d")).unwrap();
    std::os::unix::fs::symlink("/dev/full", user.at("d/full.toml")).unwrap();
    type_path(&mut harness, &user.at("d/full.toml"));
    click(&mut harness, "Save file");
    click(&mut harness, "Replace file");
    wait_for_label(&mut harness, "Not saved");
    assert!(is_reported(&harness, "No space left"));
    assert!(harness.state().document().is_unsaved());
    assert_eq!(design(&harness).sheet.wefts, 44);
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_files_is_reported() {
    let user = User::new();
    let mut harness = user.start(None);
    type_number(&mut harness, "Wefts", "44");
    key(&mut harness, Modifiers::COMMAND, Key::S);
    // The kernel's own folder: not even an administrator, as whom tests may run, can write there.
    type_path(&mut harness, Path::new("/sys/one.toml"));
    click(&mut harness, "Save file");
    wait_for_label(&mut harness, "Not saved");
    assert!(is_reported(&harness, "/sys/one.toml"));
    assert!(harness.state().document().is_unsaved());
    assert_eq!(design(&harness).sheet.wefts, 44);
    // Elsewhere it can be saved.
    key(&mut harness, Modifiers::COMMAND, Key::S);
    type_path(&mut harness, &user.at("one.toml"));
    click(&mut harness, "Save file");
    wait_for_document(&mut harness, "one");
    assert_eq!(
        files::load_design(&user.at("one.toml"))
            .unwrap()
            .sheet
            .wefts,
        44
    );
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_files_too() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let user = User::new();
    let folder = user.at("").join(OsStr::from_bytes(b"folder \xff"));
    fs::create_dir(&folder).unwrap();
    let preset = user.preset("one.toml");
    let odd = folder.join(OsStr::from_bytes(b"od\xfed.toml"));
    fs::copy(&preset, &odd).unwrap();
    fs::copy(user.at("chart.png"), folder.join("chart.png")).unwrap();
    let mut harness = Harness::builder()
        .with_size(vec2(1280.0, 720.0))
        .with_step_dt(1.0 / 60.0)
        // The window draws a box for what is no character.
        .allow_missing_glyphs()
        .build_eframe(|cc| App::new(cc, user.setup(Some(odd.clone()))));
    wait(&mut harness, "the preset", |h| {
        h.state().document().path() == Some(odd.as_path())
    });
    harness.run_steps(3);
    type_number(&mut harness, "Wefts", "44");
    wait_for_kept(&user, &mut harness);
    key(&mut harness, Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saved", |h| {
        !h.state().document().is_unsaved()
    });
    let saved = files::load_design(&odd).unwrap();
    assert_eq!(saved.sheet.wefts, 44);
    assert_eq!(saved.chart.pixels, design(&harness).chart.pixels);
}
