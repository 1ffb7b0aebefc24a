//! Every field of a design at its ends and between, alone and in pairs: a finite picture in bounded time, or a fault
//! that names the field.

use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use renderer_core::cpu::CpuBackend;
use renderer_core::design::{
    AreaLight, ChartObject, Design, Entry, LengthEntry, Method, NamedYarn, Shape, Shaped, preset,
};
use renderer_core::gpu::GpuBackend;
use renderer_core::render::{Backend, RenderError};
use renderer_core::scene::compile;

use crate::support::device::{finish, gpu, reference};
use crate::support::scenes::{request, small_towel};

const SIZE: [u32; 2] = [6, 5];
/// No design takes longer on an idle core than a fraction of this; the rest is for busy machines.
const LONGEST: Duration = Duration::from_secs(60);

/// A design in which each field means something, and that is drawn at once.
fn small() -> Design {
    let mut design = small_towel();
    (design.sheet.warps, design.sheet.wefts) = (6, 5);
    let pile = &mut design.pile;
    (pile.layers, pile.resolution, pile.variants, pile.fibres) = (3, 6, 2, 10);
    design.length.table = vec![LengthEntry::default()];
    design.light.area = vec![AreaLight::default()];
    design.chart.object = vec![ChartObject::default()];
    design.chart.yarn = vec![NamedYarn::default()];
    design.view.cameras[0].distance = 14.0;
    design.view.current = Some(design.view.cameras[0].clone());
    design.quality.method = Method::Tracked;
    design.quality.bounces = 3;
    design
}

/// A field of a design and what to write into it.
struct Choice {
    path: String,
    /// Smallest and largest number, or the first and the last word.
    ends: [String; 2],
    /// The value at a share of the way from end to end.
    between: Box<dyn Fn(f64) -> String>,
}

/// Every field that a file can hold with a range of its own.
fn every_field() -> Vec<Choice> {
    let mut all = Vec::new();
    walk(&Design::shape(), String::new(), &mut all);
    all
}

fn walk(shape: &Shape, path: String, all: &mut Vec<Choice>) {
    match shape {
        Shape::Number(field) => {
            let field = *field;
            let between = move |share: f64| {
                let value = field.min + (field.max - field.min) * share;
                let whole = if field.integer { value.round() } else { value };
                whole.to_string()
            };
            all.push(Choice {
                path,
                ends: [between(0.0), between(1.0)],
                between: Box::new(between),
            });
        }
        Shape::Switch => words(path, vec!["false".into(), "true".into()], all),
        Shape::Choice(names) => {
            words(
                path,
                names.iter().map(|(name, _)| name.clone()).collect(),
                all,
            );
        }
        Shape::Colour => words(path, vec!["#000000".into(), "#ffffff".into()], all),
        Shape::Table(entries) => {
            for entry in entries {
                let dot = if path.is_empty() { "" } else { "." };
                walk(&entry.shape, format!("{path}{dot}{}", entry.name), all);
            }
        }
        Shape::List { of, .. } if matches!(**of, Shape::Table(_)) => {
            walk(of, format!("{path}[0]"), all);
        }
        Shape::Optional(of) => walk(of, path, all),
        // Ranges of these depend on where they stand; `cameras` has them.
        Shape::Real | Shape::Text | Shape::Stitch | Shape::List { .. } | Shape::Hidden => {}
    }
}

fn words(path: String, names: Vec<String>, all: &mut Vec<Choice>) {
    let ends = [names[0].clone(), names[names.len() - 1].clone()];
    let between = move |share: f64| {
        names[((share * names.len() as f64) as usize).min(names.len() - 1)].clone()
    };
    all.push(Choice {
        path,
        ends,
        between: Box::new(between),
    });
}

/// Whether a design gives a finite picture on these backends, or faults that name a field; in bounded time.
fn judge(design: &Design, backends: &mut [&mut dyn Backend]) -> Result<bool, String> {
    let start = Instant::now();
    let drawn = match compile(design) {
        Err(error) => {
            let message = error.to_string();
            let Shape::Table(sections) = Design::shape() else {
                return Err("a design is a table".into());
            };
            let named = |section: &Entry| message.contains(&format!("{}.", section.name));
            if !sections.iter().any(named) {
                return Err(format!("names no field: {message}"));
            }
            false
        }
        Ok(_) => {
            let mut request = request(design, SIZE);
            request.settings.samples = 1;
            for backend in backends {
                match backend.begin(&request) {
                    Ok(()) => {}
                    // Some methods are for the reference alone.
                    Err(RenderError::Method { .. }) => continue,
                    Err(error) => return Err(error.to_string()),
                }
                let picture = finish(*backend, &request);
                for pixel in &picture.pixels {
                    if !pixel.iter().all(|value| value.is_finite() && *value >= 0.0) {
                        return Err(format!("{}: {pixel:?}", backend.kind().name()));
                    }
                }
            }
            true
        }
    };
    if start.elapsed() > LONGEST {
        return Err(format!("took {:?}", start.elapsed()));
    }
    Ok(drawn)
}

fn with(design: &Design, edits: &[(&str, &str)]) -> Design {
    edits.iter().fold(design.clone(), |design, (path, value)| {
        preset::set(&design, path, value)
            .unwrap_or_else(|error| panic!("{path} = {value}: {error}"))
    })
}

