//! Every shader program parses and validates, for every pair of features and for all that the presets ask for, and
//! errors are given by file and line.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use naga::back::pipeline_constants::process_overrides;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Expression, Function, Handle, Literal, TypeInner};
use renderer_core::design::{Method, Phase, SkeletonHeight, SkeletonShading};
use renderer_core::gpu::constants::{declare, prelude};
use renderer_core::gpu::dead_branches::without_dead_branches;
use renderer_core::gpu::pipeline_key::PipelineKey;
use renderer_core::gpu::shaders::{Composed, ERROR, FINALISE, Part, RESOLVE, TRACE};

use crate::support::scenes::{load_design, preset_paths, request};

/// The portable core: nothing that a WebGPU device may lack.
fn validator() -> Validator {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
}

/// Parses a program, or says where it is wrong.
pub fn parse(parts: &[Part]) -> naga::Module {
    parsed(&Composed::new(parts))
}

/// Parses a program as a device is given it for a pipeline with these constants.
pub fn parse_for(parts: &[Part], constants: &[(&str, f64)]) -> naga::Module {
    parsed(&Composed::new(parts).specialised(constants))
}

fn parsed(composed: &Composed) -> naga::Module {
    naga::front::wgsl::parse_str(&composed.text).unwrap_or_else(|error| {
        let line = error
            .location(&composed.text)
            .map_or(0, |location| location.line_number);
        let (file, line) = composed.place(line);
        panic!(
            "shaders/{file}:{line}: {}",
            error.emit_to_string(&composed.text)
        )
    })
}

/// Specialises and validates one entry point.
fn specialise(parts: &[Part], entry: &str, constants: &[(&str, f64)]) -> naga::Module {
    let module = parse_for(parts, constants);
    let info = validator().validate(&module).expect("the program is valid");
    let constants = constants
        .iter()
        .map(|&(name, value)| (name.to_owned(), value))
        .collect();
    let stage = Some((naga::ShaderStage::Compute, entry));
    let (module, _) = process_overrides(&module, &info, stage, &constants)
        .unwrap_or_else(|error| panic!("{entry} {constants:?}: {error}"));
    validator()
        .validate(&module)
        .unwrap_or_else(|error| panic!("{entry} {constants:?}: {error:?}"));
    module.into_owned()
}

/// How many values each feature of [`key_of`] has.
const CHOICES: [usize; 27] = [
    4, 5, 3, 3, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2,
];

/// The key that has one value of each feature.
fn key_of(values: &[usize; 27]) -> PipelineKey {
    let on = |place: usize| values[place] == 1;
    let methods = [
        Method::Single,
        Method::Layered,
        Method::Tracked,
        Method::Exact,
    ];
    let skeletons = [
        None,
        Some(SkeletonHeight::Winding),
        Some(SkeletonHeight::Paper),
    ];
    PipelineKey {
        method: methods[values[0]],
        // The last choice: materials scatter in different ways.
        phase: Phase::ALL.get(values[1]).copied(),
        skeleton: skeletons[values[2]],
        shading: SkeletonShading::ALL[values[3]],
        sky: values[4] as u32,
        layers: if on(5) { 16 } else { 5 },
        suns: if on(6) { 8 } else { 0 },
        areas: if on(7) { 4 } else { 0 },
        long_paths: on(8),
        path_cutoff: on(9),
        linear_layers: on(10),
        root_blend: on(11),
        environment: on(12),
        shadows: on(13),
        owen: on(14),
        sampled_environment: on(15),
        cached_shadows: on(16),
        bounced_light: on(17),
        bent: on(18),
        levels: on(19),
        aov: on(20),
        counters: on(21),
        filter_f32: on(22),
        opaque_rays: on(23),
        hidden_ground: on(24),
        last_looks: on(25),
        later_lights: on(26),
    }
}

/// Two features with a value each.
type Pair = [(usize, usize); 2];

