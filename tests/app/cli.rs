//! The command line end to end: the real program is run, on a machine without Vulkan unless a test says otherwise.
//!
//! Presets here are a few loops wide, so that a run takes a fraction of a second.
//! Longer than most files because all subcommands share one bench and one small preset.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use exr::prelude::{ReadChannels, ReadLayers};
use tempfile::TempDir;

use crate::support::picture_files::jpeg_of_blocks;

/// A folder with a preset of a few loops.
struct Bench {
    folder: TempDir,
}

const SMALL: &str = "format = 1
[sheet]
warps = 12
wefts = 10
[chart]
image = 'chart.png'
[pile]
variants = 2
layers = 3
resolution = 8
base_width = 2.4
top_width = 2.4
[view]
cameras = [{ name = 'above', distance = 25 }, { name = 'side', distance = 25, elevation = 20 }]
[quality]
method = 'single'
bounces = 1
samples = 2
";

impl Bench {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("small.toml"), SMALL).unwrap();
        let chart = image::RgbaImage::from_fn(4, 4, |x, y| {
            image::Rgba([200, (x * 60) as u8, (y * 60) as u8, 255])
        });
        chart.save(folder.path().join("chart.png")).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the program in the folder.
    fn run(&self, arguments: &[&str]) -> Output {
        program(self.folder.path())
            .args(arguments)
            .output()
            .unwrap()
    }

    /// Runs it, and requires that it succeeds and prints nothing to stdout.
    fn ok(&self, arguments: &[&str]) -> Output {
        let output = self.run(arguments);
        let errors = text(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {errors}");
        assert_eq!(text(&output.stdout), "", "{arguments:?}");
        output
    }

    /// Runs it, and requires this exit code, a message that holds all of `says`, and no new file.
    fn fails(&self, code: i32, arguments: &[&str], says: &[&str]) {
        let before = self.names();
        let output = self.run(arguments);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {errors}");
        for part in says {
            assert!(
                errors.contains(part),
                "{arguments:?}: no {part:?} in: {errors}"
            );
        }
        assert_eq!(text(&output.stdout), "", "{arguments:?}");
        assert_eq!(self.names(), before, "{arguments:?}");
    }

    fn names(&self) -> Vec<PathBuf> {
        let mut names: Vec<_> = fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        names.sort();
        names
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }
}

/// The program, where no Vulkan driver can be found.
fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_towel-designer"));
    command
        .current_dir(folder)
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env("VK_DRIVER_FILES", "/nonexistent");
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Channels of an EXR file by name, row by row.
fn exr_channels(path: &Path) -> ((usize, usize), BTreeMap<String, Vec<f32>>) {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let size = (image.layer_data.size.0, image.layer_data.size.1);
    let channels = image.layer_data.channel_data.list.iter().map(|channel| {
        let values = channel.sample_data.values_as_f32().collect();
        (channel.name.to_string(), values)
    });
    (size, channels.collect())
}

#[test]
fn renders_a_png_of_the_size_asked_for_without_vulkan() {
    let bench = Bench::new();
    bench.ok(&["render", "small.toml", "-o", "a.png", "--size", "40x30"]);
    let picture = image::open(bench.path("a.png")).unwrap();
    assert_eq!(picture.color(), image::ColorType::Rgb8);
    let picture = picture.into_rgb8();
    assert_eq!(picture.dimensions(), (40, 30));
    let colours: std::collections::HashSet<_> = picture.pixels().collect();
    assert!(colours.len() > 50, "only {} colours", colours.len());
}

#[test]
fn png_has_the_depth_and_alpha_asked_for() {
    let bench = Bench::new();
    let sized = ["render", "small.toml", "--size", "20x20"];
    let render = |more: &[&str]| bench.ok(&[&sized[..], more].concat());
    render(&["-o", "a.png", "--depth", "16"]);
    let deep = image::open(bench.path("a.png")).unwrap();
    assert_eq!(deep.color(), image::ColorType::Rgb16);
    render(&["-o", "b.png", "--transparent"]);
    let clear = image::open(bench.path("b.png")).unwrap();
    assert_eq!(clear.color(), image::ColorType::Rgba8);
    let clear = clear.into_rgba8();
    // The sheet is 9 x 7 mm, and the picture 13 mm high: cloth in the middle, none in the corner.
    assert_eq!(clear.get_pixel(0, 0).0, [0, 0, 0, 0]);
    assert!(clear.get_pixel(10, 10).0[3] > 200);
    render(&["-o", "c.png"]);
    let opaque = image::open(bench.path("c.png")).unwrap().into_rgb8();
    // The default background.
    assert_eq!(opaque.get_pixel(0, 0).0, [0xf7, 0xf6, 0xf0]);
}

#[test]
fn same_preset_and_seed_give_the_same_bytes_and_another_seed_others() {
    let bench = Bench::new();
    for extension in ["png", "exr"] {
        let render = |name: &str, seed: &str| {
            let file = format!("{name}.{extension}");
            bench.ok(&[
                "render",
                "small.toml",
                "-o",
                &file,
                "--size",
                "40x30",
                "--seed",
                seed,
            ]);
            bench.read(&file)
        };
        let first = render("a", "7");
        assert_eq!(render("b", "7"), first);
        assert_ne!(render("c", "8"), first);
    }
}

#[test]
fn a_crop_is_that_part_of_the_whole_picture() {
    let bench = Bench::new();
    let render = |more: &[&str]| {
        bench.ok(&[&["render", "small.toml", "--size", "40x30"], more].concat());
    };
    render(&["-o", "whole.exr"]);
    render(&["-o", "part.exr", "--crop", "11,7,19,13"]);
    let (size, whole) = exr_channels(&bench.path("whole.exr"));
    assert_eq!(size, (40, 30));
    let (size, part) = exr_channels(&bench.path("part.exr"));
    assert_eq!(size, (19, 13));
    for (name, values) in &part {
        let rows = (7..7 + 13).flat_map(|y| &whole[name][y * 40 + 11..y * 40 + 11 + 19]);
        assert!(rows.eq(values), "channel {name}");
    }
}

