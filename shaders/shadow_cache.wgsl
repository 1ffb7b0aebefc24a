// Shadows that a picture's first samples share: definition, bias and layout in
// renderer-core/src/render/shadow_cache.rs. Behind the counters in `totals`: for each entry the means that are known,
// then for each three sums.

// The entry of the first light around a point, moved by up to half a texel.
fn shadow_entry(at: Scatter, random: ptr<function, Pcg>) -> u32 {
    let x = pcg_next(random);
    let y = pcg_next(random);
    let z = pcg_next(random);
    let texels = vec3<i32>(slice.shadow_texels.xyz);
    let per_cell = slice.shadow_per_cell;
    let shift = vec2<u32>(slice.shadow_shift);
    let move_by = (vec2<f32>(x, y) - 0.5) * f32(1u << slice.shadow_shift);
    let within = floor((at.point.xy / scene.pitch + 0.5) * f32(per_cell) + move_by);
    let texel = clamp((at.cell * per_cell + vec2<i32>(within)) >> shift, vec2<i32>(), texels.xy - 1);
    let depth = i32(max(abs(at.point.z) * slice.shadow_layers_per_mm + z - 0.5, 0.0));
    let below = slice.shadow_layers_below;
    let layer = select(min(below + depth, texels.z - 1), max(below - depth - 1, 0), at.point.z < 0.0);
    return u32((layer * texels.y + texel.y) * texels.x + texel.x) * slice.shadow_texels.w;
}

// What is known of an entry: mean visibility, and the visibility that brings as much light by multiple scattering;
// negative if nothing, or if a ray is to make it better.
fn known_shadow(entry: u32, random: ptr<function, Pcg>) -> vec2<f32> {
    let mean = atomicLoad(&totals[SHADOWS_FROM + entry]);
    if mean == 0u {
        return vec2<f32>(-1.0);
    }
    if (mean & SHADOW_FINAL) == 0u {
        if pcg_next(random) < TRACED_SHARE {
            return vec2<f32>(-1.0);
        }
    }
    let direct = f32(mean & 0x7fffu) / SHADOW_MEAN_STEPS;
    let diffuse = f32((mean >> 15u) & 0x7fffu) / SHADOW_MEAN_STEPS;
    return vec2<f32>(direct, pow(diffuse, 1.0 / SCATTERING_MODE_MIDDLE.z));
}

fn learn_shadow(entry: u32, visibility: f32) {
    let diffuse = pow(max(visibility, SCATTERING_FLOOR), SCATTERING_MODE_MIDDLE.z);
    let texels = slice.shadow_texels;
    let entries = texels.x * texels.y * texels.z * texels.w;
    let sums = SHADOWS_FROM + entries + 3u * entry;
    atomicAdd(&totals[sums], 1u);
    atomicAdd(&totals[sums + 1u], u32(visibility * SHADOW_STEPS + 0.5));
    atomicAdd(&totals[sums + 2u], u32(diffuse * SHADOW_STEPS + 0.5));
}