/// Few sets of values in which every two values of two features meet: each begins with a pair that has not met yet, and
/// takes of every further feature the value that meets most that are new.
fn covering_array<const N: usize>(choices: &[usize; N]) -> Vec<[usize; N]> {
    let mut unmet: BTreeSet<Pair> = BTreeSet::new();
    for (one, &ones) in choices.iter().enumerate() {
        for (other, &others) in choices.iter().enumerate().skip(one + 1) {
            unmet.extend((0..ones).flat_map(|a| (0..others).map(move |b| [(one, a), (other, b)])));
        }
    }
    let mut rows = Vec::new();
    while let Some(&[first, second]) = unmet.first() {
        let mut chosen = vec![first, second];
        for (place, &count) in choices.iter().enumerate() {
            if place == first.0 || place == second.0 {
                continue;
            }
            let meets = |value: usize| {
                let pair = |&other: &(usize, usize)| {
                    let mut pair = [other, (place, value)];
                    pair.sort_unstable();
                    pair
                };
                chosen
                    .iter()
                    .filter(|other| unmet.contains(&pair(other)))
                    .count()
            };
            // Of equals another one each time.
            let values = (0..count).map(|k| (k + rows.len()) % count);
            let best = values
                .max_by_key(|&value| meets(value))
                .expect("has values");
            chosen.push((place, best));
        }
        chosen.sort_unstable();
        unmet.retain(|pair| !pair.iter().all(|part| chosen.contains(part)));
        rows.push(std::array::from_fn(|place| chosen[place].1));
    }
    rows
}

/// The two names of all overrides of which not all values meet in some key, or one that has a single value.
fn unmet(keys: &[PipelineKey]) -> Vec<[&'static str; 2]> {
    let rows: Vec<_> = keys.iter().map(PipelineKey::constants).collect();
    let mut values: BTreeMap<&str, HashSet<u64>> = BTreeMap::new();
    for &(name, value) in rows.iter().flatten() {
        values.entry(name).or_default().insert(value.to_bits());
    }
    let mut unmet = Vec::new();
    let names: Vec<&str> = rows[0].iter().map(|&(name, _)| name).collect();
    for (k, &one) in names.iter().enumerate() {
        for (l, &other) in names.iter().enumerate().skip(k + 1) {
            let met: HashSet<_> = (rows.iter())
                .map(|row| [row[k].1.to_bits(), row[l].1.to_bits()])
                .collect();
            let [ones, others] = [values[one].len(), values[other].len()];
            if ones < 2 || others < 2 || met.len() < ones * others {
                unmet.push([one, other]);
            }
        }
    }
    unmet
}

/// Keys in which all features meet in pairs.
fn pairwise_keys() -> Vec<PipelineKey> {
    covering_array(&CHOICES).iter().map(key_of).collect()
}

/// The keys of all presets, as they are drawn, with shadows cached where a window asks for it, and with all that a
/// picture file may hold; each once.
pub fn preset_keys() -> Vec<PipelineKey> {
    let mut keys = Vec::new();
    let mut seen = HashSet::new();
    for path in preset_paths() {
        let request = request(&load_design(&path), [64, 64]);
        let drawn = PipelineKey {
            levels: request.level_count() > 1,
            ..PipelineKey::new(request.scene(), &request.settings, false)
        };
        let several_levels = PipelineKey {
            levels: !drawn.bent,
            ..drawn
        };
        let live = PipelineKey {
            cached_shadows: true,
            path_cutoff: true,
            bounced_light: request.settings.bounces > 1,
            long_paths: request.settings.bounces > 1,
            ..several_levels
        };
        let filed = PipelineKey {
            aov: true,
            counters: true,
            ..several_levels
        };
        keys.extend(
            [drawn, live, filed]
                .into_iter()
                .filter(|&key| seen.insert(key)),
        );
    }
    keys
}

#[test]
fn all_pairs_of_features_meet() {
    let keys = pairwise_keys();
    eprintln!("{} keys", keys.len());
    assert_eq!(unmet(&keys), Vec::<[&str; 2]>::new());
    // Two features that are always the same, and one that never changes.
    let locked: Vec<_> = keys
        .iter()
        .map(|&key| PipelineKey {
            levels: key.bent,
            ..key
        })
        .collect();
    assert!(unmet(&locked).contains(&["BENT", "LEVELS"]));
    let never: Vec<_> = keys
        .iter()
        .map(|&key| PipelineKey { aov: false, ..key })
        .collect();
    assert!(unmet(&never).contains(&["AOV", "COUNTERS"]));
}

#[test]
fn the_tracing_program_is_valid_for_every_pair_of_features() {
    for needs in pairwise_keys() {
        specialise(TRACE, "trace_main", &needs.constants());
    }
    specialise(TRACE, "baseline_main", &pairwise_keys()[0].constants());
}

#[test]
fn the_tracing_program_is_valid_for_every_preset() {
    let keys = preset_keys();
    // Cloth that is bent has one level, and what has several is not: neither stands for the other.
    assert!(keys.iter().any(|key| key.bent && !key.levels));
    assert!(keys.iter().any(|key| key.levels && !key.bent));
    for needs in keys {
        specialise(TRACE, "trace_main", &needs.constants());
    }
}

