//! The program in a real window of a virtual display that nobody sees, driven by keys and pointer.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for anything. Software Vulkan on a busy machine takes many seconds to show a first frame.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// A process that does not outlive the test.
pub struct Process(pub Child);

impl Drop for Process {
    fn drop(&mut self) {
        // Ended already, as it should: then there is nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display that nobody sees.
pub struct Display {
    /// What `DISPLAY` is set to.
    pub name: String,
    _server: Process,
}

impl Display {
    /// Starts a server on a free number, which it tells itself.
    pub fn start(size: &str) -> Self {
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                size,
                "-noreset",
                "-nolisten",
                "tcp",
            ])
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

    /// Runs a program on this display to its end.
    pub fn run(&self, program: &str, arguments: &[&str]) -> Output {
        Command::new(program)
            .args(arguments)
            .env("DISPLAY", &self.name)
            .output()
            .unwrap_or_else(|error| {
                panic!("{program}: {error}; on Debian and Ubuntu install xdotool and imagemagick")
            })
    }

    /// Keys and pointer: the words of an `xdotool` command.
    pub fn xdotool(&self, arguments: &str) -> Output {
        self.run("xdotool", &arguments.split(' ').collect::<Vec<_>>())
    }

    /// The window whose title contains `title`.
    pub fn window(&self, title: &str) -> Option<String> {
        let found = self.run("xdotool", &["search", "--onlyvisible", "--name", title]);
        let text = String::from_utf8_lossy(&found.stdout).into_owned();
        text.lines().last().map(str::to_owned)
    }

    /// What the screen shows; the file stays at `path`.
    pub fn photograph(&self, path: &Path) -> image::RgbImage {
        let path_text = path.to_string_lossy();
        let taken = self.run("import", &["-window", "root", &path_text]);
        assert!(taken.status.success(), "import: {taken:?}");
        image::open(path).expect("a picture").into_rgb8()
    }
}

/// Looks again and again until something has come.
pub fn wait<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what} has not come");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// The program in a window of a display, at its top left corner, with the keyboard's focus.
pub struct Program {
    /// The process.
    pub process: Process,
    /// X11's number of the window.
    pub window: String,
}

impl Program {
    /// Starts the program in `folder` and waits for a window whose title contains `title`.
    pub fn start(
        display: &Display,
        folder: &Path,
        arguments: &[&str],
        title: &str,
        [width, height]: [u32; 2],
    ) -> Self {
        let program = Command::new(env!("CARGO_BIN_EXE_towel-designer"))
            .args(arguments)
            .current_dir(folder)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            // No desktop portal, so that the program's own file dialog opens wherever this runs.
            .env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/nonexistent")
            .env("XDG_RUNTIME_DIR", folder)
            // Its settings and unsaved designs are not those of who runs the tests.
            .env("HOME", folder)
            .env("XDG_CONFIG_HOME", folder.join("home/config"))
            // Where nothing can be kept, no pictures of presets are drawn, which would take the machine from the test.
            .env("XDG_CACHE_HOME", "/dev/null/cache")
            .env("XDG_STATE_HOME", folder.join("home/state"))
            .env("XDG_DATA_HOME", folder.join("home/data"))
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut process = Process(program);
        let window = wait("the window", || {
            if let Some(ended) = process.0.try_wait().expect("a status") {
                let mut message = String::new();
                let stderr = process.0.stderr.as_mut().expect("piped");
                stderr.read_to_string(&mut message).expect("text");
                panic!("the program ended early: {ended:?}\n{message}");
            }
            // With the document's name: the preset is read.
            display.window(title)
        });
        display.xdotool(&format!("windowmove {window} 0 0"));
        display.xdotool(&format!("windowsize {window} {width} {height}"));
        // Without a window manager nobody gives it the keyboard.
        wait("the focus", || {
            display.xdotool(&format!("windowfocus {window}"));
            let focused = display.xdotool("getwindowfocus");
            (String::from_utf8_lossy(&focused.stdout).trim() == window).then_some(())
        });
        Self { process, window }
    }

    /// Waits until nothing runs any more: all samples are there.
    pub fn wait_for_rest(&self) {
        wait("the program's rest", || {
            let before = cpu_seconds(self.process.0.id());
            std::thread::sleep(Duration::from_secs(2));
            (cpu_seconds(self.process.0.id()) - before < 0.1).then_some(())
        });
    }

    /// Waits until it has dealt with what keys and pointer did: for a moment it computes next to nothing. What follows
    /// sooner may come in the same frame, and a busy machine shows few.
    pub fn settle(&self) {
        wait("a moment's rest", || {
            let before = cpu_seconds(self.process.0.id());
            std::thread::sleep(Duration::from_millis(400));
            (cpu_seconds(self.process.0.id()) - before < 0.03).then_some(())
        });
    }

    /// Quits by keyboard; the program must end well.
    pub fn quit(mut self, display: &Display) {
        display.xdotool("key ctrl+q");
        let status = wait("the end", || self.process.0.try_wait().expect("a status"));
        assert!(status.success(), "{status:?}");
    }
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
