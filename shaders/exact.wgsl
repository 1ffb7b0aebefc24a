// Method `exact` (MODEL.md §4, §8, §9): a ray's whole way through all loops, their densities summed where they overlap.
//
// A ray's part in a block is cut where it enters or leaves a loop, at each of its texels' centre lines and layer lines,
// and into pieces of at most `slice.step`; a piece is uniform, as it is in its middle. Nothing is kept in arrays: the
// next cut is searched among the loops that the ray meets in the block, and the ones that it is inside of are bits of a
// mask.

// Crossings farther from a loop's middle than this, mm, are no crossings of the loop.
const BEYOND: f32 = 1.0e6;

// Where the line crosses the patch at `w`, FAR where it does not. With S = z − wh, u′v′ is S/(A·n̂), so
// S(1 + αq + βp) − (A·n̂)pq − (αβ/(A·n̂))S² = 0, a quadratic in t; αβ vanishes faster than A·n̂ (MODEL.md §4). A second
// place of the patch with the same p and q, far outside of a convex loop, may add a crossing: a cut that cuts nothing.
fn crossings_of_w(line: LoopLine, w: f32) -> vec2<f32> {
    let value = vec3<f32>(line.value.xy, line.value.z - w * scene.thickness);
    let slope = line.slope;
    let bend = select(line.alpha * line.beta / line.lift, 0.0, abs(line.lift) < 1.0e-6);
    let g = vec2<f32>(
        1.0 + line.alpha * value.y + line.beta * value.x,
        line.alpha * slope.y + line.beta * slope.x,
    );
    let c2 = slope.z * g.y - line.lift * slope.x * slope.y - bend * slope.z * slope.z;
    let c1 = value.z * g.y + slope.z * g.x - line.lift * (value.x * slope.y + slope.x * value.y)
        - 2.0 * bend * value.z * slope.z;
    let c0 = value.z * g.x - line.lift * value.x * value.y - bend * value.z * value.z;
    let discriminant = c1 * c1 - 4.0 * c2 * c0;
    if discriminant < 0.0 {
        return vec2<f32>(FAR);
    }
    let root = sqrt(discriminant);
    let q = -0.5 * (c1 + select(-root, root, c1 >= 0.0));
    // Each division is made only where its result is somewhere near: none is by zero.
    var crossings = vec2<f32>(FAR);
    if abs(c0) < BEYOND * abs(q) {
        crossings.x = line.t_near + c0 / q;
    }
    if abs(q) < BEYOND * abs(c2) {
        crossings.y = line.t_near + q / c2;
    }
    return crossings;
}

// The nearer of `cut` and `t`, if `t` lies beyond `after`.
fn nearer(cut: f32, after: f32, t: f32) -> f32 {
    return select(cut, min(cut, t), t > after);
}

// The nearest centre line of texels or line of layers beyond `t`, from inside the loop. The line that is nearest to the
// place at `t` and its neighbours are looked at: rounding may put the place on either side of a line just crossed, but
// distances of lines are always the same numbers.
fn next_line(line: LoopLine, t: f32) -> f32 {
    let place = place_on(line, t);
    let layers = f32(LAYERS);
    let shift = select(0.0, 0.5, LINEAR_LAYERS);
    let texel = round(place.xy * scene.resolution - 0.5);
    let layer = round((place.z + 0.5) * layers - shift);
    let first_layer = select(1.0, 0.0, LINEAR_LAYERS);
    var cut = FAR;
    for (var step = -1.0; step <= 1.0; step += 1.0) {
        let column = texel.x + step;
        if column >= 0.0 && column < scene.resolution {
            cut = nearer(cut, t, zero_of(line, over_u(line, (column + 0.5) / scene.resolution)));
        }
        let row = texel.y + step;
        if row >= 0.0 && row < scene.resolution {
            cut = nearer(cut, t, zero_of(line, over_v(line, (row + 0.5) / scene.resolution)));
        }
        let border = layer + step;
        if border >= first_layer && border < layers {
            let crossings = crossings_of_w(line, (border + shift) / layers - 0.5);
            cut = nearer(nearer(cut, t, crossings.x), t, crossings.y);
        }
    }
    return cut;
}

// How a ray goes on from a distance.
struct Onward {
    // Next distance at which it enters or leaves the loop or crosses a line in it.
    cut: f32,
    // Whether it is inside the loop until there.
    inside: bool,
}

