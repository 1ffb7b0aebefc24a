// Work counters of one thread, added to the device's 64-bit totals at its end; nothing of this is left without
// COUNTERS.

// Low and high word of each of the COUNT_* totals; behind them, from SHADOWS_FROM on, what is known of shadows, if
// anything.
@group(1) @binding(3) var<storage, read_write> totals: array<atomic<u32>>;

fn add_total(which: u32, amount: u32) {
    let before = atomicAdd(&totals[2u * which], amount);
    if before + amount < before {
        atomicAdd(&totals[2u * which + 1u], 1u);
    }
}

var<private> count_rays: u32;
var<private> count_shadow_rays: u32;
var<private> count_cells: u32;
var<private> count_patch_tests: u32;
var<private> count_volume_samples: u32;
var<private> count_contributing_hits: u32;
var<private> count_ended_rays: u32;
var<private> count_hidden_rays: u32;
var<private> count_cached_rays: u32;
