// The ground weave (MODEL.md §7): warps along y and wefts along x, each cell holding its own crossing.
//
// "winding": the yarn is the tube (x − x_i)² + (z − H·s)² = R²; its upper half is the displacement map, its lower half
// the same seen from behind. The ray steps by the tube's distance divided by a bound of its slope, so it cannot jump
// over the tube. "paper": the height field z = A·s (the paper's equation 2), by fixed steps and bisection.

struct YarnHit {
    // FAR where nothing is hit.
    t: f32,
    // Outward, unit.
    normal: vec3<f32>,
    // Along the yarn on its surface, unit; 0 on a cut end.
    along: vec3<f32>,
    // Relative to `cell`.
    point: vec3<f32>,
    cell: vec2<i32>,
}

fn no_yarn() -> YarnHit {
    return YarnHit(FAR, vec3<f32>(), vec3<f32>(), vec3<f32>(), vec2<i32>());
}

// How far off the surface rays that leave it start, as a share of the radius: far above rounding, far below notice.
const YARN_LIFT: f32 = 1.0e-4;
// Enough to graze along a whole cell 8 radii long by smallest steps.
const YARN_STEPS: u32 = 512u;
// Halvings of a bracket of the paper's height field: down to what f32 resolves of a yarn.
const BISECTIONS: u32 = 16u;
// Steps of false position inside a bracket one smallest step wide, where the distance is all but straight.
const REFINEMENTS: u32 = 2u;

// +1 where the warp is over, −1 where it is under.
fn warp_side(stitch: u32, place: u32) -> f32 {
    return f32((stitch >> place) & 1u) * 2.0 - 1.0;
}

// One yarn in one cell, in coordinates across it, along it and up, relative to its crossing.
struct GroundYarn {
    radius: f32,
    pitch: f32,
    // +1 over, −1 under: at the crossing before, at this one and at the next.
    before: f32,
    here: f32,
    next: f32,
}

// s and its derivative at a place along the yarn.
fn winding(yarn: GroundYarn, along: f32) -> vec2<f32> {
    let neighbour = select(yarn.before, yarn.next, along >= 0.0);
    let phase = along * PI / yarn.pitch;
    let half_change = 0.5 * (yarn.here - neighbour);
    return vec2<f32>(
        0.5 * (yarn.here + neighbour) + half_change * cos(phase),
        -half_change * sin(phase) * PI / yarn.pitch,
    );
}

// The part of the range in which start + slope·t is within ±bound.
fn clip_band(range: vec2<f32>, start: f32, slope: f32, bound: f32) -> vec2<f32> {
    let inverse = 1.0 / select(slope, PARALLEL, abs(slope) < PARALLEL);
    let a = (-bound - start) * inverse;
    let b = (bound - start) * inverse;
    return vec2<f32>(max(range.x, min(a, b)), min(range.y, max(a, b)));
}

// Distance from the tube, in the plane across the yarn; negative inside.
fn tube_distance(yarn: GroundYarn, point: vec3<f32>) -> f32 {
    return length(vec2<f32>(point.x, point.z - scene.crimp * winding(yarn, point.y).x)) - yarn.radius;
}

// `origin` and `direction` are (across, along, up); so are the normal and the point returned.
fn winding_hit(yarn: GroundYarn, origin: vec3<f32>, direction: vec3<f32>, range: vec2<f32>) -> YarnHit {
    // The tube's distance changes at most this fast along a unit direction.
    let straight = yarn.before == yarn.here && yarn.next == yarn.here;
    let steepness = select(scene.crimp * PI / yarn.pitch, 0.0, straight);
    let safe_share = inverseSqrt(1.0 + steepness * steepness);
    let smallest = SMALLEST_STEP * yarn.radius;
    var t = range.x;
    var gap = tube_distance(yarn, origin + t * direction);
    var before = t;
    var gap_before = gap;
    // A ray that is inside from the start has met the yarn at its cut end.
    for (var i = 0u; i < YARN_STEPS && gap > 0.0 && t < range.y; i++) {
        before = t;
        gap_before = gap;
        t = min(t + max(gap * safe_share, smallest), range.y);
        gap = tube_distance(yarn, origin + t * direction);
    }
    if gap > 0.0 {
        return no_yarn();
    }
    // False position moves one end of the bracket only, the inner one where the distance is convex: the better end is
    // taken. What remains is far below the lift of rays that leave.
    var after = t;
    var gap_after = gap;
    for (var i = 0u; i < REFINEMENTS && gap_before > 0.0; i++) {
        let middle = mix(before, after, clamp(gap_before / (gap_before - gap_after), 0.0, 1.0));
        let gap_middle = tube_distance(yarn, origin + middle * direction);
        let outside = gap_middle > 0.0;
        before = select(before, middle, outside);
        gap_before = select(gap_before, gap_middle, outside);
        after = select(middle, after, outside);
        gap_after = select(gap_middle, gap_after, outside);
    }
    t = select(after, before, gap_before < -gap_after);
    let point = origin + t * direction;
    let s = winding(yarn, point.y);
    let above = point.z - scene.crimp * s.x;
    let normal = vec3<f32>(point.x, -scene.crimp * s.y * above, above);
    let along = normalize(vec3<f32>(0.0, 1.0, scene.crimp * s.y));
    return YarnHit(t, normal * inverseSqrt(max(dot(normal, normal), 1.0e-30)), along, point, vec2<i32>());
}

