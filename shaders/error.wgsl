// ENTRY error_main: for every tile the sums behind the error estimate (MODEL.md §10): the spread of the
// scrambles' means, and the mean; formula and reason: renderer-core/src/render/accumulation.rs. One workgroup a tile;
// the host adds up the few numbers that are left.

// (sum of the variance of the mean, sum of the mean) of the three channels over the pixels of a tile.
@group(1) @binding(6) var<storage, read_write> tile_errors: array<vec2<f32>>;

var<workgroup> partial: array<vec2<f32>, WORKGROUP>;

// How many of the first samples belong to each scramble: they take turns by runs.
fn samples_of_scrambles(samples: u32) -> vec4<f32> {
    let before = samples / (RUN * SCRAMBLES) * RUN;
    let rest = vec4<i32>(i32(samples % (RUN * SCRAMBLES))) - i32(RUN) * vec4<i32>(0, 1, 2, 3);
    return vec4<f32>(vec4<i32>(i32(before)) + clamp(rest, vec4<i32>(), vec4<i32>(i32(RUN))));
}

fn pixel_error(tile: u32, in_tile: vec2<u32>) -> vec2<f32> {
    if any(tile_corner(tile) + in_tile >= slice.size) {
        return vec2<f32>();
    }
    let end = tile_ends[tile];
    if end == ALL_BACKGROUND {
        return vec2<f32>(0.0, slice.background.x + slice.background.y + slice.background.z);
    }
    let at = sum_index(tile, in_tile);
    let sum = sums[at + SUM_SIGNED];
    let count = max(select(end, slice.samples_before, end == 0u), 1u);
    let samples = f32(count);
    let each = samples_of_scrambles(count);
    let off = sum / max(each, vec4<f32>(1.0)) - dot(sum, vec4<f32>(1.0)) / samples;
    let others = dot(vec4<f32>(each > vec4<f32>()), vec4<f32>(1.0)) - 1.0;
    let colour = sums[at + SUM_COLOUR].xyz / samples;
    return vec2<f32>(
        dot(each, off * off) / max(others * samples, 1.0),
        colour.x + colour.y + colour.z,
    );
}

@compute @workgroup_size(WORKGROUP)
fn error_main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = slice.first_tile + group.x;
    var sum = vec2<f32>();
    for (var rank = lane; rank < TILE_PIXELS; rank += WORKGROUP) {
        sum += pixel_error(tile, vec2<u32>(rank % TILE, rank / TILE));
    }
    partial[lane] = sum;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if lane < half {
            partial[lane] += partial[lane + half];
        }
        workgroupBarrier();
    }
    if lane == 0u {
        tile_errors[group.x] = partial[0];
    }
}
