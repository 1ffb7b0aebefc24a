//! What a check calls sound can be drawn, and what cannot be drawn it refuses with the same words: some thousand random
//! designs, most of them bent.

use renderer_core::cpu::CpuBackend;
use renderer_core::design::{Design, FormKind, Shape, Shaped, preset};
use renderer_core::geometry::Camera;
use renderer_core::render::{Backend, RenderRequest, Settings};
use renderer_core::sampling::Pcg;
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodPlan};
use renderer_core::scene::{Cancel, CompileError, Compiler};

use crate::support::device::finish;
use crate::support::scenes::small_towel;

const SIZE: [u32; 2] = [4, 4];
/// Sections whose numbers decide whether there is a scene.
const SECTIONS: [&str; 7] = [
    "form",
    "length",
    "pile",
    "turbulence",
    "skeleton",
    "finish",
    "sheet",
];
/// Numbers that only cost time, and the sheet's, which are drawn from a range of their own.
const LEFT_OUT: [&str; 7] = [
    "variants",
    "layers",
    "resolution",
    "fibres",
    "warps",
    "wefts",
    "octaves",
];

/// Paths of numbers, with their ranges and whether they are whole.
fn numbers() -> Vec<(String, [f64; 2], bool)> {
    let Shape::Table(sections) = Design::shape() else {
        panic!("a design is a table");
    };
    let mut numbers = Vec::new();
    for section in sections
        .iter()
        .filter(|section| SECTIONS.contains(&section.name))
    {
        let Shape::Table(entries) = &section.shape else {
            panic!("{} is a table", section.name);
        };
        for entry in entries
            .iter()
            .filter(|entry| !LEFT_OUT.contains(&entry.name) || section.name == "form")
        {
            if let Shape::Number(field) = entry.shape {
                numbers.push((
                    format!("{}.{}", section.name, entry.name),
                    [field.min, field.max],
                    field.integer,
                ));
            }
        }
    }
    assert!(numbers.len() > 30, "only {} numbers", numbers.len());
    numbers
}

/// Small cloth of a random size and form, with a few of its other numbers at random, small ones more often.
fn random_design(numbers: &[(String, [f64; 2], bool)], random: &mut Pcg) -> Design {
    let mut share = || f64::from(random.next_float());
    let mut design = small_towel();
    let pile = &mut design.pile;
    (pile.layers, pile.resolution, pile.variants, pile.fibres) = (2, 4, 1, 4);
    design.sheet.warps = 6 + (share() * 40.0) as u32;
    design.sheet.wefts = 6 + (share() * 40.0) as u32;
    let forms = [
        FormKind::Flat,
        FormKind::Wave,
        FormKind::Roll,
        FormKind::Stack,
        FormKind::Hanging,
    ];
    design.form.kind = forms[(share() * forms.len() as f64) as usize];
    design.form.layers = 2 + (share() * 3.0) as u32;
    design.form.radius = 1.0 + share() * 20.0;
    for _ in 0..(share() * 5.0) as usize {
        let (path, [min, max], integer) = &numbers[(share() * numbers.len() as f64) as usize];
        let value = min + (max - min) * share().powi(3);
        let value = if *integer { value.round() } else { value };
        design = preset::set(&design, path, &value.to_string())
            .unwrap_or_else(|error| panic!("{error}"));
    }
    design
}

/// What a check says of a design, of all that can be wrong with it.
fn checked(design: &Design) -> Result<(), String> {
    let faults = design.faults();
    if let Some(fault) = faults.first() {
        return Err(fault.to_string());
    }
    let camera = Camera::from_design(&design.view.cameras[0]);
    let plan = LodPlan::new(design, &camera, SIZE, LodBudget::FINAL, None);
    let result = LodCompiler::default().check(design, &plan, &Cancel::never());
    result.map(drop).map_err(|error| error.to_string())
}

/// Draws a few pixels of a design.
fn drawn(design: &Design) -> Result<(), String> {
    let camera = Camera::from_design(&design.view.cameras[0]);
    let plan = LodPlan::new(design, &camera, SIZE, LodBudget::FINAL, None);
    let cloth = LodCompiler::default().make(design, plan, &Cancel::never());
    let cloth = cloth.map_err(|error| error.to_string())?;
    let settings = Settings {
        samples: 1,
        ..Settings::from(&design.quality)
    };
    let request = RenderRequest::new(cloth.view(design, &camera, SIZE), SIZE, settings);
    let mut backend = CpuBackend::default();
    backend.begin(&request).map_err(|error| error.to_string())?;
    let picture = finish(&mut backend, &request);
    assert!(
        picture
            .pixels
            .iter()
            .flatten()
            .all(|value| value.is_finite())
    );
    Ok(())
}

#[test]
fn what_is_checked_is_drawn_and_what_is_refused_is_refused_alike() {
    let numbers = numbers();
    let mut random = Pcg::new(0x1e57, 15);
    let (mut sound, mut refused_by_form) = (0, 0);
    for number in 0..1000 {
        let design = random_design(&numbers, &mut random);
        let (checked, drawn) = (checked(&design), drawn(&design));
        // Several faults are reported at once where the design itself has them.
        let first = |result: Result<(), String>| {
            result.map_err(|text| text.lines().next().map(str::to_owned))
        };
        assert_eq!(
            first(checked.clone()),
            first(drawn),
            "design {number}: {:?}",
            preset::write(&design)
        );
        sound += u32::from(checked.is_ok());
        let is_bent = |why: &String| why.starts_with("form.layers") || why.starts_with("form.kind");
        refused_by_form += u32::from(checked.as_ref().err().is_some_and(is_bent));
    }
    // Both happen often enough to tell.
    assert!(sound > 300, "only {sound} are sound");
    assert!(
        refused_by_form > 30,
        "only {refused_by_form} are refused for their form"
    );
}

#[test]
fn no_volume_is_made_of_what_is_refused() {
    let mut design = small_towel();
    design.form.kind = FormKind::Stack;
    design.form.layers = 60;
    let mut compiler = Compiler::default();
    let error = compiler.compile(&design).unwrap_err();
    assert!(matches!(error, CompileError::Invalid(_)), "{error}");
    let seconds = compiler.last_report().seconds;
    assert_eq!(
        (seconds.volumes, seconds.looks),
        (0.0, 0.0),
        "made for nothing"
    );
    // Neither by a check, of what is sound.
    compiler
        .check(&small_towel(), None, &Cancel::never())
        .unwrap();
    let seconds = compiler.last_report().seconds;
    assert_eq!(
        (seconds.volumes, seconds.looks),
        (0.0, 0.0),
        "made for a check"
    );
}
