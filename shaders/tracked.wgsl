// Method `tracked` (MODEL.md §9): delta tracking (Woodcock 1965) through the summed densities of overlapping loops,
// and ratio tracking (Novák et al. 2014) for shadow rays. Unbiased; each cell has its own majorant.

// Densities at a point, summed over the loops of a cell.
struct Overlap {
    // Σ density_k·ρ_k · min(1, 1.5/Σρ_k), 1/mm.
    extinction: f32,
    // One of the loops, drawn in proportion to density_k·ρ_k, and where the point is in it.
    index: u32,
    shade: f32,
    at: vec3<f32>,
}

// Where loops overlap yarns displace each other: the sum of ρ is held to this.
const CROWDED: f32 = 1.5;
// A mean free path below 1/256 mm cannot be told from a surface; denser yarn collides at once where it begins, and
// tracking through the empty parts beside it stays affordable.
const MAX_MAJORANT: f32 = 256.0;
// Collisions, real or null, within one cell. At MAX_MAJORANT this is a path of 64 mm through one cell.
const MAX_COLLISIONS: u32 = 16384u;

// `point` is relative to the cell.
fn overlap_at(cell_of_ray: Cell, point: vec3<f32>, random: ptr<function, Pcg>) -> Overlap {
    var weights = 0.0;
    var rho_sum = 0.0;
    var result = Overlap(0.0, 0u, 0.0, vec3<f32>());
    let height = (point.z - cell_of_ray.low) * 255.0 / max(cell_of_ray.high - cell_of_ray.low, 1.0e-20);
    var cell = cell_of_ray;
    cell.ray_low = height;
    cell.ray_high = height;
    for (var i = next_met(cell, cell.entries_start); i < cell.entries_end; i = next_met(cell, i + 1u)) {
        if COUNTERS {
            count_patch_tests += 1u;
        }
        let listed = open_entry(cell, i);
        let shape = load_patch(listed.index);
        let shift = vec2<f32>(listed.cell - cell.place) * scene.pitch;
        let at = invert_point(shape, patch_normal(shape), vec3<f32>(point.xy - shift, point.z));
        if any(abs(at - vec3<f32>(0.5, 0.5, 0.0)) > vec3<f32>(0.5)) {
            continue;
        }
        let yarn = load_yarn(listed.index);
        let rho = sample_density(yarn, at.x, at.y, layer_at(at.z));
        let weight = yarn.density * rho.x;
        if weight <= 0.0 {
            continue;
        }
        let first = weights == 0.0;
        weights += weight;
        rho_sum += rho.x;
        if first || pcg_next(random) * weights < weight {
            result.index = listed.index;
            result.shade = rho.y / rho.x;
            result.at = at;
        }
    }
    result.extinction = weights * min(1.0, CROWDED / max(rho_sum, 1.0e-6));
    return result;
}

// No extinction in the cell is above this; 0 where it lists nothing.
fn majorant(cell: Cell) -> f32 {
    let listed = cell.entries_end - cell.entries_start;
    let crowded = select(f32(listed), CROWDED, listed > 1u);
    return min(scene.max_density * crowded, MAX_MAJORANT);
}

// The part of a ray between two distances that is within the height range of a cell.
fn within_heights(ray: Ray, cell: Cell, t_from: f32, t_to: f32) -> vec2<f32> {
    let inverse = 1.0 / select(ray.direction.z, PARALLEL, abs(ray.direction.z) < PARALLEL);
    let a = (cell.low - ray.origin.z) * inverse;
    let b = (cell.high - ray.origin.z) * inverse;
    return vec2<f32>(max(t_from, min(a, b)), min(t_to, max(a, b)));
}

fn free_path(mean: f32, random: ptr<function, Pcg>) -> f32 {
    // 1 − random is in (0, 1], so the logarithm is finite.
    return -log(1.0 - pcg_next(random)) * mean;
}

// The next collision of a ray, or the ground yarn it meets, or nothing.
fn track(ray: Ray, random: ptr<function, Pcg>) -> Scatter {
    var walk = walk_begin(ray, scene.z_range, FAR);
    var hit = Gathered(0.0, 0.0, 0.0, vec3<f32>());
    var hit_index = 0u;
    let limit = walk_limit();
    for (var n = 0u; n < limit && walk_goes_on(walk); n++) {
        if COUNTERS {
            count_cells += 1u;
        }
        let origin = origin_in_cell(ray, walk.cell);
        let cell = open_cell(ray, walk.cell, walk.t_enter, walk.t_exit);
        let rate = majorant(cell);
        let range = within_heights(ray, cell, walk.t_enter, walk.t_exit);
        var t = range.x;
        for (var k = 0u; k < MAX_COLLISIONS && rate > 0.0; k++) {
            t += free_path(1.0 / rate, random);
            if t >= range.y {
                break;
            }
            let overlap = overlap_at(cell, origin + t * ray.direction, random);
            if overlap.extinction > 0.0 && pcg_next(random) * rate < overlap.extinction {
                hit = Gathered(1.0, t, overlap.shade, overlap.at);
                hit_index = overlap.index;
                break;
            }
        }
        if hit.alpha > 0.0 {
            break;
        }
        walk_step(ray, &walk);
    }
    // Free paths in pile are short, so that seldom much of the skeleton lies before the collision.
    let ground = ground_along(ray, select(FAR, hit.t, hit.alpha > 0.0));
    if ground.t < FAR {
        return ground_scatter(ray, ground);
    }
    if hit.alpha > 0.0 {
        if COUNTERS {
            count_contributing_hits += 1u;
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
    var walk = walk_begin(ray, scene.z_range, FAR);
    var visible = 1.0;
    let limit = walk_limit();
    for (var n = 0u; n < limit && walk_goes_on(walk); n++) {
        if COUNTERS {
            count_cells += 1u;
        }
        let origin = origin_in_cell(ray, walk.cell);
        let cell = open_cell(ray, walk.cell, walk.t_enter, walk.t_exit);
        let rate = majorant(cell);
        let range = within_heights(ray, cell, walk.t_enter, walk.t_exit);
        var t = range.x;
        for (var k = 0u; k < MAX_COLLISIONS && rate > 0.0; k++) {
            t += free_path(1.0 / rate, random);
            if t >= range.y {
                break;
            }
            let overlap = overlap_at(cell, origin + t * ray.direction, random);
            if COUNTERS && overlap.extinction > 0.0 {
                count_contributing_hits += 1u;
            }
            visible *= max(1.0 - overlap.extinction / rate, 0.0);
            if visible < ROULETTE_BELOW {
                if visible <= 0.0 || pcg_next(random) >= ROULETTE_SURVIVAL {
                    return 0.0;
                }
                visible /= ROULETTE_SURVIVAL;
            }
        }
        walk_step(ray, &walk);
    }
    return visible;
}
