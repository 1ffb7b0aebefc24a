// Shadows that a picture's first samples share: definition, bias and layout in
// renderer-core/src/render/shadow_cache.rs. Behind the counters in `totals`: the LEARNED_* words, from SHADOWS_FROM on the
// room of each page of the sheet, the means that are known, an entry each, and five sums of each.

// Of a point of whose page there is no room.
const NO_ENTRY: u32 = 0xffffffffu;

// A texel around a point, moved by up to half a texel, of `texels` that are 1 / `per_cell` or 1 << `shift` cells wide.
fn texel_around(at: Scatter, random: ptr<function, Pcg>, texels: vec3<i32>, per_cell: i32, shift: u32) -> vec3<i32> {
    let x = pcg_next(random);
    let y = pcg_next(random);
    let z = pcg_next(random);
    let move_by = (vec2<f32>(x, y) - 0.5) * f32(1u << shift);
    let within = floor((at.point.xy / scene.pitch + 0.5) * f32(per_cell) + move_by);
    let texel = clamp((at.cell * per_cell + vec2<i32>(within)) >> vec2<u32>(shift), vec2<i32>(), texels.xy - 1);
    let depth = i32(max(abs(at.point.z) * slice.shadow_layers_per_mm + z - 0.5, 0.0));
    let below = slice.shadow_layers_below;
    let layer = select(min(below + depth, texels.z - 1), max(below - depth - 1, 0), at.point.z < 0.0);
    return vec3<i32>(texel, layer);
}

// The entry of the first light around a point, or NO_ENTRY.
fn shadow_entry(at: Scatter, random: ptr<function, Pcg>) -> u32 {
    let texels = vec3<i32>(slice.shadow_texels.xyz);
    let texel = vec3<u32>(texel_around(at, random, texels, slice.shadow_per_cell, slice.shadow_shift));
    let pages_across = (slice.shadow_texels.x + PAGE_SIDE - 1u) / PAGE_SIDE;
    let page = texel.xy / PAGE_SIDE;
    let room = room_of(SHADOWS_FROM + page.y * pages_across + page.x);
    if room == 0u {
        return NO_ENTRY;
    }
    let in_page = texel.xy % PAGE_SIDE;
    let place = ((texel.z * PAGE_SIDE + in_page.y) * PAGE_SIDE + in_page.x) * slice.shadow_texels.w;
    return (room - 1u) * atomicLoad(&totals[LEARNED_PAGE_ENTRIES]) + place;
}

// The room of a page, from 1; it is taken where there is none; 0 if all are.
fn room_of(page: u32) -> u32 {
    let room = atomicLoad(&totals[page]);
    let most = atomicLoad(&totals[LEARNED_MOST_ROOMS]);
    if room > 0u || atomicLoad(&totals[LEARNED_ROOMS]) >= most {
        return room;
    }
    let taken = atomicAdd(&totals[LEARNED_ROOMS], 1u) + 1u;
    if taken > most {
        return 0u;
    }
    // Where another thread was faster, this room stays empty.
    let before = atomicCompareExchangeWeak(&totals[page], 0u, taken);
    if before.exchanged {
        return taken;
    }
    return before.old_value;
}

// What is known of an entry: mean visibility, and the visibility that brings as much light by multiple scattering;
// negative if nothing, or if a ray is to make it better.
fn known_shadow(entry: u32, random: ptr<function, Pcg>) -> vec2<f32> {
    let mean = atomicLoad(&totals[atomicLoad(&totals[LEARNED_MEANS]) + entry]);
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

// Adds what one ray saw, with the light that it would have brought directly and by multiple scattering.
fn learn_shadow(entry: u32, visibility: f32, unhindered: vec2<f32>) {
    let diffuse = pow(max(visibility, SCATTERING_FLOOR), SCATTERING_MODE_MIDDLE.z);
    let scale = bitcast<f32>(atomicLoad(&totals[LEARNED_SHADOW_SCALE]));
    let steps = min(unhindered * scale, vec2<f32>(SHADOW_MOST_STEPS));
    let arrived = steps * vec2<f32>(visibility, diffuse);
    let sums = atomicLoad(&totals[LEARNED_SUMS]) + SHADOW_SUMS * entry;
    atomicAdd(&totals[sums], 1u);
    atomicAdd(&totals[sums + 1u], u32(steps.x + 0.5));
    atomicAdd(&totals[sums + 2u], u32(steps.y + 0.5));
    atomicAdd(&totals[sums + 3u], u32(arrived.x + 0.5));
    atomicAdd(&totals[sums + 4u], u32(arrived.y + 0.5));
}
