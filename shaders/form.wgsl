// Bent cloth: a ray of the world as a chain of straight stretches through the flat sheet. What facets, their tetrahedra and
// boxes are: renderer-core/src/scene/form/mod.rs. Level cloth has one stretch, the ray itself.

// Texels of a row of form_mesh.
const FORM_ROW: u32 = 1024u;
// Stretches of one ray: far more than there are in any.
const MOST_STRETCHES: u32 = 8192u;
// Boxes looked at for one entry into the cloth.
const MOST_BOXES: u32 = 65536u;

fn form_texel(index: u32) -> vec3<f32> {
    return textureLoad(form_mesh, vec2<u32>(index % FORM_ROW, index / FORM_ROW), 0).xyz;
}

// World position of a corner of a facet's hexahedron.
fn form_corner(facet: vec2<i32>, upper: vec3<u32>) -> vec3<f32> {
    let place = vec2<u32>(facet) + upper.xy;
    return form_texel(2u * (place.y * u32(scene.form_facets.x + 1) + place.x) + upper.z);
}

// One of the six tetrahedra of a facet: shares of the facet fall along these axes, 1 ≥ s[first] ≥ s[second] ≥ s[third] ≥ 0.
struct Order {
    first: u32,
    second: u32,
    third: u32,
}

fn unit_of(axis: u32) -> vec3<u32> {
    return select(vec3<u32>(0u), vec3<u32>(1u), vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u));
}

fn along(vector: vec3<f32>, axis: u32) -> f32 {
    return dot(vector, vec3<f32>(unit_of(axis)));
}

// The corners of a tetrahedron.
struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

fn tet_corners(facet: vec2<i32>, order: Order) -> Corners {
    let second = unit_of(order.first);
    let third = second + unit_of(order.second);
    return Corners(
        form_corner(facet, vec3<u32>(0u)),
        form_corner(facet, second),
        form_corner(facet, third),
        form_corner(facet, vec3<u32>(1u)),
    );
}

// The map of a tetrahedron: origin + x·s.x + y·s.y + z·s.z.
struct TetMap {
    origin: vec3<f32>,
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
}

fn edge_along(axis: u32, order: Order, corners: Corners) -> vec3<f32> {
    return select(
        select(corners.d - corners.c, corners.c - corners.b, order.second == axis),
        corners.b - corners.a,
        order.first == axis,
    );
}

fn tet_map(facet: vec2<i32>, order: Order) -> TetMap {
    let corners = tet_corners(facet, order);
    return TetMap(
        corners.a,
        edge_along(0u, order, corners),
        edge_along(1u, order, corners),
        edge_along(2u, order, corners),
    );
}

// The shares that a vector of the world comes to.
fn shares_along(map: TetMap, vector: vec3<f32>) -> vec3<f32> {
    let yz = cross(map.y, map.z);
    return vec3<f32>(dot(yz, vector), dot(cross(map.z, map.x), vector), dot(cross(map.x, map.y), vector)) / dot(map.x, yz);
}

fn facet_mm() -> vec3<f32> {
    return vec3<f32>(f32(scene.form_facet_cells) * scene.pitch, scene.form_heights.y - scene.form_heights.x);
}

// A place of the cloth.
struct ClothPlace {
    facet: vec2<i32>,
    order: Order,
    shares: vec3<f32>,
}

// The one of a point relative to the centre of a cell.
fn cloth_place(cell: vec2<i32>, point: vec3<f32>) -> ClothPlace {
    let from_first = cell - scene.form_first_cell;
    let facet = clamp(from_first / scene.form_facet_cells, vec2<i32>(0), scene.form_facets - 1);
    let cells = vec2<f32>(from_first - facet * scene.form_facet_cells) + 0.5 + point.xy / scene.pitch;
    // A point beside its cell may be in the next facet.
    let moved = clamp(facet + vec2<i32>(floor(cells / f32(scene.form_facet_cells))), vec2<i32>(0), scene.form_facets - 1);
    let shares = vec3<f32>(
        cells / f32(scene.form_facet_cells) - vec2<f32>(moved - facet),
        (point.z - scene.form_heights.x) / (scene.form_heights.y - scene.form_heights.x),
    );
    let x_before_y = shares.x >= shares.y;
    let high = select(1u, 0u, x_before_y);
    let low = 1u - high;
    let most = max(shares.x, shares.y);
    let least = min(shares.x, shares.y);
    var order = Order(high, low, 2u);
    if shares.z > most {
        order = Order(2u, high, low);
    } else if shares.z > least {
        order = Order(high, 2u, low);
    }
    return ClothPlace(moved, order, shares);
}