#[test]
fn exr_holds_linear_light_whatever_the_display_and_the_layers_asked_for() {
    let bench = Bench::new();
    let render = |more: &[&str]| {
        bench.ok(&[&["render", "small.toml", "--size", "20x20"], more].concat());
    };
    render(&["-o", "a.exr"]);
    render(&[
        "-o",
        "b.exr",
        "--set",
        "view.exposure=2",
        "--set",
        "view.tone_map=filmic",
    ]);
    assert_eq!(bench.read("a.exr"), bench.read("b.exr"));
    let (_, plain) = exr_channels(&bench.path("a.exr"));
    assert_eq!(plain.keys().collect::<Vec<_>>(), ["B", "G", "R"]);

    render(&["-o", "c.exr", "--aov", "albedo,depth,normal,alpha"]);
    let (_, layers) = exr_channels(&bench.path("c.exr"));
    let names = [
        "B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "alpha.A", "depth.Z", "normal.X",
        "normal.Y", "normal.Z",
    ];
    assert_eq!(layers.keys().collect::<Vec<_>>(), names);
    assert_eq!(layers["R"], plain["R"]);
    let (corner, middle) = (0, 10 * 20 + 10);
    assert_eq!(
        [layers["alpha.A"][corner], layers["depth.Z"][corner]],
        [0.0; 2]
    );
    assert!(layers["alpha.A"][middle] > 0.5);
    // The eye is 25 mm from the sheet, and the pile a few mm high.
    assert!((20.0..26.0).contains(&layers["depth.Z"][middle]));

    render(&["-o", "d.exr", "--transparent"]);
    let (_, clear) = exr_channels(&bench.path("d.exr"));
    assert_eq!(clear.keys().collect::<Vec<_>>(), ["A", "B", "G", "R"]);
    assert_eq!([clear["R"][corner], clear["A"][corner]], [0.0; 2]);
    let alpha = clear["A"][middle];
    let background = 0xf7 as f32 / 255.0;
    let background = ((background + 0.055) / 1.055).powf(2.4);
    // Premultiplied light and the background through the gaps are the opaque picture, up to rounding to f32.
    let whole = clear["R"][middle] + (1.0 - alpha) * background;
    assert!((whole - plain["R"][middle]).abs() < 1e-5);
}

#[test]
fn stats_say_what_was_done() {
    let bench = Bench::new();
    let common = [
        "render",
        "small.toml",
        "-o",
        "a.png",
        "--size",
        "20x10",
        "--samples",
        "16",
    ];
    bench.ok(&[&common[..], &["--stats", "plain.json"]].concat());
    let stats = bench.json("plain.json");
    let keys = |value: &serde_json::Value| -> Vec<String> {
        value.as_object().unwrap().keys().cloned().collect()
    };
    let expected = [
        "adapter",
        "backend",
        "bands",
        "bytes",
        "compile",
        "crop",
        "denoised",
        "dropped_loops",
        "error_estimate",
        "loops",
        "method",
        "nonfinite_pixels",
        "processor_seconds",
        "samples",
        "seconds",
        "size",
        "version",
    ];
    assert_eq!(keys(&stats), expected);
    assert_eq!(stats["backend"], "cpu");
    assert_eq!(stats["method"], "single");
    assert_eq!(stats["size"], serde_json::json!([20, 10]));
    assert_eq!(stats["samples"], 16);
    // The default checker plants every second crossing of 12 x 10, on both faces.
    assert_eq!(stats["loops"], 120);
    assert_eq!(stats["nonfinite_pixels"], 0);
    assert!(stats["error_estimate"].as_f64().unwrap() > 0.0);
    // Shape and look take 24 bytes.
    assert!(stats["bytes"]["scene"].as_u64().unwrap() > 120 * 24);
    assert!(stats["bytes"]["per_loop"].as_f64().unwrap() > 24.0);
    assert_eq!(stats["bytes"]["gpu_total"], 0);
    let parts = [
        "compile",
        "first_image",
        "open",
        "pipelines",
        "render",
        "total",
        "upload",
        "write",
    ];
    assert_eq!(keys(&stats["seconds"]), parts);
    let seconds = |part: &str| stats["seconds"][part].as_f64().unwrap();
    let sum: f64 = ["open", "compile", "upload", "pipelines", "render", "write"]
        .map(seconds)
        .iter()
        .sum();
    assert!(parts.iter().all(|part| seconds(part) > 0.0));
    assert!(seconds("total") >= sum && seconds("first_image") <= seconds("total"));

    bench.ok(&[&common[..], &["--stats", "counted.json", "--counters"]].concat());
    let counters = &bench.json("counted.json")["counters"];
    let names = [
        "cached_rays",
        "cells",
        "contributing_hits",
        "converged_tiles",
        "ended_rays",
        "hidden_rays",
        "patch_tests",
        "rays",
        "repeated_tests",
        "shadow_rays",
        "skipped_cells",
        "skipped_tiles",
        "volume_samples",
    ];
    assert_eq!(keys(counters), names);
    // One bounce: a ray a sample, and at most one more that looks for the environment.
    let rays = counters["rays"].as_u64().unwrap();
    assert!((3200..=6400).contains(&rays), "{rays}");
}

#[test]
fn the_first_target_reached_ends_the_picture() {
    let bench = Bench::new();
    let samples = |more: &[&str]| {
        let common = [
            "render",
            "small.toml",
            "-o",
            "a.png",
            "--size",
            "12x12",
            "--stats",
            "s.json",
        ];
        bench.ok(&[&common[..], more].concat());
        bench.json("s.json")["samples"].as_u64().unwrap()
    };
    assert_eq!(samples(&[]), 2, "the preset's quality");
    assert_eq!(samples(&["--samples", "8"]), 8);
    assert_eq!(samples(&["--set", "quality.samples=3"]), 3);
    let by_error = samples(&["--error", "0.3"]);
    assert!((4..4096).contains(&by_error), "{by_error}");
    assert_eq!(samples(&["--error", "0.3", "--samples", "3"]), 3);
    assert!(samples(&["--time", "0.3"]) > 2);
    assert_eq!(samples(&["--time", "60", "--samples", "5"]), 5);
    // Too short for anything: one whole sample all the same.
    assert!(samples(&["--time", "0.000001"]) >= 1);
}

