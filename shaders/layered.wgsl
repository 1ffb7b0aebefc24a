// Method `layered` (MODEL.md §9): the patch is moved to the middle of each layer along n̂ and solved there; every root
// is an event of its own, with the part of the ray inside that layer's slab.

fn layer_middle(layer: u32) -> f32 {
    return (f32(layer) + 0.5) / f32(LAYERS) - 0.5;
}

fn layered_gathered(event: Event, shape: Patch, normal: vec3<f32>, yarn: Yarn, ray: Ray) -> Gathered {
    let slopes = patch_slopes(shape, normal, ray.direction, event.u, event.v);
    let reach = 0.5 / (f32(LAYERS) * abs(slopes.w));
    var range = vec2<f32>(max(-reach, ray.t_start - event.t), reach);
    range = clip_unit(range, event.u, slopes.u);
    range = clip_unit(range, event.v, slopes.v);
    let w = layer_middle(event.layer);
    var gathered = Gathered(0.0, event.t, 0.0, vec3<f32>(event.u, event.v, w));
    if range.x >= range.y {
        return gathered;
    }
    let middle = 0.5 * (range.x + range.y);
    let u = event.u + slopes.u * middle;
    let v = event.v + slopes.v * middle;
    let rho = sample_density(yarn, u, v, f32(event.layer));
    gathered.depth = yarn.density * rho.x * (range.y - range.x);
    gathered.t = event.t + middle;
    gathered.shade = rho.y / max(rho.x, 1.0e-6);
    gathered.at = vec3<f32>(u, v, w);
    return gathered;
}
