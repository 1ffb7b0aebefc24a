// Method `single` (the paper's §5.2, MODEL.md §9): one solve a loop. At each root of the mid patch the ray is mapped
// linearly into (u, v, w); the layers it then crosses are composited, and the loop is one event at its root.

fn single_gathered(event: Event, shape: Patch, normal: vec3<f32>, yarn: Yarn, ray: Ray) -> Gathered {
    let slopes = patch_slopes(shape, normal, ray.direction, event.u, event.v);
    // The linear map holds until the ray leaves the slab, or until the patch's bend moves w by half a thickness.
    let reach = min(0.5 / abs(slopes.w), sqrt(scene.thickness * 0.5 / max(abs(slopes.bend), 1.0e-20)));
    var range = vec2<f32>(max(-reach, ray.t_start - event.t), reach);
    let behind = vec2<f32>(max(range.x, event.gap), range.y);
    let ahead = vec2<f32>(range.x, min(range.y, event.gap));
    range = select(behind, ahead, event.gap >= 0.0);
    range = clip_unit(range, event.u, slopes.u);
    range = clip_unit(range, event.v, slopes.v);
    var gathered = Gathered(0.0, event.t, 0.0, vec3<f32>(event.u, event.v, 0.0));
    if range.x >= range.y {
        return gathered;
    }
    let n = f32(LAYERS);
    let forward = slopes.w > 0.0;
    let first = clamp(floor((slopes.w * range.x + 0.5) * n), 0.0, n - 1.0);
    let last = clamp(floor((slopes.w * range.y + 0.5) * n), 0.0, n - 1.0);
    let way = select(-1.0, 1.0, forward);
    let count = min(u32(abs(last - first)) + 1u, LAYERS);
    let per_w = 1.0 / slopes.w;
    var weight_sum = 0.0;
    var t_sum = 0.0;
    var shade_sum = 0.0;
    for (var i = 0u; i < count; i++) {
        let layer = first + way * f32(i);
        let a = (layer / n - 0.5) * per_w;
        let b = ((layer + 1.0) / n - 0.5) * per_w;
        let enter = max(range.x, min(a, b));
        let leave = min(range.y, max(a, b));
        if leave <= enter {
            continue;
        }
        let middle = 0.5 * (enter + leave);
        let layer_place = select(layer, layer_at(slopes.w * middle), LINEAR_LAYERS);
        let rho = sample_density(yarn, event.u + slopes.u * middle, event.v + slopes.v * middle, layer_place);
        let depth = yarn.density * rho.x * (leave - enter);
        let weight = exp(-gathered.depth) * opacity_of(depth);
        weight_sum += weight;
        t_sum += weight * middle;
        shade_sum += weight * rho.y / max(rho.x, 1.0e-6);
        gathered.depth += depth;
    }
    if weight_sum > 0.0 {
        let inverse = 1.0 / weight_sum;
        let tau = t_sum * inverse;
        gathered.t = event.t + tau;
        gathered.shade = shade_sum * inverse;
        gathered.at = vec3<f32>(event.u + slopes.u * tau, event.v + slopes.v * tau, slopes.w * tau);
    }
    return gathered;
}
