//! Every pipeline that presets ask for can be translated for all interfaces that users have, Vulkan, Metal, Direct3D
//! and OpenGL ES, as wgpu translates it there, and keeps to the limits of the adapters that the program takes.

use std::io::Write as _;
use std::process::{Command, Stdio};

use naga::back::pipeline_constants::process_overrides;
use naga::back::{glsl, hlsl, msl, spv};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{
    AddressSpace, ImageClass, Module, ResourceBinding, ShaderStage, StorageAccess, TypeInner,
};
use renderer_core::gpu::constants::WORKGROUP;
use renderer_core::gpu::context::STORAGE_BUFFERS;
use renderer_core::gpu::shaders::{ERROR, FINALISE, Part, RESOLVE, TRACE};

use crate::shaders::{parse_for, preset_keys};

/// An entry point with its constants put in.
struct Pipeline {
    entry: &'static str,
    module: Module,
    info: ModuleInfo,
}

impl Pipeline {
    fn new(parts: &[Part], entry: &'static str, constants: &[(&str, f64)]) -> Self {
        let module = parse_for(parts, constants);
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .expect("the program is valid");
        let constants = constants
            .iter()
            .map(|&(name, value)| (name.to_owned(), value))
            .collect();
        let stage = Some((ShaderStage::Compute, entry));
        let (module, info) =
            process_overrides(&module, &info, stage, &constants).expect("has its constants");
        Self {
            entry,
            module: module.into_owned(),
            info: info.into_owned(),
        }
    }

    /// What the entry point uses, in the order of its bindings.
    fn resources(&self) -> Vec<(ResourceBinding, Resource)> {
        let place = self
            .module
            .entry_points
            .iter()
            .position(|entry| entry.name == self.entry);
        let used = self.info.get_entry_point(place.expect("is there"));
        let mut resources: Vec<_> = (self.module.global_variables.iter())
            .filter(|(handle, _)| !used[*handle].is_empty())
            .filter_map(|(_, variable)| {
                let resource = match (variable.space, &self.module.types[variable.ty].inner) {
                    (AddressSpace::Uniform, _) => Resource::Uniform,
                    (AddressSpace::Storage { access }, _) => Resource::Storage {
                        is_written: access.contains(StorageAccess::STORE),
                    },
                    (_, TypeInner::Sampler { .. }) => Resource::Sampler,
                    (
                        _,
                        TypeInner::Image {
                            class: ImageClass::Storage { .. },
                            ..
                        },
                    ) => Resource::Image,
                    _ => Resource::Texture,
                };
                Some((variable.binding?, resource))
            })
            .collect();
        resources.sort_unstable();
        resources
    }

