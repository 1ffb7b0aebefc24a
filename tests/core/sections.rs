//! Which sections of a scene an edit changes, and that nothing non-finite leaves compile.

use renderer_core::design::{
    AreaLight, ChartImage, Colour, Design, Fit, LengthEntry, LengthMap, Metering, Numbers, Pattern,
    Phase, PileKind, preset,
};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{CompileError, Compiler, SECTIONS, Scene, compile};

/// A small sheet with small volumes.
fn small() -> Design {
    let mut design = Design::default();
    (design.pile.layers, design.pile.resolution) = (2, 6);
    (design.pile.variants, design.pile.fibres) = (2, 10);
    (design.sheet.warps, design.sheet.wefts) = (12, 10);
    design.light.area = vec![AreaLight::default()];
    // A meter makes the background depend on all lights and on bounces.
    design.view.metering = Metering::None;
    design
}

/// Names of the sections that differ.
fn changed(a: &Scene, b: &Scene) -> Vec<&'static str> {
    let same = a.same_sections(b);
    let names = SECTIONS.into_iter().zip(same);
    names
        .filter_map(|(name, is_same)| (!is_same).then_some(name))
        .collect()
}

/// Sections that change when the design does.
fn changed_by(base: &Design, edit: impl FnOnce(&mut Design)) -> Vec<&'static str> {
    let mut compiler = Compiler::default();
    let before = compiler.compile(base).unwrap();
    let mut edited = base.clone();
    edit(&mut edited);
    let after = compiler.compile(&edited).unwrap();
    changed(&before, &after)
}

/// Every number of the design: its path, a value that differs, and the sections that must change.
fn every_number(design: &Design) -> Vec<(String, f64, &'static [&'static str])> {
    let sections: [(&str, &dyn Numbers); 14] = [
        ("sheet", &design.sheet),
        ("chart", &design.chart),
        ("length", &design.length),
        ("pile", &design.pile),
        ("turbulence", &design.turbulence),
        ("finish", &design.finish),
        ("nap", &design.nap),
        ("skeleton", &design.skeleton),
        ("form", &design.form),
        ("light.sun[0]", &design.light.sun[0]),
        ("light.area[0]", &design.light.area[0]),
        ("light.environment", &design.light.environment),
        ("view", &design.view),
        ("quality", &design.quality),
    ];
    let mut all = Vec::new();
    for (section, numbers) in sections {
        for (field, value) in numbers.numbers() {
            let other = if field.integer {
                value + if value < field.max { 1.0 } else { -1.0 }
            } else {
                let up = value * 1.01 + 0.01;
                if up <= field.max { up } else { value * 0.99 }
            };
            let sections: &[&str] = match (section, field.name) {
                ("sheet", "warps" | "wefts") => &["sheet", "loops", "looks"],
                ("sheet", _) => &["sheet", "loops"],
                ("length", "value") => &["loops", "volumes"],
                // The length map is constant.
                ("length", _) => &[],
                ("pile", "base_width" | "thickness") => &["loops", "volumes"],
                ("pile", "yarn_diameter" | "plies" | "twist_per_cm" | "fibres" | "hairiness") => {
                    &["volumes"]
                }
                ("pile", "layers" | "resolution" | "root_blend") => &["volumes"],
                ("pile", "variants") => &["looks", "volumes"],
                ("pile", "density" | "transmission" | "specular" | "exponent") => &["pile"],
                ("pile", "max_albedo") => &["looks"],
                ("pile", _) => &["loops"],
                ("turbulence", "seed") => &["loops", "looks"],
                ("turbulence", _) => &["loops"],
                ("finish", "wetness") => &["loops", "looks", "volumes", "pile", "skeleton"],
                ("finish", "pulled") => &["loops"],
                // Nothing is shorn, pulled or wet.
                ("finish", _) => &[],
                // There is no map.
                ("nap", _) => &[],
                // No root stands on a weft here.
                ("skeleton", "weft_radius" | "specular" | "exponent" | "fibre_spacing") => {
                    &["skeleton"]
                }
                ("skeleton", _) => &["loops", "skeleton"],
                // The light is constant.
                ("light.environment", "rotation") => &[],
                ("light.sun[0]" | "light.area[0]" | "light.environment", _) => &["lights"],
                // How much of the light comes back decides how bright fibres must be for a colour.
                ("quality", "bounces") => &["looks"],
                // View and the rest of quality belong to the request.
                _ => &[],
            };
            all.push((format!("{section}.{}", field.name), other, sections));
        }
    }
    all
}