#[test]
fn arguments_change_the_picture() {
    let bench = Bench::new();
    let mut seen = vec![];
    for more in [
        &[][..],
        &["--camera", "side"],
        &["--method", "layered"],
        &["--method", "tracked"],
        &["--method", "tracked", "--bounces", "4"],
        &["--set", "turbulence.seed=3"],
        &["--set", "chart.fit=tile"],
        &["--set", "view.exposure=0.5"],
    ] {
        bench.ok(&[
            &["render", "small.toml", "-o", "a.png", "--size", "20x20"],
            more,
        ]
        .concat());
        let bytes = bench.read("a.png");
        assert!(!seen.contains(&bytes), "{more:?} changes nothing");
        seen.push(bytes);
    }
    // The first camera is the one without --camera; `cpu` is what `auto` means here.
    let with = |more: [&str; 2]| {
        bench.ok(&[
            &["render", "small.toml", "-o", "a.png", "--size", "20x20"],
            &more[..],
        ]
        .concat());
        bench.read("a.png")
    };
    for more in [["--camera", "above"], ["--backend", "cpu"]] {
        assert_eq!(with(more), seen[0], "{more:?}");
    }
    // The reference draws the same samples: but for rounding, and one or two that rounding puts beside an edge, the
    // same.
    let pixels = |png: &[u8]| {
        image::load_from_memory(png)
            .unwrap()
            .into_rgba8()
            .into_raw()
    };
    let [of_reference, of_cpu] =
        [&with(["--backend", "reference"]), &seen[0]].map(|png| pixels(png));
    let pairs = of_reference.chunks(4).zip(of_cpu.chunks(4));
    let differ = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
    assert_eq!(of_reference.len(), of_cpu.len());
    assert!(pairs.filter(differ).count() <= 2);
}

#[test]
fn a_picture_of_the_surroundings_lights_the_cloth() {
    let bench = Bench::new();
    fs::create_dir(bench.path("skies")).unwrap();
    for (name, bright) in [("right", 8..12), ("left", 4..8)] {
        // The middle is beyond the far edge, so that its left lies to the left of who looks over it.
        let sky = image::GrayImage::from_fn(16, 8, |x, _| {
            image::Luma([255 * u8::from(bright.contains(&x))])
        });
        sky.save(bench.path(&format!("skies/{name}.png"))).unwrap();
        let text = SMALL
            .replace("'single'", "'tracked'")
            .replace("samples = 2", "samples = 128")
            + &format!(
                "[light]\nsun = []\nbackground = '#000000'\nenvironment = \
                 {{ kind = 'image', image = 'skies/{name}.png', radiance = 3 }}\n\
                 [skeleton]\nvisible = false\n"
            );
        let text = text.replace("base_width", "lean_x = 60\nbase_width");
        fs::write(bench.path(&format!("{name}.toml")), text).unwrap();
    }
    let mean = |arguments: &[&str]| -> f64 {
        let backend = [
            "--size",
            "24x24",
            "--set",
            "pile.phase=frame_lambert",
            "-o",
            "a.exr",
        ];
        bench.ok(&[&["render"], arguments, &backend[..]].concat());
        let image = exr::prelude::read_first_rgba_layer_from_file(
            bench.path("a.exr"),
            |_, _| 0.0,
            |sum: &mut f64, _, (r, g, b, _): (f32, f32, f32, f32)| *sum += f64::from(r + g + b),
        );
        image.unwrap().layer_data.channel_data.pixels / (3.0 * 24.0 * 24.0)
    };
    // Loops lean to the right, so that it matters where light comes from; a quarter turn makes one sky the other.
    for backend in ["cpu", "reference"] {
        let lit = |more: &[&str]| mean(&[more, &["--backend", backend]].concat());
        let left = lit(&["left.toml"]);
        let right = lit(&["right.toml"]);
        let turned = lit(&["left.toml", "--set", "light.environment.rotation=-90"]);
        let dark = lit(&["left.toml", "--set", "light.environment.radiance=0"]);
        assert!(
            left > dark && right > dark,
            "{left} and {right}, not {dark}"
        );
        assert!((left / right - 1.0).abs() > 0.02, "{left} and {right}");
        // Directions are drawn by the light, column by column: a turned picture gives other samples of the same mean,
        // here three in a thousand apart.
        assert!(
            (turned / right - 1.0).abs() < 0.012,
            "{turned}, not {right}"
        );
    }
}

