//! Programs that are killed while they write: whatever moment it is, each file is the old one or the new one, and what
//! is left lying is gone after the next run.
//!
//! A moment is a call that changes something on the disk, one by one or in the middle of a write: between them a kill
//! changes nothing. Which of them, is drawn by chance from a fixed seed. TOWEL_KILLS says how many, 40 unless it is set.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use renderer_core::design::chart_edit::draw_line;
use renderer_core::design::{ChartImage, Design};
use tempfile::TempDir;
use towel_designer::files::{
    self, AutosaveFile, Carried, OwnImages, Packer, RecoveryFile, Unsaved,
};

use crate::support::faults::{Fault, with_faults};
use crate::support::folders::names_in;

/// Names the folder of a child that plays a part of the program.
const FOLDER: &str = "TOWEL_CHILD_FOLDER";

const SMALL: &str = "format = 1\nsheet = { warps = 12, wefts = 10 }\nchart.image = 'chart.png'\n\
                     pile = { variants = 2, layers = 3, resolution = 8 }\n\
                     quality = { method = 'single', bounces = 1, samples = 1 }\n";

/// A process that runs one of the parts below in `folder`.
pub(crate) fn child(part: &str, folder: &Path) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--exact", &format!("killed::part_{part}"), "--nocapture"])
        .env(FOLDER, folder);
    command
}

/// The folder of this process, if it is such a child.
fn folder_of_child() -> Option<PathBuf> {
    std::env::var_os(FOLDER).map(PathBuf::from)
}

/// A design that says by its warps which it is, with a chart that was painted here.
pub(crate) fn painted(warps: u32) -> Design {
    let mut design = Design::default();
    design.sheet.warps = warps;
    let mut pixels = ChartImage::filled(300, 200, [255; 4]).unwrap();
    for k in 0..60 {
        let colour = [warps as u8, 4 * k as u8, 255 - k as u8, 255];
        draw_line(&mut pixels, [3 * k, 4], [299 - k, 190], 2, colour);
    }
    design.chart.pixels = Some(pixels);
    design
}

fn warps(design: &Design) -> u32 {
    design.sheet.warps
}

/// Saves a design over an older one, as a preset with its chart and as a bundle.
#[test]
fn part_saves() {
    let Some(folder) = folder_of_child() else {
        return;
    };
    let none = Carried::default();
    for name in ["design.toml", "design.towel"] {
        let to = folder.join(name);
        let known = OwnImages::default();
        files::save_edited(&painted(77), &none, &to, None, &known).expect("saved");
    }
}

/// Keeps an unsaved design, twice.
#[test]
fn part_keeps() {
    let Some(folder) = folder_of_child() else {
        return;
    };
    let file = AutosaveFile::new(&folder).expect("a file");
    let mut packer = Packer::default();
    for warps in [31, 77] {
        let unsaved = Unsaved {
            design: painted(warps),
            carried: Carried::default(),
            path: None,
            name: None,
            stamp: None,
        };
        file.write(&unsaved, &mut packer).expect("kept");
    }
    // Nothing is given up: the process is about to end without saving.
    std::mem::forget(file);
}

/// Something to be killed.
struct Victim {
    /// What it is called here.
    name: &'static str,
    /// Makes the old files.
    prepare: fn(&Path),
    /// The program.
    program: fn(&Path) -> Command,
    /// Looks whether all files are old or new, and none is lost.
    check: fn(&Path),
    /// What lies in the folder after a run to the end.
    names: &'static [&'static str],
}

fn towel_designer(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_towel-designer"));
    command.current_dir(folder).args(arguments);
    command
}

fn write_small(folder: &Path) {
    fs::write(folder.join("small.toml"), SMALL).unwrap();
    let chart = image::RgbImage::from_fn(4, 4, |x, y| {
        image::Rgb([200, (60 * x) as u8, (60 * y) as u8])
    });
    chart.save(folder.join("chart.png")).unwrap();
}

fn check_small(folder: &Path) {
    files::load_design(&folder.join("small.toml")).expect("the design is as it was");
}

/// The file is what it was, or a whole new one.
fn old_or(folder: &Path, name: &str, is_new: impl Fn(&[u8]) -> bool) {
    let bytes = fs::read(folder.join(name)).unwrap();
    assert!(
        bytes == b"old" || is_new(&bytes),
        "{name} is neither old nor new"
    );
}