#[test]
fn every_number_changes_its_sections_and_no_other() {
    let base = small();
    let numbers = every_number(&base);
    assert!(numbers.len() > 50);
    for (path, value, sections) in numbers {
        let found = changed_by(&base, |design| {
            *design = preset::set(design, &path, &value.to_string()).unwrap();
        });
        assert_eq!(found, sections, "{path} = {value}");
    }
}

#[test]
fn choices_change_their_sections_and_no_other() {
    for (path, value, sections) in [
        (
            "weave.pattern",
            "[[7]]",
            &["loops", "looks", "skeleton"][..],
        ),
        ("weave.back", "none", &["loops", "looks"]),
        ("chart.colour", "#803020", &["looks"]),
        ("chart.fit", "tile", &[]),
        ("chart.fit", "place", &[]),
        ("chart.average", "true", &[]),
        ("chart.mirror_x", "true", &[]),
        ("chart.half_drop", "true", &[]),
        ("length.map", "gray", &["loops", "volumes"]),
        ("length.curve", "[[0.0, 0.0], [1.0, 0.5]]", &[]),
        ("pile.kind", "cut", &["volumes"]),
        ("pile.phase", "frame_lambert", &["looks", "pile"]),
        // Only fibres need their directions in the volumes.
        ("pile.phase", "kajiya_kay", &["looks", "volumes", "pile"]),
        ("pile.interpolation", "nearest", &["volumes"]),
        ("turbulence.kind", "worley", &["loops"]),
        ("turbulence.filter", "box", &["loops"]),
        (
            "finish.sheared",
            "front",
            &["loops", "looks", "volumes", "pile"],
        ),
        ("nap.fit", "tile", &[]),
        ("skeleton.height", "paper", &["loops", "skeleton"]),
        ("skeleton.shading", "phong", &["skeleton"]),
        ("skeleton.colour", "#803020", &["looks", "skeleton"]),
        ("skeleton.visible", "false", &["skeleton"]),
        ("light.background", "#803020", &["lights"]),
        ("light.environment.colour", "#803020", &["lights"]),
        ("light.environment.kind", "gradient", &["lights"]),
        ("light.environment.zenith", "#803020", &[]),
        ("light.environment.horizon", "#803020", &[]),
        ("light.environment.ground", "#803020", &[]),
        ("light.environment.image", "sky.hdr", &[]),
        ("view.tone_map", "filmic", &[]),
        ("view.cameras[0].distance", "100", &[]),
        ("quality.method", "single", &[]),
        ("quality.sampler", "random", &[]),
        ("quality.shadows", "false", &[]),
    ] {
        let found = changed_by(&small(), |design| {
            *design = preset::set(design, path, value).unwrap();
        });
        assert_eq!(found, sections, "{path} = {value}");
    }
}

#[test]
fn bounces_decide_how_bright_fibres_must_be_for_a_colour() {
    let mut base = small();
    base.chart.colour = Colour([90, 120, 160]);
    assert_eq!(
        changed_by(&base, |design| design.quality.bounces = 1),
        ["looks"]
    );
    base.view.metering = Metering::Incident;
    assert_eq!(
        changed_by(&base, |design| design.quality.bounces = 1),
        ["looks", "lights"]
    );
    assert_eq!(
        changed_by(&base, |design| design.view.metering = Metering::None),
        ["lights"]
    );
}

