// What a block of the grid lists, and which of it a ray may meet: the f32 twin of reference/walk.rs and scene/loops.rs,
// where the records are described.
//
// Of the ray's part in a block two things are kept: which of the block's subcells it passes, as bits in the place in
// which entries have theirs, and between which heights it is, in the steps of entries of either face.

struct Block {
    place: vec2<i32>,
    entries_start: u32,
    entries_end: u32,
    // Lowest and highest point of loops in the block, mm.
    low: f32,
    high: f32,
    // Bits of the subcells that the ray passes.
    passed: u32,
    // The ray's lowest and highest point, in steps of the front's entries and of the back's.
    front: vec2<f32>,
    back: vec2<f32>,
    // Of a ray that starts in the block, for patches alone: the bit of its first quadrant, and its start's height in
    // steps of the front's entries and of the back's. A loop that holds the start is met even where its patch lies
    // behind.
    start: u32,
    start_steps: vec2<f32>,
}

// What of a loop a ray may meet: all of its volume, or, which is all that `single` asks for, its patch.
const MEET_VOLUME: u32 = 2u;
const MEET_PATCH: u32 = 3u;

// What the first segment of a path and its shadow rays may meet.
fn met_part() -> u32 {
    return select(MEET_VOLUME, MEET_PATCH, METHOD == METHOD_SINGLE);
}

// How far beside its place a subcell still counts as passed, in subcells: far more than rounding.
const SUBCELL_SLACK: f32 = 1.0e-3;

fn header_index(block: vec2<i32>) -> u32 {
    let place = vec2<u32>(block + scene.margin);
    return place.y * u32(scene.blocks.x) + place.x;
}

// A point's place in a block, given relative to the middle of the block's first cell, from 0 to n.
fn place_in_block(from_cell: vec2<f32>, n: f32) -> vec2<f32> {
    return (from_cell + 0.5 * scene.pitch) * n / (scene.pitch * f32(1u << scene.block_shift));
}

// Bits of the subcells, n along each side, of a block that a line passes between two distances; `origin` and
// `direction` in subcells. Row by row: which columns it passes between the row's two edges.
fn subcells_passed(origin: vec2<f32>, direction: vec2<f32>, t_from: f32, t_to: f32, n: u32) -> u32 {
    let slope = select(direction.y, PARALLEL, abs(direction.y) < PARALLEL);
    let inverse = 1.0 / slope;
    var bits = 0u;
    for (var row = 0u; row < n; row++) {
        let a = (f32(row) - SUBCELL_SLACK - origin.y) * inverse;
        let b = (f32(row) + 1.0 + SUBCELL_SLACK - origin.y) * inverse;
        let enter = max(t_from, min(a, b));
        let leave = min(t_to, max(a, b));
        if enter <= leave {
            let p = origin.x + enter * direction.x;
            let q = origin.x + leave * direction.x;
            let last = f32(n) - 1.0;
            let first_column = u32(clamp(floor(min(p, q) - SUBCELL_SLACK), 0.0, last));
            let last_column = u32(clamp(floor(max(p, q) + SUBCELL_SLACK), 0.0, last));
            bits |= ((2u << last_column) - (1u << first_column)) << (n * row);
        }
    }
    return bits;
}

// How many steps of entries a height is above the lowest of a range; of a flat range, which has no steps, `flat`.
fn steps_of(z: f32, low: f32, high: f32, flat: f32) -> f32 {
    let steps = f32(1u << scene.height_bits);
    return select((z - low) * steps / max(high - low, 1.0e-20), flat, high <= low);
}

