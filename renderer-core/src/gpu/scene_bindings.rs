//! Group 0 of the tracing program, a scene, in one table: what the layout says of each binding, what it is made of, and
//! when two scenes have it in common.

use crate::render::RenderError;
use crate::scene::{Scene, Skeleton, Sky};

use super::GpuContext;
use super::bindings::{other, storage, table, uniform, volume};
use super::constants::{STITCH_FAR, STITCH_HERE, STITCH_LEFT, STITCH_NEAR, STITCH_RIGHT};
use super::layout::SceneConstants;
use super::scene_constants::scene_constants;
use super::scene_textures::{
    form_texture, highlight_texture, sky_texture, tangent_texture, voxel_texture,
};

/// Something that is bound.
#[derive(Debug, Clone)]
pub enum Resource {
    /// A buffer.
    Buffer(wgpu::Buffer),
    /// A texture, and all of it as a view.
    Texture(wgpu::Texture, wgpu::TextureView),
    /// How voxels are filtered.
    Sampler(wgpu::Sampler),
}

impl Resource {
    /// To be bound as a whole.
    pub fn as_binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(_, view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }

    /// Whether both are one.
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Buffer(one), Self::Buffer(other)) => one == other,
            (Self::Texture(one, _), Self::Texture(other, _)) => one == other,
            (Self::Sampler(one), Self::Sampler(other)) => one == other,
            _ => false,
        }
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Buffer(buffer) => buffer.size(),
            Self::Texture(texture, _) => {
                let size = texture.size();
                let texel = texture.format().block_copy_size(None).unwrap_or(0);
                u64::from(size.width)
                    * u64::from(size.height)
                    * u64::from(size.depth_or_array_layers)
                    * u64::from(texel)
            }
            Self::Sampler(_) => 0,
        }
    }
}

impl From<wgpu::Texture> for Resource {
    fn from(texture: wgpu::Texture) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self::Texture(texture, view)
    }
}

type Made = Result<Resource, RenderError>;

/// One binding of the group.
pub struct SceneBinding {
    /// What the layout says of it, at its place.
    layout: fn(u32) -> wgpu::BindGroupLayoutEntry,
    /// Whether two scenes have it in common.
    pub is_same: fn(&Scene, &Scene) -> bool,
    /// Brings a scene's to the device.
    pub make: fn(&GpuContext, &Scene) -> Made,
}