fn painted(colour: [u8; 4]) -> Option<ChartImage> {
    let mut pixels = vec![[200, 200, 200, 255]; 120];
    pixels[17] = colour;
    ChartImage::new(12, 10, &pixels)
}

#[test]
fn painting_the_chart_rebuilds_loops_only_where_lengths_follow() {
    let mut base = small();
    base.weave.pattern = Pattern::filled(1, 1, 7);
    base.chart.pixels = painted([200, 200, 200, 255]);
    base.chart.fit = Fit::Tile;
    let paint =
        |base: &Design, colour| changed_by(base, |design| design.chart.pixels = painted(colour));
    assert_eq!(paint(&base, [90, 20, 20, 255]), ["looks"]);
    assert_eq!(paint(&base, [200, 200, 200, 0]), ["loops", "looks"]);
    base.length.map = LengthMap::Gray;
    assert_eq!(paint(&base, [90, 20, 20, 255]), ["loops", "looks"]);
    // Without image, the chart's colour is all loops' brightness.
    base.chart.pixels = None;
    let found = changed_by(&base, |design| design.chart.colour = Colour([90; 3]));
    assert_eq!(found, ["loops", "looks"]);
}

#[test]
fn rows_of_the_table_change_what_they_name() {
    let mut base = small();
    base.length.map = LengthMap::Lut;
    base.length.table = vec![LengthEntry::default(); 2];
    base.length.table[1].colour = Colour([0; 3]);
    let edit =
        |edit: fn(&mut LengthEntry)| changed_by(&base, |design| edit(&mut design.length.table[0]));
    assert_eq!(edit(|row| row.length = 2.5), ["loops"]);
    assert_eq!(edit(|row| row.length = 3.5), ["loops", "volumes"]);
    assert_eq!(edit(|row| row.albedo_scale = 0.5), ["looks"]);
    assert_eq!(edit(|row| row.density = Some(5.0)), ["looks", "pile"]);
    assert_eq!(edit(|row| row.lean_x = Some(5.0)), ["loops"]);
    assert_eq!(edit(|row| row.lean_y = Some(5.0)), ["loops"]);
    assert_eq!(edit(|row| row.tilt = Some(5.0)), ["loops"]);
    assert_eq!(edit(|row| row.top_width = Some(1.5)), ["loops"]);
    assert_eq!(
        edit(|row| row.yarn_diameter = Some(0.5)),
        ["looks", "volumes", "pile"]
    );
    assert_eq!(
        edit(|row| row.phase = Some(Phase::FrameLambert)),
        ["looks", "pile"]
    );
    assert_eq!(
        edit(|row| row.phase = Some(Phase::KajiyaKay)),
        ["looks", "volumes", "pile"]
    );
    assert_eq!(edit(|row| row.transmission = Some(0.2)), ["looks", "pile"]);
    assert_eq!(edit(|row| row.specular = Some(0.2)), ["looks", "pile"]);
    assert_eq!(edit(|row| row.exponent = Some(20.0)), ["looks", "pile"]);
    assert_eq!(
        edit(|row| row.kind = Some(PileKind::Cut)),
        ["looks", "volumes", "pile"]
    );
}

#[test]
fn an_equal_design_is_the_same_scene() {
    let mut compiler = Compiler::default();
    let first = compiler.compile(&small()).unwrap();
    let second = compiler.compile(&small()).unwrap();
    assert!(std::sync::Arc::ptr_eq(&first, &second));
    // Undone edits compile to equal records, in new sections.
    let fresh = compile(&small()).unwrap();
    assert_eq!(fresh.loops.shapes, first.loops.shapes);
    assert_eq!(fresh.loops.entries, first.loops.entries);
    assert_eq!(*fresh.looks, *first.looks);
}

