//! A scene on the device. Sections are compared by identity: what is the same `Arc` as before keeps its buffers.

use bytemuck::Zeroable;

use crate::design::Phase;
use crate::render::RenderError;
use crate::scene::{FormMesh, PileOptics, Scene, Skeleton, Sky, Volumes};

use super::layout::{
    self, AreaLight, FORM_ROW, HIGHLIGHT_INTERVALS, MAX_AREAS, MAX_MATERIALS, MAX_SUNS, Material,
    SKY_SUMS, STITCH_FAR, STITCH_HERE, STITCH_LEFT, STITCH_NEAR, STITCH_RIGHT, SceneConstants, Sun,
};
use super::{GpuContext, highlight, pipelines::Pipelines};

/// Buffers and textures of one scene, and the scene they were made from.
#[derive(Debug)]
pub struct SceneBuffers {
    scene: Scene,
    constants: wgpu::Buffer,
    shapes: wgpu::Buffer,
    looks: wgpu::Buffer,
    headers: wgpu::Buffer,
    entries: wgpu::Buffer,
    stitches: wgpu::Buffer,
    highlight: wgpu::Texture,
    voxels: wgpu::Texture,
    tangents: [wgpu::Texture; 2],
    sampler: wgpu::Sampler,
    sky: wgpu::Texture,
    form: wgpu::Texture,
    /// All of them as group 0 of the tracing program.
    pub group: wgpu::BindGroup,
}

impl SceneBuffers {
    /// Brings `scene` to the device, taking over from `old` what has not changed.
    ///
    /// # Errors
    /// When a part of the scene is beyond the device.
    pub fn new(
        context: &GpuContext,
        pipelines: &Pipelines,
        scene: &Scene,
        old: Option<&Self>,
    ) -> Result<Self, RenderError> {
        context.guarded(|| Self::upload(context, pipelines, scene, old))?
    }

    fn upload(
        context: &GpuContext,
        pipelines: &Pipelines,
        scene: &Scene,
        old: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let kept = |same: fn(&Scene, &Scene) -> bool| old.filter(|old| same(&old.scene, scene));
        let storage = |what, bytes: &[u8]| storage_buffer(context, what, bytes);

        let [shapes, headers, entries] = match kept(|a, b| a.loops == b.loops) {
            Some(old) => [old.shapes.clone(), old.headers.clone(), old.entries.clone()],
            None => [
                storage(
                    "the bytes of all loop shapes",
                    bytemuck::cast_slice(&scene.loops.shapes),
                )?,
                storage(
                    "the bytes of all block headers",
                    bytemuck::cast_slice(&scene.loops.headers),
                )?,
                storage(
                    "the bytes of all block lists",
                    bytemuck::cast_slice(&scene.loops.entries),
                )?,
            ],
        };
        let looks = match kept(|a, b| a.looks == b.looks) {
            Some(old) => old.looks.clone(),
            None => storage(
                "the bytes of all loop looks",
                bytemuck::cast_slice(&scene.looks),
            )?,
        };
        let stitches = match kept(|a, b| a.skeleton == b.skeleton) {
            Some(old) => old.stitches.clone(),
            None => storage(
                "the bytes of the stitch pattern",
                bytemuck::cast_slice(&stitch_words(&scene.skeleton)),
            )?,
        };
        let highlight = match kept(|a, b| a.pile == b.pile) {
            Some(old) => old.highlight.clone(),
            None => highlight_texture(context, &scene.pile),
        };
        let (voxels, tangents) = match kept(|a, b| a.volumes == b.volumes) {
            Some(old) => (old.voxels.clone(), old.tangents.clone()),
            None => volume_textures(context, &scene.volumes)?,
        };
        let sampler = match old {
            Some(old) => old.sampler.clone(),
            None => context.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("voxels"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        };
        let sky = match kept(|a, b| a.lights == b.lights || same_picture(a, b)) {
            Some(old) => old.sky.clone(),
            None => sky_texture(context, &scene.lights.sky),
        };
        let form = match kept(|a, b| a.form == b.form) {
            Some(old) => old.form.clone(),
            None => form_texture(context, scene.form.as_ref())?,
        };
        let constants = uniform_buffer(context, bytemuck::bytes_of(&scene_constants(scene)));

        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let views = [&highlight, &voxels, &tangents[0], &tangents[1]].map(view);
        let [sky_view, form_view] = [&sky, &form].map(view);
        let buffers = [&constants, &shapes, &looks, &headers, &entries, &stitches];
        let resources = buffers
            .into_iter()
            .map(wgpu::Buffer::as_entire_binding)
            .chain(views.iter().map(wgpu::BindingResource::TextureView))
            .chain([
                wgpu::BindingResource::Sampler(&sampler),
                wgpu::BindingResource::TextureView(&sky_view),
                wgpu::BindingResource::TextureView(&form_view),
            ]);
        let entries_of_group: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = context
            .device
            .create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("scene"),
                layout: &pipelines.scene_layout,
                entries: &entries_of_group,
            });
        Ok(Self {
            scene: scene.clone(),
            constants,
            shapes,
            looks,
            headers,
            entries,
            stitches,
            highlight,
            voxels,
            tangents,
            sampler,
            sky,
            form,
            group,
        })
    }

    /// Whether a scene's loops are there.
    pub fn has_loops_of(&self, scene: &Scene) -> bool {
        self.scene.loops == scene.loops
    }

    /// Bytes of some scenes on the device; what they share counts once.
    pub fn bytes(scenes: &[Self]) -> u64 {
        let buffers = distinct(scenes.iter().flat_map(Self::buffers));
        let textures = distinct(scenes.iter().flat_map(Self::textures));
        let texture = |texture: &wgpu::Texture| {
            let size = texture.size();
            let texel = texture.format().block_copy_size(None).unwrap_or(0);
            u64::from(size.width)
                * u64::from(size.height)
                * u64::from(size.depth_or_array_layers)
                * u64::from(texel)
        };
        let buffers = buffers.into_iter().map(wgpu::Buffer::size);
        buffers.sum::<u64>() + textures.into_iter().map(texture).sum::<u64>()
    }

    fn buffers(&self) -> [&wgpu::Buffer; 6] {
        [
            &self.constants,
            &self.shapes,
            &self.looks,
            &self.headers,
            &self.entries,
            &self.stitches,
        ]
    }

    fn textures(&self) -> [&wgpu::Texture; 6] {
        let [tangents_a, tangents_b] = &self.tangents;
        [
            &self.voxels,
            &self.highlight,
            &self.sky,
            &self.form,
            tangents_a,
            tangents_b,
        ]
    }
}

