// ENTRY finalise_main: between two samples, makes known what their shadow rays have taught (see shadow_cache.wgsl).

fn mean_of(sum: u32, rays: u32) -> u32 {
    return u32(f32(sum) * (SHADOW_MEAN_STEPS / SHADOW_STEPS) / f32(rays) + 0.5);
}

@compute @workgroup_size(WORKGROUP)
fn finalise_main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let entries = (arrayLength(&totals) - SHADOWS_FROM) / 4u;
    for (var entry = id.x; entry < entries; entry += workgroups.x * WORKGROUP) {
        let sums = SHADOWS_FROM + entries + 3u * entry;
        let rays = atomicLoad(&totals[sums]);
        if rays >= ENOUGH_RAYS && (atomicLoad(&totals[SHADOWS_FROM + entry]) & SHADOW_FINAL) == 0u {
            let direct = mean_of(atomicLoad(&totals[sums + 1u]), rays);
            // What comes by multiple scattering is never nothing, so that known means are not 0.
            let diffuse = max(mean_of(atomicLoad(&totals[sums + 2u]), rays), 1u);
            let mark = select(0u, SHADOW_FINAL, rays >= ALL_RAYS);
            atomicStore(&totals[SHADOWS_FROM + entry], direct | diffuse << 15u | mark);
        }
    }
}
