// What is accumulated, and where: tile by tile, so that threads of a tile touch neighbouring memory and the
// accumulation of a large picture can be several buffers.

struct Slice {
    // Size of the picture that is made, pixels.
    size: vec2<u32>,
    // Its corner in the whole picture, pixels.
    corner: vec2<u32>,
    // Tiles in a row of tiles.
    tiles_across: u32,
    // First tile of the accumulation buffer that is bound.
    buffer_first_tile: u32,
    // Tiles from `first_tile` up to `end_tile` are worked on; the tracing program counts only those that are drawn.
    first_tile: u32,
    end_tile: u32,
    // Samples from `first_sample` up to `end_sample` are added.
    first_sample: u32,
    end_sample: u32,
    // The pixels of each tile that are worked on: those of the lattice of this stride that are not on the next coarser
    // one; 0: all pixels.
    stride: u32,
    pixels_per_tile: u32,
    seed: u32,
    bounces: u32,
    // Of the tiles that are drawn those before this one have `samples_before` samples, the others `samples_after`;
    // where that is 0, only the pixels on the lattice of stride `lattice_before` or `lattice_after` have one.
    split_tile: u32,
    samples_before: u32,
    samples_after: u32,
    lattice_before: u32,
    lattice_after: u32,
    // Display: 2^exposure, and TONE_*.
    tone_map: u32,
    exposure_scale: f32,
    // The scattering at which the light of further ones is estimated, with PATH_CUTOFF.
    path_cutoff: u32,
    // Longest piece of a ray that METHOD_EXACT takes as uniform, mm.
    step: f32,
    // First samples whose shadows may come from a cache, with CACHED_SHADOWS.
    cached_shadows: u32,
    // With LEVELS: the level of detail that is drawn, the picture's last one, how fine the whole picture's first row of
    // pixels needs the cloth, and how much finer the next does.
    level: u32,
    last_level: u32,
    first_row_fineness: f32,
    fineness_per_row: f32,
    // Texels of the cache along x, y and z; lights.
    shadow_texels: vec4<u32>,
    // Its texels are 1 / shadow_per_cell cells wide where that is above 1, else 1 << shadow_shift cells.
    shadow_per_cell: i32,
    shadow_shift: u32,
    // Its layers below the sheet's plane, and in a millimetre.
    shadow_layers_below: i32,
    shadow_layers_per_mm: f32,
    // What tiles of background show; w: of how many neighbouring threads of the tracing program one works at a time.
    background: vec4<f32>,
}

// Vectors of a pixel in the accumulation: radiance and coverage, signed sums by scramble, then with AOV normal and
// depth, albedo and count of the samples that met cloth.
const SUM_COLOUR: u32 = 0u;
const SUM_SIGNED: u32 = 1u;
const SUM_NORMAL: u32 = 2u;
const SUM_ALBEDO: u32 = 3u;

@group(1) @binding(1) var<storage, read_write> sums: array<vec4<f32>>;
@group(1) @binding(2) var<uniform> slice: Slice;
// For each tile of the picture: 0 while it is drawn, then its samples; ALL_BACKGROUND if it never was.
@group(1) @binding(7) var<storage, read> tile_ends: array<u32>;

// The signs with which the channels of a pixel make up the one number that its error is estimated from: over every
// 2 × 2 pixels all products of two channels cancel, and what is left is the sum of the channels' variances.
fn channel_signs(pixel: vec2<u32>) -> vec3<f32> {
    let minus = pixel.x % 2u + 2u * (pixel.y % 2u);
    return select(vec3<f32>(1.0), vec3<f32>(-1.0), vec3<u32>(1u, 2u, 3u) == vec3<u32>(minus));
}

fn sums_per_pixel() -> u32 {
    if AOV {
        return SUMS_WITH_AOV;
    }
    return SUMS;
}

fn sum_index(tile: u32, pixel_in_tile: vec2<u32>) -> u32 {
    let pixel = (tile - slice.buffer_first_tile) * TILE_PIXELS + pixel_in_tile.y * TILE + pixel_in_tile.x;
    return pixel * sums_per_pixel();
}

fn tile_corner(tile: u32) -> vec2<u32> {
    return vec2<u32>(tile % slice.tiles_across, tile / slice.tiles_across) * TILE;
}

// The pixel of a tile that thread `rank` works on.
fn pixel_of_rank(rank: u32) -> vec2<u32> {
    if slice.stride == 0u {
        // Squares of 8 × 8 pixels a workgroup: neighbours cross the same loops.
        let square = rank / 64u;
        let within = rank % 64u;
        return vec2<u32>((square % 2u) * 8u + within % 8u, (square / 2u) * 8u + within / 8u);
    }
    if slice.stride == COARSEST {
        return vec2<u32>();
    }
    // Three of the four lattice points of every coarser square are new.
    let across = TILE / (2u * slice.stride);
    let square = rank / 3u;
    let corner = rank % 3u + 1u;
    return (vec2<u32>(square % across, square / across) * 2u + vec2<u32>(corner & 1u, corner >> 1u)) * slice.stride;
}
