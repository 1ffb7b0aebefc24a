//! What `bench` measures besides run time against error: each part's table at a tiny size, and what it rests on.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, Method};
use renderer_core::render::{Backend, BackendKind, Optimisation};
use renderer_core::scene::{Compiler, SECTIONS, compile};
use towel_benches::coarse_preview::FirstPicture;
use towel_benches::costs::{Cost, largest};
use towel_benches::drawing;
use towel_benches::first_picture::{Edit, FirstPictures, camera, edit};
use towel_benches::growth::grown;
use towel_benches::measured::Measured;
use towel_benches::optimisations::{
    Difference, Switch, counter_of, curve_optimisations, drawing_optimisations, switch_of, verdict,
};
use towel_benches::parts::{Part, chosen, share_of_first};
use towel_benches::plot::{Bar, Bars, Curve, Curves, Figure, Limit};
use towel_benches::{first_picture, summary};
use towel_designer::clock::Spent;

use super::{conditions, folder, names, parse_csv, run, texts};

/// A shipped preset.
fn preset(name: &str) -> Design {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../presets/{name}.toml"));
    towel_designer::files::load_design(&path).unwrap()
}

/// A table: its header, and its rows by the names of columns.
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let (header, rows) = parse_csv(&fs::read_to_string(path).unwrap());
        assert!(!rows.is_empty(), "{}", path.display());
        for row in &rows {
            assert_eq!(row.len(), header.len(), "{}: {row:?}", path.display());
        }
        Self { header, rows }
    }

    fn column(&self, name: &str) -> Vec<&str> {
        let index = self.header.iter().position(|header| header == name);
        let index = index.unwrap_or_else(|| panic!("{name}: {:?}", self.header));
        self.rows.iter().map(|row| &*row[index]).collect()
    }

    fn numbers(&self, name: &str) -> Vec<f64> {
        let texts = self.column(name).into_iter();
        texts
            .map(|text| text.parse().unwrap_or_else(|_| panic!("{name}: {text:?}")))
            .collect()
    }
}

