// ENTRY trace_main: adds samples to pixels. One thread follows the paths of one pixel.
//
// The paper's §6 traces each ray in steps 3 to 6; they are named below. (Steps 1 and 2, the skeleton with its stitch
// pattern and the loop frames, are scene::compile's.) With more than one scattering the light that arrives at a point
// of the pile comes from other points as well: paths go on through the same medium by `tracked`.

// The share of light that reaches a scattering point from a direction of the world.
fn visibility(at: Scatter, towards_light: vec3<f32>, bounce: u32, random: ptr<function, Pcg>) -> f32 {
    if !SHADOWS {
        return 1.0;
    }
    if COUNTERS {
        count_shadow_rays += 1u;
    }
    var segments = ray_segments(ray_from(at.cell, at.point, towards_light), true);
    var visible = 1.0;
    for (var n = 0u; visible > 0.0 && goes_on(&segments, n); n++) {
        visible *= visibility_along(segments.segment, bounce, random);
        let composited = METHOD != METHOD_TRACKED && (!LONG_PATHS || bounce == 1u);
        if BENT && OPAQUE_RAYS && composited && visible < DARK {
            return 0.0;
        }
    }
    return visible;
}

// The same along a ray through the flat sheet.
fn visibility_along(ray: Ray, bounce: u32, random: ptr<function, Pcg>) -> f32 {
    if METHOD == METHOD_TRACKED {
        return track_visibility(ray, random);
    }
    if LONG_PATHS {
        if bounce > 1u {
            return track_visibility(ray, random);
        }
    }
    if METHOD == METHOD_EXACT {
        return exact_visibility(ray);
    }
    return composite_visibility(ray);
}

struct Path {
    radiance: vec3<f32>,
    // The first scattering.
    first: Scatter,
}

// Steps 3, 4 and 5: a ray through loops (3: where they reflect, 4: what they let through), skeleton and the loops of
// the other side (5). The ray picks one event of all that it meets, with its share of the light.
fn scatter_along(ray: Ray, bounce: u32, film: vec4<f32>, random: ptr<function, Pcg>) -> Scatter {
    if COUNTERS {
        count_rays += 1u;
    }
    var depth_left = depth_of(1.0 - film.z);
    var segments = ray_segments(ray, bounce > 1u);
    var at = no_scatter();
    for (var n = 0u; at.what == NOTHING && goes_on(&segments, n); n++) {
        at = placed(scatter_in(segments.segment, bounce, film, &depth_left, random), segments);
    }
    return at;
}

// The same along a ray through the flat sheet.
fn scatter_in(
    ray: Ray,
    bounce: u32,
    film: vec4<f32>,
    depth_left: ptr<function, f32>,
    random: ptr<function, Pcg>,
) -> Scatter {
    if METHOD != METHOD_TRACKED {
        if !LONG_PATHS || bounce == 1u {
            if METHOD == METHOD_EXACT {
                return exact_first(ray, depth_left, film.w);
            }
            return composite_first(ray, depth_left);
        }
    }
    return track(ray, random);
}

// The share of light that reaches a point from a direction of the world, as direct light needs it and as light that has
// scattered many times does: from an entry of the cache if that is known, else by a ray.
fn shadow(
    at: Scatter,
    towards_light: vec3<f32>,
    bounce: u32,
    cached: bool,
    entry: u32,
    // What would arrive with nothing in the way, directly and by multiple scattering.
    unhindered: vec2<f32>,
    random: ptr<function, Pcg>,
) -> vec2<f32> {
    if cached {
        let known = known_shadow(entry, random);
        if known.x >= 0.0 {
            if COUNTERS {
                count_cached_rays += 1u;
            }
            return known;
        }
    }
    let traced = visibility(at, towards_light, bounce, random);
    if cached {
        learn_shadow(entry, traced, unhindered);
    }
    return vec2<f32>(traced);
}