// Height above the paper's surface A·s.
fn paper_height(yarn: GroundYarn, point: vec3<f32>) -> f32 {
    let a = sqrt(max(yarn.radius * yarn.radius - point.x * point.x, 0.0));
    return point.z - a * winding(yarn, point.y).x;
}

fn paper_hit(yarn: GroundYarn, origin: vec3<f32>, direction: vec3<f32>, range: vec2<f32>) -> YarnHit {
    var t_before = range.x;
    let side = select(-1.0, 1.0, paper_height(yarn, origin + range.x * direction) >= 0.0);
    for (var i = 1u; i <= PAPER_STEPS; i++) {
        let t = mix(range.x, range.y, f32(i) / f32(PAPER_STEPS));
        if paper_height(yarn, origin + t * direction) * side < 0.0 {
            var low = t_before;
            var high = t;
            for (var k = 0u; k < BISECTIONS; k++) {
                let middle = 0.5 * (low + high);
                let below = paper_height(yarn, origin + middle * direction) * side < 0.0;
                low = select(middle, low, below);
                high = select(high, middle, below);
            }
            // The near end of the bracket: on the side that the ray came from.
            let point = origin + low * direction;
            let s = winding(yarn, point.y);
            let a = sqrt(max(yarn.radius * yarn.radius - point.x * point.x, 0.0));
            let normal = side * vec3<f32>(point.x * s.x, -a * a * s.y, a);
            let along = normalize(vec3<f32>(0.0, 1.0, a * s.y));
            return YarnHit(low, normal * inverseSqrt(max(dot(normal, normal), 1.0e-30)), along, point, vec2<i32>());
        }
        t_before = t;
    }
    return no_yarn();
}

fn yarn_hit(yarn: GroundYarn, origin: vec3<f32>, direction: vec3<f32>, range: vec2<f32>) -> YarnHit {
    if SKELETON == SKELETON_PAPER {
        let strip = clip_band(range, origin.x, direction.x, yarn.radius);
        let within = clip_band(strip, origin.z, direction.z, yarn.radius);
        if within.x >= within.y {
            return no_yarn();
        }
        return paper_hit(yarn, origin, direction, within);
    }
    let strip = clip_band(range, origin.x, direction.x, yarn.radius * ROOMY);
    let within = clip_band(strip, origin.z, direction.z, (yarn.radius + scene.crimp) * ROOMY);
    if within.x >= within.y {
        return no_yarn();
    }
    return winding_hit(yarn, origin, direction, within);
}

// The stitch word of a crossing; the pattern repeats over the sheet.
fn stitch_at(cell: vec2<i32>) -> u32 {
    let place = vec2<u32>(cell) % scene.repeat;
    return stitches[place.y * scene.repeat.x + place.x];
}

fn ground_yarn(stitch: u32, is_weft: bool) -> GroundYarn {
    let here = warp_side(stitch, STITCH_HERE);
    if is_weft {
        let left = warp_side(stitch, STITCH_LEFT);
        let right = warp_side(stitch, STITCH_RIGHT);
        return GroundYarn(scene.yarn_radius.y, scene.pitch.x, -left, -here, -right);
    }
    let near = warp_side(stitch, STITCH_NEAR);
    let far = warp_side(stitch, STITCH_FAR);
    return GroundYarn(scene.yarn_radius.x, scene.pitch.y, near, here, far);
}

