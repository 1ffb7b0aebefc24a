//! Runs an entry point of probe.wgsl, which stands behind the whole tracing program, on the tests' device.

use bytemuck::Pod;
use renderer_core::gpu::constants::WORKGROUP;
use renderer_core::gpu::shaders::{Composed, Part, TRACE};

use super::device::context;

/// The inputs' and the answers' binding in group 2.
pub struct Probe {
    pub entry: &'static str,
    pub bindings: [u32; 2],
    /// Bytes of one answer.
    pub answer_size: u64,
    /// The scene's constants, where the entry point reads them.
    pub scene: Option<Vec<u8>>,
}

/// A file of entry points other than probe.wgsl, and what they need.
pub struct Special<'a> {
    pub part: Part,
    /// Values of `override` constants.
    pub constants: &'a [(&'static str, f64)],
    /// The table of N_p: a row of so many numbers each.
    pub highlight: (u32, &'a [f32]),
}

/// Answers of `probe` to every input.
pub fn ask<I: Pod, A: Pod>(probe: &Probe, inputs: &[I]) -> Vec<A> {
    ask_special(probe, None, inputs)
}

/// Answers of `probe` of another file to every input.
pub fn ask_special<I: Pod, A: Pod>(
    probe: &Probe,
    special: Option<&Special<'_>>,
    inputs: &[I],
) -> Vec<A> {
    let context = context();
    let (device, queue) = (&context.device, &context.queue);
    let mut parts: Vec<Part> = TRACE.to_vec();
    let own = ("probe.wgsl", include_str!("probe.wgsl"));
    parts.push(special.map_or(own, |special| special.part));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("probe"),
        source: wgpu::ShaderSource::Wgsl(Composed::new(&parts).text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(probe.entry),
        layout: None,
        module: &module,
        entry_point: Some(probe.entry),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: special.map_or(&[], |special| special.constants),
            ..Default::default()
        },
        cache: None,
    });
    let buffer = |bytes: u64, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let input_bytes: &[u8] = bytemuck::cast_slice(inputs);
    let answer_bytes = probe.answer_size * inputs.len() as u64;
    let input = buffer(input_bytes.len() as u64, wgpu::BufferUsages::STORAGE);
    queue.write_buffer(&input, 0, input_bytes);
    let answers = buffer(
        answer_bytes,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    );
    let back = buffer(answer_bytes, wgpu::BufferUsages::MAP_READ);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(2),
        entries: &[
            wgpu::BindGroupEntry {
                binding: probe.bindings[0],
                resource: input.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: probe.bindings[1],
                resource: answers.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        if let Some(bytes) = &probe.scene {
            let scene = buffer(bytes.len() as u64, wgpu::BufferUsages::UNIFORM);
            queue.write_buffer(&scene, 0, bytes);
            let mut entries = vec![wgpu::BindGroupEntry {
                binding: 0,
                resource: scene.as_entire_binding(),
            }];
            let table = special.map(|special| highlight_table(device, queue, special.highlight));
            if let Some(table) = &table {
                entries.push(wgpu::BindGroupEntry {
                    binding: 6,
                    resource: wgpu::BindingResource::TextureView(table),
                });
            }
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &pipeline.get_bind_group_layout(0),
                entries: &entries,
            });
            pass.set_bind_group(0, &group, &[]);
        }
        pass.set_bind_group(2, &group, &[]);
        pass.dispatch_workgroups((inputs.len() as u32).div_ceil(WORKGROUP), 1, 1);
    }
    encoder.copy_buffer_to_buffer(&answers, 0, &back, 0, answer_bytes);
    queue.submit([encoder.finish()]);
    back.slice(..)
        .map_async(wgpu::MapMode::Read, |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    bytemuck::pod_collect_to_vec(&back.slice(..).get_mapped_range().unwrap())
}

fn highlight_table(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    (width, values): (u32, &[f32]),
) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width,
        height: values.len() as u32 / width,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * width),
        rows_per_image: None,
    };
    queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(values),
        layout,
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
