// Rays of the camera, from the bases that the host computes in f64 for every tile (render::RayTile).

struct RayTile {
    // The cell that the origin is relative to; z: which tile of the picture it is; w unused.
    cell: vec4<i32>,
    // Origin of the ray through the tile's reference point, mm; w: how many times the direction lies between the eye
    // and the origin.
    origin: vec4<f32>,
    // Changes for a pixel right and down, in whole multiples of a power of two, so that a tile's worth of them is exact
    // in f32; w: how much closer together origins get.
    origin_dx: vec4<f32>,
    origin_dy: vec4<f32>,
    // What is left of the changes; w unused.
    origin_dx_rest: vec4<f32>,
    origin_dy_rest: vec4<f32>,
    // Size of a cell: the part in the same multiples, then the rest.
    pitch: vec4<f32>,
    // Direction, not normalised; w unused.
    direction: vec4<f32>,
    // Its changes for a pixel right and down; w: changes of how many directions lie before the origin.
    direction_dx: vec4<f32>,
    direction_dy: vec4<f32>,
}

@group(1) @binding(0) var<storage, read> ray_tiles: array<RayTile>;

struct CameraRay {
    ray: Ray,
    // Distance from the eye to the ray's origin, mm.
    from_eye: f32,
}

// The ray through a point given in pixels from the tile's reference point: whole pixels, and the place in the pixel.
//
// Origins of a tile may lie a hundred cells apart, and are wanted to 10⁻⁷ mm: the large parts of the way, whole pixels
// there and whole cells back, are sums without rounding.
fn camera_ray(tile_index: u32, pixel: vec2<f32>, film: vec2<f32>) -> CameraRay {
    let tile = ray_tiles[tile_index];
    let coarse = pixel.x * tile.origin_dx.xyz + pixel.y * tile.origin_dy.xyz;
    let fine = film.x * tile.origin_dx.xyz + film.y * tile.origin_dy.xyz
        + ((pixel.x + film.x) * tile.origin_dx_rest.xyz + (pixel.y + film.y) * tile.origin_dy_rest.xyz);
    let offset = pixel + film;
    let shrink = offset.x * tile.origin_dx.w + offset.y * tile.origin_dy.w;
    // (coarse + fine) / (1 + shrink) = coarse + fine − …
    let shrunk = (coarse + fine) * (shrink / (1.0 + shrink));
    let rest = tile.origin.xyz + (fine - shrunk);
    let moved = floor((coarse + rest).xy / scene.pitch + 0.5);
    let near = (coarse.xy - moved * tile.pitch.xy) + (rest.xy - moved * tile.pitch.zw);
    let direction = tile.direction.xyz + offset.x * tile.direction_dx.xyz + offset.y * tile.direction_dy.xyz;
    let stretch = length(direction);
    let depth = tile.origin.w + offset.x * tile.direction_dx.w + offset.y * tile.direction_dy.w;
    let from_eye = stretch * depth / (1.0 + shrink);
    // Origins need not lie where their rays enter the cloth's box: some may have entered it before.
    let ray = Ray(
        tile.cell.xy + vec2<i32>(moved),
        vec3<f32>(near, coarse.z + rest.z),
        direction / max(stretch, 1.0e-30),
        -from_eye,
        -from_eye,
        FAR,
    );
    return CameraRay(ray, from_eye);
}
