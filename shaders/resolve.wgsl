// ENTRY resolve_display: the mean so far, exposed, tone mapped and sRGB-encoded, into the texture the window shows.
// ENTRY resolve_linear: the mean so far, linear, into a buffer that is read back. Host twin of the display:
// image/display.rs.

@group(1) @binding(4) var display: texture_storage_2d<rgba8unorm, write>;
// One vec4 a pixel of the tiles of a slice, tile by tile; three with AOV.
@group(1) @binding(5) var<storage, read_write> linear: array<vec4<f32>>;

struct Mean {
    // Radiance and coverage.
    colour: vec4<f32>,
    // Normal and depth, albedo: of the samples that met cloth.
    normal_depth: vec4<f32>,
    albedo: vec4<f32>,
}

// The mean of a pixel, or of the nearest pixel towards the tile's corner that has a sample.
fn mean_of(tile: u32, in_tile: vec2<u32>) -> Mean {
    let end = tile_ends[tile];
    if end == ALL_BACKGROUND {
        return Mean(vec4<f32>(slice.background.xyz, 0.0), vec4<f32>(), vec4<f32>());
    }
    let before = tile < slice.split_tile;
    let drawn = select(slice.samples_after, slice.samples_before, before);
    let samples = max(select(end, drawn, end == 0u), 1u);
    let drawn_lattice = select(slice.lattice_after, slice.lattice_before, before);
    let lattice = max(select(1u, drawn_lattice, end == 0u), 1u);
    let first = sum_index(tile, (in_tile / lattice) * lattice);
    var mean = Mean(sums[first + SUM_COLOUR] / f32(samples), vec4<f32>(), vec4<f32>());
    if AOV {
        let albedo = sums[first + SUM_ALBEDO];
        let per_met = 1.0 / max(albedo.w, 1.0);
        mean.normal_depth = sums[first + SUM_NORMAL] * per_met;
        mean.albedo = albedo * per_met;
    }
    return mean;
}

fn srgb_encoded(linear_value: vec3<f32>) -> vec3<f32> {
    let low = linear_value * 12.92;
    let high = 1.055 * pow(max(linear_value, vec3<f32>(1.0e-9)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(high, low, linear_value <= vec3<f32>(0.0031308));
}

// The shoulder of a film's curve without its toe.
fn filmic(light: vec3<f32>) -> vec3<f32> {
    let room = 1.0 - SHOULDER;
    let rolled = 1.0 - room * room / (max(light - SHOULDER, vec3<f32>(0.0)) + room);
    return select(rolled, light, light <= vec3<f32>(SHOULDER));
}

fn displayed(radiance: vec3<f32>) -> vec3<f32> {
    let exposed = max(radiance * slice.exposure_scale, vec3<f32>(0.0));
    if slice.tone_map == TONE_FILMIC {
        return srgb_encoded(filmic(exposed));
    }
    return srgb_encoded(min(exposed, vec3<f32>(1.0)));
}

@compute @workgroup_size(WORKGROUP)
fn resolve_display(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = slice.first_tile + id.x / TILE_PIXELS;
    let in_tile = pixel_of_rank(id.x % TILE_PIXELS);
    let in_picture = tile_corner(tile) + in_tile;
    if tile >= slice.end_tile || any(in_picture >= slice.size) {
        return;
    }
    let mean = mean_of(tile, in_tile);
    textureStore(display, in_picture, vec4<f32>(displayed(mean.colour.xyz), 1.0));
}

@compute @workgroup_size(WORKGROUP)
fn resolve_linear(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = slice.first_tile + id.x / TILE_PIXELS;
    let rank = id.x % TILE_PIXELS;
    if tile >= slice.end_tile {
        return;
    }
    let mean = mean_of(tile, vec2<u32>(rank % TILE, rank / TILE));
    let pixel = (tile - slice.first_tile) * TILE_PIXELS + rank;
    if AOV {
        linear[3u * pixel] = mean.colour;
        linear[3u * pixel + 1u] = mean.normal_depth;
        linear[3u * pixel + 2u] = mean.albedo;
    } else {
        linear[pixel] = mean.colour;
    }
}
