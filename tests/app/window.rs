//! The program itself in a real window, under a virtual display of its own: opened with a preset, driven by keys and
//! pointer, saved, photographed, closed.

use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use towel_designer::designer::App;
use towel_designer::files;

use crate::designer;
use crate::support::display::{Display, PATIENCE, Program, wait};
use crate::support::file_drop::drop_file;

/// Share of the pixels of a part of a picture that differ from the part's first pixel.
fn variety(picture: &image::RgbImage, [x, y, width, height]: [u32; 4]) -> f64 {
    let first = picture.get_pixel(x, y);
    let part = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    let different = part
        .filter(|&(x, y)| picture.get_pixel(x, y) != first)
        .count();
    different as f64 / f64::from(width * height)
}

/// A design small and simple enough that the processor shows it at once.
fn small_preset(folder: &Path) -> PathBuf {
    let path = folder.join("small.toml");
    let text = "format = 1\n\n[sheet]\nwarps = 24\nwefts = 24\n\n[chart]\ncolour = \"#c04040\"\n\n\
                [view]\ncameras = [{ name = \"near\", distance = 50.0 }]\n\n\
                [quality]\nmethod = \"single\"\nbounces = 1\nsamples = 4\n";
    std::fs::write(&path, text).expect("written");
    path
}

#[test]
fn the_program_opens_draws_saves_and_closes() {
    let folder = tempfile::tempdir().expect("a folder");
    let preset = small_preset(folder.path());
    let display = Display::start("1280x720x24");
    let program = Program::start(
        &display,
        folder.path(),
        &[&preset.to_string_lossy(), "--backend", "cpu"],
        "small - Towel Designer",
        SIZE,
    );

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

    program.wait_for_rest();

    // A cell of the pattern is painted by the keyboard: Tab reaches everything, but a click is nearer.
    click(&display, &program, designer::cell(&twin(&preset), 0, 0));
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

    program.quit(&display);
}

/// Size of the window that the scripted run drives, pixels.
const SIZE: [u32; 2] = [1280, 720];

/// Where things are in the window: the same design in a window that is drawn nowhere and tells the places of its
/// widgets.
fn twin(preset: &Path) -> Harness<'static, App> {
    let size = vec2(SIZE[0] as f32, SIZE[1] as f32);
    let mut twin = designer::designer_of_size(Some(preset.to_path_buf()), size);
    designer::wait(&mut twin, "the preset", |twin| {
        twin.state().document().path().is_some()
    });
    twin.run_steps(20);
    twin
}

/// Moves the pointer to `from`, holds it down, goes on to each of `to` and lets go.
fn drag(display: &Display, program: &Program, from: Pos2, to: &[Pos2]) {
    let act = |what: &str| {
        display.xdotool(what);
        program.settle();
    };
    let go = |at: Pos2| act(&format!("mousemove {} {}", at.x.round(), at.y.round()));
    go(from);
    act("mousedown 1");
    to.iter().copied().for_each(go);
    act("mouseup 1");
}

/// Not as [`drag`] does it: a button that is held down for long is no click.
fn click(display: &Display, program: &Program, at: Pos2) {
    display.xdotool(&format!("mousemove {} {}", at.x.round(), at.y.round()));
    program.settle();
    display.xdotool("click 1");
    program.settle();
}

/// Types into what has the keyboard, instead of what it holds.
fn type_instead(display: &Display, program: &Program, text: &str) {
    display.xdotool("key ctrl+a");
    program.settle();
    display.run("xdotool", &["type", "--delay", "30", text]);
    program.settle();
}

/// Waits for a file that is read without fault.
fn wait_for<T>(what: &str, path: &Path, read: impl Fn(&Path) -> Option<T>) -> T {
    wait(what, || path.is_file().then(|| read(path)).flatten())
}

