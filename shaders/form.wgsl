// Bent cloth: a ray of the world as a chain of straight segments through the flat sheet. What facets, their tetrahedra
// and boxes are: renderer-core/src/scene/form/mod.rs. Level cloth has one segment, the ray itself.

// Segments of one ray: far more than there are in any.
const MOST_SEGMENTS: u32 = 8192u;
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

// One of the six tetrahedra of a facet: coordinates in the facet, from 0 to 1, fall along these axes,
// 1 ≥ s[first] ≥ s[second] ≥ s[third] ≥ 0.
struct KuhnTetrahedron {
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

// A vector's components along a tetrahedron's axes.
fn in_order(vector: vec3<f32>, tetrahedron: KuhnTetrahedron) -> vec3<f32> {
    return vec3<f32>(
        along(vector, tetrahedron.first),
        along(vector, tetrahedron.second),
        along(vector, tetrahedron.third),
    );
}

// The corners of a tetrahedron.
struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

fn tet_corners(facet: vec2<i32>, tetrahedron: KuhnTetrahedron) -> Corners {
    let second = unit_of(tetrahedron.first);
    let third = second + unit_of(tetrahedron.second);
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

fn edge_along(axis: u32, tetrahedron: KuhnTetrahedron, corners: Corners) -> vec3<f32> {
    return select(
        select(corners.d - corners.c, corners.c - corners.b, tetrahedron.second == axis),
        corners.b - corners.a,
        tetrahedron.first == axis,
    );
}

fn tet_map(facet: vec2<i32>, tetrahedron: KuhnTetrahedron) -> TetMap {
    let corners = tet_corners(facet, tetrahedron);
    return TetMap(
        corners.a,
        edge_along(0u, tetrahedron, corners),
        edge_along(1u, tetrahedron, corners),
        edge_along(2u, tetrahedron, corners),
    );
}

// A vector of the world in coordinates of the facet.
fn coordinates_along(map: TetMap, vector: vec3<f32>) -> vec3<f32> {
    let yz = cross(map.y, map.z);
    let across = vec3<f32>(dot(yz, vector), dot(cross(map.z, map.x), vector), dot(cross(map.x, map.y), vector));
    return across / dot(map.x, yz);
}

fn facet_mm() -> vec3<f32> {
    return vec3<f32>(f32(scene.form_facet_cells) * scene.pitch, scene.form_heights.y - scene.form_heights.x);
}

// A place of the cloth.
struct ClothPlace {
    facet: vec2<i32>,
    tetrahedron: KuhnTetrahedron,
    coordinates: vec3<f32>,
}

// The one of a point relative to the centre of a cell.
fn cloth_place(cell: vec2<i32>, point: vec3<f32>) -> ClothPlace {
    let from_first = cell - scene.form_first_cell;
    let facet = clamp(from_first / scene.form_facet_cells, vec2<i32>(0), scene.form_facets - 1);
    let cells = vec2<f32>(from_first - facet * scene.form_facet_cells) + 0.5 + point.xy / scene.pitch;
    // A point beside its cell may be in the next facet.
    let ahead = vec2<i32>(floor(cells / f32(scene.form_facet_cells)));
    let moved = clamp(facet + ahead, vec2<i32>(0), scene.form_facets - 1);
    let coordinates = vec3<f32>(
        cells / f32(scene.form_facet_cells) - vec2<f32>(moved - facet),
        (point.z - scene.form_heights.x) / (scene.form_heights.y - scene.form_heights.x),
    );
    let x_before_y = coordinates.x >= coordinates.y;
    let high = select(1u, 0u, x_before_y);
    let low = 1u - high;
    let most = max(coordinates.x, coordinates.y);
    let least = min(coordinates.x, coordinates.y);
    var tetrahedron = KuhnTetrahedron(high, low, 2u);
    if coordinates.z > most {
        tetrahedron = KuhnTetrahedron(2u, high, low);
    } else if coordinates.z > least {
        tetrahedron = KuhnTetrahedron(high, 2u, low);
    }
    return ClothPlace(moved, tetrahedron, coordinates);
}

// Turns directions of the sheet to those of the world.
struct Rotation {
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
}

fn rotation_of(map: TetMap) -> Rotation {
    let z = normalize(cross(map.x, map.y));
    let x = normalize(map.x);
    return Rotation(x, cross(z, x), z);
}

fn rotation_at(at: Scatter) -> Rotation {
    if !BENT || at.what == NOTHING {
        return Rotation(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(0.0, 0.0, 1.0));
    }
    let place = cloth_place(at.cell, at.point);
    return rotation_of(tet_map(place.facet, place.tetrahedron));
}

// The world position of a scattering point.
fn world_point(at: Scatter) -> vec3<f32> {
    if BENT {
        let place = cloth_place(at.cell, at.point);
        let map = tet_map(place.facet, place.tetrahedron);
        return map.origin + map.x * place.coordinates.x + map.y * place.coordinates.y + map.z * place.coordinates.z;
    }
    let cell = vec2<f32>(at.cell) + 0.5 - 0.5 * vec2<f32>(scene.sheet);
    return at.point + vec3<f32>(cell * scene.pitch, 0.0);
}

fn world_from_sheet(rotation: Rotation, direction: vec3<f32>) -> vec3<f32> {
    if !BENT {
        return direction;
    }
    return rotation.x * direction.x + rotation.y * direction.y + rotation.z * direction.z;
}

fn sheet_from_world(rotation: Rotation, direction: vec3<f32>) -> vec3<f32> {
    if !BENT {
        return direction;
    }
    return vec3<f32>(dot(rotation.x, direction), dot(rotation.y, direction), dot(rotation.z, direction));
}

// A ray through the cloth, segment by segment.
struct RaySegments {
    // The part of the ray that is in one tetrahedron, in sheet space; the ray's start is where it would be if the map
    // were this one all along.
    segment: Ray,
    // World mm that the ray had come before its origin, and world mm in a mm of it.
    t_before: f32,
    world_per_sheet: f32,
    // What follows: where the ray is, with which direction of the world, how far from its start it began to count, and
    // whether it is in the cloth.
    place: ClothPlace,
    // World position, outside of the cloth.
    point: vec3<f32>,
    direction: vec3<f32>,
    t: f32,
    t_start: f32,
    inside: bool,
}

// A ray of the world: from a point of the cloth, or, with the same numbers meaning the world, from the eye.
fn ray_segments(ray: Ray, in_cloth: bool) -> RaySegments {
    var segments: RaySegments;
    segments.segment = ray;
    segments.world_per_sheet = 1.0;
    if BENT {
        segments.direction = ray.direction;
        segments.t_start = ray.t_start;
        segments.inside = in_cloth;
        if in_cloth {
            segments.place = cloth_place(ray.cell, ray.origin);
        } else {
            let middle = (vec2<f32>(ray.cell) + 0.5 - 0.5 * vec2<f32>(scene.sheet)) * scene.pitch;
            segments.point = vec3<f32>(middle + ray.origin.xy, ray.origin.z);
        }
    }
    return segments;
}

fn boxes_of(level: u32) -> vec2<u32> {
    return (vec2<u32>(scene.form_facets) + (1u << level) - 1u) >> vec2<u32>(level);
}

// Where a ray goes through a triangle towards the side on which `opposite` lies; FAR if it does not. All is relative to
// the ray's origin.
fn enters_by(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, opposite: vec3<f32>, direction: vec3<f32>) -> f32 {
    let normal = cross(b - a, c - a);
    let speed = dot(normal, direction);
    // Volumes over the three sides: neighbouring triangles have the same of the side they share.
    let sides = vec3<f32>(dot(cross(b, a), direction), dot(cross(c, b), direction), dot(cross(a, c), direction));
    let within = all(sides >= vec3<f32>(0.0)) || all(sides <= vec3<f32>(0.0));
    return select(FAR, dot(normal, a) / speed, within && speed * dot(normal, opposite - a) > 0.0);
}

// The tetrahedron after another, of the six: (x, y, z), (y, z, x), (z, x, y), then (y, x, z) and so on.
fn next_tetrahedron(tetrahedron: KuhnTetrahedron, index: u32) -> KuhnTetrahedron {
    if index == 3u {
        return KuhnTetrahedron(1u, 0u, 2u);
    }
    return KuhnTetrahedron(tetrahedron.second, tetrahedron.third, tetrahedron.first);
}

// Whether the cloth ends with a facet on a side of an axis.
fn is_outer(facet: vec2<i32>, axis: u32, side: i32) -> bool {
    let beyond = facet + side * vec2<i32>(unit_of(axis).xy);
    return axis == 2u || any(beyond < vec2<i32>(0)) || any(beyond >= scene.form_facets);
}

// Whether coordinates are those of a point in a tetrahedron.
fn is_within(coordinates: vec3<f32>, tetrahedron: KuhnTetrahedron) -> bool {
    let s = in_order(coordinates, tetrahedron);
    return s.x <= 1.0 && s.y <= s.x && s.z <= s.y && s.z >= 0.0;
}

// Where a ray comes into the cloth, and into which tetrahedron; FAR if it does not.
struct Entry {
    t: f32,
    facet: vec2<i32>,
    tetrahedron: KuhnTetrahedron,
}

// Where a ray enters a tetrahedron of a facet by those of its sides at which the cloth ends; FAR if it does not.
fn tet_entry(facet: vec2<i32>, tetrahedron: KuhnTetrahedron, point: vec3<f32>, direction: vec3<f32>) -> f32 {
    let ahead = is_outer(facet, tetrahedron.first, 1);
    let behind = is_outer(facet, tetrahedron.third, -1);
    var t = FAR;
    if !ahead && !behind {
        return t;
    }
    let corners = tet_corners(facet, tetrahedron);
    let a = corners.a - point;
    let b = corners.b - point;
    let c = corners.c - point;
    let d = corners.d - point;
    if ahead {
        let through = enters_by(b, c, d, a, direction);
        t = select(t, through, through > 0.0);
    }
    if behind {
        let through = enters_by(a, b, c, d, direction);
        t = select(t, min(t, through), through > 0.0);
    }
    return t;
}

// The nearest of an entry and those into a facet's tetrahedra. One that holds the ray's start, if any may, is entered
// at once.
fn facet_entry(nearest: Entry, facet: vec2<i32>, point: vec3<f32>, direction: vec3<f32>, may_hold: bool) -> Entry {
    var entry = nearest;
    var tetrahedron = KuhnTetrahedron(2u, 0u, 1u);
    for (var index = 0u; index < 6u; index++) {
        tetrahedron = next_tetrahedron(tetrahedron, index);
        if may_hold {
            let map = tet_map(facet, tetrahedron);
            if is_within(coordinates_along(map, point - map.origin), tetrahedron) {
                return Entry(0.0, facet, tetrahedron);
            }
        }
        let t = tet_entry(facet, tetrahedron, point, direction);
        if t < entry.t {
            entry = Entry(t, facet, tetrahedron);
        }
    }
    return entry;
}

// A box around facets.
struct FacetBox {
    level: u32,
    // The number of the level's first box among those of all levels.
    first: u32,
    at: vec2<u32>,
}

// The one box around all facets.
fn box_around_all() -> FacetBox {
    let top = scene.form_levels - 1u;
    var first = 0u;
    for (var below = 0u; below < top; below++) {
        let count = boxes_of(below);
        first += count.x * count.y;
    }
    return FacetBox(top, first, vec2<u32>(0u));
}

// The first of the four boxes that a box is made of.
fn first_within(whole: FacetBox) -> FacetBox {
    let level = whole.level - 1u;
    let count = boxes_of(level);
    return FacetBox(level, whole.first - count.x * count.y, whole.at * 2u);
}

// The next box, in the order of a Z curve, that is not in this one; the one around all if this is the last.
fn box_after(here: FacetBox) -> FacetBox {
    let top = scene.form_levels - 1u;
    var after = here;
    while after.level < top && all((after.at & vec2<u32>(1u)) == vec2<u32>(1u)) {
        let count = boxes_of(after.level);
        after.first += count.x * count.y;
        after.level += 1u;
        after.at = after.at >> vec2<u32>(1u);
    }
    if after.level < top {
        let is_left = (after.at.x & 1u) == 0u;
        after.at = select(vec2<u32>(after.at.x - 1u, after.at.y + 1u), after.at + vec2<u32>(1u, 0u), is_left);
    }
    return after;
}

// A box's least and greatest corner, relative to a point.
struct BoxCorners {
    least: vec3<f32>,
    greatest: vec3<f32>,
}

fn corners_of_box(here: FacetBox, point: vec3<f32>) -> BoxCorners {
    let corners_in_all = 2u * u32((scene.form_facets.x + 1) * (scene.form_facets.y + 1));
    let texel = corners_in_all + 2u * (here.first + here.at.y * boxes_of(here.level).x + here.at.x);
    return BoxCorners(form_texel(texel) - point, form_texel(texel + 1u) - point);
}

// Where a ray enters a box, 0 if it starts in it; FAR if it does not, or if there is no such box.
fn box_entry(here: FacetBox, point: vec3<f32>, inverse: vec3<f32>) -> f32 {
    if any(here.at >= boxes_of(here.level)) {
        return FAR;
    }
    let corners = corners_of_box(here, point);
    let a = corners.least * inverse;
    let b = corners.greatest * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    return select(FAR, enter, enter <= min(far.x, min(far.y, far.z)));
}

// Brings a ray from outside to where it comes into the cloth next; false if it never does. One that comes from the eye
// may be in the cloth already. Boxes are looked at in the order of a Z curve, without a stack.
fn enter_cloth(segments: ptr<function, RaySegments>, from_eye: bool) -> bool {
    var point = (*segments).point;
    let direction = (*segments).direction;
    let inverse = bounded_inverse(direction);
    var here = box_around_all();
    if from_eye {
        // Its origin may lie behind where it comes into the box around all, but not its eye.
        let corners = corners_of_box(here, point);
        let near = min(corners.least * inverse, corners.greatest * inverse);
        let back = clamp(max(near.x, max(near.y, near.z)), min((*segments).t_start, 0.0), 0.0);
        point += back * direction;
        (*segments).t += back;
    }
    var nearest = Entry(FAR, vec2<i32>(0), KuhnTetrahedron(0u, 1u, 2u));
    for (var n = 0u; n < MOST_BOXES; n++) {
        let enter = box_entry(here, point, inverse);
        if enter < nearest.t && here.level > 0u {
            here = first_within(here);
            continue;
        }
        if enter < nearest.t {
            nearest = facet_entry(nearest, vec2<i32>(here.at), point, direction, from_eye && enter <= 0.0);
        }
        here = box_after(here);
        if here.level == scene.form_levels - 1u {
            break;
        }
    }
    if nearest.t >= FAR {
        return false;
    }
    let map = tet_map(nearest.facet, nearest.tetrahedron);
    (*segments).place = ClothPlace(
        nearest.facet,
        nearest.tetrahedron,
        clamp(coordinates_along(map, point + nearest.t * direction - map.origin), vec3<f32>(0.0), vec3<f32>(1.0)),
    );
    (*segments).t += nearest.t;
    return true;
}

// How far it is until what is `value` and changes by `slope` comes to 0; FAR if it does not.
fn until_zero(value: f32, slope: f32) -> f32 {
    return select(FAR, max(-value / min(slope, -1.0e-30), 0.0), slope < 0.0);
}

// Goes on to the next segment; false where the ray has left the cloth for good.
fn next_segment(segments: ptr<function, RaySegments>, is_first: bool) -> bool {
    if !(*segments).inside {
        (*segments).inside = enter_cloth(segments, is_first);
        if !(*segments).inside {
            return false;
        }
    }
    let facet = (*segments).place.facet;
    let tetrahedron = (*segments).place.tetrahedron;
    let coordinates = (*segments).place.coordinates;
    let map = tet_map(facet, tetrahedron);
    let slope = coordinates_along(map, (*segments).direction);
    // What must stay above 0: 1 − s[first], s[first] − s[second], s[second] − s[third], s[third].
    let s = in_order(coordinates, tetrahedron);
    let v = in_order(slope, tetrahedron);
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
    var segment = ray_from(first_cell, corner + coordinates * facet_mm(), across / sheet_per_world);
    segment.t_start = ((*segments).t_start - (*segments).t) * sheet_per_world;
    segment.t_from = 0.0;
    segment.t_to = leaves * sheet_per_world;
    (*segments).segment = segment;
    (*segments).t_before = (*segments).t;
    (*segments).world_per_sheet = 1.0 / sheet_per_world;

    (*segments).t += leaves;
    var next = coordinates + leaves * slope;
    if leaves == until.y {
        (*segments).place.tetrahedron = KuhnTetrahedron(tetrahedron.second, tetrahedron.first, tetrahedron.third);
    } else if leaves == until.z {
        (*segments).place.tetrahedron = KuhnTetrahedron(tetrahedron.first, tetrahedron.third, tetrahedron.second);
    } else {
        let ahead = leaves == until.x;
        let axis = select(tetrahedron.third, tetrahedron.first, ahead);
        let side = select(-1, 1, ahead);
        if is_outer(facet, axis, side) {
            (*segments).inside = false;
            (*segments).point = map.origin + map.x * next.x + map.y * next.y + map.z * next.z;
        } else {
            next -= f32(side) * vec3<f32>(unit_of(axis));
            (*segments).place.facet = facet + side * vec2<i32>(unit_of(axis).xy);
            (*segments).place.tetrahedron = KuhnTetrahedron(
                select(tetrahedron.third, tetrahedron.second, ahead),
                select(tetrahedron.first, tetrahedron.third, ahead),
                select(tetrahedron.second, tetrahedron.first, ahead),
            );
        }
    }
    (*segments).place.coordinates = next;
    return true;
}

// The next part of a ray to look for something in; false at the end. `count` is how many came before.
fn goes_on(segments: ptr<function, RaySegments>, count: u32) -> bool {
    if !BENT {
        return count == 0u;
    }
    return count < MOST_SEGMENTS && next_segment(segments, count == 0u);
}

// What was found in a segment, as found by the whole ray.
fn placed(at: Scatter, segments: RaySegments) -> Scatter {
    var found = at;
    if BENT {
        found.t = segments.t_before + at.t * segments.world_per_sheet;
    }
    return found;
}