#[test]
fn bad_presets_are_refused_with_file_place_value_and_what_is_allowed() {
    let bench = Bench::new();
    #[rustfmt::skip]
    let cases = [
        ("format = 1\n[pile]\ntilt = 200", &["bad.toml:3:8: pile.tilt is 200, allowed is 0 to 180"][..]),
        ("format = 1\n[pile]\ntlit = 2", &["bad.toml:3:1: pile.tlit is not a field; did you mean pile.tilt?"]),
        ("format = 1\n[view]\nexposure = nan", &["bad.toml:3:12: view.exposure is nan, allowed is -16 to 16 EV"]),
        ("format = 1\n[weave]\npattern = [[7, 0], [0, 5]]", &["bad.toml:3:24: weave.pattern[1][1] is 5, allowed is 0 \
            (weft over), 1 "]),
        ("format = 2", &["bad.toml:1:10: format is 2, newer than this program"]),
        ("format = 1\n[chart]\nimage = 'gone.png'", &["bad.toml:3:9: chart.image: gone.png: chart image: cannot be \
            read"]),
        ("format = 1\n[light]\nenvironment.kind = 'image'\nenvironment.image = 'gone.hdr'", &["bad.toml:4:21: light.environment.image: gone.hdr: environment image: cannot be read"]),
        ("format = 1\n[light.environment]\nimage = 'wide.png'\n[chart]\nimage = 'gone.png'", &["bad.toml:3:9: light.environment.image: wide.png: environment image: has 9000 x 1 pixels, allowed are at most 8192 x 4096", "bad.toml:5:9: chart.image: gone.png"]),
        ("format = 1\n[light.environment]\nkind = 'image'", &["bad.toml:2:1: light.environment.image is left out, \
            allowed is the path of an image"]),
        ("format = 1\n[chart]\nimage = 'bad.toml'", &["bad.toml: chart image: is none of PNG, JPEG, WebP"]),
        ("format = 1\n[chart]\nimage = 'cut.png'", &["cut.png: chart image: is broken"]),
        ("format = 1\n[chart]\nimage = 'wide.png'", &["wide.png: chart image: has 9000 x 1 pixels, allowed are at \
            most 8192 x 8192"]),
        ("format = 1\n[pile]\ntilt = 200\nplies = 0", &["bad.toml:3:8: ", "bad.toml:4:9: "]),
        ("format = \u{0}", &["bad.toml:1:"]),
    ];
    let chart = bench.read("chart.png");
    fs::write(bench.path("cut.png"), &chart[..chart.len() / 2]).unwrap();
    let wide = image::GrayImage::new(9000, 1);
    wide.save(bench.path("wide.png")).unwrap();
    for (preset, says) in cases {
        fs::write(bench.path("bad.toml"), preset).unwrap();
        bench.fails(2, &["render", "bad.toml", "-o", "x.png"], says);
        bench.fails(2, &["check", "bad.toml"], says);
        bench.fails(2, &["export", "loops", "bad.toml", "-o", "x.json"], says);
    }
    fs::write(bench.path("bad.toml"), b"format = 1 # \xff").unwrap();
    bench.fails(
        2,
        &["render", "bad.toml", "-o", "x.png"],
        &["bad.toml: is no preset: a preset is UTF-8 text"],
    );
    bench.fails(
        2,
        &["render", "gone.toml", "-o", "x.png"],
        &["gone.toml: cannot be read: No such file"],
    );
}

#[test]
fn bad_arguments_are_refused_with_value_and_what_is_allowed() {
    let bench = Bench::new();
    #[rustfmt::skip]
    let cases = [
        (2, "-o x.png --size 0x0", &["'0x0'", "--size", "allowed is WIDTHxHEIGHT, each 1 to 16384 pixels"][..]),
        (2, "-o x.png --size 16385x1", &["'16385x1'", "each 1 to 16384 pixels"]),
        (2, "-o x.png --size 10", &["'10'", "WIDTHxHEIGHT"]),
        (2, "-o x.png --size 99999999999x1", &["'99999999999x1'", "WIDTHxHEIGHT"]),
        (2, "-o x.png --size 20x20 --crop 0,0,0,5", &["crop is 0,0,0,5", "inside 20x20"]),
        (2, "-o x.png --size 20x20 --crop 10,10,11,5", &["crop is 10,10,11,5", "inside 20x20"]),
        (2, "-o x.png --size 20x20 --crop 4294967295,0,2,2", &["crop is 4294967295,0,2,2", "inside 20x20"]),
        (2, "-o x.png --crop 1,2,3", &["'1,2,3'", "allowed is X,Y,WIDTH,HEIGHT"]),
        (2, "-o x.png --samples 0", &["'0'", "1..=1048576"]),
        (2, "-o x.png --samples -1", &["'-1'", "1..=1048576"]),
        (2, "-o x.png --bounces 65", &["'65'", "1..=64"]),
        (2, "-o x.png --error 0", &["'0'", "above 0, up to 1"]),
        (2, "-o x.png --error nan", &["'nan'", "above 0, up to 1"]),
        (2, "-o x.png --time -2", &["'-2'", "seconds above 0"]),
        (2, "-o x.png --time inf", &["'inf'", "seconds above 0"]),
        (2, "-o x.png --method six", &["'six'", "\"single\", \"layered\", \"exact\", \"six-face\" or \"tracked\""]),
        (2, "-o x.png --backend abacus", &["'abacus'", "auto, gpu, cpu, reference"]),
        (2, "-o x.png --camera behind", &["small.toml: there is no camera \"behind\", allowed are \"above\", \
            \"side\""]),
        (2, "-o x.png --set pile.tlit=3", &["--set pile.tlit=3: pile.tlit is not a field; did you mean pile.tilt?"]),
        (2, "-o x.png --set pile.tilt=181", &["pile.tilt is 181, allowed is 0 to 180"]),
        (2, "-o x.png --set pile.tilt", &["'pile.tilt'", "allowed is PATH=VALUE"]),
        (2, "-o x.png --set length.min=99", &["small.toml: with what was set, length.min is 99, allowed is at most \
            length.max"]),
        (2, "-o x.png --set chart.image=gone.png", &["error: gone.png: chart image: cannot be read"]),
        (2, "-o x.png --set light.environment.image=gone.hdr", &["error: gone.hdr: environment image: cannot be read"]),
        (2, "-o x.png --set light.environment.kind=image", &["light.environment.image is left out"]),
        (2, "-o x.png --depth 12", &["'12'", "8, 16"]),
        (2, "-o x.exr --depth 16", &["--depth is for .png files"]),
        (2, "-o x.png --aov depth", &["--aov needs an .exr file, but the output is x.png"]),
        (2, "-o x.exr --aov depht", &["'depht'", "depth, normal, albedo, alpha"]),
        (2, "-o x.png --counters", &["--stats"]),
        (2, "-o x.png --no-skip all", &["--no-optimisation"]),
        (2, "-o x.jpg", &["the output is x.jpg, allowed are names that end in .png or .exr"]),
        (2, "-o x", &["the output is x, allowed are names that end in .png or .exr"]),
        (2, "", &["--output"]),
        (1, "-o gone/x.png", &["gone/x.png: cannot be written: there is no directory gone"]),
        (1, "-o folder.png", &["folder.png: cannot be written: is a directory"]),
        (1, "-o x.png --stats gone/x.json", &["gone/x.json: cannot be written"]),
    ];
    fs::create_dir(bench.path("folder.png")).unwrap();
    for (code, arguments, says) in cases {
        let arguments: Vec<&str> = ["render", "small.toml"]
            .into_iter()
            .chain(arguments.split_whitespace())
            .collect();
        bench.fails(code, &arguments, says);
    }
    bench.fails(
        2,
        &["export", "loops", "small.toml", "-o", "x.stl"],
        &["x.stl, allowed are names that end in .json or .glb"],
    );
    bench.fails(
        2,
        &["export", "turbulence", "small.toml", "-o", "x.png"],
        &["x.png, allowed are names that end in .exr"],
    );
    bench.fails(
        1,
        &["export", "volume", "small.toml", "-o", "chart.png"],
        &["chart.png: cannot be written: is a file"],
    );
    bench.fails(
        1,
        &["export", "volume", "small.toml", "-o", "gone/x"],
        &["gone/x: cannot be written"],
    );
    bench.fails(
        2,
        &["rendr", "small.toml", "-o", "x.png"],
        &["rendr: there is no such preset, nor such a command"],
    );
    bench.fails(
        2,
        &["rendr"],
        &[
            "rendr: there is no such preset, nor such a command; commands are render, check, export, info",
        ],
    );
}