/// Each of some things once.
fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for one in all {
        if !found.contains(&one) {
            found.push(one);
        }
    }
    found
}

/// A read-only storage buffer; never empty, since an empty one cannot be bound.
fn storage_buffer(
    context: &GpuContext,
    what: &'static str,
    bytes: &[u8],
) -> Result<wgpu::Buffer, RenderError> {
    context.check(what, bytes.len() as u64, context.largest_binding())?;
    Ok(filled_buffer(context, bytes, wgpu::BufferUsages::STORAGE))
}

fn uniform_buffer(context: &GpuContext, bytes: &[u8]) -> wgpu::Buffer {
    filled_buffer(context, bytes, wgpu::BufferUsages::UNIFORM)
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

/// Exponents whose table of N_p the pile needs, each once: the table's rows. Phases without a highlight never read it.
fn exponents(pile: &PileOptics) -> Vec<f32> {
    let mut rows = Vec::new();
    if pile.has(Phase::KajiyaKay) {
        for material in &pile.materials {
            if !rows.contains(&material.exponent) {
                rows.push(material.exponent);
            }
        }
    }
    rows
}

/// N_p over angles, a row for each exponent.
fn highlight_texture(context: &GpuContext, pile: &PileOptics) -> wgpu::Texture {
    let rows = exponents(pile);
    let norms: Vec<f32> = rows.iter().copied().flat_map(highlight::table).collect();
    texture(
        context,
        wgpu::TextureDimension::D2,
        wgpu::TextureFormat::R32Float,
        [HIGHLIGHT_INTERVALS + 1, rows.len() as u32, 1],
        bytemuck::cast_slice(&norms),
    )
}

/// Whether two scenes have the same picture of the sky, whatever else of their lights differs.
fn same_picture(a: &Scene, b: &Scene) -> bool {
    match (&a.lights.sky, &b.lights.sky) {
        (Sky::Image { image: a, .. }, Sky::Image { image: b, .. }) => a == b,
        (Sky::Image { .. }, _) | (_, Sky::Image { .. }) => false,
        _ => true,
    }
}

/// The picture of the sky in f32, since a sun in it may be too bright for less; a tiny one where there is none. Beside each texel
/// its row's light up to it; in two more columns the upper half's and the lower half's light up to each of their rows.
fn sky_texture(context: &GpuContext, sky: &Sky) -> wgpu::Texture {
    let (size, texels) = match sky {
        Sky::Image { image, .. } => {
            let light = image.light();
            let rows = image.pixels().chunks_exact(image.width());
            let sums = light.in_row().chunks_exact(image.width());
            let mut texels: Vec<[f32; 4]> = Vec::new();
            for (y, (row, sums)) in rows.zip(sums).enumerate() {
                let row = row.iter().zip(sums);
                texels.extend(row.map(|(&[r, g, b], &sum)| [r, g, b, sum]));
                let of_row = |half| light.of_rows(half).get(y).copied().unwrap_or(1.0);
                texels.extend([0, 1].map(|half| [0.0, 0.0, 0.0, of_row(half)]));
            }
            let width = image.width() as u32 + SKY_SUMS;
            ([width, image.height() as u32, 1], texels)
        }
        Sky::Uniform | Sky::Gradient { .. } => ([1; 3], Vec::new()),
    };
    texture(
        context,
        wgpu::TextureDimension::D2,
        wgpu::TextureFormat::Rgba32Float,
        size,
        bytemuck::cast_slice(&texels),
    )
}

/// The mesh of bent cloth: corners, then boxes, in rows; a tiny texture for level cloth.
fn form_texture(
    context: &GpuContext,
    mesh: Option<&FormMesh>,
) -> Result<wgpu::Texture, RenderError> {
    let mut texels: Vec<[f32; 4]> = Vec::new();
    let mut height = 1;
    if let Some(mesh) = mesh {
        let ends = mesh.corners.iter().chain(&mesh.boxes).flatten();
        texels.extend(ends.map(|&[x, y, z]| [x, y, z, 0.0]));
        let row = FORM_ROW as usize;
        height = texels.len().div_ceil(row);
        texels.resize(height * row, [0.0; 4]);
        let limit = u64::from(context.limits.max_texture_dimension_2d);
        context.check("the rows of the bent cloth's mesh", height as u64, limit)?;
    }
    let width = if mesh.is_some() { FORM_ROW } else { 1 };
    Ok(texture(
        context,
        wgpu::TextureDimension::D2,
        wgpu::TextureFormat::Rgba32Float,
        [width, height as u32, 1],
        bytemuck::cast_slice(&texels),
    ))
}

/// Voxels as one 3D texture with all volumes stacked up, and tangents as two; tiny ones where there are none.
fn volume_textures(
    context: &GpuContext,
    volumes: &Volumes,
) -> Result<(wgpu::Texture, [wgpu::Texture; 2]), RenderError> {
    let side = volumes.resolution;
    let slices =
        u64::from(volumes.layers) * u64::from(volumes.variants) * volumes.kinds.len() as u64;
    let limit = u64::from(context.limits.max_texture_dimension_3d);
    context.check(
        "pile.layers times pile.variants times the kinds of pile in use",
        slices,
        limit,
    )?;
    context.check("pile.resolution", side.into(), limit)?;
    let voxels = texture(
        context,
        wgpu::TextureDimension::D3,
        wgpu::TextureFormat::Rg8Unorm,
        [side, side, slices as u32],
        bytemuck::cast_slice(&volumes.voxels),
    );
    let size = if volumes.tangents.is_empty() {
        [1; 3]
    } else {
        [side, side, slices as u32]
    };
    let volume = wgpu::TextureDimension::D3;
    let part = |channels: std::ops::Range<usize>| -> Vec<u8> {
        volumes
            .tangents
            .iter()
            .flat_map(|tensor| &tensor[channels.clone()])
            .map(|&value| value as u8)
            .collect()
    };
    let tangents = [
        texture(
            context,
            volume,
            wgpu::TextureFormat::Rgba8Snorm,
            size,
            &part(0..4),
        ),
        texture(
            context,
            volume,
            wgpu::TextureFormat::Rg8Snorm,
            size,
            &part(4..6),
        ),
    ];
    Ok((voxels, tangents))
}

fn texture(
    context: &GpuContext,
    dimension: wgpu::TextureDimension,
    format: wgpu::TextureFormat,
    [width, height, depth]: [u32; 3],
    bytes: &[u8],
) -> wgpu::Texture {
    let size = wgpu::Extent3d {
        width: width.max(1),
        height: height.max(1),
        depth_or_array_layers: depth.max(1),
    };
    let texture = context.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    if !bytes.is_empty() {
        let texel = format.block_copy_size(None).unwrap_or(1);
        context.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * texel),
                rows_per_image: Some(height),
            },
            size,
        );
    }
    texture
}

