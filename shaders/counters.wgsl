// Work counters of one thread, added to the device's 64-bit totals at its end; nothing of this is left without COUNTERS.

// Low and high word of each of the COUNT_* totals; behind them, from SHADOWS_FROM on, what is known of shadows, if anything.
@group(1) @binding(3) var<storage, read_write> totals: array<atomic<u32>>;

fn add_total(which: u32, amount: u32) {
    let before = atomicAdd(&totals[2u * which], amount);
    if before + amount < before {
        atomicAdd(&totals[2u * which + 1u], 1u);
    }
}

// Order of the totals; shared with gpu/layout.rs. Each takes two words: low, high.
const COUNT_RAYS: u32 = 0u;
const COUNT_SHADOW_RAYS: u32 = 1u;
const COUNT_CELLS: u32 = 2u;
const COUNT_PATCH_TESTS: u32 = 3u;
const COUNT_VOLUME_SAMPLES: u32 = 4u;
const COUNT_CONTRIBUTING_HITS: u32 = 5u;
const COUNT_ENDED_RAYS: u32 = 6u;
const COUNT_HIDDEN_RAYS: u32 = 7u;
const COUNT_CACHED_RAYS: u32 = 8u;

var<private> count_rays: u32;
var<private> count_shadow_rays: u32;
var<private> count_cells: u32;
var<private> count_patch_tests: u32;
var<private> count_volume_samples: u32;
var<private> count_contributing_hits: u32;
var<private> count_ended_rays: u32;
var<private> count_hidden_rays: u32;
var<private> count_cached_rays: u32;