// The block's list, empty where the part of the ray from `t_from` to `t_to` misses the block's heights.
fn open_block(ray: Ray, place: vec2<i32>, t_from: f32, t_to: f32, part: u32) -> Block {
    let index = header_index(place);
    let header = block_headers[index];
    let range = bitcast<i32>(header.w);
    let low = f32(extractBits(range, 0u, 16u)) * scene.height_unit;
    let high = f32(extractBits(range, 16u, 16u)) * scene.height_unit;
    let front_low = max(low, -scene.penetration_depth);
    let back_high = min(high, scene.penetration_depth);
    let z_from = ray.origin.z + t_from * ray.direction.z;
    let z_to = ray.origin.z + t_to * ray.direction.z;
    let lowest = min(z_from, z_to);
    let highest = max(z_from, z_to);
    let missed = low > high || lowest > high || highest < low;
    let all_steps = f32(1u << scene.height_bits);

    let origin = origin_in_cell(ray, place << vec2<u32>(scene.block_shift)).xy;
    let subcells = f32(part);
    let in_block = place_in_block(origin, subcells);
    let direction = ray.direction.xy * subcells / (scene.pitch * f32(1u << scene.block_shift));
    let passed = subcells_passed(in_block, direction, t_from, t_to, part);
    var start = 0u;
    var start_steps = vec2<f32>();
    if part == MEET_PATCH && t_from <= ray.t_start {
        let quadrant = vec2<u32>(place_in_block(origin + t_from * ray.direction.xy, 2.0) >= vec2<f32>(1.0));
        start = 1u << (scene.masks_shift + quadrant.x + 2u * quadrant.y);
        start_steps = vec2<f32>(steps_of(z_from, front_low, high, 0.0), steps_of(z_from, low, back_high, 0.0));
    }
    return Block(
        place,
        header.x,
        select(block_headers[index + 1u].x, header.x, missed),
        low,
        high,
        passed << (scene.masks_shift + select(0u, 4u, part == MEET_PATCH)),
        vec2<f32>(steps_of(lowest, front_low, high, 0.0), steps_of(highest, front_low, high, all_steps)),
        vec2<f32>(steps_of(lowest, low, back_high, 0.0), steps_of(highest, low, back_high, all_steps)),
        start,
        start_steps,
    );
}

// Whether the ray's part in the block may meet the loop of an entry.
fn meets(block: Block, bits: u32) -> bool {
    let heights = bits >> scene.heights_shift;
    let lowest = f32(extractBits(heights, 0u, scene.height_bits));
    let highest = f32(extractBits(heights, scene.height_bits, scene.height_bits)) + 1.0;
    let is_back = extractBits(bits, scene.place_shift, 1u) != 0u;
    let steps = select(block.front, block.back, is_back);
    let start = select(block.start_steps.x, block.start_steps.y, is_back);
    let passed = (bits & block.passed) != 0u && lowest <= steps.y && highest >= steps.x;
    return passed || ((bits & block.start) != 0u && lowest <= start && highest >= start);
}

// The first entry from `start` on that the ray's part in the block may meet; the end of the list if none. A loop of its
// own, so that neighbouring threads that skip different entries come together at the costly test.
fn next_met(block: Block, start: u32) -> u32 {
    var index = start;
    for (; index < block.entries_end; index++) {
        if meets(block, block_entries[index]) {
            break;
        }
    }
    return index;
}

// A loop that a block lists.
struct Listed {
    index: u32,
    // Its own cell.
    cell: vec2<i32>,
}

fn open_entry(block: Block, index: u32) -> Listed {
    let bits = block_entries[index];
    let word = bitcast<i32>(bits);
    let offset_bits = scene.place_shift >> 1u;
    let offset = vec2<i32>(extractBits(word, 0u, offset_bits), extractBits(word, offset_bits, offset_bits));
    let shift = scene.block_shift;
    let bit = extractBits(bits, scene.place_shift, 2u * shift + 1u);
    let home = block.place + offset;
    let header = block_headers[header_index(home)];
    let cell_in_block = vec2<u32>(extractBits(bit, 1u, shift), bit >> (1u + shift));
    return Listed(
        header.y + countOneBits(header.z & ((1u << bit) - 1u)),
        (home << vec2<u32>(shift)) + vec2<i32>(cell_in_block),
    );
}