#[test]
fn an_unwritable_output_is_found_before_rendering() {
    let bench = Bench::new();
    // Without a device, which is asked for after that.
    bench.fails(
        1,
        &[
            "render",
            "small.toml",
            "-o",
            "gone/x.png",
            "--backend",
            "gpu",
        ],
        &["gone/x.png"],
    );
    bench.fails(
        1,
        &[
            "render",
            "small.toml",
            "-o",
            "x.png",
            "--stats",
            "gone/x",
            "--backend",
            "gpu",
        ],
        &["gone/x"],
    );
}

#[test]
fn gpu_without_a_driver_says_what_to_install() {
    let bench = Bench::new();
    bench.fails(
        1,
        &["render", "small.toml", "-o", "x.png", "--backend", "gpu"],
        &["no GPU adapter", "mesa-vulkan-drivers", "--backend cpu"],
    );
}

#[test]
fn the_gpu_renders_the_same_cloth() {
    let bench = Bench::new();
    let common = [
        "render",
        "small.toml",
        "--size",
        "16x12",
        "--samples",
        "16",
        "--stats",
        "s.json",
    ];
    let mut pictures = vec![];
    for backend in ["cpu", "gpu"] {
        let file = format!("{backend}.exr");
        // With the machine's own drivers.
        let output = Command::new(env!("CARGO_BIN_EXE_towel-designer"))
            .current_dir(bench.folder.path())
            .args(common)
            .args(["-o", &file, "--backend", backend])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let stats = bench.json("s.json");
        assert_eq!(stats["backend"], backend);
        let on_device = stats["bytes"]["gpu_total"].as_u64().unwrap();
        assert_eq!(on_device > 0, backend == "gpu");
        let (_, channels) = exr_channels(&bench.path(&file));
        let mean = |name: &str| channels[name].iter().sum::<f32>() / (16.0 * 12.0);
        pictures.push(["R", "G", "B"].map(mean));
    }
    for (cpu, gpu) in pictures[0].iter().zip(pictures[1]) {
        // Both draw the same samples, in f64 and f32: a few rays of 3072 may meet another loop.
        assert!((gpu - cpu).abs() < 0.01 * cpu, "{pictures:?}");
    }
}