fn onward_from(line: LoopLine, t: f32) -> Onward {
    let sides = between_sides(line);
    if sides.x >= sides.y || t >= sides.y {
        return Onward(FAR, false);
    }
    let start = max(t, sides.x);
    var end = sides.y;
    for (var w = -0.5; w <= 0.5; w += 1.0) {
        let crossings = crossings_of_w(line, w);
        end = nearer(nearer(end, start, crossings.x), start, crossings.y);
    }
    if abs(place_on(line, 0.5 * (start + end)).z) > 0.5 {
        // Between the side faces, but before or behind the loop: the faces themselves cut nothing.
        return Onward(select(FAR, end, end < sides.y), false);
    }
    if t < start {
        return Onward(start, false);
    }
    return Onward(min(end, next_line(line, t)), true);
}

// What a loop holds at a distance of a ray that is inside of it.
struct Held {
    index: u32,
    // ρ, and ρ times the density of solid yarn.
    rho: f32,
    extinction: f32,
    shade: f32,
    at: vec3<f32>,
}

fn held_by(ray: Ray, block: Block, entry: u32, t: f32) -> Held {
    let listed = open_entry(block, block.entries_start + entry);
    let at = place_on(loop_line(ray, listed), t);
    // In a list so long that bits are shared, this may be a loop that the ray is not inside of.
    let outside = any(abs(at - vec3<f32>(0.5, 0.5, 0.0)) > vec3<f32>(0.5));
    if block.entries_end - block.entries_start > MASKED && outside {
        return Held(listed.index, 0.0, 0.0, 0.0, at);
    }
    let yarn = load_yarn(listed.index);
    let rho = sample_density(yarn, at.x, at.y, layer_at(at.z));
    return Held(listed.index, rho.x, rho.x * yarn.density, rho.y / max(rho.x, 1.0e-6), at);
}

// σ where a ray is inside of the loops of a mask; and the sum of the loops' own, which crowding lowers to σ.
fn extinction_at(ray: Ray, block: Block, inside: vec4<u32>, t: f32) -> vec2<f32> {
    let count = block.entries_end - block.entries_start;
    var sum = 0.0;
    var rho = 0.0;
    for (var i = next_bit(inside, 0u, count); i < count; i = next_bit(inside, i + 1u, count)) {
        let held = held_by(ray, block, i, t);
        sum += held.extinction;
        rho += held.rho;
    }
    return vec2<f32>(sum * min(1.0, MOST_OVERLAP / max(rho, 1.0e-6)), sum);
}

// The end of a march: the piece in which the transmittance e^−depth fell below a threshold.
struct Marched {
    // Whether it did, else the ray left the cloth.
    fell: bool,
    // ∫σ before that piece, or in the end.
    depth: f32,
    start: f32,
    middle: f32,
    // σ, and the sum of the loops' own.
    extinction: f32,
    sum: f32,
    block: Block,
    inside: vec4<u32>,
    // The ground yarn at which it ended, if it was looked for.
    ground: YarnHit,
    ground_known: bool,
}

// Pieces of one ray: far more than there are between any two sides of a carpet.
const MAX_CUTS: u32 = 1048576u;

// The next cut of the loops around a ray beyond a distance, and the loops that it is inside of until there.
struct Cut {
    t: f32,
    inside: vec4<u32>,
}

fn next_cut(ray: Ray, block: Block, around: vec4<u32>, t: f32, t_exit: f32) -> Cut {
    let count = block.entries_end - block.entries_start;
    var cut = Cut(t_exit, vec4<u32>());
    for (var i = next_bit(around, 0u, count); i < count; i = next_bit(around, i + 1u, count)) {
        let onward = onward_from(loop_line(ray, open_entry(block, block.entries_start + i)), t);
        cut.t = min(cut.t, onward.cut);
        if onward.inside {
            cut.inside = with_bit(cut.inside, i);
        }
    }
    return cut;
}

// Marches on to a cut, in pieces.
fn march_to(ray: Ray, cut: Cut, t: f32, depth_to: f32, marched: ptr<function, Marched>) {
    let pieces = max(ceil((cut.t - t) / slice.step), 1.0);
    let piece = (cut.t - t) / pieces;
    for (var k = 0.0; k < pieces; k += 1.0) {
        let middle = t + (k + 0.5) * piece;
        let extinction = extinction_at(ray, (*marched).block, cut.inside, middle);
        if COUNTERS && extinction.x > 0.0 {
            count_contributing_hits += 1u;
        }
        let depth = (*marched).depth + extinction.x * piece;
        if depth > depth_to {
            (*marched).fell = true;
            (*marched).start = t + k * piece;
            (*marched).middle = middle;
            (*marched).extinction = extinction.x;
            (*marched).sum = extinction.y;
            (*marched).inside = cut.inside;
            return;
        }
        (*marched).depth = depth;
    }
}