fn brightest(colour: vec3<f32>) -> f32 {
    return max(max(colour.x, colour.y), colour.z);
}

// Light that a point scatters towards the eye.
struct Lit {
    // After this scattering.
    light: vec3<f32>,
    // After further ones, as estimated.
    estimate: vec3<f32>,
}

// Step 6: what arrives at a point from the lights and is scattered towards the eye.
fn lit_at(
    at: Scatter,
    rotation: Rotation,
    towards_eye: vec3<f32>,
    bounce: u32,
    seed: u32,
    sample: u32,
    random: ptr<function, Pcg>,
) -> Lit {
    var lit = Lit();
    // `tracked`, and later scatterings, meet the environment where a path escapes, unless it is drawn.
    let is_cut_off = PATH_CUTOFF && bounce == slice.path_cutoff;
    let looks_last = LAST_LOOKS && METHOD == METHOD_TRACKED && bounce == slice.bounces;
    let composited = METHOD != METHOD_TRACKED && bounce == 1u;
    let sky = ENVIRONMENT && (SAMPLED_ENVIRONMENT || is_cut_off || looks_last || composited);
    let sources = SUN_COUNT + AREA_COUNT;
    let lights = sources + u32(sky);
    // Where later scatterings lie, less light comes than to what the camera sees beside them.
    var cached = CACHED_SHADOWS && bounce == 1u && sample < slice.cached_shadows;
    var entry = 0u;
    if cached {
        entry = shadow_entry(at, random);
        cached = entry != NO_ENTRY;
    }
    // The environment is the last light: one body for all, since everything here is inlined.
    for (var i = 0u; i < lights; i++) {
        let is_source = i < sources;
        let lamp_set = select(SET_FIRST_AREA + i - SUN_COUNT, i, i < SUN_COUNT);
        let u = sample_set(seed, sample, set_at(bounce, select(SET_ENVIRONMENT, lamp_set, is_source)));
        var counts = 1.0;
        if LATER_LIGHTS && LONG_PATHS {
            if bounce > 1u && !is_cut_off {
                if u.w >= LATER_LIGHTS_SHARE {
                    continue;
                }
                counts = 1.0 / LATER_LIGHTS_SHARE;
            }
        }
        var towards_light: vec3<f32>;
        // By the light itself, and by multiple scattering, from all sides.
        var share: vec3<f32>;
        var diffuse_share: vec3<f32>;
        // Directions by a sky's light see other shadows than those by the phase.
        let known = entry + i + u32(SAMPLED_ENVIRONMENT && !is_source && u.x >= PHASE_SHARE);
        if is_source {
            let light = from_lamp(i, at, u.xy);
            towards_light = sheet_from_world(rotation, light.direction);
            share = scattered(at, towards_eye, towards_light) * light.irradiance;
            diffuse_share = at.albedo * light.irradiance * (0.25 / PI);
        } else {
            let drawn = draw_sky(at, rotation, towards_eye, u.xyz);
            towards_light = drawn.direction;
            share = drawn.weight * environment_radiance(world_from_sheet(rotation, drawn.direction));
            diffuse_share = share;
        }
        if is_cut_off || brightest(share) > 0.0 {
            let direction = world_from_sheet(rotation, towards_light);
            let up = max(select(-1.0, 1.0, at.point.z >= 0.0) * towards_light.z, 0.0);
            let unhindered = vec2<f32>(brightest(share), up * brightest(diffuse_share)) / max(brightest(at.albedo), 1.0e-3);
            let visible = shadow(at, direction, bounce, cached, known, unhindered, random);
            lit.light += counts * share * visible.x;
            if is_cut_off {
                lit.estimate += diffuse_share * multiple_scattering(at, towards_light, visible.y);
            }
        }
    }
    return lit;
}

