//! `bench`: the whole command at a tiny size, what its files say, and the logic behind them on made-up measurements.
//!
//! Longer than most files because the parts of the command are tried on the same made-up rows.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on fails, and says where"
)]

mod edits;
mod flip;
mod parts;
#[path = "../../support/pictures.rs"]
mod pictures;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use renderer_core::design::{Method, Quality, Sampler};
use renderer_core::image::Picture;
use renderer_core::render::{BackendKind, Counters, Optimisation};
use tempfile::TempDir;
use towel_benches::conditions::Conditions;
use towel_benches::error_table;
use towel_benches::measure::{Character, Findings, Row};
use towel_benches::measured::Measured;
use towel_benches::pareto::{Point, cheapest, domination, front};
use towel_benches::plan::{Target, share, targets};
use towel_benches::plot::{Figure, Plot};
use towel_benches::summary;
use towel_benches::truth::{Bias, Known, Truth, known};
use towel_designer::clock::Spent;

const PRESET: &str = "format = 1
[sheet]
warps = 12
wefts = 10
[pile]
variants = 2
layers = 3
resolution = 8
base_width = 2.4
top_width = 2.4
[view]
cameras = [{ name = 'above', distance = 25 }]
[quality]
method = 'single'
bounces = BOUNCES
";

/// Runs the program in `folder` without Vulkan.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_towel-bench"))
        .current_dir(folder)
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env("VK_DRIVER_FILES", "/nonexistent")
        .args(arguments)
        .output()
        .unwrap()
}

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, bounces) in [("plain.toml", "1"), ("white, towel.toml", "3")] {
        let text = PRESET.replace("BOUNCES", bounces);
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A CSV file's header and rows; fields may be quoted.
fn parse_csv(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = text
        .strip_suffix("\r\n")
        .unwrap()
        .split("\r\n")
        .map(|line| {
            let mut fields = vec![String::new()];
            let mut quoted = false;
            for c in line.chars() {
                match c {
                    '"' => quoted = !quoted,
                    ',' if !quoted => fields.push(String::new()),
                    _ => fields.last_mut().unwrap().push(c),
                }
            }
            fields
        });
    (lines.next().unwrap(), lines.collect())
}

#[test]
fn a_tiny_bench_writes_table_plots_and_summary() {
    let folder = folder();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("bench.csv"), "old").unwrap();
    let start = Instant::now();
    let output = run(
        folder.path(),
        &[
            "bench",
            "plain.toml",
            "white, towel.toml",
            "-o",
            "out",
            "--size",
            "20x16",
            "--budget",
            "3",
            "--backend",
            "cpu",
            "--what",
            "errors",
        ],
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    // Two presets of three seconds; the rest is the start of the program and drawing the plots, on a busy machine.
    assert!(start.elapsed() < Duration::from_secs(30));
    assert_eq!(
        names(&out),
        [
            "bench.csv",
            "plain-without-optimisations.png",
            "plain-without-optimisations.svg",
            "plain.png",
            "plain.svg",
            "summary.md",
            "white, towel-bounces-3.png",
            "white, towel-bounces-3.svg",
            "white, towel-without-optimisations.png",
            "white, towel-without-optimisations.svg",
            "white, towel.png",
            "white, towel.svg",
        ]
    );

    let (header, rows) = parse_csv(&fs::read_to_string(out.join("bench.csv")).unwrap());
    let column = |name: &str| header.iter().position(|h| h.starts_with(name)).unwrap();
    for name in [
        "clock time [s]",
        "FLIP [0 to 1]",
        "patch tests [1/ray]",
        "error [relRMSE]",
    ] {
        assert!(header.iter().any(|h| h == name), "{name}: {header:?}");
    }
    for row in &rows {
        assert_eq!(row.len(), header.len(), "{row:?}");
        let number = |name| row[column(name)].parse::<f64>().unwrap();
        assert!(number("samples").log2().fract() == 0.0);
        assert!(number("clock time") > 0.0 && number("truth's noise") > 0.0);
        assert!((0.0..1.0).contains(&number("FLIP [")) && number("measured error") > 0.0);
        assert!(number("patch tests") > 0.0 && number("rays [") >= 1.0);
        assert_eq!(
            number("shadow rays") > 0.0,
            row[column("shadows")] == "true"
        );
        let below = row[column("error is below")] == "true";
        assert_eq!(row[column("error [")].is_empty(), below);
    }
    // Every method with both samplers, with and without shadows, for both; and the light of three scatterings.
    for &method in Method::ALL {
        for sampler in ["owen", "random"] {
            for shadows in ["true", "false"] {
                for preset in ["plain", "white, towel"] {
                    let found = rows.iter().any(|row| {
                        (&*row[0], &*row[column("method")]) == (preset, &*method.name())
                            && (&*row[column("sampler")], &*row[column("shadows")])
                                == (sampler, shadows)
                    });
                    assert!(found, "{preset}, {method:?}, {sampler}, {shadows}");
                }
            }
        }
    }
    let deep = rows.iter().filter(|row| row[column("bounces")] == "3");
    let stand_in = rows.iter().any(|row| row[column("traced bounces")] == "1");
    assert!(stand_in, "the live view's estimate");
    let kinds: Vec<_> = deep
        .map(|row| (&*row[column("method")], &*row[column("setting bounces")]))
        .collect();
    assert!(
        kinds.contains(&("tracked", "3")) && kinds.contains(&("single", "1")),
        "{kinds:?}"
    );

    // What leaving out work is worth, by the preset's own method.
    for optimisation in ["", "empty-cells", "background-tiles", "opaque-rays"] {
        let found = rows.iter().any(|row| {
            (
                &*row[column("without optimisation")],
                &*row[column("method")],
            ) == (optimisation, "single")
                && row[column("bounces")] == "1"
        });
        assert!(found, "without {optimisation}");
    }

    // Up to error targets with tiles that end early and without, from the same targets on.
    let sides = ["", "converged-tiles"].map(|optimisation| {
        let is_side = |row: &&Vec<String>| {
            !row[column("error wanted")].is_empty()
                && row[column("without optimisation")] == optimisation
        };
        let of_plain = rows.iter().filter(|row| row[0] == "plain");
        let side: Vec<[f64; 2]> = of_plain
            .filter(is_side)
            .map(|row| {
                ["error wanted", "estimated noise"].map(|name| row[column(name)].parse().unwrap())
            })
            .collect();
        for [wanted, estimate] in &side {
            assert!(
                estimate <= wanted,
                "{optimisation}: {estimate} for {wanted}"
            );
        }
        for pair in side.windows(2) {
            // Six digits are written of each.
            assert!((pair[0][0] / pair[1][0] - 2_f64.sqrt()).abs() < 1e-4);
        }
        side
    });
    assert_eq!(sides[0][0][0], sides[1][0][0], "the same targets");

    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(printed, fs::read_to_string(out.join("summary.md")).unwrap());
    for part in [
        "| error target | time with `converged-tiles` | without |",
        "## plain: light that scatters once",
        "up to 3 times",
        "| 0.05 |",
        "Dominated",
        "in patch tests",
    ] {
        assert!(printed.contains(part), "{part}: {printed}");
    }

    let png = image::open(out.join("plain.png")).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (1920, 1200));
    let svg = fs::read_to_string(out.join("plain.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    for part in [
        "plain: light that scatters once",
        "error [relRMSE]",
        "[s]",
        "Pareto front",
        "single",
    ] {
        assert!(svg.contains(part), "{part}");
    }
}

#[test]
fn a_bench_that_cannot_be_is_refused_before_it_starts() {
    let folder = folder();
    fs::create_dir(folder.path().join("other")).unwrap();
    fs::copy(
        folder.path().join("plain.toml"),
        folder.path().join("other/plain.toml"),
    )
    .unwrap();
    fs::write(folder.path().join("file"), "in the way").unwrap();
    for (code, arguments, says) in [
        (2, &["bench", "-o", "out"][..], "PRESET"),
        (2, &["bench", "plain.toml"], "--output"),
        (2, &["bench", "none.toml", "-o", "out"], "none.toml"),
        (
            2,
            &["bench", "plain.toml", "-o", "out", "--size", "0x4"],
            "1 to 16384",
        ),
        (
            2,
            &["bench", "plain.toml", "-o", "out", "--budget", "-1"],
            "above 0",
        ),
        (
            2,
            &[
                "bench",
                "plain.toml",
                "-o",
                "out",
                "--what",
                "errors,weather",
            ],
            "first-picture",
        ),
        (
            2,
            &["bench", "plain.toml", "-o", "out", "--window", "1920"],
            "widthxheight",
        ),
        (
            2,
            &["bench", "plain.toml", "other/plain.toml", "-o", "out"],
            "plain",
        ),
        (1, &["bench", "plain.toml", "-o", "file"], "file"),
        (
            1,
            &["bench", "plain.toml", "-o", "out", "--backend", "gpu"],
            "mesa-vulkan-drivers",
        ),
    ] {
        let output = run(folder.path(), arguments);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {errors}");
        assert!(
            errors.to_lowercase().contains(&says.to_lowercase()),
            "{arguments:?}: {errors}"
        );
        assert!(output.stdout.is_empty());
    }
    assert_eq!(fs::read(folder.path().join("file")).unwrap(), b"in the way");
}

/// (cost, error) as points.
fn points(list: &[(f64, f64)]) -> Vec<Point> {
    list.iter()
        .map(|&(cost, error)| Point { cost, error })
        .collect()
}

#[test]
fn the_front_holds_what_nothing_beats() {
    let all = points(&[
        (4.0, 0.3),
        (1.0, 0.9),
        (2.0, 0.95), // dearer and worse than the one before
        (2.0, 0.5),
        (2.0, 0.6), // as dear and worse than the one before
        (8.0, 0.3), // as good as the first, and dearer
        (16.0, 0.1),
        (1.5, f64::NAN),
    ]);
    assert_eq!(front(&all), [1, 3, 0, 6]);
    for (a, one) in all.iter().enumerate() {
        // The front by its definition.
        let beaten = one.error.is_nan() || all.iter().any(|other| other.beats(one));
        assert_eq!(front(&all).contains(&a), !beaten, "{one:?}");
    }
    assert_eq!(cheapest(&all, 1.0), Some(1));
    assert_eq!(cheapest(&all, 0.5), Some(3));
    assert_eq!(cheapest(&all, 0.49), Some(0));
    assert_eq!(cheapest(&all, 0.09), None);
    assert_eq!(front(&[]), [] as [usize; 0]);
    assert!(!all[0].beats(&all[0]) && all[0].beats(&all[5]) && !all[5].beats(&all[0]));

    // A group on the front; one that is twice as dear at best; one whose errors nothing dearer reaches.
    assert_eq!(domination(&all, &[2, 3]), None);
    assert_eq!(domination(&all, &[2, 5]), Some(2.0));
    assert_eq!(domination(&all, &[4]), Some(1.0));
}

/// A picture of `side` × `side` pixels of the value 1 + noise of this deviation.
fn noisy(side: u32, deviation: f64, seed: u32, shift: f64) -> Picture {
    let mut random = renderer_core::sampling::Pcg::new(seed, 0);
    // Uniform numbers of variance 1: ±√3.
    let mut noise = || deviation * 3.0_f64.sqrt() * (2.0 * f64::from(random.next_float()) - 1.0);
    let mut pixel = || {
        [
            (1.0 + shift + noise()) as f32,
            (1.0 + shift + noise()) as f32,
            (1.0 + shift + noise()) as f32,
            1.0,
        ]
    };
    Picture {
        size: [side, side],
        pixels: (0..side * side).map(|_| pixel()).collect(),
        aov: None,
    }
}

#[test]
fn the_truths_noise_is_known_and_taken_out() {
    // Halves of 100 and 300 samples with a deviation of 2 a sample: the mean's is 2/√400.
    let halves = [
        noisy(64, 2.0 / 10.0, 1, 0.0),
        noisy(64, 2.0 / 300.0_f64.sqrt(), 2, 0.0),
    ];
    let truth = Truth::new(halves, [100, 300], 0.0).unwrap();
    // 64² · 3 numbers know a deviation to 0.6 %, uniform ones better.
    assert!((truth.noise / 0.1 - 1.0).abs() < 0.03, "{}", truth.noise);
    // And the mean is that far from what it stands for.
    let exact = noisy(64, 0.0, 3, 0.0);
    let off = renderer_core::image::metrics::rel_rmse(&truth.mean, &exact).unwrap();
    assert!((off / truth.noise - 1.0).abs() < 0.03, "{off}");

    for (error, expected) in [
        (0.3, Some(0.3)),
        (0.12, Some(0.12)),
        (0.05, None),
        (0.0, None),
    ] {
        let picture = noisy(64, error, 4, 0.0);
        let measured = renderer_core::image::metrics::rel_rmse(&picture, &truth.mean).unwrap();
        match (known(measured, truth.noise), expected) {
            (Known::Error(found), Some(expected)) => {
                assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
            }
            (Known::BelowNoise, None) => {}
            other => panic!("{other:?}"),
        }
    }
    // Exactly: 0.5² = 0.3² + 0.4²; √2 times the noise is an error as large as the noise, which counts as below.
    assert_eq!(known(0.5, 0.3), Known::Error((0.25_f64 - 0.3 * 0.3).sqrt()));
    assert_eq!(known(0.4, 0.3), Known::BelowNoise);
    assert_eq!(Known::BelowNoise.bound(0.3), 0.3);
    assert!(matches!(known(f64::NAN, 0.3), Known::Error(error) if error.is_nan()));
}

#[test]
fn a_bias_is_found_under_noise_several_times_as_large() {
    let halves = [noisy(96, 0.3, 11, 0.0), noisy(96, 0.3, 12, 0.0)];
    let truth = Truth::new(halves, [10, 10], 0.0).unwrap();
    let of = |shift| {
        let [a, b] = [noisy(96, 0.4, 13, shift), noisy(96, 0.4, 14, shift)];
        Bias::new([&a, &b], &truth).unwrap()
    };
    // Noise of 0.5 in each difference, 27648 numbers: the mean of products is known to 0.25/166.
    let bias = of(0.15);
    assert!(
        (bias.square - 0.0225).abs() < 4.0 * bias.deviation,
        "{bias:?}"
    );
    assert!((0.5..2.0).contains(&(bias.deviation / 0.0015)), "{bias:?}");
    assert!(bias.to_string().starts_with("0.1"), "{bias}");
    // Without one, none is found.
    let none = of(0.0);
    assert!(none.square.abs() < 4.0 * none.deviation, "{none:?}");
    assert!(none.to_string().starts_with("below 0.0"), "{none}");
    // One picture for both would take its own noise for a bias: what independence is for.
    let one = noisy(96, 0.4, 13, 0.0);
    let same = Bias::new([&one, &one], &truth).unwrap();
    assert!(same.square > 0.1, "{same:?}");
}

#[test]
fn the_plan_has_every_method_and_more_scatterings_where_the_preset_has() {
    let quality = |bounces| Quality {
        bounces,
        ..Quality::default()
    };
    let direct = &targets(&quality(1), Method::ALL, &[])[..];
    assert_eq!(direct.len(), 1);
    // And the preset's own method with shared shadows.
    assert_eq!(direct[0].settings.len(), 4 * Method::ALL.len() + 1);
    assert!(
        direct[0]
            .settings
            .iter()
            .all(|setting| setting.bounces == 1)
    );
    let both = targets(&quality(9), &[Method::Single, Method::Tracked], &[]);
    assert_eq!((both[0].bounces, both[1].bounces), (1, 9));
    assert_eq!(both[0].settings.len(), 9);
    assert!((both[0].share + both[1].share - 1.0).abs() < 1e-12);
    // What is left is shared by weight, and the last takes all.
    let settings = &both[0].settings;
    let last = settings.len() - 1;
    assert_eq!(share(&settings[last..], 7.0), 7.0);
    let mut left = 7.0;
    for index in 0..=last {
        let part = share(&settings[index..], left);
        assert!(part > 0.0 && part <= left);
        left -= part;
    }
    assert!(left.abs() < 1e-12);
    assert!(share(settings, 7.0) > 7.0 / settings.len() as f64);
}

#[test]
fn tiles_that_end_early_are_held_against_none_at_the_same_error_targets() {
    let quality = Quality::default();
    let optimisations = [Optimisation::ConvergedTiles, Optimisation::OpaqueRays];
    let of = |optimisations| targets(&quality, &[quality.method], optimisations).remove(0);
    let (plain, target) = (of(&[]), of(&optimisations));
    let new = &target.settings[plain.settings.len()..];
    let kinds: Vec<_> = new.iter().map(|s| (s.without, s.to_error)).collect();
    let converged = Some(Optimisation::ConvergedTiles);
    assert_eq!(
        kinds,
        [
            (None, true),
            (converged, true),
            (Some(Optimisation::OpaqueRays), false)
        ]
    );
    assert!(new.iter().all(|setting| !setting.is_choice()));

    let (with, without) = (plain.settings.len(), plain.settings.len() + 1);
    let rows = [
        (0, 16, 1.6, 0.2),
        (with, 32, 2.0, 0.15),
        (with, 64, 3.0, 0.11),
        (without, 32, 3.0, 0.14),
        (without, 64, 6.0, 0.1),
    ];
    let mut findings = findings(&rows, 0.01);
    for (row, wanted) in findings.rows.iter_mut().skip(1).zip([0.2, 0.1, 0.2, 0.1]) {
        row.wanted = Some(wanted);
    }
    findings.characters = vec![findings.characters[0]; target.settings.len()];
    findings.target = target;
    let conditions = conditions();
    let plot = Plot::of_optimisations("made-up", &conditions, &findings).unwrap();
    let shown = texts(&plot.svg().unwrap());
    let shows = |wanted: &str| shown.iter().any(|(.., text)| text == wanted);
    let method = quality.method.name();
    assert!(shows(&format!("{method}, up to an error")) && shows("without converged-tiles"));
    assert!(shows("Squares: error targets, each the"), "{shown:?}");
    assert!(!shows("without opaque-rays"), "there is no row of it");
    let choices = Plot::new("made-up", &conditions, &findings).svg().unwrap();
    assert!(!choices.contains("up to an error") && !choices.contains("Squares"));

    let measured = Measured {
        name: "made-up".into(),
        findings: vec![findings],
        ..Measured::default()
    };
    let text = summary::write(&conditions, std::slice::from_ref(&measured));
    for part in [
        "| 0.2000 | 2.0 s | 3.0 s | 1.50 | 0.150 | 0.140 | 32 | 32 |",
        "| 0.1000 | 3.0 s | 6.0 s | 2.00 | 0.110 | 0.100 | 64 | 64 |",
        // They are no choice of users beside settings whose pixels all have as many samples.
        "| 0.1 | none in this time |",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let (header, rows) = parse_csv(&error_table::csv(
        &conditions,
        &[(&measured.name, &measured.findings)],
    ));
    let wanted = header.iter().position(|h| h == "error wanted [relRMSE]");
    let wanted: Vec<_> = rows.iter().map(|row| &*row[wanted.unwrap()]).collect();
    assert_eq!(wanted, ["", "0.2", "0.1", "0.2", "0.1"]);
}

/// Findings with one row for each (setting, samples, seconds, error).
fn findings(list: &[(usize, u32, f64, f64)], noise: f64) -> Findings {
    let quality = Quality {
        bounces: 1,
        ..Quality::default()
    };
    let target: Target = targets(&quality, &[Method::Single, Method::Layered], &[]).remove(0);
    let spent = |seconds: f64| Spent {
        wall: Duration::from_secs_f64(seconds),
        processor: None,
    };
    let rows = list.iter().map(|&(setting, samples, seconds, error)| {
        let measured = error.hypot(noise);
        Row {
            setting,
            samples,
            wanted: None,
            spent: spent(seconds),
            measured,
            error: known(measured, noise),
            estimate: None,
            flip: 0.5 * error,
            rounds: 2,
        }
    });
    let black = noisy(4, 0.0, 1, 0.0);
    let mut truth = Truth::new([black.clone(), black], [7, 8], 0.0).unwrap();
    truth.noise = noise;
    let character = |patch_tests| Character {
        counters: Some(Counters {
            rays: 10,
            shadow_rays: 10,
            patch_tests,
            volume_samples: 40,
            ..Counters::default()
        }),
        per_sample: Some(spent(patch_tests as f64 * 1e-3)),
        bias: None,
    };
    Findings {
        rows: rows.collect(),
        characters: target
            .settings
            .iter()
            .map(|setting| {
                character(if setting.method == Method::Single {
                    60
                } else {
                    150
                })
            })
            .collect(),
        target,
        truth,
        bare: Some(Duration::from_millis(2)),
    }
}

fn conditions() -> Conditions {
    Conditions {
        size: [4, 4],
        window: [8, 6],
        // Of the GPU time by the clock counts.
        backend: BackendKind::Gpu,
        device: "test".into(),
        budget: Duration::from_secs(9),
    }
}

#[test]
fn the_summary_names_the_best_and_the_dominated() {
    // Settings 0 and 1: single and layered with Owen points; 2 and 3: with random ones.
    let findings = findings(
        &[
            (0, 1, 1.0, 0.6),
            (0, 2, 2.0, 0.45),
            (0, 4, 4.0, 0.4),
            (1, 1, 3.0, 0.5),
            (1, 4, 12.0, 0.15),
            (2, 2, 2.1, 0.46),
            (3, 8, 30.0, 0.01),
        ],
        0.08,
    );
    assert_eq!(findings.target.settings[2].sampler, Sampler::Random);
    let measured = Measured {
        name: "made-up".into(),
        findings: vec![findings],
        ..Measured::default()
    };
    let text = summary::write(&conditions(), std::slice::from_ref(&measured));
    for part in [
        "| 0.5 | single, Owen | 2 | 2.0 s | 0.450 | 0.225 |",
        "| 0.2 | layered, Owen | 4 | 12.0 s | 0.150 | 0.075 |",
        "| 0.1 | layered, random | 8 | 30.0 s | below 0.080 |",
        "| 0.05 | not known: below the truth's noise",
        "- single, random: another gives the same error in 1/1.1 of the time",
        "layered : single = 2.50 : 1.00 in time, 2.50 : 1.00 in patch tests and 1.00 : 1.00 in volume samples",
        "| layered | 150 ms | 2.50 | 7.5 | 2.0 | not measured |",
        "Not measured, since time was up: single, Owen, no shadows; ",
        "takes 2.000 ms a sample",
        "so many times that: layered 75, single 30.",
        "time by the clock",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(
        !text.contains("- single, Owen") && !text.contains("- layered, Owen:"),
        "{text}"
    );

    let table = error_table::csv(&conditions(), &[(&measured.name, &measured.findings)]);
    let (header, rows) = parse_csv(&table);
    assert_eq!(rows.len(), 7);
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    assert_eq!(rows[1][column("error [relRMSE]")], "0.45");
    assert_eq!(rows[6][column("error [relRMSE]")], "");
    assert_eq!(rows[6][column("error is below the truth's noise")], "true");
    assert_eq!(rows[0][column("patch tests [1/ray]")], "3");
    assert_eq!(rows[0][column("processor time [s]")], "");
}

/// Where the SVG has text, and what.
fn texts(svg: &str) -> Vec<(f64, f64, String)> {
    let mut found = Vec::new();
    for part in svg.split("<text ").skip(1) {
        let attribute = |name: &str| -> f64 {
            let start = part.find(&format!("{name}=\"")).unwrap() + name.len() + 2;
            part[start..].split('"').next().unwrap().parse().unwrap()
        };
        let text = part
            .split('>')
            .nth(1)
            .unwrap()
            .split('<')
            .next()
            .unwrap()
            .trim();
        found.push((attribute("x"), attribute("y"), text.to_owned()));
    }
    found
}

#[test]
fn plots_of_any_range_can_be_read() {
    let wide: Vec<_> = (0..20)
        .map(|k| {
            (
                k as usize % 8,
                1 << (k / 8),
                0.001 * 4_f64.powi(k),
                9.0 * 0.6_f64.powi(k),
            )
        })
        .collect();
    for list in [
        &[(0, 1, 0.02, 0.3)][..],
        &[(0, 1, 1.0, 0.3), (1, 2, 1.1, 0.29)],
        &wide,
        &[],
    ] {
        let (conditions, findings) = (conditions(), findings(list, 0.01));
        let plot = Plot::new("made-up", &conditions, &findings);
        let svg = plot.svg().unwrap();
        let texts = texts(&svg);
        // At least two numbers at each axis: x below the field, y left of it.
        let numbers = texts
            .iter()
            .filter(|(.., text)| text.parse::<f64>().is_ok());
        let (left, under): (Vec<_>, Vec<_>) = numbers.partition(|(x, ..)| *x < 80.0);
        assert!(left.len() >= 2 && under.len() >= 2, "{list:?}: {texts:?}");
        // No two of an axis on top of each other: a line is 14 units high, the widest number five digits.
        for (axis, labels, apart) in [(0, &under, 24.0), (1, &left, 14.0)] {
            let mut places: Vec<f64> = labels.iter().map(|(x, y, _)| [*x, *y][axis]).collect();
            places.sort_by(f64::total_cmp);
            let closest = places
                .windows(2)
                .map(|pair| pair[1] - pair[0])
                .fold(f64::MAX, f64::min);
            assert!(closest >= apart, "{list:?}: {places:?}");
        }
        assert!(
            texts
                .iter()
                .all(|&(x, y, _)| (0.0..960.0).contains(&x) && (0.0..600.0).contains(&y))
        );
        let png = image::load_from_memory(&plot.png().unwrap())
            .unwrap()
            .into_rgb8();
        // Light, with something on it.
        let light = png.pixels().filter(|pixel| pixel.0 == [255; 3]).count();
        let all = png.pixels().len();
        assert!(
            light > all / 2 && light < all - all / 100,
            "{light} of {all}"
        );
    }
}
