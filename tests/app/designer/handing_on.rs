//! How files are called and what is given away with them: endings, proposed names, outputs that are inputs, designs that
//! stay out of pictures, and images that files of strangers name.

use std::fs;
use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use renderer_core::design::Design;
use towel_designer::designer::{App, Document};
use towel_designer::files::{self, Carried, Unsaved};

use super::export::{export_to, open, with_gray};
use super::filing::{User, file_menu, is_reported, key, wait_for_document, wait_for_label};
use super::{click, design, type_number, type_path, wait, write_chart};

/// Saves under a name that is typed.
#[track_caller]
fn save_as(harness: &mut Harness<'_, App>, line: &str, name: &str) {
    file_menu(harness, line);
    type_path(harness, Path::new(name));
    click(harness, "Save file");
}

/// What the dialog proposes.
fn proposed(harness: &Harness<'_, App>) -> String {
    let field = harness.get_by_role_and_label(Role::TextInput, "Path");
    field.value().unwrap_or_default()
}

#[test]
fn a_name_with_a_dot_keeps_it_and_gets_its_ending() {
    let user = User::new();
    let mut harness = user.start(Some(user.preset("one.toml")));
    wait_for_document(&mut harness, "one");
    save_as(&mut harness, "Save as…", "Beach 2.5");
    wait_for_document(&mut harness, "Beach 2.5");
    assert!(files::load_design(&user.at("Beach 2.5.toml")).is_ok());
    save_as(&mut harness, "Save as…", "thing.png");
    wait_for_document(&mut harness, "thing.png");
    assert!(files::load_design(&user.at("thing.png.toml")).is_ok());
    save_as(&mut harness, "Save as bundle…", "Set 3.1");
    wait_for_document(&mut harness, "Set 3.1");
    let bundle = files::open_design(&user.at("Set 3.1.towel")).unwrap();
    assert_eq!(bundle.origin, files::Origin::Bundle);
    assert!(bundle.carried.get("chart.png").is_some());
    // An ending in other letters is one.
    save_as(&mut harness, "Save as…", "loud.TOML");
    wait_for_document(&mut harness, "loud");
    // A name that becomes that of another file is asked about.
    file_menu(&mut harness, "Save as…");
    type_path(&mut harness, Path::new("Beach 2.5"));
    click(&mut harness, "Save file");
    assert!(is_reported(&harness, "Beach 2.5.toml exists. Replace it?"));
}

#[test]
fn an_export_is_called_otherwise_than_what_the_design_is_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_chart(&at("waves.png"));
    let chart = fs::read(at("waves.png")).unwrap();
    fs::write(at("waves.toml"), "format = 1\nchart.image = 'waves.png'\n").unwrap();
    let mut harness = with_gray(Some(&at("waves.toml")));
    wait_for_document(&mut harness, "waves");
    open(&mut harness);
    type_number(&mut harness, "Export samples", "1");
    click(&mut harness, "Choose file and export…");
    assert_eq!(proposed(&harness), "waves-picture.png");
    // Who insists is refused.
    type_path(&mut harness, &at("waves.png"));
    click(&mut harness, "Save file");
    click(&mut harness, "Replace file");
    wait_for_label(&mut harness, "Not exported");
    assert!(is_reported(
        &harness,
        "waves.png: is the chart image of the design"
    ));
    assert!(fs::read(at("waves.png")).unwrap() == chart);

    // The ending is not what stands behind any dot.
    export_to(&mut harness, &at("towel v1.2"));
    wait_for_label(&mut harness, "Exported");
    assert!(files::carries_design(&at("towel v1.2.png")));

    // A picture is the file of the design that was opened from it.
    fs::rename(at("towel v1.2.png"), at("waves-picture.png")).unwrap();
    let mut harness = with_gray(Some(&at("waves-picture.png")));
    wait_for_document(&mut harness, "waves-picture");
    open(&mut harness);
    click(&mut harness, "Choose file and export…");
    type_path(&mut harness, folder.path());
    click(&mut harness, "Save file");
    click(&mut harness, "Cancel");
    export_to(&mut harness, &at("waves-picture.png"));
    click(&mut harness, "Replace file");
    wait_for_label(&mut harness, "Not exported");
    assert!(is_reported(
        &harness,
        "waves-picture.png: is the file of the design"
    ));
}