#[test]
fn a_design_made_by_pointer_and_keys_is_saved_exported_and_opened_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let preset = small_preset(folder.path());
    let chart = folder.path().join("two halves.png");
    image::RgbImage::from_fn(24, 24, |x, _| {
        image::Rgb(if x < 12 {
            [30, 60, 160]
        } else {
            [240, 240, 230]
        })
    })
    .save(&chart)
    .expect("written");
    let mut twin = twin(&preset);

    let display = Display::start("1280x720x24");
    let arguments = [&*preset.to_string_lossy(), "--backend", "cpu"];
    let program = Program::start(
        &display,
        folder.path(),
        &arguments,
        "small - Towel Designer",
        SIZE,
    );
    program.wait_for_rest();

    // Paint a stroke of loops over the near row of the pattern.
    let cells = [0, 1].map(|col| designer::cell(&twin, col, 0));
    drag(&display, &program, cells[0], &cells);
    wait("the unsaved mark", || {
        display.window("small\\* - Towel Designer")
    });
    // Set the loops closer.
    let slider = twin.get_by_role_and_label(Role::Slider, "Warps per cm");
    let rail = slider.rect();
    let [from, to] = [0.25, 0.35].map(|share| rail.left_center() + vec2(share * rail.width(), 0.0));
    drag(&display, &program, from, &[to]);
    // Drop a chart on the cloth.
    let window = program.window.parse().expect("a number");
    drop_file(&display.name, window, [700, 400], &chart, PATIENCE);
    let shot = folder.path().join("shot.png");
    wait("blue cloth", || {
        let picture = display.photograph(&shot);
        let blue = picture
            .enumerate_pixels()
            .filter(|(x, y, p)| {
                (400..1050).contains(x) && (100..650).contains(y) && p[2] > 60 && p[0] < p[2] / 2
            })
            .count();
        (blue > 1000).then_some(())
    });

    display.xdotool("key ctrl+s");
    wait("the saved mark", || {
        display.window("small - Towel Designer")
    });
    let saved = files::load_design(&preset).expect("a preset");
    assert_eq!(
        [0, 1].map(|col| saved.weave.pattern.at(col, 0)),
        [7, 7],
        "what was painted is saved"
    );
    // The default is 13.3; the rail's share 0.35 lies well above.
    assert!(saved.sheet.warps_per_cm > 16.0, "{:?}", saved.sheet);
    assert_eq!(saved.chart.image.as_deref(), Some("two halves.png"));

    // Export what is seen.
    display.xdotool("key ctrl+e");
    program.settle();
    twin.key_press_modifiers(Modifiers::COMMAND, Key::E);
    twin.run_steps(20);
    for (field, value) in [("Export width", "96"), ("Export height", "64")] {
        let at = twin.get_by_role_and_label(Role::SpinButton, field).rect();
        click(&display, &program, at.center());
        type_instead(&display, &program, value);
        display.xdotool("key Return");
        program.settle();
    }
    let button = twin.get_by_label("Choose file and export…").rect();
    click(&display, &program, button.center());
    // The system's dialog is waited for first.
    std::thread::sleep(Duration::from_secs(1));
    program.settle();
    let exported = folder.path().join("exported.png");
    type_instead(&display, &program, &exported.to_string_lossy());
    display.xdotool("key Return");
    let exported = wait_for("the exported picture", &exported, |path| {
        image::open(path).ok().map(image::DynamicImage::into_rgb8)
    });
    program.wait_for_rest();
    let before = display.photograph(&shot);
    program.quit(&display);

    // The same program without a window makes the same picture of what was saved.
    let rendered = folder.path().join("rendered.png");
    let status = std::process::Command::new(env!("CARGO_BIN_EXE_towel-designer"))
        .args(["render", &preset.to_string_lossy(), "--backend", "cpu"])
        .args(["--size", "96x64", "--quiet", "-o"])
        .arg(&rendered)
        .status()
        .expect("the program starts");
    assert!(status.success(), "{status:?}");
    let rendered = image::open(&rendered).expect("a picture").into_rgb8();
    assert!(
        exported == rendered,
        "exported and rendered pictures differ: {:?}, {:?}",
        exported.dimensions(),
        rendered.dimensions()
    );

    // Opened again, the window shows what it showed.
    let program = Program::start(
        &display,
        folder.path(),
        &arguments,
        "small - Towel Designer",
        SIZE,
    );
    program.wait_for_rest();
    let after = display.photograph(&shot);
    let cloth = [400, 150, 600, 400];
    let differing = difference(&before, &after, cloth);
    assert!(differing < 0.01, "{differing} of the cloth's pixels differ");
    assert!(
        difference(&before, &image::imageops::flip_horizontal(&after), cloth) > 0.05,
        "the comparison sees no difference where there is one"
    );
    program.quit(&display);
}

/// Share of the pixels of a part that differ between two pictures.
fn difference(a: &image::RgbImage, b: &image::RgbImage, [x, y, width, height]: [u32; 4]) -> f64 {
    let part = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    let differing = part.filter(|&(x, y)| a.get_pixel(x, y) != b.get_pixel(x, y));
    differing.count() as f64 / f64::from(width * height)
}
