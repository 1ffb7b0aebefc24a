// The volume inside a loop (MODEL.md §5): density, shade and fibre tangents at (u, v, w).

// What a loop is made of, as far as light notices.
struct Yarn {
    albedo: vec3<f32>,
    // Extinction of solid yarn, 1/mm.
    density: f32,
    // First slice of the loop's volume in the voxel textures.
    first_slice: f32,
    // Index of its material.
    material: u32,
}

fn load_yarn(index: u32) -> Yarn {
    let look = loop_looks[index];
    let index_of_material = min(look.y >> 24u, MAX_MATERIALS - 1u);
    let density = scene.materials[index_of_material].density;
    let kind = scene.materials[index_of_material].kind;
    let variant = (look.y >> 16u) & 0xffu;
    let volume = kind * scene.variants + variant;
    return Yarn(
        vec3<f32>(unpack2x16unorm(look.x), unpack2x16unorm(look.y).x),
        density,
        f32(volume * LAYERS),
        index_of_material,
    );
}

// Position between layers: whole numbers are layer centres.
fn layer_at(w: f32) -> f32 {
    let n = f32(LAYERS);
    if LINEAR_LAYERS {
        return clamp((w + 0.5) * n - 0.5, 0.0, n - 1.0);
    }
    return clamp(floor((w + 0.5) * n), 0.0, n - 1.0);
}

fn fade(v: f32) -> f32 {
    if !ROOT_BLEND {
        return 1.0;
    }
    return smoothstep(0.0, scene.root_blend, v);
}

// One texel row pair of one slice, filtered along u and v with f32 weights; voxels outside repeat the border.
fn filter_slice(volume: texture_3d<f32>, u: f32, v: f32, slice: i32) -> vec4<f32> {
    let last = i32(scene.resolution) - 1;
    let place = vec2<f32>(u, v) * scene.resolution - 0.5;
    let low = floor(place);
    let weight = place - low;
    let a = clamp(vec2<i32>(low), vec2<i32>(0), vec2<i32>(last));
    let b = clamp(vec2<i32>(low) + 1, vec2<i32>(0), vec2<i32>(last));
    let near = mix(
        textureLoad(volume, vec3<i32>(a.x, a.y, slice), 0),
        textureLoad(volume, vec3<i32>(b.x, a.y, slice), 0),
        weight.x,
    );
    let far = mix(
        textureLoad(volume, vec3<i32>(a.x, b.y, slice), 0),
        textureLoad(volume, vec3<i32>(b.x, b.y, slice), 0),
        weight.x,
    );
    return mix(near, far, weight.y);
}

// `layer` as from layer_at: it never blends with a slice of another volume.
fn filter_voxels(volume: texture_3d<f32>, first_slice: f32, u: f32, v: f32, layer: f32) -> vec4<f32> {
    let slice = first_slice + layer;
    if FILTER_F32 {
        let low = floor(layer);
        let near = filter_slice(volume, u, v, i32(first_slice + low));
        if low == layer {
            return near;
        }
        return mix(near, filter_slice(volume, u, v, i32(first_slice + low) + 1), layer - low);
    }
    return textureSampleLevel(volume, voxel_sampler, vec3<f32>(u, v, (slice + 0.5) * scene.per_slice), 0.0);
}

// ρ and ρ·shade, faded towards the root.
fn sample_density(yarn: Yarn, u: f32, v: f32, layer: f32) -> vec2<f32> {
    if COUNTERS {
        count_volume_samples += 1u;
    }
    return filter_voxels(voxels, yarn.first_slice, u, v, layer).xy * fade(v);
}