#[test]
fn images_written_beside_a_saved_preset_are_its_own_too() {
    let user = User::new();
    let mut harness = user.start(Some(user.preset("one.toml")));
    wait_for_document(&mut harness, "one");
    save_as(&mut harness, "Save as bundle…", "two.towel");
    wait_for_document(&mut harness, "two");
    drop(harness);
    let deep = user.at("deep");
    fs::create_dir(&deep).unwrap();
    let mut harness = user.start(Some(user.at("two.towel")));
    wait_for_document(&mut harness, "two");
    save_as(
        &mut harness,
        "Save as…",
        &deep.join("three.toml").to_string_lossy(),
    );
    wait_for_document(&mut harness, "three");
    let files = harness.state().document().files();
    let chart = deep.join("chart.png");
    assert!(chart.is_file());
    assert!(files.iter().any(|file| file.path == chart), "{files:?}");
}

#[test]
fn a_design_is_not_saved_over_its_own_images() {
    let user = User::new();
    let mut harness = user.start(Some(user.preset("one.toml")));
    wait_for_document(&mut harness, "one");
    fs::rename(user.at("chart.png"), user.at("chart.toml")).unwrap();
    let chart = fs::read(user.at("chart.toml")).unwrap();
    let path = user.at("chart.toml").to_string_lossy().into_owned();
    harness.state_mut().document_mut().design.chart.image = Some(path);
    harness.run_steps(3);
    save_as(&mut harness, "Save as…", "chart");
    click(&mut harness, "Replace file");
    wait_for_label(&mut harness, "Not saved");
    assert!(is_reported(
        &harness,
        "chart.toml: is the chart image of the design"
    ));
    assert!(fs::read(user.at("chart.toml")).unwrap() == chart);
}

#[test]
fn a_picture_without_its_design_says_its_size_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.png");
    let mut harness = with_gray(None);
    open(&mut harness);
    type_number(&mut harness, "Export samples", "1");
    click(&mut harness, "in the file");
    type_number(&mut harness, "Print resolution", "200");
    export_to(&mut harness, &path);
    wait_for_label(&mut harness, "Exported");
    assert!(!files::carries_design(&path));
    let bytes = fs::read(&path).unwrap();
    let at = bytes
        .windows(4)
        .position(|part| part == b"pHYs")
        .expect("a size");
    // 200 pixels in 25.4 mm.
    assert_eq!(bytes[at + 4..at + 8], 7874_u32.to_be_bytes());
    // EXR files take no design along, and the window says so.
    let mut harness = with_gray(None);
    open(&mut harness);
    super::choose(&mut harness, "File", "EXR, linear light");
    assert!(harness.query_by_label("in the file").is_none());
    harness.get_by_label("not in EXR files");
}

/// A preset in a folder of its own whose chart is in another.
fn stranger(user: &User) -> PathBuf {
    for folder in ["in", "out"] {
        fs::create_dir_all(user.at(folder)).unwrap();
    }
    write_chart(&user.at("out/far.png"));
    let path = user.at("in/strange.toml");
    fs::write(
        &path,
        "format = 1\nsheet.warps = 31\nchart.image = '../out/far.png'\n",
    )
    .unwrap();
    path
}