// Normal of a yarn's cut end, where a ray enters the cell inside the yarn: only the sheet's border can be there.
fn cut_normal(point: vec3<f32>) -> vec3<f32> {
    let x_border = abs(point.x) * scene.pitch.y > abs(point.y) * scene.pitch.x;
    return select(vec3<f32>(0.0, sign(point.y), 0.0), vec3<f32>(sign(point.x), 0.0, 0.0), x_border);
}

// The nearest ground yarn of a cell between two distances. `ray_origin` is relative to the cell.
fn skeleton_hit(cell: vec2<i32>, ray_origin: vec3<f32>, direction: vec3<f32>, range: vec2<f32>) -> YarnHit {
    // Distances from where the ray enters: small numbers, however far the ray has come.
    let origin = ray_origin + range.x * direction;
    var nearest = no_yarn();
    nearest.t = range.y - range.x;
    var found = false;
    // Warps, then wefts: one body for both, since everything here is inlined.
    for (var weft = 0; weft < 2; weft++) {
        let is_weft = weft == 1;
        let reach = scene.yarn_reach[weft];
        for (var offset = -reach; offset <= reach; offset++) {
            let place = cell + select(vec2<i32>(offset, 0), vec2<i32>(0, offset), is_weft);
            if any(place < vec2<i32>(0)) || any(place >= scene.sheet) {
                continue;
            }
            let shift = vec3<f32>(vec2<f32>(place - cell) * scene.pitch, 0.0);
            let from_yarn = origin - shift;
            let hit = yarn_hit(
                ground_yarn(stitch_at(place), is_weft),
                select(from_yarn, from_yarn.yxz, is_weft),
                select(direction, direction.yxz, is_weft),
                vec2<f32>(0.0, nearest.t),
            );
            if hit.t < FAR {
                var normal = select(hit.normal, hit.normal.yxz, is_weft);
                var along = select(hit.along, hit.along.yxz, is_weft);
                if SKELETON == SKELETON_WINDING && hit.t <= 0.0 {
                    normal = cut_normal(origin);
                    along = vec3<f32>();
                }
                let point = select(hit.point, hit.point.yxz, is_weft);
                nearest = YarnHit(hit.t, normal, along, point + shift, cell);
                found = true;
            }
        }
    }
    nearest.t = select(FAR, range.x + nearest.t, found);
    return nearest;
}

// Ground yarns lie between minus this and this.
fn ground_height() -> f32 {
    let thickest = max(scene.yarn_radius.x, scene.yarn_radius.y);
    return select((thickest + scene.crimp) * ROOMY, thickest, SKELETON == SKELETON_PAPER);
}

// Where a ray enters the heights of ground yarns: before that it meets none. FAR if it never does.
fn ground_entry(ray: Ray) -> f32 {
    if SKELETON == SKELETON_NONE {
        return FAR;
    }
    let range = clip_band(vec2<f32>(ray.t_from, ray.t_to), ray.origin.z, ray.direction.z, ground_height());
    return select(FAR, range.x, range.x < range.y);
}

// From where on the way along a ray ground yarns are looked for.
fn ground_search_start(ray: Ray) -> f32 {
    if HIDDEN_GROUND {
        return ground_entry(ray);
    }
    return -FAR;
}

// The first ground yarn that a ray meets before `t_to`. A walk of its own, through the few cells in which the ray is
// within the yarns' heights.
fn ground_along(ray: Ray, t_to: f32) -> YarnHit {
    var hit = no_yarn();
    if SKELETON == SKELETON_NONE {
        return hit;
    }
    let highest = ground_height();
    var walk = walk_cells_begin(ray, vec2<f32>(-highest, highest), t_to);
    let limit = walk_limit();
    for (var n = 0u; n < limit && walk_goes_on(walk) && hit.t >= FAR; n++) {
        let range = vec2<f32>(walk.t_enter, walk.t_exit);
        hit = skeleton_hit(walk.place, origin_in_cell(ray, walk.place), ray.direction, range);
        walk_step(ray, &walk);
    }
    return hit;
}

// Where light is scattered by a ground yarn.
fn ground_scatter(ray: Ray, hit: YarnHit) -> Scatter {
    let facing = select(-1.0, 1.0, dot(hit.normal, ray.direction) <= 0.0) * hit.normal;
    let lift = YARN_LIFT * min(scene.yarn_radius.x, scene.yarn_radius.y);
    let point = hit.point + lift * facing;
    return Scatter(GROUND, hit.cell, point, hit.t, facing, hit.along, 0.0, scene.skeleton_albedo.xyz, 0u);
}