const VICTIMS: [Victim; 5] = [
    Victim {
        name: "render",
        prepare: |folder| {
            write_small(folder);
            fs::write(folder.join("a.png"), "old").unwrap();
            fs::write(folder.join("a.json"), "old").unwrap();
        },
        program: |folder| {
            let arguments =
                "render small.toml -o a.png --stats a.json --size 400x300 --depth 16 --backend cpu";
            towel_designer(folder, &arguments.split(' ').collect::<Vec<_>>())
        },
        check: |folder| {
            check_small(folder);
            old_or(folder, "a.png", |bytes| {
                image::load_from_memory(bytes).is_ok()
            });
            old_or(folder, "a.json", |bytes| {
                serde_json::from_slice::<serde_json::Value>(bytes).is_ok()
            });
        },
        names: &["a.json", "a.png", "chart.png", "small.toml"],
    },
    Victim {
        name: "export loops",
        prepare: |folder| {
            write_small(folder);
            fs::write(folder.join("loops.json"), "old").unwrap();
        },
        program: |folder| {
            towel_designer(
                folder,
                &["export", "loops", "small.toml", "-o", "loops.json"],
            )
        },
        check: |folder| {
            check_small(folder);
            old_or(folder, "loops.json", |bytes| {
                serde_json::from_slice::<serde_json::Value>(bytes).is_ok()
            });
        },
        names: &["chart.png", "loops.json", "small.toml"],
    },
    Victim {
        name: "export volume",
        prepare: write_small,
        program: |folder| towel_designer(folder, &["export", "volume", "small.toml", "-o", "."]),
        check: |folder| {
            check_small(folder);
            for name in names_in(folder) {
                if name.starts_with("terry") {
                    image::open(folder.join(name)).expect("a whole layer");
                }
            }
        },
        names: &[
            "chart.png",
            "small.toml",
            "terry-variant-00-layer-00.png",
            "terry-variant-00-layer-01.png",
            "terry-variant-00-layer-02.png",
            "terry-variant-01-layer-00.png",
            "terry-variant-01-layer-01.png",
            "terry-variant-01-layer-02.png",
        ],
    },
    Victim {
        name: "save",
        prepare: |folder| {
            for name in ["design.toml", "design.towel"] {
                files::save(&painted(31), &Carried::default(), &folder.join(name), None).unwrap();
            }
        },
        program: |folder| child("saves", folder),
        check: |folder| {
            for name in ["design.toml", "design.towel"] {
                let design = files::load_design(&folder.join(name)).expect("it opens");
                assert!([31, 77].contains(&warps(&design)));
                let pixels = &design.chart.pixels;
                let known = [painted(31), painted(77)].map(|design| design.chart.pixels);
                assert!(known.contains(pixels), "{name} has another chart");
            }
        },
        names: &["design-chart.png", "design.toml", "design.towel"],
    },
    Victim {
        name: "keep",
        prepare: |_| {},
        program: |folder| child("keeps", folder),
        check: |folder| {
            // Before the first is whole there is none.
            let Some(left) = RecoveryFile::find(folder) else {
                return;
            };
            let unsaved = left.read().expect("it is whole");
            assert!([31, 77].contains(&warps(&unsaved.design)));
            assert!(unsaved.design.chart.pixels.is_some());
        },
        names: &[],
    },
];

fn run(victim: &Victim, folder: &Path, faults: &[Fault<'_>]) -> Output {
    let mut program = (victim.program)(folder);
    with_faults(&mut program, folder, faults).output().unwrap()
}

/// How many calls of a victim change something on the disk.
fn calls(victim: &Victim, way: &[Fault<'_>]) -> u64 {
    let folder = TempDir::new().unwrap();
    (victim.prepare)(folder.path());
    let counted = TempDir::new().unwrap();
    let file = counted.path().join("count");
    let done = run(
        victim,
        folder.path(),
        &[way, &[Fault::Count(&file)]].concat(),
    );
    let errors = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{}: {errors}", victim.name);
    let count = fs::read_to_string(file).unwrap().parse().unwrap();
    assert!(count >= 4, "{}: {count} calls", victim.name);
    count
}

#[test]
fn a_kill_at_any_moment_harms_no_file() {
    let kills: u64 =
        std::env::var("TOWEL_KILLS").map_or(40, |kills| kills.parse().expect("a number"));
    let ways: [&[Fault<'_>]; 2] = [&[], &[Fault::Named]];
    let mut state = 15_u64;
    let mut random = |below: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) % below
    };
    let counts: Vec<[u64; 2]> = VICTIMS
        .iter()
        .map(|victim| ways.map(|way| calls(victim, way)))
        .collect();
    let mut left_behind = 0;
    for kill in 0..kills {
        let which = kill as usize % VICTIMS.len();
        let (victim, way) = (&VICTIMS[which], random(2) as usize);
        let moment = 1 + random(counts[which][way]);
        let folder = TempDir::new().unwrap();
        let folder = folder.path();
        (victim.prepare)(folder);
        let faults = [ways[way], &[Fault::Kill(moment)]].concat();
        let ended = run(victim, folder, &faults);
        let what = format!("{} killed by {faults:?}", victim.name);
        assert_eq!(
            std::os::unix::process::ExitStatusExt::signal(&ended.status),
            Some(9),
            "{what}"
        );
        eprintln!("{what}: {:?}", names_in(folder));
        (victim.check)(folder);
        let drafts = names_in(folder)
            .iter()
            .filter(|name| name.starts_with(".towel-draft-"))
            .count();
        left_behind += drafts;
        // The next run does its work, and clears up.
        let done = run(victim, folder, &[]);
        assert!(
            done.status.success(),
            "{what}: {}",
            String::from_utf8_lossy(&done.stderr)
        );
        (victim.check)(folder);
        let after = names_in(folder);
        if victim.names.is_empty() {
            assert!(
                !after.iter().any(|name| name.starts_with(".towel-draft-")),
                "{what}: {after:?}"
            );
        } else {
            assert_eq!(after, victim.names, "{what}");
        }
    }
    // The kills were where it matters: some between the making of a draft and its new name.
    assert!(
        left_behind >= kills as usize / 10,
        "only {left_behind} drafts of {kills} kills"
    );
}
