//! Every shader program parses and validates, for every combination of features that a scene can ask for, and errors
//! are told by file and line.

use naga::back::pipeline_constants::process_overrides;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Expression, Function, Handle, TypeInner};
use renderer_core::design::{Method, Phase, SkeletonHeight, SkeletonShading};
use renderer_core::gpu::pipeline_key::PipelineKey;
use renderer_core::gpu::shaders::{Composed, ERROR, FINALISE, Part, RESOLVE, TRACE};

/// The portable core: nothing that a WebGPU device may lack.
fn validator() -> Validator {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
}

/// Parses a program, or says where it is wrong.
fn parse(parts: &[Part]) -> naga::Module {
    let composed = Composed::new(parts);
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
fn specialise(module: &naga::Module, entry: &str, constants: &[(&str, f64)]) {
    let info = validator().validate(module).expect("the program is valid");
    let constants = constants
        .iter()
        .map(|&(name, value)| (name.to_owned(), value))
        .collect();
    let stage = Some((naga::ShaderStage::Compute, entry));
    let (module, _) = process_overrides(module, &info, stage, &constants)
        .unwrap_or_else(|error| panic!("{entry} {constants:?}: {error}"));
    validator()
        .validate(&module)
        .unwrap_or_else(|error| panic!("{entry} {constants:?}: {error:?}"));
}

fn all_needs() -> Vec<PipelineKey> {
    let mut all = Vec::new();
    let skeletons = [
        None,
        Some(SkeletonHeight::Winding),
        Some(SkeletonHeight::Paper),
    ];
    for &method in Method::ALL {
        for phase in Phase::ALL.iter().copied().map(Some).chain([None]) {
            for skeleton in skeletons {
                for flags in 0..1 << 7 {
                    let on = |bit: u32| flags >> bit & 1 == 1;
                    all.push(PipelineKey {
                        method,
                        phase,
                        skeleton,
                        shading: SkeletonShading::ALL[flags as usize % 3],
                        long_paths: on(0),
                        linear_layers: on(1),
                        layers: if on(1) { 16 } else { 5 },
                        root_blend: on(2),
                        suns: if on(3) { 8 } else { 0 },
                        areas: if on(3) == on(2) { 4 } else { 0 },
                        environment: on(4),
                        shadows: on(4) == on(6),
                        path_cutoff: on(5),
                        owen: on(3) == on(5),
                        sky: flags % 3,
                        drawn_sky: on(4) && flags % 3 == 2 && on(1),
                        levels: on(1) == on(5),
                        aov: on(5),
                        counters: on(6),
                        filter_f32: on(6),
                        opaque_rays: on(2),
                        hidden_ground: on(3) == on(4),
                        cached_shadows: on(2) == on(6),
                        bent: on(1) == on(5),
                    });
                }
            }
        }
    }
    all
}

#[test]
fn the_tracing_program_is_valid_for_every_combination_of_needs() {
    let module = parse(TRACE);
    // Every method, phase and skeleton with every seventh set of flags: all pairs of features meet many times,
    // and the test stays within seconds.
    for (index, needs) in all_needs().iter().enumerate() {
        if index % 7 == 0 {
            specialise(&module, "trace_main", &needs.constants());
        }
    }
    specialise(&module, "baseline_main", &all_needs()[0].constants());
}

#[test]
fn every_need_is_an_override_of_the_program_and_every_override_is_set() {
    let module = parse(TRACE);
    let mut declared: Vec<&str> = module
        .overrides
        .iter()
        .filter_map(|(_, value)| value.name.as_deref())
        .collect();
    let constants = all_needs()[0].constants();
    let mut set: Vec<&str> = constants.iter().map(|&(name, _)| name).collect();
    declared.sort_unstable();
    set.sort_unstable();
    assert_eq!(declared, set);
}

#[test]
fn the_small_programs_are_valid() {
    for aov in [0.0, 1.0] {
        let constants = [("AOV", aov)];
        let resolve = parse(RESOLVE);
        specialise(&resolve, "resolve_display", &constants);
        specialise(&resolve, "resolve_linear", &constants);
        specialise(&parse(ERROR), "error_main", &constants);
    }
    specialise(&parse(FINALISE), "finalise_main", &[]);
}

/// All functions of a module with their names.
fn functions(module: &naga::Module) -> impl Iterator<Item = (&str, &Function)> {
    let named = module.functions.iter().map(|(_, function)| function);
    named
        .chain(module.entry_points.iter().map(|entry| &entry.function))
        .map(|function| (function.name.as_deref().unwrap_or("entry point"), function))
}

/// Whether what an expression is a part of lies in a thread's own registers or scratch memory, rather than in a buffer, a
/// uniform or a workgroup's memory, where any element is as near as the first.
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
    // What a thread holds at most if nothing is optimised: a hint, where drivers tell nothing. Arrays, which would be in
    // slow memory, there are none of.
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
fn lines_of_a_program_are_told_by_file() {
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
    assert_eq!(composed.place(1), ("first.wgsl", 1));
    assert_eq!(composed.place(3), ("second.wgsl", 1));
    assert_eq!(composed.place(6), ("third.wgsl", 1));
}
