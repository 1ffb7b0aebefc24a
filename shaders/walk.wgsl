// Walking the grid of cells along a ray (Amanatides and Woo 1987), in coordinates that do not grow with the sheet.
// A boundary's distance is computed from whole cells, never summed up, so it is the same from both of its sides.

// A ray from a point given relative to the centre (x, y) of a cell and to the sheet (z), mm.
struct Ray {
    cell: vec2<i32>,
    origin: vec3<f32>,
    direction: vec3<f32>,
    // Distance at which the ray starts: 0, or the eye's, which lies before the origin of a camera's ray.
    t_start: f32,
}

struct Walk {
    // The cell the walk is in, and the part of the ray inside it.
    cell: vec2<i32>,
    t_enter: f32,
    t_exit: f32,
    // Where the ray leaves the grid's box.
    t_end: f32,
    // 1 / direction, bounded.
    inverse: vec2<f32>,
    // Which way cells follow each other.
    step: vec2<i32>,
    // Distances of the next boundaries across x and y.
    t_next: vec2<f32>,
}

// Below this a direction's component counts as 0: over any distance in a scene it moves less than f32 resolves.
const PARALLEL: f32 = 1.0e-12;

fn bounded_inverse(direction: vec3<f32>) -> vec3<f32> {
    let safe = select(direction, vec3<f32>(PARALLEL), abs(direction) < vec3<f32>(PARALLEL));
    return 1.0 / safe;
}

// The ray from a point relative to `cell`, told relative to the cell that the point is in.
fn ray_from(cell: vec2<i32>, point: vec3<f32>, direction: vec3<f32>) -> Ray {
    let moved = floor(point.xy / scene.pitch + 0.5);
    return Ray(
        cell + vec2<i32>(moved),
        vec3<f32>(point.xy - moved * scene.pitch, point.z),
        direction,
        0.0,
    );
}

fn origin_in_cell(ray: Ray, cell: vec2<i32>) -> vec3<f32> {
    return vec3<f32>(ray.origin.xy - vec2<f32>(cell - ray.cell) * scene.pitch, ray.origin.z);
}

fn walk_boundaries(ray: Ray, walk: Walk) -> vec2<f32> {
    let boundary = (vec2<f32>(walk.cell - ray.cell) + 0.5 * vec2<f32>(walk.step)) * scene.pitch;
    let t = (boundary - ray.origin.xy) * walk.inverse;
    return select(t, vec2<f32>(FAR), abs(ray.direction.xy) < vec2<f32>(PARALLEL));
}

