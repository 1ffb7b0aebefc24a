// Appended to the tracing program by the tests: values of lobes and directions drawn from them.

struct LobeProbe {
    // PILE or GROUND, index of the material; the rest unused.
    what: vec4<u32>,
    // w: how much of a surface it is.
    normal: vec4<f32>,
    axis: vec4<f32>,
    towards_eye: vec4<f32>,
    towards_light: vec4<f32>,
    // Two random numbers.
    numbers: vec4<f32>,
}

struct LobeAnswer {
    // Direction drawn; w: its weight.
    drawn: vec4<f32>,
    // Value towards the light.
    value: vec4<f32>,
}

@group(2) @binding(0) var<storage, read> lobe_probes: array<LobeProbe>;
@group(2) @binding(1) var<storage, read_write> lobe_answers: array<LobeAnswer>;

@compute @workgroup_size(WORKGROUP)
fn probe_lobes(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&lobe_probes) {
        return;
    }
    let probe = lobe_probes[id.x];
    var at = no_scatter();
    at.what = probe.what.x;
    at.material = probe.what.y;
    at.normal = probe.normal.xyz;
    at.surfaceness = probe.normal.w;
    at.axis = probe.axis.xyz;
    at.albedo = vec3<f32>(1.0, 0.5, 0.25);
    let value = scattered(at, probe.towards_eye.xyz, probe.towards_light.xyz);
    let drawn = draw_direction(at, probe.towards_eye.xyz, probe.numbers.xy);
    lobe_answers[id.x] = LobeAnswer(vec4<f32>(drawn.direction, drawn.weight.x), vec4<f32>(value, 0.0));
}
