// How pile scatters (MODEL.md §8): ψ in 1/sr, times |cos| for surfaces, and directions drawn for it. Ground yarns:
// surface.wgsl.
// `towards_eye` and `towards_light` point away from the scattering point.

// Unit vectors that make a right-handed basis with a unit vector (Duff et al., JCGT 2017).
fn basis_x(n: vec3<f32>) -> vec3<f32> {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    return vec3<f32>(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x);
}

fn basis_y(n: vec3<f32>) -> vec3<f32> {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    return vec3<f32>(n.x * n.y * a, sign + n.y * n.y * a, -n.y);
}

// (cos 2πv, sin 2πv) to f32's last digits, v in [0, 1]: of sin() and cos() 2⁻¹¹ is all that a device owes. After the
// nearest quarter turn, which is taken away without rounding, their series are short.
fn on_circle(v: f32) -> vec2<f32> {
    let quarters = round(4.0 * v);
    let angle = 2.0 * PI * (v - 0.25 * quarters);
    let x = angle * angle;
    let sine = angle * (1.0 + x * (-1.0 / 6.0 + x * (1.0 / 120.0 + x * (-1.0 / 5040.0 + x / 362880.0))));
    let cosine = 1.0 + x * (-0.5 + x * (1.0 / 24.0 + x * (-1.0 / 720.0 + x / 40320.0)));
    let odd = u32(quarters) % 2u == 1u;
    let turned = select(vec2<f32>(cosine, sine), vec2<f32>(-sine, cosine), odd);
    return select(turned, -turned, u32(quarters) % 4u >= 2u);
}

fn uniform_on_sphere(u: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - 2.0 * u.x;
    // √(1 − z²), without the difference.
    return vec3<f32>(2.0 * sqrt(max(u.x * (1.0 - u.x), 0.0)) * on_circle(u.y), z);
}

// Density cos θ/π about `normal`.
fn cosine_about(normal: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    let disc = sqrt(u.x) * on_circle(u.y);
    let up = sqrt(max(1.0 - u.x, 0.0));
    return disc.x * basis_x(normal) + disc.y * basis_y(normal) + up * normal;
}

// N_p(θ_v) from one row of its table, which is symmetric about π/2.
fn highlight_normalisation(row: u32, cos_eye: f32) -> f32 {
    let angle = acos(clamp(abs(cos_eye), 0.0, 1.0));
    let place = clamp(angle * (2.0 / PI), 0.0, 1.0) * f32(HIGHLIGHT_INTERVALS);
    let index = min(u32(place), HIGHLIGHT_INTERVALS - 1u);
    let low = textureLoad(highlight_norm, vec2<u32>(index, row), 0).x;
    let high = textureLoad(highlight_norm, vec2<u32>(index + 1u, row), 0).x;
    return mix(low, high, place - f32(index));
}

fn kajiya_kay(at: Scatter, towards_eye: vec3<f32>, towards_light: vec3<f32>) -> f32 {
    let tangent = at.axis;
    let specular = scene.materials[at.material].specular;
    let exponent = scene.materials[at.material].exponent;
    let row = scene.materials[at.material].highlight_row;
    let cos_eye = clamp(dot(tangent, towards_eye), -1.0, 1.0);
    let cos_light = clamp(dot(tangent, towards_light), -1.0, 1.0);
    let sin_eye = sqrt(max(1.0 - cos_eye * cos_eye, 0.0));
    let sin_light = sqrt(max(1.0 - cos_light * cos_light, 0.0));
    // cos(θ_l + θ_v − π): 1 on the cone of mirror directions.
    let mirrored = max(sin_light * sin_eye - cos_light * cos_eye, 0.0);
    var highlight = 0.0;
    if mirrored > 0.0 {
        highlight = pow(mirrored, exponent) / max(highlight_normalisation(row, cos_eye), 1.0e-20);
    }
    return mix(sin_light / (PI * PI), highlight, specular);
}

