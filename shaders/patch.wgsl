// Ray against bilinear patch, in f32, relative to the loop's own cell; mm.
//
// With s = 2u − 1, the middle M of the base edge, half the base edge g, half the top edge e and the axis C′:
// P(s, v) = M + v·C′ + s·(g + v·(e − g)). Eliminating s and t from P = o + t·d leaves a quadratic in v with
// coefficients (· × ·)·d; it is solved with the sign-safe root (Reshetov, "Cool Patches", Ray Tracing Gems 2019, ch. 8;
// Wang's §5.2 solves the same system). The origin is first moved along the ray to its point nearest M: from far away
// the coefficients would be differences of large numbers.

struct Patch {
    // M; its x and y are 0.
    middle: vec3<f32>,
    // g, from M to P1.
    half_base: vec3<f32>,
    // C′.
    axis: vec3<f32>,
    // e, from the middle of the top edge to P2.
    half_top: vec3<f32>,
}

fn load_patch(index: u32) -> Patch {
    let a = loop_shapes[2u * index];
    let b = loop_shapes[2u * index + 1u];
    return Patch(
        vec3<f32>(0.0, 0.0, 0.5 * (a.w + b.w)),
        vec3<f32>(0.0, scene.half_base_width, 0.5 * (b.w - a.w)),
        a.xyz,
        b.xyz,
    );
}

// n̂ = normalize(b × c); scene::compile drops loops where the product (nearly) vanishes.
fn patch_normal(shape: Patch) -> vec3<f32> {
    let n = cross(shape.half_base + shape.half_top, shape.axis);
    return n * inverseSqrt(max(dot(n, n), 1.0e-30));
}

// Crossings with (u, v) in [0,1]², nearer first.
struct Roots {
    count: u32,
    // (u, v, t).
    first: vec3<f32>,
    second: vec3<f32>,
}

const NO_ROOT: vec3<f32> = vec3<f32>(-1.0, -1.0, FAR);

// The crossing at a known v, or NO_ROOT where u is outside [0, 1]. `q` is M minus the moved origin.
fn root_at(shape: Patch, q: vec3<f32>, direction: vec3<f32>, t_moved: f32, v: f32) -> vec3<f32> {
    let across = shape.half_base + v * (shape.half_top - shape.half_base);
    let from_origin = q + v * shape.axis;
    let across_d = cross(across, direction);
    let s_times = -dot(cross(from_origin, direction), across_d);
    let squared = dot(across_d, across_d);
    if abs(s_times) > squared || squared <= 0.0 {
        return NO_ROOT;
    }
    let s = s_times / squared;
    return vec3<f32>(0.5 * s + 0.5, v, t_moved + dot(from_origin + s * across, direction));
}

fn patch_roots(shape: Patch, origin: vec3<f32>, direction: vec3<f32>) -> Roots {
    let to_middle = shape.middle - origin;
    let t_moved = dot(to_middle, direction);
    let q = to_middle - t_moved * direction;
    let spread = shape.half_top - shape.half_base;
    let c0 = dot(cross(q, shape.half_base), direction);
    let c1 = dot(cross(q, spread) + cross(shape.axis, shape.half_base), direction);
    let c2 = dot(cross(shape.axis, spread), direction);
    let discriminant = c1 * c1 - 4.0 * c0 * c2;
    var roots = Roots(0u, NO_ROOT, NO_ROOT);
    if discriminant < 0.0 {
        return roots;
    }
    let root = sqrt(discriminant);
    let q2 = -0.5 * (c1 + select(-root, root, c1 >= 0.0));
    var a = NO_ROOT;
    var b = NO_ROOT;
    // v = c0/q2 and v = q2/c2; each division is made only where its result lies in [0, 1], so a vanishing leading
    // coefficient leaves the linear root and no division by zero.
    if q2 != 0.0 && c0 * q2 >= 0.0 && abs(c0) <= abs(q2) {
        a = root_at(shape, q, direction, t_moved, c0 / q2);
    }
    if c2 != 0.0 && root > 0.0 && q2 * c2 >= 0.0 && abs(q2) <= abs(c2) {
        b = root_at(shape, q, direction, t_moved, q2 / c2);
    }
    roots.count = u32(a.z < FAR) + u32(b.z < FAR);
    let swapped = b.z < a.z;
    roots.first = select(a, b, swapped);
    roots.second = select(b, a, swapped);
    return roots;
}

