//! The one test binary: a module a concern.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on fails, and says where"
)]

mod agreement;
mod bench;
mod bounced;
mod bundles;
mod chart;
mod chart_edit;
mod chart_files;
mod cli;
mod colour;
mod compile;
mod cpu;
mod designer;
mod environment;
mod error_estimate;
mod excerpts;
mod finish;
mod first_look;
mod form;
mod frames;
mod geometry;
mod gpu_backend;
mod gpu_skips;
mod gpu_vs_reference;
mod grid;
mod height;
mod intervals;
mod layout;
mod levels;
mod lobes;
mod materials;
mod metrics;
mod nap;
mod picture_file;
mod presets;
mod probes;
mod recovery;
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
mod volumes;
mod window;

#[path = "../support/mod.rs"]
mod support;