// `learns`: the path goes on where others are cut off, to teach how good the estimate is.
fn trace_path(camera_ray: Ray, film: vec4<f32>, seed: u32, sample: u32, learns: bool) -> Path {
    var random = pcg_new(seed, sample);
    var is_learning = false;
    var learning_at = 0u;
    var estimate = vec3<f32>();
    // The path's radiance up to where it would be cut off.
    var seen = vec3<f32>();
    var path = Path(scene.background.xyz, no_scatter());
    var throughput = vec3<f32>(1.0);
    var ray = camera_ray;
    for (var bounce = 1u; bounce <= slice.bounces + 1u; bounce++) {
        let at = scatter_along(ray, bounce, film, &random);
        if bounce == 1u {
            if at.what == NOTHING {
                break;
            }
            path = Path(vec3<f32>(), at);
        } else if at.what == NOTHING {
            // After the first scattering of `single` and `layered`, and of a path that learns, the environment has been
            // counted already.
            var is_counted = false;
            if BOUNCED_LIGHT {
                is_counted = bounce == slice.path_cutoff + 1u;
            }
            if !is_counted && SHADOWS && !SAMPLED_ENVIRONMENT && (METHOD == METHOD_TRACKED || bounce > 2u) {
                path.radiance += throughput * environment_radiance(ray.direction);
            }
            break;
        }
        if bounce > slice.bounces {
            break;
        }
        let rotation = rotation_at(at);
        let towards_eye = sheet_from_world(rotation, -ray.direction);
        let lit = lit_at(at, rotation, towards_eye, bounce, seed, sample, &random);
        path.radiance += throughput * lit.light;
        if PATH_CUTOFF {
            var further = lit.estimate;
            if BOUNCED_LIGHT {
                if bounce == slice.path_cutoff {
                    let entry = bounced_entry(at, &random);
                    further *= bounced_correction(entry);
                    is_learning = learns && is_learning_bounces(entry);
                    learning_at = entry;
                    estimate = lit.estimate;
                    seen = path.radiance + further;
                    further = vec3<f32>();
                    path.radiance = select(seen, vec3<f32>(), is_learning);
                }
            }
            path.radiance += throughput * further;
            if bounce == slice.path_cutoff && !is_learning {
                break;
            }
        }
        // The way on: to the environment if it escapes, else to the next scattering.
        if METHOD != METHOD_TRACKED && !LONG_PATHS {
            break;
        }
        let looks_last = LAST_LOOKS && METHOD == METHOD_TRACKED;
        if bounce == slice.bounces && (!ENVIRONMENT || SAMPLED_ENVIRONMENT || looks_last) {
            break;
        }
        let onward = sample_set(seed, sample, set_at(bounce, SET_ONWARD));
        let drawn = draw_direction(at, towards_eye, onward.xy);
        let onward_direction = world_from_sheet(rotation, drawn.direction);
        throughput *= drawn.weight;
        if !SHADOWS && !SAMPLED_ENVIRONMENT && (METHOD == METHOD_TRACKED || bounce > 1u) {
            // Nothing is between the point and the environment: no ray needs to find out.
            path.radiance += throughput * environment_radiance(onward_direction);
            if bounce == slice.bounces {
                break;
            }
        }
        if bounce >= ROULETTE_FROM {
            let survival = min(brightest(throughput), 1.0);
            if onward.z >= survival {
                break;
            }
            throughput /= survival;
        }
        ray = ray_from(at.cell, at.point, onward_direction);
    }
    if BOUNCED_LIGHT {
        if is_learning {
            learn_bounces(learning_at, path.radiance, estimate);
            path.radiance = seen;
        }
    }
    return path;
}

// The pixel that a thread works on.
struct Place {
    // False for threads beyond the tiles or the picture.
    is_inside: bool,
    // Its tile's place among those that are drawn.
    drawn_tile: u32,
    // In the whole picture.
    pixel: vec2<u32>,
    in_tile: vec2<u32>,
    seed: u32,
    first_sum: u32,
}

