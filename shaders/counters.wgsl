// Work counters of one thread, added to the device's 64-bit totals at its end; nothing of this is left without COUNTERS.

// Order of the totals; shared with gpu/layout.rs. Each takes two words: low, high.
const COUNT_RAYS: u32 = 0u;
const COUNT_SHADOW_RAYS: u32 = 1u;
const COUNT_CELLS: u32 = 2u;
const COUNT_PATCH_TESTS: u32 = 3u;
const COUNT_VOLUME_SAMPLES: u32 = 4u;
const COUNT_CONTRIBUTING_HITS: u32 = 5u;
const COUNT_ENDED_RAYS: u32 = 6u;
const COUNT_HIDDEN_RAYS: u32 = 7u;

var<private> count_rays: u32;
var<private> count_shadow_rays: u32;
var<private> count_cells: u32;
var<private> count_patch_tests: u32;
var<private> count_volume_samples: u32;
var<private> count_contributing_hits: u32;
var<private> count_ended_rays: u32;
var<private> count_hidden_rays: u32;