/// Names of the functions that a pipeline is made of.
fn functions_for(key: &PipelineKey) -> BTreeSet<String> {
    let module = specialise(TRACE, "trace_main", &key.constants());
    let names = module
        .functions
        .iter()
        .filter_map(|(_, function)| function.name.clone());
    names.collect()
}

#[test]
fn a_pipeline_has_no_function_that_its_constants_rule_out() {
    let mut values = [0; 27];
    // Lit, with ground yarns.
    (values[2], values[6], values[13]) = (1, 1, 1);
    let single = key_of(&values);
    let has = |key: &PipelineKey, name: &str| functions_for(key).contains(name);
    for (with, name) in [
        (
            PipelineKey {
                method: Method::Exact,
                ..single
            },
            "exact_first",
        ),
        (
            PipelineKey {
                method: Method::Tracked,
                ..single
            },
            "track_visibility",
        ),
        (
            PipelineKey {
                long_paths: true,
                ..single
            },
            "track",
        ),
        (
            PipelineKey {
                bent: true,
                ..single
            },
            "next_segment",
        ),
        (PipelineKey { areas: 4, ..single }, "from_area"),
        (
            PipelineKey {
                path_cutoff: true,
                long_paths: true,
                ..single
            },
            "multiple_scattering",
        ),
    ] {
        assert!(has(&with, name) && !has(&single, name), "{name}");
    }
    assert!(has(&single, "composite_first"));
    assert!(!has(
        &PipelineKey {
            method: Method::Tracked,
            ..single
        },
        "composite_first"
    ));
}

#[test]
fn branches_that_are_never_taken_are_cut_from_the_text_alone() {
    let cut = |body: &str| {
        let text = format!("const ONE: u32 = 1u;\nfn f() {{ {body} }}");
        let cut = without_dead_branches(&text, &[("ON", 1.0), ("OFF", 0.0), ("N", 1.0)]);
        assert_eq!(cut.len(), text.len(), "{cut}");
        let (_, cut) = cut.split_once("fn f() {").expect("the function");
        cut.strip_suffix('}')
            .expect("its end")
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    for (body, left) in [
        ("if ON { a(); } b();", "{ a(); } b();"),
        ("if OFF { a(); } b();", "b();"),
        ("if !OFF { return; } b();", "{ return; }"),
        (
            "for (;;) { if ON { break; } b(); } c();",
            "for (;;) { { break; } } c();",
        ),
        (
            "if x { if ON { return; } a(); } b();",
            "if x { { return; } } b();",
        ),
        (
            "if ON { if x { return; } } b();",
            "{ if x { return; } } b();",
        ),
        ("if OFF { a(); } else { b(); }", "{ b(); }"),
        (
            "if ON { a(); } else if x { b(); } else { c(); }",
            "{ a(); }",
        ),
        (
            "if x { a(); } else if OFF { b(); } else { c(); }",
            "if x { a(); } else { c(); }",
        ),
        (
            "if x { a(); } else if ON { b(); } else { c(); }",
            "if x { a(); } else { b(); }",
        ),
        (
            "if OFF { a(); } else if OFF { b(); } else if x { c(); }",
            "if x { c(); }",
        ),
        ("if x { a(); } else if OFF { b(); }", "if x { a(); }"),
        ("if N == ONE && x { a(); }", "if N == ONE && x { a(); }"),
        ("if N != ONE && x { a(); }", ""),
        ("if x && (OFF || N > ONE) { a(); }", ""),
        ("if x || N >= ONE { a(); }", "{ a(); }"),
        ("if x || OFF { a(); }", "if x || OFF { a(); }"),
        (
            "if g(ON, OFF) || v.ON { a(); }",
            "if g(ON, OFF) || v.ON { a(); }",
        ),
        ("if N + 1u == ONE { a(); }", "if N + 1u == ONE { a(); }"),
        (
            "let on = ON && x; if on { a(); }",
            "let on = ON && x; if on { a(); }",
        ),
        (
            "let on = OFF && x; if on { a(); } b();",
            "let on = OFF && x; b();",
        ),
        // What a name is worth ends with its block, and with another of that name.
        (
            "{ let on = OFF; } if on { a(); }",
            "{ let on = OFF; } if on { a(); }",
        ),
        (
            "let on = OFF; { let on = x; if on { a(); } }",
            "let on = OFF; { let on = x; if on { a(); } }",
        ),
        (
            "let on = OFF; { var on = x; if on { a(); } }",
            "let on = OFF; { var on = x; if on { a(); } }",
        ),
        ("// if OFF {\n a();", "// if OFF { a();"),
        (
            "switch n { case 0u: { return; } default: { if ON { break; } a(); } } b();",
            "switch n { case 0u: { return; } default: { { break; } } } b();",
        ),
    ] {
        assert_eq!(cut(body), left, "{body}");
    }
}

#[test]
fn every_need_is_an_override_of_the_program_and_every_override_is_set() {
    let module = parse(TRACE);
    let mut declared: Vec<&str> = module
        .overrides
        .iter()
        .filter_map(|(_, value)| value.name.as_deref())
        .collect();
    let constants = pairwise_keys()[0].constants();
    let mut set: Vec<&str> = constants.iter().map(|&(name, _)| name).collect();
    declared.sort_unstable();
    set.sort_unstable();
    assert_eq!(declared, set);
}

#[test]
fn the_small_programs_are_valid() {
    for aov in [0.0, 1.0] {
        let constants = [("AOV", aov)];
        specialise(RESOLVE, "resolve_display", &constants);
        specialise(RESOLVE, "resolve_linear", &constants);
        specialise(ERROR, "error_main", &constants);
        specialise(FINALISE, "finalise_main", &constants);
    }
}

/// All functions of a module with their names.
fn functions(module: &naga::Module) -> impl Iterator<Item = (&str, &Function)> {
    let named = module.functions.iter().map(|(_, function)| function);
    named
        .chain(module.entry_points.iter().map(|entry| &entry.function))
        .map(|function| (function.name.as_deref().unwrap_or("entry point"), function))
}

/// Whether what an expression is a part of lies in a thread's own registers or scratch memory, rather than in a buffer,
/// a uniform or a workgroup's memory, where any element is as near as the first.
fn is_threads_own(module: &naga::Module, function: &Function, of: Handle<Expression>) -> bool {
    match function.expressions[of] {
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
            is_threads_own(module, function, base)
        }
        Expression::GlobalVariable(variable) => {
            module.global_variables[variable].space == AddressSpace::Private
        }
        // Loaded values, arguments, variables, constants and everything that was computed.
        _ => true,
    }
}

