// Lights (MODEL.md §8): suns as discs, area lights, and an environment that is constant, a gradient or a picture.

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

// A light seen from a point: unit direction, and irradiance on a plane that faces it.
struct FromLight {
    direction: vec3<f32>,
    irradiance: vec3<f32>,
}

// From a place of an area light, uniform over its area, to a point in world space: radiance times dA·cos/r².
fn from_area(area: AreaLight, point: vec3<f32>, u: vec2<f32>) -> FromLight {
    let side = 2.0 * u - 1.0;
    let place = area.centre.xyz + side.x * area.half_width.xyz + side.y * area.half_height.xyz;
    let way = place - point;
    let squared = max(dot(way, way), 1.0e-12);
    let direction = way * inverseSqrt(squared);
    let cosine = max(-dot(area.facing.xyz, direction), 0.0);
    return FromLight(direction, area.intensity.xyz * (cosine / squared));
}

// From a sun or, after those, an area light.
fn from_lamp(number: u32, at: Scatter, u: vec2<f32>) -> FromLight {
    if AREA_COUNT > 0u && number >= SUN_COUNT {
        return from_area(scene.areas[number - SUN_COUNT], world_point(at), u);
    }
    return FromLight(sun_direction(scene.suns[number], u), scene.suns[number].irradiance.xyz);
}

fn sky_gradient(up: f32) -> vec3<f32> {
    let other = select(scene.sky_ground.xyz, scene.sky_zenith.xyz, up >= 0.0);
    let reach = select(scene.sky_ground.w, 1.0, up >= 0.0);
    return mix(scene.sky_horizon.xyz, other, smoothstep(0.0, reach, abs(up)));
}

// The angle of (x, y) from +x, in (−π, π], to f32 rounding: WGSL's own atan2 may err by 4096 of its last places, several
// columns of a picture. Polynomial of Cephes' atanf, good below tan(π/8).
fn angle_of(y: f32, x: f32) -> f32 {
    let shorter = min(abs(x), abs(y));
    let longer = max(abs(x), abs(y));
    let slope = shorter / max(longer, 1.0e-30);
    let steep = slope > 0.41421356;
    let reduced = select(slope, (slope - 1.0) / (slope + 1.0), steep);
    let z = reduced * reduced;
    let series = ((0.0805374449538 * z - 0.138776856032) * z + 0.199777106478) * z - 0.333329491539;
    var angle = series * z * reduced + reduced + select(0.0, PI / 4.0, steep);
    angle = select(angle, PI / 2.0 - angle, abs(y) > abs(x));
    angle = select(angle, PI - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

// Two neighbouring texels of a row; columns go round.
fn sky_row(left: i32, share: f32, y: i32, size: vec2<i32>) -> vec3<f32> {
    let row = clamp(y, 0, size.y - 1);
    let a = textureLoad(sky_picture, vec2<i32>((left + size.x) % size.x, row), 0).xyz;
    let b = textureLoad(sky_picture, vec2<i32>((left + 1) % size.x, row), 0).xyz;
    return mix(a, b, share);
}

// Columns go against azimuths, rows from the zenith down. Filtered by hand: a sampler's 8-bit weights would show where a
// sun stands beside a sky.
fn sky_image(direction: vec3<f32>) -> vec3<f32> {
    let size = vec2<i32>(textureDimensions(sky_picture));
    let azimuth = angle_of(direction.y, direction.x);
    let turn = fract(0.5 - (azimuth - scene.environment.w) / (2.0 * PI));
    let fall = angle_of(length(direction.xy), direction.z) / PI;
    let place = vec2<f32>(turn, fall) * vec2<f32>(size) - 0.5;
    let corner = floor(place);
    let share = place - corner;
    let left = i32(corner.x);
    let upper = i32(corner.y);
    return mix(sky_row(left, share.x, upper, size), sky_row(left, share.x, upper + 1, size), share.y);
}

// What arrives from a direction in world space.
fn environment_radiance(direction: vec3<f32>) -> vec3<f32> {
    if !ENVIRONMENT {
        return vec3<f32>();
    }
    if SKY == SKY_GRADIENT {
        return scene.environment.xyz * sky_gradient(direction.z);
    }
    if SKY == SKY_IMAGE {
        return scene.environment.xyz * sky_image(direction);
    }
    return scene.environment.xyz;
}
