//! The program itself in a real window, under a virtual display of its own: opened with a preset, driven by keys and
//! pointer, saved, photographed, closed.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use towel_designer::files;

/// Longest wait for anything. Software Vulkan on a busy machine takes many seconds to show a first frame.
const PATIENCE: Duration = Duration::from_secs(120);

/// A process that does not outlive the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        // Ended already, as it should: then there is nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display that nobody sees.
struct Display {
    name: String,
    _server: Process,
}

impl Display {
    /// Starts a server on a free number, which it tells itself.
    fn start(size: &str) -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", size, "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb does not start; on Debian and Ubuntu install xvfb");
        let mut number = String::new();
        let stdout = server.stdout.take().expect("piped");
        BufReader::new(stdout)
            .read_line(&mut number)
            .expect("Xvfb tells its display");
        assert!(!number.trim().is_empty(), "Xvfb ended without a display");
        Self {
            name: format!(":{}", number.trim()),
            _server: Process(server),
        }
    }

    fn run(&self, program: &str, arguments: &[&str]) -> Output {
        Command::new(program)
            .args(arguments)
            .env("DISPLAY", &self.name)
            .output()
            .unwrap_or_else(|error| {
                panic!("{program}: {error}; on Debian and Ubuntu install xdotool and imagemagick")
            })
    }

    fn xdotool(&self, arguments: &str) -> Output {
        self.run("xdotool", &arguments.split(' ').collect::<Vec<_>>())
    }

    /// The window whose title contains `title`.
    fn window(&self, title: &str) -> Option<String> {
        let found = self.run("xdotool", &["search", "--onlyvisible", "--name", title]);
        let text = String::from_utf8_lossy(&found.stdout).into_owned();
        text.lines().last().map(str::to_owned)
    }

    fn photograph(&self, path: &Path) -> image::RgbImage {
        let path_text = path.to_string_lossy();
        let taken = self.run("import", &["-window", "root", &path_text]);
        assert!(taken.status.success(), "import: {taken:?}");
        image::open(path).expect("a picture").into_rgb8()
    }
}

fn wait<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what} has not come");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Share of the pixels of a part of a picture that differ from the part's first pixel.
fn variety(picture: &image::RgbImage, [x, y, width, height]: [u32; 4]) -> f64 {
    let first = picture.get_pixel(x, y);
    let part = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    let different = part
        .filter(|&(x, y)| picture.get_pixel(x, y) != first)
        .count();
    different as f64 / f64::from(width * height)
}

/// Processor time that a process has used, all threads, seconds.
fn cpu_seconds(process: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).expect("a process");
    // Fields behind the name, which may hold spaces: utime and stime are the 12th and 13th, in ticks of 10 ms.
    let fields: Vec<&str> = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .collect();
    let ticks = |index: usize| fields[index].parse::<f64>().expect("a number");
    (ticks(11) + ticks(12)) / 100.0
}

/// A design small and simple enough that the processor shows it at once.
fn small_preset(folder: &Path) -> PathBuf {
    let path = folder.join("small.toml");
    let text = "format = 1\n\n[sheet]\nwarps = 24\nwefts = 24\n\n[chart]\ncolour = \"#c04040\"\n\n\
                [quality]\nmethod = \"single\"\nbounces = 1\nsamples = 4\n";
    std::fs::write(&path, text).expect("written");
    path
}

#[test]
fn the_program_opens_draws_saves_and_closes() {
    let folder = tempfile::tempdir().expect("a folder");
    let preset = small_preset(folder.path());
    let display = Display::start("1280x720x24");
    let program = Command::new(env!("CARGO_BIN_EXE_towel-designer"))
        .arg(&preset)
        .args(["--backend", "cpu"])
        .current_dir(folder.path())
        .env("DISPLAY", &display.name)
        .env_remove("WAYLAND_DISPLAY")
        // No desktop portal, so that the program's own file dialog opens wherever this runs.
        .env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/nonexistent")
        .env("XDG_RUNTIME_DIR", folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut program = Process(program);
    let window = wait("the window", || {
        let ended = program.0.try_wait().expect("a status");
        assert!(ended.is_none(), "the program ended early: {ended:?}");
        // With the document's name: the preset is read.
        display.window("small - Towel Designer")
    });
    display.xdotool(&format!("windowmove {window} 0 0"));
    display.xdotool(&format!("windowsize {window} 1280 720"));
    wait("the focus", || {
        display.xdotool(&format!("windowfocus {window}"));
        let focused = display.xdotool("getwindowfocus");
        (String::from_utf8_lossy(&focused.stdout).trim() == window).then_some(())
    });

    // Panels left and right, a picture of red cloth between them.
    let shot = folder.path().join("shot.png");
    wait("the picture", || {
        let picture = display.photograph(&shot);
        let panel = variety(&picture, [0, 100, 350, 200]);
        let red = picture
            .enumerate_pixels()
            .filter(|(x, y, p)| {
                (400..1050).contains(x) && (100..650).contains(y) && p[0] > 90 && p[1] < p[0] / 2
            })
            .count();
        (panel > 0.02 && red > 1000).then_some(())
    });

    // When all samples are there, nothing runs any more.
    wait("the program's rest", || {
        let before = cpu_seconds(program.0.id());
        std::thread::sleep(Duration::from_secs(2));
        (cpu_seconds(program.0.id()) - before < 0.1).then_some(())
    });

    // A cell of the pattern is painted by the keyboard: Tab reaches everything, but a click is nearer.
    // The editor's near left cell, where the layout at this size puts it.
    display.xdotool("mousemove 23 345");
    display.xdotool("click 1");
    wait("the painted stitch's unsaved mark", || {
        display.xdotool("key 9");
        std::thread::sleep(Duration::from_millis(300));
        display.window("small\\* - Towel Designer")
    });

    // Saved under another name, through the program's own dialog.
    let copy = folder.path().join("copy.toml");
    display.xdotool("key ctrl+shift+s");
    std::thread::sleep(Duration::from_secs(2));
    display.xdotool("key ctrl+a");
    display.run(
        "xdotool",
        &["type", "--delay", "30", &copy.to_string_lossy()],
    );
    display.xdotool("key Return");
    wait("the saved copy", || {
        display
            .window("copy - Towel Designer")
            .filter(|_| copy.is_file())
    });
    let design = files::load_design(&copy).expect("a preset");
    assert_eq!(design.sheet.warps, 24);
    assert_eq!(
        design.weave.pattern.at(0, 0),
        9,
        "what was painted is saved"
    );

    display.xdotool("key ctrl+q");
    let status = wait("the end", || program.0.try_wait().expect("a status"));
    assert!(status.success(), "{status:?}");
}
