// ENTRY error_main: for every tile the sums behind the error estimate (MODEL.md §10): the spread of the four
// scrambles' means, and the mean. One workgroup a tile; the host adds up the few numbers that are left.

// (sum of the variance of the mean, sum of the mean) of the three channels over the pixels of a tile.
@group(1) @binding(6) var<storage, read_write> tile_errors: array<vec2<f32>>;

var<workgroup> partial: array<vec2<f32>, WORKGROUP>;

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
    // Asked for, and ended, only at sample counts that all scrambles share equally.
    let samples = f32(max(select(end, slice.samples_before, end == 0u), 1u));
    let means = sum * f32(SCRAMBLES) / samples;
    let mean = dot(means, vec4<f32>(0.25));
    let off = means - mean;
    // Variance of the mean of four: the sample variance (÷ 3) over 4.
    let colour = sums[at + SUM_COLOUR].xyz / samples;
    return vec2<f32>(dot(off, off) / 12.0, colour.x + colour.y + colour.z);
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