// A small Lambertian surface that lets a share of the light through.
fn two_sided(at: Scatter, normal: vec3<f32>, towards_eye: vec3<f32>, towards_light: vec3<f32>) -> f32 {
    let cos_light = dot(normal, towards_light);
    let same_side = cos_light * dot(normal, towards_eye) > 0.0;
    let transmission = scene.materials[at.material].transmission;
    let share = select(transmission, 1.0 - transmission, same_side);
    return share * abs(cos_light) / PI;
}

// A direction with density two_sided.
fn two_sided_direction(at: Scatter, normal: vec3<f32>, towards_eye: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    let eye_side = select(-1.0, 1.0, dot(normal, towards_eye) >= 0.0) * normal;
    let transmission = scene.materials[at.material].transmission;
    let reflected = 1.0 - transmission;
    if u.x < reflected {
        return cosine_about(eye_side, vec2<f32>(u.x / reflected, u.y));
    }
    let rest = clamp((u.x - reflected) / max(transmission, 1.0e-6), 0.0, 1.0);
    return cosine_about(-eye_side, vec2<f32>(rest, u.y));
}

// Light scattered towards the eye for light of unit irradiance from one direction: ψ.
fn scattered(at: Scatter, towards_eye: vec3<f32>, towards_light: vec3<f32>) -> vec3<f32> {
    if at.what == GROUND {
        return at.albedo * surface_value(at, towards_eye, towards_light);
    }
    let phase = phase_of(at.material);
    if phase == PHASE_FRAME_LAMBERT {
        return at.albedo * two_sided(at, at.normal, towards_eye, towards_light);
    }
    if phase == PHASE_GRADIENT_LAMBERT {
        let surface = two_sided(at, at.axis, towards_eye, towards_light);
        return at.albedo * mix(0.25 / PI, surface, at.surfaceness);
    }
    if phase == PHASE_KAJIYA_KAY {
        return at.albedo * kajiya_kay(at, towards_eye, towards_light);
    }
    return at.albedo * (0.25 / PI);
}

struct Drawn {
    direction: vec3<f32>,
    // scattered / probability density.
    weight: vec3<f32>,
}

// A direction to gather light from, drawn with two numbers.
fn draw_direction(at: Scatter, towards_eye: vec3<f32>, u: vec2<f32>) -> Drawn {
    if at.what == GROUND {
        let drawn = surface_direction(at, towards_eye, u);
        return Drawn(drawn.direction, at.albedo * drawn.weight);
    }
    let phase = phase_of(at.material);
    if phase == PHASE_FRAME_LAMBERT {
        return Drawn(two_sided_direction(at, at.normal, towards_eye, u), at.albedo);
    }
    if phase == PHASE_GRADIENT_LAMBERT {
        if u.x < at.surfaceness {
            let rest = vec2<f32>(u.x / at.surfaceness, u.y);
            return Drawn(two_sided_direction(at, at.axis, towards_eye, rest), at.albedo);
        }
        let rest = clamp((u.x - at.surfaceness) / max(1.0 - at.surfaceness, 1.0e-6), 0.0, 1.0);
        return Drawn(uniform_on_sphere(vec2<f32>(rest, u.y)), at.albedo);
    }
    let direction = uniform_on_sphere(u);
    if phase == PHASE_KAJIYA_KAY {
        return Drawn(direction, at.albedo * (4.0 * PI * kajiya_kay(at, towards_eye, direction)));
    }
    return Drawn(direction, at.albedo);
}

// The same towards the environment, with three numbers: points that scatter equally look to the other side of the
// ground in the share `looks_down` only.
fn draw_sky_direction(at: Scatter, towards_eye: vec3<f32>, u: vec3<f32>) -> Drawn {
    if phase_of(at.material) != PHASE_ISOTROPIC || at.what == GROUND {
        return draw_direction(at, towards_eye, u.xy);
    }
    let down = u.z < scene.looks_down;
    var direction = uniform_on_sphere(vec2<f32>(0.5 * u.x, u.y));
    direction.z *= select(-1.0, 1.0, (at.point.z >= 0.0) != down);
    let share = select(1.0 - scene.looks_down, scene.looks_down, down);
    return Drawn(direction, at.albedo * (0.5 / share));
}
