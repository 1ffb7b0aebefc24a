// Lights (MODEL.md §8): suns as discs, and a constant environment.

// A direction in the sun's disc, uniform over its solid angle.
fn sun_direction(sun: Sun, u: vec2<f32>) -> vec3<f32> {
    // 1 − cos θ is kept apart: for a small sun cos θ has no digits left to tell directions by.
    let fall = u.x * sun.direction.w;
    let sin_angle = sqrt(max(fall * (2.0 - fall), 0.0));
    let disc = sin_angle * on_circle(u.y);
    let centre = sun.direction.xyz;
    let direction = disc.x * basis_x(centre) + disc.y * basis_y(centre) + (1.0 - fall) * centre;
    return direction * inverseSqrt(max(dot(direction, direction), 1.0e-30));
}

fn environment_radiance() -> vec3<f32> {
    if ENVIRONMENT {
        return scene.environment.xyz;
    }
    return vec3<f32>();
}