fn ends_of_all_fields(methods: &[&str]) {
    let base = small();
    let fields = every_field();
    assert!(fields.len() > 80, "only {} fields", fields.len());
    let mut faulty = Vec::new();
    for method in methods {
        for field in &fields {
            for value in &field.ends {
                let design = with(&base, &[("quality.method", method), (&field.path, value)]);
                let what = format!("{method}, {} = {value}", field.path);
                match judge(&design, &mut [&mut CpuBackend::default(), &mut reference()]) {
                    Ok(true) => {}
                    Ok(false) => faulty.push(field.path.clone()),
                    Err(error) => panic!("{what}: {error}"),
                }
            }
        }
    }
    faulty.dedup();
    // Few fields have an end that others at their defaults forbid.
    let expected = [
        "pile.base_width",
        "pile.top_width",
        "pile.thickness",
        "pile.max_length",
    ];
    for path in &faulty {
        let sections = [
            "length.",
            "sheet.",
            "turbulence.filter",
            "light.environment.",
            "light.area[0].distance",
            // A net has no points, and a height picture no pixels, unless it is given some.
            "form.kind",
        ];
        let known = expected.contains(&path.as_str())
            || sections.iter().any(|start| path.starts_with(start));
        assert!(known, "{faulty:?}");
    }
}

#[test]
fn every_field_at_its_ends_gives_a_finite_picture() {
    ends_of_all_fields(&["tracked"]);
}

#[test]
#[ignore = "long: about 40 s"]
fn every_field_at_its_ends_gives_a_finite_picture_by_every_method() {
    ends_of_all_fields(&["single", "layered", "exact", "six-face"]);
}

#[test]
fn a_handful_of_ends_on_the_device() {
    let mut device = gpu();
    for edits in [
        [("pile.density", "1000000"), ("pile.thickness", "0.01")],
        [("pile.density", "0"), ("turbulence.frequency", "10")],
        [("pile.layers", "64"), ("pile.resolution", "4")],
        [("pile.layers", "1"), ("pile.resolution", "128")],
        [
            ("skeleton.warp_radius", "10"),
            ("skeleton.weft_radius", "0.005"),
        ],
        [
            ("light.sun[0].angular_diameter", "120"),
            ("light.sun[0].elevation", "-90"),
        ],
        [
            ("light.area[0].distance", "100000"),
            ("light.area[0].width", "100000"),
        ],
        [
            ("light.area[0].irradiance", "1000"),
            ("light.area[0].elevation", "-90"),
        ],
        [
            ("light.environment.radiance", "1000"),
            ("pile.max_albedo", "1"),
        ],
        [
            ("view.cameras[0].distance", "0.01"),
            ("view.cameras[0].fov", "150"),
        ],
        [
            ("view.cameras[0].distance", "1000000"),
            ("view.cameras[0].fov", "0.1"),
        ],
        [("pile.twist", "143"), ("pile.tilt", "180")],
    ] {
        for method in ["single", "tracked"] {
            let design = with(&small(), &[("quality.method", method), edits[0], edits[1]]);
            let drawn = judge(&design, &mut [&mut device, &mut CpuBackend::default()]);
            assert_eq!(drawn, Ok(true), "{method} {edits:?}");
        }
    }
}

/// Random values for some random fields; one in three of them at an end.
fn some_fields(runs: u32, at_once: usize, device: Option<&mut GpuBackend>) {
    let fields = every_field();
    let config = Config {
        cases: runs,
        failure_persistence: None,
        ..Config::default()
    };
    let random = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, random);
    let share = prop_oneof![
        Just(0.0),
        Just(1.0),
        0.0..1.0_f64,
        0.0..0.01_f64,
        0.99..1.0_f64,
        0.0..1.0_f64
    ];
    let edits = prop::collection::vec((0..fields.len(), share), 1..=at_once);
    let device = std::cell::RefCell::new(device);
    let count = std::cell::Cell::new(0);
    let result = runner.run(&edits, |edits| {
        let written: Vec<(&str, String)> = edits
            .iter()
            .map(|&(index, share)| (fields[index].path.as_str(), (fields[index].between)(share)))
            .collect();
        let borrowed: Vec<(&str, &str)> = written.iter().map(|(p, v)| (*p, v.as_str())).collect();
        let design = with(&small(), &borrowed);
        let (mut cpu, mut reference) = (CpuBackend::default(), reference());
        let mut device = device.borrow_mut();
        let mut backends: Vec<&mut dyn Backend> = vec![&mut cpu, &mut reference];
        if let Some(device) = device.as_deref_mut() {
            backends.push(device);
        }
        match judge(&design, &mut backends) {
            Ok(drawn) => count.set(count.get() + u32::from(drawn)),
            Err(error) => prop_assert!(false, "{borrowed:?}: {error}"),
        }
        Ok(())
    });
    if let Err(error) = result {
        panic!("{error}");
    }
    assert!(
        count.get() > runs / 3,
        "only {} of {runs} drawn",
        count.get()
    );
}

#[test]
fn random_pairs_give_finite_pictures() {
    some_fields(100, 2, None);
}

#[test]
#[ignore = "long: about 60 s"]
fn many_random_fields_give_finite_pictures() {
    some_fields(2000, 2, None);
    some_fields(1000, 8, None);
    some_fields(100, 4, Some(&mut gpu()));
}

#[test]
fn too_large_is_reported_before_memory_is_asked_for() {
    let start = Instant::now();
    for (edits, says) in [
        (
            [("sheet.warps", "100000"), ("sheet.wefts", "100000")],
            "sheet.wefts",
        ),
        (
            [("sheet.warps", "5000"), ("sheet.wefts", "5000")],
            "sheet.wefts",
        ),
        (
            [("length.value", "100"), ("pile.max_length", "100")],
            "pile.max_length",
        ),
    ] {
        let message = compile(&with(&small(), &edits)).unwrap_err().to_string();
        assert!(message.contains(says), "{message}");
    }
    assert!(start.elapsed() < Duration::from_secs(5));
}
