// `single` and `layered` along a ray: the events of all loops, composited front to back, block by block.

// An event counts only in the block that holds it, so none is found twice.
fn event_is_in(ray: Ray, t: f32, t_from: f32, t_to: f32) -> bool {
    let ahead = max(t, ray.t_start);
    return ahead >= t_from && ahead < t_to;
}

fn gathered(event: Event, shape: Patch, normal: vec3<f32>, yarn: Yarn, ray: Ray) -> Gathered {
    var result: Gathered;
    if METHOD == METHOD_LAYERED {
        result = layered_gathered(event, shape, normal, yarn, ray);
    } else {
        result = single_gathered(event, shape, normal, yarn, ray);
    }
    if COUNTERS && result.depth > 0.0 {
        count_contributing_hits += 1u;
    }
    return result;
}

// How many solves a loop needs.
fn solves() -> u32 {
    if METHOD == METHOD_LAYERED {
        return LAYERS;
    }
    return 1u;
}

// Roots of one solve of a loop.
fn solve(shape: Patch, origin: vec3<f32>, direction: vec3<f32>, layer: u32) -> Roots {
    if COUNTERS {
        count_patch_tests += 1u;
    }
    if METHOD == METHOD_LAYERED {
        let shift = layer_middle(layer) * scene.thickness;
        return patch_roots(shape, origin - shift * patch_normal(shape), direction);
    }
    return patch_roots(shape, origin, direction);
}

fn first_event(roots: Roots, index: u32, layer: u32) -> Event {
    let gap = select(FAR, 0.5 * (roots.second.z - roots.first.z), roots.count == 2u);
    return Event(roots.first.z, roots.first.x, roots.first.y, gap, index, layer);
}

fn second_event(roots: Roots, index: u32, layer: u32) -> Event {
    // A hair below zero where both roots coincide: the sign says which side is whose.
    let gap = min(-0.5 * (roots.second.z - roots.first.z), -1.0e-20);
    return Event(roots.second.z, roots.second.x, roots.second.y, gap, index, layer);
}

// The nearest events of a block from `t_from` to `t_to` that come after another.
fn nearest_events(ray: Ray, block: Block, t_from: f32, t_to: f32, after: Event) -> Nearest {
    var nearest = no_events();
    for (var i = next_met(block, block.entries_start); i < block.entries_end; i = next_met(block, i + 1u)) {
        let listed = open_entry(block, i);
        let shape = load_patch(listed.index);
        let origin = origin_in_cell(ray, listed.cell);
        for (var layer = 0u; layer < solves(); layer++) {
            let roots = solve(shape, origin, ray.direction, layer);
            let first = first_event(roots, listed.index, layer);
            if roots.count > 0u && comes_before(after, first) && event_is_in(ray, first.t, t_from, t_to) {
                offer(&nearest, first);
            }
            let second = second_event(roots, listed.index, layer);
            if roots.count > 1u && comes_before(after, second) && event_is_in(ray, second.t, t_from, t_to) {
                offer(&nearest, second);
            }
        }
    }
    return nearest;
}

fn pile_scatter(ray: Ray, hit: Gathered, index: u32) -> Scatter {
    let shape = load_patch(index);
    let normal = patch_normal(shape);
    let yarn = load_yarn(index);
    let point = ray.origin + hit.t * ray.direction;
    var at = Scatter(PILE, ray.cell, point, hit.t, normal, vec3<f32>(), 0.0, yarn.albedo * hit.shade, yarn.material);
    let phase = phase_of(yarn.material);
    if phase == PHASE_KAJIYA_KAY {
        at.axis = fibre_tangent(shape, normal, yarn, hit.at);
    }
    if phase == PHASE_GRADIENT_LAMBERT {
        let surface = density_surface(shape, normal, yarn, hit.at);
        at.axis = surface.xyz;
        at.surfaceness = surface.w;
    }
    return at;
}

