// The nearest few events of a ray in one cell, sorted, in registers: an array would live in slow memory. What does not
// fit is found by scanning the cell again beyond the last event that was used.

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
// Scans of one cell; with NEAREST events each, more than loops of 64 layers crowded into a cell can make visible.
const MAX_SCANS: u32 = 256u;

fn no_event() -> Event {
    return Event(FAR, 0.0, 0.0, FAR, 0u, 0u);
}

fn no_events() -> Nearest {
    return Nearest(no_event(), no_event(), no_event(), no_event(), 0u);
}

fn offer(nearest: ptr<function, Nearest>, event: Event) {
    (*nearest).offered += 1u;
    if event.t < (*nearest).b.t {
        (*nearest).d = (*nearest).c;
        (*nearest).c = (*nearest).b;
        if event.t < (*nearest).a.t {
            (*nearest).b = (*nearest).a;
            (*nearest).a = event;
        } else {
            (*nearest).b = event;
        }
    } else if event.t < (*nearest).c.t {
        (*nearest).d = (*nearest).c;
        (*nearest).c = event;
    } else if event.t < (*nearest).d.t {
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
    // Share of the light that does not pass.
    alpha: f32,
    // Opacity-weighted mean distance.
    t: f32,
    // Opacity-weighted mean shade.
    shade: f32,
    // (u, v, w) at `t`.
    at: vec3<f32>,
}