// Projected areas are positive, since compile makes every loop convex, and above this (mm²), since it drops the
// degenerate; below, products of slopes would not be finite.
const SMALLEST_AREA: f32 = 1.0e-9;

// How fast a ray moves through (u, v, w) at a point of the patch.
struct Slopes {
    u: f32,
    v: f32,
    w: f32,
    // (A·n̂)·u′·v′, the curvature of w along the ray times h.
    bend: f32,
}

// (u′, v′, w′) = J⁻¹·d, J = [∂P/∂u, ∂P/∂v, h·n̂]. |w′| is at least 1e-6, so that a ray along the patch keeps a direction.
fn patch_slopes(shape: Patch, normal: vec3<f32>, direction: vec3<f32>, u: f32, v: f32) -> Slopes {
    let spread = shape.half_top - shape.half_base;
    let along_u = 2.0 * (shape.half_base + v * spread);
    let along_v = shape.axis + (2.0 * u - 1.0) * spread;
    let area_vector = cross(along_u, along_v);
    let inverse = 1.0 / max(dot(area_vector, normal), SMALLEST_AREA);
    let du = dot(direction, cross(along_v, normal)) * inverse;
    let dv = dot(direction, cross(normal, along_u)) * inverse;
    let dw = dot(direction, area_vector) * inverse / scene.thickness;
    let dw_bounded = select(-1.0, 1.0, dw >= 0.0) * max(abs(dw), 1.0e-6);
    return Slopes(du, dv, dw_bounded, 2.0 * dot(spread, normal) * du * dv);
}

// A range of distances clipped to where start + slope·τ lies in [0, 1]; empty where x > y.
fn clip_unit(range: vec2<f32>, start: f32, slope: f32) -> vec2<f32> {
    // A slope below this moves less than f32 resolves over any interval inside a loop.
    let inverse = 1.0 / select(slope, 1.0e-9, abs(slope) < 1.0e-9);
    let a = -start * inverse;
    let b = (1.0 - start) * inverse;
    return vec2<f32>(max(range.x, min(a, b)), min(range.y, max(a, b)));
}

// (u, v, w) of a point; outside [0,1]² × [−½, ½] the point is not in the loop (MODEL.md §4: projected along n̂ the
// patch is p = u′(1 + αv′), q = v′(1 + βu′) with u′ = u − ½, v′ = v − ½ in the basis (b, c)).
fn invert_point(shape: Patch, normal: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    let b = shape.half_base + shape.half_top;
    let c = shape.axis;
    let spread = 2.0 * (shape.half_top - shape.half_base);
    let from_centre = point - shape.middle - 0.5 * c;
    // Dual basis of (b, c) in the plane across n̂.
    let per_area = 1.0 / max(dot(cross(b, c), normal), SMALLEST_AREA);
    let b_dual = cross(c, normal) * per_area;
    let c_dual = cross(normal, b) * per_area;
    let p = dot(from_centre, b_dual);
    let q = dot(from_centre, c_dual);
    let alpha = dot(spread, b_dual);
    let beta = dot(spread, c_dual);
    let linear = 1.0 + alpha * q - beta * p;
    let discriminant = linear * linear + 4.0 * beta * p;
    if discriminant < 0.0 {
        return vec3<f32>(FAR);
    }
    let u = 2.0 * p / max(linear + sqrt(discriminant), 1.0e-6);
    let v = q / max(1.0 + beta * u, 1.0e-6);
    let w = (dot(from_centre, normal) - u * v * dot(spread, normal)) / scene.thickness;
    return vec3<f32>(u + 0.5, v + 0.5, w);
}