/// Functions in which a variable picks a part of a thread's own value: many devices keep such values in memory, or walk
/// through all their parts.
fn indexed_in_registers(module: &naga::Module) -> Vec<String> {
    functions(module)
        .filter(|(_, function)| {
            (function.expressions.iter()).any(|(_, expression)| match *expression {
                Expression::Access { base, .. } => is_threads_own(module, function, base),
                _ => false,
            })
        })
        .map(|(name, _)| name.to_owned())
        .collect()
}

#[test]
fn no_value_in_registers_is_indexed_by_a_variable() {
    for parts in [TRACE, RESOLVE, ERROR, FINALISE] {
        let indexed = indexed_in_registers(&parse(parts));
        let program = parts.last().expect("has parts").0;
        assert_eq!(indexed, Vec::<String>::new(), "{program}");
    }
    // What would be noticed, and what need not be.
    let program = |body: &str| {
        let text = format!(
            "struct S {{ a: vec4<f32>, b: array<vec4<f32>, 4> }}
             @group(0) @binding(0) var<uniform> uniforms: S;
             var<private> own: array<f32, 4>;
             var<workgroup> shared_by_all: array<f32, 4>;
             const TABLE: vec4<f32> = vec4<f32>(1.0, 2.0, 3.0, 4.0);
             fn f(i: u32, v: vec4<f32>, p: ptr<function, vec4<f32>>) -> f32 {{ {body} }}"
        );
        naga::front::wgsl::parse_str(&text).expect("valid WGSL")
    };
    for own in [
        "var list: array<f32, 4>; list[i] = 1.0; return list[0];",
        "return v[i];",
        "return (*p)[i];",
        "return own[i];",
        "return TABLE[i];",
        "let loaded = uniforms.a; return loaded[i];",
        "let copy = uniforms; return copy.b[i].x;",
    ] {
        assert_eq!(indexed_in_registers(&program(own)), ["f"], "{own}");
    }
    for others in [
        "return uniforms.a[i];",
        "return uniforms.b[i].x;",
        "return shared_by_all[i];",
        "var list = vec4<f32>(); list[2] = v[1]; return list.x;",
    ] {
        assert!(
            indexed_in_registers(&program(others)).is_empty(),
            "{others}"
        );
    }
}

