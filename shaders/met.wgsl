// Which loops of a block's list a ray may meet, kept as bits of a mask: arrays would live in slow memory.

// Which entries of a block's list: bit k stands for entry k, and in longer lists also for k + 128, k + 256 and so on.
const MASKED: u32 = 128u;

fn with_bit(mask: vec4<u32>, entry: u32) -> vec4<u32> {
    let word = (entry % MASKED) / 32u;
    return mask | select(vec4<u32>(), vec4<u32>(1u << (entry % 32u)), vec4<u32>(word) == vec4<u32>(0u, 1u, 2u, 3u));
}

// One word of a mask, by selection: a vector indexed by a variable would leave the registers on some devices.
fn word_of(mask: vec4<u32>, word: u32) -> u32 {
    let halves = select(mask.xz, mask.yw, (word & 1u) != 0u);
    return select(halves.x, halves.y, (word & 2u) != 0u);
}

// The first entry from `start` on whose bit is set, or `end`.
fn next_bit(mask: vec4<u32>, start: u32, end: u32) -> u32 {
    var entry = start;
    while entry < end {
        let word = word_of(mask, entry / 32u) >> (entry % 32u);
        if word != 0u {
            return min(entry + firstTrailingBit(word), end);
        }
        entry = (entry / 32u + 1u) * 32u;
    }
    return end;
}

// The loops that a ray may meet in its part of a block.
struct Met {
    loops: vec4<u32>,
    // How many there are.
    count: u32,
    // Before the first of these distances and behind the second it is in none of them.
    t_from: f32,
    t_to: f32,
}

fn met_in(ray: Ray, block: Block, t_from: f32, t_to: f32) -> Met {
    var met = Met(vec4<u32>(), 0u, t_to, t_from);
    for (var i = next_met(block, block.entries_start); i < block.entries_end; i = next_met(block, i + 1u)) {
        if COUNTERS {
            count_patch_tests += 1u;
        }
        let line = loop_line(ray, open_entry(block, i));
        let sides = between_sides(line);
        let reach = 0.5 * scene.thickness + 0.25 * abs(line.lift);
        let heights = clip_band(vec2<f32>(-FAR, FAR), line.value.z, line.slope.z, reach);
        let low = max(max(sides.x, heights.x + line.t_near), t_from);
        let high = min(min(sides.y, heights.y + line.t_near), t_to);
        if low < high {
            met.loops = with_bit(met.loops, i - block.entries_start);
            met.count += 1u;
            met.t_from = min(met.t_from, low);
            met.t_to = max(met.t_to, high);
        }
    }
    return met;
}
