// Lights (MODEL.md §8): suns as discs, area lights, and an environment that is constant, a gradient or a picture.

// A direction in the sun's disc, uniform over its solid angle.
fn sun_direction(sun: Sun, u: vec2<f32>) -> vec3<f32> {
    // 1 − cos θ is kept apart: for a small sun cos θ has no digits left to distinguish directions.
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
    let offset = place - point;
    let squared = max(dot(offset, offset), 1.0e-12);
    let direction = offset * inverseSqrt(squared);
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

// The angle of (x, y) from +x, in (−π, π], to f32 rounding: WGSL's own atan2 may err by 4096 of its last places,
// several columns of a picture. Polynomial of Cephes' atanf, good below tan(π/8).
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

fn sky_size() -> vec2<i32> {
    return vec2<i32>(textureDimensions(sky_picture)) - vec2<i32>(i32(SKY_SUMS), 0);
}

// Two neighbouring texels of a row; columns go round.
fn sky_row(left: i32, share: f32, y: i32, size: vec2<i32>) -> vec3<f32> {
    let row = clamp(y, 0, size.y - 1);
    let a = textureLoad(sky_picture, vec2<i32>((left + size.x) % size.x, row), 0).xyz;
    let b = textureLoad(sky_picture, vec2<i32>((left + 1) % size.x, row), 0).xyz;
    return mix(a, b, share);
}

// Columns go against azimuths, rows from the zenith down. Filtered by hand: a sampler's 8-bit weights would show where
// a sun stands beside a sky.
fn sky_image(direction: vec3<f32>) -> vec3<f32> {
    let size = sky_size();
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

// Directions by a picture's light: what is drawn how, and why, stands in
// renderer-core/src/sampling/piecewise_constant_2d.rs.

// Place and width of the `index`-th share among sums of light: in a row of texels or, for `row` < 0, of the rows of a
// half.
fn light_sum(index: i32, row: i32, column: i32) -> f32 {
    if index < 0 {
        return 0.0;
    }
    let at = select(vec2<i32>(column, index), vec2<i32>(index, row), row >= 0);
    return textureLoad(sky_picture, at, 0).w;
}

// The first of `count` sums above a number, and how far the number is from the one before to it.
fn find_light(number: f32, count: i32, row: i32, column: i32) -> vec2<f32> {
    var first = 0;
    var last = count - 1;
    while first < last {
        let middle = (first + last) / 2;
        if light_sum(middle, row, column) <= number {
            first = middle + 1;
        } else {
            last = middle;
        }
    }
    let before = light_sum(first - 1, row, column);
    let width = light_sum(first, row, column) - before;
    return vec2<f32>(f32(first), clamp((number - before) / max(width, 1.0e-30), 0.0, 1.0));
}

// 1 − cos of the angles from a half's pole at which a row begins and ends.
fn ring_falls(ring: i32, height: i32) -> vec2<f32> {
    let edges = min(vec2<f32>(f32(ring), f32(ring + 1)) / (4.0 * f32(height)), vec2<f32>(0.125));
    let half_sines = vec2<f32>(on_circle(edges.x).y, on_circle(edges.y).y);
    return 2.0 * half_sines * half_sines;
}

// Row of a half's ring.
fn ring_row(ring: i32, below: bool, height: i32) -> i32 {
    return select(ring, height - 1 - ring, below);
}

fn direction_by_light(below: bool, u: vec2<f32>) -> vec3<f32> {
    let size = sky_size();
    let ring = find_light(u.y, (size.y + 1) / 2, -1, size.x + i32(below));
    let row = ring_row(i32(ring.x), below, size.y);
    let column = find_light(u.x, size.x, row, 0);
    let falls = ring_falls(i32(ring.x), size.y);
    let fall = mix(falls.x, falls.y, ring.y);
    let across = sqrt(max(fall * (2.0 - fall), 0.0));
    let turn = 0.5 - (column.x + column.y) / f32(size.x) + scene.environment.w / (2.0 * PI);
    let circle = on_circle(fract(turn));
    return vec3<f32>(across * circle, select(1.0 - fall, fall - 1.0, below));
}

// Its density, per sr, in the half that the direction is in.
fn density_by_light(direction: vec3<f32>) -> f32 {
    let size = sky_size();
    let below = direction.z < 0.0;
    let angle = angle_of(length(direction.xy), abs(direction.z));
    let ring = min(i32(angle / PI * f32(size.y)), (size.y + 1) / 2 - 1);
    let row = ring_row(ring, below, size.y);
    let azimuth = angle_of(direction.y, direction.x);
    let turn = fract(0.5 - (azimuth - scene.environment.w) / (2.0 * PI));
    let column = min(i32(turn * f32(size.x)), size.x - 1);
    let of_row = light_sum(ring, -1, size.x + i32(below)) - light_sum(ring - 1, -1, size.x + i32(below));
    let in_row = light_sum(column, row, 0) - light_sum(column - 1, row, 0);
    let falls = ring_falls(ring, size.y);
    return of_row * in_row / (2.0 * PI / f32(size.x) * (falls.y - falls.x));
}

// The density with which the phase draws a direction to the sky; of fibres that of a Lambertian surface. `same_side`:
// the share of looks to the side of the sheet that the direction goes to.
fn density_by_phase(at: Scatter, towards_eye: vec3<f32>, direction: vec3<f32>, same_side: f32) -> f32 {
    if at.what == GROUND {
        if SHADING == SHADING_PHONG {
            return phong_density(at.normal, towards_eye, direction);
        }
        return max(dot(at.normal, direction), 0.0) / PI;
    }
    if PHASE == PHASE_FRAME_LAMBERT {
        return two_sided(at, at.normal, towards_eye, direction);
    }
    if PHASE == PHASE_GRADIENT_LAMBERT {
        return mix(0.25 / PI, two_sided(at, at.axis, towards_eye, direction), at.surfaceness);
    }
    if PHASE == PHASE_KAJIYA_KAY {
        return 0.25 / PI;
    }
    return same_side * (0.5 / PI);
}

// A direction to the sky with three numbers: by the phase, and that of an importance-sampled environment mostly by its
// light (one-sample balance heuristic).
fn draw_sky(at: Scatter, rotation: Rotation, towards_eye: vec3<f32>, u: vec3<f32>) -> Drawn {
    if !SAMPLED_ENVIRONMENT {
        return draw_sky_direction(at, towards_eye, u);
    }
    var direction: vec3<f32>;
    let above = at.point.z >= 0.0;
    // Bent cloth may see as much of the lower half of the sky as of the upper.
    let looks_down = select(scene.looks_down, 0.5, BENT);
    if u.x >= PHASE_SHARE {
        let rest = min((u.x - PHASE_SHARE) * (1.0 / (1.0 - PHASE_SHARE)), 0.99999994);
        direction = sheet_from_world(rotation, direction_by_light((u.z < looks_down) == above, vec2<f32>(rest, u.y)));
    } else {
        let by_phase = vec3<f32>(u.x / PHASE_SHARE, u.yz);
        if at.what == GROUND && shows_fibres(at) {
            direction = cosine_about(at.normal, by_phase.xy);
        } else {
            direction = draw_sky_direction(at, towards_eye, by_phase).direction;
        }
    }
    let in_world = world_from_sheet(rotation, direction);
    let down = (direction.z < 0.0) == above && direction.z != 0.0;
    let down_in_world = (in_world.z < 0.0) == above && in_world.z != 0.0;
    let same_side = select(1.0 - scene.looks_down, scene.looks_down, down);
    let half_share = select(1.0 - looks_down, looks_down, down_in_world);
    let density = PHASE_SHARE * density_by_phase(at, towards_eye, direction, same_side)
        + (1.0 - PHASE_SHARE) * half_share * density_by_light(in_world);
    return Drawn(direction, scattered(at, towards_eye, direction) / max(density, 1.0e-20));
}