#[test]
fn a_faulty_design_names_its_faults_and_keeps_the_last_scene() {
    let mut compiler = Compiler::default();
    let first = compiler.compile(&small()).unwrap();
    let mut faulty = small();
    faulty.pile.tilt = f64::NAN;
    faulty.weave.pattern.set(1, 0, 5);
    let error = compiler.compile(&faulty).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("pile.tilt is NaN"), "{text}");
    assert!(text.contains("weave.pattern[0][1] is 5"), "{text}");
    assert!(matches!(error, CompileError::Invalid(faults) if faults.len() == 2));
    let again = compiler.compile(&small()).unwrap();
    assert!(std::sync::Arc::ptr_eq(&first, &again));
}

fn assert_finite(scene: &Scene, what: &str) {
    let finite = |numbers: &[f32]| numbers.iter().all(|x| x.is_finite());
    let loops = &scene.loops;
    for index in 0..loops.shapes.len() {
        let shape = loops.patch(index);
        assert!(
            finite(&shape.axis)
                && finite(&shape.half_top)
                && finite(&[shape.root_z0, shape.root_z1]),
            "{what}: {shape:?}"
        );
        let [b, c, _] = shape.coefficients(loops.base_width_mm);
        assert!(b.cross(c).length() > 0.0, "{what}: {shape:?}");
    }
    assert!(finite(&loops.z_range_mm) && finite(&[loops.height_unit_mm, loops.thickness_mm]));
    assert!(loops.height_unit_mm > 0.0, "{what}");
    for (index, header) in loops.headers[..loops.headers.len() - 1].iter().enumerate() {
        let [low, high] = header.z_units();
        assert!(
            loops.entries_of(index).is_empty() == (low > high),
            "{what}: {header:?}"
        );
    }
    assert!(finite(&scene.volumes.reference_size_mm), "{what}");
    assert!(scene.pile.materials.iter().all(|m| finite(&[
        m.density_per_mm,
        m.transmission,
        m.specular,
        m.exponent
    ])));
    let lights = &scene.lights;
    let suns = lights.suns.iter();
    assert!(
        suns.flat_map(|sun| sun.direction.into_iter().chain(sun.irradiance))
            .chain(lights.environment)
            .all(f64::is_finite)
    );
    assert!(lights.areas.iter().all(|area| {
        let [x, y] = area.half_sides;
        [area.centre, x, y, area.facing, area.intensity]
            .iter()
            .flatten()
            .all(|value| value.is_finite())
    }));
}

#[test]
fn everything_is_finite_at_the_ends_of_all_ranges() {
    let mut random = Pcg::new(5, 0);
    let mut compiled = 0;
    for round in 0..400 {
        let mut design = small();
        for (section, numbers) in [
            ("length", &small().length as &dyn Numbers),
            ("pile", &small().pile),
            ("turbulence", &small().turbulence),
            ("finish", &small().finish),
            ("skeleton", &small().skeleton),
            ("light.sun[0]", &small().light.sun[0]),
            ("light.area[0]", &small().light.area[0]),
        ] {
            for (field, default) in numbers.numbers() {
                // Volumes are large at their ends, and are tested on their own.
                if ["layers", "resolution", "variants", "fibres"].contains(&field.name) {
                    continue;
                }
                let value = match (random.next_float() * 6.0) as u32 {
                    0 => field.min,
                    1 => field.max,
                    _ => default,
                };
                let path = format!("{section}.{}", field.name);
                design = preset::set(&design, &path, &value.to_string()).unwrap();
            }
        }
        // So that long pile stays within reach of a list.
        (design.sheet.warps_per_cm, design.sheet.wefts_per_cm) = (0.5, 0.5 + f64::from(round % 7));
        match compile(&design) {
            Ok(scene) => {
                compiled += 1;
                assert_finite(&scene, &format!("{design:?}"));
            }
            Err(error) => {
                // Only relations can be violated here.
                let text = error.to_string();
                assert!(
                    text.contains("max_length")
                        || text.contains("length.m")
                        || text.contains("light.area[0].distance"),
                    "{text}"
                );
            }
        }
    }
    assert!(compiled > 200, "only {compiled} compiled");
}