fn rgb(colour: [f64; 3]) -> [f32; 4] {
    [colour[0] as f32, colour[1] as f32, colour[2] as f32, 0.0]
}

fn scene_constants(scene: &Scene) -> SceneConstants {
    let (sheet, loops, volumes) = (&scene.sheet, &scene.loops, &scene.volumes);
    let (pile, skeleton, lights) = (&scene.pile, &scene.skeleton, &scene.lights);
    let form = scene.form.as_ref();
    let slices = volumes.layers * volumes.variants * volumes.kinds.len() as u32;
    let [u, v, w] = volumes.reference_size_mm;
    let reach = |radius: f32, pitch: f64| {
        // Yarns k places away reach into the cell while k·pitch − radius < ½ pitch.
        (f64::from(radius) / pitch - 0.5).ceil().max(0.0) as i32
    };
    let mut suns = [Sun {
        direction: [0.0; 4],
        irradiance: [0.0; 4],
    }; MAX_SUNS as usize];
    for (slot, sun) in suns.iter_mut().zip(&lights.suns) {
        slot.direction = rgb(sun.direction);
        slot.direction[3] = (2.0 * (sun.angular_radius / 2.0).sin().powi(2)) as f32;
        slot.irradiance = rgb(sun.irradiance);
    }
    let mut areas = [AreaLight::zeroed(); MAX_AREAS as usize];
    for (slot, area) in areas.iter_mut().zip(&lights.areas) {
        let [half_width, half_height] = area.half_sides.map(rgb);
        *slot = AreaLight {
            centre: rgb(area.centre),
            half_width,
            half_height,
            facing: rgb(area.facing),
            intensity: rgb(area.intensity),
        };
    }
    let rows = exponents(pile);
    let mut materials = [Material::zeroed(); MAX_MATERIALS as usize];
    for (slot, material) in materials.iter_mut().zip(&pile.materials) {
        let row = rows.iter().position(|&row| row == material.exponent);
        *slot = Material {
            density: material.density_per_mm,
            kind: material.kind,
            transmission: material.transmission,
            specular: material.specular,
            exponent: material.exponent,
            highlight_row: row.unwrap_or(0) as u32,
            phase: layout::phase(material.phase),
            unused: 0,
        };
    }
    let mut environment = rgb(lights.environment);
    let ([zenith, horizon, ground], middle) = match &lights.sky {
        Sky::Uniform => ([[0.0; 3]; 3], 0.0),
        Sky::Gradient {
            zenith,
            horizon,
            ground,
        } => ([*zenith, *horizon, *ground], 0.0),
        Sky::Image { middle, .. } => ([[0.0; 3]; 3], *middle),
    };
    environment[3] = middle as f32;
    let mut sky_ground = rgb(ground);
    sky_ground[3] = Sky::HAZE as f32;
    SceneConstants {
        pitch: [sheet.pitch_x_mm as f32, sheet.pitch_y_mm as f32],
        z_range: loops.z_range_mm,
        sheet: [sheet.warps as i32, sheet.wefts as i32],
        blocks: loops.blocks.map(|blocks| blocks as i32),
        margin: loops.margin.map(|blocks| blocks as i32),
        half_base_width: 0.5 * loops.base_width_mm,
        thickness: loops.thickness_mm,
        height_unit: loops.height_unit_mm,
        dip: loops.dip_mm,
        length_unit: loops.length_unit_mm,
        block_shift: loops.block_cells.ilog2(),
        place_shift: loops.entry_layout.place_shift(),
        quadrants_shift: loops.entry_layout.quadrants_shift(),
        heights_shift: loops.entry_layout.heights_shift(),
        height_bits: loops.entry_layout.height_bits,
        root_blend: volumes.root_blend,
        reference_size: [u, v, w, scene.sheet.cloth_scale() as f32],
        resolution: volumes.resolution as f32,
        per_slice: 1.0 / slices.max(1) as f32,
        variants: volumes.variants,
        max_density: pile
            .materials
            .iter()
            .fold(0.0, |most, material| most.max(material.density_per_mm)),
        crimp: skeleton.crimp_mm,
        yarn_radius: [skeleton.warp_radius_mm, skeleton.weft_radius_mm],
        yarn_reach: [
            reach(skeleton.warp_radius_mm, sheet.pitch_x_mm),
            reach(skeleton.weft_radius_mm, sheet.pitch_y_mm),
        ],
        repeat: skeleton.repeat,
        skeleton_specular: skeleton.specular,
        skeleton_exponent: skeleton.exponent,
        fibre_spacing: 2.0 * skeleton.fibre_spacing,
        looks_down: skeleton.worth_looking_down(&scene.sheet),
        form_facets: form.map_or([0; 2], |form| form.facets.map(|count| count as i32)),
        form_first_cell: form.map_or([0; 2], |form| form.first_cell),
        form_heights: form.map_or([0.0; 2], |form| form.heights.map(|mm| mm as f32)),
        form_facet_cells: form.map_or(1, |form| form.facet_cells as i32),
        form_levels: form.map_or(0, |form| form.levels.len() as u32),
        skeleton_albedo: rgb(skeleton.albedo.map(f64::from)),
        environment,
        sky_zenith: rgb(zenith),
        sky_horizon: rgb(horizon),
        sky_ground,
        background: rgb(lights.background),
        suns,
        areas,
        materials,
    }
}
