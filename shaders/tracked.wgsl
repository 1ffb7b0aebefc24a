// Method `tracked` (MODEL.md §9): delta tracking (Woodcock 1965) through the summed densities of overlapping loops,
// and ratio tracking (Novák et al. 2014) for shadow rays. Unbiased.
//
// A ray's part in a block is cut into segments. In one only the loops around it are looked at, where there are none
// nothing is spent, and the majorant is that of as many loops as are around.

// Densities at a point, summed over the loops of a block.
struct Overlap {
    // Σ density_k·ρ_k · min(1, 1.5/Σρ_k), 1/mm.
    extinction: f32,
    // One of the loops, drawn in proportion to density_k·ρ_k, and where the point is in it.
    index: u32,
    shade: f32,
    at: vec3<f32>,
}

// A mean free path below 1/256 mm is no different from a surface; denser yarn collides at once where it begins, and
// tracking through the empty parts beside it stays affordable.
const MAX_MAJORANT: f32 = 256.0;
// Collisions, real or null, of one ray. At MAX_MAJORANT this is a path of 250 mm through blocks that list loops.
const MAX_COLLISIONS: u32 = 65536u;

// A loop that holds a point.
struct Holder {
    // Place in the block's list; its end where there is none.
    entry: u32,
    index: u32,
    // The point in the loop.
    at: vec3<f32>,
}

// The first loop from `start` on in a block's list that holds the point, of those around. A loop of its own, like
// next_met.
fn next_holder(block: Block, around: vec4<u32>, start: u32, point: vec3<f32>) -> Holder {
    var holder = Holder(start, 0u, vec3<f32>());
    for (; holder.entry < block.entries_end; holder.entry++) {
        holder.entry = next_of(block, around, holder.entry);
        if holder.entry >= block.entries_end {
            break;
        }
        if COUNTERS {
            count_patch_tests += 1u;
        }
        let listed = open_entry(block, holder.entry);
        let shape = load_patch(listed.index);
        let shift = vec2<f32>(listed.cell - (block.place << vec2<u32>(scene.block_shift))) * scene.pitch;
        holder.index = listed.index;
        holder.at = invert_point(shape, patch_normal(shape), vec3<f32>(point.xy - shift, point.z));
        if all(abs(holder.at - vec3<f32>(0.5, 0.5, 0.0)) <= vec3<f32>(0.5)) {
            break;
        }
    }
    return holder;
}

// `point` is relative to the block's first cell.
fn overlap_at(block: Block, around: vec4<u32>, point: vec3<f32>, random: ptr<function, Pcg>) -> Overlap {
    var weights = 0.0;
    var rho_sum = 0.0;
    var result = Overlap(0.0, 0u, 0.0, vec3<f32>());
    var start = block.entries_start;
    loop {
        let holder = next_holder(block, around, start, point);
        if holder.entry >= block.entries_end {
            break;
        }
        start = holder.entry + 1u;
        let yarn = load_yarn(holder.index);
        let rho = sample_density(yarn, holder.at.x, holder.at.y, layer_at(holder.at.z));
        let weight = yarn.density * rho.x;
        let first = weights == 0.0;
        weights += weight;
        rho_sum += rho.x;
        if weight > 0.0 && (first || pcg_next(random) * weights < weight) {
            result.index = holder.index;
            result.shade = rho.y / rho.x;
            result.at = holder.at;
        }
    }
    result.extinction = weights * min(1.0, MOST_OVERLAP / max(rho_sum, 1.0e-6));
    return result;
}

// No extinction where a ray may be in so many loops is above this.
fn majorant(count: u32) -> f32 {
    return min(scene.max_density * min(f32(count), MOST_OVERLAP), MAX_MAJORANT);
}

// A ray on its way from one tentative collision to the next.
struct Flight {
    walk: Walk,
    // Whether the walk's block has been opened.
    begun: bool,
    block: Block,
    segment: RaySegment,
    // Tentative collisions in a millimetre of this segment.
    rate: f32,
    // The way that is left of it.
    t: f32,
    t_to: f32,
}

fn take_off(ray: Ray) -> Flight {
    var flight: Flight;
    flight.walk = walk_begin(ray, scene.z_range, FAR);
    flight.t = flight.walk.t_enter;
    flight.t_to = flight.walk.t_enter;
    return flight;
}

