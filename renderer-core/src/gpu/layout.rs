//! Host mirrors of the structs and constants that WGSL shares with the host: the only place where both are written.
//!
//! The test `layout` parses the composed WGSL and compares name, offset and size of every member, and the value of
//! every constant, with [`STRUCTS`] and [`CONSTANTS`].

use bytemuck::{Pod, Zeroable};

use crate::design::Phase;

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

macro_rules! constants {
    ($( $(#[$meta:meta])* $name:ident = $value:expr; )+) => {
        $( $(#[$meta])* pub const $name: u32 = $value; )+

        /// Every mirrored constant: name in WGSL and value.
        pub const CONSTANTS: &[(&str, u32)] = &[$( (stringify!($name), $name), )+];
    };
}

constants! {
    /// METHOD for `single`.
    METHOD_SINGLE = 0;
    /// METHOD for `layered`.
    METHOD_LAYERED = 1;
    /// METHOD for `tracked`.
    METHOD_TRACKED = 2;
    /// METHOD for `exact`.
    METHOD_EXACT = 3;
    /// PHASE for `isotropic`.
    PHASE_ISOTROPIC = 0;
    /// PHASE for `frame_lambert`.
    PHASE_FRAME_LAMBERT = 1;
    /// PHASE for `kajiya_kay`.
    PHASE_KAJIYA_KAY = 2;
    /// PHASE for `gradient_lambert`.
    PHASE_GRADIENT_LAMBERT = 3;
    /// PHASE where not all materials scatter alike.
    PHASE_OF_MATERIAL = 4;
    /// SKELETON for none.
    SKELETON_NONE = 0;
    /// SKELETON for tubes.
    SKELETON_WINDING = 1;
    /// SKELETON for the paper's product.
    SKELETON_PAPER = 2;
    /// SKY for one colour.
    SKY_UNIFORM = 0;
    /// SKY for a gradient.
    SKY_GRADIENT = 1;
    /// SKY for a picture.
    SKY_IMAGE = 2;
    /// Columns of sums beside the picture.
    SKY_SUMS = 2;
    /// SHADING for `lambert`.
    SHADING_LAMBERT = 0;
    /// SHADING for `phong`.
    SHADING_PHONG = 1;
    /// SHADING for `poulin_fournier`.
    SHADING_POULIN_FOURNIER = 2;
    /// Side of a tile, pixels.
    TILE = 16;
    /// Pixels of a tile.
    TILE_PIXELS = 256;
    /// Threads of a workgroup.
    WORKGROUP = 64;
    /// Most suns.
    MAX_SUNS = 8;
    /// Most area lights.
    MAX_AREAS = 4;
    /// Most materials.
    MAX_MATERIALS = 130;
    /// Intervals of the table of N_p.
    HIGHLIGHT_INTERVALS = 256;
    /// Scrambles of the random sequence.
    SCRAMBLES = crate::sampling::SCRAMBLES;
    /// Samples of one scramble before the next one's turn.
    RUN = crate::sampling::RUN;
    /// Index of the counter of rays.
    COUNT_RAYS = 0;
    /// Index of the counter of shadow rays.
    COUNT_SHADOW_RAYS = 1;
    /// Index of the counter of cells.
    COUNT_CELLS = 2;
    /// Index of the counter of patch tests.
    COUNT_PATCH_TESTS = 3;
    /// Index of the counter of volume samples.
    COUNT_VOLUME_SAMPLES = 4;
    /// Index of the counter of contributing hits.
    COUNT_CONTRIBUTING_HITS = 5;
    /// Index of the counter of shadow rays that ended in the dark.
    COUNT_ENDED_RAYS = 6;
    /// Index of the counter of rays for which no ground yarn was looked for.
    COUNT_HIDDEN_RAYS = 7;
    /// Index of the counter of shadow rays that the cache saved.
    COUNT_CACHED_RAYS = 8;
    /// Number of counters.
    COUNTERS_IN_ALL = 9;
    /// Word of the counters' buffer at which shadows begin.
    SHADOWS_FROM = 32;
    /// Rays that make a mean of shadows.
    ENOUGH_RAYS = crate::render::shadow_cache::ENOUGH_RAYS;
    /// Rays that make a final one.
    ALL_RAYS = crate::render::shadow_cache::ALL_RAYS;
    /// Bit of a stitch word: warp over at the crossing itself.
    STITCH_HERE = 0;
    /// Bit of a stitch word: warp over at the next crossing along x.
    STITCH_RIGHT = 1;
    /// Bit of a stitch word: warp over at the crossing before along x.
    STITCH_LEFT = 2;
    /// Bit of a stitch word: warp over at the next crossing along y.
    STITCH_FAR = 3;
    /// Bit of a stitch word: warp over at the crossing before along y.
    STITCH_NEAR = 4;
    /// Texels of a row of a bent cloth's mesh.
    FORM_ROW = 1024;
    /// Vectors a pixel in the accumulation.
    SUMS = 2;
    /// How many there are with AOV.
    SUMS_WITH_AOV = 4;
    /// End of a tile that shows background alone.
    ALL_BACKGROUND = u32::MAX;
    /// Coarsest lattice of the first sample, pixels.
    COARSEST = 16;
    /// Tone map: hard clip.
    TONE_NONE = 0;
    /// Tone map: filmic.
    TONE_FILMIC = 1;
}

/// How shaders number phase functions.
pub(super) fn phase(phase: Phase) -> u32 {
    match phase {
        Phase::Isotropic => PHASE_ISOTROPIC,
        Phase::FrameLambert => PHASE_FRAME_LAMBERT,
        Phase::KajiyaKay => PHASE_KAJIYA_KAY,
        Phase::GradientLambert => PHASE_GRADIENT_LAMBERT,
    }
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
        /// Background.
        background: [f32; 4],
    }
}
