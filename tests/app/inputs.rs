//! What is named as an input and is no file: pipes bring presets, devices and folders are refused at once, and nothing is
//! waited for without end. And what is a file and never ends.

#![cfg(unix)]

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use towel_designer::files::{self, FileError, KnownOutside, Outline};

const SMALL: &str = "format = 1\n[sheet]\nwarps = 12\nwefts = 10\n[pile]\nvariants = 1\nlayers = 2\nresolution = 4\n\
                     [quality]\nmethod = 'single'\nbounces = 1\nsamples = 1\n";
/// Longest that refusing takes, on a busy machine.
const AT_ONCE: Duration = Duration::from_secs(60);

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_towel-designer"))
}

/// What the program says when it is given this through its standard input.
fn piped(arguments: &[&str], input: &[u8]) -> Output {
    piped_in(Path::new("."), arguments, input)
}

/// As [`piped`], of a program that works in a folder.
fn piped_in(folder: &Path, arguments: &[&str], input: &[u8]) -> Output {
    let mut child = program()
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Who has read enough closes its end.
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[output.stdout.clone(), output.stderr.clone()].concat()).into_owned()
}

#[test]
fn presets_and_bundles_come_through_pipes() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("out.png");
    let picture = picture.to_str().unwrap();
    let rendered = [
        "render",
        "/dev/stdin",
        "-o",
        picture,
        "--size",
        "16x16",
        "--backend",
        "cpu",
    ];
    let output = piped(&rendered, SMALL.as_bytes());
    assert!(output.status.success(), "{}", said(&output));
    // A bundle, and the picture that was just made.
    let bundle = folder.path().join("one.towel");
    let design = files::load_design(Path::new(picture)).unwrap();
    files::save(&design, &files::Carried::default(), &bundle, None).unwrap();
    for file in [Path::new(picture), &bundle] {
        let output = piped(&["check", "/dev/stdin"], &fs::read(file).unwrap());
        assert!(
            output.status.success() && said(&output).contains("ok"),
            "{}",
            said(&output)
        );
    }
    let output = piped(&["check", "/dev/stdin"], b"format = 1\nx = 1\n");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("/dev/stdin:2:1: x is not a field"),
        "{}",
        said(&output)
    );
}

#[test]
fn images_of_a_piped_preset_are_looked_for_where_the_program_works() {
    let folder = tempfile::tempdir().unwrap();
    let image = image::RgbImage::new(4, 2);
    image.save(folder.path().join("chart.png")).unwrap();
    let preset = format!("{SMALL}[chart]\nimage = \"chart.png\"\n");
    let output = piped_in(folder.path(), &["check", "/dev/stdin"], preset.as_bytes());
    assert!(output.status.success(), "{}", said(&output));
}

#[test]
fn a_pipe_with_a_name_is_read_when_somebody_writes() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let check = program()
        .arg("check")
        .arg(&pipe)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    File::create(&pipe)
        .unwrap()
        .write_all(SMALL.as_bytes())
        .unwrap();
    let output = check.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
}

/// What opening a path says; it must come to an end.
fn refusal(path: &Path) -> String {
    let (sender, answer) = std::sync::mpsc::channel();
    let of = path.to_owned();
    std::thread::spawn(move || {
        let error = files::open_design(&of).expect_err("refused");
        assert!(matches!(error, FileError::Read { .. }), "{error}");
        let _ = sender.send(error.to_string());
    });
    answer
        .recv_timeout(AT_ONCE)
        .unwrap_or_else(|_| panic!("{} is still read", path.display()))
}

#[test]
fn what_is_no_file_is_refused_with_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    for (path, what) in [
        (Path::new("/dev/zero"), "a device"),
        (Path::new("/dev/null"), "a device"),
        (folder.path(), "a folder"),
        (&pipe, "nothing wrote to"),
    ] {
        let message = refusal(path);
        assert!(
            message.contains(what) && message.contains(path.to_str().unwrap()),
            "{message}"
        );
    }
}

#[test]
fn endless_and_huge_inputs_are_refused_with_little_read() {
    // More than may be read, of a pipe that would go on.
    let output = piped(&["check", "/dev/stdin"], &vec![b'\n'; 20 << 20]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("larger than 16777216 bytes"),
        "{}",
        said(&output)
    );
    // A file that takes no room and says to be a terabyte.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.toml");
    File::create(&path).unwrap().set_len(1 << 40).unwrap();
    assert!(refusal(&path).contains("larger than"));
    fs::write(&path, "PK\x03\x04").unwrap();
    File::options()
        .write(true)
        .open(&path)
        .unwrap()
        .set_len(1 << 40)
        .unwrap();
    assert!(refusal(&path).contains("larger than"));
}

#[test]
fn images_that_are_no_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("chart.png");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let path = folder.path().join("one.toml");
    for image in ["/dev/zero", "chart.png", "."] {
        fs::write(&path, format!("format = 1\n[chart]\nimage = '{image}'\n")).unwrap();
        let error = files::load_design(&path).expect_err(image).to_string();
        assert!(
            error.contains("one.toml:3:") && error.contains("no regular file"),
            "{error}"
        );
    }
}

#[test]
fn lists_of_presets_pass_over_what_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(
        Command::new("mkfifo")
            .arg(at("pipe.toml"))
            .status()
            .unwrap()
            .success()
    );
    std::os::unix::fs::symlink("/dev/zero", at("zero.toml")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", at("zero.towel")).unwrap();
    fs::write(
        at("image.toml"),
        "# Seen.\nformat = 1\n[chart]\nimage = '/dev/zero'\n",
    )
    .unwrap();
    for name in ["pipe.toml", "zero.toml", "zero.towel"] {
        assert_eq!(
            Outline::of_file(&at(name), &KnownOutside::default()),
            Outline::default(),
            "{name}"
        );
    }
    assert_eq!(
        Outline::of_file(&at("image.toml"), &KnownOutside::default()).comment,
        "Seen."
    );
}

#[test]
fn help_is_no_failure() {
    for arguments in [
        &["help"][..],
        &["help", "render"],
        &["--help"],
        &["render", "--help"],
        &["help", "export", "loops"],
    ] {
        let output = program().args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", said(&output));
        assert!(
            said(&output).contains("Usage:") && output.stderr.is_empty(),
            "{arguments:?}"
        );
    }
    for arguments in [
        &["help", "nonsense"][..],
        &["nonsense"],
        &["nonsense", "--size", "1x1"],
    ] {
        let output = program().args(arguments).output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(2),
            "{arguments:?}: {}",
            said(&output)
        );
        assert!(
            said(&output).contains("nonsense"),
            "{arguments:?}: {}",
            said(&output)
        );
    }
}

#[test]
fn check_refuses_what_render_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.toml");
    let picture = folder.path().join("out.png");
    for form in [
        "kind = 'stack'\nlayers = 60",
        "kind = 'roll'\nradius = 0.5\nrolled = 1.0",
        "kind = 'wave'\nwavelength = 100.0",
    ] {
        fs::write(&path, format!("{SMALL}[form]\n{form}\n")).unwrap();
        let check = program().arg("check").arg(&path).output().unwrap();
        let mut render = program();
        render.arg("render").arg(&path).arg("-o").arg(&picture);
        let render = render
            .args(["--size", "4x4", "--backend", "cpu"])
            .output()
            .unwrap();
        assert_eq!(
            check.status.code(),
            render.status.code(),
            "{}{}",
            said(&check),
            said(&render)
        );
        if !check.status.success() {
            assert!(said(&check).contains("form."), "{}", said(&check));
        }
    }
}
