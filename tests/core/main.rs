//! The tests of renderer-core, which know nothing of the program: a module a concern.

#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test that cannot go on fails, and says where; directions of tests are not 0, and NaN fails them"
)]

mod agreement;
mod arrows;
mod bounced;
mod bounced_light;
mod chart;
mod chart_edit;
mod chart_loops;
mod checked;
mod coarse_preview;
mod colour;
mod compile;
mod cpu;
mod denoise;
mod documents;
mod environment;
mod error_estimate;
mod finish;
mod form;
mod frames;
mod geometry;
mod gpu_backend;
mod gpu_optimisations;
mod gpu_vs_reference;
mod grid;
mod height;
mod intervals;
mod layout;
mod less_noise;
mod levels;
mod lobes;
mod lod_regions;
mod long_paths;
mod many_faults;
mod materials;
mod metering;
mod metrics;
mod nap;
mod portability;
mod presets;
mod probes;
mod reference;
mod same_sample;
mod sampling;
mod sections;
mod shaders;
mod shadow_cache;
mod shadows;
mod skeleton;
mod stability;
mod tiles;
mod turbulence;
mod typed_numbers;
mod volumes;

/// What tests of pictures share: a device without a window, small scenes, rendering to the end, comparators.
#[path = "../support"]
mod support {
    pub mod agreement;
    pub mod closed;
    pub mod compare;
    pub mod denoisers;
    pub mod device;
    pub mod drawing;
    pub mod patches;
    pub mod pictures;
    pub mod probe;
    pub mod same_sample;
    pub mod scenes;
    pub mod unlike;
}