#[test]
fn variables_of_the_tracing_program_are_few() {
    // What a thread holds at most if nothing is optimised: a hint, where drivers tell nothing. Arrays, which would be
    // in slow memory, there are none of.
    let module = parse(TRACE);
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("layout");
    let mut sizes = Vec::new();
    for (name, function) in functions(&module) {
        let mut bytes = 0;
        for (_, variable) in function.local_variables.iter() {
            let array = matches!(module.types[variable.ty].inner, TypeInner::Array { .. });
            assert!(!array, "{name} has an array");
            bytes += layouter[variable.ty].size;
        }
        sizes.push((bytes, name));
    }
    sizes.sort_unstable();
    let all: u32 = sizes.iter().map(|(bytes, _)| bytes).sum();
    eprintln!("{} functions, {all} bytes of variables; most:", sizes.len());
    for (bytes, name) in sizes.iter().rev().take(8) {
        eprintln!("{bytes:5} {name}");
    }
    let (most, name) = sizes.last().expect("has functions");
    assert!(*most <= 512, "{name} has {most} bytes of variables");
}

#[test]
fn entry_points_stand_in_the_files_that_say_so() {
    for parts in [TRACE, RESOLVE, ERROR, FINALISE] {
        for (name, text) in parts {
            let says = text.starts_with("// ENTRY ");
            assert_eq!(says, text.contains("@compute"), "shaders/{name}");
        }
    }
}

#[test]
fn lines_of_a_program_are_given_by_file() {
    let parts: [Part; 3] = [
        ("first.wgsl", "const A: u32 = 1u;\nconst B: u32 = 2u;\n"),
        (
            "second.wgsl",
            "const C: u32 = A;\n\nconst D: u32 = nowhere;",
        ),
        ("third.wgsl", "const E: u32 = 3u;\n"),
    ];
    let composed = Composed::new(&parts);
    let error = naga::front::wgsl::parse_str(&composed.text).expect_err("nowhere is unknown");
    let line = error
        .location(&composed.text)
        .expect("errors have places")
        .line_number;
    assert_eq!(composed.place(line), ("second.wgsl", 3));
    let before = prelude().lines().count() as u32;
    assert_eq!(composed.place(1), ("generated constants", 1));
    assert_eq!(composed.place(before), ("generated constants", before));
    assert_eq!(composed.place(before + 1), ("first.wgsl", 1));
    assert_eq!(composed.place(before + 3), ("second.wgsl", 1));
    assert_eq!(composed.place(before + 6), ("third.wgsl", 1));
}

#[test]
fn constants_reach_shaders_to_the_last_bit() {
    // Shortest digits, subnormal numbers, the largest, and what an f64 in between would round twice.
    let mut random = 1_u32;
    let mut values = vec![
        0.1_f32,
        1e-45,
        f32::MIN_POSITIVE,
        f32::MAX,
        1.0,
        16_777_216.0,
        1.000_000_1,
    ];
    values.extend((0..1000).map(|_| {
        random = renderer_core::sampling::hash(random);
        f32::from_bits(random & 0x7fff_ffff)
    }));
    values.retain(|value| value.is_finite());
    let mut text = String::new();
    for (k, value) in values.iter().enumerate() {
        declare(&mut text, &format!("C{k}"), value);
    }
    let module = naga::front::wgsl::parse_str(&text).expect("valid WGSL");
    let mut read = 0;
    for (_, constant) in module.constants.iter() {
        let name = constant.name.as_deref().expect("is named");
        let value = values[name[1..].parse::<usize>().expect("a number")];
        let literal = &module.global_expressions[constant.init];
        let Expression::Literal(Literal::F32(got)) = *literal else {
            panic!("{name} is {literal:?}");
        };
        assert_eq!(
            got.to_bits(),
            value.to_bits(),
            "{name}: {got} is not {value}"
        );
        read += 1;
    }
    assert_eq!(read, values.len());
}

#[test]
fn no_file_declares_what_is_generated() {
    for (name, text) in [TRACE, RESOLVE, ERROR, FINALISE].into_iter().flatten() {
        for line in prelude().lines() {
            let (constant, _) = line.split_once(':').expect("has a type");
            assert!(
                !text.contains(&format!("{constant}:")),
                "shaders/{name}: {constant}"
            );
        }
    }
}
