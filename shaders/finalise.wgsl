// ENTRY finalise_main: between two samples, makes known what their rays have taught of shadows (shadow_cache.wgsl) and of
// light that goes on (bounced_light.wgsl).

fn mean_of(arrived: u32, unhindered: u32) -> u32 {
    let share = f32(arrived) / f32(max(unhindered, 1u));
    return u32(min(share, 1.0) * SHADOW_MEAN_STEPS + 0.5);
}

fn finalise_shadow(mean: u32, sums: u32) {
    let rays = atomicLoad(&totals[sums]);
    if rays >= ENOUGH_RAYS && (atomicLoad(&totals[mean]) & SHADOW_FINAL) == 0u {
        let direct = mean_of(atomicLoad(&totals[sums + 3u]), atomicLoad(&totals[sums + 1u]));
        let diffuse = mean_of(atomicLoad(&totals[sums + 4u]), atomicLoad(&totals[sums + 2u]));
        let mark = select(0u, SHADOW_FINAL, rays >= ALL_RAYS);
        // What comes by multiple scattering is never nothing, so that known means are not 0.
        atomicStore(&totals[mean], direct | max(diffuse, 1u) << 15u | mark);
    }
}

fn finalise_bounced(ratios: u32, sums: u32) {
    let paths = atomicLoad(&totals[sums]);
    if paths == 0u {
        return;
    }
    let known = 1.0 + BOUNCED_PRIOR_PATHS / f32(paths);
    for (var channel = 0u; channel < 3u; channel++) {
        let found = f32(atomicLoad(&totals[sums + 1u + channel]));
        let estimated = f32(atomicLoad(&totals[sums + 4u + channel]));
        let excess = (found - estimated) / max(estimated * known, 1.0);
        let ratio = clamp(1.0 + excess, BOUNCED_LEAST, BOUNCED_MOST);
        atomicStore(&totals[ratios + channel], bitcast<u32>(ratio - 1.0));
    }
}

@compute @workgroup_size(WORKGROUP)
fn finalise_main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let threads = workgroups.x * WORKGROUP;
    let rooms = min(atomicLoad(&totals[LEARNED_ROOMS]), atomicLoad(&totals[LEARNED_MOST_ROOMS]));
    let entries = rooms * atomicLoad(&totals[LEARNED_PAGE_ENTRIES]);
    let means = atomicLoad(&totals[LEARNED_MEANS]);
    let sums = atomicLoad(&totals[LEARNED_SUMS]);
    for (var entry = id.x; entry < entries; entry += threads) {
        finalise_shadow(means + entry, sums + SHADOW_SUMS * entry);
    }
    let ratios = atomicLoad(&totals[LEARNED_RATIOS]);
    let texels = atomicLoad(&totals[LEARNED_BOUNCED]);
    for (var texel = id.x; texel < texels; texel += threads) {
        finalise_bounced(ratios + 3u * texel, ratios + 3u * texels + BOUNCED_SUMS * texel);
    }
}
