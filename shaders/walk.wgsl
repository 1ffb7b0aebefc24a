// Walking the grid of blocks, or the cells of the flat sheet, along a ray (Amanatides and Woo 1987), in coordinates
// that do not grow with the sheet. A boundary's distance is computed from whole cells, never summed up, so it is the
// same from both of its sides.

// A ray from a point given relative to the centre (x, y) of a cell and to the sheet (z), mm.
struct Ray {
    cell: vec2<i32>,
    origin: vec3<f32>,
    direction: vec3<f32>,
    // Distance at which the ray starts: 0, or the eye's, which lies before the origin of a camera's ray.
    t_start: f32,
    // The part of it that is looked at: all, or a segment of it through bent cloth.
    t_from: f32,
    t_to: f32,
}

struct Walk {
    // The block the walk is in (or the cell, where it goes from cell to cell), and the part of the ray inside it.
    place: vec2<i32>,
    t_enter: f32,
    t_exit: f32,
    // Where the ray leaves what is walked through.
    t_end: f32,
    // 1 / direction, bounded.
    inverse: vec2<f32>,
    // Which way places follow each other.
    step: vec2<i32>,
    // Distances of the next boundaries across x and y.
    t_next: vec2<f32>,
    // The first place, and the one behind the last.
    first: vec2<i32>,
    end: vec2<i32>,
    // A place is 1 << shift cells wide and deep.
    shift: u32,
}

// Below this a direction's component counts as 0: over any distance in a scene it moves less than f32 resolves.
const PARALLEL: f32 = 1.0e-12;

fn bounded_inverse(direction: vec3<f32>) -> vec3<f32> {
    let safe = select(direction, vec3<f32>(PARALLEL), abs(direction) < vec3<f32>(PARALLEL));
    return 1.0 / safe;
}

// The ray from a point relative to `cell`, given relative to the cell that the point is in.
fn ray_from(cell: vec2<i32>, point: vec3<f32>, direction: vec3<f32>) -> Ray {
    let moved = floor(point.xy / scene.pitch + 0.5);
    return Ray(
        cell + vec2<i32>(moved),
        vec3<f32>(point.xy - moved * scene.pitch, point.z),
        direction,
        0.0,
        0.0,
        FAR,
    );
}

fn origin_in_cell(ray: Ray, cell: vec2<i32>) -> vec3<f32> {
    return vec3<f32>(ray.origin.xy - vec2<f32>(cell - ray.cell) * scene.pitch, ray.origin.z);
}

fn walk_boundaries(ray: Ray, walk: Walk) -> vec2<f32> {
    let ahead = walk.place + select(vec2<i32>(0), vec2<i32>(1), walk.step > vec2<i32>(0));
    let boundary = (vec2<f32>((ahead << vec2<u32>(walk.shift)) - ray.cell) - 0.5) * scene.pitch;
    let t = (boundary - ray.origin.xy) * walk.inverse;
    return select(t, vec2<f32>(FAR), abs(ray.direction.xy) < vec2<f32>(PARALLEL));
}

// Clips the ray to distances below `t_to`, to places from `first` to before `end`, and to what is between two heights,
// and finds its first place.
fn walk_over(ray: Ray, heights: vec2<f32>, t_to: f32, first: vec2<i32>, end: vec2<i32>, shift: u32) -> Walk {
    let inverse = bounded_inverse(ray.direction);
    let first_edge = vec2<f32>((first << vec2<u32>(shift)) - ray.cell) - 0.5;
    let last_edge = vec2<f32>((end << vec2<u32>(shift)) - ray.cell) - 0.5;
    let low = vec3<f32>(first_edge * scene.pitch, heights.x);
    let high = vec3<f32>(last_edge * scene.pitch, heights.y);
    let a = (low - ray.origin) * inverse;
    let b = (high - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let t_enter = max(max(near.x, near.y), max(near.z, ray.t_from));
    let t_end = min(min(far.x, far.y), min(far.z, min(ray.t_to, t_to)));
    let entry = ray.origin.xy + t_enter * ray.direction.xy;
    let cells = clamp(floor(entry / scene.pitch + 0.5), first_edge + 0.5, last_edge - 0.5);
    var walk = Walk(
        (ray.cell + vec2<i32>(cells)) >> vec2<u32>(shift),
        t_enter,
        t_end,
        t_end,
        inverse.xy,
        select(vec2<i32>(-1), vec2<i32>(1), ray.direction.xy >= vec2<f32>(0.0)),
        vec2<f32>(FAR),
        first,
        end,
        shift,
    );
    walk.t_next = walk_boundaries(ray, walk);
    walk.t_exit = max(walk.t_enter, min(walk.t_end, min(walk.t_next.x, walk.t_next.y)));
    return walk;
}

// The blocks along a ray.
fn walk_begin(ray: Ray, heights: vec2<f32>, t_to: f32) -> Walk {
    return walk_over(ray, heights, t_to, -scene.margin, scene.blocks - scene.margin, scene.block_shift);
}

// The cells of the sheet along a ray.
fn walk_cells_begin(ray: Ray, heights: vec2<f32>, t_to: f32) -> Walk {
    return walk_over(ray, heights, t_to, vec2<i32>(0), scene.sheet, 0u);
}

fn walk_goes_on(walk: Walk) -> bool {
    return walk.t_enter < walk.t_end;
}

fn walk_step(ray: Ray, walk: ptr<function, Walk>) {
    if (*walk).t_next.x < (*walk).t_next.y {
        (*walk).place.x += (*walk).step.x;
    } else {
        (*walk).place.y += (*walk).step.y;
    }
    let inside = all((*walk).place >= (*walk).first) && all((*walk).place < (*walk).end);
    let t_enter = (*walk).t_exit;
    (*walk).t_enter = select((*walk).t_end, t_enter, inside);
    (*walk).t_next = walk_boundaries(ray, *walk);
    (*walk).t_exit = max(t_enter, min((*walk).t_end, min((*walk).t_next.x, (*walk).t_next.y)));
}

// No walk has more steps than this.
fn walk_limit() -> u32 {
    let cells = max(scene.blocks << vec2<u32>(scene.block_shift), scene.sheet);
    return u32(cells.x + cells.y) + 2u;
}