fn place_of(id: vec3<u32>) -> Place {
    let thread = id.x;
    // Of so many neighbours one works in each row of workgroups: all in the only one, but on software Vulkan.
    let has_turn = thread % u32(slice.background.w) == id.y;
    let drawn_tile = slice.first_tile + thread / slice.pixels_per_tile;
    let in_tile = pixel_of_rank(thread % slice.pixels_per_tile);
    let tile = u32(ray_tiles[min(drawn_tile, slice.end_tile - 1u)].cell.z);
    let in_picture = tile_corner(tile) + in_tile;
    return Place(
        has_turn && drawn_tile < slice.end_tile && all(in_picture < slice.size),
        drawn_tile,
        slice.corner + in_picture,
        in_tile,
        pixel_seed(slice.seed, slice.corner + in_picture),
        sum_index(tile, in_tile),
    );
}

fn film_ray(place: Place, film: vec2<f32>) -> CameraRay {
    // Tiles' reference points are their centres.
    return camera_ray(place.drawn_tile, vec2<f32>(place.in_tile) - 0.5 * f32(TILE), film);
}

@compute @workgroup_size(WORKGROUP)
fn trace_main(@builtin(global_invocation_id) id: vec3<u32>) {
    let place = place_of(id);
    if !place.is_inside {
        return;
    }
    // Sums are read and written once, whatever the number of samples.
    let first_sum = place.first_sum;
    var colour = sums[first_sum + SUM_COLOUR];
    var signed = sums[first_sum + SUM_SIGNED];
    var normal_depth = vec4<f32>();
    var albedo = vec4<f32>();
    if AOV {
        normal_depth = sums[first_sum + SUM_NORMAL];
        albedo = sums[first_sum + SUM_ALBEDO];
    }
    for (var sample = slice.first_sample; sample < slice.end_sample; sample++) {
        if LEVELS {
            if level_of(place.pixel.y, place.seed, sample) != slice.level {
                continue;
            }
        }
        let film = sample_set(place.seed, sample, SET_FILM);
        let camera = film_ray(place, film.xy);
        var learns = false;
        if BOUNCED_LIGHT {
            learns = learns_bounces(place.pixel, sample);
        }
        let path = trace_path(camera.ray, film, place.seed, sample, learns);
        let met = path.first.what != NOTHING;
        colour += vec4<f32>(path.radiance, f32(met));
        let signed_sum = dot(path.radiance, channel_signs(place.in_tile));
        let scramble = vec4<u32>(scramble_of(sample)) == vec4<u32>(0u, 1u, 2u, 3u);
        signed += select(vec4<f32>(), vec4<f32>(signed_sum), scramble);
        if AOV && met {
            let normal = world_from_sheet(rotation_at(path.first), path.first.normal);
            let facing = select(-1.0, 1.0, dot(normal, camera.ray.direction) <= 0.0) * normal;
            normal_depth += vec4<f32>(facing, (camera.from_eye + path.first.t) * scene.reference_size.w);
            albedo += vec4<f32>(path.first.albedo, 1.0);
        }
    }
    sums[first_sum + SUM_COLOUR] = colour;
    sums[first_sum + SUM_SIGNED] = signed;
    if AOV {
        sums[first_sum + SUM_NORMAL] = normal_depth;
        sums[first_sum + SUM_ALBEDO] = albedo;
    }
    if COUNTERS {
        add_total(COUNT_RAYS, count_rays);
        add_total(COUNT_SHADOW_RAYS, count_shadow_rays);
        add_total(COUNT_CELLS, count_cells);
        add_total(COUNT_PATCH_TESTS, count_patch_tests);
        add_total(COUNT_VOLUME_SAMPLES, count_volume_samples);
        add_total(COUNT_CONTRIBUTING_HITS, count_contributing_hits);
        add_total(COUNT_ENDED_RAYS, count_ended_rays);
        add_total(COUNT_HIDDEN_RAYS, count_hidden_rays);
        add_total(COUNT_CACHED_RAYS, count_cached_rays);
    }
}