/// The bindings, from 0.
pub const SCENE_BINDINGS: [SceneBinding; 13] = [
    SceneBinding {
        layout: |place| uniform(place, size_of::<SceneConstants>()),
        is_same: |_, _| false,
        make: |context, scene| {
            let constants = scene_constants(scene);
            let bytes = bytemuck::bytes_of(&constants);
            let buffer = filled_buffer(context, bytes, wgpu::BufferUsages::UNIFORM);
            Ok(Resource::Buffer(buffer))
        },
    },
    SceneBinding {
        layout: |place| storage(place, true),
        is_same: |a, b| a.loops == b.loops,
        make: |context, scene| {
            let shapes = bytemuck::cast_slice(&scene.loops.shapes);
            storage_buffer(context, "the bytes of all loop shapes", shapes)
        },
    },
    SceneBinding {
        layout: |place| storage(place, true),
        is_same: |a, b| a.looks == b.looks,
        make: |context, scene| {
            let looks = bytemuck::cast_slice(&scene.looks);
            storage_buffer(context, "the bytes of all loop looks", looks)
        },
    },
    SceneBinding {
        layout: |place| storage(place, true),
        is_same: |a, b| a.loops == b.loops,
        make: |context, scene| {
            let headers = bytemuck::cast_slice(&scene.loops.headers);
            storage_buffer(context, "the bytes of all block headers", headers)
        },
    },
    SceneBinding {
        layout: |place| storage(place, true),
        is_same: |a, b| a.loops == b.loops,
        make: |context, scene| {
            let entries = bytemuck::cast_slice(&scene.loops.entries);
            storage_buffer(context, "the bytes of all block lists", entries)
        },
    },
    SceneBinding {
        layout: |place| storage(place, true),
        is_same: |a, b| a.skeleton == b.skeleton,
        make: |context, scene| {
            let stitches = stitch_words(&scene.skeleton);
            let bytes = bytemuck::cast_slice(&stitches);
            storage_buffer(context, "the bytes of the stitch pattern", bytes)
        },
    },
    SceneBinding {
        layout: table,
        is_same: |a, b| a.pile == b.pile,
        make: |context, scene| Ok(highlight_texture(context, &scene.pile).into()),
    },
    SceneBinding {
        layout: volume,
        is_same: |a, b| a.volumes == b.volumes,
        make: |context, scene| Ok(voxel_texture(context, &scene.volumes)?.into()),
    },
    SceneBinding {
        layout: volume,
        is_same: |a, b| a.volumes == b.volumes,
        make: |context, scene| {
            let format = wgpu::TextureFormat::Rgba8Snorm;
            Ok(tangent_texture(context, &scene.volumes, 0, format)?.into())
        },
    },
    SceneBinding {
        layout: volume,
        is_same: |a, b| a.volumes == b.volumes,
        make: |context, scene| {
            let format = wgpu::TextureFormat::Rg8Snorm;
            Ok(tangent_texture(context, &scene.volumes, 4, format)?.into())
        },
    },
    SceneBinding {
        layout: |place| {
            let filters = wgpu::SamplerBindingType::Filtering;
            other(place, wgpu::BindingType::Sampler(filters))
        },
        is_same: |_, _| true,
        make: |context, _| {
            let descriptor = wgpu::SamplerDescriptor {
                label: Some("voxels"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            };
            let sampler = context.device.create_sampler(&descriptor);
            Ok(Resource::Sampler(sampler))
        },
    },
    SceneBinding {
        layout: table,
        is_same: |a, b| a.lights == b.lights || same_picture(a, b),
        make: |context, scene| Ok(sky_texture(context, &scene.lights.sky).into()),
    },
    SceneBinding {
        layout: table,
        is_same: |a, b| a.form == b.form,
        make: |context, scene| Ok(form_texture(context, scene.form.as_ref())?.into()),
    },
];

/// The group's layout.
///
/// # Errors
/// When the device fails.
pub fn layout(context: &GpuContext) -> Result<wgpu::BindGroupLayout, RenderError> {
    let places = (0..).zip(&SCENE_BINDINGS);
    let entries: Vec<_> = places.map(|(place, of)| (of.layout)(place)).collect();
    context.guarded(|| {
        let descriptor = wgpu::BindGroupLayoutDescriptor {
            label: Some("scene"),
            entries: &entries,
        };
        context.device.create_bind_group_layout(&descriptor)
    })
}

/// A read-only storage buffer; never empty, since an empty one cannot be bound.
fn storage_buffer(context: &GpuContext, what: &'static str, bytes: &[u8]) -> Made {
    context.check(what, bytes.len() as u64, context.largest_binding())?;
    let buffer = filled_buffer(context, bytes, wgpu::BufferUsages::STORAGE);
    Ok(Resource::Buffer(buffer))
}

fn filled_buffer(context: &GpuContext, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: (bytes.len() as u64).next_multiple_of(16).max(16),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    if !bytes.is_empty() {
        context.queue.write_buffer(&buffer, 0, bytes);
    }
    buffer
}

/// For each crossing of the repeat: which yarn is over there and at its four neighbours, as `STITCH_*` bits.
fn stitch_words(skeleton: &Skeleton) -> Vec<u32> {
    let [columns, rows] = skeleton.repeat.map(i64::from);
    let over = |i: i64, j: i64| {
        let index = j.rem_euclid(rows) * columns + i.rem_euclid(columns);
        skeleton
            .warp_over
            .get(index as usize)
            .copied()
            .unwrap_or(false)
    };
    let word = |i: i64, j: i64| {
        [
            (STITCH_HERE, over(i, j)),
            (STITCH_RIGHT, over(i + 1, j)),
            (STITCH_LEFT, over(i - 1, j)),
            (STITCH_FAR, over(i, j + 1)),
            (STITCH_NEAR, over(i, j - 1)),
        ]
        .into_iter()
        .fold(0, |word, (bit, on)| word | u32::from(on) << bit)
    };
    (0..rows)
        .flat_map(|j| (0..columns).map(move |i| (i, j)))
        .map(|(i, j)| word(i, j))
        .collect()
}

/// Whether two scenes have the same picture of the sky, whatever else of their lights differs.
fn same_picture(a: &Scene, b: &Scene) -> bool {
    match (&a.lights.sky, &b.lights.sky) {
        (Sky::Image { image: a, .. }, Sky::Image { image: b, .. }) => a == b,
        (Sky::Image { .. }, _) | (_, Sky::Image { .. }) => false,
        _ => true,
    }
}
