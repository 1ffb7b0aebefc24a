// Rays of the camera, from the bases that the host computes in f64 for every tile (render::RayTile).

struct RayTile {
    // The cell that the origin is relative to; z and w unused.
    cell: vec4<i32>,
    // Origin of the ray through the tile's reference point, mm; w: how many times the direction lies between the eye
    // and the origin.
    origin: vec4<f32>,
    // Changes for a pixel right and down; w unused.
    origin_dx: vec4<f32>,
    origin_dy: vec4<f32>,
    // Direction, not normalised; w unused.
    direction: vec4<f32>,
    direction_dx: vec4<f32>,
    direction_dy: vec4<f32>,
}

@group(1) @binding(0) var<storage, read> ray_tiles: array<RayTile>;

struct CameraRay {
    ray: Ray,
    // Distance from the eye to the ray's origin, mm.
    from_eye: f32,
}

// `offset` is from the tile's reference point, in pixels.
fn camera_ray(tile_index: u32, offset: vec2<f32>) -> CameraRay {
    let tile = ray_tiles[tile_index];
    let origin = tile.origin.xyz + offset.x * tile.origin_dx.xyz + offset.y * tile.origin_dy.xyz;
    let direction = tile.direction.xyz + offset.x * tile.direction_dx.xyz + offset.y * tile.direction_dy.xyz;
    let stretch = length(direction);
    var ray = ray_from(tile.cell.xy, origin, direction / max(stretch, 1.0e-30));
    // Only the reference ray starts exactly at the cloth's box; others may have entered it before.
    let from_eye = stretch * tile.origin.w;
    ray.t_start = -from_eye;
    return CameraRay(ray, from_eye);
}