#[test]
fn distances_are_compared_with_the_whole_cloth() {
    let folder = folder();
    let what = ["bench", "plain.toml", "-o", "out", "--what", "distances"];
    let output = run(
        folder.path(),
        &[&what[..], &["--budget", "25", "--backend", "cpu"]].concat(),
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let distances = Table::read(&folder.path().join("out/distances.csv"));
    let measured = distances.column("measured");
    let is_measured = measured.iter().take_while(|found| **found == "yes").count();
    assert!(is_measured >= 2, "{measured:?}");
    let numbers = |name: &str| distances.column(name)[..is_measured].to_vec();
    let number = |text: &str| text.parse::<f64>().unwrap();
    for (cells, lod) in numbers("cells a pixel").iter().zip(numbers("lod")) {
        // Four loops along each side of a pixel are left.
        let left = number(cells) / 2.0_f64.powf(number(lod));
        assert!((2.0..8.5).contains(&left), "{cells} {lod}");
    }
    for brightness in numbers("brightness over the whole cloth's") {
        assert!((0.8..1.25).contains(&number(brightness)), "{brightness}");
    }
    let [bytes, of_whole] = ["bytes", "bytes of the whole cloth"].map(numbers);
    assert!(
        bytes
            .iter()
            .zip(&of_whole)
            .all(|(part, whole)| number(part) < number(whole))
    );
}

#[test]
fn every_part_writes_its_table_and_plots() {
    let folder = folder();
    let out = folder.path().join("out");
    let output = run(
        folder.path(),
        &[
            "bench",
            "plain.toml",
            "-o",
            "out",
            "--what",
            "costs,optimisations,backends,growth,first-picture,lights,piles,forms",
            "--size",
            "24x20",
            "--window",
            "64x48",
            "--budget",
            "20",
            "--backend",
            "cpu",
        ],
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let mut expected: Vec<String> = [
        "backends",
        "costs",
        "first-picture",
        "growth",
        "memory",
        "pixels",
        "optimisations",
    ]
    .iter()
    .flat_map(|plot| [format!("plain-{plot}.png"), format!("plain-{plot}.svg")])
    .collect();
    let tables = [
        "backends",
        "costs",
        "first-picture",
        "growth",
        "lights",
        "forms",
        "piles",
        "optimisations",
    ];
    expected.extend(tables.map(|table| format!("{table}.csv")));
    expected.push("summary.md".into());
    expected.sort();
    assert_eq!(names(&out), expected);

    optimisations_are_compared(&Table::read(&out.join("optimisations.csv")));
    backends_are_compared(&Table::read(&out.join("backends.csv")));
    growth_is_measured(&Table::read(&out.join("growth.csv")));

    let first = Table::read(&out.join("first-picture.csv"));
    let edits: BTreeSet<&str> = first.column("edit").into_iter().collect();
    assert_eq!(edits, Edit::ALL.map(Edit::name).into_iter().collect());
    for name in ["clock time [s]", "whole sample clock time [s]"] {
        assert!(first.numbers(name).iter().all(|time| *time > 0.0));
    }
    let widths = first.numbers("picture width [px]");
    assert!(widths.iter().all(|width| (1.0..=64.0).contains(width)));

    let forms = Table::read(&out.join("forms.csv"));
    assert_eq!(forms.column("measured")[0], "yes");
    assert_eq!(forms.column("form").len(), 7);
    let piles = Table::read(&out.join("piles.csv"));
    assert_eq!(piles.column("measured"), ["yes"; 10]);
    let lights = Table::read(&out.join("lights.csv"));
    assert_eq!(lights.column("measured"), ["yes"; 12]);
    let noise = lights.numbers("noise of these [relRMSE]");
    let of = |name: &str| {
        let row = lights
            .column("light")
            .iter()
            .position(|light| *light == name);
        noise[row.unwrap_or_else(|| panic!("no light {name}"))]
    };
    assert!(of("an area light") > 0.0 && of("a small sun") > 0.0);

    let costs = Table::read(&out.join("costs.csv"));
    let shares = costs.numbers("share");
    assert!(
        (shares.iter().sum::<f64>() - 1.0).abs() < 1e-4,
        "{shares:?}"
    );
    for stage in ["frames", "grid", "upload", "camera rays", "shadow rays"] {
        assert!(costs.column("stage").contains(&stage), "{stage}");
    }
    // The preset's light scatters once.
    let further = costs.column("stage").into_iter();
    let further = further
        .zip(&shares)
        .find(|(stage, _)| *stage == "further bounces");
    assert_eq!(further, Some(("further bounces", &0.0)));
    let most = (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
    let most = costs.column("stage")[most.unwrap()];

    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(printed, fs::read_to_string(out.join("summary.md")).unwrap());
    for part in [
        &*format!("plain: the largest remaining cost is **{most}**"),
        "## plain: with and without each optimisation",
        "## plain: each backend",
        "## plain: each kind of light",
        "## plain: growth",
        "## plain: from an edit to its first picture",
        "One sample of all 64 × 48 pixels",
    ] {
        assert!(printed.contains(part), "{part}: {printed}");
    }
    assert!(!printed.contains("relRMSE against"), "{printed}");
}

fn optimisations_are_compared(table: &Table) {
    assert_eq!(
        table.column("optimisation"),
        Optimisation::ALL.map(Optimisation::name)
    );
    let column = |name| table.column(name);
    let (measured, difference) = (
        column("measured"),
        column("difference of pictures [relRMSE]"),
    );
    let counted = [column("counted with"), column("counted without")];
    for (row, optimisation) in Optimisation::ALL.into_iter().enumerate() {
        let found = measured[row];
        match optimisation {
            // There is no Vulkan in this test.
            Optimisation::HiddenGround | Optimisation::UnusedShading => {
                assert!(
                    found.starts_with("no: GPU alone"),
                    "{optimisation}: {found}"
                );
            }
            // They are of `tracked`.
            Optimisation::WeighedEvents | Optimisation::LastLooks => {
                assert!(
                    found.starts_with("no: it has no switch"),
                    "{optimisation}: {found}"
                );
            }
            // It has no counter of its own: fewer rays are.
            Optimisation::LaterLights => assert_eq!(found, "yes"),
            _ => {
                assert_eq!(found, "yes", "{optimisation}");
                let [with, without] = [0, 1].map(|side| counted[side][row].parse::<u64>().unwrap());
                assert!(with >= without, "{optimisation}: {with} {without}");
                // Single, one scattering: but for rounding and the last of the light the samples are the same, and
                // tiles that end at an error are what noise is about.
                let difference: f64 = difference[row].parse().unwrap();
                let is_exact = !matches!(optimisation, Optimisation::ConvergedTiles);
                assert!(
                    !is_exact || difference < 1e-3,
                    "{optimisation}: {difference}"
                );
            }
        }
    }
    let of = |optimisation: Optimisation, name: &str| {
        let row = Optimisation::ALL
            .iter()
            .position(|other| *other == optimisation)
            .unwrap();
        table.column(name)[row].parse::<f64>().unwrap()
    };
    for optimisation in [
        Optimisation::EmptyCells,
        Optimisation::RepeatedTests,
        Optimisation::OpaqueRays,
    ] {
        assert!(
            of(optimisation, "counted with") > 0.0 && of(optimisation, "counted without") == 0.0
        );
    }
    assert!(
        of(Optimisation::EmptyCells, "patch tests with")
            < of(Optimisation::EmptyCells, "patch tests without")
    );
}

fn backends_are_compared(table: &Table) {
    let all = ["cpu", "cpu without wide instructions", "reference", "gpu"];
    assert_eq!(table.column("backend"), all);
    let measured = table.column("measured");
    assert_eq!(measured[..3], ["yes"; 3]);
    assert!(measured[3].contains("mesa-vulkan-drivers"), "{measured:?}");
    let rays = table.column("rays [1/sample]");
    assert!(rays[0].parse::<f64>().unwrap() >= 1.0 && rays[3].is_empty());
}

fn growth_is_measured(table: &Table) {
    let grows = table.column("grows");
    let loops: Vec<f64> = (table.column("loops").into_iter())
        .filter_map(|text| text.parse().ok())
        .collect();
    let pixels = grows.iter().filter(|grows| **grows == "pixels").count();
    assert!(!loops.is_empty() && pixels > 0, "{grows:?}");
    assert_eq!(loops.len() + pixels, grows.len());
    for (loops, wanted) in loops.iter().zip([1e3, 1e4, 1e5, 1e6]) {
        assert!((loops / wanted - 1.0_f64).abs() < 0.1, "{loops} {wanted}");
    }
    for name in [
        "compile [µs/loop]",
        "patch tests [1/ray]",
        "shapes looks lists and bounds [bytes/loop]",
    ] {
        let given = table.column(name).into_iter();
        let given: Vec<f64> = given.filter_map(|text| text.parse().ok()).collect();
        assert_eq!(given.len(), loops.len(), "{name}");
        assert!(given.iter().all(|value| *value > 0.0), "{name}: {given:?}");
    }
}

#[test]
fn parts_are_measured_once_and_share_all_of_the_time() {
    assert_eq!(chosen(&[]), Part::ALL);
    let some = [Part::Growth, Part::Errors, Part::Growth];
    assert_eq!(chosen(&some), [Part::Errors, Part::Growth]);
    let mut left = 1.0;
    for first in 0..Part::ALL.len() {
        let share = left * share_of_first(&Part::ALL[first..]);
        assert!(share > 0.0 && share <= left);
        left -= share;
    }
    assert!(left.abs() < 1e-12);
    assert_eq!(share_of_first(&[]), 0.0);
}

#[test]
fn optimisations_have_their_switch_where_the_bench_says() {
    for method in [Method::Single, Method::Layered] {
        let mut design = preset("paper-fig12");
        (design.quality.method, design.quality.samples) = (method, 1);
        design.quality.bounces = 3;
        // From so far that there are tiles of background.
        design.view.cameras[0].distance *= 1.5;
        let with = {
            let scene = Arc::new(compile(&design).unwrap());
            let mut request = drawing::request(&design, &scene, [96, 80], 1).unwrap();
            request.settings.counters = true;
            request
        };
        let listed = drawing_optimisations(BackendKind::Cpu, method);
        for optimisation in Optimisation::ALL {
            let counters = [
                with.settings.optimisations,
                with.settings.optimisations.without(optimisation),
            ]
            .map(|optimisations| {
                let mut request = with.clone();
                request.settings.optimisations = optimisations;
                let mut cpu = CpuBackend::default();
                drawing::draw(&mut cpu, &request, None).unwrap();
                cpu.counters().unwrap()
            });
            let moves = counters[0] != counters[1];
            assert_eq!(
                moves,
                listed.contains(&optimisation),
                "{optimisation}: {counters:?}"
            );
        }
    }
    // Who draws plainly on the processor leaves out nothing of a path's first scattering.
    let plain = drawing_optimisations(BackendKind::Cpu, Method::Exact);
    assert_eq!(
        plain,
        drawing_optimisations(BackendKind::Reference, Method::Single)
    );
    assert_eq!(
        plain,
        [Optimisation::BackgroundTiles, Optimisation::LaterLights]
    );
    let gpu = drawing_optimisations(BackendKind::Gpu, Method::Tracked);
    assert!(
        gpu.contains(&Optimisation::UnusedShading) && !gpu.contains(&Optimisation::RepeatedTests)
    );
    // Curves are of these, and of what ends tiles at an error, whatever draws.
    for kind in [BackendKind::Cpu, BackendKind::Gpu, BackendKind::Reference] {
        let mut curves = curve_optimisations(kind, Method::Single);
        curves.retain(|optimisation| *optimisation != Optimisation::ConvergedTiles);
        assert_eq!(curves, drawing_optimisations(kind, Method::Single));
        assert!(curve_optimisations(kind, Method::Single).len() > curves.len());
    }
    let compiled = switch_of(
        Optimisation::UnchangedSections,
        BackendKind::Gpu,
        Method::Single,
    );
    assert_eq!(compiled, Switch::Compiling);
    // Every optimisation shows in a number but unused code, and what takes noise away or is seen in the number of rays.
    let is_countless =
        |optimisation: &Optimisation| counter_of(*optimisation, &Default::default()).is_none();
    let countless: Vec<_> = Optimisation::ALL.into_iter().filter(is_countless).collect();
    assert_eq!(
        countless,
        [
            Optimisation::UnusedShading,
            Optimisation::WeighedEvents,
            Optimisation::LastLooks,
            Optimisation::LaterLights,
        ]
    );
}

#[test]
fn differences_are_judged_by_what_two_seeds_differ() {
    let of = |rel_rmse| {
        verdict(&Difference {
            rel_rmse,
            largest: 0.0,
            between_seeds: 0.2,
        })
    };
    assert_eq!(of(0.0), "none");
    assert_eq!(of(2e-6), "rounding, 2e-6");
    assert_eq!(of(0.002), "2.00e-3, 1.00 % of that of two seeds");
    assert!(of(0.2).ends_with("no less than that of two seeds"));
}

#[test]
fn a_grown_sheet_fills_the_same_share_of_the_picture() {
    let mut design = Design::default();
    (design.sheet.warps, design.sheet.wefts) = (12, 10);
    design.view.cameras[0].target = [3.0, -2.0, 1.0];
    design.view.cameras[0].orthographic_height = Some(40.0);
    let large = grown(&design, 3.0);
    assert_eq!(large.sheet.warps, 3 * design.sheet.warps);
    assert_eq!(large.sheet.wefts, 3 * design.sheet.wefts);
    let camera = &large.view.cameras[0];
    assert_eq!(camera.target, [9.0, -6.0, 3.0]);
    assert_eq!(camera.distance, 3.0 * design.view.cameras[0].distance);
    assert_eq!(camera.orthographic_height, Some(120.0));
    assert_eq!(large.pile, design.pile);
    let planted = |design| compile(design).unwrap().loops.counts.planted;
    // But for what its borders cut off of the pattern.
    let times = planted(&large) as f64 / planted(&design) as f64;
    assert!((8.0..10.0).contains(&times), "{times}");
    // A small one is still a sheet.
    let small = grown(&design, 0.05);
    assert!(small.faults().is_empty() && small.sheet.wefts >= 1);
}

#[test]
fn every_edit_changes_what_it_is_called_after_and_is_taken_back() {
    for name in ["paper-fig1", "harbour-stripe", "peer-towel"] {
        let mut original = preset(name);
        (original.sheet.warps, original.sheet.wefts) = (16, 14);
        let first = &original.view.cameras[0];
        for kind in [Edit::Camera, Edit::Pan] {
            assert_ne!(camera(first, kind, true), *first);
            assert_eq!(camera(first, kind, false), *first);
        }
        for kind in Edit::ALL {
            let mut compiler = Compiler::default();
            let before = compiler.compile(&original).unwrap();
            let mut design = original.clone();
            edit(&mut design, kind, &original, true);
            assert!(design.faults().is_empty(), "{name}, {}", kind.name());
            let after = compiler.compile(&design).unwrap();
            let same = after.same_sections(&before);
            let changed = |name| !same[SECTIONS.iter().position(|s| *s == name).unwrap()];
            let expected = match kind {
                Edit::Camera | Edit::Pan => None,
                Edit::Light => Some("lights"),
                // With a chart on all of the cloth its own colour cannot be seen.
                Edit::Colour if original.chart.pixels.is_some() => None,
                Edit::Colour | Edit::Chart => Some("looks"),
                Edit::Length | Edit::Turbulence | Edit::Pattern => Some("loops"),
            };
            if let Some(section) = expected {
                assert!(changed(section), "{name}, {}: {same:?}", kind.name());
            } else {
                assert!([Edit::Camera, Edit::Pan, Edit::Colour].contains(&kind));
            }
            edit(&mut design, kind, &original, false);
            assert_eq!(design, original, "{name}, {}", kind.name());
        }
    }
}

/// First pictures that take so long, against whole samples of 2 s.
fn first_pictures(list: &[(Edit, f64)]) -> FirstPictures {
    let spent = |seconds: f64| Spent {
        wall: Duration::from_secs_f64(seconds),
        processor: None,
    };
    let picture = |seconds| FirstPicture {
        spent: spent(seconds),
        size: [4, 3],
    };
    FirstPictures {
        window: [8, 6],
        edits: (list.iter())
            .map(|&(edit, seconds)| (edit, vec![picture(seconds); 3]))
            .collect(),
        whole: vec![spent(9.0), spent(2.0), spent(1.0)],
        is_partial: false,
    }
}

#[test]
fn the_summary_names_late_pictures_and_the_largest_cost() {
    let cost = |stage, seconds, share| Cost {
        stage,
        seconds,
        share,
    };
    let costs = vec![cost("grid", 0.1, 0.1), cost("shadow rays", 0.9, 0.9)];
    assert_eq!(largest(&costs).unwrap().stage, "shadow rays");
    let measured = Measured {
        name: "made-up".into(),
        first_pictures: Some(first_pictures(&[(Edit::Light, 0.1), (Edit::Chart, 0.3)])),
        costs,
        ..Measured::default()
    };
    let text = summary::write(&conditions(), &[measured]);
    for part in [
        "made-up: the largest remaining cost is **shadow rays**: 90 % of the time",
        "| light | 100 ms | 4 × 3 | – | 0.050 | – | 3 |",
        "| chart | 300 ms | 4 × 3 | – | 0.150 | – | 3 |",
        "Later than that by one clock at least: chart.",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let text = first_picture::section(&first_pictures(&[(Edit::Light, 0.2)]));
    assert!(text.contains("every edit is seen within"), "{text}");
    let nothing = first_picture::section(&FirstPictures::default());
    assert!(nothing.contains("before there was one sample"), "{nothing}");
}

/// Whether all of a plot's text has its anchor inside, and no two lines of it share a place.
fn assert_can_be_read(figure: &impl Figure) -> Vec<String> {
    let texts = texts(&figure.svg().unwrap());
    for (index, (x, y, text)) in texts.iter().enumerate() {
        assert!(
            (0.0..960.0).contains(x) && (0.0..600.0).contains(y),
            "{text}"
        );
        for (other_x, other_y, other) in &texts[..index] {
            let apart = (x - other_x).abs().max((y - other_y).abs());
            assert!(apart >= 12.0, "{text} on {other}");
        }
    }
    let png = image::load_from_memory(&figure.png().unwrap()).unwrap();
    assert_eq!((png.width(), png.height()), (1920, 1200));
    texts.into_iter().map(|(.., text)| text).collect()
}

#[test]
fn bars_and_curves_of_any_range_can_be_read() {
    let bars = |values: &[Option<f64>], limit| Bars {
        title: "made-up".into(),
        under: "test".into(),
        axis: "time [ms]".into(),
        bars: (values.iter().enumerate())
            .map(|(index, value)| Bar {
                name: format!("bar {index}"),
                value: *value,
                text: format!("number {index}"),
            })
            .collect(),
        limit,
        cut: Some(50.0),
    };
    for values in [
        &[Some(3e-6), Some(0.0), None][..],
        &[Some(12345.0); 12],
        &[Some(f64::NAN), Some(1.0)],
        &[],
    ] {
        let found = assert_can_be_read(&bars(values, Some((1.0, "limit".into()))));
        assert!(found.contains(&"limit".into()));
        for index in 0..values.len() {
            assert!(found.contains(&format!("number {index}")), "{found:?}");
        }
        // Zero, and something beside it.
        let numbers = found.iter().filter(|text| text.parse::<f64>().is_ok());
        assert!(numbers.count() >= 2, "{found:?}");
    }
    for points in [
        vec![],
        vec![[1e3, 0.01]],
        (0..8)
            .map(|k| [10.0_f64.powi(k), 0.0_f64.max(f64::from(k) - 1.0)])
            .collect(),
    ] {
        let curve = |name: &str| Curve {
            name: name.into(),
            points: points.clone(),
        };
        let curves = Curves {
            title: "made-up".into(),
            under: "test".into(),
            axes: ["loops".into(), "time [s]".into()],
            curves: vec![curve("one"), curve("two")],
            limit: Some(Limit {
                name: "bound".into(),
                value: 64.0,
            }),
            notes: vec!["a note".into()],
        };
        let found = assert_can_be_read(&curves);
        for text in ["one", "two", "bound", "a note", "loops", "time [s]"] {
            assert!(found.contains(&text.into()), "{text}: {found:?}");
        }
    }
}
