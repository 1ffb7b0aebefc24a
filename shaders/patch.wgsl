// Ray against bilinear patch, in f32, relative to the loop's own cell; mm.
//
// With u′ = u − ½, v′ = v − ½ and A = 2(e − g): P = M + ½C′ + u′·(g + e) + v′·C′ + u′v′·A, where M is the middle of the
// base edge, g half the base edge, e half the top edge and C′ the axis. A ray o + t·d meets a line of constant u′ or v′
// where a product of three vectors vanishes, which is a quadratic; it is solved with the sign-safe root (Reshetov,
// "Cool Patches", Ray Tracing Gems 2019, ch. 8; Wang's §5.2 solves the same system). Of the two families of lines the
// one is taken that runs less along the ray. The origin is first moved along the ray to its point nearest the patch's
// middle: from far away the coefficients would be differences of large numbers.

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

// Two i16 in the unit of the loops' shapes.
fn lengths(pair: u32) -> vec2<f32> {
    let word = bitcast<i32>(pair);
    return vec2<f32>(vec2<i32>(extractBits(word, 0u, 16u), word >> 16u)) * scene.length_unit;
}

fn load_patch(index: u32) -> Patch {
    let shape = loop_shapes[index];
    let axis_xy = lengths(shape.x);
    let axis_z_root_z0 = lengths(shape.y);
    let half_top_xy = lengths(shape.z);
    let half_top_z_root_z1 = lengths(shape.w);
    let root_z0 = axis_z_root_z0.y;
    let root_z1 = half_top_z_root_z1.y;
    return Patch(
        vec3<f32>(0.0, 0.0, 0.5 * (root_z0 + root_z1)),
        vec3<f32>(0.0, scene.half_base_width, 0.5 * (root_z1 - root_z0)),
        vec3<f32>(axis_xy, axis_z_root_z0.x),
        vec3<f32>(half_top_xy, half_top_z_root_z1.x),
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

// A patch seen along a ray: with p and r in [−½, ½] and r the one that is eliminated,
// P = Q + p·along_p + r·along_r + p·r·twist, Q from the ray's point nearest to the middle.
struct Seen {
    middle: vec3<f32>,
    along_p: vec3<f32>,
    along_r: vec3<f32>,
    twist: vec3<f32>,
    direction: vec3<f32>,
    t_moved: f32,
}

// One step of Newton's method on the place where point and ray meet, if it is small.
fn refined(seen: Seen, at: vec2<f32>) -> vec2<f32> {
    let tangent_p = seen.along_p + at.y * seen.twist;
    let tangent_r = seen.along_r + at.x * seen.twist;
    let point = seen.middle + at.x * seen.along_p + at.y * tangent_r;
    let area = dot(cross(tangent_p, tangent_r), seen.direction);
    let p_area = dot(cross(tangent_r, point), seen.direction);
    let r_area = dot(cross(point, tangent_p), seen.direction);
    // A step leaves the product of its parts, times the twist. Where that is more than rounding two crossings are about
    // to become one, and the method fails.
    if abs(p_area * r_area) > 1.0e-7 * area * area || area == 0.0 {
        return at;
    }
    return at + vec2<f32>(p_area, r_area) / area;
}

// The crossing (p, r, t) at a known p, or NO_ROOT where r is outside [−½, ½].
fn root_at(seen: Seen, p: f32) -> vec3<f32> {
    let ruling = seen.along_r + p * seen.twist;
    let start = seen.middle + p * seen.along_p;
    let ruling_d = cross(ruling, seen.direction);
    let r_times = -dot(cross(start, seen.direction), ruling_d);
    let squared = dot(ruling_d, ruling_d);
    let is_short = squared < SHORT * dot(seen.along_r, seen.along_r);
    // Before that step r may be a little off.
    if abs(r_times) > select(0.5, 0.6, is_short) * squared || squared <= 0.0 {
        return NO_ROOT;
    }
    var at = vec2<f32>(p, r_times / squared);
    if is_short {
        at = refined(seen, at);
        if any(abs(at) > vec2<f32>(0.5)) {
            return NO_ROOT;
        }
    }
    let point = seen.middle + at.x * seen.along_p + at.y * (seen.along_r + at.x * seen.twist);
    return vec3<f32>(at, seen.t_moved + dot(point, seen.direction));
}

fn patch_roots(shape: Patch, origin: vec3<f32>, direction: vec3<f32>) -> Roots {
    let along_u = shape.half_base + shape.half_top;
    let along_v = shape.axis;
    let to_middle = shape.middle + 0.5 * shape.axis - origin;
    let t_moved = dot(to_middle, direction);
    // Lines of constant p should not run along the ray: all of them would be near solutions, and rounding would choose.
    let u_cross = cross(along_u, direction);
    let v_cross = cross(along_v, direction);
    let solve_u = dot(u_cross, u_cross) * dot(along_v, along_v) < dot(v_cross, v_cross) * dot(along_u, along_u);
    let seen = Seen(
        to_middle - t_moved * direction,
        select(along_v, along_u, solve_u),
        select(along_u, along_v, solve_u),
        2.0 * (shape.half_top - shape.half_base),
        direction,
        t_moved,
    );
    let r_cross = select(u_cross, v_cross, solve_u);
    let twist_cross = cross(seen.twist, direction);
    // (Q + p·along_p)·((along_r + p·twist) × d) = c0 + c1·p + c2·p² = 0.
    let c0 = dot(seen.middle, r_cross);
    let c1 = dot(seen.middle, twist_cross) + dot(seen.along_p, r_cross);
    let c2 = dot(seen.along_p, twist_cross);
    let discriminant = c1 * c1 - 4.0 * c0 * c2;
    var roots = Roots(0u, NO_ROOT, NO_ROOT);
    if discriminant < 0.0 {
        return roots;
    }
    let root = sqrt(discriminant);
    let q2 = -0.5 * (c1 + select(-root, root, c1 >= 0.0));
    var a = NO_ROOT;
    var b = NO_ROOT;
    // p = c0/q2 and p = q2/c2; each division is made only where its result lies in [−½, ½], so a vanishing leading
    // coefficient leaves the linear root and no division by zero.
    if q2 != 0.0 && abs(c0) <= 0.5 * abs(q2) {
        a = root_at(seen, c0 / q2);
    }
    if c2 != 0.0 && root > 0.0 && abs(q2) <= 0.5 * abs(c2) {
        b = root_at(seen, q2 / c2);
    }
    roots.count = u32(a.z < FAR) + u32(b.z < FAR);
    let swapped = b.z < a.z;
    let first = select(a, b, swapped);
    let second = select(b, a, swapped);
    roots.first = vec3<f32>(select(first.yx, first.xy, solve_u) + 0.5, first.z);
    roots.second = vec3<f32>(select(second.yx, second.xy, solve_u) + 0.5, second.z);
    return roots;
}

// How fast a ray moves through (u, v, w) at a point of the patch.
struct Slopes {
    u: f32,
    v: f32,
    w: f32,
    // (A·n̂)·u′·v′, the curvature of w along the ray times h.
    bend: f32,
}

// (u′, v′, w′) = J⁻¹·d, J = [∂P/∂u, ∂P/∂v, h·n̂]. |w′| is at least FLATTEST, so that a ray along the patch keeps a
// direction.
fn patch_slopes(shape: Patch, normal: vec3<f32>, direction: vec3<f32>, u: f32, v: f32) -> Slopes {
    let spread = shape.half_top - shape.half_base;
    let along_u = 2.0 * (shape.half_base + v * spread);
    let along_v = shape.axis + (2.0 * u - 1.0) * spread;
    let area_vector = cross(along_u, along_v);
    let inverse = 1.0 / max(dot(area_vector, normal), SMALLEST_AREA);
    let du = dot(direction, cross(along_v, normal)) * inverse;
    let dv = dot(direction, cross(normal, along_u)) * inverse;
    let dw = dot(direction, area_vector) * inverse / scene.thickness;
    let dw_bounded = select(-1.0, 1.0, dw >= 0.0) * max(abs(dw), FLATTEST);
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
