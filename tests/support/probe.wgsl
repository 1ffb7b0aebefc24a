// Appended to the tracing program by the tests: runs its parts on chosen inputs.

struct PatchProbe {
    // From the middle of the base edge; w unused.
    half_base: vec4<f32>,
    axis: vec4<f32>,
    half_top: vec4<f32>,
    // Middle of the base edge.
    middle: vec4<f32>,
    // Of the ray, relative to its cell; w of both: the patch's cell along x and y, counted from there.
    origin: vec4<f32>,
    direction: vec4<f32>,
}

struct PatchAnswer {
    // (u, v, t) of both roots; w: the count, and unused. All zeros where there is no root.
    first: vec4<f32>,
    second: vec4<f32>,
    // (u′, v′, w′, (A·n̂)u′v′) at the first root.
    slopes: vec4<f32>,
    // (u, v, w) of the point at the first root.
    inverted: vec4<f32>,
}

@group(2) @binding(0) var<storage, read> patch_probes: array<PatchProbe>;
@group(2) @binding(1) var<storage, read_write> patch_answers: array<PatchAnswer>;

fn probed_patch(probe: PatchProbe) -> Patch {
    return Patch(probe.middle.xyz, probe.half_base.xyz, probe.axis.xyz, probe.half_top.xyz);
}

@compute @workgroup_size(WORKGROUP)
fn probe_patches(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&patch_probes) {
        return;
    }
    let probe = patch_probes[id.x];
    let shape = probed_patch(probe);
    let normal = patch_normal(shape);
    let ray = Ray(vec2<i32>(), probe.origin.xyz, probe.direction.xyz, 0.0, 0.0, FAR);
    let origin = origin_in_cell(ray, vec2<i32>(vec2<f32>(probe.origin.w, probe.direction.w)));
    let roots = patch_roots(shape, origin, ray.direction);
    if roots.count == 0u {
        patch_answers[id.x] = PatchAnswer(vec4<f32>(), vec4<f32>(), vec4<f32>(), vec4<f32>());
        return;
    }
    let slopes = patch_slopes(shape, normal, probe.direction.xyz, roots.first.x, roots.first.y);
    let point = origin + roots.first.z * ray.direction;
    patch_answers[id.x] = PatchAnswer(
        vec4<f32>(roots.first, f32(roots.count)),
        vec4<f32>(roots.second, 0.0),
        vec4<f32>(slopes.u, slopes.v, slopes.w, slopes.bend),
        vec4<f32>(invert_point(shape, normal, point), 0.0),
    );
}

// (u, v, w) of points, which are the origins of probes.
@group(2) @binding(4) var<storage, read_write> point_answers: array<vec4<f32>>;

@compute @workgroup_size(WORKGROUP)
fn probe_points(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&patch_probes) {
        return;
    }
    let shape = probed_patch(patch_probes[id.x]);
    let at = invert_point(shape, patch_normal(shape), patch_probes[id.x].origin.xyz);
    point_answers[id.x] = vec4<f32>(at, 0.0);
}

// Pixel's seed, sample, set.
@group(2) @binding(2) var<storage, read> sample_probes: array<vec4<u32>>;
// Bits of each set, then as numbers, then independent bits; last three numbers of the free paths' generator.
@group(2) @binding(3) var<storage, read_write> sample_answers: array<vec4<u32>>;

@compute @workgroup_size(WORKGROUP)
fn probe_samples(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&sample_probes) {
        return;
    }
    let probe = sample_probes[id.x];
    let seed = pixel_seed(probe.w, probe.xy);
    let sample = probe.z;
    for (var k = 0u; k < 5u; k++) {
        // Film, a sun, environment, onward and an area light of a bounce that differs from probe to probe.
        let bounce = 1u + sample % 64u;
        let purpose = array<u32, 5>(0u, sample % 8u, SET_ENVIRONMENT, SET_ONWARD, SET_FIRST_AREA + sample % 4u)[k];
        let set_number = select(set_at(bounce, purpose), SET_FILM, k == 0u);
        sample_answers[16u * id.x + 3u * k] = owen_bits(seed, sample, set_number);
        sample_answers[16u * id.x + 3u * k + 1u] = bitcast<vec4<u32>>(sample_set(seed, sample, set_number));
        sample_answers[16u * id.x + 3u * k + 2u] = random_bits(seed, sample, set_number);
    }
    var random = pcg_new(seed, sample);
    let numbers = vec4<f32>(pcg_next(&random), pcg_next(&random), pcg_next(&random), 0.0);
    sample_answers[16u * id.x + 15u] = bitcast<vec4<u32>>(numbers);
}