    /// Bytes of a workgroup's memory.
    fn workgroup_bytes(&self) -> u32 {
        let variables = self.module.global_variables.iter();
        variables
            .filter(|(_, variable)| variable.space == AddressSpace::WorkGroup)
            .map(|(_, variable)| {
                self.module.types[variable.ty]
                    .inner
                    .size(self.module.to_ctx())
            })
            .sum()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Resource {
    Uniform,
    Storage { is_written: bool },
    Texture,
    Image,
    Sampler,
}

/// All pipelines of presets, and those that every picture needs.
fn pipelines() -> Vec<Pipeline> {
    let keys = preset_keys();
    let mut pipelines: Vec<Pipeline> = (keys.iter())
        .map(|key| Pipeline::new(TRACE, "trace_main", &key.constants()))
        .collect();
    let constants = keys[0].constants();
    pipelines.push(Pipeline::new(TRACE, "baseline_main", &constants));
    for aov in [0.0, 1.0] {
        let constants = [("AOV", aov)];
        pipelines.push(Pipeline::new(RESOLVE, "resolve_display", &constants));
        pipelines.push(Pipeline::new(RESOLVE, "resolve_linear", &constants));
        pipelines.push(Pipeline::new(ERROR, "error_main", &constants));
    }
    pipelines.push(Pipeline::new(FINALISE, "finalise_main", &[]));
    pipelines
}

/// Numbers resources of each kind from 0 on, as OpenGL and Metal have them.
fn numbered<T>(
    pipeline: &Pipeline,
    kind: impl Fn(Resource) -> usize,
    target: impl Fn(Resource, u8) -> T,
) -> impl Iterator<Item = (ResourceBinding, T)> {
    let mut next = [0_u8; 5];
    pipeline
        .resources()
        .into_iter()
        .map(move |(binding, resource)| {
            let number = &mut next[kind(resource)];
            *number += 1;
            (binding, target(resource, *number - 1))
        })
}

/// Metal as of macOS 10.13.
fn to_msl(pipeline: &Pipeline) -> Result<String, String> {
    let target = |resource, number| {
        let mut target = msl::BindTarget::default();
        match resource {
            Resource::Uniform => target.buffer = Some(number),
            Resource::Storage { is_written } => {
                (target.buffer, target.mutable) = (Some(number), is_written);
            }
            Resource::Texture => target.texture = Some(number),
            Resource::Image => (target.texture, target.mutable) = (Some(number), true),
            Resource::Sampler => target.sampler = Some(msl::BindSamplerTarget::Resource(number)),
        }
        target
    };
    let kind = |resource| match resource {
        Resource::Uniform | Resource::Storage { .. } => 0,
        Resource::Texture | Resource::Image => 1,
        Resource::Sampler => 2,
    };
    let resources = msl::EntryPointResources {
        resources: numbered(pipeline, kind, target).collect(),
        // Behind the others, of which Metal has 31.
        sizes_buffer: Some(30),
        immediates_buffer: None,
    };
    let options = msl::Options {
        lang_version: (2, 0),
        fake_missing_bindings: false,
        per_entry_point_map: [(pipeline.entry.to_owned(), resources)].into(),
        ..msl::Options::default()
    };
    let only = msl::PipelineOptions {
        entry_point: Some((ShaderStage::Compute, pipeline.entry.to_owned())),
        ..msl::PipelineOptions::default()
    };
    let (text, info) = msl::write_string(&pipeline.module, &pipeline.info, &options, &only)
        .map_err(|error| error.to_string())?;
    let names: Result<Vec<String>, _> = info.entry_point_names.into_iter().collect();
    names.map_err(|error| error.to_string())?;
    Ok(text)
}

/// Direct3D 12 with the oldest shader model that wgpu writes, which every Direct3D 12 device takes.
fn to_hlsl(pipeline: &Pipeline) -> Result<String, String> {
    let options = hlsl::Options {
        shader_model: hlsl::ShaderModel::V5_1,
        ..hlsl::Options::default()
    };
    let only = hlsl::PipelineOptions {
        entry_point: Some((ShaderStage::Compute, pipeline.entry.to_owned())),
    };
    let mut text = String::new();
    let info = hlsl::Writer::new(&mut text, &options, &only)
        .write(&pipeline.module, &pipeline.info, None)
        .map_err(|error| error.to_string())?;
    let names: Result<Vec<String>, _> = info.entry_point_names.into_iter().collect();
    names.map_err(|error| error.to_string())?;
    Ok(text)
}

/// OpenGL ES 3.1, the first that computes.
fn to_glsl(pipeline: &Pipeline) -> Result<String, String> {
    let kind = |resource| match resource {
        Resource::Uniform => 0,
        Resource::Storage { .. } => 1,
        Resource::Texture => 2,
        Resource::Image => 3,
        Resource::Sampler => 4,
    };
    let options = glsl::Options {
        version: glsl::Version::Embedded {
            version: 310,
            is_webgl: false,
        },
        binding_map: numbered(pipeline, kind, |_, number| number).collect(),
        ..glsl::Options::default()
    };
    let only = glsl::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: pipeline.entry.to_owned(),
        multiview: None,
    };
    let mut text = String::new();
    let policies = BoundsCheckPolicies::default();
    glsl::Writer::new(
        &mut text,
        &pipeline.module,
        &pipeline.info,
        &options,
        &only,
        policies,
    )
    .and_then(|mut writer| writer.write())
    .map_err(|error| error.to_string())?;
    Ok(text)
}

/// Vulkan 1.0.
fn to_spirv(pipeline: &Pipeline) -> Result<Vec<u32>, String> {
    let options = spv::Options {
        lang_version: (1, 0),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Restrict,
            image_load: BoundsCheckPolicy::Restrict,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        ..spv::Options::default()
    };
    let only = spv::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: pipeline.entry.to_owned(),
    };
    spv::write_vec(&pipeline.module, &pipeline.info, &options, Some(&only))
        .map_err(|error| error.to_string())
}

/// Capabilities that every Vulkan device has: Matrix, Shader, ImageQuery.
const COMMON: [u32; 3] = [0, 1, 50];

/// Numbers of the capabilities that a module asks for.
fn capabilities(words: &[u32]) -> Vec<u32> {
    const HEADER: usize = 5;
    const OP_CAPABILITY: u32 = 17 | 2 << 16;
    let mut asked: Vec<u32> = (words[HEADER..].chunks_exact(2))
        .take_while(|pair| pair[0] == OP_CAPABILITY)
        .map(|pair| pair[1])
        .collect();
    asked.sort_unstable();
    asked
}

