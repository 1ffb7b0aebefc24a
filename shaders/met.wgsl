// Which loops of a block's list are around a ray, and from where to where: kept as bits of a mask, since arrays would
// live in slow memory.

// Which entries of a block's list: bit k stands for entry k, and in longer lists also for k + 128, k + 256 and so on.
const MASKED: u32 = 128u;
const ALL_ENTRIES: vec4<u32> = vec4<u32>(0xffffffffu);

fn with_bit(mask: vec4<u32>, entry: u32) -> vec4<u32> {
    let word = (entry % MASKED) / 32u;
    return mask | select(vec4<u32>(), vec4<u32>(1u << (entry % 32u)), vec4<u32>(word) == vec4<u32>(0u, 1u, 2u, 3u));
}

// The lowest bit that is set, or MASKED.
fn lowest_bit(mask: vec4<u32>) -> u32 {
    let places = firstTrailingBit(mask) + vec4<u32>(0u, 32u, 64u, 96u);
    let bits = select(places, vec4<u32>(MASKED), mask == vec4<u32>());
    return min(min(bits.x, bits.y), min(bits.z, bits.w));
}

// The first entry from `start` on whose bit is set, or `end`. Without a loop or a vector indexed by a variable.
fn next_bit(mask: vec4<u32>, start: u32, end: u32) -> u32 {
    let first = start % MASKED;
    let passed = max(vec4<u32>(first), vec4<u32>(0u, 32u, 64u, 96u)) - vec4<u32>(0u, 32u, 64u, 96u);
    let kept = select(ALL_ENTRIES << min(passed, vec4<u32>(31u)), vec4<u32>(), passed >= vec4<u32>(32u));
    let here = lowest_bit(mask & kept);
    let again = lowest_bit(mask);
    let ahead = start - first + select(here, MASKED + again, here == MASKED);
    return select(min(ahead, end), end, again == MASKED);
}

// The first entry from `start` on that the ray's part in the block may meet, of those of a mask; the end of the list if
// none. A loop of its own, like next_met.
fn next_of(block: Block, mask: vec4<u32>, start: u32) -> u32 {
    let count = block.entries_end - block.entries_start;
    var entry = start;
    for (; entry < block.entries_end; entry++) {
        entry = block.entries_start + next_bit(mask, entry - block.entries_start, count);
        if entry >= block.entries_end || meets(block, block_entries[entry]) {
            break;
        }
    }
    return entry;
}

// A distance that no ray needs to go from a loop's middle to cross it, mm.
const NEVER: f32 = 1.0e6;

// Between which distances c.x + c.y·t + c.z·t², c.z ≥ 0, is below 0; the first is FAR where it never is.
fn below_zero(c: vec3<f32>) -> vec2<f32> {
    let discriminant = c.y * c.y - 4.0 * c.x * c.z;
    if discriminant <= 0.0 {
        return select(vec2<f32>(FAR, -FAR), vec2<f32>(-FAR, FAR), c.x < 0.0);
    }
    let falls = c.y < 0.0;
    let q = -0.5 * (c.y + select(1.0, -1.0, falls) * sqrt(discriminant));
    // The division is made only where its result is somewhere near: none is by zero.
    var root = select(-FAR, FAR, falls);
    if abs(q) < NEVER * c.z {
        root = q / c.z;
    }
    return select(vec2<f32>(root, c.x / q), vec2<f32>(c.x / q, root), falls);
}

// Outside of these distances a line is certainly not in the loop: between its side faces and, with w·h = z −
// (A·n̂)u′v′, where that may be within ±h/2. u′v′ is pq but for (1 + αv′)(1 + βu′), and at most ¼.
fn part_in_loop(line: LoopLine) -> vec2<f32> {
    let sides = between_sides(line) - line.t_near;
    let half_skew = 0.5 * abs(vec2<f32>(line.alpha, line.beta));
    let differ = half_skew.x + half_skew.y + half_skew.x * half_skew.y;
    let most = 0.5 * WIDENED * scene.thickness + 0.25 * abs(line.lift) * differ;
    let p = vec2<f32>(line.value.x, line.slope.x);
    let q = vec2<f32>(line.value.y, line.slope.y);
    let bent = vec3<f32>(line.value.z, line.slope.z, 0.0)
        - line.lift * vec3<f32>(p.x * q.x, p.x * q.y + p.y * q.x, p.y * q.y);
    // Turned so that it opens upwards: it is below `most` between two distances, and below −`most` between two others.
    let up = select(bent, -bent, bent.z < 0.0);
    let inner = below_zero(up - vec3<f32>(most, 0.0, 0.0));
    let beyond = below_zero(up + vec3<f32>(most, 0.0, 0.0));
    var part = vec2<f32>(max(sides.x, inner.x), min(sides.y, inner.y));
    part.x = select(part.x, beyond.y, beyond.x < part.x && part.x < beyond.y);
    part.y = select(part.y, beyond.x, beyond.x < part.y && part.y < beyond.y);
    return part + line.t_near;
}

// A part of a ray's way through a block.
struct RaySegment {
    // The loops that the ray may be in somewhere in it, and how many.
    around: vec4<u32>,
    count: u32,
    // These, and those that it may be in farther on.
    ahead: vec4<u32>,
    // Where the first of those around begins, and the last ends.
    begin: f32,
    end: f32,
    // Where the next loop begins that is not among those around; else where the ray leaves the block.
    next: f32,
}

// What is around a ray from `t` to `t_look` and on to where the next loop begins, of the loops `ahead`; the ray leaves
// the block at `t_to`.
fn segment_from(ray: Ray, block: Block, ahead: vec4<u32>, t: f32, t_look: f32, t_to: f32) -> RaySegment {
    var segment = RaySegment(vec4<u32>(), 0u, vec4<u32>(), t_to, t, t_to);
    for (var i = next_of(block, ahead, block.entries_start); i < block.entries_end; i = next_of(block, ahead, i + 1u)) {
        if COUNTERS {
            count_patch_tests += 1u;
        }
        let part = part_in_loop(loop_line(ray, open_entry(block, i)));
        let begin = max(part.x, t);
        let end = min(part.y, t_to);
        if begin < end {
            segment.ahead = with_bit(segment.ahead, i - block.entries_start);
            if begin <= t_look {
                segment.around = with_bit(segment.around, i - block.entries_start);
                segment.count += 1u;
                segment.begin = min(segment.begin, begin);
                segment.end = max(segment.end, end);
            } else {
                segment.next = min(segment.next, begin);
            }
        }
    }
    return segment;
}