// The first event at which the optical depth exceeds `depth_left`, which is lowered by what the ray meets: an event is
// chosen with probability T·α, so its weight is 1 and the walk ends there.
fn composite_first(ray: Ray, depth_left: ptr<function, f32>) -> Scatter {
    // Step 5: the skeleton is opaque; loops of the far side are met in blocks behind its gaps. It is looked for once
    // the ray is about to reach it: most are taken by pile above it.
    let ground_from = ground_search_start(ray);
    var ground = no_yarn();
    var ground_known = ground_from >= FAR;
    var walk = walk_begin(ray, scene.z_range, FAR);
    let depth_to = *depth_left;
    var depth = 0.0;
    var chosen: Gathered;
    var chosen_index = 0u;
    let limit = walk_limit();
    // One step more than there are blocks, for the ground of rays that leave the loops before they reach it.
    for (var n = 0u; n <= limit; n++) {
        if !ground_known && (!walk_goes_on(walk) || walk.t_exit > ground_from) {
            ground = ground_along(ray, FAR);
            ground_known = true;
            walk_cut(&walk, ground.t);
        }
        if !walk_goes_on(walk) {
            break;
        }
        if COUNTERS {
            count_cells += 1u;
        }
        let block = open_block(ray, walk.place, walk.t_enter, walk.t_exit, met_part());
        var after = event_at_infinity(-FAR);
        var scans = select(0u, MAX_SCANS, block.entries_start < block.entries_end);
        for (; scans > 0u; scans--) {
            var nearest = nearest_events(ray, block, walk.t_enter, walk.t_exit, after);
            for (var i = 0u; i < NEAREST && nearest.a.t < FAR && depth <= depth_to; i++) {
                let shape = load_patch(nearest.a.index);
                chosen = gathered(nearest.a, shape, patch_normal(shape), load_yarn(nearest.a.index), ray);
                chosen_index = nearest.a.index;
                depth += chosen.depth;
                after = nearest.a;
                drop_first(&nearest);
            }
            if nearest.offered <= NEAREST || depth > depth_to {
                break;
            }
        }
        if depth > depth_to {
            break;
        }
        walk_step(ray, &walk);
    }
    *depth_left = depth_to - depth;
    if depth > depth_to {
        if COUNTERS && !ground_known {
            count_hidden_rays += 1u;
        }
        return pile_scatter(ray, chosen, chosen_index);
    }
    if ground.t < FAR {
        return ground_scatter(ray, ground);
    }
    return no_scatter();
}

// Ends a walk at a distance, as if it had been begun so.
fn walk_cut(walk: ptr<function, Walk>, t_to: f32) {
    (*walk).t_end = min((*walk).t_end, t_to);
    (*walk).t_exit = max((*walk).t_enter, min((*walk).t_exit, (*walk).t_end));
}

// A search for crossings along a ray, in whatever order they come within a block.
struct Search {
    walk: Walk,
    block: Block,
    // The next solve to make.
    entry: u32,
    layer: u32,
}

// A loop met by a ray: the roots of one solve.
struct Crossing {
    // False where the ray has left the cloth.
    found: bool,
    index: u32,
    layer: u32,
    roots: Roots,
    shape: Patch,
}

fn enter(ray: Ray, walk: Walk) -> Search {
    if COUNTERS {
        count_cells += 1u;
    }
    let block = open_block(ray, walk.place, walk.t_enter, walk.t_exit, met_part());
    return Search(walk, block, next_met(block, block.entries_start), 0u);
}

// Goes on to the next solve that has a root in its block's part of the ray. A loop of its own over blocks, entries and
// layers, so that neighbouring threads come together at the costly look into the volume.
fn next_crossing(ray: Ray, search: ptr<function, Search>) -> Crossing {
    var crossing: Crossing;
    let limit = walk_limit();
    for (var n = 0u; n < limit && !crossing.found && walk_goes_on((*search).walk);) {
        if (*search).entry < (*search).block.entries_end {
            let listed = open_entry((*search).block, (*search).entry);
            crossing.index = listed.index;
            crossing.layer = (*search).layer;
            crossing.shape = load_patch(listed.index);
            crossing.roots = solve(crossing.shape, origin_in_cell(ray, listed.cell), ray.direction, crossing.layer);
            let t_from = (*search).walk.t_enter;
            let t_to = (*search).walk.t_exit;
            let first_in = event_is_in(ray, crossing.roots.first.z, t_from, t_to);
            let second_in = event_is_in(ray, crossing.roots.second.z, t_from, t_to);
            crossing.found = crossing.roots.count > 0u && (first_in || second_in);
            (*search).layer += 1u;
            if (*search).layer >= solves() {
                (*search).layer = 0u;
                (*search).entry = next_met((*search).block, (*search).entry + 1u);
            }
        } else {
            n++;
            var walk = (*search).walk;
            walk_step(ray, &walk);
            (*search).walk = walk;
            if walk_goes_on(walk) {
                *search = enter(ray, walk);
            }
        }
    }
    return crossing;
}

// V: the share of light that passes all loops and the skeleton along a ray.
fn composite_visibility(ray: Ray) -> f32 {
    if ground_along(ray, FAR).t < FAR {
        return 0.0;
    }
    let blocked = -log(DARK);
    var depth = 0.0;
    var search: Search;
    search.walk = walk_begin(ray, scene.z_range, FAR);
    if walk_goes_on(search.walk) {
        search = enter(ray, search.walk);
    }
    loop {
        let crossing = next_crossing(ray, &search);
        if !crossing.found {
            break;
        }
        let walk = search.walk;
        // One body for both roots, since everything here is inlined.
        for (var k = 0u; k < crossing.roots.count; k++) {
            var event = first_event(crossing.roots, crossing.index, crossing.layer);
            if k == 1u {
                event = second_event(crossing.roots, crossing.index, crossing.layer);
            }
            if event_is_in(ray, event.t, walk.t_enter, walk.t_exit) {
                let normal = patch_normal(crossing.shape);
                depth += gathered(event, crossing.shape, normal, load_yarn(crossing.index), ray).depth;
            }
        }
        if OPAQUE_RAYS && depth > blocked {
            if COUNTERS {
                count_ended_rays += 1u;
            }
            return 0.0;
        }
    }
    return exp(-depth);
}