// The fibre's unit tangent in world space: the main axis of the filtered ρ·ttᵀ, carried along by ∂X.
fn fibre_tangent(shape: Patch, normal: vec3<f32>, yarn: Yarn, at: vec3<f32>) -> vec3<f32> {
    let layer = layer_at(at.z);
    let a = filter_voxels(tangents_a, yarn.first_slice, at.x, at.y, layer);
    let b = filter_voxels(tangents_b, yarn.first_slice, at.x, at.y, layer);
    // Columns (xx xy xz), (xy yy yz), (xz yz zz). Squaring eight times lets the largest eigenvalue win by its 256th
    // power.
    var tensor = mat3x3<f32>(
        vec3<f32>(a.x, a.w, b.x),
        vec3<f32>(a.w, a.y, b.y),
        vec3<f32>(b.x, b.y, a.z),
    );
    for (var i = 0u; i < 8u; i++) {
        let trace = tensor[0].x + tensor[1].y + tensor[2].z;
        tensor *= 1.0 / max(trace, 1.0e-12);
        tensor *= tensor;
    }
    let diagonal = vec3<f32>(tensor[0].x, tensor[1].y, tensor[2].z);
    var axis = tensor[2];
    if diagonal.x >= diagonal.y && diagonal.x >= diagonal.z {
        axis = tensor[0];
    } else if diagonal.y >= diagonal.z {
        axis = tensor[1];
    }
    // No fibre here: along the loop.
    if dot(axis, axis) < 1.0e-12 {
        axis = vec3<f32>(0.0, 1.0, 0.0);
    }
    let uvw = axis / scene.reference_size.xyz;
    let spread = shape.half_top - shape.half_base;
    let along_u = 2.0 * (shape.half_base + at.y * spread);
    let along_v = shape.axis + (2.0 * at.x - 1.0) * spread;
    let tangent = along_u * uvw.x + along_v * uvw.y + normal * (scene.thickness * uvw.z);
    return tangent * inverseSqrt(max(dot(tangent, tangent), 1.0e-30));
}

// For PHASE_GRADIENT_LAMBERT: unit vector down the slope of a loop's density, without its fade towards the root, and
// how much of a surface that slope makes, x²/(1 + x²) with x the change of ρ over the loop's thickness.
fn density_surface(shape: Patch, normal: vec3<f32>, yarn: Yarn, at: vec3<f32>) -> vec4<f32> {
    // Central differences: a voxel to each side along u and v, a layer to each side along w.
    let voxel = 1.0 / scene.resolution;
    let per_layer = 1.0 / f32(LAYERS);
    var slope = vec3<f32>();
    for (var axis = 0u; axis < 3u; axis++) {
        let is_axis = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
        let half_step = select(vec3<f32>(), vec3<f32>(voxel, voxel, per_layer), is_axis);
        let ahead = at + half_step;
        let behind = at - half_step;
        let more = filter_voxels(voxels, yarn.first_slice, ahead.x, ahead.y, layer_at(ahead.z)).x;
        let less = filter_voxels(voxels, yarn.first_slice, behind.x, behind.y, layer_at(behind.z)).x;
        slope = select(slope, vec3<f32>(more - less), is_axis);
    }
    slope *= 0.5 * vec3<f32>(scene.resolution, scene.resolution, f32(LAYERS));
    // J⁻ᵀ: the gradient in world space, 1/mm.
    let spread = shape.half_top - shape.half_base;
    let along_u = 2.0 * (shape.half_base + at.y * spread);
    let along_v = shape.axis + (2.0 * at.x - 1.0) * spread;
    let along_w = scene.thickness * normal;
    let volume = max(dot(cross(along_u, along_v), along_w), SMALLEST_AREA * scene.thickness);
    let across_u = cross(along_v, along_w);
    let across_v = cross(along_w, along_u);
    let across_w = cross(along_u, along_v);
    let gradient = (slope.x * across_u + slope.y * across_v + slope.z * across_w) / volume;
    let steepness = length(gradient);
    let x = steepness * scene.thickness;
    return vec4<f32>(-gradient / max(steepness, 1.0e-12), x * x / (1.0 + x * x));
}
