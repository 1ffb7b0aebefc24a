// How ground yarns scatter (MODEL.md §7): lambert, phong, and poulin_fournier, whose yarns are covered with parallel
// half-cylinders along the yarn, `fibre_spacing` radii apart, that hide and shade each other and the floor between them
// (Poulin and Fournier 1990). Values are ψ/albedo with the light's cosine; what they mean and why is said in
// renderer-core/src/optics/surface.rs.

fn mirrored(normal: vec3<f32>, towards_eye: vec3<f32>) -> vec3<f32> {
    return 2.0 * dot(normal, towards_eye) * normal - towards_eye;
}

// max(0, x)^p.
fn power(x: f32, p: f32) -> f32 {
    if x <= 0.0 {
        return 0.0;
    }
    return pow(x, p);
}

// The built-in asin may be 2e-4 off, as on Mesa; atan2 is better by far.
fn arcsine(x: f32) -> f32 {
    return atan2(x, sqrt(max((1.0 - x) * (1.0 + x), 0.0)));
}

// Density (p + 1)/2π·cos^p about `axis`.
fn power_lobe(axis: vec3<f32>, p: f32, u: vec2<f32>) -> vec3<f32> {
    // 1 − cos θ = 1 − e^−t is kept apart: where p is large, cos θ has few digits left to distinguish directions.
    let t = -log(1.0 - u.x) / (p + 1.0);
    let series = t * (1.0 - t / 2.0 * (1.0 - t / 3.0 * (1.0 - t / 4.0 * (1.0 - t / 5.0 * (1.0 - t / 6.0)))));
    let fall = select(1.0 - exp(-t), series, t < 0.25);
    let disc = sqrt(max(fall * (2.0 - fall), 0.0)) * on_circle(u.y);
    return disc.x * basis_x(axis) + disc.y * basis_y(axis) + (1.0 - fall) * axis;
}

fn phong(normal: vec3<f32>, towards_eye: vec3<f32>, towards_light: vec3<f32>) -> f32 {
    let p = scene.skeleton_exponent;
    let highlight = 0.5 * (p + 2.0) * power(dot(mirrored(normal, towards_eye), towards_light), p);
    return max(dot(normal, towards_light), 0.0) / PI * mix(1.0, highlight, scene.skeleton_specular);
}

struct DrawnFromSurface {
    direction: vec3<f32>,
    // Value over probability density, without the albedo.
    weight: f32,
}

fn phong_density(normal: vec3<f32>, towards_eye: vec3<f32>, direction: vec3<f32>) -> f32 {
    let p = scene.skeleton_exponent;
    let cosine = max(dot(normal, direction), 0.0);
    let lobe = 0.5 * (p + 1.0) * power(dot(mirrored(normal, towards_eye), direction), p);
    return mix(cosine, lobe, scene.skeleton_specular) / PI;
}

// By the diffuse part or by the highlight, weighed by the density of both together.
fn phong_direction(normal: vec3<f32>, towards_eye: vec3<f32>, u: vec2<f32>) -> DrawnFromSurface {
    let p = scene.skeleton_exponent;
    let diffuse = 1.0 - scene.skeleton_specular;
    let peak = mirrored(normal, towards_eye);
    var direction: vec3<f32>;
    if u.x < diffuse {
        direction = cosine_about(normal, vec2<f32>(u.x / diffuse, u.y));
    } else {
        let rest = clamp((u.x - diffuse) / max(scene.skeleton_specular, 1.0e-6), 0.0, 1.0);
        direction = power_lobe(peak, p, vec2<f32>(rest, u.y));
    }
    let density = phong_density(normal, towards_eye, direction);
    return DrawnFromSurface(direction, phong(normal, towards_eye, direction) / max(density, 1.0e-20));
}

// A direction in the axes of a fibre: angle from the normal in the plane across it, length in that plane, component
// along it.
fn in_fibre(normal: vec3<f32>, across: vec3<f32>, along: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let x = dot(direction, across);
    let z = dot(direction, normal);
    return vec3<f32>(atan2(x, z), length(vec2<f32>(x, z)), dot(direction, along));
}

// The angles of a fibre's wall that a direction at `theta` reaches: turned towards it, above the floor and not behind
// the neighbour; empty where x > y.
fn walls_reached(theta: f32) -> vec2<f32> {
    let angle = abs(theta);
    let neighbour = arcsine(clamp(scene.fibre_spacing * cos(angle) - 1.0, -1.0, 1.0));
    let range = vec2<f32>(angle - 0.5 * PI, min(angle + neighbour, 0.5 * PI));
    return select(range, -range.yx, theta < 0.0);
}

// The part of the floor that it reaches between the axes of a fibre, at 0, and of the next one.
fn floor_reached(theta: f32) -> vec2<f32> {
    let shadow = 1.0 / max(cos(theta), 1.0e-6);
    let right = vec2<f32>(1.0, scene.fibre_spacing - shadow);
    return select(right, vec2<f32>(shadow, scene.fibre_spacing - 1.0), theta < 0.0);
}

fn shared_part(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(max(a.x, b.x), min(a.y, b.y));
}