// Turns directions of the sheet to those of the world.
struct Turn {
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
}

fn turn_of(map: TetMap) -> Turn {
    let z = normalize(cross(map.x, map.y));
    let x = normalize(map.x);
    return Turn(x, cross(z, x), z);
}

fn turn_at(at: Scatter) -> Turn {
    if !BENT || at.what == NOTHING {
        return Turn(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(0.0, 0.0, 1.0));
    }
    let place = cloth_place(at.cell, at.point);
    return turn_of(tet_map(place.facet, place.order));
}

// The world position of a scattering point.
fn world_point(at: Scatter) -> vec3<f32> {
    if BENT {
        let place = cloth_place(at.cell, at.point);
        let map = tet_map(place.facet, place.order);
        return map.origin + map.x * place.shares.x + map.y * place.shares.y + map.z * place.shares.z;
    }
    let cell = vec2<f32>(at.cell) + 0.5 - 0.5 * vec2<f32>(scene.sheet);
    return at.point + vec3<f32>(cell * scene.pitch, 0.0);
}

fn world_from_sheet(turn: Turn, direction: vec3<f32>) -> vec3<f32> {
    if !BENT {
        return direction;
    }
    return turn.x * direction.x + turn.y * direction.y + turn.z * direction.z;
}

fn sheet_from_world(turn: Turn, direction: vec3<f32>) -> vec3<f32> {
    if !BENT {
        return direction;
    }
    return vec3<f32>(dot(turn.x, direction), dot(turn.y, direction), dot(turn.z, direction));
}

// A ray on its way through the cloth.
struct Way {
    // The part of the ray that is in one tetrahedron, in sheet space; the ray's start is told as if the map were this one all
    // the way.
    stretch: Ray,
    // World mm that the ray had come before its origin, and world mm in a mm of it.
    t_before: f32,
    world_per_sheet: f32,
    // What follows: where the ray is, with which direction of the world, how far from its start it began to count, and whether
    // it is in the cloth.
    place: ClothPlace,
    // World position, outside of the cloth.
    point: vec3<f32>,
    direction: vec3<f32>,
    t: f32,
    t_start: f32,
    inside: bool,
}

// A ray of the world: from a point of the cloth, or, with the same numbers meaning the world, from the eye.
fn way_begin(ray: Ray, in_cloth: bool) -> Way {
    var way: Way;
    way.stretch = ray;
    way.world_per_sheet = 1.0;
    if BENT {
        way.direction = ray.direction;
        way.t_start = ray.t_start;
        way.inside = in_cloth;
        if in_cloth {
            way.place = cloth_place(ray.cell, ray.origin);
        } else {
            let middle = (vec2<f32>(ray.cell) + 0.5 - 0.5 * vec2<f32>(scene.sheet)) * scene.pitch;
            way.point = vec3<f32>(middle + ray.origin.xy, ray.origin.z);
        }
    }
    return way;
}

fn boxes_of(level: u32) -> vec2<u32> {
    return (vec2<u32>(scene.form_facets) + (1u << level) - 1u) >> vec2<u32>(level);
}

// Where a ray goes through a triangle towards the side on which `opposite` lies; FAR if it does not. All is relative to the
// ray's origin.
fn enters_by(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, opposite: vec3<f32>, direction: vec3<f32>) -> f32 {
    let normal = cross(b - a, c - a);
    let speed = dot(normal, direction);
    // Volumes over the three sides: neighbouring triangles have the same of the side they share.
    let sides = vec3<f32>(dot(cross(b, a), direction), dot(cross(c, b), direction), dot(cross(a, c), direction));
    let within = all(sides >= vec3<f32>(0.0)) || all(sides <= vec3<f32>(0.0));
    return select(FAR, dot(normal, a) / speed, within && speed * dot(normal, opposite - a) > 0.0);
}