/// What Khronos' validator has against a module, if anything.
fn spirv_faults(words: &[u32]) -> Option<String> {
    let mut validator = Command::new("spirv-val")
        .args(["--target-env", "vulkan1.0", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| {
            panic!("spirv-val: {error}; it comes with Debian's package spirv-tools")
        });
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let mut input = validator.stdin.take().unwrap();
    input.write_all(&bytes).unwrap();
    drop(input);
    let end = validator.wait_with_output().unwrap();
    (!end.status.success()).then(|| String::from_utf8_lossy(&end.stderr).into_owned())
}

#[test]
fn pipelines_of_presets_can_be_translated_for_every_interface() {
    let pipelines = pipelines();
    eprintln!("{} pipelines", pipelines.len());
    for (number, pipeline) in pipelines.iter().enumerate() {
        let what = format!("{} {number}", pipeline.entry);
        for (language, result) in [
            ("MSL", to_msl(pipeline)),
            ("HLSL", to_hlsl(pipeline)),
            ("GLSL ES", to_glsl(pipeline)),
        ] {
            let text = result.unwrap_or_else(|error| panic!("{what} in {language}: {error}"));
            assert!(!text.is_empty(), "{what} in {language}");
        }
        let words = to_spirv(pipeline).unwrap_or_else(|error| panic!("{what} in SPIR-V: {error}"));
        let asked = capabilities(&words);
        assert!(
            asked.iter().all(|asked| COMMON.contains(asked)),
            "{what}: {asked:?}"
        );
        assert_eq!(spirv_faults(&words), None, "{what}");
    }
}

#[test]
fn what_an_interface_lacks_would_be_noticed() {
    let text = "@group(0) @binding(0) var<storage, read_write> out: array<f64>;
        @compute @workgroup_size(64) fn trace_main() { out[0] = out[1] * out[2]; }";
    let module = naga::front::wgsl::parse_str(text).expect("valid WGSL");
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .expect("valid with all capabilities");
    let pipeline = Pipeline {
        entry: "trace_main",
        module,
        info,
    };
    assert!(to_glsl(&pipeline).is_err(), "OpenGL ES has no f64");
    let words = to_spirv(&pipeline).unwrap();
    let asked = capabilities(&words);
    assert!(
        !asked.iter().all(|asked| COMMON.contains(asked)),
        "nor has every Vulkan device"
    );
    let mut words = to_spirv(&Pipeline::new(FINALISE, "finalise_main", &[])).unwrap();
    assert_eq!(spirv_faults(&words), None);
    let middle = words.len() / 2;
    words.remove(middle);
    assert!(spirv_faults(&words).is_some(), "a word is missing");
}

/// The limits that a pipeline goes beyond: name, what it needs, what is allowed.
fn beyond(pipeline: &Pipeline, limits: &wgpu::Limits) -> Vec<(&'static str, u32, u32)> {
    let resources = pipeline.resources();
    let count = |of: &dyn Fn(Resource) -> bool| {
        resources
            .iter()
            .filter(|&&(_, resource)| of(resource))
            .count() as u32
    };
    let most_bindings = resources
        .iter()
        .map(|(binding, _)| binding.binding + 1)
        .max()
        .unwrap_or(0);
    [
        (
            "storage buffers",
            count(&|r| matches!(r, Resource::Storage { .. })),
            limits.max_storage_buffers_per_shader_stage,
        ),
        (
            "uniform buffers",
            count(&|r| r == Resource::Uniform),
            limits.max_uniform_buffers_per_shader_stage,
        ),
        (
            "textures",
            count(&|r| r == Resource::Texture),
            limits.max_sampled_textures_per_shader_stage,
        ),
        (
            "images",
            count(&|r| r == Resource::Image),
            limits.max_storage_textures_per_shader_stage,
        ),
        (
            "samplers",
            count(&|r| r == Resource::Sampler),
            limits.max_samplers_per_shader_stage,
        ),
        (
            "bindings of a group",
            most_bindings,
            limits.max_bindings_per_bind_group,
        ),
        (
            "bytes of a workgroup",
            pipeline.workgroup_bytes(),
            limits.max_compute_workgroup_storage_size,
        ),
        (
            "threads of a workgroup",
            WORKGROUP,
            limits.max_compute_invocations_per_workgroup,
        ),
        (
            "threads along x",
            WORKGROUP,
            limits.max_compute_workgroup_size_x,
        ),
    ]
    .into_iter()
    .filter(|&(_, needed, allowed)| needed > allowed)
    .collect()
}

#[test]
fn pipelines_need_no_more_than_adapters_must_have_but_storage_buffers() {
    let mut most = 0;
    for pipeline in pipelines() {
        for bound in &pipeline.module.global_variables.iter().collect::<Vec<_>>() {
            assert!(
                bound.1.binding.is_none_or(|binding| binding.group < 2),
                "a third group"
            );
        }
        assert_eq!(
            beyond(&pipeline, &wgpu::Limits::defaults()),
            [],
            "{}",
            pipeline.entry
        );
        for (what, needed, allowed) in beyond(&pipeline, &wgpu::Limits::downlevel_defaults()) {
            // Adapters that have fewer are not taken.
            assert_eq!(
                what, "storage buffers",
                "{}: {needed} of {allowed}",
                pipeline.entry
            );
            most = most.max(needed);
        }
    }
    assert_eq!(
        most, STORAGE_BUFFERS,
        "what adapters are asked for is what is needed"
    );
}

#[test]
fn constants_of_a_scene_fit_the_smallest_uniform_buffers() {
    let allowed = wgpu::Limits::downlevel_defaults().max_uniform_buffer_binding_size;
    for host in renderer_core::gpu::layout::STRUCTS {
        assert!(host.size as u64 <= allowed, "{}: {}", host.name, host.size);
    }
}