// Marches through the block that a walk is in; the cuts made so far, and with it.
fn march_block(ray: Ray, walk: Walk, cuts: u32, depth_to: f32, marched: ptr<function, Marched>) -> u32 {
    if COUNTERS {
        count_cells += 1u;
    }
    let block = open_block(ray, walk.place, walk.t_enter, walk.t_exit, MEET_VOLUME);
    (*marched).block = block;
    var segment = RaySegment(vec4<u32>(), 0u, ALL_ENTRIES, walk.t_enter, walk.t_enter, walk.t_enter);
    var t = walk.t_enter;
    var t_look = t;
    var made = cuts;
    while t < walk.t_exit && made < MAX_CUTS && !(*marched).fell {
        made++;
        if t >= segment.next || t_look > segment.next {
            t_look = max(t_look, t);
            segment = segment_from(ray, block, segment.ahead, t, t_look, walk.t_exit);
        }
        let cut = next_cut(ray, block, segment.around, t, walk.t_exit);
        if !any(cut.inside != vec4<u32>()) {
            t = min(cut.t, segment.next);
        } else if cut.t > segment.next {
            // The loops that begin before it may cut as well.
            t_look = cut.t;
        } else {
            march_to(ray, cut, t, depth_to, marched);
            t = cut.t;
        }
    }
    return made;
}

// Ground yarns are looked for when the march comes to `ground_from`; it goes on to the yarn found, or ends at once.
fn march(ray: Ray, depth_to: f32, ground_from: f32, ends_with_ground: bool) -> Marched {
    var marched: Marched;
    marched.ground = no_yarn();
    marched.ground_known = ground_from >= FAR;
    var walk = walk_begin(ray, scene.z_range, FAR);
    let limit = walk_limit();
    var cuts = 0u;
    // One step more than there are blocks, for the ground of rays that leave the loops before they reach it.
    for (var n = 0u; n <= limit && !marched.fell; n++) {
        if !marched.ground_known && (!walk_goes_on(walk) || walk.t_exit > ground_from) {
            marched.ground = ground_along(ray, FAR);
            marched.ground_known = true;
            walk_cut(&walk, marched.ground.t);
            if ends_with_ground && marched.ground.t < FAR {
                break;
            }
        }
        if !walk_goes_on(walk) {
            break;
        }
        cuts = march_block(ray, walk, cuts, depth_to, &marched);
        walk_step(ray, &walk);
    }
    return marched;
}

// Where the optical depth along a ray exceeds `depth_left`, which is lowered by what the ray meets; `choice` in [0, 1)
// picks one of the loops there, by their shares of σ.
fn exact_first(ray: Ray, depth_left: ptr<function, f32>, choice: f32) -> Scatter {
    let depth_to = *depth_left;
    let marched = march(ray, depth_to, ground_search_start(ray), false);
    *depth_left = depth_to - marched.depth;
    if !marched.fell {
        if marched.ground.t < FAR {
            return ground_scatter(ray, marched.ground);
        }
        return no_scatter();
    }
    if COUNTERS && !marched.ground_known {
        count_hidden_rays += 1u;
    }
    let block = marched.block;
    let count = block.entries_end - block.entries_start;
    var rest = choice * marched.sum;
    var chosen: Held;
    let inside = marched.inside;
    for (var i = next_bit(inside, 0u, count); i < count && rest >= 0.0; i = next_bit(inside, i + 1u, count)) {
        let held = held_by(ray, block, i, marched.middle);
        if held.extinction > 0.0 {
            chosen = held;
            rest -= held.extinction;
        }
    }
    let t = marched.start + (depth_to - marched.depth) / marched.extinction;
    return pile_scatter(ray, Gathered(1.0, t, chosen.shade, chosen.at), chosen.index);
}

// V: the share of light that passes all loops and the skeleton along a ray.
fn exact_visibility(ray: Ray) -> f32 {
    let marched = march(ray, select(FAR, -log(DARK), OPAQUE_RAYS), -FAR, true);
    if COUNTERS && marched.fell {
        count_ended_rays += 1u;
    }
    return select(exp(-marched.depth), 0.0, marched.fell || marched.ground.t < FAR);
}
