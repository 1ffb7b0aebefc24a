//! Host mirrors of the structs that WGSL shares with the host; constants are in [`super::constants`].
//!
//! The test `layout` parses the composed WGSL and compares name, offset and size of every member with [`STRUCTS`].

use bytemuck::{Pod, Zeroable};

use super::constants::{MAX_AREAS, MAX_MATERIALS, MAX_SUNS};

/// A struct of the host as WGSL should see it: name, size, and (name, offset, size) of each member.
#[derive(Debug)]
pub struct StructLayout {
    /// Name in WGSL.
    pub name: &'static str,
    /// Bytes of the struct.
    pub size: usize,
    /// Name, offset and size of each member, in order.
    pub members: &'static [(&'static str, usize, usize)],
}

macro_rules! mirrors {
    ($( $(#[$meta:meta])* struct $name:ident { $( $(#[$member_meta:meta])* $member:ident: $type:ty, )+ } )+) => {
        $(
            $(#[$meta])*
            #[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
            #[repr(C)]
            pub struct $name { $( $(#[$member_meta])* pub $member: $type, )+ }
        )+

        /// Every mirrored struct.
        pub const STRUCTS: &[StructLayout] = &[$(
            StructLayout {
                name: stringify!($name),
                size: size_of::<$name>(),
                members: &[$( (stringify!($member), std::mem::offset_of!($name, $member), size_of::<$type>()), )+],
            },
        )+];
    };
}

mirrors! {
    /// A sun; see shaders/scene.wgsl, as for all that follow.
    struct Sun {
        /// Unit vector to the centre; 1 − cos(angular radius).
        direction: [f32; 4],
        /// Irradiance; unused.
        irradiance: [f32; 4],
    }

    /// An area light.
    struct AreaLight {
        /// Its middle, mm; unused.
        centre: [f32; 4],
        /// From there to the middle of a side, mm; unused.
        half_width: [f32; 4],
        /// Of a neighbouring side.
        half_height: [f32; 4],
        /// Unit vector to where it shines; unused.
        facing: [f32; 4],
        /// Radiance times area, mm²; unused.
        intensity: [f32; 4],
    }

    /// A kind of yarn.
    struct Material {
        /// Extinction of solid yarn, 1/mm.
        density: f32,
        /// Kind of pile.
        kind: u32,
        /// k of `frame_lambert` and `gradient_lambert`.
        transmission: f32,
        /// s of `kajiya_kay`.
        specular: f32,
        /// p of `kajiya_kay`.
        exponent: f32,
        /// Row of the table of N_p.
        highlight_row: u32,
        /// PHASE_*.
        phase: u32,
        /// Padding.
        unused: u32,
    }

    /// What is constant in a scene.
    struct SceneConstants {
        /// Size of a cell, mm.
        pitch: [f32; 2],
        /// Lowest and highest point of the loops, mm.
        z_range: [f32; 2],
        /// Cells of the sheet.
        sheet: [i32; 2],
        /// Blocks of the grid.
        blocks: [i32; 2],
        /// Blocks before block 0.
        margin: [i32; 2],
        /// Half of w₀, mm.
        half_base_width: f32,
        /// Thickness of all loops, mm.
        thickness: f32,
        /// Unit of the blocks' height ranges, mm.
        height_unit: f32,
        /// How far loops of one face reach to the other's side, mm.
        penetration_depth: f32,
        /// Unit of the loops' shapes, mm.
        length_unit: f32,
        /// Binary logarithm of a block's cells along each side.
        block_shift: u32,
        /// Where an entry's place begins.
        place_shift: u32,
        /// Where its occupancy masks begin.
        masks_shift: u32,
        /// Where its heights begin.
        heights_shift: u32,
        /// Bits of each of its heights.
        height_bits: u32,
        /// Share of the loop over which it fades in.
        root_blend: f32,
        /// Voxels along u and v.
        resolution: f32,
        /// 1 / slices of the voxel texture.
        per_slice: f32,
        /// Volumes of each kind.
        variants: u32,
        /// Size of the reference loop, mm; mm of the cloth in one of the scene's.
        reference_size: [f32; 4],
        /// Highest density, 1/mm.
        max_density: f32,
        /// H, mm.
        crimp: f32,
        /// Radii of warps and wefts, mm.
        yarn_radius: [f32; 2],
        /// Yarns beside a cell that reach into it.
        yarn_reach: [i32; 2],
        /// Repeat of the pattern, cells.
        repeat: [u32; 2],
        /// Share of light in the ground yarns' highlight.
        skeleton_specular: f32,
        /// Its sharpness.
        skeleton_exponent: f32,
        /// Distance of their fibres' axes, in radii of a fibre.
        fibre_spacing: f32,
        /// Share of looks at the environment that go to the other side of the ground.
        looks_down: f32,
        /// Facets of bent cloth.
        form_facets: [i32; 2],
        /// First cell of the first.
        form_first_cell: [i32; 2],
        /// Lowest and highest z of the flat cloth, mm.
        form_heights: [f32; 2],
        /// Cells along a facet's sides.
        form_facet_cells: i32,
        /// Levels of boxes around facets.
        form_levels: u32,
        /// Albedo of the ground yarns.
        skeleton_albedo: [f32; 4],
        /// Radiance of the environment where the sky is 1; azimuth of a picture's middle.
        environment: [f32; 4],
        /// Gradient at the zenith.
        sky_zenith: [f32; 4],
        /// Gradient at the horizon.
        sky_horizon: [f32; 4],
        /// Gradient at the ground; how deep the haze reaches.
        sky_ground: [f32; 4],
        /// Background.
        background: [f32; 4],
        /// All suns.
        suns: [Sun; MAX_SUNS as usize],
        /// All area lights.
        areas: [AreaLight; MAX_AREAS as usize],
        /// All materials.
        materials: [Material; MAX_MATERIALS as usize],
    }

    /// Camera rays of a tile that is drawn.
    struct RayTile {
        /// Cell that the origin is relative to; which tile it is.
        cell: [i32; 4],
        /// Origin, mm; how many directions lie before it.
        origin: [f32; 4],
        /// Change for a pixel right, the part in whole quanta; shrinking.
        origin_dx: [f32; 4],
        /// Change for a pixel down, the part in whole quanta; shrinking.
        origin_dy: [f32; 4],
        /// The rest of the change for a pixel right.
        origin_dx_rest: [f32; 4],
        /// The rest of the change for a pixel down.
        origin_dy_rest: [f32; 4],
        /// Size of a cell along x and y: the part in whole quanta, then the rest, mm.
        pitch: [f32; 4],
        /// Direction, not normalised.
        direction: [f32; 4],
        /// Change for a pixel right; of how many directions lie before the origin.
        direction_dx: [f32; 4],
        /// Change for a pixel down; of how many directions lie before the origin.
        direction_dy: [f32; 4],
    }

    /// One dispatch's work.
    struct Slice {
        /// Size of the picture made, pixels.
        size: [u32; 2],
        /// Its corner in the whole picture.
        corner: [u32; 2],
        /// Tiles in a row.
        tiles_across: u32,
        /// First tile of the bound accumulation buffer.
        buffer_first_tile: u32,
        /// First tile to work on; for the tracing program, place among the tiles that are drawn.
        first_tile: u32,
        /// The one to stop before.
        end_tile: u32,
        /// First sample to add.
        first_sample: u32,
        /// Sample to stop before.
        end_sample: u32,
        /// Lattice of the pixels to work on; 0: all.
        stride: u32,
        /// Pixels of each tile to work on.
        pixels_per_tile: u32,
        /// The picture's seed.
        seed: u32,
        /// Most scatterings.
        bounces: u32,
        /// Tile at which the sample count changes.
        split_tile: u32,
        /// Samples before that tile.
        samples_before: u32,
        /// Samples from that tile on.
        samples_after: u32,
        /// Lattice of pixels that have samples, before that tile.
        lattice_before: u32,
        /// Lattice from that tile on.
        lattice_after: u32,
        /// `TONE_*`.
        tone_map: u32,
        /// 2^exposure.
        exposure_scale: f32,
        /// Scattering at which further ones are estimated.
        path_cutoff: u32,
        /// Longest uniform piece of `exact`, mm.
        step: f32,
        /// First samples whose shadows may come from a cache.
        cached_shadows: u32,
        /// The level of detail that is drawn.
        level: u32,
        /// The last of the picture's.
        last_level: u32,
        /// How fine the whole picture's first row of pixels needs the cloth.
        first_row_fineness: f32,
        /// How much finer the next does.
        fineness_per_row: f32,
        /// Texels of the cache along x, y and z; lights.
        shadow_texels: [u32; 4],
        /// Its texels of a cell along each side.
        shadow_per_cell: i32,
        /// Binary logarithm of the cells of a texel along each side.
        shadow_shift: u32,
        /// Its layers below the sheet's plane.
        shadow_layers_below: i32,
        /// Its layers in a millimetre.
        shadow_layers_per_mm: f32,
        /// Background; of how many neighbouring threads of the tracing program one works at a time.
        background: [f32; 4],
    }
}
