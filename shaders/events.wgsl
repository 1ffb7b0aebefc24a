// The nearest few events of a ray in one block, sorted, in registers: an array would live in slow memory. What does not
// fit is found by scanning the block again beyond the last event that was used.

// A crossing of a loop's patch that may take light away; its opacity is computed only when its turn comes.
struct Event {
    // Distance of the root; before the ray's start where a loop is already left behind in part. FAR: no event.
    t: f32,
    // Place of the root in the patch.
    u: f32,
    v: f32,
    // `single`: how far the event's part of the ray reaches towards the loop's other root, positive ahead, negative
    // behind; FAR where there is none.
    gap: f32,
    // Index of the loop.
    index: u32,
    // `layered`: which layer.
    layer: u32,
}

struct Nearest {
    a: Event,
    b: Event,
    c: Event,
    d: Event,
    // How many events were offered in all.
    offered: u32,
}
const NEAREST: u32 = 4u;
// Scans of one block; with NEAREST events each, more than loops of 64 layers crowded into a block can make visible.
const MAX_SCANS: u32 = 256u;

fn event_at_infinity(t: f32) -> Event {
    return Event(t, 0.0, 0.0, FAR, 0u, 0u);
}

// The order of events. Rounding makes some distances equal; then loop and layer decide, so that an event is neither
// lost nor found twice where a scan ends between two of the same distance.
fn comes_before(a: Event, b: Event) -> bool {
    if a.t != b.t {
        return a.t < b.t;
    }
    if a.index != b.index {
        return a.index < b.index;
    }
    return a.layer < b.layer;
}

fn no_events() -> Nearest {
    let none = event_at_infinity(FAR);
    return Nearest(none, none, none, none, 0u);
}

fn offer(nearest: ptr<function, Nearest>, event: Event) {
    (*nearest).offered += 1u;
    if comes_before(event, (*nearest).b) {
        (*nearest).d = (*nearest).c;
        (*nearest).c = (*nearest).b;
        if comes_before(event, (*nearest).a) {
            (*nearest).b = (*nearest).a;
            (*nearest).a = event;
        } else {
            (*nearest).b = event;
        }
    } else if comes_before(event, (*nearest).c) {
        (*nearest).d = (*nearest).c;
        (*nearest).c = event;
    } else if comes_before(event, (*nearest).d) {
        (*nearest).d = event;
    }
}

fn drop_first(nearest: ptr<function, Nearest>) {
    (*nearest).a = (*nearest).b;
    (*nearest).b = (*nearest).c;
    (*nearest).c = (*nearest).d;
    (*nearest).d.t = FAR;
}

// What an event takes away and where.
struct Gathered {
    // Optical depth; e^−depth of the light passes. Depths are summed, and no transmittance is made of opacities before
    // the end: 1 − opacity has few digits left where little light passes.
    depth: f32,
    // Opacity-weighted mean distance.
    t: f32,
    // Opacity-weighted mean shade.
    shade: f32,
    // (u, v, w) at `t`.
    at: vec3<f32>,
}

// 1 − e^−depth.
fn opacity_of(depth: f32) -> f32 {
    if depth < 0.1 {
        return depth * (1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth / 24.0)));
    }
    return 1.0 - exp(-depth);
}

// −ln x for x in (0, 1], to f32's last digits also next to 1, where log() may keep only absolute precision: with
// x = 2^e·m, m about 1, and s = (m − 1)/(m + 1), ln m = 2(s + s³/3 + s⁵/5 + …).
fn depth_of(x: f32) -> f32 {
    let parts = frexp(x);
    let low = parts.fract < 0.70710678;
    let m = select(parts.fract, 2.0 * parts.fract, low);
    let e = f32(parts.exp) - select(0.0, 1.0, low);
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let series = 2.0 * s * (1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 / 9.0))));
    return -(series + e * 0.69314718);
}