// The order after another, of the six: (x, y, z), (y, z, x), (z, x, y), then (y, x, z) and so on.
fn next_order(order: Order, index: u32) -> Order {
    if index == 3u {
        return Order(1u, 0u, 2u);
    }
    return Order(order.second, order.third, order.first);
}

// Whether the cloth ends with a facet on a side of an axis.
fn is_outer(facet: vec2<i32>, axis: u32, side: i32) -> bool {
    let beyond = facet + side * vec2<i32>(unit_of(axis).xy);
    return axis == 2u || any(beyond < vec2<i32>(0)) || any(beyond >= scene.form_facets);
}

// Whether shares are in the tetrahedron of an order.
fn is_within(shares: vec3<f32>, order: Order) -> bool {
    let s = vec3<f32>(along(shares, order.first), along(shares, order.second), along(shares, order.third));
    return s.x <= 1.0 && s.y <= s.x && s.z <= s.y && s.z >= 0.0;
}

// Brings a ray from outside to where it comes into the cloth next; false if it never does. One that comes from the eye may be in
// the cloth already. Boxes are looked at in the order of a Z curve, without a stack.
fn enter_cloth(way: ptr<function, Way>, from_eye: bool) -> bool {
    var point = (*way).point;
    let direction = (*way).direction;
    let inverse = bounded_inverse(direction);
    let top = scene.form_levels - 1u;
    let corners_in_all = 2u * u32((scene.form_facets.x + 1) * (scene.form_facets.y + 1));
    var level = top;
    var first = 0u;
    for (var below = 0u; below < top; below++) {
        let count = boxes_of(below);
        first += count.x * count.y;
    }
    if from_eye {
        // Its origin may lie behind where it comes into the box around all, but not its eye.
        let a = (form_texel(corners_in_all + 2u * first) - point) * inverse;
        let b = (form_texel(corners_in_all + 2u * first + 1u) - point) * inverse;
        let near = min(a, b);
        let back = clamp(max(near.x, max(near.y, near.z)), min((*way).t_start, 0.0), 0.0);
        point += back * direction;
        (*way).t += back;
    }
    var at = vec2<u32>(0u);
    var nearest = FAR;
    var nearest_facet = vec2<i32>(0);
    var nearest_order = Order(0u, 1u, 2u);
    for (var n = 0u; n < MOST_BOXES; n++) {
        let count = boxes_of(level);
        var meets = all(at < count);
        var holds = false;
        if meets {
            let texel = corners_in_all + 2u * (first + at.y * count.x + at.x);
            let a = (form_texel(texel) - point) * inverse;
            let b = (form_texel(texel + 1u) - point) * inverse;
            let near = min(a, b);
            let far = max(a, b);
            let enter = max(max(near.x, near.y), max(near.z, 0.0));
            meets = enter <= min(far.x, min(far.y, far.z)) && enter < nearest;
            holds = from_eye && enter <= 0.0;
        }
        if meets && level > 0u {
            level -= 1u;
            let lower = boxes_of(level);
            first -= lower.x * lower.y;
            at *= 2u;
            continue;
        }
        if meets {
            let facet = vec2<i32>(at);
            var order = Order(2u, 0u, 1u);
            for (var index = 0u; index < 6u; index++) {
                order = next_order(order, index);
                let ahead = is_outer(facet, order.first, 1);
                let behind = is_outer(facet, order.third, -1);
                if holds {
                    let map = tet_map(facet, order);
                    if is_within(shares_along(map, point - map.origin), order) {
                        nearest = 0.0;
                        nearest_facet = facet;
                        nearest_order = order;
                        break;
                    }
                }
                if !ahead && !behind {
                    continue;
                }
                let corners = tet_corners(facet, order);
                let a = corners.a - point;
                let b = corners.b - point;
                let c = corners.c - point;
                let d = corners.d - point;
                var t = FAR;
                if ahead {
                    let through = enters_by(b, c, d, a, direction);
                    t = select(t, through, through > 0.0);
                }
                if behind {
                    let through = enters_by(a, b, c, d, direction);
                    t = select(t, min(t, through), through > 0.0);
                }
                if t < nearest {
                    nearest = t;
                    nearest_facet = facet;
                    nearest_order = order;
                }
            }
        }
        // On to the next box that is not in this one.
        while level < top && all((at & vec2<u32>(1u)) == vec2<u32>(1u)) {
            let here = boxes_of(level);
            first += here.x * here.y;
            level += 1u;
            at = at >> vec2<u32>(1u);
        }
        if level == top {
            break;
        }
        if (at.x & 1u) == 0u {
            at.x += 1u;
        } else {
            at = vec2<u32>(at.x - 1u, at.y + 1u);
        }
    }
    if nearest >= FAR {
        return false;
    }
    let map = tet_map(nearest_facet, nearest_order);
    (*way).place = ClothPlace(
        nearest_facet,
        nearest_order,
        clamp(shares_along(map, point + nearest * direction - map.origin), vec3<f32>(0.0), vec3<f32>(1.0)),
    );
    (*way).t += nearest;
    return true;
}

