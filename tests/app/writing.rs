//! Writing where disks and folders are not as they should be: a finished file is never lost, an old one never harmed,
//! and messages name the file that the user knows.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;
use towel_designer::files::{self, Carried, FileError, OwnImages, UsedFile};

use crate::support::faults::{Fault, with_faults};
use crate::support::folders::names_in;

const SMALL: &str = "format = 1\nsheet = { warps = 12, wefts = 10 }\n\
                     pile = { variants = 2, layers = 3, resolution = 8 }\n\
                     quality = { method = 'single', bounces = 1, samples = 1 }\n";

/// A folder with a preset, in one that programs take for their temporary files.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().unwrap());
        fs::create_dir(bench.at("work")).unwrap();
        fs::create_dir(bench.at("temporary")).unwrap();
        fs::write(bench.at("small.toml"), SMALL).unwrap();
        bench
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Renders a picture of some 50 kB, more or less, to a file of the folder `work`.
    fn render(&self, output: &str, faults: &[Fault<'_>]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_towel-designer"));
        let command = command
            .current_dir(self.at("work"))
            .env("TMPDIR", self.at("temporary"))
            .args(["render", "../small.toml", "-o", output, "--backend", "cpu"])
            .args(["--size", "400x300", "--depth", "16"]);
        with_faults(command, &self.at("work"), faults)
            .output()
            .unwrap()
    }

    #[track_caller]
    fn renders(&self, output: &str, faults: &[Fault<'_>]) {
        let done = self.render(output, faults);
        assert!(done.status.success(), "{faults:?}: {}", errors(&done));
        assert!(
            image::open(self.at("work").join(output)).is_ok(),
            "{faults:?}"
        );
    }

    /// Fails to render, with code 1 and a message that has all of `says`.
    #[track_caller]
    fn fails(&self, output: &str, faults: &[Fault<'_>], says: &[&str]) -> String {
        let done = self.render(output, faults);
        let errors = errors(&done);
        assert_eq!(done.status.code(), Some(1), "{faults:?}: {errors}");
        for part in says {
            assert!(errors.contains(part), "{faults:?}: no {part:?} in {errors}");
        }
        assert!(!errors.contains(".towel-draft"), "{faults:?}: {errors}");
        errors
    }

    fn names(&self, folder: &str) -> Vec<String> {
        names_in(&self.at(folder))
    }
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Both ways to make a file: without a name until it is whole, and with one.
const WAYS: [&[Fault<'_>]; 2] = [&[], &[Fault::Named]];

#[test]
fn a_picture_needs_no_more_room_than_it_has() {
    let bench = Bench::new();
    bench.renders("a.png", &[]);
    let size = fs::metadata(bench.at("work/a.png")).unwrap().len();
    assert!(size > 10_000, "{size}");
    fs::write(bench.at("work/a.png"), "old").unwrap();
    for way in WAYS {
        // Less than it needs: the old one stays, and nothing is left.
        let tight = [way, &[Fault::Full(size - 1)]].concat();
        bench.fails(
            "a.png",
            &tight,
            &["a.png: cannot be written: No space left"],
        );
        assert_eq!(fs::read(bench.at("work/a.png")).unwrap(), b"old");
        assert_eq!(bench.names("work"), ["a.png"]);
        // Just enough.
        bench.renders("b.png", &[way, &[Fault::Full(size)]].concat());
        fs::remove_file(bench.at("work/b.png")).unwrap();
    }
}

#[test]
fn a_folder_that_cannot_be_synced_takes_files_like_others() {
    let bench = Bench::new();
    for way in WAYS {
        let faults = [way, &[Fault::NoFolderSync]].concat();
        bench.renders("a.png", &faults);
        assert_eq!(bench.names("work"), ["a.png"]);
    }
}

#[test]
fn a_read_only_folder_is_found_before_rendering() {
    let bench = Bench::new();
    for way in WAYS {
        let faults = [way, &[Fault::ReadOnly]].concat();
        let says = ["a.png: cannot be written: Read-only file system"];
        bench.fails("a.png", &faults, &says);
        assert_eq!(bench.names("work"), [""; 0]);
    }
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let bench = Bench::new();
    let says = ["none/a.png: cannot be written: there is no directory none"];
    bench.fails("none/a.png", &[], &says);
    std::os::unix::fs::symlink("gone/b.png", bench.at("work/link.png")).unwrap();
    let says = ["link.png: cannot be written: there is no directory", "gone"];
    bench.fails("link.png", &[], &says);
    std::os::unix::fs::symlink("round.png", bench.at("work/round.png")).unwrap();
    bench.fails(
        "round.png",
        &[],
        &["round.png: cannot be written: is a link that leads"],
    );
    // One behind another.
    assert_eq!(bench.names("work"), ["link.png", "round.png"]);
}

#[test]
fn a_finished_picture_that_cannot_take_its_name_is_kept() {
    for way in WAYS {
        let bench = Bench::new();
        let faults = [way, &[Fault::NoRename("a.png")]].concat();
        for kept in ["a-kept.png", "a-kept-2.png"] {
            let says = ["a.png: cannot be written: ", "kept as "];
            let errors = bench.fails("a.png", &faults, &says);
            let place = bench.at("work").canonicalize().unwrap().join(kept);
            assert!(errors.contains(&*place.to_string_lossy()), "{errors}");
            assert!(image::open(place).is_ok());
        }
        assert_eq!(bench.names("work"), ["a-kept-2.png", "a-kept.png"]);
    }
}

#[test]
fn a_picture_whose_folder_went_away_is_kept_elsewhere() {
    for way in WAYS {
        let bench = Bench::new();
        let gone = bench.at("gone");
        let faults = [way, &[Fault::Move(&gone)]].concat();
        bench.fails(
            "../work/a.png",
            &faults,
            &["a.png: cannot be written: ", "kept as "],
        );
        let kept = bench.at("temporary/a-kept.png");
        assert!(image::open(&kept).is_ok(), "{:?}", bench.names("temporary"));
    }
}

#[test]
fn names_as_long_as_the_disk_takes_are_written() {
    let bench = Bench::new();
    for length in [244, 250, 255] {
        let name = format!("{}.png", "n".repeat(length - 4));
        for way in WAYS {
            bench.renders(&name, way);
        }
        fs::remove_file(bench.at("work").join(&name)).unwrap();
        let path = bench
            .at("work")
            .join("ö".repeat((length - 5) / 2) + ".toml");
        files::write_atomically(&path, b"text").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"text");
        fs::remove_file(path).unwrap();
    }
    // A chart that was painted here takes its name from the preset's, as far as there is room.
    let preset = bench.at("work").join("m".repeat(250) + ".toml");
    let design = crate::killed::painted(31);
    files::save(&design, &Carried::default(), &preset, None).unwrap();
    let opened = files::load_design(&preset).unwrap();
    assert_eq!(opened.chart.pixels, design.chart.pixels);
    // One more is found at once, not after minutes.
    let name = format!("{}.png", "n".repeat(252));
    let says = ["cannot be written: File name too long"];
    bench.fails(&name, &[Fault::ReadOnly], &says);
}

#[test]
fn a_link_is_followed_also_where_there_is_no_file_yet() {
    let bench = Bench::new();
    fs::create_dir(bench.at("store")).unwrap();
    let link = |to: &str, name: &str| {
        std::os::unix::fs::symlink(to, bench.at(name)).unwrap();
    };
    link("second.png", "work/first.png");
    link("../store/a.png", "work/second.png");
    bench.renders("first.png", &[]);
    assert_eq!(bench.names("store"), ["a.png"]);
    for name in ["work/first.png", "work/second.png"] {
        assert!(fs::symlink_metadata(bench.at(name)).unwrap().is_symlink());
    }
    let before = fs::read(bench.at("store/a.png")).unwrap();
    fs::write(bench.at("store/a.png"), "old").unwrap();
    bench.renders("first.png", &[]);
    assert!(fs::read(bench.at("store/a.png")).unwrap() == before);
}

#[test]
fn a_pipe_takes_a_picture_behind_a_link() {
    let bench = Bench::new();
    std::os::unix::fs::symlink("/dev/stdout", bench.at("work/pipe.png")).unwrap();
    let done = bench.render("pipe.png", &[]);
    assert!(done.status.success(), "{}", errors(&done));
    assert!(image::load_from_memory(&done.stdout).is_ok());
    assert_eq!(bench.names("work"), ["pipe.png"]);
}

#[test]
fn what_dead_programs_left_is_swept_away_and_nothing_else() {
    let bench = Bench::new();
    let at = |name: &str| bench.at("work").join(name);
    for name in [
        ".towel-draft-1-0.tmp",
        ".towel-draft-ffff-a.tmp",
        ".other.tmp",
        ".towel-draft-x",
    ] {
        fs::write(at(name), "left").unwrap();
    }
    // One in the making, and one that is whole and was kept.
    fs::write(at(".towel-draft-2-0.tmp"), "in the making").unwrap();
    let living = fs::File::options()
        .write(true)
        .open(at(".towel-draft-2-0.tmp"))
        .unwrap();
    living.try_lock().unwrap();
    fs::write(at(".towel-draft-3-0.tmp"), "whole").unwrap();
    let mut permissions = fs::metadata(at(".towel-draft-3-0.tmp"))
        .unwrap()
        .permissions();
    permissions.set_readonly(true);
    fs::set_permissions(at(".towel-draft-3-0.tmp"), permissions).unwrap();
    bench.renders("a.png", &[]);
    let left = [
        ".other.tmp",
        ".towel-draft-2-0.tmp",
        ".towel-draft-3-0.tmp",
        ".towel-draft-x",
        "a.png",
    ];
    assert_eq!(bench.names("work"), left);
    drop(living);
}

#[test]
fn rights_of_the_old_file_stay_and_a_protected_one_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    let path = bench.at("work/a.toml");
    fs::write(&path, "old").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    files::write_atomically(&path, b"new").unwrap();
    assert_eq!(
        fs::metadata(&path).unwrap().permissions().mode() & 0o777,
        0o640
    );
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
    let error = files::write_atomically(&path, b"other")
        .unwrap_err()
        .to_string();
    assert!(
        error.ends_with("a.toml: cannot be written: is write-protected"),
        "{error}"
    );
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

/// Whether the file of a folder would be taken for another.
fn taken(folder: &Path, used: &str, output: &str) -> bool {
    let input = UsedFile::new(folder.join(used), "the chart");
    let output = UsedFile::new(folder.join(output), "the picture");
    match files::check_apart(&[input], &[output]) {
        Ok(()) => false,
        Err(FileError::NotApart { what, .. }) => what == "the chart",
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn one_file_is_known_by_all_its_names() {
    let bench = Bench::new();
    let folder = bench.at("work");
    for name in ["chart.png", "Other.png"] {
        fs::write(folder.join(name), name).unwrap();
    }
    fs::create_dir(folder.join("deep")).unwrap();
    std::os::unix::fs::symlink("chart.png", folder.join("soft.png")).unwrap();
    std::os::unix::fs::symlink("later.png", folder.join("dangling.png")).unwrap();
    std::os::unix::fs::symlink(&folder, folder.join("deep/up")).unwrap();
    fs::hard_link(folder.join("chart.png"), folder.join("hard.png")).unwrap();
    for name in [
        "chart.png",
        "./chart.png",
        "deep/../chart.png",
        "deep/up/chart.png",
        "soft.png",
        "hard.png",
    ] {
        assert!(taken(&folder, "chart.png", name), "{name}");
        assert!(taken(&folder, name, "chart.png"), "{name}");
    }
    // Two that are not there, and would be one on some disks.
    for [a, b] in [
        ["later.png", "dangling.png"],
        ["New.PNG", "new.png"],
        ["M\u{f6}we.png", "Mo\u{308}we.png"],
    ] {
        assert!(taken(&folder, a, b), "{a} {b}");
    }
    for [a, b] in [
        ["chart.png", "Other.png"],
        ["chart.png", "new.png"],
        ["chart.png", "deep/chart.png"],
        ["none/a.png", "a.png"],
        // There, each by itself.
        ["Other.png", "other.png"],
    ] {
        assert!(!taken(&folder, a, b), "{a} {b}");
    }
    assert!(!taken(Path::new("/dev"), "null", "null"));
}

#[test]
fn a_design_is_saved_again_where_folders_cannot_be_synced() {
    // What a saving window does, in a process that meets the fault.
    let bench = Bench::new();
    let saved = |faults: &[Fault<'_>]| {
        let mut child = crate::killed::child("saves", &bench.at("work"));
        with_faults(&mut child, &bench.at("work"), faults)
            .output()
            .unwrap()
    };
    let done = saved(&[Fault::NoFolderSync]);
    assert!(done.status.success(), "{}", errors(&done));
    let before = fs::read(bench.at("work/design.toml")).unwrap();
    let done = saved(&[Fault::Full(100)]);
    assert!(!done.status.success());
    assert!(errors(&done).contains("No space left"), "{}", errors(&done));
    assert!(fs::read(bench.at("work/design.toml")).unwrap() == before);
    let design = files::load_design(&bench.at("work/design.toml")).unwrap();
    let again = files::save_edited(
        &design,
        &Carried::default(),
        &bench.at("work/again.toml"),
        None,
        &OwnImages::default(),
    );
    assert!(again.is_ok());
}