// Moves on to the next tentative collision, through as many segments and blocks as it takes; false where the ray leaves
// the cloth. A loop of its own, so that neighbouring threads come together at the costly look into the loops.
fn fly(ray: Ray, flight: ptr<function, Flight>, random: ptr<function, Pcg>) -> bool {
    // 1 − random is in (0, 1], so the logarithm is finite.
    var depth = -log(1.0 - pcg_next(random));
    let limit = walk_limit();
    // Pointers to parts of a struct cannot be passed on in portable WGSL.
    var walk = (*flight).walk;
    // In a block every segment is farther on than the last.
    for (var n = 0u; n < limit && walk_goes_on(walk);) {
        let depth_here = (*flight).rate * ((*flight).t_to - (*flight).t);
        if depth < depth_here {
            (*flight).t += depth / (*flight).rate;
            return true;
        }
        depth -= depth_here;
        var t = (*flight).segment.next;
        if !(*flight).begun || !(t < walk.t_exit) {
            n++;
            if (*flight).begun {
                walk_step(ray, &walk);
                (*flight).walk = walk;
                if !walk_goes_on(walk) {
                    break;
                }
            }
            if COUNTERS {
                count_cells += 1u;
            }
            (*flight).begun = true;
            (*flight).block = open_block(ray, walk.place, walk.t_enter, walk.t_exit, MEET_VOLUME);
            (*flight).segment.ahead = ALL_ENTRIES;
            t = walk.t_enter;
        }
        let ahead = (*flight).segment.ahead;
        let segment = segment_from(ray, (*flight).block, ahead, t, t, walk.t_exit);
        (*flight).segment = segment;
        (*flight).rate = majorant(segment.count);
        (*flight).t = segment.begin;
        (*flight).t_to = max(segment.begin, min(segment.end, segment.next));
    }
    return false;
}

fn overlap_on(ray: Ray, flight: Flight, random: ptr<function, Pcg>) -> Overlap {
    let point = origin_in_cell(ray, flight.block.place << vec2<u32>(scene.block_shift)) + flight.t * ray.direction;
    return overlap_at(flight.block, flight.segment.around, point, random);
}

// The next collision of a ray, or the ground yarn it meets, or nothing.
fn track(ray: Ray, random: ptr<function, Pcg>) -> Scatter {
    var flight = take_off(ray);
    var hit = Gathered(0.0, 0.0, 0.0, vec3<f32>());
    var hit_index = 0u;
    for (var k = 0u; k < MAX_COLLISIONS && hit.depth <= 0.0; k++) {
        if !fly(ray, &flight, random) {
            break;
        }
        let overlap = overlap_on(ray, flight, random);
        if overlap.extinction > 0.0 && pcg_next(random) * flight.rate < overlap.extinction {
            hit = Gathered(1.0, flight.t, overlap.shade, overlap.at);
            hit_index = overlap.index;
        }
    }
    // Free paths in pile are short, so that seldom much of the skeleton lies before the collision.
    let t_hit = select(FAR, hit.t, hit.depth > 0.0);
    let ground = ground_along(ray, select(FAR, t_hit, HIDDEN_GROUND));
    if ground.t < t_hit {
        return ground_scatter(ray, ground);
    }
    if hit.depth > 0.0 {
        if COUNTERS {
            count_contributing_hits += 1u;
            let entry = ground_entry(ray);
            if HIDDEN_GROUND && entry < FAR && hit.t <= entry {
                count_hidden_rays += 1u;
            }
        }
        return pile_scatter(ray, hit, hit_index);
    }
    return no_scatter();
}

// Below this visibility a shadow ray goes on with ROULETTE_SURVIVAL only, and counts for more.
const ROULETTE_BELOW: f32 = 0.05;
const ROULETTE_SURVIVAL: f32 = 0.25;

// An unbiased estimate of the share of light that passes along a ray.
fn track_visibility(ray: Ray, random: ptr<function, Pcg>) -> f32 {
    if ground_along(ray, FAR).t < FAR {
        return 0.0;
    }
    var flight = take_off(ray);
    var visible = 1.0;
    for (var k = 0u; k < MAX_COLLISIONS && visible > 0.0; k++) {
        if !fly(ray, &flight, random) {
            break;
        }
        let overlap = overlap_on(ray, flight, random);
        if COUNTERS && overlap.extinction > 0.0 {
            count_contributing_hits += 1u;
        }
        visible *= max(1.0 - overlap.extinction / flight.rate, 0.0);
        if OPAQUE_RAYS && visible < ROULETTE_BELOW {
            visible = select(0.0, visible / ROULETTE_SURVIVAL, pcg_next(random) < ROULETTE_SURVIVAL);
            if COUNTERS && visible <= 0.0 {
                count_ended_rays += 1u;
            }
        }
    }
    return visible;
}