fn poulin_fournier(normal: vec3<f32>, along: vec3<f32>, towards_eye: vec3<f32>, towards_light: vec3<f32>) -> f32 {
    if dot(normal, towards_eye) <= 0.0 || dot(normal, towards_light) <= 0.0 {
        return 0.0;
    }
    let across = cross(normal, along);
    let eye = in_fibre(normal, across, along, towards_eye);
    let light = in_fibre(normal, across, along, towards_light);
    let p = scene.skeleton_exponent;
    let sum = eye.x + light.x;
    let both = eye.y * light.y;
    let walls = shared_part(walls_reached(eye.x), walls_reached(light.x));
    let floors = shared_part(floor_reached(eye.x), floor_reached(light.x));
    let on_floor = max(floors.y - floors.x, 0.0) * cos(eye.x) * cos(light.x);
    var diffuse = on_floor;
    var highlight = on_floor * power(both * cos(sum) - eye.z * light.z, p);
    let width = walls.y - walls.x;
    if width > 0.0 {
        // ∫ cos(φ−θ_v)·cos(φ−θ_l) dφ
        diffuse += 0.5 * (width * cos(eye.x - light.x) + cos(walls.x + walls.y - sum) * sin(width));
        let reach = REACH * sqrt(max(both - eye.z * light.z, 0.0) / max(4.0 * both * p, 1.0e-20));
        let part = shared_part(walls, vec2<f32>(0.5 * sum - reach, 0.5 * sum + reach));
        let half_width = 0.5 * (part.y - part.x);
        let middle = 0.5 * (part.x + part.y);
        // Turned so that the pair of points in turn comes first: nothing is indexed.
        var nodes = NODES;
        var weights = NODE_WEIGHTS;
        for (var k = 0u; k < 8u && half_width > 0.0; k++) {
            let node = nodes.x * select(1.0, -1.0, k % 2u == 0u);
            let phi = middle + half_width * node;
            let value = power(both * cos(2.0 * phi - sum) - eye.z * light.z, p) * cos(phi - eye.x) * cos(phi - light.x);
            highlight += half_width * weights.x * value;
            nodes = select(nodes, nodes.yzwx, k % 2u == 1u);
            weights = select(weights, weights.yzwx, k % 2u == 1u);
        }
    }
    let per_area = light.y / (scene.fibre_spacing * max(cos(eye.x), 1.0e-6));
    return per_area / PI * mix(diffuse, 0.5 * (p + 2.0) * highlight, scene.skeleton_specular);
}

// A facet as the eye sees them, and from it a direction as from a surface of its own.
fn poulin_fournier_direction(
    normal: vec3<f32>,
    along: vec3<f32>,
    towards_eye: vec3<f32>,
    u: vec2<f32>,
) -> DrawnFromSurface {
    let side = cross(normal, along);
    let across = select(side, -side, dot(towards_eye, side) < 0.0);
    let theta = in_fibre(normal, across, along, towards_eye).x;
    let cos_theta = max(cos(theta), 1.0e-6);
    // The place across the view, from the edge of a fibre to that of the next one.
    let place = fract(u.y * FACETS) * scene.fibre_spacing * cos_theta - 1.0;
    let on_wall = place <= cos_theta;
    let phi = select(0.0, theta + arcsine(clamp(place, -1.0, 1.0)), on_wall);
    let facet = cos(phi) * normal + sin(phi) * across;
    let p = scene.skeleton_exponent;
    let diffuse = 1.0 - scene.skeleton_specular;
    var drawn: DrawnFromSurface;
    if u.x < diffuse {
        drawn = DrawnFromSurface(cosine_about(facet, vec2<f32>(u.x / diffuse, u.y)), 1.0);
    } else {
        let rest = clamp((u.x - diffuse) / max(scene.skeleton_specular, 1.0e-6), 0.0, 1.0);
        let direction = power_lobe(mirrored(facet, towards_eye), p, vec2<f32>(rest, u.y));
        drawn = DrawnFromSurface(direction, (p + 2.0) / (p + 1.0) * max(dot(facet, direction), 0.0));
    }
    let light = in_fibre(normal, across, along, drawn.direction).x;
    let reached = select(floor_reached(light), walls_reached(light), on_wall);
    let at = select(place / cos_theta, phi, on_wall);
    if abs(light) >= 0.5 * PI || at < reached.x || at > reached.y {
        drawn.weight = 0.0;
    }
    return drawn;
}

// The yarns' cut ends have no direction along them: fibres met end on are Lambertian.
fn shows_fibres(at: Scatter) -> bool {
    return SHADING == SHADING_POULIN_FOURNIER && dot(at.axis, at.axis) > 0.0;
}

fn surface_value(at: Scatter, towards_eye: vec3<f32>, towards_light: vec3<f32>) -> f32 {
    if SHADING == SHADING_PHONG {
        return phong(at.normal, towards_eye, towards_light);
    }
    if shows_fibres(at) {
        return poulin_fournier(at.normal, at.axis, towards_eye, towards_light);
    }
    return max(dot(at.normal, towards_light), 0.0) / PI;
}

fn surface_direction(at: Scatter, towards_eye: vec3<f32>, u: vec2<f32>) -> DrawnFromSurface {
    if SHADING == SHADING_PHONG {
        return phong_direction(at.normal, towards_eye, u);
    }
    if shows_fibres(at) {
        return poulin_fournier_direction(at.normal, at.axis, towards_eye, u);
    }
    return DrawnFromSurface(cosine_about(at.normal, u), 1.0);
}
