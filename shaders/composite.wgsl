// `single` and `layered` along a ray: the events of all loops, composited front to back, cell by cell.

// An event counts only in the cell that holds it, so none is found twice.
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
    if COUNTERS && result.alpha > 0.0 {
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
fn solve(shape: Patch, normal: vec3<f32>, origin: vec3<f32>, direction: vec3<f32>, layer: u32) -> Roots {
    if COUNTERS {
        count_patch_tests += 1u;
    }
    if METHOD == METHOD_LAYERED {
        return patch_roots(shape, origin - layer_middle(layer) * scene.thickness * normal, direction);
    }
    return patch_roots(shape, origin, direction);
}

fn first_event(roots: Roots, index: u32, layer: u32) -> Event {
    let gap = select(FAR, 0.5 * (roots.second.z - roots.first.z), roots.count == 2u);
    return Event(roots.first.z, roots.first.x, roots.first.y, gap, index, layer);
}

fn second_event(roots: Roots, index: u32, layer: u32) -> Event {
    // A hair below zero where both roots coincide: the sign tells which side is whose.
    let gap = min(-0.5 * (roots.second.z - roots.first.z), -1.0e-20);
    return Event(roots.second.z, roots.second.x, roots.second.y, gap, index, layer);
}

// The nearest events of a cell from `t_from` to `t_to` that lie beyond `after`.
fn nearest_events(ray: Ray, place: vec2<i32>, cell: Cell, t_from: f32, t_to: f32, after: f32) -> Nearest {
    var nearest = no_events();
    for (var i = cell.entries_start; i < cell.entries_end; i++) {
        let entry = open_entry(cell, i);
        if !entry.met {
            continue;
        }
        let index = loop_index(entry, place);
        let shape = load_patch(index);
        let normal = patch_normal(shape);
        let origin = origin_in_cell(ray, place + entry.offset);
        for (var layer = 0u; layer < solves(); layer++) {
            let roots = solve(shape, normal, origin, ray.direction, layer);
            if roots.count > 0u && roots.first.z > after && event_is_in(ray, roots.first.z, t_from, t_to) {
                offer(&nearest, first_event(roots, index, layer));
            }
            if roots.count > 1u && roots.second.z > after && event_is_in(ray, roots.second.z, t_from, t_to) {
                offer(&nearest, second_event(roots, index, layer));
            }
        }
    }
    return nearest;
}

fn pile_scatter(ray: Ray, hit: Gathered, shape: Patch, normal: vec3<f32>, yarn: Yarn) -> Scatter {
    var tangent = vec3<f32>();
    if PHASE == PHASE_KAJIYA_KAY {
        tangent = fibre_tangent(shape, normal, yarn, hit.at);
    }
    return Scatter(PILE, ray.cell, ray.origin + hit.t * ray.direction, hit.t, normal, tangent, yarn.albedo * hit.shade);
}

// The first event at which the transmittance falls below `threshold` in (0, 1]: an event is chosen with probability
// T·α, so its weight is 1 and the walk ends there. Steps 3 to 5 of the paper's §6 for one ray.
fn composite_first(ray: Ray, threshold: f32) -> Scatter {
    var walk = walk_begin(ray);
    var transmittance = 1.0;
    let limit = walk_limit();
    for (var n = 0u; n < limit && walk_goes_on(walk); n++) {
        if COUNTERS {
            count_cells += 1u;
        }
        let ground = skeleton_hit(walk.cell, origin_in_cell(ray, walk.cell), ray.direction, walk.t_enter, walk.t_exit);
        let t_to = min(walk.t_exit, ground.t);
        let cell = open_cell(ray, walk.cell, walk.t_enter, t_to);
        var after = -FAR;
        for (var scan = 0u; scan < MAX_SCANS && cell.entries_start < cell.entries_end; scan++) {
            var nearest = nearest_events(ray, walk.cell, cell, walk.t_enter, t_to, after);
            for (var i = 0u; i < NEAREST && nearest.a.t < FAR; i++) {
                let shape = load_patch(nearest.a.index);
                let normal = patch_normal(shape);
                let yarn = load_yarn(nearest.a.index);
                let hit = gathered(nearest.a, shape, normal, yarn, ray);
                transmittance *= 1.0 - hit.alpha;
                if transmittance < threshold {
                    return pile_scatter(ray, hit, shape, normal, yarn);
                }
                after = nearest.a.t;
                drop_first(&nearest);
            }
            if nearest.offered <= NEAREST {
                break;
            }
        }
        if ground.t < FAR {
            return ground_scatter(ray, walk.cell, ground);
        }
        walk_step(ray, &walk);
    }
    return no_scatter();
}

// Below this a shadow ray counts as blocked.
const BLOCKED: f32 = 1.0e-4;

// V: the share of light that passes all loops and the skeleton along a ray.
fn composite_visibility(ray: Ray) -> f32 {
    var walk = walk_begin(ray);
    var visible = 1.0;
    let limit = walk_limit();
    for (var n = 0u; n < limit && walk_goes_on(walk); n++) {
        if COUNTERS {
            count_cells += 1u;
        }
        let ground = skeleton_hit(walk.cell, origin_in_cell(ray, walk.cell), ray.direction, walk.t_enter, walk.t_exit);
        if ground.t < FAR {
            return 0.0;
        }
        let cell = open_cell(ray, walk.cell, walk.t_enter, walk.t_exit);
        for (var i = cell.entries_start; i < cell.entries_end; i++) {
            let entry = open_entry(cell, i);
            if !entry.met {
                continue;
            }
            let index = loop_index(entry, walk.cell);
            let shape = load_patch(index);
            let normal = patch_normal(shape);
            let origin = origin_in_cell(ray, walk.cell + entry.offset);
            for (var layer = 0u; layer < solves(); layer++) {
                let roots = solve(shape, normal, origin, ray.direction, layer);
                // One call for both roots keeps the loop over layers in the program once.
                for (var k = 0u; k < roots.count; k++) {
                    var event = first_event(roots, index, layer);
                    if k == 1u {
                        event = second_event(roots, index, layer);
                    }
                    if event_is_in(ray, event.t, walk.t_enter, walk.t_exit) {
                        let hit = gathered(event, shape, normal, load_yarn(index), ray);
                        visible *= 1.0 - hit.alpha;
                    }
                }
                if visible < BLOCKED {
                    return 0.0;
                }
            }
        }
        walk_step(ray, &walk);
    }
    return visible;
}
