//! What programs are bound to: the places of group 1, what a layout says of each, and a dispatch with all of them
//! bound. Group 0 of the tracing program is the scene's: `scene_bindings`.

use super::GpuContext;
use super::layout::Slice;

/// Ray tiles.
pub const RAY_TILES: u32 = 0;
/// Accumulation.
pub const SUMS: u32 = 1;
/// The slice.
pub const SLICE: u32 = 2;
/// Counters.
pub const TOTALS: u32 = 3;
/// Display texture.
pub const DISPLAY: u32 = 4;
/// Linear pixels to read back.
pub const LINEAR: u32 = 5;
/// Errors of tiles to read back.
pub const TILE_ERRORS: u32 = 6;
/// Where tiles ended.
pub const TILE_ENDS: u32 = 7;

/// A storage buffer of any size.
pub fn storage(binding: u32, read_only: bool) -> wgpu::BindGroupLayoutEntry {
    buffer(binding, wgpu::BufferBindingType::Storage { read_only }, 0)
}

/// A uniform buffer of `size` bytes.
pub fn uniform(binding: u32, size: usize) -> wgpu::BindGroupLayoutEntry {
    buffer(binding, wgpu::BufferBindingType::Uniform, size)
}

fn buffer(binding: u32, ty: wgpu::BufferBindingType, size: usize) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: std::num::NonZeroU64::new(size as u64),
        },
        count: None,
    }
}

/// Anything that is no buffer.
pub fn other(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

/// A texture that is filtered in three dimensions.
pub fn volume(binding: u32) -> wgpu::BindGroupLayoutEntry {
    other(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        },
    )
}

/// A texture read texel by texel.
pub fn table(binding: u32) -> wgpu::BindGroupLayoutEntry {
    other(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
    )
}

/// A whole buffer at a binding.
pub fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}

/// A uniform buffer with one slice.
pub fn slice_buffer(context: &GpuContext, slice: &Slice) -> wgpu::Buffer {
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("slice"),
        size: size_of::<Slice>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    context
        .queue
        .write_buffer(&buffer, 0, bytemuck::bytes_of(slice));
    buffer
}

/// Records a dispatch of a pipeline whose group 1, of this layout, holds `entries`.
pub fn record_dispatch(
    context: &GpuContext,
    encoder: &mut wgpu::CommandEncoder,
    (pipeline, layout): (&wgpu::ComputePipeline, &wgpu::BindGroupLayout),
    entries: &[wgpu::BindGroupEntry<'_>],
    workgroups: u32,
) {
    let group = context
        .device
        .create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries,
        });
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(1, &group, &[]);
    pass.dispatch_workgroups(workgroups, 1, 1);
}
