// ENTRY baseline_main: the least that a sample can cost, for comparison: the ray of every pixel, and its sums read and
// written. Nothing is traced, and the sums are worth nothing.

@compute @workgroup_size(WORKGROUP)
fn baseline_main(@builtin(global_invocation_id) id: vec3<u32>) {
    let place = place_of(id);
    if !place.is_inside {
        return;
    }
    var colour = sums[place.first_sum + SUM_COLOUR];
    var signed = sums[place.first_sum + SUM_SIGNED];
    for (var sample = slice.first_sample; sample < slice.end_sample; sample++) {
        let film = sample_set(place.seed, sample, SET_FILM);
        let camera = film_ray(place, film.xy);
        colour += vec4<f32>(camera.ray.direction, camera.from_eye);
        signed += vec4<f32>(camera.ray.origin, film.z);
    }
    sums[place.first_sum + SUM_COLOUR] = colour;
    sums[place.first_sum + SUM_SIGNED] = signed;
}
