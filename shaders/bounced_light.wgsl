// What paths that go on where others are cut off have taught: definition, bias and layout in
// renderer-core/src/render/bounced_light.rs. Behind the shadows in `totals`: for each texel three ratios less 1, as bits
// of numbers, then for each how many paths, and sums of what they found and of what was estimated for them.

// The texel around a point, moved by up to half a texel.
fn bounced_entry(at: Scatter, random: ptr<function, Pcg>) -> u32 {
    let across = atomicLoad(&totals[LEARNED_BOUNCED_X]);
    let along = atomicLoad(&totals[LEARNED_BOUNCED_Y]);
    let texels = vec3<i32>(i32(across), i32(along), i32(slice.shadow_texels.z));
    let texel = vec3<u32>(texel_around(at, random, texels, 1, atomicLoad(&totals[LEARNED_BOUNCED_SHIFT])));
    return (texel.z * along + texel.y) * across + texel.x;
}

// What an estimate at a texel is to be multiplied with.
fn bounced_correction(entry: u32) -> vec3<f32> {
    let ratios = atomicLoad(&totals[LEARNED_RATIOS]) + 3u * entry;
    return 1.0 + vec3<f32>(
        bitcast<f32>(atomicLoad(&totals[ratios])),
        bitcast<f32>(atomicLoad(&totals[ratios + 1u])),
        bitcast<f32>(atomicLoad(&totals[ratios + 2u])),
    );
}

fn bounced_sums(entry: u32) -> u32 {
    return atomicLoad(&totals[LEARNED_RATIOS]) + 3u * atomicLoad(&totals[LEARNED_BOUNCED]) + BOUNCED_SUMS * entry;
}

// Whether the path of a sample of a pixel of the whole picture goes on to its end.
fn learns_bounces(pixel: vec2<u32>, sample: u32) -> bool {
    let block = pixel_seed(slice.seed, pixel >> vec2<u32>(BOUNCED_BLOCK_SHIFT));
    return sample < slice.cached_shadows && hash_with(block, sample) < BOUNCED_CHANCE;
}

fn is_learning_bounces(entry: u32) -> bool {
    return atomicLoad(&totals[bounced_sums(entry)]) < BOUNCED_ALL_PATHS;
}

fn learn_bounces(entry: u32, found: vec3<f32>, estimate: vec3<f32>) {
    let sums = bounced_sums(entry);
    let most = vec3<f32>(BOUNCED_MOST_STEPS);
    let scale = bitcast<f32>(atomicLoad(&totals[LEARNED_BOUNCED_SCALE]));
    let found_steps = vec3<u32>(min(found * scale, most) + 0.5);
    let estimate_steps = vec3<u32>(min(estimate * scale, most) + 0.5);
    atomicAdd(&totals[sums], 1u);
    atomicAdd(&totals[sums + 1u], found_steps.x);
    atomicAdd(&totals[sums + 2u], found_steps.y);
    atomicAdd(&totals[sums + 3u], found_steps.z);
    atomicAdd(&totals[sums + 4u], estimate_steps.x);
    atomicAdd(&totals[sums + 5u], estimate_steps.y);
    atomicAdd(&totals[sums + 6u], estimate_steps.z);
}