// How far it is until what is `value` and changes by `slope` comes to 0; FAR if it does not.
fn until_zero(value: f32, slope: f32) -> f32 {
    return select(FAR, max(-value / min(slope, -1.0e-30), 0.0), slope < 0.0);
}

// Goes on to the next stretch; false where the ray has left the cloth for good.
fn next_stretch(way: ptr<function, Way>, is_first: bool) -> bool {
    if !(*way).inside {
        (*way).inside = enter_cloth(way, is_first);
        if !(*way).inside {
            return false;
        }
    }
    let facet = (*way).place.facet;
    let order = (*way).place.order;
    let shares = (*way).place.shares;
    let map = tet_map(facet, order);
    let slope = shares_along(map, (*way).direction);
    // What must stay above 0: 1 − s[first], s[first] − s[second], s[second] − s[third], s[third].
    let s = vec3<f32>(along(shares, order.first), along(shares, order.second), along(shares, order.third));
    let v = vec3<f32>(along(slope, order.first), along(slope, order.second), along(slope, order.third));
    let until = vec4<f32>(
        until_zero(1.0 - s.x, -v.x),
        until_zero(s.x - s.y, v.x - v.y),
        until_zero(s.y - s.z, v.y - v.z),
        until_zero(s.z, v.z),
    );
    let leaves = min(min(until.x, until.y), min(until.z, until.w));

    let across = slope * facet_mm();
    let sheet_per_world = length(across);
    let first_cell = scene.form_first_cell + facet * scene.form_facet_cells;
    let corner = vec3<f32>(-0.5 * scene.pitch, scene.form_heights.x);
    var stretch = ray_from(first_cell, corner + shares * facet_mm(), across / sheet_per_world);
    stretch.t_start = ((*way).t_start - (*way).t) * sheet_per_world;
    stretch.t_from = 0.0;
    stretch.t_to = leaves * sheet_per_world;
    (*way).stretch = stretch;
    (*way).t_before = (*way).t;
    (*way).world_per_sheet = 1.0 / sheet_per_world;

    (*way).t += leaves;
    var next = shares + leaves * slope;
    if leaves == until.y {
        (*way).place.order = Order(order.second, order.first, order.third);
    } else if leaves == until.z {
        (*way).place.order = Order(order.first, order.third, order.second);
    } else {
        let ahead = leaves == until.x;
        let axis = select(order.third, order.first, ahead);
        let side = select(-1, 1, ahead);
        if is_outer(facet, axis, side) {
            (*way).inside = false;
            (*way).point = map.origin + map.x * next.x + map.y * next.y + map.z * next.z;
        } else {
            next -= f32(side) * vec3<f32>(unit_of(axis));
            (*way).place.facet = facet + side * vec2<i32>(unit_of(axis).xy);
            (*way).place.order = Order(
                select(order.third, order.second, ahead),
                select(order.first, order.third, ahead),
                select(order.second, order.first, ahead),
            );
        }
    }
    (*way).place.shares = next;
    return true;
}

// The next part of a ray to look for something in; false at the end. `stretches` counts those before.
fn goes_on(way: ptr<function, Way>, stretches: u32) -> bool {
    if !BENT {
        return stretches == 0u;
    }
    return stretches < MOST_STRETCHES && next_stretch(way, stretches == 0u);
}

// What was found in a stretch, as found by the whole ray.
fn placed(at: Scatter, way: Way) -> Scatter {
    var found = at;
    if BENT {
        found.t = way.t_before + at.t * way.world_per_sheet;
    }
    return found;
}
