//! The textures of a scene: voxels and tangents of the pile, the table of highlights, the sky, bent cloth.

use crate::design::Phase;
use crate::render::RenderError;
use crate::scene::{FormMesh, PileOptics, Sky, Volumes};

use super::constants::{FORM_ROW, HIGHLIGHT_INTERVALS, SKY_SUMS};
use super::{GpuContext, highlight};

/// Exponents whose table of N_p the pile needs, each once: the table's rows. Phases without a highlight never read it.
pub fn exponents(pile: &PileOptics) -> Vec<f32> {
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
pub fn highlight_texture(context: &GpuContext, pile: &PileOptics) -> wgpu::Texture {
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

/// The picture of the sky in f32, since a sun in it may be too bright for less; a tiny one where there is none. Beside
/// each texel its row's light up to it; in two more columns the upper half's and the lower half's light up to each of
/// their rows.
pub fn sky_texture(context: &GpuContext, sky: &Sky) -> wgpu::Texture {
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
pub fn form_texture(
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

/// Width, height and depth of all volumes stacked up.
fn volume_size(context: &GpuContext, volumes: &Volumes) -> Result<[u32; 3], RenderError> {
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
    Ok([side, side, slices as u32])
}

/// Density and shade of all volumes, stacked up.
///
/// # Errors
/// When the device's textures are too small.
pub fn voxel_texture(
    context: &GpuContext,
    volumes: &Volumes,
) -> Result<wgpu::Texture, RenderError> {
    Ok(texture(
        context,
        wgpu::TextureDimension::D3,
        wgpu::TextureFormat::Rg8Unorm,
        volume_size(context, volumes)?,
        bytemuck::cast_slice(&volumes.voxels),
    ))
}

/// As many of the six numbers of each voxel's tangents as `format` holds, from number `first` on; tiny where there are
/// none.
///
/// # Errors
/// When the device's textures are too small.
pub fn tangent_texture(
    context: &GpuContext,
    volumes: &Volumes,
    first: usize,
    format: wgpu::TextureFormat,
) -> Result<wgpu::Texture, RenderError> {
    let size = if volumes.tangents.is_empty() {
        [1; 3]
    } else {
        volume_size(context, volumes)?
    };
    let channels = first..first + usize::from(format.components());
    let tensors = volumes.tangents.iter();
    let bytes: Vec<u8> = tensors
        .flat_map(|tensor| &tensor[channels.clone()])
        .map(|&value| value as u8)
        .collect();
    Ok(texture(
        context,
        wgpu::TextureDimension::D3,
        format,
        size,
        &bytes,
    ))
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