#[test]
fn images_from_elsewhere_are_opened_after_a_question() {
    let user = User::new();
    let path = stranger(&user);
    let question = "Open images from elsewhere?";
    let mut harness = user.start(Some(path.clone()));
    wait_for_label(&mut harness, question);
    assert!(is_reported(&harness, "the chart image ../out/far.png"));
    click(&mut harness, "Cancel");
    assert_eq!(harness.state().document().name(), "untitled");
    drop(harness);

    // Without them it is another design, which is not saved over the file.
    let mut harness = user.start(Some(path.clone()));
    wait_for_label(&mut harness, question);
    click(&mut harness, "Open without them");
    wait_for_document(&mut harness, "strange");
    assert!(is_reported(&harness, "Opened without the chart image"));
    assert!(design(&harness).chart.pixels.is_none());
    assert_eq!(harness.state().document().path(), None);
    drop(harness);

    let mut harness = user.start(Some(path.clone()));
    wait_for_label(&mut harness, question);
    click(&mut harness, "Open them");
    wait_for_document(&mut harness, "strange");
    assert!(design(&harness).chart.pixels.is_some());
    drop(harness);
    // Answered once and for all.
    let mut harness = user.start(Some(path.clone()));
    wait_for_document(&mut harness, "strange");

    // What is saved here needs no question.
    save_as(
        &mut harness,
        "Save as…",
        &user.at("in/own.toml").to_string_lossy(),
    );
    wait_for_document(&mut harness, "own");
    let text = fs::read_to_string(user.at("in/own.toml")).unwrap();
    assert!(text.contains("../out/far.png"), "{text}");
    drop(harness);
    let mut harness = user.start(Some(user.at("in/own.toml")));
    wait_for_document(&mut harness, "own");
    assert!(design(&harness).chart.pixels.is_some());
    drop(harness);
    // Another image is another question.
    fs::rename(user.at("out/far.png"), user.at("out/other.png")).unwrap();
    fs::write(&path, "format = 1\nchart.image = '../out/other.png'\n").unwrap();
    let mut harness = user.start(Some(path));
    wait_for_label(&mut harness, question);
}

#[test]
fn unsaved_changes_are_asked_about_once_where_images_are_elsewhere() {
    let user = User::new();
    let path = stranger(&user);
    let mut harness = user.start(None);
    type_number(&mut harness, "Warps", "45");
    key(&mut harness, Modifiers::COMMAND, Key::O);
    click(&mut harness, "Discard changes");
    type_path(&mut harness, &path);
    click(&mut harness, "Open file");
    wait_for_label(&mut harness, "Open images from elsewhere?");
    click(&mut harness, "Open them");
    wait_for_document(&mut harness, "strange");
    assert!(harness.query_by_label("Discard changes").is_none());
    assert_eq!(design(&harness).sheet.warps, 31);
}

/// A path that leads to a file from where this process is.
fn relative(path: &Path) -> PathBuf {
    let here = std::env::current_dir().unwrap();
    let up = here.components().skip(1).map(|_| "..");
    up.collect::<PathBuf>()
        .join(path.strip_prefix("/").unwrap())
}

#[cfg(unix)]
#[test]
fn a_design_opened_by_a_relative_name_is_known_by_its_whole_path() {
    let user = User::new();
    let path = user.preset("one.toml");
    let mut harness = user.start(Some(relative(&path)));
    wait_for_document(&mut harness, "one");
    let opened = harness.state().document().path().unwrap().to_owned();
    assert!(opened.is_absolute());
    // And so is what is kept of it in case the program dies.
    type_number(&mut harness, "Wefts", "44");
    wait(&mut harness, "the unsaved design", |_| {
        user.names("state")
            .iter()
            .any(|name| name.ends_with(".towel"))
    });
    drop(harness);
    let left = files::RecoveryFile::find(&user.at("state")).expect("an unsaved design");
    assert_eq!(left.read().unwrap().path, Some(opened));
}

#[test]
fn a_relative_path_that_an_earlier_program_kept_leads_nowhere() {
    let unsaved = Unsaved {
        design: Design::default(),
        carried: Carried::default(),
        path: Some("waves.toml".into()),
        name: None,
        stamp: None,
    };
    let document = Document::recovered(unsaved);
    assert_eq!((document.path(), document.name().as_str()), (None, "waves"));
    assert!(document.is_unsaved());
}