// Clips the ray to distances below `t_to` and to the part of the grid between two heights, and finds its first cell.
fn walk_begin(ray: Ray, heights: vec2<f32>, t_to: f32) -> Walk {
    let inverse = bounded_inverse(ray.direction);
    let first = vec2<f32>(-scene.margin - ray.cell) - 0.5;
    let last = vec2<f32>(scene.sheet + scene.margin - ray.cell) - 0.5;
    let low = vec3<f32>(first * scene.pitch, heights.x);
    let high = vec3<f32>(last * scene.pitch, heights.y);
    let a = (low - ray.origin) * inverse;
    let b = (high - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let t_enter = max(max(near.x, near.y), max(near.z, ray.t_start));
    let t_end = min(min(far.x, far.y), min(far.z, t_to));
    let entry = ray.origin.xy + t_enter * ray.direction.xy;
    let cells = clamp(floor(entry / scene.pitch + 0.5), first + 0.5, last - 0.5);
    var walk = Walk(
        ray.cell + vec2<i32>(cells),
        t_enter,
        t_end,
        t_end,
        inverse.xy,
        select(vec2<i32>(-1), vec2<i32>(1), ray.direction.xy >= vec2<f32>(0.0)),
        vec2<f32>(FAR),
    );
    walk.t_next = walk_boundaries(ray, walk);
    walk.t_exit = max(walk.t_enter, min(walk.t_end, min(walk.t_next.x, walk.t_next.y)));
    return walk;
}

fn walk_goes_on(walk: Walk) -> bool {
    return walk.t_enter < walk.t_end;
}

fn walk_step(ray: Ray, walk: ptr<function, Walk>) {
    if (*walk).t_next.x < (*walk).t_next.y {
        (*walk).cell.x += (*walk).step.x;
    } else {
        (*walk).cell.y += (*walk).step.y;
    }
    let inside = all((*walk).cell >= -scene.margin) && all((*walk).cell < scene.sheet + scene.margin);
    let t_enter = (*walk).t_exit;
    (*walk).t_enter = select((*walk).t_end, t_enter, inside);
    (*walk).t_next = walk_boundaries(ray, *walk);
    (*walk).t_exit = max(t_enter, min((*walk).t_end, min((*walk).t_next.x, (*walk).t_next.y)));
}

// No ray crosses more cells than this.
fn walk_limit() -> u32 {
    let cells = scene.sheet + 2 * scene.margin;
    return u32(cells.x + cells.y) + 2u;
}

// What a cell lists.
struct Cell {
    place: vec2<i32>,
    entries_start: u32,
    entries_end: u32,
    // Lowest and highest point of loops in the cell, mm.
    low: f32,
    high: f32,
    // Lowest and highest point of the ray's part in the cell, in 255ths of the cell's height range.
    ray_low: f32,
    ray_high: f32,
}

fn header_index(cell: vec2<i32>) -> u32 {
    let place = vec2<u32>(cell + scene.margin);
    return place.y * u32(scene.sheet.x + 2 * scene.margin.x) + place.x;
}

// The cell's list, empty where the part of the ray from `t_from` to `t_to` misses the cell's height range.
fn open_cell(ray: Ray, place: vec2<i32>, t_from: f32, t_to: f32) -> Cell {
    let header = cell_headers[header_index(place)];
    let range = bitcast<i32>(header.w);
    let low = f32(extractBits(range, 0u, 16u)) * scene.height_unit;
    let high = f32(extractBits(range, 16u, 16u)) * scene.height_unit;
    let z_from = ray.origin.z + t_from * ray.direction.z;
    let z_to = ray.origin.z + t_to * ray.direction.z;
    let steps = 255.0 / max(high - low, 1.0e-20);
    let ray_low = (min(z_from, z_to) - low) * steps;
    let ray_high = (max(z_from, z_to) - low) * steps;
    // A flat range has no steps: all of its entries are met.
    let flat = high <= low;
    let missed = low > high || min(z_from, z_to) > high || max(z_from, z_to) < low;
    return Cell(
        place,
        header.x,
        header.x + select(header.y, 0u, missed),
        low,
        high,
        select(ray_low, 0.0, flat),
        select(ray_high, 255.0, flat),
    );
}

// The first entry from `start` on whose height range the ray's part in the cell meets; the end of the list if none. A
// loop of its own, so that neighbouring threads that skip different entries come together at the costly test.
fn next_met(cell: Cell, start: u32) -> u32 {
    var index = start;
    for (; index < cell.entries_end; index++) {
        let bits = cell_entries[index];
        let lowest = f32(extractBits(bits, 16u, 8u));
        let highest = f32(extractBits(bits, 24u, 8u));
        if lowest <= cell.ray_high && highest >= cell.ray_low {
            break;
        }
    }
    return index;
}

// A loop that a cell lists.
struct Listed {
    index: u32,
    // Its own cell.
    cell: vec2<i32>,
}

fn open_entry(cell: Cell, index: u32) -> Listed {
    let bits = cell_entries[index];
    let word = bitcast<i32>(bits);
    let own_cell = cell.place + vec2<i32>(extractBits(word, 0u, 8u), extractBits(word, 8u, 7u));
    return Listed(cell_headers[header_index(own_cell)].z + extractBits(bits, 15u, 1u), own_cell);
}