#[test]
fn check_names_the_sound_and_every_fault() {
    let bench = Bench::new();
    fs::write(
        bench.path("bad.toml"),
        "format = 1\npile = 3\n[sheet]\nwarps = 0",
    )
    .unwrap();
    let output = bench.run(&["check", "bad.toml", "small.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(&output.stdout), "small.toml: ok\n");
    let errors = text(&output.stderr);
    assert!(
        errors.contains("bad.toml:2:8: pile is 3")
            && errors.contains("bad.toml:4:9: sheet.warps is 0"),
        "{errors}"
    );
    assert_eq!(bench.run(&["check", "small.toml"]).status.code(), Some(0));
}

#[test]
fn what_is_wrong_with_an_image_that_opens_is_told_on_stderr_by_every_command() {
    let bench = Bench::new();
    let jpeg = jpeg_of_blocks(&[&[90], &[200]]);
    fs::write(bench.path("chart.png"), &jpeg[..jpeg.len() - 2]).unwrap();
    let says = "warning: chart.png: chart image: ends in the middle of its picture: what is missing is grey or blurred\n";
    for arguments in [
        &["check", "small.toml"][..],
        &[
            "render",
            "small.toml",
            "-o",
            "s.png",
            "--size",
            "8x8",
            "--samples",
            "1",
        ],
        &["export", "loops", "small.toml", "-o", "l.json"],
    ] {
        let output = bench.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        let errors = text(&output.stderr);
        assert!(errors.contains(says), "{arguments:?}: {errors}");
    }
}

#[test]
fn loops_are_exported_whole_and_alike_in_both_formats() {
    let bench = Bench::new();
    bench.ok(&["export", "loops", "small.toml", "-o", "loops.json"]);
    bench.ok(&["export", "loops", "small.toml", "-o", "loops.glb"]);
    let json = bench.json("loops.json");
    let loops = json["loops"].as_array().unwrap();
    assert_eq!(loops.len(), 120);
    let vector =
        |value: &serde_json::Value| -> [f64; 3] { serde_json::from_value(value.clone()).unwrap() };
    let pitch: [f64; 2] = serde_json::from_value(json["pitch"].clone()).unwrap();
    for record in loops {
        let [i, j]: [u32; 2] = serde_json::from_value(record["cell"].clone()).unwrap();
        assert_eq!((i + j) % 2, 0);
        let [p0, p1] = ["p0", "p1"].map(|p| vector(&record[p]));
        // The root's middle is the cell's centre (MODEL.md §4), to the six decimals of the file.
        let centre = [f64::from(i) + 0.5 - 6.0, f64::from(j) + 0.5 - 5.0];
        for axis in 0..2 {
            let middle = (p0[axis] + p1[axis]) / 2.0;
            assert!((middle - centre[axis] * pitch[axis]).abs() < 2e-6);
        }
        let normal = vector(&record["normal"]);
        let squared: f64 = normal.iter().map(|c| c * c).sum();
        assert!((squared - 1.0).abs() < 1e-5);
        // Row 0 of the chart is the far edge, and red is 200 everywhere.
        let (x, y) = ((2 * i + 1) * 4 / 24, (2 * (10 - j) - 1) * 4 / 20);
        assert_eq!(record["colour"], format!("#c8{:02x}{:02x}", x * 60, y * 60));
        assert!(record["length"].as_f64().unwrap() > 0.5);
        let variant = record["variant"].as_u64().unwrap();
        assert!(variant < 2);
        assert_eq!(record["volume"], format!("terry-variant-{variant:02}"));
        assert_eq!(record["kind"], "terry");
        assert_eq!(record["phase"], "isotropic");
        assert_eq!(record["density"].as_f64(), Some(10.0));
        assert!(record.get("transmission").is_none() && record.get("specular").is_none());
        assert!(["front", "back"].contains(&record["face"].as_str().unwrap()));
    }

    let glb = bench.read("loops.glb");
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    let json_length = word(12);
    assert_eq!(&glb[16..20], b"JSON");
    let head: serde_json::Value = serde_json::from_slice(&glb[20..20 + json_length]).unwrap();
    let binary = 20 + json_length;
    assert_eq!(
        (word(binary), &glb[binary + 4..binary + 8]),
        (glb.len() - binary - 8, &b"BIN\0"[..])
    );
    assert_eq!(head["accessors"][0]["count"], 480);
    assert_eq!(head["accessors"][2]["count"], 720);
    let vertices = binary + 8;
    for (index, record) in loops.iter().enumerate() {
        for (corner, name) in ["p0", "p1", "p2", "p3"].into_iter().enumerate() {
            let at = vertices + (4 * index + corner) * 20;
            for (axis, expected) in vector(&record[name]).into_iter().enumerate() {
                let found = f32::from_bits(word(at + 4 * axis) as u32);
                // Six decimals against f32 up to 16 mm.
                assert!((f64::from(found) - expected).abs() < 2e-6);
                let low = head["accessors"][0]["min"][axis].as_f64().unwrap();
                let high = head["accessors"][0]["max"][axis].as_f64().unwrap();
                assert!((low..=high).contains(&f64::from(found)));
            }
        }
    }
    let last = glb.len() - 24;
    let indices: Vec<usize> = (0..6).map(|k| word(last + 4 * k)).collect();
    assert_eq!(indices, [476, 477, 478, 476, 478, 479]);
}

#[test]
fn each_loop_says_what_it_is_made_of() {
    let bench = Bench::new();
    let rows = "
        [length]
        map = 'lut'
        [[length.table]]
        colour = '#c80000'
        [[length.table]]
        colour = '#c8b4b4'
        density = 2.5
        kind = 'cut'
        phase = 'kajiya_kay'
        specular = 0.25
        exponent = 30
        yarn_diameter = 0.5
        [[length.table]]
        colour = '#c8b400'
        kind = 'cut'
        phase = 'frame_lambert'
        transmission = 0.75
        ";
    fs::write(bench.path("mixed.toml"), format!("{SMALL}{rows}")).unwrap();
    bench.ok(&["export", "loops", "mixed.toml", "-o", "loops.json"]);
    bench.ok(&["export", "volume", "mixed.toml", "-o", "volume"]);
    let json = bench.json("loops.json");
    assert_eq!(json["yarn"]["interpolation"], "linear");
    assert!((json["yarn"]["root_blend"].as_f64().unwrap() - 0.1).abs() < 1e-6);
    let mut kinds = std::collections::BTreeSet::new();
    for record in json["loops"].as_array().unwrap() {
        let volume = record["volume"].as_str().unwrap();
        assert!(
            bench
                .path(&format!("volume/{volume}-layer-00.png"))
                .is_file()
        );
        let variant = record["variant"].as_u64().unwrap();
        let name = volume
            .strip_suffix(&format!("-variant-{variant:02}"))
            .unwrap();
        let line = |field: &str| record.get(field).map(ToString::to_string);
        kinds.insert((
            name.to_owned(),
            record["kind"].to_string() + " " + record["phase"].as_str().unwrap(),
            ["density", "transmission", "specular", "exponent"].map(line),
        ));
    }
    let of = |name: &str, is: &str, numbers: [Option<&str>; 4]| {
        (
            name.to_owned(),
            is.to_owned(),
            numbers.map(|number| number.map(str::to_owned)),
        )
    };
    let expected = [
        of(
            "cut",
            "\"cut\" kajiya_kay",
            [Some("2.5"), None, Some("0.25"), Some("30")],
        ),
        of(
            "cut-2",
            "\"cut\" frame_lambert",
            [Some("10"), Some("0.75"), None, None],
        ),
        of(
            "terry",
            "\"terry\" isotropic",
            [Some("10"), None, None, None],
        ),
    ];
    assert_eq!(Vec::from_iter(kinds), expected);
}

#[test]
fn loops_of_bent_cloth_are_exported_where_they_lie() {
    let bench = Bench::new();
    bench.ok(&["export", "loops", "small.toml", "-o", "level.json"]);
    let level = bench.json("level.json");
    // A net that sets the cloth upright: what was y is z, and what was z is -y.
    let pitch: [f64; 2] = serde_json::from_value(level["pitch"].clone()).unwrap();
    let size = [12.0 * pitch[0], 10.0 * pitch[1]];
    let net = renderer_core::scene::net_through([4, 4], |across, along| {
        [size[0] * (across - 0.5), 0.0, size[1] * (along - 0.5)]
    });
    let upright = SMALL.to_owned() + &format!("[form]\nkind = 'net'\nnet = {net:?}\n");
    fs::write(bench.path("upright.toml"), upright).unwrap();
    bench.ok(&["export", "loops", "upright.toml", "-o", "upright.json"]);
    let upright = bench.json("upright.json");
    let [level, upright] = [&level, &upright].map(|json| json["loops"].as_array().unwrap());
    assert_eq!((level.len(), upright.len()), (120, 120));
    let vector =
        |value: &serde_json::Value| -> [f64; 3] { serde_json::from_value(value.clone()).unwrap() };
    for (level, upright) in level.iter().zip(upright) {
        for name in ["p0", "p1", "p2", "p3", "normal"] {
            let ([x, y, z], found) = (vector(&level[name]), vector(&upright[name]));
            for (expected, found) in [x, -z, y].into_iter().zip(found) {
                // Corners of facets are rounded to f32: 1e-6 of numbers up to 16 mm.
                assert!(
                    (expected - found).abs() < 1e-5,
                    "{name}: {expected} {found}"
                );
            }
        }
        for name in ["cell", "face", "colour", "length"] {
            assert_eq!(level[name], upright[name]);
        }
    }
}

#[test]
fn the_list_of_loops_tells_what_else_a_renderer_needs() {
    let bench = Bench::new();
    bench.ok(&[
        "export",
        "loops",
        "small.toml",
        "-o",
        "loops.json",
        "--set",
        "pile.yarn_diameter=0.5",
        "--set",
        "length.value=2.5",
        "--set",
        "skeleton.crimp=0.125",
        "--set",
        "light.environment.radiance=0.75",
        "--set",
        "light.sun[0].azimuth=90",
        "--set",
        "light.sun[0].elevation=30",
        "--set",
        "light.sun[0].irradiance=3",
        "--set",
        "light.sun[0].angular_diameter=5",
        "--set",
        "view.cameras[1].target=[1, 2, 3]",
        "--set",
        "view.cameras[1].orthographic_height=12",
    ]);
    let json = bench.json("loops.json");
    // Directions and lengths go through f64, and what a scene keeps through f32: 6e-8 of numbers up to 25.
    let near = |value: &serde_json::Value, expected: &[f64]| {
        let found: Vec<f64> = serde_json::from_value(value.clone()).unwrap();
        let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 2e-6;
        assert!(
            found.len() == expected.len() && found.iter().zip(expected).all(is_near),
            "{found:?} instead of {expected:?}"
        );
    };
    assert_eq!(json["yarn"]["kind"], "terry");
    assert_eq!(json["yarn"]["diameter"], 0.5);
    // Base width, longest loop, and the default thickness.
    near(&json["yarn"]["reference_size"], &[2.4, 2.5, 0.92]);
    let ground = &json["ground"];
    assert_eq!(
        (&ground["visible"], &ground["height"]),
        (&true.into(), &"winding".into())
    );
    assert_eq!(ground["crimp"], 0.125);
    near(
        &serde_json::json!([ground["warp_radius"], ground["weft_radius"]]),
        &[0.22, 0.22],
    );

    let sun = &json["suns"][0];
    near(&sun["direction"], &[0.0, 0.75_f64.sqrt(), 0.5]);
    near(&sun["irradiance"], &[3.0; 3]);
    near(&serde_json::json!([sun["angular_diameter"]]), &[5.0]);
    assert_eq!(json["environment"]["kind"], "constant");
    near(&json["environment"]["radiance"], &[0.75; 3]);

    let [above, side] = [0, 1].map(|k| &json["cameras"][k]);
    assert_eq!(
        (&above["name"], &side["name"]),
        (&"above".into(), &"side".into())
    );
    // From the near edge (−90°) at 50°, the default elevation.
    let (sin, cos) = 50_f64.to_radians().sin_cos();
    near(&above["eye"], &[0.0, -25.0 * cos, 25.0 * sin]);
    near(&above["right"], &[1.0, 0.0, 0.0]);
    near(&above["forward"], &[0.0, cos, -sin]);
    near(&above["up"], &[0.0, sin, cos]);
    near(&serde_json::json!([above["fov"]]), &[30.0]);
    assert!(above["orthographic_height"].is_null());
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    near(&side["eye"], &[1.0, 2.0 - 25.0 * cos, 3.0 + 25.0 * sin]);
    assert!(side["fov"].is_null());
    assert_eq!(side["orthographic_height"], 12.0);
}

#[test]
fn volumes_are_exported_a_png_a_layer() {
    let bench = Bench::new();
    bench.ok(&["export", "volume", "small.toml", "-o", "volume"]);
    let mut names: Vec<String> = fs::read_dir(bench.path("volume"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names.len(), 2 * 3);
    assert_eq!(names[0], "terry-variant-00-layer-00.png");
    assert_eq!(names[5], "terry-variant-01-layer-02.png");
    let middle = image::open(bench.path("volume/terry-variant-00-layer-01.png")).unwrap();
    assert_eq!(middle.color(), image::ColorType::La8);
    assert_eq!((middle.width(), middle.height()), (8, 8));
    let middle = middle.into_luma_alpha8();
    let density = |row: u32| -> u32 {
        (0..8)
            .map(|x| u32::from(middle.get_pixel(x, row).0[1]))
            .sum()
    };
    // An arch stands on two legs and closes at the top: seen from the front there is yarn at the top's middle, and none
    // between the legs.
    let at = |x: u32, row: u32| middle.get_pixel(x, row).0[1];
    assert!(density(0) > 0 && density(7) > 0);
    assert!(
        at(3, 7) + at(4, 7) < at(0, 7).max(at(1, 7)),
        "legs at the bottom"
    );
    // Again into the same folder, which exists now.
    bench.ok(&["export", "volume", "small.toml", "-o", "volume"]);
}

#[test]
fn volumes_are_laid_out_as_help_says() {
    let bench = Bench::new();
    bench.ok(&["export", "volume", "small.toml", "-o", "volume"]);
    let design = renderer_core::design::preset::parse(SMALL).unwrap();
    let scene = renderer_core::scene::compile(&design).unwrap();
    let volumes = &scene.volumes;
    let n = volumes.resolution;
    let mut shaded = 0;
    for (variant, layer) in [(0, 0), (1, 2)] {
        let name = format!("volume/terry-variant-{variant:02}-layer-{layer:02}.png");
        let picture = image::open(bench.path(&name)).unwrap().into_luma_alpha8();
        for (x, y, image::LumaA([gray, alpha])) in picture.enumerate_pixels() {
            // Column 0 at u = 0, row 0 at v = 1, layer 0 at w = −½ (MODEL.md §5): a runs along u, b along v.
            let (a, b) = (x, n - 1 - y);
            let voxel = ((variant * volumes.layers + layer) * n + b) * n + a;
            let [density, with_shade] = volumes.voxels[voxel as usize];
            assert_eq!(*alpha, density, "{name} {x},{y}");
            let product = f64::from(*gray) * f64::from(*alpha) / 255.0;
            assert!(
                (product - f64::from(with_shade)).abs() <= 0.5,
                "{name} {x},{y}"
            );
            assert!(density > 0 || *gray == 0);
            shaded += u32::from(*gray < 255 && density > 0);
        }
    }
    assert!(shaded > 0, "some yarn is shaded");
    let help = bench.run(&["export", "volume", "--help"]);
    let help = String::from_utf8(help.stdout).unwrap();
    for says in [
        "A = 255·ρ",
        "L = 255·shade",
        "Row 0 is at v = 1",
        "column 0 at u = 0",
        "layer 0 at w = −½",
    ] {
        let words: Vec<&str> = help.split_whitespace().collect();
        assert!(words.join(" ").contains(says), "{says}: {help}");
    }
}

#[test]
fn fields_of_earlier_programs_are_said_to_be_ignored() {
    let bench = Bench::new();
    let old = format!("{SMALL}traced_bounces = 1\n");
    fs::write(bench.path("old.toml"), old).unwrap();
    let checked = bench.run(&["check", "old.toml"]);
    let errors = String::from_utf8(checked.stderr).unwrap();
    let line = SMALL.lines().count() + 1;
    let says = format!("warning: old.toml:{line}:18: quality.traced_bounces is ignored: ");
    assert!(errors.starts_with(&says), "{errors}");
    assert_eq!(checked.status.code(), Some(0));
    // The picture is that of the preset without the field.
    for name in ["old", "small"] {
        let (preset, picture) = (format!("{name}.toml"), format!("{name}.exr"));
        bench.ok(&[
            "render",
            &preset,
            "-o",
            &picture,
            "--backend",
            "cpu",
            "--size",
            "16x12",
        ]);
    }
    assert_eq!(bench.read("old.exr"), bench.read("small.exr"));
}

#[test]
fn turbulence_is_exported_a_pixel_a_cell_far_edge_first() {
    let bench = Bench::new();
    bench.ok(&["export", "turbulence", "small.toml", "-o", "t.exr"]);
    let (size, channels) = exr_channels(&bench.path("t.exr"));
    assert_eq!(size, (12, 10));
    assert_eq!(
        channels.keys().collect::<Vec<_>>(),
        ["stretch", "tilt_x", "tilt_y", "twist"]
    );
    let design = renderer_core::design::preset::parse(SMALL).unwrap();
    let sheet = renderer_core::scene::SheetGeometry::new(&design);
    let field = renderer_core::scene::TurbulenceField::new(&sheet, &design.turbulence);
    for (c, name) in ["tilt_x", "tilt_y", "stretch", "twist"]
        .into_iter()
        .enumerate()
    {
        for (i, j) in [(0, 0), (11, 0), (5, 3), (0, 9)] {
            assert_eq!(
                channels[name][(9 - j) * 12 + i],
                field.at(i, j)[c],
                "{name} {i} {j}"
            );
        }
    }
}

#[test]
fn info_and_version_tell_what_would_be_used() {
    let bench = Bench::new();
    for arguments in [["info"], ["--version"], ["-V"]] {
        let output = bench.run(&arguments);
        assert!(output.status.success());
        let message = text(&output.stdout);
        for part in [
            concat!("towel-designer ", env!("CARGO_PKG_VERSION")),
            "adapters: none",
            "pictures up to 16384 x 16384",
            "--backend auto uses: cpu",
        ] {
            assert!(message.contains(part), "{message}");
        }
    }
}

#[test]
fn a_picture_in_the_way_is_replaced_whole_and_nothing_is_left_beside_it() {
    let bench = Bench::new();
    fs::write(bench.path("a.png"), "old").unwrap();
    let before = bench.names();
    bench.ok(&["render", "small.toml", "-o", "a.png", "--size", "8x8"]);
    assert_eq!(bench.names(), before);
    assert!(image::open(bench.path("a.png")).is_ok());
}

#[cfg(unix)]
#[test]
fn a_killed_render_leaves_the_old_file_and_nothing_else() {
    let bench = Bench::new();
    fs::write(bench.path("a.png"), "old").unwrap();
    let before = bench.names();
    let mut child = program(bench.folder.path())
        .args([
            "render",
            "small.toml",
            "-o",
            "a.png",
            "--time",
            "60",
            // A frequency far above the cells' makes a warning, the last that is said before rendering begins.
            "--set",
            "turbulence.frequency=9",
        ])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    let warning = said.next().unwrap().unwrap();
    assert!(warning.starts_with("warning: "), "{warning}");
    assert!(child.try_wait().unwrap().is_none(), "it ended too early");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(bench.names(), before);
    assert_eq!(bench.read("a.png"), b"old");
}

#[test]
fn quiet_prints_nothing() {
    let bench = Bench::new();
    // A frequency far above the cells' makes a warning.
    let warned = [
        "render",
        "small.toml",
        "-o",
        "a.png",
        "--size",
        "8x8",
        "--set",
        "turbulence.frequency=9",
    ];
    assert!(text(&bench.ok(&warned).stderr).contains("warning: the highest turbulence octave"));
    let quiet = bench.ok(&[&warned[..], &["--quiet"]].concat());
    assert_eq!(text(&quiet.stderr), "");
}
